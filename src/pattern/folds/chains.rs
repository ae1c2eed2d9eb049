//! Edges to fold lines: at each vertex the edges that go on straightest are joined in pairs.

use super::{Edge, Fold, FoldParams, Frame};
use crate::mesh::VertexId;
use crate::pattern::piece::squared_distance;

/// Joins edges to folds. Each edge is in exactly one.
pub(super) fn join(edges: &[Edge], frame: &Frame, params: &FoldParams) -> Vec<Fold> {
    let next = continuations(edges, frame, params);
    let mut folds = Vec::new();
    let mut is_done = vec![false; edges.len()];
    for seed in 0..edges.len() {
        if is_done[seed] {
            continue;
        }
        // Back to where the line begins, or once around.
        let (mut first, mut from) = (seed, 0);
        while let Some(before) = next[first][from].filter(|&e| e != seed) {
            from = usize::from(edges[before].ends[0] == edges[first].ends[from]);
            first = before;
        }
        let mut vertices = vec![edges[first].ends[from]];
        let (mut edge, mut to) = (first, 1 - from);
        let (mut weight, mut angle) = (0.0, 0.0);
        loop {
            is_done[edge] = true;
            let [p, q] = edges[edge].ends.map(|v| frame.place(v));
            let size = (q[0] - p[0]).hypot(q[1] - p[1]);
            weight += size;
            angle += size * edges[edge].angle;
            let end = edges[edge].ends[to];
            vertices.push(end);
            match next[edge][to] {
                Some(on) if !is_done[on] => {
                    to = usize::from(edges[on].ends[0] == end);
                    edge = on;
                }
                _ => break,
            }
        }
        // An edge without length in the plane has no line.
        let angle = angle / weight;
        let points: Vec<[f64; 2]> = vertices.iter().map(|&v| frame.place(v)).collect();
        if !angle.is_finite() || points.iter().flatten().any(|x| !x.is_finite()) {
            continue;
        }
        let kept = simplified(&points, params.tolerance_mm);
        folds.push(Fold {
            points: kept.iter().map(|&i| points[i]).collect(),
            vertices: kept.iter().map(|&i| vertices[i]).collect(),
            angle,
        });
    }
    folds
}

/// For each edge and each of its ends the edge that the line goes on with.
fn continuations(edges: &[Edge], frame: &Frame, params: &FoldParams) -> Vec<[Option<usize>; 2]> {
    let mut ends: Vec<(VertexId, usize, usize)> = Vec::with_capacity(2 * edges.len());
    for (edge, Edge { ends: [a, b], .. }) in edges.iter().enumerate() {
        ends.extend([(*a, edge, 0), (*b, edge, 1)]);
    }
    ends.sort_unstable();
    let away = |edge: usize, end: usize| {
        let [from, to] = [end, 1 - end].map(|i| frame.place(edges[edge].ends[i]));
        (to[1] - from[1]).atan2(to[0] - from[0])
    };
    let mut next = vec![[None; 2]; edges.len()];
    for here in ends.chunk_by(|s, t| s.0 == t.0) {
        let mut pairs = Vec::new();
        for (k, &(_, e, i)) in here.iter().enumerate() {
            for &(_, f, j) in &here[k + 1..] {
                let (a, b) = (edges[e].angle, edges[f].angle);
                let straight = (away(e, i) - away(f, j)).rem_euclid(std::f64::consts::TAU);
                let bend = (straight - std::f64::consts::PI).abs();
                // Signs differ where the product is negative.
                if a * b > 0.0 && (a - b).abs() <= params.difference && bend <= params.bend {
                    pairs.push((bend, (e, i), (f, j)));
                }
            }
        }
        pairs.sort_by(|s, t| s.0.total_cmp(&t.0).then((s.1, s.2).cmp(&(t.1, t.2))));
        for (_, (e, i), (f, j)) in pairs {
            if next[e][i].is_none() && next[f][j].is_none() {
                next[e][i] = Some(f);
                next[f][j] = Some(e);
            }
        }
    }
    next
}

/// Indices of the points that remain when all others lie within a distance of the line (Douglas and Peucker).
pub(in super::super) fn simplified(points: &[[f64; 2]], tolerance: f64) -> Vec<usize> {
    split(points.len(), |i, j| {
        let far = (i + 1..j).map(|k| (squared_distance(points[k], points[i], points[j]), k));
        let far = far.filter(|&(squared, _)| squared > tolerance * tolerance);
        far.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|(_, k)| k)
    })
}

/// Indices from 0 to `count` − 1 that remain when each gap is split where `worst` says, until it says nothing.
pub(in super::super) fn split(
    count: usize,
    worst: impl Fn(usize, usize) -> Option<usize>,
) -> Vec<usize> {
    let mut kept = vec![0];
    if count < 2 {
        return kept;
    }
    let mut gaps = vec![(0, count - 1)];
    while let Some((i, j)) = gaps.pop() {
        match worst(i, j) {
            Some(k) => gaps.extend([(k, j), (i, k)]),
            None => kept.push(j),
        }
    }
    kept
}
