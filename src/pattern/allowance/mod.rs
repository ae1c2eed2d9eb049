//! Seam allowance: the line along which a piece is cut, from the line along which it is sewn.
//!
//! The cut piece is the union of the piece with a strip of the given width along each side and with what fills the corners between
//! strips. At a corner with outward normals n₁, n₂ and widths a₁, a₂ the far edges meet in the point p with n₁·(p − v) = a₁,
//! n₂·(p − v) = a₂; far tips are cut off; between edges that go straight on with different widths there is a square step; where the
//! outline turns inward the union does what is right. Corners are judged over a distance: the small steps of a noisy outline
//! get round joints, which leave no spikes.
//!
//! Guaranteed, by a check of the result and told where it fails: the cut line never enters the piece, keeps the asked distance (to
//! 0.01 mm) where the width does not change, is one outer contour with holes and does not cross itself. Round parts lie outside the true
//! offset, by no more than the tolerance. Where a width is 0 the cut line has the points of the sew line, to the last bit.
//! Not guaranteed: that two sides that face each other across a gap both have their own allowance (the gap is filled, and a notice
//! says so).

mod darts;
mod notice;
mod strips;
mod union;
mod verify;

pub use darts::{Dart, darts, draw_darts};
pub use notice::CutNotice;
pub(crate) use union::union;

use super::curve::{reach, turns};
use super::piece::Piece;
use super::plane::{Walk, area, distance, right, turning, winding};
use super::sheet::{Layer, Line};
use strips::{Join, Strip};

/// How the cut line goes around a corner of the piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// Both edges go on until they meet.
    Mitre,
    /// A circle about the corner.
    Round,
    /// Cut off square to the middle of the corner, at the distance of the allowance.
    Square,
}

/// Shape of seam allowances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllowanceParams {
    /// At corners.
    pub corner: Corner,
    /// The tip of a mitre is cut off where it is farther from the corner than this many allowances. 2.5 leaves corners down to 47°.
    pub mitre_limit: f64,
    /// How far the polygon that stands for an arc may lie outside it, mm.
    pub chord_mm: f64,
}

impl Default for AllowanceParams {
    fn default() -> Self {
        Self { corner: Corner::Mitre, mitre_limit: 2.5, chord_mm: 0.05 }
    }
}

/// What is cut of a piece.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutLines {
    /// The outer contour, counter-clockwise, then holes, clockwise; mm.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Cuts that end inside: darts without width and without allowance. Open lines.
    pub slits: Vec<Vec<[f64; 2]>>,
    /// What a person should know before cutting; where there is one the lines are the best that could be done.
    pub notices: Vec<CutNotice>,
}

/// Allowances above this are a slip of the keyboard, mm.
const WIDEST_MM: f64 = 10_000.0;
/// A gap left open between allowances that is smaller than this is closed, mm².
const POCKET_MM2: f64 = 4.0;

/// The cut line around a piece.
///
/// **Takes** `widths[outline][side]`, the allowance in mm of the side from point `side` of that outline to the next; 0 cuts on the sew
/// line. Missing numbers count as 0, absurd ones too, with a notice. **Gives** the cut lines, checked; with all widths 0 the
/// outlines as they are. Narrow [`darts`] are not cut but filled, with a cap at the base; wide ones have an allowance
/// that shrinks linearly to 0 at the tip. **Costs** O(n log n).
pub fn cut_lines(piece: &Piece, widths: &[Vec<f64>], params: &AllowanceParams) -> CutLines {
    let mut notices = Vec::new();
    let asked = widths;
    let widths = checked(piece, asked, &mut notices);
    if widths.iter().flatten().all(|&w| w <= 0.0) {
        let outlines = piece.outlines.iter().map(|outline| outline.points.clone()).collect();
        return CutLines { outlines, slits: Vec::new(), notices };
    }
    let darts = darts(piece, &widths);
    let strips = all_strips(piece, &widths, &darts);
    let beside = |dart: &Dart| {
        let strips = &strips[dart.outline];
        let before = strips
            .iter()
            .find(|s| (s.side + 1) % piece.outlines[dart.outline].points.len() == dart.ends[0]);
        let after = strips.iter().find(|s| s.side == dart.ends[2]);
        [before, after]
    };
    let mut contours = Vec::new();
    let mut slits = Vec::new();
    for (outline, strips) in piece.outlines.iter().zip(&strips) {
        contours.extend(strips::contours(&outline.points, strips, params));
    }
    for dart in darts.iter().filter(|dart| dart.within.is_none()) {
        let points = &piece.outlines[dart.outline].points;
        if !dart.is_cut {
            contours.push(dart.filling(points, beside(dart)));
        } else if dart.base_mm < verify::DEPTH_MM && !dart.is_branched {
            slits.push(dart.slit(points, beside(dart)));
        }
    }
    let kept = strips.iter().flatten().filter(|s| s.widths[0].max(s.widths[1]) <= 0.0);
    let kept = kept.flat_map(|s| s.ends);
    let shapes = union(contours.iter().map(Vec::as_slice), kept);
    let outlines = chosen(piece, &widths, &darts, shapes, &mut notices);
    verify::verify(piece, &strips, &outlines, &mut notices);
    CutLines { outlines, slits, notices }
}

/// The widths as asked for, with 0 where they make no sense.
fn checked(piece: &Piece, asked: &[Vec<f64>], notices: &mut Vec<CutNotice>) -> Vec<Vec<f64>> {
    let mut first_bad = None;
    let mut row = |outline: usize, side: usize| {
        let w = asked.get(outline).and_then(|row| row.get(side)).copied().unwrap_or(0.0);
        if (0.0..=WIDEST_MM).contains(&w) {
            w
        } else {
            first_bad.get_or_insert((outline, side));
            0.0
        }
    };
    let sides = piece.outlines.iter().enumerate();
    let widths = sides.map(|(o, outline)| (0..outline.points.len()).map(|s| row(o, s)).collect());
    let widths = widths.collect();
    if let Some((outline, side)) = first_bad {
        notices.push(CutNotice::BadWidth { patch: piece.patch, outline, side });
    }
    widths
}

/// The strips of all outlines: nothing along darts that are not cut, less and less towards the tips of those that are.
fn all_strips(piece: &Piece, widths: &[Vec<f64>], darts: &[Dart]) -> Vec<Vec<Strip>> {
    let mut ends: Vec<Vec<[f64; 2]>> =
        widths.iter().map(|row| row.iter().map(|&w| [w, w]).collect()).collect();
    for dart in darts {
        for (leg, is_second) in dart.legs.into_iter().zip([false, true]) {
            let seam = &piece.seams[leg];
            let points = piece.seam_points(seam);
            let n = ends[dart.outline].len();
            let mut gone = 0.0;
            for k in 0..seam.sides {
                let size = distance(points[k], points[k + 1]);
                let shares = [gone, gone + size].map(|s| {
                    let share = (s / seam.length_mm).min(1.0);
                    if is_second { 1.0 - share } else { share }
                });
                gone += size;
                let is_cut = dart.is_cut && dart.within.is_none();
                let factor = |share: f64| if is_cut { dart.taper(share) } else { 0.0 };
                let widths = &mut ends[dart.outline][(seam.first + k) % n];
                *widths = [widths[0] * factor(shares[0]), widths[1] * factor(shares[1])];
            }
        }
    }
    let outlines = piece.outlines.iter().enumerate().zip(&ends);
    outlines.map(|((o, outline), ends)| strips::strips(o, &outline.points, ends)).collect()
}

/// The largest part of a union, with the holes that are more than a gap between allowances.
fn chosen(
    piece: &Piece,
    widths: &[Vec<f64>],
    darts: &[Dart],
    shapes: Vec<union::Shape>,
    notices: &mut Vec<CutNotice>,
) -> Vec<Vec<[f64; 2]>> {
    let patch = piece.patch;
    if shapes.len() > 1 {
        notices.push(CutNotice::NotOnePiece { patch, parts: shapes.len() });
    }
    let Some(shape) = shapes.into_iter().next() else {
        notices.push(CutNotice::NotOnePiece { patch, parts: 0 });
        return piece.outlines.iter().map(|outline| outline.points.clone()).collect();
    };
    let mut contours = shape.into_iter();
    let mut outlines: Vec<Vec<[f64; 2]>> = contours.next().into_iter().collect();
    let mut is_open = vec![false; piece.outlines.len()];
    for hole in contours {
        let at = inside(&hole);
        let own = (1..piece.outlines.len()).find(|&k| winding(&piece.outlines[k].points, at) != 0);
        if let Some(k) = own {
            is_open[k] = true;
        }
        if own.is_some() || area(&hole).abs() > POCKET_MM2 {
            outlines.push(hole);
        }
    }
    for outline in (1..piece.outlines.len()).filter(|&k| !is_open[k]) {
        let is_dart = darts.iter().any(|d| d.outline == outline && d.is_eye);
        let allowance_mm = widths[outline].iter().copied().fold(0.0, f64::max);
        if !is_dart {
            notices.push(CutNotice::HoleClosed { patch, outline, allowance_mm });
        }
    }
    outlines
}

/// A point inside a simple polygon: in the middle of where a level line enters and leaves it.
fn inside(points: &[[f64; 2]]) -> [f64; 2] {
    let mut levels: Vec<f64> = points.iter().map(|p| p[1]).collect();
    levels.sort_by(f64::total_cmp);
    let widest = levels.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    let y = widest.map_or(0.0, |pair| 0.5 * (pair[0] + pair[1]));
    let sides = points.iter().zip(points.iter().cycle().skip(1));
    let crossed = sides.filter(|(a, b)| (a[1] > y) != (b[1] > y));
    let mut places: Vec<f64> =
        crossed.map(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])).collect();
    places.sort_by(f64::total_cmp);
    match places[..] {
        [from, to, ..] => [0.5 * (from + to), y],
        _ => points.first().copied().unwrap_or([0.0; 2]),
    }
}

/// Clips: at corners where the outline turns inward and both sides have an allowance, a line from the cut line to 2 mm from the
/// corner. Cut there, the allowance spreads when the seam is turned. Tips of darts have none.
///
/// **Takes** the index of the piece on its sheet, the widths that its cut lines were made with. **Gives** lines in
/// [`Layer::Internal`] (`A-clip-1`), none where the allowance is below 3 mm.
pub fn draw_clips(index: usize, piece: &Piece, widths: &[Vec<f64>], cut: &CutLines) -> Vec<Line> {
    let widths = checked(piece, widths, &mut Vec::new());
    let darts = darts(piece, &widths);
    let mut lines = Vec::new();
    for (o, outline) in piece.outlines.iter().enumerate() {
        let points = &outline.points;
        let n = points.len();
        let walk = Walk { points, is_closed: true };
        for v in turns(points, true) {
            let Some(directions) = walk.directions(v, reach(points, true)) else { continue };
            let ends = [widths[o][(v + n - 1) % n], widths[o][v]];
            let is_tip = darts.iter().any(|d| {
                d.outline == o && d.ends[..2].contains(&v) && (d.ends[1] == v || d.is_eye)
            });
            if turning(directions) >= 0.0 || ends[0].min(ends[1]) < 3.0 || is_tip {
                continue;
            }
            let join = Join { at: points[v], normals: directions.map(right), widths: ends };
            let Some(from) = join.inner() else { continue };
            // It must lie on the cut line: elsewhere the gap is filled, and there is nothing to clip.
            let sides = cut.outlines.iter().flat_map(|c| c.iter().zip(c.iter().cycle().skip(1)));
            let off = sides
                .map(|(&a, &b)| distance(super::plane::nearest(from, a, b).0, from))
                .fold(f64::INFINITY, f64::min);
            let far = distance(points[v], from);
            if off < 0.1 && far > 2.5 {
                let to = [0, 1].map(|i| points[v][i] + 2.0 / far * (from[i] - points[v][i]));
                lines.push(Line {
                    layer: Layer::Internal,
                    id: format!("{}-clip-{}", piece.name, lines.len() + 1),
                    piece: Some(index),
                    seam: None,
                    is_closed: false,
                    points: vec![from, to],
                    curve: Vec::new(),
                });
            }
        }
    }
    lines
}
