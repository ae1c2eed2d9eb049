//! SVG in real size.
//!
//! One user unit is one millimetre: width and height of the root are millimetres, with the same decimals in its `viewBox`. y
//! is turned over point by point; there is no transform anywhere, because cutters' programs drop them. Each [`Layer`] is a group
//! that drawing programs show as a layer; lines are styled by attributes, which every program reads. A piece's outline is a
//! closed path `M … Z` of its own with the id `A-cut`; `data-` attributes keep the names of piece, seam and
//! partner.

use super::number::{millimetre_text, millimetres};
use super::piece::piece_name;
use super::seam::Partner;
use super::sheet::{Layer, Line, Sheet, Text};

/// The bytes of an SVG file of the sheet.
pub fn svg(sheet: &Sheet) -> Vec<u8> {
    let [width, height] = sheet.size.map(millimetre_text);
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" \
         xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
         width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">\n"
    );
    if let Some(title) = sheet.texts.iter().find(|text| text.id == "title-1") {
        out += &format!("<title>{}</title>\n", escape(&title.text));
    }
    out += "<desc>Made by Cutflow. Millimetres; pieces seen from the outer side.</desc>\n";
    for layer in Layer::ALL {
        if !sheet.lines.iter().any(|line| line.layer == layer)
            && !sheet.texts.iter().any(|text| text.layer == layer)
        {
            continue;
        }
        let Style { id, label, stroke, width } = style(layer);
        out += &format!(
            "<g id=\"{id}\" class=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{label}\" \
             fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{width}\" stroke-linejoin=\"round\" \
             stroke-linecap=\"round\">\n"
        );
        for line in sheet.lines.iter().filter(|line| line.layer == layer) {
            write_line(&mut out, sheet, line);
        }
        for text in sheet.texts.iter().filter(|text| text.layer == layer) {
            write_text(&mut out, sheet, text, stroke);
        }
        out += "</g>\n";
    }
    out += "</svg>\n";
    out.into_bytes()
}

struct Style {
    id: &'static str,
    label: &'static str,
    stroke: &'static str,
    width: &'static str,
}

fn style(layer: Layer) -> Style {
    let (id, label, stroke, width) = match layer {
        Layer::Cut => ("cut", "CUT", "#000000", "0.25"),
        Layer::Sew => ("sew", "SEW", "#2f6fb5", "0.18"),
        Layer::Notch => ("notch", "NOTCH", "#000000", "0.25"),
        Layer::Grain => ("grain", "GRAIN", "#5b616c", "0.18"),
        Layer::FoldMountain => ("fold_m", "FOLD_M", "#5b616c", "0.18"),
        Layer::FoldValley => ("fold_v", "FOLD_V", "#5b616c", "0.18"),
        Layer::Score => ("score", "SCORE", "#5b616c", "0.18"),
        Layer::Drill => ("drill", "DRILL", "#5b616c", "0.18"),
        Layer::Internal => ("internal", "INTERNAL", "#5b616c", "0.18"),
        Layer::Text => ("text", "TEXT", "#1b1d22", "0.18"),
        Layer::Control => ("control", "CONTROL", "#5b616c", "0.25"),
    };
    Style { id, label, stroke, width }
}

fn write_line(out: &mut String, sheet: &Sheet, line: &Line) {
    // Points that fall together when rounded would make sides without length.
    let mut points: Vec<[String; 2]> = line
        .points
        .iter()
        .map(|&[x, y]| [millimetre_text(x), millimetre_text(sheet.size[1] - y)])
        .collect();
    points.dedup();
    if line.is_closed && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    *out += &format!("<path id=\"{}\"", line.id);
    if let Some(piece) = line.piece {
        let piece = &sheet.pattern.pieces[piece];
        *out += &format!(" data-piece=\"{}\"", piece.name);
        if line.layer == Layer::Cut {
            let numbers: Vec<String> = piece.seams.iter().map(|s| s.number.to_string()).collect();
            let area = millimetre_text(piece.area_mm2);
            *out += &format!(" data-seams=\"{}\" data-area-mm2=\"{area}\"", numbers.join(" "));
        }
    }
    *out += " d=\"M";
    for (i, [x, y]) in points.iter().enumerate() {
        *out += if i == 1 { " L " } else { " " };
        *out += &format!("{x},{y}");
    }
    *out += if line.is_closed { " Z\"/>\n" } else { "\"/>\n" };
}

fn write_text(out: &mut String, sheet: &Sheet, text: &Text, colour: &str) {
    let [x, y] = text.at;
    *out += &format!("<text id=\"{}\"", text.id);
    if let Some(piece) = text.piece {
        let piece = &sheet.pattern.pieces[piece];
        *out += &format!(" data-piece=\"{}\"", piece.name);
        if let Some(seam) = text.seam.map(|seam| &piece.seams[seam]) {
            let partner = match seam.partner {
                Partner::Patch(patch) => piece_name(patch),
                Partner::Own { .. } => piece.name.clone(),
            };
            let [flat, surface] = [seam.length_mm, seam.surface_length_mm].map(millimetre_text);
            *out += &format!(
                " data-seam=\"{}\" data-partner=\"{partner}\" data-length-mm=\"{flat}\" \
                 data-surface-length-mm=\"{surface}\"",
                seam.number
            );
        }
    }
    *out += " x=\"";
    millimetres(out, x);
    *out += "\" y=\"";
    // The baseline; capitals are 0.72 of the font size high in the usual sans-serif fonts.
    millimetres(out, sheet.size[1] - y + 0.5 * text.height);
    let anchor = if text.is_left { "start" } else { "middle" };
    let font_size = millimetre_text(text.height / 0.72);
    *out += &format!(
        "\" font-family=\"sans-serif\" font-size=\"{font_size}\" text-anchor=\"{anchor}\" \
         fill=\"{colour}\" stroke=\"none\">{}</text>\n",
        escape(&text.text)
    );
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
