//! Whole surfaces: random soups, a ball with random damage, and the collection beside the checkout. The tests of the
//! collection say so where there is none.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cutflow::geometry::doctor::{examine, repair, repair_all};
use cutflow::mesh::Soup;
use cutflow::mesh::doctor::{FindingKind, Repair, Severity};
use cutflow::mesh::read::obj;

use super::{Random, ball, count, cured, is_mesh, shape};

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

/// Torn, flipped, doubled and bent: a ball with random damage.
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
