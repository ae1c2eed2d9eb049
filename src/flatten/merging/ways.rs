//! Ways to merge two patches, and trials of them.

use super::flow::{Member, MergeFlow, hash};
use super::trial::{Failure, Limits, Map, Reject};
use crate::flatten::small;
use crate::mesh::{EdgeId, FaceId};

/// What is added to A_abs when merges are compared: isometric ones differ by the seam that they remove.
pub(super) const GROUND: f64 = 0.01;

/// Power of the smaller patch's area in the order of merges: small patches are used up first, while they still fit anywhere.
const SMALL_FIRST: f64 = 0.25;

/// A merge that passes.
#[derive(Clone)]
pub(super) struct Offer {
    pub removed: Vec<EdgeId>,
    pub darts: Vec<EdgeId>,
    pub map: Map,
}

/// A way to merge a pair: the seam that goes, and what is known of it.
#[derive(Clone)]
pub(super) struct Way {
    pub edges: Vec<EdgeId>,
    /// What A_abs + .01 is multiplied with to make its key.
    pub factor: f64,
    /// Its key if there is an offer, else a lower bound of it: the bits of a positive number, which are ordered like it.
    pub rank: u64,
    /// Whether it has waited once already.
    pub has_waited: bool,
    pub offer: Option<Offer>,
}

/// What became of a trial.
pub(super) enum Tried {
    Passed(Offer),
    /// The boundary alone says that the key is at least this: others come first.
    Later(f64),
    Failed,
}

impl MergeFlow {
    /// Whether two patches may meet at all.
    pub(super) fn may_join(&self, pair: [u32; 2]) -> bool {
        let [Some(p), Some(q)] = pair.map(|i| self.members[i as usize].as_ref()) else {
            return false;
        };
        let is_apart = self.wishes.apart.iter().any(|[a, b]| {
            (p.labels.contains(a) && q.labels.contains(b))
                || (p.labels.contains(b) && q.labels.contains(a))
        });
        let is_loose = |m: &Member| m.charts.len() == 1 && self.loose.contains(&m.charts[0]);
        let is_barred = is_apart || (is_loose(p) && is_loose(q));
        !is_barred
            && p.area + q.area <= self.params.max_patch_area * self.total_area * (1.0 + 1e-12)
    }

    /// Lists the ways to merge a pair: all its curves at once, and each alone.
    pub(super) fn list_ways(&mut self, pair: [u32; 2]) {
        if !self.may_join(pair) {
            return;
        }
        let Some(curves) = self.between.get(&pair) else { return };
        let edges_of = |c: &u32| self.curves[*c as usize].edges.clone();
        let mut ways: Vec<Vec<EdgeId>> = curves.iter().map(edges_of).collect();
        if curves.len() > 1 {
            ways.push(curves.iter().flat_map(edges_of).collect());
        }
        let [p, q] = pair.map(|i| self.members[i as usize].as_ref().map_or(0.0, |m| m.area));
        let smaller = (p.min(q) / self.total_area).powf(SMALL_FIRST);
        let mut listed = Vec::new();
        for edges in ways {
            let mut removed = self.bench.remove(&edges);
            self.bench.zip(&mut removed);
            removed.iter().for_each(|&e| self.bench.set_cut(e, true));
            let length: f64 = removed.iter().map(|&e| self.priced_length(e)).sum();
            listed.push((length > 0.0).then(|| {
                let factor = smaller / length;
                Way {
                    edges,
                    factor,
                    rank: (GROUND * factor).to_bits(),
                    has_waited: false,
                    offer: None,
                }
            }));
        }
        for (i, way) in listed.iter().enumerate() {
            self.queue.extend(way.as_ref().map(|way| (way.rank, pair, small(i))));
        }
        self.ways.insert(pair, listed);
    }

    /// What an edge of a seam costs: its length, times its price where there is one.
    fn priced_length(&self, e: EdgeId) -> f64 {
        let price = self.wishes.prices.get(e.index()).copied().unwrap_or(1.0);
        price * self.bench.geometry.edge_length(e)
    }

    /// Forgets the ways to merge a pair.
    pub(super) fn drop_ways(&mut self, pair: [u32; 2]) {
        for (i, way) in self.ways.remove(&pair).into_iter().flatten().enumerate() {
            if let Some(way) = way {
                self.queue.remove(&(way.rank, pair, small(i)));
            }
        }
    }

    /// One trial, and more with darts where they may help. The cut is as before afterwards.
    ///
    /// **Takes** the A_tot from which on others come first.
    pub(super) fn try_way(
        &mut self,
        pair: [u32; 2],
        edges: &[EdgeId],
        enough: f64,
        zips: bool,
    ) -> Tried {
        let mut removed = self.bench.remove(edges);
        if removed.is_empty() {
            return Tried::Failed;
        }
        if zips {
            self.bench.zip(&mut removed);
        }
        let tried = self.try_cut(pair, &removed, enough, zips);
        removed.iter().for_each(|&e| self.bench.set_cut(e, true));
        match tried {
            Ok((map, darts)) => Tried::Passed(Offer { removed, darts, map }),
            Err(Reject::Later(bound)) => Tried::Later(bound),
            Err(_) => Tried::Failed,
        }
    }

    /// One trial of the very edges that go and that are cut. The cut is as before afterwards.
    pub(super) fn try_exactly(
        &mut self,
        pair: [u32; 2],
        removed: &[EdgeId],
        darts: &[EdgeId],
        limits: &Limits,
    ) -> Option<Map> {
        if removed.iter().any(|e| self.bench.is_kept[e.index()]) {
            return None;
        }
        let gone = self.bench.remove(removed);
        let is_whole = |e: &&EdgeId| !self.bench.is_cut()[e.index()];
        let cut: Vec<EdgeId> = darts.iter().filter(is_whole).copied().collect();
        cut.iter().for_each(|&e| self.bench.set_cut(e, true));
        let found = self.bench.flatten(&self.joined_faces(pair), limits);
        cut.iter().for_each(|&e| self.bench.set_cut(e, false));
        gone.iter().for_each(|&e| self.bench.set_cut(e, true));
        found.ok()
    }

    /// A map of a pair along the present cut, and the darts that it needs.
    fn try_cut(
        &mut self,
        pair: [u32; 2],
        removed: &[EdgeId],
        enough: f64,
        allows_darts: bool,
    ) -> Result<(Map, Vec<EdgeId>), Reject> {
        let faces = self.joined_faces(pair);
        let mut key = removed.iter().fold(0, |key, e| key ^ hash(1, e.0));
        for member in pair.iter().filter_map(|&p| self.members[p as usize].as_ref()) {
            key ^= member.hash;
        }
        let count = if allows_darts { self.params.darts } else { 0 };
        let wanted = Limits { enough, ..self.limits() };
        let failure =
            match self.flatten_once(key, &faces, &Limits { wants_darts: count > 0, ..wanted }) {
                Ok(map) => return Ok((map, Vec::new())),
                Err(failure) => failure,
            };
        // What darts lead to is not postponed: the boundary without them says nothing about it.
        let wanted = Limits { enough: f64::INFINITY, ..wanted };
        let first_darts = failure.darts;
        for kind in 0..first_darts.len() {
            if first_darts[..kind].contains(&first_darts[kind]) {
                continue;
            }
            let (mut darts, mut key, mut next) = (Vec::new(), key, first_darts[kind].clone());
            let mut found = None;
            for left in (0..count).rev() {
                let Some(dart) = next else { break };
                for e in dart {
                    self.bench.set_cut(e, true);
                    darts.push(e);
                    key ^= hash(1, e.0);
                }
                let limits = Limits { wants_darts: left > 0, ..wanted };
                match self.flatten_once(key, &faces, &limits) {
                    Ok(map) => {
                        found = Some(map);
                        break;
                    }
                    Err(Failure { mut darts, .. }) => next = darts[kind].take(),
                }
            }
            darts.iter().for_each(|&e| self.bench.set_cut(e, false));
            if let Some(map) = found {
                return Ok((map, darts));
            }
        }
        Err(failure.reject)
    }

    /// One trial, unless it is known to fail.
    fn flatten_once(
        &mut self,
        key: u128,
        faces: &[FaceId],
        limits: &Limits,
    ) -> Result<Map, Failure> {
        if let Some(reject) = self.rejected.get(&key).filter(|reject| limits.still_reject(reject)) {
            return Err((*reject).into());
        }
        let found = self.bench.flatten(faces, limits);
        if let Err(Failure { reject, .. }) = &found
            && !matches!(reject, Reject::Later(_))
        {
            self.rejected.insert(key, *reject);
        }
        found
    }
}
