//! Pieces made ready for the workshop: cut lines with allowance, flaps and notches, and every line inside them, before they
//! are laid on a sheet.
//!
//! Guaranteed: without allowance, flaps, kerf and smooth curves the cut lines are the outlines bit for bit; what is asked for and cannot be had
//! is told. Not guaranteed: that allowances or flaps of different pieces fit beside each other; that is the business of
//! [`nesting`](super::nesting).

use std::collections::BTreeMap;

use super::allowance::{AllowanceParams, CutLines, cut_lines, darts, draw_clips, draw_darts};
use super::curve::{corners, fit, turns};
use super::flaps::{Flap, FlapParams, cut_with_flaps, flap_labels, flaps};
use super::folds::{Fold, FoldParams, fold_layer, folds};
use super::hints::{Ease, HintParams, PieceHints, hints};
use super::kerf::kerf;
use super::laid::LaidSurface;
use super::marks::{Mark, MarkParams, marks};
use super::notches::{NotchParams, NotchPlan, draw, plan, with_outward};
use super::piece::{Pattern, Piece};
use super::seam::Seam;
use super::sheet::{Layer, Line};

/// What a person asks of the pieces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlankParams {
    /// What is left outside the sewing line, mm.
    pub allowance_mm: f64,
    /// Other allowances, by the number of the seam.
    pub seam_allowances: BTreeMap<usize, f64>,
    /// Whether the rim of the surface itself has none.
    pub bare_rim: bool,
    /// How allowances go around corners.
    pub allowance: AllowanceParams,
    /// Balance marks.
    pub notches: Option<NotchParams>,
    /// Fold lines.
    pub folds: Option<FoldParams>,
    /// Glue flaps: in place of allowances.
    pub flaps: Option<FlapParams>,
    /// Ends of seams, tips of darts, places where several pieces meet.
    pub marks: Option<MarkParams>,
    /// Width of what the tool takes away, mm.
    pub kerf_mm: f64,
    /// How far smooth curves may be off, mm; without it outlines are exact polylines.
    pub curve_tolerance_mm: Option<f64>,
}

/// A piece with all its lines, in the frame of its chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Blank {
    /// The piece itself.
    pub piece: Piece,
    /// What is cut: the outer outline counter-clockwise, then holes clockwise.
    pub cut: Vec<Vec<[f64; 2]>>,
    /// All lines; their ids lack the name of the piece.
    pub lines: Vec<Line>,
    /// Words that have a place of their own: numbers on flaps and at junctions.
    pub words: Vec<Word>,
    /// How it has to stretch and bend.
    pub hints: PieceHints,
}

/// A word at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// Unique in the piece.
    pub id: String,
    /// Index of the seam.
    pub seam: Option<usize>,
    /// Its middle.
    pub at: [f64; 2],
    /// Height of the capitals, mm.
    pub height: f64,
    /// What it says.
    pub text: String,
}

/// All pieces of a pattern, made ready.
#[derive(Clone, Debug, PartialEq)]
pub struct Blanks {
    /// In the order of the pattern's pieces.
    pub pieces: Vec<Blank>,
    /// Where notches stand, by the number of the seam.
    pub notches: NotchPlan,
    /// Lengths of both sides of every seam.
    pub seams: Vec<Ease>,
    /// What a person should know before cutting.
    pub notices: Vec<String>,
}

/// Makes the pieces of a pattern ready.
///
/// **Takes** what the pattern was made of, and the pattern itself, not moved since. **Costs** O(n log n).
pub fn blanks(surface: &LaidSurface, pattern: &Pattern, params: &BlankParams) -> Blanks {
    let folds_of = folds(surface, pattern, &params.folds.unwrap_or_default());
    let mut notices: Vec<String> = Vec::new();
    let no_flaps = || vec![Vec::new(); pattern.pieces.len()];
    let flaps_of = params.flaps.as_ref().map_or_else(no_flaps, |asked| {
        let (flaps, told) = flaps(surface, pattern, &folds_of, asked);
        notices.extend(told.iter().map(ToString::to_string));
        flaps
    });
    let labels = flap_labels(pattern, &flaps_of);
    let marks_of = params.marks.as_ref().map(|asked| marks(surface, pattern, asked));
    let notch_plan = params.notches.as_ref().map(|asked| plan(pattern, asked));
    let notch_plan = notch_plan.unwrap_or_default();
    notices.extend(notch_plan.notices.iter().map(ToString::to_string));
    let told = hints(surface, pattern, &HintParams::default());
    let mut pieces = Vec::new();
    for (index, (piece, hints)) in pattern.pieces.iter().zip(told.pieces).enumerate() {
        let mut maker = Maker { piece, params, lines: Vec::new(), notices: &mut notices };
        let cut = maker.outlines(&flaps_of[index], &notch_plan);
        if params.folds.is_some() {
            maker.folds(&folds_of[index]);
        }
        let mut words = Vec::new();
        if let Some(marks) = &marks_of {
            maker.marks(&marks[index], &mut words);
        }
        for (k, label) in labels.iter().filter(|label| label.piece == index).enumerate() {
            words.push(Word {
                id: format!("flap-{}", k + 1),
                seam: Some(label.seam),
                at: label.at,
                height: label.height,
                text: label.text.clone(),
            });
        }
        pieces.push(Blank { piece: piece.clone(), cut, lines: maker.lines, words, hints });
    }
    Blanks { pieces, notches: notch_plan, seams: told.seams, notices }
}

/// Makes one piece ready.
struct Maker<'a> {
    piece: &'a Piece,
    params: &'a BlankParams,
    lines: Vec<Line>,
    notices: &'a mut Vec<String>,
}

impl Maker<'_> {
    /// Cut line, sewing lines, notches. **Gives** what is cut.
    fn outlines(&mut self, flaps: &[Flap], notches: &NotchPlan) -> Vec<Vec<[f64; 2]>> {
        let piece = self.piece;
        let mut cut = if self.params.flaps.is_some() {
            for (k, flap) in flaps.iter().enumerate() {
                let points =
                    piece.outlines[flap.base.outline].run(flap.base.first, flap.base.sides);
                let least = self.params.folds.unwrap_or_default().least_angle;
                let layer = fold_layer(flap.angle, least);
                self.push(layer, format!("base-{}", k + 1), Some(flap.base.seam), false, points);
            }
            CutLines { outlines: cut_with_flaps(piece, flaps), ..CutLines::default() }
        } else {
            let widths = self.widths();
            let cut = cut_lines(piece, &widths, &self.params.allowance);
            let widest = widths.iter().flatten().copied().fold(0.0, f64::max);
            if widest > 2.0 * piece.room_mm {
                self.notices.push(format!(
                    "an allowance of {widest:.1} mm is wider than the piece {} itself",
                    piece.name
                ));
            }
            if widths.iter().flatten().any(|&width| width > 0.0) {
                self.sewing_lines(&widths);
                let legs = draw_darts(0, piece, &darts(piece, &widths));
                // Tips are among the marks.
                self.take(legs.into_iter().filter(|line| line.layer == Layer::Internal));
                if self.params.marks.is_some() {
                    self.take(draw_clips(0, piece, &widths, &cut));
                }
            }
            cut
        };
        if let Some(params) = &self.params.notches {
            self.take(draw(0, piece, notches, &cut, params));
            cut = with_outward(piece, notches, &cut, params);
        }
        self.notices.extend(cut.notices.iter().map(ToString::to_string));
        let mut outlines = cut.outlines;
        if self.params.kerf_mm > 0.0 {
            outlines = kerf(&outlines, self.params.kerf_mm);
        }
        let is_own = outlines.len() == piece.outlines.len()
            && outlines.iter().zip(&piece.outlines).all(|(cut, own)| *cut == own.points);
        let mut kept = Vec::new();
        for (k, points) in outlines.into_iter().enumerate() {
            let id = if k == 0 { "cut".to_owned() } else { format!("hole-{k}") };
            let corners = if is_own { corners(piece, k) } else { turns(&points, true) };
            kept.push(self.curved(Layer::Cut, id, None, true, points, &corners));
        }
        for (k, slit) in cut.slits.into_iter().enumerate() {
            self.push(Layer::Cut, format!("slit-{}", k + 1), None, false, slit);
        }
        kept
    }

    /// What is left outside each side of each outline.
    fn widths(&self) -> Vec<Vec<f64>> {
        let BlankParams { allowance_mm, seam_allowances, bare_rim, .. } = self.params;
        let rim = if *bare_rim { 0.0 } else { *allowance_mm };
        let outlines = self.piece.outlines.iter();
        let mut widths: Vec<Vec<f64>> = outlines.map(|o| vec![rim; o.points.len()]).collect();
        for seam in &self.piece.seams {
            let width = seam_allowances.get(&seam.number).unwrap_or(allowance_mm);
            let row = &mut widths[seam.outline];
            let n = row.len();
            for side in seam.first..seam.first + seam.sides {
                row[side % n] = *width;
            }
        }
        widths
    }

    /// The line of each seam, and the rim where it has an allowance: a line for each stretch of it.
    fn sewing_lines(&mut self, widths: &[Vec<f64>]) {
        let piece = self.piece;
        for (index, seam) in piece.seams.iter().enumerate() {
            let mut points = piece.seam_points(seam);
            if seam.is_closed {
                points.pop();
            }
            let id = format!("sew-{}", seam_id(seam));
            let corners = turns(&points, seam.is_closed);
            self.curved(Layer::Sew, id, Some(index), seam.is_closed, points, &corners);
        }
        let mut number = 0;
        for (index, outline) in piece.outlines.iter().enumerate() {
            let n = outline.points.len();
            let mut is_sewn = vec![false; n];
            for seam in piece.seams.iter().filter(|seam| seam.outline == index) {
                (seam.first..seam.first + seam.sides).for_each(|side| is_sewn[side % n] = true);
            }
            if is_sewn.iter().all(|&sewn| sewn) || widths[index].iter().all(|&w| w <= 0.0) {
                continue;
            }
            let starts: Vec<usize> =
                (0..n).filter(|&i| !is_sewn[i] && is_sewn[(i + n - 1) % n]).collect();
            let runs: Vec<(usize, usize)> = if starts.is_empty() {
                vec![(0, n)]
            } else {
                let end = |&i: &usize| (1..n).take_while(|k| !is_sewn[(i + k) % n]).count() + 1;
                starts.iter().map(|i| (*i, end(i))).collect()
            };
            for (first, sides) in runs {
                if widths[index][first] <= 0.0 {
                    continue;
                }
                number += 1;
                let is_closed = sides == n;
                let mut points = outline.run(first, sides);
                if is_closed {
                    points.pop();
                }
                let corners = turns(&points, is_closed);
                let id = format!("hem-{number}");
                self.curved(Layer::Sew, id, None, is_closed, points, &corners);
            }
        }
    }

    fn folds(&mut self, folds: &[Fold]) {
        for (k, fold) in folds.iter().enumerate() {
            let id = format!("fold-{}", k + 1);
            self.push(fold.layer(), id, None, false, fold.points.clone());
        }
    }

    fn marks(&mut self, marks: &[Mark], words: &mut Vec<Word>) {
        for (k, mark) in marks.iter().enumerate() {
            for (j, (is_closed, points)) in mark.lines.iter().enumerate() {
                let id = format!("mark-{}-{}", k + 1, j + 1);
                self.push(mark.layer, id, None, *is_closed, points.clone());
            }
            if let Some((at, height, text)) = &mark.text {
                let id = format!("junction-{}", k + 1);
                let (at, height, text) = (*at, *height, text.clone());
                words.push(Word { id, seam: None, at, height, text });
            }
        }
    }

    /// Takes lines that carry the name of the piece.
    fn take(&mut self, lines: impl IntoIterator<Item = Line>) {
        let name = format!("{}-", self.piece.name);
        self.lines.extend(lines.into_iter().map(|line| Line {
            id: line.id.strip_prefix(&name).unwrap_or(&line.id).to_owned(),
            piece: None,
            ..line
        }));
    }

    fn push(
        &mut self,
        layer: Layer,
        id: String,
        seam: Option<usize>,
        is_closed: bool,
        points: Vec<[f64; 2]>,
    ) {
        let curve = Vec::new();
        self.lines.push(Line { layer, id, piece: None, seam, is_closed, points, curve });
    }

    /// A line that is made smooth if that is asked for. **Gives** its points.
    fn curved(
        &mut self,
        layer: Layer,
        id: String,
        seam: Option<usize>,
        is_closed: bool,
        points: Vec<[f64; 2]>,
        corners: &[usize],
    ) -> Vec<[f64; 2]> {
        let (points, curve) = match self.params.curve_tolerance_mm {
            Some(tolerance) => {
                let fitted = fit(&points, is_closed, corners, tolerance);
                (fitted.points, fitted.curve)
            }
            None => (points, Vec::new()),
        };
        let kept = points.clone();
        self.lines.push(Line { layer, id, piece: None, seam, is_closed, points, curve });
        kept
    }
}

/// A seam as a part of an id: its number, and which of the two runs where both are of one piece.
pub(super) fn seam_id(seam: &Seam) -> String {
    use super::seam::Partner;
    let is_second = seam.partner == Partner::Own { is_second: true };
    format!("{}{}", seam.number, if is_second { "-b" } else { "" })
}
