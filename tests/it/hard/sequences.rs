//! Sequences of commands, with steps, pictures and files in between: nothing panics, nothing is no number, refusals change nothing, Undo and Redo
//! lead to the last bit, and what was done can be done again to the same bytes.

use std::cell::RefCell;
use std::collections::BTreeMap;

use cutflow::session::{Brought, Command, Event, Method, Session};

use super::commands::{self, Dice};
use super::documents;
use super::guarded;
use super::sound::{KINDS, check_events, check_file, check_scene, check_session};

/// How much was done.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    pub sequences: usize,
    pub commands: usize,
    pub refused: usize,
    pub steps: usize,
    pub scenes: usize,
    pub files: usize,
    /// Commands that Undo took back, by name.
    pub undone: BTreeMap<String, usize>,
    /// Projects that were replayed.
    pub replayed: usize,
}

/// Steps that a sequence may make at a time.
const MOST_STEPS: usize = 4;

/// One in so many sequences is on surfaces of hundreds of triangles, one in so many replays compares all files.
const RARELY: usize = 40;

/// Characters of a project's log that a finding shows.
const LOG_SHOWN: usize = 4000;

/// Files whose charts are nested, which takes seconds.
const NESTED: [&str; 7] = [
    "UV mesh (OBJ)",
    "UV mesh (GLB)",
    "Flat mesh (OBJ)",
    "Cut surface (PLY)",
    "Pattern (SVG)",
    "Pattern (DXF)",
    "Pattern (PDF)",
];

/// Seconds of processor time that an action on a surface of a few hundred triangles may take, several files included.
const MOST_SECONDS: f64 = 15.0;

/// One sequence of so many actions. **Fails** with what was found and the whole sequence.
pub fn run(seed: u64, actions: usize, counts: &mut Counts) -> Result<(), String> {
    let told = RefCell::new(Vec::new());
    let result = guarded(|| {
        let mut sequence = Sequence::new(seed, &told);
        for _ in 0..actions {
            sequence.act(counts)?;
        }
        sequence.replay(counts)
    });
    counts.sequences += 1;
    result.map_err(|what| {
        let told = told.borrow();
        format!("sequence {seed}: {what}\n  {}", told.join("\n  "))
    })
}

struct Sequence<'a> {
    dice: Dice,
    session: Session,
    names: Vec<String>,
    documents: Vec<(&'static str, Vec<u8>)>,
    told: &'a RefCell<Vec<String>>,
}

/// A command was refused: error, status and the parameters in force follow each other.
fn is_refused(events: &[Event]) -> bool {
    let is = |e: &[Event]| {
        matches!(e, [Event::Error { .. }, Event::Status { .. }, Event::Parameters { .. }])
    };
    events.windows(3).any(is)
}

/// The parts of two documents that differ.
fn difference(before: &[(&'static str, u64)], session: &Session) -> String {
    let after = session.digests();
    let differ = before.iter().zip(&after).filter(|(a, b)| a != b).map(|(a, _)| a.0);
    differ.collect::<Vec<_>>().join(", ")
}

/// Whether two files say the same but for the last digits of numbers.
fn nearly_same(own: &[u8], other: &[u8]) -> bool {
    let words = |bytes: &[u8]| -> Vec<String> {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let is_end = |c: char| !(c.is_ascii_alphanumeric() || "+-._".contains(c));
        text.split(is_end).filter(|word| !word.is_empty()).map(str::to_owned).collect()
    };
    let (own, other) = (words(own), words(other));
    let is_near = |a: &str, b: &str| {
        let near = |x: f64, y: f64| (x - y).abs() <= 1e-7 * (x.abs() + y.abs()) + 1e-9;
        a == b || matches!((a.parse(), b.parse()), (Ok(x), Ok(y)) if near(x, y))
    };
    own.len() == other.len() && own.iter().zip(&other).all(|(a, b)| is_near(a, b))
}

/// Parts that change where what was painted or asked for, and waited, is taken up.
const FOLLOWING: &[&str] = &["settings", "flow", "history", "segments", "seams", "cones"];

/// Those that may change by a command that is refused.
fn following(was_behind: bool) -> &'static [&'static str] {
    if was_behind { FOLLOWING } else { &[] }
}

/// Whether something waits that what needs a cut at rest does first. Cones set λ where it follows from a target.
fn waits(session: &Session) -> bool {
    session.is_behind() || (session.method() == Method::Cones && session.is_running())
}

/// The first part of a difference that may not be there.
fn unexplained<'a>(difference: &'a str, may: &[&str]) -> Option<&'a str> {
    difference.split(", ").find(|part| !part.is_empty() && !may.contains(part))
}

/// A report without what it cost: a solver that was at work before has less to do. Other files stay as they are.
fn without_effort(file: Vec<u8>) -> Vec<u8> {
    fn drop_costs(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(map) => {
                // Whether charts overlap by a millionth of a millionth is for rounding to decide, and how they are turned on their sheet.
                for key in ["rounds", "factorisations", "solves", "seconds", "validity"] {
                    map.remove(key);
                }
                map.values_mut().for_each(drop_costs);
            }
            serde_json::Value::Array(list) => list.iter_mut().for_each(drop_costs),
            _ => {}
        }
    }
    let Ok(mut value) = serde_json::from_slice(&file) else { return file };
    drop_costs(&mut value);
    // Results beside this one are in no project.
    if let serde_json::Value::Object(map) = &mut value {
        map.remove("comparison");
    }
    value.to_string().into_bytes()
}

impl<'a> Sequence<'a> {
    fn new(seed: u64, told: &'a RefCell<Vec<String>>) -> Self {
        let mut dice = Dice::new(seed);
        let mut session = Session::new();
        let is_large = dice.once_in(RARELY);
        let documents = if is_large { documents::small() } else { documents::tiny() };
        // Now and then nothing is open.
        if !dice.once_in(12) {
            let (name, bytes) = &documents[dice.below(documents.len())];
            told.borrow_mut().push(format!("open {name}"));
            session.open(name, bytes);
        }
        // One in three sequences is of another method from its start.
        if dice.once_in(3) {
            let id = dice.of(&["cones", "phasefield", "developable"]).to_owned();
            told.borrow_mut().push(format!("method {id}"));
            session.handle(Command::SetMethod { id });
        }
        Self { dice, session, names: commands::names(), documents, told }
    }

    fn tell(&self, what: String) {
        self.told.borrow_mut().push(what);
    }

    fn act(&mut self, counts: &mut Counts) -> Result<(), String> {
        check_events(&self.session.take_late())?;
        let start = super::processor_seconds();
        self.one(counts)?;
        match (start, super::processor_seconds()) {
            (Some(start), Some(end)) if end - start > MOST_SECONDS => {
                Err(format!("the last action took {:.1} s", end - start))
            }
            _ => Ok(()),
        }
    }

    fn one(&mut self, counts: &mut Counts) -> Result<(), String> {
        match self.dice.below(24) {
            0..15 => self.command(counts),
            15..19 => self.advance(counts),
            19 => {
                self.tell("scene".into());
                counts.scenes += 1;
                let scene = self.session.scene();
                scene.as_ref().map_or(Ok(()), check_scene)
            }
            20 => self.export(counts),
            21 => self.open(),
            22 => self.bring(),
            _ => {
                self.tell("check".into());
                check_session(&mut self.session)
            }
        }
    }

    fn pick(&mut self) -> Command {
        loop {
            // What takes a document back or to another method would be most of all otherwise.
            let name = match self.dice.below(6) {
                0 => "set_parameter",
                1 => self.dice.of(&["run", "step", "paint", "undo", "redo"]),
                _ => &self.names[self.dice.below(self.names.len())],
            };
            let name = name.to_owned();
            if let Some(command) = self.dice.command(&name, &self.session) {
                return command;
            }
        }
    }

    fn command(&mut self, counts: &mut Counts) -> Result<(), String> {
        let command = self.pick();
        let name = commands::name_of(&command);
        let tests_undo = self.dice.once_in(3);
        self.tell(format!("{command:?}{}", if tests_undo { ", Undo, Redo" } else { "" }));
        // What was painted belongs to the flow once the stroke has ended.
        self.session.handle(Command::EndStroke);
        let was_comparing = self.session.is_comparing();
        if tests_undo && !was_comparing {
            self.take_up()?;
        }
        if name == "set_seam_allowance" {
            // Seams are those of a cut at rest, and allowances of the cut before are gone then.
            let _ = self.session.layout();
        }
        let was_behind = waits(&self.session);
        let (before, depth) = (self.session.digests(), self.session.undo_depth());
        let events = self.session.handle(command.clone());
        counts.commands += 1;
        check_events(&events)?;
        if was_comparing {
            // What was there is a run of the comparison; most commands end it, and the document is back.
            return Ok(());
        }
        let travels = matches!(command, Command::Undo | Command::Redo | Command::Travel { .. });
        if is_refused(&events) {
            counts.refused += 1;
            let differ = difference(&before, &self.session);
            return match unexplained(&differ, following(was_behind)).filter(|_| !travels) {
                Some(part) => Err(format!("{name} was refused and changed: {part}")),
                None => Ok(()),
            };
        }
        if tests_undo && !travels && self.session.undo_depth() == depth + 1 {
            self.take_up()?;
            let after = self.session.digests();
            check_events(&self.session.handle(Command::Undo))?;
            let differ = difference(&before, &self.session);
            if !differ.is_empty() {
                return Err(format!("{name} and Undo changed: {differ}"));
            }
            check_events(&self.session.handle(Command::Redo))?;
            let differ = difference(&after, &self.session);
            if !differ.is_empty() {
                return Err(format!("{name}, Undo and Redo changed: {differ}"));
            }
            *counts.undone.entry(name).or_default() += 1;
        }
        Ok(())
    }

    /// Undo and Redo lead to where nothing waits.
    fn take_up(&mut self) -> Result<(), String> {
        match self.session.is_behind() {
            true => check_events(&self.session.advance(&mut || false)),
            false => Ok(()),
        }
    }

    fn advance(&mut self, counts: &mut Counts) -> Result<(), String> {
        let budget = self.dice.below(MOST_STEPS) + 1;
        self.tell(format!("advance {budget}"));
        if !self.session.is_running() {
            return Ok(());
        }
        let mut left = budget;
        let events = self.session.advance(&mut || {
            left -= 1;
            left > 0
        });
        counts.steps += budget - left;
        check_events(&events)
    }

    /// A kind of file, rarely one that takes long.
    fn kind(&mut self) -> &'static str {
        let is_slow = |kind: &str| NESTED.contains(&kind) || kind == "All files (ZIP)";
        let may_be_slow = self.dice.once_in(RARELY / 4);
        loop {
            let kind = KINDS[self.dice.below(KINDS.len())];
            if may_be_slow || !is_slow(kind) {
                return kind;
            }
        }
    }

    fn export(&mut self, counts: &mut Counts) -> Result<(), String> {
        let kind = self.kind();
        self.tell(format!("export {kind}"));
        let (before, was_behind) = (self.session.digests(), waits(&self.session));
        match self.session.export(kind) {
            Ok(file) => {
                counts.files += 1;
                check_file(kind, &file)?;
            }
            Err(problem) => {
                let parts = [&problem.what, &problem.place, &problem.what_to_do];
                if parts.iter().any(|part| part.is_empty()) {
                    return Err(format!("a refusal without words: {problem:?}"));
                }
            }
        }
        // What was painted or asked for and waited may be done for the file; the rest stays.
        let differ = difference(&before, &self.session);
        // So may a first cut.
        let may = if was_behind { FOLLOWING } else { &["flow", "history", "segments", "seams"] };
        match unexplained(&differ, may) {
            Some(part) => Err(format!("the export of {kind} changed {part}")),
            None => Ok(()),
        }
    }

    fn open(&mut self) -> Result<(), String> {
        // Mostly something that cannot be read: documents that change too often test nothing else.
        let (name, bytes) = &self.documents[self.dice.below(self.documents.len())];
        let mut bytes = bytes.clone();
        let is_damaged = !self.dice.once_in(4);
        if is_damaged {
            bytes = crate::mutation::mutate(self.dice.0.next(), &bytes);
        }
        self.tell(format!("open {name}{}", if is_damaged { ", damaged" } else { "" }));
        check_events(&self.session.open(name, &bytes))
    }

    fn bring(&mut self) -> Result<(), String> {
        let count = self.session.document().map_or(0, |d| d.soup.positions.len());
        let count = if self.dice.once_in(5) { count + 1 } else { count };
        let channel = self.dice.of(&["region", "penalty", "heat", "pin", "importance", "x"]);
        let values: Vec<f64> = (0..count)
            .map(|_| match self.dice.below(200) {
                0 => self.dice.number(),
                n => (n % 3) as f64 * 0.5,
            })
            .map(|x| if channel == "region" { x.round() } else { x })
            .collect();
        let vertex = self.dice.below(count.max(1)) as f64;
        let own = self.session.export("Cut (JSON)").map(|file| file.bytes).unwrap_or_default();
        let cones = self.session.export("Cones (JSON)").map(|file| file.bytes).unwrap_or_default();
        let (was_comparing, was_behind) = (self.session.is_comparing(), waits(&self.session));
        let before = self.session.digests();
        let what = match self.dice.below(6) {
            0 => Brought::Layer { channel, values: &values },
            1 => Brought::Seeds(&[vertex, 0.0, f64::NAN]),
            2 => Brought::Cut { name: "cut.json", bytes: &own },
            3 => Brought::Eye([vertex, f64::INFINITY, 0.0]),
            4 => Brought::Cones { name: "cones.json", bytes: &cones },
            _ => Brought::Cone { vertex, angle: Some(0.7) },
        };
        self.tell(format!("bring {}", format!("{what:?}").chars().take(60).collect::<String>()));
        let events = self.session.bring(what);
        check_events(&events)?;
        let is_refused =
            matches!(events.last_chunk::<2>(), Some([Event::Error { .. }, Event::Status { .. }]));
        let differ = difference(&before, &self.session);
        // A comparison ends, and the document is back.
        match unexplained(&differ, following(was_behind)).filter(|_| is_refused && !was_comparing) {
            Some(part) => Err(format!("what was brought was refused and changed: {part}")),
            None => Ok(()),
        }
    }

    /// The project of all this gives the same files again.
    fn replay(&mut self, counts: &mut Counts) -> Result<(), String> {
        // Where a run goes on, a project pauses.
        if self.session.is_comparing() {
            // Whatever is no part of a comparison ends it, and the document comes back.
            self.session.handle(Command::TracePath);
        }
        self.session.handle(Command::Pause);
        let Ok(project) = self.session.export("Project (JSON)") else { return Ok(()) };
        let text = String::from_utf8_lossy(&project.bytes);
        let log = text.find("\"log\"").map_or("", |at| &text[at..]);
        self.tell(format!("replay {}", log.chars().take(LOG_SHOWN).collect::<String>()));
        let mut again = Session::new();
        check_events(&again.open("again.json", &project.bytes))?;
        // What is still due after the pause, such as paint that the flow does not know yet, comes to rest in both.
        for session in [&mut again, &mut self.session] {
            let mut left = 100_000;
            while session.is_running() && left > 0 {
                left -= 1;
                check_events(&session.advance(&mut || false))?;
            }
        }
        let differ = difference(&self.session.digests(), &again);
        if !differ.is_empty() {
            return Err(format!("the replay of the project differs in {differ}"));
        }
        let is_thorough = self.dice.once_in(RARELY);
        let has_cones = self.session.method() == Method::Cones;
        let is_compared = |kind: &&&str| {
            !["Project (JSON)", "All files (ZIP)"].contains(*kind)
                && (is_thorough || !NESTED.contains(*kind))
        };
        for kind in KINDS.iter().filter(is_compared) {
            // What was passed over in reading is told in reports, and a project's mesh has nothing of it.
            let is_read_whole = self.session.document().is_none_or(|d| d.reading.is_empty());
            if *kind == "Report (JSON)" && !is_read_whole {
                continue;
            }
            let bytes =
                |session: &mut Session| session.export(kind).map(|file| without_effort(file.bytes));
            let start = super::processor_seconds();
            let both = (bytes(&mut self.session), bytes(&mut again));
            if let (Some(start), Some(end)) = (start, super::processor_seconds())
                && end - start > MOST_SECONDS
            {
                return Err(format!("writing {kind} twice took {:.1} s", end - start));
            }
            match both {
                // A solver of cones that has gone back by Undo knows more than one that has not, which shows in the last digits.
                (Ok(own), Ok(other)) if has_cones && nearly_same(&own, &other) => {}
                (Ok(own), Ok(other)) if own != other => {
                    let at = own.iter().zip(&other).take_while(|(a, b)| a == b).count();
                    let part = |bytes: &[u8]| {
                        let near = at.saturating_sub(80)..bytes.len().min(at + 60);
                        String::from_utf8_lossy(&bytes[near]).into_owned()
                    };
                    let [own, other] = [part(&own), part(&other)];
                    return Err(format!("the replay differs in {kind}:\n{own}\n-- {other}"));
                }
                (Err(own), Err(other)) if own != other => {
                    return Err(format!("the replay refuses {kind} by {other:?}, not {own:?}"));
                }
                (Ok(_), Err(problem)) | (Err(problem), Ok(_)) => {
                    return Err(format!("only one of both writes {kind}: {problem:?}"));
                }
                _ => {}
            }
        }
        counts.replayed += 1;
        Ok(())
    }
}

#[test]
fn commands_in_any_order_break_nothing() {
    let mut counts = Counts::default();
    for seed in 0..25 {
        run(seed, 25, &mut counts).unwrap_or_else(|what| panic!("{what}"));
    }
    println!("{counts:?}");
    assert!(counts.commands > 200 && counts.files > 5 && counts.replayed > 10, "{counts:?}");
}

/// Sequences of the long run that once found something, one for each fault.
const FOUND: [u64; 31] = [
    1_099_511_627_902,
    1_099_511_627_914,
    1_099_511_627_919,
    1_099_511_627_972,
    1_099_511_628_027,
    1_099_511_628_042,
    1_099_511_628_480,
    1_099_511_628_517,
    1_099_511_628_723,
    1_099_511_628_787,
    1_099_511_628_790,
    2_199_023_256_118,
    7_696_581_394_788,
    8_796_093_022_536,
    8_796_093_022_623,
    8_796_093_022_888,
    23_089_744_183_410,
    23_089_744_183_558,
    35_184_372_088_856,
    35_184_372_088_878,
    34_084_860_461_176,
    34_084_860_461_290,
    34_084_860_461_475,
    35_184_372_088_931,
    45_079_976_738_885,
    56_075_093_017_404,
    56_075_093_018_093,
    56_075_093_018_388,
    67_070_209_294_530,
    68_169_720_922_381,
    68_169_720_923_023,
];

#[test]
fn what_the_long_run_found_is_mended() {
    let mut counts = Counts::default();
    for seed in FOUND {
        run(seed, 25, &mut counts).unwrap_or_else(|what| panic!("{what}"));
    }
    assert_eq!(counts.sequences, FOUND.len());
}
