//! Fewer triangles on nearly the same surface: edge collapse by quadric error.
//!
//! Each vertex carries the sum of squared distances from the planes of the given faces that it stands for. The edge whose collapse
//! raises these sums least goes first, to the place where they are least. Planes across feature lines hold those in place; on
//! the boundary, on seams and between materials only edges along the line are collapsed, onto the line.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{Point3, Vector3};

use super::features::{Feature, feature_edges};
use super::quadric::Quadric;
use super::triangles::{Triangles, shape, turns_over, vector};
use super::{Attributes, NONE, Prepared, Surface, Uv, check};
use crate::geometry::closest;
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Options of [`DecimateFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecimateParams {
    /// Number of faces aimed at.
    pub target_faces: usize,
    /// Edges whose faces turn by more than this, in radians, are held where they are as far as possible.
    pub feature_angle: f64,
}

impl Default for DecimateParams {
    fn default() -> Self {
        Self { target_faces: 20_000, feature_angle: 40f64.to_radians() }
    }
}

impl DecimateParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        check("target faces", self.target_faces as f64, 1.0, 1e9)?;
        check("feature angle", self.feature_angle, 0.0, std::f64::consts::PI)
    }
}

/// Weight of the squared distance from the given vertices against that from the planes. Without it the place is undefined where a
/// surface is flat and triangles become needles there; at 0.1 creases are rounded to keep triangles even.
const EVENNESS: f64 = 1e-3;

/// Weight of the planes across feature lines. At 1 a rim frays as a face may bend; far above, a rim keeps its last vertex while
/// the faces beside it grow coarse.
const LINE: f64 = 10.0;

/// Cosine of the largest turn of a face in one collapse. Below 0 faces fold over; towards 1 sharp tips can never be simplified.
const TURN: f64 = 0.2;

/// Faces thinner than this (1 equilateral) are not made, unless they were thinner before.
const THIN: f64 = 0.1;

/// Nearer than this to an end of an edge along a line, in edge lengths, its new vertex is that end: the pull towards given
/// vertices would otherwise move corners of a rim a little, and cut them.
const SNAP: f64 = 0.05;

/// Bits of a cost that are not compared: costs within about a thousandth of each other are alike, and numbers of vertices tell which
/// goes first. On even surfaces many are the same but for rounding, which is another one on other machines.
const ALIKE: u32 = 42;

/// Sorts costs, which are not below zero.
fn rank(cost: f64) -> u64 {
    // Bits of such numbers sort like the numbers. Round numbers stand in the middle of what is alike.
    (cost.to_bits() + (1 << (ALIKE - 1))) >> ALIKE
}

/// What may happen to a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Free,
    /// On a line that must stay a line.
    Line,
    /// Where such lines end or meet.
    Corner,
}

/// How an edge would be collapsed.
struct Plan {
    gone: u32,
    kept: u32,
    point: Point3<f64>,
    cost: f64,
    /// How far from `gone` to `kept` the point lies, where it lies on the edge.
    share: Option<f64>,
}

/// An edge in the queue: the rank of its cost, its ends, and how often these had been changed then.
type Entry = Reverse<(u64, [u32; 2], [u32; 2])>;

/// Takes triangles away where they tell least.
///
/// **Step** collapses that take away an eighth of the faces, at least 8192. **Minimises** greedily the sum of squared distances from
/// the planes of the given faces. **Ends** `Converged` at the target or up to one face below; `Stalled` where nothing legal is left.
/// **Takes** any surface. **Gives** the same topology; lines that were boundary, seam, or between materials are still, their
/// texture coordinates linear along what they were; no face turned over in the texture that was not before.
/// **Fails** on coordinates that are not finite. **Costs** O(F log F).
/// **From** Garland, Heckbert: *Surface simplification using quadric error metrics*, 1997. **Differs**: only edges are collapsed;
/// a small pull towards the given vertices makes the best place unique.
pub struct DecimateFlow {
    params: DecimateParams,
    attributes: Attributes,
    triangles: Triangles,
    kinds: Vec<Kind>,
    /// About `centre`, so that surfaces far from the origin lose no digits.
    quadrics: Vec<Quadric>,
    centre: Vector3<f64>,
    changes: Vec<u32>,
    queue: BinaryHeap<Entry>,
    given_faces: usize,
    /// Collapses since the queue was filled.
    since: usize,
    error: f64,
    steps: usize,
    status: Status,
    scratch: [Vec<u32>; 2],
    state: Prepared,
}

impl DecimateFlow {
    /// Sums the quadrics and sorts the edges.
    pub fn new(surface: Surface, params: &DecimateParams) -> Result<Self, SolveError> {
        params.validate()?;
        surface.check_finite()?;
        let mesh = &surface.mesh;
        let features = feature_edges(&surface, params.feature_angle);
        let mut triangles = Triangles::new(&surface);
        let mut lines = vec![0u32; mesh.vertex_count()];
        for e in mesh.edges().filter(|e| features[e.index()] == Feature::Hard) {
            triangles.mark_edge(mesh, e, 0);
            for v in mesh.edge_vertices(e) {
                lines[v.index()] += 1;
            }
        }
        let kind = |&n: &u32| match n {
            0 => Kind::Free,
            2 => Kind::Line,
            _ => Kind::Corner,
        };
        let (low, high) = surface.positions.iter().fold(
            (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)),
            |(low, high), p| (low.inf(&p.coords), high.sup(&p.coords)),
        );
        let centre = low * 0.5 + high * 0.5;
        let source =
            |f: u32| surface.attributes.corner_uvs.get(f as usize).copied().unwrap_or_default();
        let state = triangles.export(&surface.attributes, |f| f, source)?;
        let mut flow = Self {
            params: *params,
            kinds: lines.iter().map(kind).collect(),
            quadrics: quadrics(&surface, &features, centre),
            centre,
            changes: vec![0; mesh.vertex_count()],
            queue: BinaryHeap::new(),
            given_faces: mesh.face_count(),
            since: 0,
            error: 0.0,
            steps: 0,
            status: Status::Running,
            scratch: Default::default(),
            state,
            triangles,
            attributes: surface.attributes,
        };
        if flow.triangles.face_count <= params.target_faces {
            flow.status = Status::Converged;
        } else {
            flow.fill_queue();
        }
        Ok(flow)
    }

    fn fill_queue(&mut self) {
        self.since = 0;
        let edges = self.triangles.edges();
        let entries: Vec<Entry> = edges.iter().filter_map(|&[a, b]| self.entry(a, b)).collect();
        self.queue = BinaryHeap::from(entries);
    }

    fn entry(&self, a: u32, b: u32) -> Option<Entry> {
        let ends = [a.min(b), a.max(b)];
        let plan = self.plan(ends)?;
        Some(Reverse((rank(plan.cost), ends, ends.map(|v| self.changes[v as usize]))))
    }

    fn place(&self, v: u32) -> Vector3<f64> {
        self.triangles.positions[v as usize].coords - self.centre
    }

    /// Where the ends of an edge would go; none where they must not.
    fn plan(&self, [a, b]: [u32; 2]) -> Option<Plan> {
        let q = self.quadrics[a as usize].plus(&self.quadrics[b as usize]);
        let onto = |gone: u32, kept: u32| {
            let point = self.triangles.positions[kept as usize];
            Plan { gone, kept, point, cost: q.at(self.place(kept)), share: Some(1.0) }
        };
        let kinds = [a, b].map(|v| self.kinds[v as usize]);
        if !kinds.contains(&Kind::Free) && self.triangles.mark(a, b) == NONE {
            return None;
        }
        match kinds {
            [Kind::Free, Kind::Free] => {
                let (p, r) = (self.place(a), self.place(b));
                let reach = (p - r).norm();
                let best = q.least().filter(|x| (x - (p + r) * 0.5).norm() < 2.0 * reach);
                Some(match best {
                    Some(x) => {
                        let point = Point3::from(x + self.centre);
                        Plan { gone: b, kept: a, point, cost: q.at(x), share: None }
                    }
                    None if q.at(p) <= q.at(r) => onto(b, a),
                    None => onto(a, b),
                })
            }
            [Kind::Free, _] | [Kind::Line, Kind::Corner] => Some(onto(a, b)),
            [_, Kind::Free] | [Kind::Corner, Kind::Line] => Some(onto(b, a)),
            [Kind::Corner, Kind::Corner] => None,
            [Kind::Line, Kind::Line] => {
                let t = q.least_along(self.place(a), self.place(b));
                if t < SNAP {
                    return Some(onto(b, a));
                }
                if t > 1.0 - SNAP {
                    return Some(onto(a, b));
                }
                let [p, r] = [a, b].map(|v| self.triangles.positions[v as usize]);
                let point = p + (r - p) * t;
                let cost = q.at(point.coords - self.centre);
                Some(Plan { gone: a, kept: b, point, cost, share: Some(t) })
            }
        }
    }

    /// Carries a plan out, unless topology or the shape of faces is against it.
    fn collapse(&mut self, plan: &Plan) -> bool {
        let Plan { gone, kept, point, .. } = *plan;
        if !self.triangles.can_collapse(gone, kept, &mut self.scratch) {
            return false;
        }
        let uvs = self.new_uvs(plan);
        let mut next = 0;
        for (v, other) in [(gone, kept), (kept, gone)] {
            for &f in &self.triangles.fans[v as usize] {
                let corners = self.triangles.faces[f as usize];
                if corners.contains(&other) {
                    continue;
                }
                let before = self.triangles.points(f);
                let i = self.triangles.corner(f, v);
                let mut after = before;
                after[i] = point;
                let thin = shape(after);
                if turns_over(vector(before), vector(after), TURN)
                    || (thin < THIN && thin < shape(before))
                {
                    return false;
                }
                if let Some(&(_, uv)) = uvs.get(next) {
                    let before = self.triangles.uvs[f as usize];
                    let mut after = before;
                    after[i] = uv;
                    if let (Some(before), Some(after)) = (uv_area(before), uv_area(after))
                        && before * after < 0.0
                    {
                        return false;
                    }
                }
                next += 1;
            }
        }
        self.triangles.collapse(gone, kept);
        for (f, uv) in uvs {
            let i = self.triangles.corner(f, kept);
            self.triangles.uvs[f as usize][i] = uv;
        }
        if self.triangles.positions[kept as usize] != point {
            self.triangles.positions[kept as usize] = point;
            self.triangles.is_old[kept as usize] = false;
        }
        let q = self.quadrics[gone as usize];
        self.quadrics[kept as usize] = self.quadrics[kept as usize].plus(&q);
        self.changes[kept as usize] += 1;
        self.changes[gone as usize] += 1;
        true
    }

    /// The texture coordinates of the new vertex in the faces that stay around it, first those of `gone`.
    fn new_uvs(&self, plan: &Plan) -> Vec<(u32, Uv)> {
        if self.triangles.uvs.is_empty() {
            return Vec::new();
        }
        let Plan { gone, kept, point, share, .. } = *plan;
        let uv = |f: u32, v: u32| self.triangles.uvs[f as usize][self.triangles.corner(f, v)];
        let at = self.triangles.edge_faces(gone, kept);
        // Old values at both ends and the new one, for each side of the edge.
        let sides: Vec<[Uv; 3]> = at
            .as_slice()
            .iter()
            .map(|&f| {
                let (a, b) = (uv(f, gone), uv(f, kept));
                let new = match share {
                    Some(t) if t >= 1.0 => b,
                    Some(t) => a.zip(b).map(|(a, b)| [0, 1].map(|i| (1.0 - t) * a[i] + t * b[i])),
                    None => self.uv_around(gone, kept, point),
                };
                [a, b, new]
            })
            .collect();
        let mut found = Vec::new();
        for (end, v) in [gone, kept].into_iter().enumerate() {
            for &f in &self.triangles.fans[v as usize] {
                if at.as_slice().contains(&f) {
                    continue;
                }
                let old = uv(f, v);
                // A vertex that moves has the line on both sides at most, and no other seam.
                let is_moved = end == 0 || share.is_none_or(|t| t < 1.0);
                let side = if is_moved { sides.iter().find(|side| side[end] == old) } else { None };
                found.push((f, side.map_or(old, |side| side[2])));
            }
        }
        found
    }

    /// The texture coordinate at the point nearest to `point` of the faces around two free vertices.
    fn uv_around(&self, a: u32, b: u32, point: Point3<f64>) -> Uv {
        let fans = [a, b].map(|v| &self.triangles.fans[v as usize]);
        let mut best: (f64, Uv) = (f64::INFINITY, None);
        for &f in fans.into_iter().flatten() {
            let (weights, place) = closest(&self.triangles.points(f), point);
            let squared = (place - point).norm_squared();
            if squared < best.0 {
                let uvs = self.triangles.uvs[f as usize];
                let mix = |[a, b, c]: [[f64; 2]; 3]| {
                    [0, 1].map(|i| weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i])
                };
                best = (squared, whole(uvs).map(mix));
            }
        }
        best.1
    }

    fn run(&mut self) {
        let take = (self.triangles.face_count / 8).max(8192);
        let goal = self.triangles.face_count.saturating_sub(take).max(self.params.target_faces);
        let mut around = Vec::new();
        while self.triangles.face_count > goal {
            let Some(Reverse((_, ends, changes))) = self.queue.pop() else {
                // Edges that were refused may have become legal. A thousandth, so that this comes to an end soon.
                if self.since > self.triangles.face_count / 1000 {
                    self.fill_queue();
                } else {
                    self.status = Status::Stalled;
                }
                return;
            };
            if ends.map(|v| self.changes[v as usize]) != changes {
                continue;
            }
            let Some(plan) = self.plan(ends) else { continue };
            if self.collapse(&plan) {
                self.since += 1;
                self.error = self.error.max(plan.cost);
                self.triangles.neighbours(plan.kept, &mut around);
                for &w in &around {
                    self.queue.extend(self.entry(plan.kept, w));
                }
            }
        }
        if self.triangles.face_count <= self.params.target_faces {
            self.status = Status::Converged;
        }
    }
}

impl Flow for DecimateFlow {
    type State = Prepared;

    fn state(&self) -> &Prepared {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status == Status::Running {
            self.run();
            let triangles = &self.triangles;
            let uvs = |f: u32| triangles.uvs.get(f as usize).copied().unwrap_or_default();
            self.state = triangles.export(&self.attributes, |f| triangles.tags[f as usize], uvs)?;
            self.steps += 1;
        }
        let left = self.triangles.face_count.saturating_sub(self.params.target_faces) as f32;
        let all = self.given_faces.saturating_sub(self.params.target_faces).max(1) as f32;
        let progress = if self.status == Status::Running { 1.0 - left / all } else { 1.0 };
        Ok(StepReport {
            step: self.steps,
            energy: vec![
                ("faces", self.triangles.face_count as f64),
                ("largest quadric error", self.error),
            ],
            residual: 0.0,
            progress: Some(progress),
            status: self.status,
        })
    }
}

/// The quadric of each vertex: planes of its faces and lines, and itself.
fn quadrics(surface: &Surface, features: &[Feature], centre: Vector3<f64>) -> Vec<Quadric> {
    let mesh = &surface.mesh;
    let place = |v: usize| surface.positions[v].coords - centre;
    let mut quadrics = vec![Quadric::default(); mesh.vertex_count()];
    let vectors = surface.face_vectors();
    for (vertices, vector) in mesh.triangles().iter().zip(&vectors) {
        let area = 0.5 * vector.norm();
        if let Some(n) = vector.try_normalize(0.0).filter(|n| n.iter().all(|x| x.is_finite())) {
            let plane = Quadric::plane(n, place(vertices[0].index()), area / 3.0);
            for v in vertices.map(|v| v.index()) {
                let point = Quadric::point(place(v), EVENNESS * area / 3.0);
                quadrics[v] = quadrics[v].plus(&plane).plus(&point);
            }
        }
    }
    for e in mesh.edges() {
        let weight = match features[e.index()] {
            Feature::None => continue,
            Feature::Sharp => 1.0,
            Feature::Hard => LINE,
        };
        let [a, b] = mesh.edge_vertices(e).map(|v| v.index());
        let along = place(b) - place(a);
        for h in [e.halfedge(), e.halfedge().twin()] {
            let Some(f) = mesh.face(h) else { continue };
            let across = along.cross(&vectors[f.index()]);
            if let Some(n) = across.try_normalize(0.0).filter(|n| n.iter().all(|x| x.is_finite())) {
                let plane = Quadric::plane(n, place(a), weight * along.norm_squared());
                for v in [a, b] {
                    quadrics[v] = quadrics[v].plus(&plane);
                }
            }
        }
    }
    quadrics
}

/// All three texture coordinates, if there are.
fn whole([a, b, c]: [Uv; 3]) -> Option<[[f64; 2]; 3]> {
    Some([a?, b?, c?])
}

/// Twice the signed area of a face in the texture.
fn uv_area(uvs: [Uv; 3]) -> Option<f64> {
    let [a, b, c] = whole(uvs)?;
    Some((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}
