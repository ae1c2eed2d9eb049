//! Gradients against central differences.

use std::sync::Arc;

use super::domain::Domain;
use super::objective::{Member, Objective, Prices};
use super::params::PhaseFieldParams;
use super::profile::indicator;
use super::state::PhaseFieldState;
use super::terms::connected::{Parts, Proof, add, edge};
use crate::geometry::Geometry;
use crate::linalg::dot;
use crate::mesh::Mesh;

/// A sphere of latitude rings with a dent, of unit area: cheap, uneven, and no two edges alike.
fn blob(rows: u32, around: u32) -> Domain {
    let mut positions = vec![[0.0, 0.0, 1.1]];
    for j in 1..rows {
        let theta = std::f64::consts::PI * f64::from(j) / f64::from(rows);
        for i in 0..around {
            let phi =
                std::f64::consts::TAU * (f64::from(i) + 0.37 * f64::from(j)) / f64::from(around);
            let r = 1.0 + 0.15 * (2.0 * phi).sin() * theta.sin() + 0.1 * (3.0 * theta).cos();
            positions.push([
                r * theta.sin() * phi.cos(),
                r * theta.sin() * phi.sin(),
                r * theta.cos(),
            ]);
        }
    }
    positions.push([0.0, 0.0, -0.9]);
    let last = (rows - 1) * around + 1;
    let at = |j: u32, i: u32| 1 + (j - 1) * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(1, i), at(1, i + 1)]);
        triangles.push([last, at(rows - 1, i + 1), at(rows - 1, i)]);
        for j in 1..rows - 1 {
            triangles.push([at(j, i), at(j + 1, i), at(j, i + 1)]);
            triangles.push([at(j, i + 1), at(j + 1, i), at(j + 1, i + 1)]);
        }
    }
    let mesh = Mesh::new(positions.len(), &triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, &positions).unwrap();
    Domain::new(Arc::new(mesh), Arc::new(geometry)).unwrap()
}

/// Fields with several bumps of both signs.
fn bumps(domain: &Domain, shift: f64) -> Vec<f64> {
    domain
        .geometry
        .positions
        .iter()
        .map(|p| {
            let q = p.coords * domain.scale;
            (1.6 * ((3.0 * q.x + shift).sin() * (3.1 * q.y).cos() + 0.5 * (4.0 * q.z).sin())).tanh()
        })
        .collect()
}

/// The gradient along some directions against central differences, relative to the larger of both.
fn worst(domain: &Domain, objective: &mut Objective, fields: &[f64], h: f64) -> f64 {
    let start: Vec<f64> = fields.iter().map(|&u| indicator(u).1 + 0.01).collect();
    let at = objective.evaluate(domain, fields, &start).unwrap();
    let directions = objective.directions(&at);
    let gradient = objective.reduce(domain, &at, &directions);
    let mut worst: f64 = 0.0;
    for k in 0..6 {
        let d: Vec<f64> =
            (0..fields.len()).map(|i| (0.7 * i as f64 * f64::from(k + 1)).sin()).collect();
        let mut value = |t: f64| {
            let trial: Vec<f64> = at.u.iter().zip(&d).map(|(u, d)| u + t * d).collect();
            objective.evaluate(domain, &trial, &directions).unwrap().value
        };
        let difference = (value(h) - value(-h)) / (2.0 * h);
        let exact = dot(&gradient, &d);
        worst = worst.max((difference - exact).abs() / exact.abs().max(difference.abs()));
    }
    worst
}

fn prices(epsilon: f64) -> Prices {
    let params = PhaseFieldParams { epsilon, ..PhaseFieldParams::default() };
    Prices::new(&params, false)
}

#[test]
fn every_term_alone_has_the_gradient_of_its_central_differences() {
    let domain = blob(18, 26);
    let u = bumps(&domain, 0.3);
    let ones = vec![1.0; domain.len()];
    let segment: Vec<f64> = bumps(&domain, 1.0).iter().map(|&u| indicator(u).0).collect();
    let base = prices(0.3);
    for weight in [ones, segment] {
        for (name, prices) in [
            ("perimeter", base),
            ("fraction", Prices { fraction: 0.3, ..base }),
            ("distortion", Prices { omega: 2.0, ..base }),
            ("sharper distortion", Prices { omega: 2.0, lambda: 11.0, ..base }),
            ("connectedness", Prices { parts: 3.0, ..base }),
        ] {
            let mut objective =
                Objective::new(&domain, vec![Member::given(weight.clone())], prices);
            let error = worst(&domain, &mut objective, &u, 1e-6);
            // Steps of 1e-6: rounding of 1e-10 and kinks of χ″ where |u| = 1 − δ.
            assert!(error < 1e-5, "{name}: {error}");
        }
    }
}

#[test]
fn connectedness_has_its_gradient_with_many_parts() {
    let domain = blob(30, 44);
    let u = bumps(&domain, 0.3);
    let faces = domain.face_means(&u);
    let epsilon: f64 = 0.2;
    let parts = |u: &[f64]| Parts::new(&domain, u, edge(epsilon));
    let counts = parts(&faces).counts;
    assert!(counts.iter().all(|&c| c >= 3), "{counts:?} parts");
    let w = vec![1.0; faces.len()];
    let value = |u: &[f64], sign: f64| {
        let (mut a, mut b) = (vec![0.0; u.len()], vec![0.0; u.len()]);
        let c = add(&domain, [u, &w], &parts(u), sign, epsilon, 1.0, [&mut a, &mut b]);
        (c, a)
    };
    for (k, sign) in (1..6).flat_map(|k| [(k, 1.0), (k, -1.0)]) {
        let (total, gradient) = value(&faces, sign);
        assert!(total > 0.0);
        let d: Vec<f64> = (0..faces.len()).map(|i| (1.3 * i as f64 * f64::from(k)).sin()).collect();
        let at = |t: f64| {
            let trial: Vec<f64> = faces.iter().zip(&d).map(|(u, d)| u + t * d).collect();
            value(&trial, sign).0
        };
        let difference = (at(1e-6) - at(-1e-6)) / 2e-6;
        let exact = dot(&gradient, &d);
        // Rounding 1e-9 of a sum of hundreds of terms.
        assert!((difference - exact).abs() < 1e-6 * exact.abs(), "{difference} {exact}");
    }
}

#[test]
fn a_carried_proof_never_says_that_islands_are_one_part_and_rarely_misses_that_there_is_one() {
    let domain = blob(30, 44);
    let e1 = edge(0.2);
    let heights: Vec<f64> = domain.geometry.positions.iter().map(|p| p.z / 1.1).collect();
    let noise = bumps(&domain, 0.3);
    let mut proof = Proof::default();
    let (mut carried, mut missed, mut apart) = (0, 0, 0);
    for step in 0..1000 {
        let t = 0.02 * f64::from(step);
        // An interface that wanders, and islands that come and go.
        let at = |v: usize| {
            let island = (3.0 * t).sin().max(0.0) * noise[v];
            (4.0 * (heights[v] - 0.4 * t.sin())).clamp(-1.0, 1.0) + 0.9 * island
        };
        let u: Vec<f64> = (0..domain.len()).map(at).collect();
        let faces = domain.face_means(&u);
        let is_one = Parts::new(&domain, &faces, e1).counts.iter().all(|&c| c < 2);
        let holds = proof.holds(|f| domain.face_mean(f, &u), e1, &domain);
        assert!(is_one || !holds, "step {step}");
        carried += usize::from(holds);
        missed += usize::from(is_one && !holds);
        apart += usize::from(!is_one);
        if is_one && !holds {
            proof.renew(&faces, e1, &domain);
        }
    }
    assert!(
        apart > 40 && carried > 3 * missed,
        "{carried} carried, {missed} missed, {apart} apart"
    );
}

#[test]
fn islands_that_reach_no_phase_lie_on_the_side_around_them() {
    let domain = blob(30, 44);
    let at = |j: usize, i: usize| 1 + (j - 1) * 44 + i;
    let mut u: Vec<f64> =
        (0..domain.len()).map(|v| if v < at(15, 0) { 1.0 } else { -1.0 }).collect();
    let block = |columns: std::ops::Range<usize>| {
        (21..26).flat_map(move |j| columns.clone().map(move |i| at(j, i))).collect::<Vec<_>>()
    };
    let (faint, strong) = (block(5..10), block(20..25));
    faint.iter().for_each(|&v| u[v] = 0.3);
    strong.iter().for_each(|&v| u[v] = 0.9);
    // An island in the island.
    u[at(23, 7)] = -0.2;
    let mut state = PhaseFieldState::whole(u.len());
    state.put(0, &u);
    assert_eq!(state.sides(0)[at(23, 6)], 0);
    assert!(state.give_up_islands(&domain.mesh, 0, 0.6).is_some());
    let sides = state.sides(0);
    assert!(faint.iter().all(|&v| sides[v] == 1), "with what lies in it");
    assert!(strong.iter().all(|&v| sides[v] == 0), "this one is a phase");
    assert_eq!((sides[0], sides[u.len() - 1]), (0, 1));
    // Weights follow, and still add up to 1.
    let weights = state.leaf_weights();
    assert!(faint.iter().all(|&v| weights[1][v] > 0.5));
    assert!((0..u.len()).all(|v| (weights[0][v] + weights[1][v] - 1.0).abs() < 1e-15));
    // A field that reaches no phase anywhere still divides.
    state.put(0, &u.iter().map(|u| 0.1 * u).collect::<Vec<_>>());
    state.give_up_islands(&domain.mesh, 0, 0.6);
    let sides = state.sides(0);
    assert_eq!((sides[0], sides[u.len() - 1]), (0, 1));
    assert!(strong.iter().chain(&faint).all(|&v| sides[v] == 1));
}

#[test]
fn several_levels_together_have_their_gradient() {
    let domain = blob(18, 26);
    let fields = [bumps(&domain, 0.3), bumps(&domain, 1.7), bumps(&domain, 2.9)].concat();
    for prices in [prices(0.3), Prices { omega: 2.0, parts: 3.0, fraction: 0.4, ..prices(0.3) }] {
        let members = vec![
            Member::given(vec![1.0; domain.len()]),
            Member::below(0, 1.0),
            Member::below(0, -1.0),
        ];
        let mut objective = Objective::new(&domain, members, prices);
        let error = worst(&domain, &mut objective, &fields, 1e-6);
        // As for single terms.
        assert!(error < 1e-5, "{error}");
    }
}

#[test]
fn areas_are_kept_to_rounding() {
    let domain = blob(18, 26);
    for fraction in [0.02, 0.5, 0.9] {
        let base = Prices { fraction, ..prices(0.3) };
        for u in [bumps(&domain, 0.3), vec![1.0; domain.len()], vec![-1.0; domain.len()]] {
            let mut objective =
                Objective::new(&domain, vec![Member::given(vec![1.0; domain.len()])], base);
            let directions: Vec<f64> = u.iter().map(|&u| indicator(u).1 + 0.01).collect();
            let at = objective.evaluate(&domain, &u, &directions).unwrap();
            assert!(at.terms[0].area_error < 1e-12, "{fraction}: {}", at.terms[0].area_error);
        }
    }
}
