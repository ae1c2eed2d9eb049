//! The dialect for clothing: ASTM D6673, as its readers want it.

use super::groups::Groups;
use super::{AstmParams, cutting_order, lines_of, names, piece_bounds};
use crate::pattern::check::WriteError;
use crate::pattern::drawn::{drawn, twice_area};
use crate::pattern::piece::{Bounds, Piece, length};
use crate::pattern::sheet::{Layer, Line, Sheet};

/// A vertex that turns by more, in radians, is a turn point.
const TURN: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// Height of system texts.
const TEXT: f64 = 5.0;
/// Names of pieces are no longer.
const LONGEST_NAME: usize = 20;
/// A point of an outline this near to the end of a seam is that end, mm.
const SAME: f64 = 1e-3;

/// A contour of a piece: points relative to its corner.
struct Contour {
    points: Vec<[f64; 2]>,
    is_closed: bool,
}

pub(super) fn write(sheet: &Sheet, params: &AstmParams) -> Result<Vec<u8>, WriteError> {
    let mut groups = Groups::default();
    groups.open_section("HEADER");
    if !params.is_gerber {
        groups.word(9, "$ACADVER").word(1, "AC1009");
    }
    groups.close_section();
    let cuts = cutting_order(sheet);
    let pieces = &sheet.pattern.pieces;
    let names: Vec<String> = pieces.iter().map(|piece| piece.name.clone()).collect();
    let names = names::unique(&names);
    let mut inserts = Vec::new();
    groups.open_section("BLOCKS");
    for (index, name) in names.iter().enumerate() {
        let Some(bounds) = piece_bounds(sheet, index) else { continue };
        let lines = lines_of(sheet, &cuts, Some(index));
        let mut block = Block { groups: &mut groups, piece: &pieces[index], bounds };
        block.groups.open_block("1", name);
        block.names(params, index);
        block.lines(&lines).ok_or(WriteError::NoOutline { piece: index })?;
        let own = sheet.texts.iter().filter(|text| text.piece == Some(index));
        for text in own.filter(|text| !text.text.trim().is_empty()) {
            let at = block.place(text.at);
            let left = if text.is_left { 0.0 } else { 0.4 * text.height * text.text.len() as f64 };
            let at = [at[0] - left, at[1] - 0.5 * text.height];
            block.groups.text("15", at, text.height, &text.text);
        }
        groups.close_block("1");
        inserts.push((name, bounds.low));
    }
    groups.close_section();
    groups.open_section("ENTITIES");
    style_texts(&mut groups, sheet, params);
    for (name, at) in inserts {
        groups.insert("1", name, at);
    }
    groups.close_section();
    groups.finish();
    Ok(groups.bytes())
}

/// What the file is, below the sheet.
fn style_texts(groups: &mut Groups, sheet: &Sheet, params: &AstmParams) {
    let texts = [
        format!("Style Name: {}", sheet.title),
        format!("Creation Date: {}", params.date),
        format!("Creation Time: {}", params.time),
        format!("Author: Cutflow;Cutflow;{}", env!("CARGO_PKG_VERSION")),
        format!("Sample Size: {}", size(params)),
        "Grade Rule Table: ".to_owned(),
        "Units: METRIC".to_owned(),
        "Curve Tolerance: 0.1".to_owned(),
        "ASTM/D13Proposal 1 Version: D6673-10".to_owned(),
    ];
    for (k, text) in texts.iter().enumerate() {
        groups.text("1", [0.0, -2.0 * TEXT * (k + 1) as f64], TEXT, text);
    }
}

fn size(params: &AstmParams) -> &str {
    if params.size.is_empty() { "1" } else { &params.size }
}

/// The block of one piece.
struct Block<'a> {
    groups: &'a mut Groups,
    piece: &'a Piece,
    bounds: Bounds,
}

impl Block<'_> {
    fn place(&self, p: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|a| p[a] - self.bounds.low[a])
    }

    fn names(&mut self, params: &AstmParams, index: usize) {
        let name: String = self.piece.name.chars().take(LONGEST_NAME).collect();
        let [plain, mirrored] = params.quantities.get(index).copied().unwrap_or([1, 0]);
        let mut texts = vec![
            format!("Piece Name: {name}"),
            format!("Size: {}", size(params)),
            format!("Quantity: {plain},{mirrored}"),
        ];
        if !params.material.is_empty() {
            texts.push(format!("Material: {}", params.material));
        }
        let [x, y] = self.place(self.piece.centre);
        for (k, text) in texts.iter().enumerate() {
            self.groups.text("1", [x, y - 1.5 * TEXT * k as f64], TEXT, text);
        }
    }

    /// Everything that is drawn of the piece, in the order that readers expect. `None` if it has no closed cut line.
    fn lines(&mut self, lines: &[&Line]) -> Option<()> {
        let contours = |wanted: fn(Layer) -> bool| {
            let lines = lines.iter().filter(move |line| wanted(line.layer));
            let strokes = lines.flat_map(|line| drawn(line));
            let contours: Vec<Contour> = strokes
                .map(|stroke| Contour {
                    points: stroke.points.into_iter().map(|p| self.place(p)).collect(),
                    is_closed: stroke.is_closed,
                })
                .collect();
            contours
        };
        let mut cuts = contours(|layer| layer == Layer::Cut);
        let area = |contour: &Contour| twice_area(&contour.points).abs();
        let closed = (0..cuts.len()).filter(|&i| cuts[i].is_closed);
        let boundary = closed.max_by(|&i, &j| area(&cuts[i]).total_cmp(&area(&cuts[j])))?;
        let mut boundary = cuts.remove(boundary);
        if twice_area(&boundary.points) < 0.0 {
            boundary.points.reverse();
        }
        let sew = contours(|layer| layer == Layer::Sew);
        let inner = contours(|layer| {
            matches!(
                layer,
                Layer::FoldMountain | Layer::FoldValley | Layer::Score | Layer::Internal
            )
        });
        let notches = contours(|layer| layer == Layer::Notch);
        let grain = contours(|layer| layer == Layer::Grain);
        let drills: Vec<[f64; 2]> = lines
            .iter()
            .filter(|line| line.layer == Layer::Drill && !line.points.is_empty())
            .map(|line| {
                let Bounds { low, high } = Bounds::around(line.points.iter().copied());
                self.place([0, 1].map(|a| 0.5 * (low[a] + high[a])))
            })
            .collect();

        let boundary = [boundary];
        self.contours(&boundary, ["1", "84"]);
        self.contours(&sew, ["14", "87"]);
        self.contours(&inner, ["8", "85"]);
        self.contours(&cuts, ["11", "86"]);
        let ends = self.seam_ends();
        for contour in boundary.iter().chain(&sew).chain(&inner).chain(&cuts) {
            for (i, &point) in contour.points.iter().enumerate() {
                let is_turn =
                    turns(contour, i) || ends.iter().any(|&end| length(&[end, point]) < SAME);
                self.groups.point(if is_turn { "2" } else { "3" }, point);
            }
        }
        self.grain(&grain);
        for notch in &notches {
            self.notch(notch, &boundary[0]);
        }
        // Crosses come as two lines with one middle.
        let is_first = |i: usize| drills[..i].iter().all(|&p| length(&[p, drills[i]]) > SAME);
        for i in (0..drills.len()).filter(|&i| is_first(i)) {
            self.groups.point("13", drills[i]);
        }
        Some(())
    }

    /// Each on its layer, and all once more for checking.
    fn contours(&mut self, contours: &[Contour], layers: [&str; 2]) {
        for layer in layers {
            for contour in contours {
                self.groups.polyline(layer, &contour.points, contour.is_closed);
            }
        }
    }

    fn seam_ends(&self) -> Vec<[f64; 2]> {
        let mut ends = Vec::new();
        for seam in &self.piece.seams {
            let Some(outline) = self.piece.outlines.get(seam.outline) else { continue };
            let n = outline.points.len();
            for i in [seam.first, seam.first + seam.sides] {
                ends.extend(outline.points.get(i % n.max(1)).map(|&p| self.place(p)));
            }
        }
        ends
    }

    /// The longest stretch of what is drawn as grain; a vertical line where nothing is.
    fn grain(&mut self, grain: &[Contour]) {
        let sides = grain.iter().flat_map(|contour| contour.points.windows(2));
        let longest = sides.max_by(|a, b| length(a).total_cmp(&length(b)));
        let line = longest.map_or_else(
            || {
                let [x, y] = self.place(self.piece.centre);
                let half = 0.25 * (self.bounds.high[1] - self.bounds.low[1]);
                [[x, y - half], [x, y + half]]
            },
            |side| [side[0], side[1]],
        );
        self.groups.line("7", line);
    }

    /// A point on the boundary with depth, width and the direction into the piece.
    fn notch(&mut self, notch: &Contour, boundary: &Contour) {
        let points = &notch.points;
        let (first, last) = (points[0], points[points.len() - 1]);
        let (foot, tip, width) = if points.len() == 2 {
            let [near, far] = if distance(first, boundary) <= distance(last, boundary) {
                [first, last]
            } else {
                [last, first]
            };
            (near, far, 0.0)
        } else {
            let foot = [0, 1].map(|a| 0.5 * (first[a] + last[a]));
            let far =
                points.iter().max_by(|p, q| length(&[foot, **p]).total_cmp(&length(&[foot, **q])));
            (foot, far.copied().unwrap_or(last), length(&[first, last]))
        };
        let angle = (tip[1] - foot[1]).atan2(tip[0] - foot[0]).to_degrees();
        // V and slit; what has more corners is a T.
        let layer = if points.len() <= 3 { "4" } else { "80" };
        self.groups.word(0, "POINT").word(8, layer).number(10, foot[0]).number(20, foot[1]);
        self.groups.number(30, length(&[foot, tip]));
        if width > 0.0 {
            self.groups.number(39, width);
        }
        self.groups.number(50, if angle < 0.0 { angle + 360.0 } else { angle });
    }
}

/// Whether a contour changes direction at a point by more than a curve does; ends do.
fn turns(contour: &Contour, i: usize) -> bool {
    let n = contour.points.len();
    if !contour.is_closed && (i == 0 || i + 1 == n) {
        return true;
    }
    let [a, b, c] = [(i + n - 1) % n, i, (i + 1) % n].map(|k| contour.points[k]);
    let [u, v] = [[b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]];
    let turn = (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]);
    turn.abs() > TURN
}

/// Distance from a point to the sides of a closed contour.
fn distance(p: [f64; 2], contour: &Contour) -> f64 {
    let points = &contour.points;
    let next = points.iter().cycle().skip(1);
    let sides = points.iter().zip(next);
    sides
        .map(|(&a, &b)| super::super::piece::squared_distance(p, a, b))
        .fold(f64::INFINITY, f64::min)
}
