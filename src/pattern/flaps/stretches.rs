//! Seams cut into nearly straight stretches, the same on both sides.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use super::shape::turn_left;
use super::{Base, FlapParams};
use crate::mesh::VertexId;
use crate::pattern::folds::{Fold, split};
use crate::pattern::laid::LaidSurface;
use crate::pattern::piece::{Pattern, length, squared_distance};
use crate::pattern::seam::Partner;

/// A seam with both its sides.
pub(super) struct Joint {
    /// Number of the seam.
    pub number: usize,
    /// The patches on its two sides.
    pub patches: [usize; 2],
    /// Along the side met first.
    pub stretches: Vec<Stretch>,
}

/// A stretch of a seam.
pub(super) struct Stretch {
    /// The part of the outline on the side met first, and on the other one. The latter runs backwards.
    pub bases: [Option<Base>; 2],
    /// The shorter of its two chords.
    pub length_mm: f64,
    /// By how much the surface turns there.
    pub angle: f64,
}

/// All seams, by number.
pub(super) fn joints(
    surface: &LaidSurface,
    pattern: &Pattern,
    folds: &[Vec<Fold>],
    params: &FlapParams,
) -> Vec<Joint> {
    let strong = folds.iter().flatten().filter(|fold| fold.angle.abs() > params.fold_angle);
    let ends: BTreeSet<VertexId> = strong
        .flat_map(|f| f.vertices.first().into_iter().chain(f.vertices.last()))
        .copied()
        .collect();
    let mut joints = Vec::new();
    for (p, piece) in pattern.pieces.iter().enumerate() {
        let turns = surface.seam_turns(piece);
        for (s, turns) in turns.iter().enumerate() {
            let across = pattern.across(p, s);
            // Each seam once: from the side met first, or from the only one that there is.
            if piece.seams[s].is_second && across.is_some() {
                continue;
            }
            joints.push(joint(pattern, (p, s), across, turns, &ends, params));
        }
    }
    joints.sort_by_key(|joint| joint.number);
    joints
}

fn joint(
    pattern: &Pattern,
    (p, s): (usize, usize),
    across: Option<(usize, usize)>,
    turns: &[f64],
    ends: &BTreeSet<VertexId>,
    params: &FlapParams,
) -> Joint {
    let seam = &pattern.pieces[p].seams[s];
    let n = seam.sides;
    // Points and vertices of both sides in the direction of the first.
    let line = |(p, s): (usize, usize), is_back: bool| {
        let piece = &pattern.pieces[p];
        let seam = &piece.seams[s];
        let outline = &piece.outlines[seam.outline];
        let mut points = piece.seam_points(seam);
        let count = outline.vertices.len();
        let mut vertices: Vec<VertexId> =
            (0..=seam.sides).map(|i| outline.vertices[(seam.first + i) % count]).collect();
        if is_back {
            points.reverse();
            vertices.reverse();
        }
        (points, vertices)
    };
    let mut lines = vec![line((p, s), false)];
    // Both sides of a seam have the same points of the surface.
    lines.extend(across.map(|side| line(side, true)).filter(|(points, _)| points.len() == n + 1));
    let is_end = |i: usize| lines.iter().any(|(_, vertices)| ends.contains(&vertices[i]));
    let kept = divide(&lines, is_end, params.tolerance_mm);
    let stretch = |w: &[usize]| {
        let (from, to) = (w[0], w[1]);
        let base = |(p, s): (usize, usize), first: usize| {
            let seam = &pattern.pieces[p].seams[s];
            let count = pattern.pieces[p].outlines[seam.outline].points.len();
            let first = (seam.first + first) % count;
            Base { piece: p, seam: s, outline: seam.outline, first, sides: to - from }
        };
        let chord = |points: &[[f64; 2]]| length(&[points[from], points[to]]);
        let lengths = lines.iter().map(|(points, _)| chord(points));
        let weights = (from..to).map(|i| length(&lines[0].0[i..=i + 1])).collect::<Vec<f64>>();
        let total: f64 = weights.iter().sum();
        let angle: f64 =
            weights.iter().zip(&turns[from..to]).map(|(w, a)| w * a).sum::<f64>() / total;
        Stretch {
            bases: [Some(base((p, s), from)), across.map(|side| base(side, n - to))],
            length_mm: lengths.fold(f64::INFINITY, f64::min),
            angle: if angle.is_finite() { angle } else { 0.0 },
        }
    };
    let own = pattern.pieces[p].patch;
    let other = match seam.partner {
        Partner::Patch(patch) => patch,
        Partner::Own { .. } => own,
    };
    Joint {
        number: seam.number,
        patches: [own, other],
        stretches: kept.windows(2).map(stretch).collect(),
    }
}

/// One side of a seam: places and vertices.
type Side = (Vec<[f64; 2]>, Vec<VertexId>);

/// Chords that meet at a sharper angle meet in a corner, radians.
const CORNER: f64 = 0.5;

/// Indices of the points of a seam where stretches end: at the ends of folds, at corners, and in between so that no side runs farther
/// beside its chord than the tolerance, if possible in equal parts.
fn divide(lines: &[Side], is_end: impl Fn(usize) -> bool, tolerance: f64) -> Vec<usize> {
    let n = lines[0].0.len();
    // The point of a stretch that is farthest from a chord.
    let farthest = |i: usize, j: usize| {
        let apart = |k: usize| {
            let from_chord =
                |(points, _): &Side| squared_distance(points[k], points[i], points[j]).sqrt();
            lines.iter().map(from_chord).fold(0.0, f64::max)
        };
        let by_distance =
            |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1));
        (i + 1..j).map(|k| (apart(k), k)).max_by(by_distance)
    };
    let kept = split(n, |i, j| {
        let central = |k: &usize| (2 * k).abs_diff(i + j);
        let ends = (i + 1..j).filter(|&k| is_end(k)).min_by_key(central);
        ends.or_else(|| farthest(i, j).filter(|&(d, _)| d > tolerance).map(|(_, k)| k))
    });
    let is_corner = |w: &[usize]| {
        is_end(w[1])
            || lines.iter().any(|(points, _)| {
                let [a, b, c] = [w[0], w[1], w[2]].map(|i| points[i]);
                let turn = turn_left([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
                turn.min(TAU - turn) > CORNER
            })
    };
    let mut fixed = vec![0];
    fixed.extend((1..kept.len() - 1).filter(|&k| is_corner(&kept[k - 1..=k + 1])));
    fixed.push(kept.len() - 1);
    let mut result = vec![0];
    for section in fixed.windows(2) {
        let own = &kept[section[0]..=section[1]];
        let even = even(&lines[0].0, own[0], own[own.len() - 1], own.len() - 1);
        // Even parts may be a little farther off: they look better.
        let is_near = |w: &[usize]| {
            w[0] < w[1] && farthest(w[0], w[1]).is_none_or(|(d, _)| d <= 1.25 * tolerance)
        };
        let chosen = if even.windows(2).all(is_near) { &even[..] } else { own };
        result.extend(&chosen[1..]);
    }
    result
}

/// Indices from one to another at about equal distances along a line.
fn even(points: &[[f64; 2]], from: usize, to: usize, parts: usize) -> Vec<usize> {
    let total = length(&points[from..=to]);
    let mut indices = vec![from];
    let (mut at, mut arc) = (from, 0.0);
    for part in 1..parts {
        let wanted = total * part as f64 / parts as f64;
        while at < to {
            let step = length(&points[at..=at + 1]);
            if arc + 0.5 * step > wanted {
                break;
            }
            arc += step;
            at += 1;
        }
        indices.push(at);
    }
    indices.push(to);
    indices
}
