//! Where something is drawn on a sheet.

use super::super::drawn::{Stroke, drawn};
use super::super::piece::Bounds;
use super::super::sheet::{Layer, Line, Sheet, Text};
use super::letters;

/// Polylines and boxes of all that is drawn.
pub(super) struct Ink {
    /// Those of closed lines end where they begin.
    pub polylines: Vec<Vec<[f64; 2]>>,
    pub boxes: Vec<Bounds>,
    /// For each piece its closed cut lines, and the bounds of these.
    pub pieces: Vec<(Bounds, Vec<Vec<[f64; 2]>>)>,
    /// Around everything; a point if there is nothing.
    pub bounds: Bounds,
}

/// Title and control square, which pages have of their own.
pub(super) fn is_footer(id: &str) -> bool {
    id.starts_with("control-") || id.starts_with("title-")
}

/// The box of a text.
pub(super) fn text_box(text: &Text) -> Bounds {
    let width = letters::width(&text.text, text.height);
    let left = if text.is_left { text.at[0] } else { text.at[0] - 0.5 * width };
    let half = 0.5 * text.height;
    Bounds { low: [left, text.at[1] - half], high: [left + width, text.at[1] + half] }
}

impl Ink {
    /// Of the layers that are wanted, with or without title and control square.
    pub fn new(sheet: &Sheet, layers: &[Layer], has_footer: bool) -> Self {
        let is_wanted = |layer: Layer, id: &str| {
            layers.contains(&layer) && (has_footer || layer != Layer::Control || !is_footer(id))
        };
        let lines = || sheet.lines.iter().filter(|line| is_wanted(line.layer, &line.id));
        let texts = sheet.texts.iter().filter(|text| is_wanted(text.layer, &text.id));
        let around_again = |mut stroke: Stroke| {
            let joint = stroke.is_closed.then(|| stroke.points[0]);
            stroke.points.extend(joint);
            stroke.points
        };
        let polylines: Vec<Vec<[f64; 2]>> = lines().flat_map(drawn).map(around_again).collect();
        let boxes: Vec<Bounds> =
            texts.filter(|text| !text.text.trim().is_empty()).map(text_box).collect();
        let mut pieces: Vec<Vec<Vec<[f64; 2]>>> = vec![Vec::new(); sheet.pattern.pieces.len()];
        let is_cut = |line: &&Line| line.layer == Layer::Cut && line.is_closed;
        for line in lines().filter(is_cut) {
            if let Some(rings) = line.piece.and_then(|piece| pieces.get_mut(piece)) {
                rings.push(line.points.clone());
            }
        }
        let around = |rings: &Vec<Vec<[f64; 2]>>| Bounds::around(rings.iter().flatten().copied());
        let pieces = pieces.into_iter().filter(|rings| !rings.is_empty());
        let pieces = pieces.map(|rings| (around(&rings), rings)).collect();
        let corners = boxes.iter().flat_map(|b| [b.low, b.high]);
        let points: Vec<[f64; 2]> = polylines.iter().flatten().copied().chain(corners).collect();
        let bounds = if points.is_empty() {
            Bounds { low: [0.0; 2], high: [0.0; 2] }
        } else {
            Bounds::around(points)
        };
        Self { polylines, boxes, pieces, bounds }
    }

    /// Whether a point lies in a piece.
    pub fn is_inside(&self, p: [f64; 2]) -> bool {
        let near = self
            .pieces
            .iter()
            .filter(|(bounds, _)| (0..2).all(|a| (bounds.low[a]..=bounds.high[a]).contains(&p[a])));
        near.into_iter().any(|(_, rings)| {
            let sides = rings.iter().flat_map(|ring| {
                ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
            });
            let crossed = sides.filter(|[a, b]| {
                (a[1] > p[1]) != (b[1] > p[1])
                    && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            });
            crossed.count() % 2 == 1
        })
    }
}
