//! SVG in real size.
//!
//! One user unit is one millimetre: width and height of the root are millimetres, with the same decimals in its `viewBox`. y
//! is turned over point by point; there is no transform anywhere, because cutters' programs drop them. Each [`Layer`] is a group
//! that drawing programs show as a layer; lines are styled by attributes, which every program reads. A piece's outline is a
//! closed path `M … Z` of its own with the id `A-cut`; `data-` attributes keep the names of piece, seam and
//! partner.

use super::check::{WriteError, refuse};
use super::drawn::{cutting_order, drawn, rounded};
use super::number::{millimetre_text, millimetres};
use super::piece::{Piece, length, piece_name};
use super::seam::{Partner, Seam};
use super::sheet::{Layer, Line, Sheet, Text};
use super::stroke_font;
use super::style::{WIDTH, style};

/// What the drawing is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SvgProfile {
    /// Paper: thin lines in quiet colours, dashes for what is not cut, texts as text.
    #[default]
    Print,
    /// A laser cutter: hairlines in the colours that drivers tell cuts from scores by, nothing dashed, texts as strokes, and
    /// lines in an order that they can be cut in.
    Laser,
}

/// How a sheet is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SvgParams {
    /// What for.
    pub profile: SvgProfile,
    /// Other colours than those of the profile.
    pub colours: Vec<(Layer, [u8; 3])>,
    /// Texts as strokes in print too.
    pub text_as_paths: bool,
    /// With a laser: folds and scores as short cuts with bridges between instead of whole lines.
    pub perforation: bool,
    /// Lines are at least as wide, mm: for a look at a whole sheet, on which a hairline cannot be seen.
    pub least_stroke_mm: f64,
}

/// Length of the cuts of a perforation, and of the bridges between.
const PERFORATION: [f64; 2] = [2.0, 2.0];
/// A thousandth of an inch: drivers of lasers cut along lines that are thinner than a few of these, and engrave others.
const HAIRLINE: f64 = 0.0254;

/// The bytes of an SVG file of the sheet.
///
/// **Fails** as [`check`](super::check()) does. **Costs** O(n).
pub fn svg(sheet: &Sheet, params: &SvgParams) -> Result<Vec<u8>, WriteError> {
    refuse(sheet)?;
    let is_laser = params.profile == SvgProfile::Laser;
    let [width, height] = sheet.size.map(millimetre_text);
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" \
         xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
         width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">\n"
    );
    out += &format!("<title>{}</title>\n", escape(&sheet.title));
    out += "<desc>Made by Cutflow. Millimetres; pieces seen from the outer side.</desc>\n";
    let mut layers = Layer::ALL;
    if is_laser {
        // Engraved and scored first, cut last.
        layers.reverse();
    }
    let writer = Writer { sheet, params, is_laser };
    for layer in layers {
        let mut lines: Vec<&Line> = if layer == Layer::Cut && is_laser {
            cutting_order(sheet).into_iter().map(|i| &sheet.lines[i]).collect()
        } else {
            sheet.lines.iter().filter(|line| line.layer == layer).collect()
        };
        lines.retain(|line| !drawn(line).is_empty());
        let mut texts: Vec<&Text> = sheet.texts.iter().filter(|t| t.layer == layer).collect();
        texts.retain(|text| text.text.chars().any(|c| !c.is_whitespace()));
        if lines.is_empty() && texts.is_empty() {
            continue;
        }
        writer.open_group(&mut out, layer);
        for line in lines {
            writer.line(&mut out, line);
        }
        for text in texts {
            writer.text(&mut out, text);
        }
        out += "</g>\n";
    }
    out += "</svg>\n";
    Ok(out.into_bytes())
}

struct Writer<'a> {
    sheet: &'a Sheet,
    params: &'a SvgParams,
    is_laser: bool,
}

impl Writer<'_> {
    fn open_group(&self, out: &mut String, layer: Layer) {
        let style = style(layer);
        let (id, label, stroke) = (style.id, style.label, self.colour(layer));
        let width = if self.is_laser { HAIRLINE } else { WIDTH };
        let width = millimetre_text(width.max(self.params.least_stroke_mm));
        *out += &format!(
            "<g id=\"{id}\" class=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{label}\" \
             fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{width}\" stroke-linejoin=\"round\" \
             stroke-linecap=\"round\""
        );
        if !self.is_laser && !style.dashes.is_empty() {
            let dashes: Vec<String> = style.dashes.iter().map(|&x| millimetre_text(x)).collect();
            *out += &format!(" stroke-dasharray=\"{}\"", dashes.join(" "));
        }
        *out += ">\n";
    }

    fn colour(&self, layer: Layer) -> String {
        let own = self.params.colours.iter().find(|(other, _)| *other == layer);
        let [r, g, b] = match (own, self.is_laser) {
            (Some(&(_, rgb)), _) => rgb,
            (None, false) => style(layer).rgb,
            (None, true) => match layer {
                Layer::Cut => [255, 0, 0],
                _ if self.is_perforated(layer) => [255, 0, 0],
                Layer::Sew
                | Layer::Notch
                | Layer::FoldMountain
                | Layer::FoldValley
                | Layer::Score
                | Layer::Drill => [0, 0, 255],
                Layer::Grain | Layer::Internal | Layer::Text | Layer::Control => [0; 3],
            },
        };
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    fn is_perforated(&self, layer: Layer) -> bool {
        let is_fold = matches!(layer, Layer::FoldMountain | Layer::FoldValley | Layer::Score);
        self.is_laser && self.params.perforation && is_fold
    }

    fn line(&self, out: &mut String, line: &Line) {
        *out += &format!("<path id=\"{}\"", line.id);
        let piece = line.piece.and_then(|piece| self.sheet.pattern.pieces.get(piece));
        self.names(out, piece, line.seam);
        if let Some(piece) = piece.filter(|_| line.layer == Layer::Cut) {
            let numbers: Vec<String> = piece.seams.iter().map(|s| s.number.to_string()).collect();
            let area = millimetre_text(piece.area_mm2);
            *out += &format!(" data-seams=\"{}\" data-area-mm2=\"{area}\"", numbers.join(" "));
        }
        *out += " d=\"";
        if self.is_perforated(line.layer) {
            for stroke in drawn(line) {
                for points in perforated(&stroke.points, stroke.is_closed) {
                    self.polyline(out, &points);
                }
            }
        } else if !line.curve.is_empty() {
            self.curve(out, line);
        } else {
            for stroke in drawn(line) {
                self.polyline(out, &stroke.points);
                *out += if stroke.is_closed { " Z" } else { "" };
            }
        }
        *out += "\"/>\n";
    }

    fn point(&self, out: &mut String, [x, y]: [f64; 2]) {
        out.push(' ');
        millimetres(out, rounded(x));
        out.push(',');
        millimetres(out, self.sheet.size[1] - rounded(y));
    }

    fn polyline(&self, out: &mut String, points: &[[f64; 2]]) {
        *out += if out.ends_with('"') { "M" } else { " M" };
        for (i, &point) in points.iter().enumerate() {
            *out += if i == 1 { " L" } else { "" };
            self.point(out, point);
        }
    }

    fn curve(&self, out: &mut String, line: &Line) {
        let written = |p: [f64; 2]| p.map(|x| rounded(x).to_bits());
        let mut last = line.points[0];
        self.polyline(out, &[last]);
        *out += " C";
        for &[p, q, end] in &line.curve {
            // Without length as written: nothing to draw.
            if [p, q, end].map(written).iter().all(|&r| r == written(last)) {
                continue;
            }
            for r in [p, q, end] {
                self.point(out, r);
            }
            last = end;
        }
        *out += if line.is_closed { " Z" } else { "" };
    }

    /// Piece, seam and partner.
    fn names(&self, out: &mut String, piece: Option<&Piece>, seam: Option<usize>) {
        let Some(piece) = piece else { return };
        *out += &format!(" data-piece=\"{}\"", piece.name);
        if let Some(seam) = seam.and_then(|seam| piece.seams.get(seam)) {
            let [flat, surface] = [seam.length_mm, seam.surface_length_mm].map(millimetre_text);
            let (number, partner) = (seam.number, partner_name(piece, seam));
            *out += &format!(
                " data-seam=\"{number}\" data-partner=\"{partner}\" data-length-mm=\"{flat}\" \
                 data-surface-length-mm=\"{surface}\""
            );
        }
    }

    fn text(&self, out: &mut String, text: &Text) {
        let piece = text.piece.and_then(|piece| self.sheet.pattern.pieces.get(piece));
        if self.is_laser || self.params.text_as_paths {
            *out += &format!("<path id=\"{}\"", text.id);
            self.names(out, piece, text.seam);
            *out += " d=\"";
            for stroke in stroke_font::strokes(&text.text, text.at, text.height, text.is_left) {
                self.polyline(out, &stroke);
            }
            *out += "\"/>\n";
            return;
        }
        *out += &format!("<text id=\"{}\"", text.id);
        self.names(out, piece, text.seam);
        *out += " x=\"";
        millimetres(out, text.at[0]);
        *out += "\" y=\"";
        // The baseline; capitals are 0.72 of the font size high in the usual sans-serif fonts.
        millimetres(out, self.sheet.size[1] - text.at[1] + 0.5 * text.height);
        let anchor = if text.is_left { "start" } else { "middle" };
        let (font_size, colour) = (millimetre_text(text.height / 0.72), self.colour(text.layer));
        *out += &format!(
            "\" font-family=\"sans-serif\" font-size=\"{font_size}\" text-anchor=\"{anchor}\" \
             fill=\"{colour}\" stroke=\"none\">{}</text>\n",
            escape(&text.text)
        );
    }
}

/// The name of the piece that a seam joins to.
pub(super) fn partner_name(piece: &Piece, seam: &Seam) -> String {
    match seam.partner {
        Partner::Patch(patch) => piece_name(patch),
        Partner::Own { .. } => piece.name.clone(),
    }
}

/// Short cuts along a polyline, half a bridge or more at both ends, so that a fold does not tear from the edge on.
fn perforated(points: &[[f64; 2]], is_closed: bool) -> Vec<Vec<[f64; 2]>> {
    let mut points = points.to_vec();
    if is_closed {
        points.extend(points.first().copied());
    }
    let total: f64 = points.windows(2).map(length).sum();
    let [cut, bridge] = PERFORATION;
    // As many cuts as fit, evenly, with bridges no shorter than they should be.
    let count = (total / (cut + bridge)).floor().max(1.0);
    let pitch = total / count;
    let cut = cut.min(0.5 * pitch);
    let mut out = Vec::new();
    let mut next = 0.5 * (pitch - cut);
    let mut open: Option<Vec<[f64; 2]>> = None;
    let mut walked = 0.0;
    for side in points.windows(2) {
        let step = length(side);
        let place = |arc: f64| {
            let t = (arc - walked) / step;
            [0, 1].map(|a| side[0][a] + t * (side[1][a] - side[0][a]))
        };
        if step <= 0.0 {
            continue;
        }
        loop {
            match &mut open {
                None if next <= walked + step => open = Some(vec![place(next)]),
                Some(stroke) if next + cut <= walked + step => {
                    stroke.push(place(next + cut));
                    out.extend(open.take());
                    next += pitch;
                }
                Some(stroke) => {
                    stroke.push(side[1]);
                    break;
                }
                None => break,
            }
        }
        walked += step;
    }
    out
}

/// Text as XML has it; control characters, which XML cannot hold, left out.
fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars().filter(|c| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}')) {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perforation_is_short_cuts_with_bridges_at_both_ends() {
        let cuts = perforated(&[[0.0, 0.0], [10.0, 0.0], [10.0, 11.0]], false);
        assert_eq!(cuts.len(), 5);
        let lengths: Vec<f64> = cuts.iter().map(|c| c.windows(2).map(length).sum()).collect();
        // Rounding of sums about 10.
        assert!(lengths.iter().all(|l| (l - 2.0).abs() < 1e-12), "{lengths:?}");
        assert!(cuts[0][0][0] >= 1.0 && cuts[4][cuts[4].len() - 1][1] <= 10.0);
        // The one in the middle goes round the corner.
        assert!(cuts[2].contains(&[10.0, 0.0]), "{cuts:?}");
        assert_eq!(perforated(&[[0.0, 0.0], [1.0, 0.0]], false), [[[0.25, 0.0], [0.75, 0.0]]]);
    }
}
