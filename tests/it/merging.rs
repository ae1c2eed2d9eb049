//! Merging into quasi-developable patches: valid at any moment, within the limits, as the user wishes, the same every time.

use std::collections::BTreeSet;
use std::sync::Arc;

use cutflow::flatten::merging::{
    AreaMeasure, MergeFlow, MergeParams, MergePhase, MergeState, MergeStrategy, MergeWishes,
    ParamsChange, maps_triangles,
};
use cutflow::flatten::{measure, validate};
use cutflow::geometry::{Geometry, centre_lines};
use cutflow::mesh::{EdgeId, Mesh, VertexId};
use cutflow::methods::cutflow::{Initial, initial_labels};
use cutflow::methods::flow::{Flow, SolveError, Status};

use nalgebra::Point3;

use crate::surfaces::Surface;

/// Clusters of normals: charts to begin with.
fn labels(surface: &Surface, regions: u32) -> Vec<u32> {
    let initial = Initial::NormalClusters { angle: 0.6, regions };
    let found = initial_labels(&surface.mesh, &surface.geometry, &initial).unwrap().labels;
    // Of vertices: a face takes that of its first corner.
    surface.mesh.triangles().iter().map(|t| found[t[0].index()]).collect()
}

fn begin(surface: &Surface, labels: &[u32], params: MergeParams, wishes: MergeWishes) -> MergeFlow {
    let (mesh, geometry) = (Arc::new(surface.mesh.clone()), Arc::new(surface.geometry.clone()));
    MergeFlow::new(mesh, geometry, labels, params, wishes).unwrap()
}

fn run(flow: &mut MergeFlow) {
    let mut steps = 0;
    while flow.status() == Status::Running {
        flow.step().unwrap();
        steps += 1;
        assert!(steps < 100_000, "it goes on for ever");
    }
}

/// The segmentation is one: patches are connected along uncut edges, and cut edges are all that parts them.
fn assert_valid(flow: &MergeFlow) {
    let (mesh, state) = (flow.mesh(), flow.state());
    let mut is_cut = vec![false; mesh.edge_count()];
    state.cut_edges.iter().for_each(|e| is_cut[e.index()] = true);
    for e in mesh.edges() {
        let [f, g] = [e.halfedge(), e.halfedge().twin()].map(|h| mesh.face(h));
        if let (Some(f), Some(g)) = (f, g)
            && state.face_patches[f.index()] != state.face_patches[g.index()]
        {
            assert!(is_cut[e.index()], "patches meet across edge {}", e.0);
        }
    }
    let limits = flow.params();
    for patch in &state.patches {
        let area = match limits.measure {
            AreaMeasure::Total => patch.area_total,
            AreaMeasure::Absolute => patch.area_absolute,
        };
        assert!(patch.is_flat && (area <= limits.area_limit || patch.is_forced), "{patch:?}");
        assert!(patch.l2_stretch <= limits.l2_limit && patch.closure_error < 1e-9, "{patch:?}");
    }
    let faces: usize = state.patches.iter().map(|p| p.faces).sum();
    assert_eq!(faces, mesh.face_count());
}

/// The maps are what was promised, by code that knows nothing of merging.
fn assert_flat(flow: &MergeFlow) {
    let (opened, geometry, charts) = flow.flattening().unwrap();
    assert_eq!(opened.patch_count, flow.state().patches.len());
    assert_eq!(opened.face_patches, flow.state().face_patches);
    assert!(charts.charts.iter().all(Result::is_ok), "every patch is a disk");
    let validity = validate(&opened, &charts, None);
    assert!(validity.is_valid(), "{:?}", validity.totals);
    let measures = measure(&opened, &geometry, &charts);
    for (chart, patch) in measures.charts.iter().zip(&flow.state().patches) {
        let chart = chart.as_ref().unwrap();
        // Rounding of sums over some hundred faces, and of lengths taken from positions.
        assert!((chart.area_change_abs - patch.area_absolute).abs() < 1e-9, "{chart:?}, {patch:?}");
        assert!((chart.l2_stretch - patch.l2_stretch).abs() < 1e-9, "{chart:?}, {patch:?}");
        assert_eq!(chart.faces, patch.faces);
    }
}

fn small_surface() -> (Surface, Vec<u32>) {
    let surface = Surface::sphere(9);
    let labels = labels(&surface, 24);
    (surface, labels)
}

#[test]
fn a_flow_of_merges_keeps_the_contract() {
    let (surface, labels) = small_surface();
    for (measure, strategy) in [
        (AreaMeasure::Absolute, MergeStrategy::BestFirst),
        (AreaMeasure::Total, MergeStrategy::BestFirst),
        (AreaMeasure::Absolute, MergeStrategy::Paper),
    ] {
        let params = MergeParams { measure, strategy, ..MergeParams::default() };
        let mut flow = begin(&surface, &labels, params, MergeWishes::default());
        let mut twin = begin(&surface, &labels, params, MergeWishes::default());
        let mut patches = flow.state().patches.len();
        let before = patches;
        let mut steps = 0;
        while flow.status() == Status::Running {
            let report = flow.step().unwrap();
            assert_eq!(report, twin.step().unwrap());
            assert_eq!(flow.state(), twin.state(), "the same every time");
            assert!(flow.state().patches.len() <= patches, "patches never become more");
            patches = flow.state().patches.len();
            steps += 1;
            if steps % 10 == 0 {
                assert_valid(&flow);
            }
        }
        assert_eq!((flow.status(), flow.state().phase), (Status::Converged, MergePhase::Done));
        assert!(patches < before, "{before} to {patches}");
        let end: MergeState = flow.state().clone();
        flow.step().unwrap();
        assert_eq!(flow.state(), &end, "quiet at its end");
        assert_valid(&flow);
        assert_flat(&flow);
    }
}

#[test]
fn parts_of_a_cylinder_become_one_patch_again() {
    let surface = Surface::from_soup("cylinder", &crate::surfaces::cylinder(24, 9));
    // Eight strips along it.
    let at = |f: usize| {
        let [a, b, c] = surface.mesh.triangles()[f].map(|v| surface.geometry.positions[v.index()]);
        let centre = (a.coords + b.coords + c.coords) / 3.0;
        let turn = centre.y.atan2(centre.x) / std::f64::consts::TAU + 0.5;
        ((turn * 8.0) as u32).min(7)
    };
    let labels: Vec<u32> = (0..surface.mesh.face_count()).map(at).collect();
    let mut flow = begin(&surface, &labels, MergeParams::default(), MergeWishes::default());
    run(&mut flow);
    let state = flow.state();
    assert_eq!(state.patches.len(), 1);
    // One cut from rim to rim is left, and the rest is isometric.
    assert!(state.patches[0].area_absolute < 1e-9 && state.dart_length > 0.0, "{state:?}");
    assert_flat(&flow);
}

#[test]
fn wishes_are_kept() {
    let (surface, labels) = small_surface();
    let free = {
        let mut flow = begin(&surface, &labels, MergeParams::default(), MergeWishes::default());
        run(&mut flow);
        flow.state().clone()
    };
    let of_label = |label: u32| labels.iter().position(|&l| l == label).unwrap();
    // Two labels that one patch has: apart from now on.
    let mut pair = None;
    for f in 0..labels.len() {
        for g in 0..labels.len() {
            if labels[f] != labels[g] && free.face_patches[f] == free.face_patches[g] {
                pair = pair.or(Some([labels[f], labels[g]]));
            }
        }
    }
    let [a, b] = pair.expect("something was merged");
    let kept = free.cut_edges[0];
    let wishes = MergeWishes { apart: vec![[a, b]], kept_edges: vec![kept], ..Default::default() };
    let mut flow = begin(&surface, &labels, MergeParams::default(), wishes);
    run(&mut flow);
    let patches = &flow.state().face_patches;
    for (f, &p) in patches.iter().enumerate().filter(|(f, _)| labels[*f] == a) {
        let other = (0..labels.len()).any(|g| labels[g] == b && patches[g] == p);
        assert!(!other, "face {f} shares a patch with label {b}");
    }
    assert!(flow.state().cut_edges.contains(&kept));
    assert_valid(&flow);

    // Two that it does not have, together.
    let (f, g) = (0..labels.len())
        .find_map(|f| {
            let neighbours = surface.mesh.face_halfedges(cutflow::mesh::FaceId::from(f));
            neighbours.into_iter().find_map(|h| {
                let g = surface.mesh.face(h.twin())?.index();
                (free.face_patches[f] != free.face_patches[g]).then_some((f, g))
            })
        })
        .unwrap();
    let together = vec![[labels[f], labels[g]]];
    let wishes = MergeWishes { together, ..Default::default() };
    let mut flow = begin(&surface, &labels, MergeParams::default(), wishes);
    run(&mut flow);
    let patches = &flow.state().face_patches;
    let one = patches[of_label(labels[f])] == patches[of_label(labels[g])];
    assert!(one || !flow.state().refused.is_empty());
    assert_valid(&flow);
    assert_flat(&flow);
}

#[test]
fn a_line_that_is_drawn_parts_patches_and_may_end_anywhere() {
    let (surface, labels) = small_surface();
    let height = |v: VertexId| surface.geometry.positions[v.index()].z;
    let drawn = |is_in: &dyn Fn(VertexId) -> bool| {
        let painted: Vec<bool> = surface.mesh.vertices().map(is_in).collect();
        centre_lines(&surface.mesh, &surface.geometry, &painted, |_| false, 0.0)
    };
    let radius = surface.geometry.positions[0].coords.norm();
    let ring = drawn(&|v| height(v).abs() < 0.2 * radius);
    // As long as the equator, and a half more along zigzags.
    let length: f64 = ring.iter().map(|&e| surface.geometry.edge_length(e)).sum();
    assert!((1.0..1.5).contains(&(length / (std::f64::consts::TAU * radius))), "{length}");
    let wishes = MergeWishes { kept_edges: ring.clone(), ..Default::default() };
    let mut flow = begin(&surface, &labels, MergeParams::default(), wishes);
    run(&mut flow);
    assert!(ring.iter().all(|e| flow.state().cut_edges.contains(e)));
    let mut sides = vec![[false; 2]; flow.state().patches.len()];
    for (triangle, &patch) in surface.mesh.triangles().iter().zip(&flow.state().face_patches) {
        let mean = triangle.iter().map(|&v| height(v)).sum::<f64>() / 3.0;
        sides[patch as usize][0] |= mean > 0.25 * radius;
        sides[patch as usize][1] |= mean < -0.25 * radius;
    }
    assert!(sides.iter().all(|side| *side != [true; 2]), "no patch reaches across");
    assert_eq!(flow.state().released, 0);
    assert_valid(&flow);
    assert_flat(&flow);

    // A stroke that begins and ends wherever it does.
    let stroke = drawn(&|v| {
        let p = surface.geometry.positions[v.index()];
        p.z > 0.0 && p.y.abs() < 0.15 * radius && p.x.abs() < 0.8 * radius
    });
    assert!(stroke.len() > 5);
    let wishes = MergeWishes { kept_edges: stroke.clone(), ..Default::default() };
    let mut flow = begin(&surface, &labels, MergeParams::default(), wishes);
    run(&mut flow);
    let kept = stroke.iter().filter(|e| flow.state().cut_edges.contains(e)).count();
    assert!(kept + flow.state().released >= stroke.len() && kept > 0, "{kept} kept");
    assert_valid(&flow);
    assert_flat(&flow);
}

#[test]
fn cuts_keep_a_mirror_plane_edge_by_edge() {
    let (surface, labels) = small_surface();
    keeps_a_mirror_plane(&surface, &labels);
    // Quadrilaterals on one side divided along their other diagonals: their halves stay together.
    let (flipped, count) = with_flipped_edges(&surface);
    assert!(count > 5, "{count}");
    keeps_a_mirror_plane(&flipped, &labels);
}

/// The same surface with a few edges flipped where x > 0, no two in one face. Faces keep their numbers.
fn with_flipped_edges(surface: &Surface) -> (Surface, usize) {
    let mesh = &surface.mesh;
    let mut triangles: Vec<[u32; 3]> = mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect();
    let mut is_free = vec![true; mesh.face_count()];
    let mut count = 0;
    for e in mesh.edges().step_by(37) {
        let h = e.halfedge();
        let (Some(f), Some(g)) = (mesh.face(h), mesh.face(h.twin())) else { continue };
        let [a, b] = [mesh.tail(h), mesh.tip(h)];
        let [c, d] = [h, h.twin()].map(|h| mesh.tip(mesh.next(h)));
        let is_right = [a, b, c, d].iter().all(|v| surface.geometry.positions[v.index()].x > 0.01);
        if is_right && is_free[f.index()] && is_free[g.index()] {
            triangles[f.index()] = [c.0, d.0, b.0];
            triangles[g.index()] = [d.0, c.0, a.0];
            [f, g].iter().for_each(|f| is_free[f.index()] = false);
            count += 1;
        }
    }
    let flipped = Mesh::new(mesh.vertex_count(), &triangles).unwrap();
    let places: Vec<[f64; 3]> =
        surface.geometry.positions.iter().map(|p| p.coords.into()).collect();
    let (geometry, _) = Geometry::unit_area(&flipped, &places).unwrap();
    (Surface { name: "flipped".into(), mesh: flipped, geometry }, count)
}

fn keeps_a_mirror_plane(surface: &Surface, labels: &[u32]) {
    let mesh = &surface.mesh;
    let places = &surface.geometry.positions;
    let image = |v: VertexId| {
        let p = places[v.index()];
        let far = |w: &VertexId| (places[w.index()] - Point3::new(-p.x, p.y, p.z)).norm();
        mesh.vertices().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap()
    };
    let vertices: Vec<VertexId> = mesh.vertices().map(image).collect();
    assert!(maps_triangles(mesh, &vertices));
    let unmatched = |flow: &MergeFlow| {
        let ends = |&e: &EdgeId| mesh.edge_vertices(e);
        let cut: BTreeSet<[VertexId; 2]> = flow.state().cut_edges.iter().map(ends).collect();
        let is_cut = |[a, b]: [VertexId; 2]| cut.contains(&[a, b]) || cut.contains(&[b, a]);
        cut.iter().filter(|pair| !is_cut(pair.map(|v| vertices[v.index()]))).count()
    };
    for strategy in [MergeStrategy::BestFirst, MergeStrategy::Paper] {
        let params = MergeParams { strategy, ..MergeParams::default() };
        let mut free = begin(surface, labels, params, MergeWishes::default());
        run(&mut free);
        assert!(unmatched(&free) > 0, "nothing to see");
        let symmetry = Some(vertices.clone());
        let wishes = MergeWishes { symmetry, ..MergeWishes::default() };
        let mut flow = begin(surface, labels, params, wishes);
        let first = flow.state().patches.len();
        while flow.status() == Status::Running {
            flow.step().unwrap();
            assert_eq!(unmatched(&flow), 0);
        }
        assert!(flow.state().patches.len() < first, "{first} and nothing merged");
        assert_valid(&flow);
        assert_flat(&flow);
        // Two labels that are joined by hand, and their images, or none.
        let apart = mesh.edges().find_map(|e| {
            let sides = [e.halfedge(), e.halfedge().twin()].map(|h| mesh.face(h));
            let [f, g] = [sides[0]?.index(), sides[1]?.index()];
            let patches = &flow.state().face_patches;
            (labels[f] != labels[g] && patches[f] != patches[g]).then(|| [labels[f], labels[g]])
        });
        let together = vec![apart.unwrap()];
        let wishes =
            MergeWishes { together, symmetry: Some(vertices.clone()), ..MergeWishes::default() };
        let mut flow = begin(surface, labels, params, wishes);
        run(&mut flow);
        assert_eq!(unmatched(&flow), 0);
        assert_valid(&flow);
        assert_flat(&flow);
    }
    // Another order of the vertices is no symmetry.
    let mut wrong = vertices.clone();
    wrong.rotate_left(1);
    assert!(!maps_triangles(mesh, &wrong));
}

#[test]
fn limits_can_be_changed_while_it_runs() {
    let (surface, labels) = small_surface();
    let tight = MergeParams { area_limit: 0.03, ..MergeParams::default() };
    let mut flow = begin(&surface, &labels, tight, MergeWishes::default());
    run(&mut flow);
    let many = flow.state().patches.len();
    let loose = MergeParams { area_limit: 0.12, ..tight };
    assert_eq!(flow.set_params(loose), Ok(ParamsChange::Continued));
    assert_eq!(flow.state().patches.len(), many, "what there is stays");
    run(&mut flow);
    let few = flow.state().patches.len();
    assert!(few < many, "{many} to {few}");
    assert_valid(&flow);
    assert_eq!(flow.set_params(loose), Ok(ParamsChange::Nothing));
    assert_eq!(flow.set_params(tight), Ok(ParamsChange::Restarted));
    run(&mut flow);
    assert_eq!(flow.state().patches.len(), many, "from the charts it goes the same way again");
    let wrong = MergeParams { area_limit: f64::NAN, ..tight };
    assert!(matches!(flow.set_params(wrong), Err(SolveError::Parameter { .. })));
    // No patch may be more than an eighth of the surface.
    let small = MergeParams { max_patch_area: 0.125, ..loose };
    assert_eq!(flow.set_params(small), Ok(ParamsChange::Restarted));
    run(&mut flow);
    assert!(flow.state().patches.iter().all(|p| p.area <= 0.125 + 1e-9));
    assert_valid(&flow);
}

#[test]
fn charts_that_fail_are_split_first() {
    // All of a sphere is one chart, which nothing flattens.
    let surface = Surface::sphere(6);
    let labels = vec![7; surface.mesh.face_count()];
    let mut flow = begin(&surface, &labels, MergeParams::default(), MergeWishes::default());
    assert!(flow.state().splits > 4);
    assert_valid(&flow);
    run(&mut flow);
    assert_valid(&flow);
    assert_flat(&flow);
}
