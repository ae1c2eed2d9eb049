//! Surfaces made by our own code, so that there is something to cut before a file is opened.
//!
//! Guaranteed of each sample: about 10 000 vertices, the same numbers each time, triangles without small angles,
//! faces that look outwards, one connected piece without a repeated vertex. The unit is the model's own; all
//! fit a ball of radius 1.5 about the origin, upright along y.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector3;

use crate::mesh::Soup;

/// What a person chooses from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Stable identifier, the argument of [`generate`].
    pub name: &'static str,
    /// What the list says.
    pub label: &'static str,
    /// One line: what it is good for.
    pub description: &'static str,
}

/// All samples, in the order of the list.
pub const SAMPLES: &[Sample] = &[
    Sample {
        name: "ball",
        label: "Ball",
        description: "A unit sphere: curved the same everywhere, the classic that cannot be flattened.",
    },
    Sample {
        name: "rounded_box",
        label: "Rounded box",
        description: "A box with rounded edges: flat sides, curvature along the edges and in eight corners.",
    },
    Sample {
        name: "torus",
        label: "Torus",
        description: "A ring: one handle, curved outwards outside and saddle-shaped inside.",
    },
    Sample {
        name: "wavy_vase",
        label: "Wavy vase",
        description: "A fluted vase with an open rim: one boundary, bumps and saddles side by side.",
    },
];

/// The sample of that name.
pub fn generate(name: &str) -> Option<Soup> {
    match name {
        "ball" => Some(icosphere(32)),
        "rounded_box" => Some(rounded_box()),
        "torus" => Some(torus(142, 72)),
        "wavy_vase" => Some(wavy_vase()),
        _ => None,
    }
}

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
fn rounded_box() -> Soup {
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
fn torus(around: u32, rows: u32) -> Soup {
    const MAJOR: f64 = 1.0;
    const MINOR: f64 = 0.4;
    let stretch = ((MAJOR + MINOR) / (MAJOR - MINOR)).sqrt();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
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
    for row in 0..rows {
        for column in 0..around {
            let (here, right) = (at(row, column), at(row, column + 1));
            let (above, above_right) = (at(row + 1, column), at(row + 1, column + 1));
            // The vertex of the same column stands half a step ahead above an even row, behind above an odd one.
            if row % 2 == 0 {
                triangles.extend([[here, right, above], [right, above_right, above]]);
            } else {
                triangles.extend([[here, right, above_right], [here, above_right, above]]);
            }
        }
    }
    Soup::from_triangles(positions, &triangles)
}

/// A vase: a profile turned about the y axis, with six flutes that swell upwards and wind a little.
///
/// Rings of points at equal steps of the profile, each ring divided into steps of that length; so the bottom is
/// a disk whose rings get denser outwards, and the wall has more points where it is wider. Neighbouring rings
/// are joined along the shorter diagonals.
fn wavy_vase() -> Soup {
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

/// Points on a closed curve over 0..2π, about `step` apart along it and all equally far; the first one `shift`
/// of a step from the start.
fn evenly_spaced(curve: impl Fn(f64) -> Vector3<f64>, step: f64, shift: f64) -> Vec<Vector3<f64>> {
    const PIECES: u32 = 720;
    let turn = |i: u32| TAU * f64::from(i) / f64::from(PIECES);
    let mut lengths = vec![0.0];
    let mut length = 0.0;
    for i in 0..PIECES {
        length += (curve(turn(i + 1)) - curve(turn(i))).norm();
        lengths.push(length);
    }
    let count = whole(length / step).max(5);
    let at = |k: u32| {
        let s = length * (f64::from(k) + shift) / f64::from(count);
        let i = lengths.partition_point(|&l| l < s).clamp(1, lengths.len() - 1);
        let t = (s - lengths[i - 1]) / (lengths[i] - lengths[i - 1]);
        curve(TAU * ((i - 1) as f64 + t) / f64::from(PIECES))
    };
    (0..count).map(at).collect()
}

/// Fills the band between two closed rings of vertices that run the same way, seen from outside with `above` to
/// the left of the way: always along the shorter of the two diagonals. A ring may be one vertex.
fn join_rings(
    positions: &[[f64; 3]],
    below: std::ops::Range<usize>,
    above: std::ops::Range<usize>,
    triangles: &mut Vec<[u32; 3]>,
) {
    let distance = |a: usize, b: usize| {
        (Vector3::from(positions[a]) - Vector3::from(positions[b])).norm_squared()
    };
    let nearest = above
        .clone()
        .min_by(|&a, &b| distance(below.start, a).total_cmp(&distance(below.start, b)));
    let start = nearest.unwrap_or(above.start) - above.start;
    let low = |i: usize| below.start + i % below.len();
    let high = |j: usize| above.start + (start + j) % above.len();
    // A single vertex has no edges to walk along.
    let steps_below = if below.len() > 1 { below.len() } else { 0 };
    let (mut i, mut j) = (0, 0);
    while i < steps_below || j < above.len() {
        let goes_below = j == above.len()
            || i < steps_below && distance(low(i + 1), high(j)) < distance(low(i), high(j + 1));
        if goes_below {
            triangles.push([low(i), low(i + 1), high(j)].map(to_u32));
            i += 1;
        } else {
            triangles.push([low(i), high(j + 1), high(j)].map(to_u32));
            j += 1;
        }
    }
}

/// The triangles of a triangle whose sides are divided into `n`; `at` gives the vertex for the shares of the three
/// corners, which add up to `n`.
fn triangular_grid(n: u32, mut at: impl FnMut([u32; 3]) -> u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for k in 0..n {
        for j in 0..n - k {
            let i = n - k - j;
            let (here, right, above) =
                (at([i, j, k]), at([i - 1, j + 1, k]), at([i - 1, j, k + 1]));
            triangles.push([here, right, above]);
            if i > 1 {
                triangles.push([right, at([i - 2, j + 1, k + 1]), above]);
            }
        }
    }
    triangles
}

/// The triangles of a rectangle of `columns` × `rows` cells, halved along diagonals that change their direction
/// from cell to cell, so that none is preferred.
fn square_grid(columns: i32, rows: i32, mut at: impl FnMut(i32, i32) -> u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    triangles
}

/// Vertices that are made once for each key.
struct Vertices<Key> {
    positions: Vec<[f64; 3]>,
    known: BTreeMap<Key, u32>,
}

impl<Key> Default for Vertices<Key> {
    fn default() -> Self {
        Self { positions: Vec::new(), known: BTreeMap::new() }
    }
}

impl<Key: Ord> Vertices<Key> {
    fn at(&mut self, key: Key, position: impl FnOnce() -> Vector3<f64>) -> u32 {
        *self.known.entry(key).or_insert_with(|| {
            self.positions.push(position().into());
            to_u32(self.positions.len() - 1)
        })
    }
}

/// A length in steps, rounded.
#[allow(clippy::cast_possible_truncation, reason = "a few thousand at most; saturates")]
fn whole(x: f64) -> u32 {
    x.round() as u32
}

/// A vertex number of a sample, far below 2³².
fn to_u32(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the tests want to know of a triangle mesh.
    struct Facts {
        euler_characteristic: i64,
        /// Number of edges with one triangle.
        boundary_edges: usize,
        boundary_loops: usize,
        /// In degrees.
        smallest_angle: f64,
        /// Longest edge over shortest.
        edge_ratio: f64,
        /// Volume under the triangles as seen from the point given.
        volume: f64,
        area: f64,
    }

    fn facts(soup: &Soup, apex: [f64; 3]) -> Facts {
        let p = |v: u32| Vector3::from(soup.positions[v as usize]) - Vector3::from(apex);
        let mut halfedges = BTreeMap::new();
        let mut facts = Facts {
            euler_characteristic: 0,
            boundary_edges: 0,
            boundary_loops: 0,
            smallest_angle: 180.0,
            edge_ratio: 0.0,
            volume: 0.0,
            area: 0.0,
        };
        let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
        for i in 0..soup.polygon_count() {
            let &[a, b, c] = soup.polygon(i) else { panic!("not a triangle") };
            for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                assert_eq!(halfedges.insert((a, b), ()), None, "faces agree on their side");
                let (u, v) = (p(b) - p(a), p(c) - p(a));
                facts.smallest_angle = facts.smallest_angle.min(u.angle(&v).to_degrees());
                (shortest, longest) = (shortest.min(u.norm()), longest.max(u.norm()));
            }
            facts.volume += p(a).dot(&p(b).cross(&p(c))) / 6.0;
            facts.area += (p(b) - p(a)).cross(&(p(c) - p(a))).norm() / 2.0;
        }
        facts.edge_ratio = longest / shortest;
        let open = halfedges.keys().filter(|&&(a, b)| !halfedges.contains_key(&(b, a)));
        let mut next = BTreeMap::from_iter(open.map(|&(a, b)| (b, a)));
        facts.boundary_edges = next.len();
        while let Some((_, mut at)) = next.pop_first() {
            facts.boundary_loops += 1;
            while let Some(after) = next.remove(&at) {
                at = after;
            }
        }
        let edges = (halfedges.len() + facts.boundary_edges) / 2;
        let count = |n: usize| i64::try_from(n).unwrap();
        facts.euler_characteristic =
            count(soup.positions.len()) - count(edges) + count(soup.polygon_count());
        let mut used = soup.corners.clone();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), soup.positions.len(), "each vertex is used");
        facts
    }

    #[test]
    fn each_sample_is_what_the_list_promises() {
        // Name, Euler characteristic, boundary loops, least angle in degrees, greatest edge ratio.
        let expected = [
            ("ball", 2, 0, 50.0, 1.5),
            ("rounded_box", 2, 0, 40.0, 2.0),
            ("torus", 0, 0, 55.0, 2.6),
            ("wavy_vase", 1, 1, 30.0, 2.2),
        ];
        assert_eq!(expected.map(|e| e.0), *Vec::from_iter(SAMPLES.iter().map(|s| s.name)));
        for (name, euler_characteristic, boundary_loops, angle, edge_ratio) in expected {
            let soup = generate(name).unwrap();
            assert!((8_000..=12_000).contains(&soup.positions.len()), "{name}");
            // Seen from the middle of the rim the open vase is as good as closed.
            let facts = facts(&soup, [0.0, if name == "wavy_vase" { 0.85 } else { 0.0 }, 0.0]);
            eprintln!(
                "{name}: {} vertices, angles from {:.1} degrees, edges 1 : {:.2}",
                soup.positions.len(),
                facts.smallest_angle,
                facts.edge_ratio
            );
            assert_eq!(facts.euler_characteristic, euler_characteristic, "{name}");
            assert_eq!(facts.boundary_loops, boundary_loops, "{name}");
            assert!(facts.smallest_angle > angle, "{name}: {}", facts.smallest_angle);
            assert!(facts.edge_ratio < edge_ratio, "{name}: {}", facts.edge_ratio);
            assert!(facts.volume > 0.0, "{name} looks outwards");
            let reach = soup.positions.iter().map(|p| Vector3::from(*p).norm()).fold(0.0, f64::max);
            assert!(reach < 1.5, "{name}: {reach}");
            assert_eq!(generate(name).unwrap(), soup, "{name} is the same each time");
        }
    }

    #[test]
    fn samples_have_the_size_of_the_bodies_they_stand_for() {
        let origin = [0.0; 3];
        // Flat triangles lose a little, of the order of edge² / radius²: most where the torus has edges of 0.06.
        let close = |x: f64, exact: f64| (1.0 - x / exact).abs() < 4e-3;
        let ball = facts(&generate("ball").unwrap(), origin);
        assert!(close(ball.area, 4.0 * PI) && close(ball.volume, 4.0 / 3.0 * PI));
        let torus = facts(&generate("torus").unwrap(), origin);
        assert!(
            close(torus.area, 4.0 * PI * PI * 0.4) && close(torus.volume, 2.0 * PI * PI * 0.16)
        );
        // Steiner: the inner box, moved outwards by r.
        let [a, b, c, r]: [f64; 4] = [1.2, 0.7, 0.4, 0.2];
        let (sides, edges) = (2.0 * (a * b + b * c + c * a), a + b + c);
        let rounded = facts(&generate("rounded_box").unwrap(), origin);
        assert!(close(rounded.area, sides + edges * TAU * r + 4.0 * PI * r * r));
        let volume = a * b * c + sides * r + edges * PI * r * r + 4.0 / 3.0 * PI * r.powi(3);
        assert!(close(rounded.volume, volume));
    }

    #[test]
    fn an_icosphere_has_ten_n_squared_and_two_vertices_on_the_unit_sphere() {
        for n in [1, 2, 3, 7, 16] {
            let soup = icosphere(n);
            assert_eq!(soup.positions.len(), (10 * n * n + 2) as usize);
            assert_eq!(soup.polygon_count(), (20 * n * n) as usize);
            assert_eq!(facts(&soup, [0.0; 3]).euler_characteristic, 2);
            let off = soup.positions.iter().map(|p| (Vector3::from(*p).norm() - 1.0).abs());
            assert!(off.fold(0.0, f64::max) < 4.0 * f64::EPSILON);
        }
        assert_eq!(icosphere(0), icosphere(1));
    }

    #[test]
    fn the_rim_of_the_vase_is_level() {
        let soup = generate("wavy_vase").unwrap();
        let top = soup.positions.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
        assert!((top - 0.85).abs() < 1e-9);
        let at_top = soup.positions.iter().filter(|p| (p[1] - top).abs() < 1e-9).count();
        assert_eq!(at_top, facts(&soup, [0.0; 3]).boundary_edges);
    }

    #[test]
    fn an_unknown_name_makes_nothing() {
        assert_eq!(generate("cow"), None);
    }
}
