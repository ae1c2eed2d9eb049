//! Developable patches at work: first pieces, tighter seams, merging, one stage after the other.

use std::cell::RefCell;
use std::rc::Rc;

use serde::Serialize;

use super::super::layout::Layout;
use super::super::message::{Event, NoticeText, Row};
use super::super::report::FlattenReport;
use super::super::surface::{Surface, face_to_vertex};
use super::super::text::{Problem, plural};
use super::super::work::Work;
use super::report::{DevelopReport, DevelopSeconds, PatchRow, not_divided, status_word};
use super::run::{Hands, Run, Stage, keeps_charts, parts, plan, wishes};
use super::{Inputs, Segmentation};
use crate::flatten::Flattening;
use crate::flatten::merging::{MergePhase, ParamsChange, PatchInfo};
use crate::geometry::Geometry;
use crate::mesh::{CutMesh, Mesh, OpenedMesh};
use crate::methods::cutflow::Initial;
use crate::methods::developable::chart_normals;
use crate::methods::flow::{Flow, SolveError, Status};

/// How patches come about, stage by stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DevelopTable {
    /// In their order.
    pub stages: Vec<DevelopStage>,
}

/// A stage in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DevelopStage {
    /// What a person calls it.
    pub label: String,
    /// Pieces after it, or so far.
    pub pieces: Option<usize>,
    /// Length of all seams then, √area = 1.
    pub seam: Option<f64>,
    /// Whether it goes on.
    pub is_active: bool,
}

/// Developable patches of a document. Nothing is computed before the method is chosen.
#[derive(Default)]
pub struct Developable {
    run: Option<Run>,
    /// Where to go on from, once there is time.
    saved: Option<DevelopCheckpoint>,
    /// The last checkpoint.
    kept: RefCell<Option<DevelopCheckpoint>>,
    /// What is asked for beside the limits, by hand.
    hands: Hands,
    /// Whether that was given up because first pieces have changed.
    has_dropped: bool,
}

/// What Undo goes back to.
#[derive(Clone)]
pub struct DevelopCheckpoint(Rc<Run>);

impl DevelopCheckpoint {
    /// Writes what tells it from others.
    pub fn describe(&self, to: &mut dyn std::fmt::Write) -> std::fmt::Result {
        write!(to, "{:?} {:?} {} {:?}", self.0.plan, self.0.hands, self.0.steps, self.0.curve)
    }
}

impl Developable {
    /// What is needed to come back; the same one as long as nothing has changed.
    pub fn checkpoint(&self) -> Option<DevelopCheckpoint> {
        let Some(run) = &self.run else { return self.saved.clone() };
        let mut kept = self.kept.borrow_mut();
        let is_same = |c: &&DevelopCheckpoint| {
            c.0.steps == run.steps && c.0.plan == run.plan && c.0.hands == run.hands
        };
        if kept.as_ref().filter(is_same).is_none() {
            *kept = Some(DevelopCheckpoint(Rc::new(run.clone())));
        }
        kept.clone()
    }

    /// Where to go on from.
    pub fn put_back(&mut self, checkpoint: Option<DevelopCheckpoint>) {
        self.hands = checkpoint.as_ref().map(|c| c.0.hands.clone()).unwrap_or_default();
        self.saved = checkpoint;
    }

    /// The pieces as the start of a cut flow: every vertex has the piece of most of the area about it.
    pub fn cut_start(&self) -> Option<Initial> {
        self.labels().map(Initial::Labels)
    }

    /// The stage that the next step belongs to.
    pub fn stage(&self) -> Option<&'static str> {
        Some(match self.run.as_ref()?.stage {
            Stage::Vsa(_) => "vsa",
            Stage::Tighten(..) => "refine",
            Stage::Smooth(_) => "denoise",
            Stage::Merge(_) => "merge",
        })
    }

    /// Joins two pieces or keeps them apart, from the first pieces on. **Takes** a face of either.
    pub fn sew(&mut self, faces: [usize; 2], joins: bool) {
        let Some(pair) = self.first_pieces(faces) else { return };
        let is_other = |other: &[u32; 2]| *other != pair && *other != [pair[1], pair[0]];
        self.hands.apart.retain(is_other);
        self.hands.together.retain(is_other);
        if joins {
            self.hands.together.push(pair);
        } else {
            self.hands.apart.push(pair);
        }
    }

    /// The first pieces of two faces, where they are merged and different ones.
    pub fn first_pieces(&self, faces: [usize; 2]) -> Option<[u32; 2]> {
        let run = self.run.as_ref().filter(|run| matches!(run.stage, Stage::Merge(_)))?;
        let pair = faces.map(|f| run.charts[f]);
        (pair[0] != pair[1]).then_some(pair)
    }

    /// Whether two faces of different pieces come from one: only what was drawn parts them.
    pub fn is_one_first_piece(&self, faces: [usize; 2]) -> bool {
        let run = self.run.as_ref().filter(|run| matches!(run.stage, Stage::Merge(_)));
        run.is_some_and(|run| {
            !run.plan.drawn.is_empty() && run.charts[faces[0]] == run.charts[faces[1]]
        })
    }

    /// The opened patches with the very maps that they were accepted with, where merging is over.
    pub fn maps(&self) -> Option<(CutMesh, OpenedMesh, Flattening)> {
        // Maps of a surface with smoothed borders are not true to the surface itself.
        let run = self.run.as_ref().filter(|run| !run.plan.smooths)?;
        let Stage::Merge(flow) = &run.stage else { return None };
        let cut = flow.cut_mesh();
        let (opened, _, flattening) = flow.flattening().ok()?;
        Some((cut, opened, flattening))
    }
}

impl Segmentation for Developable {
    fn prepare(&mut self, inputs: &Inputs) -> Result<bool, Problem> {
        let wrong = |error| Problem::solve(&inputs.surface.name, &error);
        let plan = plan(inputs);
        plan.vsa.validate().and_then(|()| plan.merge.validate()).map_err(wrong)?;
        let is_back = self.saved.is_some();
        if let Some(DevelopCheckpoint(saved)) = self.saved.take() {
            self.run = Some((*saved).clone());
        }
        let Some(run) = self.run.as_mut().filter(|run| keeps_charts(&run.plan, &plan)) else {
            // What was joined or kept apart by hand were other first pieces.
            let had_hands = self.run.is_some() && self.hands != Hands::default();
            let run = Run::new(inputs.surface, plan, Hands::default()).map_err(wrong)?;
            self.hands = Hands::default();
            self.has_dropped = had_hands;
            self.run = Some(run);
            *self.kept.borrow_mut() = None;
            return Ok(true);
        };
        let has_changed = run.plan != plan || run.hands != self.hands;
        if !has_changed {
            return Ok(is_back);
        }
        let is_merge = run.plan.merge != plan.merge;
        let is_wish = run.hands != self.hands
            || run.plan.kept != plan.kept
            || run.plan.drawn != plan.drawn
            || run.plan.symmetry != plan.symmetry;
        if let Stage::Merge(flow) = &mut run.stage {
            if is_merge {
                let has_merged = flow.steps() > 0;
                match flow.set_params(plan.merge).map_err(wrong)? {
                    ParamsChange::Nothing => {}
                    ParamsChange::Continued => run.has_gone_on |= has_merged,
                    ParamsChange::Restarted => {
                        run.curve.truncate(1);
                        run.has_gone_on = false;
                    }
                }
            }
            if is_wish {
                let wishes = wishes(&plan, &self.hands, (&run.mesh, &run.geometry), &run.charts);
                flow.set_wishes(wishes).map_err(wrong)?;
            }
        }
        run.plan = plan;
        run.hands = self.hands.clone();
        *self.kept.borrow_mut() = None;
        Ok(true)
    }

    fn begin_again(&mut self) {
        *self = Self::default();
    }

    fn step(&mut self, inputs: &Inputs) -> Result<(), Problem> {
        let Some(run) = &mut self.run else { return Ok(()) };
        run.step().map_err(|error| Problem::solve(&inputs.surface.name, &error))
    }

    fn steps(&self) -> usize {
        self.run.as_ref().map_or(0, |run| run.steps)
    }

    fn status(&self) -> Option<Status> {
        self.run.as_ref().map(Run::status)
    }

    fn doing(&self) -> String {
        let Some(run) = &self.run else { return String::new() };
        let pieces = plural(run.count(), "piece");
        match &run.stage {
            Stage::Vsa(_) => format!("{pieces}, growing"),
            Stage::Tighten(flow, _) => {
                format!("{pieces}, {} moved", plural(flow.state().moved, "seam"))
            }
            Stage::Smooth(_) => format!("{pieces}, smoothing seams"),
            Stage::Merge(flow) => match flow.state().phase {
                MergePhase::Merging => format!("{pieces}, merging"),
                MergePhase::Improving => format!("{pieces}, trying to do without some"),
                MergePhase::Zipping => format!("{pieces}, closing darts that are not needed"),
                MergePhase::Checking | MergePhase::Done => format!("{pieces}, checking all"),
            },
        }
    }

    fn labels(&self) -> Option<Vec<u32>> {
        let run = self.run.as_ref()?;
        Some(vertex_labels(&run.mesh, &run.geometry, run.face_charts()))
    }

    fn cut(&self, _: &Surface) -> Option<CutMesh> {
        let run = self.run.as_ref()?;
        Some(match &run.stage {
            Stage::Merge(flow) => flow.cut_mesh(),
            _ => {
                let mut cut = CutMesh::uncut(&run.mesh);
                let charts = run.face_charts();
                let edges = run.mesh.edges().filter(|&e| parts(&run.mesh, charts, e));
                cut.cut_edges = edges.map(|e| run.mesh.edge_vertices(e).map(|v| v.0)).collect();
                cut
            }
        })
    }

    fn curve(&self) -> &[Event] {
        self.run.as_ref().map_or(&[], |run| &run.curve)
    }

    fn rows(&self, layout: Option<&Layout>) -> Vec<Row> {
        let Some(run) = &self.run else { return Vec::new() };
        let Stage::Merge(flow) = &run.stage else { return Vec::new() };
        let state = flow.state();
        // At rest those of the charts that are there, whoever made them.
        let changes: Vec<[f64; 2]> = match layout {
            Some(layout) => {
                let charts = layout.measures.charts.iter().flatten();
                charts.map(|chart| [chart.area_change.abs(), chart.area_change_abs]).collect()
            }
            None => state.patches.iter().map(|p| [p.area_total, p.area_absolute]).collect(),
        };
        let worst = |i: usize| 100.0 * changes.iter().map(|change| change[i]).fold(0.0, f64::max);
        let first = run.after[0].map_or(f64::NAN, |(pieces, _)| pieces as f64);
        vec![
            Row::new("first_pieces", "First pieces", "", first),
            Row::new("dart_length", "Darts", "√A", state.dart_length),
            Row::new("worst_total", "Area change, worst piece", "%", worst(0)),
            Row::new("worst_area", "anywhere in it", "%", worst(1)),
        ]
    }

    fn field(&self, id: &str) -> Result<Option<Vec<f64>>, SolveError> {
        let Some(run) = self.run.as_ref().filter(|_| id == "normal_error") else {
            return Ok(None);
        };
        // |n − N|², N the mean normal of the piece.
        let means = chart_normals(&run.mesh, &run.geometry, run.face_charts());
        let normals = run.geometry.face_normals(&run.mesh);
        let errors: Vec<f64> =
            normals.iter().zip(&means).map(|(n, mean)| (n - mean).norm_squared()).collect();
        Ok(Some(face_to_vertex(&run.mesh, &run.geometry, &errors)))
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.has_dropped {
            notes.push("First pieces have changed: what was joined or kept apart by hand was given up; Undo brings it back.".to_owned());
        }
        let Some(Run { stage: Stage::Merge(flow), plan, has_gone_on, .. }) = &self.run else {
            return notes;
        };
        let state = flow.state();
        if *has_gone_on {
            notes.push("Looser limits went on from the pieces that there were: Reset and Run may lead to fewer.".to_owned());
        }
        if plan.smooths {
            notes.push("Limits were tested on the surface with smooth seams; the measures are those of the surface itself.".to_owned());
        }
        if !plan.symmetry.ids.is_empty() && plan.merge.improvements > 0 {
            notes.push("With a symmetry pieces are not improved one by one: there may be more of them than without.".to_owned());
        }
        if state.splits > 0 {
            let times =
                if state.splits == 1 { "once".into() } else { format!("{} times", state.splits) };
            notes.push(format!(
                "First pieces were divided {times} more before merging, so that each lies flat."
            ));
        }
        if state.released > 0 {
            notes.push("A drawn seam ends inside a piece that does not lie flat with it open: it was left out there. Draw on to the next seam.".to_owned());
        }
        let bent = state.patches.iter().filter(|patch| !patch.is_flat).count();
        if bent > 0 {
            notes.push(format!(
                "{} cannot be laid flat without folds: look at the mesh there.",
                plural(bent, "piece")
            ));
        }
        let forced = state.patches.iter().filter(|patch| patch.is_forced).count();
        if forced > 0 {
            notes.push(format!(
                "{} joined by hand, whatever the limits say.",
                if forced == 1 { "1 piece is".to_owned() } else { format!("{forced} pieces are") }
            ));
        }
        if !state.refused.is_empty() {
            notes.push(format!(
                "{} could not be joined: there is no map without folds or overlaps.",
                plural(state.refused.len(), "pair")
            ));
        }
        notes
    }

    fn told(&self) -> Option<Event> {
        let run = self.run.as_ref()?;
        let now = Some((run.count(), run.seam()));
        let number = run.number();
        let is_running = run.status() == Status::Running;
        let labels = [
            ("First pieces", true),
            ("Tighter seams", run.plan.tightens),
            ("Smooth seams", run.plan.smooths),
            ("Merged", true),
        ];
        let stage = |(i, (label, _)): (usize, &(&str, bool))| {
            let numbers = if i == number { now } else { run.after[i] };
            DevelopStage {
                label: (*label).into(),
                pieces: numbers.map(|(pieces, _)| pieces),
                seam: numbers.map(|(_, seam)| seam),
                is_active: is_running && i == number,
            }
        };
        let shown = labels.iter().enumerate().filter(|(_, (_, is_asked))| *is_asked);
        Some(Event::Patches(DevelopTable { stages: shown.map(stage).collect() }))
    }
}

/// For each vertex the chart of most of the area about it.
fn vertex_labels(mesh: &Mesh, geometry: &Geometry, charts: &[u32]) -> Vec<u32> {
    let label = |v| {
        let mut votes: Vec<(u32, f64)> = Vec::new();
        for f in mesh.outgoing(v).filter_map(|h| mesh.face(h)) {
            let (chart, area) = (charts[f.index()], geometry.face_areas[f.index()]);
            match votes.iter_mut().find(|(other, _)| *other == chart) {
                Some((_, sum)) => *sum += area,
                None => votes.push((chart, area)),
            }
        }
        let most = votes.into_iter().max_by(|(a, x), (b, y)| x.total_cmp(y).then(b.cmp(a)));
        most.map_or(0, |(chart, _)| chart)
    };
    mesh.vertices().map(label).collect()
}

impl Work {
    /// The report of `cutflow develop`.
    pub(in super::super) fn develop_report(
        &self,
        seconds: Option<DevelopSeconds>,
    ) -> Result<DevelopReport, Problem> {
        let (Some(run), Some(layout)) = (&self.develop.run, &self.layout) else {
            return Err(not_divided(self));
        };
        let (patches, darts): (Vec<PatchRow>, f64) = match &run.stage {
            Stage::Merge(flow) => {
                let state = flow.state();
                let row = |patch: &PatchInfo| PatchRow {
                    faces: patch.faces,
                    area: patch.area,
                    area_change: patch.area_total,
                    area_change_abs: patch.area_absolute,
                    l2_stretch: patch.l2_stretch,
                    overlap: !patch.is_flat,
                    loops: patch.loops,
                };
                let charts = layout.measures.charts.iter().flatten();
                let on_surface = charts.map(|m| PatchRow {
                    faces: m.faces,
                    area: m.area,
                    area_change: m.area_change.abs(),
                    area_change_abs: m.area_change_abs,
                    l2_stretch: m.l2_stretch,
                    overlap: m.flipped > 0 || m.overlaps > 0,
                    loops: 1,
                });
                let rows = match run.plan.smooths {
                    true => on_surface.collect(),
                    false => state.patches.iter().map(row).collect(),
                };
                (rows, state.dart_length)
            }
            _ => (Vec::new(), 0.0),
        };
        let notes = self.develop.notes().into_iter();
        let notes = notes.map(|text| NoticeText::new("developable", 1, text));
        Ok(DevelopReport {
            vertices: self.document.summary.vertices,
            faces: self.document.summary.faces,
            vsa_charts: run.after[0].map_or(run.count(), |(pieces, _)| pieces),
            patches,
            seam_length: run.seam(),
            dart_length: darts,
            steps: run.steps,
            status: status_word(Some(run.status())),
            symmetry: self.layers.patch_symmetry.ids.clone(),
            flattening: FlattenReport::new(layout, None),
            notices: self.notices(layout).into_iter().chain(notes).collect(),
            seconds,
        })
    }
}
