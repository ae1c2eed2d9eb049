//! Samples with a parametric form: a place for each vertex by formula, triangles by counting.
//!
//! Guaranteed: connectivity does not depend on rounding, except in the vase, whose rings are joined along shorter
//! diagonals.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector3;

use super::grids::{
    Vertices, evenly_spaced, join_rings, square_grid, staggered_rings, triangular_grid, whole,
};
use crate::mesh::Soup;

/// The unit sphere from an icosahedron whose edges are divided into `frequency` equal arcs:
/// 10 `frequency`² + 2 vertices, 20 `frequency`² triangles.
pub fn icosphere(frequency: u32) -> Soup {
    let n = frequency.max(1);
    let tips = icosahedron();
    // Neighbouring tips stand at the angle atan 2.
    let arc = 2.0_f64.atan();
    let mut vertices = Vertices::default();
    let mut triangles = Vec::new();
    for face in ICOSAHEDRON_FACES {
        triangles.extend(triangular_grid(n, |[i, j, k]| {
            // A point is known by the tips that it is a mixture of, and by how much of each.
            let mut key = [(face[0], i), (face[1], j), (face[2], k)];
            key.iter_mut().filter(|(_, share)| *share == 0).for_each(|none| *none = (u32::MAX, 0));
            key.sort_unstable();
            vertices.at(key, || {
                let mixture = key.iter().filter(|(_, share)| *share > 0);
                let sum: Vector3<f64> = mixture
                    .map(|&(tip, share)| tips[tip as usize] * share_of_arc(arc, share, n))
                    .sum();
                sum.normalize()
            })
        }));
    }
    Soup::from_triangles(vertices.positions, &triangles)
}

#[rustfmt::skip]
const ICOSAHEDRON_FACES: [[u32; 3]; 20] = [
    [0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1],
    [1, 6, 2], [2, 7, 3], [3, 8, 4], [4, 9, 5], [5, 10, 1],
    [2, 6, 7], [3, 7, 8], [4, 8, 9], [5, 9, 10], [1, 10, 6],
    [11, 7, 6], [11, 8, 7], [11, 9, 8], [11, 10, 9], [11, 6, 10],
];

/// The tips of the icosahedron: a pole, two rings of five, and the other pole, along y.
fn icosahedron() -> [Vector3<f64>; 12] {
    let (y, r) = (1.0 / 5.0_f64.sqrt(), 2.0 / 5.0_f64.sqrt());
    std::array::from_fn(|i| match i {
        0 => Vector3::y(),
        11 => -Vector3::y(),
        _ => {
            let lower = i > 5;
            let turn = (i - 1) as f64 + if lower { 0.5 } else { 0.0 };
            let (x, z) = (TAU * turn / 5.0).sin_cos();
            Vector3::new(r * x, if lower { -y } else { y }, r * z)
        }
    })
}

/// The weight of a tip in a mixture on the sphere. With weights sin(arc · share / n) the points of an edge
/// between two tips divide it into equal arcs.
fn share_of_arc(arc: f64, share: u32, n: u32) -> f64 {
    (arc * f64::from(share) / f64::from(n)).sin()
}

/// A box of 1.6 × 1.1 × 0.8 with edges rounded by 0.2, on squares of one size that are halved.
///
/// A point is a point of the inner box (1.2 × 0.7 × 0.4) moved by 0.2 along a direction. On flat sides the
/// direction is fixed, along edges it turns in one plane, at corners it covers an octant of the sphere.
pub(super) fn rounded_box() -> Soup {
    const RADIUS: f64 = 0.2;
    const INNER: [f64; 3] = [1.2, 0.7, 0.4];
    // A quarter turn in 12 steps of 0.0262, the inner box in steps of 0.0261, 0.0259 and 0.0267.
    const TURN: i32 = 12;
    const STEPS: [i32; 3] = [46, 27, 15];
    let mut vertices = Vertices::default();
    // A vertex is known by its place on the lattice of the inner box and by its direction in steps, whose
    // absolute values add up to `TURN`.
    let mut at = |place: [i32; 3], direction: [i32; 3]| {
        vertices.at((place, direction), || {
            let centre: [f64; 3] = std::array::from_fn(|a| {
                INNER[a] * (f64::from(place[a]) / f64::from(STEPS[a]) - 0.5)
            });
            let towards = direction.map(|d| {
                let share = share_of_arc(FRAC_PI_2, d.unsigned_abs(), TURN.unsigned_abs());
                f64::from(d.signum()) * share
            });
            Vector3::from(centre) + Vector3::from(towards).normalize() * RADIUS
        })
    };
    let end = |axis: usize, side: i32| if side > 0 { STEPS[axis] } else { 0 };
    let mut triangles = Vec::new();
    for a in 0..3 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        for side in [-1, 1] {
            // The flat side across axis `a`.
            triangles.extend(square_grid(STEPS[b], STEPS[c], |i, j| {
                let (mut place, mut direction) = ([0; 3], [0; 3]);
                (place[a], place[b], place[c]) = (end(a, side), i, j);
                direction[a] = side * TURN;
                at(place, direction)
            }));
        }
        for (side_b, side_c) in [(-1, -1), (-1, 1), (1, -1), (1, 1)] {
            // The edge along axis `a`.
            triangles.extend(square_grid(STEPS[a], TURN, |i, j| {
                let (mut place, mut direction) = ([0; 3], [0; 3]);
                (place[a], place[b], place[c]) = (i, end(b, side_b), end(c, side_c));
                (direction[b], direction[c]) = (side_b * (TURN - j), side_c * j);
                at(place, direction)
            }));
        }
    }
    for corner in 0..8 {
        let side: [i32; 3] = std::array::from_fn(|a| if corner >> a & 1 == 1 { 1 } else { -1 });
        let place = std::array::from_fn(|a| end(a, side[a]));
        triangles.extend(triangular_grid(TURN.unsigned_abs(), |share| {
            at(place, std::array::from_fn(|a| side[a] * share[a].cast_signed()))
        }));
    }
    let positions = vertices.positions;
    // The body is convex about the origin, which tells outside from inside.
    for triangle in &mut triangles {
        let [p, q, r] = triangle.map(|v| Vector3::from(positions[v as usize]));
        if (q - p).cross(&(r - p)).dot(&p) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    Soup::from_triangles(positions, &triangles)
}

/// A torus of radii 1 and 0.4 about the y axis, of `around` × `rows` nearly equilateral triangle pairs.
///
/// Rows stand where the conformal coordinate s with ds = r dφ / (R + r cos φ) has equal steps, and every
/// second row is moved by half a step: so all triangles have one shape, and only their size follows the
/// distance from the axis. The shape is equilateral for rows / around = √(r² / (R² − r²)) · 2/√3 ≈ 0.504.
pub(super) fn torus(around: u32, rows: u32) -> Soup {
    const MAJOR: f64 = 1.0;
    const MINOR: f64 = 0.4;
    let stretch = ((MAJOR + MINOR) / (MAJOR - MINOR)).sqrt();
    let mut positions = Vec::new();
    for row in 0..rows {
        let s = PI * (f64::from(row) / f64::from(rows) - 0.5);
        let (sin, cos) = (2.0 * (stretch * s.tan()).atan()).sin_cos();
        for column in 0..around {
            let turn = f64::from(column) + 0.5 * f64::from(row % 2);
            let (x, z) = (TAU * turn / f64::from(around)).sin_cos();
            let reach = MAJOR + MINOR * cos;
            positions.push([reach * x, MINOR * sin, reach * z]);
        }
    }
    let at = |row: u32, column: u32| row % rows * around + column % around;
    Soup::from_triangles(positions, &staggered_rings(around, rows, at))
}

/// A vase: a profile turned about the y axis, with six flutes that swell upwards and wind a little.
///
/// Rings of points at equal steps of the profile, each ring divided into steps of that length; so the bottom is
/// a disk whose rings get denser outwards, and the wall has more points where it is wider. Neighbouring rings
/// are joined along the shorter diagonals.
pub(super) fn wavy_vase() -> Soup {
    const FLUTES: f64 = 6.0;
    const DEPTH: f64 = 0.13;
    const WINDING: f64 = 0.5;
    const STEP: f64 = 0.0284;
    const HEIGHT: f64 = 1.7;
    let profile = vase_profile();
    let length = profile.last().map_or(0.0, |&(s, ..)| s);
    // Rings √3/2 of a step apart make equilateral triangles.
    let rings = whole(length / (STEP * 0.75_f64.sqrt()));
    let mut positions = vec![[0.0, -HEIGHT / 2.0, 0.0]];
    let mut triangles = Vec::new();
    let mut below = 0..1;
    for ring in 1..=rings {
        let s = f64::from(ring) / f64::from(rings);
        let (radius, y) = along(&profile, s * length);
        // The foot is round: flutes begin where the wall does.
        let swell = ((s - 0.2) / 0.5).clamp(0.0, 1.0);
        let depth = DEPTH * swell * swell * (3.0 - 2.0 * swell);
        let outline = |turn: f64| {
            let r = radius * (1.0 + depth * (FLUTES * (turn - WINDING * y)).cos());
            let (x, z) = turn.sin_cos();
            Vector3::new(r * x, y - HEIGHT / 2.0, r * z)
        };
        let above = positions.len();
        let points = evenly_spaced(outline, STEP, 0.5 * f64::from(ring % 2));
        positions.extend(points.into_iter().map(<[f64; 3]>::from));
        let above = above..positions.len();
        join_rings(&positions, below, above.clone(), &mut triangles);
        below = above;
    }
    Soup::from_triangles(positions, &triangles)
}

/// Points (arc length, distance from the axis, height) of the vase's profile, from the middle of the foot to the
/// rim: Bézier curves that continue each other without a corner.
fn vase_profile() -> Vec<(f64, f64, f64)> {
    const CURVES: [[[f64; 2]; 4]; 4] = [
        [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0], [0.28, 0.0]],
        [[0.28, 0.0], [0.52, 0.0], [0.64, 0.3], [0.64, 0.62]],
        [[0.64, 0.62], [0.64, 0.98], [0.36, 1.04], [0.36, 1.34]],
        [[0.36, 1.34], [0.36, 1.5], [0.42, 1.62], [0.54, 1.7]],
    ];
    const PIECES: u32 = 200;
    let mut profile = vec![(0.0, 0.0, 0.0)];
    let (mut s, mut x, mut y) = (0.0, 0.0, 0.0);
    for [p, q, r, end] in CURVES {
        for piece in 1..=PIECES {
            let t = f64::from(piece) / f64::from(PIECES);
            let u = 1.0 - t;
            let [next_x, next_y] = [0, 1].map(|a| {
                u * u * u * p[a] + 3.0 * u * t * (u * q[a] + t * r[a]) + t * t * t * end[a]
            });
            s += f64::hypot(next_x - x, next_y - y);
            (x, y) = (next_x, next_y);
            profile.push((s, x, y));
        }
    }
    profile
}

/// The place on a profile at arc length `s`.
fn along(profile: &[(f64, f64, f64)], s: f64) -> (f64, f64) {
    let i = profile.partition_point(|point| point.0 < s).clamp(1, profile.len() - 1);
    let ((s0, x0, y0), (s1, x1, y1)) = (profile[i - 1], profile[i]);
    let t = ((s - s0) / (s1 - s0)).clamp(0.0, 1.0);
    (x0 + t * (x1 - x0), y0 + t * (y1 - y0))
}
