//! Pages: real size, nothing lost between them, nothing printed in vain.

use std::collections::{BTreeMap, BTreeSet};

use cutflow::pattern::{Layer, Orientation, Paper, PdfParams, Picture, WriteError, pdf, tiles};

use super::sheets::round_pieces;
use super::{hollow, small};

/// Bytes as text, each as long as it was.
fn latin(bytes: &[u8]) -> String {
    bytes.iter().map(|&b| if b.is_ascii() { char::from(b) } else { '?' }).collect()
}

/// Objects of a document by number, streams left compressed, each where the table of the document says.
fn objects(bytes: &[u8]) -> BTreeMap<usize, Vec<u8>> {
    let text = latin(bytes);
    let table = text.rfind("\nxref").unwrap() + 1;
    let start: usize =
        text[text.rfind("startxref").unwrap() + 10..].lines().next().unwrap().parse().unwrap();
    assert_eq!(start, table);
    let mut out = BTreeMap::new();
    for (number, row) in text[table..].lines().skip(2).enumerate() {
        let words: Vec<&str> = row.split_whitespace().collect();
        let [offset, _, kind] = words[..] else { break };
        if kind == "n" {
            let offset: usize = offset.parse().unwrap();
            assert!(text[offset..].starts_with(&format!("{number} 0 obj")), "{number}");
            let end = offset + text[offset..].find("endobj").unwrap();
            out.insert(number, bytes[offset..end].to_vec());
        }
    }
    out
}

/// The contents of each page.
fn contents(bytes: &[u8]) -> Vec<String> {
    let objects = objects(bytes);
    let pages =
        objects.values().map(|object| latin(object)).filter(|t| t.contains("/Type /Page\n"));
    let pages = pages.map(|page| {
        let rest = page.split("/Contents ").nth(1).unwrap().to_owned();
        let number: usize = rest.split(' ').next().unwrap().parse().unwrap();
        let object = &objects[&number];
        let from = latin(object).find("stream\n").unwrap() + 7;
        let inflated = miniz_oxide::inflate::decompress_to_vec_zlib(&object[from..]).unwrap();
        String::from_utf8(inflated).unwrap()
    });
    pages.collect()
}

#[test]
fn a_document_has_layers_real_size_and_the_same_bytes_each_time() {
    let sheet = small();
    let params = PdfParams::default();
    let bytes = pdf(&sheet, &params).unwrap();
    assert_eq!(bytes, pdf(&sheet, &params).unwrap());
    let text = latin(&bytes);
    assert!(text.starts_with("%PDF-1.6") && text.contains("/PrintScaling /None"));
    assert!(!text.contains("Date") && !text.contains("UserUnit"));
    for layer in Layer::ALL {
        assert!(text.contains(&format!("/Name ({})", layer.id().to_uppercase())));
    }
    // Another sheet, another id.
    let id = |text: &str| text[text.find("/ID").unwrap()..].to_owned();
    let mut other = sheet.clone();
    other.title += "!";
    let other = latin(&pdf(&other, &params).unwrap());
    assert_ne!(id(&text), id(&other));
    let pages = contents(&bytes);
    let tiles = tiles(&sheet, &params).unwrap();
    assert_eq!(pages.len(), 2 + tiles.len());
    for page in &pages {
        assert!(page.starts_with("2.834645669 0 0 2.834645669 0 0 cm\n"));
        assert!(!page.contains("NaN") && !page.contains("inf"));
        let count = |operator: &str| page.lines().filter(|l| l.ends_with(operator)).count();
        assert_eq!(count("BDC"), count("EMC"));
        let words = |word: &str| page.lines().filter(|&line| line == word).count();
        assert_eq!(words("q"), words("Q"));
    }
    // Each page of the sheet has a control square of exactly 50 mm.
    for page in &pages[2..] {
        assert!(has_square(page, 50.0));
    }
    assert!(has_square(&pages[0], 50.0) && has_square(&pages[0], 50.8));
}

/// Whether a closed path is an upright square of that side.
fn has_square(page: &str, side: f64) -> bool {
    let lines: Vec<&str> = page.lines().collect();
    let point = |line: &str, end: &str| -> Option<[f64; 2]> {
        let mut numbers = line.strip_suffix(end)?.split_whitespace().map(|w| w.parse().ok());
        Some([numbers.next()??, numbers.next()??])
    };
    lines.windows(5).any(|w| {
        let corners = [point(w[0], " m"), point(w[1], " l"), point(w[2], " l"), point(w[3], " l")];
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return false };
        let same = |x: f64, y: f64| (x - y).abs() < 1.5e-4;
        w[4] == "s"
            && same(b[0] - a[0], side)
            && same(c[1] - b[1], side)
            && same(a[1], b[1])
            && same(d[0], a[0])
            && same(d[1], c[1])
    })
}

#[test]
fn pages_cover_all_ink_and_only_needed_ones_are_printed() {
    let sheet = round_pieces(4, 2, 100.0, 96);
    for paper in [Paper::A4, Paper::A3, Paper::Letter, Paper::Roll { width_mm: 300.0 }] {
        for overlap_mm in [0.0, 12.0] {
            let params =
                PdfParams { paper, overlap_mm, keep_inner_pages: false, ..PdfParams::default() };
            let tiles = tiles(&sheet, &params).unwrap();
            let shows = |p: &[f64; 2]| {
                tiles
                    .iter()
                    .filter(|t| (0..2).all(|a| p[a] >= t.low[a] && p[a] <= t.high[a]))
                    .count()
            };
            let pieces = sheet.lines.iter().filter(|line| line.piece.is_some());
            let points: Vec<[f64; 2]> = pieces.flat_map(|line| line.points.clone()).collect();
            assert!(points.iter().all(|p| shows(p) > 0), "{paper:?}");
            let size = |k: usize| [0, 1].map(|a| tiles[k].high[a] - tiles[k].low[a]);
            for (k, tile) in tiles.iter().enumerate() {
                assert!((0..2).all(|a| (size(k)[a] - size(0)[a]).abs() < 1e-9));
                // Neighbours overlap by what was asked for.
                for other in
                    tiles.iter().filter(|o| o.row == tile.row && o.column == tile.column + 1)
                {
                    assert!((tile.high[0] - other.low[0] - overlap_mm).abs() < 1e-9);
                }
                for other in
                    tiles.iter().filter(|o| o.column == tile.column && o.row == tile.row + 1)
                {
                    assert!((other.high[1] - tile.low[1] - overlap_mm).abs() < 1e-9);
                }
            }
            let names: BTreeSet<&str> = tiles.iter().map(|t| t.name.as_str()).collect();
            assert_eq!(names.len(), tiles.len());
        }
    }
}

#[test]
fn pages_inside_a_piece_are_kept_if_asked_for() {
    let sheet = hollow(700.0);
    let count = |keep_inner_pages| {
        let orientation = Orientation::Portrait;
        let params = PdfParams { keep_inner_pages, orientation, ..PdfParams::default() };
        let tiles = tiles(&sheet, &params).unwrap();
        let rows = tiles.iter().map(|t| t.row).max().unwrap() + 1;
        let columns = tiles.iter().map(|t| t.column).max().unwrap() + 1;
        (tiles.len(), rows, columns)
    };
    // 702 mm across: ⌈(702 − 12) / 178⌉ = 4 columns, ⌈(702 − 12) / 256⌉ = 3 rows.
    assert_eq!(count(true), (12, 3, 4));
    assert_eq!(count(false), (10, 3, 4));
}

#[test]
fn marks_are_the_same_on_both_pages_and_only_between_printed_ones() {
    let sheet = hollow(300.0);
    let params =
        PdfParams { orientation: Orientation::Portrait, has_cover: false, ..PdfParams::default() };
    let tiles = tiles(&sheet, &params).unwrap();
    assert_eq!(tiles.len(), 4);
    let pages = contents(&pdf(&sheet, &params).unwrap());
    // Letters a to d, each on the two pages that meet there, and the middles of their marks at one place of the sheet.
    let pages = &pages[pages.len() - 4..];
    let mut places: BTreeMap<char, Vec<[f64; 2]>> = BTreeMap::new();
    for (tile, page) in tiles.iter().zip(pages) {
        let lines: Vec<&str> = page.lines().collect();
        for (k, line) in lines.iter().enumerate() {
            let Some(hex) = line.strip_prefix('<').and_then(|l| l.strip_suffix("> Tj ET")) else {
                continue;
            };
            if hex.len() != 2 {
                continue;
            }
            let letter = char::from(u8::from_str_radix(hex, 16).unwrap());
            let numbers: Vec<f64> =
                lines[k - 1].split(' ').filter_map(|word| word.parse().ok()).collect();
            let at = [numbers[0] - 10.0 + tile.low[0], numbers[1] - 10.0 + tile.low[1]];
            places.entry(letter).or_default().push(at);
        }
    }
    assert_eq!(places.keys().collect::<String>(), "abcd");
    for both in places.values() {
        assert_eq!(both.len(), 2);
        // Four decimals.
        assert!((0..2).all(|a| (both[0][a] - both[1][a]).abs() < 2e-4), "{both:?}");
    }
}

#[test]
fn one_page_is_the_sheet_and_what_is_longer_than_a_page_can_be_is_split() {
    let sheet = small();
    let params = PdfParams { paper: Paper::OnePage, ..PdfParams::default() };
    let one = tiles(&sheet, &params).unwrap();
    assert_eq!((one.len(), one[0].low, one[0].high), (1, [0.0; 2], sheet.size));
    let long = round_pieces(60, 60, 50.0, 24);
    for paper in [Paper::OnePage, Paper::Roll { width_mm: 160.0 }] {
        let params = PdfParams { paper, ..PdfParams::default() };
        assert_eq!(tiles(&long, &params).unwrap().len(), 2);
        let text = latin(&pdf(&long, &params).unwrap());
        let boxes = text.split("/MediaBox [").skip(1).map(|rest| {
            let numbers =
                rest[..rest.find(']').unwrap()].split(' ').map(|w| w.parse::<f64>().unwrap());
            numbers.fold(0.0, f64::max)
        });
        // Readers take 14400 points.
        assert!(boxes.into_iter().all(|longest| longest <= 14400.1));
    }
}

#[test]
fn layers_can_be_left_out_and_a_picture_stands_on_the_cover() {
    let sheet = small();
    let picture = Picture { width: 2, height: 1, rgb: vec![0, 1, 2, 3, 4, 5] };
    let layers = vec![Layer::Cut];
    let params = PdfParams { layers, picture: Some(picture.clone()), ..PdfParams::default() };
    let bytes = pdf(&sheet, &params).unwrap();
    let pages = contents(&bytes);
    assert!(pages[0].contains("/Im0 Do") && !pages[1].contains("/Im0 Do"));
    assert!(pages[2..].iter().all(|page| page.contains("/OC0 BDC") && !page.contains("/OC1 BDC")));
    let wrong = Picture { rgb: vec![0; 5], ..picture };
    let params = PdfParams { picture: Some(wrong), ..PdfParams::default() };
    let error = WriteError::NoPicture { width: 2, height: 1, bytes: 5 };
    assert_eq!(pdf(&sheet, &params), Err(error));
}
