//! Outlines that charts are given instead of their true length: round or rectangular.

use nalgebra::{Point2, Vector2};

use super::charting::ChartError;
use super::text::plural;
use crate::flatten::targets::{Interior, RimTarget, TargetSolver};
use crate::flatten::{Flattening, measure};
use crate::geometry::Geometry;
use crate::mesh::{FaceId, OpenedMesh, VertexId};

/// What the outline of every chart is to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outline {
    /// As long as on the surface.
    #[default]
    TrueLength,
    /// A circle.
    Disk,
    /// A rectangle.
    Rectangle,
}

impl Outline {
    /// By the identifier of the option.
    pub fn of(id: &str) -> Self {
        match id {
            "disk" => Self::Disk,
            "rectangle" => Self::Rectangle,
            _ => Self::TrueLength,
        }
    }

    /// Gives all charts this outline.
    ///
    /// **Takes** charts with isometric rims, from which the corners of rectangles are chosen, unless four are given (of the one patch that has
    /// them on its rim; other charts get corners of their own). **Gives** what a person should know of it.
    pub(super) fn shape(
        self,
        opened: &OpenedMesh,
        geometry: &Geometry,
        flattening: &mut Flattening,
        corners: &[VertexId],
    ) -> Result<Option<String>, ChartError> {
        if self == Self::TrueLength {
            return Ok(None);
        }
        let mut raised = 0;
        for patch in 0..flattening.charts.len() {
            if flattening.charts[patch].is_err() {
                continue;
            }
            let mut solver = TargetSolver::new(opened, geometry, patch)?;
            let rim: Vec<VertexId> = solver.rim().iter().map(|&h| opened.mesh.tail(h)).collect();
            let target = match self {
                Self::TrueLength => RimTarget::Isometric,
                Self::Disk => RimTarget::Disk,
                Self::Rectangle if corners.iter().any(|corner| rim.contains(corner)) => {
                    RimTarget::Rectangle(corners.to_vec())
                }
                Self::Rectangle => {
                    let outline: Vec<_> = rim.iter().map(|v| flattening.uv[v.index()]).collect();
                    // A triangle has no four corners: it stays as it is.
                    let Some(corners) = best_corners(&outline) else { continue };
                    RimTarget::Rectangle(corners.map(|i| rim[i]).to_vec())
                }
            };
            let chart = solver.flatten(&target, Interior::Harmonic)?;
            solver.put(&chart, &target, flattening);
            raised += usize::from(chart.is_raised);
        }
        Ok(self.warning(opened, geometry, flattening, raised))
    }

    /// What such an outline did to triangles.
    fn warning(
        self,
        opened: &OpenedMesh,
        geometry: &Geometry,
        flattening: &Flattening,
        raised: usize,
    ) -> Option<String> {
        let mesh = &opened.mesh;
        let totals = measure(opened, geometry, flattening).totals;
        let mut sentences = Vec::new();
        // Between corners the outline is straight: what it runs around on one side is flat.
        let is_along = |f: &FaceId| {
            let [p, q, r] = mesh.face_vertices(*f).map(|v| flattening.uv[v.index()]);
            (q - p).perp(&(r - p)).abs() <= 1e-9 * geometry.face_areas[f.index()]
        };
        let along = match self {
            Self::Rectangle => mesh.faces().filter(is_along).count(),
            _ => 0,
        };
        if along > 0 {
            sentences.push(format!(
                "{} flat on a straight side, whatever the map: remesh the surface, under Prepare or by the command prepare with --tool remesh, or choose another outline.",
                if along == 1 { "1 triangle lies".to_owned() } else { format!("{along} triangles lie") }
            ));
        }
        if raised > 0 {
            sentences.push(format!(
                "Harmonic coordinates turn triangles of {} over: edges got other weights there, and angles change.",
                plural(raised, "piece")
            ));
        }
        if totals.angle_distortion > MUCH {
            sentences.push(format!(
                "Such an outline distorts angles {:.1}-fold on average here: its shape is far from that of the piece. Outlines of true length do not.",
                totals.angle_distortion
            ));
        }
        (!sentences.is_empty()).then(|| sentences.join(" "))
    }
}

/// Mean angle distortion beyond which an outline is not what anybody wants: a face scan as a disk has 1.04. Less, and pieces that fit well are
/// warned of; more, and strips are not.
const MUCH: f64 = 1.5;

/// The corners of an outline that lie best at those of the smallest rectangle around it, counter-clockwise, all different.
fn best_corners(outline: &[Point2<f64>]) -> Option<[usize; 4]> {
    if outline.len() < 4 {
        return None;
    }
    let n = outline.len();
    // A smallest rectangle has a side along one of the convex hull's; sides of the outline stand for those.
    let box_along = |along: Vector2<f64>| {
        let across = Vector2::new(-along.y, along.x);
        let (mut low, mut high) =
            (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
        for p in outline {
            let q = Vector2::new(p.coords.dot(&along), p.coords.dot(&across));
            low = low.inf(&q);
            high = high.sup(&q);
        }
        let place = |x: f64, y: f64| Point2::from(along * x + across * y);
        let extent = high - low;
        let corners = [
            place(low.x, low.y),
            place(high.x, low.y),
            place(high.x, high.y),
            place(low.x, high.y),
        ];
        (extent.x * extent.y, corners)
    };
    // A few hundred directions tell enough, however many sides there are.
    let stride = n.div_ceil(360);
    let (_, corners) = (0..n)
        .step_by(stride)
        .filter_map(|i| (outline[(i + 1) % n] - outline[i]).try_normalize(0.0))
        .map(box_along)
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let nearest = |corner: &Point2<f64>| {
        (0..n).min_by(|&a, &b| {
            let distance = |i: usize| (outline[i] - corner).norm_squared();
            distance(a).total_cmp(&distance(b))
        })
    };
    let mut found = [0; 4];
    for (place, corner) in found.iter_mut().zip(&corners) {
        *place = nearest(corner)?;
    }
    found.sort_unstable();
    // Corners that fall together move on to the next vertices.
    for i in 1..4 {
        found[i] = found[i].max(found[i - 1] + 1);
    }
    for (i, place) in found.iter_mut().enumerate() {
        *place = (*place).min(n - 4 + i);
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_a_turned_rectangle_are_found_and_never_fall_together() {
        let (sin, cos) = 0.4f64.sin_cos();
        let turn = |x: f64, y: f64| Point2::new(cos * x - sin * y, sin * x + cos * y);
        let mut outline = Vec::new();
        for i in 0..20 {
            outline.push(turn(f64::from(i) * 0.1, 0.0));
        }
        for i in 0..10 {
            outline.push(turn(2.0, f64::from(i) * 0.1));
        }
        for i in 0..20 {
            outline.push(turn(2.0 - f64::from(i) * 0.1, 1.0));
        }
        for i in 0..10 {
            outline.push(turn(0.0, 1.0 - f64::from(i) * 0.1));
        }
        assert_eq!(best_corners(&outline), Some([0, 20, 30, 50]));
        let sliver = [turn(0.0, 0.0), turn(1.0, 0.0), turn(1.0, 1e-3), turn(0.5, 1e-3)];
        assert_eq!(best_corners(&sliver), Some([0, 1, 2, 3]));
        assert_eq!(best_corners(&sliver[..3]), None);
    }
}
