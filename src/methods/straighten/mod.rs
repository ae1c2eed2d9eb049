//! Smooth outlines: the curves of a cut made straight, or moved onto edges of the mesh.
//!
//! A cut is a network of curves on a surface. Between its junctions a curve is told by the edges of the mesh that it crosses, in
//! order, and where: p₀ p₁ … pₙ with pᵢ = (1 − tᵢ) tail + tᵢ tip. Its length Σ |pᵢ₊₁ − pᵢ| is convex in t, the two faces beside an edge laid out flat. Two kinds
//! of curves are told apart:
//!
//! * *Free* curves were added to make disks, along edges. They become geodesics: crossings slide until the curve is straight, and
//!   the sequence of edges changes where the curve is shorter on the other side of a vertex (its angle there is below π). Their ends
//!   slide along the boundary and along other curves, which they meet at right angles; their junctions move from face to face to where the arms
//!   balance, at 120° for three.
//! * *Held* curves are where a flow wants them. They only lose what is short: minimised is Σ |pᵢ₊₁ − pᵢ| + Σ mᵢ/(2 s²) |pᵢ − aᵢ|², which
//!   damps waves shorter than 2π s; aᵢ is the old place, and once more with what the first time took away added to it, so that
//!   bends of radius R move by s⁴/R³ instead of s²/R. No point goes farther than a bound.
//!
//! Guaranteed: the curves are moved without crossing each other or a vertex that is fixed, so patches keep their shapes (checked at
//! the end, and the old cut is given back where they did not); every triangle has an area; the mesh's vertices come first;
//! the same input gives the same cut. Not guaranteed: the shortest network; a junction of four arms does not split into two.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

mod build;
mod flat;
mod hop;
mod lay;
mod network;
mod refine;
mod relax;
mod snap;

use self::flat::Place;
use self::network::Network;
use crate::geometry::Geometry;
use crate::mesh::{CutMesh, Mesh, MeshError};

pub use lay::cut_along;
pub use snap::{Snapped, snap_to_edges};

/// What [`straighten`] may do.
#[derive(Clone, Debug, PartialEq)]
pub struct StraightenParams {
    /// Index into [`CutMesh::cut_edges`] from which on curves are free.
    pub free_from: usize,
    /// How far points of held curves may move, in mean edge lengths.
    pub reach: f64,
    /// The length s that held curves are smoothed over, in mean edge lengths. 1 leaves a wave of the mesh in the outlines, 4 rounds
    /// corners that the flow means.
    pub smoothing: f64,
    /// Cuts along mesh edges stay there if the faces beside turn by more than this, radians.
    pub feature_angle: f64,
}

impl Default for StraightenParams {
    fn default() -> Self {
        Self {
            free_from: usize::MAX,
            reach: 0.5,
            smoothing: 1.5,
            feature_angle: 40f64.to_radians(),
        }
    }
}

/// Why a cut was left as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unchanged {
    /// There is no cut.
    #[error("there is no cut to straighten")]
    NoCut,
    /// Points lie so close together, or cut edges where no edges are, that curves cannot be told apart.
    #[error("the cut runs through points too close together to be straightened")]
    TooClose,
    /// A face could not be divided along the new curves into triangles with area.
    #[error("a face could not be divided along the straightened cut")]
    Undivided,
    /// Patches would have changed.
    #[error("straightening would have changed the number or the shape of the patches")]
    Reshaped,
}

/// A cut after [`straighten`].
#[derive(Clone, Debug)]
pub struct Straightened {
    /// The refined mesh; held cut edges first, then free ones.
    pub cut: CutMesh,
    /// Index of the first free cut edge.
    pub free_from: usize,
    /// Length of all cuts before and after.
    pub lengths: [f64; 2],
    /// Why it is the given one, if it is.
    pub unchanged: Option<Unchanged>,
}

/// Rounds of passing vertices at most. A curve moves by about an edge in each; rounds end when nothing is gained.
const ROUNDS: usize = 300;

/// Sweeps in a round, and how far crossings overshoot in them: relaxation of a string of n points takes about n sweeps
/// instead of n².
const SWEEPS: usize = 12;
const OVER: f64 = 1.7;

/// Rounds end when the free curves lose less than this share of their length in each of [`PATIENCE`] rounds.
const SETTLED: f64 = 1e-7;
const PATIENCE: usize = 4;

/// Straightens the curves of a cut.
///
/// **Takes** a surface with its geometry, a refinement of it along a cut, and for each vertex how strongly it is pinned: curves
/// through vertices with a positive pin keep them (empty for none). Curves that end inside a patch keep their ends.
/// **Gives** a refinement along curves that are homotopic to the given ones, or the given one and why.
/// **Fails** if the given triangles are no manifold. **Costs** O(F) and about 10 ms for each thousand crossings and hundred
/// rounds. **Differs** from shortening by edge flips (Sharp, Crane: *You Can Find Geodesic Paths in Triangle Meshes by Just Flipping Edges*,
/// 2020) in that junctions and ends move and several curves share an edge.
pub fn straighten(
    mesh: &Mesh,
    geometry: &Geometry,
    cut: &CutMesh,
    params: &StraightenParams,
    pins: &[f64],
) -> Result<Straightened, MeshError> {
    let before = length(mesh, geometry, cut);
    let unchanged = |reason| Straightened {
        cut: cut.clone(),
        free_from: params.free_from.min(cut.cut_edges.len()),
        lengths: [before; 2],
        unchanged: Some(reason),
    };
    if cut.cut_edges.is_empty() {
        return Ok(unchanged(Unchanged::NoCut));
    }
    let Some(mut net) = build::build(mesh, geometry, cut, params, pins) else {
        return Ok(unchanged(Unchanged::TooClose));
    };
    hop::simplify(&mut net);
    smooth_held(&mut net, params.smoothing * geometry.mean_edge_length());
    straighten_free(&mut net);
    let Some((straight, free_from)) = refine::refine(&mut net) else {
        return Ok(unchanged(Unchanged::Undivided));
    };
    if shapes(&straight).ok() != Some(shapes(cut)?) {
        return Ok(unchanged(Unchanged::Reshaped));
    }
    let after = length(mesh, geometry, &straight);
    Ok(Straightened { cut: straight, free_from, lengths: [before, after], unchanged: None })
}

/// Euler characteristics and numbers of boundary loops of all patches, sorted.
fn shapes(cut: &CutMesh) -> Result<Vec<(i64, usize)>, MeshError> {
    let mut shapes = cut.open()?.patch_shapes();
    shapes.sort_unstable();
    Ok(shapes)
}

/// Length of a cut, in the unit of the positions.
pub fn length(mesh: &Mesh, geometry: &Geometry, cut: &CutMesh) -> f64 {
    let at = |p: u32| geometry.locate(mesh, cut.points[p as usize]);
    cut.cut_edges.iter().map(|&[a, b]| (at(b) - at(a)).norm()).sum()
}

/// Smooths the curves that stay near their place.
fn smooth_held(net: &mut Network, scale: f64) {
    if !net.segments.iter().any(|s| s.is_alive && !s.is_free) || !(scale > 0.0) {
        return;
    }
    for n in 0..net.nodes.len() {
        net.nodes[n].anchor = net.nodes[n].anchor.map(|mut anchor| {
            anchor.stiffness = stiffness(net, n, scale);
            anchor
        });
    }
    for time in 0..2 {
        for round in 0..6 {
            for _ in 0..10 {
                relax::sweep(net, 1.3);
            }
            if time == 0 && round < 4 && hop::pass_vertices(net) > 0 {
                hop::simplify(net);
            }
        }
        if time == 0 {
            for node in net.nodes.iter_mut().filter(|n| n.is_alive) {
                if let (Place::Edge(_, t), Some(anchor)) = (node.place, &mut node.anchor) {
                    anchor.target += anchor.target - t;
                }
            }
        }
    }
}

/// How strongly a crossing is held: by the length that it stands for, and by how much it moves across the curve.
fn stiffness(net: &Network, node: usize, scale: f64) -> f64 {
    let Place::Edge(e, _) = net.nodes[node].place else { return 0.0 };
    let arms = &net.nodes[node].arms;
    let (mut mass, mut slant) = (0.0, 0.0);
    for &arm in arms {
        let other = net.place(net.other_end(arm, node as u32));
        let face = net.segments[arm as usize].face;
        let own = net.flat.beside(face, e, net.nodes[node].place)[0];
        let [x, y] = net.flat.beside(face, e, other);
        let length = (x - own).hypot(y);
        mass += 0.5 * length;
        slant += y / length.max(1e-300) / arms.len() as f64;
    }
    mass * (slant * slant).max(0.05) / (scale * scale)
}

/// Makes the free curves geodesics.
fn straighten_free(net: &mut Network) {
    if !net.segments.iter().any(|s| s.is_alive && s.is_free) {
        return;
    }
    let mut length = net.length(true);
    let mut idle = 0;
    for _ in 0..ROUNDS {
        for _ in 0..SWEEPS {
            relax::sweep(net, OVER);
        }
        hop::pass_vertices(net);
        hop::simplify(net);
        let new = net.length(true);
        // Passes without gain are a curve through a vertex that rounding sends to and fro.
        idle = if new > length * (1.0 - SETTLED) { idle + 1 } else { 0 };
        length = new;
        if idle == PATIENCE {
            break;
        }
    }
    for _ in 0..2 * SWEEPS {
        relax::sweep(net, 1.0);
    }
    hop::simplify(net);
}

/// A cut made ready for patterns: flows' curves without zigzag, disk cuts straight.
///
/// **Takes** a cut whose edges from `free_from` on were added by [`super::cutgraph::cut_to_disks`], and the pins of
/// [`straighten`]. **Gives** its result, which is the given cut where straightening refuses. **Fails**, **Costs**: as [`straighten`].
pub fn finish_cut(
    mesh: &Mesh,
    geometry: &Geometry,
    cut: &CutMesh,
    free_from: usize,
    params: &StraightenParams,
    pins: &[f64],
) -> Result<Straightened, MeshError> {
    straighten(mesh, geometry, cut, &StraightenParams { free_from, ..params.clone() }, pins)
}
