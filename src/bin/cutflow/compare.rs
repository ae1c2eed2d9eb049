//! `cutflow compare`: methods or settings on one mesh side by side, as a table.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use cutflow::session::{
    Command, Method, Problem, ResultRow, ResultTable, RunRequest, Session, settings_for,
};

use super::cut::{assignment, typed};
use super::{
    MeshArgs, Report, clock, flattenings, make_folder, open, tell, write, write_json,
    writes_to_stdout,
};

/// Between two columns of the table.
const GAP: &str = "  ";

#[derive(Args)]
pub struct CompareArgs {
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// The methods: cutflow, cones, phasefield, developable. All four without this and --run.
    #[arg(long, value_name = "METHOD", value_delimiter = ',')]
    methods: Vec<String>,
    /// A parameter of one of them, by its identifier; `cutflow cut --set help` and the like list them.
    #[arg(long = "set", value_name = "METHOD.ID=VALUE", allow_hyphen_values = true)]
    values: Vec<String>,
    /// One run with parameters of its own, for settings of one method beside each other; may be given several times.
    #[arg(long, value_name = "METHOD[,ID=VALUE …]", allow_hyphen_values = true)]
    run: Vec<String>,
    /// Steps after which a flow is stopped. Cones are solved to the end.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    /// Folder for comparison.csv and comparison.json.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Compares ways to flatten the same patches instead, as they lie on the surface.
    #[arg(long, conflicts_with_all = ["methods", "values", "run", "steps", "output"])]
    flattenings: bool,
    /// A cut.json for --flattenings. Without it the surface is taken as it is: it needs a boundary then.
    #[arg(long, value_name = "FILE", requires = "flattenings")]
    pub cut: Option<PathBuf>,
    #[command(flatten)]
    pub report: Report,
}

impl CompareArgs {
    /// The folder that is made for results, and where the report goes.
    pub fn outputs(&self) -> (Option<&Path>, &Report) {
        (self.output.as_deref(), &self.report)
    }
}

pub fn run(args: &CompareArgs) -> Result<(), Problem> {
    if args.flattenings {
        return flattenings::run(args);
    }
    let runs = runs(args)?;
    let document = open(&args.mesh)?;
    document.surface()?;
    let settings = settings_for(&document);
    let mut session = Session::new();
    tell(session.open_with(Ok(document), settings))?;
    while session.is_running() {
        tell(session.advance(&mut || true))?;
    }
    let steps = args.steps.map(|n| n as usize);
    tell(session.handle(Command::Compare { runs, steps, waits: false }))?;
    while session.is_running() {
        let clock = clock();
        tell(session.advance(&mut || true))?;
        session.spend(clock.elapsed().as_secs_f64());
    }
    let table = session.result_table();
    if !writes_to_stdout(&args.report) {
        print(&table);
    }
    if let Some(folder) = &args.output {
        make_folder(folder)?;
        let file = session.export("Comparison (CSV)")?;
        write(&folder.join("comparison.csv"), &file.bytes)?;
        let json = Report { json: Some(folder.join("comparison.json")) };
        write_json(&json, &table)?;
    }
    write_json(&args.report, &table)?;
    // A comparison without any result is none.
    match table.results.iter().find(|result| !result.has_result) {
        Some(first) if table.results.iter().all(|result| !result.has_result) => Err(Problem::new(
            "No method gave a result.",
            format!("{}, {}.", args.mesh.mesh, first.name),
            first.note.clone().unwrap_or_default(),
        )),
        _ => Ok(()),
    }
}

/// What the options ask for.
fn runs(args: &CompareArgs) -> Result<Vec<RunRequest>, Problem> {
    let mut values: BTreeMap<String, BTreeMap<_, _>> = BTreeMap::new();
    for text in &args.values {
        let (name, value) = assignment(text, "--set")?;
        let Some((method, id)) = name.split_once('.') else {
            return Err(Problem::new(
                format!("{text} names no method."),
                "--set.",
                "Write METHOD.ID=VALUE, as in cutflow.length=2.",
            ));
        };
        known(method, "--set")?;
        values.entry(method.into()).or_default().insert(id.to_owned(), typed(id, value)?);
    }
    let mut runs = Vec::new();
    let methods: Vec<String> = if args.methods.is_empty() && args.run.is_empty() {
        Method::ALL.map(|method| method.id().to_owned()).into()
    } else {
        args.methods.clone()
    };
    for method in methods {
        known(&method, "--methods")?;
        let values = values.get(&method).cloned().unwrap_or_default();
        runs.push(RunRequest { method, values, name: None });
    }
    for text in &args.run {
        let mut parts = text.split(',').map(str::trim);
        let method = parts.next().unwrap_or_default().to_owned();
        known(&method, "--run")?;
        let mut own = values.get(&method).cloned().unwrap_or_default();
        for part in parts {
            let (id, value) = assignment(part, "--run")?;
            own.insert(id.to_owned(), typed(id, value)?);
        }
        runs.push(RunRequest { method, values: own, name: Some(text.clone()) });
    }
    if let Some(unused) = values.keys().find(|id| !runs.iter().any(|run| run.method == **id)) {
        return Err(Problem::new(
            format!("{unused} is not compared, but has parameters."),
            "--set.",
            "Add it to --methods, or leave its parameters out.",
        ));
    }
    Ok(runs)
}

fn known(method: &str, option: &str) -> Result<(), Problem> {
    if Method::from_id(method).is_some() {
        return Ok(());
    }
    Err(Problem::new(
        format!("There is no method called “{method}”."),
        format!("{option}."),
        format!("Choose from {}.", Method::known()),
    ))
}

/// The table, a column for each result.
fn print(table: &ResultTable) {
    let mut lines = vec![vec![String::new()]];
    lines[0].extend(table.results.iter().map(|result| result.name.clone()));
    let row = |label: &str, cells: Vec<String>| {
        std::iter::once(label.to_owned()).chain(cells).collect::<Vec<_>>()
    };
    for measured in &table.rows {
        let label = match &*measured.unit {
            "" => measured.label.clone(),
            unit => format!("{}, {unit}", measured.label),
        };
        let cells = (0..table.results.len()).map(|i| cell(measured, i)).collect();
        lines.push(row(&label, cells));
    }
    let count = table.results.len() + 1;
    let widths: Vec<usize> = (0..count)
        .map(|i| lines.iter().map(|line| line[i].chars().count()).max().unwrap_or(0))
        .collect();
    for line in &lines {
        let mut text = format!("{:<1$}", line[0], widths[0]);
        for (cell, width) in line.iter().zip(&widths).skip(1) {
            text += &format!("{GAP}{cell:>width$}");
        }
        say!("{}", text.trim_end());
    }
    say!("* the fewest, shortest, least or fastest of the row");
    for result in &table.results {
        say!("{}: {}", result.name, result.status);
        if let Some(note) = &result.note {
            say!("  note: {note}");
        }
    }
}

/// A value and its mark; empty where there is none.
fn cell(row: &ResultRow, i: usize) -> String {
    let Some(value) = row.values[i] else { return String::new() };
    let mark = if row.best[i] { "*" } else { " " };
    let is_count = row.unit.is_empty() && value.fract().abs() <= 0.0;
    let is_plain = value.abs() <= 0.0 || (1e-3..1e6).contains(&value.abs());
    match (is_count, is_plain) {
        (true, _) => format!("{value:.0} {mark}"),
        (_, true) => format!("{value:.4} {mark}"),
        _ => format!("{value:.3e} {mark}"),
    }
}
