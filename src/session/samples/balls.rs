//! Balls triangulated for the seams that they are known for.
//!
//! Guaranteed: made of + − × ÷ and √ alone, so that the same bits come out on all targets.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::grids::{Vertices, triangular_grid};
use crate::mesh::Soup;

/// The unit sphere with the symmetry of a tennis ball: two mirrors through the y axis, and half turns that swap the
/// poles.
///
/// A snub disphenoid, which has that symmetry and 12 nearly equilateral faces, is divided, moved to the sphere and
/// relaxed: 6 `frequency`² + 2 vertices. Symmetric to the last bit for odd frequencies: these have no vertex on the
/// axes of the half turns.
pub(super) fn tennis_ball(frequency: u32) -> Soup {
    // Edges pull like springs that would be half their length: stiffer ones overshoot, longer ones fold triangles at
    // the tips of valence 4, shorter ones draw them together there. 200 rounds reach across a face.
    const ROUNDS: usize = 200;
    const STIFFNESS: f64 = 0.25;
    const REST: f64 = 0.5;
    let tips = disphenoid();
    let mut vertices = Vertices::default();
    let mut triangles = Vec::new();
    for face in DISPHENOID_FACES {
        triangles.extend(triangular_grid(frequency, |share| {
            let key = mixture([0, 1, 2].map(|i| (face[i], share[i])));
            vertices.at(key, || {
                let parts = key.iter().filter(|(_, share)| *share > 0);
                let sum: Vector3<f64> =
                    parts.map(|&(tip, share)| tips[tip as usize] * f64::from(share)).sum();
                sum.normalize()
            })
        }));
    }
    let mut positions = Vec::from_iter(vertices.positions.iter().copied().map(Vector3::from));
    for triangle in &mut triangles {
        let [p, q, r] = triangle.map(|v| positions[v as usize]);
        if p.cross(&q).dot(&r) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    // The edge of equilateral triangles of that number on the sphere.
    let edge = (16.0 * PI / (3.0_f64.sqrt() * triangles.len() as f64)).sqrt();
    for _ in 0..ROUNDS {
        let mut pulls = vec![Vector3::zeros(); positions.len()];
        for [a, b, c] in &triangles {
            for (v, w) in [(a, b), (b, c), (c, a)] {
                let way = positions[*w as usize] - positions[*v as usize];
                pulls[*v as usize] += way * (STIFFNESS * (1.0 - REST * edge / way.norm()));
            }
        }
        for (p, pull) in positions.iter_mut().zip(pulls) {
            *p = (*p + pull).normalize();
        }
    }
    // Rounding must not tell images of one vertex apart: the one with the least key leads.
    let mut even = vec![[0.0; 3]; positions.len()];
    for (&key, &v) in &vertices.known {
        let images = (0..8).map(|symmetry| (moved(key, symmetry), symmetry));
        let Some((leader, symmetry)) = images.min() else { continue };
        let [mut x, y, mut z]: [f64; 3] = positions[vertices.known[&leader] as usize].into();
        for (c, mirror) in [(&mut x, MIRROR_X), (&mut z, MIRROR_Z)] {
            if moved(leader, mirror) == leader {
                *c = 0.0;
            } else if symmetry & mirror != 0 {
                *c = -*c;
            }
        }
        even[v as usize] = if symmetry & SWAP == 0 { [x, y, z] } else { [z, -y, x] };
    }
    Soup::from_triangles(even, &triangles)
}

/// A symmetry is a sum of these: first the half turn that swaps x with z and the poles, then mirrors.
const MIRROR_X: u32 = 1;
const MIRROR_Z: u32 = 2;
const SWAP: u32 = 4;

/// What a vertex is a mixture of: tips and their shares, in order.
type Mixture = [(u32, u32); 3];

fn mixture(mut parts: Mixture) -> Mixture {
    parts.iter_mut().filter(|(_, share)| *share == 0).for_each(|none| *none = (u32::MAX, 0));
    parts.sort_unstable();
    parts
}

/// The image of a vertex. Tips are numbered so that a bit tells their sign and the next one whether they stand
/// along x or z.
fn moved(key: Mixture, symmetry: u32) -> Mixture {
    mixture(key.map(|(tip, share)| {
        let tip = if symmetry & SWAP == 0 { tip } else { tip ^ 2 };
        let mirror = if tip & 2 == 0 { MIRROR_X } else { MIRROR_Z };
        (if symmetry & mirror == 0 { tip } else { tip ^ 1 }, share)
    }))
}

/// The tips of the snub disphenoid: two of valence 4 below along x, two above along z, and four of valence 5.
fn disphenoid() -> [Vector3<f64>; 8] {
    // The real root of 2q³ + 11q² + 4q − 1, which makes all edges equal.
    let q: f64 = 0.169_023_454_155_77;
    let (r, s) = (q.sqrt(), ((1.0 - q) / (2.0 * q)).sqrt());
    let t = 2.0 * r * s;
    std::array::from_fn(|i| {
        let (out, y) = if i < 4 { (1.0, -s) } else { (t, r) };
        let out = if i & 1 == 0 { out } else { -out };
        if i & 2 == 0 { Vector3::new(out, y, 0.0) } else { Vector3::new(0.0, -y, out) }
    })
}

#[rustfmt::skip]
const DISPHENOID_FACES: [[u32; 3]; 12] = [
    [2, 3, 4], [2, 3, 5], [0, 1, 6], [0, 1, 7],
    [2, 4, 6], [2, 5, 6], [3, 4, 7], [3, 5, 7],
    [0, 6, 4], [0, 4, 7], [1, 6, 5], [1, 5, 7],
];

/// The unit sphere from a cube whose sides are divided into `count`² cells, which are halved along the diagonals
/// that point to the nearest corner of the cube: 6 `count`² + 2 vertices.
///
/// A multiple of six has all symmetries of the cube, and edges along the bounds of three equal panels on each side,
/// whichever way they run.
pub(super) fn volleyball(count: i32) -> Soup {
    let mut vertices = Vertices::default();
    let mut at = |place: [i32; 3]| {
        vertices.at(place, || {
            let spread = place.map(|i| {
                let u = f64::from(2 * i - count) / f64::from(count);
                // Close to tan(π u / 4), which makes all angles along the middle of a side equal.
                u * (0.785 + 0.215 * u * u)
            });
            Vector3::from(spread).normalize()
        })
    };
    let mut triangles = Vec::new();
    for a in 0..3 {
        for side in [0, count] {
            let mut corner = |i: i32, j: i32| {
                let mut place = [side; 3];
                (place[(a + 1) % 3], place[(a + 2) % 3]) = (i, j);
                at(place)
            };
            for i in 0..count {
                for j in 0..count {
                    let mut cell = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
                    if (2 * i < count) != (2 * j < count) {
                        cell.rotate_left(1);
                    }
                    if side == 0 {
                        cell.swap(1, 3);
                    }
                    let [p, q, r, s] = cell.map(|[i, j]| corner(i, j));
                    triangles.extend([[p, q, r], [p, r, s]]);
                }
            }
        }
    }
    Soup::from_triangles(vertices.positions, &triangles)
}
