//! Even triangles on an old surface: isotropic remeshing.
//!
//! Edges much longer than wanted are split, much shorter ones collapsed, diagonals turned towards six edges at a vertex, and
//! vertices drawn to the middle of their neighbours; after each move a vertex is put back onto the *given* surface, within the
//! part of it (between feature lines) that it belongs to, so that errors do not add up and nothing slides over a crease.
//!
//! Texture coordinates are read off the given surface at the end of each round: inside a part at the point where a vertex
//! lies, on a line from the face on the side in question. Seams are feature lines, so that both sides stay exact.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

mod given;
mod texture;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{Point3, Vector3};

use super::features::{Features, Place};
use super::triangles::{Triangles, shape, turns_over, vector};
use super::{NONE, Prepared, Surface, check};
use crate::geometry::{Geometry, Nearest, closest};
use crate::mesh::FaceId;
use crate::methods::flow::{Flow, SolveError, Status, StepReport};
use given::{length_scales, split_parts};

/// How long the new edges shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeTarget {
    /// In multiples of the mean edge length of the given surface.
    MeanEdges(f64),
    /// In the unit of the positions.
    Length(f64),
}

/// Options of [`RemeshFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemeshParams {
    /// Edge length aimed at.
    pub target: EdgeTarget,
    /// Rounds of splitting, collapsing, flipping and smoothing. Five make most triangles good; ten settle the last ones.
    pub iterations: u32,
    /// Edges whose faces turn by more than this, in radians, are kept, and so are corners of lines that turn by more.
    pub feature_angle: f64,
    /// 0: the same length everywhere. 1: length inversely proportional to curvature, between a quarter and twice the target. At one
    /// half fingertips and horns keep their shape (they lose twice as much at 0) at the same number of faces.
    pub adaptivity: f64,
}

impl Default for RemeshParams {
    fn default() -> Self {
        Self {
            target: EdgeTarget::MeanEdges(1.0),
            iterations: 8,
            feature_angle: 40f64.to_radians(),
            adaptivity: 0.5,
        }
    }
}

impl RemeshParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        match self.target {
            EdgeTarget::MeanEdges(multiple) => check("edge length", multiple, 0.05, 100.0)?,
            EdgeTarget::Length(length) => check("edge length", length, 1e-100, 1e100)?,
        }
        check("iterations", f64::from(self.iterations), 1.0, 100.0)?;
        check("feature angle", self.feature_angle, 0.0, std::f64::consts::PI)?;
        check("adaptivity", self.adaptivity, 0.0, 1.0)
    }
}

/// Longer than this, in multiples of the length wanted, an edge is split; shorter than the other, collapsed. Halving an edge of
/// 4/3 gives two of 2/3, and joining two of 4/5 gives one of 4/3 at most in a flat lattice: each leaves edges nearer to 1.
const LONG: f64 = 4.0 / 3.0;
const SHORT: f64 = 4.0 / 5.0;

/// Cosine of the largest turn of a face in one operation. At 0 a face may stand on its side and the next move turns it over;
/// near 1 coarse targets cannot be reached on curved surfaces.
const TURN: f64 = 0.5;

/// Cosine of the largest turn of faces when a diagonal flips: 32°, below any feature angle of use. At 60° ridges without
/// feature lines get notches.
const FLAT: f64 = 0.85;

/// How far the new surface may pass by a vertex that was collapsed or moved, in lengths wanted. At 0.5 fingertips and horns narrower
/// than an edge are eaten up round by round; at 0.02 nothing can move on curved surfaces.
const FAR: f64 = 0.1;

/// More faces than this are not begun: each costs some 300 bytes.
const MOST_FACES: f64 = 4e6;

/// What the next step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Split,
    Collapse,
    Flip,
    Relax,
}

/// Draws even triangles on a surface.
///
/// **Step** a quarter of a round (splits, collapses, flips, or smoothing) and no more than a quarter of the faces at a time; the
/// state changes at the end of each round. Unevenness may rise from one quarter to the next. **Ends** `Converged` after the rounds asked for.
/// **Takes** any surface. **Gives** edges of about the length wanted, angles mostly between 35° and 90° away from features. Feature
/// vertices lie on the given feature lines, free vertices on the given surface.
/// **Fails** on coordinates that are not finite, and on a length that would make more than four million faces.
/// **Costs** O(F log F) a round. **From** Botsch, Kobbelt: *A remeshing approach to multiresolution modeling*, 2004.
/// **Differs**: points are put back by nearest point within a part of the surface; lines are slid along by arc length; the last
/// rounds flip for angles in place of valences.
pub struct RemeshFlow {
    params: RemeshParams,
    given: Surface,
    /// One face of the given surface for each part between feature lines.
    parts: Vec<u32>,
    features: Features,
    nearest: Nearest,
    /// For each face of the given surface the part that it belongs to.
    face_parts: Vec<u32>,
    /// Normals of the given surface, of the length of twice an area.
    face_vectors: Vec<Vector3<f64>>,
    length: f64,
    /// Length wanted at the vertices of the given surface, in multiples of `length`; empty where it is 1 everywhere.
    given_scales: Vec<f64>,
    /// Tags are parts.
    triangles: Triangles,
    places: Vec<Place>,
    /// Where a free vertex lies on the face of its place.
    weights: Vec<[f64; 3]>,
    scales: Vec<f64>,
    phase: Phase,
    queue: BinaryHeap<(u64, Reverse<[u32; 2]>)>,
    round: u32,
    steps: usize,
    scratch: [Vec<u32>; 2],
    state: Prepared,
}

impl RemeshFlow {
    /// Finds the feature lines and prepares for nearest points.
    pub fn new(surface: Surface, params: &RemeshParams) -> Result<Self, SolveError> {
        params.validate()?;
        surface.check_finite()?;
        let mesh = &surface.mesh;
        let geometry = Geometry::measure(mesh, surface.positions.clone());
        let length = match params.target {
            EdgeTarget::MeanEdges(multiple) => multiple * geometry.mean_edge_length(),
            EdgeTarget::Length(length) => length,
        };
        let shortest = (geometry.total_area() / (MOST_FACES * 3f64.sqrt() / 4.0)).sqrt();
        check("edge length", length, shortest.max(f64::MIN_POSITIVE), f64::MAX)?;
        let features = Features::new(&surface, params.feature_angle);
        let (face_parts, parts) = split_parts(mesh, &features.edge_curves);
        let given_scales = length_scales(mesh, &geometry, params.adaptivity);
        let mut triangles = Triangles::new(&surface);
        triangles.uvs = Vec::new();
        for e in mesh.edges() {
            triangles.mark_edge(mesh, e, features.edge_curves[e.index()]);
        }
        triangles.tags.clone_from(&face_parts);
        let weights = features
            .places
            .iter()
            .enumerate()
            .map(|(v, place)| match place {
                Place::Free(f) => {
                    mesh.face_vertices(FaceId(*f)).map(|w| f64::from(u8::from(w.index() == v)))
                }
                _ => [0.0; 3],
            })
            .collect();
        let source = |f: u32| parts[triangles.tags[f as usize] as usize];
        let uvs =
            |f: u32| surface.attributes.corner_uvs.get(f as usize).copied().unwrap_or_default();
        let state = triangles.export(&surface.attributes, source, uvs)?;
        let mut flow = Self {
            params: *params,
            places: features.places.clone(),
            nearest: Nearest::new(mesh, &surface.positions),
            face_parts,
            face_vectors: surface.face_vectors(),
            scales: given_scales.clone(),
            parts,
            features,
            length,
            given_scales,
            triangles,
            weights,
            phase: Phase::Split,
            queue: BinaryHeap::new(),
            round: 0,
            steps: 0,
            scratch: Default::default(),
            state,
            given: surface,
        };
        flow.fill_queue();
        Ok(flow)
    }

    /// Length of an edge over the length wanted there.
    fn ratio(&self, a: u32, b: u32) -> f64 {
        let [p, q] = [a, b].map(|v| self.triangles.positions[v as usize]);
        (p - q).norm() / (self.length * 0.5 * (self.scale(a) + self.scale(b)))
    }

    fn scale(&self, v: u32) -> f64 {
        self.scales.get(v as usize).copied().unwrap_or(1.0)
    }

    /// The edges that the phase has to work on. Bits of numbers above zero sort like the numbers: longest edges come first
    /// where they are split, shortest where they are collapsed.
    fn fill_queue(&mut self) {
        self.queue.clear();
        for [a, b] in self.triangles.edges() {
            self.enqueue(a, b);
        }
    }

    fn enqueue(&mut self, a: u32, b: u32) {
        if let Some(key) = self.key(a, b) {
            self.queue.push((key, Reverse([a.min(b), a.max(b)])));
        }
    }

    fn key(&self, a: u32, b: u32) -> Option<u64> {
        let ratio = self.ratio(a.min(b), a.max(b));
        match self.phase {
            Phase::Split => (ratio > LONG && ratio.is_finite()).then_some(ratio.to_bits()),
            Phase::Collapse => (ratio < SHORT).then_some(!ratio.to_bits()),
            _ => None,
        }
    }

    /// Works through the queue; gives whether it is empty.
    fn drain(&mut self) -> bool {
        let budget = (self.triangles.face_count / 4).max(4096);
        let mut around = Vec::new();
        for _ in 0..budget {
            let Some((key, Reverse([a, b]))) = self.queue.pop() else { return true };
            let is_there = !self.triangles.edge_faces(a, b).as_slice().is_empty();
            if !is_there || self.key(a, b) != Some(key) {
                continue;
            }
            let changed =
                if self.phase == Phase::Split { self.split(a, b) } else { self.collapse(a, b) };
            if let Some(v) = changed {
                self.triangles.neighbours(v, &mut around);
                for &w in &around {
                    self.enqueue(v, w);
                }
            }
        }
        self.queue.is_empty()
    }

    /// Sum of the face vectors around a vertex, of the length of twice an area.
    fn normal(&self, v: u32) -> Vector3<f64> {
        self.triangles.fans[v as usize].iter().map(|&f| vector(self.triangles.points(f))).sum()
    }

    /// The nearest point of the given surface within a part, on faces whose normals do not look away from `normal`, as place,
    /// weights and point.
    fn project(
        &self,
        point: Point3<f64>,
        normal: Vector3<f64>,
        part: u32,
        hint: Place,
    ) -> Option<(Place, [f64; 3], Point3<f64>)> {
        let hint = match hint {
            Place::Free(f) => Some(FaceId(f)),
            _ => None,
        };
        let hit = self.nearest.find_among(point, hint, |f| {
            self.face_parts[f.index()] == part && !(self.face_vectors[f.index()].dot(&normal) < 0.0)
        })?;
        Some((Place::Free(hit.face.0), hit.weights, hit.point))
    }

    /// The arc length of a vertex on a curve that it lies on or ends.
    fn arc(&self, curve: u32, v: u32) -> f64 {
        match self.places[v as usize] {
            Place::Curve(c, arc) if c == curve => arc,
            // The corners of a curve are vertices of the given surface and keep their numbers.
            _ => self.features.curves[curve as usize].end(v),
        }
    }

    fn split(&mut self, a: u32, b: u32) -> Option<u32> {
        let [p, q] = [a, b].map(|v| self.triangles.positions[v as usize]);
        let curve = self.triangles.mark(a, b);
        let middle = Point3::from(0.5 * p.coords + 0.5 * q.coords);
        let faces = self.triangles.edge_faces(a, b);
        let (place, weights, mut point) = if curve == NONE {
            let f = faces.as_slice()[0];
            let normal = faces.as_slice().iter().map(|&f| vector(self.triangles.points(f))).sum();
            let hint = [a, b].map(|v| self.places[v as usize]);
            let hint = if matches!(hint[0], Place::Free(_)) { hint[0] } else { hint[1] };
            self.project(middle, normal, self.triangles.tags[f as usize], hint)?
        } else {
            let arc = 0.5 * self.arc(curve, a) + 0.5 * self.arc(curve, b);
            let line = &self.features.curves[curve as usize];
            (Place::Curve(curve, arc), [0.0; 3], line.at(arc))
        };
        let turns = |point: Point3<f64>| {
            faces.as_slice().iter().any(|&f| {
                let corners = self.triangles.faces[f as usize];
                [a, b].iter().any(|&v| {
                    let moved = corners
                        .map(|w| if w == v { point } else { self.triangles.positions[w as usize] });
                    turns_over(vector(self.triangles.points(f)), vector(moved), TURN)
                })
            })
        };
        if turns(point) {
            // On a line there is no other place for it; inside, smoothing will put it right.
            if curve != NONE {
                return None;
            }
            point = middle;
        }
        if point == p || point == q {
            return None;
        }
        let m = self.triangles.split(a, b, point);
        self.places.push(place);
        self.weights.push(weights);
        if !self.scales.is_empty() {
            self.scales.push(0.5 * self.scales[a as usize] + 0.5 * self.scales[b as usize]);
        }
        Some(m)
    }

    fn collapse(&mut self, a: u32, b: u32) -> Option<u32> {
        let mark = self.triangles.mark(a, b);
        let places = [a, b].map(|v| self.places[v as usize]);
        let position = |v: u32| self.triangles.positions[v as usize];
        let stay = |v: u32| (self.places[v as usize], self.weights[v as usize], position(v));
        let (gone, kept, (place, weights, point)) = match places {
            [Place::Free(_), Place::Free(_)] => {
                let middle = Point3::from(0.5 * position(a).coords + 0.5 * position(b).coords);
                let part = self.triangles.tags[self.triangles.fans[a as usize][0] as usize];
                let normal = self.normal(a) + self.normal(b);
                (b, a, self.project(middle, normal, part, places[0])?)
            }
            [Place::Free(_), _] => (a, b, stay(b)),
            [_, Place::Free(_)] => (b, a, stay(a)),
            _ if mark == NONE => return None,
            [Place::Corner, Place::Corner] => return None,
            [Place::Corner, _] => (b, a, stay(a)),
            [_, Place::Corner] => (a, b, stay(b)),
            _ => {
                let arc = 0.5 * self.arc(mark, a) + 0.5 * self.arc(mark, b);
                let line = &self.features.curves[mark as usize];
                (b, a, (Place::Curve(mark, arc), [0.0; 3], line.at(arc)))
            }
        };
        let is_bad = |v: u32, other: u32| {
            self.triangles.fans[v as usize].iter().any(|&f| {
                let corners = self.triangles.faces[f as usize];
                if corners.contains(&other) {
                    return false;
                }
                let moved = corners.map(|w| if w == v { point } else { position(w) });
                let too_long = corners.iter().filter(|&&w| w != v).any(|&w| {
                    let wanted = self.length * 0.5 * (self.scale(kept) + self.scale(w));
                    (position(w) - point).norm() > LONG * wanted
                });
                too_long || turns_over(vector(self.triangles.points(f)), vector(moved), TURN)
            })
        };
        if is_bad(gone, kept)
            || is_bad(kept, gone)
            || self.leaves_behind([gone, kept], point)
            || !self.triangles.can_collapse(gone, kept, &mut self.scratch)
        {
            return None;
        }
        self.triangles.collapse(gone, kept);
        self.put(kept, place, weights, point);
        Some(kept)
    }

    /// Moves a vertex.
    fn put(&mut self, v: u32, place: Place, weights: [f64; 3], point: Point3<f64>) {
        self.places[v as usize] = place;
        self.weights[v as usize] = weights;
        if self.triangles.positions[v as usize] != point {
            self.triangles.positions[v as usize] = point;
            self.triangles.is_old[v as usize] = false;
        }
        if !self.scales.is_empty() {
            self.scales[v as usize] = match place {
                Place::Free(f) => {
                    let corners = self.given.mesh.face_vertices(FaceId(f));
                    let value = |i: usize| self.given_scales[corners[i].index()] * weights[i];
                    value(0) + value(1) + value(2)
                }
                Place::Curve(c, arc) => {
                    let curve = &self.features.curves[c as usize];
                    let (i, t) = curve.segment(arc);
                    let value = |i: usize| self.given_scales[curve.vertices[i] as usize];
                    (1.0 - t) * value(i) + t * value(i + 1)
                }
                Place::Corner => self.scales[v as usize],
            };
        }
    }

    /// Turns diagonals: towards the right number of edges at each vertex, or towards larger angles.
    fn flip_all(&mut self, by_angle: bool) {
        let mut around = Vec::new();
        let mut excess: Vec<i32> = Vec::with_capacity(self.triangles.fans.len());
        for v in 0..self.triangles.fans.len() as u32 {
            self.triangles.neighbours(v, &mut around);
            let faces = self.triangles.fans[v as usize].len();
            let wanted = if around.len() > faces { 4 } else { 6 };
            excess.push(around.len() as i32 - wanted);
        }
        for [a, b] in self.triangles.edges() {
            let faces = self.triangles.edge_faces(a, b);
            let &[f, g] = faces.as_slice() else { continue };
            if self.triangles.mark(a, b) != NONE {
                continue;
            }
            let (c, d) = (self.triangles.third(f, a, b), self.triangles.third(g, a, b));
            let [ea, eb, ec, ed] = [a, b, c, d].map(|v| excess[v as usize]);
            let gain = (ea * ea + eb * eb + ec * ec + ed * ed)
                - ((ea - 1).pow(2) + (eb - 1).pow(2) + (ec + 1).pow(2) + (ed + 1).pow(2));
            if (!by_angle && gain <= 0) || !self.may_flip(a, b, [f, g], [c, d], by_angle) {
                continue;
            }
            if self.triangles.flip(a, b) {
                for (v, change) in [(a, -1), (b, -1), (c, 1), (d, 1)] {
                    excess[v as usize] += change;
                }
            }
        }
    }

    /// Whether the other diagonal makes two faces that look where the old ones looked, with fair angles, or better ones.
    fn may_flip(&self, a: u32, b: u32, old: [u32; 2], [c, d]: [u32; 2], by_angle: bool) -> bool {
        let [f, _] = old;
        // With the face on the left of ab first, the new faces are adc and dbc.
        let is_left = self.triangles.faces[f as usize][(self.triangles.corner(f, a) + 1) % 3] == b;
        let (c, d) = if is_left { (c, d) } else { (d, c) };
        let at = |v: u32| self.triangles.positions[v as usize];
        let before = old.map(|f| self.triangles.points(f));
        let after = [[at(a), at(d), at(c)], [at(d), at(b), at(c)]];
        let olds = before.map(vector);
        if after.iter().any(|&n| olds.iter().any(|&o| turns_over(o, vector(n), FLAT))) {
            return false;
        }
        let worst = |faces: [[Point3<f64>; 3]; 2]| shape(faces[0]).min(shape(faces[1]));
        if by_angle {
            worst(after) > 1.01 * worst(before)
        } else {
            worst(after) > (0.5 * worst(before)).min(0.3)
        }
    }

    /// Draws every vertex to the middle of its neighbours, along the surface or its line.
    fn relax(&mut self) {
        let mut around = Vec::new();
        for v in 0..self.triangles.fans.len() as u32 {
            if self.triangles.fans[v as usize].is_empty() {
                continue;
            }
            match self.places[v as usize] {
                Place::Corner => {}
                Place::Curve(curve, _) => {
                    self.triangles.neighbours(v, &mut around);
                    let ends = around.iter().filter(|&&w| self.triangles.mark(v, w) == curve);
                    let (mut sum, mut total) = (0.0, 0.0);
                    for &w in ends {
                        let weight = 1.0 / (self.scale(v) + self.scale(w));
                        sum += weight * self.arc(curve, w);
                        total += weight;
                    }
                    let arc = sum / total;
                    if arc.is_finite() {
                        let point = self.features.curves[curve as usize].at(arc);
                        if !self.turns_any(v, point) {
                            self.put(v, Place::Curve(curve, arc), [0.0; 3], point);
                        }
                    }
                }
                place @ Place::Free(_) => self.relax_free(v, place),
            }
        }
    }

    fn relax_free(&mut self, v: u32, place: Place) {
        let here = self.triangles.positions[v as usize];
        let normal = self.normal(v);
        let part = self.triangles.tags[self.triangles.fans[v as usize][0] as usize];
        let (mut sum, mut total) = (Vector3::zeros(), 0.0);
        for &f in &self.triangles.fans[v as usize] {
            let corners = self.triangles.points(f);
            let scale: f64 = self.triangles.faces[f as usize].map(|w| self.scale(w)).iter().sum();
            // Larger faces pull harder, so that sizes even out.
            let weight = vector(corners).norm() / (scale * scale);
            let centre = (corners[0].coords + corners[1].coords + corners[2].coords) / 3.0;
            sum += (centre - here.coords) * weight;
            total += weight;
        }
        let mut pull = sum / total;
        pull -= normal * (pull.dot(&normal) / normal.norm_squared());
        if !pull.iter().all(|x| x.is_finite()) {
            return;
        }
        // At worst back onto the surface.
        for share in [1.0, 0.5, 0.0] {
            if let Some((place, weights, point)) =
                self.project(here + pull * share, normal, part, place)
                && !self.turns_any(v, point)
                && (share == 0.0 || !self.leaves_behind([v], point))
            {
                self.put(v, place, weights, point);
                return;
            }
        }
    }

    /// Whether the faces around one vertex, or two that become one, would pass by where these were when drawn to a point.
    fn leaves_behind<const N: usize>(&self, vertices: [u32; N], point: Point3<f64>) -> bool {
        vertices.iter().any(|&v| {
            let here = self.triangles.positions[v as usize];
            let limit = FAR * self.length * self.scale(v);
            let fans = vertices.iter().flat_map(|&w| &self.triangles.fans[w as usize]);
            !fans.into_iter().any(|&f| {
                let corners = self.triangles.faces[f as usize];
                let moved = [0, 1, 2].map(|i| {
                    let is_moved = vertices.contains(&corners[i]);
                    if is_moved { point } else { self.triangles.positions[corners[i] as usize] }
                });
                (closest(&moved, here).1 - here).norm_squared() <= limit * limit
            })
        })
    }

    /// Whether moving a vertex turns a face too far.
    fn turns_any(&self, v: u32, point: Point3<f64>) -> bool {
        self.triangles.fans[v as usize].iter().any(|&f| {
            let corners = self.triangles.points(f);
            let mut moved = corners;
            moved[self.triangles.corner(f, v)] = point;
            turns_over(vector(corners), vector(moved), TURN)
        })
    }

    /// Root mean square of how far edges are off the length wanted, in multiples of it.
    fn unevenness(&self) -> f64 {
        let edges = self.triangles.edges();
        let sum: f64 = edges.iter().map(|&[a, b]| (self.ratio(a, b) - 1.0).powi(2)).sum();
        (sum / edges.len() as f64).sqrt()
    }

    fn is_done(&self) -> bool {
        self.round >= self.params.iterations
    }
}

impl Flow for RemeshFlow {
    type State = Prepared;

    fn state(&self) -> &Prepared {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if !self.is_done() {
            // The last rounds are for angles.
            let is_late = self.round + 3 > self.params.iterations;
            match self.phase {
                Phase::Split | Phase::Collapse => {
                    if self.drain() {
                        self.phase =
                            if self.phase == Phase::Split { Phase::Collapse } else { Phase::Flip };
                        self.fill_queue();
                    }
                }
                Phase::Flip => {
                    self.flip_all(false);
                    if is_late {
                        self.flip_all(true);
                    }
                    self.phase = Phase::Relax;
                }
                Phase::Relax => {
                    self.relax();
                    self.relax();
                    if is_late {
                        self.flip_all(true);
                        self.relax();
                    }
                    let parts = &self.parts;
                    let source = |f: u32| parts[self.triangles.tags[f as usize] as usize];
                    let state =
                        self.triangles.export(&self.given.attributes, source, |f| self.uvs(f))?;
                    self.state = state;
                    self.round += 1;
                    self.phase = Phase::Split;
                    self.fill_queue();
                }
            }
            self.steps += 1;
        }
        let status = if self.is_done() { Status::Converged } else { Status::Running };
        let quarter = f32::from(self.phase as u8) / 4.0;
        Ok(StepReport {
            step: self.steps,
            energy: vec![
                ("unevenness", self.unevenness()),
                ("faces", self.triangles.face_count as f64),
            ],
            residual: 0.0,
            progress: Some(
                ((self.round as f32 + quarter) / self.params.iterations as f32).min(1.0),
            ),
            status,
        })
    }
}
