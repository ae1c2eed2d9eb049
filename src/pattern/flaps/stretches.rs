//! Seams cut into nearly straight stretches, the same on both sides.

use std::collections::BTreeSet;

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
    let kept = split(n + 1, |i, j| {
        let middle = 0.5 * (i + j) as f64;
        let central = |k: &usize| ((*k as f64 - middle).abs(), *k);
        let by_centre = |a: &usize, b: &usize| {
            let (a, b) = (central(a), central(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        };
        (i + 1..j).filter(|&k| is_end(k)).min_by(by_centre).or_else(|| {
            let apart = |k: usize| {
                let from_chord =
                    |points: &[[f64; 2]]| squared_distance(points[k], points[i], points[j]).sqrt();
                lines.iter().map(|(points, _)| from_chord(points)).fold(0.0, f64::max)
            };
            (i + 1..j)
                .map(|k| (apart(k), k))
                .filter(|(d, _)| *d > params.tolerance_mm)
                .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))
                .map(|(_, k)| k)
        })
    });
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
