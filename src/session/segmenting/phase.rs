//! A phase field at work: the flow on the open surface, and what is told of it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;
use std::rc::Rc;
use std::sync::Arc;

use super::super::blending::layers;
use super::super::layout::Layout;
use super::super::message::{Event, NoticeText, Row, Term};
use super::super::method::Method;
use super::super::report::FlattenReport;
use super::super::scene::LayerScene;
use super::super::surface::Surface;
use super::super::text::{Problem, plural};
use super::super::work::Work;
use super::report::{not_divided, status_word};
use super::tree::{Segment, SegmentTree, colour};
use super::{Inputs, PhaseFieldReport, Segmentation};
use crate::flatten::{Atlas, AtlasParams};
use crate::mesh::CutMesh;
use crate::methods::cutflow::Initial;
use crate::methods::flow::{Flow, SolveError, Status};
use crate::methods::phasefield::{
    PhaseFieldCheckpoint, PhaseFieldFlow, PhaseFieldParams, PhaseMeasures, PhaseNode, Screening,
    Start, epsilon_floor, length_scale,
};

/// Largest |u| below which a field divides nothing: it should be near 1 on either side.
const FAINT: f64 = 0.5;

/// What the undivided surface is called.
const WHOLE: &str = "Whole";

/// The widest interface.
const WIDEST: f64 = 0.5;

/// A phase field of a document. Nothing is computed before the method is chosen.
#[derive(Default)]
pub struct PhaseField {
    flow: Option<PhaseFieldFlow>,
    /// Area of the surface that belongs to each vertex.
    areas: Vec<f64>,
    /// Length at area 4π of a length of the surface.
    scale: f64,
    /// Connected parts of the surface.
    parts: usize,
    /// ε as it was asked for.
    asked: f64,
    /// Where to go on from, once there is time.
    saved: Option<PhaseCheckpoint>,
    curve: Vec<Event>,
    /// The segment that is shown; without one the one that is divided, or the whole.
    selected: Option<usize>,
    /// Of the splits that are done.
    measures: BTreeMap<usize, PhaseMeasures>,
    /// The last checkpoint, by the steps and options of then.
    kept: RefCell<Option<PhaseCheckpoint>>,
}

/// What Undo goes back to.
#[derive(Clone)]
pub struct PhaseCheckpoint {
    flow: Rc<PhaseFieldCheckpoint>,
    params: PhaseFieldParams,
    steps: usize,
    curve: Rc<Vec<Event>>,
    measures: BTreeMap<usize, PhaseMeasures>,
}

impl PhaseCheckpoint {
    /// Writes what tells it from others.
    pub fn describe(&self, to: &mut dyn std::fmt::Write) -> std::fmt::Result {
        write!(to, "{:?} {} {:?}", self.params, self.steps, self.curve)
    }
}

impl PhaseField {
    /// What is needed to come back; the same one as long as nothing has changed.
    pub fn checkpoint(&self) -> Option<PhaseCheckpoint> {
        let Some(flow) = &self.flow else { return self.saved.clone() };
        let mut kept = self.kept.borrow_mut();
        let is_same = |c: &&PhaseCheckpoint| c.steps == flow.steps() && c.params == *flow.params();
        if kept.as_ref().filter(is_same).is_none() {
            *kept = Some(PhaseCheckpoint {
                flow: Rc::new(flow.checkpoint()),
                params: flow.params().clone(),
                steps: flow.steps(),
                curve: Rc::new(self.curve.clone()),
                measures: self.measures.clone(),
            });
        }
        kept.clone()
    }

    /// Where to go on from.
    pub fn put_back(&mut self, checkpoint: Option<PhaseCheckpoint>) {
        self.saved = checkpoint;
    }

    /// What of an earlier state of the same surface stays: what was looked at.
    pub fn keep(&mut self, old: Self) {
        self.selected = old.selected;
    }

    /// Shows a segment. **Gives** whether there is such a one.
    pub fn select(&mut self, node: usize) -> bool {
        let is_there = self.flow.as_ref().is_some_and(|flow| node < flow.state().tree().len());
        if is_there {
            self.selected = Some(node);
        }
        is_there
    }

    /// The leaves as the start of a cut flow.
    pub fn cut_start(&self) -> Option<Initial> {
        self.flow.as_ref().map(PhaseFieldFlow::cut_start)
    }

    /// The segment that is shown.
    fn shown(&self) -> usize {
        let Some(flow) = &self.flow else { return 0 };
        let known = self.selected.filter(|&node| node < flow.state().tree().len());
        known.or(flow.current().map(|(node, _)| node)).unwrap_or(0)
    }

    fn measure_surface(&mut self, surface: &Surface) {
        let (mesh, geometry) = surface.solving();
        self.areas = geometry.vertex_dual_areas(mesh);
        self.scale = length_scale(geometry);
        self.parts = surface.topology.components;
    }

    fn start(&mut self, flow: PhaseFieldFlow) {
        self.curve = vec![point(&flow)];
        self.measures.clear();
        self.flow = Some(flow);
    }

    /// Measures anew what can be measured: fields are to change.
    fn forget_measures(&mut self) -> Result<(), SolveError> {
        self.measures.clear();
        *self.kept.borrow_mut() = None;
        self.measure(None)
    }

    /// Measures what is done; everything at the end.
    fn measure(&mut self, before: Option<usize>) -> Result<(), SolveError> {
        let Some(flow) = &self.flow else { return Ok(()) };
        let now = flow.current().map(|(node, _)| node);
        if now == before && now.is_some() {
            return Ok(());
        }
        if now.is_none() && flow.params().is_joint {
            // Relaxed together, all have moved once more.
            self.measures.clear();
        }
        for (node, segment) in flow.state().tree().iter().enumerate() {
            let is_due = now.is_none() || Some(node) == before;
            if is_due && segment.children.is_some() && !self.measures.contains_key(&node) {
                self.measures.insert(node, flow.measure(node)?);
            }
        }
        Ok(())
    }

    /// The hierarchy.
    fn tree(&self) -> Option<SegmentTree> {
        let flow = self.flow.as_ref()?;
        let state = flow.state();
        let (nodes, leaves) = (state.tree(), state.leaves());
        let names = names(nodes);
        let total: f64 = self.areas.iter().sum();
        let mut list = Vec::with_capacity(nodes.len());
        for (node, segment) in nodes.iter().enumerate() {
            let weighed = segment.weight.iter().zip(&self.areas);
            let area: f64 = weighed.map(|(w, a)| w * a).sum();
            let of_parent = segment.parent.and_then(|parent| {
                let side = usize::from(nodes[parent].children?[1] == node);
                Some(self.measures.get(&parent)?.components[side])
            });
            let measures = self.measures.get(&node);
            let leaf = leaves.iter().position(|&leaf| leaf == node);
            list.push(Segment {
                node,
                parent: segment.parent,
                level: segment.level,
                label: names[node].clone(),
                is_leaf: leaf.is_some(),
                color: leaf.map(colour),
                area_fraction: area / total,
                components: if node == 0 { self.parts } else { of_parent.unwrap_or(1) },
                length: measures.map(|m| m.length / self.scale),
                loss: measures.map(|m| m.sharp[0] + m.sharp[1]).filter(|x| x.is_finite()),
            });
        }
        let active = flow.current().map(|(node, _)| node);
        Some(SegmentTree { nodes: list, selected: self.shown(), active })
    }

    /// Sums over all splits of what was measured, lengths at area 4π: length and sharp loss.
    fn sums(&self) -> (f64, f64) {
        let each = self.measures.values();
        each.fold((0.0, 0.0), |(length, loss), m| {
            (length + m.length, loss + m.sharp[0] + m.sharp[1])
        })
    }

    fn yamabe(&self) -> f64 {
        let Some(flow) = &self.flow else { return 0.0 };
        flow.state().tree().iter().map(|node| node.terms.yamabe).sum()
    }
}

impl Segmentation for PhaseField {
    fn prepare(&mut self, inputs: &Inputs) -> Result<bool, Problem> {
        let surface = inputs.surface;
        let wrong = |error| Problem::solve(&surface.name, &error);
        let is_painted = inputs.settings.text("phase_start") == "painted";
        // What was found before goes on without its start.
        if is_painted && inputs.layers.regions.is_empty() && self.saved.is_none() {
            return Err(Problem::new(
                "Nothing to start from: no regions are painted yet.",
                "Start of the divisions.",
                "Choose Brush, Regions, and paint on the surface, or choose another start.",
            ));
        }
        let params = params(inputs);
        self.asked = inputs.settings.number("epsilon");
        if let Some(saved) = self.saved.take() {
            let (mesh, geometry) = surface.solving_shared();
            let flow = PhaseFieldFlow::resume(mesh, geometry, &saved.flow, saved.params.clone())
                .map_err(wrong)?;
            self.flow = Some(flow);
            self.curve = saved.curve.to_vec();
            self.measures.clone_from(&saved.measures);
            self.measure_surface(surface);
            *self.kept.borrow_mut() = Some(saved);
            if let Some(flow) = self.flow.as_mut().filter(|flow| *flow.params() != params) {
                flow.set_params(params).map_err(wrong)?;
                self.forget_measures().map_err(wrong)?;
            }
            return Ok(true);
        }
        // Another way to search is another search, and so is anything before the first step.
        let is_same_start = |flow: &PhaseFieldFlow| {
            let of = |p: &PhaseFieldParams| (p.seed, p.starts, p.warm_up);
            flow.steps() > 0
                && flow.params().start == params.start
                && of(flow.params()) == of(&params)
        };
        match &mut self.flow {
            Some(flow) if *flow.params() == params => Ok(false),
            Some(flow) if is_same_start(flow) => {
                flow.set_params(params).map_err(wrong)?;
                self.forget_measures().map_err(wrong)?;
                Ok(true)
            }
            _ => {
                let (mesh, geometry) = surface.solving_shared();
                let flow = PhaseFieldFlow::new(mesh, geometry, params).map_err(wrong)?;
                self.measure_surface(surface);
                self.start(flow);
                Ok(true)
            }
        }
    }

    fn begin_again(&mut self) {
        *self = Self::default();
    }

    fn step(&mut self, inputs: &Inputs) -> Result<(), Problem> {
        let wrong = |error| Problem::solve(&inputs.surface.name, &error);
        let Some(flow) = &mut self.flow else { return Ok(()) };
        let before = flow.current().map(|(node, _)| node);
        flow.step().map_err(wrong)?;
        self.curve.push(point(flow));
        self.measure(before).map_err(wrong)
    }

    fn steps(&self) -> usize {
        self.flow.as_ref().map_or(0, PhaseFieldFlow::steps)
    }

    fn status(&self) -> Option<Status> {
        self.flow.as_ref().map(PhaseFieldFlow::status)
    }

    fn doing(&self) -> String {
        let Some(flow) = &self.flow else { return String::new() };
        let Some((node, attempt)) = flow.current() else { return String::new() };
        let starts = flow.params().starts;
        let what = match &*names(flow.state().tree())[node] {
            WHOLE => "dividing the whole".to_owned(),
            name => format!("dividing segment {name}"),
        };
        if starts > 1 { format!("{what}, start {} of {starts}", attempt + 1) } else { what }
    }

    fn labels(&self) -> Option<Vec<u32>> {
        self.flow.as_ref().map(|flow| flow.state().labels())
    }

    fn cut(&self, surface: &Surface) -> Option<CutMesh> {
        self.flow.as_ref().map(|flow| match surface.solving {
            Some(_) => flow.cut_mesh_on(&surface.mesh, &surface.geometry),
            None => flow.cut_mesh(),
        })
    }

    fn curve(&self) -> &[Event] {
        &self.curve
    }

    fn rows(&self, _: Option<&Layout>) -> Vec<Row> {
        let Some(flow) = &self.flow else { return Vec::new() };
        let state = flow.state();
        let mut rows = vec![
            Row::new("segments", "Segments", "", state.leaves().len() as f64),
            Row::new("share", "First part", "%", 100.0 * state.tree()[0].terms.area_fraction),
            Row::new("interface", "Interface ∫ of the phase field", "√A", self.interface(flow)),
        ];
        // Without a price it is measured at the end only.
        if flow.params().omega > 0.0 || flow.current().is_none() {
            rows.push(Row::new("yamabe", "Diffuse distortion J", "", self.yamabe()));
        }
        if !self.measures.is_empty() {
            let (length, loss) = self.sums();
            rows.push(Row::new("level_length", "Level-set length", "√A", length / self.scale));
            rows.push(Row::new("sharp", "Sharp Hencky loss", "", loss));
        }
        rows
    }

    fn field(&self, id: &str) -> Result<Option<Vec<f64>>, SolveError> {
        let Some(flow) = &self.flow else { return Ok(None) };
        let nodes = flow.state().tree();
        let shown = self.shown();
        // A segment that is not divided is a side of its parent's division.
        let divided = match nodes[shown].children {
            Some(_) => shown,
            None => nodes[shown].parent.unwrap_or(0),
        };
        let within = |values: &[f64]| {
            let weights = nodes[divided].weight.iter();
            let values = values.iter().zip(weights);
            values.map(|(x, w)| if *w > 1e-3 { *x } else { f64::NAN }).collect()
        };
        Ok(match id {
            "weight" => Some(nodes[shown].weight.to_vec()),
            "phase" => Some(within(&nodes[divided].u)),
            "yamabe" => Some(within(&flow.scale_factors(divided)?)),
            _ => None,
        })
    }

    fn notes(&self) -> Vec<String> {
        let Some(flow) = &self.flow else { return Vec::new() };
        let mut notes = Vec::new();
        let epsilon = flow.params().epsilon;
        if epsilon > 1.01 * self.asked {
            notes.push(format!(
                "The interface is {epsilon:.3} wide in place of {:.3}: two edges of this mesh. For a thinner one remesh it, under Prepare or by the command prepare with --tool remesh.",
                self.asked
            ));
        }
        if let Some(small) = flow.epsilon_notice() {
            notes.push(format!(
                "The mesh is too coarse for any interface: two of its edges span {:.3}. Remesh it, under Prepare or by the command prepare with --tool remesh.",
                small.floor
            ));
        }
        let most = flow.state().tree()[0].u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        if flow.status() != Status::Running && most < FAINT {
            notes.push(format!(
                "The field stays near 0 (at most {most:.2}): an interface of width {epsilon:.3} is too wide for this surface. Choose a smaller one, or remesh."
            ));
        }
        let leaves = self.tree().into_iter().flat_map(|tree| tree.nodes);
        let extra: usize =
            leaves.filter(|leaf| leaf.is_leaf).map(|leaf| leaf.components.saturating_sub(1)).sum();
        if flow.status() != Status::Running && extra > 0 {
            notes.push(format!(
                "Segments fall into {} more than there are segments: other starts, a smaller ω or a larger κ may join them.",
                plural(extra, "part")
            ));
        }
        notes
    }

    fn told(&self) -> Option<Event> {
        self.tree().map(Event::Segments)
    }
}

impl PhaseField {
    /// P/√2, all splits.
    fn interface(&self, flow: &PhaseFieldFlow) -> f64 {
        let sum: f64 = flow.state().tree().iter().map(|node| node.terms.perimeter).sum();
        sum / SQRT_2 / self.scale
    }
}

/// What a person calls segments: `Whole`, `1`, `2`, `1.1` and so on.
fn names(nodes: &[PhaseNode]) -> Vec<String> {
    let mut names: Vec<String> = vec![WHOLE.into()];
    for (node, segment) in nodes.iter().enumerate().skip(1) {
        let parent = segment.parent.unwrap_or(0);
        let side = nodes[parent].children.map_or(0, |c| usize::from(c[1] == node)) + 1;
        names.push(if parent == 0 {
            side.to_string()
        } else {
            format!("{}.{side}", names[parent])
        });
    }
    names
}

/// The options that parameters and paint ask for. ε spans two edges at least.
fn params(inputs: &Inputs) -> PhaseFieldParams {
    let Inputs { surface, settings, layers } = *inputs;
    let (mesh, geometry) = surface.solving();
    let whole = |id: &str| super::super::params::whole(settings.number(id));
    let start = match settings.text("phase_start") {
        "random" => Start::Random,
        "normals" => Start::Normals,
        "painted" if !layers.regions.is_empty() => {
            let side = |v: usize| if layers.regions[v] == 0 { 1.0 } else { -1.0 };
            Start::Values(Arc::new((0..mesh.vertex_count()).map(side).collect()))
        }
        _ => Start::Axes,
    };
    PhaseFieldParams {
        epsilon: settings.number("epsilon").max(epsilon_floor(geometry)).min(WIDEST),
        kappa: settings.number("kappa"),
        omega: settings.number("omega"),
        fraction: settings.number("fraction") / 100.0,
        levels: whole("levels"),
        starts: whole("starts"),
        start,
        is_connected: settings.is_on("connected"),
        is_joint: settings.is_on("relax"),
        screening: match settings.text("screening") {
            "paper" => Screening::Paper,
            "sharp" => Screening::Sharp,
            _ => Screening::Outside,
        },
        warm_up: whole("warm_up"),
        seed: whole("phase_seed") as u64,
        ..PhaseFieldParams::default()
    }
}

/// The objective of all divisions so far, the one under way included.
fn point(flow: &PhaseFieldFlow) -> Event {
    let [interface, distortion, connectedness] = flow.costs();
    let term = |name: &str, value: f64| Term { name: name.into(), value };
    Event::Energy {
        step: flow.steps(),
        total: interface + distortion + connectedness,
        terms: vec![
            term("Interface P", interface),
            term("Distortion ωJ", distortion),
            term("Connectedness", connectedness),
        ],
    }
}

impl Work {
    /// Overlapping charts of the segments, where a phase field is at rest.
    pub(in super::super) fn atlas_layers(&mut self) -> Option<LayerScene> {
        if self.method != Method::PhaseField || !self.is_settled {
            return None;
        }
        if self.atlas.is_none() {
            let weights = self.phase.flow.as_ref()?.state().chart_weights();
            if weights.len() < 2 {
                return None;
            }
            let surface = self.document.surface.as_ref()?;
            let (mesh, geometry) = (&surface.mesh, &surface.geometry);
            match Atlas::new(mesh, geometry, &weights, &AtlasParams::default()) {
                Ok(atlas) => {
                    let colours: Vec<u8> = (0..weights.len()).map(colour).collect();
                    self.atlas = Some(layers(surface, &atlas, &colours));
                }
                Err(error) => {
                    let text = format!("There is no atlas of overlapping charts: {error}.");
                    self.layout.as_mut()?.tell(&text);
                    self.atlas = Some(LayerScene::default());
                }
            }
        }
        self.atlas.clone().filter(|layers| !layers.charts.is_empty())
    }

    /// The report of `cutflow phasefield`.
    pub(in super::super) fn phase_report(
        &self,
        seconds: Option<f64>,
    ) -> Result<PhaseFieldReport, Problem> {
        let phase = &self.phase;
        let (Some(flow), Some(tree), Some(layout)) = (&phase.flow, phase.tree(), &self.layout)
        else {
            return Err(not_divided(self));
        };
        let (params, root) = (flow.params(), &flow.state().tree()[0]);
        let leaves = tree.nodes.iter().filter(|segment| segment.is_leaf);
        let history = phase.curve.iter().filter_map(|event| match event {
            Event::Energy { step, total, .. } => Some([*step as f64, *total]),
            _ => None,
        });
        let notes = phase.notes().into_iter().map(|text| NoticeText::new("phase_field", 1, text));
        Ok(PhaseFieldReport {
            vertices: self.document.summary.vertices,
            faces: self.document.summary.faces,
            epsilon: params.epsilon,
            levels: params.levels,
            omega: params.omega,
            perimeter: phase.sums().0 / phase.scale,
            area_fraction: root.terms.area_fraction,
            components: leaves.map(|segment| segment.components).sum(),
            yamabe: phase.yamabe(),
            steps: phase.steps(),
            status: status_word(phase.status()),
            segments: tree.nodes,
            history: history.collect(),
            flattening: FlattenReport::new(layout, None),
            notices: self.notices(layout).into_iter().chain(notes).collect(),
            seconds,
        })
    }
}
