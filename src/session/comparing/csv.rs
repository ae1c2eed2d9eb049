//! The table as comma-separated values by RFC 4180: a line for each result, units in the headings, numbers with all their digits.

use super::ResultTable;

/// A line for each result below one of headings. What a result cannot have is empty.
pub(super) fn csv(table: &ResultTable) -> String {
    let own = |id: &str| ["steps", "seconds"].contains(&id);
    let measures = || table.rows.iter().filter(|row| !own(&row.id));
    let heads = ["Name", "Method", "Settings", "Status", "Steps", "Time (s)"];
    let mut lines = vec![heads.map(str::to_owned).to_vec()];
    lines[0].extend(measures().map(|row| match &*row.unit {
        "" => row.label.clone(),
        unit => format!("{} ({unit})", row.label),
    }));
    lines[0].push("Note".into());
    for (i, result) in table.results.iter().enumerate() {
        let settings: Vec<String> =
            result.settings.iter().map(|s| format!("{} = {}", s.label, s.text)).collect();
        let mut line = vec![
            result.name.clone(),
            result.method_label.clone(),
            settings.join("; "),
            result.status.clone(),
            result.steps.map(|n| n.to_string()).unwrap_or_default(),
            number(result.seconds),
        ];
        line.extend(measures().map(|row| number(row.values[i])));
        line.push(result.note.clone().unwrap_or_default());
        lines.push(line);
    }
    let text =
        |line: &Vec<String>| line.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",");
    lines.iter().map(|line| text(line) + "\r\n").collect()
}

fn number(x: Option<f64>) -> String {
    x.map(|x| x.to_string()).unwrap_or_default()
}

/// A field, in quotes where it has to be.
fn quoted(cell: &str) -> String {
    if cell.contains(['"', ',', '\r', '\n']) || cell.starts_with(' ') || cell.ends_with(' ') {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}
