//! Texture coordinates in single precision, in which no triangle turns over that does not in double precision.
//!
//! In the unit square single precision is a grid of 2⁻²⁴ or finer. Corners of a triangle that is smaller than a few cells may be rounded onto a
//! line or past it: one of them is then put on another point of the grid near its own, where all triangles around it keep their sides.

use nalgebra::Point2;

use super::super::bytes::single;
use crate::flatten::overlap::orientation;
use crate::mesh::{HalfedgeId, Mesh, VertexId};

/// The grid near 1, where it is coarsest.
const CELL: f64 = 1.0 / 16_777_216.0;
/// Cells that a corner is moved by at most, along either axis.
const REACH: i32 = 4;
/// Times that all triangles are looked through: moving one corner may make room for another.
const ROUNDS: usize = 4;

/// Rounds places in the unit square.
///
/// **Takes** a place for each vertex of a mesh. **Gives** them rounded. Triangles whose sides are those of the places before
/// keep them, but for some that have no room among their neighbours: no test mesh has one.
pub(super) fn rounded(mesh: &Mesh, places: &[[f64; 2]]) -> Vec<[f32; 2]> {
    let mut singles: Vec<[f32; 2]> = places.iter().map(|place| place.map(single)).collect();
    let corners = |f: usize| mesh.triangles()[f].map(VertexId::index);
    let side = |places: [[f64; 2]; 3]| {
        let [a, b, c] = places.map(Point2::from);
        let turn = orientation(a, b, c);
        if turn == 0.0 {
            0
        } else if turn > 0.0 {
            1
        } else {
            -1
        }
    };
    let is_kept = |singles: &[[f32; 2]], f: usize| {
        let before = side(corners(f).map(|v| places[v]));
        before == 0 || before == side(corners(f).map(|v| singles[v].map(f64::from)))
    };
    let mut wrong: Vec<usize> = (0..mesh.face_count()).filter(|&f| !is_kept(&singles, f)).collect();
    if wrong.is_empty() {
        return singles;
    }
    let mut moves: Vec<[i32; 2]> =
        (-REACH..=REACH).flat_map(|x| (-REACH..=REACH).map(move |y| [x, y])).collect();
    moves.sort_by_key(|[x, y]| x * x + y * y);
    for _ in 0..ROUNDS {
        for f in std::mem::take(&mut wrong) {
            if is_kept(&singles, f) {
                continue;
            }
            let is_mended = corners(f).into_iter().any(|v| {
                let old = singles[v];
                let around = || {
                    let faces =
                        mesh.outgoing(VertexId::from(v)).filter_map(|h: HalfedgeId| mesh.face(h));
                    faces.map(|f| f.index())
                };
                let found = moves.iter().any(|way| {
                    singles[v] = [0, 1]
                        .map(|k| single((places[v][k] + CELL * f64::from(way[k])).clamp(0.0, 1.0)));
                    around().all(|f| is_kept(&singles, f))
                });
                if !found {
                    singles[v] = old;
                }
                found
            });
            if !is_mended {
                wrong.push(f);
            }
        }
    }
    singles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan around vertex 0 whose triangles are slivers of a tenth of a cell.
    #[test]
    fn slivers_below_the_grid_keep_their_sides() {
        let count = 8;
        for shift in 0..40 {
            let base = 0.7 + 1e-9 * f64::from(shift);
            let mut places = vec![[base, 0.6]];
            let mut triangles = Vec::new();
            for i in 0..count {
                let t = std::f64::consts::TAU * f64::from(i) / f64::from(count);
                // The second ring vertex comes as near as a tenth of a cell.
                let reach = if i == 1 { 0.1 * CELL } else { 0.01 };
                places.push([base + reach * t.cos(), 0.6 + reach * t.sin()]);
                triangles.push([0, 1 + i, 1 + (i + 1) % count]);
            }
            let mesh = Mesh::new(places.len(), &triangles).unwrap();
            let found = rounded(&mesh, &places);
            for [a, b, c] in mesh.triangles() {
                let [a, b, c] = [a, b, c].map(|v| Point2::from(found[v.index()].map(f64::from)));
                assert!(orientation(a, b, c) > 0.0, "shift {shift}");
            }
            let off = found
                .iter()
                .zip(&places)
                .flat_map(|(found, place)| [0, 1].map(|k| (f64::from(found[k]) - place[k]).abs()));
            assert!(off.fold(0.0, f64::max) < 6.0 * CELL);
        }
    }

    #[test]
    fn what_is_turned_over_before_stays_so_and_disturbs_nothing() {
        let places = [[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]];
        let mesh = Mesh::new(3, &[[0, 2, 1]]).unwrap();
        assert_eq!(rounded(&mesh, &places), places.map(|p| p.map(single)));
    }
}
