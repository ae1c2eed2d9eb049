//! The doctor of meshes: what is found, and that repairs leave a surface.
//!
//! Here is what makes patients and what holds for every cure; below are patients with one fault each, and surfaces with
//! many.

mod faults;
mod wholes;

use std::f64::consts::TAU;

use cutflow::geometry::doctor::{Examination, examine, repair_all, triangles};
use cutflow::mesh::doctor::{FindingKind, Repair};
use cutflow::mesh::{Mesh, Soup};

/// A closed ball of squares and triangles: `n` meridians, `n / 2` belts; 2 + n(n/2 − 1) vertices.
fn ball(n: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let belts = n / 2;
    let mut positions = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    for i in 1..belts {
        for j in 0..n {
            let (t, p) = (f64::from(i) / f64::from(n) * TAU, f64::from(j) / f64::from(n) * TAU);
            positions.push([t.sin() * p.cos(), t.sin() * p.sin(), t.cos()]);
        }
    }
    let at = |i: u32, j: u32| 2 + (i - 1) * n + j % n;
    let mut triangles = Vec::new();
    for j in 0..n {
        triangles.push([0, at(1, j), at(1, j + 1)]);
        for i in 1..belts - 1 {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        triangles.push([1, at(belts - 1, j + 1), at(belts - 1, j)]);
    }
    (positions, triangles)
}

fn sphere() -> Soup {
    let (positions, triangles) = ball(12);
    Soup::from_triangles(positions, &triangles)
}

/// A soup of polygons.
fn polygons(positions: Vec<[f64; 3]>, polygons: &[&[u32]]) -> Soup {
    let mut soup = Soup { positions, starts: vec![0], ..Soup::default() };
    for polygon in polygons {
        soup.corners.extend_from_slice(polygon);
        soup.starts.push(soup.corners.len() as u32);
    }
    soup
}

/// A band of `n` by 4 squares closed with half a turn, as triangles.
fn moebius(n: u32) -> Soup {
    let mut positions = Vec::new();
    for i in 0..n {
        for j in 0..5 {
            let (t, s) = (f64::from(i) / f64::from(n) * TAU, (f64::from(j) - 2.0) / 5.0);
            let r = 1.0 + s * (t / 2.0).cos();
            positions.push([r * t.cos(), r * t.sin(), s * (t / 2.0).sin()]);
        }
    }
    let at = |i: u32, j: u32| if i == n { 4 - j } else { 5 * i + j };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..4 {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Soup::from_triangles(positions, &triangles)
}

/// Every triangle with its own vertices, moved by at most `jitter` along each axis.
fn exploded(soup: &Soup, jitter: f64) -> Soup {
    let mut random = Random(7);
    let mut moved =
        |v: &u32| soup.positions[*v as usize].map(|x| x + jitter * (2.0 * random.unit() - 1.0));
    let positions = Vec::from_iter(soup.corners.iter().map(&mut moved));
    let corners = (0..).take(positions.len()).collect();
    Soup { positions, corners, starts: soup.starts.clone(), ..Soup::default() }
}

/// A seeded sequence (splitmix64).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn is_mesh(soup: &Soup) -> bool {
    Mesh::new(soup.positions.len(), &triangles(soup).0).is_ok()
}

fn count(examination: &Examination, kind: FindingKind) -> usize {
    examination.find(kind).map_or(0, |finding| finding.count)
}

/// Used vertices, polygons, components, loops, Euler characteristic.
fn shape(examination: &Examination) -> [i64; 5] {
    [
        examination.vertices as i64,
        examination.faces as i64,
        examination.components.len() as i64,
        examination.boundary_loops.len() as i64,
        examination.euler,
    ]
}

/// Repairs all, asserts what is guaranteed of that, and gives the result.
fn cured(soup: &Soup) -> Soup {
    let (result, done) = repair_all(soup);
    let after = examine(&result);
    assert!(result.polygon_count() == 0 || is_mesh(&result), "{done:?}");
    assert!(result.polygon_count() == 0 || after.is_solvable, "{done:?} {:?}", after.findings);
    let recommended = after.recommended();
    assert!(recommended.iter().all(|r| matches!(r, Repair::Weld { .. })), "{recommended:?}");
    assert_sound(soup, &result);
    // Once more finds nothing to do, unless the weld of a soup in pieces is asked for again.
    let (again, more) = repair_all(&result);
    if !more.iter().any(|(r, _)| matches!(r, Repair::Weld { .. })) {
        assert!(more.is_empty(), "{done:?} then {more:?}");
        assert_eq!(again, result);
    }
    result
}

/// What holds for all repairs: vertices keep numbers and bits, lists have their lengths, indices are in range.
fn assert_sound(before: &Soup, after: &Soup) {
    let bits = |soup: &Soup| Vec::from_iter(soup.positions.iter().map(|p| p.map(f64::to_bits)));
    assert!(bits(after).starts_with(&bits(before)));
    assert_eq!(after.starts.last().map(|&end| end as usize), Some(after.corners.len()));
    assert!(after.corners.iter().all(|&v| (v as usize) < after.positions.len()));
    for (corners, values) in [
        (&after.texture_corners, after.texture_coordinates.len()),
        (&after.normal_corners, after.normals.len()),
    ] {
        assert!(corners.is_empty() || corners.len() == after.corners.len());
        assert!(corners.iter().all(|&t| t == u32::MAX || (t as usize) < values));
    }
    for list in [&after.lines, &after.polygon_groups, &after.polygon_materials] {
        assert!(list.is_empty() || list.len() == after.polygon_count());
    }
}
