//! Commands at random: sensible ones, senseless ones, and numbers that are none.

use std::collections::BTreeMap;

use cutflow::session::{Command, ParamKind, RunRequest, Session, Spot, Value, all_specs};

use crate::mutation::SplitMix64;

/// The names of all commands, as serde knows them: no list of our own that could fall behind.
pub fn names() -> Vec<String> {
    let error = serde_json::from_str::<Command>(r#"{"type": "?"}"#).unwrap_err().to_string();
    let list = error.split("expected one of").nth(1).unwrap_or_default();
    list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// What serde calls a command.
pub fn name_of(command: &Command) -> String {
    let value = serde_json::to_value(command).unwrap();
    value["type"].as_str().unwrap().to_owned()
}

/// A source of random choices.
pub struct Dice(pub SplitMix64);

/// Numbers that nobody should hand in.
const HOSTILE: [f64; 14] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN_POSITIVE,
    -0.0,
    0.0,
    -1.0,
    1e300,
    1e9,
    1e-9,
    0.5,
    255.0,
    4294967296.0,
];

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.0.below(n)
    }

    /// Whether something happens that happens once in n times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// From 0 to 1.
    pub fn part(&mut self) -> f64 {
        self.below(1 << 20) as f64 / f64::from((1 << 20) - 1)
    }

    pub fn of<'a, T: ?Sized>(&mut self, list: &[&'a T]) -> &'a T {
        list[self.below(list.len())]
    }

    pub fn number(&mut self) -> f64 {
        HOSTILE[self.below(HOSTILE.len())]
    }

    /// Mostly one of these words; sometimes a word that nobody knows.
    fn word(&mut self, words: &[&str]) -> String {
        if self.once_in(12) {
            return self.of(&["", "nonsense", "../../x", "<script>", "\u{202e}\0\n"]).to_owned();
        }
        self.of(words).to_owned()
    }

    fn index(&mut self, count: usize) -> usize {
        match self.below(12) {
            0 => usize::MAX,
            1 => count,
            2 => 0xffff_ffff,
            _ => self.below(count.max(1)),
        }
    }

    fn face(&mut self, session: &Session) -> u32 {
        let faces = session.document().map_or(1, |d| d.triangles.len());
        u32::try_from(self.index(faces)).unwrap_or(u32::MAX)
    }

    /// A place in the unit ball, mostly.
    fn place(&mut self) -> [f64; 3] {
        let mut place = [0; 3].map(|_| 2.0 * self.part() - 1.0);
        if self.once_in(10) {
            place[self.below(3)] = self.number();
        }
        place
    }

    fn some<T>(&mut self, make: impl FnOnce(&mut Self) -> T) -> Option<T> {
        (!self.once_in(3)).then(|| make(self))
    }

    /// A value of a parameter: mostly one within its range.
    fn value(&mut self, kind: &ParamKind) -> Value {
        if self.once_in(10) {
            return match self.below(3) {
                0 => Value::Number(self.number()),
                1 => Value::Text(self.word(&["normals", "1", "x"])),
                _ => Value::Truth(self.once_in(2)),
            };
        }
        match kind {
            ParamKind::Number { min, max, logarithmic, integer, .. } => {
                let t = match self.below(6) {
                    0 => 0.0,
                    1 => 1.0,
                    _ => self.part(),
                };
                let x = if *logarithmic && *min > 0.0 {
                    min * (max / min).powf(t)
                } else {
                    min + (max - min) * t
                };
                let x = x.clamp(*min, *max);
                Value::Number(if *integer { x.round() } else { x })
            }
            ParamKind::Choice { options } => {
                Value::Text(options[self.below(options.len())].id.clone())
            }
            ParamKind::Switch => Value::Truth(self.once_in(2)),
        }
    }

    /// A command of this name; `None` for one that is not known here.
    pub fn command(&mut self, name: &str, session: &Session) -> Option<Command> {
        const CHANNELS: [&str; 9] = [
            "region",
            "seed",
            "penalty",
            "heat",
            "pin",
            "importance",
            "unimportant",
            "cone_cost",
            "excluded",
        ];
        Some(match name {
            "hello" => Command::Hello,
            // The samples themselves are large; documents are small here.
            "open_sample" => {
                Command::OpenSample { name: self.of(&["", "moon", "BALL"]).to_owned() }
            }
            "set_parameter" => self.parameter(),
            "hold" => Command::Hold { is_held: self.once_in(2) },
            "run" => Command::Run,
            "pause" => Command::Pause,
            "step" => Command::Step,
            "reset" => Command::Reset,
            "show_field" => {
                let fields = ["pieces", "u", "curvature", "phi", "area", "stretch", "isometry"];
                let more = ["angle", "importance", "phase", "weight", "penalty", "heat", "regions"];
                let last =
                    ["yamabe", "normal_error", "adjoint", "flux", "velocity", "level", "moved"];
                Command::ShowField { id: self.word(&[fields, more, last].concat()) }
            }
            "undo" => Command::Undo,
            "redo" => Command::Redo,
            "dismiss_error" => Command::DismissError,
            "show_finding" => {
                let known = session.document().map(|d| &d.examination.findings);
                let ids = known.map(|list| list.iter().map(|f| f.kind.id().to_owned()).collect());
                let ids: Vec<String> = ids.unwrap_or_default();
                let id = self.some(|d| match ids.is_empty() || d.once_in(5) {
                    true => d.word(&["slivers", "open_edges", "nonmanifold_edges"]),
                    false => ids[d.below(ids.len())].clone(),
                });
                Command::ShowFinding { id }
            }
            "repair" => {
                let known = session.document().map(|d| &d.examination.findings);
                let ids = known.map(|list| {
                    list.iter().flat_map(|f| &f.repairs).map(|repair| repair.id()).collect()
                });
                let ids: Vec<String> = ids.unwrap_or_default();
                let id = match ids.is_empty() || self.once_in(5) {
                    true => self.word(&[
                        "weld:0",
                        "weld:0.3",
                        "weld:nan",
                        "fill_holes",
                        "keep_component:99",
                        "keep_largest",
                    ]),
                    false => ids[self.below(ids.len())].clone(),
                };
                Command::Repair { id }
            }
            "repair_all" => Command::RepairAll,
            "set_unit" => {
                Command::SetUnit { id: self.word(&["none", "mm", "cm", "m", "in", "inch"]) }
            }
            "set_size" => {
                let value = if self.once_in(3) { self.number() } else { 1.0 + 500.0 * self.part() };
                Command::SetSize { axis: self.index(3), value }
            }
            "prepare" => self.prepare(session),
            "cancel" => Command::Cancel,
            "apply_preset" => {
                let presets = ["ball", "upholstery", "plush", "bandage", "vase", "heat", "atlas"];
                Command::ApplyPreset { id: self.word(&presets) }
            }
            "paint" => {
                let value = match self.below(6) {
                    0 => self.number(),
                    1 => 0.0,
                    2 => 1.0,
                    _ => self.below(4) as f64,
                };
                Command::Paint {
                    channel: self.word(&[&CHANNELS[..], &["seam_paint", "drawn_seam"]].concat()),
                    face: self.face(session),
                    place: self.place(),
                    radius: if self.once_in(8) { self.number() } else { 0.6 * self.part() },
                    value,
                    begins: self.once_in(2),
                }
            }
            "end_stroke" => Command::EndStroke,
            "clear_paint" => Command::ClearPaint { channel: self.word(&CHANNELS) },
            "place_circle" => {
                Command::PlaceCircle { face: self.face(session), place: self.place() }
            }
            "hide_from_camera" => Command::HideFromCamera { eye: self.place().map(|x| 4.0 * x) },
            "find_symmetries" => Command::FindSymmetries,
            "set_symmetry" => {
                let count = self.below(3);
                let found = session.symmetry_choices();
                let mut known: Vec<&str> = found.iter().map(|choice| choice.id.as_str()).collect();
                known.push("mirror_1");
                Command::SetSymmetry { ids: (0..count).map(|_| self.word(&known)).collect() }
            }
            "fold" => Command::Fold,
            "unfold" => Command::Unfold,
            "set_method" => {
                let methods = ["cutflow", "cones", "phasefield", "developable"];
                Command::SetMethod { id: self.word(&methods) }
            }
            "select_segment" => Command::SelectSegment { node: self.index(5) },
            "sew" => {
                Command::Sew { patches: [self.index(5), self.index(5)], joins: self.once_in(2) }
            }
            "hand_over" => Command::HandOver,
            "show_pattern" => Command::ShowPattern { is_shown: self.once_in(2) },
            "nest" => Command::Nest,
            "apply_trade" => {
                let trades =
                    ["plain", "plush", "garment", "upholstery", "leather", "paper", "sheet_metal"];
                Command::ApplyTrade { id: self.word(&trades) }
            }
            "set_seam_allowance" => {
                let seam = self.index(6);
                let mm = self.some(|d| if d.once_in(4) { d.number() } else { 20.0 * d.part() });
                Command::SetSeamAllowance { seam, mm }
            }
            "add_cone" => {
                let (face, place) = (self.face(session), self.place());
                Command::AddCone { face, place, angle: self.angle() }
            }
            "move_cone" => {
                let (face, place) = (self.face(session), self.place());
                Command::MoveCone { cone: self.index(6), face, place }
            }
            "set_cone_angle" => Command::SetConeAngle { cone: self.index(6), angle: self.angle() },
            "remove_cone" => Command::RemoveCone { cone: self.index(6) },
            "clear_cones" => Command::ClearCones,
            "trace_path" => Command::TracePath,
            "compare_cones" => Command::CompareCones,
            "travel" => {
                let changes = i32::try_from(self.index(9)).map_or(i32::MIN, |n| n - 4);
                Command::Travel { changes }
            }
            "keep_cut" => Command::KeepCut,
            "keep_result" => {
                let name = self.some(|d| d.word(&["First", "Second"]));
                Command::KeepResult { name, seconds: self.some(Self::number) }
            }
            "restore_result" => Command::RestoreResult { id: self.index(4) },
            "remove_result" => Command::RemoveResult { id: self.index(4) },
            "rename_result" => {
                Command::RenameResult { id: self.index(4), name: self.word(&["Third"]) }
            }
            "compare" => self.compare(),
            "next_result" => Command::NextResult,
            "measure" => {
                let mut spot = || Spot { face: self.face(session), place: self.place() };
                Command::Measure { from: spot(), to: spot() }
            }
            _ => return None,
        })
    }

    fn angle(&mut self) -> Option<f64> {
        self.some(|d| if d.once_in(4) { d.number() } else { 6.0 * d.part() - 3.0 })
    }

    fn parameter(&mut self) -> Command {
        let specs = all_specs();
        let spec = &specs[self.below(specs.len())];
        let id = if self.once_in(20) { self.word(&["length"]) } else { spec.id.clone() };
        let mut value = self.value(&spec.kind);
        // Textures of 4096² take seconds each; they are of the size asked for, and that is tested elsewhere.
        if id == "uv_pixels" {
            value = Value::Text("1024".into());
        }
        Command::SetParameter { id, value }
    }

    fn compare(&mut self) -> Command {
        let specs = all_specs();
        let count = self.below(3);
        let runs = (0..count).map(|_| {
            let methods = ["cutflow", "cones", "phasefield", "developable"];
            let spec = &specs[self.below(specs.len())];
            let values = [(spec.id.clone(), self.value(&spec.kind))];
            RunRequest {
                method: self.word(&methods),
                values: values.into_iter().take(self.below(2)).collect(),
                name: self.some(|d| d.word(&["Run"])),
            }
        });
        let runs = runs.collect();
        Command::Compare { runs, steps: Some(self.below(6)), waits: self.once_in(4) }
    }

    fn prepare(&mut self, session: &Session) -> Command {
        // Documents stay small.
        let is_large = session.document().is_some_and(|d| d.triangles.len() > 500);
        let tools: &[&str] =
            if is_large { &["decimate"] } else { &["subdivide", "refine", "remesh", "decimate"] };
        let tool = self.word(tools);
        let mut values = BTreeMap::new();
        let ids: &[(&str, f64, f64)] = match tool.as_str() {
            "subdivide" => &[("rounds", 1.0, 1.0)],
            "refine" => &[("tolerance", 5.0, 60.0)],
            "remesh" => &[("edge", 0.6, 3.0), ("adaptivity", 0.0, 1.0), ("crease", 10.0, 90.0)],
            _ => &[("faces", 4.0, 300.0), ("crease", 10.0, 90.0)],
        };
        for (id, from, to) in ids {
            let x = from + (to - from) * self.part();
            let whole = matches!(*id, "rounds" | "faces");
            let x = if self.once_in(12) { self.number() } else { x };
            values.insert((*id).to_owned(), if whole { x.round() } else { x });
        }
        if self.once_in(20) {
            values.insert("nonsense".into(), 1.0);
        }
        Command::Prepare { tool, values }
    }
}

#[test]
fn every_command_that_there_is_can_be_made_at_random() {
    let names = names();
    assert!(names.len() > 40 && names.contains(&"run".to_owned()), "{names:?}");
    let mut dice = Dice::new(1);
    let session = Session::new();
    for name in &names {
        let command = dice.command(name, &session);
        let command = command.unwrap_or_else(|| panic!("nothing makes the command {name}"));
        assert_eq!(name_of(&command), *name);
    }
}
