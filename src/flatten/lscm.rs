//! Conformal maps with natural boundary: least squares (LSCM, two points held) and spectral (no point held).
//!
//! A map is conformal where its conformal energy vanishes, E_C = ½ ∫|∇x|² + ½ ∫|∇y|² − A, with A the area of the image. E_C ≥ 0 for every
//! map, is quadratic in the places, and counts each face's failure to be a similarity. In its Hessian the rows of x and of y hold
//! the cotan Laplacian, and x meets y along the rim only, because areas telescope.
//!
//! *LSCM*: two rim points are held, far apart, and E_C is minimised: one solve. *Natural discrete conformal maps* (DNCP, DCP)
//! minimise the same quadratic form with the same two points held, so they are the same map. *Spectral* (SCP): the two held
//! points are what pulls LSCM out of shape; instead the smallest E_C among maps of unit spread of the rim is sought, an
//! eigenvector problem E_C x = λ B x solved by inverse iteration.
//!
//! Guaranteed: developable patches become isometric charts up to scale, then of their true size; a defective patch costs no other
//! patch its chart. Not guaranteed: freedom from flips (with obtuse angles) and overlaps; equally long seam partners; a size that is even: far from
//! held points LSCM charts of strongly curved patches shrink to nothing.

use nalgebra::{Complex, Point2};

use super::disks::Disks;
use super::{Flattening, small};
use crate::geometry::Geometry;
use crate::linalg::{LinalgError, Pattern};
use crate::mesh::{FaceId, HalfedgeId, OpenedMesh, VertexId};

/// What is added to E_C before it is factored, in units of the spread B: the inverse iteration's shift, which changes how fast it
/// converges and nothing about what it converges to. Much smaller, and rounding in slivers makes the matrix indefinite.
const SHIFT: f64 = 1e-6;

/// The iteration ends when it changes no chart by more than this fraction of its spread: ten digits.
const UNCHANGED: f64 = 1e-10;

/// Solves at most; 4 to 14 were needed where it was measured. Each reduces the error by the ratio of the two smallest eigenvalues.
const SOLVES: usize = 60;

/// Height of a face over its longest side below which its cotangents are those of this height: see [`Geometry::measure`].
const BOUNDED: f64 = 1e-8;

/// Least squares conformal maps of every patch that is a disk.
///
/// **Takes** an opened surface and its measures. **Gives** charts of the area of their patches, in frames of their own,
/// counter-clockwise; u estimated from areas; seam partners are not equally long.
/// **Fails** for lack of memory only; patches that cannot be flattened say so one by one.
/// **Costs** one analysis, one factorisation and one solve of 2 V rows.
/// **From** Lévy et al.: *Least Squares Conformal Maps for Automatic Texture Atlas Generation*, 2002; Desbrun, Meyer, Alliez: *Intrinsic
/// Parameterizations of Surface Meshes*, 2002. **Differs**: the held points halve the rim and, of all pairs that do, lie farthest apart in space.
pub fn lscm(opened: &OpenedMesh, geometry: &Geometry) -> Result<Flattening, LinalgError> {
    let disks = Disks::new(opened, geometry);
    let shares = area_shares(opened, geometry);
    least_squares(disks, &geometry.corner_cotangents, &shares)
}

/// For each face what its cotangents are worth: 1, less for slivers whose cotangents [`Geometry::measure`] bounded. Their areas must
/// count as little, or E_C would be negative for some maps.
fn area_shares(opened: &OpenedMesh, geometry: &Geometry) -> Vec<f64> {
    let share = |f: FaceId| {
        let sides = opened.mesh.face_halfedges(f).map(|h| geometry.edge_length(h.edge()));
        let longest = sides.into_iter().fold(0.0, f64::max);
        (2.0 * geometry.face_areas[f.index()] / (BOUNDED * longest * longest)).min(1.0)
    };
    opened.mesh.faces().map(share).collect()
}

/// Discrete conformal maps with natural boundary of every patch that is a disk, by their spectral form, which holds no point.
///
/// Minimises E_C(x) / xᵀBx over maps whose rim has its centre at the origin; xᵀBx is the mean square of the rim's distance from it.
///
/// **Takes**, **Gives**, **Fails** as [`lscm`]. **Costs** one analysis, one factorisation, and 4 to 14 solves of 2 V rows.
/// **From** Mullen et al.: *Spectral Conformal Parameterization*, 2008. **Differs**: rim vertices count by the length of rim beside them
/// instead of all alike, so that the map does not depend on how finely the rim is divided.
pub fn dcp(opened: &OpenedMesh, geometry: &Geometry) -> Result<Flattening, LinalgError> {
    let mut disks = Disks::new(opened, geometry);
    let n = opened.mesh.vertex_count();
    let shares = area_shares(opened, geometry);
    let energy = ConformalEnergy::new(&disks, &geometry.corner_cotangents, &shares);
    let mut spread = vec![0.0; n];
    let mut places = vec![Complex::new(0.0, 0.0); n];
    for rim in disks.charts.iter().flatten() {
        let length: f64 = rim.iter().map(|h| geometry.edge_length(h.edge())).sum();
        let mut walked = 0.0;
        for &h in rim {
            let side = geometry.edge_length(h.edge()) / length;
            spread[opened.mesh.tail(h).index()] += 0.5 * side;
            spread[opened.mesh.tip(h).index()] += 0.5 * side;
            // A circle to begin with: only the rim enters the first solve.
            places[opened.mesh.tail(h).index()] =
                Complex::from_polar(1.0, std::f64::consts::TAU * walked);
            walked += side;
        }
    }
    let (mut factor, values) = disks.factor(|disks| {
        let (pattern, mut values) = energy.matrix(disks, |_| false);
        for (v, b) in spread.iter().enumerate() {
            values[pattern.diagonal(v)] += SHIFT * b;
            values[pattern.diagonal(n + v)] += SHIFT * b;
        }
        (pattern, values)
    })?;
    let mut residual = 0.0;
    for _ in 0..SOLVES {
        let mut rhs = vec![0.0; 2 * n];
        for v in opened.mesh.vertices().filter(|&v| disks.is_in(v)).map(VertexId::index) {
            rhs[v] = spread[v] * places[v].re;
            rhs[n + v] = spread[v] * places[v].im;
        }
        residual = factor.solve_measured(&values, &mut rhs, 1);
        let mut next: Vec<_> = (0..n).map(|v| Complex::new(rhs[v], rhs[n + v])).collect();
        if normalise(&disks, &spread, &places, &mut next) < UNCHANGED {
            places = next;
            break;
        }
        places = next;
    }
    let uv = places.into_iter().map(|z| Point2::new(z.re, z.im)).collect();
    Ok(disks.finish(uv, residual))
}

/// Takes the means out, turns each chart to where it was and scales it to unit spread. **Gives** the largest change of spread.
fn normalise(
    disks: &Disks,
    spread: &[f64],
    before: &[Complex<f64>],
    places: &mut [Complex<f64>],
) -> f64 {
    let count = disks.charts.len();
    let mut means = vec![Complex::new(0.0, 0.0); count];
    let patch = |v: usize| disks.vertex_patches[v] as usize;
    for v in 0..places.len() {
        means[patch(v)] += places[v] * spread[v];
    }
    let (mut squares, mut turns) = (vec![0.0; count], means.clone());
    turns.fill(Complex::new(0.0, 0.0));
    for v in 0..places.len() {
        places[v] -= means[patch(v)];
        squares[patch(v)] += spread[v] * places[v].norm_sqr();
        turns[patch(v)] += places[v].conj() * before[v] * spread[v];
    }
    let mut changes = vec![0.0; count];
    for v in 0..places.len() {
        let p = patch(v);
        places[v] *= turns[p] / (turns[p].norm() * squares[p].sqrt());
        changes[p] += spread[v] * (places[v] - before[v]).norm_sqr();
    }
    let changed = |p: usize| if disks.charts[p].is_ok() { changes[p] } else { 0.0 };
    (0..count).map(changed).fold(0.0, f64::max).sqrt()
}

/// The map of least conformal energy, with two points of each rim held.
///
/// **Takes** the cotangents of the corners of each face, those of the surface or of other triangles that the chart is to be made of, and the
/// weight of its area that goes with them (1 where the cotangents are a triangle's).
pub(super) fn least_squares(
    mut disks: Disks,
    cotangents: &[[f64; 3]],
    shares: &[f64],
) -> Result<Flattening, LinalgError> {
    let n = disks.opened.mesh.vertex_count();
    let energy = ConformalEnergy::new(&disks, cotangents, shares);
    let mut held = vec![None; n];
    for rim in disks.charts.iter().flatten() {
        if let Some([a, b]) = far_apart(disks.opened, disks.geometry, rim) {
            let length: f64 = rim.iter().map(|h| disks.geometry.edge_length(h.edge())).sum();
            held[a.index()] = Some(Complex::new(0.0, 0.0));
            held[b.index()] = Some(Complex::new(length / 3.0, 0.0));
        }
    }
    let is_held = |v: usize| held[v].is_some();
    let (mut factor, values) = disks.factor(|disks| energy.matrix(disks, is_held))?;
    let mut x = vec![0.0; 2 * n];
    for edge in energy.edges_of(&disks) {
        for (free, other, turn) in edge.ways() {
            if let (None, Some(z)) = (held[free], held[other]) {
                x[free] += edge.weight * z.re + 0.5 * turn * z.im;
                x[n + free] += edge.weight * z.im - 0.5 * turn * z.re;
            }
        }
    }
    for v in 0..n {
        if let Some(z) = held[v] {
            (x[v], x[n + v]) = (z.re, z.im);
        }
    }
    let residual = factor.solve_measured(&values, &mut x, 1);
    let uv = (0..n).map(|v| Point2::new(x[v], x[n + v])).collect();
    Ok(disks.finish(uv, residual))
}

/// Two rim vertices with half of the rim between them, the pair that is farthest apart in space.
fn far_apart(
    opened: &OpenedMesh,
    geometry: &Geometry,
    rim: &[HalfedgeId],
) -> Option<[VertexId; 2]> {
    let lengths: Vec<f64> = rim.iter().map(|h| geometry.edge_length(h.edge())).collect();
    let half = 0.5 * lengths.iter().sum::<f64>();
    let (mut ahead, mut between) = (0, 0.0);
    let mut best: Option<(f64, [VertexId; 2])> = None;
    for i in 0..rim.len() {
        // `ahead` never falls behind i: the way between is positive while it is half of the rim.
        while between < half && ahead < i + rim.len() - 1 {
            between += lengths[ahead % rim.len()];
            ahead += 1;
        }
        let pair = [i, ahead % rim.len()].map(|k| opened.mesh.tail(rim[k]));
        let distance =
            (geometry.positions[pair[0].index()] - geometry.positions[pair[1].index()]).norm();
        if pair[0] != pair[1] && best.is_none_or(|(d, _)| distance > d) {
            best = Some((distance, pair));
        }
        between -= lengths[i];
    }
    best.map(|(_, pair)| pair)
}

/// One edge of the conformal energy: weight of the Laplacian, and by how much the areas to its left and right differ in weight.
#[derive(Clone, Copy)]
struct Edge {
    ends: [usize; 2],
    weight: f64,
    turn: f64,
}

impl Edge {
    /// The edge from either end, with the sign of its turn.
    fn ways(&self) -> [(usize, usize, f64); 2] {
        let [a, b] = self.ends;
        [(a, b, self.turn), (b, a, -self.turn)]
    }
}

/// E_C as edges.
struct ConformalEnergy {
    edges: Vec<(u32, Edge)>,
}

impl ConformalEnergy {
    fn new(disks: &Disks, cotangents: &[[f64; 3]], shares: &[f64]) -> Self {
        let mesh = &disks.opened.mesh;
        let (mut weights, mut turns) = (vec![0.0; mesh.edge_count()], vec![0.0; mesh.edge_count()]);
        for f in mesh.faces().filter(|&f| disks.has_face(f)) {
            let share = shares[f.index()];
            for (i, h) in mesh.face_halfedges(f).into_iter().enumerate() {
                weights[h.edge().index()] += 0.5 * cotangents[f.index()][(i + 2) % 3];
                let forward = h == h.edge().halfedge();
                turns[h.edge().index()] += if forward { share } else { -share };
            }
        }
        let edges = mesh
            .edges()
            .map(|e| {
                let [a, b] = mesh.edge_vertices(e);
                let turn = turns[e.index()];
                // What rounding leaves of 1 − 1.
                let turn = if turn.abs() < 1e-12 { 0.0 } else { turn };
                let edge = Edge { ends: [a.index(), b.index()], weight: weights[e.index()], turn };
                (disks.vertex_patches[a.index()], edge)
            })
            .collect();
        Self { edges }
    }

    fn edges_of<'a>(&'a self, disks: &'a Disks) -> impl Iterator<Item = Edge> + 'a {
        self.edges.iter().filter(|(patch, _)| disks.charts[*patch as usize].is_ok()).map(|e| e.1)
    }

    /// The Hessian of E_C: rows of x, then of y. Rows of vertices that are held or have no chart are those of the identity.
    fn matrix(&self, disks: &Disks, is_held: impl Fn(usize) -> bool) -> (Pattern, Vec<f64>) {
        let n = disks.opened.mesh.vertex_count();
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        let mut entries = Vec::new();
        let mut diagonal = vec![0.0; n];
        for edge in self.edges_of(disks) {
            let [a, b] = edge.ends;
            diagonal[a] += edge.weight;
            diagonal[b] += edge.weight;
            if is_held(a) || is_held(b) {
                continue;
            }
            pairs.extend([[a, b], [n + a, n + b]].map(|p| p.map(small)));
            entries.extend([-edge.weight; 2]);
            if edge.turn != 0.0 {
                pairs.extend([[a, n + b], [b, n + a]].map(|p| p.map(small)));
                entries.extend([-0.5 * edge.turn, 0.5 * edge.turn]);
            }
        }
        let (pattern, slots) = Pattern::new(2 * n, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        for (slot, entry) in slots.into_iter().zip(entries) {
            values[slot as usize] += entry;
        }
        for v in 0..n {
            let free = disks.is_in(VertexId::from(v)) && !is_held(v);
            for row in [v, n + v] {
                values[pattern.diagonal(row)] = if free { diagonal[v] } else { 1.0 };
            }
        }
        (pattern, values)
    }
}
