//! Figures of length-preserved boundaries and of merging.

use std::f64::consts::PI;
use std::sync::Arc;

use cutflow::flatten::comparison::{Compared, Specimen};
use cutflow::flatten::lpfb::boundary::{BoundaryProblem, BoundarySolver};
use cutflow::flatten::merging::{AreaMeasure, MergeFlow, MergeParams, MergeWishes};
use cutflow::geometry::Geometry;
use cutflow::mesh::{CutMesh, Mesh};
use cutflow::methods::cutflow::{Initial, initial_labels};
use cutflow::methods::flow::{Flow, Status};
use cutflow::session::{Command, Session, Value};
use nalgebra::Point3;

use crate::{Row, seconds, shared_bytes, sphere, time_of};

/// The rim of a crumpled disk.
fn rim(n: usize) -> BoundaryProblem {
    let lengths = (0..n).map(|i| 1.0 + 0.4 * (i as f64 * 1.7).sin()).collect();
    let angles =
        (0..n).map(|i| PI - 2.0 * PI / n as f64 + 0.3 * (i as f64 * 0.9).cos() + 3.0 / n as f64);
    let angles = angles.collect();
    BoundaryProblem { lengths, angles, loops: vec![0; n], loop_count: 1, cuts: vec![] }
}

/// A bowl over an n × n grid.
fn bowl(n: u32) -> Specimen {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let mut triangles = Vec::new();
    let mut points = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(n) - 0.5);
            points.push(Point3::new(x, y, 0.3 * x * x + 0.2 * y * y + 0.01 * (9.0 * x * y).sin()));
            if i < n && j < n {
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    let mesh = Mesh::new(points.len(), &triangles).expect("a grid is a surface");
    let opened = CutMesh::uncut(&mesh).open().expect("there is nothing to cut");
    let geometry = Geometry::measure(&opened.mesh, points);
    Specimen::new(opened, geometry).expect("a grid is a disk")
}

/// All of them.
pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for (n, limit) in [(1500, 1.0), (6000, 4.0)] {
        let prepared = BoundarySolver::new(&rim(n));
        let time = time_of(20, || {
            let outcome = prepared.clone().solve();
            assert_eq!(outcome.status, Status::Converged);
        });
        let name = format!("boundary of {n} sides");
        rows.push(Row { name, value: 1e3 * time, unit: "ms", limit: Some(limit) });
    }
    let bowl = bowl(100);
    let [ours, lscm] = [Compared::Lpfb, Compared::Lscm].map(|method| {
        time_of(5, || {
            method.flatten(&bowl).expect("memory suffices");
        })
    });
    rows.push(Row {
        name: "length-preserved boundary and interior of 10k vertices, over LSCM".to_owned(),
        value: ours / lscm,
        unit: "",
        limit: Some(0.5),
    });
    rows.push(trials(60, 1.0, None));
    // Charts of some 500 faces, and no patch of more than two of them.
    rows.push(trials(40, 0.055, Some(1.0)));
    let files = [("spot.obj", 3.0), ("homer.obj", 3.0), ("nefertiti.ply", 40.0)];
    rows.extend(files.into_iter().filter_map(|(name, limit)| pipeline(name, limit)));
    rows
}

/// Developable patches by A_tot of a mesh of `../shared`, from the first chart to patches with their maps.
fn pipeline(name: &str, limit: f64) -> Option<Row> {
    let bytes = shared_bytes(name)?;
    let mut session = Session::new();
    session.open(name, &bytes);
    session.handle(Command::SetMethod { id: "developable".into() });
    let value = Value::Text("total".into());
    session.handle(Command::SetParameter { id: "merge_measure".into(), value });
    let time = seconds(|| {
        session.handle(Command::Run);
        while session.is_running() {
            session.advance(&mut || true);
        }
    });
    let pieces = session.develop_report(None).ok()?.patches.len();
    Some(Row {
        name: format!("developable patches by A_tot, {name}: {pieces}"),
        value: time,
        unit: "s",
        limit: Some(limit),
    })
}

/// Mean time of a trial of merging a sphere's clusters by A_tot, over a run.
fn trials(regions: u32, max_patch_area: f64, limit: Option<f64>) -> Row {
    let (mesh, geometry) = sphere(32);
    let initial = Initial::NormalClusters { angle: 0.5, regions };
    let found = initial_labels(&mesh, &geometry, &initial).expect("a sphere has clusters").labels;
    let labels: Vec<u32> = mesh.triangles().iter().map(|t| found[t[0].index()]).collect();
    let measure = AreaMeasure::Total;
    let params = MergeParams { measure, max_patch_area, ..MergeParams::default() };
    let (mesh, geometry) = (Arc::new(mesh), Arc::new(geometry));
    let mut count = 0;
    let time = seconds(|| {
        let mut flow = MergeFlow::new(mesh, geometry, &labels, params, MergeWishes::default())
            .expect("a sphere can be merged");
        while flow.status() == Status::Running {
            flow.step().expect("a sphere can be merged");
        }
        count = flow.state().trials;
    });
    let most = (max_patch_area * labels.len() as f64).round();
    Row {
        name: format!("a merge trial, patches of up to {most} faces, mean of {count}"),
        value: 1e3 * time / count as f64,
        unit: "ms",
        limit,
    }
}
