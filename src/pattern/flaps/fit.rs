//! Flaps where there is room: as large as wished, else slimmer, else lower.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::shape::{contains, meet, trapezoid, turn_left};
use super::stretches::Joint;
use super::{Base, Flap, FlapParams};
use crate::pattern::folds::Fold;
use crate::pattern::piece::{Bounds, Pattern};

/// A flap's angle stays this far below the partner's interior angle.
const BESIDE_PARTNER: f64 = 1.0 / 180.0 * std::f64::consts::PI;
/// Two flaps at one vertex, or a flap and the piece, are this far apart.
const BESIDE_FLAP: f64 = 2.0 / 180.0 * std::f64::consts::PI;
/// No flap is slimmer than this: it would not hold, and scissors would not follow.
const LEAST_ANGLE: f64 = 12.0 / 180.0 * std::f64::consts::PI;
/// Depth over length of the base.
const DEPTH_OF_LENGTH: f64 = 0.4;
/// Parts of the angles and of the depth that are tried.
const ANGLES: [f64; 5] = [1.0, 0.85, 0.7, 0.55, 0.4];
const DEPTHS: [f64; 4] = [1.0, 0.75, 0.5, 0.3];
/// A flap lower than this part of its base, or than 2 mm if that is less, does not hold.
const LEAST_DEPTH: f64 = 0.15;
const LEAST_DEPTH_MM: f64 = 2.0;

/// The flaps placed so far, and what they must not meet.
pub(super) struct Places<'a> {
    pattern: &'a Pattern,
    folds: &'a [Vec<Fold>],
    params: &'a FlapParams,
    /// All bases that are meant to have a flap.
    wanted: Vec<Base>,
    /// For each piece its flaps with the angles at the ends of their bases.
    placed: Vec<Vec<(Flap, [f64; 2])>>,
}

type Segment = [[f64; 2]; 2];

impl<'a> Places<'a> {
    pub(super) fn new(
        pattern: &'a Pattern,
        folds: &'a [Vec<Fold>],
        joints: &[Joint],
        sides: &[Vec<usize>],
        params: &'a FlapParams,
    ) -> Self {
        let mut wanted = Vec::new();
        for (joint, sides) in joints.iter().zip(sides) {
            for (stretch, &side) in joint.stretches.iter().zip(sides) {
                let is_wanted = |k: usize| k == side || params.side == super::FlapSide::Both;
                let bases = (0..2).filter(|&k| is_wanted(k)).filter_map(|k| stretch.bases[k]);
                wanted.extend(bases);
            }
        }
        let placed = vec![Vec::new(); pattern.pieces.len()];
        Self { pattern, folds, params, wanted, placed }
    }

    /// The flaps of each piece in the order of its seams.
    pub(super) fn into_flaps(self) -> Vec<Vec<Flap>> {
        let sorted = |placed: Vec<(Flap, [f64; 2])>| {
            let mut flaps: Vec<Flap> = placed.into_iter().map(|(flap, _)| flap).collect();
            let key = |f: &Flap| (f.base.seam, f.stretch.0);
            // Along the piece's own direction.
            flaps.sort_by_key(|f| (key(f).0, f.base.first));
            flaps
        };
        self.placed.into_iter().map(sorted).collect()
    }

    /// Flaps for some stretches of a seam, each on its side: all or none.
    pub(super) fn add_all(
        &mut self,
        joint: &Joint,
        stretches: &[usize],
        side: impl Fn(usize) -> usize,
    ) -> bool {
        let before: Vec<usize> = self.placed.iter().map(Vec::len).collect();
        let is_done = stretches.iter().all(|&k| self.add(joint, k, side(k)));
        if !is_done {
            for (placed, before) in self.placed.iter_mut().zip(before) {
                placed.truncate(before);
            }
        }
        is_done
    }

    /// A flap for a stretch on a side, if there is room for one.
    pub(super) fn add(&mut self, joint: &Joint, stretch: usize, side: usize) -> bool {
        let Some((flap, angles)) = self.flap(joint, stretch, side) else { return false };
        self.placed[flap.base.piece].push((flap, angles));
        true
    }

    fn flap(&self, joint: &Joint, stretch: usize, side: usize) -> Option<(Flap, [f64; 2])> {
        let count = joint.stretches.len();
        let on = &joint.stretches[stretch];
        let base = on.bases[side]?;
        let partner = on.bases[1 - side];
        let chord = base.chord(&self.pattern.pieces[base.piece]);
        let depth = self.params.depth_mm.min(DEPTH_OF_LENGTH * on.length_mm);
        let most = [0, 1].map(|end| self.most_angle(base, partner, end));
        if !(most.iter().all(|&angle| angle >= LEAST_ANGLE) && depth > 0.0) {
            return None;
        }
        let least_depth = (LEAST_DEPTH * on.length_mm).min(LEAST_DEPTH_MM);
        let own = self.lines(base, chord, 3.0 * depth);
        let under = partner.map(|partner| self.faces(partner));
        // A flap across a fold of its partner would have to be folded too: only where there is no other.
        for heeds_folds in [true, false] {
            for (d, a) in DEPTHS.iter().flat_map(|d| ANGLES.iter().map(move |a| (d, a))) {
                let angles = most.map(|angle| (a * angle).max(LEAST_ANGLE));
                let (points, height) = trapezoid(chord, angles, d * depth);
                if height >= least_depth
                    && self.is_free(base, &own, &points)
                    && under.as_ref().is_none_or(|under| under.holds(chord, &points, heeds_folds))
                {
                    let flap = Flap {
                        number: joint.number,
                        stretch: (stretch + 1, count),
                        base,
                        partner,
                        points,
                        depth_mm: height,
                        angle: on.angle,
                    };
                    return Some((flap, angles));
                }
            }
        }
        None
    }

    /// The largest angle that a flap may have at an end of its base.
    fn most_angle(&self, base: Base, partner: Option<Base>, end: usize) -> f64 {
        let mut most = self.params.angle.min(FRAC_PI_2);
        if let Some(partner) = partner {
            most = most.min(TAU - self.opening(partner, 1 - end) - BESIDE_PARTNER);
        }
        let piece = &self.pattern.pieces[base.piece];
        let at = base.ends(piece)[end];
        let opening = self.opening(base, end);
        let is_beside = |other: &Base| {
            let is_same = other.piece == base.piece && other.outline == base.outline;
            is_same && *other != base && other.ends(piece)[1 - end] == at
        };
        let placed = self.placed[base.piece].iter().find(|(flap, _)| is_beside(&flap.base));
        let share = match placed {
            Some((_, angles)) => opening - angles[1 - end] - BESIDE_FLAP,
            None if self.wanted.iter().any(is_beside) => 0.5 * (opening - BESIDE_FLAP),
            None => opening - BESIDE_FLAP,
        };
        most.min(share)
    }

    /// The angle outside the piece between the chord of a base and the side before it, or after it.
    fn opening(&self, base: Base, end: usize) -> f64 {
        let piece = &self.pattern.pieces[base.piece];
        let points = &piece.outlines[base.outline].points;
        let n = points.len();
        let at = base.ends(piece)[end];
        let beside = points[if end == 0 { (at + n - 1) % n } else { (at + 1) % n }];
        let [p, q] = base.chord(piece);
        let here = [p, q][end];
        let to = |x: [f64; 2]| [x[0] - here[0], x[1] - here[1]];
        if end == 0 { turn_left(to(beside), to(q)) } else { turn_left(to(p), to(beside)) }
    }

    /// The lines near a base that its flap must not meet: outlines and flaps of the piece.
    fn lines(&self, base: Base, chord: Segment, reach: f64) -> Vec<Segment> {
        let piece = &self.pattern.pieces[base.piece];
        let Bounds { low, high } = Bounds::around(chord);
        let is_near = |s: &Segment| {
            (0..2).all(|axis| {
                s[0][axis].min(s[1][axis]) <= high[axis] + reach
                    && s[0][axis].max(s[1][axis]) >= low[axis] - reach
            })
        };
        let mut lines = Vec::new();
        for outline in &piece.outlines {
            lines.extend(outline.sides().map(|(a, b)| [a, b]).filter(is_near));
        }
        for (flap, _) in &self.placed[base.piece] {
            lines.extend(flap.points.windows(2).map(|w| [w[0], w[1]]).filter(is_near));
        }
        lines
    }

    /// Whether a flap meets none of the lines, and lies neither in its piece nor in or around another flap.
    fn is_free(&self, base: Base, lines: &[Segment], points: &[[f64; 2]]) -> bool {
        let piece = &self.pattern.pieces[base.piece];
        let sides = points.windows(2).map(|w| [w[0], w[1]]);
        let inner = &points[1..points.len() - 1];
        let chord = [points[0], points[points.len() - 1]];
        if lines.iter().any(|&line| sides.clone().any(|side| meet(side, line)))
            || inner.iter().any(|&p| piece.contains(p))
        {
            return false;
        }
        // Nothing else may touch the chord: the other side of a slit would.
        let own = base.points_in(piece);
        let is_own = |line: &Segment| own.windows(2).any(|w| [w[0], w[1]] == *line);
        if lines.iter().any(|line| !is_own(line) && meet(chord, *line)) {
            return false;
        }
        let others = self.placed[base.piece].iter().map(|(flap, _)| &flap.points);
        !others.clone().any(|other| {
            inner.iter().any(|&p| contains(other, p))
                || other[1..other.len() - 1].iter().any(|&p| contains(points, p))
        })
    }

    fn faces(&self, base: Base) -> Under<'a> {
        let piece = &self.pattern.pieces[base.piece];
        let own = base.points_in(piece);
        let is_own = |line: &Segment| own.windows(2).any(|w| [w[0], w[1]] == *line);
        let sides = piece.outlines.iter().flat_map(|outline| outline.sides());
        let rim = sides.map(|(a, b)| [a, b]).filter(|line| !is_own(line)).collect();
        let folds = self.folds.get(base.piece).map_or(&[][..], Vec::as_slice).iter();
        let strong = folds.filter(|fold| fold.angle.abs() > self.params.fold_angle);
        let folds = strong.flat_map(|f| f.points.windows(2).map(|w| [w[0], w[1]])).collect();
        Under { pattern: self.pattern, base, chord: base.chord(piece), rim, folds }
    }
}

/// The piece that a flap is glued under.
struct Under<'a> {
    pattern: &'a Pattern,
    base: Base,
    chord: Segment,
    rim: Vec<Segment>,
    folds: Vec<Segment>,
}

impl Under<'_> {
    /// Whether a flap lies within the piece when glued, up to a hair at the ends of its base, and, if that matters, crosses no fold.
    fn holds(&self, chord: Segment, points: &[[f64; 2]], heeds_folds: bool) -> bool {
        let glued = self.glued(chord, points);
        let piece = &self.pattern.pieces[self.base.piece];
        let n = glued.len();
        if !glued[1..n - 1].iter().all(|&p| piece.contains(p)) {
            return false;
        }
        // The legs begin a little above the base: there the angles were compared already, and the two sides of a seam need
        // not be equally long in the plane.
        let mut line = glued.clone();
        for (end, inner) in [(0, 1), (n - 1, n - 2)] {
            line[end] = [0, 1].map(|i| glued[end][i] + 0.1 * (glued[inner][i] - glued[end][i]));
        }
        let folds = if heeds_folds { &self.folds[..] } else { &[] };
        let mut obstacles = self.rim.iter().chain(folds);
        !obstacles.any(|&other| line.windows(2).any(|w| meet([w[0], w[1]], other)))
    }

    /// Moves a flap so that its base lies on that of the partner, middle on middle.
    fn glued(&self, [p, q]: Segment, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        // The partner's runs the other way.
        let [end, start] = self.chord;
        let (from, to) = ([q[0] - p[0], q[1] - p[1]], [end[0] - start[0], end[1] - start[1]]);
        let size = from[0].hypot(from[1]) * to[0].hypot(to[1]);
        let cos = (from[0] * to[0] + from[1] * to[1]) / size;
        let sin = (from[0] * to[1] - from[1] * to[0]) / size;
        let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let (here, there) = (middle(p, q), middle(start, end));
        let moved = |x: &[f64; 2]| {
            let [dx, dy] = [x[0] - here[0], x[1] - here[1]];
            [there[0] + cos * dx - sin * dy, there[1] + sin * dx + cos * dy]
        };
        points.iter().map(moved).collect()
    }
}
