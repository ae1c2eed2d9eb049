//! Coarse to fine: the first steps of a run are made on a surface with a fraction of the triangles.
//!
//! Far from its minimum a cut has a long way to go, and a step moves it by one edge: on a coarse surface edges are longer and steps
//! cost less. The coarse flow runs beside the fine one; after every few of its steps its level sets are carried over, and the fine
//! state becomes theirs if J is lower there and the regions are the same. So the fine state descends as always.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::Point3;

use super::band::LevelSets;
use super::init::{Start, pieces};
use super::{Checkpoint, CutFields, CutFlow, Source};
use crate::geometry::{Geometry, Nearest};
use crate::mesh::{FaceId, Mesh, VertexId};
use crate::methods::flow::{Flow, SolveError, Status};
use crate::methods::prepare::{Attributes, DecimateFlow, DecimateParams, Surface};

/// Surfaces with fewer vertices are solved as they are: their steps are short already.
const SMALLEST: usize = 4000;

/// Triangles of the fine surface for one of the coarse one. More makes the coarse surface miss what the cut goes by.
const FRACTION: usize = 5;

/// Coarse steps between two looks at the fine surface: together they cost about as much as one step there.
const STRIDE: usize = 4;

/// Looks in a row that did not lower J, after which the coarse surface has nothing more to say.
const PATIENCE: usize = 2;

/// How much lower J must be for a carried cut to be taken: less is found faster by the fine flow itself.
const GAIN: f64 = 2e-3;

/// Where a vertex lies on the other surface.
type Place = ([VertexId; 3], [f64; 3]);

/// A flow on the coarse surface.
pub(super) struct Coarse {
    flow: Box<CutFlow>,
    /// Every fine vertex on the coarse surface.
    places: Vec<Place>,
    failures: usize,
}

/// What a checkpoint keeps of it.
#[derive(Clone, Debug)]
pub(super) struct SavedCoarse {
    checkpoint: Box<Checkpoint>,
    failures: usize,
}

impl Coarse {
    pub fn save(&self) -> SavedCoarse {
        SavedCoarse { checkpoint: Box::new(self.flow.checkpoint()), failures: self.failures }
    }

    /// Gives back what can be made anew.
    pub fn rest(&mut self) {
        self.flow.rest();
    }
}

impl CutFlow {
    /// Whether the first steps are to be made on a coarser surface.
    pub(super) fn wants_coarse(&self) -> bool {
        self.params.coarse_to_fine
            && self.params.schedule.is_none()
            && self.symmetric.is_empty()
            && !self.problem.pins.iter().any(|pin| *pin > 0.0)
            && self.problem.mesh.vertex_count() >= SMALLEST
    }

    /// The flow on the coarse surface, from the cut as it is; `None` where the surface cannot be made so coarse.
    ///
    /// **Takes** whether its state is to be replaced anyway: then any will do.
    pub(super) fn make_coarse(&self, is_filled: bool) -> Result<Option<Coarse>, SolveError> {
        let fine = &self.problem;
        let target_faces = fine.mesh.face_count() / FRACTION;
        let surface = Surface {
            mesh: (*fine.mesh).clone(),
            positions: fine.geometry.positions.clone(),
            attributes: Attributes::default(),
        };
        let params = DecimateParams { target_faces, ..DecimateParams::default() };
        let mut decimation = DecimateFlow::new(surface, &params)?;
        while decimation.step()?.status == Status::Running {}
        let Surface { mesh, positions, .. } = decimation.state().surface.clone();
        if mesh.face_count() > 2 * target_faces {
            return Ok(None);
        }
        let Ok(geometry) = Geometry::new(&mesh, positions) else { return Ok(None) };
        let (Some(places), Some(back)) = (
            places(&mesh, &geometry, &fine.mesh, &fine.geometry),
            places(&fine.mesh, &fine.geometry, &mesh, &geometry),
        ) else {
            return Ok(None);
        };
        let mut start = carried(&self.state.levels, &back);
        mend(&mesh, &mut start.labels, regions(self));
        let average = |values: &[f64]| -> Vec<f64> {
            let at = |(v, w): &Place| (0..3).map(|i| values[v[i].index()] * w[i]).sum();
            if values.is_empty() { Vec::new() } else { back.iter().map(at).collect() }
        };
        let source = match &self.fields.source {
            Source::Heat(density) => Source::Heat(average(density)),
            other => other.clone(),
        };
        let fields = CutFields {
            source,
            penalty: average(&self.fields.penalty),
            pins: average(&self.fields.pins),
            ..CutFields::default()
        };
        let mut params = self.params;
        params.coarse_to_fine = false;
        params.saddle_tests = 0;
        // The fine flow finishes; the last tenths of a percent are its own.
        params.tolerance = params.tolerance.max(1e-3);
        let has_its_side =
            |flow: &Self| !params.weights.one_sided || flow.state.labels().contains(&0);
        match Self::from_start(mesh.into(), geometry.into(), start, params, &fields) {
            // With many regions, one that the coarse surface cannot hold may vanish, as in any step.
            Ok(flow)
                if has_its_side(&flow)
                    && (is_filled
                        || is_allowed(regions(&flow), regions(self), self.has_many_regions())) =>
            {
                Ok(Some(Coarse { flow: Box::new(flow), places, failures: 0 }))
            }
            // Too coarse for this cut.
            Ok(_) | Err(SolveError::EmptyCut { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The coarse flow as a checkpoint left it.
    pub(super) fn revive_coarse(
        &mut self,
        saved: &SavedCoarse,
    ) -> Result<Option<Coarse>, SolveError> {
        let coarse = match self.coarse.take() {
            Some(coarse) => Some(coarse),
            None => self.make_coarse(true)?,
        };
        let Some(mut coarse) = coarse else { return Ok(None) };
        coarse.flow.restore(&saved.checkpoint)?;
        coarse.failures = saved.failures;
        Ok(Some(coarse))
    }

    /// A few coarse steps and a look at what they are worth here; says whether J fell. The coarse flow is gone when it has
    /// nothing more to say.
    pub(super) fn step_coarse(&mut self) -> bool {
        let Some(mut coarse) = self.coarse.take() else { return false };
        while coarse.failures < PATIENCE {
            let mut is_over = false;
            for _ in 0..STRIDE {
                let report = coarse.flow.step();
                is_over = !report.is_ok_and(|report| report.status == Status::Running);
                if is_over {
                    break;
                }
            }
            let before = self.state.solution.energy.total;
            let mut start = carried(&coarse.flow.state.levels, &coarse.places);
            mend(&self.problem.mesh, &mut start.labels, regions(&coarse.flow));
            let Some(state) = self.state_from(&start) else { return false };
            let is_better = state.solution.energy.total < before - GAIN * before.abs()
                && is_allowed(
                    regions_of(&self.problem.mesh, &state.levels.labels),
                    regions(self).min(regions(&coarse.flow)),
                    self.has_many_regions(),
                );
            if is_better {
                let old = std::mem::replace(&mut self.state, state);
                self.spare = Some(old.solution);
                coarse.failures = 0;
                if !is_over {
                    self.coarse = Some(coarse);
                }
                return true;
            }
            self.spare = Some(state.solution);
            coarse.failures += 1;
            if is_over {
                break;
            }
        }
        false
    }
}

/// Every vertex of a surface on another one that lies close to it, on faces that look the same way.
fn places(
    mesh: &Mesh,
    geometry: &Geometry,
    of: &Mesh,
    of_geometry: &Geometry,
) -> Option<Vec<Place>> {
    let tree = Nearest::new(mesh, &geometry.positions);
    let face_normals = geometry.face_normals(mesh);
    let normals = of_geometry.vertex_normals(of);
    let mut hint = None;
    of.vertices()
        .map(|v| {
            if of.halfedge(v).is_none() {
                // Takes no part.
                return Some(([VertexId(0); 3], [1.0, 0.0, 0.0]));
            }
            let point: Point3<f64> = of_geometry.positions[v.index()];
            let faces_it = |f: FaceId| face_normals[f.index()].dot(&normals[v.index()]) > 0.0;
            let hit = tree.find_among(point, hint, faces_it).or_else(|| tree.find(point))?;
            hint = Some(hit.face);
            Some((mesh.face_vertices(hit.face), hit.weights))
        })
        .collect()
}

/// Level sets at places of another surface.
fn carried(levels: &LevelSets, places: &[Place]) -> Start {
    let mut labels = Vec::with_capacity(places.len());
    let mut starts = vec![0u32];
    let mut entries: Vec<(u32, f64)> = Vec::new();
    for (corners, weights) in places {
        let mut near = corners.map(|v| levels.labels[v.index()]);
        near.sort_unstable();
        if near[0] == near[2] {
            labels.push(near[0]);
        } else {
            let value = |label: u32| -> f64 {
                let at = |v: VertexId| levels.signed_value(v, label);
                (0..3).map(|i| weights[i] * at(corners[i])).sum()
            };
            let first = entries.len();
            for (i, &label) in near.iter().enumerate() {
                if i == 0 || near[i - 1] != label {
                    entries.push((label, value(label)));
                }
            }
            let own = entries[first..].iter().min_by(|a, b| a.1.total_cmp(&b.1));
            labels.push(own.map_or(near[0], |e| e.0));
        }
        starts.push(entries.len() as u32);
    }
    Start::of_entries(labels, starts, entries)
}

/// Whether a number of regions may follow another.
fn is_allowed(now: usize, before: usize, many: bool) -> bool {
    now == before || (many && now < before)
}

/// Number of connected regions of equal label.
fn regions(flow: &CutFlow) -> usize {
    regions_of(&flow.problem.mesh, &flow.state.levels.labels)
}

fn regions_of(mesh: &Mesh, labels: &[u32]) -> usize {
    components(mesh, labels).1.len()
}

/// The connected region of every vertex, and the number of vertices of each.
fn components(mesh: &Mesh, labels: &[u32]) -> (Vec<u32>, Vec<usize>) {
    let (regions, count) = pieces(mesh, labels);
    let mut sizes = vec![0; count];
    for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        sizes[regions[v.index()] as usize] += 1;
    }
    (regions, sizes)
}

/// Gives the smallest regions to their neighbours until there are no more than `most`: crumbs of regions that are narrow for the
/// triangles, which carrying broke off.
fn mend(mesh: &Mesh, labels: &mut [u32], most: usize) {
    loop {
        let (regions, sizes) = components(mesh, labels);
        let smallest = (0..sizes.len()).min_by_key(|&r| (sizes[r], r));
        let Some(crumb) = smallest.filter(|_| sizes.len() > most) else { return };
        let members: Vec<VertexId> =
            mesh.vertices().filter(|v| regions[v.index()] == crumb as u32).collect();
        let mut votes = std::collections::BTreeMap::<u32, usize>::new();
        for &v in &members {
            for w in mesh.outgoing(v).map(|h| mesh.tip(h)) {
                if regions[w.index()] != crumb as u32 {
                    *votes.entry(labels[w.index()]).or_default() += 1;
                }
            }
        }
        // A whole component of the surface has no neighbours.
        let Some((&label, _)) =
            votes.iter().max_by_key(|(label, n)| (**n, std::cmp::Reverse(**label)))
        else {
            return;
        };
        members.iter().for_each(|v| labels[v.index()] = label);
    }
}
