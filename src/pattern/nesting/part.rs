//! A shape made ready to be laid: what does not depend on where it lies.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2, TAU};

use super::plane::{self, Dice, Turn, cross, dot, minus, size};
use super::room::Room;
use super::{NestParams, NestShape};
use crate::pattern::piece::Bounds;

/// Turns that the raster tries for each part at most: its time grows with them, its gain hardly.
const MOST_TURNS: usize = 8;
/// Points of a rim that the search works with at most, if the outline can be simplified so far.
const POINTS: usize = 64;
/// Outlines are simplified by at most this part of the size of a shape: what is lost is lost in the gap.
const COARSEST: f64 = 0.002;

/// A shape and its turns.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Its number.
    pub shape: usize,
    pub area: f64,
    /// The largest distance of two of its points, or a little more.
    pub diameter: f64,
    /// Convex hull of the outlines.
    pub hull: Vec<[f64; 2]>,
    /// Outlines with fewer points, no original point farther off than `slack`.
    pub rim: Vec<Vec<[f64; 2]>>,
    pub slack: f64,
    /// Turns that fit the stock, a few of them.
    pub fits: Vec<Fit>,
    /// Turns without jitter and whether mirrored; empty where all are allowed.
    turns: Vec<Turn>,
    may_mirror: bool,
    /// Radians off these; none where all turns are allowed.
    jitter: f64,
}

/// A turn and the extent of the part after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    pub turn: Turn,
    pub bounds: Bounds,
}

impl Fit {
    pub fn size(&self) -> [f64; 2] {
        [0, 1].map(|k| self.bounds.high[k] - self.bounds.low[k])
    }
}

/// A part somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub sheet: usize,
    pub turn: Turn,
    pub at: [f64; 2],
    /// Of the part on the sheet.
    pub bounds: Bounds,
}

impl Spot {
    /// A part with the low corner of its extent at a place.
    pub fn new(sheet: usize, fit: &Fit, corner: [f64; 2]) -> Self {
        let at = minus(corner, fit.bounds.low);
        let high = [0, 1].map(|k| fit.bounds.high[k] + at[k]);
        Self { sheet, turn: fit.turn, at, bounds: Bounds { low: corner, high } }
    }

    /// Where a point of the part lies.
    pub fn place(&self, p: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.turn.apply(p);
        [x + self.at[0], y + self.at[1]]
    }

    /// The middle of its extent.
    pub fn middle(&self) -> [f64; 2] {
        let Bounds { low, high } = self.bounds;
        [0, 1].map(|k| 0.5 * (low[k] + high[k]))
    }

    pub fn moved(&self, by: [f64; 2]) -> Self {
        let add = |p: [f64; 2]| [p[0] + by[0], p[1] + by[1]];
        let bounds = Bounds { low: add(self.bounds.low), high: add(self.bounds.high) };
        Self { at: add(self.at), bounds, ..*self }
    }
}

impl Part {
    /// Whether it has the outlines and turns of another part.
    pub fn is_copy_of(&self, other: &Self) -> bool {
        self.rim == other.rim
            && self.fits == other.fits
            && self.slack.to_bits() == other.slack.to_bits()
    }

    /// `None` where the shape fits the stock in no turn.
    pub fn new(
        shape: usize,
        polygon: &NestShape,
        params: &NestParams,
        room: &Room,
    ) -> Option<Self> {
        let hull = plane::convex_hull(polygon.outlines.iter().flatten().copied());
        let spread = hull.iter().map(|&p| size(minus(p, hull[0]))).fold(0.0, f64::max);
        let bounds = Bounds::around(hull.iter().copied());
        let diameter = size(minus(bounds.high, bounds.low)).min(2.0 * spread);
        let (rim, slack) = simple_rim(&polygon.outlines, diameter);
        let mirrors: &[bool] = if polygon.may_mirror { &[false, true] } else { &[false] };
        let turn = |angle: f64, is_mirrored: bool| {
            let upright = if is_mirrored { -polygon.upright } else { polygon.upright };
            Turn::new(upright + angle, is_mirrored)
        };
        let both = |angles: &[f64]| -> Vec<Turn> {
            mirrors.iter().flat_map(|&m| angles.iter().map(move |&a| turn(a, m))).collect()
        };
        let mut part = Self {
            shape,
            area: polygon.area(),
            diameter,
            hull,
            rim,
            slack,
            fits: Vec::new(),
            turns: Vec::new(),
            may_mirror: polygon.may_mirror,
            jitter: params.tolerance_deg.to_radians(),
        };
        let tried = if let Some(angles) = params.rotations.turns() {
            part.turns = both(&angles);
            part.turns.clone()
        } else {
            let lying = smallest_rectangle(&part.hull);
            let eighth = |k: u32| FRAC_PI_2 * f64::from(k % 4) + FRAC_PI_4 * f64::from(k / 4);
            let angles: Vec<f64> = (0..8).map(|k| lying + eighth(k)).collect();
            let turns = angles.iter().map(|&angle| Turn::new(angle, false));
            let turned_over = angles.iter().map(|&angle| Turn::new(-angle, true));
            turns.chain(turned_over.filter(|_| polygon.may_mirror)).collect()
        };
        part.fits = part.fitting(&tried, room);
        if part.fits.is_empty() {
            // Slanted as far as may be: a strip may fit along a diagonal.
            let reach = if part.turns.is_empty() { 0.5 * TAU } else { part.jitter };
            if reach > 0.0 {
                let slanted: Vec<Turn> = tried
                    .iter()
                    .take(MOST_TURNS)
                    .flat_map(|t| {
                        (-180..=180).map(move |k| {
                            Turn::new(t.angle + reach * f64::from(k) / 180.0, t.is_mirrored)
                        })
                    })
                    .collect();
                part.fits = part.fitting(&slanted, room);
            }
        }
        // The smallest extents are likely to lie well; a stable sort keeps the order of equal ones.
        if part.fits.len() > MOST_TURNS {
            let area = |fit: &Fit| fit.size()[0] * fit.size()[1];
            part.fits.sort_by(|a, b| area(a).total_cmp(&area(b)));
            part.fits.truncate(MOST_TURNS);
        }
        (!part.fits.is_empty()).then_some(part)
    }

    fn fitting(&self, turns: &[Turn], room: &Room) -> Vec<Fit> {
        let fits = turns.iter().map(|&turn| self.fit(turn));
        fits.filter(|fit| room.fits(fit.size())).collect()
    }

    pub fn fit(&self, turn: Turn) -> Fit {
        Fit { turn, bounds: turn.bounds(&self.hull) }
    }

    /// Whether its turns are not a few fixed ones.
    pub fn turns_freely(&self) -> bool {
        self.turns.is_empty() || self.jitter > 0.0
    }

    /// A turn that is allowed; it need not fit.
    pub fn random_fit(&self, dice: &mut Dice) -> Fit {
        if !self.turns_freely() || dice.below(2) == 0 {
            return self.fits[dice.below(self.fits.len())];
        }
        if self.turns.is_empty() {
            let is_mirrored = self.may_mirror && dice.below(2) == 1;
            return self.fit(Turn::new(dice.between(0.0, TAU), is_mirrored));
        }
        let turn = self.turns[dice.below(self.turns.len())];
        let angle = turn.angle + dice.between(-self.jitter, self.jitter);
        self.fit(Turn::new(angle, turn.is_mirrored))
    }

    /// A turn a little further, as far as is allowed.
    pub fn turned(&self, turn: Turn, by: f64) -> Turn {
        let mut angle = turn.angle + by;
        if !self.turns.is_empty() {
            let off = |base: &Turn| {
                let rest = (angle - base.angle + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
                (rest.abs(), rest)
            };
            let same = self.turns.iter().filter(|base| base.is_mirrored == turn.is_mirrored);
            let nearest = same.map(off).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, rest)) = nearest {
                angle += rest.clamp(-self.jitter, self.jitter) - rest;
            }
        }
        Turn::new(angle, turn.is_mirrored)
    }

    /// The least height that it has in any turn, and the least side of an upright square around it; or less.
    pub fn least_extent(&self) -> [f64; 2] {
        if self.turns_freely() {
            let width = least_width(&self.hull);
            return [width, width.max(0.5 * SQRT_2 * self.spread())];
        }
        let least = |of: fn([f64; 2]) -> f64| {
            self.turns.iter().map(|&t| of(self.fit(t).size())).fold(f64::INFINITY, f64::min)
        };
        [least(|s| s[1]), least(|s| s[0].max(s[1]))]
    }

    /// A distance of two of its points.
    fn spread(&self) -> f64 {
        self.hull.iter().map(|&p| size(minus(p, self.hull[0]))).fold(0.0, f64::max)
    }
}

/// Outlines with about [`POINTS`] points, and how far they are off.
fn simple_rim(outlines: &[Vec<[f64; 2]>], diameter: f64) -> (Vec<Vec<[f64; 2]>>, f64) {
    let mut result = (Vec::new(), 0.0);
    for part in [0.0, 0.0625, 0.125, 0.25, 0.5, 1.0] {
        let tolerance = part * COARSEST * diameter;
        let rim: Vec<_> = outlines
            .iter()
            .filter(|outline| outline.len() > 2)
            .map(|outline| plane::simplify(outline, tolerance))
            .collect();
        let count: usize = rim.iter().map(Vec::len).sum();
        result = (rim, tolerance);
        if count <= POINTS {
            break;
        }
    }
    result
}

/// The least distance of two parallel lines around a hull: one of them lies along a side.
fn least_width(hull: &[[f64; 2]]) -> f64 {
    let across = plane::sides(hull).map(|[a, b]| {
        let along = minus(b, a);
        let heights = hull.iter().map(|&p| cross(along, minus(p, a)));
        heights.fold(0.0, f64::max) / size(along)
    });
    let least = across.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// The turn that gives a hull its smallest upright rectangle, lying.
fn smallest_rectangle(hull: &[[f64; 2]]) -> f64 {
    let mut best = (f64::INFINITY, 0.0);
    for [a, b] in plane::sides(hull) {
        let along = minus(b, a);
        let up = [-along[1], along[0]];
        let extent = |axis: [f64; 2]| {
            let at = hull.iter().map(|&p| dot(minus(p, a), axis));
            let (low, high) = at.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        let (width, height) = (extent(along), extent(up));
        let area = width * height / dot(along, along);
        if area < best.0 * (1.0 - 1e-12) {
            let lying = if height > width { FRAC_PI_2 } else { 0.0 };
            best = (area, lying - along[1].atan2(along[0]));
        }
    }
    best.1
}
