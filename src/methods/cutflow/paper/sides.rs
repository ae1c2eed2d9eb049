//! Normal derivatives on both sides of a cut, and the gradient of the paper's Table 1 that is made of them.
//!
//! Every crossing has two *sides* and every triple point three, one for each patch that meets there. The side's row of the
//! patch's own stiffness, which the unknowns of the Yamabe equation never see, gives the flux integrated over the hat function
//! on the rim: r = (A u)_c − f_c = ∫ ∂u/∂n φ_c. Divided by lengths alone it has unbounded errors where a crossing is close to a
//! vertex; smoothed once along the rim, v = (M_lump + h² L_1D)⁻¹ r, it is first-order accurate everywhere.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::sync::Arc;

use nalgebra::Vector2;

use super::super::cut::{Corner, CrossedFace, Cut, Node};
use super::super::energy::{Element, Problem};
use super::super::terms::Weights;
use super::prices::{length_price, pointwise_slopes, price_slope, reward, scale, source};
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};
use crate::mesh::HalfedgeId;

/// The sides of a cut: 2c for the smaller label of crossing c and 2c + 1 for the larger one, then three for each triple point.
pub(super) struct Sides<'a> {
    pub problem: &'a Problem,
    pub cut: &'a Cut,
    pub labels: &'a [u32],
    /// Half the length of the segments at each crossing.
    pub dual_lengths: Vec<f64>,
}

/// Fluxes and gradients at the sides and crossings of a cut.
pub(super) struct Fluxes {
    /// ∂u/∂n at the sides, n out of the side's own patch.
    pub flux: Vec<f64>,
    /// ∂p/∂n at the sides.
    pub adjoint_flux: Vec<f64>,
    /// What a unit of area costs that a side gains, at the sides: Table 1.
    pub densities: Vec<f64>,
    /// What the cut's length costs where the smaller label gains a unit of area, at the crossings: ακ.
    pub tensions: Vec<f64>,
}

impl<'a> Sides<'a> {
    pub fn new(problem: &'a Problem, cut: &'a Cut, labels: &'a [u32]) -> Self {
        let mut dual_lengths = vec![0.0; cut.crossings.len()];
        for segment in &cut.segments {
            for end in segment.ends {
                if let Node::Crossing(c) = end {
                    dual_lengths[c as usize] += 0.5 * segment.length;
                }
            }
        }
        Self { problem, cut, labels, dual_lengths }
    }

    /// Number of sides.
    pub fn count(&self) -> usize {
        2 * self.cut.crossings.len() + 3 * self.cut.centres.len()
    }

    /// The side of a crossing that a label is on.
    pub fn of_crossing(&self, c: u32, label: u32) -> usize {
        2 * c as usize + usize::from(self.cut.crossings[c as usize].labels[0] != label)
    }

    fn of_centre(&self, centre: u32, corner: usize) -> usize {
        2 * self.cut.crossings.len() + 3 * centre as usize + corner
    }

    /// The label of a corner of a face.
    pub fn label(&self, crossed: &CrossedFace, corner: usize) -> u32 {
        self.labels[self.problem.mesh.face_vertices(crossed.face)[corner].index()]
    }

    /// The side at a corner of a sub-triangle that belongs to the patch of corner `own`; `None` for a vertex.
    fn at(&self, crossed: &CrossedFace, own: usize, corner: Corner) -> Option<usize> {
        match corner {
            Corner::Vertex(_) => None,
            Corner::Side(i) => {
                Some(self.of_crossing(crossed.crossings[i], self.label(crossed, own)))
            }
            Corner::Centre => Some(self.of_centre(crossed.centre, own)),
        }
    }

    /// Pieces of rim: the sides at their ends, and their lengths.
    fn rims(&self) -> Vec<([u32; 2], f64)> {
        let mut rims = Vec::with_capacity(2 * self.cut.segments.len());
        for crossed in &self.cut.faces {
            let count = if crossed.lone == 3 { 3 } else { 1 };
            for i in 0..count {
                let segment = &self.cut.segments[crossed.first_segment as usize + i];
                for label in segment.labels {
                    let ends = segment.ends.map(|end| match end {
                        Node::Crossing(c) => self.of_crossing(c, label) as u32,
                        Node::Centre(m) => {
                            let own = (0..3).find(|&k| self.label(crossed, k) == label);
                            self.of_centre(m, own.unwrap_or(0)) as u32
                        }
                    });
                    rims.push((ends, segment.length));
                }
            }
        }
        rims
    }

    /// Normal derivatives of u and p = −q on both sides, and the gradient.
    ///
    /// **Takes** u and q with A q = 2 w_D A_a u + w_H ∫b′(u). **From** [VSC] Table 1, 5.5, 5.6: the density of a side is
    /// −a w_D (∂u/∂n)² − ∂u/∂n ∂p/∂n, which is w_D (∂u/∂n)² where nothing is rescaled and w_H = 0.
    /// **Differs**: the paper divides by dual lengths and smooths next to slivers.
    pub fn fluxes(
        &self,
        weights: &Weights,
        u: &[f64],
        q: &[f64],
        mean_edge: f64,
    ) -> Result<Fluxes, LinalgError> {
        let Self { problem, cut, .. } = *self;
        let mut flux = vec![0.0; self.count()];
        // ∫∂q/∂n φ_c but for its part 2 w_D a ∂u/∂n.
        let mut adjoint_flux = vec![0.0; self.count()];
        let mut scales = vec![0.0; cut.crossings.len()];
        let mut scale_weights = vec![0.0; cut.crossings.len()];
        let mut centre_scales = vec![1.0; cut.centres.len()];
        for crossed in &cut.faces {
            let f = crossed.face;
            let vertices = problem.mesh.face_vertices(f);
            let points = cut.face_points(&problem.mesh, &problem.frames, crossed);
            let values = |field: &[f64], triangle: [Corner; 3]| {
                triangle.map(|corner| match corner {
                    Corner::Vertex(i) => field[vertices[i].index()],
                    _ => 0.0,
                })
            };
            let a = scale(problem, weights, f);
            for (triangle, _) in points.triangles(crossed.lone) {
                let element = Element::new(&points, triangle);
                let (u, q) = (values(u, triangle), values(q, triangle));
                for (i, side) in self.of_triangle(crossed, triangle).into_iter().enumerate() {
                    let Some(side) = side else { continue };
                    for j in 0..3 {
                        let stiffness = element.stiffness(i, j);
                        flux[side] += stiffness * u[j];
                        adjoint_flux[side] +=
                            stiffness * (q[j] - 2.0 * weights.dirichlet * a * u[j]);
                    }
                }
            }
            for (triangle, weight) in points.weighted_triangles(crossed.lone) {
                let area = weight * points.area(triangle);
                let slopes = pointwise_slopes(weights, values(u, triangle));
                let label = self.label(crossed, own_corner(triangle));
                let share = source(problem, weights, f, label) * area / 3.0;
                for (i, side) in self.of_triangle(crossed, triangle).into_iter().enumerate() {
                    let Some(side) = side else { continue };
                    flux[side] += share;
                    adjoint_flux[side] -= weights.hencky * area * slopes[i];
                }
            }
            let count = if crossed.lone == 3 { 3 } else { 1 };
            for s in crossed.first_segment..crossed.first_segment + count {
                let segment = &cut.segments[s as usize];
                for end in segment.ends {
                    match end {
                        Node::Crossing(c) => {
                            scales[c as usize] += segment.length * a;
                            scale_weights[c as usize] += segment.length;
                        }
                        Node::Centre(m) => centre_scales[m as usize] = a,
                    }
                }
            }
        }
        for (scale, weight) in scales.iter_mut().zip(&scale_weights) {
            *scale /= weight.max(1e-300);
        }
        let scale_at = |side: usize| match side.checked_sub(2 * scales.len()) {
            Some(i) => centre_scales[i / 3],
            None => scales[side / 2],
        };
        for (side, r) in flux.iter().enumerate() {
            adjoint_flux[side] += 2.0 * weights.dirichlet * scale_at(side) * r;
            // p = −q.
            adjoint_flux[side] = -adjoint_flux[side];
        }
        let mut smoothing = Smoothing::new(self.count(), &self.rims(), mean_edge)?;
        smoothing.apply(&mut flux);
        smoothing.apply(&mut adjoint_flux);
        let mut densities: Vec<f64> = (0..self.count())
            .map(|side| {
                let (v, w) = (flux[side], adjoint_flux[side]);
                -weights.dirichlet * scale_at(side) * v * v - v * w
            })
            .collect();
        for (c, crossing) in cut.crossings.iter().enumerate() {
            for (s, label) in crossing.labels.into_iter().enumerate() {
                densities[2 * c + s] -= reward(weights, label);
            }
        }
        let tensions = self.tensions(weights, mean_edge)?;
        Ok(Fluxes { flux, adjoint_flux, densities, tensions })
    }

    /// The sides at the corners of a sub-triangle.
    pub fn of_triangle(&self, crossed: &CrossedFace, triangle: [Corner; 3]) -> [Option<usize>; 3] {
        let own = own_corner(triangle);
        triangle.map(|corner| self.at(crossed, own, corner))
    }

    /// ακ: how the price of the length, smoothed along the cut, grows where the cut moves towards the larger label.
    ///
    /// The two faces of a crossed edge are unfolded into one plane; a segment pulls at its end along itself.
    fn tensions(&self, weights: &Weights, mean_edge: f64) -> Result<Vec<f64>, LinalgError> {
        let Self { problem, cut, .. } = *self;
        let count = cut.crossings.len();
        let mut pulls = vec![Vector2::zeros(); count];
        let mut normals = vec![Vector2::zeros(); count];
        let mut tensions = vec![0.0; count];
        let mut pieces = Vec::with_capacity(cut.segments.len());
        for crossed in &cut.faces {
            let points = cut.face_points(&problem.mesh, &problem.frames, crossed);
            let halfedges = problem.mesh.face_halfedges(crossed.face);
            let axes = |side: usize| axes(halfedges[side], &points.corners, side);
            let segments = if crossed.lone == 3 { 3 } else { 1 };
            for s in crossed.first_segment..crossed.first_segment + segments {
                let segment = &cut.segments[s as usize];
                let place = |end: Node| match end {
                    Node::Crossing(c) => crossed
                        .crossings
                        .iter()
                        .position(|&x| x == c)
                        .map_or(points.centre, |i| points.sides[i]),
                    Node::Centre(_) => points.centre,
                };
                let price = length_price(problem, weights, crossed.face);
                let sliding = 0.5
                    * segment.length
                    * price_slope(problem, weights, crossed.face).dot(&segment.normal);
                for (end, other) in [(0, 1), (1, 0)] {
                    let Node::Crossing(c) = segment.ends[end] else { continue };
                    let Some(side) = crossed.crossings.iter().position(|&x| x == c) else {
                        continue;
                    };
                    let (along, across) = axes(side);
                    let unfold = |d: Vector2<f64>| Vector2::new(d.dot(&along), d.dot(&across));
                    let away = place(segment.ends[other]) - place(segment.ends[end]);
                    pulls[c as usize] += unfold(away) / segment.length.max(1e-300) * price;
                    normals[c as usize] += unfold(segment.normal);
                    tensions[c as usize] += sliding;
                }
                match segment.ends {
                    [Node::Crossing(a), Node::Crossing(b)] => {
                        pieces.push(([a, b], segment.length));
                    }
                    [Node::Crossing(a), _] | [_, Node::Crossing(a)] => {
                        pieces.push(([a, a], segment.length));
                    }
                    _ => {}
                }
            }
        }
        for (tension, (pull, normal)) in tensions.iter_mut().zip(pulls.iter().zip(&normals)) {
            *tension -= normal.try_normalize(1e-300).map_or(0.0, |normal| pull.dot(&normal));
        }
        Smoothing::new(count, &pieces, CURVATURE_WIDTH * mean_edge)?.apply(&mut tensions);
        Ok(tensions)
    }
}

/// The corner of the face whose patch a sub-triangle belongs to: it always has one.
fn own_corner(triangle: [Corner; 3]) -> usize {
    let vertex = |corner: &Corner| match corner {
        Corner::Vertex(i) => Some(*i),
        _ => None,
    };
    triangle.iter().find_map(vertex).unwrap_or(0)
}

/// Direction of an edge from its tail to its tip in the frame of one of its faces, and the normal that is the same in the
/// frames of both.
fn axes(h: HalfedgeId, corners: &[Vector2<f64>; 3], side: usize) -> (Vector2<f64>, Vector2<f64>) {
    let own = (corners[(side + 1) % 3] - corners[side]).normalize();
    let along = if h.0 & 1 == 0 { own } else { -own };
    (along, Vector2::new(-along.y, along.x))
}

/// Curvature is smoothed over so many mean edges: a second derivative of a piecewise straight curve has errors of the size of
/// itself, of 3 % after a width of one edge and of 1 % after this.
const CURVATURE_WIDTH: f64 = 2.0;

/// Pieces shorter than this (in widths) tie their ends together firmly enough; shorter ones would only cost digits.
const SHORTEST: f64 = 1e-3;

/// (M_lump + width² L_1D)⁻¹ on curves.
struct Smoothing {
    factor: Factor,
}

impl Smoothing {
    /// **Takes** pieces of curve by the numbers of their ends; a piece that ends in nothing names its end twice.
    fn new(count: usize, pieces: &[([u32; 2], f64)], width: f64) -> Result<Self, LinalgError> {
        let pairs: Vec<[u32; 2]> =
            pieces.iter().map(|piece| piece.0).filter(|[a, b]| a != b).collect();
        let (pattern, slots) = Pattern::new(count, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        let mut next_slot = slots.iter();
        for &([a, b], length) in pieces {
            let ends = [a, b].map(|end| pattern.diagonal(end as usize));
            if a == b {
                values[ends[0]] += 0.5 * length;
                continue;
            }
            let stiffness = width * width / length.max(SHORTEST * width);
            for end in ends {
                values[end] += 0.5 * length + stiffness;
            }
            if let Some(&slot) = next_slot.next() {
                values[slot as usize] -= stiffness;
            }
        }
        for i in 0..count {
            // Nodes without any length about them keep what they have.
            let diagonal = &mut values[pattern.diagonal(i)];
            *diagonal += 1e-12 * width;
        }
        Ok(Self { factor: Factor::new(Arc::new(Analysis::new(pattern)?), &values)? })
    }

    fn apply(&mut self, integrated: &mut [f64]) {
        if !integrated.is_empty() {
            self.factor.solve(integrated, 1);
        }
    }
}
