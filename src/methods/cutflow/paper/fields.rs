//! Fields on the whole surface: the harmonic extension of a speed, signed distances, a step of curve shortening.

use nalgebra::Vector2;

use super::super::band::LevelSets;
use super::super::cut::{Corner, Cut};
use super::super::energy::{Element, Problem};
use super::super::terms::Weights;
use super::prices::length_price;
use super::sides::Sides;
use crate::geometry::geodesic_distances_from;
use crate::linalg::{Factor, LinalgError};
use crate::mesh::VertexId;

/// Stands for the distance on a component that a label's border does not touch: more than any surface of unit area needs.
const UNREACHED: f64 = 10.0;

/// The function that is harmonic on every patch and has given values on the sides of the cut, with the factor of u.
///
/// The factor holds the mesh's boundary too; there the values go linearly along the boundary from one end of a cut to the next,
/// and are 0 on loops that no cut meets. **Costs** one solve.
pub(super) fn extend(sides: &Sides, at_sides: &[f64], factor: &mut Factor) -> Vec<f64> {
    let (problem, cut) = (sides.problem, sides.cut);
    let (mesh, geometry) = (&problem.mesh, &problem.geometry);
    let held = boundary_values(sides, at_sides);
    let mut field = held.clone();
    let free = |v: VertexId| !problem.is_pinned(v);
    let mut next_crossed = cut.faces.iter().peekable();
    for f in mesh.faces() {
        let vertices = mesh.face_vertices(f);
        if next_crossed.peek().is_none_or(|c| c.face != f) {
            for i in 0..3 {
                for j in (0..3).filter(|&j| j != i) {
                    if free(vertices[i]) && !free(vertices[j]) {
                        let weight = 0.5 * geometry.corner_cotangents[f.index()][3 - i - j];
                        field[vertices[i].index()] += weight * held[vertices[j].index()];
                    }
                }
            }
            continue;
        }
        let Some(crossed) = next_crossed.next() else { continue };
        let points = cut.face_points(mesh, &problem.frames, crossed);
        for (triangle, _) in points.triangles(crossed.lone) {
            let element = Element::new(&points, triangle);
            let at = sides.of_triangle(crossed, triangle);
            for (i, corner) in triangle.into_iter().enumerate() {
                let Corner::Vertex(own) = corner else { continue };
                let v = vertices[own];
                if !free(v) {
                    continue;
                }
                for j in (0..3).filter(|&j| j != i) {
                    let value = match (at[j], triangle[j]) {
                        (Some(side), _) => at_sides[side],
                        (None, Corner::Vertex(other)) => held[vertices[other].index()],
                        (None, _) => 0.0,
                    };
                    let is_known = match triangle[j] {
                        Corner::Vertex(other) => !free(vertices[other]),
                        _ => true,
                    };
                    if is_known {
                        field[v.index()] -= element.stiffness(i, j) * value;
                    }
                }
            }
        }
    }
    factor.solve(&mut field, 1);
    field
}

/// Values at the vertices of the mesh's boundary, linear along it between the cuts that end there.
fn boundary_values(sides: &Sides, at_sides: &[f64]) -> Vec<f64> {
    let Sides { problem, cut, labels, .. } = *sides;
    let (mesh, geometry) = (&problem.mesh, &problem.geometry);
    let mut values = vec![0.0; mesh.vertex_count()];
    for &start in mesh.boundary_loops() {
        let mut stations: Vec<(f64, u32)> = Vec::new();
        let mut places: Vec<(f64, VertexId)> = Vec::new();
        let mut length = 0.0;
        for h in mesh.boundary_loop(start) {
            let edge = geometry.edge_length(h.edge());
            places.push((length, mesh.tail(h)));
            if let Ok(c) = cut.crossings.binary_search_by_key(&h.edge(), |c| c.edge) {
                let t = cut.crossings[c].t;
                let from_tail = if h.0 & 1 == 0 { t } else { 1.0 - t };
                stations.push((length + edge * from_tail, u32::try_from(c).unwrap_or(u32::MAX)));
            }
            length += edge;
        }
        let (Some(first), Some(last)) = (stations.first().copied(), stations.last().copied())
        else {
            continue;
        };
        for (place, v) in places {
            let after = stations.partition_point(|s| s.0 <= place);
            let before = match after.checked_sub(1) {
                Some(i) => stations[i],
                None => (last.0 - length, last.1),
            };
            let after = stations.get(after).copied().unwrap_or((first.0 + length, first.1));
            let value = |c: u32| at_sides[sides.of_crossing(c, labels[v.index()])];
            let w = (place - before.0) / (after.0 - before.0).max(1e-300);
            values[v.index()] = (1.0 - w) * value(before.1) + w * value(after.1);
        }
    }
    values
}

/// Signed distance of every vertex to the cut, negative: the vertex lies inside its own region.
///
/// Exact within the crossed faces, marched from there. **Costs** one march.
pub(super) fn depths(problem: &Problem, cut: &Cut) -> Vec<f64> {
    let mut near: Vec<(VertexId, f64)> = Vec::with_capacity(3 * cut.faces.len());
    for crossed in &cut.faces {
        let points = cut.face_points(&problem.mesh, &problem.frames, crossed);
        let segments: Vec<[Vector2<f64>; 2]> = if crossed.lone == 3 {
            points.sides.iter().map(|side| [*side, points.centre]).collect()
        } else {
            let own = crossed.lone as usize;
            vec![[points.sides[own], points.sides[(own + 2) % 3]]]
        };
        for (v, p) in problem.mesh.face_vertices(crossed.face).into_iter().zip(points.corners) {
            for [a, b] in &segments {
                let along = b - a;
                let t = (p - a).dot(&along) / along.norm_squared().max(1e-300);
                near.push((v, (p - (a + along * t.clamp(0.0, 1.0))).norm()));
            }
        }
    }
    near.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    near.dedup_by_key(|(v, _)| *v);
    geodesic_distances_from(&problem.mesh, &problem.geometry, &near)
        .into_iter()
        .map(|distance| -distance.min(UNREACHED))
        .collect()
}

/// Signed distances φ_k to the borders of all labels, on all vertices; of two labels only the first, the other is its negative.
#[derive(Clone)]
pub(super) struct Distances {
    labels: Vec<u32>,
    fields: Vec<Vec<f64>>,
}

impl Distances {
    /// **Takes** the level sets near the cut, whose values beside it are kept: measured anew they would let the cut drift.
    /// **Costs** one march over the surface for each label.
    pub fn new(problem: &Problem, cut: &Cut, levels: &LevelSets) -> Self {
        let mut labels = levels.labels.clone();
        labels.sort_unstable();
        labels.dedup();
        let mut near = Vec::new();
        for crossed in &cut.faces {
            let vertices = problem.mesh.face_vertices(crossed.face);
            for v in vertices {
                near.extend(vertices.map(|w| (levels.labels[w.index()], v)));
            }
        }
        near.sort_unstable();
        near.dedup();
        let count = if labels.len() == 2 { 1 } else { labels.len() };
        let fields = labels[..count]
            .iter()
            .map(|&label| {
                let begin = near.partition_point(|&(k, _)| k < label);
                let end = near.partition_point(|&(k, _)| k <= label);
                let seeds: Vec<(VertexId, f64)> = near[begin..end]
                    .iter()
                    .map(|&(_, v)| (v, levels.value(v, label).abs()))
                    .collect();
                let mut field = geodesic_distances_from(&problem.mesh, &problem.geometry, &seeds);
                for (distance, own) in field.iter_mut().zip(&levels.labels) {
                    let reached = distance.min(UNREACHED);
                    *distance = if *own == label { -reached } else { reached };
                }
                field
            })
            .collect();
        Self { labels, fields }
    }

    /// φ_label(v).
    pub fn value(&self, v: VertexId, label: u32) -> f64 {
        match self.labels.binary_search(&label) {
            Ok(i) if i < self.fields.len() => self.fields[i][v.index()],
            Ok(_) => -self.fields[0][v.index()],
            Err(_) => UNREACHED,
        }
    }

    /// ½(φ_own − smallest other): what the projection of [Los06] makes of the value of `own`.
    pub fn projected(&self, v: VertexId, own: u32) -> f64 {
        let other = self
            .labels
            .iter()
            .filter(|&&label| label != own)
            .map(|&label| self.value(v, label))
            .fold(f64::INFINITY, f64::min);
        if other < f64::INFINITY { 0.5 * (self.value(v, own) - other) } else { self.value(v, own) }
    }

    /// Number of fields.
    pub fn count(&self) -> usize {
        self.fields.len()
    }

    /// φ_k − τ dφ_k: `growth` is the speed at which each vertex's own region grows; all others recede.
    pub fn advect(&mut self, own: &[u32], growth: &[f64], step: f64) {
        for (field, label) in self.fields.iter_mut().zip(&self.labels) {
            for ((value, own), growth) in field.iter_mut().zip(own).zip(growth) {
                *value -= if own == label { step * growth } else { -step * growth };
            }
        }
    }

    /// Implicit curve shortening: (M + τ L_α) φ = M φ̃ for every field.
    ///
    /// **Differs** from [VSC] 7.1: L_α has the price of each face within, so that a price that varies adds its slope.
    /// **Costs** one factorisation and a solve for each field.
    pub fn shorten(
        &mut self,
        problem: &Problem,
        weights: &Weights,
        step: f64,
        factor: &mut Option<Factor>,
    ) -> Result<(), LinalgError> {
        let (mesh, geometry) = (&problem.mesh, &problem.geometry);
        let pattern = problem.analysis.pattern();
        let mut values = vec![0.0; pattern.entry_count()];
        let areas = geometry.vertex_dual_areas(mesh);
        for f in mesh.faces() {
            let price = step * length_price(problem, weights, f);
            let vertices = mesh.face_vertices(f);
            for (i, h) in mesh.face_halfedges(f).into_iter().enumerate() {
                let weight = 0.5 * price * geometry.corner_cotangents[f.index()][(i + 2) % 3];
                values[problem.edge_slot(h.edge())] -= weight;
                values[pattern.diagonal(vertices[i].index())] += weight;
                values[pattern.diagonal(vertices[(i + 1) % 3].index())] += weight;
            }
        }
        for (v, area) in areas.iter().enumerate() {
            // Vertices without faces keep what they have.
            values[pattern.diagonal(v)] += if *area > 0.0 { *area } else { 1.0 };
        }
        let factor = match factor {
            Some(old) => {
                old.refactor(&values)?;
                old
            }
            None => factor.insert(Factor::new(problem.analysis.clone(), &values)?),
        };
        let mut all = Vec::with_capacity(self.fields.len() * areas.len());
        for field in &self.fields {
            let weigh =
                |(value, area): (&f64, &f64)| if *area > 0.0 { value * area } else { *value };
            all.extend(field.iter().zip(&areas).map(weigh));
        }
        factor.solve(&mut all, self.fields.len());
        for (field, solved) in self.fields.iter_mut().zip(all.chunks(areas.len())) {
            field.copy_from_slice(solved);
        }
        Ok(())
    }
}
