//! Length-preserved boundaries: exact where the surface is developable, the values of the notes where it is not.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use cutflow::flatten::comparison::{Compared, Specimen};
use cutflow::flatten::fixed::Interior;
use cutflow::flatten::lpfb::{LpfbReport, lpfb, rim_errors};
use cutflow::flatten::{Flattening, Measures, NoChart, measure};
use cutflow::methods::flow::Status;
use nalgebra::Point3;

use crate::baselines::{Sheet, strain};
use crate::surfaces::{Surface, grid};

/// A cube of side 1, each face divided into n × n squares, cut along five edges that make an H.
fn cube(n: u32) -> Sheet {
    let mut numbers: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let mut points = Vec::new();
    let mut number = |p: [u32; 3]| {
        *numbers.entry(p).or_insert_with(|| {
            points.push(Point3::from(p.map(|x| f64::from(x) / f64::from(n))));
            points.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let mut at = |i: u32, j: u32| {
                        let mut p = [0; 3];
                        p[axis] = side;
                        p[(axis + 1) % 3] = i;
                        p[(axis + 2) % 3] = j;
                        number(p)
                    };
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    // Diagonals as the notes' L² has them; the other figures hardly depend on them.
                    let mut pair =
                        if side == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                    if side == 0 {
                        pair.iter_mut().for_each(|t| t.swap(1, 2));
                    }
                    triangles.extend(pair);
                }
            }
        }
    }
    // The bar along x, two legs along y at one end and the other, two along z.
    let mut cut = Vec::new();
    let mut along = |from: [u32; 3], axis: usize| {
        for k in 0..n {
            let (mut p, mut q) = (from, from);
            p[axis] += k;
            q[axis] += k + 1;
            cut.push([number(p), number(q)]);
        }
    };
    along([0, 0, 0], 0);
    for end in [0, n] {
        along([end, 0, 0], 1);
        along([end, 0, 0], 2);
    }
    Sheet::new(&points, &triangles, cut)
}

fn flatten(sheet: &Sheet) -> (Flattening, LpfbReport, Measures) {
    let (charts, mut reports) = lpfb(&sheet.opened, &sheet.geometry).unwrap();
    assert_eq!(reports.len(), 1);
    let measures = measure(&sheet.opened, &sheet.geometry, &charts);
    (charts, reports.remove(0), measures)
}

/// A flat or bent sheet without the squares in some rectangles.
fn with_holes(
    size: [u32; 2],
    holes: &[[[u32; 2]; 2]],
    place: impl Fn(f64, f64) -> [f64; 3],
) -> Sheet {
    let (points, triangles, _) = grid(size, false, place);
    let mut numbers = vec![u32::MAX; points.len()];
    let mut used = Vec::new();
    let mut kept = Vec::new();
    for (i, triangle) in triangles.iter().enumerate() {
        let square = i as u32 / 2;
        let at = [square % size[0], square / size[0]];
        let inside =
            |[low, high]: &[[u32; 2]; 2]| (0..2).all(|k| low[k] <= at[k] && at[k] < high[k]);
        if holes.iter().any(inside) {
            continue;
        }
        kept.push(triangle.map(|v| {
            if numbers[v as usize] == u32::MAX {
                numbers[v as usize] = used.len() as u32;
                used.push(points[v as usize]);
            }
            numbers[v as usize]
        }));
    }
    Sheet::new(&used, &kept, vec![])
}

const TWO_HOLES: [[[u32; 2]; 2]; 2] = [[[4, 4], [8, 9]], [[13, 5], [18, 8]]];

#[test]
fn developable_patches_keep_all_lengths() {
    let bent = |s: f64, t: f64| [0.3 * (3.0 * s).cos(), 0.3 * (3.0 * s).sin(), t];
    let sheets = [
        ("flat", Sheet::flat(), 1),
        ("cylinder", Sheet::cylinder(), 1),
        ("cone", Sheet::cone(), 1),
        (
            "flat with holes",
            with_holes([24, 14], &TWO_HOLES, |s, t| [2.0 * s, t + 0.3 * s, 0.0]),
            3,
        ),
        ("cylinder with holes", with_holes([24, 14], &TWO_HOLES, bent), 3),
    ];
    for (name, sheet, loops) in sheets {
        let (charts, report, measures) = flatten(&sheet);
        let boundary = report.boundary.unwrap();
        eprintln!("{name}: {boundary:?}, length error {:.1e}", report.length_error_max);
        assert_eq!((boundary.status, report.loops.len()), (Status::Converged, loops), "{name}");
        // Rounding of sums over some hundred sides.
        assert!(boundary.closure_error < 1e-12 && boundary.angle_error < 1e-9, "{name}");
        assert!(report.length_error_max < 1e-11, "{name}: {}", report.length_error_max);
        let [_, angle_error] =
            rim_errors(&sheet.opened, &sheet.geometry, &charts.uv, &report.loops);
        assert!(angle_error < 1e-9, "{name}: {angle_error}");
        let chart = measures.charts[0].as_ref().unwrap();
        assert!(
            chart.area_change.abs() < 1e-9 && chart.area_change_abs < 1e-9,
            "{name}: {chart:?}"
        );
        assert!((chart.l2_stretch - 1.0).abs() < 1e-9, "{name}: {}", chart.l2_stretch);
        assert!(strain(&sheet, &charts.uv) < 1e-9, "{name}");
        assert_eq!((report.flipped, report.crossings, chart.overlaps), (0, 0, 0), "{name}");
        assert_eq!(report.interior, Some(Interior::Harmonic));
    }
}

#[test]
fn a_cube_cut_like_an_h_is_distorted_as_the_notes_say() {
    let sheet = cube(8);
    assert_eq!(sheet.opened.mesh.vertex_count(), 425);
    assert_eq!(sheet.opened.mesh.face_count(), 768);
    let (_, report, measures) = flatten(&sheet);
    let chart = measures.charts[0].as_ref().unwrap();
    assert_eq!(report.sides, 80);
    let boundary = report.boundary.unwrap();
    assert!((boundary.angle_error - PI / 80.0).abs() < 1e-6, "{boundary:?}");
    // To the digits that the notes give.
    assert!((chart.area_change.abs() - 0.50851).abs() < 5e-6, "{}", chart.area_change);
    assert!((chart.area_change_abs - 0.5100).abs() < 5e-5, "{}", chart.area_change_abs);
    assert!((chart.l2_stretch - 1.8792).abs() < 5e-5, "{}", chart.l2_stretch);
}

/// A cylinder of radius 1, slit, with twelve vertices pulled out by .15.
fn spiked([n, m]: [u32; 2], height: f64) -> Sheet {
    let is_spike = |s: f64, t: f64| {
        let (i, j) = ((s * f64::from(n)).round() as u32, (t * f64::from(m)).round() as u32);
        i % (n / 4) == n / 8 && j % (m / 3) == m / 6
    };
    Sheet::grid([n, m], true, |s, t| {
        let radius = if is_spike(s, t) { 1.15 } else { 1.0 };
        [radius * (TAU * s).cos(), radius * (TAU * s).sin(), height * t]
    })
}

#[test]
fn a_cylinder_with_spikes_is_nearly_developable_all_the_same() {
    let (_, report, measures) = flatten(&spiked([96, 48], 2.0));
    let chart = measures.charts[0].as_ref().unwrap();
    // No spike touches the rim: its angles are those of a cylinder.
    assert!(report.boundary.unwrap().angle_error < 1e-12);
    // The notes have 2.22 %, 3.80 % and 1.085 on a mesh that they do not give; this one is like it.
    assert!((chart.area_change + 0.0222).abs() < 0.001, "{}", chart.area_change);
    assert!((chart.area_change_abs - 0.0380).abs() < 0.001, "{}", chart.area_change_abs);
    assert!((chart.l2_stretch - 1.085).abs() < 0.005, "{}", chart.l2_stretch);
    assert_eq!(chart.flipped, 0);
}

#[test]
fn a_hemisphere_takes_few_undamped_iterations() {
    let sheet = Sheet::cap(24, PI / 2.0);
    let (_, report, _) = flatten(&sheet);
    let boundary = report.boundary.unwrap();
    eprintln!("{boundary:?}");
    assert_eq!(boundary.status, Status::Converged);
    assert!(boundary.iterations <= 12 && !boundary.is_damped, "{boundary:?}");
}

#[test]
fn patches_with_handles_have_no_chart_and_say_why() {
    let surface = Surface::sample("torus");
    let sheet = Sheet::new(&surface.geometry.positions, &triangles(&surface), vec![]);
    let (charts, report, _) = flatten(&sheet);
    assert_eq!(charts.charts[0], Err(NoChart::NotADisk { euler: 0, boundary_loops: 0 }));
    assert!(report.boundary.is_none() && report.interior.is_none());
}

fn triangles(surface: &Surface) -> Vec<[u32; 3]> {
    surface.mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect()
}

#[test]
fn the_table_of_the_paper_side_by_side() {
    let cylinder = spiked([48, 24], 2.0);
    let bent = |s: f64, t: f64| {
        let (x, y) = (2.0 * s - 1.0, 1.2 * t - 0.6);
        [x, y, 0.5 * (1.0 - 0.3 * x * x - 0.4 * y * y).sqrt()]
    };
    let sheets = [
        ("cylinder", cylinder),
        ("cube", cube(8)),
        ("two holes", with_holes([32, 20], &TWO_HOLES, bent)),
        ("large", with_holes([90, 60], &[], bent)),
    ];
    for (name, sheet) in sheets {
        let specimen = Specimen::new(sheet.opened, sheet.geometry).unwrap();
        let rows = specimen.compare().unwrap();
        for row in &rows {
            eprintln!(
                "{name:10} {:16} faces {:5} rim {:4} L2 {:.4} A {:+.4} A_abs {:.4} Π_L {:.1e} Π_θ {:.1e} flips {} overlaps {}",
                row.method.name(),
                row.faces,
                row.rim_sides,
                row.l2_stretch,
                row.area_change,
                row.area_change_abs,
                row.length_error,
                row.angle_error,
                row.flipped,
                row.overlaps
            );
        }
        let [ours, others @ ..] = rows.as_slice() else { panic!("no rows") };
        assert_eq!(ours.method, Compared::Lpfb);
        // Lengths to rounding; the others stretch the rim.
        assert!(ours.length_error < 1e-11, "{name}: {}", ours.length_error);
        for other in others {
            assert_eq!(other.faces, ours.faces, "{name}: {:?} has no chart", other.method);
            assert!(other.length_error > 1e-6, "{name}: {other:?}");
        }
        if name == "cube" {
            // The amplifier of the paper: what is not developable is told by the area.
            assert!(ours.area_change < -0.5);
        } else {
            assert!(ours.area_change_abs < 0.1 && ours.angle_error < 1e-2, "{name}: {ours:?}");
            assert_eq!((ours.flipped, ours.overlaps), (0, 0), "{name}");
        }
    }
}
