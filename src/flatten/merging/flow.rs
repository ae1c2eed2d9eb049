//! The flow: patches and their cut from the first charts to the last merge.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::mirror::Mirror;
use super::network::{Curve, connected_charts, curves};
use super::params::{MergeParams, MergeStrategy, MergeWishes};
use super::split::bisect;
use super::state::{MergePhase, MergeState, PatchInfo};
use super::trial::{Bench, Limits, Map, Reject};
use super::ways::{Offer, Way};
use crate::flatten::small;
use crate::geometry::Geometry;
use crate::mesh::{EdgeId, FaceId, HalfedgeId, Mesh};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// What new parameters did to a flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamsChange {
    /// Nothing is different.
    Nothing,
    /// Limits are looser: what there is stays, and what was rejected is tried again.
    Continued,
    /// Patches may fail now: it starts from the charts again.
    Restarted,
}

/// A patch at work.
#[derive(Clone)]
pub(super) struct Member {
    pub faces: Vec<FaceId>,
    pub charts: Vec<u32>,
    pub labels: BTreeSet<u32>,
    /// None for charts that fail and cannot be split.
    pub map: Option<Map>,
    pub is_forced: bool,
    pub area: f64,
    /// Of its charts and of what its cut differs in from their borders.
    pub hash: u128,
}

/// Merges charts into patches that flatten, one bounded step at a time.
///
/// **Minimises** the number of patches, greedily, under limits on the distortion of each. **Step** some trials, or one accepted merge; then one patch zipped; then the check.
/// The number of patches never rises; the length of seams may, where darts are cut. **Ends** `Converged` when nothing that is left passes and the
/// patches have been flattened anew.
#[derive(Clone)]
pub struct MergeFlow {
    pub(super) params: MergeParams,
    pub(super) wishes: MergeWishes,
    labels: Vec<u32>,
    pub(super) bench: Bench,
    pub(super) total_area: f64,
    pub(super) face_charts: Vec<u32>,
    chart_labels: Vec<u32>,
    pub(super) curves: Vec<Curve>,
    pub(super) members: Vec<Option<Member>>,
    /// Curves between patches that are still there.
    pub(super) between: BTreeMap<[u32; 2], Vec<u32>>,
    /// Ways to merge each pair.
    pub(super) ways: BTreeMap<[u32; 2], Vec<Option<Way>>>,
    /// All ways by rank.
    pub(super) queue: BTreeSet<(u64, [u32; 2], u32)>,
    /// Pairs whose ways have yet to be listed.
    pub(super) pending: BTreeSet<[u32; 2]>,
    /// Curves that the paper's strategy has yet to look at.
    pub(super) unseen: BTreeSet<u32>,
    /// What is known to fail, by what it is made of.
    pub(super) rejected: BTreeMap<u128, Reject>,
    pub(super) mirror: Option<Mirror>,
    pub(super) member_of_chart: Vec<u32>,
    /// Charts as they were to begin with.
    pub(super) charts: Vec<Member>,
    /// Patches that may yet be dissolved in this round of improvements, last first, and rounds begun.
    pub(super) to_dissolve: Vec<u32>,
    pub(super) rounds: usize,
    /// Charts that may not be merged with each other for now.
    pub(super) loose: BTreeSet<u32>,
    pub(super) next_zip: usize,
    pub(super) state: MergeState,
    pub(super) step: usize,
    pub(super) status: Status,
}

impl MergeFlow {
    /// Prepares charts: splits those that fail, and merges those that are wanted together.
    ///
    /// **Takes** a surface, any scale, and a label for each face; faces of one label that hang together are a chart. **Fails** on parameters out of range, on
    /// edges that are not there, on a symmetry that the charts do not have, and for lack of memory.
    /// **Costs** a trial for each chart, and two for each split.
    pub fn new(
        mesh: Arc<Mesh>,
        geometry: Arc<Geometry>,
        labels: &[u32],
        params: MergeParams,
        wishes: MergeWishes,
    ) -> Result<Self, SolveError> {
        Self::on(Bench::new(mesh, geometry)?, labels, params, wishes)
    }

    fn on(
        bench: Bench,
        labels: &[u32],
        params: MergeParams,
        wishes: MergeWishes,
    ) -> Result<Self, SolveError> {
        params.validate()?;
        assert_eq!(labels.len(), bench.mesh.face_count());
        let total_area = bench.geometry.total_area();
        if !(total_area > 0.0 && total_area.is_finite()) {
            return Err(SolveError::NotFinite);
        }
        let mut flow = Self {
            params,
            wishes,
            labels: labels.to_vec(),
            bench,
            total_area,
            face_charts: Vec::new(),
            chart_labels: Vec::new(),
            curves: Vec::new(),
            members: Vec::new(),
            between: BTreeMap::new(),
            ways: BTreeMap::new(),
            queue: BTreeSet::new(),
            pending: BTreeSet::new(),
            unseen: BTreeSet::new(),
            rejected: BTreeMap::new(),
            mirror: None,
            member_of_chart: Vec::new(),
            charts: Vec::new(),
            to_dissolve: Vec::new(),
            rounds: 0,
            loose: BTreeSet::new(),
            next_zip: 0,
            state: MergeState::default(),
            step: 0,
            status: Status::Running,
        };
        if let Some(vertices) = &flow.wishes.symmetry {
            flow.mirror = Some(Mirror::new(&flow.bench.mesh, vertices)?);
        }
        flow.start()?;
        Ok(flow)
    }

    /// From the labels to patches of one chart each.
    fn start(&mut self) -> Result<(), SolveError> {
        // Charts may be split another way than before: their numbers then name other faces.
        self.rejected.clear();
        let mesh = self.bench.mesh.clone();
        let geometry = self.bench.geometry.clone();
        // Kept edges that one image of a symmetry has to do without: neither has them then.
        let mut given_up = BTreeSet::new();
        let maps = loop {
            self.keep(&given_up)?;
            let maps = self.first_charts();
            self.state.released += given_up.len();
            let Some(mirror) = &self.mirror else { break maps };
            let is_kept = &self.bench.is_kept;
            let uneven = |e: &EdgeId| {
                mirror.edge(*e).is_some_and(|image| is_kept[e.index()] != is_kept[image.index()])
            };
            let before = given_up.len();
            given_up.extend(mesh.edges().filter(uneven));
            if given_up.len() == before {
                break maps;
            }
        };
        self.member_of_chart = (0..small(maps.len())).collect();
        self.curves = curves(&mesh, &geometry, &self.face_charts);
        for curve in &self.curves {
            curve.edges.iter().for_each(|&e| self.bench.set_cut(e, true));
        }
        self.members = maps
            .into_iter()
            .enumerate()
            .map(|(chart, (faces, map))| {
                let area = faces.iter().map(|f| geometry.face_areas[f.index()]).sum();
                Some(Member {
                    faces,
                    charts: vec![small(chart)],
                    labels: BTreeSet::from([self.chart_labels[chart]]),
                    map,
                    is_forced: false,
                    area,
                    hash: hash(0, small(chart)),
                })
            })
            .collect();
        self.charts = self.members.iter().flatten().cloned().collect();
        self.rounds = 0;
        self.loose.clear();
        self.between.clear();
        self.ways.clear();
        self.queue.clear();
        for (i, curve) in self.curves.iter().enumerate() {
            self.between.entry(curve.charts).or_default().push(small(i));
        }
        for pair in self.wishes.together.clone() {
            self.force(pair);
        }
        self.pending = self.between.keys().copied().collect();
        self.unseen = (0..small(self.curves.len())).collect();
        self.next_zip = 0;
        self.status = Status::Running;
        self.picture();
        Ok(())
    }

    /// Cuts what the wishes keep, and nothing else. With a symmetry both images are kept; a diagonal that has none is gone around.
    fn keep(&mut self, given_up: &BTreeSet<EdgeId>) -> Result<(), SolveError> {
        let mesh = self.bench.mesh.clone();
        for e in mesh.edges() {
            self.bench.set_cut(e, false);
        }
        self.bench.is_kept.fill(false);
        let mut kept = Vec::new();
        for &e in &self.wishes.kept_edges {
            if e.index() >= mesh.edge_count() {
                let (value, max) = (f64::from(e.0), mesh.edge_count() as f64);
                return Err(SolveError::Parameter { name: "kept edge", value, min: 0.0, max });
            }
            let Some(mirror) = &self.mirror else {
                kept.push(e);
                continue;
            };
            let h = e.halfedge();
            let around = [mesh.next(h).edge(), mesh.prev(h).edge()];
            let all = if mirror.edge(e).is_some() { &[e][..] } else { &around };
            kept.extend(all.iter().flat_map(|&e| [Some(e), mirror.edge(e)]).flatten());
        }
        for e in kept {
            if !mesh.is_boundary_edge(e) && !given_up.contains(&e) {
                self.bench.is_kept[e.index()] = true;
                self.bench.set_cut(e, true);
            }
        }
        Ok(())
    }

    /// Charts that pass, by labels and kept edges. **Gives** faces and map of each.
    fn first_charts(&mut self) -> Vec<(Vec<FaceId>, Option<Map>)> {
        (self.face_charts, self.chart_labels) = match &self.mirror {
            Some(mirror) => self.parted(&mirror.whole_labels(&self.labels)),
            None => self.parted(&self.labels),
        };
        self.state = MergeState::default();
        let mut maps = self.split_charts();
        // Charts that are no images of each other are divided until they are; pieces of charts that pass may fail and be split once more.
        for _ in 0..2 {
            let Some(mirror) = &self.mirror else { break };
            let (fine, firsts) = mirror.common_labels(&self.face_charts);
            let old = std::mem::take(&mut self.chart_labels);
            let (charts, of) = self.parted(&fine);
            self.face_charts = charts;
            self.chart_labels =
                of.into_iter().map(|fine| old[firsts[fine as usize] as usize]).collect();
            maps = self.split_charts();
        }
        maps
    }

    /// Charts of some labels, parted along what stays cut as well.
    fn parted(&self, labels: &[u32]) -> (Vec<u32>, Vec<u32>) {
        connected_charts(&self.bench.mesh, labels, |e| self.bench.is_kept[e.index()])
    }

    /// Splits charts until they pass. **Gives** faces and map of each chart.
    fn split_charts(&mut self) -> Vec<(Vec<FaceId>, Option<Map>)> {
        let (mesh, geometry) = (self.bench.mesh.clone(), self.bench.geometry.clone());
        let normals = geometry.face_normals(&mesh);
        let limits =
            Limits { area: self.params.split_limit.min(self.params.area_limit), ..self.limits() };
        let mut groups: Vec<Vec<FaceId>> = vec![Vec::new(); self.chart_labels.len()];
        for f in mesh.faces() {
            groups[self.face_charts[f.index()] as usize].push(f);
        }
        let mut maps: Vec<Option<Map>> = Vec::new();
        // What is split off joins the queue at its end.
        while maps.len() < groups.len() {
            let chart = maps.len();
            loop {
                if let Ok(map) = self.bench.flatten(&groups[chart], &limits) {
                    maps.push(Some(map));
                    break;
                }
                if let Some(map) = self.release(chart, &groups[chart], &limits) {
                    maps.push(Some(map));
                    break;
                }
                let is_kept = |e: EdgeId| self.bench.is_kept[e.index()];
                let halves = bisect(&mesh, &normals, &geometry.face_areas, &groups[chart], is_kept);
                let Some([kept, split]) = halves else {
                    maps.push(None);
                    break;
                };
                self.state.splits += 1;
                for f in &split {
                    self.face_charts[f.index()] = small(groups.len());
                }
                self.chart_labels.push(self.chart_labels[chart]);
                groups.push(split);
                groups[chart] = kept;
            }
        }
        groups.into_iter().zip(maps).collect()
    }

    /// Gives up cuts that were to stay and end inside a chart, where it lies flat without them.
    fn release(&mut self, chart: usize, faces: &[FaceId], limits: &Limits) -> Option<Map> {
        let mesh = self.bench.mesh.clone();
        let is_inside = |h: HalfedgeId| {
            let across = mesh.face(h.twin()).map(|g| self.face_charts[g.index()] as usize);
            self.bench.is_kept[h.edge().index()] && across == Some(chart)
        };
        let mut slits: Vec<EdgeId> = faces
            .iter()
            .flat_map(|&f| mesh.face_halfedges(f))
            .filter(|&h| is_inside(h))
            .map(|h| h.edge())
            .collect();
        slits.sort_unstable();
        slits.dedup();
        if slits.is_empty() {
            return None;
        }
        slits.iter().for_each(|&e| self.bench.set_cut(e, false));
        let found = self.bench.flatten(faces, limits).ok();
        for &e in &slits {
            self.bench.is_kept[e.index()] = found.is_none();
            self.bench.set_cut(e, found.is_none());
        }
        self.state.released += if found.is_some() { slits.len() } else { 0 };
        found
    }

    /// Merges all patches with these two labels, limits or not.
    fn force(&mut self, [a, b]: [u32; 2]) {
        let mut is_done = false;
        loop {
            let wanted = self.between.keys().copied().find(|[p, q]| {
                let has = |i: u32, label: u32| {
                    self.members[i as usize].as_ref().is_some_and(|m| m.labels.contains(&label))
                };
                (has(*p, a) && has(*q, b)) || (has(*p, b) && has(*q, a))
            });
            let Some(pair) = wanted else { break };
            let curves = self.between[&pair].clone();
            let edges: Vec<EdgeId> =
                curves.iter().flat_map(|&c| self.curves[c as usize].edges.clone()).collect();
            let mut removed = self.bench.remove(&edges);
            self.bench.zip(&mut removed);
            let faces = self.joined_faces(pair);
            let found = self.bench.flatten(&faces, &self.no_limits());
            removed.iter().for_each(|&e| self.bench.set_cut(e, true));
            let Ok(map) = found else { break };
            if !self.merge_images(pair, Offer { removed, darts: Vec::new(), map }, true) {
                break;
            }
            is_done = true;
        }
        let one =
            self.members.iter().flatten().any(|m| m.labels.contains(&a) && m.labels.contains(&b));
        if !(is_done || one) {
            self.state.refused.push([a, b]);
        }
    }

    pub(super) fn joined_faces(&self, pair: [u32; 2]) -> Vec<FaceId> {
        let parts = pair.map(|p| self.members[p as usize].as_ref());
        let mut faces: Vec<FaceId> =
            parts.iter().flatten().flat_map(|m| m.faces.iter().copied()).collect();
        // In increasing order, as the check and the pipeline have them: ties between virtual cuts are then decided alike.
        // Two runs in order: a stable sort merges them.
        faces.sort();
        faces
    }

    /// Options in force.
    pub fn params(&self) -> &MergeParams {
        &self.params
    }

    /// How it stands.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Accepted steps so far.
    pub fn steps(&self) -> usize {
        self.step
    }

    /// The surface.
    pub fn mesh(&self) -> &Mesh {
        &self.bench.mesh
    }

    /// Goes on with other options. Looser limits keep what there is; anything else starts from the charts again. After `Err` everything is as it was.
    pub fn set_params(&mut self, params: MergeParams) -> Result<ParamsChange, SolveError> {
        params.validate()?;
        if params == self.params {
            return Ok(ParamsChange::Nothing);
        }
        if params.measure != self.params.measure || params.rigid_steps != self.params.rigid_steps {
            self.rejected.clear();
        }
        let is_looser = params.loosens(&self.params);
        self.params = params;
        if is_looser {
            self.ways.clear();
            self.queue.clear();
            self.pending = self.between.keys().copied().collect();
            self.unseen = self.between.values().flatten().copied().collect();
            self.next_zip = 0;
            self.rounds = 0;
            self.state.phase = MergePhase::Merging;
            self.status = Status::Running;
            return Ok(ParamsChange::Continued);
        }
        self.start()?;
        Ok(ParamsChange::Restarted)
    }

    /// Starts from the charts again with other wishes. After `Err` everything is as it was.
    pub fn set_wishes(&mut self, wishes: MergeWishes) -> Result<(), SolveError> {
        let mut bench = self.bench.clone();
        bench.trials = 0;
        let mut other = Self::on(bench, &self.labels, self.params, wishes)?;
        other.step = self.step;
        *self = other;
        Ok(())
    }

    /// What is asked of a patch.
    pub(super) fn limits(&self) -> Limits {
        let limits = Limits::of(&self.params);
        match self.params.strategy {
            MergeStrategy::Paper => Limits { rigid_steps: 0, ..limits },
            MergeStrategy::BestFirst => limits,
        }
    }

    /// Makes one patch of two. The cut is brought up to date.
    pub(super) fn merge(
        &mut self,
        pair: [u32; 2],
        removed: &[EdgeId],
        darts: &[EdgeId],
        map: Map,
        is_forced: bool,
    ) {
        removed.iter().for_each(|&e| self.bench.set_cut(e, false));
        darts.iter().for_each(|&e| self.bench.set_cut(e, true));
        let [p, q] = pair.map(|i| i as usize);
        let (Some(mut one), Some(other)) = (self.members[p].take(), self.members[q].take()) else {
            return;
        };
        for &chart in &other.charts {
            self.member_of_chart[chart as usize] = pair[0];
        }
        one.faces.extend(other.faces);
        one.faces.sort();
        one.charts.extend(other.charts);
        one.labels.extend(other.labels);
        one.is_forced |= other.is_forced || is_forced;
        one.area += other.area;
        one.hash ^= other.hash;
        one.hash = removed.iter().chain(darts).fold(one.hash, |key, e| key ^ hash(1, e.0));
        one.map = Some(map);
        self.members[p] = Some(one);
        self.between.remove(&pair);
        let touched: Vec<[u32; 2]> =
            self.between.keys().filter(|k| k.iter().any(|i| pair.contains(i))).copied().collect();
        for old in touched {
            self.drop_ways(old);
            self.pending.remove(&old);
            let Some(curves) = self.between.remove(&old) else { continue };
            let far = if pair.contains(&old[0]) { old[1] } else { old[0] };
            let new = [far.min(pair[0]), far.max(pair[0])];
            let all = self.between.entry(new).or_default();
            all.extend(curves);
            all.sort_unstable();
            self.pending.insert(new);
        }
        self.drop_ways(pair);
        self.pending.remove(&pair);
        self.state.merges += 1;
    }

    /// Makes the public state from what is known.
    pub(super) fn picture(&mut self) {
        let mesh = self.bench.mesh.clone();
        let geometry = self.bench.geometry.clone();
        let mut member_of = vec![0u32; mesh.face_count()];
        for (i, member) in self.members.iter().enumerate() {
            for f in member.iter().flat_map(|m| &m.faces) {
                member_of[f.index()] = small(i);
            }
        }
        let mut numbers = vec![u32::MAX; self.members.len()];
        let mut patches: Vec<PatchInfo> = Vec::new();
        self.state.face_patches.clear();
        for &member in &member_of {
            let number = &mut numbers[member as usize];
            if *number == u32::MAX {
                *number = small(patches.len());
                patches.extend(self.members[member as usize].as_ref().map(|m| self.info(m)));
            }
            self.state.face_patches.push(*number);
        }
        self.state.cut_edges.clear();
        (self.state.seam_length, self.state.dart_length) = (0.0, 0.0);
        for e in mesh.edges().filter(|e| self.bench.is_cut()[e.index()]) {
            self.state.cut_edges.push(e);
            let length = geometry.edge_length(e);
            self.state.seam_length += length;
            let [f, g] = [e.halfedge(), e.halfedge().twin()].map(|h| mesh.face(h));
            if let (Some(f), Some(g)) = (f, g)
                && self.state.face_patches[f.index()] == self.state.face_patches[g.index()]
            {
                self.state.dart_length += length;
                patches[self.state.face_patches[f.index()] as usize].dart_length += length;
            }
        }
        self.state.patches = patches;
        self.state.face_charts.clone_from(&self.face_charts);
    }

    fn info(&self, member: &Member) -> PatchInfo {
        let mut info = PatchInfo {
            faces: member.faces.len(),
            area: member.area / self.total_area,
            charts: member.charts.len(),
            is_forced: member.is_forced,
            is_flat: member.map.is_some(),
            ..PatchInfo::default()
        };
        if let Some(map) = &member.map {
            info.area_total = map.measures.area_total;
            info.area_absolute = map.measures.area_absolute;
            info.l2_stretch = map.measures.l2_stretch;
            info.l2_stretch_normalized = map.measures.l2_stretch_normalized;
            info.angle_error = map.angle_error;
            info.closure_error = map.closure_error;
            info.loops = map.loops;
        }
        info
    }

    pub(super) fn limits_of(&self, member: &Member) -> Limits {
        if member.is_forced { self.no_limits() } else { self.limits() }
    }

    /// What is asked of a patch that was joined by hand: a map, without flips and crossings.
    pub(super) fn no_limits(&self) -> Limits {
        Limits { rigid_steps: self.limits().rigid_steps, ..Limits::none(&self.params) }
    }

    fn report(&self) -> StepReport {
        StepReport {
            step: self.step,
            energy: vec![
                ("patches", self.state.patches.len() as f64),
                ("seam length", self.state.seam_length),
                ("dart length", self.state.dart_length),
                ("ways to try", (self.queue.len() + self.pending.len()) as f64),
            ],
            residual: 0.0,
            progress: None,
            status: self.status,
        }
    }
}

impl Flow for MergeFlow {
    type State = MergeState;

    fn state(&self) -> &MergeState {
        &self.state
    }

    /// Some trials or one merge; one patch zipped; or the check.
    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status != Status::Running {
            return Ok(self.report());
        }
        match self.state.phase {
            MergePhase::Merging => match self.params.strategy {
                MergeStrategy::BestFirst => self.best_first_step(),
                MergeStrategy::Paper => self.paper_step(),
            },
            MergePhase::Improving => self.improve_step(),
            MergePhase::Zipping => self.zip_step(),
            MergePhase::Checking => {
                self.check()?;
                self.state.phase = MergePhase::Done;
                self.status = Status::Converged;
            }
            MergePhase::Done => {}
        }
        self.state.trials = self.bench.trials;
        self.step += 1;
        Ok(self.report())
    }
}

/// A number for each chart and each edge, by the mixing steps of SplitMix64 (Steele, Lea, Flood 2014), twice.
pub(super) fn hash(kind: u32, number: u32) -> u128 {
    let mix = |seed: u64| {
        let mut z = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let name = u64::from(kind) << 32 | u64::from(number);
    u128::from(mix(2 * name + 1)) << 64 | u128::from(mix(2 * name + 2))
}
