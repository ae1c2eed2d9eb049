//! Phase-field segmentation of spheres: a whole run, and what an iteration costs beside a product of matrix and vector.

use std::sync::Arc;

use cutflow::geometry::Laplacian;
use cutflow::linalg::{Analysis, Factor};
use cutflow::methods::flow::{Flow, Status};
use cutflow::methods::phasefield::{PhaseFieldFlow, PhaseFieldParams, Start};

use crate::{Row, seconds, sphere, time_of};

/// Mean time of a step once the first `rest` steps are made.
fn step_time(flow: &mut PhaseFieldFlow, rest: usize, steps: usize) -> f64 {
    for _ in 0..rest {
        flow.step().expect("a sphere can be split");
    }
    let time = seconds(|| {
        for _ in 0..steps {
            flow.step().expect("as above");
        }
    });
    time / steps as f64
}

pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let (mesh, geometry) = sphere(32);
    let (mesh, geometry) = (Arc::new(mesh), Arc::new(geometry));
    let new = |params: PhaseFieldParams| {
        PhaseFieldFlow::new(mesh.clone(), geometry.clone(), params).expect("a sphere has a metric")
    };
    let random =
        PhaseFieldParams { start: Start::Random, starts: 1, ..PhaseFieldParams::default() };
    let mut steps = 0;
    let whole = seconds(|| {
        let mut flow = new(random.clone());
        while flow.step().expect("a sphere can be split").status == Status::Running {}
        steps = flow.steps();
    });
    rows.push(Row {
        name: format!("phase field, sphere halved from noise, 10242 vertices, {steps} steps"),
        value: whole,
        unit: "s",
        limit: Some(2.0),
    });

    let Laplacian { pattern, mut values, .. } = Laplacian::new(&mesh, &geometry);
    for v in 0..mesh.vertex_count() {
        values[pattern.diagonal(v)] += 1e-4;
    }
    let x: Vec<f64> = (0..mesh.vertex_count()).map(|i| (i as f64).sin()).collect();
    let mut y = x.clone();
    let product = time_of(200, || pattern.multiply(&values, &x, &mut y));
    let analysis = Arc::new(Analysis::new(pattern).expect("memory suffices"));
    let mut factor = Factor::new(analysis, &values).expect("the matrix is positive definite");
    let numeric = time_of(10, || factor.refactor(&values).expect("as before"));
    let solve = time_of(10, || factor.solve(&mut y, 1));

    // Endless: what is timed is the step.
    let endless = PhaseFieldParams { tolerance: 0.0, warm_up: 40, ..random };
    let plain = PhaseFieldParams { is_connected: false, ..endless.clone() };
    let alone = step_time(&mut new(plain.clone()), 60, 60);
    rows.push(Row {
        name: "phase field, an iteration without distortion".into(),
        value: alone / product,
        unit: "products of matrix and vector",
        limit: Some(12.0),
    });
    rows.push(Row {
        name: "phase field, connectedness beside an iteration without".into(),
        value: step_time(&mut new(endless), 60, 60) / alone,
        unit: "",
        limit: Some(1.5),
    });
    let distorted = PhaseFieldParams { omega: 1.0, ..plain };
    rows.push(Row {
        name: "phase field, an iteration with distortion, beside two factorisations and six solves"
            .into(),
        value: step_time(&mut new(distorted), 10, 10) / (2.0 * numeric + 6.0 * solve),
        unit: "",
        limit: Some(1.3),
    });
    rows
}
