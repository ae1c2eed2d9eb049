//! Sweeps: each crossing slides to where its curve is straight, each junction to where its arms balance.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Matrix2, Vector2};

use super::flat::Place;
use super::hop;
use super::network::Network;
use crate::mesh::EdgeId;

/// Crossings keep this distance from vertices and from each other, as a fraction of the edge, where there is room. Smaller gaps
/// make needles of the triangles beside them; larger ones bend curves that pass vertices visibly.
pub(super) const GAP: f64 = 1e-3;

/// Junctions keep this distance from the sides of their face, in barycentric coordinates.
const INSET: f64 = 1e-3;

/// The same for junctions that may not leave their face: nearer they only make needles of the triangles around.
const HELD_INSET: f64 = 0.03;

/// How much a free curve pulls at a junction against one that stays near its place: where the first ends at the second it
/// bends it by this angle, a degree.
const FREE_PULL: f64 = 0.02;

/// One pass over all nodes. **Takes** how far crossings go beyond their place of balance, 1 not at all. **Gives** whether a
/// junction changed its face.
pub(super) fn sweep(net: &mut Network, over: f64) -> bool {
    let mut has_hopped = false;
    for node in 0..net.nodes.len() {
        let n = &net.nodes[node];
        if !n.is_alive || n.is_fixed {
            continue;
        }
        match n.place {
            Place::Vertex(_) => {}
            Place::Edge(e, t) => slide(net, node, e, t, over),
            Place::Face(..) => has_hopped |= balance(net, node),
        }
    }
    has_hopped
}

/// Where a crossing may go.
fn bounds(net: &Network, node: usize, e: EdgeId) -> [f64; 2] {
    let [low, high] = net.gap_around(node as u32);
    let gap = GAP.min(0.25 * (high - low));
    let (mut low, mut high) = (low + gap, high - gap);
    if let Some(anchor) = net.nodes[node].anchor {
        let reach = anchor.reach / net.flat.length(e);
        low = low.max(anchor.origin - reach);
        high = high.min(anchor.origin + reach);
    }
    [low, high]
}

fn slide(net: &mut Network, node: usize, e: EdgeId, t: f64, over: f64) {
    let [low, high] = bounds(net, node, e);
    if !(low < high) {
        return;
    }
    let length = net.flat.length(e);
    let beside = |arm: u32| {
        let other = net.other_end(arm, node as u32);
        net.flat.beside(net.segments[arm as usize].face, e, net.place(other))
    };
    let (best, is_end) = match net.nodes[node].arms[..] {
        [arm] => (beside(arm)[0], true),
        [arm, other] => {
            let (p, q) = (beside(arm), beside(other));
            let anchor = net.nodes[node].anchor.filter(|a| a.stiffness > 0.0);
            if let Some(a) = anchor {
                let range = [low * length, high * length];
                (balance_on_edge(p, q, a.stiffness, a.target * length, range), false)
            } else if p[1] + q[1] > 1e-12 * length {
                ((p[0] * q[1] + q[0] * p[1]) / (p[1] + q[1]), false)
            } else {
                return;
            }
        }
        _ => return,
    };
    // Ends have nothing behind them that over-shooting would help.
    let over = if is_end { 1.0 } else { over };
    let new = (t + over * (best / length - t)).clamp(low, high);
    if !new.is_finite() {
        return;
    }
    net.set_t(node as u32, new);
    if !net.is_clean_at(node as u32) {
        net.set_t(node as u32, t);
    }
}

/// The minimiser of |x − p| + |x − q| + k/2 (x − target)² on a line, by Newton's method kept in a bracket.
fn balance_on_edge(p: [f64; 2], q: [f64; 2], k: f64, target: f64, range: [f64; 2]) -> f64 {
    let slope = |x: f64| {
        let (mut g, mut h) = (k * (x - target), k);
        for [px, py] in [p, q] {
            let d = (x - px).hypot(py).max(1e-300);
            g += (x - px) / d;
            h += py * py / (d * d * d);
        }
        (g, h)
    };
    let [mut low, mut high] = range;
    if slope(low).0 >= 0.0 {
        return low;
    }
    if slope(high).0 <= 0.0 {
        return high;
    }
    let mut x = target.clamp(low, high);
    for _ in 0..30 {
        let (g, h) = slope(x);
        if g > 0.0 {
            high = x
        } else {
            low = x
        }
        let newton = x - g / h;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 1e-12 * (range[1] - range[0]) {
            return next;
        }
        x = next;
    }
    x
}

/// Moves a junction by a step of Newton's method, into the next face if it leads there. **Gives** whether it did.
fn balance(net: &mut Network, node: usize) -> bool {
    let Place::Face(f, x) = net.nodes[node].place else { return false };
    let arms: Vec<(Vector2<f64>, f64)> = net.nodes[node]
        .arms
        .iter()
        .map(|&arm| {
            let other = net.other_end(arm, node as u32);
            let pull = if net.segments[arm as usize].is_free { FREE_PULL } else { 1.0 };
            (net.flat.at(f, net.place(other)), pull)
        })
        .collect();
    if arms.len() < 2 {
        return false;
    }
    let size = net.flat.mesh.face_halfedges(f).map(|h| net.flat.length(h.edge()));
    let size = size.into_iter().fold(0.0, f64::max);
    let Some(step) = newton_step(x, &arms, size) else { return false };

    let (from, to) = (net.flat.weights(f, x), net.flat.weights(f, x + step));
    let held = arms.iter().filter(|a| a.1 > FREE_PULL).count();
    let stays = held > 2 && net.nodes[node].hops >= hop::HELD_HOPS;
    let inset = if stays { HELD_INSET } else { INSET };
    // How much of the step stays inside, and the side that ends it.
    let (mut share, mut exit) = (1.0, None);
    for i in 0..3 {
        if to[i] < inset && to[i] < from[i] {
            let s = ((from[i] - inset) / (from[i] - to[i])).max(0.0);
            if s < share {
                (share, exit) = (s, Some((i + 1) % 3));
            }
        }
    }
    if let Some(side) = exit {
        let e = net.flat.mesh.face_halfedges(f)[side].edge();
        let [along, _] = net.flat.beside(f, e, Place::Face(f, x + step * share));
        if hop::cross_edge(net, node as u32, e, along / net.flat.length(e)) {
            return true;
        }
    }
    let energy = |x: Vector2<f64>| arms.iter().map(|(p, w)| (x - p).norm() * w).sum::<f64>();
    let before = energy(x);
    for _ in 0..4 {
        let new = x + step * share;
        if energy(new) < before {
            net.nodes[node].place = Place::Face(f, new);
            if net.is_clean_at(node as u32) {
                return false;
            }
            net.nodes[node].place = Place::Face(f, x);
        }
        share *= 0.4;
    }
    false
}

/// A step towards the minimiser of the weighted sum of distances, at most a fraction of `size` long.
fn newton_step(x: Vector2<f64>, arms: &[(Vector2<f64>, f64)], size: f64) -> Option<Vector2<f64>> {
    let mut gradient = Vector2::zeros();
    let mut hessian = Matrix2::zeros();
    for &(p, w) in arms {
        let d = x - p;
        // At an arm's end the sum has a kink; near it the step must stay small.
        let norm = d.norm().max(1e-6 * size);
        gradient += d * (w / norm);
        let n = d / norm;
        hessian += (Matrix2::identity() - n * n.transpose()) * (w / norm);
    }
    hessian += Matrix2::identity() * (1e-9 * hessian.trace());
    let step = -(hessian.try_inverse()? * gradient);
    let norm = step.norm();
    if !norm.is_finite() {
        return None;
    }
    let longest = 0.3 * size;
    Some(if norm > longest { step * (longest / norm) } else { step })
}
