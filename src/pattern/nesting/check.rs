//! Whether a layout may be cut as it stands: by distances of outlines alone, whatever made it.

use std::fmt;

use super::placed::{Placed, overlap, rim_distance};
use super::plane;
use super::{NestParams, NestPose, NestShape, Stock};
use crate::pattern::piece::Bounds;

/// Distances may fall short by this much, mm: a thousandth of what any cutter knows, and a million times the rounding of a
/// metre. Without it pieces that touch would fail by their last digit.
pub const CHECK_TOLERANCE_MM: f64 = 1e-6;

/// A turn may be off by this much, radians: rounding.
const TURN_TOLERANCE: f64 = 1e-9;

/// What is wrong with a layout. Shapes are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NestFault {
    /// There is not one pose for each shape.
    Count {
        /// Shapes.
        shapes: usize,
        /// Poses.
        poses: usize,
    },
    /// A pose is not finite.
    NotFinite {
        /// The shape.
        shape: usize,
    },
    /// The grain does not allow the turn.
    Turned {
        /// The shape.
        shape: usize,
        /// Degrees from the nearest turn that is allowed.
        by_deg: f64,
    },
    /// The shape must not be turned over.
    Mirrored {
        /// The shape.
        shape: usize,
    },
    /// The shape reaches over the margin.
    Outside {
        /// The shape.
        shape: usize,
        /// How far.
        by_mm: f64,
    },
    /// A roll, or stock without limit, has one sheet.
    NoSuchSheet {
        /// The shape.
        shape: usize,
        /// Where it lies.
        sheet: usize,
    },
    /// A shape that is too large for the stock is not alone on its sheet.
    NotAlone {
        /// The shape.
        shape: usize,
        /// Another on its sheet.
        other: usize,
    },
    /// Two shapes are closer than the gap.
    TooClose {
        /// The shapes.
        shapes: [usize; 2],
        /// Their distance.
        distance_mm: f64,
        /// Where, on the sheet.
        at: [f64; 2],
    },
    /// Two shapes overlap.
    Overlap {
        /// The shapes.
        shapes: [usize; 2],
        /// Where, on the sheet.
        at: [f64; 2],
    },
}

impl fmt::Display for NestFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Count { shapes, poses } => write!(f, "{poses} poses for {shapes} pieces"),
            Self::NotFinite { shape } => write!(f, "piece {} lies nowhere", shape + 1),
            Self::Turned { shape, by_deg } => {
                write!(f, "piece {} is turned {by_deg:.3}° off its grain", shape + 1)
            }
            Self::Mirrored { shape } => write!(f, "piece {} is turned over", shape + 1),
            Self::Outside { shape, by_mm } => {
                write!(f, "piece {} reaches {by_mm:.3} mm over the margin", shape + 1)
            }
            Self::NoSuchSheet { shape, sheet } => {
                write!(f, "piece {} lies on sheet {} of one", shape + 1, sheet + 1)
            }
            Self::NotAlone { shape, other } => {
                write!(f, "piece {} is too large, but shares a sheet with {}", shape + 1, other + 1)
            }
            Self::TooClose { shapes: [a, b], distance_mm, at: [x, y] } => write!(
                f,
                "pieces {} and {} are {distance_mm:.3} mm apart at {x:.1}, {y:.1} mm",
                a + 1,
                b + 1
            ),
            Self::Overlap { shapes: [a, b], at: [x, y] } => {
                write!(f, "pieces {} and {} overlap at {x:.1}, {y:.1} mm", a + 1, b + 1)
            }
        }
    }
}

/// Whether all shapes keep the gap, the margin and the grain, to [`CHECK_TOLERANCE_MM`]; a shape may lie in a hole of another.
///
/// **Takes** shapes as nested, and a pose for each; shapes without a finite outline are passed over. **Gives** the first fault by
/// number of shape. Crossings are decided by exact predicates on the rounded places of points. Where the gap is 0 and outlines may
/// touch, depth of overlap is measured at their points, at where they come within reach of one another, and at three places
/// between. **Costs** about O(n log n) for outlines that are near each other only here and there.
pub fn check(
    shapes: &[NestShape],
    poses: &[NestPose],
    params: &NestParams,
) -> Result<(), NestFault> {
    if shapes.len() != poses.len() {
        return Err(NestFault::Count { shapes: shapes.len(), poses: poses.len() });
    }
    let mut placed = Vec::new();
    for (shape, (polygon, pose)) in shapes.iter().zip(poses).enumerate() {
        if polygon.is_laid() {
            check_pose(shape, polygon, pose, params)?;
            let placed_shape = Placed::new(shape, polygon, pose);
            check_margin(&placed_shape, pose, params)?;
            placed.push(placed_shape);
        }
    }
    placed.sort_by(|a, b| a.sheet.cmp(&b.sheet).then(a.bounds.low[0].total_cmp(&b.bounds.low[0])));
    let mut first: Option<NestFault> = None;
    let mut order = [usize::MAX; 2];
    for (i, a) in placed.iter().enumerate() {
        let beside = placed[i + 1..].iter().take_while(|b| b.sheet == a.sheet);
        for b in beside {
            let (a, b) = if a.shape < b.shape { (a, b) } else { (b, a) };
            if [a.shape, b.shape] < order
                && let Some(fault) = check_pair(a, b, poses, params.gap_mm)
            {
                first = Some(fault);
                order = [a.shape, b.shape];
            }
        }
    }
    first.map_or(Ok(()), Err)
}

impl NestShape {
    /// Whether it can be laid at all: points, all of them finite.
    pub(super) fn is_laid(&self) -> bool {
        let is_finite = self.outlines.iter().flatten().flatten().all(|x| x.is_finite());
        is_finite && self.upright.is_finite() && self.area() > 0.0
    }

    /// Area within the outlines, mm².
    pub fn area(&self) -> f64 {
        self.outlines.iter().map(|outline| plane::area(outline)).sum()
    }
}

fn check_pose(
    shape: usize,
    polygon: &NestShape,
    pose: &NestPose,
    params: &NestParams,
) -> Result<(), NestFault> {
    if !pose.angle.is_finite() || !pose.shift.iter().all(|x| x.is_finite()) {
        return Err(NestFault::NotFinite { shape });
    }
    if pose.is_mirrored && !polygon.may_mirror {
        return Err(NestFault::Mirrored { shape });
    }
    // Grain along φ from up is along −φ in the mirror.
    let upright = if pose.is_mirrored { -polygon.upright } else { polygon.upright };
    let off = params.rotations.off(pose.angle - upright);
    if off > params.tolerance_deg.to_radians() + TURN_TOLERANCE {
        return Err(NestFault::Turned { shape, by_deg: off.to_degrees() });
    }
    Ok(())
}

fn check_margin(placed: &Placed, pose: &NestPose, params: &NestParams) -> Result<(), NestFault> {
    if pose.is_too_large {
        return Ok(());
    }
    if pose.sheet > 0 && !matches!(params.stock, Stock::Sheet { .. }) {
        return Err(NestFault::NoSuchSheet { shape: placed.shape, sheet: pose.sheet });
    }
    let margin = params.margin_mm;
    let high = match params.stock {
        Stock::Roll { width_mm } => [width_mm, f64::INFINITY],
        Stock::Sheet { width_mm, height_mm, .. } => [width_mm, height_mm],
        Stock::Free => [f64::INFINITY; 2],
    };
    let Bounds { low, high: top } = placed.bounds;
    let over = (0..2).map(|k| (margin - low[k]).max(top[k] - (high[k] - margin)));
    let by_mm = over.fold(0.0, f64::max);
    if by_mm > CHECK_TOLERANCE_MM {
        return Err(NestFault::Outside { shape: placed.shape, by_mm });
    }
    Ok(())
}

fn check_pair(a: &Placed, b: &Placed, poses: &[NestPose], gap: f64) -> Option<NestFault> {
    let shapes = [a.shape, b.shape];
    for (shape, other) in [(a.shape, b.shape), (b.shape, a.shape)] {
        if poses[shape].is_too_large {
            return Some(NestFault::NotAlone { shape, other });
        }
    }
    let is_apart = |k: usize| {
        a.bounds.low[k] >= b.bounds.high[k] + gap || b.bounds.low[k] >= a.bounds.high[k] + gap
    };
    if is_apart(0) || is_apart(1) {
        return None;
    }
    let least = gap - CHECK_TOLERANCE_MM;
    if least <= 0.0 {
        let deepest = -least;
        return overlap(a, b, deepest).map(|at| NestFault::Overlap { shapes, at });
    }
    let (distance_mm, at) = rim_distance(a, b, gap);
    if distance_mm >= least {
        // The rims are apart, so that a point tells for all: outer outlines come first.
        let within = [(a, b), (b, a)].into_iter().find_map(|(a, b)| {
            let p = a.outlines[0][0];
            b.contains(p).then_some(p)
        });
        return within.map(|at| NestFault::Overlap { shapes, at });
    }
    Some(if distance_mm > 0.0 {
        NestFault::TooClose { shapes, distance_mm, at }
    } else {
        NestFault::Overlap { shapes, at }
    })
}
