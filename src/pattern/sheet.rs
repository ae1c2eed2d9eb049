//! What is drawn of a pattern: lines and texts in layers, the same for every drawing format.

use super::labels::{Labels, text_width};
use super::marks::{seam_ends, tick};
use super::number::millimetre_text;
use super::piece::{Bounds, Pattern};
use super::seam::Partner;

/// A kind of line or text; drawing programs show or hide each as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// What is cut: outlines and holes, with allowance and flaps.
    Cut,
    /// Where pieces are sewn or glued: the outlines of the charts, where they are not cut themselves.
    Sew,
    /// Balance marks of seams.
    Notch,
    /// Along the grain of the material.
    Grain,
    /// Folded away from the person who looks at the outer side.
    FoldMountain,
    /// Folded towards that person.
    FoldValley,
    /// Cut half through, as for the folds of flaps.
    Score,
    /// Points to drill or to punch.
    Drill,
    /// Marks inside a piece: ends of seams, tips of darts, clips.
    Internal,
    /// Names, seams, notes.
    Text,
    /// Title, control square, frames of stock sheets.
    Control,
}

impl Layer {
    /// All of them, in the order in which they are written.
    pub const ALL: [Self; 11] = [
        Self::Cut,
        Self::Sew,
        Self::Notch,
        Self::Grain,
        Self::FoldMountain,
        Self::FoldValley,
        Self::Score,
        Self::Drill,
        Self::Internal,
        Self::Text,
        Self::Control,
    ];
}

/// A polyline, or a smooth curve with a polyline that stands for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its layer.
    pub layer: Layer,
    /// Unique on the sheet; letters, digits, hyphens and underscores, a letter first.
    pub id: String,
    /// Index of the piece that it belongs to.
    pub piece: Option<usize>,
    /// Index of the seam of that piece that it belongs to.
    pub seam: Option<usize>,
    /// Whether the last point is joined to the first, which is not repeated.
    pub is_closed: bool,
    /// Places, mm, y up.
    pub points: Vec<[f64; 2]>,
    /// Cubic Bézier curves, each by two control points and its end, the first from `points[0]`; empty for a polyline. `points` lie on
    /// them, so close that chords are off by no more than the tolerance that the curve was fitted with.
    pub curve: Vec<[[f64; 2]; 3]>,
}

/// A line of text, upright.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// Its layer.
    pub layer: Layer,
    /// Unique on the sheet, as ids of lines are.
    pub id: String,
    /// Index of the piece that it belongs to.
    pub piece: Option<usize>,
    /// Index of the seam of that piece that it is written beside.
    pub seam: Option<usize>,
    /// Middle of the text, or of its left end; half way up the capitals.
    pub at: [f64; 2],
    /// Whether it begins at `at` instead of being centred there.
    pub is_left: bool,
    /// Height of capital letters and digits, mm.
    pub height: f64,
    /// The words.
    pub text: String,
}

/// Everything that is drawn, from the lower left corner of the sheet. Every writer of files writes this and nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Name of the model.
    pub title: String,
    /// Width and height, mm.
    pub size: [f64; 2],
    /// The pieces as they lie on the sheet.
    pub pattern: Pattern,
    /// Polylines, by layer.
    pub lines: Vec<Line>,
    /// Texts, by layer.
    pub texts: Vec<Text>,
    /// Sheets of stock within, where the pieces are nested on such.
    pub frames: Vec<Bounds>,
}

/// What a person wants on the sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetParams {
    /// Name of the model.
    pub title: String,
    /// Millimetres per unit of the user's file, for the title; `None` leaves it out.
    pub mm_per_model_unit: Option<f64>,
    /// Free space on all four sides.
    pub margin_mm: f64,
}

impl Default for SheetParams {
    fn default() -> Self {
        Self { title: "Pattern".into(), mm_per_model_unit: None, margin_mm: 10.0 }
    }
}

/// Side of the control square.
const SQUARE: f64 = 50.0;
/// Between the pieces and what stands below them.
const GAP: f64 = 10.0;

impl Sheet {
    /// Lays out title, control square, names and seam labels around the pieces.
    pub fn new(mut pattern: Pattern, params: &SheetParams) -> Self {
        let margin = params.margin_mm;
        let [width, height] = pattern.bounds.high;
        let footer = footer(&pattern, params);
        let wanted = footer.iter().map(|(text, height)| SQUARE + 5.0 + text_width(text, *height));
        let inner_width = wanted.fold(width, f64::max);
        // Tenths of millimetres: sizes that people can read.
        let tenths = |x: f64| (10.0 * x).ceil() / 10.0;
        let below = if pattern.pieces.is_empty() { SQUARE } else { SQUARE + GAP };
        let size = [tenths(inner_width + 2.0 * margin), tenths(height + below + 2.0 * margin)];
        let origin = [margin, size[1] - margin - height];
        pattern.translate(origin);
        let mut sheet = Self {
            title: params.title.clone(),
            size,
            pattern,
            lines: Vec::new(),
            texts: Vec::new(),
            frames: Vec::new(),
        };
        for index in 0..sheet.pattern.pieces.len() {
            sheet.draw_piece(index);
        }
        sheet.draw_control(margin, footer);
        sheet.lines.sort_by_key(|line| line.layer);
        sheet.texts.sort_by_key(|text| text.layer);
        sheet
    }

    fn draw_piece(&mut self, index: usize) {
        let piece = &self.pattern.pieces[index];
        let name = &piece.name;
        let line = |layer, id, is_closed, points| Line {
            layer,
            id,
            piece: Some(index),
            seam: None,
            is_closed,
            points,
            curve: Vec::new(),
        };
        for (k, outline) in piece.outlines.iter().enumerate() {
            let id = if k == 0 { format!("{name}-cut") } else { format!("{name}-hole-{k}") };
            self.lines.push(line(Layer::Cut, id, true, outline.points.clone()));
        }
        for (k, (outline, point)) in seam_ends(piece).into_iter().enumerate() {
            let points = tick(&piece.outlines[outline].points, point);
            self.lines.push(line(Layer::Internal, format!("{name}-tick-{}", k + 1), false, points));
        }
        let mut text = |layer, id, seam, (at, height), text| {
            let piece = Some(index);
            self.texts.push(Text { layer, id, piece, seam, at, is_left: false, height, text });
        };
        let mut labels = Labels::new(piece);
        let mut lines =
            vec![name.clone(), format!("{}/{}", piece.patch + 1, self.pattern.patch_count)];
        if piece.crossings > 0 {
            lines.push("outline crosses itself".to_owned());
        }
        let places = labels.place_name(&lines);
        for ((line, place), id) in lines.into_iter().zip(places).zip(["name", "number", "warning"])
        {
            text(Layer::Text, format!("{name}-{id}"), None, place, line);
        }
        for (k, seam) in piece.seams.iter().enumerate() {
            let label = piece.seam_label(seam);
            let is_second = seam.partner == Partner::Own { is_second: true };
            let id = format!("{name}-seam-{}{}", seam.number, if is_second { "-b" } else { "" });
            text(Layer::Text, id, Some(k), labels.place_beside(seam, &label), label);
        }
    }

    fn draw_control(&mut self, margin: f64, footer: Vec<(String, f64)>) {
        let (low, high) = (margin, margin + SQUARE);
        self.lines.push(Line {
            layer: Layer::Control,
            id: "control-square".into(),
            piece: None,
            seam: None,
            is_closed: true,
            curve: Vec::new(),
            points: vec![[low, low], [high, low], [high, high], [low, high]],
        });
        let mut text = |id: String, at, is_left, height, text| {
            let layer = Layer::Control;
            self.texts.push(Text { layer, id, piece: None, seam: None, at, is_left, height, text });
        };
        let middle = 0.5 * (low + high);
        text("control-label".into(), [middle; 2], false, 3.0, "50 mm × 50 mm".into());
        let mut y = high;
        for (k, (words, height)) in footer.into_iter().enumerate() {
            y -= height;
            text(format!("title-{}", k + 1), [high + 5.0, y], true, height, words);
            y -= height;
        }
    }
}

impl Pattern {
    /// Moves all pieces.
    fn translate(&mut self, by: [f64; 2]) {
        for piece in &mut self.pieces {
            piece.translate(by);
        }
        let Self { bounds, .. } = self;
        for p in [&mut bounds.low, &mut bounds.high] {
            *p = [p[0] + by[0], p[1] + by[1]];
        }
    }
}

/// The lines beside the control square and their heights.
fn footer(pattern: &Pattern, params: &SheetParams) -> Vec<(String, f64)> {
    let count = pattern.pieces.len();
    let [width, height] = pattern.bounds.high;
    let mut lines = vec![
        (params.title.clone(), 5.0),
        (
            format!(
                "{count} piece{}, {width:.0} × {height:.0} mm",
                if count == 1 { "" } else { "s" }
            ),
            3.0,
        ),
    ];
    if let Some(mm) = params.mm_per_model_unit {
        // Four significant digits.
        let digits = [1000.0, 100.0, 10.0, 1.0].iter().filter(|&&limit| mm < limit).count();
        let mm = millimetre_text(format!("{mm:.digits$}").parse().unwrap_or(mm));
        lines.push((format!("1 unit of the model = {mm} mm"), 3.0));
    }
    lines.push(("Print at 100 %: the square measures 50 mm".into(), 3.0));
    lines.push(("Outer side up. 3 > B: seam 3, sewn to piece B".into(), 3.0));
    lines
}
