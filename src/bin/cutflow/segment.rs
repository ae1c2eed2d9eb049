//! `cutflow phasefield` and `cutflow develop`: segmentations from a terminal.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cutflow::session::{
    Command, DevelopReport, DevelopSeconds, Document, Event, Method, PhaseFieldReport, Problem,
    Session, Settings, Value, settings_for,
};

use super::cut::{bring_layers, keep_symmetries, set_others};
use super::{
    MeshArgs, Report, clock, make_folder, open, print_flattening, tell, warn_of_charts, write,
    write_cut, write_json, writes_to_stdout,
};

/// Steps between two lines of progress.
const SHOWN_EVERY: usize = 100;

#[derive(Clone, Copy, ValueEnum)]
enum PhaseStart {
    /// Along the axes of inertia.
    Axes,
    /// Random.
    Random,
    /// By normals.
    Normals,
    /// From regions that `--paint region=FILE` brings.
    Painted,
}

#[derive(Args)]
pub struct PhaseFieldArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// How often segments are divided, from 1 to 5: into 2, 4, 8, 16 or 32.
    #[arg(long, value_name = "K")]
    levels: Option<f64>,
    /// Width of the interface, on the surface scaled to area 4π. It has to span two edges.
    #[arg(long, value_name = "E")]
    epsilon: Option<f64>,
    /// What distortion costs against length.
    #[arg(long, value_name = "W")]
    omega: Option<f64>,
    /// What unconnected parts cost: ε to the power −κ.
    #[arg(long, value_name = "KAPPA")]
    kappa: Option<f64>,
    /// Draws parts of a segment that fell apart together, which is what happens without this option too.
    #[arg(long, conflicts_with = "unconnected")]
    connected: bool,
    /// Leaves parts of a segment where they are.
    #[arg(long)]
    unconnected: bool,
    /// How much of a segment's area its first part gets, per cent.
    #[arg(long, value_name = "PERCENT")]
    fraction: Option<f64>,
    /// What the first division starts from.
    #[arg(long, value_enum)]
    start: Option<PhaseStart>,
    /// Runs for each division; the best is kept.
    #[arg(long, value_name = "N")]
    starts: Option<f64>,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, ValueEnum)]
enum Measure {
    /// Change of area triangle by triangle.
    Absolute,
    /// Change of area of the piece as a whole, as in the paper.
    Total,
}

#[derive(Clone, Copy, ValueEnum)]
enum Strategy {
    /// Least change of area for the longest seam first, until nothing more fits.
    Best,
    /// Smallest area first, one pass, as in the paper.
    Paper,
}

#[derive(Args)]
pub struct DevelopArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// How far normals of a first piece may be from their mean: squared difference times area, as a fraction of the surface.
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    /// What merged pieces are tested by.
    #[arg(long, value_enum)]
    measure: Option<Measure>,
    /// Pieces are not merged where their area would change by more, per cent.
    #[arg(long, value_name = "PERCENT")]
    area: Option<f64>,
    /// Nor where they would be stretched by more (raw L²).
    #[arg(long, value_name = "L2")]
    stretch: Option<f64>,
    /// Darts that one piece may get at a time.
    #[arg(long, value_name = "N")]
    darts: Option<f64>,
    /// The order of merging.
    #[arg(long, value_enum)]
    strategy: Option<Strategy>,
    /// Smooths the borders of first pieces for merging.
    #[arg(long)]
    denoise: bool,
    /// Leaves the borders of first pieces as they are.
    #[arg(long)]
    no_min_cut: bool,
    /// Merges pieces in both images of one symmetry or in neither: mirror-1, axis2-1 … as `--symmetry list` names them.
    #[arg(long, value_name = "ID")]
    symmetry: Option<String>,
    #[command(flatten)]
    common: Common,
}

impl PhaseFieldArgs {
    /// The folder that is made for results, and where the report goes.
    pub fn outputs(&self) -> (Option<&Path>, &Report) {
        (self.common.output.as_deref(), &self.common.report)
    }
}

impl DevelopArgs {
    /// The folder that is made for results, and where the report goes.
    pub fn outputs(&self) -> (Option<&Path>, &Report) {
        (self.common.output.as_deref(), &self.common.report)
    }
}

/// What both take.
#[derive(Args)]
struct Common {
    /// A layer of one number from 0 to 1 for each vertex of the file, or of labels: region, penalty, seam_paint (seams that stay) or drawn_seam (seams that are made).
    #[arg(long, value_name = "LAYER=FILE")]
    paint: Vec<String>,
    /// Any other parameter by its identifier; `--set help` lists them all.
    #[arg(long = "set", value_name = "ID=VALUE", allow_hyphen_values = true)]
    values: Vec<String>,
    /// Longest side of the model in the pattern.
    #[arg(long, value_name = "MM", conflicts_with = "unit")]
    size_mm: Option<f64>,
    /// What one unit of the file is: mm, cm, m or in.
    #[arg(long)]
    unit: Option<String>,
    /// Folder for cut.json, uv.obj, cut.obj and pattern.svg, of developable patches also pattern.dxf and pattern.pdf.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    report: Report,
}

/// Parameters of a document, with those that options ask for.
fn settings(
    document: &Document,
    method: Method,
    options: &[(&str, Option<Value>)],
    common: &Common,
) -> Result<Settings, Problem> {
    let mut settings = settings_for(document);
    let mut given = Vec::new();
    for (id, value) in options {
        if let Some(value) = value {
            settings.set(id, value.clone())?;
            given.push(*id);
        }
    }
    if let Some(size) = common.size_mm {
        settings.set("size", Value::Number(size))?;
    }
    set_others(&mut settings, &common.values, method, given)?;
    Ok(settings)
}

/// Opens a mesh for a method, with everything that belongs to the surface.
fn begin(
    method: Method,
    mesh: &MeshArgs,
    options: &[(&str, Option<Value>)],
    common: &Common,
) -> Result<Session, Problem> {
    let document = open(mesh)?;
    document.surface()?;
    let mut settings = settings(&document, method, options, common)?;
    if let Some(folder) = &common.output {
        make_folder(folder)?;
    }
    let is_brought = common.paint.iter().any(|text| text.starts_with("region="));
    if method == Method::PhaseField && settings.text("phase_start") == "painted" {
        if !is_brought {
            return Err(Problem::new(
                "Nothing to start from: there are no regions.",
                "Start of the divisions.",
                "Bring a label for each vertex by --paint region=FILE, or choose another start.",
            ));
        }
        // Bringing regions chooses this start.
        settings.set("phase_start", Value::Text("axes".into()))?;
    }
    let mut session = Session::new();
    tell(session.handle(Command::SetMethod { id: method.id().into() }))?;
    tell(session.open_with(Ok(document), settings))?;
    if let Some(unit) = &common.unit {
        tell(session.handle(Command::SetUnit { id: unit.clone() }))?;
    }
    bring_layers(&mut session, &common.paint, &[])?;
    Ok(session)
}

/// What follows the run: files and warnings.
fn end(session: &mut Session, common: &Common) -> Result<(), Problem> {
    warn_of_charts(session.layout()?);
    match &common.output {
        Some(folder) => write_cut(session, folder),
        None => Ok(()),
    }
}

fn number(value: Option<f64>) -> Option<Value> {
    value.map(Value::Number)
}

fn text(value: Option<&str>) -> Option<Value> {
    value.map(|text| Value::Text(text.into()))
}

pub fn phasefield(args: &PhaseFieldArgs) -> Result<(), Problem> {
    let start = args.start.map(|start| match start {
        PhaseStart::Axes => "axes",
        PhaseStart::Random => "random",
        PhaseStart::Normals => "normals",
        PhaseStart::Painted => "painted",
    });
    let options = [
        ("levels", number(args.levels)),
        ("epsilon", number(args.epsilon)),
        ("omega", number(args.omega)),
        ("kappa", number(args.kappa)),
        ("connected", (args.connected || args.unconnected).then_some(Value::Truth(args.connected))),
        ("fraction", number(args.fraction)),
        ("phase_start", text(start)),
        ("starts", number(args.starts)),
    ];
    let mut session = begin(Method::PhaseField, &args.mesh, &options, &args.common)?;
    let is_quiet = writes_to_stdout(&args.common.report);
    let clock = clock();
    tell(session.handle(Command::Run))?;
    let mut steps = 0;
    while session.is_running() {
        let events = session.advance(&mut || {
            steps += 1;
            steps % SHOWN_EVERY != 0
        });
        let status = events.iter().rev().find_map(|event| match event {
            Event::Status { text, .. } => Some(text.clone()),
            _ => None,
        });
        tell(events)?;
        if let (false, Some(text)) = (is_quiet, status) {
            eprintln!("{text}");
        }
    }
    let seconds = clock.elapsed().as_secs_f64();
    let report = session.phase_report(Some(seconds))?;
    if !is_quiet {
        print_phase(&report);
    }
    end(&mut session, &args.common)?;
    write_json(&args.common.report, &report)
}

fn print_phase(report: &PhaseFieldReport) {
    say!(
        "{} after {} steps: {} segments, interface {:.4} √A, diffuse distortion J {:.5}",
        report.status,
        report.steps,
        report.segments.iter().filter(|segment| segment.is_leaf).count(),
        report.perimeter,
        report.yamabe,
    );
    let mut segments: Vec<_> = report.segments.iter().collect();
    // As a tree: every segment before its parts.
    segments.sort_by_key(
        |segment| if segment.level == 0 { String::new() } else { segment.label.clone() },
    );
    for segment in segments {
        let indent = 2 * segment.level + 2;
        let divided =
            segment.length.map_or(String::new(), |x| format!(", divided along {x:.4} √A"));
        say!(
            "{:indent$}{:8} {:5.1} % of the area, {} connected {}{divided}",
            "",
            segment.label,
            100.0 * segment.area_fraction,
            segment.components,
            if segment.components == 1 { "part" } else { "parts" },
        );
    }
    print_flattening(&report.flattening);
    for notice in &report.notices {
        eprintln!("note: {}", notice.text);
    }
}

pub fn develop(args: &DevelopArgs) -> Result<(), Problem> {
    let measure = args.measure.map(|measure| match measure {
        Measure::Absolute => "absolute",
        Measure::Total => "total",
    });
    let strategy = args.strategy.map(|strategy| match strategy {
        Strategy::Best => "best",
        Strategy::Paper => "paper",
    });
    let options = [
        ("vsa_tolerance", number(args.tolerance)),
        ("merge_measure", text(measure)),
        ("area_limit", number(args.area)),
        ("stretch_limit", number(args.stretch)),
        ("darts", number(args.darts)),
        ("merge_strategy", text(strategy)),
        ("denoise", args.denoise.then_some(Value::Truth(true))),
        ("min_cut", args.no_min_cut.then_some(Value::Truth(false))),
    ];
    let mut session = begin(Method::Developable, &args.mesh, &options, &args.common)?;
    let symmetry: Vec<String> = args.symmetry.iter().cloned().collect();
    keep_symmetries(&mut session, &symmetry)?;
    if symmetry == ["list"] {
        return Ok(());
    }
    let is_quiet = writes_to_stdout(&args.common.report);
    tell(session.handle(Command::Run))?;
    let mut seconds = DevelopSeconds::default();
    let mut clock = clock();
    while session.is_running() {
        let stage = session.develop_stage();
        // One stage at a time, each with a time of its own.
        tell(session.advance(&mut || false))?;
        seconds.add(stage, clock.elapsed().as_secs_f64());
        clock = super::clock();
    }
    let report = session.develop_report(Some(seconds))?;
    if !is_quiet {
        print_patches(&report);
    }
    end(&mut session, &args.common)?;
    write_json(&args.common.report, &report)?;
    if let Some(folder) = &args.common.output {
        // The command `pattern` flattens a cut anew: only here do pieces leave with the maps that they were accepted with.
        for (kind, name) in [("Pattern (DXF)", "pattern.dxf"), ("Pattern (PDF)", "pattern.pdf")] {
            write(&folder.join(name), &session.export(kind)?.bytes)?;
        }
    }
    Ok(())
}

fn print_patches(report: &DevelopReport) {
    say!(
        "{} after {} steps: {} first pieces merged to {}, seam {:.4}, darts {:.4}",
        report.status,
        report.steps,
        report.vsa_charts,
        report.patches.len(),
        report.seam_length,
        report.dart_length,
    );
    for (i, patch) in report.patches.iter().enumerate() {
        say!(
            "  piece {:3}: {:6} triangles, area change {:6.2} % in total, {:6.2} % anywhere, L² {:.4}",
            i + 1,
            patch.faces,
            100.0 * patch.area_change,
            100.0 * patch.area_change_abs,
            patch.l2_stretch,
        );
    }
    print_flattening(&report.flattening);
    for notice in &report.notices {
        eprintln!("note: {}", notice.text);
    }
}
