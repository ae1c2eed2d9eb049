//! `cutflow pattern` and `cutflow run`: real-size patterns and all other files, from a mesh, a cut or a project.

use std::path::{Path, PathBuf};

use clap::Args;
use cutflow::session::{Command, PatternReport, Problem, Session, Value, settings_for};

use super::cut::{assignment, typed};
use super::{
    MeshArgs, Report, cones, make_folder, open, read, tell, warn_of_charts, write, write_cut,
    write_json, writes_to_stdout,
};

/// What each ending stands for.
const FILES: [(&str, &str); 8] = [
    ("svg", "Pattern (SVG)"),
    ("dxf", "Pattern (DXF)"),
    ("pdf", "Pattern (PDF)"),
    ("glb", "UV mesh (GLB)"),
    ("obj", "UV mesh (OBJ)"),
    ("ply", "Cut surface (PLY)"),
    ("png", "Surface picture (PNG)"),
    ("zip", "All files (ZIP)"),
];

#[derive(Args)]
pub struct PatternArgs {
    /// The mesh, or `sample:NAME`, or a project that was saved before.
    #[command(flatten)]
    mesh: MeshArgs,
    /// A cut.json that another command wrote: its pieces are flattened anew, and divided where their charts would overlap; `uv` for the UV
    /// seams of the mesh. Without it the cut flow runs.
    #[arg(long, value_name = "FILE")]
    cut: Option<PathBuf>,
    /// A cones.json that `cutflow cones` wrote: seams join these cones.
    #[arg(long, value_name = "FILE", conflicts_with = "cut")]
    cones: Option<PathBuf>,
    /// Longest side of the model, such as 300mm, 30cm, 0.3m or 12in.
    #[arg(long, value_name = "LENGTH")]
    size: Option<String>,
    /// Seam allowance, such as 10mm.
    #[arg(long, value_name = "LENGTH")]
    allowance: Option<String>,
    /// What a trade usually asks for: plain, plush, garment, upholstery, leather, paper or sheet_metal. Other options change it.
    #[arg(long)]
    trade: Option<String>,
    /// Any other parameter by its identifier; `--set help` lists them all.
    #[arg(long = "set", value_name = "ID=VALUE", allow_hyphen_values = true)]
    values: Vec<String>,
    /// Steps of nesting after the first layout; each takes a few hundredths of a second. The page makes them with Improve layout.
    #[arg(long, value_name = "N", default_value_t = 0)]
    nest: usize,
    /// What to write, by its ending: .svg .dxf .pdf (pattern), .glb .obj .ply (surface with UV map), .png (picture of the
    /// surface with its pieces, from two sides), .zip (all). May be given several
    /// times.
    #[arg(short, long, value_name = "OUT", required = true)]
    output: Vec<PathBuf>,
    #[command(flatten)]
    report: Report,
}

impl PatternArgs {
    /// Where files go.
    pub fn outputs(&self) -> (&[PathBuf], &Report) {
        (&self.output, &self.report)
    }
}

#[derive(Args)]
pub struct RunArgs {
    /// The project.
    project: PathBuf,
    /// Folder for cut.json, uv.obj, cut.obj, pattern.svg, the report and the project as it then is.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    report: Report,
}

impl RunArgs {
    /// The folder that is made for results, and where the report goes.
    pub fn outputs(&self) -> (Option<&Path>, &Report) {
        (self.output.as_deref(), &self.report)
    }
}

/// A length with its unit, in millimetres.
fn length(text: &str, option: &str) -> Result<f64, Problem> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[digits.len()..] {
        "mm" | "" => Some(1.0),
        "cm" => Some(10.0),
        "m" => Some(1000.0),
        "in" | "inch" => Some(25.4),
        _ => None,
    };
    match (digits.trim().parse::<f64>(), unit) {
        (Ok(number), Some(mm)) if (number * mm).is_finite() => Ok(number * mm),
        _ => Err(Problem::new(
            format!("“{text}” is no length."),
            format!("{option}."),
            "Write a number with mm, cm, m or in, such as 300mm.",
        )),
    }
}

fn set(session: &mut Session, id: &str, value: Value) -> Result<(), Problem> {
    tell(session.handle(Command::SetParameter { id: id.into(), value }))
}

/// Does whatever there is to do.
fn finish(session: &mut Session) -> Result<(), Problem> {
    while session.is_running() {
        tell(session.advance(&mut || true))?;
    }
    Ok(())
}

/// The session with the cut that a pattern is to be made of.
fn with_cut(args: &PatternArgs, is_quiet: bool) -> Result<Session, Problem> {
    let path = Path::new(&args.mesh.mesh);
    let is_json = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
    let mut session = Session::new();
    if is_json {
        if args.cut.is_some() || args.cones.is_some() {
            return Err(Problem::new(
                "A project has a cut of its own.",
                "--cut and --cones.",
                "Give the mesh instead of the project, or leave out the cut.",
            ));
        }
        tell(session.open(&args.mesh.mesh, &read(path)?))?;
        finish(&mut session)?;
        return Ok(session);
    }
    let document = open(&args.mesh)?;
    if let Some(cones) = &args.cones {
        return cones::with_cones(document, cones, &[]);
    }
    let settings = settings_for(&document);
    tell(session.open_with(Ok(document), settings))?;
    if args.cut.as_deref() == Some(Path::new("uv")) {
        session.lay_out_uv_seams()?;
        return Ok(session);
    }
    if let Some(cut) = &args.cut {
        session.lay_out_cut(&cut.display().to_string(), &read(cut)?)?;
        return Ok(session);
    }
    if !is_quiet {
        say!("no cut given: the cut flow runs from its start");
    }
    tell(session.handle(Command::Run))?;
    finish(&mut session)?;
    Ok(session)
}

pub fn pattern(args: &PatternArgs) -> Result<(), Problem> {
    let kinds = args.output.iter().map(|path| {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let known = FILES.iter().find(|(known, _)| *known == ending);
        known.map(|(_, kind)| (path, *kind)).ok_or_else(|| {
            Problem::new(
                "The format of the output is not known.",
                path.display().to_string(),
                format!(
                    "Choose a name that ends in {}.",
                    FILES.map(|(e, _)| format!(".{e}")).join(", ")
                ),
            )
        })
    });
    let kinds: Vec<(&PathBuf, &str)> = kinds.collect::<Result<_, _>>()?;
    let size = args.size.as_deref().map(|text| length(text, "--size")).transpose()?;
    let allowance =
        args.allowance.as_deref().map(|text| length(text, "--allowance")).transpose()?;
    let is_quiet = writes_to_stdout(&args.report);
    let mut session = with_cut(args, is_quiet)?;
    if let Some(id) = &args.trade {
        tell(session.handle(Command::ApplyTrade { id: id.clone() }))?;
    }
    for (id, value) in [("size", size), ("allowance", allowance)] {
        if let Some(value) = value {
            set(&mut session, id, Value::Number(value))?;
        }
    }
    for text in &args.values {
        let (id, value) = assignment(text, "--set")?;
        set(&mut session, id, typed(id, value)?)?;
    }
    finish(&mut session)?;
    let mut left = args.nest;
    while left > 0 {
        tell(session.handle(Command::Nest))?;
        // Nothing can be shorter.
        if !session.is_running() {
            break;
        }
        while session.is_running() && left > 0 {
            tell(session.advance(&mut || {
                left -= 1;
                left > 0
            }))?;
        }
        tell(session.handle(Command::Pause))?;
    }
    let report = session.pattern_report()?;
    if !is_quiet {
        tell_pattern(&report);
    }
    for notice in &report.notices {
        eprintln!("note: {notice}");
    }
    warn_of_charts(session.layout()?);
    for (path, kind) in kinds {
        write(path, &session.export(kind)?.bytes)?;
    }
    write_json(&args.report, &report)
}

fn tell_pattern(report: &PatternReport) {
    let [width, height] = report.sheet_mm;
    say!(
        "pieces: {}, seams: {}, drawing of {width:.0} × {height:.0} mm, {:.0} % of the material used",
        report.pieces.len(),
        report.seams.len(),
        100.0 * report.utilisation
    );
    for piece in &report.pieces {
        let [width, height] = piece.size_mm;
        say!("  {}  {width:.0} × {height:.0} mm  {}", piece.name, piece.hint);
    }
}

pub fn run(args: &RunArgs) -> Result<(), Problem> {
    let mut session = Session::new();
    tell(session.open(&args.project.display().to_string(), &read(&args.project)?))?;
    finish(&mut session)?;
    let whole = session.export("Report (JSON)")?.bytes;
    if let Some(folder) = &args.output {
        make_folder(folder)?;
        write_cut(&mut session, folder)?;
        write(&folder.join("report.json"), &whole)?;
        write(&folder.join("project.json"), &session.export("Project (JSON)")?.bytes)?;
    }
    match &args.report.json {
        None => {
            let layout = session.layout()?;
            say!("{} pieces", layout.opened.patch_count);
            warn_of_charts(layout);
            Ok(())
        }
        Some(_) if writes_to_stdout(&args.report) => {
            say!("{}", String::from_utf8_lossy(&whole));
            Ok(())
        }
        Some(path) => write(path, &whole),
    }
}
