//! What is laid, and what a layout comes to.

use super::part::{Part, Spot};
use super::plane::Turn;
use super::room::Room;
use super::{NestNotice, NestParams, NestPose, NestShape, Stock};
use crate::pattern::piece::Bounds;

/// A layout that has passed [`check`](super::check).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NestState {
    /// One for each shape; all zero for a shape that is not laid.
    pub poses: Vec<NestPose>,
    /// Sheets used, those of pieces that are too large not counted; they come after these.
    pub sheets: usize,
    /// Width and height of what is used of the last sheet, margins included, mm.
    pub used_mm: [f64; 2],
    /// What is made small: the length used of a roll; for sheets their heights, of the last one only what is used; the side of a square.
    pub cost_mm: f64,
    /// Area of the pieces (not those that are too large) over the area of stock used: width × length of a roll; whole sheets, the last
    /// one up to the height used; the rectangle around all pieces and the margin.
    pub utilisation: f64,
    /// What to tell a person.
    pub notices: Vec<NestNotice>,
}

/// Shapes, sorted by whether they can be laid.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    pub params: NestParams,
    pub shapes: Vec<NestShape>,
    pub room: Room,
    pub parts: Vec<Part>,
    too_large: Vec<usize>,
    none: Vec<usize>,
}

impl Laid {
    pub fn new(shapes: &[NestShape], params: &NestParams) -> Self {
        let room = Room::new(params);
        let (mut parts, mut too_large, mut none) = (Vec::new(), Vec::new(), Vec::new());
        for (index, shape) in shapes.iter().enumerate() {
            if !shape.is_laid() {
                none.push(index);
            } else if let Some(part) = Part::new(index, shape, params, &room) {
                parts.push(part);
            } else {
                too_large.push(index);
            }
        }
        Self { params: *params, shapes: shapes.to_vec(), room, parts, too_large, none }
    }

    /// The state of a layout.
    pub fn state(&self, spots: &[Spot]) -> NestState {
        let mut poses = vec![NestPose::default(); self.shapes.len()];
        let mut notices: Vec<NestNotice> =
            self.none.iter().map(|&shape| NestNotice::NoOutline { shape }).collect();
        let sheets = spots.iter().map(|spot| spot.sheet + 1).max().unwrap_or(0);
        for (part, spot) in self.parts.iter().zip(spots) {
            poses[part.shape] = NestPose {
                angle: spot.turn.angle,
                shift: spot.at,
                is_mirrored: spot.turn.is_mirrored,
                sheet: spot.sheet,
                is_too_large: false,
            };
            if let Stock::Sheet { most, .. } = self.params.stock
                && spot.sheet >= most
            {
                notices.push(NestNotice::NoRoom { shape: part.shape });
            }
        }
        for (&shape, sheet) in self.too_large.iter().zip(sheets..) {
            // Upright, with its low corner at the margin.
            let angle = self.shapes[shape].upright;
            let turn = Turn::new(angle, false);
            let points = self.shapes[shape].outlines.iter().flatten();
            let Bounds { low, .. } = Bounds::around(points.map(|&p| turn.apply(p)));
            let shift = low.map(|x| self.room.margin - x);
            poses[shape] = NestPose { angle, shift, is_mirrored: false, sheet, is_too_large: true };
            notices.push(NestNotice::TooLarge { shape });
        }
        notices.sort_by_key(|notice| match *notice {
            NestNotice::TooLarge { shape }
            | NestNotice::NoRoom { shape }
            | NestNotice::NoOutline { shape } => shape,
        });
        let on_last = spots.iter().filter(|spot| spot.sheet + 1 == sheets);
        let used_mm = [0, 1].map(|k| {
            let high = on_last.clone().map(|s| s.bounds.high[k]).fold(0.0, f64::max);
            if sheets > 0 { high + self.room.margin } else { 0.0 }
        });
        let cost_mm = self.room.cost(spots);
        let area: f64 = self.parts.iter().map(|part| part.area).sum();
        let stock = match self.params.stock {
            Stock::Roll { width_mm } | Stock::Sheet { width_mm, .. } => width_mm * cost_mm,
            Stock::Free => used_mm[0] * used_mm[1],
        };
        let utilisation = if stock > 0.0 { area / stock } else { 0.0 };
        NestState { poses, sheets, used_mm, cost_mm, utilisation, notices }
    }
}
