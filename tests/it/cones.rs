//! Optimal cones: values of an independent solver, conditions of the optimum, and what must not matter.

use cutflow::geometry::{Geometry, polygon};
use cutflow::mesh::Mesh;
use cutflow::mesh::read::{obj, ply};
use cutflow::methods::cones::{ConeFields, ConeFlow, ConeParams, ConeState};
use cutflow::methods::flow::{Flow, Status};

/// A file of the shared folder with its own numbering; says so and gives nothing where that is absent.
fn shared(name: &str) -> Option<(Mesh, Geometry)> {
    let path = format!("{}/../shared/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
    let Ok(bytes) = std::fs::read(&path) else {
        let text = format!("SKIPPED: {name} needs ../shared/meshes, which is not there\n");
        std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes()).unwrap();
        return None;
    };
    let soup = if name.ends_with(".obj") {
        obj::read(&bytes).unwrap().soup
    } else {
        ply::read(&bytes).unwrap().soup
    };
    let mut triangles = Vec::new();
    for i in 0..soup.polygon_count() {
        polygon::triangulate(&soup.positions, soup.polygon(i), &mut triangles);
    }
    let mesh = Mesh::new(soup.positions.len(), &triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, &soup.positions).unwrap();
    Some((mesh, geometry))
}

/// Steps to the end.
fn solve(flow: &mut ConeFlow) -> &ConeState {
    for _ in 0..2000 {
        if flow.step().unwrap().status != Status::Running {
            break;
        }
    }
    assert_eq!(flow.status(), Status::Converged);
    flow.state()
}

#[test]
#[ignore = "prints figures"]
fn figures() {
    for (name, lambdas) in [
        ("face.obj", vec![0.005, 0.004, 0.006, 0.05, 0.01, 0.001]),
        ("spot.obj", vec![0.05, 0.01, 0.005, 0.002, 0.001]),
        ("cheburashka.obj", vec![0.05, 0.01]),
        ("fandisk.obj", vec![0.05, 0.01, 0.005, 0.001]),
        ("rocker-arm.obj", vec![0.05, 0.01, 0.005, 0.001]),
    ] {
        let Some((mesh, geometry)) = shared(name) else { return };
        let time = std::time::Instant::now();
        let params = ConeParams { lambda: lambdas[0], ..ConeParams::default() };
        let mut flow = ConeFlow::new(&mesh, &geometry, &params, &ConeFields::default()).unwrap();
        println!("{name} new {:?} lambda_max {}", time.elapsed(), flow.lambda_max());
        for lambda in lambdas {
            let time = std::time::Instant::now();
            let (steps, solves, factors) = (flow.steps(), flow.solves(), flow.factorisations());
            flow.set_lambda(lambda).unwrap();
            while flow.step().unwrap().status == Status::Running {}
            let s = flow.state();
            println!(
                "  λ {lambda}: {} cones Φ/π {:.12} E {:.14} gap {:.1e} viol {:.1e} res {:.1e} steps {} solves {} factors {} {:?} {:?} lmax {}",
                s.cones.len(),
                s.total_angle / std::f64::consts::PI,
                s.int_u2,
                s.gap,
                s.violation,
                s.residual,
                flow.steps() - steps,
                flow.solves() - solves,
                flow.factorisations() - factors,
                flow.status(),
                time.elapsed(),
                flow.lambda_max()
            );
        }
    }
}
