//! The figures: every time as a ratio to one numeric factorisation of the same mesh's Laplacian, in the same run.
//!
//! A ratio means something on a machine that is busy or slow; seconds do not. Each figure stands beside its limit.

mod charts;
mod cones;
mod develop;
mod memory;
mod patterns;
mod phasefield;
mod spheres;
mod stages;
mod values;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use cutflow::geometry::{Geometry, Laplacian};
use cutflow::linalg::{Analysis, Factor};
use cutflow::mesh::{Mesh, read};
use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial, Weights};
use cutflow::methods::flow::{Flow, Status};
use cutflow::session::{Command, Layout, Session, Surface, samples};
use nalgebra::{Point3, Vector3};

/// One figure.
struct Row {
    name: String,
    value: f64,
    unit: &'static str,
    /// Largest value that was promised; for speeds ("MB/s") the smallest.
    limit: Option<f64>,
}

impl Row {
    /// Whether the promise is kept; none where nothing was promised.
    fn is_met(&self) -> Option<bool> {
        let limit = self.limit?;
        Some(if self.unit == "MB/s" { self.value >= limit } else { self.value <= limit })
    }
}

/// Seconds that this process has spent on a processor, to some milliseconds: on a busy machine the wall's clock counts the work
/// of others. `None` where the system does not tell.
#[expect(clippy::disallowed_methods, reason = "asks the system about itself")]
fn processor_time() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/schedstat").ok()?;
    Some(text.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
}

#[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
fn seconds(work: impl FnOnce()) -> f64 {
    let (start, before) = (Instant::now(), processor_time());
    work();
    match (before, processor_time()) {
        (Some(before), Some(after)) => after - before,
        _ => start.elapsed().as_secs_f64(),
    }
}

/// Rounds of which the fastest counts: what others do on the machine slows some of them, hardly all.
const ROUNDS: usize = 4;

/// Time of a piece of work that is done about so many times: its mean in the fastest of a few rounds, by the wall's clock.
#[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
fn time_of(repeats: usize, mut work: impl FnMut()) -> f64 {
    // Once before: memory is touched for the first time.
    work();
    let each = repeats.div_ceil(ROUNDS);
    let mut round = || {
        let start = Instant::now();
        (0..each).for_each(|_| work());
        start.elapsed().as_secs_f64() / each as f64
    };
    (0..ROUNDS).map(|_| round()).fold(f64::INFINITY, f64::min)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn sphere(frequency: u32) -> (Mesh, Geometry) {
    let soup = samples::icosphere(frequency);
    let triangles: Vec<[u32; 3]> =
        (0..soup.polygon_count()).map(|i| [0, 1, 2].map(|k| soup.polygon(i)[k])).collect();
    let mesh = Mesh::new(soup.positions.len(), &triangles).expect("a sphere is a surface");
    let (geometry, _) = Geometry::unit_area(&mesh, &soup.positions).expect("a sphere has an area");
    (mesh, geometry)
}

/// The Laplacian plus a hundredth of the mass: its factor and its values.
fn factored(mesh: &Mesh, geometry: &Geometry) -> (Factor, Vec<f64>) {
    let laplacian = Laplacian::new(mesh, geometry);
    let mut values = laplacian.values.clone();
    for (v, area) in geometry.vertex_dual_areas(mesh).iter().enumerate() {
        values[laplacian.pattern.diagonal(v)] += 0.01 * area;
    }
    let analysis = Arc::new(Analysis::new(laplacian.pattern).expect("memory suffices"));
    let factor = Factor::new(analysis, &values).expect("the matrix is positive definite");
    (factor, values)
}

/// What a ratio is measured in, done again beside every piece of work: a machine that slows down slows both.
struct Unit {
    factor: Factor,
    values: Vec<f64>,
}

impl Unit {
    fn new(mesh: &Mesh, geometry: &Geometry) -> Self {
        let (factor, values) = factored(mesh, geometry);
        Self { factor, values }
    }

    /// Seconds of one numeric factorisation.
    fn time(&mut self) -> f64 {
        elapsed(|| self.factor.refactor(&self.values).expect("as before"))
    }

    /// How many of them a piece of work takes, over so many turns of both.
    fn ratio(&mut self, turns: usize, mut work: impl FnMut()) -> f64 {
        work();
        let (mut spent, mut units) = (0.0, 0.0);
        for _ in 0..turns {
            spent += elapsed(&mut work);
            units += self.time();
        }
        spent / units
    }
}

/// Seconds by the wall's clock.
#[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
fn elapsed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// Time of a numeric factorisation.
fn factorisation(mesh: &Mesh, geometry: &Geometry, repeats: usize) -> f64 {
    let (mut factor, values) = factored(mesh, geometry);
    time_of(repeats, || factor.refactor(&values).expect("as before"))
}

/// Mean time of one solve with the factor of a mesh's Laplacian.
fn solve(mesh: &Mesh, geometry: &Geometry) -> f64 {
    let (mut factor, _) = factored(mesh, geometry);
    let mut x = vec![1.0; mesh.vertex_count()];
    time_of(10, || factor.solve(&mut x, 1))
}

/// A file that only our own machines have; says so where it is absent.
fn shared_bytes(name: &str) -> Option<Vec<u8>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes").join(name);
    #[expect(clippy::disallowed_methods, reason = "reads a test mesh")]
    let Ok(bytes) = std::fs::read(&path) else {
        println!("{} is absent: its figures are left out", path.display());
        return None;
    };
    Some(bytes)
}

/// The mesh of such a file.
fn shared(name: &str) -> Option<(Mesh, Geometry)> {
    let bytes = shared_bytes(name)?;
    let soup = read::read(name, &bytes).expect("a sound file").soup;
    let triangles: Vec<[u32; 3]> =
        (0..soup.polygon_count()).map(|i| [0, 1, 2].map(|k| soup.polygon(i)[k])).collect();
    let mesh = Mesh::new(soup.positions.len(), &triangles).expect("it is a surface");
    let (geometry, _) = Geometry::unit_area(&mesh, &soup.positions).expect("it has an area");
    Some((mesh, geometry))
}

fn params(dirichlet: f64, hencky: f64) -> CutFlowParams {
    let weights = Weights { dirichlet, hencky, length: 2.0, ..Weights::default() };
    CutFlowParams { weights, ..CutFlowParams::default() }
}

/// Mean time of a step, failed trials included, over the first steps of a run.
fn step_time(flow: &mut CutFlow, steps: usize) -> f64 {
    let mut total = 0.0;
    let before = flow.steps();
    while flow.steps() < before + steps && flow.status() == Status::Running {
        total += seconds(|| {
            flow.step().expect("the sphere can be cut");
        });
    }
    total / (flow.steps() - before) as f64
}

/// A trial of a line search in factorisations: cut mesh, assembly, factorisation, solve, energy.
fn trial_ratio(flow: &mut CutFlow, turns: usize, unit: &mut Unit) -> f64 {
    let length = 1e-4 * flow.mean_edge_length();
    let displacements = vec![1.0; flow.state().crossing_count()];
    unit.ratio(turns, || {
        flow.energy_beside(&displacements, length).expect("a small move can be evaluated");
    })
}

/// The exact gradient in factorisations, with the adjoint solve where J asks for one.
fn gradient_ratio(flow: &mut CutFlow, turns: usize, unit: &mut Unit) -> f64 {
    let length = 1e-4 * flow.mean_edge_length();
    let both = unit.ratio(turns, || {
        flow.directional_derivative(|_| 1.0, length).expect("a small move can be evaluated");
    });
    let before = flow.factorisations();
    flow.directional_derivative(|_| 1.0, length).expect("as above");
    // The trial beside it has overwritten the factor that an accepted step would have kept for the adjoint.
    let again = flow.factorisations() - before - 1;
    both - again as f64 - trial_ratio(flow, turns, unit)
}

/// A step in factorisations, failed trials included, over the first steps of a run; with a surface, the flattened preview that follows
/// it in the page as well.
fn step_ratio(flow: &mut CutFlow, steps: usize, unit: &mut Unit, shown: Option<&Surface>) -> f64 {
    let (mut spent, mut units) = (0.0, 0.0);
    let mut packing = None;
    let before = flow.steps();
    while flow.steps() < before + steps && flow.status() == Status::Running {
        spent += elapsed(|| {
            flow.step().expect("the surface can be cut");
            if let Some(surface) = shown {
                let cut = flow.cut_mesh();
                let factor = flow.factor().expect("it was factored");
                let layout = Layout::preview(surface, cut, factor, packing.as_ref())
                    .expect("the cut can be opened");
                packing = Some(layout.packing);
            }
        });
        units += unit.time();
    }
    spent / units
}

/// A sphere as a session holds it.
fn sphere_surface(frequency: u32) -> Surface {
    let soup = samples::icosphere(frequency);
    let triangles = (0..soup.polygon_count()).map(|i| [0, 1, 2].map(|k| soup.polygon(i)[k]));
    let triangles: Vec<[u32; 3]> = triangles.collect();
    let polygons = (0..u32::try_from(triangles.len()).expect("few")).collect();
    Surface::new("sphere", std::rc::Rc::new(soup), triangles, polygons).expect("it is a surface")
}

/// How the time of a step grows with the number of vertices: the exponent between the smallest and the largest of three sizes.
fn growth() -> Vec<Row> {
    let mut rows = Vec::new();
    let mut points = Vec::new();
    for frequency in [32, 64, 128] {
        let (mesh, geometry) = sphere(frequency);
        let vertices = mesh.vertex_count();
        let plane = Initial::Plane { point: Point3::origin(), normal: Vector3::z() };
        let mut flow =
            CutFlow::new(mesh, geometry, &plane, params(10.0, 0.0)).expect("a sphere can be cut");
        // Without the disturbance of the first step.
        step_time(&mut flow, 1);
        let time = step_time(&mut flow, 8);
        points.push((vertices as f64, time));
        rows.push(Row {
            name: format!("step, two regions, {vertices} vertices"),
            value: 1e3 * time,
            unit: "ms",
            limit: None,
        });
    }
    let [(v, s), .., (w, t)] = points[..] else { return rows };
    rows.push(Row {
        name: "exponent of the time of a step, 10 k to 164 k vertices".into(),
        value: (t / s).ln() / (w / v).ln(),
        unit: "",
        limit: Some(1.3),
    });
    rows
}

/// In the precision of binary files.
#[expect(clippy::cast_possible_truncation, reason = "what PLY and STL hold")]
fn single(x: f64) -> [u8; 4] {
    (x as f32).to_le_bytes()
}

/// Reading of a sphere of half a million triangles in three formats, detection included.
fn import_speeds() -> Vec<Row> {
    let soup = samples::icosphere(160);
    let (mut obj, mut ply, mut stl) = (String::new(), Vec::new(), vec![b' '; 80]);
    ply.extend(
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            soup.positions.len(),
            soup.polygon_count()
        )
        .into_bytes(),
    );
    for [x, y, z] in &soup.positions {
        obj += &format!("v {x:.9} {y:.9} {z:.9}\n");
        ply.extend([x, y, z].iter().flat_map(|&&c| single(c)));
    }
    stl.extend(u32::try_from(soup.polygon_count()).expect("half a million").to_le_bytes());
    for i in 0..soup.polygon_count() {
        let corners = soup.polygon(i);
        obj += &format!("f {} {} {}\n", corners[0] + 1, corners[1] + 1, corners[2] + 1);
        ply.push(3);
        ply.extend(corners.iter().flat_map(|v| v.to_le_bytes()));
        stl.extend([0; 12]);
        let places = corners.iter().flat_map(|&v| soup.positions[v as usize]);
        stl.extend(places.flat_map(single));
        stl.extend([0; 2]);
    }
    [("OBJ", obj.into_bytes(), 15.0), ("binary PLY", ply, 25.0), ("binary STL", stl, 25.0)]
        .into_iter()
        .map(|(name, bytes, limit)| {
            let read = |_| {
                seconds(|| {
                    let content = read::read("sphere", &bytes).expect("a sound file");
                    assert_eq!(content.soup.polygon_count(), soup.polygon_count());
                })
            };
            let time = median((0..5).map(read).collect());
            let megabytes = bytes.len() as f64 / 1e6;
            Row {
                name: format!("import of {name}, {megabytes:.0} MB"),
                value: megabytes / time,
                unit: "MB/s",
                limit: Some(limit),
            }
        })
        .collect()
}

/// Steps until 99 % of the whole decrease, from the equator of a sphere, with and without a coarse surface.
fn steps_to_the_end() -> Vec<Row> {
    let mut rows = Vec::new();
    for (frequency, [dirichlet, hencky], coarse_to_fine, limit) in [
        (16, [3.0, 0.0], false, 25.0),
        (32, [10.0, 0.0], false, 45.0),
        (32, [0.0, 3000.0], false, 45.0),
        (32, [10.0, 0.0], true, 15.0),
        (32, [0.0, 3000.0], true, 15.0),
    ] {
        let (mesh, geometry) = sphere(frequency);
        let vertices = mesh.vertex_count();
        let plane = Initial::Plane { point: Point3::origin(), normal: Vector3::z() };
        let params = CutFlowParams { coarse_to_fine, ..params(dirichlet, hencky) };
        let mut flow = CutFlow::new(mesh, geometry, &plane, params).expect("a sphere can be cut");
        let mut totals = vec![flow.state().energy().total];
        while totals.len() <= 120 && flow.step().expect("as above").status == Status::Running {
            totals.push(flow.state().energy().total);
        }
        let (first, last) = (totals[0], totals[totals.len() - 1]);
        let goal = last + 0.01 * (first - last);
        let steps = totals.iter().position(|j| *j <= goal).unwrap_or(totals.len());
        let how = if coarse_to_fine { ", coarse to fine" } else { "" };
        rows.push(Row {
            name: format!("steps to 99 %, {vertices} vertices, w_D {dirichlet}, w_H {hencky}{how}"),
            value: steps as f64,
            unit: "steps",
            limit: Some(limit),
        });
        rows.push(Row {
            name: format!("its J at the end{how}"),
            value: last,
            unit: "",
            limit: Some(match (frequency, hencky > 0.0) {
                (16, _) => 10.65,
                (_, false) => 15.6,
                (_, true) => 15.5,
            }),
        });
    }
    rows
}

/// Steps, trials and previews, of two regions or of many patches.
fn flow_rows(is_quick: bool, is_many: bool) -> Vec<Row> {
    let mut rows = Vec::new();
    let sizes: &[u32] = if is_quick { &[32] } else { &[32, 64] };
    for &frequency in sizes {
        let (mesh, geometry) = sphere(frequency);
        let vertices = mesh.vertex_count();
        let turns = if is_quick { 20 } else { 40 };
        let mut unit = Unit::new(&mesh, &geometry);
        rows.push(Row {
            name: format!("numeric factorisation, {vertices} vertices"),
            value: 1e3 * median((0..turns).map(|_| unit.time()).collect()),
            unit: "ms",
            limit: None,
        });
        let (name, initial, weights, limit) = if is_many {
            let clusters = Initial::NormalClusters { angle: 45f64.to_radians(), regions: 10 };
            ("many patches", clusters, params(0.0, 3000.0), 4.5)
        } else {
            let plane = Initial::Plane { point: Point3::origin(), normal: Vector3::z() };
            ("two regions", plane, params(10.0, 0.0), 2.5)
        };
        let mut flow = CutFlow::new(mesh.clone(), geometry.clone(), &initial, weights)
            .expect("the sphere can be cut");
        let steps = if is_quick { 15 } else { 40 };
        rows.push(Row {
            name: format!("step, {name}, {vertices} vertices"),
            value: step_ratio(&mut flow, steps, &mut unit, None),
            unit: "factorisations",
            limit: Some(limit),
        });
        rows.push(Row {
            name: format!("trial, {name}, {vertices} vertices"),
            value: trial_ratio(&mut flow, turns, &mut unit),
            unit: "factorisations",
            limit: Some(1.5),
        });
        rows.push(Row {
            name: format!("gradient, {name}, {vertices} vertices"),
            value: gradient_ratio(&mut flow, turns, &mut unit),
            unit: "factorisations",
            limit: None,
        });
        let surface = sphere_surface(frequency);
        let mut flow =
            CutFlow::new(surface.mesh.clone(), surface.geometry.clone(), &initial, weights)
                .expect("the sphere can be cut");
        rows.push(Row {
            name: format!("step with preview, {name}, {vertices} vertices"),
            value: step_ratio(&mut flow, steps, &mut unit, Some(&surface)),
            unit: "factorisations",
            limit: Some(limit),
        });
    }
    rows
}

/// What a run on a sphere reaches, and the time of a step in a session.
fn session_rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let (mesh, geometry) = sphere(32);
    let plane = Initial::Plane { point: Point3::origin(), normal: Vector3::z() };
    let mut flow = CutFlow::new(mesh, geometry, &plane, params(10.0, 0.0)).expect("as above");
    for _ in 0..60 {
        flow.step().expect("as above");
    }
    rows.push(Row {
        name: "J of the 10242-vertex sphere, w_D 10, after 60 steps".into(),
        value: flow.state().energy().total,
        unit: "",
        limit: Some(15.8),
    });

    // The same script as tests/bench/engine.mjs runs in wasm.
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "ball".into() });
    let advance = |session: &mut Session, count: usize| {
        let mut left = count;
        session.advance(&mut || {
            left -= 1;
            left > 0
        });
    };
    let round = |_| {
        session.handle(Command::Reset);
        session.handle(Command::Run);
        advance(&mut session, 10);
        seconds(|| advance(&mut session, 20)) / 20.0
    };
    let native = median((0..3).map(round).collect());
    rows.push(Row {
        name: "session step, ball, native".into(),
        value: 1e3 * native,
        unit: "ms",
        limit: None,
    });
    rows
}

/// Figures that are measured together, by the name that `--only` takes a part of.
type Group<'a> = (&'static str, Box<dyn FnOnce() -> Vec<Row> + 'a>);

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|a| a == memory::RUN) {
        memory::run();
        return;
    }
    let is_quick = arguments.iter().any(|a| a == "--quick");
    let value =
        |name: &str| arguments.iter().position(|a| a == name).and_then(|i| arguments.get(i + 1));
    let json = value("--json");
    let meshes = value("--meshes").map(Path::new);
    let only = value("--only").map_or("", String::as_str);
    let groups: [Group; 15] = [
        // First, while this process is small itself.
        ("memory", Box::new(memory::rows)),
        ("flow of two regions", Box::new(move || flow_rows(is_quick, false))),
        ("flow of many patches", Box::new(move || flow_rows(is_quick, true))),
        ("growth", Box::new(growth)),
        ("convergence", Box::new(steps_to_the_end)),
        ("spheres", Box::new(move || if is_quick { Vec::new() } else { spheres::rows() })),
        ("values", Box::new(move || if is_quick { Vec::new() } else { values::rows() })),
        ("session", Box::new(session_rows)),
        ("cones", Box::new(cones::rows)),
        ("charts", Box::new(charts::rows)),
        ("phasefield", Box::new(phasefield::rows)),
        ("develop", Box::new(develop::rows)),
        ("patterns", Box::new(patterns::rows)),
        ("import", Box::new(import_speeds)),
        ("stages", Box::new(move || meshes.map_or_else(Vec::new, |m| stages::rows(is_quick, m)))),
    ];
    let names: Vec<&str> = groups.iter().map(|(name, _)| *name).collect();
    let wanted = groups.into_iter().filter(|(name, _)| name.contains(only));
    let rows: Vec<Row> = wanted.flat_map(|(_, rows)| rows()).collect();
    if rows.is_empty() {
        println!("no figures of the group `{only}`; there are: {}", names.join(", "));
    }

    for row in &rows {
        let sign = if row.unit == "MB/s" { '≥' } else { '≤' };
        let verdict = match (row.limit, row.is_met()) {
            (Some(limit), Some(true)) => format!("{sign} {limit}: met"),
            (Some(limit), _) => format!("{sign} {limit}: MISSED"),
            _ => String::new(),
        };
        println!("{:<56} {:>9.3} {:<15} {verdict}", row.name, row.value, row.unit);
    }
    if let Some(path) = json {
        let list: Vec<serde_json::Value> = rows
            .iter()
            .map(|row| {
                serde_json::json!({
                    "name": row.name, "value": row.value, "unit": row.unit, "limit": row.limit
                })
            })
            .collect();
        #[expect(clippy::disallowed_methods, reason = "asked to write the figures")]
        std::fs::write(path, serde_json::to_string_pretty(&list).expect("plain numbers"))
            .expect("the file can be written");
    }
}
