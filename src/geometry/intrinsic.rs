//! A metric fit for solving where the given triangles are not.
//!
//! The cotangent of a sliver is huge, and that of a triangle without area does not exist. Both are accidents of how the
//! surface was divided: the surface itself is smooth there. Two intrinsic steps mend the division and leave positions and
//! vertices alone. *Mollification* adds one small length to every edge, so that every triangle has an area. *Intrinsic
//! flips* exchange an edge for the other geodesic diagonal of the two triangles beside it, unfolded, which changes no
//! distance, no area and no angle sum at all.
//!
//! Guaranteed: the same vertices; the same angle sums and area up to rounding if nothing was mollified; a simplicial mesh
//! again, so that everything made for meshes works on it. Not guaranteed: that every edge is Delaunay. Only edges beside
//! slivers are flipped (elsewhere the given triangles stay, and with them the neighbours that a cut sees), and never to a pair of vertices
//! that have an edge already.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::collections::{HashSet, VecDeque};

use super::Geometry;
use crate::mesh::{FaceId, HalfedgeId, Mesh, MeshError};

/// Triangles with a smaller angle are slivers (radians, 2°): cotangents above 28. Larger thresholds flip edges that do no
/// harm, smaller ones leave systems whose condition the slivers rule.
const SLIVER: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// By how much two sides of a triangle must be longer than the third, in mean edge lengths. 1e-6 leaves heights of a
/// thousandth of an edge; the angles that follow have ten good digits.
const SLACK: f64 = 1e-6;

/// Flips beyond this many per edge would be an endless loop, which exact arithmetic excludes and rounding might not.
const FLIPS_PER_EDGE: usize = 20;

const NONE: u32 = u32::MAX;

/// A triangulation for solving on, with the vertices of the given one.
#[derive(Clone, Debug)]
pub struct Intrinsic {
    /// Connectivity after the flips.
    pub mesh: Mesh,
    /// Its metric; positions are the given ones.
    pub geometry: Geometry,
    /// Edges that were exchanged.
    pub flips: usize,
    /// Length that was added to every edge, 0 where all triangles had an area.
    pub mollified: f64,
}

/// The smallest length that, added to every edge, leaves two sides of each triangle longer than the third by `slack`.
///
/// **From** Sharp, Crane: *A Laplacian for Nonmanifold Triangle Meshes*, 2020, §4.5. **Costs** O(F).
pub fn mollification(mesh: &Mesh, edge_lengths: &[f64], slack: f64) -> f64 {
    mesh.faces()
        .flat_map(|f| {
            let [a, b, c] = mesh.face_halfedges(f).map(|h| edge_lengths[h.edge().index()]);
            [a + b - c, b + c - a, c + a - b]
        })
        .fold(0.0, |needed: f64, excess| needed.max(slack - excess))
}

/// A triangulation of the same surface without slivers as far as flips can help; `None` where there are none.
///
/// **Takes** a geometry that may hold triangles without area. **Fails** only if the flips left something that is no
/// mesh, which they do not. **Costs** O(F) and a little for each flip. **From** Fisher et al.: *An Algorithm for the
/// Construction of Intrinsic Delaunay Triangulations*, 2007. **Differs**: stays simplicial, and flips beside slivers only.
pub fn without_slivers(mesh: &Mesh, geometry: &Geometry) -> Result<Option<Intrinsic>, MeshError> {
    if !geometry.corner_angles.iter().any(is_sliver) {
        return Ok(None);
    }
    let mut lengths = geometry.edge_lengths.clone();
    let flat = geometry.face_areas.iter().zip(mesh.faces()).any(|(area, f)| {
        let longest = mesh
            .face_halfedges(f)
            .iter()
            .fold(0.0, |m: f64, h| m.max(geometry.edge_length(h.edge())));
        // What lengths can tell: a height below 1e-6 of the side leaves their sums less than four digits.
        !(2.0 * area > 1e-6 * longest * longest)
    });
    let mut mollified = 0.0;
    if flat {
        mollified = mollification(mesh, &lengths, SLACK * geometry.mean_edge_length());
        lengths.iter_mut().for_each(|l| *l += mollified);
    }
    let mut flipper = Flipper::new(mesh, lengths);
    let flips = flipper.run();
    let mesh = Mesh::new(mesh.vertex_count(), &flipper.faces)?;
    let lengths = flipper.lengths_of(&mesh);
    let geometry = Geometry::from_lengths(&mesh, geometry.positions.clone(), lengths);
    Ok(Some(Intrinsic { mesh, geometry, flips, mollified }))
}

fn is_sliver(angles: &[f64; 3]) -> bool {
    // Not so: angles of triangles without area may not be numbers.
    !angles.iter().all(|a| *a >= SLIVER)
}

/// Angles of a triangle at its corners, from the lengths of the sides that leave them.
pub(super) fn angles_of(sides: [f64; 3]) -> ([f64; 3], f64) {
    let doubled = 2.0 * heron(sides);
    let angles = [0, 1, 2].map(|i| {
        let (next, prev, far) = (sides[i], sides[(i + 2) % 3], sides[(i + 1) % 3]);
        (2.0 * doubled).atan2(next * next + prev * prev - far * far)
    });
    (angles, 0.5 * doubled)
}

/// Area of a triangle from its sides, to nearly all digits also where it is flat.
fn heron(mut sides: [f64; 3]) -> f64 {
    sides.sort_unstable_by(|a, b| b.total_cmp(a));
    let [a, b, c] = sides;
    0.25 * ((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))).max(0.0).sqrt()
}

/// Triangles whose edges can be exchanged.
struct Flipper {
    faces: Vec<[u32; 3]>,
    /// For each face its edges: number `i` joins corners `i` and `i + 1`.
    sides: Vec<[u32; 3]>,
    lengths: Vec<f64>,
    /// The one or two faces of each edge.
    beside: Vec<[u32; 2]>,
    pairs: HashSet<[u32; 2]>,
}

impl Flipper {
    fn new(mesh: &Mesh, lengths: Vec<f64>) -> Self {
        let side = |h: HalfedgeId| mesh.face(h).map_or(NONE, |f| f.0);
        Self {
            faces: mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect(),
            sides: mesh.faces().map(|f| mesh.face_halfedges(f).map(|h| h.edge().0)).collect(),
            lengths,
            beside: mesh.edges().map(|e| [e.halfedge(), e.halfedge().twin()].map(side)).collect(),
            pairs: mesh.edges().map(|e| sorted(mesh.edge_vertices(e).map(|v| v.0))).collect(),
        }
    }

    fn face_lengths(&self, face: u32) -> [f64; 3] {
        self.sides[face as usize].map(|e| self.lengths[e as usize])
    }

    fn run(&mut self) -> usize {
        let is_flat = |this: &Self, face: u32| is_sliver(&angles_of(this.face_lengths(face)).0);
        let slivers = (0..self.faces.len() as u32).filter(|&f| is_flat(self, f));
        let mut queue: VecDeque<u32> = slivers.flat_map(|f| self.sides[f as usize]).collect();
        let limit = FLIPS_PER_EDGE * self.lengths.len();
        let mut flips = 0;
        while let Some(edge) = queue.pop_front() {
            let [left, right] = self.beside[edge as usize];
            if left == NONE || right == NONE || flips == limit {
                continue;
            }
            if (is_flat(self, left) || is_flat(self, right)) && self.flip(edge) {
                flips += 1;
                for face in [left, right] {
                    queue.extend(self.sides[face as usize].iter().filter(|&&e| e != edge));
                }
            }
        }
        flips
    }

    /// Exchanges an edge that is not Delaunay for the other diagonal, where that is a new pair of vertices.
    fn flip(&mut self, edge: u32) -> bool {
        let [left, right] = self.beside[edge as usize];
        let place = |face: u32| self.sides[face as usize].iter().position(|&e| e == edge);
        let (Some(i), Some(j)) = (place(left), place(right)) else { return false };
        let turn = |face: u32, i: usize| {
            let f = face as usize;
            let corners = [0, 1, 2].map(|k| self.faces[f][(i + k) % 3]);
            let sides = [0, 1, 2].map(|k| self.sides[f][(i + k) % 3]);
            (corners, sides)
        };
        // Left: a → b → c over edge, bc, ca. Right: b → a → d over edge, ad, db.
        let ([a, b, c], [_, bc, ca]) = turn(left, i);
        let ([_, _, d], [_, ad, db]) = turn(right, j);
        if c == d || self.pairs.contains(&sorted([c, d])) {
            return false;
        }
        let length = |e: u32| self.lengths[e as usize];
        let [angles_left, angles_right] = [left, right].map(|f| angles_of(self.face_lengths(f)).0);
        let opposite = angles_left[(i + 2) % 3] + angles_right[(j + 2) % 3];
        if !(opposite > std::f64::consts::PI + 1e-12) {
            return false;
        }
        // The angle at a over both triangles is what the new diagonal is seen under.
        let at_a = angles_left[i] + angles_right[(j + 1) % 3];
        let (to_c, to_d) = (length(ca), length(ad));
        // As a sum of squares it does not lose the digits of a short diagonal.
        let squared = (to_c - to_d).powi(2) + 4.0 * to_c * to_d * (0.5 * at_a).sin().powi(2);
        let diagonal = squared.sqrt();
        let fits = |x: f64, y: f64| diagonal + x.min(y) > x.max(y) && x + y > diagonal;
        if !(diagonal > 0.0 && fits(to_c, to_d) && fits(length(bc), length(db))) {
            return false;
        }
        self.pairs.remove(&sorted([a, b]));
        self.pairs.insert(sorted([c, d]));
        self.lengths[edge as usize] = diagonal;
        self.faces[left as usize] = [a, d, c];
        self.sides[left as usize] = [ad, edge, ca];
        self.faces[right as usize] = [d, b, c];
        self.sides[right as usize] = [db, bc, edge];
        for (e, from, to) in [(ad, right, left), (bc, left, right)] {
            for face in &mut self.beside[e as usize] {
                if *face == from {
                    *face = to;
                    break;
                }
            }
        }
        true
    }

    fn lengths_of(&self, mesh: &Mesh) -> Vec<f64> {
        let mut lengths = vec![0.0; mesh.edge_count()];
        for (f, sides) in self.sides.iter().enumerate() {
            for (h, &side) in mesh.face_halfedges(FaceId::from(f)).iter().zip(sides) {
                lengths[h.edge().index()] = self.lengths[side as usize];
            }
        }
        lengths
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::geometry::angle_sums;

    /// A sheet of `rows` × `columns` squares, put somewhere.
    fn sheet([rows, columns]: [u32; 2], place: impl Fn(u32, u32) -> [f64; 3]) -> (Mesh, Geometry) {
        let at = |i: u32, j: u32| i * (columns + 1) + j;
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for i in 0..=rows {
            positions.extend((0..=columns).map(|j| Point3::from(place(i, j))));
        }
        for i in 0..rows {
            for j in 0..columns {
                triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
        let mesh = Mesh::new(positions.len(), &triangles).unwrap();
        let geometry = Geometry::measure(&mesh, positions);
        (mesh, geometry)
    }

    /// Bent, with every second row only a hundredth high and shifted, so that edges there are not Delaunay.
    fn pleated(i: u32, j: u32) -> [f64; 3] {
        let (x, y) = (f64::from(j + 2 * (i % 2)), f64::from(i / 2) + f64::from(i % 2) * 0.99);
        [x, y, 0.3 * x * (0.2 * y).sin()]
    }

    #[test]
    fn flips_change_neither_angle_sums_nor_area() {
        let (mesh, geometry) = sheet([9, 9], pleated);
        let better = without_slivers(&mesh, &geometry).unwrap().unwrap();
        assert!(better.mollified == 0.0 && better.flips > 0);
        // The lengths pass through square roots of flat triangles: half of the digits of 1e-2 are at stake.
        for (a, b) in
            angle_sums(&mesh, &geometry).iter().zip(angle_sums(&better.mesh, &better.geometry))
        {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        let (area, same) = (geometry.total_area(), better.geometry.total_area());
        assert!((area / same - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_triangle_without_area_gets_finite_cotangents() {
        // A fan around a vertex in the middle of a straight edge: the cap 0-1-4 has no area.
        let positions = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 0.0], [1.0, -1.0]]
            .map(|[x, y]| Point3::new(x, y, 0.0));
        let triangles = [[4, 1, 2], [4, 2, 3], [4, 3, 0], [0, 1, 4], [0, 5, 1]];
        let mesh = Mesh::new(6, &triangles).unwrap();
        let geometry = Geometry::measure(&mesh, positions.to_vec());
        let better = without_slivers(&mesh, &geometry).unwrap().unwrap();
        assert!(better.mollified > 0.0 && better.mollified < 1e-5, "{}", better.mollified);
        assert_eq!(better.flips, 1, "the long edge goes");
        for cotangents in &better.geometry.corner_cotangents {
            assert!(cotangents.iter().all(|c| c.abs() < 10.0), "{cotangents:?}");
        }
        // The cap became √(2 · 1.6e-6) high.
        assert!((better.geometry.total_area() - 5.0).abs() < 4e-3);
    }

    #[test]
    fn nearly_flat_caps_on_the_rim_get_finite_cotangents_at_every_height() {
        for exponent in 3..=14 {
            let height = 10f64.powi(-exponent);
            // The long side of the cap 0-1-2 has nothing beside it to flip with.
            let positions = [[0.0, 0.0], [2.0, 0.0], [1.0, height], [0.0, 2.0], [2.0, 2.0]];
            let positions = positions.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
            let triangles = [[0, 1, 2], [1, 4, 2], [2, 4, 3], [2, 3, 0]];
            let mesh = Mesh::new(5, &triangles).unwrap();
            let geometry = Geometry::measure(&mesh, positions);
            let better = without_slivers(&mesh, &geometry).unwrap().unwrap();
            let cotangents = better.geometry.corner_cotangents.iter().flatten();
            // At least √(2e-6) high after mollifying: cotangents of 2 / height at most.
            assert!(cotangents.copied().all(|c| c.abs() < 3e6), "{height}");
            assert!(better.geometry.face_areas.iter().all(|a| *a > 0.0), "{height}");
        }
    }

    #[test]
    fn a_sheared_sheet_loses_its_slivers_away_from_the_rim() {
        // Each row is shifted by 30 squares against the one below: the tips have angles below 2°.
        let size = [6, 400];
        let place = |i, j| [f64::from(j) + 30.0 * f64::from(i), f64::from(i), 0.0];
        let (mesh, geometry) = sheet(size, place);
        let better = without_slivers(&mesh, &geometry).unwrap().unwrap();
        let slivers = |g: &Geometry| g.corner_angles.iter().filter(|a| is_sliver(a)).count();
        assert_eq!(slivers(&geometry), mesh.face_count());
        // Thirty squares at either end of each row have nothing beside them to flip with.
        assert!(slivers(&better.geometry) < mesh.face_count() / 5);
        let (even, square) = sheet(size, |i, j| [f64::from(j), f64::from(i), 0.0]);
        assert!(without_slivers(&even, &square).unwrap().is_none());
    }
}
