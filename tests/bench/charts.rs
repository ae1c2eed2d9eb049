//! Figures of flattening: boundary first, conformal equivalence, the proof that nothing overlaps.

use cutflow::flatten::conformal::{ConformalFlow, ConformalParams, RimCondition};
use cutflow::flatten::{bff, validate};
use cutflow::geometry::Geometry;
use cutflow::mesh::{CutMesh, OpenedMesh};
use cutflow::methods::cones::{ConeFields, ConeFlow, ConeParams, RoundParams, round_clusters};
use cutflow::methods::cutflow::{Initial, initial_labels, labelled_cut};
use cutflow::methods::cutgraph::{cut_through, cut_to_disks};
use cutflow::methods::flow::{Flow, Status};
use cutflow::session::Document;
use nalgebra::Point3;

use crate::{Row, Unit, factorisation, sphere, time_of};

/// A sphere cut into normal clusters, opened and measured.
fn cut_sphere(frequency: u32) -> (OpenedMesh, Geometry) {
    let (mesh, geometry) = sphere(frequency);
    let initial = Initial::NormalClusters { angle: 0.9, regions: 10 };
    let labels = initial_labels(&mesh, &geometry, &initial).expect("a sphere has clusters").labels;
    let mut cut: CutMesh = labelled_cut(&mesh, &geometry, &labels, |_| None);
    let points: Vec<Point3<f64>> = cut.points.iter().map(|&p| geometry.locate(&mesh, p)).collect();
    let disks = cut_to_disks(&mut cut, &points).expect("the cut can be opened");
    let places = disks.opened.vertex_points.iter().map(|&p| points[p as usize]).collect();
    let measured = Geometry::measure(&disks.opened.mesh, places);
    (disks.opened, measured)
}

/// All of them.
pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let (opened, geometry) = cut_sphere(32);
    let unit = factorisation(&opened.mesh, &geometry, 10);
    let solve = crate::solve(&opened.mesh, &geometry);
    let time = time_of(5, || {
        bff(&opened, &geometry).expect("memory suffices");
    });
    rows.push(Row {
        name: format!(
            "BFF of {} vertices, over 2 factorisations + 8 solves",
            opened.mesh.vertex_count()
        ),
        value: time / (2.0 * unit + 8.0 * solve),
        unit: "",
        limit: Some(1.0),
    });

    let (opened, geometry) = cut_sphere(71);
    let flattening = bff(&opened, &geometry).expect("memory suffices");
    let mut is_valid = true;
    let time = time_of(3, || is_valid &= validate(&opened, &flattening, None).is_valid());
    assert!(is_valid, "charts of a sphere's clusters are valid");
    rows.push(Row {
        name: format!("exact overlap test of {} triangles", opened.mesh.face_count()),
        value: time,
        unit: "s",
        limit: Some(0.3),
    });
    rows.extend(conformal());
    rows
}

/// Conformal equivalence with optimal cones on a generated animal.
fn conformal() -> Vec<Row> {
    let document = Document::from_sample("plush_bear").expect("it is a sample");
    let surface = document.surface().expect("it can be cut");
    let (mesh, geometry) = (&surface.mesh, &surface.geometry);
    let params = ConeParams { lambda: 0.002, ..ConeParams::default() };
    let mut flow =
        ConeFlow::new(mesh, geometry, &params, &ConeFields::default()).expect("the bear has cones");
    while flow.step().expect("it converges").status == Status::Running {}
    let cones = round_clusters(mesh, geometry, &flow.state().cones, &RoundParams::default()).cones;
    let vertices: Vec<_> = cones.iter().map(|c| c.vertex).collect();
    let seams = cut_through(mesh, geometry, &vertices, &[]).expect("seams join them");
    let points: Vec<_> = seams.cut.points.iter().map(|&p| geometry.locate(mesh, p)).collect();
    let mut unit = Unit::new(mesh, geometry);
    let (rim, params) = (RimCondition::Isometric, ConformalParams::default());
    let begin = || {
        ConformalFlow::on_surface(mesh, &seams.cut, &points, &cones, &rim, &params)
            .expect("the cones are feasible")
    };
    let mut flow = begin();
    while flow.step().expect("it converges").status == Status::Running {}
    let report = flow.result().expect("it ended").report;
    assert_eq!((report.rounds, report.doubled), (0, 0), "steps come first, then one layout");
    let steps = report.newton_steps;
    // Three runs of growing length: the clock is too coarse for a step.
    let before = unit.ratio(20, || drop(begin()));
    let stepped = unit.ratio(20, || {
        let mut flow = begin();
        (0..steps).for_each(|_| drop(flow.step().expect("it converges")));
    });
    let whole = unit.ratio(20, || {
        let mut flow = begin();
        while flow.step().expect("it converges").status == Status::Running {}
    });
    vec![
        Row {
            name: format!("conformal equivalence, {} cones: Newton steps", cones.len()),
            value: steps as f64,
            unit: "",
            limit: Some(8.0),
        },
        Row {
            name: "the same, a step, trials and flips included".into(),
            value: (stepped - before) / steps as f64,
            unit: "factorisations",
            limit: Some(1.5),
        },
        Row {
            name: "the same, once: triangulation and flips before".into(),
            value: before,
            unit: "factorisations",
            limit: None,
        },
        Row {
            name: "the same, once: flips taken back and charts after".into(),
            value: whole - stepped,
            unit: "factorisations",
            limit: None,
        },
    ]
}
