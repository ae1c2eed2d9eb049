//! `cutflow cones`: optimal cones from a terminal.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cutflow::session::{
    Brought, Command, ConesReport, Document, Event, Method, Problem, Session, Settings, Value,
    settings_for,
};

use super::cut::{assignment, bring_layers, set_others};
use super::{
    MeshArgs, Report, clock, make_folder, open, print_flattening, read, tell, warn_of_charts,
    write, write_cut, write_json, writes_to_stdout,
};

/// λ is for a surface of unit area; the paper's is for another scale.
const PAPERS_SCALE: f64 = 100.0;

#[derive(Clone, Copy, ValueEnum)]
enum Boundary {
    /// True lengths: u = 0.
    Isometric,
    /// Whatever lengths distort least.
    Optimal,
    /// A polygon: angle at its corners costs as cones do.
    Polygonal,
    /// Convex: angle at the boundary is free, but not negative.
    Convex,
    /// A convex polygon.
    PolygonalConvex,
}

#[derive(Args)]
pub struct ConesArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// Price of a radian of cone angle on the surface of unit area: 0.005 if nothing is given. The paper's λ is about 100 times
    /// this one.
    #[arg(long, value_name = "L", allow_hyphen_values = true)]
    lambda: Option<f64>,
    /// The smallest price that leads to at most so many cones.
    #[arg(long, value_name = "N", conflicts_with = "lambda")]
    count: Option<f64>,
    /// Exactly so many cones, where local search finds that they do most.
    #[arg(long, value_name = "N", conflicts_with_all = ["lambda", "count"])]
    exactly: Option<f64>,
    /// The price that leads to this total angle, in units of π.
    #[arg(long, value_name = "PI", conflicts_with_all = ["lambda", "count", "exactly"])]
    total_angle: Option<f64>,
    /// The largest price that leads to at most this ∫u².
    #[arg(long, value_name = "E", conflicts_with_all = ["lambda", "count", "exactly", "total_angle"])]
    distortion: Option<f64>,
    /// Smallest and largest angle of a cone, radians: 0,inf for positive cones only. `pi` may follow a number.
    #[arg(long, value_name = "LO,HI", value_delimiter = ',', allow_hyphen_values = true)]
    bounds: Vec<String>,
    /// What the flattened boundary has to be.
    #[arg(long, value_enum)]
    boundary: Option<Boundary>,
    /// Leaves clusters of the optimum as they are.
    #[arg(long)]
    no_rounding: bool,
    /// Keeps the places of the optimum and chooses their angles anew for least distortion.
    #[arg(long)]
    debias: bool,
    /// Vertices that are cones for free, counted from 0; their angles are found.
    #[arg(long, value_name = "VERTEX", value_delimiter = ',')]
    free: Vec<f64>,
    /// Cones of a given angle, radians.
    #[arg(long, value_name = "VERTEX=ANGLE", value_delimiter = ',', allow_hyphen_values = true)]
    fix: Vec<String>,
    /// A layer of one number from 0 to 1 for each vertex of the file: importance, unimportant, cone_cost, excluded, or
    /// penalty (for seams).
    #[arg(long, value_name = "LAYER=FILE")]
    paint: Vec<String>,
    /// Makes cones and seams dear where they are seen from this place, in units of the file.
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true)]
    hide_from: Vec<f64>,
    /// Any other parameter by its identifier; `--set help` lists them all.
    #[arg(long = "set", value_name = "ID=VALUE", allow_hyphen_values = true)]
    values: Vec<String>,
    /// Solves for the whole range of λ and reports that path.
    #[arg(long)]
    path: bool,
    /// Reports what the greedy strategy makes of as many cones.
    #[arg(long)]
    compare: bool,
    /// Longest side of the model in the pattern.
    #[arg(long, value_name = "MM", conflicts_with = "unit")]
    size_mm: Option<f64>,
    /// What one unit of the file is: mm, cm, m or in.
    #[arg(long)]
    unit: Option<String>,
    /// Folder for cones.json, cut.json, uv.obj, cut.obj and pattern.svg.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    report: Report,
}

/// The parameters that the options ask for.
fn settings(args: &ConesArgs, document: &Document) -> Result<Settings, Problem> {
    let mut settings = settings_for(document);
    let text = |text: &str| Value::Text(text.into());
    if let Some(lambda) = args.lambda {
        settings.set("lambda", Value::Number(lambda)).map_err(|problem| Problem {
            what_to_do: match lambda {
                x if x > 0.2 => format!(
                    "{} Prices are for a surface of unit area: if this is a λ of the paper, try {}.",
                    problem.what_to_do,
                    x / PAPERS_SCALE
                ),
                _ => problem.what_to_do,
            },
            ..problem
        })?;
    }
    for (id, target, value) in [
        ("count", "cone_count", args.count),
        ("exactly", "exact_count", args.exactly),
        ("angle", "angle_target", args.total_angle),
        ("distortion", "distortion_target", args.distortion),
    ] {
        if let Some(value) = value {
            settings.set("choose_by", text(id))?;
            settings.set(target, Value::Number(value))?;
        }
    }
    match &args.bounds[..] {
        [] => {}
        [low, high] => {
            settings.set("bounds", text("custom"))?;
            // From two full turns on a bound bounds nothing.
            let in_pi = |bound: &String| {
                Ok((angle(bound, "--bounds")? / std::f64::consts::PI).clamp(-2.0, 2.0))
            };
            let [low, high] = [in_pi(low)?, in_pi(high)?];
            if low > 0.0 || high < 0.0 {
                return Err(Problem::new(
                    format!("Bounds of {low:.3} π and {high:.3} π allow no vertex to be flat."),
                    "--bounds, in radians or with pi after them.",
                    "Let 0 lie between them, such as 0,inf or -0.5pi,0.5pi.",
                ));
            }
            settings.set("angle_min", Value::Number(low))?;
            settings.set("angle_max", Value::Number(high))?;
        }
        _ => {
            return Err(Problem::new(
                "Bounds are two numbers.",
                "--bounds.",
                "Write the smallest and the largest angle, such as 0,inf or -0.5pi,0.5pi.",
            ));
        }
    }
    if let Some(boundary) = args.boundary {
        let id = match boundary {
            Boundary::Isometric => "isometric",
            Boundary::Optimal => "optimal",
            Boundary::Polygonal => "polygonal",
            Boundary::Convex => "convex",
            Boundary::PolygonalConvex => "polygonal_convex",
        };
        settings.set("boundary", text(id))?;
    }
    settings.set("round", Value::Truth(!args.no_rounding))?;
    settings.set("debias", Value::Truth(args.debias))?;
    if let Some(size) = args.size_mm {
        settings.set("size", Value::Number(size))?;
    }
    let given = if args.lambda.is_some() { vec!["lambda"] } else { Vec::new() };
    set_others(&mut settings, &args.values, Method::Cones, given)?;
    Ok(settings)
}

/// An angle in radians, or in units of π if `pi` follows, which may be divided.
fn angle(text: &str, option: &str) -> Result<f64, Problem> {
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| !x.is_nan());
    let value = match text.trim().split_once("pi") {
        None => number(text.trim()),
        Some((times, over)) => {
            let times = match times {
                "" => Some(1.0),
                "-" => Some(-1.0),
                times => number(times),
            };
            let over = match over.strip_prefix('/') {
                Some(over) => number(over).filter(|x| *x > 0.0),
                None => over.is_empty().then_some(1.0),
            };
            times.zip(over).map(|(times, over)| times * std::f64::consts::PI / over)
        }
    };
    match value {
        Some(value) => Ok(value),
        None => Err(Problem::new(
            format!("“{text}” is no angle."),
            format!("{option}."),
            "Write radians such as 1.57, or units of π such as 0.5pi or pi/2.",
        )),
    }
}

/// Everything that belongs to the surface and not to the parameters.
fn bring(session: &mut Session, args: &ConesArgs) -> Result<(), Problem> {
    bring_layers(session, &args.paint, &args.hide_from)?;
    for &vertex in &args.free {
        tell(session.bring(Brought::Cone { vertex, angle: None }))?;
    }
    for text in &args.fix {
        let (vertex, value) = assignment(text, "--fix")?;
        let vertex = vertex.parse().unwrap_or(f64::NAN);
        let angle = Some(angle(value, "--fix")?);
        tell(session.bring(Brought::Cone { vertex, angle }))?;
    }
    Ok(())
}

impl ConesArgs {
    /// The folder that is made for results, and where the report goes.
    pub fn outputs(&self) -> (Option<&Path>, &Report) {
        (self.output.as_deref(), &self.report)
    }
}

pub fn run(args: &ConesArgs) -> Result<(), Problem> {
    let mut session = Session::new();
    let document = open(&args.mesh)?;
    document.surface()?;
    let settings = settings(args, &document)?;
    tell(session.handle(Command::SetMethod { id: "cones".into() }))?;
    tell(session.open_with(Ok(document), settings))?;
    if let Some(unit) = &args.unit {
        tell(session.handle(Command::SetUnit { id: unit.clone() }))?;
    }
    if let Some(folder) = &args.output {
        make_folder(folder)?;
    }
    bring(&mut session, args)?;
    let clock = clock();
    let is_quiet = writes_to_stdout(&args.report);
    drive(&mut session)?;
    let seconds = clock.elapsed().as_secs_f64();
    if args.path {
        tell(session.handle(Command::TracePath))?;
        drive(&mut session)?;
    }
    if args.compare {
        tell(session.handle(Command::CompareCones))?;
        drive(&mut session)?;
    }
    let mut report = session.cones_report(Some(seconds))?;
    if report.status != PLACED {
        report.lambda_max = session.find_lambda_max()?;
    }
    if !is_quiet {
        print(&report);
    }
    warn_of_charts(session.layout()?);
    if let Some(folder) = &args.output {
        write(&folder.join("cones.json"), &session.export("Cones (JSON)")?.bytes)?;
        write_cut(&mut session, folder)?;
    }
    write_json(&args.report, &report)
}

/// Seconds between two lines of progress.
const SHOWN_EVERY: f64 = 5.0;

/// Does whatever there is to do, and says how far it is where that takes long.
fn drive(session: &mut Session) -> Result<(), Problem> {
    let mut shown = clock();
    while session.is_running() {
        let events = session.advance(&mut || false);
        if let Some(Event::Status { text, .. }) =
            events.iter().rev().find(|event| matches!(event, Event::Status { .. }))
            && shown.elapsed().as_secs_f64() > SHOWN_EVERY
        {
            eprintln!("{text}");
            shown = clock();
        }
        tell(events)?;
    }
    Ok(())
}

/// Status of an exact number of cones: no price led to them.
const PLACED: &str = "placed";

fn print(report: &ConesReport) {
    let effort = format!(
        "{} after {} rounds ({} factorisations, {} solves)",
        report.status, report.rounds, report.factorisations, report.solves
    );
    if report.status == PLACED {
        say!("{effort}");
    } else {
        say!("{effort}: λ {:.6} of {:.6}", report.lambda, report.lambda_max);
        say!(
            "{} cones, total angle {:.6} π, ∫u² {:.9}, residual {:.1e}",
            report.cones.len(),
            report.total_angle_over_pi,
            report.int_u2,
            report.kkt_residual
        );
    }
    let used = &report.rounded;
    say!(
        "used: {} cones, total angle {:.6} π, ∫u² {:.9}, seams {:.4}",
        used.cones.len(),
        used.total_angle_over_pi,
        used.int_u2,
        report.cut_length
    );
    if let Some(note) = &report.note {
        say!("note: {note}");
    }
    for point in &report.path {
        say!(
            "λ {:.6} {:5} cones  Φ {:8.4} π  ∫u² {:.6}",
            point.lambda,
            point.count,
            point.total_angle / std::f64::consts::PI,
            point.int_u2
        );
    }
    for row in &report.comparison {
        say!(
            "{:24} {:4} cones  Φ {:8.4} π  ∫u² {:.6}  largest |u| {:.3}",
            row.label,
            row.count,
            row.total_angle / std::f64::consts::PI,
            row.int_u2,
            row.max_abs_u
        );
    }
    print_flattening(&report.flattening);
}

/// Flattens with the cones of a file. **Takes** parameters with their values. **Gives** the session at rest.
pub fn with_cones(
    document: Document,
    path: &Path,
    choices: &[(&str, Value)],
) -> Result<Session, Problem> {
    document.surface()?;
    let mut session = Session::new();
    tell(session.handle(Command::SetMethod { id: "cones".into() }))?;
    let settings = settings_for(&document);
    tell(session.open_with(Ok(document), settings))?;
    for (id, value) in choices {
        let (id, value) = ((*id).to_owned(), value.clone());
        tell(session.handle(Command::SetParameter { id, value }))?;
    }
    let name = path.display().to_string();
    tell(session.bring(Brought::Cones { name: &name, bytes: &read(path)? }))?;
    drive(&mut session)?;
    Ok(session)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_radians_or_units_of_pi() {
        let told = |text: &str| angle(text, "--bounds").map_err(|problem| problem.what);
        let half = std::f64::consts::FRAC_PI_2;
        for (text, value) in [
            ("1.5", 1.5),
            ("pi", 2.0 * half),
            ("-pi/2", -half),
            ("0.5pi", half),
            ("3pi/2", 3.0 * half),
            ("inf", f64::INFINITY),
        ] {
            assert_eq!(told(text), Ok(value), "{text}");
        }
        for text in ["", "pie", "pi/0", "xpi", "nan", "pi/"] {
            assert!(told(text).is_err(), "{text}");
        }
    }
}
