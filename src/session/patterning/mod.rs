//! The pattern of the cut at rest: pieces made ready for a trade, laid on their material, and what is told and written of them.

mod exports;
mod pictures;
mod report;
mod specs;

use std::collections::BTreeMap;

use super::exporting::base_name;
use super::layout::Layout;
use super::message::Command;
use super::message::{Event, TradeChoice, Value};
use super::params::{Effect, Settings, whole};
use super::surface::Surface;
use super::text::Problem;
use super::work::Work;
use super::{Entry, Session, nothing_open};
use crate::methods::flow::{Flow, Status};
use crate::pattern::allowance::{AllowanceParams, Corner};
use crate::pattern::notches::{NotchParams, NotchStyle};
use crate::pattern::{
    BlankParams, Blanks, Bounds, FlapParams, FlapSide, FoldParams, GrainParams, LaidSurface,
    MarkParams, NestFlow, NestNotice, NestParams, NestPose, NestShape, Paper, Pattern, PdfParams,
    PieceNote, Placed, Rotations, Sheet, SheetParams, Stock, SvgParams, Tile, blanks, check, svg,
    tiles, uprights,
};

pub use report::{PageView, PatternPieceReport, PatternReport, PatternSeamReport, PatternView};
pub use specs::specs;

/// Whether a parameter makes other pieces, or lays them elsewhere; others only draw or write the same ones differently.
pub(super) fn makes_other_pieces(id: &str) -> bool {
    !matches!(
        id,
        "seam_labels"
            | "piece_labels"
            | "hints"
            | "grain"
            | "svg_profile"
            | "dxf_profile"
            | "dxf_unit"
            | "paper"
            | "page_overlap"
            | "uv_texture"
            | "uv_pixels"
            | "uv_margin"
    )
}

/// Steps of nesting that are made when somebody asks for them.
const NESTING_STEPS: usize = 400;
/// Widths of a line, as it is shown, that the longer side of the sheet has.
const SHOWN_STROKES: f64 = 1500.0;
/// Sheets of stock that there are: as many as it takes.
const MOST_SHEETS: usize = 1000;

/// A pattern made of a layout.
pub(super) struct Patterning {
    blanks: Blanks,
    placed: Vec<(usize, [usize; 2], bool)>,
    nest: NestFlow,
    /// Steps of nesting made, and how many are allowed.
    steps: [usize; 2],
    notices: Vec<String>,
    /// Whether a better layout is being looked for.
    is_nesting: bool,
}

impl Patterning {
    fn new(
        surface: &Surface,
        layout: &Layout,
        settings: &Settings,
        seam_allowances: &BTreeMap<usize, f64>,
        mm_per_unit: f64,
    ) -> Result<Self, Problem> {
        // The charts as they were flattened: where they lie on the screen is of no account.
        let charts: Vec<[f64; 2]> = layout.flattening.uv.iter().map(|p| [p.x, p.y]).collect();
        let laid = LaidSurface {
            opened: &layout.opened,
            charts: &charts,
            positions: &layout.points,
            mm_per_unit,
        };
        let (pattern, told) = Pattern::new(&layout.opened, &charts, &layout.points, mm_per_unit);
        let params = blank_params(settings, seam_allowances);
        let blanks = blanks(&laid, &pattern, &params);
        let mut notices: Vec<String> = told.iter().map(ToString::to_string).collect();
        if params.flaps.is_some() && (params.allowance_mm > 0.0 || !seam_allowances.is_empty()) {
            notices.push("glue flaps take the place of seam allowances".into());
        }
        notices.extend(blanks.notices.iter().cloned());
        let axis = 1;
        let upright = uprights(&laid, axis);
        let copies = whole(settings.number("copies"));
        let sides: &[bool] = if settings.is_on("mirrored") { &[false, true] } else { &[false] };
        let mut placed = Vec::new();
        let mut shapes = Vec::new();
        for (index, blank) in blanks.pieces.iter().enumerate() {
            for &is_mirrored in sides {
                for copy in 0..copies {
                    placed.push((index, [copy, copies], is_mirrored));
                    let turn = upright[blank.piece.patch];
                    let flip = NestPose { is_mirrored, ..NestPose::default() };
                    let shape = blank.moved(&flip);
                    shapes.push(NestShape {
                        outlines: shape.cut,
                        upright: if is_mirrored { -turn } else { turn },
                        may_mirror: false,
                    });
                }
            }
        }
        let wrong = |error| Problem::solve(&surface.name, &error);
        let nest_params = nest_params(settings);
        if settings.text("stock") != "free"
            && nest_params.margin_mm < settings.number("stock_margin")
        {
            notices.push(format!(
                "the margins leave no room on the material: they are taken as {:.1} mm",
                nest_params.margin_mm
            ));
        }
        let mut nest = NestFlow::new(&shapes, &nest_params).map_err(wrong)?;
        nest.step().map_err(wrong)?;
        Ok(Self { blanks, placed, nest, steps: [1, 1], notices, is_nesting: false })
    }

    /// For each piece on the sheet whether it is mirrored.
    fn mirrored(&self) -> impl Iterator<Item = bool> + '_ {
        self.placed.iter().map(|(_, _, is_mirrored)| *is_mirrored)
    }

    /// The sheet as it is now.
    fn sheet(&self, params: &SheetParams) -> Sheet {
        let state = self.nest.state();
        let placed: Vec<Placed> = self
            .placed
            .iter()
            .zip(&state.poses)
            .map(|(&(blank, copy, is_mirrored), &pose)| Placed { blank, copy, is_mirrored, pose })
            .collect();
        Sheet::new(&self.blanks.pieces, &placed, &self.stock(), params)
    }

    /// What nesting has to tell, by the name of the piece.
    fn told(&self, notice: &NestNotice) -> String {
        let name = |shape: usize| &self.blanks.pieces[self.placed[shape].0].piece.name;
        match *notice {
            NestNotice::TooLarge { shape } => {
                format!("piece {} is larger than the material; it lies beside it", name(shape))
            }
            NestNotice::NoRoom { shape } => {
                format!("the sheets are full: piece {} needs a further one", name(shape))
            }
            NestNotice::NoOutline { shape } => {
                format!("piece {} is not laid: nothing of it is left to be cut", name(shape))
            }
        }
    }

    /// Sizes of the sheets that pieces lie on.
    fn stock(&self) -> Vec<[f64; 2]> {
        let state = self.nest.state();
        let params = self.nest.params();
        let mut sizes = match params.stock {
            Stock::Free => return Vec::new(),
            Stock::Roll { width_mm } => vec![[width_mm, state.used_mm[1]]; state.sheets],
            Stock::Sheet { width_mm, height_mm, .. } => vec![[width_mm, height_mm]; state.sheets],
        };
        // What is too large stands beside them, on as much as it needs.
        for (&(blank, _, is_mirrored), pose) in self.placed.iter().zip(&state.poses) {
            if pose.is_too_large {
                let moved = self.blanks.pieces[blank].moved(&NestPose { is_mirrored, ..*pose });
                let bounds = Bounds::around(moved.cut.iter().flatten().copied());
                sizes.resize(sizes.len().max(pose.sheet + 1), [0.0; 2]);
                sizes[pose.sheet] = bounds.high.map(|x| x + params.margin_mm);
            }
        }
        sizes
    }
}

/// What is asked of the pieces.
fn blank_params(settings: &Settings, seam_allowances: &BTreeMap<usize, f64>) -> BlankParams {
    let fold_angle = settings.number("fold_angle").to_radians();
    BlankParams {
        allowance_mm: settings.number("allowance"),
        seam_allowances: seam_allowances.clone(),
        bare_rim: !settings.is_on("rim_allowance"),
        allowance: AllowanceParams {
            corner: match settings.text("corner") {
                "round" => Corner::Round,
                "square" => Corner::Square,
                _ => Corner::Mitre,
            },
            ..AllowanceParams::default()
        },
        notches: match settings.text("notches") {
            "slit" => Some(NotchStyle::Slit),
            "v" => Some(NotchStyle::V),
            "t" => Some(NotchStyle::T),
            _ => None,
        }
        .map(|style| NotchParams {
            style,
            spacing_mm: settings.number("notch_spacing"),
            ..NotchParams::default()
        }),
        folds: settings
            .is_on("folds")
            .then(|| FoldParams { least_angle: fold_angle, ..FoldParams::default() }),
        flaps: match settings.text("flaps") {
            "alternate" => Some(FlapSide::Alternate),
            "smaller" => Some(FlapSide::SmallerPiece),
            "both" => Some(FlapSide::Both),
            _ => None,
        }
        .map(|side| FlapParams {
            side,
            depth_mm: settings.number("flap_depth"),
            angle: settings.number("flap_angle").to_radians(),
            ..FlapParams::default()
        }),
        marks: settings.is_on("marks").then(MarkParams::default),
        kerf_mm: settings.number("kerf"),
        curve_tolerance_mm: (settings.text("outlines") == "smooth")
            .then(|| settings.number("curve_tolerance")),
    }
}

fn nest_params(settings: &Settings) -> NestParams {
    let width_mm = settings.number("stock_width");
    NestParams {
        stock: match settings.text("stock") {
            "roll" => Stock::Roll { width_mm },
            "sheet" => Stock::Sheet {
                width_mm,
                height_mm: settings.number("stock_height"),
                most: MOST_SHEETS,
            },
            _ => Stock::Free,
        },
        gap_mm: settings.number("gap"),
        margin_mm: match settings.text("stock") {
            "free" => 0.0,
            // Something has to be left between the margins.
            "roll" => settings.number("stock_margin").min(0.25 * width_mm),
            _ => settings
                .number("stock_margin")
                .min(0.25 * width_mm)
                .min(0.25 * settings.number("stock_height")),
        },
        rotations: match settings.text("turns") {
            "none" => Rotations::Nap,
            "half" => Rotations::Woven,
            "quarter" => Rotations::Cross,
            _ => Rotations::Free,
        },
        // The session counts: whoever asks again gets as many again.
        step_limit: usize::MAX,
        ..NestParams::default()
    }
}

impl Work {
    /// Pieces of another cut, or of another size, are other pieces.
    pub(super) fn drop_pattern(&mut self) {
        self.patterning = None;
    }

    /// The pattern of the cut at rest, made if there is none.
    fn pattern(&mut self) -> Result<&mut Patterning, Problem> {
        if self.patterning.is_none() {
            let surface = self.document.surface()?;
            let layout = self.layout.as_ref().ok_or_else(nothing_open)?;
            let mm = self.mm_per_unit();
            let patterning =
                Patterning::new(surface, layout, &self.settings, &self.seam_allowances, mm)?;
            self.patterning = Some(patterning);
        }
        self.patterning.as_mut().ok_or_else(nothing_open)
    }

    fn sheet_params(&self) -> SheetParams {
        let settings = &self.settings;
        let scale = self.document.surface.as_ref().map_or(1.0, |surface| surface.frame.scale);
        SheetParams {
            title: base_name(&self.document.name).to_owned(),
            mm_per_model_unit: Some(self.mm_per_unit() * scale),
            margin_mm: if settings.text("stock") == "free" {
                settings.number("stock_margin")
            } else {
                10.0
            },
            piece_labels: settings.is_on("piece_labels"),
            seam_labels: settings.is_on("seam_labels"),
            hints: settings.is_on("hints"),
            grain: match settings.text("grain") {
                "both" => Some(false),
                "nap" => Some(true),
                _ => None,
            }
            .map(|has_nap| GrainParams { has_nap, ..GrainParams::default() }),
        }
    }

    /// The sheet as it would be written now.
    pub(super) fn sheet(&mut self) -> Result<Sheet, Problem> {
        let params = self.sheet_params();
        Ok(self.pattern()?.sheet(&params))
    }

    fn pdf_params(&self) -> PdfParams {
        let settings = &self.settings;
        let made = self.patterning.as_ref();
        let pieces = made.iter().flat_map(|made| {
            made.placed.iter().map(|&(blank, _, is_mirrored)| PieceNote {
                count: if is_mirrored { "1 mirrored".into() } else { String::new() },
                note: made.blanks.pieces[blank].hints.to_string(),
            })
        });
        PdfParams {
            pieces: pieces.collect(),
            paper: match settings.text("paper") {
                "a3" => Paper::A3,
                "letter" => Paper::Letter,
                "one" => Paper::OnePage,
                _ => Paper::A4,
            },
            overlap_mm: settings.number("page_overlap"),
            ..PdfParams::default()
        }
    }

    /// The sheet as it would be written now.
    fn view(&mut self) -> Result<PatternView, Problem> {
        let sheet = self.sheet()?;
        let mut report = self.report_of(&sheet)?;
        let pages = tiles(&sheet, &self.pdf_params()).unwrap_or_else(|error| {
            report.notices.push(format!("no PDF: {error}"));
            Vec::new()
        });
        let height = sheet.size[1];
        let page = |tile: Tile| PageView {
            name: tile.name,
            frame: [
                tile.low[0],
                height - tile.high[1],
                tile.high[0] - tile.low[0],
                tile.high[1] - tile.low[1],
            ],
        };
        let pages = pages.into_iter().map(page).collect();
        let least_stroke_mm = sheet.size[0].max(sheet.size[1]) / SHOWN_STROKES;
        let params = SvgParams { least_stroke_mm, ..exports::svg_params(&self.settings) };
        let svg = svg(&sheet, &params)
            .map_err(|error| exports::unwritten(&self.document.name, &error))?;
        let is_nesting = self.patterning.as_ref().is_some_and(|made| made.is_nesting);
        let svg = String::from_utf8_lossy(&svg).into_owned();
        Ok(PatternView { svg, pages, report, is_nesting })
    }

    /// What page and command are told of the pattern.
    fn report_of(&mut self, sheet: &Sheet) -> Result<PatternReport, Problem> {
        let params = blank_params(&self.settings, &self.seam_allowances);
        let is_roll = self.settings.text("stock") == "roll";
        let made = self.pattern()?;
        let mut notices = made.notices.clone();
        let state = made.nest.state();
        notices.extend(state.notices.iter().map(|notice| made.told(notice)));
        if let Ok(told) = check(sheet) {
            notices.extend(told.iter().map(ToString::to_string));
        }
        let name = |patch: usize| crate::pattern::piece_name(patch);
        let counts = |index: usize, mirrored: bool| {
            made.placed.iter().filter(|(blank, _, m)| *blank == index && *m == mirrored).count()
        };
        let pieces = made.blanks.pieces.iter().enumerate().map(|(index, blank)| {
            // As it lies on the sheet, which is what the files say.
            let first = made.placed.iter().zip(&state.poses).find(|((own, ..), _)| *own == index);
            let lies = first.map(|(&(_, _, is_mirrored), pose)| {
                blank.moved(&NestPose { is_mirrored, ..*pose })
            });
            let outline = &lies.as_ref().unwrap_or(blank).cut;
            let bounds = Bounds::around(outline.iter().flatten().copied());
            PatternPieceReport {
                name: blank.piece.name.clone(),
                patch: blank.piece.patch,
                size_mm: [0, 1].map(|a| bounds.high[a] - bounds.low[a]),
                area_mm2: blank.piece.area_mm2,
                copies: [counts(index, false), counts(index, true)],
                hint: blank.hints.to_string(),
            }
        });
        let notches = |number: usize| {
            let mut seams = made.blanks.notches.seams.iter();
            let found = seams.find(|seam| seam.number == number);
            let groups = found.iter().flat_map(|seam| &seam.groups);
            groups.map(|group| (group.arc_mm, group.count)).collect()
        };
        let seams = made.blanks.seams.iter().map(|seam| PatternSeamReport {
            number: seam.number,
            pieces: seam.patches.map(name),
            length_mm: seam.surface_length_mm,
            flat_mm: seam.lengths_mm,
            allowance_mm: *params.seam_allowances.get(&seam.number).unwrap_or(&params.allowance_mm),
            notches: notches(seam.number),
        });
        Ok(PatternReport {
            sheet_mm: sheet.size,
            sheets: state.sheets,
            utilisation: state.utilisation,
            roll_length_mm: if is_roll { state.used_mm[1] } else { 0.0 },
            nesting_steps: made.steps[0],
            pieces: pieces.collect(),
            seams: seams.collect(),
            notices,
        })
    }
}

impl Session {
    /// The sheet of the pattern, as every writer writes it.
    pub fn pattern_sheet(&mut self) -> Result<Sheet, Problem> {
        self.settled()?.sheet()
    }

    /// The report of `cutflow pattern`.
    pub fn pattern_report(&mut self) -> Result<PatternReport, Problem> {
        let work = self.settled()?;
        let sheet = work.sheet()?;
        work.report_of(&sheet)
    }

    pub(super) fn show_pattern(
        &mut self,
        is_shown: bool,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        self.is_pattern_shown = is_shown;
        if !is_shown {
            if self.is_nesting() {
                self.stop_nesting();
                // Looking is no part of a project; its end is.
                self.log.push(Entry::Do(Command::ShowPattern { is_shown }));
            }
            return Ok(());
        }
        // Made of the cut at rest.
        if self.is_running {
            self.pause(events)?;
            self.log.push(Entry::Do(Command::Pause));
        }
        self.settled()?;
        events.push(self.trades_event());
        self.tell_pattern(events);
        Ok(())
    }

    /// Tells what the sheet has become, if somebody looks at it.
    pub(super) fn tell_pattern(&mut self, events: &mut Vec<Event>) {
        if !self.is_pattern_shown || self.is_running || !self.replay.is_over() {
            return;
        }
        let Some(work) = self.work.as_mut().filter(|work| work.is_settled) else { return };
        match work.view() {
            Ok(view) => events.push(Event::Pattern(view)),
            // What was asked for is in force all the same.
            Err(problem) => events.push(super::error_event(problem)),
        }
    }

    pub(super) fn nest(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        if self.is_running {
            self.pause(events)?;
        }
        let made = self.settled()?.pattern()?;
        made.steps[1] = made.steps[0] + NESTING_STEPS;
        made.is_nesting = made.nest.status() == Status::Running;
        events.push(self.status());
        self.tell_pattern(events);
        Ok(())
    }

    pub(super) fn stop_nesting(&mut self) {
        if let Some(made) = self.work.as_mut().and_then(|work| work.patterning.as_mut()) {
            made.is_nesting = false;
        }
    }

    pub(super) fn is_nesting(&self) -> bool {
        let made = self.work.as_ref().and_then(|work| work.patterning.as_ref());
        made.is_some_and(|made| made.is_nesting)
    }

    /// One step of nesting.
    pub(super) fn nest_on(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        let Some(made) = &mut work.patterning else { return Ok(()) };
        let before = made.nest.state().cost_mm;
        let result = made.nest.step();
        made.steps[0] += 1;
        let goes_on = matches!(&result, Ok(report) if report.status == Status::Running);
        made.is_nesting = goes_on && made.steps[0] < made.steps[1];
        let is_better = made.nest.state().cost_mm < before;
        let has_ended = !made.is_nesting;
        result.map_err(|error| Problem::solve(&work.document.name, &error))?;
        if is_better || has_ended {
            self.tell_pattern(events);
        }
        Ok(())
    }

    /// What the status line says of nesting.
    pub(super) fn nesting_text(&self) -> Option<String> {
        let made = self.work.as_ref()?.patterning.as_ref().filter(|made| made.is_nesting)?;
        Some(format!("Running step {} of nesting", made.steps[0] + 1))
    }

    pub(super) fn apply_trade(&mut self, id: &str, events: &mut Vec<Event>) -> Result<(), Problem> {
        let trades = specs::trades();
        let Some((_, label, _, values)) = trades.iter().find(|(known, ..)| *known == id) else {
            let known: Vec<&str> = trades.iter().map(|(id, ..)| *id).collect();
            return Err(Problem::new(
                format!("There is no trade called “{id}”."),
                "In the choice of a trade.",
                format!("Choose one of {}.", known.join(", ")),
            ));
        };
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let mut settings = work.settings.clone();
        for spec in specs() {
            let asked = values.iter().find(|(id, _)| *id == spec.id).map(|(_, value)| value);
            settings.set(&spec.id, asked.unwrap_or(&spec.default).clone())?;
        }
        let label = format!("preset {label} for patterns");
        self.apply(&label, settings, Effect::Pattern, events)
    }

    pub(super) fn trades_event(&self) -> Event {
        let options = specs::trades();
        let values = self.work.as_ref().map(|work| work.settings.values()).unwrap_or_default();
        let is_so = |asked: &[(&str, Value)]| {
            specs().iter().all(|spec| {
                let wanted = asked.iter().find(|(id, _)| *id == spec.id).map(|(_, value)| value);
                values.get(&spec.id) == Some(wanted.unwrap_or(&spec.default))
            })
        };
        let current = options.iter().find(|(.., values)| is_so(values));
        Event::Trades {
            current: current.map(|(id, ..)| (*id).to_owned()),
            options: options
                .iter()
                .map(|(id, label, help, _)| TradeChoice {
                    id: (*id).into(),
                    label: (*label).into(),
                    help: (*help).into(),
                })
                .collect(),
        }
    }

    pub(super) fn set_seam_allowance(
        &mut self,
        seam: usize,
        mm: Option<f64>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let made = self.settled()?.pattern()?;
        let count = made.blanks.seams.iter().map(|seam| seam.number).max().unwrap_or(0);
        if !made.blanks.seams.iter().any(|known| known.number == seam) {
            return Err(Problem::new(
                format!("There is no seam {seam}."),
                "Seam allowance of one seam.",
                format!("Choose a number from 1 to {count}."),
            ));
        }
        if mm.is_some_and(|mm| !(0.0..=100.0).contains(&mm)) {
            return Err(Problem::new(
                "The allowance is out of range.",
                format!("Seam {seam}."),
                "Choose a number from 0 to 100 mm.",
            ));
        }
        self.remember("change the allowance of a seam", &format!("set allowance {seam}"));
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        match mm {
            Some(mm) => work.seam_allowances.insert(seam, mm),
            None => work.seam_allowances.remove(&seam),
        };
        work.drop_pattern();
        events.push(self.history_event());
        self.tell_pattern(events);
        Ok(())
    }
}
