//! Room for texts inside a piece.

use super::piece::{Bounds, Piece, length};
use super::seam::Seam;

/// Width of a character over the height of capitals, generously: fonts differ.
const CHARACTER: f64 = 0.8;
/// Heights of capitals: no larger than needed, and as small as can be read in print.
const NAME_HEIGHTS: [f64; 2] = [1.2, 10.0];
const SEAM_HEIGHTS: [f64; 2] = [1.2, 3.0];
/// From one size that does not fit to the next.
const SMALLER: f64 = 0.85;
/// Places tried for a line on either side of the name.
const BESIDE: usize = 12;
/// Between a text and the outline.
const GAP: f64 = 1.0;
/// Where along a seam its label may stand; in the middle if it can.
const ALONG: [f64; 7] = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8];

/// Width of a text of that height of capitals.
pub(super) fn text_width(text: &str, height: f64) -> f64 {
    CHARACTER * height * text.chars().count() as f64
}

/// Places texts so that they cover neither one another nor the outline of their piece, as far as there is room. What does not
/// fit anywhere is written where it belongs all the same, as small as can be read: never left out.
pub(super) struct Labels<'a> {
    piece: &'a Piece,
    taken: Vec<Bounds>,
    /// Where the name stands.
    name: Option<Bounds>,
}

impl<'a> Labels<'a> {
    pub(super) fn new(piece: &'a Piece) -> Self {
        Self { piece, taken: Vec::new(), name: None }
    }

    /// Leaves room for a text that has a place already.
    pub(super) fn take(&mut self, at: [f64; 2], text: &str, height: f64) {
        self.taken.push(rectangle(at, text_width(text, height), height));
    }

    /// Leaves room for an upright line.
    pub(super) fn take_line(&mut self, from: [f64; 2], to: [f64; 2]) {
        let Bounds { low, high } = Bounds::around([from, to]);
        let [low, high] = [[low[0] - GAP, low[1]], [high[0] + GAP, high[1]]];
        self.taken.push(Bounds { low, high });
    }

    /// Abscissas to be tried for an upright line beside the name, the nearest first; the middle of the piece where it has no name.
    pub(super) fn beside_the_name(&self) -> Vec<f64> {
        let Some(Bounds { low, high }) = self.name else { return vec![self.piece.centre[0]] };
        let Bounds { low: left, high: right } = self.piece.bounds;
        let places = (0..BESIDE).flat_map(|k| {
            let t = k as f64 / BESIDE as f64;
            let near = 3.0 * GAP;
            [high[0] + near + t * (right[0] - high[0]), low[0] - near - t * (low[0] - left[0])]
        });
        places.collect()
    }

    /// Whether an upright line meets no text.
    pub(super) fn is_line_free(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        !self.taken.iter().any(|taken| is_met(taken, from, to))
    }

    /// Lines of text under one another about the centre of the piece: the middle of each, and its height. The first is
    /// as high as the room allows, the others 0.4 of it.
    pub(super) fn place_name(&mut self, lines: &[String]) -> Vec<([f64; 2], f64)> {
        let [smallest, largest] = NAME_HEIGHTS;
        let sizes = |height: f64| {
            let small = (0.4 * height).max(smallest);
            lines
                .iter()
                .enumerate()
                .map(move |(i, line)| (line, if i == 0 { height } else { small }))
        };
        let block = |height: f64| {
            let width = sizes(height).map(|(line, h)| text_width(line, h)).fold(0.0, f64::max);
            let total: f64 = sizes(height).map(|(_, h)| 1.4 * h).sum();
            rectangle(self.piece.centre, width, total)
        };
        let mut height = (0.5 * self.piece.room_mm).clamp(smallest, largest);
        while height > smallest && !self.is_free(&block(height)) {
            height = (SMALLER * height).max(smallest);
        }
        let taken = block(height);
        let mut top = taken.high[1];
        let places = sizes(height).map(|(_, h)| {
            top -= 1.4 * h;
            ([self.piece.centre[0], top + 0.7 * h], h)
        });
        let places = places.collect();
        self.taken.push(taken);
        self.name = Some(taken);
        places
    }

    /// A label beside its seam, inside the piece: its middle and its height.
    pub(super) fn place_beside(&mut self, seam: &Seam, label: &str) -> ([f64; 2], f64) {
        let points = self.piece.seam_points(seam);
        let [smallest, largest] = SEAM_HEIGHTS;
        // No wider than the seam is long.
        let mut height = (seam.length_mm / text_width(label, 1.0)).clamp(smallest, largest);
        loop {
            let width = text_width(label, height);
            let candidates = ALONG.map(|t| beside(&points, t * seam.length_mm, width, height));
            let free = candidates.iter().find(|&&at| self.is_free(&rectangle(at, width, height)));
            if free.is_some() || height <= smallest {
                let at = *free.unwrap_or(&candidates[0]);
                self.taken.push(rectangle(at, width, height));
                return (at, height);
            }
            height = (SMALLER * height).max(smallest);
        }
    }

    fn is_free(&self, bounds: &Bounds) -> bool {
        let centre = [0, 1].map(|a| 0.5 * (bounds.low[a] + bounds.high[a]));
        let sides = || self.piece.outlines.iter().flat_map(|outline| outline.sides());
        !self.taken.iter().any(|other| meet(other, bounds))
            && !sides().any(|(a, b)| is_met(bounds, a, b))
            && self.piece.contains(centre)
    }
}

/// The middle of an upright text beside a polyline, on its left, at an arc length.
pub(super) fn beside(points: &[[f64; 2]], arc_length: f64, width: f64, height: f64) -> [f64; 2] {
    // The direction over the width of the text, not that of one small side.
    let [before, at, after] =
        [-0.5, 0.0, 0.5].map(|shift| point_along(points, arc_length + shift * width));
    let [dx, dy] = unit(before, after);
    let normal = [-dy, dx];
    // As far inside as the box of the text reaches back, and a little more.
    let reach = 0.5 * (width * normal[0].abs() + height * normal[1].abs()) + GAP;
    [0, 1].map(|a| at[a] + reach * normal[a])
}

/// The point of a polyline at an arc length; its ends beyond them.
fn point_along(points: &[[f64; 2]], arc_length: f64) -> [f64; 2] {
    let mut rest = arc_length;
    for side in points.windows(2) {
        let step = length(side);
        if rest <= step {
            let t = if step > 0.0 { (rest / step).max(0.0) } else { 0.0 };
            return [0, 1].map(|a| side[0][a] + t * (side[1][a] - side[0][a]));
        }
        rest -= step;
    }
    points[points.len() - 1]
}

/// The direction from one point to another; along x where they are the same.
pub(super) fn unit(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let d = [to[0] - from[0], to[1] - from[1]];
    let size = d[0].hypot(d[1]);
    if size > 0.0 { d.map(|x| x / size) } else { [1.0, 0.0] }
}

fn rectangle(centre: [f64; 2], width: f64, height: f64) -> Bounds {
    let half = [0.5 * width, 0.5 * height];
    Bounds { low: [0, 1].map(|a| centre[a] - half[a]), high: [0, 1].map(|a| centre[a] + half[a]) }
}

pub(super) fn meet(a: &Bounds, b: &Bounds) -> bool {
    (0..2).all(|axis| a.low[axis] < b.high[axis] && b.low[axis] < a.high[axis])
}

/// Whether a segment has a point inside a rectangle: what its four sides leave of the segment.
pub(super) fn is_met(bounds: &Bounds, a: [f64; 2], b: [f64; 2]) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (low, high, step) =
            (bounds.low[axis] - a[axis], bounds.high[axis] - a[axis], b[axis] - a[axis]);
        if step == 0.0 {
            if low >= 0.0 || high <= 0.0 {
                return false;
            }
        } else {
            let (s, t) = (low / step, high / step);
            from = from.max(s.min(t));
            to = to.min(s.max(t));
        }
    }
    from < to
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_meets_a_rectangle_if_it_passes_through_it() {
        let square = Bounds { low: [0.0, 0.0], high: [2.0, 1.0] };
        for (a, b, meets) in [
            ([-1.0, 0.5], [3.0, 0.5], true),
            ([0.5, 0.5], [0.6, 0.6], true),
            ([1.0, -5.0], [1.0, 5.0], true),
            ([-1.0, 1.0], [1.0, 3.0], false),
            ([3.0, -1.0], [3.0, 2.0], false),
            ([-1.0, 0.5], [-0.5, 0.5], false),
            ([-0.1, 0.9], [0.2, 1.2], false),
            ([-0.1, 0.7], [0.4, 1.2], true),
        ] {
            assert_eq!(is_met(&square, a, b), meets, "{a:?} {b:?}");
            assert_eq!(is_met(&square, b, a), meets, "{b:?} {a:?}");
        }
    }
}
