//! Splitting: charts that overlap themselves become disks that do not, by few and short cuts.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use cutflow::flatten::{
    Flattening, Flips, Split, SplitParams, bff_scaled, measure, split_overlaps, validate,
};
use cutflow::geometry::Geometry;
use cutflow::mesh::{CutMesh, FaceId, Mesh, OpenedMesh, VertexId};
use cutflow::methods::cones::{
    Cone, ConeFields, ConeFlow, ConeParams, RoundParams, round_clusters,
};
use cutflow::methods::cutgraph::{Seams, cut_through};
use cutflow::methods::flow::{Flow, Status};
use nalgebra::{Point2, Point3};

use super::surfaces::Surface;
use super::validity::{charted, common_area, sector};

/// Charts with their surface.
struct Case {
    cut: CutMesh,
    opened: OpenedMesh,
    geometry: Geometry,
    flattening: Flattening,
}

impl Case {
    /// A chart laid out by hand, with its plane for surface.
    fn flat(places: &[Point2<f64>], triangles: &[[u32; 3]]) -> Self {
        let (opened, flattening) = charted(places, triangles);
        let positions = places.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
        let geometry = Geometry::measure(&opened.mesh, positions);
        let cut = CutMesh::uncut(&Mesh::new(places.len(), triangles).unwrap());
        Self { cut, opened, geometry, flattening }
    }

    fn split(&self, params: &SplitParams) -> Split {
        let Self { cut, opened, geometry, flattening } = self;
        let split = split_overlaps(cut, opened, geometry, flattening, &[], params).unwrap();
        self.check(&split);
        split
    }

    /// What holds after any splitting.
    fn check(&self, split: &Split) {
        let (old, new) = (&self.opened, &split.opened);
        assert_eq!(split.cut.triangles, self.cut.triangles);
        let (before, added) = split.cut.cut_edges.split_at(self.cut.cut_edges.len());
        assert_eq!((before, added), (&self.cut.cut_edges[..], &split.edges[..]));
        assert!(new.patch_shapes().iter().all(|&shape| shape == (1, 1)), "disks");
        assert_eq!(new.patch_count, old.patch_count + split.added);
        let same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
        let mirrored: BTreeSet<usize> = (0..new.mesh.face_count())
            .filter(|&f| {
                let f = FaceId::from(f);
                let [a, b] = [(old, &self.flattening), (new, &split.flattening)]
                    .map(|(mesh, flat)| flat.uv[mesh.mesh.face_vertices(f)[0].index()]);
                !same(a.x, b.x)
            })
            .collect();
        for f in new.mesh.faces() {
            let corners = old.mesh.face_vertices(f).into_iter().zip(new.mesh.face_vertices(f));
            for (v, w) in corners {
                assert_eq!(old.vertex_points[v.index()], new.vertex_points[w.index()]);
                let (a, b) = (self.flattening.uv[v.index()], split.flattening.uv[w.index()]);
                let sign = if mirrored.contains(&f.index()) { -1.0 } else { 1.0 };
                assert!(same(sign * a.x, b.x) && same(a.y, b.y), "places stay");
                assert!(same(self.flattening.u[v.index()], split.flattening.u[w.index()]));
            }
        }
        let partners = old.mesh.faces().flat_map(|f| new.mesh.face_halfedges(f));
        for h in partners.filter(|&h| new.partner(h).is_some()) {
            let place = |v: VertexId| split.flattening.uv[v.index()];
            let length = |h| (place(new.mesh.tip(h)) - place(new.mesh.tail(h))).norm();
            let ratio = length(h) / length(new.partner(h).unwrap());
            assert!(!self.flattening.seams_equal || (ratio - 1.0).abs() < 1e-9, "{ratio}");
        }
    }
}

/// Pairs of faces of one chart that share area beyond rounding, found without any of the engine's code.
fn brute_pairs(opened: &OpenedMesh, flattening: &Flattening) -> usize {
    let mut charts = vec![Vec::new(); opened.patch_count];
    for f in opened.mesh.faces() {
        let t = opened.mesh.face_vertices(f).map(|v| flattening.uv[v.index()]);
        charts[opened.face_patches[f.index()] as usize].push(t);
    }
    let mut pairs = 0;
    for mut triangles in charts {
        let left = |t: &[Point2<f64>; 3]| t[0].x.min(t[1].x).min(t[2].x);
        let right = |t: &[Point2<f64>; 3]| t[0].x.max(t[1].x).max(t[2].x);
        let low = |t: &[Point2<f64>; 3]| t[0].y.min(t[1].y).min(t[2].y);
        let high = |t: &[Point2<f64>; 3]| t[0].y.max(t[1].y).max(t[2].y);
        triangles.sort_by(|s, t| left(s).total_cmp(&left(t)));
        let area = |t: &[Point2<f64>; 3]| 0.5 * (t[1] - t[0]).perp(&(t[2] - t[0])).abs();
        let total: f64 = triangles.iter().map(area).sum();
        for (i, s) in triangles.iter().enumerate() {
            let end = right(s);
            for t in triangles[i + 1..].iter().take_while(|t| left(t) < end) {
                if low(s) < high(t) && low(t) < high(s) {
                    // Neighbours share rounding of 1e-16 of the extent times a side.
                    pairs += usize::from(common_area(s, t) > 1e-14 * total);
                }
            }
        }
    }
    pairs
}

/// Optimal cones, merged, with the scale factors that they give.
pub fn cones(surface: &Surface, lambda: f64) -> (Vec<Cone>, Vec<f64>) {
    let params = ConeParams { lambda, ..ConeParams::default() };
    let fields = ConeFields::default();
    let mut flow = ConeFlow::new(&surface.mesh, &surface.geometry, &params, &fields).unwrap();
    while flow.status() == Status::Running {
        flow.step().unwrap();
    }
    let found = flow.state().cones.clone();
    let params = RoundParams::default();
    let rounded = round_clusters(&surface.mesh, &surface.geometry, &found, &params).cones;
    let u = flow.evaluate(&rounded).unwrap().u;
    (rounded, u)
}

/// The surface opened along seams and flattened with these scale factors.
fn laid_out(surface: &Surface, seams: Seams, u: &[f64]) -> Case {
    let Seams { cut, opened, .. } = seams;
    let place = |&p: &u32| surface.geometry.positions[p as usize];
    let places = opened.vertex_points.iter().map(place).collect();
    let geometry = Geometry::measure(&opened.mesh, places);
    let rim_u: Vec<f64> = opened.vertex_points.iter().map(|&p| u[p as usize]).collect();
    let flattening = bff_scaled(&opened, &geometry, &rim_u).unwrap();
    Case { cut, opened, geometry, flattening }
}

#[test]
fn charts_with_many_cones_are_split_by_few_short_cuts() {
    for (name, lambda, most_cuts, most_length) in [
        ("spot.obj", 0.001, 8, 0.4),
        ("cheburashka.obj", 0.00042, 14, 1.3),
        ("bunny-closed.obj", 0.0005, 16, 0.7),
        ("face.obj", 0.001, 10, 0.4),
    ] {
        let Some(surface) = Surface::shared(name) else { continue };
        let (cones, u) = cones(&surface, lambda);
        let places: Vec<VertexId> = cones.iter().map(|c| c.vertex).collect();
        let seams = cut_through(&surface.mesh, &surface.geometry, &places, &[]).unwrap();
        let case = laid_out(&surface, seams, &u);
        let before = validate(&case.opened, &case.flattening, None).totals;
        let now = std::time::Instant::now();
        let split = case.split(&SplitParams { tolerance: 0.0, ..SplitParams::default() });
        println!(
            "{name} {lambda}: {} cones, {} flips, {} pairs, {:.2} % overlap, {} added, length {:.3}, left {}, {} ms",
            cones.len(),
            before.flipped,
            before.pairs,
            100.0 * before.overlapping_area
                / measure(&case.opened, &case.geometry, &case.flattening).totals.area,
            split.added,
            split.length,
            split.left.len(),
            now.elapsed().as_millis()
        );
        let flips: BTreeSet<FaceId> = split.flips.iter().map(|flip| flip.face).collect();
        assert_eq!(flips.len(), before.flipped);
        let after = validate(&split.opened, &split.flattening, None).totals;
        assert_eq!(after.pairs, split.left.len(), "what is left is what is told");
        if flips.is_empty() {
            assert_eq!(after.pairs, 0);
            assert_eq!(brute_pairs(&split.opened, &split.flattening), 0);
        }
        assert!(split.added <= most_cuts && split.length < most_length);
        // With flipped faces cut out and mirrored nothing is left.
        if !flips.is_empty() {
            let out = case.split(&SplitParams {
                tolerance: 0.0,
                flips: Flips::CutOut,
                ..SplitParams::default()
            });
            println!("  cut out: {} added, length {:.3}", out.added, out.length);
            assert!(validate(&out.opened, &out.flattening, None).is_valid());
            assert_eq!((out.left.len(), out.flips.len()), (0, 0));
            assert_eq!(brute_pairs(&out.opened, &out.flattening), 0);
        }
    }
}

#[test]
fn strips_that_wind_are_parted_once_a_turn() {
    for (turns, most) in [(0.9, 0), (1.5, 1), (2.4, 2), (3.3, 3)] {
        let (places, triangles) = sector([160, 5], turns * TAU, |_, row| 1.0 + row);
        let case = Case::flat(&places, &triangles);
        let split = case.split(&SplitParams::default());
        assert_eq!(split.added, most, "{turns}");
        // Every cut is a straight one across.
        assert!((split.length - most as f64).abs() < 1e-9, "{}", split.length);
        assert!(validate(&split.opened, &split.flattening, None).is_valid());
        assert_eq!(brute_pairs(&split.opened, &split.flattening), 0);
    }
    // A spiral that gets narrower faster than it makes room.
    let (places, triangles) =
        sector([300, 4], 3.0 * TAU, |turn, row| (2.0 - 0.5 * turn) * (1.0 + 0.4 * row));
    let case = Case::flat(&places, &triangles);
    let split = case.split(&SplitParams::default());
    assert!((2..=4).contains(&split.added), "{}", split.added);
    assert_eq!(brute_pairs(&split.opened, &split.flattening), 0);
}

#[test]
fn a_sector_of_more_than_a_full_turn_about_a_cone_is_parted_at_the_cone() {
    // A cone of total angle 2.6 π, slit once: rows of a sector that begin in one point.
    let (n, m) = (60u32, 8u32);
    let (ring, squares) =
        sector([n, m - 1], 1.3 * TAU, |_, row| (1.0 + row * f64::from(m - 1)) / f64::from(m));
    let apex = ring.len() as u32;
    let places = [ring, vec![Point2::origin()]].concat();
    let mut triangles = squares;
    triangles.extend((0..n).map(|i| [apex, i * m, (i + 1) * m]));
    let case = Case::flat(&places, &triangles);
    assert!(!validate(&case.opened, &case.flattening, None).is_valid());
    let split = case.split(&SplitParams::default());
    assert_eq!(split.added, 1);
    // From the cone to the rim, which is at distance 1.
    assert!((split.length - 1.0).abs() < 1e-9, "{}", split.length);
    assert!(split.edges.iter().any(|edge| edge.contains(&apex)));
    assert_eq!(brute_pairs(&split.opened, &split.flattening), 0);
}

#[test]
fn a_lobe_over_the_middle_of_a_sheet_is_cut_off_and_dear_seams_are_avoided() {
    // A long strip that goes around and comes to lie on its own middle.
    let (places, triangles) = sector([200, 6], 1.25 * TAU, |turn, row| {
        let inwards = 1.0 - 0.55 * (turn * 1.25 - 0.9).max(0.0) / 0.35;
        2.0 * inwards + 0.5 * row
    });
    let case = Case::flat(&places, &triangles);
    let split = case.split(&SplitParams::default());
    assert_eq!(brute_pairs(&split.opened, &split.flattening), 0);
    // Where seams cost a hundred times as much, another place is found.
    let touched: BTreeSet<u32> = split.edges.iter().flatten().copied().collect();
    if split.added == 0 {
        return;
    }
    let cost: Vec<f64> =
        (0..places.len() as u32).map(|p| if touched.contains(&p) { 100.0 } else { 0.0 }).collect();
    let other = split_overlaps(
        &case.cut,
        &case.opened,
        &case.geometry,
        &case.flattening,
        &cost,
        &SplitParams::default(),
    )
    .unwrap();
    case.check(&other);
    let again: BTreeSet<u32> = other.edges.iter().flatten().copied().collect();
    assert!(again.is_disjoint(&touched));
    assert_eq!(brute_pairs(&other.opened, &other.flattening), 0);
}

#[test]
fn slits_that_rounding_closes_are_left_alone_and_the_limit_of_charts_is_kept() {
    // Two halves of a square that hang together at one end; the slit between them is closed to rounding, and a little beyond.
    let mut places = Vec::new();
    let mut triangles = Vec::new();
    for half in [0.0, 1.0] {
        for i in 0..=10u32 {
            let slit = if half > 0.0 { 1.0 - 1e-16 * f64::from(i % 3) } else { 1.0 };
            let rows = if half > 0.0 { [slit, 2.0] } else { [0.0, slit] };
            places.extend(rows.map(|y| Point2::new(f64::from(i), y)));
        }
    }
    for half in [0u32, 22] {
        for i in 0..10 {
            let a = half + 2 * i;
            triangles.extend([[a, a + 2, a + 3], [a, a + 3, a + 1]]);
        }
    }
    // The ends are one point.
    let joined = 10 * 2 + 1;
    triangles.iter_mut().flatten().for_each(|v| {
        if *v == 22 + 20 {
            *v = joined;
        }
    });
    places[joined as usize].y = 1.0;
    triangles.push([joined, 20, 44]);
    triangles.push([joined, 44, 43]);
    places.push(Point2::new(12.0, 1.0));
    let case = Case::flat(&places, &triangles);
    let split = case.split(&SplitParams::default());
    assert_eq!(split.added, 0);
    let pairs = validate(&case.opened, &case.flattening, None).totals.pairs;
    assert_eq!(split.ignored.0, pairs);

    let (places, triangles) = sector([160, 5], 3.3 * TAU, |_, row| 1.0 + row);
    let case = Case::flat(&places, &triangles);
    let split = case.split(&SplitParams { most_added: 1, ..SplitParams::default() });
    assert_eq!(split.added, 1);
    assert!(!split.left.is_empty());
    let pairs = validate(&split.opened, &split.flattening, None).totals.pairs;
    assert_eq!(split.left.len(), pairs);
}

#[test]
fn flipped_faces_are_reported_with_their_neighbourhood_or_cut_out() {
    let n = 8u32;
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let mut places: Vec<Point2<f64>> = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| Point2::new(f64::from(i), f64::from(j))))
        .collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    places[at(4, 4) as usize] = Point2::new(5.4, 4.7);
    let case = Case::flat(&places, &triangles);
    let flipped = validate(&case.opened, &case.flattening, None).totals.flipped;
    assert!(flipped > 0);
    let split = case.split(&SplitParams::default());
    assert_eq!((split.added, split.flips.len()), (0, flipped));
    for flip in &split.flips {
        assert!(flip.neighbourhood.len() >= 9 && !flip.neighbourhood.contains(&flip.face));
    }
    assert_eq!(split.left.len(), validate(&case.opened, &case.flattening, None).totals.pairs);
    let split = case.split(&SplitParams { flips: Flips::CutOut, ..SplitParams::default() });
    assert!(validate(&split.opened, &split.flattening, None).is_valid());
    assert_eq!(brute_pairs(&split.opened, &split.flattening), 0);
    assert!(split.left.is_empty() && split.flips.is_empty());
}
