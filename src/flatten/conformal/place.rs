//! Charts from faces laid flat: each goes beside the one before it.

use std::collections::VecDeque;

use nalgebra::{Complex, Point2};

use super::develop::Developed;
use crate::flatten::overlap::orientation;
use crate::flatten::{NoChart, rims};
use crate::mesh::{FaceId, HalfedgeId, Mesh, OpenedMesh};

/// Charts in frames of their own.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub charts: Vec<Result<Vec<HalfedgeId>, NoChart>>,
    /// NaN without chart.
    pub uv: Vec<Point2<f64>>,
    /// By how much a side of a face differs from the places of its ends, at most, over the diameter of the chart.
    pub closure: f64,
}

/// The side `3 f + i` that a halfedge inside a face is.
pub(super) fn side_of_halfedges(mesh: &Mesh) -> Vec<usize> {
    let mut sides = vec![usize::MAX; mesh.halfedge_count()];
    for f in mesh.faces() {
        for (i, h) in mesh.face_halfedges(f).into_iter().enumerate() {
            sides[h.index()] = 3 * f.index() + i;
        }
    }
    sides
}

/// Places the faces of every patch that is a disk.
///
/// **Takes** every face laid flat, or why it is not. **Costs** O(F).
pub(super) fn place(opened: &OpenedMesh, developed: &[Result<[Developed; 3], NoChart>]) -> Placed {
    let mesh = &opened.mesh;
    let nowhere = Point2::new(f64::NAN, f64::NAN);
    let mut placed =
        Placed { charts: rims(opened), uv: vec![nowhere; mesh.vertex_count()], closure: 0.0 };
    for (face, flat) in developed.iter().enumerate() {
        let chart = &mut placed.charts[opened.face_patches[face] as usize];
        if let (Err(reason), Ok(_)) = (flat, &chart) {
            *chart = Err(*reason);
        }
    }
    let sides = side_of_halfedges(mesh);
    let mut is_seen = vec![false; mesh.face_count()];
    for seed in mesh.faces() {
        let patch = opened.face_patches[seed.index()] as usize;
        if is_seen[seed.index()] || placed.charts[patch].is_err() {
            continue;
        }
        is_seen[seed.index()] = true;
        placed.uv[mesh.face_vertices(seed)[0].index()] = Point2::origin();
        let mut turned: Vec<(FaceId, Complex<f64>)> = Vec::new();
        let mut queue = VecDeque::from([(seed, Complex::new(1.0, 0.0))]);
        while let Some((face, turn)) = queue.pop_front() {
            let Ok(flat) = &developed[face.index()] else { continue };
            turned.push((face, turn));
            let corners = mesh.face_vertices(face).map(|v| v.index());
            // At least one corner is placed; the others follow it around.
            let known = (0..3).find(|&i| placed.uv[corners[i]].x.is_finite()).unwrap_or(0);
            for k in 0..2 {
                let (i, j) = ((known + k) % 3, (known + k + 1) % 3);
                if !placed.uv[corners[j]].x.is_finite() {
                    placed.uv[corners[j]] = moved(placed.uv[corners[i]], turn * flat[i].z);
                }
            }
            for (i, h) in mesh.face_halfedges(face).into_iter().enumerate() {
                if let Some(across) = mesh.face(h.twin())
                    && !std::mem::replace(&mut is_seen[across.index()], true)
                {
                    debug_assert!(sides[h.twin().index()] / 3 == across.index());
                    queue.push_back((across, turn * flat[i].r));
                }
            }
        }
        placed.measure(opened, developed, &turned, patch);
    }
    placed
}

fn moved(p: Point2<f64>, z: Complex<f64>) -> Point2<f64> {
    Point2::new(p.x + z.re, p.y + z.im)
}

impl Placed {
    /// Closure of one chart; a chart with places that are no numbers is taken back.
    fn measure(
        &mut self,
        opened: &OpenedMesh,
        developed: &[Result<[Developed; 3], NoChart>],
        turned: &[(FaceId, Complex<f64>)],
        patch: usize,
    ) {
        let mesh = &opened.mesh;
        let (mut low, mut high) = (Point2::origin(), Point2::origin());
        let mut worst: f64 = 0.0;
        for &(face, turn) in turned {
            let Ok(flat) = &developed[face.index()] else { continue };
            let corners = mesh.face_vertices(face).map(|v| self.uv[v.index()]);
            for i in 0..3 {
                low = low.inf(&corners[i]);
                high = high.sup(&corners[i]);
                let gap = moved(corners[i], turn * flat[i].z) - corners[(i + 1) % 3];
                worst = if gap.norm() <= worst { worst } else { gap.norm() };
            }
        }
        let diameter = (high - low).norm();
        if worst.is_finite() && diameter > 0.0 && diameter.is_finite() {
            self.closure = self.closure.max(worst / diameter);
            return;
        }
        let first = turned.first().map_or(FaceId(0), |t| t.0);
        self.charts[patch] = Err(NoChart::Degenerate { face: first });
        for (face, _) in turned {
            for v in mesh.face_vertices(*face) {
                self.uv[v.index()] = Point2::new(f64::NAN, f64::NAN);
            }
        }
    }
}

/// The faces of charts that are turned over or have no area, by exact orientation.
pub(super) fn flipped_faces(
    opened: &OpenedMesh,
    charts: &[Result<Vec<HalfedgeId>, NoChart>],
    uv: &[Point2<f64>],
) -> Vec<FaceId> {
    let is_placed = |f: &FaceId| charts[opened.face_patches[f.index()] as usize].is_ok();
    let is_flipped = |f: &FaceId| {
        let [a, b, c] = opened.mesh.face_vertices(*f).map(|v| uv[v.index()]);
        !(orientation(a, b, c) > 0.0)
    };
    opened.mesh.faces().filter(is_placed).filter(is_flipped).collect()
}

/// Largest difference of the lengths of partners in their charts, over their length; sides shorter than the mean of all seams count as
/// that, since places have an absolute accuracy.
pub(super) fn partner_mismatch(opened: &OpenedMesh, uv: &[Point2<f64>]) -> f64 {
    let mesh = &opened.mesh;
    let length = |h: HalfedgeId| (uv[mesh.tip(h).index()] - uv[mesh.tail(h).index()]).norm();
    // Without a chart there is no length.
    let pairs: Vec<[f64; 2]> = mesh
        .faces()
        .flat_map(|f| mesh.face_halfedges(f))
        .filter_map(|h| Some([length(h), length(opened.partner(h)?)]))
        .filter(|[a, b]| (a + b).is_finite())
        .collect();
    let mean = pairs.iter().map(|p| p[0]).sum::<f64>() / pairs.len().max(1) as f64;
    pairs.iter().fold(0.0, |worst: f64, [a, b]| worst.max((a - b).abs() / a.max(*b).max(mean)))
}
