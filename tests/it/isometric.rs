//! Isometric refinement: what it gains, what it keeps, what the flow promises.

use cutflow::flatten::fixed::seam_difference;
use cutflow::flatten::isometric::{Distortion, IsometricFlow, IsometricParams, Start};
use cutflow::flatten::lscm::lscm;
use cutflow::flatten::{Flattening, bff, measure};
use cutflow::mesh::VertexId;
use cutflow::methods::cutflow::Initial;
use cutflow::methods::flow::{Flow, SolveError, Status};
use nalgebra::{Point2, Point3, Vector2, Vector3};

use crate::baselines::{Sheet, strain};
use crate::surfaces::Surface;

fn charts(sheet: &Sheet) -> Flattening {
    bff(&sheet.opened, &sheet.geometry).unwrap()
}

fn flow(sheet: &Sheet, start: &Flattening, params: IsometricParams) -> IsometricFlow {
    IsometricFlow::new(&sheet.opened, &sheet.geometry, start, params).unwrap()
}

/// A hemisphere and more of a sphere, cut into two unequal lunes that share seams.
fn lunes() -> Sheet {
    let mut sheet = Sheet::cap(10, 1.9);
    // Along the first spoke to the pole and back along the second: a sixth, and the rest.
    let points = sheet.geometry.positions.clone();
    let triangles: Vec<_> = sheet.opened.mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect();
    let first = |j: u32| if j == 0 { 0 } else { 1 + 3 * j * (j - 1) };
    let mut cuts = Vec::new();
    for j in 0..10 {
        for side in [0, 1] {
            let at = |j: u32| if j == 0 { 0 } else { first(j) + side * j };
            cuts.push([at(j), at(j + 1)]);
        }
    }
    sheet = Sheet::new(&points, &triangles, cuts);
    assert_eq!(sheet.opened.patch_shapes(), [(1, 1), (1, 1)]);
    sheet
}

/// A cap slit from the rim nearly to the pole: partners in one chart, that meet at a tip.
fn slit_cap() -> Sheet {
    let whole = Sheet::cap(9, 1.6);
    let triangles: Vec<_> = whole.opened.mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect();
    let at = |j: u32| if j == 0 { 0 } else { 1 + 3 * j * (j - 1) };
    let cuts = (1..9).map(|j| [at(j), at(j + 1)]).collect();
    Sheet::new(&whole.geometry.positions, &triangles, cuts)
}

/// Steps until the flow ends or the number is reached, and checks what every step promises.
fn run_checked(sheet: &Sheet, flow: &mut IsometricFlow, steps: usize) {
    let mut total = flow.state().energy().total;
    for _ in 0..steps {
        let before = flow.steps();
        let report = flow.step().unwrap();
        // An update of multipliers keeps E up to rounding of its constant.
        let slack = 1e-13 * report.energy.iter().map(|e| e.1.abs()).sum::<f64>();
        assert!(report.energy[0].1 <= total + slack, "E rose from {total} in step {}", report.step);
        assert!(report.residual < 1e-6, "residual {}", report.residual);
        assert!(report.step - before <= 1, "a step is one iteration");
        let terms: f64 = report.energy[1..].iter().map(|e| e.1).sum();
        assert!((terms - report.energy[0].1).abs() <= slack);
        assert!(flow.state().step_length() <= 1.0);
        let measures = measure(&sheet.opened, &sheet.geometry, &flow.flattening());
        assert_eq!(measures.totals.flipped, 0, "a triangle turned over in step {}", report.step);
        total = report.energy[0].1;
        if report.status != Status::Running {
            break;
        }
    }
}

#[test]
fn a_developable_start_has_converged_before_its_first_step() {
    for sheet in [Sheet::flat(), Sheet::cylinder(), Sheet::cone()] {
        let start = charts(&sheet);
        let mut flow = flow(&sheet, &start, IsometricParams::default());
        assert_eq!(flow.status(), Status::Converged, "{:?}", flow.state().energy());
        assert_eq!(flow.step().unwrap().step, 0);
        assert_eq!(flow.flattening().uv, start.uv);
    }
}

#[test]
fn a_developable_surface_is_found_again_from_a_bad_start() {
    for distortion in [Distortion::SymmetricDirichlet, Distortion::Arap] {
        for sheet in [Sheet::flat(), Sheet::cone()] {
            let mut start = charts(&sheet);
            // Sheared, of twice the size: Newton has to find both size and shape.
            start.uv.iter_mut().for_each(|p| *p = Point2::new(2.0 * p.x + 0.9 * p.y, 1.7 * p.y));
            let params =
                IsometricParams { distortion, tolerance: 1e-9, ..IsometricParams::default() };
            let mut flow = flow(&sheet, &start, params);
            run_checked(&sheet, &mut flow, 60);
            let worst = strain(&sheet, &flow.flattening().uv);
            eprintln!("{distortion:?}: strain {worst:.1e} after {} steps", flow.steps());
            assert_eq!(flow.status(), Status::Converged);
            // Newton converges quadratically to energies of 1e-21.
            assert!(worst < 1e-8, "{distortion:?}: {worst}");
        }
    }
}

#[test]
fn a_cap_gets_less_distorted_than_its_conformal_map() {
    let sheet = Sheet::cap(12, 1.4);
    let start = charts(&sheet);
    for distortion in [Distortion::SymmetricDirichlet, Distortion::Arap] {
        let params = IsometricParams { distortion, ..IsometricParams::default() };
        let mut flow = flow(&sheet, &start, params);
        let before = flow.state().energy().distortion;
        run_checked(&sheet, &mut flow, 60);
        let after = flow.state().energy().distortion;
        eprintln!("{distortion:?}: {before:.5} to {after:.5} in {} steps", flow.steps());
        assert_eq!(flow.status(), Status::Converged);
        assert!(flow.steps() < 20 && after < 0.7 * before, "{before} {after} {}", flow.steps());
        // It was the minimum: a much smaller tolerance finds hardly more.
        let mut longer = self::flow(&sheet, &start, IsometricParams { tolerance: 1e-12, ..params });
        run_checked(&sheet, &mut longer, 60);
        let best = longer.state().energy().distortion;
        assert!(best <= after && after < best * (1.0 + 1e-4), "{after} {best}");
        // A disk again: all rim vertices of the corners of rings equally far from the pole.
        let uv = flow.flattening().uv;
        let first = 1 + 3 * 12 * 11;
        let radii: Vec<f64> = (0..6).map(|k| (uv[first + 12 * k] - uv[0]).norm()).collect();
        assert!(radii.iter().all(|r| (r / radii[0] - 1.0).abs() < 1e-3), "{radii:?}");
    }
}

#[test]
fn seam_partners_end_equal_to_the_tolerance() {
    for (name, sheet) in [("lunes", lunes()), ("slit cap", slit_cap())] {
        // Least squares conformal charts do not care about partners at all.
        for start in [charts(&sheet), lscm(&sheet.opened, &sheet.geometry).unwrap()] {
            for seam_tolerance in [1e-3, 1e-6] {
                let params = IsometricParams { seam_tolerance, ..IsometricParams::default() };
                let mut flow = flow(&sheet, &start, params);
                let before = flow.state().seam_difference();
                run_checked(&sheet, &mut flow, 100);
                let state = flow.state();
                eprintln!(
                    "{name}: {before:.1e} to {:.1e} in {} steps, {:?}",
                    state.seam_difference(),
                    flow.steps(),
                    state.energy()
                );
                assert_eq!(flow.status(), Status::Converged);
                assert!(state.seam_difference() <= seam_tolerance);
                let charts = flow.flattening();
                let outside = seam_difference(&sheet.opened, &charts.uv);
                assert!((outside - state.seam_difference()).abs() < 1e-12);
                assert!(!charts.seams_equal || outside < 1e-9);
            }
        }
        let params = IsometricParams { seam_weight: 0.0, ..IsometricParams::default() };
        let mut free = flow(&sheet, &lscm(&sheet.opened, &sheet.geometry).unwrap(), params);
        run_checked(&sheet, &mut free, 100);
        assert_eq!(free.status(), Status::Converged);
    }
}

#[test]
fn pins_stay_where_they_are_and_pull_where_they_are_not() {
    let sheet = Sheet::cap(8, 1.0);
    let start = charts(&sheet);
    let mut flow = flow(&sheet, &start, IsometricParams::default());
    let (pole, rim) = (VertexId(0), VertexId(1 + 3 * 8 * 7));
    let held = start.uv[pole.index()];
    let pull = start.uv[rim.index()] + (start.uv[rim.index()] - held) * 0.15;
    flow.set_pins(&[(pole, held), (rim, pull)]).unwrap();
    run_checked(&sheet, &mut flow, 100);
    assert_eq!(flow.status(), Status::Converged);
    assert_eq!(flow.state().place(pole), held, "held exactly");
    let off = (flow.state().place(rim) - pull).norm();
    eprintln!("{} steps, off by {off:.1e}, {:?}", flow.steps(), flow.state().energy());
    assert!((off - flow.state().pin_distance()).abs() < 1e-15);
    // The pull's spring gives by force / (2 κ): thousandths of the way.
    assert!(off < 2e-3 * (pull - held).norm(), "{off}");
    // Without pins the chart springs back to what it is without.
    flow.set_pins(&[]).unwrap();
    run_checked(&sheet, &mut flow, 100);
    let mut other = self::flow(&sheet, &start, IsometricParams::default());
    run_checked(&sheet, &mut other, 100);
    let [a, b] = [&flow, &other].map(|f| f.state().energy().distortion);
    assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
}

#[test]
fn the_gradient_is_the_derivative_of_the_energy() {
    for sheet in [lunes(), slit_cap()] {
        let start = lscm(&sheet.opened, &sheet.geometry).unwrap();
        let mut flow = flow(&sheet, &start, IsometricParams::default());
        let pull = start.uv[7] + Vector2::new(0.05, 0.02);
        flow.set_pins(&[(VertexId(7), pull)]).unwrap();
        let faces = sheet.opened.mesh.face_count();
        let weights: Vec<f64> = (0..faces).map(|f| 1.0 + (f % 7) as f64).collect();
        flow.set_face_weights(&weights).unwrap();
        for _ in 0..2 {
            flow.step().unwrap();
        }
        for mode in 0..3u32 {
            let direction = |v: usize| match mode {
                0 => [1.0, 0.0],
                1 => [(0.3 * v as f64).sin(), (0.7 * v as f64).cos()],
                _ => [0, 1].map(|i| ((v * 7919 + i * 104_729) % 1013) as f64 / 506.0 - 1.0),
            };
            let length = 1e-6;
            let (predicted, ahead) = flow.directional_derivative(direction, length);
            let (_, behind) = flow.directional_derivative(direction, -length);
            let actual = (ahead - behind) / (2.0 * length);
            // Third derivatives of 1e4 (edges of a tenth) times length²; E of rounding 1e-16 over length.
            let scale = predicted.abs().max(flow.state().energy().total.abs());
            assert!((actual - predicted).abs() < 1e-6 * scale, "{mode}: {predicted} {actual}");
        }
    }
}

#[test]
fn faces_of_a_stiffer_material_are_distorted_less() {
    let sheet = Sheet::cap(8, 1.2);
    let start = charts(&sheet);
    let mesh = &sheet.opened.mesh;
    let is_stiff = |f: usize| {
        let f = cutflow::mesh::FaceId::from(f);
        mesh.face_vertices(f).iter().all(|v| sheet.geometry.positions[v.index()].x > 0.0)
    };
    let spread = |weights: &[f64]| {
        let mut flow = flow(&sheet, &start, IsometricParams::default());
        flow.set_face_weights(weights).unwrap();
        run_checked(&sheet, &mut flow, 60);
        let scales = measure(&sheet.opened, &sheet.geometry, &flow.flattening()).face_log_scales;
        let stiff = (0..scales.len()).filter(|&f| is_stiff(f)).map(|f| scales[f].abs());
        stiff.fold(0.0, f64::max)
    };
    let count = mesh.face_count();
    let even = spread(&vec![1.0; count]);
    let stiff: Vec<f64> = (0..count).map(|f| if is_stiff(f) { 20.0 } else { 1.0 }).collect();
    assert!(spread(&stiff) < 0.95 * even);
}

#[test]
fn a_start_with_flips_begins_as_a_disk_instead() {
    let sheet = slit_cap();
    let mut start = charts(&sheet);
    let best = {
        let mut flow = flow(&sheet, &start, IsometricParams::default());
        run_checked(&sheet, &mut flow, 100);
        flow.state().energy().distortion
    };
    start.uv[0] += Vector2::new(5.0, 3.0);
    let mut flow = flow(&sheet, &start, IsometricParams::default());
    assert!(matches!(flow.starts()[0], Start::Disk { flipped } if flipped > 0));
    run_checked(&sheet, &mut flow, 200);
    let end = flow.state().energy().distortion;
    eprintln!("from a disk: {end} in {} steps, {best} from bff", flow.steps());
    assert_eq!(flow.status(), Status::Converged);
    // Tolerance 1e-5 of the decrease leaves some thousandths where the valley is flat.
    assert!((end / best - 1.0).abs() < 0.02, "{end} {best}");
}

#[test]
fn rims_do_not_come_to_cross_themselves() {
    let sheet = Sheet::grid([40, 12], true, |s, t| {
        // A saddle-like skirt: rings get longer than flat ones.
        let (r, a) = (0.2 + t, std::f64::consts::TAU * s);
        [r * a.cos(), r * a.sin(), 0.35 * t * (4.0 * a).cos()]
    });
    let start = charts(&sheet);
    let run = |guard_rims| {
        let params = IsometricParams { guard_rims, ..IsometricParams::default() };
        let mut flow = flow(&sheet, &start, params);
        run_checked(&sheet, &mut flow, 100);
        eprintln!("{guard_rims}: {:?} after {} steps", flow.status(), flow.steps());
        flips_and_crossings(&sheet, &flow.flattening())[1]
    };
    let [_, before] = flips_and_crossings(&sheet, &start);
    let (free, guarded) = (run(false), run(true));
    eprintln!("{before} crossings, free {free}, guarded {guarded}");
    // Ruffled, it has more rim than room: left alone its ends slide over each other.
    assert!(guarded <= before && free > before);
}

#[test]
fn a_run_repeats_bit_for_bit_goes_on_from_a_checkpoint_and_ends_quietly() {
    let sheet = lunes();
    let start = lscm(&sheet.opened, &sheet.geometry).unwrap();
    let params = IsometricParams { seam_tolerance: 1e-5, ..IsometricParams::default() };
    let (mut whole, mut split) = (flow(&sheet, &start, params), flow(&sheet, &start, params));
    for _ in 0..10 {
        whole.step().unwrap();
    }
    for _ in 0..4 {
        split.step().unwrap();
    }
    let checkpoint = split.checkpoint();
    let mut other = flow(&sheet, &start, params);
    other.step().unwrap();
    other.restore(&checkpoint);
    assert_eq!(other.state(), split.state());
    for _ in 0..6 {
        other.step().unwrap();
    }
    assert_eq!((whole.steps(), whole.state()), (other.steps(), other.state()));
    run_checked(&sheet, &mut whole, 500);
    assert_eq!(whole.status(), Status::Converged);
    let (end, state) = (whole.steps(), whole.state().clone());
    let report = whole.step().unwrap();
    assert_eq!((report.step, whole.state()), (end, &state));
}

#[test]
fn scale_changes_nothing_but_the_unit() {
    let run = |scale: f64| {
        let sheet = lunes();
        let points: Vec<_> = sheet.geometry.positions.iter().map(|p| p * scale).collect();
        let geometry = cutflow::geometry::Geometry::measure(&sheet.opened.mesh, points);
        let sheet = Sheet { opened: sheet.opened, geometry };
        let start = lscm(&sheet.opened, &sheet.geometry).unwrap();
        let mut flow = flow(&sheet, &start, IsometricParams::default());
        for _ in 0..4 {
            flow.step().unwrap();
        }
        flow.state().energy()
    };
    let one = run(1.0);
    for scale in [1e-6, 1e6] {
        let other = run(scale);
        for (a, b) in [(other.total, one.total), (other.distortion, one.distortion)] {
            // Rounding of the start, through four steps.
            assert!((a - b).abs() < 1e-8 * b.abs(), "{scale}: {a} {b}");
        }
    }
}

#[test]
fn nonsense_is_refused_with_its_reason() {
    let sheet = Sheet::cap(3, 1.0);
    let start = charts(&sheet);
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let params = IsometricParams { seam_weight: bad, ..IsometricParams::default() };
        let error = IsometricFlow::new(&sheet.opened, &sheet.geometry, &start, params).err();
        assert!(matches!(error, Some(SolveError::Parameter { name: "seam weight", .. })));
    }
    let mut flow = flow(&sheet, &start, IsometricParams::default());
    let before = flow.state().clone();
    let place = Point2::new(0.0, 0.0);
    for (pins, wanted) in [
        (vec![(VertexId(999), place)], "there is no vertex 999 among 37"),
        (vec![(VertexId(1), place), (VertexId(1), place)], "vertex 1 is a seed twice"),
        (vec![(VertexId(1), Point2::new(f64::NAN, 0.0))], "the energy is not finite"),
    ] {
        assert_eq!(flow.set_pins(&pins).unwrap_err().to_string(), wanted);
        assert_eq!(flow.state(), &before);
    }
    assert!(flow.set_face_weights(&vec![0.0; sheet.opened.mesh.face_count()]).is_err());
}

#[test]
fn a_real_model_in_one_chart_is_refined_without_flips() {
    let Some(surface) = Surface::shared("spot.obj") else { return };
    let sheet = Sheet::disks(&surface);
    let start = charts(&sheet);
    let mut flow = flow(&sheet, &start, IsometricParams::default());
    let before = flow.state().energy().distortion;
    let [_, crossings] = flips_and_crossings(&sheet, &start);
    run_checked(&sheet, &mut flow, 100);
    eprintln!("{before:.3} to {:?} in {} steps", flow.state().energy(), flow.steps());
    assert_eq!(flow.status(), Status::Converged);
    // One chart of a closed animal: legs and head are squeezed into it conformally by a factor of ten.
    assert!(flow.state().energy().distortion < 0.1 * before);
    assert!(flow.state().seam_difference() <= 1e-4);
    let end = flips_and_crossings(&sheet, &flow.flattening());
    assert!(end[0] == 0 && end[1] <= crossings);
}

/// Cuts of the flow cross triangles anywhere and leave slivers along seams; ten charts, some of whose rims come to touch.
#[test]
fn cuts_of_the_flow_are_refined_to_the_end() {
    let plane = Initial::Plane { point: Point3::new(0.0, 0.0, 0.0123), normal: Vector3::z() };
    let clusters = Initial::NormalClusters { angle: 60f64.to_radians(), regions: 10 };
    let mut sheets = vec![Sheet::of_flow(Surface::sphere(12), &plane, 5)];
    let spot = Surface::shared("spot.obj");
    sheets.extend(spot.map(|surface| Sheet::of_flow(surface, &clusters, 3)));
    for sheet in sheets {
        let start = charts(&sheet);
        let mut flow = flow(&sheet, &start, IsometricParams::default());
        let (before, given) =
            (flow.state().energy().distortion, flips_and_crossings(&sheet, &start));
        while flow.status() == Status::Running && flow.steps() < 80 {
            flow.step().unwrap();
        }
        let (state, end) = (flow.state(), flips_and_crossings(&sheet, &flow.flattening()));
        eprintln!(
            "{before:.3} to {:.5}, {:?} in {} steps, seams {:.1e}, {} contacts, {given:?} to {end:?}",
            state.energy().distortion,
            flow.status(),
            flow.steps(),
            state.seam_difference(),
            state.contacts(),
        );
        assert_eq!(flow.status(), Status::Converged);
        assert!(state.energy().distortion < 0.5 * before && state.seam_difference() <= 1e-4);
        assert!(end[0] == 0 && end[1] <= given[1]);
    }
}

fn flips_and_crossings(sheet: &Sheet, charts: &Flattening) -> [usize; 2] {
    let totals = measure(&sheet.opened, &sheet.geometry, charts).totals;
    [totals.flipped, totals.overlaps]
}
