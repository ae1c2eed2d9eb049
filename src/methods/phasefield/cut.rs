//! From fields to a cut: labels by the sign of every field, crossings at its zeros.

use std::collections::BTreeMap;

use super::domain::Domain;
use super::profile::STEEPNESS;
use super::state::PhaseFieldState;
use super::terms::sharp;
use crate::geometry::Geometry;
use crate::linalg::LinalgError;
use crate::mesh::{CutMesh, EdgeId, Mesh};
use crate::methods::cutflow::cut::{Cut, Frames};
use crate::methods::cutflow::{Initial, labelled_cut};

/// What is measured of a finished split. Lengths and areas are those at area 4π.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseMeasures {
    /// Length of the zero set of u inside the segment, through triangles.
    pub length: f64,
    /// Number of connected parts of {u > 0} and {u < 0} inside the segment, by vertices joined by edges.
    pub components: [usize; 2],
    /// ∫s² of both sides with sharp borders: the Hencky loss. Infinite for a closed component in one piece, 0 for a side that is not there.
    pub sharp: [f64; 2],
}

impl PhaseFieldState {
    /// The surface refined along the borders of the leaves: crossings lie at the zero of the field where the ways of two labels part.
    ///
    /// **Takes** a triangulation with the vertices of the fields, whatever its edges.
    pub fn cut_mesh_on(&self, mesh: &Mesh, geometry: &Geometry) -> CutMesh {
        labelled_cut(mesh, geometry, &self.labels(), |ends| self.crossing(ends.map(|v| v.index())))
    }

    /// The leaves as the start of a cut flow: level sets where there are two, labels with level sets nearby where there are more.
    /// Labels are numbered anew without gaps.
    ///
    /// **Takes** ε over [`super::length_scale`]: the width of the interface in the geometry's unit.
    pub fn cut_start(&self, mesh: &Mesh, width: f64) -> Initial {
        // Back from the profile to the distance.
        let distance = |u: f64| {
            let u = u.clamp(-0.999, 0.999);
            0.5 * ((1.0 + u) / (1.0 - u)).ln() * width / STEEPNESS
        };
        if let [root, ..] = &self.nodes[..]
            && self.leaves().len() == 2
        {
            // 0 is positive here, and is outside there.
            let level = |(v, &u): (usize, &f64)| {
                let size = distance(u).abs();
                if self.is_positive(0, v) { -size.max(1e-12) } else { size }
            };
            return Initial::Levels(root.u.iter().enumerate().map(level).collect());
        }
        let mut labels = self.labels();
        let mut is_used = vec![false; self.leaves().len()];
        for &label in &labels {
            is_used[label as usize] = true;
        }
        let mut next = 0;
        let numbers: Vec<u32> = is_used
            .iter()
            .map(|&used| {
                next += u32::from(used);
                next.saturating_sub(1)
            })
            .collect();
        for label in &mut labels {
            *label = numbers[*label as usize];
        }
        // How far every vertex at a border lies from it, for its own label and the one across.
        let mut near: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); labels.len()];
        for e in mesh.edges() {
            let ends = mesh.edge_vertices(e).map(|v| v.index());
            let Some(node) = self.parting(ends) else { continue };
            for (v, w) in [(ends[0], ends[1]), (ends[1], ends[0])] {
                let size = distance(self.nodes[node].u[v]).abs();
                for (label, level) in [(labels[v], -size), (labels[w], size)] {
                    let entry = near[v].entry(label).or_insert(level);
                    if level.abs() < entry.abs() {
                        *entry = level;
                    }
                }
            }
        }
        let (mut starts, mut entries) = (vec![0], Vec::new());
        for levels in near {
            entries.extend(levels);
            starts.push(u32::try_from(entries.len()).unwrap_or(u32::MAX));
        }
        Initial::LabelLevels { labels, starts, entries }
    }

    /// Length, parts and sharp losses of a split.
    pub(super) fn measure(
        &self,
        domain: &Domain,
        node: usize,
    ) -> Result<PhaseMeasures, LinalgError> {
        let none = PhaseMeasures { length: 0.0, components: [0; 2], sharp: [0.0; 2] };
        if self.nodes.get(node).is_none_or(|n| n.children.is_none()) {
            return Ok(none);
        }
        let sides = self.sides(node);
        let (mesh, geometry) = (&*domain.mesh, &*domain.geometry);
        let frames = Frames::new(mesh, geometry);
        let place =
            |e: EdgeId| self.crossing(mesh.edge_vertices(e).map(|v| v.index())).unwrap_or(0.5);
        let cut = Cut::of_labels(mesh, &frames, &sides, place);
        let losses = sharp::losses(domain, &frames, &cut, &sides, 3)?;
        Ok(PhaseMeasures {
            length: self.interface_length(domain, &frames, node) * domain.scale,
            components: components(mesh, &sides),
            sharp: [losses[0], losses[1]],
        })
    }
}

impl PhaseFieldState {
    /// Length of the zero set of a split's field, linear on faces, where the fields above it have the signs of the segment.
    fn interface_length(&self, domain: &Domain, frames: &Frames, node: usize) -> f64 {
        let path = self.path(node);
        let u = &self.nodes[node].u;
        let mut length = 0.0;
        for f in domain.mesh.faces() {
            let corners = domain.triangles[f.index()].map(|v| v as usize);
            let values = corners.map(|v| u[v]);
            // Where the sides cross 0, as weights of the corners.
            let mut ends = [[0.0; 3]; 2];
            let mut found = 0;
            for i in 0..3 {
                let j = (i + 1) % 3;
                let is_crossed = (values[i] >= 0.0) != (values[j] >= 0.0);
                if is_crossed && found < 2 {
                    let t = values[i] / (values[i] - values[j]);
                    ends[found][i] = 1.0 - t;
                    ends[found][j] = t;
                    found += 1;
                }
            }
            if found < 2 {
                continue;
            }
            let (mut from, mut to) = (0.0, 1.0);
            for &(above, is_positive) in &path {
                let sides = corners.map(|v| self.is_positive(above, v) == is_positive);
                if sides == [true; 3] {
                    continue;
                }
                if sides == [false; 3] {
                    to = 0.0;
                    break;
                }
                let sign = if is_positive { 1.0 } else { -1.0 };
                let field = &self.nodes[above].u;
                let [a, b] =
                    ends.map(|end| sign * (0..3).map(|i| end[i] * field[corners[i]]).sum::<f64>());
                let zero = a / (a - b);
                match (a >= 0.0, b >= 0.0) {
                    (true, true) => {}
                    (true, false) => to = f64::min(to, zero),
                    (false, true) => from = f64::max(from, zero),
                    (false, false) => to = 0.0,
                }
            }
            if from < to {
                let places = frames.corners(f);
                let [a, b] = ends.map(|e| places[0] * e[0] + places[1] * e[1] + places[2] * e[2]);
                length += (to - from) * (b - a).norm();
            }
        }
        length
    }
}

/// Number of connected parts of the vertices with label 0 and with label 1.
fn components(mesh: &Mesh, labels: &[u32]) -> [usize; 2] {
    let mut counts = [0; 2];
    let mut is_seen = vec![false; labels.len()];
    let mut stack = Vec::new();
    for start in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        let label = labels[start.index()];
        if label > 1 || is_seen[start.index()] {
            continue;
        }
        counts[label as usize] += 1;
        is_seen[start.index()] = true;
        stack.push(start);
        while let Some(v) = stack.pop() {
            for h in mesh.outgoing(v) {
                let w = mesh.tip(h);
                if labels[w.index()] == label && !is_seen[w.index()] {
                    is_seen[w.index()] = true;
                    stack.push(w);
                }
            }
        }
    }
    counts
}
