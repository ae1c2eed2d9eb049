//! Darts: seams of a piece with itself that end inside it.
//!
//! The two sides of such a seam, its legs, meet at the tip, with the gap that is sewn shut between them. A wide dart is cut out with
//! allowances that shrink to nothing towards the tip; of a narrow one the cloth stays, folded away when it is sewn, and only its
//! legs and its tip are marked. At the base of a narrow dart the edge is cut as it lies when the dart is folded to one
//! side: a small cap, whose two halves come to lie on the edges beside the dart.

use std::collections::BTreeSet;

use super::strips::Strip;
use crate::pattern::plane::{Walk, along, area, direction, distance, dot, meeting, minus, nearest};
use crate::pattern::{Layer, Line, Partner, Piece};

/// What is left open between the allowances of a dart that is cut out, mm: less cannot be cut with shears.
const OPENING_MM: f64 = 4.0;

/// A seam of a piece with itself whose two sides meet at a tip.
#[derive(Clone, Debug, PartialEq)]
pub struct Dart {
    /// Indices of the two sides in the piece's seams: the first runs to the tip, the second away from it.
    pub legs: [usize; 2],
    /// The outline in which both lie.
    pub outline: usize,
    /// Points of the outline: the open end of the first leg, the tip, the open end of the second leg.
    pub ends: [usize; 3],
    /// Distance between the open ends; for a dart without open ends its greatest width.
    pub base_mm: f64,
    /// Whether both ends are tips: a dart that is a whole hole.
    pub is_eye: bool,
    /// Whether other darts branch off at its tip.
    pub is_branched: bool,
    /// Whether it is cut out. Otherwise it is only marked.
    pub is_cut: bool,
    /// Index of the narrow dart of which it is a branch, which then stands for both.
    pub within: Option<usize>,
}

/// The darts of a piece, and which of them are cut out.
///
/// A dart is cut out if its base is wider than the allowances of both legs and 4 mm, or if neither leg has an
/// allowance. **Takes** the widths as [`super::cut_lines`] does.
pub fn darts(piece: &Piece, widths: &[Vec<f64>]) -> Vec<Dart> {
    let mut darts = Vec::new();
    for outline in 0..piece.outlines.len() {
        let mut order: Vec<usize> =
            (0..piece.seams.len()).filter(|&s| piece.seams[s].outline == outline).collect();
        order.sort_by_key(|&s| piece.seams[s].first);
        // The outline is a circle, and a pair can be read as brackets about either part of it. From every start all readings
        // come up; only one of the two has its gap outside the piece.
        let mut seen = BTreeSet::new();
        for start in 0..order.len() {
            for pair in matched(piece, &order, start) {
                if seen.insert(pair.legs) {
                    darts.extend(dart(piece, widths, &pair));
                }
            }
        }
    }
    for i in 0..darts.len() {
        let inside = |d: &Dart, e: &Dart| {
            let n = piece.outlines[d.outline].points.len();
            let from = |p: usize| (p + n - d.ends[0]) % n;
            d.outline == e.outline
                && from(e.ends[0]) <= from(e.ends[2])
                && from(e.ends[2]) <= from(d.ends[2])
        };
        darts[i].within = (0..darts.len()).find(|&j| {
            j != i && darts[j].is_branched && !darts[j].is_cut && inside(&darts[j], &darts[i])
        });
    }
    darts
}

struct Pair {
    legs: [usize; 2],
    is_branched: bool,
}

/// Pairs of seams with nothing but pairs between them, found like brackets.
fn matched(piece: &Piece, order: &[usize], start: usize) -> Vec<Pair> {
    let mut open: Vec<(usize, bool)> = Vec::new();
    let mut pairs = Vec::new();
    let mut end = None;
    for k in 0..order.len() {
        let s = order[(start + k) % order.len()];
        let seam = &piece.seams[s];
        let n = piece.outlines[seam.outline].points.len();
        if end != Some(seam.first % n) {
            // A piece of rim: nothing pairs across it.
            open.clear();
        }
        end = Some((seam.first + seam.sides) % n);
        let is_own = matches!(seam.partner, Partner::Own { .. }) && !seam.is_closed;
        match open.last() {
            Some(&(other, has_branches)) if is_own && piece.seams[other].number == seam.number => {
                open.pop();
                pairs.push(Pair { legs: [other, s], is_branched: has_branches });
                if let Some(parent) = open.last_mut() {
                    parent.1 = true;
                }
            }
            _ if is_own => open.push((s, false)),
            _ => open.clear(),
        }
    }
    pairs
}

/// What a pair of seams is, if it is a dart: its gap lies outside the piece, and opens less than a right angle.
fn dart(piece: &Piece, widths: &[Vec<f64>], pair: &Pair) -> Option<Dart> {
    let [first, second] = pair.legs.map(|s| &piece.seams[s]);
    let outline = first.outline;
    let points = &piece.outlines[outline].points;
    let n = points.len();
    let tip = second.first % n;
    let ends = [first.first % n, tip, (second.first + second.sides) % n];
    let is_eye = ends[0] == ends[2];
    let polygon = run(points, ends[0], ends[2]);
    let [p, t, q] = ends.map(|i| points[i]);
    let size = area(&polygon);
    let extent = first.length_mm.max(second.length_mm);
    if size > 1e-9 * extent * extent {
        return None;
    }
    let legs = [first, second].map(|seam| piece.seam_points(seam));
    let base_mm = if is_eye {
        let far = |p: &[f64; 2]| {
            let sides = legs[1].windows(2);
            sides.map(|s| distance(nearest(*p, s[0], s[1]).0, *p)).fold(f64::INFINITY, f64::min)
        };
        legs[0].iter().map(far).fold(0.0, f64::max)
    } else {
        distance(p, q)
    };
    // At its tip; a run of branches is as wide as its base is.
    if !is_eye && base_mm > 1.4 * distance(p, t).min(distance(q, t)) {
        return None;
    }
    let width = |seam: &crate::pattern::Seam| {
        let row = widths.get(outline).map_or(&[][..], Vec::as_slice);
        let at = |k: usize| row.get((seam.first + k) % n).copied().unwrap_or(0.0);
        (0..seam.sides).map(at).filter(|w| w.is_finite()).fold(0.0, f64::max)
    };
    let wide = [first, second].map(width);
    let is_cut = wide[0].max(wide[1]) <= 0.0 || base_mm > wide[0] + wide[1] + OPENING_MM;
    let Pair { legs, is_branched } = *pair;
    Some(Dart { legs, outline, ends, base_mm, is_eye, is_branched, is_cut, within: None })
}

/// Points of an outline from one to another, the whole of it if they are the same.
fn run(points: &[[f64; 2]], from: usize, to: usize) -> Vec<[f64; 2]> {
    let n = points.len();
    let sides = if from == to { n - 1 } else { (to + n - from) % n };
    (from..=from + sides).map(|i| points[i % n]).collect()
}

impl Dart {
    /// Factor of the allowance at a distance along a leg of that length from its open end: shrinks to 0 at the tip. An eye's
    /// is widest in its middle.
    pub(super) fn taper(&self, share_to_tip: f64) -> f64 {
        if self.is_branched {
            1.0
        } else if self.is_eye {
            (2.0 * share_to_tip.min(1.0 - share_to_tip)).clamp(0.0, 1.0)
        } else {
            (1.0 - share_to_tip).clamp(0.0, 1.0)
        }
    }

    /// The gap of a dart that is not cut, with its cap, counter-clockwise.
    pub(super) fn filling(
        &self,
        points: &[[f64; 2]],
        beside: [Option<&Strip>; 2],
    ) -> Vec<[f64; 2]> {
        let mut polygon = run(points, self.ends[0], self.ends[2]);
        polygon.reverse();
        if self.is_eye {
            return polygon;
        }
        let [p, tip, q] = self.ends.map(|i| points[i]);
        let walk = Walk { points, is_closed: true };
        let far = 0.25 * distance(p, tip).min(distance(q, tip));
        // Directions of both legs away from the tip, at the base.
        let legs = [
            direction(minus(p, walk.from(self.ends[0], 1, far))),
            direction(minus(q, walk.from(self.ends[2], -1, far))),
        ];
        let corner = |at: [f64; 2], leg: Option<[f64; 2]>, strip: Option<&Strip>, end: usize| {
            let (leg, strip) = (leg?, strip?);
            let (w, slope) = (strip.widths[end], dot(leg, strip.normal));
            (slope > 0.3).then(|| along(at, w / slope, leg))
        };
        let [Some(e), Some(f)] =
            [corner(p, legs[0], beside[0], 1), corner(q, legs[1], beside[1], 0)]
        else {
            return polygon;
        };
        polygon.push(e);
        if let [Some(l0), Some(l1)] = legs
            && let [Some(before), Some(after)] = beside
            && let Some(centre) = direction(along(minus(p, tip), 1.0, minus(q, tip)))
        {
            // The edges beside the dart, mirrored over its legs, where they reach its middle line.
            let mirrored = |d: [f64; 2], l: [f64; 2]| along(d.map(|x| -x), 2.0 * dot(d, l), l);
            let long = 4.0 * distance(e, tip).max(distance(f, tip));
            let middle = [tip, along(tip, long, centre)];
            let reached = [(e, before.along().map(|x| -x), l0), (f, after.along(), l1)]
                .map(|(at, d, l)| meeting(middle, [at, along(at, long, mirrored(d, l))]));
            if let [Some([s, _]), Some([t, _])] = reached {
                let far = 0.5 * (s + t) * long;
                let leg = distance(e, tip).max(distance(f, tip));
                if far > 0.7 * leg && far < 1.4 * leg {
                    polygon.push(along(tip, far, centre));
                }
            }
        }
        polygon.push(f);
        polygon
    }

    /// The cut of a dart that has no width: one line from beyond its open end to its tip.
    pub(super) fn slit(&self, points: &[[f64; 2]], beside: [Option<&Strip>; 2]) -> Vec<[f64; 2]> {
        let mut line = run(points, self.ends[0], self.ends[1]);
        if self.is_eye {
            return line;
        }
        let w = beside.iter().flatten().map(|s| s.widths[0].max(s.widths[1])).fold(0.0, f64::max);
        if let (true, Some(out)) =
            (w > 0.0, line.get(1).and_then(|&p| direction(minus(line[0], p))))
        {
            line.insert(0, along(line[0], w, out));
        }
        line
    }
}

/// The legs of the darts that are not cut, and the tips of all: a cross of 3 mm.
///
/// **Takes** the index of the piece on its sheet. **Gives** lines in [`Layer::Internal`] (`A-dart-3`, with the seam they
/// are legs of) and [`Layer::Drill`] (`A-tip-3`).
pub fn draw_darts(index: usize, piece: &Piece, darts: &[Dart]) -> Vec<Line> {
    let name = &piece.name;
    let line = |layer, id, seam, points| Line {
        layer,
        id,
        piece: Some(index),
        seam: Some(seam),
        is_closed: false,
        points,
        curve: Vec::new(),
    };
    let mut lines = Vec::new();
    for dart in darts {
        let points = &piece.outlines[dart.outline].points;
        let number = piece.seams[dart.legs[0]].number;
        if !dart.is_cut || dart.within.is_some() {
            for (leg, side) in dart.legs.into_iter().zip(["a", "b"]) {
                let id = format!("{name}-dart-{number}{side}");
                lines.push(line(Layer::Internal, id, leg, piece.seam_points(&piece.seams[leg])));
            }
        }
        let tips = if dart.is_eye { vec![dart.ends[1], dart.ends[0]] } else { vec![dart.ends[1]] };
        for (k, tip) in tips.into_iter().enumerate().filter(|_| !dart.is_branched) {
            let [x, y] = points[tip];
            let r = 1.5_f64.min(0.1 * piece.seams[dart.legs[0]].length_mm);
            for (way, d) in [("x", [r, 0.0]), ("y", [0.0, r])] {
                let ends = vec![[x - d[0], y - d[1]], [x + d[0], y + d[1]]];
                let more = if k > 0 { "-2" } else { "" };
                let id = format!("{name}-tip-{number}{more}-{way}");
                lines.push(line(Layer::Drill, id, dart.legs[0], ends));
            }
        }
    }
    lines
}
