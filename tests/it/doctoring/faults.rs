//! Each fault by itself: how it is found, and what its repair leaves.

use cutflow::geometry::doctor::{examine, fill_holes, repair, repair_all, weld};
use cutflow::mesh::Soup;
use cutflow::mesh::doctor::{FindingKind, Repair, Severity, drop_isolated, turn};

use super::{Random, ball, count, cured, exploded, is_mesh, moebius, polygons, shape, sphere};

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
    let finding = examination.find(FindingKind::InsideOut).unwrap();
    assert_eq!(finding.severity, Severity::Note);
    assert_eq!(finding.repairs, [Repair::Orient, Repair::TurnInsideOut]);
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
fn a_tolerance_below_rounding_welds_what_is_equal() {
    // Cells so small have no number. A triangle far away leaves all others in one octant of the box, and so in one cell:
    // 10⁹ pairs would be compared.
    let (mut positions, mut triangles) = ball(300);
    let far = positions.len() as u32;
    positions.extend([[-9.0, -9.0, -9.0], [-9.0, -9.0, -8.0], [-9.0, -8.0, -9.0]]);
    triangles.push([far, far + 1, far + 2]);
    let loose = exploded(&Soup::from_triangles(positions, &triangles), 0.0);
    let (welded, count) = weld(&loose, 1e-300);
    assert_eq!((welded, count), weld(&loose, 0.0));
    assert!(count > 150_000);
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
