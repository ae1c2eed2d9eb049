//! Validity: overlaps are found whatever triangles and outlines share, and nothing else is.

use std::f64::consts::TAU;

use cutflow::flatten::overlap::{contacts, overlapping_triangles, winding};
use cutflow::flatten::{ChartMeasures, Flattening, Pose, measure, measures, rims, validate};
use cutflow::geometry::Geometry;
use cutflow::mesh::{CutMesh, Mesh, OpenedMesh};
use nalgebra::{Point2, Point3, Vector2};

type Triangle = [Point2<f64>; 3];

/// Charts that were laid out by hand: no cut, each component a chart.
pub fn charted(places: &[Point2<f64>], triangles: &[[u32; 3]]) -> (OpenedMesh, Flattening) {
    let mesh = Mesh::new(places.len(), triangles).unwrap();
    let opened = CutMesh::uncut(&mesh).open().unwrap();
    let charts = rims(&opened);
    let u = vec![0.0; places.len()];
    let flattening = Flattening {
        charts,
        uv: places.to_vec(),
        u,
        seams_equal: true,
        angles_exact: true,
        closing: 0.0,
        residual: 0.0,
    };
    (opened, flattening)
}

/// A ring sector of n × m squares that turns by an angle about the origin, its radii given by turn and row.
pub fn sector(
    [n, m]: [u32; 2],
    angle: f64,
    radius: impl Fn(f64, f64) -> f64,
) -> (Vec<Point2<f64>>, Vec<[u32; 3]>) {
    let at = |i: u32, j: u32| i * (m + 1) + j;
    let mut places = Vec::new();
    for (i, j) in (0..=n).flat_map(|i| (0..=m).map(move |j| (i, j))) {
        let (turn, row) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(m));
        let (sin, cos) = (turn * angle).sin_cos();
        places.push(Point2::new(cos, sin) * radius(turn, row));
    }
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        // Outwards, then on: counter-clockwise.
        triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
    }
    (places, triangles)
}

/// Area of the intersection, by clipping with half planes, one after the other.
pub fn common_area(s: &Triangle, t: &Triangle) -> f64 {
    let area = |polygon: &[Point2<f64>]| {
        let n = polygon.len();
        (0..n).map(|i| polygon[i].coords.perp(&polygon[(i + 1) % n].coords)).sum::<f64>() / 2.0
    };
    let orient = |t: &Triangle| if area(t) < 0.0 { [t[0], t[2], t[1]] } else { *t };
    if area(s) == 0.0 || area(t) == 0.0 {
        return 0.0;
    }
    let (s, t) = (orient(s), orient(t));
    let mut polygon = t.to_vec();
    for i in 0..3 {
        let (a, along) = (s[i], s[(i + 1) % 3] - s[i]);
        let mut clipped = Vec::new();
        for k in 0..polygon.len() {
            let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            let [from, to] = [p, q].map(|x| along.perp(&(x - a)));
            if from >= 0.0 {
                clipped.push(p);
            }
            if from * to < 0.0 {
                clipped.push(p + (q - p) * (from / (from - to)));
            }
        }
        polygon = clipped;
    }
    if polygon.len() < 3 { 0.0 } else { area(&polygon) }
}

/// A sequence of numbers below a bound without pattern.
fn numbers(seed: u64) -> impl FnMut(u64) -> f64 {
    let mut state = seed;
    move |bound| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((state >> 33) % bound) as f64
    }
}

#[test]
fn overlaps_of_triangles_on_a_small_lattice_are_exactly_those_of_positive_area() {
    // Coordinates 0 … 4: corners on sides, sides on sides and equal triangles are common.
    let mut next = numbers(7);
    let mut found = [0usize; 2];
    for _ in 0..30 {
        let triangles: Vec<Triangle> =
            (0..60).map(|_| [(); 3].map(|()| Point2::new(next(5), next(5)))).collect();
        let pairs = overlapping_triangles(&triangles);
        let mut pairs = pairs.iter().peekable();
        for i in 0..60u32 {
            for j in i + 1..60 {
                let area = common_area(&triangles[i as usize], &triangles[j as usize]);
                // Two different lattice triangles with a common inside share far more than rounding.
                assert!(!(1e-12..1e-4).contains(&area));
                let has_pair = pairs.peek().is_some_and(|p| p.triangles == [i, j]);
                found[usize::from(has_pair)] += 1;
                assert_eq!(has_pair, area > 1e-6, "{:?}", [i, j]);
                if has_pair {
                    assert!((pairs.next().unwrap().area - area).abs() < 1e-12);
                }
            }
        }
    }
    assert!(found.iter().all(|&n| n > 5000), "{found:?}");
}

#[test]
fn one_unit_in_the_last_place_makes_an_overlap() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    // The third corner lies on a line through two others, which are not representable thirds, or beside it.
    let (a, b) = (p(0.1, 0.1), p(0.7, 0.7));
    let left = [a, b, p(0.0, 1.0)];
    for (y, overlaps) in [(0.4, false), (0.4f64.next_up(), true), (0.4f64.next_down(), false)] {
        let right = [p(0.4, y), p(0.3, -2.0), p(2.0, 0.3)];
        assert_eq!(overlapping_triangles(&[left, right]).len(), usize::from(overlaps), "{y}");
    }
}

#[test]
fn a_fan_of_more_than_a_full_turn_overlaps_at_its_corner_and_a_full_turn_does_not() {
    for (count, overlaps) in [(11u32, false), (12, false), (13, true), (30, true)] {
        // Right angles apart by 30 degrees; whole turns come back to the very same places.
        let ring: Vec<Point2<f64>> = (0..=count)
            .map(|i| {
                let (sin, cos) = (TAU / 12.0 * f64::from(i % 12)).sin_cos();
                Point2::new(cos, sin)
            })
            .collect();
        let mut places = vec![Point2::origin()];
        places.extend(ring);
        let triangles: Vec<[u32; 3]> = (0..count).map(|i| [0, i + 1, i + 2]).collect();
        let (opened, flattening) = charted(&places, &triangles);
        let validity = validate(&opened, &flattening, None);
        // Triangle i lies on triangle i + 12 exactly, and shares the apex only.
        let pairs: u32 = (0..count).map(|i| i / 12).sum();
        assert_eq!(validity.totals.pairs, pairs as usize);
        assert_eq!(validity.totals.flipped, 0);
        let area = 0.5 * (TAU / 12.0).sin();
        assert!((validity.totals.overlapping_area - f64::from(pairs) * area).abs() < 1e-12);
        let positions = places.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
        let geometry = Geometry::measure(&opened.mesh, positions);
        let measures = measure(&opened, &geometry, &flattening);
        // No sides cross here; they run along each other.
        assert_eq!(measures.totals.overlaps > 0, overlaps, "{count}");
        assert_eq!(validity.totals.is_valid(), !overlaps);
    }
}

#[test]
fn strips_that_wind_more_than_once_overlap_and_spirals_that_make_room_do_not() {
    for turns in [0.7, 1.5, 2.3] {
        let (places, triangles) = sector([120, 4], turns * TAU, |_, row| 1.0 + row);
        let (opened, flattening) = charted(&places, &triangles);
        let validity = validate(&opened, &flattening, None);
        assert_eq!(validity.is_valid(), turns < 1.0, "{turns}");
        // Area of a sector, times how often pairs cover it, up to the polygons' corners.
        let pairs = match turns {
            t if t < 1.0 => 0.0,
            t if t < 2.0 => t - 1.0,
            t => 3.0 * (t - 2.0) + (3.0 - t),
        };
        let area = pairs * TAU * 1.5;
        assert!((validity.totals.overlapping_area - area).abs() <= 0.02 * area, "{turns}");
        // Faces beyond the first turn lie on others, and those below them too.
        let twice = if turns < 1.0 { 0.0 } else { (2.0 * (turns - 1.0f64)).min(turns) / turns };
        let share = validity.covered_twice.len() as f64 / triangles.len() as f64;
        assert!((share - twice).abs() < 0.03, "{turns}: {share}");
    }
    let (places, triangles) = sector([200, 3], 2.5 * TAU, |turn, row| 1.0 + 2.5 * turn + 0.9 * row);
    let (opened, flattening) = charted(&places, &triangles);
    assert!(validate(&opened, &flattening, None).is_valid());
}

#[test]
fn flips_are_found_with_their_faces_and_overlap_their_neighbours() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let places = [p(0.0, 0.0), p(4.0, 0.0), p(4.0, 4.0), p(0.0, 4.0), p(5.0, 1.0)];
    let fan = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    // The middle vertex lies outside, beyond the side 1-2.
    let (opened, flattening) = charted(&places, &fan);
    let validity = validate(&opened, &flattening, None);
    assert_eq!(validity.totals.flipped, 1);
    let (face, area) = validity.totals.smallest.unwrap();
    assert_eq!((face.0, area), (1, -2.0));
    assert!(validity.totals.pairs >= 2 && !validity.is_valid());
    assert!(validity.covered_twice.contains(&face));
    assert_eq!(validity.totals.crossings, 0, "the outline is a square");
}

#[test]
fn charts_inside_each_other_or_along_each_other_overlap_on_the_sheet() {
    let square = |x: f64, y: f64, size: f64| {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[i, j]| Point2::new(x + size * i, y + size * j))
    };
    let cases = [
        ("apart", square(2.0, 0.0, 1.0), 0),
        ("side by side", square(1.0, 0.0, 1.0), 0),
        ("corner to corner", square(1.0, 1.0, 1.0), 0),
        ("inside", square(0.25, 0.25, 0.5), 1),
        ("inside, in a corner", square(0.0, 0.0, 0.5), 1),
        ("the same", square(0.0, 0.0, 1.0), 1),
        ("shifted along a side", square(0.5, 0.0, 1.0), 1),
        ("crossing", square(0.5, 0.5, 1.0), 2),
    ];
    for (name, other, overlaps) in cases {
        let places = [square(0.0, 0.0, 1.0), other].concat();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let (opened, flattening) = charted(&places, &triangles);
        let still = Pose { angle: 0.0, shift: Vector2::zeros() };
        let mut packing = flattening.pack(&opened, 0, 0.1, None);
        packing.poses = vec![still; 2];
        let found = measures::overlaps_across(&opened, &flattening, &packing);
        assert_eq!(found, overlaps, "{name}");
        let validity = validate(&opened, &flattening, Some(&packing));
        assert_eq!(validity.across.pairs > 0, overlaps > 0, "{name}");
        assert_eq!(validity.totals.pairs, validity.across.pairs);
        assert!(validate(&opened, &flattening, None).is_valid(), "each for itself is fine");
    }
}

#[test]
fn sides_that_touch_are_told_from_sides_that_cross() {
    let outline = |points: &[[f64; 2]]| points.iter().map(|&p| Point2::from(p)).collect::<Vec<_>>();
    // A slit: the way in and the way back are the same.
    let slit = outline(&[
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 0.5],
        [1.0, 1.0],
        [0.0, 1.0],
    ]);
    let found = contacts(&[&slit]);
    assert!(found.crossings.is_empty());
    assert!(!found.touches.is_empty());
    let simple = outline(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 0.5], [0.0, 1.0]]);
    assert_eq!(contacts(&[&simple]), Default::default());
    assert_eq!(winding(&simple, Point2::new(0.5, 0.5)), 1);
    assert_eq!(winding(&simple, Point2::new(1.0, 0.9)), 0);
    let twice = [simple.clone(), simple.clone()].concat();
    assert_eq!(winding(&twice, Point2::new(0.5, 0.5)), 2);
    assert!(contacts(&[&twice]).crossings.is_empty());
    assert!(!contacts(&[&twice]).touches.is_empty());
}

#[test]
fn measures_of_a_linear_map_say_stretch_and_energy() {
    // A right triangle stretched by 2 and squeezed to 1/2, and one kept.
    let p = |x: f64, y: f64| Point2::new(x, y);
    let flat = [p(0.0, 0.0), p(2.0, 0.0), p(0.0, 0.5), p(5.0, 5.0), p(6.0, 5.0), p(5.0, 6.0)];
    let (opened, flattening) = charted(&flat, &[[0, 1, 2], [3, 4, 5]]);
    let space = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let positions = space.iter().chain(&space).map(|p| Point3::new(p[0], p[1], 0.0)).collect();
    let geometry = Geometry::measure(&opened.mesh, positions);
    let measures = measure(&opened, &geometry, &flattening);
    let [Some(first), Some(second)] = &measures.charts[..] else { panic!("two charts") };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    close(first.linf_stretch, 2.0);
    close(first.l2_stretch, (4.25f64 / 2.0).sqrt());
    close(first.l2_stretch_normalized, first.l2_stretch);
    close(first.symmetric_dirichlet, 0.25 * (4.25 + 4.25));
    close(first.smallest_signed_area, 0.5);
    let isometric = |m: &ChartMeasures| {
        [m.l2_stretch, m.linf_stretch, m.l2_stretch_normalized, m.symmetric_dirichlet]
    };
    assert!(isometric(second).iter().all(|x| (x - 1.0).abs() < 1e-14));
    close(measures.totals.symmetric_dirichlet, 0.5 * (2.125 + 1.0));
    close(measures.face_stretches[0], first.l2_stretch);
    close(measures.face_symmetric_dirichlet[1], 1.0);
    // A similarity is isometric up to size.
    let large: Vec<Point2<f64>> = flat.iter().map(|p| p * 3.0).collect();
    let (opened, flattening) = charted(&large, &[[3, 4, 5]]);
    let mut places = vec![Point3::origin(); 3];
    places.extend(space.iter().map(|p| Point3::new(p[0], p[1], 0.0)));
    let geometry = Geometry::measure(&opened.mesh, places);
    let totals = measure(&opened, &geometry, &flattening).totals;
    close(totals.linf_stretch, 1.0 / 3.0);
    close(totals.linf_stretch_normalized, 1.0);
}
