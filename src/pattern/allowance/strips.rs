//! The allowance as polygons: a strip along each side, and what fills the corners between strips.
//!
//! The strip of a side from a to b with outward normal n and widths w, w' at its ends is the polygon a, a + w n, b + w' n, b. Strips,
//! corners and the inside of the outlines all wind once counter-clockwise (holes once back), so the points about which their sum
//! winds are their union. The sum of an outline with its strips is one contour: from foot to foot, through the
//! vertex where the outline turns right.

use std::f64::consts::PI;

use super::{AllowanceParams, Corner};
use crate::pattern::curve::{reach, turns};
use crate::pattern::plane::{Walk, along, cross, direction, distance, dot, minus, right, turning};

/// Widths of this size are equal, mm.
const EQUAL_MM: f64 = 1e-9;

/// A side of an outline with its allowance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    /// Index of the outline.
    pub outline: usize,
    /// Index of the side in it.
    pub side: usize,
    /// Its ends.
    pub ends: [[f64; 2]; 2],
    /// Outward.
    pub normal: [f64; 2],
    /// Widths at its ends.
    pub widths: [f64; 2],
}

impl Strip {
    /// The direction of the side.
    pub fn along(&self) -> [f64; 2] {
        [-self.normal[1], self.normal[0]]
    }

    pub fn length(&self) -> f64 {
        distance(self.ends[0], self.ends[1])
    }

    /// The corner of the strip beside an end.
    fn foot(&self, end: usize) -> [f64; 2] {
        along(self.ends[end], self.widths[end], self.normal)
    }

    /// The least distance that the far edge of the strip keeps from the side.
    pub fn least(&self) -> f64 {
        let [from, to] = self.widths;
        let cosine = 1.0 / (1.0 + ((to - from) / self.length()).powi(2)).sqrt();
        from.min(to) * cosine
    }
}

/// The strips of an outline; sides without length have none.
pub(super) fn strips(outline: usize, points: &[[f64; 2]], widths: &[[f64; 2]]) -> Vec<Strip> {
    let n = points.len();
    let strip = |side: usize| {
        let ends = [points[side], points[(side + 1) % n]];
        let normal = right(direction(minus(ends[1], ends[0]))?);
        Some(Strip { outline, side, ends, normal, widths: widths[side] })
    };
    (0..n).filter_map(strip).collect()
}

/// The contours of an outline with its allowance: the sum of the outline and its strips first, then what fills corners that are
/// made of many small steps.
pub(super) fn contours(
    outline: &[[f64; 2]],
    strips: &[Strip],
    params: &AllowanceParams,
) -> Vec<Vec<[f64; 2]>> {
    let far = reach(outline, true);
    let corners = turns(outline, true);
    let n = strips.len();
    // Between each strip and the next: the points that join them, and whether these stand for both feet as well.
    let mut joints = Vec::with_capacity(n);
    let mut fills = Vec::new();
    for (i, strip) in strips.iter().enumerate() {
        let next = &strips[(i + 1) % n];
        let vertex = next.side;
        let is_corner = corners.binary_search(&vertex).is_ok();
        let is_exact = strip.length() >= far && next.length() >= far;
        let style = if is_corner && is_exact { params.corner } else { Corner::Round };
        let join = Join {
            at: strip.ends[1],
            normals: [strip.normal, next.normal],
            widths: [strip.widths[1], next.widths[0]],
        };
        let tip = join.tip(strip, next).map(|tip| vec![tip]);
        let points = join.points(style, params);
        // One point that lies on both far edges: the same contour without the feet.
        joints.push(match tip {
            Some(tip) if turning(join.normals) < 0.0 || points.len() == 1 => (tip, true),
            _ => (points, false),
        });
        if is_corner && !is_exact && params.corner != Corner::Round {
            let walk = Walk { points: outline, is_closed: true };
            let Some(directions) = walk.directions(vertex, far) else { continue };
            if turning(directions) <= 0.0 {
                continue;
            }
            let join = Join { normals: directions.map(right), ..join };
            let feet = [0, 1].map(|k| along(join.at, join.widths[k], join.normals[k]));
            let mut fill = vec![join.at, feet[0]];
            fill.extend(join.points(params.corner, params));
            fill.push(feet[1]);
            fills.push(fill);
        }
    }
    let mut chain = Vec::with_capacity(3 * n);
    for (i, strip) in strips.iter().enumerate() {
        let (joint, is_whole) = &joints[i];
        if !joints[(i + n - 1) % n].1 {
            chain.push(strip.foot(0));
        }
        if !is_whole {
            chain.push(strip.foot(1));
        }
        chain.extend(joint);
    }
    let mut contours = vec![chain];
    contours.extend(fills);
    contours
}

/// The end of a strip and the beginning of the next, at a vertex.
#[derive(Clone, Copy)]
pub(super) struct Join {
    /// The vertex.
    pub at: [f64; 2],
    /// Outward, of the side before and the side after.
    pub normals: [[f64; 2]; 2],
    /// Of those two at the vertex.
    pub widths: [f64; 2],
}

impl Join {
    /// The points between the feet of both strips.
    fn points(&self, style: Corner, params: &AllowanceParams) -> Vec<[f64; 2]> {
        let Self { at, normals: [n1, n2], widths: [w1, w2] } = *self;
        if w1.max(w2) <= 0.0 {
            return Vec::new();
        }
        let turn = turning([n1, n2]);
        let is_equal = (w1 - w2).abs() <= EQUAL_MM;
        // At the tip of a needle rounding decides on which side the outline turns back; a cap does no harm.
        if turn <= 0.0 && turn > 1e-9 - PI {
            // Through the vertex; straight on without a step there is nothing between.
            return if is_equal && turn > -1e-12 { Vec::new() } else { vec![at] };
        }
        let turn = turn.abs();
        match style {
            Corner::Round if is_equal => self.arc(w1, turn, params.chord_mm),
            Corner::Square if is_equal => self.clipped(turn, w1),
            _ => self.mitre(turn, params.mitre_limit),
        }
    }

    /// Where the far edges of two strips of one width meet, if that is well within both: the strips cut off there have the same union, and
    /// a smooth outline far fewer crossings.
    fn tip(&self, strip: &Strip, next: &Strip) -> Option<[f64; 2]> {
        let w = self.widths[0];
        let is_even = [strip, next]
            .iter()
            .all(|s| (s.widths[0] - w).abs() <= EQUAL_MM && (s.widths[1] - w).abs() <= EQUAL_MM);
        let half = 0.5 * turning(self.normals);
        let cut = w * half.tan().abs();
        let is_within = half > 0.0 || cut <= 0.45 * strip.length().min(next.length());
        if !(is_even && w > 0.0 && half.abs() < 0.7 && is_within) {
            return None;
        }
        let [n1, n2] = self.normals;
        let middle = direction([n1[0] + n2[0], n1[1] + n2[1]])?;
        Some(along(self.at, w / half.cos(), middle))
    }

    /// The corners of a polygon about an arc of radius w, so close that they lie no further from it than the tolerance.
    fn arc(&self, w: f64, turn: f64, tolerance: f64) -> Vec<[f64; 2]> {
        // Half the angle of a step: w / cos h − w is the tolerance.
        let half = (w / (w + tolerance.max(1e-6))).acos().clamp(0.01, 0.5);
        let steps = (turn / (2.0 * half)).ceil().max(1.0);
        let half = 0.5 * turn / steps;
        let [x, y] = self.normals[0];
        let mut out = Vec::new();
        let mut angle = half;
        while angle < turn {
            let (s, c) = angle.sin_cos();
            out.push(along(self.at, w / half.cos(), [c * x - s * y, s * x + c * y]));
            angle += 2.0 * half;
        }
        out
    }

    /// Where the far edges of the strips meet: n₁·(p − v) = w₁, n₂·(p − v) = w₂. Where they meet before the foot of one of
    /// them (its strip is much narrower), a step square to the wider one; beyond the limit a bevel.
    fn mitre(&self, turn: f64, limit: f64) -> Vec<[f64; 2]> {
        let Self { at, normals: [n1, n2], widths: [w1, w2] } = *self;
        let (sine, cosine) = turn.sin_cos();
        let (s1, s2) = (w2 - w1 * cosine, w1 - w2 * cosine);
        if s1 < 0.0 {
            return vec![along(at, w2 / cosine, n1)];
        }
        if s2 < 0.0 {
            return vec![along(at, w1 / cosine, n2)];
        }
        let wide = w1.max(w2);
        // (p − v) sin t, which stays finite.
        let d1 = [-n1[1], n1[0]];
        let to = along(n1.map(|x| w1 * sine * x), s1, d1);
        if to[0].hypot(to[1]) <= limit.max(1.0) * wide * sine {
            vec![along(at, 1.0 / sine, to)]
        } else {
            self.clipped(turn, limit.max(1.0) * wide)
        }
    }

    /// The mitre cut off square to the direction of its tip, at a distance from the vertex no less than the widths.
    fn clipped(&self, turn: f64, far: f64) -> Vec<[f64; 2]> {
        let Self { at, normals: [n1, n2], widths: [w1, w2] } = *self;
        let (sine, cosine) = turn.sin_cos();
        let [d1, d2] = [n1, n2].map(|n| [-n[1], n[0]]);
        let to = along(n1.map(|x| w1 * sine * x), w2 - w1 * cosine, d1);
        let Some(axis) = direction(to) else { return vec![at] };
        let on = |w: f64, n: [f64; 2], d: [f64; 2]| {
            along(along(at, w, n), (far - w * dot(axis, n)) / dot(axis, d), d)
        };
        let ends = [on(w1, n1, d1), on(w2, n2, d2)];
        // Both are ahead of the vertex on their lines, or there is nothing to cut off.
        let is_sound = ends.iter().flatten().all(|x| x.is_finite())
            && cross(minus(ends[0], at), minus(ends[1], at)) >= 0.0;
        if is_sound { ends.to_vec() } else { Vec::new() }
    }

    /// The corner of the allowance on the far side of a vertex where the outline turns right, if there is one.
    pub fn inner(&self) -> Option<[f64; 2]> {
        let Self { at, normals: [n1, n2], widths: [w1, w2] } = *self;
        let (sine, cosine) = turning([n1, n2]).sin_cos();
        let d1 = [-n1[1], n1[0]];
        let p = along(along(at, w1, n1), (w2 - w1 * cosine) / sine, d1);
        p.iter().all(|x| x.is_finite()).then_some(p)
    }
}
