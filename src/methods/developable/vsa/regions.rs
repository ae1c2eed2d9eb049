//! Charts about planes: flooding, fitting, splitting, joining.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use nalgebra::Vector3;

use super::params::{VsaChart, VsaState};
use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh};

/// No chart, no neighbour.
pub(super) const NONE: u32 = u32::MAX;

/// What floods need to know of a surface, side by side.
#[derive(Clone)]
pub(super) struct Faces {
    pub normals: Vec<Vector3<f64>>,
    pub areas: Vec<f64>,
    pub neighbours: Vec<[u32; 3]>,
    pub total_area: f64,
    /// Error, face and chart in one number, so that one comparison orders them.
    heap: BinaryHeap<Reverse<u128>>,
}

/// Smaller errors first, then smaller faces, then smaller charts.
fn key(error: f64, f: u32, r: u32) -> Reverse<u128> {
    Reverse(u128::from(error.to_bits()) << 64 | u128::from(f) << 32 | u128::from(r))
}

/// Face and chart of a key.
#[expect(clippy::cast_possible_truncation, reason = "each has 32 bits of its own")]
fn names(bits: u128) -> (u32, u32) {
    ((bits >> 32) as u32, bits as u32)
}

impl Faces {
    pub fn new(mesh: &Mesh, geometry: &Geometry) -> Self {
        let neighbour = |h: crate::mesh::HalfedgeId| mesh.face(h.twin()).map_or(NONE, |f| f.0);
        Self {
            normals: geometry.face_normals(mesh),
            areas: geometry.face_areas.clone(),
            neighbours: mesh.faces().map(|f| mesh.face_halfedges(f).map(neighbour)).collect(),
            total_area: geometry.total_area(),
            heap: BinaryHeap::new(),
        }
    }

    /// a |n − N|²: never negative, so that its bits are ordered like it.
    fn error(&self, f: u32, proxy: &Vector3<f64>) -> f64 {
        self.areas[f as usize] * (self.normals[f as usize] - proxy).norm_squared()
    }

    /// A chart without faces yet.
    pub fn chart(&self, seed: FaceId) -> VsaChart {
        let proxy = self.normals[seed.index()];
        VsaChart { proxy, area: 0.0, error: 0.0, seed, faces: Vec::new() }
    }

    /// Gives the faces that have no chart to the charts in `set`, which begin with the faces they have: best fit first, ties by face, then chart.
    pub fn spread(&mut self, state: &mut VsaState, set: &[u32]) {
        let mut heap = std::mem::take(&mut self.heap);
        for &r in set {
            let chart = &state.charts[r as usize];
            for f in &chart.faces {
                for g in self.neighbours[f.index()] {
                    if g != NONE && state.face_charts[g as usize] == NONE {
                        heap.push(key(self.error(g, &chart.proxy), g, r));
                    }
                }
            }
        }
        while let Some(Reverse(bits)) = heap.pop() {
            let (f, r) = names(bits);
            if state.face_charts[f as usize] != NONE {
                continue;
            }
            state.face_charts[f as usize] = r;
            let chart = &mut state.charts[r as usize];
            chart.faces.push(FaceId(f));
            for g in self.neighbours[f as usize] {
                if g != NONE && state.face_charts[g as usize] == NONE {
                    heap.push(key(self.error(g, &chart.proxy), g, r));
                }
            }
        }
        self.heap = heap;
    }

    /// One iteration of Lloyd's on some charts, from their seeds; the others stay as they are.
    pub fn flood(&mut self, state: &mut VsaState, set: &[u32]) {
        for &r in set {
            for f in std::mem::take(&mut state.charts[r as usize].faces) {
                state.face_charts[f.index()] = NONE;
            }
        }
        for &r in set {
            let seed = state.charts[r as usize].seed;
            state.face_charts[seed.index()] = r;
            state.charts[r as usize].faces.push(seed);
        }
        self.spread(state, set);
        for &r in set {
            self.fit(&mut state.charts[r as usize]);
        }
    }

    /// The best plane of a chart, its error, and the face that fits best.
    pub fn fit(&self, chart: &mut VsaChart) {
        let sum = self.sum(chart);
        chart.area = chart.faces.iter().fold(0.0, |area, f| area + self.areas[f.index()]);
        // Faces in all directions have no plane: the one before is as good as any.
        if sum.norm() > 1e-12 * chart.area {
            chart.proxy = sum.normalize();
        }
        chart.error = 0.0;
        let mut best = (f64::INFINITY, NONE);
        for f in &chart.faces {
            let deviation = (self.normals[f.index()] - chart.proxy).norm_squared();
            chart.error += self.areas[f.index()] * deviation;
            if deviation < best.0 || (deviation <= best.0 && f.0 < best.1) {
                best = (deviation, f.0);
            }
        }
        chart.seed = FaceId(best.1);
    }

    /// Σ a n.
    pub fn sum(&self, chart: &VsaChart) -> Vector3<f64> {
        chart
            .faces
            .iter()
            .fold(Vector3::zeros(), |sum, f| sum + self.normals[f.index()] * self.areas[f.index()])
    }

    /// The face with the largest error that is not the seed.
    pub fn worst_face(&self, chart: &VsaChart) -> Option<FaceId> {
        let mut worst = (0.0, NONE);
        for f in chart.faces.iter().filter(|&&f| f != chart.seed) {
            let error = self.error(f.0, &chart.proxy);
            if error > worst.0 || (error >= worst.0 && f.0 < worst.1 && error > 0.0) {
                worst = (error, f.0);
            }
        }
        (worst.1 != NONE).then_some(FaceId(worst.1))
    }

    /// The charts beside a chart, in increasing order, and itself.
    pub fn around(&self, state: &VsaState, r: u32) -> Vec<u32> {
        let near = state.charts[r as usize].faces.iter().flat_map(|f| self.neighbours[f.index()]);
        let mut set: Vec<u32> =
            near.filter(|&g| g != NONE).map(|g| state.face_charts[g as usize]).collect();
        set.push(r);
        set.sort_unstable();
        set.dedup();
        set
    }

    /// The adjacent pair whose union has the least error more than both: Σ a |n − N|² = 2 (A − |Σ a n|) for unit normals, so that is 2 (|S| + |T| − |S + T|).
    ///
    /// **Takes** what a union may be, asked with its increase and its error.
    pub fn cheapest_pair(
        &self,
        state: &VsaState,
        may: impl Fn(f64, f64) -> bool,
    ) -> Option<[u32; 2]> {
        let sums: Vec<Vector3<f64>> = state.charts.iter().map(|c| self.sum(c)).collect();
        let mut pairs = BTreeSet::new();
        for (f, near) in self.neighbours.iter().enumerate() {
            let a = state.face_charts[f];
            for g in near.iter().filter(|&&g| g != NONE) {
                let b = state.face_charts[*g as usize];
                if a < b {
                    pairs.insert([a, b]);
                }
            }
        }
        let mut best: Option<(f64, [u32; 2])> = None;
        for pair in pairs {
            let [s, t] = pair.map(|r| sums[r as usize]);
            let [a, b] = pair.map(|r| &state.charts[r as usize]);
            let increase = (2.0 * (s.norm() + t.norm() - (s + t).norm())).max(0.0);
            if may(increase, a.error + b.error + increase)
                && best.is_none_or(|(least, _)| increase < least)
            {
                best = Some((increase, pair));
            }
        }
        best.map(|(_, pair)| pair)
    }

    /// Gives all faces of the second chart to the first, and leaves the second empty.
    pub fn join(&self, state: &mut VsaState, [a, b]: [u32; 2]) {
        let faces = std::mem::take(&mut state.charts[b as usize].faces);
        for f in &faces {
            state.face_charts[f.index()] = a;
        }
        let chart = &mut state.charts[a as usize];
        chart.faces.extend(faces);
        self.fit(chart);
    }

    /// Lets a new chart, `slot`, begin at the worst face of `r`, and floods about it. The error never rises: where the flood about all
    /// neighbours does not lower it, `r` alone is split, and two planes always fit better than one.
    ///
    /// **Gives** false, and changes nothing, where `r` is flat.
    pub fn insert(&mut self, state: &mut VsaState, r: u32, slot: u32, lloyd: usize) -> bool {
        let Some(seed) = self.worst_face(&state.charts[r as usize]) else { return false };
        let mut set = self.around(state, r);
        let before: Vec<VsaChart> = set.iter().map(|&c| state.charts[c as usize].clone()).collect();
        let error = |state: &VsaState, set: &[u32]| {
            set.iter().fold(0.0, |sum, &c| sum + state.charts[c as usize].error)
        };
        let old_error = error(state, &set);
        let begin = |state: &mut VsaState| {
            let chart = self.chart(seed);
            if slot as usize == state.charts.len() {
                state.charts.push(chart);
            } else {
                state.charts[slot as usize] = chart;
            }
        };
        begin(state);
        let old_set = set.clone();
        if let Err(at) = set.binary_search(&slot) {
            set.insert(at, slot);
        }
        for _ in 0..lloyd {
            self.flood(state, &set);
        }
        if !(error(state, &set) < old_error) {
            for (&c, chart) in old_set.iter().zip(before) {
                for f in &chart.faces {
                    state.face_charts[f.index()] = c;
                }
                state.charts[c as usize] = chart;
            }
            state.charts[slot as usize] = self.chart(seed);
            let mut both = [r, slot];
            both.sort_unstable();
            self.flood(state, &both);
        }
        true
    }
}
