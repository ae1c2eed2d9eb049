//! Glue flaps: one for each stretch of a seam, in nobody's way, and within the piece that they are glued to.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};

use cutflow::flatten::overlap::contacts;
use cutflow::pattern::{
    Flap, FlapNotice, FlapParams, FlapSide, FoldParams, Pattern, cut_with_flaps, flap_labels,
    flaps, folds,
};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;
use nalgebra::{Point2, Point3};

use crate::patterns::{Example, box_with_lid, pillow, slit_prism};

fn area(points: &[[f64; 2]]) -> f64 {
    let n = points.len();
    let o = points[0];
    let cross = |i: usize| {
        let (a, b) = (points[i], points[(i + 1) % n]);
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    0.5 * (0..n).map(cross).sum::<f64>()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

struct Made {
    pattern: Pattern,
    flaps: Vec<Vec<Flap>>,
    notices: Vec<FlapNotice>,
}

fn make(example: &Example, mm: f64, params: &FlapParams) -> Made {
    let (pattern, _) = example.pattern(mm);
    let laid = example.laid(mm);
    let folds = folds(&laid, &pattern, &FoldParams::default());
    let (flaps, notices) = flaps(&laid, &pattern, &folds, params);
    Made { pattern, flaps, notices }
}

impl Made {
    /// All that is promised, by other means than those of the code: the cut lines with flaps do not meet themselves, enclose what the
    /// piece and its flaps do, and each flap lies within its partner.
    fn check(&self, params: &FlapParams) {
        for (index, (piece, flaps)) in self.pattern.pieces.iter().zip(&self.flaps).enumerate() {
            let cut = cut_with_flaps(piece, flaps);
            assert_eq!(cut.len(), piece.outlines.len());
            let before = piece.outlines.iter().map(|outline| outline.points.clone());
            assert_eq!(meetings(&cut), meetings(&Vec::from_iter(before)), "piece {}", piece.name);
            let total: f64 = cut.iter().map(|outline| area(outline)).sum();
            // Clockwise from end to end of the base and back along it: on the outer side.
            let added: f64 = flaps
                .iter()
                .map(|flap| {
                    let mut ring = flap.base.points(&self.pattern);
                    ring.extend(flap.points[1..flap.points.len() - 1].iter().rev());
                    -area(&ring)
                })
                .sum();
            // Rounding of sums.
            assert!((total - piece.area_mm2 - added).abs() < 1e-9 * total, "{total} {added}");
            for flap in flaps {
                assert_eq!(flap.base.piece, index);
                self.check_flap(flap, params);
            }
        }
    }

    fn check_flap(&self, flap: &Flap, params: &FlapParams) {
        let base = flap.base.points(&self.pattern);
        let [p, q] = [base[0], base[base.len() - 1]];
        assert_eq!([flap.points[0], flap.points[flap.points.len() - 1]], [p, q]);
        // A point is up to a little higher than the trapezoid whose top vanished.
        let most = params.depth_mm.min(0.4 * distance(p, q)) * (1.0 + 1e-9);
        let height = if flap.points.len() == 3 { most + 1.0 } else { most };
        assert!(flap.depth_mm <= height, "{} {most}", flap.depth_mm);
        assert!(area(&flap.points) > 0.1 * flap.depth_mm.powi(2));
        let Some(partner) = flap.partner else { return };
        // Glued: base on base, without distortion, as these examples unfold.
        let other = partner.points(&self.pattern);
        let [end, start] = [other[0], other[other.len() - 1]].map(Point2::from);
        let turn = nalgebra::Rotation2::rotation_between(
            &(Point2::from(q) - Point2::from(p)),
            &(end - start),
        );
        let glued: Vec<[f64; 2]> = flap
            .points
            .iter()
            .map(|&x| (start + turn * (Point2::from(x) - Point2::from(p))).into())
            .collect();
        let outlines = self.pattern.pieces[partner.piece].outlines.iter();
        let outlines: Vec<Vec<[f64; 2]>> = outlines.map(|outline| outline.points.clone()).collect();
        let common =
            vec![glued.clone()].overlay(&outlines, OverlayRule::Intersect, FillRule::EvenOdd);
        let common: f64 = common.iter().flatten().map(|ring| area(ring)).sum();
        // The judge rounds coordinates; a curved seam runs a little beside its chord, on either side.
        let slack = 1e-3 + if base.len() > 2 { params.tolerance_mm * distance(p, q) } else { 0.0 };
        assert!((common - area(&glued).abs()).abs() < slack, "{common} {}", area(&glued));
    }

    /// Numbers of seams with flaps on their first, and on their second side.
    fn sides(&self) -> [BTreeSet<usize>; 2] {
        let on = |is_second: bool| {
            let flaps = self.flaps.iter().flatten();
            let of = |f: &&Flap| {
                self.pattern.pieces[f.base.piece].seams[f.base.seam].is_second == is_second
            };
            flaps.filter(of).map(|flap| flap.number).collect()
        };
        [on(false), on(true)]
    }

    fn seam_count(&self) -> usize {
        self.pattern.pieces.iter().flat_map(|p| &p.seams).map(|s| s.number).max().unwrap_or(0)
    }

    /// Each seam has flaps on one side.
    fn check_sides(&self) {
        let [first, second] = self.sides();
        assert!(first.is_disjoint(&second), "{first:?} {second:?}");
        assert_eq!(first.len() + second.len(), self.seam_count());
    }
}

/// How often outlines meet themselves or each other.
fn meetings(outlines: &[Vec<[f64; 2]>]) -> (usize, usize) {
    let outlines: Vec<Vec<Point2<f64>>> =
        outlines.iter().map(|o| o.iter().copied().map(Point2::from).collect()).collect();
    let outlines: Vec<&[Point2<f64>]> = outlines.iter().map(Vec::as_slice).collect();
    let found = contacts(&outlines);
    (found.crossings.len(), found.touches.len())
}

fn tetrahedron() -> Example {
    let positions = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let triangles = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    Example::new(positions, &triangles, &[[0, 1], [0, 2], [0, 3]])
}

/// Two disks on each other, the lower one turned over: a round pillow.
fn round_pillow(n: u32) -> Example {
    let mut positions = vec![[0.0; 3], [0.0; 3]];
    for i in 0..n {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
        positions.push([cos, sin, 0.0]);
    }
    let rim = |i: u32| 2 + i % n;
    let fan = (0..n).flat_map(|i| [[0, rim(i), rim(i + 1)], [1, rim(i + 1), rim(i)]]);
    let cuts: Vec<[u32; 2]> = (0..n).map(|i| [rim(i), rim(i + 1)]).collect();
    Example::new(positions, &Vec::from_iter(fan), &cuts)
}

#[test]
fn every_seam_of_a_box_gets_one_whole_flap() {
    let params = FlapParams::default();
    for (example, count) in [(box_with_lid(), 8), (tetrahedron(), 3)] {
        let made = make(&example, 50.0, &params);
        assert!(made.notices.is_empty(), "{:?}", made.notices);
        made.check(&params);
        made.check_sides();
        let all: Vec<&Flap> = made.flaps.iter().flatten().collect();
        assert_eq!((all.len(), made.seam_count()), (count, count));
        for flap in all {
            assert_eq!((flap.points.len(), flap.stretch), (4, (1, 1)));
            assert!(flap.depth_mm == 7.0, "there is room");
            assert!(flap.angle > 1.0, "folded under");
        }
    }
    // Taking turns: no two neighbours around the lid have flaps.
    let made = make(&box_with_lid(), 50.0, &params);
    assert!(made.flaps[1].len() <= 2 && made.flaps[0].len() >= 6);
}

#[test]
fn the_side_of_the_flaps_can_be_chosen() {
    let of = |side| FlapParams { side, ..FlapParams::default() };
    let example = box_with_lid();
    let first = make(&example, 50.0, &of(FlapSide::First));
    assert_eq!(first.sides()[1], BTreeSet::new());
    // The lid is smaller; the standing edges join the cross to itself.
    let small = make(&example, 50.0, &of(FlapSide::SmallerPiece));
    assert_eq!(small.flaps.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
    let both = make(&example, 50.0, &of(FlapSide::Both));
    let [a, b] = both.sides();
    assert_eq!((a.len(), b.len()), (8, 8));
    for made in [&first, &small, &both] {
        assert!(made.notices.is_empty());
        made.check(&FlapParams::default());
    }
    let zigzag = make(&round_pillow(60), 80.0, &of(FlapSide::Zigzag));
    let [a, b] = [0, 1].map(|i| zigzag.flaps[i].len());
    assert!(a.abs_diff(b) <= 1 && a > 5, "{a} {b}");
    zigzag.check(&FlapParams::default());
}

#[test]
fn curved_seams_get_teeth() {
    let params = FlapParams::default();
    for (example, mm) in [(round_pillow(60), 80.0), (round_pillow(200), 40.0)] {
        let made = make(&example, mm, &params);
        assert!(made.notices.is_empty(), "{:?}", made.notices);
        made.check(&params);
        made.check_sides();
        let teeth = &made.flaps[0];
        // Sagitta: a chord of length L over radius R is off by L² / 8 R.
        let longest = (8.0 * mm * 1.25 * params.tolerance_mm).sqrt();
        assert!(teeth.len() as f64 > TAU * mm / longest * 0.99, "{}", teeth.len());
        let along: usize = teeth.iter().map(|flap| flap.base.sides).sum();
        assert_eq!(along, made.pattern.pieces[0].outlines[0].points.len());
        let labels = flap_labels(&made.pattern, &made.flaps);
        assert!(labels.iter().all(|label| label.text.starts_with("1.")));
        assert!(!labels.is_empty() && labels.len().is_multiple_of(2));
    }
    // A square pillow has corners, and no stretch goes around one.
    let made = make(&pillow(), 50.0, &params);
    made.check(&params);
    made.check_sides();
    assert_eq!(made.flaps[0].len(), 4);
}

#[test]
fn the_numbers_on_a_flap_and_on_its_partner_are_the_same_and_lie_inside() {
    let made = make(&box_with_lid(), 60.0, &FlapParams::default());
    let labels = flap_labels(&made.pattern, &made.flaps);
    assert_eq!(labels.len(), 16);
    for pair in labels.chunks(2) {
        assert_eq!(pair[0].text, pair[1].text);
        assert_eq!([pair[0].is_on_flap, pair[1].is_on_flap], [true, false]);
        assert!(pair.iter().all(|label| (2.0..=3.0).contains(&label.height)));
        let number = |i: usize| made.pattern.pieces[pair[i].piece].seams[pair[i].seam].number;
        assert_eq!(
            [number(0), number(1)].map(|n| n.to_string()),
            [0, 1].map(|i| pair[i].text.clone())
        );
    }
}

#[test]
fn a_slit_in_flat_material_has_no_room_for_flaps_and_is_told() {
    // Unfolded, both sides of the prism's slit lie on each other; the seam from end to end is free.
    let params = FlapParams::default();
    let made = make(&slit_prism(), 20.0, &params);
    made.check(&params);
    let slit = made.pattern.pieces[0].seams.iter().find(|s| s.sides == 2).unwrap().number;
    assert!(made.flaps.iter().flatten().all(|flap| flap.number != slit));
    let [FlapNotice::NoRoom { number, patches, length_mm }] = made.notices[..] else {
        panic!("{:?}", made.notices)
    };
    assert_eq!((number, patches), (slit, [0, 0]));
    assert!((length_mm - 20.0).abs() < 1e-9);
    assert!(made.notices[0].to_string().contains("use tape there"));
    // Small enough, nothing is long enough.
    let made = make(&slit_prism(), 0.5, &params);
    assert!(made.flaps.iter().all(Vec::is_empty));
    assert!(made.notices.iter().all(|n| matches!(n, FlapNotice::TooShort { .. })));
}

#[test]
fn larger_models_have_the_same_flaps_at_depth_in_proportion() {
    let example = box_with_lid();
    let params = FlapParams { side: FlapSide::First, ..FlapParams::default() };
    let small = make(&example, 50.0, &params);
    let scaled = FlapParams { depth_mm: 70.0, ..params };
    let large = make(&example, 500.0, &scaled);
    for (a, b) in small.flaps.iter().flatten().zip(large.flaps.iter().flatten()) {
        assert_eq!((a.base, a.partner), (b.base, b.partner));
        // Rounding about 1500 mm.
        let is_scaled = |(p, q): (&[f64; 2], &[f64; 2])| distance(p.map(|x| 10.0 * x), *q) < 1e-9;
        assert!(a.points.iter().zip(&b.points).all(is_scaled));
    }
}

/// Numbers from 0 to 1 (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The hull of random points on a sphere, unfolded along a random tree of its faces, some edges of which are cut as well.
fn random_polyhedron(seed: u64, points: usize, extra: f64) -> Example {
    let mut random = Random(seed);
    let positions: Vec<[f64; 3]> = (0..points)
        .map(|_| {
            let (z, angle) = (2.0 * random.next() - 1.0, TAU * random.next());
            let r = (1.0 - z * z).sqrt();
            [r * angle.cos(), r * angle.sin(), z]
        })
        .collect();
    let at = |i: usize| Point3::from(positions[i]);
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for i in 0..points {
        for j in i + 1..points {
            for k in j + 1..points {
                let normal = (at(j) - at(i)).cross(&(at(k) - at(i)));
                let sides: Vec<f64> = (0..points)
                    .filter(|l| ![i, j, k].contains(l))
                    .map(|l| normal.dot(&(at(l) - at(i))))
                    .collect();
                let [i, j, k] = [i, j, k].map(|x| x as u32);
                if sides.iter().all(|&s| s < 0.0) {
                    triangles.push([i, j, k]);
                } else if sides.iter().all(|&s| s > 0.0) {
                    triangles.push([i, k, j]);
                }
            }
        }
    }
    assert_eq!(triangles.len(), 2 * points - 4);
    let mut faces: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (f, t) in triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            faces.entry([a.min(b), a.max(b)]).or_default().push(f);
        }
    }
    let mut edges: Vec<(f64, [u32; 2], usize, usize)> =
        faces.iter().map(|(&e, f)| (random.next(), e, f[0], f[1])).collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut groups: Vec<usize> = (0..triangles.len()).collect();
    let mut cuts = Vec::new();
    for (_, edge, f, g) in edges {
        let (a, b) = (groups[f], groups[g]);
        if a == b || random.next() < extra {
            cuts.push(edge);
        } else {
            groups.iter_mut().filter(|x| **x == b).for_each(|x| *x = a);
        }
    }
    Example::new(positions, &triangles, &cuts)
}

#[test]
fn flaps_of_random_nets_meet_nothing_and_lie_within_their_partners() {
    let (mut made_all, mut flap_count, mut told, mut moved) = (0, 0, 0, 0);
    for seed in 0..60 {
        let points = 5 + seed as usize % 12;
        let extra = [0.0, 0.1, 0.3][seed as usize % 3];
        let example = random_polyhedron(seed, points, extra);
        let side =
            [FlapSide::Alternate, FlapSide::SmallerPiece, FlapSide::First][seed as usize % 3];
        let params = FlapParams { side, depth_mm: 8.0, angle: PI / 3.0, ..FlapParams::default() };
        let made = make(&example, 60.0, &params);
        // Nets of convex bodies may overlap themselves: those are told elsewhere and no one cuts them.
        if made.pattern.pieces.iter().any(|piece| piece.crossings > 0) {
            continue;
        }
        made_all += 1;
        made.check(&params);
        let without: BTreeSet<usize> = made
            .notices
            .iter()
            .map(|notice| match *notice {
                FlapNotice::NoRoom { number, .. } | FlapNotice::TooShort { number, .. } => number,
                FlapNotice::Moved { number, .. } => {
                    moved += 1;
                    number
                }
            })
            .collect();
        told += without.len();
        let [first, second] = made.sides();
        assert!(first.is_disjoint(&second));
        // A seam of several stretches may have flaps on some of them only.
        let seams: BTreeSet<usize> = first.iter().chain(&second).chain(&without).copied().collect();
        assert!(seams.into_iter().eq(1..=made.seam_count()), "seed {seed}");
        flap_count += made.flaps.iter().map(Vec::len).sum::<usize>();
    }
    assert!(made_all > 30 && flap_count > 300, "{made_all} {flap_count}");
    // Slivers of triangles leave no room for a flap of 2 mm on either side; most seams have some.
    assert!(told * 20 < flap_count && moved == 0, "{told} of {flap_count} without flap");
}
