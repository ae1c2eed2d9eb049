//! The doctor of meshes: what is found, and that repairs leave a surface.
//!
//! The first half makes its own patients and always runs; the second reads the collection beside the checkout, and says
//! so where there is none.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use cutflow::geometry::doctor::{
    Examination, examine, fill_holes, repair, repair_all, triangles, weld,
};
use cutflow::mesh::doctor::{FindingKind, Repair, Severity, drop_isolated, turn};
use cutflow::mesh::read::obj;
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
    Mesh::new(soup.positions.len(), &triangles(soup)).is_ok()
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

#[test]
fn a_sound_sphere_has_no_finding_and_needs_no_repair() {
    let examination = examine(&sphere());
    assert_eq!(examination.findings, []);
    assert!(examination.is_solvable && examination.is_manifold && examination.is_orientable);
    assert_eq!((examination.euler, examination.genus), (2, Some(0)));
    let [component] = &examination.components[..] else { panic!() };
    assert!(component.is_closed && component.volume.unwrap() > 3.0);
    assert_eq!(repair_all(&sphere()), (sphere(), vec![]));
}

#[test]
fn nothing_at_all_is_told_and_not_touched() {
    let empty = Soup { starts: vec![0], ..Soup::default() };
    assert_eq!(count(&examine(&empty), FindingKind::NoFaces), 1);
    assert_eq!(count(&examine(&Soup::default()), FindingKind::NoFaces), 1);
    assert!(repair_all(&empty).1.is_empty());
    for id in
        ["weld:1e-6", "fill_holes", "keep_largest", "orient", "split_edges", "keep_component:0"]
    {
        assert_eq!(repair(&empty, Repair::from_id(id).unwrap()).1, 0, "{id}");
    }
}

#[test]
fn repetitions_and_spikes_are_taken_out_of_polygons() {
    let square =
        vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.5, 0.0]];
    let soup = polygons(
        square,
        &[&[0, 0, 1, 2, 3, 3], &[1, 1, 4], &[1, 4, 2, 4], &[4, 2, 1, 2], &[0, 1, 0, 2]],
    );
    let examination = examine(&soup);
    assert_eq!(examination.find(FindingKind::RepeatedVertices).unwrap().faces, [0, 1, 2, 3, 4]);
    let (result, changed) = repair(&soup, Repair::DropRepeated);
    assert_eq!((changed, result.polygon_count(), result.polygon(0)), (5, 1, &[0, 1, 2, 3][..]));
}

#[test]
fn copies_begun_elsewhere_or_turned_over_are_duplicates_and_their_edges_are_no_fault() {
    let (positions, mut all) = ball(12);
    let n = all.len();
    for i in [3, 8, 20, 33] {
        let [a, b, c] = all[i];
        all.extend([[a, b, c], [b, c, a], [b, a, c]]);
    }
    let soup = Soup::from_triangles(positions, &all);
    let examination = examine(&soup);
    let kinds = Vec::from_iter(examination.findings.iter().map(|f| (f.kind, f.count)));
    assert_eq!(kinds, [(FindingKind::DuplicateFaces, 12)]);
    assert_eq!(examination.find(FindingKind::DuplicateFaces).unwrap().faces[0], n as u32);
    assert_eq!(cured(&soup), sphere());
    let quads = polygons(sphere().positions, &[&[2, 3, 15, 14], &[14, 15, 3, 2], &[2, 15, 3, 14]]);
    assert_eq!(examine(&quads).find(FindingKind::DuplicateFaces).unwrap().faces, [1]);
}

#[test]
fn triangles_without_area_on_top_of_a_closed_surface_are_dropped() {
    let (mut positions, mut all) = ball(12);
    let n = positions.len() as u32;
    let [a, b, _] = all[0];
    let middle = [0, 1, 2].map(|k| (positions[a as usize][k] + positions[b as usize][k]) / 2.0);
    positions.extend([positions[a as usize], middle]);
    all.extend([[a, a, b], [b, b, b], [a, n, b], [a, b, n + 1]]);
    let soup = Soup::from_triangles(positions, &all);
    let examination = examine(&soup);
    assert_eq!(count(&examination, FindingKind::DegenerateFaces), 4);
    assert_eq!(count(&examination, FindingKind::RepeatedVertices), 2);
    assert_eq!(count(&examination, FindingKind::NonManifoldEdges), 0);
    assert!(!examination.is_solvable);
    assert_eq!(drop_isolated(&cured(&soup)), (sphere(), 2));
}

#[test]
fn a_needle_is_collapsed_and_a_cap_hands_its_corner_on_so_that_nothing_opens() {
    // A tetrahedron; one edge has a cap between its two faces, then one has a needle.
    let corners =
        vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [1.0, 0.0, 0.0]];
    let cap = Soup::from_triangles(
        corners.clone(),
        &[[0, 2, 1], [0, 1, 4], [0, 4, 3], [4, 1, 3], [1, 2, 3], [0, 3, 2]],
    );
    let examination = examine(&cap);
    let finding = examination.find(FindingKind::DegenerateFaces).unwrap();
    assert_eq!((finding.severity, &finding.faces[..]), (Severity::Warning, &[1][..]));
    assert!(examination.is_solvable);
    assert_eq!(shape(&examine(&cured(&cap))), [5, 5, 1, 0, 2]);

    let mut needle = cap.clone();
    needle.positions[4] = [0.0, 0.0, 0.0];
    let result = cured(&needle);
    assert_eq!(shape(&examine(&result)), [4, 4, 1, 0, 2]);
    assert_eq!(count(&examine(&result), FindingKind::Isolated), 1);
}

#[test]
fn caps_back_to_back_go_without_a_hole() {
    // A flat square whose diagonal has two corners more on it, reached by triangles without area.
    let p = |x: f64, y: f64| [x, y, 0.0];
    let positions =
        vec![p(0.0, 0.0), p(3.0, 0.0), p(3.0, 3.0), p(0.0, 3.0), p(1.0, 1.0), p(2.0, 2.0)];
    let soup = Soup::from_triangles(
        positions,
        &[[0, 1, 4], [4, 1, 2], [0, 4, 2], [0, 2, 5], [0, 5, 3], [5, 2, 3]],
    );
    assert_eq!(count(&examine(&soup), FindingKind::DegenerateFaces), 2);
    let result = cured(&soup);
    let after = examine(&result);
    assert_eq!(shape(&after)[2..], [1, 1, 1]);
    assert!((after.area - 9.0).abs() < 1e-12, "rounding of a few products: {}", after.area);
}

#[test]
fn a_soup_of_nothing_but_lines_or_points_is_refused() {
    let line = Vec::from_iter((0..9).map(|i| [f64::from(i), 0.0, 0.0]));
    let strip = Vec::from_iter((0..7).map(|i| [i, i + 1, i + 2]));
    let examination = examine(&Soup::from_triangles(line, &strip));
    let finding = examination.find(FindingKind::DegenerateFaces).unwrap();
    assert_eq!((finding.count, finding.severity), (7, Severity::Blocks));
    let examination = examine(&Soup::from_triangles(vec![[1.0; 3]; 9], &strip));
    assert_eq!(count(&examination, FindingKind::NoExtent), 1);
    assert!(!examination.is_solvable);
}

#[test]
fn a_fin_leaves_the_surface_that_it_stands_on_closed() {
    for reversed in [false, true] {
        let (mut positions, mut all) = ball(12);
        positions.push([0.3, 0.0, 1.6]);
        let fin = positions.len() as u32 - 1;
        let [a, b, _] = all[0];
        all.insert(0, if reversed { [a, b, fin] } else { [b, a, fin] });
        let soup = Soup::from_triangles(positions, &all);
        let examination = examine(&soup);
        assert_eq!(count(&examination, FindingKind::NonManifoldEdges), 1);
        assert_eq!(examination.genus, None);
        let result = cured(&soup);
        let after = examine(&result);
        assert_eq!(result.positions.len(), soup.positions.len() + 2);
        assert!(after.components.iter().any(|part| part.is_closed && part.faces == all.len() - 1));
        assert_eq!(after.components.len(), 2);
    }
}

/// Two cubes of squares that share the edge from (0,0,0) to (0,0,1) only.
fn cubes() -> Soup {
    let mut positions = Vec::new();
    let mut faces: Vec<[u32; 4]> = Vec::new();
    for sign in [-1.0, 1.0] {
        let mut names = Vec::new();
        for k in 0..8 {
            let p = [f64::from(k & 1) * sign, f64::from(k >> 1 & 1) * sign, f64::from(k >> 2)];
            let found = positions.iter().position(|q| *q == p);
            names.push(found.unwrap_or(positions.len()) as u32);
            if found.is_none() {
                positions.push(p);
            }
        }
        for square in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            faces.push(square.map(|k: usize| names[k]));
        }
    }
    let faces = Vec::from_iter(faces.iter().map(|face| &face[..]));
    polygons(positions, &faces)
}

#[test]
fn solids_that_meet_in_an_edge_stay_closed() {
    assert_eq!(count(&examine(&cubes()), FindingKind::NonManifoldEdges), 1);
    let after = examine(&cured(&cubes()));
    assert_eq!(shape(&after), [16, 12, 2, 0, 4]);
    // Each has the volume of its cube, to the rounding of its sum.
    assert!(after.components.iter().all(|part| (part.volume.unwrap() - 1.0).abs() < 1e-12));
}

#[test]
fn a_solid_pinched_along_an_edge_gets_a_second_edge_there() {
    // The two cubes with a tunnel between them: above and below they are joined by one more cube each.
    let mut soup = cubes();
    let mut faces = Vec::from_iter((0..12).map(|i| soup.polygon(i).to_vec()));
    // A ring: take a face off each cube and join the openings by a bent square tube outside.
    let (one, other) = (faces[1].clone(), faces[7].clone());
    faces.remove(7);
    faces.remove(1);
    let first = soup.positions.len() as u32;
    for ring in [&one, &other] {
        for &v in ring {
            let [x, y, _] = soup.positions[v as usize];
            soup.positions.push([x + 0.1 * y, y, 2.0]);
        }
    }
    for (base, ring) in [(first, &one), (first + 4, &other)] {
        for k in 0..4 {
            let (l, k) = ((k + 1) % 4, k);
            faces.push(vec![ring[k], ring[l], base + l as u32, base + k as u32]);
        }
    }
    // Nothing but connectivity matters here: tube end to tube end, turned over.
    for k in 0..4 {
        let l = (k + 1) % 4;
        faces.push(vec![first + k, first + l, first + 4 + (4 - l) % 4, first + 4 + (4 - k) % 4]);
    }
    let soup = polygons(soup.positions, &Vec::from_iter(faces.iter().map(|face| &face[..])));
    let before = examine(&soup);
    assert_eq!(
        (count(&before, FindingKind::NonManifoldEdges), before.boundary_loops.len()),
        (1, 0)
    );
    let after = examine(&cured(&soup));
    assert_eq!(after.boundary_loops.len(), 0, "{:?}", after.findings);
}

#[test]
fn bow_ties_are_split_into_one_vertex_for_each_fan() {
    let cross =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [-1.0, -1.0, 0.0]];
    let soup = Soup::from_triangles(cross.to_vec(), &[[0, 1, 2], [0, 3, 4]]);
    let examination = examine(&soup);
    assert_eq!(examination.find(FindingKind::NonManifoldVertices).unwrap().vertices, [0]);
    assert_eq!(shape(&examination), [5, 2, 2, 2, 1]);
    let (result, changed) = repair(&soup, Repair::SplitVertices);
    assert_eq!((changed, shape(&examine(&result))), (1, [6, 2, 2, 2, 2]));
    assert_eq!(count(&examine(&result), FindingKind::CoincidentVertices), 0);
}

#[test]
fn flipped_faces_are_turned_back_and_closed_parts_face_outward() {
    let mut random = Random(3);
    let flips = Vec::from_iter((0..sphere().polygon_count()).map(|_| random.unit() < 0.3));
    let flipped = turn(&sphere(), |i| flips[i as usize]);
    let finding = examine(&flipped).find(FindingKind::Orientation).cloned().unwrap();
    assert_eq!(finding.faces.len(), flips.iter().filter(|&&flip| flip).count());
    assert_eq!(cured(&flipped), sphere());

    let inward = turn(&sphere(), |_| true);
    let examination = examine(&inward);
    assert!(examination.is_solvable && examination.components[0].volume.unwrap() < -3.0);
    assert_eq!(examination.find(FindingKind::InsideOut).unwrap().severity, Severity::Note);
    // Nothing blocks, so it is left as it is until asked.
    assert_eq!(cured(&inward), inward);
    assert_eq!(repair(&inward, Repair::Orient), (sphere(), sphere().polygon_count()));
    assert_eq!(repair(&inward, Repair::TurnInsideOut).0, sphere());
}

#[test]
fn open_parts_are_turned_as_little_as_possible() {
    let kept = |i: u32| i.is_multiple_of(7) || i > 10;
    let open = cutflow::mesh::doctor::keep_polygons(&sphere(), |i| i > 10);
    let some = turn(&open, |i| !kept(i));
    let (result, turned) = repair(&some, Repair::Orient);
    assert_eq!((result, turned), (open, 9));
}

#[test]
fn a_moebius_strip_is_told_apart_and_opened_to_a_disk() {
    let examination = examine(&moebius(40));
    assert_eq!(shape(&examination), [200, 320, 1, 1, 0]);
    assert!(!examination.is_orientable && examination.genus.is_none());
    assert_eq!(count(&examination, FindingKind::NotOrientable), 1);
    assert_eq!(count(&examination, FindingKind::Orientation), 0);
    let after = examine(&cured(&moebius(40)));
    assert_eq!(shape(&after)[1..], [320, 1, 1, 1]);
}

#[test]
fn loose_triangles_are_welded_with_the_tolerance_that_they_need() {
    let whole = sphere();
    for (jitter, id) in [(0.0, "weld:0e0"), (4e-7, "weld:1e-6")] {
        let loose = exploded(&whole, jitter);
        let examination = examine(&loose);
        let finding = examination.find(FindingKind::CoincidentVertices).unwrap();
        assert_eq!(finding.closable, Some(loose.corners.len()));
        assert_eq!(finding.count, loose.positions.len() - whole.positions.len());
        assert!(finding.recommended);
        assert_eq!(finding.repairs[0].id(), id);
        let after = examine(&cured(&loose));
        assert_eq!(shape(&after), shape(&examine(&whole)));
    }
    // Twice the tolerance away is not near.
    assert_eq!(weld(&exploded(&whole, 1e-4), 1e-6).1, 0);
}

#[test]
fn what_only_touches_is_not_welded() {
    let cross = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [-1.0, -1.0, 0.0],
    ];
    let soup = Soup::from_triangles(cross, &[[0, 1, 2], [3, 4, 5]]);
    assert_eq!(weld(&soup, 1e-3), (soup.clone(), 0));
    assert_eq!(count(&examine(&soup), FindingKind::CoincidentVertices), 0);
}

#[test]
fn holes_are_filled_and_the_rim_of_a_sheet_is_not() {
    // Without the pole and a belt square.
    let holes = cutflow::mesh::doctor::keep_polygons(&sphere(), |i| {
        let t = sphere().polygon(i as usize).to_vec();
        !t.contains(&0) && i != 44
    });
    let examination = examine(&holes);
    let edges = Vec::from_iter(examination.boundary_loops.iter().map(|l| l.edges));
    assert_eq!(edges, [12, 3]);
    let (some, filled) = fill_holes(&holes, Some(4));
    assert_eq!((filled, examine(&some).boundary_loops.len()), (1, 1));
    let (all, filled) = fill_holes(&holes, None);
    let after = examine(&all);
    assert_eq!((filled, after.euler, after.boundary_loops.len()), (2, 2, 0));
    assert!(after.is_solvable && after.components[0].volume.unwrap() > 0.0);

    let sheet = polygons(sphere().positions[2..6].to_vec(), &[&[0, 1, 2], &[0, 2, 3]]);
    assert_eq!(fill_holes(&sheet, None).1, 0);
    assert_eq!(fill_holes(&polygons(sheet.positions, &[&[0, 1, 2, 3]]), None).1, 0);
}

#[test]
fn components_are_numbered_measured_and_kept() {
    let (mut positions, mut all) = ball(12);
    let n = positions.len() as u32;
    let (second, more) = ball(8);
    positions.extend(second.iter().map(|p| p.map(|x| 5.0 + 0.05 * x)));
    all.splice(0..0, more.iter().map(|t| t.map(|v| v + n)));
    let soup = Soup::from_triangles(positions, &all);
    let examination = examine(&soup);
    let [small, large] = &examination.components[..] else { panic!() };
    assert_eq!((small.first_face, large.first_face as usize), (0, more.len()));
    assert!(small.area_share < 0.01 && (small.area_share + large.area_share - 1.0).abs() < 1e-12);
    for keeps in
        [Repair::KeepLargest, Repair::KeepComponent { component: 1 }, Repair::DropSmallComponents]
    {
        let (kept, dropped) = repair(&soup, keeps);
        assert_eq!((dropped, kept.polygon_count()), (1, sphere().polygon_count()), "{keeps}");
        assert_eq!(kept.positions.len(), soup.positions.len());
    }
    assert_eq!(repair(&soup, Repair::KeepComponent { component: 2 }), (soup.clone(), 0));
}

#[test]
fn polygons_with_the_same_diagonal_are_split_so_that_all_edges_differ() {
    // Two kites that share two sides, over the same short diagonal.
    let points = vec![
        [0.0, -1.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-2.0, 0.0, 0.0],
        [-2.0, 0.0, 1.0],
    ];
    let soup = polygons(points, &[&[0, 1, 2, 3], &[2, 1, 0, 4]]);
    let examination = examine(&soup);
    assert!(!is_mesh(&soup) && !examination.is_solvable);
    assert_eq!(examination.find(FindingKind::FoldedPolygons).unwrap().faces, [1]);
    let result = cured(&soup);
    assert_eq!(
        (result.positions.len(), result.polygon_count()),
        (5, 3),
        "the other diagonal is free"
    );

    // A diagonal that is also an edge, in a quadrilateral that has no other: a dart.
    let points = vec![[0.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.5, 0.0, 0.0], [2.0, 1.0, 0.0]];
    let soup = polygons(points, &[&[0, 1, 2, 3], &[2, 1, 0]]);
    assert_eq!(examine(&soup).find(FindingKind::FoldedPolygons).unwrap().faces, [0]);
    let result = cured(&soup);
    assert_eq!((result.positions.len(), result.polygon_count()), (5, 5));
    assert_eq!(result.positions[4], [0.25, 0.0, 0.0]);
}

#[test]
fn scale_and_place_change_nothing() {
    for (scale, shift) in [(1e-60, 0.0), (1e30, 0.0), (1.0, 1e9)] {
        let mut soup = cubes();
        for x in soup.positions.iter_mut().flatten() {
            *x = *x * scale + shift;
        }
        let examination = examine(&soup);
        assert_eq!(
            examination.findings.iter().filter(|f| f.severity == Severity::Blocks).count(),
            1
        );
        assert_eq!(count(&examination, FindingKind::FarFromOrigin), usize::from(shift > 0.0));
        assert_eq!(shape(&examine(&cured(&soup))), [16, 12, 2, 0, 4]);
    }
}

#[test]
fn slivers_and_far_vertices_are_told_with_the_worst_value() {
    let soup = Soup::from_triangles(
        vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1e-3, 0.0], [9e9, 9e9, 9e9]],
        &[[0, 1, 2]],
    );
    let examination = examine(&soup);
    let finding = examination.find(FindingKind::Slivers).unwrap();
    // The angle at the base is atan(2e-3).
    assert!((finding.worst.unwrap() - 2e-3_f64.atan()).abs() < 1e-12);
    assert_eq!(examination.find(FindingKind::Isolated).unwrap().vertices, [3]);
    assert_eq!(count(&examination, FindingKind::FarFromOrigin), 0);
}

/// A soup of random polygons on few vertices, many at the same places or on lines, with tagged attributes.
fn random_soup(random: &mut Random) -> Soup {
    let vertices = 4 + random.below(16);
    let places = 1 + random.below(4);
    let mut soup = Soup { starts: vec![0], ..Soup::default() };
    for _ in 0..vertices {
        let mut x = || random.below(places + 1) as f64;
        soup.positions.push([x(), x(), x()]);
    }
    let largest = [3, 4, 6, 9][random.below(4)];
    for i in 0..1 + random.below(40) {
        for _ in 0..3 + random.below(largest - 2) {
            let v = random.below(vertices) as u32;
            soup.corners.push(v);
            soup.texture_corners.push(soup.texture_coordinates.len() as u32);
            soup.texture_coordinates.push([f64::from(v), i as f64]);
        }
        soup.starts.push(soup.corners.len() as u32);
        soup.groups.push(format!("{i}"));
        soup.polygon_groups.push(i as u32);
        soup.lines.push(i as u32 + 1);
    }
    soup
}

#[test]
fn random_soups_become_surfaces_with_their_attributes() {
    let mut random = Random(1);
    for _ in 0..3000 {
        let soup = random_soup(&mut random);
        let examination = examine(&soup);
        if examination.is_solvable {
            assert!(is_mesh(&soup));
        }
        let result = cured(&soup);
        for i in 0..result.polygon_count() {
            let group = result.polygon_groups[i];
            assert_eq!(result.lines[i], group + 1);
            for corner in result.starts[i]..result.starts[i + 1] {
                let texture = result.texture_corners[corner as usize] as usize;
                let [v, polygon] = result.texture_coordinates[texture];
                assert_eq!(polygon, f64::from(group));
                // Given corners are still where they were.
                if texture < soup.texture_coordinates.len() {
                    let vertex = result.corners[corner as usize] as usize;
                    let [p, q] = [result.positions[vertex], soup.positions[v as usize]];
                    assert_eq!(p, q);
                }
            }
        }
    }
}

#[test]
fn every_repair_leaves_no_finding_of_its_kind_and_does_nothing_twice() {
    let mut random = Random(2);
    for _ in 0..1000 {
        let (soup, _) = repair(&random_soup(&mut random), Repair::DropRepeated);
        let (soup, _) = repair(&soup, Repair::DropDuplicates);
        let (flat_free, _) = repair(&soup, Repair::DropDegenerate);
        let (flat_free, _) = repair(&flat_free, Repair::DropDuplicates);
        let (edges_split, _) = repair(&flat_free, Repair::SplitEdges);
        for (kind, one) in [
            (FindingKind::RepeatedVertices, Repair::DropRepeated),
            (FindingKind::DuplicateFaces, Repair::DropDuplicates),
            (FindingKind::DegenerateFaces, Repair::DropDegenerate),
            (FindingKind::NonManifoldEdges, Repair::SplitEdges),
            (FindingKind::NonManifoldVertices, Repair::SplitVertices),
            (FindingKind::NotOrientable, Repair::OpenOneSided),
            (FindingKind::Orientation, Repair::Orient),
            (FindingKind::FoldedPolygons, Repair::SplitPolygons),
            (FindingKind::Isolated, Repair::DropIsolated),
        ] {
            // What the examination leaves out does not take part in the topology either.
            let before = match kind {
                FindingKind::NonManifoldEdges | FindingKind::NonManifoldVertices => &flat_free,
                FindingKind::NotOrientable
                | FindingKind::Orientation
                | FindingKind::FoldedPolygons => &edges_split,
                _ => &soup,
            };
            let (result, _) = repair(before, one);
            assert_eq!(count(&examine(&result), kind), 0, "{one}");
            assert_eq!(repair(&result, one), (result.clone(), 0), "{one}");
        }
    }
}

/// Torn, flipped, doubled and bent: a torus with random damage.
#[test]
fn damaged_surfaces_become_surfaces() {
    let mut random = Random(5);
    for _ in 0..300 {
        let (mut positions, mut all) = ball(10);
        for _ in 0..random.below(12) {
            let (i, j) = (random.below(all.len()), random.below(positions.len()) as u32);
            match random.below(7) {
                0 => all[i].swap(0, 1),
                1 => drop(all.swap_remove(i)),
                2 => all.push(all[i]),
                3 => all[i][random.below(3)] = j,
                4 => positions[all[i][0] as usize] = positions[all[i][1] as usize],
                5 => {
                    let [a, b] = [0, 1].map(|k| positions[all[i][k] as usize]);
                    let middle = [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0);
                    positions[all[i][2] as usize] = middle;
                }
                _ => all.push([all[i][0], all[i][1], j]),
            }
        }
        cured(&Soup::from_triangles(positions, &all));
    }
}

fn collection() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: ../shared/meshes is not there");
    None
}

#[test]
fn the_collection_is_diagnosed_and_cured_as_its_readme_says() {
    use FindingKind as K;
    let Some(folder) = collection() else { return };
    // Blocking or telling findings with their counts; then vertices, polygons, components, loops, Euler when cured.
    type Row = (&'static [(FindingKind, usize)], [i64; 5]);
    let rows: BTreeMap<&str, Row> = BTreeMap::from([
        ("all-collinear.obj", (&[(K::DegenerateFaces, 98)][..], [0, 0, 0, 0, 0])),
        ("all-same-point.obj", (&[(K::NoExtent, 1)], [0, 0, 0, 0, 0])),
        ("anisotropic.obj", (&[(K::Slivers, 320), (K::HugeRatio, 1)], [162, 320, 1, 0, 2])),
        ("bowtie-vertex.obj", (&[(K::NonManifoldVertices, 1)], [6, 2, 2, 2, 2])),
        ("components.obj", (&[(K::Components, 6), (K::BoundaryLoops, 2)], [548, 1053, 6, 2, 8])),
        ("degenerate-faces.obj", (&[(K::DegenerateFaces, 4)], [42, 80, 1, 0, 2])),
        ("duplicate-faces.obj", (&[(K::DuplicateFaces, 40)], [162, 320, 1, 0, 2])),
        ("fin-on-sphere.obj", (&[(K::NonManifoldEdges, 1)], [45, 81, 2, 1, 3])),
        ("flipped-faces.obj", (&[(K::Orientation, 218)], [162, 320, 1, 0, 2])),
        ("huge-offset.obj", (&[(K::FarFromOrigin, 1)], [162, 320, 1, 0, 2])),
        ("inside-out.obj", (&[(K::InsideOut, 1)], [162, 320, 1, 0, 2])),
        ("isolated-vertices.obj", (&[(K::Isolated, 35)], [42, 80, 1, 0, 2])),
        ("klein-bottle.obj", (&[(K::NotOrientable, 1)], [544, 1024, 1, 2, 0])),
        ("moebius.obj", (&[(K::NotOrientable, 1)], [205, 320, 1, 1, 1])),
        ("nonmanifold-edge.obj", (&[(K::NonManifoldEdges, 1)], [9, 3, 3, 3, 3])),
        ("polygon-200.obj", (&[], [400, 202, 1, 0, 2])),
        ("single-triangle.obj", (&[(K::BoundaryLoops, 1)], [3, 1, 1, 1, 1])),
        ("tiny-scale.obj", (&[], [162, 320, 1, 0, 2])),
        ("touching-holes.obj", (&[(K::NonManifoldVertices, 1)], [82, 124, 1, 2, 0])),
        ("triangle-dust.obj", (&[(K::Components, 400)], [1200, 400, 400, 400, 400])),
        ("two-spheres-crossing.obj", (&[(K::Components, 2)], [324, 640, 2, 0, 4])),
        ("two-tetra-one-vertex.obj", (&[(K::NonManifoldVertices, 1)], [8, 8, 2, 0, 4])),
    ]);
    for (name, (findings, expected)) in rows {
        let bytes = std::fs::read(folder.join("bad").join(name)).unwrap();
        let soup = obj::read(&bytes).unwrap().soup;
        let examination = examine(&soup);
        for &(kind, expected) in findings {
            assert_eq!(count(&examination, kind), expected, "{name}: {kind:?}");
        }
        let blocks = examination.findings.iter().filter(|f| f.severity == Severity::Blocks);
        let allowed = |kind| findings.iter().any(|f| f.0 == kind) || kind == K::RepeatedVertices;
        assert!(blocks.map(|f| f.kind).all(allowed), "{name}: {:?}", examination.findings);
        assert_eq!(shape(&examine(&cured(&soup))), expected, "{name}");
    }
}

#[test]
fn every_sound_mesh_of_the_collection_is_left_as_it_is() {
    let Some(folder) = collection() else { return };
    let mut names = Vec::from_iter(std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()));
    names.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    names.sort();
    for path in names {
        let soup = obj::read(&std::fs::read(&path).unwrap()).unwrap().soup;
        assert!(examine(&soup).is_solvable, "{}", path.display());
        assert_eq!(repair_all(&soup), (soup, vec![]), "{}", path.display());
    }
}
