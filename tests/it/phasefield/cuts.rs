//! From fields to cuts: partitions of unity, labels, meshes refined along level sets, starts of the cut flow.

use cutflow::mesh::Mesh;
use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial};
use cutflow::methods::flow::SolveError;

use super::*;

#[test]
fn leaves_are_a_partition_of_unity_and_cut_the_surface_into_disks() {
    let surface = Surface::sphere(10);
    for levels in [1, 2, 3] {
        let flow = run(&surface, PhaseFieldParams { levels, starts: 1, ..coarse() });
        let state = flow.state();
        let weights = state.leaf_weights();
        assert_eq!(weights.len(), 1 << levels);
        for v in 0..surface.mesh.vertex_count() {
            let sum: f64 = weights.iter().map(|w| w[v]).sum();
            // Rounding of eight numbers.
            assert!((sum - 1.0).abs() < 1e-14);
        }
        let labels = state.labels();
        for (v, &label) in labels.iter().enumerate() {
            // The path of signs takes the larger half every time: 1/2 to the power of levels at least.
            assert!(weights[label as usize][v] >= 0.5f64.powi(levels as i32) - 1e-12);
        }
        let cut = flow.cut_mesh();
        let opened = cut.open().unwrap();
        assert_eq!(opened.patch_count, 1 << levels);
        assert!(opened.patch_shapes().iter().all(|&shape| shape == (1, 1)));
        // The border of the first split has the length that is measured of its field.
        let length: f64 = cut
            .cut_edges
            .iter()
            .map(|ends| {
                let [a, b] =
                    ends.map(|p| surface.geometry.locate(&surface.mesh, cut.points[p as usize]));
                (a - b).norm()
            })
            .sum();
        let scale = cutflow::methods::phasefield::length_scale(&surface.geometry);
        let splits = state.tree().iter().enumerate().filter(|n| n.1.children.is_some());
        let measured: f64 = splits.map(|(i, _)| flow.measure(i).unwrap().length).sum();
        // Where three leaves meet the cut takes the middle of a triangle: up to an edge at each of a few such points.
        // Crossings keep a millionth of an edge from vertices.
        let slack = if levels == 1 { 1e-5 } else { 0.5 };
        assert!((length * scale - measured).abs() < slack, "{} {measured}", length * scale);
    }
}

#[test]
fn a_cut_flow_starts_from_the_leaves() {
    let surface = Surface::sphere(10);
    for levels in [1, 2] {
        let split = run(&surface, PhaseFieldParams { levels, starts: 1, ..coarse() });
        let initial = split.cut_start();
        let (mesh, geometry) = (surface.mesh.clone(), surface.geometry.clone());
        let params = CutFlowParams { kick: 0.0, ..CutFlowParams::default() };
        let mut flow = CutFlow::new(mesh, geometry, &initial, params).unwrap();
        assert_eq!(flow.state().labels(), split.state().labels());
        let length = |cut: &cutflow::mesh::CutMesh| -> f64 {
            let place = |p: u32| surface.geometry.locate(&surface.mesh, cut.points[p as usize]);
            cut.cut_edges.iter().map(|&[a, b]| (place(a) - place(b)).norm()).sum()
        };
        let (was, is) = (length(&split.cut_mesh()), length(&flow.cut_mesh()));
        // Crossings are kept as distances; at points where three meet these contradict each other a little.
        assert!((was - is).abs() < 0.02 * was, "{was} {is}");
        let first = flow.state().energy().total;
        for _ in 0..3 {
            flow.step().unwrap();
        }
        assert!(flow.state().energy().total <= first);
    }
}

#[test]
fn levels_of_labels_that_do_not_fit_are_refused() {
    let surface = Surface::sphere(2);
    let n = surface.mesh.vertex_count();
    let start = |labels: Vec<u32>, starts: Vec<u32>, entries: Vec<(u32, f64)>| {
        let initial = Initial::LabelLevels { labels, starts, entries };
        cutflow::methods::cutflow::initial_labels(&surface.mesh, &surface.geometry, &initial)
    };
    assert!(start(vec![0; n], vec![0; n + 1], Vec::new()).is_ok());
    assert!(start(vec![0; n - 1], vec![0; n + 1], Vec::new()).is_err());
    assert!(start(vec![0; n], vec![0; n], Vec::new()).is_err());
    let mut starts = vec![1; n + 1];
    starts[0] = 0;
    assert!(start(vec![0; n], starts.clone(), Vec::new()).is_err());
    assert!(start(vec![0; n], starts, vec![(0, f64::NAN)]).is_err());
}

#[test]
fn two_closed_components_in_one_phase_each_are_told_to_be_whole() {
    let one = Surface::sphere(5);
    let n = one.mesh.vertex_count();
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for copy in 0..2u32 {
        positions.extend(one.geometry.positions.iter().map(|p| [p.x + f64::from(copy), p.y, p.z]));
        triangles.extend(one.mesh.triangles().iter().map(|t| t.map(|v| v.0 + copy * n as u32)));
    }
    let mesh = Mesh::new(positions.len(), &triangles).unwrap();
    let (geometry, _) = cutflow::geometry::Geometry::unit_area(&mesh, &positions).unwrap();
    let surface = Surface { name: "two spheres".into(), mesh, geometry };
    for omega in [0.0, 1.0] {
        let start = by(&surface, |p| p[0]);
        let params = PhaseFieldParams { start, starts: 1, omega, max_steps: 5, ..coarse() };
        let flow = run(&surface, PhaseFieldParams { epsilon: 0.45, ..params });
        let measures = flow.measure(0).unwrap();
        assert!(flow.state().tree()[0].objective.is_finite());
        if omega == 0.0 {
            assert_eq!(measures.sharp, [f64::INFINITY; 2]);
            assert_eq!((measures.length, measures.components), (0.0, [1, 1]));
            assert!(flow.cut_mesh().cut_edges.is_empty());
            let result = CutFlow::new(
                surface.mesh.clone(),
                surface.geometry.clone(),
                &flow.cut_start(),
                CutFlowParams::default(),
            );
            assert!(matches!(result.err(), Some(SolveError::EmptyCut { .. })));
        }
    }
}

#[test]
fn a_surface_with_a_boundary_is_split_with_distortion() {
    let surface = Surface::sample("sinusoidal_sheet");
    let floor = cutflow::methods::phasefield::epsilon_floor(&surface.geometry);
    let params = PhaseFieldParams {
        epsilon: floor.max(0.2),
        omega: 0.1,
        starts: 1,
        max_steps: 10,
        ..PhaseFieldParams::default()
    };
    let flow = run(&surface, params);
    let measures = flow.measure(0).unwrap();
    assert!(measures.length > 0.0 && measures.sharp.iter().all(|s| s.is_finite()));
    assert!(flow.cut_mesh().open().unwrap().patch_count >= 2);
}
