//! Figures of optimal cones: with few of them solves count, with many factorisations.

use cutflow::geometry::Geometry;
use cutflow::mesh::Mesh;
use cutflow::methods::cones::{ConeFields, ConeFlow, ConeMethod, ConeParams};
use cutflow::methods::flow::{Flow, Status};
use cutflow::session::Document;

use crate::{Row, factorisation, seconds, shared, solve, time_of};

/// From the surface to the certified optimum.
fn solved(mesh: &Mesh, geometry: &Geometry, params: &ConeParams) -> ConeFlow {
    let mut flow = ConeFlow::new(mesh, geometry, params, &ConeFields::default()).expect("cones");
    while flow.step().expect("it converges").status == Status::Running {}
    assert_eq!(flow.status(), Status::Converged, "the optimum is certified");
    flow
}

/// All of them.
pub fn rows() -> Vec<Row> {
    let bear = Document::from_sample("plush_bear").expect("it is a sample");
    let bear = bear.surface().expect("it can be cut");
    let mut rows = sparse("plush bear", &bear.mesh, &bear.geometry, 0.01);
    if let Some((mesh, geometry)) = shared("face.obj") {
        rows.extend(sparse("face.obj", &mesh, &geometry, 0.005));
        rows.extend(slider(&mesh, &geometry));
    }
    let params = ConeParams { lambda: 0.001, method: ConeMethod::Newton, ..ConeParams::default() };
    let dense = solved(&bear.mesh, &bear.geometry, &params);
    rows.push(Row {
        name: format!("{} cones of the plush bear by Newton's method", dense.state().cones.len()),
        value: dense.factorisations() as f64,
        unit: "factorisations",
        limit: Some(30.0),
    });
    if let Some((mesh, geometry)) = shared("igea.ply") {
        let params = ConeParams { lambda: 0.01, ..ConeParams::default() };
        let mut count = 0;
        let time = seconds(|| count = solved(&mesh, &geometry, &params).state().cones.len());
        rows.push(Row {
            name: format!("igea.ply, λ 0.01: {count} cones"),
            value: time,
            unit: "s",
            limit: Some(60.0),
        });
    }
    rows
}

/// A whole solution with at most 60 cones.
fn sparse(name: &str, mesh: &Mesh, geometry: &Geometry, lambda: f64) -> Vec<Row> {
    let unit = factorisation(mesh, geometry, 10);
    let pair = 2.0 * solve(mesh, geometry);
    let params = ConeParams { lambda, ..ConeParams::default() };
    let flow = solved(mesh, geometry, &params);
    let (cones, rounds) = (flow.state().cones.len(), flow.steps());
    assert!(cones <= 60, "{cones} cones are not few");
    let time = time_of(3, || drop(solved(mesh, geometry, &params)));
    let promised = unit + 2.5 * (cones + rounds) as f64 * pair;
    vec![
        Row {
            name: format!(
                "{name}, λ {lambda}: {cones} cones in {rounds} rounds, over 1 factorisation + 2.5 × {} pairs of solves",
                cones + rounds
            ),
            value: time / promised,
            unit: "",
            limit: Some(1.0),
        },
        Row {
            name: format!("{name}, λ {lambda}: the same"),
            value: time,
            unit: "s",
            limit: (name == "face.obj").then_some(0.25),
        },
    ]
}

/// Moves of a slider that nobody made before: each asks for Green's functions of its own.
fn slider(mesh: &Mesh, geometry: &Geometry) -> Vec<Row> {
    let mut flow = solved(mesh, geometry, &ConeParams { lambda: 0.02, ..ConeParams::default() });
    let moves = 40;
    let time = seconds(|| {
        for k in 1..=moves {
            flow.set_lambda(0.02 * 0.2f64.powf(f64::from(k) / f64::from(moves))).expect("in range");
            while flow.step().expect("it converges").status == Status::Running {}
        }
    });
    vec![Row {
        name: format!("face.obj: a first move of the slider, λ 0.02 to 0.004, mean of {moves}"),
        value: 1e3 * time / f64::from(moves),
        unit: "ms",
        limit: Some(60.0),
    }]
}
