//! `cutflow cut`: the cut flow from a terminal.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cutflow::session::{
    Brought, Command, Document, FoldReport, Method, ParamKind, Problem, Session, Settings, Value,
    all_specs, settings_for, specs_of,
};

use super::{
    MeshArgs, Report, clock, make_folder, open, print_flattening, read, tell, warn_of_charts,
    write, write_cut, write_json, writes_to_stdout,
};

/// Initial cuts with a name; anything else is a file.
const INITS: [&str; 11] = [
    "plane",
    "circle",
    "normals",
    "curvature",
    "random",
    "seeds",
    "painted",
    "uv",
    "groups",
    "materials",
    "volleyball",
];

#[derive(Clone, Copy, ValueEnum)]
enum EnergyKind {
    /// Change of stretching, ∫|∇u|².
    Dirichlet,
    /// The same times the cube of the local feature size.
    Rescaled,
    /// Amount of stretching, ∫u².
    Hencky,
}

#[derive(Args)]
pub struct CutArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// Settings for a purpose: ball, upholstery, plush, bandage, vase, heat or atlas. Other options change them.
    #[arg(long)]
    preset: Option<String>,
    /// The initial cut: plane, circle, normals, curvature, random, seeds, painted, uv, groups, materials, volleyball, or a cut.json.
    #[arg(long)]
    init: Option<String>,
    /// The distortion to lower: Hencky if not given.
    #[arg(long, value_enum)]
    energy: Option<EnergyKind>,
    /// Its weight: 10 for Dirichlet, 1000 for rescaled, 3000 for Hencky if not given.
    #[arg(long, value_name = "W")]
    weight: Option<f64>,
    /// Weight α of the cut's length, for unit area: 2 if not given.
    #[arg(long, value_name = "A")]
    length: Option<f64>,
    /// Number of labels of normal clusters, curvature bands and random cells.
    #[arg(long, value_name = "N")]
    regions: Option<f64>,
    /// Largest angle within a normal cluster, degrees.
    #[arg(long, value_name = "DEG")]
    angle: Option<f64>,
    /// Axis that the plane is perpendicular to: x, y or z.
    #[arg(long)]
    axis: Option<String>,
    /// Where the plane cuts its axis, percent from the middle.
    #[arg(long, value_name = "PERCENT")]
    offset: Option<f64>,
    /// Centre vertex of the circle, counted from 0.
    #[arg(long)]
    vertex: Option<f64>,
    /// Radius of the circle; 1 is the side of a square of the surface's area.
    #[arg(long)]
    radius: Option<f64>,
    /// Vertices that are the seeds of `--init seeds`, counted from 0.
    #[arg(long, value_name = "VERTEX", value_delimiter = ',')]
    seeds: Vec<f64>,
    /// Distortion counts in the first region only: a bandage.
    #[arg(long)]
    one_sided: bool,
    /// Reward of the first region's area.
    #[arg(long, value_name = "W")]
    area: Option<f64>,
    /// A layer of one number for each vertex of the file, separated by white space: region (labels), penalty, heat or pin
    /// (from 0 to 1).
    #[arg(long, value_name = "LAYER=FILE")]
    paint: Vec<String>,
    /// Makes cuts dear where they are seen from this place, in units of the file.
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true)]
    hide_from: Vec<f64>,
    /// Keeps the cut symmetric: `all`, or mirror-1, axis3-1 … as `--symmetry list` names them.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    symmetry: Vec<String>,
    /// Any other parameter by its identifier; `--set help` lists them all.
    #[arg(long = "set", value_name = "ID=VALUE", allow_hyphen_values = true)]
    values: Vec<String>,
    /// Steps at most; 0 evaluates the initial cut. 100 if not given.
    #[arg(long)]
    steps: Option<usize>,
    /// Largest move of the cut in a step, mean edge lengths.
    #[arg(long)]
    cap: Option<f64>,
    /// The run has converged when ten steps lower the energy by less than this fraction.
    #[arg(long, default_value_t = 1e-5)]
    tolerance: f64,
    /// Initial disturbance, mean edge lengths.
    #[arg(long)]
    kick: Option<f64>,
    /// Seed of the disturbance and of random cells.
    #[arg(long)]
    seed: Option<f64>,
    /// Longest side of the model in the pattern.
    #[arg(long, value_name = "MM", conflicts_with = "unit")]
    size_mm: Option<f64>,
    /// What one unit of the file is: mm, cm, m or in.
    #[arg(long)]
    unit: Option<String>,
    /// Rebuilds the surface from the flat pieces and reports how far it lies from the original; with -o also folded.obj.
    #[arg(long)]
    fold: bool,
    /// Folder for cut.json, uv.obj, cut.obj and pattern.svg.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    report: Report,
}

/// The parameters that the options ask for.
fn settings(args: &CutArgs, document: &Document) -> Result<Settings, Problem> {
    // A sample's own initial cut gives way to what the options say, its size does not.
    let mut settings = settings_for(document);
    if let Some(preset) = &args.preset {
        settings = settings.with_preset(preset)?;
    } else {
        settings.set("init", Value::Text("normals".into()))?;
    }
    if args.energy.is_some() || args.preset.is_none() {
        let energy = args.energy.unwrap_or(EnergyKind::Hencky);
        let (dirichlet, hencky) = match energy {
            EnergyKind::Dirichlet => (args.weight.unwrap_or(10.0), 0.0),
            EnergyKind::Rescaled => (args.weight.unwrap_or(1000.0), 0.0),
            EnergyKind::Hencky => (0.0, args.weight.unwrap_or(3000.0)),
        };
        settings.set("dirichlet", Value::Number(dirichlet))?;
        settings.set("hencky", Value::Number(hencky))?;
        settings.set("rescaled", Value::Truth(matches!(energy, EnergyKind::Rescaled)))?;
    }
    if let Some(init) = &args.init {
        let named = if INITS.contains(&init.as_str()) { init } else { "file" };
        settings.set("init", Value::Text(named.into()))?;
    }
    if let Some(axis) = &args.axis {
        settings.set("axis", Value::Text(axis.clone()))?;
    }
    if args.one_sided {
        settings.set("one_sided", Value::Truth(true))?;
    }
    if args.weight.is_some() && args.energy.is_none() && args.preset.is_some() {
        return Err(Problem::new(
            "A weight was given, and not of which distortion.",
            "--weight beside --preset.",
            "Add --energy, or set dirichlet or hencky by --set.",
        ));
    }
    // 0 steps are none at all: the loop below does not begin.
    let steps = Value::Number(args.steps.unwrap_or(100).max(1) as f64);
    settings.set("steps", steps)?;
    settings.set("tolerance", Value::Number(args.tolerance))?;
    let mut given = Vec::new();
    if args.axis.is_some() {
        given.push("axis");
    }
    for (id, value) in [
        ("length", args.length),
        ("regions", args.regions),
        ("angle", args.angle),
        ("offset", args.offset),
        ("vertex", args.vertex),
        ("radius", args.radius),
        ("area", args.area),
        ("cap", args.cap),
        ("kick", args.kick),
        ("seed", args.seed),
        ("size", args.size_mm),
    ] {
        if let Some(value) = value {
            settings.set(id, Value::Number(value))?;
            given.push(id);
        }
    }
    set_others(&mut settings, &args.values, Method::CutFlow, given)?;
    if !args.seeds.is_empty() && settings.text("init") != "seeds" {
        return Err(Problem::new(
            "Seeds were given, and another initial cut.",
            "--seeds.",
            "Add --init seeds, or leave the seeds out.",
        ));
    }
    Ok(settings)
}

/// What `--set` says; then whether everything that was given has a say.
pub fn set_others<'a>(
    settings: &mut Settings,
    values: &'a [String],
    method: Method,
    mut given: Vec<&'a str>,
) -> Result<(), Problem> {
    for text in values {
        let (id, value) = assignment(text, "--set")?;
        settings.set(id, typed(id, value)?)?;
        given.push(id);
    }
    given.iter().try_for_each(|id| settings.check_effect(method, id))
}

/// NAME=TEXT in two parts.
pub fn assignment<'a>(text: &'a str, option: &str) -> Result<(&'a str, &'a str), Problem> {
    text.split_once('=').ok_or_else(|| {
        Problem::new(
            format!("{text} sets nothing."),
            format!("{option}."),
            "Write a name, an equals sign and a value.",
        )
    })
}

/// A value as the parameter takes it.
pub fn typed(id: &str, text: &str) -> Result<Value, Problem> {
    let spec = all_specs().into_iter().find(|spec| spec.id == id);
    let wrong = || {
        Problem::new(
            format!("{text} is no value of {id}."),
            "--set.",
            "Write a number for numbers, true or false for switches, a name for choices.",
        )
    };
    Ok(match spec.map(|spec| spec.kind) {
        Some(ParamKind::Number { .. }) => Value::Number(text.parse().map_err(|_| wrong())?),
        Some(ParamKind::Switch) => Value::Truth(text.parse().map_err(|_| wrong())?),
        // Unknown parameters are refused by the settings, with the list of those that exist.
        Some(ParamKind::Choice { .. }) | None => Value::Text(text.into()),
    })
}

/// What `--set help` prints.
pub fn list_parameters(method: Method) {
    for spec in specs_of(method) {
        let range = match &spec.kind {
            ParamKind::Number { min, max, .. } => format!("{min} to {max} {}", spec.unit),
            ParamKind::Switch => "true or false".into(),
            ParamKind::Choice { options } => {
                options.iter().map(|o| o.id.as_str()).collect::<Vec<_>>().join(", ")
            }
        };
        say!("{}  ({})\n    {}: {}", spec.id, range.trim(), spec.label, spec.help);
    }
}

/// Numbers of a file, separated by white space.
fn numbers(path: &Path) -> Result<Vec<f64>, Problem> {
    let bytes = read(path)?;
    String::from_utf8_lossy(&bytes)
        .split_whitespace()
        .map(|word| {
            word.parse().map_err(|_| {
                Problem::new(
                    format!("“{word}” is no number."),
                    path.display().to_string(),
                    "Write one number for each vertex of the mesh.",
                )
            })
        })
        .collect()
}

/// Painted layers, and a place to hide from.
pub fn bring_layers(
    session: &mut Session,
    paint: &[String],
    hide_from: &[f64],
) -> Result<(), Problem> {
    for text in paint {
        let (channel, path) = assignment(text, "--paint")?;
        let values = numbers(Path::new(path))?;
        tell(session.bring(Brought::Layer { channel, values: &values }))?;
    }
    match *hide_from {
        [] => Ok(()),
        [x, y, z] => tell(session.bring(Brought::Eye([x, y, z]))),
        _ => Err(Problem::new(
            "A place has three coordinates.",
            "--hide-from.",
            "Write x,y,z in units of the file.",
        )),
    }
}

/// Everything that belongs to the surface and not to the parameters.
fn bring(session: &mut Session, args: &CutArgs) -> Result<(), Problem> {
    if !args.seeds.is_empty() {
        tell(session.bring(Brought::Seeds(&args.seeds)))?;
    }
    if let Some(init) = args.init.as_deref().filter(|init| !INITS.contains(init)) {
        tell(session.bring(Brought::Cut { name: init, bytes: &read(Path::new(init))? }))?;
    }
    bring_layers(session, &args.paint, &args.hide_from)?;
    keep_symmetries(session, &args.symmetry)
}

/// Keeps what the surface is found to have: `all`, or by identifiers; `list` names them.
pub fn keep_symmetries(session: &mut Session, ids: &[String]) -> Result<(), Problem> {
    if ids.is_empty() {
        return Ok(());
    }
    tell(session.handle(Command::FindSymmetries))?;
    let found = session.symmetry_choices();
    if ids.iter().any(|id| id == "list") {
        for choice in &found {
            say!("{}  {}  deviation {:.2e}", choice.id, choice.label, choice.deviation);
        }
        return Ok(());
    }
    if found.is_empty() {
        eprintln!("note: no symmetry was found");
    }
    let ids = match ids.iter().any(|id| id == "all") {
        true => found.into_iter().map(|choice| choice.id).collect(),
        false => ids.to_vec(),
    };
    tell(session.handle(Command::SetSymmetry { ids }))
}

/// Whether a command line asks for the list of parameters: that needs no mesh, which the parser would insist on.
pub fn asks_for_parameters(words: &[String]) -> Option<Method> {
    let method = match words.first()?.as_str() {
        "cut" | "pattern" => Method::CutFlow,
        "cones" => Method::Cones,
        "phasefield" => Method::PhaseField,
        "develop" => Method::Developable,
        _ => return None,
    };
    let is_asked = words.iter().any(|word| word == "--set=help")
        || words.windows(2).any(|pair| pair == ["--set", "help"]);
    is_asked.then_some(method)
}

/// A start that is neither a name nor a file.
fn unknown_start(init: &str) -> Problem {
    Problem::new(
        format!("There is no start called “{init}”, and no such file."),
        "--init.",
        format!("Choose one of {}; or give the cut.json of another run.", INITS.join(", ")),
    )
}

impl CutArgs {
    /// The folder that is made for results, and where the report goes.
    pub fn outputs(&self) -> (Option<&Path>, &Report) {
        (self.output.as_deref(), &self.report)
    }
}

pub fn run(args: &CutArgs) -> Result<(), Problem> {
    if let Some(init) = &args.init
        && !INITS.contains(&init.as_str())
        && !Path::new(init).exists()
    {
        return Err(unknown_start(init));
    }
    let mut session = Session::new();
    let document = open(&args.mesh)?;
    document.surface()?;
    let settings = settings(args, &document)?;
    tell(session.open_with(Ok(document), settings))?;
    if let Some(unit) = &args.unit {
        tell(session.handle(Command::SetUnit { id: unit.clone() }))?;
    }
    if let Some(folder) = &args.output {
        make_folder(folder)?;
    }
    bring(&mut session, args)?;
    if args.symmetry.iter().any(|id| id == "list") {
        return Ok(());
    }
    let clock = clock();
    let is_quiet = writes_to_stdout(&args.report);
    if args.steps != Some(0) {
        tell(session.handle(Command::Run))?;
    }
    let mut last_shown = 0;
    while session.is_running() {
        let mut slices = 10;
        tell(session.advance(&mut || {
            slices -= 1;
            slices > 0
        }))?;
        if let Some(row) = session.history().last()
            && row.step >= last_shown + 10
            && !is_quiet
        {
            last_shown = row.step;
            say!("step {:4}  J {:10.4}  cut length {:8.4}", row.step, row.total, row.length);
        }
    }
    let seconds = clock.elapsed().as_secs_f64();
    let mut report = session.cut_report(Some(seconds))?;
    if !is_quiet {
        say!(
            "{} after {} steps: {} patches, cut length {:.4}, Dirichlet {:.6}, Hencky {:.8}",
            report.status,
            report.steps,
            report.patches.len(),
            report.cut_length,
            report.dirichlet,
            report.hencky
        );
        print_flattening(&report.flattening);
    }
    for notice in &report.notices {
        eprintln!("note: {}", notice.text);
    }
    warn_of_charts(session.layout()?);
    if let Some(folder) = &args.output {
        write_cut(&mut session, folder)?;
    }
    if args.fold {
        report.fold = Some(fold(&mut session, args, is_quiet)?);
    }
    write_json(&args.report, &report)
}

/// Rebuilds the surface from the flat pieces.
fn fold(session: &mut Session, args: &CutArgs, is_quiet: bool) -> Result<FoldReport, Problem> {
    tell(session.handle(Command::Fold))?;
    while session.is_running() {
        tell(session.advance(&mut || true))?;
    }
    let report = session.fold_report()?;
    if !is_quiet {
        say!(
            "folded in {} steps: {:.4} from the original on average, {:.4} at most, stretch {:.5}",
            report.steps,
            report.distance_mean,
            report.distance_max,
            report.stretch
        );
    }
    if let Some(folder) = &args.output {
        write(&folder.join("folded.obj"), &session.export("Folded surface (OBJ)")?.bytes)?;
    }
    Ok(report)
}
