//! The elastic energy of sewn sheets: how it is made of triangles and hinges, its gradient, and a matrix above its Hessian.
//!
//! All points are three arrays in one, coordinate by coordinate: what the solver takes as three right-hand sides.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::{Flattening, FoldEnergy, FoldParams};
use crate::linalg::Pattern;
use crate::mesh::{FaceId, HalfedgeId, OpenedMesh};

/// Height of a flat triangle over its longest side below which it gets this height: see [`crate::geometry::Geometry::measure`].
const THIN: f64 = 1e-8;

/// Length that a side of length 0 gets, so that its square and that of its height are still numbers.
const NO_LENGTH: f64 = 1e-140;

/// Triangles with a larger cotangent (an angle below 0.06°) count as little as if they had this one. Crossings at 1e-6 of an
/// edge leave cotangents of 1e6: at full weight they fix their vertices to twelve digits where six are known; down to 1e2
/// the triangles of ordinary bad meshes would give way.
const STIFFEST: f64 = 1e3;

/// Hinges beside a larger cotangent (an angle below 2°) are weakened by the square of the excess: across a needle the hinge
/// magnifies the smallest stretch into a bend. Without it needles hold their neighbours like a ruler glued along the cut.
const STIFFEST_HINGE: f64 = 30.0;

/// Hinges between smaller triangles than this many mean pairs are as stiff as hinges of that size.
const SMALLEST_HINGE: f64 = 1e-3;

/// A flat triangle, its longest side first: corners at (0, 0), (length, 0), (foot, height).
#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [u32; 3],
    length: f64,
    foot: f64,
    height: f64,
    /// 1, less for slivers.
    share: f64,
}

/// An edge inside a chart with the two corners opposite: what the bend costs is ‖Σ weights · places‖².
#[derive(Clone, Copy, Debug)]
struct Hinge {
    corners: [u32; 4],
    weights: [f64; 4],
}

/// An edge and what its length says of stretch.
#[derive(Clone, Copy, Debug)]
struct Side {
    ends: [u32; 2],
    length: f64,
    /// A third of the area beside it.
    area: f64,
}

/// The sheets, sewn together at points that they share.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    triangles: Vec<Triangle>,
    hinges: Vec<Hinge>,
    sides: Vec<Side>,
    /// Area around each point on the original surface; 0 where no triangle is.
    pub point_areas: Vec<f64>,
    /// Area of the original surface.
    pub area: f64,
    /// For each point its component of the sewn surface.
    pub components: Vec<u32>,
    pub component_count: usize,
    /// The original places.
    pub origin: Vec<f64>,
    bending: f64,
    pull: f64,
}

impl Triangle {
    /// Lays a triangle flat, by the places of its corners in any space.
    fn flat(points: [u32; 3], places: [Vector3<f64>; 3]) -> Self {
        let lengths = [0, 1, 2].map(|i| (places[(i + 1) % 3] - places[i]).norm_squared());
        let first = (1..3).fold(0, |best, i| if lengths[i] > lengths[best] { i } else { best });
        let [a, b, c] = [0, 1, 2].map(|i| (first + i) % 3);
        let (base, leg) = (places[b] - places[a], places[c] - places[a]);
        let length = base.norm().max(NO_LENGTH);
        let foot = base.dot(&leg) / length;
        let height = (base.cross(&leg).norm() / length).max(THIN * length);
        let steepest = foot.max(length - foot) / height;
        Self {
            corners: [points[a], points[b], points[c]],
            length,
            foot,
            height,
            share: (STIFFEST / steepest).min(1.0),
        }
    }

    fn area(&self) -> f64 {
        0.5 * self.length * self.height
    }

    /// Cotangents at the corners.
    fn cotangents(&self) -> [f64; 3] {
        let (l, q, h) = (self.length, self.foot, self.height);
        [q / h, (l - q) / h, (h * h - q * (l - q)) / (h * l)]
    }

    /// The 3 × 2 matrix that takes the flat triangle to its place, column by column.
    fn gradient(&self, places: [Vector3<f64>; 3]) -> [Vector3<f64>; 2] {
        let (base, leg) = (places[1] - places[0], places[2] - places[0]);
        let first = base / self.length;
        [first, (leg - first * self.foot) / self.height]
    }
}

/// The 3 × 2 matrix with orthonormal columns nearest to `f`: F (FᵀF)^{-½}.
///
/// **Gives** one of the nearest where there are several (columns that are parallel or zero).
pub(super) fn nearest_isometry(f: &[Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let [p, q] = f;
    let (a, b, c) = (p.norm_squared(), p.dot(q), q.norm_squared());
    // det (FᵀF) is a difference of nearly equal numbers in flat triangles; the cross product is not.
    let det = p.cross(q).norm();
    let trace = (a + c + 2.0 * det).sqrt();
    if det > 1e-12 * (a + c) {
        // √C = (C + det) / trace, and det (C + det) = det · trace².
        let [x, y, z] = [c + det, -b, a + det].map(|v| v / (det * trace));
        return [p * x + q * y, p * y + q * z];
    }
    // One direction is left: the other column is any unit vector across.
    let turn = 0.5 * (2.0 * b).atan2(a - c);
    let (sin, cos) = turn.sin_cos();
    let along = (p * cos + q * sin).try_normalize(0.0).unwrap_or_else(Vector3::x);
    let across = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
    [along * cos - across * sin, along * sin + across * cos]
}

impl Sheet {
    /// **Takes** places and charts that belong to the opened mesh, all of them finite where they are used.
    pub fn new(
        opened: &OpenedMesh,
        points: &[Point3<f64>],
        flattening: &Flattening,
        params: &FoldParams,
    ) -> Self {
        let mesh = &opened.mesh;
        let mut point_areas = vec![0.0; points.len()];
        let mut triangles = Vec::with_capacity(mesh.face_count());
        let mut side_areas = vec![0.0; mesh.edge_count()];
        let mut chart_lengths = vec![0.0; mesh.edge_count()];
        for f in mesh.faces() {
            let corners = mesh.face_vertices(f);
            let owners = corners.map(|v| opened.vertex_points[v.index()]);
            let original = owners.map(|p| points[p as usize].coords);
            let face_area =
                0.5 * (original[1] - original[0]).cross(&(original[2] - original[0])).norm();
            for p in owners {
                point_areas[p as usize] += face_area / 3.0;
            }
            let uv = corners.map(|v| flattening.uv[v.index()]);
            let is_flat = uv.iter().all(|p| p.x.is_finite() && p.y.is_finite());
            let places = if is_flat { uv.map(|p| Vector3::new(p.x, p.y, 0.0)) } else { original };
            let triangle = Triangle::flat(owners, places);
            for (i, h) in mesh.face_halfedges(f).into_iter().enumerate() {
                side_areas[h.edge().index()] += triangle.area() / 3.0;
                chart_lengths[h.edge().index()] = (places[(i + 1) % 3] - places[i]).norm();
            }
            triangles.push(triangle);
        }
        let sides = mesh
            .edges()
            .map(|e| Side {
                ends: mesh.edge_vertices(e).map(|v| opened.vertex_points[v.index()]),
                length: chart_lengths[e.index()],
                area: side_areas[e.index()],
            })
            .filter(|side| side.length > 0.0)
            .collect();
        let hinges = hinges(opened, &triangles);
        let (components, component_count) = components(points.len(), &triangles);
        let origin = (0..3).flat_map(|axis| points.iter().map(move |p| p[axis])).collect();
        Self {
            triangles,
            hinges,
            sides,
            area: point_areas.iter().sum(),
            point_areas,
            components,
            component_count,
            origin,
            bending: params.bending,
            pull: params.pull,
        }
    }

    /// The energy of a placing and, if asked for, its gradient. All divided by the area, so without unit.
    pub fn energy(&self, x: &[f64], mut gradient: Option<&mut [f64]>) -> FoldEnergy {
        let n = self.point_areas.len();
        let at = |p: u32| {
            let p = p as usize;
            Vector3::new(x[p], x[n + p], x[2 * n + p])
        };
        let add = |gradient: &mut [f64], p: u32, v: Vector3<f64>| {
            for axis in 0..3 {
                gradient[axis * n + p as usize] += v[axis];
            }
        };
        if let Some(gradient) = gradient.as_deref_mut() {
            gradient.fill(0.0);
        }
        let mut isometry = 0.0;
        for t in &self.triangles {
            let f = t.gradient(t.corners.map(at));
            let r = nearest_isometry(&f);
            let strain = [f[0] - r[0], f[1] - r[1]];
            isometry += t.share * t.area() * (strain[0].norm_squared() + strain[1].norm_squared());
            if let Some(gradient) = gradient.as_deref_mut() {
                let scale = t.share / self.area;
                let base = (strain[0] * t.height - strain[1] * t.foot) * scale;
                let leg = strain[1] * (t.length * scale);
                add(gradient, t.corners[0], -base - leg);
                add(gradient, t.corners[1], base);
                add(gradient, t.corners[2], leg);
            }
        }
        let mut bending = 0.0;
        if self.bending > 0.0 {
            for hinge in &self.hinges {
                let bend: Vector3<f64> =
                    (0..4).map(|i| at(hinge.corners[i]) * hinge.weights[i]).sum();
                bending += self.bending * bend.norm_squared();
                if let Some(gradient) = gradient.as_deref_mut() {
                    for i in 0..4 {
                        let force = bend * (2.0 * self.bending * hinge.weights[i]);
                        add(gradient, hinge.corners[i], force);
                    }
                }
            }
        }
        let mut pull = 0.0;
        if self.pull > 0.0 {
            let scale = self.pull / (self.area * self.area);
            for axis in 0..3 {
                for p in 0..n {
                    let i = axis * n + p;
                    let away = x[i] - self.origin[i];
                    pull += scale * self.point_areas[p] * away * away;
                    if let Some(gradient) = gradient.as_deref_mut() {
                        gradient[i] += 2.0 * scale * self.point_areas[p] * away;
                    }
                }
            }
        }
        let isometry = isometry / self.area;
        FoldEnergy { total: isometry + bending + pull, isometry, bending, pull }
    }

    /// The matrix that the energy's Hessian never exceeds, one block for all three coordinates: with every triangle's
    /// isometry held fixed the energy is quadratic and above itself, and this is its second derivative.
    ///
    /// **Gives** positive definite values: where nothing holds a component in place (no pull), a hair of every point's own
    /// stiffness does. It slows rigid motion, which costs nothing, and changes no energy.
    pub fn majorizer(&self) -> (Pattern, Vec<f64>) {
        let n = self.point_areas.len();
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for t in &self.triangles {
            let [a, b, c] = t.corners;
            pairs.extend([[a, b], [b, c], [c, a]]);
        }
        let hinges: &[Hinge] = if self.bending > 0.0 { &self.hinges } else { &[] };
        for hinge in hinges {
            for i in 0..4 {
                pairs.extend((0..i).map(|j| [hinge.corners[i], hinge.corners[j]]));
            }
        }
        let (pattern, slots) = Pattern::new(n, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        let mut slots = slots.into_iter();
        for t in &self.triangles {
            let cotangents = t.cotangents();
            for i in 0..3 {
                let weight = t.share * cotangents[(i + 2) % 3] / self.area;
                if let Some(slot) = slots.next() {
                    values[slot as usize] -= weight;
                }
                values[pattern.diagonal(t.corners[i] as usize)] += weight;
                values[pattern.diagonal(t.corners[(i + 1) % 3] as usize)] += weight;
            }
        }
        for hinge in hinges {
            for i in 0..4 {
                let scale = 2.0 * self.bending * hinge.weights[i];
                values[pattern.diagonal(hinge.corners[i] as usize)] += scale * hinge.weights[i];
                for j in 0..i {
                    if let Some(slot) = slots.next() {
                        values[slot as usize] += scale * hinge.weights[j];
                    }
                }
            }
        }
        // Rounding of the largest entries stays below 1e-10 of them; points without triangles rest.
        let rest = 1.0 / self.area;
        for p in 0..n {
            let diagonal = &mut values[pattern.diagonal(p)];
            *diagonal += 1e-9 * *diagonal + 1e-9 * rest;
            *diagonal += 2.0 * self.pull * self.point_areas[p] / (self.area * self.area);
        }
        (pattern, values)
    }

    /// RMS of ln (length / flat length) over all edges, weighted by the area beside them.
    pub fn stretch(&self, x: &[f64]) -> f64 {
        let n = self.point_areas.len();
        let (mut sum, mut weight) = (0.0, 0.0);
        for side in &self.sides {
            let [a, b] = side.ends.map(|p| p as usize);
            let squared: f64 = (0..3).map(|axis| (x[axis * n + a] - x[axis * n + b]).powi(2)).sum();
            // An edge that has shrunk to a point counts as a thousandth of itself.
            let log = 0.5 * (squared / (side.length * side.length)).max(1e-6).ln();
            sum += side.area * log * log;
            weight += side.area;
        }
        if weight > 0.0 { (sum / weight).sqrt() } else { 0.0 }
    }

    /// Mean length of the flat edges.
    pub fn mean_edge(&self) -> f64 {
        let sum: f64 = self.sides.iter().map(|side| side.length).sum();
        sum / self.sides.len().max(1) as f64
    }

    /// Unit normals of the original surface at its points, zero where there is none.
    pub fn normals(&self) -> Vec<Vector3<f64>> {
        let n = self.point_areas.len();
        let at = |p: u32| {
            let p = p as usize;
            Vector3::new(self.origin[p], self.origin[n + p], self.origin[2 * n + p])
        };
        let mut normals = vec![Vector3::zeros(); n];
        for t in &self.triangles {
            let [a, b, c] = t.corners.map(at);
            for p in t.corners {
                normals[p as usize] += (b - a).cross(&(c - a));
            }
        }
        normals.into_iter().map(|v| v.try_normalize(0.0).unwrap_or_default()).collect()
    }
}

/// The hinges inside charts. Seams fold freely.
fn hinges(opened: &OpenedMesh, triangles: &[Triangle]) -> Vec<Hinge> {
    let mesh = &opened.mesh;
    let pairs: Vec<[(FaceId, HalfedgeId); 2]> = mesh
        .edges()
        .filter_map(|e| {
            let sides = [e.halfedge(), e.halfedge().twin()];
            let [Some(f), Some(g)] = sides.map(|h| mesh.face(h)) else { return None };
            Some([(f, sides[0]), (g, sides[1])])
        })
        .collect();
    let area = |pair: &[(FaceId, HalfedgeId); 2]| -> f64 {
        pair.iter().map(|(f, _)| triangles[f.index()].area()).sum()
    };
    let mean = pairs.iter().map(area).sum::<f64>() / pairs.len().max(1) as f64;
    let point = |v: crate::mesh::VertexId| opened.vertex_points[v.index()];
    pairs
        .iter()
        .filter_map(|pair| {
            let ends = [point(mesh.tail(pair[0].1)), point(mesh.tip(pair[0].1))];
            let mut corners = [ends[0], ends[1], 0, 0];
            let mut weights = [0.0; 4];
            let mut steepest = 0.0f64;
            for (side, &(f, _)) in pair.iter().enumerate() {
                let t = &triangles[f.index()];
                let tip = (0..3).find(|&i| !ends.contains(&t.corners[i]))?;
                corners[2 + side] = t.corners[tip];
                let cotangents = t.cotangents();
                let at = |p: u32| t.corners.iter().position(|&c| c == p).map(|i| cotangents[i]);
                let [tail, head] = [at(ends[0])?, at(ends[1])?];
                // Where the altitude meets the edge, less where it comes from.
                weights[0] += head;
                weights[1] += tail;
                weights[2 + side] -= head + tail;
                steepest = cotangents.iter().fold(steepest, |m, c| m.max(c.abs()));
            }
            let area = area(pair).max(SMALLEST_HINGE * mean);
            let share = (STIFFEST_HINGE / steepest).min(1.0);
            let scale = share * (3.0 / area).sqrt();
            // A sheet sewn to itself so that both far corners are one point has no such hinge.
            (corners[2] != corners[3] && scale.is_finite())
                .then(|| Hinge { corners, weights: weights.map(|w| w * scale) })
        })
        .collect()
}

/// Number of the component of the sewn surface for each point, in order of first points.
fn components(points: usize, triangles: &[Triangle]) -> (Vec<u32>, usize) {
    let mut parents: Vec<u32> = (0..points as u32).collect();
    fn root(parents: &mut [u32], mut p: u32) -> u32 {
        while parents[p as usize] != p {
            parents[p as usize] = parents[parents[p as usize] as usize];
            p = parents[p as usize];
        }
        p
    }
    for t in triangles {
        for i in 1..3 {
            let [a, b] = [t.corners[0], t.corners[i]].map(|p| root(&mut parents, p));
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    let mut count = 0;
    let mut numbers = vec![0; points];
    for p in 0..points as u32 {
        let first = root(&mut parents, p);
        if first == p {
            numbers[p as usize] = count;
            count += 1;
        } else {
            numbers[p as usize] = numbers[first as usize];
        }
    }
    (numbers, count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place on a chart.
    fn chart(p: [f64; 2]) -> Vector3<f64> {
        Vector3::new(p[0], p[1], 0.0)
    }

    #[test]
    fn the_nearest_isometry_is_orthonormal_and_no_other_is_nearer() {
        let random = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 8) / 8_388_608.0 - 1.0;
        let mut cases: Vec<[Vector3<f64>; 2]> = (0..40)
            .map(|i| {
                let v = |k: u32| {
                    Vector3::new(random(6 * i + k), random(6 * i + k + 1), random(6 * i + k + 2))
                };
                [v(0), v(3)]
            })
            .collect();
        let x = Vector3::new(0.3, -0.4, 0.2);
        cases.extend([[x, x * 2.0], [x, x * -1.0], [x, Vector3::zeros()], [Vector3::zeros(), x]]);
        cases.extend([[Vector3::zeros(); 2], [x, x + Vector3::new(1e-9, 0.0, 0.0)]]);
        for f in &cases {
            let r = nearest_isometry(f);
            let distance =
                |r: &[Vector3<f64>; 2]| (f[0] - r[0]).norm_squared() + (f[1] - r[1]).norm_squared();
            // Nearly parallel columns leave half the digits for the direction across.
            for (a, b, exact) in [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 0.0)] {
                assert!((r[a].dot(&r[b]) - exact).abs() < 1e-6, "{f:?} {r:?}");
            }
            let normal = r[0].cross(&r[1]);
            for step in [-1e-3, 1e-3] {
                let (sin, cos) = f64::sin_cos(step);
                for turned in [
                    [r[0] * cos + r[1] * sin, r[1] * cos - r[0] * sin],
                    [r[0] * cos + normal * sin, r[1]],
                    [r[0], r[1] * cos + normal * sin],
                ] {
                    assert!(distance(&turned) > distance(&r) - 1e-9, "{f:?}");
                }
            }
        }
    }

    #[test]
    fn a_flat_triangle_keeps_its_shape_whichever_side_comes_first() {
        let places = [[0.0, 0.0], [2.0, 0.5], [0.4, 0.9]].map(chart);
        for turn in 0..3 {
            let i = [0, 1, 2].map(|k| (k + turn) % 3);
            let t = Triangle::flat(i.map(|k| k as u32), i.map(|k| places[k]));
            assert_eq!(t.corners, [0, 1, 2], "the longest side joins corners 0 and 1");
            assert!((t.area() - 0.5 * (2.0 * 0.9 - 0.5 * 0.4)).abs() < 1e-14);
            let f = t.gradient(places);
            assert!((f[0].norm() - 1.0).abs() < 1e-14 && (f[1].norm() - 1.0).abs() < 1e-14);
            assert!(f[0].dot(&f[1]).abs() < 1e-14);
        }
        let needle = Triangle::flat([0, 1, 2], [[0.0, 0.0], [1.0, 0.0], [1.0, 1e-6]].map(chart));
        assert!((needle.share * 1e6 / STIFFEST - 1.0).abs() < 1e-6);
        let nothing = Triangle::flat([0, 1, 2], [[0.0, 0.0]; 3].map(chart));
        assert!(nothing.cotangents().iter().all(|c| c.is_finite()));
    }
}
