//! Level sets near the cut: one value for each nearby label, stored for vertices within a few rings only.
//!
//! φ_k is negative inside region k. A vertex of the band stores φ_k for every label whose boundary is near, and for each the
//! closest place of that boundary, found by handing segments from vertex to vertex along the mesh: two sheets that are close
//! in space but not on the surface never see each other.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::candidates::{Candidates, Nearest, joined};
use super::cut::{Crossing, Cut, NONE, Node};
use super::energy::Problem;
use crate::mesh::VertexId;

/// Rings of vertices around the crossed faces that carry level sets. With fewer than two a cut that moves one edge leaves
/// its band; more than three only cost.
const RINGS: u8 = 3;

/// Stands for a label that is not stored at a vertex: farther than any step, in mean edge lengths.
const FAR: f64 = 4.0;

/// Labels of all vertices and level-set values of those near the cut.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LevelSets {
    /// The label of every vertex: its smallest level set.
    pub labels: Vec<u32>,
    /// Where each vertex's entries begin; one more entry than vertices.
    starts: Vec<u32>,
    entry_labels: Vec<u32>,
    pub values: Vec<f64>,
    far: f64,
}

/// For each level-set entry how it follows the crossings: δφ = Σ coefficient · δ, at most three crossings.
#[derive(Clone, Debug, Default)]
pub(super) struct Response {
    rows: Vec<[(u32, f64); 3]>,
}

impl LevelSets {
    /// Level sets `level(v, label)` at the vertices of the crossed faces of a first cut, so that its crossings stay where
    /// linear interpolation puts them.
    pub fn around(
        problem: &Problem,
        cut: &Cut,
        labels: Vec<u32>,
        level: impl Fn(VertexId, u32) -> f64,
        mean_edge: f64,
    ) -> Self {
        let mut near: Vec<(VertexId, u32)> = Vec::new();
        for crossed in &cut.faces {
            let vertices = problem.mesh.face_vertices(crossed.face);
            for v in vertices {
                near.extend(vertices.map(|w| (v, labels[w.index()])));
            }
        }
        near.sort_unstable();
        near.dedup();
        let mut result = Self {
            starts: vec![0; labels.len() + 1],
            entry_labels: near.iter().map(|&(_, label)| label).collect(),
            values: Vec::with_capacity(near.len()),
            far: FAR * mean_edge,
            labels,
        };
        for &(v, label) in &near {
            result.starts[v.index() + 1] += 1;
            result.values.push(level(v, label));
        }
        for v in 0..result.labels.len() {
            result.starts[v + 1] += result.starts[v];
        }
        result
    }

    fn range(&self, v: VertexId) -> std::ops::Range<usize> {
        self.starts[v.index()] as usize..self.starts[v.index() + 1] as usize
    }

    /// The vertices that carry level sets.
    pub fn band(&self) -> impl Iterator<Item = VertexId> + '_ {
        (0..self.labels.len() as u32)
            .map(VertexId)
            .filter(|v| self.starts[v.index()] != self.starts[v.index() + 1])
    }

    /// Where φ_label(v) is stored.
    pub fn entry(&self, v: VertexId, label: u32) -> Option<usize> {
        self.range(v).find(|&i| self.entry_labels[i] == label)
    }

    /// Entries of a vertex with their labels.
    pub fn entries(&self, v: VertexId) -> impl Iterator<Item = (usize, u32)> + use<'_> {
        self.range(v).map(|i| (i, self.entry_labels[i]))
    }

    /// φ_label(v), far outside if it is not stored.
    pub fn value(&self, v: VertexId, label: u32) -> f64 {
        self.entry(v, label).map_or(self.far, |i| self.values[i])
    }

    /// φ_label(v), far inside or outside if it is not stored.
    pub fn signed_value(&self, v: VertexId, label: u32) -> f64 {
        match self.entry(v, label) {
            Some(entry) => self.values[entry],
            None if self.labels[v.index()] == label => -self.far,
            None => self.far,
        }
    }

    /// φ_lower(v) − φ_upper(v).
    pub fn difference(&self, v: VertexId, lower: u32, upper: u32) -> f64 {
        self.value(v, lower) - self.value(v, upper)
    }

    /// Shifts the values at each band vertex so that the two smallest are opposite, and gives every vertex the label of its
    /// smallest value. Crossings depend on differences only and do not move.
    pub fn project(&mut self) {
        for v in 0..self.labels.len() {
            let range = self.range(VertexId::from(v));
            if range.len() < 2 {
                continue;
            }
            let (mut first, mut second) = (usize::MAX, usize::MAX);
            for i in range.clone() {
                if first == usize::MAX || self.values[i] < self.values[first] {
                    second = first;
                    first = i;
                } else if second == usize::MAX || self.values[i] < self.values[second] {
                    second = i;
                }
            }
            let mean = 0.5 * (self.values[first] + self.values[second]);
            self.labels[v] = self.entry_labels[first];
            for i in range {
                self.values[i] -= mean;
            }
        }
    }

    /// Makes `label` win at a vertex by at least `margin`: the answer to a refused change.
    pub fn put_back(&mut self, v: VertexId, label: u32, margin: f64) {
        for i in self.range(v) {
            if self.entry_labels[i] == label {
                self.values[i] = -margin;
            } else {
                self.values[i] = self.values[i].max(margin);
            }
        }
        self.labels[v.index()] = label;
    }

    /// Builds the band of a cut.
    ///
    /// Values of `kept` survive where both the vertex and the label belong to a crossed face, so that the cut does not move;
    /// everything else becomes the signed distance to the closest place of the label's boundary.
    /// **Gives** also the linear response of every entry to normal displacements of the crossings.
    pub fn rebuild(problem: &Problem, cut: &Cut, kept: Self, mean_edge: f64) -> (Self, Response) {
        let mesh = &problem.mesh;
        let places = Places::new(problem, cut);
        let mut candidates = Candidates::new(mesh.vertex_count());
        let (mut band, mut ring): (Vec<VertexId>, Vec<VertexId>) = Default::default();
        let mut near_labels: Vec<u64> = Vec::new();
        for crossed in &cut.faces {
            let count = if crossed.lone == 3 { 3 } else { 1 };
            let vertices = mesh.face_vertices(crossed.face);
            let own_labels = vertices.map(|v| kept.labels[v.index()]);
            for v in vertices {
                if candidates.is_empty(v) {
                    ring.push(v);
                }
                for segment in crossed.first_segment..crossed.first_segment + count {
                    let labels = cut.segments[segment as usize].labels;
                    candidates.offer(v, labels, places.nearest(problem, v, segment));
                }
                for (k, label) in own_labels.iter().enumerate() {
                    if !own_labels[..k].contains(label) {
                        near_labels.push(joined(v, *label));
                    }
                }
            }
        }
        near_labels.sort_unstable();
        near_labels.dedup();
        // Chains of the ring's vertices beside each vertex: its first link, and of each link a vertex and the next one.
        let mut firsts = vec![NONE; mesh.vertex_count()];
        let mut links: Vec<(VertexId, u32)> = Vec::new();
        let (mut beside, mut near): (Vec<VertexId>, Vec<u32>) = Default::default();
        let mut offers: Vec<(VertexId, u32)> = Vec::new();
        for _ in 0..RINGS {
            // A second offer to the vertices at hand, then on to their neighbours.
            beside.clear();
            links.clear();
            for &v in &ring {
                for w in mesh.outgoing(v).map(|h| mesh.tip(h)) {
                    let first = std::mem::replace(&mut firsts[w.index()], links.len() as u32);
                    links.push((v, first));
                    if first == NONE {
                        beside.push(w);
                    }
                }
            }
            beside.sort_unstable();
            offers.clear();
            for &w in &beside {
                near.clear();
                let mut at = std::mem::replace(&mut firsts[w.index()], NONE);
                while at != NONE {
                    let (v, next) = links[at as usize];
                    candidates.for_each(v, |_, nearest| {
                        if !near.contains(&nearest.segment) {
                            near.push(nearest.segment);
                        }
                    });
                    at = next;
                }
                near.sort_unstable();
                let is_news = |&segment: &u32| {
                    !candidates.has(w, cut.segments[segment as usize].labels, segment)
                };
                offers.extend(near.iter().copied().filter(is_news).map(|segment| (w, segment)));
            }
            band.append(&mut ring);
            for &(w, segment) in &offers {
                if candidates.is_empty(w) {
                    ring.push(w);
                }
                let labels = cut.segments[segment as usize].labels;
                candidates.offer(w, labels, places.nearest(problem, w, segment));
            }
        }

        band.append(&mut ring);

        let mut result = Self {
            labels: kept.labels.clone(),
            starts: vec![0; mesh.vertex_count() + 1],
            entry_labels: Vec::with_capacity(candidates.len()),
            values: Vec::with_capacity(candidates.len()),
            far: FAR * mean_edge,
        };
        let mut response = Response { rows: Vec::with_capacity(candidates.len()) };
        let mut near_labels = &near_labels[..];
        let slopes = Slopes::new(problem, cut);
        let mut list: Vec<(u32, Nearest)> = Vec::new();
        let mut started = 0;
        band.sort_unstable();
        for &v in &band {
            result.starts[started..=v.index()].fill(result.values.len() as u32);
            started = v.index() + 1;
            list.clear();
            candidates.for_each(v, |label, nearest| list.push((label, *nearest)));
            list.sort_unstable_by_key(|(label, _)| *label);
            let own = kept.labels[v.index()];
            let passed = near_labels.iter().take_while(|&&l| l < joined(v, 0)).count();
            near_labels = &near_labels[passed..];
            for &(label, nearest) in list.iter() {
                let inside = label == own;
                let of_vertex = near_labels.iter().take_while(|&&l| l <= joined(v, label));
                let is_near = of_vertex.last() == Some(&joined(v, label));
                let distance = if inside { -nearest.distance } else { nearest.distance };
                let value = match kept.entry(v, label) {
                    Some(old) if is_near => kept.values[old],
                    _ => distance,
                };
                result.entry_labels.push(label);
                result.values.push(value);
                let mut row = places.row(problem, cut, &slopes, v, label, inside, &nearest);
                if let Some(pin) = problem.pins.get(v.index()) {
                    row.iter_mut().for_each(|(_, coefficient)| *coefficient *= 1.0 - pin);
                }
                response.rows.push(row);
            }
        }
        result.starts[started..].fill(result.values.len() as u32);
        (result, response)
    }
}

impl Response {
    /// values += scale · B δ.
    pub fn apply(&self, displacements: &[f64], scale: f64, values: &mut [f64]) {
        for (row, value) in self.rows.iter().zip(values) {
            let mut sum = 0.0;
            for &(crossing, coefficient) in row {
                if crossing != NONE {
                    sum += coefficient * displacements[crossing as usize];
                }
            }
            *value += scale * sum;
        }
    }

    /// g = Bᵀ (∂t/∂φ)ᵀ dJ/dt: the exact derivative of J with respect to normal displacements of the crossings.
    pub fn pull_back(
        &self,
        problem: &Problem,
        cut: &Cut,
        levels: &LevelSets,
        forces: &[f64],
    ) -> Vec<f64> {
        let mut gradient = vec![0.0; forces.len()];
        let mut spread = |entry: Option<usize>, amount: f64| {
            let Some(entry) = entry else { return };
            for &(crossing, coefficient) in &self.rows[entry] {
                if crossing != NONE {
                    gradient[crossing as usize] += coefficient * amount;
                }
            }
        };
        for (crossing, force) in cut.crossings.iter().zip(forces) {
            let [d0, d1] = crossing.d;
            let square = (d0 - d1) * (d0 - d1);
            let ends = problem.mesh.edge_vertices(crossing.edge);
            for (v, slope) in ends.into_iter().zip([-d1 / square, d0 / square]) {
                let [lower, upper] = crossing.labels;
                spread(levels.entry(v, lower), force * slope);
                spread(levels.entry(v, upper), -force * slope);
            }
        }
        gradient
    }
}

/// How steep the level sets are at the crossings: |∇φ| along the cut's normal.
pub(super) struct Slopes(Vec<f64>);

impl Slopes {
    /// Clipped to [.2, 5]: flatter and a small displacement moves the values of a whole neighbourhood past each other,
    /// steeper and the cut sticks.
    fn new(problem: &Problem, cut: &Cut) -> Self {
        let mut sine = vec![0.0; cut.crossings.len()];
        let mut weight = vec![0.0; cut.crossings.len()];
        for crossed in &cut.faces {
            let corners = problem.frames.corners(crossed.face);
            for (side, &c) in crossed.crossings.iter().enumerate() {
                if c == NONE {
                    continue;
                }
                let along = (corners[(side + 1) % 3] - corners[side]).normalize();
                let count = if crossed.lone == 3 { 3 } else { 1 };
                for s in crossed.first_segment..crossed.first_segment + count {
                    let segment = &cut.segments[s as usize];
                    if segment.ends.contains(&Node::Crossing(c)) {
                        sine[c as usize] += segment.length * along.dot(&segment.normal).abs();
                        weight[c as usize] += segment.length;
                    }
                }
            }
        }
        Self(
            cut.crossings
                .iter()
                .zip(sine.iter().zip(&weight))
                .map(|(crossing, (sine, weight))| {
                    let length = problem.geometry.edge_length(crossing.edge);
                    let along = 0.5 * (crossing.d[0] - crossing.d[1]).abs() / length;
                    (along * weight.max(1e-300) / sine.max(1e-300)).clamp(0.2, 5.0)
                })
                .collect(),
        )
    }
}

/// Displacement of a triple point as a linear function of its three crossings: w⃗ = (NᵀWN)⁻¹NᵀW δ, the place that
/// stretches the three spokes least.
#[derive(Clone, Copy, Debug)]
pub(super) struct CentreResponse {
    /// w⃗ per unit displacement of each crossing, in the face's frame.
    pub columns: [nalgebra::Vector2<f64>; 3],
    /// Stiffness left after that: Q = W − WN(NᵀWN)⁻¹NᵀW.
    pub stiffness: [[f64; 3]; 3],
    pub crossings: [u32; 3],
    pub first_segment: u32,
}

/// Stiffnesses 1/length of spokes shorter than this (in mean edge lengths) would make a triple point rigid.
const SHORTEST_SPOKE: f64 = 0.05;

impl CentreResponse {
    pub fn new(cut: &Cut, centre: usize, mean_edge: f64) -> Self {
        let crossed = &cut.faces[cut.centres[centre] as usize];
        let spokes = [0, 1, 2].map(|i| &cut.segments[crossed.first_segment as usize + i]);
        let weights = spokes.map(|s| 1.0 / s.length.max(SHORTEST_SPOKE * mean_edge));
        let normals = spokes.map(|s| s.normal);
        let mut square = nalgebra::Matrix2::zeros();
        for (w, n) in weights.iter().zip(&normals) {
            square += n * n.transpose() * *w;
        }
        let size = square.trace();
        let mut columns = [nalgebra::Vector2::zeros(); 3];
        // Three spokes on one line hold the point only across; then it follows none of them.
        if square.determinant() > 1e-9 * size * size
            && let Some(inverse) = square.try_inverse()
        {
            for i in 0..3 {
                columns[i] = inverse * normals[i] * weights[i];
            }
        }
        let mut stiffness = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                let own = if i == j { weights[i] } else { 0.0 };
                stiffness[i][j] = own - weights[i] * normals[i].dot(&columns[j]);
            }
        }
        Self {
            columns,
            stiffness,
            crossings: crossed.crossings,
            first_segment: crossed.first_segment,
        }
    }
}

/// Places of the cut's nodes in space.
struct Places {
    crossings: Vec<Point3<f64>>,
    centres: Vec<Point3<f64>>,
    responses: Vec<CentreResponse>,
    ends: Vec<[Node; 2]>,
}

impl Places {
    fn new(problem: &Problem, cut: &Cut) -> Self {
        let mean_edge = problem.geometry.mean_edge_length();
        let crossings: Vec<Point3<f64>> =
            cut.crossings.iter().map(|c| crossing_place(problem, c)).collect();
        let centres = cut
            .centres
            .iter()
            .map(|&face| {
                let sum: Vector3<f64> = cut.faces[face as usize]
                    .crossings
                    .iter()
                    .map(|&c| crossings[c as usize].coords)
                    .sum();
                Point3::from(sum / 3.0)
            })
            .collect();
        let responses =
            (0..cut.centres.len()).map(|i| CentreResponse::new(cut, i, mean_edge)).collect();
        let ends = cut.segments.iter().map(|s| s.ends).collect();
        Self { crossings, centres, responses, ends }
    }

    fn at(&self, node: Node) -> Point3<f64> {
        match node {
            Node::Crossing(i) => self.crossings[i as usize],
            Node::Centre(i) => self.centres[i as usize],
        }
    }

    fn nearest(&self, problem: &Problem, v: VertexId, segment: u32) -> Nearest {
        let [a, b] = self.ends[segment as usize].map(|node| self.at(node));
        let p = problem.geometry.positions[v.index()];
        let along = b - a;
        let square = along.norm_squared();
        let fraction =
            if square > 0.0 { ((p - a).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
        Nearest { segment, fraction, distance: (p - (a + along * fraction)).norm() }
    }

    /// The row of B for one entry.
    #[expect(clippy::too_many_arguments, reason = "one row depends on all of this")]
    fn row(
        &self,
        problem: &Problem,
        cut: &Cut,
        slopes: &Slopes,
        v: VertexId,
        label: u32,
        inside: bool,
        nearest: &Nearest,
    ) -> [(u32, f64); 3] {
        let segment = &cut.segments[nearest.segment as usize];
        let sign = if label == segment.labels[0] { -1.0 } else { 1.0 };
        let w = nearest.fraction;
        let mut row = [(NONE, 0.0); 3];
        match segment.ends {
            [Node::Crossing(a), Node::Crossing(b)] => {
                row[0] = (a, sign * (1.0 - w) * slopes.0[a as usize]);
                row[1] = (b, sign * w * slopes.0[b as usize]);
            }
            [Node::Crossing(a), Node::Centre(m)] => {
                let response = &self.responses[m as usize];
                let mean_slope =
                    response.crossings.iter().map(|&c| slopes.0[c as usize]).sum::<f64>() / 3.0;
                let spoke = (nearest.segment - response.first_segment) as usize;
                for i in 0..3 {
                    row[i].0 = response.crossings[i];
                }
                // Closest to the triple point itself and off the spoke's normal: the distance to a moving point.
                let away = problem.geometry.positions[v.index()] - self.centres[m as usize];
                let distance = away.norm();
                if w >= 1.0 && distance > 1e-12 {
                    let [e1, e2] = face_axes(problem, segment.face);
                    let direction = nalgebra::Vector2::new(away.dot(&e1), away.dot(&e2)) / distance;
                    let sign = if inside { 1.0 } else { -1.0 };
                    for i in 0..3 {
                        row[i].1 = sign * mean_slope * response.columns[i].dot(&direction);
                    }
                } else {
                    for i in 0..3 {
                        row[i].1 = sign * w * mean_slope * segment.normal.dot(&response.columns[i]);
                    }
                    row[spoke].1 += sign * (1.0 - w) * slopes.0[a as usize];
                }
            }
            _ => debug_assert!(false, "segments start at a crossing"),
        }
        row
    }
}

/// Unit axes of a face's frame in space.
fn face_axes(problem: &Problem, f: crate::mesh::FaceId) -> [Vector3<f64>; 2] {
    let [a, b, c] = problem.mesh.face_vertices(f).map(|v| problem.geometry.positions[v.index()]);
    let e1 = (b - a).normalize();
    let side = c - a;
    let e2 = (side - e1 * side.dot(&e1)).normalize();
    [e1, e2]
}

/// Where a crossing lies in space.
pub(super) fn crossing_place(problem: &Problem, crossing: &Crossing) -> Point3<f64> {
    let [a, b] =
        problem.mesh.edge_vertices(crossing.edge).map(|v| problem.geometry.positions[v.index()]);
    a + (b - a) * crossing.t
}
