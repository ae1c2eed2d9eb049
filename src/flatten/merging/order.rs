//! Which merge comes next: the best of all that passes, or the paper's order.

use super::flow::MergeFlow;
use super::mirror::same_edges;
use super::state::MergePhase;
use super::ways::{GROUND, Offer, Tried};
use crate::mesh::FaceId;

/// What a few trials led to.
pub(super) enum Advance {
    Merged,
    /// Trials are left.
    Busy,
    /// Nothing is left that passes.
    Nothing,
}

impl MergeFlow {
    /// Merges a pair and its image along the very images of what is removed and cut, or neither. Gives whether it did.
    pub(super) fn merge_images(&mut self, pair: [u32; 2], offer: Offer, is_forced: bool) -> bool {
        let Some(mirror) = &self.mirror else {
            self.merge(pair, &offer.removed, &offer.darts, offer.map, is_forced);
            return true;
        };
        let images = [&offer.removed, &offer.darts].map(|edges| mirror.edges(edges));
        let [Some(removed), Some(darts)] = images else { return false };
        let [Some(p), Some(q)] = pair.map(|i| self.image_of(i)) else { return false };
        let image = [p, q];
        if image == pair || image == [pair[1], pair[0]] {
            let is_own = same_edges(&removed, &offer.removed) && same_edges(&darts, &offer.darts);
            if is_own {
                self.merge(pair, &offer.removed, &offer.darts, offer.map, is_forced);
            }
            return is_own;
        }
        let saved = (self.members.clone(), self.between.clone(), self.ways.clone());
        let waiting = (self.queue.clone(), self.pending.clone(), self.member_of_chart.clone());
        let (first_removed, first_darts) = (offer.removed.clone(), offer.darts.clone());
        self.merge(pair, &offer.removed, &offer.darts, offer.map, is_forced);
        // Where the two share a patch, it is now part of the first one's union.
        let image = image.map(|i| if pair.contains(&i) { pair[0] } else { i });
        let image = [image[0].min(image[1]), image[0].max(image[1])];
        let limits = if is_forced { self.no_limits() } else { self.limits() };
        if (is_forced || self.may_join(image))
            && let Some(map) = self.try_exactly(image, &removed, &darts, &limits)
        {
            self.merge(image, &removed, &darts, map, is_forced);
            return true;
        }
        first_darts.iter().for_each(|&e| self.bench.set_cut(e, false));
        first_removed.iter().for_each(|&e| self.bench.set_cut(e, true));
        (self.members, self.between, self.ways) = saved;
        (self.queue, self.pending, self.member_of_chart) = waiting;
        self.state.merges -= 1;
        false
    }

    /// The patch of the images of all faces of a patch, itself without a symmetry. `None` where they make no patch: charts that were divided
    /// further than their images.
    pub(super) fn image_of(&self, patch: u32) -> Option<u32> {
        let (Some(mirror), Some(member)) = (&self.mirror, &self.members[patch as usize]) else {
            return Some(patch);
        };
        let holder =
            |f: &FaceId| self.member_of_chart[self.face_charts[mirror.face(*f).index()] as usize];
        let image = holder(&member.faces[0]);
        let is_whole = self.members[image as usize]
            .as_ref()
            .is_some_and(|other| other.faces.len() == member.faces.len())
            && member.faces.iter().all(|f| holder(f) == image);
        is_whole.then_some(image)
    }

    /// Trials until a step is full or the best merge is known; then that.
    ///
    /// Ways wait in one queue, those that were tried by their key, others by a lower bound of it. What comes first and was tried is the best there is.
    pub(super) fn best_first_step(&mut self) {
        match self.advance(self.params.trials_per_step) {
            Advance::Merged => self.picture(),
            Advance::Busy => {}
            Advance::Nothing => {
                self.state.phase = MergePhase::Improving;
                self.begin_round();
            }
        }
    }

    /// Trials until there were so many or the best merge is done.
    pub(super) fn advance(&mut self, trials: usize) -> Advance {
        while let Some(pair) = self.pending.pop_first() {
            self.list_ways(pair);
        }
        let before = self.bench.trials;
        while self.bench.trials < before + trials {
            let Some((_, pair, index)) = self.queue.pop_first() else {
                return Advance::Nothing;
            };
            let slot = self.ways.get_mut(&pair).and_then(|ways| ways[index as usize].take());
            let Some(mut way) = slot else { continue };
            if let Some(offer) = way.offer {
                if self.merge_images(pair, offer, false) {
                    return Advance::Merged;
                }
                continue;
            }
            let next = self.queue.first().map_or(f64::INFINITY, |next| f64::from_bits(next.0));
            let enough = if way.has_waited { f64::INFINITY } else { next / way.factor - GROUND };
            let key = match self.try_way(pair, &way.edges, enough, true) {
                Tried::Failed => continue,
                Tried::Later(bound) => {
                    way.has_waited = true;
                    (bound + GROUND) * way.factor
                }
                Tried::Passed(offer) => {
                    let key = (offer.map.measures.area_absolute + GROUND) * way.factor;
                    way.offer = Some(offer);
                    key
                }
            };
            way.rank = key.to_bits();
            self.queue.insert((way.rank, pair, index));
            if let Some(ways) = self.ways.get_mut(&pair) {
                ways[index as usize] = Some(way);
            }
        }
        Advance::Busy
    }

    /// The paper's: curves by the area on both sides, largest first, each once.
    pub(super) fn paper_step(&mut self) {
        let before = self.bench.trials;
        while self.bench.trials < before + self.params.trials_per_step {
            let mut next: Option<(f64, u32, [u32; 2])> = None;
            for (&pair, curves) in &self.between {
                let area: f64 = pair
                    .iter()
                    .filter_map(|&p| self.members[p as usize].as_ref())
                    .map(|m| m.area)
                    .sum();
                for &c in curves.iter().filter(|c| self.unseen.contains(c)) {
                    if next.is_none_or(|(a, i, _)| area > a || (area >= a && c < i)) {
                        next = Some((area, c, pair));
                    }
                }
            }
            let Some((_, curve, pair)) = next else {
                self.state.phase = MergePhase::Checking;
                return;
            };
            self.unseen.remove(&curve);
            if !self.may_join(pair) {
                continue;
            }
            let edges = self.curves[curve as usize].edges.clone();
            if let Tried::Passed(offer) = self.try_way(pair, &edges, f64::INFINITY, false)
                && self.merge_images(pair, offer, false)
            {
                self.picture();
                return;
            }
        }
    }
}
