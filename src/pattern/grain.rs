//! Grain lines: how a piece lies on the thread, the pile or the rolling direction of its material.
//!
//! On a line in the direction of the grain, the parts that lie within the piece with a little room on both sides are intervals: those that
//! no outline leaves blocked. The grain line is the middle of such an interval, as near to the centre of the piece as half of the piece's
//! extent fits, else the longest that there is.

use super::piece::Outline;

/// How grain lines are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainParams {
    /// The direction of the material on the sheet; of any length but 0.
    pub direction: [f64; 2],
    /// Whether there is only one arrow head, for materials with nap or pile.
    pub has_nap: bool,
}

impl Default for GrainParams {
    fn default() -> Self {
        Self { direction: [0.0, 1.0], has_nap: false }
    }
}

/// The grain line of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Where it begins.
    pub from: [f64; 2],
    /// Where it ends: the head that nap has.
    pub to: [f64; 2],
    /// Whether there is a head at `from` too.
    pub is_double: bool,
    /// Whether it is at least half as long as the piece and 25 mm, where the piece is that long.
    pub is_long: bool,
}

/// Length of the arrow heads, and half their width.
const HEAD_MM: f64 = 3.0;
const HALF_WIDTH_MM: f64 = 1.2;
/// Between grain line and outline.
const GAP_MM: f64 = 2.0;
/// Shortest that is drawn, and shortest wanted where there is room.
const LEAST_MM: f64 = 2.0 * HEAD_MM;
const WANTED_MM: f64 = 25.0;
/// Part of the free length that is used where that is longer than all else asks for.
const OF_ROOM: f64 = 0.6;
/// Lines that are tried to either side of the centre.
const TRIES: usize = 48;

impl Grain {
    /// The line and the two strokes of each head.
    pub fn lines(&self) -> Vec<Vec<[f64; 2]>> {
        let [dx, dy] = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let size = dx.hypot(dy);
        let (x, y) = (dx / size, dy / size);
        let head = |[px, py]: [f64; 2], sign: f64| {
            let stroke = |side: f64| {
                let (back, aside) = (-sign * HEAD_MM, side * HALF_WIDTH_MM);
                [px + back * x - aside * y, py + back * y + aside * x]
            };
            vec![stroke(1.0), [px, py], stroke(-1.0)]
        };
        let mut lines = vec![vec![self.from, self.to], head(self.to, 1.0)];
        if self.is_double {
            lines.push(head(self.from, -1.0));
        }
        lines
    }
}

/// The grain line of a piece.
///
/// **Takes** the outlines of a piece as they lie and a place well inside it ([`super::Piece::centre`]). **Gives** `None` where not even 6 mm
/// fit anywhere. **Costs** O(n) for each of about a hundred lines.
pub fn grain(outlines: &[Outline], centre: [f64; 2], params: &GrainParams) -> Option<Grain> {
    let [dx, dy] = params.direction;
    let size = dx.hypot(dy);
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    // Turned so that the grain is upright, and back.
    let (x, y) = (dx / size, dy / size);
    let upright = |p: [f64; 2]| [p[0] * y - p[1] * x, p[0] * x + p[1] * y];
    let back = |p: [f64; 2]| [p[0] * y + p[1] * x, p[1] * y - p[0] * x];
    let sides: Vec<[[f64; 2]; 2]> =
        outlines.iter().flat_map(Outline::sides).map(|(a, b)| [upright(a), upright(b)]).collect();
    let extent = |axis: usize| {
        let ends = || sides.iter().flatten().map(|p| p[axis]);
        (ends().fold(f64::INFINITY, f64::min), ends().fold(f64::NEG_INFINITY, f64::max))
    };
    let ((left, right), (low, high)) = (extent(0), extent(1));
    if !(right > left && high > low) {
        return None;
    }
    let centre = upright(centre);
    let wanted = (0.5 * (high - low)).max(WANTED_MM.min(high - low - 2.0 * GAP_MM));
    let mut best: Option<(f64, [f64; 2])> = None;
    for k in 0..=2 * TRIES {
        // From the centre outwards, to both sides in turn.
        let step = k.div_ceil(2) as f64 / TRIES as f64;
        let to = if k % 2 == 0 { left } else { right };
        let at = centre[0] + step * (to - centre[0]);
        for [from, to] in free(&sides, at) {
            // On the centre's own line the part with the centre in it comes first, if it is long enough.
            let has_centre = k == 0 && from < centre[1] && centre[1] < to;
            let room = to - from;
            let is_better = best.is_none_or(|(most, _)| {
                most < wanted && room > most || has_centre && room >= wanted
            });
            if is_better {
                best = Some((room, [at, 0.5 * (from + to)]));
            }
        }
    }
    let (room, [at, middle]) = best.filter(|(room, _)| *room >= LEAST_MM)?;
    let half = 0.5 * wanted.max(OF_ROOM * room).min(room);
    Some(Grain {
        from: back([at, middle - half]),
        to: back([at, middle + half]),
        is_double: !params.has_nap,
        is_long: room >= wanted,
    })
}

/// The parts of an upright line that lie within outlines with room on all sides.
fn free(sides: &[[[f64; 2]; 2]], at: f64) -> Vec<[f64; 2]> {
    let reach = HALF_WIDTH_MM + 0.5 * GAP_MM;
    // What each side blocks: its part in the strip about the line.
    let blocked = sides.iter().filter_map(|[a, b]| {
        let (low, high) = (a[0].min(b[0]).max(at - reach), a[0].max(b[0]).min(at + reach));
        if low > high {
            return None;
        }
        let y = |x: f64| {
            let t = ((x - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
            a[1] + t * (b[1] - a[1])
        };
        let is_upright = !((b[0] - a[0]).abs() > 0.0);
        let ends = if is_upright { [a[1], b[1]] } else { [y(low), y(high)] };
        Some([ends[0].min(ends[1]) - GAP_MM, ends[0].max(ends[1]) + GAP_MM])
    });
    let mut blocked: Vec<[f64; 2]> = blocked.collect();
    blocked.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut free = Vec::new();
    let mut reached = f64::NEG_INFINITY;
    for [from, to] in blocked {
        if from > reached && reached.is_finite() {
            free.push([reached, from]);
        }
        reached = reached.max(to);
    }
    let is_inside = |[from, to]: &[f64; 2]| {
        let y = 0.5 * (from + to);
        let above = sides.iter().filter(|[a, b]| {
            (a[0] > at) != (b[0] > at) && a[1] + (at - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) > y
        });
        above.count() % 2 == 1
    };
    free.retain(is_inside);
    free
}
