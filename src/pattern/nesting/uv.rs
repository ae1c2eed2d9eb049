//! Charts in the unit square of a texture, all at one scale, with a margin in pixels.

use super::flow::NestFlow;
use super::plane::Turn;
use super::{NestNotice, NestParams, NestPose, NestShape, Rotations, Stock};
use crate::methods::flow::{Flow, SolveError, Status};

/// What is asked of a packing of charts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UvPackParams {
    /// Side of the texture.
    pub pixels: u32,
    /// Least distance of two charts; half of it to the edge of the texture.
    pub margin_px: u32,
    /// Steps of improvement after the first layouts, each some 60 ms; 0 for none.
    pub steps: usize,
    /// For the random choices.
    pub seed: u64,
}

impl Default for UvPackParams {
    fn default() -> Self {
        Self { pixels: 1024, margin_px: 4, steps: 30, seed: 0 }
    }
}

/// Where charts lie in the unit square: x ↦ scale · turned x + shift.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UvPacking {
    /// One for each chart, with shifts in the unit square; no chart is mirrored.
    pub poses: Vec<NestPose>,
    /// Of all charts.
    pub scale: f64,
    /// Part of the unit square that is covered.
    pub utilisation: f64,
    /// Charts that are not laid.
    pub notices: Vec<NestNotice>,
}

impl UvPacking {
    /// Where a point of a chart comes to lie.
    pub fn apply(&self, chart: usize, p: [f64; 2]) -> [f64; 2] {
        let NestPose { angle, shift, is_mirrored, .. } = self.poses[chart];
        let turned = Turn::new(angle, is_mirrored).apply(p);
        [0, 1].map(|k| self.scale * turned[k] + shift[k])
    }
}

/// Side of the square in which charts are nested, before scaling: millimetres of nesting, whose tolerance is some 1e-9 of it.
const SIDE: f64 = 1000.0;
/// Sides tried, each larger than the one before, until the charts with their margins fit.
const SIDES: usize = 16;
/// Steps that lay on the raster.
const LAYOUTS: usize = 4;

/// Packs charts into the unit square in any turn, at one scale, as large as it finds.
///
/// **Takes** outlines of charts in any unit. **Gives** a packing that keeps the margins; empty for no charts. A layout of side s whose
/// charts are g apart has margins of g · pixels / s; g is chosen for a side somewhat larger than the one that is found. **Fails** where
/// charts and margins do not fit, because margins take up the whole texture.
pub fn pack_uv(shapes: &[NestShape], params: &UvPackParams) -> Result<UvPacking, SolveError> {
    SolveError::within("pixels", f64::from(params.pixels), 1.0, 1e6)?;
    let laid = shapes.iter().filter(|shape| shape.is_laid());
    let area: f64 = laid.map(NestShape::area).sum();
    if !(area > 0.0) {
        let notices = (0..shapes.len()).map(|shape| NestNotice::NoOutline { shape }).collect();
        let poses = vec![NestPose::default(); shapes.len()];
        return Ok(UvPacking { poses, scale: 1.0, utilisation: 0.0, notices });
    }
    let unit = SIDE / area.sqrt();
    let scaled: Vec<NestShape> = shapes
        .iter()
        .map(|shape| {
            let outlines = shape.outlines.iter();
            NestShape {
                outlines: outlines
                    .map(|o| o.iter().map(|p| p.map(|x| x * unit)).collect())
                    .collect(),
                upright: 0.0,
                may_mirror: false,
            }
        })
        .collect();
    let margin = f64::from(params.margin_px) / f64::from(params.pixels);
    let flow = |side: f64, steps: usize| -> Result<NestFlow, SolveError> {
        // A hair more, for what the check lets pass.
        let gap = margin * side + 2e-6;
        let nest = NestParams {
            stock: Stock::Free,
            gap_mm: gap,
            margin_mm: 0.5 * gap,
            rotations: Rotations::Free,
            tolerance_deg: 0.0,
            seed: params.seed,
            step_limit: steps,
            resolution_mm: 0.0,
        };
        let mut flow = NestFlow::new(&scaled, &nest)?;
        while flow.step()?.status == Status::Running {}
        Ok(flow)
    };
    let count = shapes.iter().filter(|shape| shape.is_laid()).count() as f64;
    // Disks as wide as the margin around a point of each chart do not overlap: they fill no more of the square than the densest
    // packing of disks, √3 π / 6.
    let refused = || {
        let value = f64::from(params.margin_px);
        let max = (f64::from(params.pixels) / count.sqrt()).floor();
        SolveError::Parameter { name: "margin_px", value, min: 0.0, max }
    };
    if count * margin * margin * 3.0_f64.sqrt() > 2.0 {
        return Err(refused());
    }
    let mut side = 1.25 * SIDE;
    let mut found = None;
    for _ in 0..SIDES {
        let flow = flow(side, 1)?;
        let cost = flow.state().cost_mm;
        if cost <= side {
            found = Some(flow.state().clone());
            break;
        }
        side = (1.02 * cost).max(1.1 * side);
    }
    let Some(mut best) = found else { return Err(refused()) };
    // The margin that belongs to this side is no larger.
    let better = flow(best.cost_mm, LAYOUTS + params.steps)?;
    if better.state().cost_mm < best.cost_mm {
        best = better.state().clone();
    }
    let side = best.cost_mm;
    let mut poses = best.poses;
    for pose in &mut poses {
        pose.shift = pose.shift.map(|x| x / side);
    }
    let scale = unit / side;
    Ok(UvPacking { poses, scale, utilisation: area * scale * scale, notices: best.notices })
}
