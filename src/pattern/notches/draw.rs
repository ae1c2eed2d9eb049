//! Notches as lines.

use super::{NotchParams, NotchPlan, NotchStyle, place};
use crate::pattern::allowance::CutLines;
use crate::pattern::plane::{along, distance, meeting, minus, nearest, right, winding};
use crate::pattern::{Layer, Line, Partner, Piece};

/// Deepest slit, mm.
const SLIT_MM: f64 = 6.0;
/// From the end of a notch to the sew line, mm.
const REST_MM: f64 = 3.0;
/// Width and depth of a V into the allowance, and out of it, mm.
const V_IN: [f64; 2] = [5.0, 4.0];
const V_OUT: [f64; 2] = [6.0, 5.0];
/// A V stands out where the allowance is narrower, mm.
const NARROW_MM: f64 = 8.0;
/// Length of the bar of a T, mm.
const BAR_MM: f64 = 4.0;
/// Length of a tick inside the piece where there is no allowance, mm.
const TICK_MM: f64 = 3.0;
/// Farthest that a foot is looked for; wider allowances have no notches on the cut line, mm.
const FAR_MM: f64 = 1e5;

/// A mark on one side of a seam.
pub(super) struct Mark {
    /// Index of the seam in the piece.
    pub seam: usize,
    /// Number of the mark in the seam's own order, from 1.
    pub number: usize,
    /// On the sew line.
    pub at: [f64; 2],
    /// Out of the piece.
    pub normal: [f64; 2],
    /// From there to the cut line; 0 where the piece is cut on the sew line, none where the cut line there is not that of this seam.
    pub allowance: Option<f64>,
}

impl Mark {
    pub fn foot(&self, allowance: f64) -> [f64; 2] {
        along(self.at, allowance, self.normal)
    }

    /// Whether it stands out of the cut line.
    pub fn is_outward(&self, style: NotchStyle) -> bool {
        style == NotchStyle::V && self.allowance.is_some_and(|a| a > 0.1 && a < NARROW_MM)
    }

    /// The triangle that stands out of the cut line, with a point inside the allowance: counter-clockwise.
    pub fn outward(&self, piece: &Piece, cut: &CutLines, factor: f64) -> Option<[[f64; 2]; 4]> {
        let a = self.allowance?;
        let [w, d] = V_OUT.map(|x| x * factor);
        let t = right(self.normal).map(|x| -x);
        let inner = along(self.at, 0.5 * a, self.normal);
        let tip = along(self.foot(a), d, self.normal);
        let feet = [-0.5, 0.5].map(|s| {
            let from = along(self.at, s * w, t);
            reached(cut, from, self.normal, 4.0 * a + d).map(|far| along(from, far, self.normal))
        });
        let ([Some(e), Some(f)], false) = (feet, is_taken(piece, cut, tip, a + d)) else {
            return None;
        };
        Some([inner, e, tip, f])
    }
}

/// Whether something else than the space beside a mark lies within its reach: the piece or its cut line.
fn is_taken(piece: &Piece, cut: &CutLines, tip: [f64; 2], far: f64) -> bool {
    let is_inside = cut.outlines.iter().map(|c| winding(c, tip)).sum::<i32>() != 0;
    is_inside || sew_distance(piece, tip) < far - 0.25 * far
}

fn sew_distance(piece: &Piece, p: [f64; 2]) -> f64 {
    let sides = piece.outlines.iter().flat_map(|outline| outline.sides());
    sides.map(|(a, b)| distance(nearest(p, a, b).0, p)).fold(f64::INFINITY, f64::min)
}

/// Distance along a direction to the first cut line.
fn reached(cut: &CutLines, from: [f64; 2], d: [f64; 2], far: f64) -> Option<f64> {
    let ray = [along(from, -1e-6, d), along(from, far, d)];
    let sides = cut.outlines.iter().flat_map(|c| c.iter().zip(c.iter().cycle().skip(1)));
    let places = sides.filter_map(|(&a, &b)| meeting(ray, [a, b]));
    let nearest = places.map(|[s, _]| s).min_by(f64::total_cmp)?;
    Some((nearest * (far + 1e-6) - 1e-6).max(0.0))
}

/// All marks of a piece, in the order of its seams.
pub(super) fn marks(piece: &Piece, plan: &NotchPlan, cut: &CutLines) -> Vec<Mark> {
    let mut marks = Vec::new();
    for (seam, side) in piece.seams.iter().enumerate() {
        let Ok(i) = plan.seams.binary_search_by_key(&side.number, |s| s.number) else { continue };
        for (k, arc) in plan.seams[i].marks(plan.pair_mm).into_iter().enumerate() {
            let Some((at, normal)) = place(piece, seam, arc) else { continue };
            let on_cut = cut.outlines.iter().flat_map(|c| c.iter().zip(c.iter().cycle().skip(1)));
            let is_on = on_cut.clone().any(|(&a, &b)| distance(nearest(at, a, b).0, at) < 1e-4);
            let allowance = if is_on {
                Some(0.0)
            } else {
                // The foot belongs to this place only if no other of the sew line is nearer to it.
                let far = reached(cut, at, normal, FAR_MM);
                far.filter(|&a| sew_distance(piece, along(at, a, normal)) > 0.97 * a - 0.05)
            };
            marks.push(Mark { seam, number: k + 1, at, normal, allowance });
        }
    }
    marks
}

/// The notches of a piece.
///
/// A slit or T runs from the cut line inward by half of the allowance, 6 mm at most, and ends 3 mm before the sew line where there is room
/// for that; a V is 5 mm wide and 4 mm deep, or stands out by 5 mm where the allowance is below 8 mm: then it is a part of
/// the cut line ([`super::with_outward`]) and no line of its own. Where there is no allowance, or the cut line belongs to another side, a
/// tick goes 3 mm into the piece from the sew line. Sizes are reduced with the plan for small models.
///
/// **Takes** the index of the piece on its sheet and its own cut lines. **Gives** open lines in [`Layer::Notch`], ids `A-notch-12-3`
/// (seam 12, third mark; `12b` on the second side of a seam that a piece has with itself). **Costs** O(n) for each mark.
pub fn draw(
    index: usize,
    piece: &Piece,
    plan: &NotchPlan,
    cut: &CutLines,
    params: &NotchParams,
) -> Vec<Line> {
    let factor = plan.factor.clamp(NotchParams::SMALLEST, 1.0);
    let mut lines = Vec::new();
    for mark in marks(piece, plan, cut) {
        if mark.is_outward(params.style) && mark.outward(piece, cut, factor).is_some() {
            continue;
        }
        let seam = &piece.seams[mark.seam];
        let b = if seam.partner == (Partner::Own { is_second: true }) { "b" } else { "" };
        lines.push(Line {
            layer: Layer::Notch,
            id: format!("{}-notch-{}{b}-{}", piece.name, seam.number, mark.number),
            piece: Some(index),
            seam: Some(mark.seam),
            is_closed: false,
            points: shape(piece, &mark, cut, params.style, factor),
            curve: Vec::new(),
        });
    }
    lines
}

/// The points of a notch that does not stand out.
fn shape(
    piece: &Piece,
    mark: &Mark,
    cut: &CutLines,
    style: NotchStyle,
    factor: f64,
) -> Vec<[f64; 2]> {
    let Some(a) = mark.allowance.filter(|&a| a > 0.1) else {
        return tick(piece, mark, factor);
    };
    let foot = mark.foot(a);
    let t = right(mark.normal).map(|x| -x);
    // What the sew line needs is left, except where the allowance is too narrow for any notch then.
    let room = (a - REST_MM).max(a / 3.0);
    let inward = |depth: f64| along(foot, -depth, mark.normal);
    match style {
        NotchStyle::V => {
            let [w, d] = V_IN.map(|x| x * factor);
            let feet = [-0.5, 0.5].map(|s| {
                let from = along(mark.at, s * w, t);
                let far = reached(cut, from, mark.normal, 2.0 * a).unwrap_or(a);
                along(from, far, mark.normal)
            });
            vec![feet[0], inward(d.min(room)), feet[1]]
        }
        NotchStyle::Slit => vec![foot, inward((0.5 * a).min(SLIT_MM).min(room))],
        NotchStyle::T => {
            let end = inward((0.5 * a).min(SLIT_MM).min(room));
            let half = 0.5 * BAR_MM * factor;
            vec![foot, end, along(end, -half, t), along(end, half, t)]
        }
    }
}

/// A short line into the piece.
fn tick(piece: &Piece, mark: &Mark, factor: f64) -> Vec<[f64; 2]> {
    let mut depth = TICK_MM * factor;
    for _ in 0..6 {
        let line =
            [along(mark.at, -1e-3 * depth, mark.normal), along(mark.at, -depth, mark.normal)];
        let mut sides = piece.outlines.iter().flat_map(|outline| outline.sides());
        if sides.all(|(a, b)| meeting(line, [a, b]).is_none()) {
            break;
        }
        depth *= 0.5;
    }
    let end = along(mark.at, -depth, mark.normal);
    debug_assert!(minus(end, mark.at).iter().all(|x| x.is_finite()));
    vec![mark.at, end]
}
