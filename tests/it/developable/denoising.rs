//! Noise in seams: gone where planes meet, untouched within a plane.

use cutflow::methods::developable::{DenoiseFlow, DenoiseParams, DenoiseState};
use cutflow::methods::flow::SolveError;
use nalgebra::Vector3;

use super::*;
use crate::surfaces::grid;

fn denoise(shape: &Shape, charts: &[u32], params: DenoiseParams) -> DenoiseState {
    let mut flow = DenoiseFlow::new(shape.0.clone(), &shape.1, charts, params).unwrap();
    let mut last = flow.state().energy;
    while flow.step().unwrap().status == Status::Running {
        // Some hundred squares of rounding are noise.
        assert!(flow.state().energy <= last * (1.0 + 1e-12) + 1e-28);
        last = flow.state().energy;
    }
    flow.state().clone()
}

/// A roof of 12 × 12 squares; `noise` displaces the vertices of its ridge.
fn roof(noise: impl Fn(f64) -> [f64; 2]) -> (Shape, Vec<u32>, u32) {
    let (points, triangles, columns) = grid([12, 12], false, |x, y| {
        let [dx, dz] = if (x - 0.5).abs() < 1e-9 { noise(12.0 * y) } else { [0.0; 2] };
        [x + dx, y, 0.5 - (x - 0.5).abs() + dz]
    });
    let mesh = Mesh::new(points.len(), &triangles).unwrap();
    let geometry = Geometry::new(&mesh, points).unwrap();
    let charts = (0..triangles.len()).map(|f| u32::from((f / 2) % 12 >= 6)).collect();
    ((Arc::new(mesh), Arc::new(geometry)), charts, columns)
}

#[test]
fn a_zigzag_across_a_ridge_becomes_its_line() {
    let (shape, charts, columns) =
        roof(|k| if (k as u32).is_multiple_of(2) { [0.02, 0.015] } else { [-0.02, -0.015] });
    let ridge: Vec<usize> = (0..=12).map(|j| (j * columns + 6) as usize).collect();
    // How far the vertices are from the straight line through the ridge's ends on average.
    let spread = |positions: &[nalgebra::Point3<f64>]| {
        let along = (positions[ridge[12]] - positions[ridge[0]]).normalize();
        let mean = ridge.iter().fold(Vector3::zeros(), |s, &v| s + positions[v].coords) / 13.0;
        let off = |&v: &usize| {
            let d = positions[v].coords - mean;
            (d - along * d.dot(&along)).norm()
        };
        ridge.iter().map(off).fold(0.0, f64::max)
    };
    let before = spread(&shape.1.positions);
    let few = denoise(&shape, &charts, DenoiseParams::default());
    let many = denoise(&shape, &charts, DenoiseParams { sweeps: 2000, step: 1.0 });
    assert_eq!(few.sweeps, 8);
    // The planes' normals are off by the noise's mean, so that their line is not quite the ridge, but it is straight.
    assert!(before > 0.02 && spread(&few.positions) < 0.15 * before, "{}", spread(&few.positions));
    assert!(spread(&many.positions) < 0.02 * before, "{}", spread(&many.positions));
    for v in shape.0.vertices().filter(|v| !ridge.contains(&v.index())) {
        assert_eq!(many.positions[v.index()], shape.1.positions[v.index()], "not on the seam");
    }
    assert!(many.farthest > 0.01 && many.energy < few.energy);
}

#[test]
fn flat_charts_and_seams_within_a_plane_stay_where_they_are() {
    let (shape, charts, _) = roof(|_| [0.0; 2]);
    let same = denoise(&shape, &charts, DenoiseParams::default());
    // Rounding of a few products.
    assert!(same.farthest < 1e-15, "{}", same.farthest);
    // Both charts on one side of the roof, with teeth.
    let teeth: Vec<u32> =
        (0..charts.len()).map(|f| u32::from((f / 2) % 12 >= 2 + (f / 24) % 2)).collect();
    let plane: Vec<u32> = teeth.iter().zip(&charts).map(|(&t, &c)| t + 2 * c).collect();
    let state = denoise(&shape, &plane, DenoiseParams::default());
    assert!(state.farthest < 1e-15, "{}", state.farthest);
}

#[test]
fn a_run_repeats_goes_on_from_a_state_and_ends_quietly() {
    let (shape, charts, _) = roof(|k| [0.01 * k.sin(), 0.01 * (2.0 * k).cos()]);
    let params = DenoiseParams { sweeps: 6, step: 0.7 };
    let whole = denoise(&shape, &charts, params);
    let new = || DenoiseFlow::new(shape.0.clone(), &shape.1, &charts, params).unwrap();
    let mut first = new();
    (0..2).for_each(|_| drop(first.step().unwrap()));
    let mut second = new();
    second.restore(first.state());
    while second.step().unwrap().status == Status::Running {}
    assert_eq!((second.state(), second.status()), (&whole, Status::StepLimit));
    assert_eq!(second.step().unwrap().step, 6);
    assert_eq!(second.state(), &whole);
    for params in
        [DenoiseParams { step: 1.5, ..params }, DenoiseParams { step: f64::NAN, ..params }]
    {
        let refused = DenoiseFlow::new(shape.0.clone(), &shape.1, &charts, params).err();
        assert!(matches!(refused, Some(SolveError::Parameter { name: "step of sweeps", .. })));
    }
}
