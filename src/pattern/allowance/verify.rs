//! The check of cut lines against the sew line: everything that is promised is measured.

use nalgebra::Point2;

use super::CutNotice;
use super::strips::Strip;
use crate::flatten::overlap;
use crate::pattern::Piece;
use crate::pattern::grid::Grid;
use crate::pattern::plane::{along, between, distance, dot, meeting, minus, nearest, winding};

/// Crossings less deep than this are rounding, mm.
pub(super) const DEPTH_MM: f64 = 1e-3;
/// How much narrower than asked an allowance may be, mm.
const SHORT_MM: f64 = 0.01;
/// How far a foot must lie inside another allowance to have no edge of its own, mm.
const COVERED_MM: f64 = 0.05;
/// Sides farther from each other along the outline than this many allowances face each other across a gap; nearer ones may lie on
/// both sides of a corner. At an inward corner of 30° strips overlap for 7.5 allowances.
const FACING: f64 = 8.0;

/// Appends what cut lines do not keep.
pub(super) fn verify(
    piece: &Piece,
    strips: &[Vec<Strip>],
    cut: &[Vec<[f64; 2]>],
    notices: &mut Vec<CutNotice>,
) {
    let patch = piece.patch;
    let all: Vec<&Strip> = strips.iter().flatten().collect();
    crossings(piece, cut, notices);
    let sew: Vec<[[f64; 2]; 2]> = all.iter().map(|s| s.ends).collect();
    let lines: Vec<[[f64; 2]; 2]> = cut.iter().flat_map(|c| sides(c)).collect();
    let widest = all.iter().flat_map(|s| s.widths).fold(0.0, f64::max);
    let (sew_grid, cut_grid) = (Grid::new(&sew), Grid::new(&lines));
    let mut close: Option<(f64, CutNotice)> = None;
    for strip in &all {
        let w = strip.least();
        if w <= SHORT_MM {
            continue;
        }
        cut_grid.near(strip.ends, w, |k| {
            let (far, [_, at]) = between(strip.ends, lines[k]);
            if far >= w - SHORT_MM || close.as_ref().is_some_and(|c| c.0 >= w - far) {
                return;
            }
            // There the cut may be that of a narrower side.
            let mut is_other = false;
            sew_grid.near([at, at], widest, |j| {
                let other = all[j];
                let (q, t) = nearest(at, other.ends[0], other.ends[1]);
                let own = other.widths[0] + t * (other.widths[1] - other.widths[0]);
                is_other |= other.least() < w - 1e-9 && distance(q, at) <= own + SHORT_MM;
            });
            if !is_other {
                let (distance_mm, allowance_mm) = (far, w);
                let notice = CutNotice::TooClose { patch, at, distance_mm, allowance_mm };
                close = Some((w - far, notice));
            }
        });
    }
    notices.extend(close.map(|c| c.1));
    notices.extend(crowded(piece, &all, &sew_grid, widest));
}

/// Crossings of cut lines among themselves and with the sew line, and a sew line outside.
fn crossings(piece: &Piece, cut: &[Vec<[f64; 2]>], notices: &mut Vec<CutNotice>) {
    let patch = piece.patch;
    let sew = piece.outlines.iter().map(|outline| outline.points.as_slice());
    let corners: Vec<Vec<Point2<f64>>> = cut
        .iter()
        .map(Vec::as_slice)
        .chain(sew)
        .map(|points| points.iter().copied().map(Point2::from).collect())
        .collect();
    let names: Vec<&[Point2<f64>]> = corners.iter().map(Vec::as_slice).collect();
    let is_cut = |side: overlap::Side| (side.outline as usize) < cut.len();
    let (mut own, mut other) = (None, None);
    for [s, t] in overlap::crossings(&names) {
        let ends = [s, t].map(|name| {
            let corners = &corners[name.outline as usize];
            let i = name.side as usize;
            [corners[i], corners[(i + 1) % corners.len()]].map(|p| [p.x, p.y])
        });
        let Some([u, _]) = meeting(ends[0], ends[1]) else { continue };
        if depth(ends[0], ends[1]).min(depth(ends[1], ends[0])) < DEPTH_MM {
            continue;
        }
        let at = along(ends[0][0], u, minus(ends[0][1], ends[0][0]));
        match (is_cut(s), is_cut(t)) {
            (true, true) => own = own.or(Some(at)),
            (false, false) => {}
            _ => other = other.or(Some(at)),
        }
    }
    // Without crossings one point of the outer outline tells for all of it.
    let outside = cut.first().and_then(|outer| {
        // Crossings are known: some of the points tell as much as all.
        let mut points = piece.outlines.first()?.points.iter().step_by(16);
        points.find(|&&p| {
            let off = |(a, b)| distance(nearest(p, a, b).0, p);
            winding(outer, p) == 0
                && outer
                    .iter()
                    .zip(outer.iter().cycle().skip(1))
                    .all(|(&a, &b)| off((a, b)) > DEPTH_MM)
        })
    });
    notices.extend(own.map(|at| CutNotice::CrossesItself { patch, at }));
    notices.extend(other.or(outside.copied()).map(|at| CutNotice::EntersPiece { patch, at }));
}

/// How far a segment that crosses a line reaches beyond it.
fn depth([a, b]: [[f64; 2]; 2], segment: [[f64; 2]; 2]) -> f64 {
    let Some(d) = crate::pattern::plane::direction(minus(b, a)) else { return 0.0 };
    let off = segment.map(|p| crate::pattern::plane::cross(d, minus(p, a)).abs());
    off[0].min(off[1])
}

/// Sides whose feet lie within the allowance of sides far from them along the outline.
fn crowded(piece: &Piece, all: &[&Strip], grid: &Grid, widest: f64) -> Option<CutNotice> {
    // Distances along each outline.
    let mut arcs = Vec::with_capacity(all.len());
    let mut around = vec![0.0; piece.outlines.len()];
    for strip in all {
        arcs.push(around[strip.outline]);
        around[strip.outline] += strip.length();
    }
    let (mut length_mm, mut worst) = (0.0, None::<(f64, [f64; 2], f64)>);
    for (i, strip) in all.iter().enumerate() {
        let w = strip.least();
        if w <= 2.0 * COVERED_MM {
            continue;
        }
        // Once per allowance; a side across is as far as the outline is long between the two places.
        let count = (strip.length() / w).ceil().clamp(1.0, 32.0);
        let mut share = 0.5 / count;
        while share < 1.0 {
            let at = along(strip.ends[0], share, minus(strip.ends[1], strip.ends[0]));
            let arc = arcs[i] + share * strip.length();
            let foot = along(at, w - COVERED_MM, strip.normal);
            let mut gap: Option<f64> = None;
            grid.near([at, foot], widest, |j| {
                let other = all[j];
                let [a, b] = other.ends;
                let (place, t) = nearest(at, a, b);
                let way = (arc - arcs[j] - t * other.length()).abs();
                let way = way.min(around[strip.outline] - way);
                if strip.outline == other.outline && way <= FACING * w.max(other.least()) {
                    return;
                }
                // Its strip lies on its outer side only: a thin neck hides the side beyond.
                let (q, _) = nearest(foot, a, b);
                let is_covered = distance(q, foot) < other.least() - COVERED_MM
                    && dot(other.normal, minus(foot, q)) > 0.0;
                if is_covered || meeting([at, foot], [a, b]).is_some() {
                    let far = distance(place, at);
                    gap = Some(gap.map_or(far, |g| g.min(far)));
                }
            });
            if let Some(gap) = gap {
                length_mm += strip.length() / count;
                if worst.is_none_or(|(least, ..)| gap < least) {
                    worst = Some((gap, at, w));
                }
            }
            share += 1.0 / count;
        }
    }
    let patch = piece.patch;
    worst.map(|(gap_mm, at, allowance_mm)| CutNotice::Crowded {
        patch,
        at,
        gap_mm,
        allowance_mm,
        length_mm,
    })
}

fn sides(points: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    points.iter().zip(points.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
}
