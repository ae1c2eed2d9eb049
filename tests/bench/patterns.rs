//! Figures of patterns: many pieces made ready, a long PDF, how much of the material nesting wastes.

use std::f64::consts::TAU;

use cutflow::flatten::bff;
use cutflow::geometry::Geometry;
use cutflow::methods::cutflow::{Initial, initial_labels, labelled_cut};
use cutflow::methods::cutgraph::cut_to_disks;
use cutflow::methods::flow::{Flow, Status};
use cutflow::pattern::notches::NotchParams;
use cutflow::pattern::{
    BlankParams, LaidSurface, MarkParams, NestFlow, NestParams, NestShape, Pattern, PdfParams,
    Placed, Rotations, Sheet, SheetParams, Stock, blanks, pdf, tiles,
};
use nalgebra::Point3;

use crate::{Row, seconds, sphere, time_of};

/// Seconds that nesting has.
const NESTING: f64 = 10.0;

/// All of them.
pub fn rows() -> Vec<Row> {
    let mut rows = pieces();
    rows.push(nesting());
    rows
}

/// A ball of 600 mm in some 200 cells: pieces with everything that is drawn on them, and all of it as a PDF.
fn pieces() -> Vec<Row> {
    let (mesh, geometry) = sphere(64);
    let initial = Initial::Random { regions: 16, cells: 200, seed: 1 };
    let labels = initial_labels(&mesh, &geometry, &initial).expect("a sphere has cells").labels;
    let mut cut = labelled_cut(&mesh, &geometry, &labels, |_| None);
    let points: Vec<Point3<f64>> = cut.points.iter().map(|&p| geometry.locate(&mesh, p)).collect();
    let opened = cut_to_disks(&mut cut, &points).expect("the cut can be opened").opened;
    let places = opened.vertex_points.iter().map(|&p| points[p as usize]).collect();
    let measured = Geometry::measure(&opened.mesh, places);
    let flattening = bff(&opened, &measured).expect("memory suffices");
    let charts: Vec<[f64; 2]> = flattening.uv.iter().map(|p| [p.x, p.y]).collect();
    let mm_per_unit = 600.0 / 0.5642;
    let laid = LaidSurface { opened: &opened, charts: &charts, positions: &points, mm_per_unit };
    let params = BlankParams {
        allowance_mm: 6.0,
        notches: Some(NotchParams { spacing_mm: 25.0, ..NotchParams::default() }),
        marks: Some(MarkParams::default()),
        ..BlankParams::default()
    };
    let ready = || {
        let (pattern, _) = Pattern::new(&opened, &charts, &points, mm_per_unit);
        blanks(&laid, &pattern, &params)
    };
    let made = ready();
    let shapes: Vec<NestShape> = made
        .pieces
        .iter()
        .map(|blank| NestShape { outlines: blank.cut.clone(), ..NestShape::default() })
        .collect();
    let mut flow = NestFlow::new(&shapes, &NestParams::default()).expect("the shapes can be laid");
    flow.step().expect("a first layout");
    let lie = |(blank, &pose)| Placed { blank, copy: [0, 1], is_mirrored: false, pose };
    let placed: Vec<Placed> = flow.state().poses.iter().enumerate().map(lie).collect();
    let sheet_of = |made: &cutflow::pattern::Blanks| {
        Sheet::new(&made.pieces, &placed, &[], &SheetParams::default())
    };
    let time = time_of(3, || {
        let made = ready();
        assert!(!sheet_of(&made).lines.is_empty(), "the sheet has lines");
    });
    let sheet = sheet_of(&made);
    let pages = tiles(&sheet, &PdfParams::default()).map_or(0, |tiles| tiles.len());
    let writing = time_of(3, || {
        pdf(&sheet, &PdfParams::default()).expect("a sheet can be written");
    });
    vec![
        Row {
            name: format!(
                "{} pieces with allowance, notches, labels, on their sheet",
                made.pieces.len()
            ),
            value: time,
            unit: "s",
            limit: Some(0.5),
        },
        Row { name: format!("PDF of {pages} pages"), value: writing, unit: "s", limit: Some(2.0) },
    ]
}

/// Twenty pieces with hollows, all different, on a roll, in any turn, after ten seconds of nesting.
fn nesting() -> Row {
    let mut state = 1u64;
    let mut next = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut blob = |size: f64| {
        let waves: Vec<[f64; 3]> = (2..6)
            .map(|n| [f64::from(n), 0.35 * next() / (f64::from(n) - 0.8), TAU * next()])
            .collect();
        let longer = 0.6 + 0.8 * next();
        let point = |i: usize| {
            let t = TAU * i as f64 / 60.0;
            let wave = waves.iter().map(|[n, a, phase]| a * (n * t + phase).cos());
            let r = size * (1.0 + wave.sum::<f64>()).max(0.15);
            [r * t.cos() * longer, r * t.sin() / longer]
        };
        NestShape { outlines: vec![(0..60).map(point).collect()], ..NestShape::default() }
    };
    let shapes: Vec<NestShape> = (0..20).map(|k| blob(40.0 + 3.0 * f64::from(k))).collect();
    let params = NestParams {
        stock: Stock::Roll { width_mm: 700.0 },
        gap_mm: 2.0,
        margin_mm: 5.0,
        rotations: Rotations::Free,
        step_limit: usize::MAX,
        ..NestParams::default()
    };
    let mut flow = NestFlow::new(&shapes, &params).expect("the shapes can be laid");
    let mut spent = 0.0;
    while spent < NESTING && flow.status() == Status::Running {
        spent += seconds(|| {
            flow.step().expect("shapes lie somewhere");
        });
    }
    Row {
        name: format!("material between 20 pieces on a roll, after {NESTING:.0} s"),
        value: 100.0 * (1.0 - flow.state().utilisation),
        unit: "%",
        limit: Some(30.0),
    }
}
