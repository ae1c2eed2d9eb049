//! Faces that no point on an edge turns over: needles at rims mostly, a millionth as wide as long. One of their corners inside the chart
//! moves by about their width, to where all faces about it lie right.
//!
//! Rims stay where they are, and with them partners and cones; angles about points add up to what they did, because the faces still
//! tile the same part of the plane. What changes is how conformal a few needles are.

use nalgebra::{Matrix2, Matrix3, Point2, Vector2, Vector3};

use crate::flatten::overlap::orientation;
use crate::mesh::{FaceId, OpenedMesh, VertexId};

/// Vertices with more faces stay: the search takes the fourth power of their number.
const MOST_FACES: usize = 20;

/// Share of the clearance at the best place that is enough in any case.
const ENOUGH: f64 = 0.5;

/// Least clearance that is asked for, over the size of the star: what orientation and rounding can tell apart with ease.
const LEAST: f64 = 1e-9;

/// Moves vertices inside charts until no face given lies on its back, as far as one vertex for each will do. **Gives** how many moved.
pub(super) fn settle(opened: &OpenedMesh, uv: &mut [Point2<f64>], flipped: &[FaceId]) -> usize {
    let mut moved = 0;
    for &face in flipped {
        let corners = opened.mesh.face_vertices(face);
        let [a, b, c] = corners.map(|v| uv[v.index()]);
        // A vertex moved before may have turned it over.
        if orientation(a, b, c) > 0.0 {
            continue;
        }
        let nearest = corners
            .into_iter()
            .filter(|v| !opened.mesh.is_boundary_vertex(*v))
            .filter_map(|v| Some((v, better_place(opened, uv, v)?)))
            .min_by(|(v, p), (w, q)| {
                let way = |v: &VertexId, p: &Point2<f64>| (p - uv[v.index()]).norm();
                way(v, p).total_cmp(&way(w, q))
            });
        if let Some((v, place)) = nearest {
            uv[v.index()] = place;
            moved += 1;
        }
    }
    moved
}

/// A place where every face about a vertex inside lies right, near to where it is: as far on the right side as it was on the wrong one.
fn better_place(opened: &OpenedMesh, uv: &[Point2<f64>], v: VertexId) -> Option<Point2<f64>> {
    let mesh = &opened.mesh;
    let here = uv[v.index()];
    let link: Vec<[Point2<f64>; 2]> =
        mesh.outgoing(v).map(|h| [h, mesh.next(h)].map(|h| uv[mesh.tip(h).index()])).collect();
    if link.len() > MOST_FACES {
        return None;
    }
    // Inside means on the left of every side of the link: normal · (p − here) ≥ offset.
    let walls: Vec<(Vector2<f64>, f64)> = link
        .iter()
        .map(|[a, b]| {
            let along = (b - a).normalize();
            let normal = Vector2::new(-along.y, along.x);
            (normal, normal.dot(&(a - here)))
        })
        .collect();
    let clearance = |d: &Vector2<f64>| {
        walls.iter().map(|(n, offset)| n.dot(d) - offset).fold(f64::INFINITY, f64::min)
    };
    let best = best_clearance(&walls, clearance)?;
    let size = link.iter().fold(0.0, |size: f64, [a, _]| size.max((a - here).norm()));
    let depth = -clearance(&Vector2::zeros());
    let wanted = depth.max(LEAST * size).min(ENOUGH * best);
    let place = here + nearest_of(&walls, wanted, clearance)?;
    link.iter().all(|[a, b]| orientation(place, *a, *b) > 0.0).then_some(place)
}

/// The shortest way to a place with so much clearance: straight to a wall, or to where two walls meet, both moved in by it.
fn nearest_of(
    walls: &[(Vector2<f64>, f64)],
    wanted: f64,
    clearance: impl Fn(&Vector2<f64>) -> f64,
) -> Option<Vector2<f64>> {
    let mut ways: Vec<Vector2<f64>> =
        walls.iter().map(|(n, offset)| n * (offset + wanted)).collect();
    for (i, (n, p)) in walls.iter().enumerate() {
        for (m, q) in &walls[..i] {
            let matrix = Matrix2::new(n.x, n.y, m.x, m.y);
            ways.extend(matrix.lu().solve(&Vector2::new(p + wanted, q + wanted)));
        }
    }
    // Places on walls are on the right side of them by rounding only.
    let lie_right = ways.into_iter().filter(|d| clearance(d) > 0.999 * wanted);
    lie_right.min_by(|c, d| c.norm().total_cmp(&d.norm()))
}

/// The largest clearance on the right side of all walls: where three of them are equally far.
fn best_clearance(
    walls: &[(Vector2<f64>, f64)],
    clearance: impl Fn(&Vector2<f64>) -> f64,
) -> Option<f64> {
    let mut best: f64 = 0.0;
    for i in 0..walls.len() {
        for j in 0..i {
            for k in 0..j {
                let rows = [i, j, k].map(|w| walls[w]);
                let matrix = Matrix3::from_fn(|r, c| if c < 2 { rows[r].0[c] } else { -1.0 });
                let right = Vector3::from_fn(|r, _| rows[r].1);
                if let Some(solution) = matrix.lu().solve(&right) {
                    best = best.max(clearance(&solution.xy()));
                }
            }
        }
    }
    (best > 0.0).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CutMesh, Mesh};

    #[test]
    fn a_vertex_outside_its_link_comes_in_and_no_further_than_it_must() {
        let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let opened = CutMesh::uncut(&Mesh::new(5, &triangles).unwrap()).open().unwrap();
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, -0.1]];
        let mut uv = corners.map(Point2::from).to_vec();
        assert_eq!(settle(&opened, &mut uv, &[FaceId(0)]), 1);
        // A tenth outside before, a tenth inside now.
        assert!((uv[4] - Point2::new(1.0, 0.1)).norm() < 1e-6, "{}", uv[4]);
        assert_eq!(settle(&opened, &mut uv, &[FaceId(0)]), 0, "it lies right now");
        // No place sees all of a link like this.
        let mut bent =
            [[0.0, 0.0], [4.0, 0.0], [3.9, 0.1], [0.0, 0.1], [9.0, 9.0]].map(Point2::from);
        bent[2] = Point2::new(-1.0, -1.0);
        assert_eq!(settle(&opened, &mut bent, &[FaceId(1)]), 0);
    }
}
