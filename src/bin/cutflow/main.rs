//! The native command: a [`Session`] driven from a terminal.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand, ValueEnum};
use cutflow::session::{
    Charting, Command, Document, Event, FlattenBy, FlattenReport, InfoReport, Layout, Outline,
    Problem, Session, Value, cut_from_json, cut_from_uv, settings_for, sphere_obj, surface_layout,
};

/// Prints a line. A reader that has gone away is no error: `cutflow info mesh.obj | head -1` is a good question.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

mod compare;
mod cones;
mod cut;
mod flattenings;
mod pattern;
mod segment;

/// Computes where to cut a curved surface so that its pieces flatten with little distortion.
#[derive(Parser)]
#[command(version, about)]
struct Cli {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Says what a mesh is and what is wrong with it.
    Info {
        #[command(flatten)]
        mesh: MeshArgs,
        #[command(flatten)]
        report: Report,
    },
    /// Repairs a mesh and writes it as OBJ.
    Repair {
        /// The mesh (OBJ, PLY, STL, OFF, GLB or glTF).
        mesh: String,
        /// Only these repairs, in this order, by their identifiers as `info --json` lists them.
        #[arg(long, value_name = "ID", value_delimiter = ',')]
        only: Vec<String>,
        /// Where to write the repaired mesh.
        #[arg(short, long, value_name = "OUT.obj")]
        output: PathBuf,
        #[command(flatten)]
        report: Report,
    },
    /// Divides a surface into other triangles and writes it as OBJ.
    #[command(allow_negative_numbers = true)]
    Prepare(PrepareArgs),
    /// Moves a cut to lower the distortion of its pieces.
    #[command(allow_negative_numbers = true)]
    Cut(Box<cut::CutArgs>),
    /// Finds the cones that lower the distortion most for their angle, joins them by seams and flattens.
    #[command(allow_negative_numbers = true)]
    Cones(Box<cones::ConesArgs>),
    /// Divides a surface in two again and again by phase fields.
    #[command(allow_negative_numbers = true)]
    Phasefield(Box<segment::PhaseFieldArgs>),
    /// Parts a surface into few pieces that nearly lie flat.
    #[command(allow_negative_numbers = true)]
    Develop(Box<segment::DevelopArgs>),
    /// Flattens a mesh along a cut and measures the result.
    Flatten(FlattenArgs),
    /// Writes a pattern at real size, or the surface with its UV map.
    #[command(allow_negative_numbers = true)]
    Pattern(Box<pattern::PatternArgs>),
    /// Does again what a project holds.
    Run(pattern::RunArgs),
    /// Runs several methods or settings on one mesh, and shows what each is worth and how long it takes.
    Compare(Box<compare::CompareArgs>),
}

#[derive(Args)]
struct Report {
    /// Writes the report to this file (`-` for standard output).
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What to work on.
#[derive(Args)]
struct MeshArgs {
    /// The mesh (OBJ, PLY, STL, OFF, GLB or glTF), or `sample:NAME` for a generated one.
    mesh: String,
    /// Lets the mesh doctor repair what stands in the way first.
    #[arg(long)]
    repair: bool,
}

#[derive(Args)]
struct PrepareArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// What to do: `subdivide`, `refine`, `remesh` or `decimate`.
    #[arg(long)]
    tool: String,
    /// Parameters of the tool as NAME=NUMBER: rounds (subdivide); tolerance in degrees (refine); edge in mean edges, crease in
    /// degrees, adaptivity from 0 to 1 (remesh); faces, crease (decimate).
    #[arg(long = "set", value_name = "NAME=NUMBER", value_delimiter = ',')]
    values: Vec<String>,
    /// Where to write the new mesh.
    #[arg(short, long, value_name = "OUT.obj")]
    output: PathBuf,
    #[command(flatten)]
    report: Report,
}

#[derive(Clone, Copy, ValueEnum)]
enum Method {
    /// Boundary first flattening, and conformal equivalence where that turns triangles over or misses the cones' angles.
    Auto,
    /// Boundary first flattening: isometric rims, or the cones' scale factors there.
    Bff,
    /// Discrete conformal equivalence with intrinsic flips: exact angles, nothing turned over.
    Conformal,
    /// True lengths at the rim, angles as near to those of the surface as closes it; a harmonic inside.
    Lpfb,
    /// Least squares conformal maps.
    Lscm,
    /// Discrete conformal parameterisation, spectral.
    Dcp,
    /// Angle based flattening (ABF++).
    Abf,
}

impl Method {
    /// As the session calls it.
    fn id(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Bff => "bff",
            Self::Conformal => "conformal",
            Self::Lpfb => "lpfb",
            Self::Lscm => "lscm",
            Self::Dcp => "dcp",
            Self::Abf => "abf",
        }
    }
}

/// What outlines are to be.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Shape {
    /// As long as on the surface.
    Length,
    /// A circle.
    Disk,
    /// A rectangle.
    Rectangle,
    /// A closed surface without handles as the unit sphere: the output has its places as positions.
    Sphere,
}

impl Shape {
    fn id(self) -> &'static str {
        match self {
            Self::Length => "length",
            Self::Sphere => "sphere",
            Self::Disk => "disk",
            Self::Rectangle => "rectangle",
        }
    }
}

#[derive(Args)]
struct FlattenArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// A cut.json that `cutflow cut` wrote, or `uv` for the seams of the mesh's own texture coordinates. Without it only cuts to
    /// disks are made.
    #[arg(long, value_name = "FILE")]
    cut: Option<PathBuf>,
    /// A cones.json that `cutflow cones` wrote: seams join these cones.
    #[arg(long, value_name = "FILE", conflicts_with = "cut")]
    cones: Option<PathBuf>,
    /// How to flatten.
    #[arg(long, value_enum, default_value = "auto")]
    method: Method,
    /// What the outline of every chart is to be; cones keep theirs.
    #[arg(long, value_enum, conflicts_with = "cones")]
    outline: Option<Shape>,
    /// The corners of a rectangle: four vertices of the file on the boundary, counted from 0. Chosen by shape without.
    #[arg(long, value_name = "V,V,V,V", value_delimiter = ',')]
    corners: Option<Vec<usize>>,
    /// Evens the stretch out afterwards, as cloth and sheet metal want it: nothing turns over, seams stay equally long.
    #[arg(long)]
    isometric: bool,
    /// Leaves charts that overlap themselves as they are.
    #[arg(long)]
    keep_overlaps: bool,
    /// Where to write the surface with texture coordinates.
    #[arg(short, long, value_name = "OUT.obj")]
    output: PathBuf,
    #[command(flatten)]
    report: Report,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let Some(method) = cut::asks_for_parameters(&words) {
        cut::list_parameters(method);
        return ExitCode::SUCCESS;
    }
    let task = match Cli::try_parse() {
        Ok(cli) => cli.command,
        // Help and version are answers, and help is one to saying nothing.
        Err(answer)
            if !answer.use_stderr()
                || answer.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand =>
        {
            answer.exit()
        }
        Err(error) => return fail(&misunderstood(&error)),
    };
    if let Err(problem) = can_write(&task) {
        return fail(&problem);
    }
    let result = match task {
        Task::Info { mesh, report } => info(&mesh, &report),
        Task::Repair { mesh, only, output, report } => repair(&mesh, &only, &output, &report),
        Task::Prepare(args) => prepare(&args),
        Task::Cut(args) => cut::run(&args),
        Task::Cones(args) => cones::run(&args),
        Task::Phasefield(args) => segment::phasefield(&args),
        Task::Develop(args) => segment::develop(&args),
        Task::Flatten(args) => flatten(&args),
        Task::Compare(args) => compare::run(&args),
        Task::Pattern(args) => pattern::pattern(&args),
        Task::Run(args) => pattern::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => fail(&problem),
    }
}

fn fail(Problem { what, place, what_to_do }: &Problem) -> ExitCode {
    eprintln!("error: {what}\nwhere: {place}\nwhat to do: {what_to_do}");
    ExitCode::FAILURE
}

/// A command line that says nothing that can be done.
fn misunderstood(error: &clap::Error) -> Problem {
    let text = error.to_string();
    let mut paragraphs = text.split("\n\n").map(str::trim).filter(|part| !part.is_empty());
    let what = paragraphs.next().unwrap_or_default();
    let rest: Vec<&str> = paragraphs
        .filter(|part| !part.starts_with("For more") && !part.contains("as a value"))
        .collect();
    Problem::new(
        what.strip_prefix("error: ").unwrap_or(what),
        "On the command line.",
        format!("{}\nAdd --help for all options.", rest.join("\n")).trim_start(),
    )
}

/// Whether there is a place for what a task writes: found out before the work is done.
fn can_write(task: &Task) -> Result<(), Problem> {
    let (output, (new_folder, report)) = match task {
        Task::Pattern(args) => {
            let (files, report) = args.outputs();
            let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
            return folders_exist(&files, None, report);
        }
        Task::Run(args) => (None, args.outputs()),
        Task::Info { report, .. } => (None, (None, report)),
        Task::Repair { output, report, .. } => (Some(output.as_path()), (None, report)),
        Task::Prepare(args) => (Some(args.output.as_path()), (None, &args.report)),
        Task::Flatten(args) => (Some(args.output.as_path()), (None, &args.report)),
        Task::Compare(args) => (None, args.outputs()),
        Task::Cut(args) => (None, args.outputs()),
        Task::Cones(args) => (None, args.outputs()),
        Task::Phasefield(args) => (None, args.outputs()),
        Task::Develop(args) => (None, args.outputs()),
    };
    folders_exist(output.as_slice(), new_folder, report)
}

/// How names of files end that a folder is hardly meant to have.
const FILE_ENDS: [&str; 9] = ["json", "obj", "ply", "stl", "glb", "svg", "dxf", "pdf", "zip"];

fn folders_exist(
    outputs: &[&Path],
    new_folder: Option<&Path>,
    report: &Report,
) -> Result<(), Problem> {
    let report = report.json.as_deref().filter(|path| *path != Path::new("-"));
    if let Some(folder) = new_folder
        && !folder.is_dir()
        && folder.extension().is_some_and(|end| FILE_ENDS.iter().any(|e| end == *e))
    {
        return Err(Problem::new(
            "This command writes several files into a folder, and this looks like the name of one file.",
            folder.display().to_string(),
            "Name a folder after -o; the report goes where --json says.",
        ));
    }
    for path in outputs.iter().copied().chain(report) {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        if folder.is_some_and(|folder| !folder.is_dir() && Some(folder) != new_folder) {
            return Err(Problem::new(
                "There is no such folder.",
                path.display().to_string(),
                "Make it first, or choose another place.",
            ));
        }
    }
    Ok(())
}

fn info(mesh: &MeshArgs, report: &Report) -> Result<(), Problem> {
    tell_info(&mesh.mesh, &InfoReport::new(&open(mesh)?), report)
}

fn tell_info(name: &str, info: &InfoReport, report: &Report) -> Result<(), Problem> {
    if !writes_to_stdout(report) {
        let shape = match info.boundary_loops {
            0 => "closed".to_owned(),
            1 => "1 boundary loop".to_owned(),
            n => format!("{n} boundary loops"),
        };
        say!("{name}");
        say!("  {} vertices, {} faces", info.vertices, info.faces);
        let components = if info.components == 1 { "component" } else { "components" };
        let genus = info.genus.map_or("no genus".to_owned(), |genus| format!("genus {genus}"));
        say!("  {} {components}, {shape}, {genus}", info.components);
        let [x, y, z] = info.size;
        let [x, y, z, area] = [x, y, z, info.area].map(short);
        say!("  size {x} × {y} × {z}, area {area} (unit of the file)");
        for notice in &info.notices {
            say!("  note: {}", notice.text);
            if !notice.repairs.is_empty() {
                say!("        repairs: {}", notice.repairs.join(", "));
            }
        }
        if !info.solvable {
            say!("  not ready to be cut: add --repair");
        }
    }
    write_json(report, info)
}

/// A number in six digits, whatever its size.
fn short(x: f64) -> String {
    let is_plain = x.abs() <= 0.0 || (1e-3..1e7).contains(&x.abs());
    if is_plain { format!("{x:.6}") } else { format!("{x:.5e}") }
}

fn repair(mesh: &str, only: &[String], output: &Path, report: &Report) -> Result<(), Problem> {
    let document = load(mesh)?;
    let mut session = Session::new();
    let settings = settings_for(&document);
    let needs_repair = !document.examination.recommended().is_empty();
    tell(session.open_with(Ok(document), settings))?;
    if only.is_empty() && needs_repair {
        tell(session.handle(Command::RepairAll))?;
    }
    for id in only {
        tell(session.handle(Command::Repair { id: id.clone() }))?;
    }
    finish(&mut session, mesh, output, report)
}

fn prepare(args: &PrepareArgs) -> Result<(), Problem> {
    let mut values = std::collections::BTreeMap::new();
    for text in &args.values {
        let parts = text.split_once('=').and_then(|(id, x)| Some((id, x.parse::<f64>().ok()?)));
        let Some((id, value)) = parts else {
            return Err(Problem::new(
                format!("{text} sets nothing."),
                "--set.",
                "Write a name, an equals sign and a number, such as length=0.02.",
            ));
        };
        values.insert(id.to_owned(), value);
    }
    let mut session = Session::new();
    let document = open(&args.mesh)?;
    let settings = settings_for(&document);
    tell(session.open_with(Ok(document), settings))?;
    tell(session.handle(Command::Prepare { tool: args.tool.clone(), values }))?;
    while session.is_running() {
        tell(session.advance(&mut || true))?;
    }
    finish(&mut session, &args.mesh.mesh, &args.output, &args.report)
}

/// Writes what every cut has.
fn write_cut(session: &mut Session, folder: &Path) -> Result<(), Problem> {
    for (kind, name) in [
        ("Cut (JSON)", "cut.json"),
        ("UV mesh (OBJ)", "uv.obj"),
        ("Cut curves (OBJ)", "cut.obj"),
        ("Pattern (SVG)", "pattern.svg"),
    ] {
        write(&folder.join(name), &session.export(kind)?.bytes)?;
    }
    Ok(())
}

/// Writes the mesh that a session holds, and says what it is.
fn finish(
    session: &mut Session,
    name: &str,
    output: &Path,
    report: &Report,
) -> Result<(), Problem> {
    write(output, &session.export("Mesh (OBJ)")?.bytes)?;
    match session.info_report() {
        Some(info) => tell_info(name, &info, report),
        None => Ok(()),
    }
}

fn flatten(args: &FlattenArgs) -> Result<(), Problem> {
    let document = open(&args.mesh)?;
    let surface = document.surface()?;
    let refine = if args.isometric { "dirichlet" } else { "none" };
    if !args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
        return Err(Problem::new(
            "The flattened surface is written as OBJ.",
            args.output.display().to_string(),
            "Choose a name that ends in .obj.",
        ));
    }
    let is_bff = matches!(args.method, Method::Auto | Method::Bff);
    if let Some(shape) = args.outline.filter(|&shape| shape != Shape::Length && !is_bff) {
        return Err(Problem::new(
            format!("The outline {} belongs to boundary first flattening.", shape.id()),
            "The choice of --outline beside --method.",
            "Leave out --method, or choose bff.",
        ));
    }
    if args.corners.is_some() && args.outline != Some(Shape::Rectangle) {
        return Err(Problem::new(
            "Corners were given, and no rectangle.",
            "The choice of --corners.",
            "Add --outline rectangle.",
        ));
    }
    if args.isometric && args.outline.is_some_and(|shape| shape != Shape::Length) {
        return Err(Problem::new(
            "Evening out does not keep an outline.",
            "The choice of --outline beside --isometric.",
            "Leave one of them out.",
        ));
    }
    if args.outline == Some(Shape::Sphere) && (args.cut.is_some() || args.report.json.is_some()) {
        return Err(Problem::new(
            "A sphere has neither cuts nor a report on charts.",
            "The choice of --outline sphere.",
            "Leave out --cut and --json.",
        ));
    }
    if args.outline == Some(Shape::Sphere) {
        let (bytes, flipped) = sphere_obj(surface)?;
        write(&args.output, &bytes)?;
        if flipped > 0 {
            eprintln!(
                "warning: {flipped} of {} triangles are turned over on the sphere: the surface is too slender there for its triangles.",
                surface.mesh.face_count()
            );
        }
        say!("{} on the unit sphere", document.name);
        return Ok(());
    }
    if let Some(path) = &args.cones {
        let clock = clock();
        let choices = [
            ("flatten", Value::Text(args.method.id().into())),
            ("refine", Value::Text(refine.into())),
            ("split", Value::Truth(!args.keep_overlaps)),
        ];
        let mut session = cones::with_cones(document, path, &choices)?;
        let mut report = session.cones_report(None)?.flattening;
        report.seconds = Some(clock.elapsed().as_secs_f64());
        let uv = session.export("UV mesh (OBJ)")?.bytes;
        return tell_flattening(args, &report, session.layout()?, &uv);
    }
    let cut = match &args.cut {
        None => None,
        Some(path) if path.as_os_str() == "uv" => Some(cut_from_uv(surface)?),
        Some(path) => Some(cut_from_json(surface, &path.display().to_string(), &read(path)?)?),
    };
    let clock = clock();
    let charting = Charting {
        by: FlattenBy::of(args.method.id()),
        splits: !args.keep_overlaps,
        outline: args.outline.map_or(Outline::TrueLength, |outline| Outline::of(outline.id())),
        corners: args.corners.as_deref().map(|corners| surface.corners(corners)).transpose()?,
    };
    let (layout, uv) = surface_layout(surface, cut, &charting, refine)?;
    let seconds = clock.elapsed().as_secs_f64();
    let report = FlattenReport::new(&layout, Some(seconds));
    tell_flattening(args, &report, &layout, &uv)
}

fn tell_flattening(
    args: &FlattenArgs,
    report: &FlattenReport,
    layout: &Layout,
    uv: &[u8],
) -> Result<(), Problem> {
    if !writes_to_stdout(&args.report) {
        print_flattening(report);
    }
    warn_of_charts(layout);
    if let Some(notice) = &layout.notice {
        eprintln!("note: {notice}");
    }
    write(&args.output, uv)?;
    write_json(&args.report, report)
}

fn print_flattening(report: &FlattenReport) {
    let totals = &report.totals;
    let charts = report.charts.iter().flatten().count();
    say!(
        "{} {} by {}: angle distortion {:.4}, area distortion {:.4}, {} flipped triangles, {} overlaps",
        charts,
        if charts == 1 { "chart" } else { "charts" },
        report.method,
        totals.angle_distortion,
        totals.area_distortion,
        totals.flipped,
        totals.overlaps.max(report.validity.overlapping_pairs)
    );
    if let Some(split) = &report.split {
        say!(
            "  {} charts more, because charts overlapped themselves: cuts of {:.4} √A",
            split.charts_added,
            split.length
        );
    }
    if let Some(made) = &report.conformal {
        say!(
            "  conformal equivalence: {} steps, angles to {:.1e}, {} triangles mended by {} points",
            made.newton_steps,
            made.angle_error,
            made.flipped_before,
            made.points_inserted
        );
    }
    if let Some(refined) = &report.refined {
        say!(
            "  evened out in {} steps: stretch {:.5} → {:.5}, seams equal to {:.1e}",
            refined.steps,
            refined.before,
            refined.after,
            refined.seam_difference
        );
    }
}

/// Names the pieces that something is wrong with.
fn warn_of_charts(layout: &Layout) {
    for (patch, note) in layout.notes() {
        eprintln!("warning: piece {}: {note}", patch + 1);
    }
}

/// Opens a file or a sample, repaired if that is asked for.
fn open(args: &MeshArgs) -> Result<Document, Problem> {
    let document = load(&args.mesh)?;
    if args.repair { document.repaired() } else { Ok(document) }
}

fn load(mesh: &str) -> Result<Document, Problem> {
    match mesh.strip_prefix("sample:") {
        Some(name) => Document::from_sample(name),
        None => Document::from_bytes(mesh, &read(Path::new(mesh))?),
    }
}

/// The first error among the events.
fn tell(events: Vec<Event>) -> Result<(), Problem> {
    for event in events {
        if let Event::Error { what, place, what_to_do, .. } = event {
            return Err(Problem { what, place, what_to_do });
        }
    }
    Ok(())
}

/// The driver keeps the time; the engine reads no clock.
#[expect(clippy::disallowed_methods, reason = "the command is the driver")]
fn clock() -> Instant {
    Instant::now()
}

fn writes_to_stdout(report: &Report) -> bool {
    report.json.as_deref() == Some(Path::new("-"))
}

fn write_json<T: serde::Serialize>(report: &Report, value: &T) -> Result<(), Problem> {
    let Some(path) = &report.json else { return Ok(()) };
    let text = serde_json::to_string_pretty(value).map_err(|error| {
        Problem::new(
            format!("The report could not be written: {error}."),
            path.display().to_string(),
            "Run again.",
        )
    })?;
    if writes_to_stdout(report) {
        say!("{text}");
        return Ok(());
    }
    write(path, text.as_bytes())
}

/// Files that this run has read or written: none of them is written over.
static TOUCHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Remembers a file. **Gives** whether it was remembered before.
fn touch(path: &Path) -> bool {
    let Ok(path) = path.canonicalize() else { return false };
    let mut touched = TOUCHED.lock().unwrap_or_else(PoisonError::into_inner);
    let is_known = touched.contains(&path);
    if !is_known {
        touched.push(path);
    }
    is_known
}

#[expect(clippy::disallowed_methods, reason = "the command is where files are opened")]
fn read(path: &Path) -> Result<Vec<u8>, Problem> {
    let bytes = std::fs::read(path).map_err(|error| {
        Problem::new(
            format!("The file could not be read: {error}."),
            path.display().to_string(),
            "Check the path and its permissions.",
        )
    })?;
    touch(path);
    Ok(bytes)
}

#[expect(clippy::disallowed_methods, reason = "the command is where files are written")]
fn write(path: &Path, bytes: &[u8]) -> Result<(), Problem> {
    if touch(path) {
        return Err(Problem::new(
            "This file is another one of the same command: it would be lost.",
            path.display().to_string(),
            "Write to another place.",
        ));
    }
    std::fs::write(path, bytes).map_err(|error| unwritable(path, &error))?;
    touch(path);
    Ok(())
}

fn make_folder(path: &Path) -> Result<(), Problem> {
    std::fs::create_dir_all(path).map_err(|error| unwritable(path, &error))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Problem {
    Problem::new(
        format!("The file could not be written: {error}."),
        path.display().to_string(),
        "Check that the folder exists and may be written to.",
    )
}
