//! From a [`Scene`] to the bytes of vertex and index buffers. Pure: no graphics device in sight.

use super::color::{self, Rgb};
use super::occlusion::Occlusion;
use crate::session::scene::{FieldScene, PatchScene, Scene};
use glam::{Vec2, Vec3};

/// Absent segment or patch.
pub const NONE: u32 = u32::MAX;

/// Bytes per vertex of [`geometry`]: position `f32 × 3`, normal and openness `i16 × 4`.
pub const GEOMETRY_STRIDE: u64 = 20;
/// Bytes per vertex of [`paint`]: two colours of the texture `u8 × 4`, place on the ramp `f32`.
pub const PAINT_STRIDE: u64 = 12;
/// Bytes per vertex of [`charts`]: `f32 × 2`.
pub const CHART_STRIDE: u64 = 8;
/// Bytes per [`Ribbon`]: four places `f32 × 3`, two normals `i8 × 4`, colour `u8 × 4`.
pub const RIBBON_STRIDE: u64 = 60;

/// A scene that cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// An array has the wrong length.
    #[error("scene: `{array}` has {found} entries, expected {expected}")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// Its length.
        found: usize,
        /// The length that the other arrays ask for.
        expected: usize,
    },
    /// An index points past the end of what it indexes.
    #[error("scene: `{array}` holds {index}, but there are only {count}")]
    Index {
        /// Name of the array.
        array: &'static str,
        /// The index.
        index: u32,
        /// Number of things that it could point at.
        count: usize,
    },
    /// A coordinate is NaN or infinite where it must not be.
    #[error("scene: `{array}` holds a number that is not finite at {at}")]
    NotFinite {
        /// Name of the array.
        array: &'static str,
        /// Where in the array.
        at: usize,
    },
}

/// Checks everything that the builders below rely on, so that they cannot panic.
pub fn check(scene: &Scene) -> Result<(), SceneError> {
    let length = |array, found, expected| {
        if found == expected { Ok(()) } else { Err(SceneError::Length { array, found, expected }) }
    };
    let indices = |array, values: &[u32], count: usize, none_allowed: bool| {
        let is_bad = |&&i: &&u32| i as usize >= count && !(none_allowed && i == NONE);
        match values.iter().find(is_bad) {
            Some(&index) => Err(SceneError::Index { array, index, count }),
            None => Ok(()),
        }
    };
    let finite = |array, values: &[f32]| match values.iter().position(|x| !x.is_finite()) {
        Some(at) => Err(SceneError::NotFinite { array, at }),
        None => Ok(()),
    };
    let vertices = scene.vertex_count();
    let triangles = scene.triangles.len() / 3;
    let segments = scene.rims.len() / 2;
    length("positions", scene.positions.len(), 3 * vertices)?;
    length("normals", scene.normals.len(), 3 * vertices)?;
    length("charts", scene.charts.len(), 2 * vertices)?;
    length("vertex_patches", scene.vertex_patches.len(), vertices)?;
    if !scene.values.is_empty() {
        length("values", scene.values.len(), vertices)?;
    }
    length("triangles", scene.triangles.len(), 3 * triangles)?;
    length("triangle_faces", scene.triangle_faces.len(), triangles)?;
    length("rims", scene.rims.len(), 2 * segments)?;
    length("rim_partners", scene.rim_partners.len(), segments)?;
    length("mark_points", scene.mark_points.len(), scene.mark_points.len() / 3 * 3)?;
    length("mark_segments", scene.mark_segments.len(), scene.mark_segments.len() / 6 * 6)?;
    if let Some(layers) = &scene.layers {
        super::layers::check(layers)?;
    }
    let cones = scene.cone_points.len() / 3;
    length("cone_points", scene.cone_points.len(), 3 * cones)?;
    length("cone_angles", scene.cone_angles.len(), cones)?;
    length("cone_charts", scene.cone_charts.len(), scene.cone_charts.len() / 2 * 2)?;
    for &[vertex, cone] in scene.cone_charts.as_chunks().0 {
        indices("cone_charts", &[vertex], vertices, false)?;
        indices("cone_charts", &[cone], cones, false)?;
    }
    indices("vertex_patches", &scene.vertex_patches, scene.patches.len(), false)?;
    indices("triangles", &scene.triangles, vertices, false)?;
    indices("rims", &scene.rims, vertices, false)?;
    indices("rim_partners", &scene.rim_partners, segments, true)?;
    finite("positions", &scene.positions)?;
    finite("normals", &scene.normals)?;
    finite("mark_points", &scene.mark_points)?;
    finite("mark_segments", &scene.mark_segments)?;
    finite("cone_points", &scene.cone_points)?;
    finite("cone_angles", &scene.cone_angles)
}

/// The triangles of a scene.
pub fn triangles(scene: &Scene) -> &[[u32; 3]] {
    scene.triangles.as_chunks().0
}

/// The rim segments of a scene.
pub fn rims(scene: &Scene) -> &[[u32; 2]] {
    scene.rims.as_chunks().0
}

/// Place of a vertex on the surface.
pub fn position(scene: &Scene, vertex: u32) -> Vec3 {
    Vec3::from_slice(&scene.positions[3 * vertex as usize..])
}

/// Place of a vertex on the flattened view, in the plane z = 0.
pub fn chart(scene: &Scene, vertex: u32) -> Vec3 {
    Vec2::from_slice(&scene.charts[2 * vertex as usize..]).extend(0.0)
}

/// Unit normal at a vertex.
pub fn normal(scene: &Scene, vertex: u32) -> Vec3 {
    Vec3::from_slice(&scene.normals[3 * vertex as usize..])
}

/// Area of the surface.
pub fn area(scene: &Scene) -> f32 {
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|vertex| position(scene, vertex));
        (b - a).cross(c - a).length() / 2.0
    };
    triangles(scene).iter().map(area).sum()
}

/// Places, normals and openness of all vertices.
pub fn geometry(scene: &Scene, occlusion: &mut Occlusion) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(scene.vertex_count() * GEOMETRY_STRIDE as usize);
    for vertex in 0..scene.vertex_count() as u32 {
        let (position, normal) = (position(scene, vertex), normal(scene, vertex));
        let openness = if scene.is_folded { 1.0 } else { occlusion.openness(position, normal) };
        push_place(&mut bytes, position, normal, openness);
    }
    bytes
}

/// Appends a place of [`geometry`].
pub fn push_place(bytes: &mut Vec<u8>, position: Vec3, normal: Vec3, openness: f32) {
    push_floats(bytes, &position.to_array());
    for x in [normal.x, normal.y, normal.z, openness] {
        bytes.extend(((x * f32::from(i16::MAX)).round() as i16).to_le_bytes());
    }
}

/// Both colours of the texture of each piece.
pub fn piece_colours(patches: &[PatchScene]) -> Vec<[[u8; 4]; 2]> {
    let colours = |patch: &PatchScene| {
        let light = color::region(patch.color);
        // Without a chart there is no texture: both colours are the same.
        let dark = if patch.has_chart { light.darker() } else { light };
        [light.bytes(), dark.bytes()]
    };
    patches.iter().map(colours).collect()
}

/// Whether a field counts regions: then its values are names, not amounts.
pub fn is_labels(field: &FieldScene) -> bool {
    field.id == "regions"
}

/// Colours and values of all vertices.
pub fn paint(scene: &Scene) -> Vec<u8> {
    let colours = piece_colours(&scene.patches);
    let range = scene.field.as_ref().map_or([0.0, 1.0], |field| field.range);
    let is_labels = scene.field.as_ref().is_some_and(is_labels);
    let mut bytes = Vec::with_capacity(scene.vertex_count() * PAINT_STRIDE as usize);
    for (vertex, &patch) in scene.vertex_patches.iter().enumerate() {
        bytes.extend(colours[patch as usize].as_flattened());
        let value = scene.values.get(vertex).copied().unwrap_or(f32::NAN);
        let place = if is_labels {
            color::place_of_label(value)
        } else {
            color::place_on_ramp(value, range)
        };
        bytes.extend(place.to_le_bytes());
    }
    bytes
}

/// Places of all vertices on the flattened view; the origin where there is none, since shaders must
/// not meet NaN.
pub fn charts(scene: &Scene) -> Vec<u8> {
    let finite = |&x: &f32| if x.is_finite() { x } else { 0.0 };
    scene.charts.iter().map(finite).flat_map(f32::to_le_bytes).collect()
}

/// An index buffer of triangles.
pub fn indices<'a>(triangles: impl IntoIterator<Item = &'a [u32; 3]>) -> Vec<u8> {
    triangles.into_iter().flatten().flat_map(|i| i.to_le_bytes()).collect()
}

/// Triangles of the flattened view: those that stand as they should, and those that are turned over
/// or have no area. Triangles without a chart are in neither.
pub fn chart_triangles(scene: &Scene) -> [Vec<[u32; 3]>; 2] {
    let [mut upright, mut flipped] = [Vec::with_capacity(scene.triangles.len() / 3), Vec::new()];
    for corners in triangles(scene) {
        let [a, b, c] = corners.map(|vertex| chart(scene, vertex).as_dvec3());
        let twice_area = (b - a).cross(c - a).z;
        if twice_area > 0.0 {
            upright.push(*corners);
        } else if twice_area <= 0.0 {
            flipped.push(*corners);
        }
    }
    [upright, flipped]
}

/// A line of constant width on the screen, with its neighbours so that joints are neither doubled
/// nor gaping. A neighbour equal to the near end is none.
#[derive(Clone, Copy, Debug)]
struct Ribbon {
    before: Vec3,
    start: Vec3,
    end: Vec3,
    after: Vec3,
    normals: [Vec3; 2],
    /// Whether the ribbon vanishes where its normals point away from the eye.
    hides: bool,
    colour: [u8; 4],
}

impl Ribbon {
    /// A line, or a disc where both ends are one, that is visible from everywhere.
    fn lone(start: Vec3, end: Vec3) -> Self {
        let normals = [Vec3::ZERO; 2];
        Self { before: start, start, end, after: end, normals, hides: false, colour: [0; 4] }
    }

    fn push(&self, bytes: &mut Vec<u8>) {
        for place in [self.before, self.start, self.end, self.after] {
            push_floats(bytes, &place.to_array());
        }
        for normal in self.normals {
            let [x, y, z] = normal.to_array().map(|x| (x * 127.0).round() as i8);
            bytes.extend([x, y, z, i8::from(self.hides) * 127].map(i8::cast_unsigned));
        }
        bytes.extend(self.colour);
    }
}

/// For each rim segment the one before and the one after it along its rim; [`NONE`] where the rim ends.
pub fn rim_neighbours(scene: &Scene) -> Vec<[u32; 2]> {
    let mut starting = vec![NONE; scene.vertex_count()];
    let mut ending = vec![NONE; scene.vertex_count()];
    for (&[a, b], segment) in rims(scene).iter().zip(0..) {
        starting[a as usize] = segment;
        ending[b as usize] = segment;
    }
    rims(scene).iter().map(|&[a, b]| [ending[a as usize], starting[b as usize]]).collect()
}

/// Which rim segments become ribbons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RimChoice {
    /// One of each pair across a cut, and the mesh's own boundary.
    Cuts,
    /// All of them.
    All,
    /// Those of one patch.
    Patch(u32),
}

/// Rims as ribbons, on the surface or on the charts.
pub fn rim_ribbons(
    scene: &Scene,
    neighbours: &[[u32; 2]],
    choice: RimChoice,
    on_charts: bool,
) -> Vec<u8> {
    let rims = rims(scene);
    let place = |vertex| if on_charts { chart(scene, vertex) } else { position(scene, vertex) };
    // Through a hole one sees the inside, and its cuts with it.
    let hides = !on_charts && !scene.rim_partners.contains(&NONE);
    let mut bytes = Vec::new();
    for (i, &[a, b]) in rims.iter().enumerate() {
        let patch = scene.vertex_patches[a as usize];
        let is_chosen = match choice {
            RimChoice::Cuts => i < scene.rim_partners[i] as usize,
            RimChoice::All => true,
            RimChoice::Patch(chosen) => patch == chosen,
        };
        let (start, end) = (place(a), place(b));
        if !is_chosen || !start.is_finite() || !end.is_finite() {
            continue;
        }
        let [before, after] = neighbours[i];
        let neighbour = |segment: u32, corner: usize, fallback| {
            rims.get(segment as usize)
                .map(|segment| place(segment[corner]))
                .filter(|place| place.is_finite())
                .unwrap_or(fallback)
        };
        let colour = color::region(scene.patches[patch as usize].color).bytes();
        let (before, after) = (neighbour(before, 0, start), neighbour(after, 1, end));
        let normals = [normal(scene, a), normal(scene, b)];
        Ribbon { before, start, end, after, normals, hides, colour }.push(&mut bytes);
    }
    bytes
}

/// The edges between triangles of one patch as ribbons, of one alone where it is given; those on rims are drawn as such.
pub fn wire_ribbons(scene: &Scene, on_charts: bool, only: Option<u32>) -> Vec<u8> {
    let place = |vertex| if on_charts { chart(scene, vertex) } else { position(scene, vertex) };
    let is_shown =
        |&&[a, ..]: &&[u32; 3]| only.is_none_or(|only| scene.vertex_patches[a as usize] == only);
    let mut bytes = Vec::new();
    for &[a, b, c] in triangles(scene).iter().filter(is_shown) {
        // The triangle across sees the same edge the other way round.
        for (from, to) in [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from < to) {
            let (start, end) = (place(from), place(to));
            if start.is_finite() && end.is_finite() {
                Ribbon::lone(start, end).push(&mut bytes);
            }
        }
    }
    bytes
}

/// The places that an error points at, as discs.
pub fn mark_point_ribbons(scene: &Scene) -> Vec<u8> {
    let mut bytes = Vec::new();
    for &point in scene.mark_points.as_chunks().0 {
        let place = Vec3::from_array(point);
        Ribbon::lone(place, place).push(&mut bytes);
    }
    bytes
}

/// The lines that an error points at.
pub fn mark_segment_ribbons(scene: &Scene) -> Vec<u8> {
    let mut bytes = Vec::new();
    for &[x0, y0, z0, x1, y1, z1] in scene.mark_segments.as_chunks().0 {
        Ribbon::lone(Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1)).push(&mut bytes);
    }
    bytes
}

/// Lines that know nothing of each other.
pub fn lone_ribbons(lines: impl Iterator<Item = [Vec3; 2]>) -> Vec<u8> {
    let mut bytes = Vec::new();
    lines.for_each(|[start, end]| Ribbon::lone(start, end).push(&mut bytes));
    bytes
}

/// An open line through places.
pub fn line_ribbons(line: &[Vec3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (i, pair) in line.windows(2).enumerate() {
        let before = line[i.saturating_sub(1)];
        let after = line[(i + 2).min(line.len() - 1)];
        Ribbon { before, after, ..Ribbon::lone(pair[0], pair[1]) }.push(&mut bytes);
    }
    bytes
}

/// Discs at places.
pub fn disc_ribbons(places: &[Vec3]) -> Vec<u8> {
    lone_ribbons(places.iter().map(|&place| [place, place]))
}

/// A closed line through places on the surface.
pub fn ring_ribbons(ring: &[Vec3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let at = |i: usize| ring[i % ring.len()];
    for i in 0..ring.len() {
        let [before, after] = [at(i + ring.len() - 1), at(i + 2)];
        Ribbon { before, after, ..Ribbon::lone(at(i), at(i + 1)) }.push(&mut bytes);
    }
    bytes
}

/// For each patch the radius of the largest disc about its anchor that stays clear of its rim, in
/// the unit of the charts: room for its number. 0 without chart.
pub fn anchor_rooms(scene: &Scene) -> Vec<f32> {
    let anchor = |patch: usize| Vec2::from_array(scene.patches[patch].anchor);
    let mut rooms = vec![f32::INFINITY; scene.patches.len()];
    for &[a, b] in rims(scene) {
        let patch = scene.vertex_patches[a as usize] as usize;
        let [a, b] = [a, b].map(|vertex| chart(scene, vertex).truncate());
        let (along, to_anchor) = (b - a, anchor(patch) - a);
        let t = (to_anchor.dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0);
        let distance = (to_anchor - along * t).length();
        if distance < rooms[patch] {
            rooms[patch] = distance;
        }
    }
    rooms.into_iter().map(|room| if room.is_finite() { room } else { 0.0 }).collect()
}

/// Appends numbers as the little-endian bytes that graphics devices expect.
pub fn push_floats(bytes: &mut Vec<u8>, numbers: &[f32]) {
    for number in numbers {
        bytes.extend(number.to_le_bytes());
    }
}

/// An opaque colour as four numbers.
pub fn opaque(colour: Rgb, opacity: f32) -> [f32; 4] {
    let [r, g, b] = colour.0;
    [r, g, b, opacity]
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{two_squares, unit_ball};
    use super::*;

    fn floats(bytes: &[u8]) -> Vec<f32> {
        bytes.as_chunks().0.iter().map(|&b| f32::from_le_bytes(b)).collect()
    }

    #[test]
    fn every_array_has_its_stride() {
        let scene = unit_ball(2, 2);
        let n = scene.vertex_count();
        assert_eq!(geometry(&scene, &mut Occlusion::new(&scene)).len(), n * 20);
        assert_eq!(paint(&scene).len(), n * 12);
        assert_eq!(charts(&scene).len(), n * 8);
        assert_eq!(mark_point_ribbons(&scene).len(), scene.mark_points.len() / 3 * 60);
        assert_eq!(indices(triangles(&scene)).len(), scene.triangles.len() * 4);
    }

    #[test]
    fn two_squares_have_the_area_of_two() {
        assert!((area(&two_squares()) - 2.0).abs() < 1e-6);
    }

    #[test]
    fn a_cut_is_drawn_once_and_a_boundary_as_well() {
        let scene = two_squares();
        let neighbours = rim_neighbours(&scene);
        let count =
            |choice| rim_ribbons(&scene, &neighbours, choice, true).len() / RIBBON_STRIDE as usize;
        assert_eq!(count(RimChoice::All), 8);
        assert_eq!(count(RimChoice::Cuts), 7);
        assert_eq!(count(RimChoice::Patch(1)), 4);
        assert_eq!(count(RimChoice::Patch(7)), 0);
    }

    #[test]
    fn neighbours_go_once_around_each_rim() {
        let scene = two_squares();
        let neighbours = rim_neighbours(&scene);
        for first in [0, 4] {
            let mut segment = first;
            for _ in 0..4 {
                let [_, next] = neighbours[segment as usize];
                assert_eq!(neighbours[next as usize][0], segment);
                segment = next;
            }
            assert_eq!(segment, first);
        }
    }

    #[test]
    fn triangles_without_a_chart_are_left_out_and_turned_ones_are_set_apart() {
        let mut scene = two_squares();
        assert_eq!(chart_triangles(&scene).map(|t| t.len()), [4, 0]);
        scene.charts[0] = f32::NAN;
        // Fold the last corner of the second square over its diagonal.
        scene.charts[14..16].copy_from_slice(&[1.8, 0.1]);
        let [upright, flipped] = chart_triangles(&scene);
        assert_eq!((upright.len(), flipped), (1, vec![[4, 6, 7]]));
        assert!(floats(&charts(&scene)).iter().all(|x| x.is_finite()));
        let neighbours = rim_neighbours(&scene);
        let ribbons = rim_ribbons(&scene, &neighbours, RimChoice::All, true);
        assert_eq!(ribbons.len() / RIBBON_STRIDE as usize, 6);
    }

    #[test]
    fn every_edge_inside_a_patch_is_wired_once() {
        let scene = two_squares();
        let inner = 2;
        let rim_edges_seen = rims(&scene).iter().filter(|[a, b]| a < b).count();
        let wires = wire_ribbons(&scene, true, None).len() / RIBBON_STRIDE as usize;
        assert_eq!(wires, inner + rim_edges_seen);
    }

    #[test]
    fn an_anchor_has_the_room_up_to_its_own_rim() {
        let rooms = anchor_rooms(&two_squares());
        assert!((rooms[0] - 0.5).abs() < 1e-6 && (rooms[1] - 0.25).abs() < 1e-6, "{rooms:?}");
    }

    #[test]
    fn a_broken_scene_is_refused_with_the_name_of_its_array() {
        let good = two_squares();
        assert_eq!(check(&good), Ok(()));
        assert_eq!(check(&Scene::default()), Ok(()));

        let mut scene = good.clone();
        scene.triangles[4] = 99;
        let error = SceneError::Index { array: "triangles", index: 99, count: 8 };
        assert_eq!(check(&scene), Err(error));

        let mut scene = good.clone();
        scene.normals.pop();
        let error = SceneError::Length { array: "normals", found: 23, expected: 24 };
        assert_eq!(check(&scene), Err(error));

        let mut scene = good.clone();
        scene.positions[5] = f32::INFINITY;
        assert_eq!(check(&scene), Err(SceneError::NotFinite { array: "positions", at: 5 }));

        let cones = Scene {
            cone_points: vec![0.0; 3],
            cone_angles: vec![1.0],
            cone_charts: vec![1, 0, 4, 0],
            ..good
        };
        assert_eq!(check(&cones), Ok(()));
        let error = SceneError::Length { array: "cone_angles", found: 1, expected: 2 };
        assert_eq!(check(&Scene { cone_points: vec![0.0; 6], ..cones.clone() }), Err(error));
        let error = SceneError::Index { array: "cone_charts", index: 1, count: 1 };
        assert_eq!(check(&Scene { cone_charts: vec![0, 1], ..cones.clone() }), Err(error));
        let error = SceneError::Length { array: "cone_charts", found: 3, expected: 2 };
        assert_eq!(check(&Scene { cone_charts: vec![0, 0, 0], ..cones.clone() }), Err(error));
        let error = SceneError::NotFinite { array: "cone_angles", at: 0 };
        assert_eq!(check(&Scene { cone_angles: vec![f32::NAN], ..cones }), Err(error));
    }
}
