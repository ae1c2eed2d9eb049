//! Improvements: one patch of few charts after another is dissolved into its charts, which other patches take up if they can.

use super::flow::MergeFlow;
use super::order::Advance;
use super::state::MergePhase;
use crate::flatten::small;
use crate::mesh::EdgeId;

/// Trials for one patch, so that a step stays bounded.
const TRIALS: usize = 400;

/// Charts of a patch that is worth dissolving at most: on seven surfaces, under both measures, 22 of 99 such patches and none of 49 larger ones found
/// places for all their charts.
const MOST_CHARTS: usize = 12;

impl MergeFlow {
    /// All patches of few charts are to be dissolved, small ones first.
    pub(super) fn begin_round(&mut self) {
        self.to_dissolve.clear();
        let is_symmetric = self.mirror.is_some();
        if self.rounds >= self.params.improvements || is_symmetric {
            self.state.phase = MergePhase::Zipping;
            return;
        }
        self.rounds += 1;
        let mut order: Vec<(f64, u32)> = self
            .members
            .iter()
            .enumerate()
            .filter_map(|(i, m)| {
                let member = m.as_ref()?;
                let is_candidate = !member.is_forced && member.charts.len() <= MOST_CHARTS;
                is_candidate.then_some((member.area, small(i)))
            })
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
        self.to_dissolve = order.into_iter().map(|(_, i)| i).collect();
    }

    /// Dissolves one patch, and goes back if that led to nothing better.
    pub(super) fn improve_step(&mut self) {
        let Some(index) = self.to_dissolve.pop() else {
            self.begin_round();
            return;
        };
        if self.members[index as usize].is_none() {
            return;
        }
        let before = self.score();
        let saved = (self.members.clone(), self.between.clone(), self.member_of_chart.clone());
        let cut = self.bench.is_cut().to_vec();
        let merges = self.state.merges;
        self.dissolve(index);
        let mut left = TRIALS;
        // First to others only; then what is left over among itself.
        for _ in 0..2 {
            while left > 0 {
                let trials = self.bench.trials;
                match self.advance(left) {
                    Advance::Nothing => break,
                    Advance::Merged | Advance::Busy => {}
                }
                left = left.saturating_sub((self.bench.trials - trials).max(1));
            }
            if self.loose.is_empty() {
                break;
            }
            let loose = std::mem::take(&mut self.loose);
            let holders: Vec<u32> =
                loose.iter().map(|&c| self.member_of_chart[c as usize]).collect();
            let again: Vec<[u32; 2]> = self
                .between
                .keys()
                .filter(|pair| pair.iter().all(|i| holders.contains(i)))
                .copied()
                .collect();
            self.pending.extend(again);
        }
        self.loose.clear();
        let after = self.score();
        if after.0 < before.0 || (after.0 == before.0 && after.1 < before.1 * (1.0 - 1e-9)) {
            self.picture();
        } else {
            (self.members, self.between, self.member_of_chart) = saved;
            for (e, cut) in cut.into_iter().enumerate() {
                self.bench.set_cut(EdgeId::from(e), cut);
            }
            self.state.merges = merges;
        }
        // Before, nothing passed; what was merged since has been tried against all that it touches, unless trials ran out.
        self.ways.clear();
        self.queue.clear();
        self.pending.clear();
    }

    /// Number of patches, and length of the cut.
    fn score(&self) -> (usize, f64) {
        let geometry = &self.bench.geometry;
        let lengths = self.bench.is_cut().iter().zip(&geometry.edge_lengths);
        let seam = lengths.filter(|(cut, _)| **cut).map(|(_, length)| length).sum();
        (self.members.iter().flatten().count(), seam)
    }

    /// Makes a patch its charts again. They may be merged with others only.
    fn dissolve(&mut self, index: u32) {
        let Some(member) = self.members[index as usize].take() else { return };
        let mesh = self.bench.mesh.clone();
        // Darts and borders alike: all sides of its faces that lie within it are as in the beginning.
        let mut is_inside = vec![false; mesh.face_count()];
        member.faces.iter().for_each(|f| is_inside[f.index()] = true);
        for &f in &member.faces {
            for h in mesh.face_halfedges(f) {
                let Some(g) = mesh.face(h.twin()).filter(|g| is_inside[g.index()]) else {
                    continue;
                };
                let e = h.edge();
                let parts = self.face_charts[f.index()] != self.face_charts[g.index()];
                let is_kept = self.bench.is_kept[e.index()];
                self.bench.set_cut(e, parts || is_kept);
            }
        }
        for &chart in &member.charts {
            // A patch has the number of its first chart; the numbers of the others are free.
            self.members[chart as usize] = Some(self.charts[chart as usize].clone());
            self.member_of_chart[chart as usize] = chart;
        }
        self.loose = member.charts.iter().copied().collect();
        let mut between = std::mem::take(&mut self.between);
        between.retain(|pair, _| !pair.contains(&index));
        for (i, curve) in self.curves.iter().enumerate() {
            let is_of_it = curve.charts.iter().any(|c| self.loose.contains(c));
            let [a, b] = curve.charts.map(|c| self.member_of_chart[c as usize]);
            if is_of_it && a != b {
                let pair = [a.min(b), a.max(b)];
                between.entry(pair).or_default().push(small(i));
                self.pending.insert(pair);
            }
        }
        self.between = between;
    }
}
