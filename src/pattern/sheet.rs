//! What is drawn of a pattern: lines and texts in layers, the same for every drawing format.

use super::blank::{Blank, seam_id};
use super::grain::{Grain, GrainParams, grain as grain_line};
use super::labels::{Labels, text_width};
use super::nesting::NestPose;
use super::number::millimetre_text;
use super::piece::{Bounds, Pattern, Piece};

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
    /// Names and numbers of pieces.
    pub piece_labels: bool,
    /// What seams are sewn to.
    pub seam_labels: bool,
    /// How pieces have to stretch and bend.
    pub hints: bool,
    /// Grain lines.
    pub grain: Option<GrainParams>,
}

impl Default for SheetParams {
    fn default() -> Self {
        Self {
            title: "Pattern".into(),
            mm_per_model_unit: None,
            margin_mm: 10.0,
            piece_labels: true,
            seam_labels: true,
            hints: false,
            grain: None,
        }
    }
}

/// A piece where it lies on the stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Index of its blank.
    pub blank: usize,
    /// Which copy of the piece it is, from 0, and of how many.
    pub copy: [usize; 2],
    /// Turned over first.
    pub is_mirrored: bool,
    /// Where on its sheet.
    pub pose: NestPose,
}

/// Side of the control square.
const SQUARE: f64 = 50.0;
/// Between the pieces and what stands below them.
const GAP: f64 = 10.0;
/// Between two sheets of stock.
const BETWEEN: f64 = 20.0;

impl Sheet {
    /// Lays out title, control square, names and seam labels around the pieces.
    ///
    /// **Takes** pieces made ready, where they lie, and the sizes of the sheets of stock that they lie on, which are put side by side; none where
    /// there is one sheet without limits. **Costs** O(n).
    pub fn new(
        blanks: &[Blank],
        placed: &[Placed],
        stock: &[[f64; 2]],
        params: &SheetParams,
    ) -> Self {
        let mut lefts = vec![0.0];
        for [width, _] in stock {
            lefts.push(lefts[lefts.len() - 1] + width + BETWEEN);
        }
        let shift = |placed: &Placed| {
            let sheet = placed.pose.sheet.min(stock.len().saturating_sub(1));
            NestPose {
                is_mirrored: placed.is_mirrored,
                shift: [placed.pose.shift[0] + lefts[sheet], placed.pose.shift[1]],
                ..placed.pose
            }
        };
        let mut laid: Vec<Blank> =
            placed.iter().map(|placed| blanks[placed.blank].moved(&shift(placed))).collect();
        let frames: Vec<Bounds> = stock
            .iter()
            .zip(&lefts)
            .map(|(&[width, height], &left)| Bounds {
                low: [left, 0.0],
                high: [left + width, height],
            })
            .collect();
        let corners = frames.iter().flat_map(|frame| [frame.low, frame.high]);
        let points = laid.iter().flat_map(|blank| blank.cut.iter().flatten().copied());
        let bounds = Bounds::around(points.chain(corners));
        let [width, height] = [0, 1].map(|a| bounds.high[a] - bounds.low[a]);
        let margin = params.margin_mm;
        let footer = footer(laid.len(), [width, height], params, !frames.is_empty());
        let wanted = footer.iter().map(|(text, height)| SQUARE + 5.0 + text_width(text, *height));
        let inner_width = wanted.fold(width, f64::max);
        // Tenths of millimetres: sizes that people can read.
        let tenths = |x: f64| (10.0 * x).ceil() / 10.0;
        let below = if laid.is_empty() { SQUARE } else { SQUARE + GAP };
        let size = [tenths(inner_width + 2.0 * margin), tenths(height + below + 2.0 * margin)];
        let origin = [margin - bounds.low[0], size[1] - margin - height - bounds.low[1]];
        let to_origin = NestPose { shift: origin, ..NestPose::default() };
        laid.iter_mut().for_each(|blank| *blank = blank.moved(&to_origin));
        let patch_count = laid.iter().map(|blank| blank.piece.patch + 1).max().unwrap_or(0);
        let pieces: Vec<Piece> = laid.iter().map(|blank| blank.piece.clone()).collect();
        let place = |p: [f64; 2]| [p[0] + origin[0], p[1] + origin[1]];
        let mut sheet = Self {
            title: params.title.clone(),
            size,
            pattern: Pattern {
                pieces,
                patch_count,
                bounds: Bounds { low: place(bounds.low), high: place(bounds.high) },
            },
            lines: Vec::new(),
            texts: Vec::new(),
            frames: frames
                .iter()
                .map(|frame| Bounds { low: place(frame.low), high: place(frame.high) })
                .collect(),
        };
        for (index, (blank, placed)) in laid.iter().zip(placed).enumerate() {
            sheet.draw(index, blank, placed, params);
        }
        sheet.draw_frames();
        sheet.draw_control(margin, footer);
        sheet.lines.sort_by_key(|line| line.layer);
        sheet.texts.sort_by_key(|text| text.layer);
        sheet
    }

    fn draw(&mut self, index: usize, blank: &Blank, placed: &Placed, params: &SheetParams) {
        let piece = &blank.piece;
        let [copy, copies] = placed.copy;
        let mut name = piece.name.clone();
        if copy > 0 {
            name += &(copy + 1).to_string();
        }
        if placed.is_mirrored {
            name += "-m";
        }
        self.lines.extend(blank.lines.iter().map(|line| Line {
            id: format!("{name}-{}", line.id),
            piece: Some(index),
            ..line.clone()
        }));
        let mut labels = Labels::new(piece);
        for word in &blank.words {
            labels.take(word.at, &word.text, word.height);
        }
        let mut text = |id: String, seam, (at, height), text| {
            let (layer, piece) = (Layer::Text, Some(index));
            let id = format!("{name}-{id}");
            self.texts.push(Text { layer, id, piece, seam, at, is_left: false, height, text });
        };
        if params.piece_labels {
            let mut lines = vec![
                (piece.name.clone(), "name"),
                (format!("{}/{}", piece.patch + 1, self.pattern.patch_count), "number"),
            ];
            if copies > 1 || placed.is_mirrored {
                let mirrored = if placed.is_mirrored { ", mirrored" } else { "" };
                lines.push((format!("copy {} of {copies}{mirrored}", copy + 1), "copy"));
            }
            if piece.crossings > 0 {
                lines.push(("outline crosses itself".to_owned(), "warning"));
            }
            if placed.pose.is_too_large {
                lines.push(("larger than the material".to_owned(), "large"));
            }
            if params.hints {
                lines.push((blank.hints.to_string(), "hint"));
            }
            let words: Vec<String> = lines.iter().map(|(line, _)| line.clone()).collect();
            let places = labels.place_name(&words);
            for ((line, id), place) in lines.into_iter().zip(places) {
                text(id.to_owned(), None, place, line);
            }
        }
        if let Some(grain) = &params.grain {
            self.grain(&name, index, piece, grain, &mut labels);
        }
        let mut text = |id: String, seam, (at, height), text| {
            let (layer, piece) = (Layer::Text, Some(index));
            let id = format!("{name}-{id}");
            self.texts.push(Text { layer, id, piece, seam, at, is_left: false, height, text });
        };
        if params.seam_labels {
            for (k, seam) in piece.seams.iter().enumerate() {
                let label = piece.seam_label(seam);
                let id = format!("seam-{}", seam_id(seam));
                text(id, Some(k), labels.place_beside(seam, &label), label);
            }
        }
        for word in &blank.words {
            text(word.id.clone(), word.seam, (word.at, word.height), word.text.clone());
        }
    }

    /// A grain line beside the name of its piece.
    fn grain(
        &mut self,
        name: &str,
        index: usize,
        piece: &Piece,
        params: &GrainParams,
        labels: &mut Labels,
    ) {
        let beside = labels.beside_the_name();
        let found = beside.into_iter().filter_map(|x| {
            let found = grain_line(&piece.outlines, [x, piece.centre[1]], params)?;
            labels.is_line_free(found.from, found.to).then_some(found)
        });
        // Where there is no room beside the name it runs through it: that can still be read.
        let longest = found.max_by(|a, b| {
            let length = |grain: &Grain| (grain.to[1] - grain.from[1]).abs();
            length(a).total_cmp(&length(b))
        });
        let Some(found) = longest.or_else(|| grain_line(&piece.outlines, piece.centre, params))
        else {
            return;
        };
        for (k, points) in found.lines().into_iter().enumerate() {
            let id = format!("{name}-grain-{}", k + 1);
            self.lines.push(line(Layer::Grain, id, Some(index), points));
        }
        labels.take_line(found.from, found.to);
    }

    fn draw_frames(&mut self) {
        let several = self.frames.len() > 1;
        for (k, Bounds { low, high }) in self.frames.iter().enumerate() {
            let points = vec![*low, [high[0], low[1]], *high, [low[0], high[1]]];
            let id = format!("stock-{}", k + 1);
            let frame = line(Layer::Control, id.clone(), None, points);
            self.lines.push(Line { is_closed: true, ..frame });
            if several {
                self.texts.push(Text {
                    layer: Layer::Control,
                    id: format!("{id}-label"),
                    piece: None,
                    seam: None,
                    at: [low[0] + 2.0, low[1] - 3.5],
                    is_left: true,
                    height: 2.5,
                    text: format!("sheet {}", k + 1),
                });
            }
        }
    }

    fn draw_control(&mut self, margin: f64, footer: Vec<(String, f64)>) {
        let (low, high) = (margin, margin + SQUARE);
        let points = vec![[low, low], [high, low], [high, high], [low, high]];
        let square = line(Layer::Control, "control-square".into(), None, points);
        self.lines.push(Line { is_closed: true, ..square });
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

/// An open polyline.
fn line(layer: Layer, id: String, piece: Option<usize>, points: Vec<[f64; 2]>) -> Line {
    Line { layer, id, piece, seam: None, is_closed: false, points, curve: Vec::new() }
}

/// The lines beside the control square and their heights.
fn footer(
    count: usize,
    [width, height]: [f64; 2],
    params: &SheetParams,
    has_stock: bool,
) -> Vec<(String, f64)> {
    let plural = if count == 1 { "" } else { "s" };
    let stock = if has_stock { " of material" } else { "" };
    let mut lines = vec![
        (params.title.clone(), 5.0),
        (format!("{count} piece{plural}, {width:.0} × {height:.0} mm{stock}"), 3.0),
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
