//! Numbers on flaps, and where they are glued.

use super::Flap;
use super::shape::contains;
use crate::pattern::labels::{beside, text_width};
use crate::pattern::piece::{Pattern, length};

/// Heights of the numbers, mm.
const HEIGHTS: [f64; 3] = [3.0, 2.5, 2.0];

/// A number on a flap, or inside the piece that the flap is glued to.
#[derive(Clone, Debug, PartialEq)]
pub struct FlapLabel {
    /// Index of the piece that it is written on.
    pub piece: usize,
    /// Index of the seam of that piece.
    pub seam: usize,
    /// Whether it stands on a flap.
    pub is_on_flap: bool,
    /// Its middle, mm.
    pub at: [f64; 2],
    /// Height of the digits, mm.
    pub height: f64,
    /// The number of the seam, and after a point that of the tooth where there are several.
    pub text: String,
}

/// Numbers for flaps and their partners, the same on both.
///
/// Flaps on which no number of 2 mm fits have none, except that the largest flap of each seam always has one. **Gives** labels by piece and
/// seam of the flap, that of its partner behind each.
pub fn flap_labels(pattern: &Pattern, flaps: &[Vec<Flap>]) -> Vec<FlapLabel> {
    let mut labels = Vec::new();
    let area = |flap: &Flap| {
        let n = flap.points.len();
        let cross = |i: usize| {
            let (a, b) = (flap.points[i], flap.points[(i + 1) % n]);
            a[0] * b[1] - a[1] * b[0]
        };
        (0..n).map(cross).sum::<f64>().abs()
    };
    let all = || flaps.iter().flatten();
    let seams = all().map(|flap| flap.number).max().unwrap_or(0);
    let mut largest: Vec<Option<(f64, &Flap)>> = vec![None; seams + 1];
    for flap in all() {
        let best = &mut largest[flap.number];
        if best.is_none_or(|(most, _)| area(flap) > most) {
            *best = Some((area(flap), flap));
        }
    }
    for flap in all() {
        let text = match flap.stretch {
            (_, 1) => flap.number.to_string(),
            (stretch, _) => format!("{}.{stretch}", flap.number),
        };
        let at = middle(&flap.points);
        let fits = |height: &f64| {
            corners(at, text_width(&text, *height), *height).iter().all(|&p| contains_flap(flap, p))
        };
        let fitting = HEIGHTS.into_iter().find(fits);
        let is_largest = largest[flap.number].is_some_and(|(_, best)| best == flap);
        if fitting.is_none() && !is_largest {
            continue;
        }
        let height = fitting.unwrap_or(HEIGHTS[HEIGHTS.len() - 1]);
        let (piece, seam) = (flap.base.piece, flap.base.seam);
        labels.push(FlapLabel { piece, seam, is_on_flap: true, at, height, text: text.clone() });
        let Some(partner) = flap.partner else { continue };
        let points = partner.points(pattern);
        let half = 0.5 * length(&points);
        let place = |height: f64| beside(&points, half, text_width(&text, height), height);
        let on = &pattern.pieces[partner.piece];
        let is_inside = |height: &f64| {
            corners(place(*height), text_width(&text, *height), *height)
                .iter()
                .all(|&p| on.contains(p))
        };
        let height = HEIGHTS
            .into_iter()
            .filter(|h| *h <= height)
            .find(is_inside)
            .unwrap_or(HEIGHTS[HEIGHTS.len() - 1]);
        let (piece, seam) = (partner.piece, partner.seam);
        labels.push(FlapLabel { piece, seam, is_on_flap: false, at: place(height), height, text });
    }
    labels
}

fn contains_flap(flap: &Flap, p: [f64; 2]) -> bool {
    contains(&flap.points, p)
}

/// Centre of gravity of a flap: half way up a trapezoid, a third up a triangle.
fn middle(points: &[[f64; 2]]) -> [f64; 2] {
    let o = points[0];
    let (mut weight, mut sum) = (0.0, [0.0; 2]);
    for w in points[1..].windows(2) {
        let [a, b] = [w[0], w[1]].map(|p| [p[0] - o[0], p[1] - o[1]]);
        let area = a[0] * b[1] - a[1] * b[0];
        weight += area;
        sum = [0, 1].map(|i| sum[i] + area * (a[i] + b[i]) / 3.0);
    }
    [0, 1].map(|i| o[i] + sum[i] / weight)
}

fn corners(at: [f64; 2], width: f64, height: f64) -> [[f64; 2]; 4] {
    let [x, y] = at;
    let (w, h) = (0.5 * width, 0.5 * height);
    [[x - w, y - h], [x + w, y - h], [x + w, y + h], [x - w, y + h]]
}
