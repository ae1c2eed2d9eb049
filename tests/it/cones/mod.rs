//! Optimal cones: values of an independent solver, conditions of the optimum, and what must not matter.

use std::f64::consts::TAU;

use cutflow::geometry::{Geometry, Laplacian, angle_defects, polygon};
use cutflow::mesh::read::obj;
use cutflow::mesh::{Mesh, VertexId};
use cutflow::methods::cones::{ConeBoundary, ConeFields, ConeFlow, ConeParams, ConeState};
use cutflow::methods::flow::{Flow, Status};

mod conditions;
mod reference;
mod running;

/// A file of the shared folder with its own numbering; says so and gives nothing where that is absent.
fn shared(name: &str) -> Option<(Mesh, Geometry)> {
    let bytes = shared_bytes(&format!("meshes/{name}"))?;
    let soup = obj::read(&bytes).unwrap().soup;
    let mut triangles = Vec::new();
    for i in 0..soup.polygon_count() {
        polygon::triangulate(&soup.positions, soup.polygon(i), &mut triangles);
    }
    let mesh = Mesh::new(soup.positions.len(), &triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, &soup.positions).unwrap();
    Some((mesh, geometry))
}

fn shared_bytes(name: &str) -> Option<Vec<u8>> {
    let bytes = std::fs::read(format!("{}/../shared/{name}", env!("CARGO_MANIFEST_DIR"))).ok();
    if bytes.is_none() {
        // Straight to the terminal: what a passing test prints is not shown.
        let text = format!("SKIPPED: needs ../shared/{name}, which is not there\n");
        std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes()).unwrap();
    }
    bytes
}

fn flow(mesh: &Mesh, geometry: &Geometry, params: &ConeParams, fields: &ConeFields) -> ConeFlow {
    ConeFlow::new(mesh, geometry, params, fields).unwrap()
}

fn at(lambda: f64) -> ConeParams {
    ConeParams { lambda, ..ConeParams::default() }
}

/// Steps to the end.
fn solve(flow: &mut ConeFlow) -> &ConeState {
    for _ in 0..2000 {
        if flow.step().unwrap().status != Status::Running {
            break;
        }
    }
    let s = flow.state();
    let text = (s.lambda, s.cones.len(), s.gap, s.violation, s.residual, flow.lambda_max());
    assert_eq!(flow.status(), Status::Converged, "{text:?}");
    flow.state()
}

/// How far a state is from the conditions of the optimum, found from mesh and state alone: L u = μ − Ω, the equation of φ, Gauss–Bonnet, the sign
/// conditions and bounds, all in natural units (radians, λ).
fn kkt(
    mesh: &Mesh,
    geometry: &Geometry,
    params: &ConeParams,
    fields: &ConeFields,
    state: &ConeState,
) -> f64 {
    let n = mesh.vertex_count();
    let laplacian = Laplacian::new(mesh, geometry);
    let multiply = |x: &[f64]| {
        let mut y = vec![0.0; n];
        laplacian.pattern.multiply(&laplacian.values, x, &mut y);
        y
    };
    let mut mu = vec![0.0; n];
    for cone in state.cones.iter().chain(&state.corners) {
        mu[cone.vertex.index()] = cone.angle;
    }
    let defects = angle_defects(mesh, geometry);
    let areas = geometry.vertex_dual_areas(mesh);
    let weight = |v: usize| fields.distortion_weight.get(v).copied().unwrap_or(1.0);
    let lu = multiply(&state.u);
    let lphi = multiply(&state.phi);
    let corners = params.boundary.has_corners();
    let mut worst: f64 = 0.0;
    for v in 0..n {
        let id = VertexId::from(v);
        let rim = mesh.is_boundary_vertex(id);
        if rim && !corners {
            if params.boundary == ConeBoundary::Isometric {
                worst = worst.max(state.u[v].abs());
            } else {
                worst = worst.max((lphi[v] + areas[v] * weight(v) * state.u[v]).abs());
            }
            continue;
        }
        worst = worst.max((lu[v] - mu[v] + defects[v]).abs());
        // u is minus the u whose dual variable φ is.
        worst = worst.max((lphi[v] + areas[v] * weight(v) * state.u[v]).abs());
        if fields.fixed.iter().any(|f| f.0 == id) || fields.excluded.get(v) == Some(&true) {
            continue;
        }
        let mut t = params.lambda * fields.cone_cost.get(v).copied().unwrap_or(1.0);
        let [mut low, mut high] = params.bounds;
        if rim {
            let convex =
                matches!(params.boundary, ConeBoundary::Convex | ConeBoundary::PolygonalConvex);
            [low, high] = [if convex { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY];
            t *= if params.boundary == ConeBoundary::Convex { 0.0 } else { params.boundary_cost };
        }
        if fields.free.contains(&id) {
            t = 0.0;
            (low, high) = (low.max(-TAU), high.min(TAU));
        }
        assert!(mu[v] >= low && mu[v] <= high, "angle {} of vertex {v}", mu[v]);
        let phi = state.phi[v];
        // φ must lie in the subdifferential of t|μ| plus the bounds' normal cone.
        let near = |x: f64, y: f64| (x - y).abs() < 1e-5;
        let mut interval = if mu[v] > 0.0 {
            [t, t]
        } else if mu[v] < 0.0 {
            [-t, -t]
        } else {
            [-t, t]
        };
        if near(mu[v], high) {
            interval[1] = f64::INFINITY;
        }
        if near(mu[v], low) {
            interval[0] = f64::NEG_INFINITY;
        }
        worst = worst.max((phi - phi.clamp(interval[0], interval[1])).abs() / params.lambda);
    }
    worst
}

/// Conditions of the optimum hold, and the certificate says so.
fn check(
    mesh: &Mesh,
    geometry: &Geometry,
    params: &ConeParams,
    fields: &ConeFields,
    state: &ConeState,
) {
    // Rounding of the solves: condition 1e5 to 1e6 of L.
    let miss = kkt(mesh, geometry, params, fields, state);
    assert!(miss < 1e-9, "{miss} {params:?}");
    assert!(state.residual < 1e-9, "{}", state.residual);
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs()
}

/// A surface of unit area from triangles.
fn unit(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> (Mesh, Geometry) {
    let mesh = Mesh::new(positions.len(), triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, positions).unwrap();
    (mesh, geometry)
}

/// A disk of `rings` rings of 6, 12, 18 … vertices, lifted into space.
fn disk(rings: i32, lift: impl Fn(f64, f64) -> [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let size = |q: i32, r: i32| q.abs().max(r.abs()).max((q + r).abs());
    let mut numbers = std::collections::BTreeMap::new();
    let mut positions = Vec::new();
    for q in -rings..=rings {
        for r in -rings..=rings {
            let ring = size(q, r);
            if ring > rings {
                continue;
            }
            // The hexagon's direction, at the radius of its ring.
            let (x, y) = (f64::from(q) + 0.5 * f64::from(r), 0.75f64.sqrt() * f64::from(r));
            let radius = f64::from(ring) / f64::from(rings) / x.hypot(y).max(1e-300);
            numbers.insert((q, r), positions.len() as u32);
            positions.push(lift(x * radius, y * radius));
        }
    }
    let mut triangles = Vec::new();
    for q in -rings - 1..=rings {
        for r in -rings - 1..=rings {
            let at = |q, r| numbers.get(&(q, r)).copied();
            for corners in
                [[(q, r), (q + 1, r), (q, r + 1)], [(q + 1, r), (q + 1, r + 1), (q, r + 1)]]
            {
                if let [Some(a), Some(b), Some(c)] = corners.map(|(q, r)| at(q, r)) {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    (positions, triangles)
}

/// Height of a sheet with two hills and a hollow.
fn hills(x: f64, y: f64) -> f64 {
    let bump = |a: f64, b: f64, s: f64| (-((x - a).powi(2) + (y - b).powi(2)) / (s * s)).exp();
    0.5 * bump(0.35, 0.2, 0.25) + 0.4 * bump(-0.4, 0.1, 0.22) - 0.2 * bump(0.0, -0.5, 0.3)
}

fn sheet(rings: i32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    disk(rings, |x, y| [x, y, hills(x, y)])
}

/// A closed surface of genus 0 with bumps and saddles.
fn blob(frequency: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let soup = cutflow::session::samples::icosphere(frequency);
    let positions = soup
        .positions
        .iter()
        .map(|p| {
            let r = 1.0 + 0.25 * (5.0 * p[0] + 0.4).sin() * (4.0 * p[1]).cos() + 0.2 * p[2] * p[0];
            p.map(|x| x * r)
        })
        .collect();
    let triangles =
        (0..soup.polygon_count()).map(|i| soup.polygon(i).try_into().unwrap()).collect();
    (positions, triangles)
}

/// A ring whose tube is thicker on one side.
fn ring(around: u32, along: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..along {
        for j in 0..around {
            let a = TAU * f64::from(i) / f64::from(along);
            let b = TAU * (f64::from(j) + 0.5 * f64::from(i)) / f64::from(around);
            let tube = 0.4 + 0.15 * a.cos();
            let r = 1.0 + tube * b.cos();
            positions.push([r * a.cos(), r * a.sin(), tube * b.sin()]);
            // Half a turn of the tube's numbering per step: the last row meets the first after `along` / 2 turns.
            let turn = if i + 1 == along { along / 2 } else { 0 };
            let at = |i: u32, j: u32| (i % along) * around + j % around;
            let (p, q) = (at(i, j), at(i, j + 1));
            let (r, s) = (at(i + 1, j + around - 1 + turn), at(i + 1, j + turn));
            triangles.extend([[p, r, s], [p, s, q]]);
        }
    }
    (positions, triangles)
}

/// Two surfaces side by side.
fn both(
    mut a: (Vec<[f64; 3]>, Vec<[u32; 3]>),
    b: (Vec<[f64; 3]>, Vec<[u32; 3]>),
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let offset = a.0.len() as u32;
    a.0.extend(b.0.iter().map(|p| [p[0] + 5.0, p[1], p[2]]));
    a.1.extend(b.1.iter().map(|t| t.map(|v| v + offset)));
    a
}

/// A price as a share of the one from which on nothing changes.
fn price(mesh: &Mesh, geometry: &Geometry, share: f64) -> f64 {
    let mut flow = flow(mesh, geometry, &at(1.0), &ConeFields::default());
    solve(&mut flow);
    share * flow.lambda_max()
}
