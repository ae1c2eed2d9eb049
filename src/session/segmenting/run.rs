//! A run of developable patches: first pieces, tighter seams, smoother ones, merging, one flow after the other.

use std::rc::Rc;
use std::sync::Arc;

use super::super::message::Event;
use super::super::params::whole;
use super::super::surface::Surface;
use super::super::symmetric::KeptByPatches;
use super::Inputs;
use crate::flatten::merging::{
    AreaMeasure, ChartGate, MergeFlow, MergeParams, MergeStrategy, MergeWishes,
};
use crate::geometry::{Geometry, centre_lines};
use crate::mesh::{EdgeId, Mesh, VertexId};
use crate::methods::developable::{
    DenoiseFlow, DenoiseParams, RefineFlow, RefineParams, VsaFlow, VsaParams,
};
use crate::methods::flow::{Flow, SolveError, Status};

/// How far beyond the tolerance moved borders may take a first piece. Without bound borders become much smoother and pieces do not flatten any more.
const SLACK: f64 = 1.2;

/// Paint from which a place counts as painted.
const PAINTED: f64 = 0.5;

/// Mean edges from which a drawn seam goes on to a border: a bridge that narrow would tear.
const REACH: f64 = 3.0;

/// What a person asks for, by the numbers of first pieces.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Hands {
    pub apart: Vec<[u32; 2]>,
    pub together: Vec<[u32; 2]>,
}

/// What a run is made for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    pub vsa: VsaParams,
    pub tightens: bool,
    pub smooths: bool,
    pub merge: MergeParams,
    /// What an edge costs beyond its length; empty for nothing.
    pub factors: Rc<Vec<f64>>,
    pub kept: Rc<Vec<EdgeId>>,
    /// Paint along which seams are made.
    pub drawn: Rc<Vec<f64>>,
    /// What merging keeps.
    pub symmetry: Rc<KeptByPatches>,
}

/// A run and where it is.
#[derive(Clone)]
pub(super) struct Run {
    pub plan: Plan,
    pub hands: Hands,
    pub mesh: Arc<Mesh>,
    pub geometry: Arc<Geometry>,
    /// What merging measures: the surface with smooth borders, or the surface.
    merged_on: Arc<Geometry>,
    pub stage: Stage,
    /// Pieces and seam after the stages that are over.
    pub after: [Option<(usize, f64)>; 4],
    /// Charts that merging began with.
    pub charts: Rc<Vec<u32>>,
    /// Whether looser limits went on from what tighter ones had merged.
    pub has_gone_on: bool,
    pub steps: usize,
    pub curve: Vec<Event>,
}

/// What a run is at.
#[derive(Clone)]
pub(super) enum Stage {
    Vsa(VsaFlow),
    Tighten(RefineFlow, Box<ChartGate>),
    Smooth(DenoiseFlow),
    Merge(Box<MergeFlow>),
}

impl Run {
    pub fn new(surface: &Surface, plan: Plan, hands: Hands) -> Result<Self, SolveError> {
        let (mesh, geometry) = (surface.mesh.clone(), surface.geometry.clone());
        let flow = VsaFlow::new(mesh.clone(), geometry.clone(), plan.vsa)?;
        let mut run = Self {
            plan,
            hands,
            merged_on: geometry.clone(),
            mesh,
            geometry,
            stage: Stage::Vsa(flow),
            after: [None; 4],
            charts: Rc::default(),
            has_gone_on: false,
            steps: 0,
            curve: Vec::new(),
        };
        run.tell();
        Ok(run)
    }

    /// Adds the length of all seams to the curve.
    fn tell(&mut self) {
        let (step, total) = (self.steps, self.seam());
        self.curve.push(Event::Energy { step, total, terms: Vec::new() });
    }

    pub fn status(&self) -> Status {
        match &self.stage {
            Stage::Merge(flow) => flow.status(),
            // Another stage follows.
            _ => Status::Running,
        }
    }

    pub fn face_charts(&self) -> &[u32] {
        match &self.stage {
            Stage::Vsa(flow) => &flow.state().face_charts,
            Stage::Tighten(flow, _) => &flow.state().face_charts,
            Stage::Smooth(_) => &self.charts,
            Stage::Merge(flow) => &flow.state().face_patches,
        }
    }

    pub fn count(&self) -> usize {
        match &self.stage {
            Stage::Vsa(flow) => flow.state().charts.len(),
            Stage::Tighten(flow, _) => flow.state().charts,
            Stage::Smooth(_) => count_of(&self.charts),
            Stage::Merge(flow) => flow.state().patches.len(),
        }
    }

    pub fn seam(&self) -> f64 {
        match &self.stage {
            Stage::Vsa(flow) => border(&self.mesh, &self.geometry, &flow.state().face_charts),
            Stage::Tighten(flow, _) => flow.state().length,
            Stage::Smooth(_) => border(&self.mesh, &self.geometry, &self.charts),
            Stage::Merge(flow) => flow.state().seam_length,
        }
    }

    /// The place of the stage among all.
    pub fn number(&self) -> usize {
        match self.stage {
            Stage::Vsa(_) => 0,
            Stage::Tighten(..) => 1,
            Stage::Smooth(_) => 2,
            Stage::Merge(_) => 3,
        }
    }

    pub fn step(&mut self) -> Result<(), SolveError> {
        let status = match &mut self.stage {
            Stage::Vsa(flow) => flow.step()?.status,
            Stage::Tighten(flow, gate) => {
                flow.step_if(&mut |charts, pair| gate.accepts(charts, pair))?.status
            }
            Stage::Smooth(flow) => flow.step()?.status,
            Stage::Merge(flow) => {
                flow.step()?;
                Status::Running
            }
        };
        self.steps += 1;
        self.tell();
        if status == Status::Running { Ok(()) } else { self.next_stage() }
    }

    /// Goes on to what follows, where a stage is over.
    fn next_stage(&mut self) -> Result<(), SolveError> {
        let number = self.number();
        self.after[number] = Some((self.count(), self.seam()));
        if let Stage::Smooth(flow) = &self.stage {
            let places = flow.state().positions.clone();
            self.merged_on = Arc::new(Geometry::measure(&self.mesh, places));
        } else {
            self.charts = Rc::new(self.face_charts().to_vec());
        }
        let (mesh, geometry) = (self.mesh.clone(), self.geometry.clone());
        self.stage = if number < 1 && self.plan.tightens {
            // Pieces may lose a little of their flatness for better borders.
            let tolerance = SLACK * self.plan.vsa.tolerance;
            // Where places are to be avoided, the way around them is longer.
            let may_lengthen = !self.plan.factors.is_empty();
            let params = RefineParams { tolerance, may_lengthen, ..RefineParams::default() };
            let prices = &self.plan.factors;
            let flow = RefineFlow::new(mesh.clone(), &geometry, &self.charts, params, prices)?;
            let charts = &flow.state().face_charts;
            let gate = ChartGate::new(mesh, geometry, charts, &self.plan.merge)?;
            Stage::Tighten(flow, Box::new(gate))
        } else if number < 2 && self.plan.smooths {
            let params = DenoiseParams::default();
            Stage::Smooth(DenoiseFlow::new(mesh, &geometry, &self.charts, params)?)
        } else {
            let on = self.merged_on.clone();
            let wishes =
                wishes(&self.plan, &self.hands, (&self.mesh, &self.geometry), &self.charts);
            let flow = MergeFlow::new(mesh, on, &self.charts, self.plan.merge, wishes)?;
            Stage::Merge(Box::new(flow))
        };
        Ok(())
    }
}

/// Whether first pieces are the same.
pub(super) fn keeps_charts(old: &Plan, new: &Plan) -> bool {
    let only_charts = |plan: &Plan| Plan {
        merge: MergeParams::default(),
        kept: Rc::default(),
        drawn: Rc::default(),
        symmetry: Rc::default(),
        ..plan.clone()
    };
    only_charts(old) == only_charts(new)
}

/// What merging of some charts is asked for beside the limits.
pub(super) fn wishes(
    plan: &Plan,
    hands: &Hands,
    (mesh, geometry): (&Mesh, &Geometry),
    charts: &[u32],
) -> MergeWishes {
    let kept = plan.kept.iter().copied().filter(|&e| parts(mesh, charts, e));
    let drawn = drawn_seams(&plan.drawn, (mesh, geometry), charts);
    MergeWishes {
        apart: hands.apart.clone(),
        together: hands.together.clone(),
        kept_edges: kept.chain(drawn).collect(),
        prices: plan.factors.to_vec(),
        symmetry: (!plan.symmetry.ids.is_empty()).then(|| plan.symmetry.vertices.clone()),
    }
}

/// The edges along which seams are drawn: the middle of what is painted, on to a border that is as good as reached.
fn drawn_seams(paint: &[f64], (mesh, geometry): (&Mesh, &Geometry), charts: &[u32]) -> Vec<EdgeId> {
    if paint.is_empty() {
        return Vec::new();
    }
    let is_painted: Vec<bool> = paint.iter().map(|&amount| amount >= PAINTED).collect();
    let is_border = |v: VertexId| {
        mesh.is_boundary_vertex(v) || mesh.outgoing(v).any(|h| parts(mesh, charts, h.edge()))
    };
    centre_lines(mesh, geometry, &is_painted, is_border, REACH * geometry.mean_edge_length())
}

/// What parameters and paint ask for.
pub(super) fn plan(inputs: &Inputs) -> Plan {
    let Inputs { surface, settings, layers } = *inputs;
    let mesh = &surface.mesh;
    let price = settings.number("seam_price");
    let paint = |layer: &[f64], e: EdgeId| {
        let [a, b] = mesh.edge_vertices(e).map(|v| layer.get(v.index()).copied().unwrap_or(0.0));
        a.min(b)
    };
    let factors = if layers.penalty.is_empty() {
        Vec::new()
    } else {
        mesh.edges().map(|e| 1.0 + price * paint(&layers.penalty, e)).collect()
    };
    let is_kept = |e: &EdgeId| paint(&layers.seams, *e) >= PAINTED;
    let kept =
        if layers.seams.is_empty() { Vec::new() } else { mesh.edges().filter(is_kept).collect() };
    Plan {
        vsa: VsaParams { tolerance: settings.number("vsa_tolerance"), ..VsaParams::default() },
        tightens: settings.is_on("min_cut"),
        smooths: settings.is_on("denoise"),
        merge: MergeParams {
            strategy: match settings.text("merge_strategy") {
                "paper" => MergeStrategy::Paper,
                _ => MergeStrategy::BestFirst,
            },
            measure: match settings.text("merge_measure") {
                "total" => AreaMeasure::Total,
                _ => AreaMeasure::Absolute,
            },
            area_limit: settings.number("area_limit") / 100.0,
            l2_limit: settings.number("stretch_limit"),
            darts: whole(settings.number("darts")),
            improvements: whole(settings.number("improvements")),
            max_patch_area: settings.number("patch_limit") / 100.0,
            ..MergeParams::default()
        },
        factors: Rc::new(factors),
        kept: Rc::new(kept),
        drawn: layers.drawn.clone(),
        symmetry: layers.patch_symmetry.clone(),
    }
}

/// Whether an edge lies between two charts.
pub(super) fn parts(mesh: &Mesh, charts: &[u32], e: EdgeId) -> bool {
    let h = e.halfedge();
    match (mesh.face(h), mesh.face(h.twin())) {
        (Some(f), Some(g)) => charts[f.index()] != charts[g.index()],
        _ => false,
    }
}

/// Length of all edges between charts.
fn border(mesh: &Mesh, geometry: &Geometry, charts: &[u32]) -> f64 {
    let edges = mesh.edges().filter(|&e| parts(mesh, charts, e));
    edges.map(|e| geometry.edge_length(e)).sum()
}

fn count_of(charts: &[u32]) -> usize {
    charts.iter().max().map_or(0, |&most| most as usize + 1)
}
