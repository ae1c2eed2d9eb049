//! From a layout to the scene that the viewer draws.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::cones::ConeSet;
use super::layout::{Layout, rim_halfedges};
use super::message::Choice;
use super::method::Method;
use super::scene::{FieldScene, PALETTE, PatchScene, Scene};
use super::surface::{Surface, face_to_vertex};
use crate::mesh::{FaceId, OpenedMesh, SurfacePoint, VertexId};

/// Colours of the palette.
pub(super) const COLOURS: usize = PALETTE.len();

/// The field u where it is no scale factor: of a uniform or painted source.
pub const TEMPERATURE: &str = "temperature";

/// Fields that are amounts of paint.
const AMOUNTS: [&str; 9] = [
    "penalty",
    "heat",
    "pin",
    "importance",
    "unimportant",
    "cone_cost",
    "excluded",
    "seam_paint",
    "drawn_seam",
];

/// Bins of a field's histogram.
const BINS: usize = 32;

/// Fields that can be painted while a method is at work, `pieces` (none) first.
pub fn fields(method: Method) -> Vec<Choice> {
    if method == Method::Cones {
        return vec![
            Choice::new("pieces", "Pieces"),
            Choice::new("u", "Scale factor u"),
            Choice::new("curvature", "Curvature K"),
            Choice::new("phi", "Potential φ (cones at ± λ)"),
            Choice::new("area", "Area distortion"),
            Choice::new("angle", "Angle distortion"),
            Choice::new("stretch", "Stretch"),
            Choice::new("isometry", "Symmetric Dirichlet"),
            Choice::new("importance", "Importance"),
            Choice::new("unimportant", "Unimportant places"),
            Choice::new("cone_cost", "Cost of cones"),
            Choice::new("excluded", "Places without cones"),
            Choice::new("penalty", "Hidden from seams"),
        ];
    }
    if method == Method::PhaseField {
        return vec![
            Choice::new("pieces", "Pieces"),
            Choice::new("phase", "Phase field u"),
            Choice::new("weight", "Weight of the segment"),
            Choice::new("yamabe", "Scale factor of the segments"),
            Choice::new("u", "Scale factor u"),
            Choice::new("curvature", "Curvature K"),
            Choice::new("area", "Area distortion"),
            Choice::new("angle", "Angle distortion"),
            Choice::new("stretch", "Stretch"),
            Choice::new("isometry", "Symmetric Dirichlet"),
            Choice::new("regions", "Painted regions"),
        ];
    }
    if method == Method::Developable {
        return vec![
            Choice::new("pieces", "Pieces"),
            Choice::new("normal_error", "Distance from the piece’s normal"),
            Choice::new("curvature", "Curvature K"),
            Choice::new("area", "Area distortion"),
            Choice::new("angle", "Angle distortion"),
            Choice::new("stretch", "Stretch"),
            Choice::new("isometry", "Symmetric Dirichlet"),
            Choice::new("penalty", "Hidden from seams"),
            Choice::new("seam_paint", "Kept seams"),
            Choice::new("drawn_seam", "Drawn seams"),
        ];
    }
    vec![
        Choice::new("pieces", "Pieces"),
        Choice::new("u", "Scale factor u"),
        Choice::new("curvature", "Curvature K"),
        Choice::new("area", "Area distortion"),
        Choice::new("angle", "Angle distortion"),
        Choice::new("stretch", "Stretch"),
        Choice::new("isometry", "Symmetric Dirichlet"),
        Choice::new("penalty", "Penalty η"),
        Choice::new("heat", "Heat"),
        Choice::new("pin", "Pinned places"),
        Choice::new("regions", "Painted regions"),
        Choice::new("adjoint", "Adjoint p"),
        Choice::new("flux", "Flux ∂u/∂n"),
        Choice::new("velocity", "Velocity of the cut"),
        Choice::new("extension", "Velocity, extended"),
        Choice::new("level", "Level set φ"),
        Choice::new("moved", "Level set, moved"),
        Choice::new("redistanced", "Level set, redistanced"),
    ]
}

/// A colour for each patch, such that neighbours differ: that of its label where possible.
pub fn patch_colours(layout: &Layout, labels: &[u32]) -> Vec<u8> {
    let neighbours = layout.neighbours();
    let patch_labels = layout.patch_labels(labels);
    let mut colours: Vec<Option<u8>> = vec![None; patch_labels.len()];
    let mut uses = [0usize; COLOURS];
    for (patch, &label) in patch_labels.iter().enumerate() {
        let taken = |c: usize| {
            neighbours[patch].iter().any(|&n| colours[n as usize].map(usize::from) == Some(c))
        };
        let own = label.map_or(0, |label| label as usize % COLOURS);
        let chosen = if label.is_some() && !taken(own) {
            own
        } else {
            (0..COLOURS).filter(|&c| !taken(c)).min_by_key(|&c| (uses[c], c)).unwrap_or(own)
        };
        uses[chosen] += 1;
        colours[patch] = u8::try_from(chosen).ok();
    }
    colours.into_iter().map(|c| c.unwrap_or(0)).collect()
}

/// A field given at the vertices of the mesh, NaN where it has no value.
#[derive(Clone, Copy, Debug)]
pub struct Painted<'a> {
    id: &'a str,
    values: &'a [f64],
}

impl<'a> Painted<'a> {
    /// **Takes** one value for each vertex.
    pub fn new(id: &'a str, values: &'a [f64]) -> Self {
        Self { id, values }
    }

    /// Fields without a sign; all others have zero in the middle of their colours.
    fn is_signed(&self) -> bool {
        !["regions", "flux", "weight", "normal_error"].contains(&self.id)
            && !AMOUNTS.contains(&self.id)
    }

    /// Whether each patch has values of its own: then points on cuts take those of their own side.
    fn is_sided(&self) -> bool {
        let sided = ["regions", "flux", "velocity", "extension", "moved", "level", "redistanced"];
        sided.contains(&self.id)
    }
}

/// The scene of a layout.
///
/// **Takes** u at the mesh's vertices (0 on cuts), the field to paint, its values where the layout does not know them, and
/// other places of the points where the surface is shown folded.
#[expect(clippy::too_many_arguments, reason = "everything that is drawn")]
pub fn scene(
    surface: &Surface,
    layout: &Layout,
    colours: &[u8],
    u: &[f64],
    field: &str,
    painted: Option<Painted>,
    folded: Option<&[Point3<f64>]>,
    revision: u32,
) -> Scene {
    let unit = 1.0 / surface.radius().max(1e-300);
    let opened = &layout.opened;
    let point_normals: Vec<Vector3<f64>> =
        layout.cut.points.iter().map(|&p| normal_at(surface, p)).collect();
    let small = |x: f64| x as f32;
    let mut result = Scene {
        positions: Vec::with_capacity(3 * opened.vertex_points.len()),
        normals: Vec::with_capacity(3 * opened.vertex_points.len()),
        charts: layout.charts.iter().flatten().map(|x| small(x * unit)).collect(),
        vertex_patches: layout.vertex_patches.clone(),
        triangles: opened.mesh.triangles().iter().flatten().map(|v| v.0).collect(),
        triangle_faces: layout.cut.triangle_faces.iter().map(|f| f.0).collect(),
        sheet: [
            0.0,
            0.0,
            small(layout.packing.sheet.x * unit),
            small(layout.packing.sheet.y * unit),
        ],
        revision,
        ..Scene::default()
    };
    for &point in &opened.vertex_points {
        let places = folded.unwrap_or(&layout.points);
        let place = places[point as usize].coords * unit;
        result.positions.extend(place.iter().map(|&x| small(x)));
        result.normals.extend(point_normals[point as usize].iter().map(|&x| small(x)));
    }

    let mut numbers = vec![u32::MAX; opened.mesh.halfedge_count()];
    let rims: Vec<_> = rim_halfedges(opened).map(|(h, _)| h).collect();
    for (i, h) in rims.iter().enumerate() {
        numbers[h.index()] = i as u32;
        result.rims.extend([opened.mesh.tail(*h).0, opened.mesh.tip(*h).0]);
    }
    result.rim_partners =
        rims.iter().map(|&h| opened.partner(h).map_or(u32::MAX, |p| numbers[p.index()])).collect();

    let total: f64 = layout.patch_areas().iter().sum();
    let anchors = anchors(layout);
    for (patch, area) in layout.patch_areas().into_iter().enumerate() {
        let measures = layout.measures.charts[patch].as_ref();
        result.patches.push(PatchScene {
            color: colours[patch],
            area_fraction: small(area / total),
            anchor: anchors[patch].map(|x| small(x * unit)),
            flipped: measures.map_or(0, |m| u32::try_from(m.flipped).unwrap_or(u32::MAX)),
            has_chart: measures.is_some(),
        });
    }

    result.is_folded = folded.is_some();
    if folded.is_some() {
        result.normals = folded_normals(opened, &result.positions);
    }

    let painted = painted.map(|painted| {
        let label = label_of(painted.id);
        (painted.id.to_owned(), label, on_opened(surface, layout, painted), painted.is_signed())
    });
    let known = field_values(surface, layout, u, field)
        .map(|(id, label, values, signed)| (id.to_owned(), label.to_owned(), values, signed));
    if let Some((id, label, values, signed)) = painted.or(known) {
        result.field = Some(legend(layout, &id, &label, &values, signed));
        result.values = values.into_iter().map(small).collect();
    }
    result
}

/// What the legend calls a field.
fn label_of(id: &str) -> String {
    let mut all = [Method::CutFlow, Method::Cones, Method::PhaseField, Method::Developable]
        .into_iter()
        .flat_map(fields);
    all.find(|f| f.id == id).map_or_else(String::new, |f| f.label)
}

/// Puts cones in, and where they are on the charts.
///
/// **Takes** other places of the points where the surface is shown folded.
pub fn put_cones(
    scene: &mut Scene,
    surface: &Surface,
    layout: &Layout,
    set: &ConeSet,
    folded: Option<&[Point3<f64>]>,
) {
    let unit = 1.0 / surface.radius().max(1e-300);
    let mut numbers = vec![u32::MAX; surface.mesh.vertex_count()];
    for (i, used) in set.cones.iter().enumerate() {
        // The points of the cut begin with the vertices of the mesh.
        let places = folded.unwrap_or(&surface.geometry.positions);
        let place = places[used.cone.vertex.index()].coords * unit;
        scene.cone_points.extend(place.iter().map(|&x| x as f32));
        scene.cone_angles.push(used.cone.angle as f32);
        numbers[used.cone.vertex.index()] = i as u32;
    }
    for (v, &point) in layout.opened.vertex_points.iter().enumerate() {
        let cone = numbers.get(point as usize).copied().unwrap_or(u32::MAX);
        let has_place = layout.charts[v].iter().all(|x| x.is_finite());
        if cone != u32::MAX && has_place && layout.opened.mesh.halfedge(VertexId::from(v)).is_some()
        {
            scene.cone_charts.extend([v as u32, cone]);
        }
    }
}

fn normal_at(surface: &Surface, point: SurfacePoint) -> Vector3<f64> {
    let at = |v: crate::mesh::VertexId| surface.vertex_normals[v.index()];
    let sum = match point {
        SurfacePoint::Vertex(v) => return at(v),
        SurfacePoint::Edge(e, t) => {
            let [a, b] = surface.mesh.edge_vertices(e).map(at);
            a * (1.0 - t) + b * t
        }
        SurfacePoint::Face(f, w) => {
            let [a, b, c] = surface.mesh.face_vertices(f).map(at);
            a * w[0] + b * w[1] + c * w[2]
        }
    };
    sum.try_normalize(1e-300).unwrap_or_else(Vector3::z)
}

/// Where each chart's number is written: the centre of the face farthest from the rim, in faces. There is room, also in
/// pieces that are bent.
fn anchors(layout: &Layout) -> Vec<[f64; 2]> {
    let mesh = &layout.opened.mesh;
    let mut queue: Vec<FaceId> = mesh
        .faces()
        .filter(|&f| mesh.face_halfedges(f).iter().any(|h| mesh.is_boundary_edge(h.edge())))
        .collect();
    let mut seen = vec![false; mesh.face_count()];
    for f in &queue {
        seen[f.index()] = true;
    }
    let mut anchors = vec![[f64::NAN; 2]; layout.opened.patch_count];
    let mut next = 0;
    // Breadth first: the last face reached in each patch is the deepest.
    while let Some(&f) = queue.get(next) {
        next += 1;
        let corners = mesh.face_vertices(f).map(|v| layout.charts[v.index()]);
        anchors[layout.opened.face_patches[f.index()] as usize] =
            [0, 1].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / 3.0);
        for h in mesh.face_halfedges(f) {
            if let Some(g) = mesh.face(h.twin())
                && !std::mem::replace(&mut seen[g.index()], true)
            {
                queue.push(g);
            }
        }
    }
    anchors
}

/// Area-weighted normals of a folded surface.
fn folded_normals(opened: &OpenedMesh, positions: &[f32]) -> Vec<f32> {
    let at = |v: usize| Vector3::new(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
    let mut sums = vec![Vector3::<f32>::zeros(); positions.len() / 3];
    for t in opened.mesh.triangles() {
        let [a, b, c] = t.map(|v| at(v.index()));
        let normal = (b - a).cross(&(c - a));
        t.iter().for_each(|v| sums[v.index()] += normal);
    }
    let unit = |n: &Vector3<f32>| n.try_normalize(1e-30).unwrap_or_else(Vector3::z);
    sums.iter().flat_map(|n| <[f32; 3]>::from(unit(n))).collect()
}

/// A field of the mesh's vertices at the opened vertices: linear along crossed edges, or the value of the own side there.
fn on_opened(surface: &Surface, layout: &Layout, painted: Painted) -> Vec<f64> {
    let opened = &layout.opened;
    let values = painted.values;
    let own = surface.mesh.vertex_count();
    let linear = |point: SurfacePoint| match point {
        SurfacePoint::Vertex(v) => values[v.index()],
        SurfacePoint::Edge(e, t) => {
            let [a, b] = surface.mesh.edge_vertices(e).map(|v| values[v.index()]);
            a + (b - a) * t
        }
        SurfacePoint::Face(f, w) => {
            let corners = surface.mesh.face_vertices(f).map(|v| values[v.index()]);
            corners.iter().zip(w).map(|(c, w)| c * w).sum()
        }
    };
    let mut result: Vec<f64> =
        opened.vertex_points.iter().map(|&p| linear(layout.cut.points[p as usize])).collect();
    if painted.is_sided() {
        let is_level = ["level", "moved", "redistanced"].contains(&painted.id);
        let is_label = painted.id == "regions";
        // The mean of the neighbours that are vertices of the mesh: they lie on the own side.
        for v in opened.mesh.vertices().filter(|v| opened.vertex_points[v.index()] as usize >= own)
        {
            let (mut sum, mut count, mut last) = (0.0, 0.0, 0.0);
            for h in opened.mesh.outgoing(v) {
                let point = opened.vertex_points[opened.mesh.tip(h).index()] as usize;
                if point < own && values[point].is_finite() {
                    sum += values[point];
                    count += 1.0;
                    last = values[point];
                }
            }
            result[v.index()] = match painted.id {
                // Level sets vanish on the cut that they belong to.
                "level" => 0.0,
                // There are no labels between labels.
                _ if is_label => last,
                _ if is_level || count > 0.0 => sum / f64::max(count, 1.0),
                _ => f64::NAN,
            };
        }
    }
    result
}

/// Identifier, label, one value for each opened vertex, whether the field is signed.
fn field_values(
    surface: &Surface,
    layout: &Layout,
    u: &[f64],
    field: &str,
) -> Option<(&'static str, &'static str, Vec<f64>, bool)> {
    let own = surface.mesh.vertex_count();
    let opened = &layout.opened;
    let on_points = |vertex_values: &[f64], elsewhere: &dyn Fn(SurfacePoint) -> f64| -> Vec<f64> {
        opened
            .vertex_points
            .iter()
            .map(|&p| match (p as usize) < own {
                true => vertex_values[p as usize],
                false => elsewhere(layout.cut.points[p as usize]),
            })
            .collect()
    };
    let per_face = |values: &[f64]| face_to_vertex(&opened.mesh, &layout.geometry, values);
    match field {
        "u" => {
            // Charts know u also on patches with added cuts; the flow's u serves where there is no chart.
            let flow = on_points(u, &|_| 0.0);
            let charts = &layout.flattening.u;
            let values = flow.iter().zip(charts).map(|(f, c)| if c.is_finite() { *c } else { *f });
            Some(("u", "Scale factor u", values.collect(), true))
        }
        // What another source than the curvature makes has nothing to do with charts.
        TEMPERATURE => Some(("u", "Temperature u", on_points(u, &|_| 0.0), true)),
        "curvature" => {
            let curvature = &surface.vertex_curvatures;
            let between = |point| match point {
                SurfacePoint::Vertex(v) => curvature[v.index()],
                SurfacePoint::Edge(e, t) => {
                    let [a, b] = surface.mesh.edge_vertices(e).map(|v| curvature[v.index()]);
                    a + (b - a) * t
                }
                SurfacePoint::Face(f, w) => {
                    let corners = surface.mesh.face_vertices(f).map(|v| curvature[v.index()]);
                    corners.iter().zip(w).map(|(c, w)| c * w).sum()
                }
            };
            Some(("curvature", "Curvature K", on_points(curvature, &between), true))
        }
        "area" => {
            let values = per_face(&layout.measures.face_log_scales);
            Some(("area", "Area distortion (log of stretch)", values, true))
        }
        "angle" => {
            let values = per_face(&layout.measures.face_angle_distortions);
            Some(("angle", "Angle distortion σ₁/σ₂", values, false))
        }
        "stretch" => {
            let values = per_face(&layout.measures.face_stretches);
            Some(("stretch", "Stretch (L², 1 is true length)", values, false))
        }
        "isometry" => {
            let values = per_face(&layout.measures.face_symmetric_dirichlet);
            Some(("isometry", "Symmetric Dirichlet energy (1 is isometric)", values, false))
        }
        _ => None,
    }
}

/// Range, mean and histogram. The range covers the middle 98 % of the area, so that a few sharp corners do not wash the
/// rest out; signed fields are centred on zero.
fn legend(layout: &Layout, id: &str, label: &str, values: &[f64], signed: bool) -> FieldScene {
    let mut samples: Vec<(f64, f64)> = Vec::new();
    let (mut sum, mut area) = (0.0, 0.0);
    for f in 0..layout.opened.mesh.face_count() {
        let corners = layout.opened.mesh.face_vertices(FaceId::from(f));
        let value = corners.iter().map(|v| values[v.index()]).sum::<f64>() / 3.0;
        if value.is_finite() {
            let weight = layout.geometry.face_areas[f];
            samples.push((value, weight));
            sum += value * weight;
            area += weight;
        }
    }
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let quantile = |fraction: f64| {
        let mut below = 0.0;
        let found = samples.iter().find(|(_, weight)| {
            below += weight;
            below >= fraction * area
        });
        found.or(samples.last()).map_or(0.0, |s| s.0)
    };
    let (mut low, mut high) = (quantile(0.01), quantile(0.99));
    if signed {
        high = high.abs().max(low.abs()).max(1e-9);
        low = -high;
    } else if high - low < 1e-9 {
        high = low + 1e-9;
    }
    if AMOUNTS.contains(&id) {
        // Amounts of paint: all of their range, however little there is.
        (low, high) = (0.0, 1.0);
    }
    let mut histogram = vec![0.0f64; BINS];
    for (value, weight) in &samples {
        let place = ((value - low) / (high - low) * BINS as f64).clamp(0.0, BINS as f64 - 1.0);
        histogram[place as usize] += weight;
    }
    let largest = histogram.iter().fold(0.0f64, |m, &x| m.max(x)).max(1e-300);
    let extremes = match (samples.first(), samples.last()) {
        (Some(first), Some(last)) => [first.0 as f32, last.0 as f32],
        _ => [0.0, 0.0],
    };
    FieldScene {
        id: id.into(),
        label: label.into(),
        unit: String::new(),
        range: [low as f32, high as f32],
        mean: (sum / area.max(1e-300)) as f32,
        extremes,
        signed,
        histogram: histogram.iter().map(|x| (x / largest) as f32).collect(),
    }
}

#[cfg(test)]
mod tests {
    use std::rc::Rc;

    use super::*;
    use crate::methods::cutflow::{Initial, initial_labels, labelled_cut};
    use crate::session::charting::Charting;
    use crate::session::samples;

    #[test]
    fn seventy_labels_share_the_palette_and_neighbours_differ() {
        let soup = Rc::new(samples::icosphere(16));
        let faces = 0..soup.polygon_count();
        let triangles = faces.clone().map(|i| [0, 1, 2].map(|k| soup.polygon(i)[k])).collect();
        let surface =
            Surface::new("ball", soup, triangles, faces.map(|f| f as u32).collect()).unwrap();
        let (mesh, geometry) = (&surface.mesh, &surface.geometry);
        let initial = Initial::Random { regions: 70, cells: 70, seed: 2 };
        let labels = initial_labels(mesh, geometry, &initial).unwrap().labels;
        let cut = labelled_cut(mesh, geometry, &labels, |_| None);
        let layout = Layout::full(&surface, cut, &Charting::default(), None).unwrap();
        let colours = patch_colours(&layout, &labels);
        assert_eq!(colours.len(), 70);
        for (patch, near) in layout.neighbours().iter().enumerate() {
            assert!(usize::from(colours[patch]) < COLOURS);
            for &other in near {
                assert_ne!(colours[patch], colours[other as usize], "{patch} and {other}");
            }
        }
    }
}
