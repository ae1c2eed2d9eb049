//! DXF: what its readers stumble over is right.

use std::collections::BTreeSet;

use cutflow::pattern::{AstmParams, DxfParams, Layer, dxf};

use super::small;

/// Codes and values of a file that ends as it should.
fn groups(bytes: &[u8]) -> Vec<(u16, String)> {
    let text = String::from_utf8(bytes.to_vec()).unwrap();
    assert!(text.is_ascii() && text.ends_with("  0\r\nEOF\r\n"));
    assert_eq!(text.matches('\n').count(), text.matches("\r\n").count());
    let lines: Vec<&str> = text.split_terminator("\r\n").collect();
    assert_eq!(lines.len() % 2, 0);
    let pair = |pair: &[&str]| (pair[0].trim().parse().unwrap(), pair[1].to_owned());
    lines.chunks(2).map(pair).collect()
}

/// Entities: name, and what follows it.
fn entities(groups: &[(u16, String)]) -> Vec<(String, Vec<(u16, String)>)> {
    let mut out: Vec<(String, Vec<(u16, String)>)> = Vec::new();
    for (code, value) in groups {
        if *code == 0 {
            out.push((value.clone(), Vec::new()));
        } else if let Some(last) = out.last_mut() {
            last.1.push((*code, value.clone()));
        }
    }
    out
}

fn value(entity: &(String, Vec<(u16, String)>), code: u16) -> Option<&str> {
    entity.1.iter().find(|pair| pair.0 == code).map(|pair| pair.1.as_str())
}

fn number(entity: &(String, Vec<(u16, String)>), code: u16) -> f64 {
    value(entity, code).unwrap().parse().unwrap()
}

type Polyline = (String, bool, Vec<[f64; 2]>);

/// Layer, closed flag and points of every polyline; each is ended.
fn polylines(entities: &[(String, Vec<(u16, String)>)]) -> Vec<Polyline> {
    let mut out: Vec<Polyline> = Vec::new();
    let mut is_open = false;
    for entity in entities {
        match entity.0.as_str() {
            "POLYLINE" => {
                assert!(!std::mem::replace(&mut is_open, true));
                assert_eq!(value(entity, 66), Some("1"));
                assert!(
                    ["10", "20", "30"].iter().all(|c| number(entity, c.parse().unwrap()) == 0.0)
                );
                let layer = value(entity, 8).unwrap().to_owned();
                out.push((layer, value(entity, 70) == Some("1"), Vec::new()));
            }
            "VERTEX" => {
                assert!(is_open);
                let polyline = out.last_mut().unwrap();
                assert_eq!(value(entity, 8), Some(polyline.0.as_str()));
                polyline.2.push([number(entity, 10), number(entity, 20)]);
            }
            "SEQEND" => assert!(std::mem::replace(&mut is_open, false)),
            _ => assert!(!is_open, "{}", entity.0),
        }
    }
    assert!(!is_open);
    for (layer, is_closed, points) in &out {
        assert!(points.len() >= if *is_closed { 3 } else { 2 }, "{layer}");
        assert!(!is_closed || points[0] != points[points.len() - 1], "not repeated");
        assert!(points.windows(2).all(|w| w[0] != w[1]));
    }
    out
}

fn doubled_area(points: &[[f64; 2]]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
}

#[test]
fn a_plain_dxf_has_a_block_for_each_piece_and_the_outlines_of_the_sheet() {
    let sheet = small();
    let bytes = dxf(&sheet, &DxfParams::default()).unwrap();
    let groups = groups(&bytes);
    let sections: Vec<&str> = groups
        .windows(2)
        .filter(|w| w[0] == (0, "SECTION".to_owned()))
        .map(|w| w[1].1.as_str())
        .collect();
    assert_eq!(sections, ["HEADER", "TABLES", "BLOCKS", "ENTITIES"]);
    assert!(groups.iter().all(|(code, _)| ![5, 100].contains(code)), "no handles");
    // Every number that is a place is written with a point and without exponent.
    for (code, text) in &groups {
        if (10..60).contains(code) {
            assert!(text.contains('.') && !text.contains('e') && text != "-0.0", "{code} {text}");
        }
    }
    let all = entities(&groups);
    let blocks: Vec<&str> =
        all.iter().filter(|e| e.0 == "BLOCK").map(|e| value(e, 2).unwrap()).collect();
    assert_eq!(blocks, ["A", "B", "C"]);
    let line_types: BTreeSet<&str> =
        all.iter().filter(|e| e.0 == "LTYPE").filter_map(|e| value(e, 2)).collect();
    let layers: Vec<_> = all.iter().filter(|e| e.0 == "LAYER").collect();
    assert!(layers.iter().all(|e| line_types.contains(value(e, 6).unwrap())));
    let names: BTreeSet<&str> = layers.iter().filter_map(|e| value(e, 2)).collect();
    let drawn = |e: &&(String, _)| ["POLYLINE", "LINE", "TEXT"].contains(&e.0.as_str());
    assert!(all.iter().filter(drawn).all(|e| names.contains(value(e, 8).unwrap())));
    // Outlines, each moved back by where its block is inserted, are those of the sheet.
    let inserts: Vec<[f64; 2]> = all
        .iter()
        .filter(|e| e.0 == "INSERT")
        .map(|e| {
            assert!([41, 42, 43, 50].iter().all(|&code| value(e, code).is_none()));
            [number(e, 10), number(e, 20)]
        })
        .collect();
    for (block, part) in all.split(|e| e.0 == "ENDBLK").take(3).enumerate() {
        let rings: Vec<Polyline> =
            polylines(part).into_iter().filter(|(layer, ..)| layer == "CUT").collect();
        assert_eq!(rings.len(), 2);
        let wanted = |id: &str| {
            let id = format!("{}-{id}", blocks[block]);
            &sheet.lines.iter().find(|line| line.id == id).unwrap().points
        };
        for ((_, is_closed, points), id) in rings.iter().zip(["hole-1", "cut"]) {
            assert!(is_closed);
            assert_eq!(points.len(), wanted(id).len());
            for (p, q) in points.iter().zip(wanted(id)) {
                // Four decimals, once for the corner and once for the point.
                assert!((0..2).all(|a| (p[a] + inserts[block][a] - q[a]).abs() < 1.01e-4));
            }
        }
        let low = |a: usize| rings[1].2.iter().map(|p| p[a]).fold(f64::INFINITY, f64::min);
        assert_eq!([low(0), low(1)], [0.0; 2], "the base is the lower left corner");
    }
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains("\r\n50 MM\r\n") && text.contains("Moebel & Co"));
    assert!(text.contains("$INSUNITS") && text.contains("cut 1 x - 0deg"));
}

#[test]
fn a_dxf_can_be_strict_and_without_blocks() {
    let sheet = small();
    let params = DxfParams::Plain { is_exploded: true, is_strict: true };
    let bytes = dxf(&sheet, &params).unwrap();
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert!(!text.contains("$INSUNITS") && !text.contains("$MEASUREMENT"));
    let all = entities(&groups(&bytes));
    assert!(all.iter().all(|e| !["BLOCK", "INSERT"].contains(&e.0.as_str())));
    let cuts: Vec<Polyline> =
        polylines(&all).into_iter().filter(|(layer, ..)| layer == "CUT").collect();
    assert_eq!(cuts.len(), 6);
    let outline = &sheet.lines.iter().find(|line| line.id == "A-cut").unwrap().points;
    let near = |points: &[[f64; 2]]| {
        points.iter().zip(outline).all(|(p, q)| (0..2).all(|a| (p[a] - q[a]).abs() < 1e-4))
    };
    assert!(cuts.iter().any(|(_, _, points)| points.len() == outline.len() && near(points)));
    // A sheet without a control square gets one below it.
    let mut bare = sheet;
    bare.lines.retain(|line| line.layer != Layer::Control);
    bare.texts.retain(|text| text.layer != Layer::Control);
    let text = String::from_utf8(dxf(&bare, &params).unwrap()).unwrap();
    assert!(text.contains("\r\n50 MM\r\n") && text.contains("-60.0"));
}

#[test]
fn an_astm_file_has_what_its_readers_count() {
    let sheet = small();
    for is_gerber in [false, true] {
        let params = AstmParams {
            is_gerber,
            date: "01-02-2030".into(),
            quantities: vec![[1, 1], [2, 0]],
            ..AstmParams::default()
        };
        let bytes = dxf(&sheet, &DxfParams::Astm(params)).unwrap();
        let groups = groups(&bytes);
        let all = entities(&groups);
        let text = String::from_utf8(bytes).unwrap();
        assert_eq!(text.contains("AC1009"), !is_gerber);
        assert!(!text.contains("TABLES"));
        assert!(text.contains("Units: METRIC") && text.contains("Style Name: Moebel & Co"));
        assert!(text.contains("Quantity: 1,1") && text.contains("Quantity: 2,0"));
        for part in all.split(|e| e.0 == "ENDBLK").take(3) {
            let lines = polylines(part);
            let of = |layer: &str| lines.iter().filter(|l| l.0 == layer).collect::<Vec<_>>();
            let boundary = of("1");
            assert!(boundary.len() == 1 && boundary[0].1 && doubled_area(&boundary[0].2) > 0.0);
            for (layer, copy) in [("1", "84"), ("8", "85"), ("11", "86"), ("14", "87")] {
                let points = |layer| of(layer).iter().map(|l| l.2.clone()).collect::<Vec<_>>();
                assert!(!points(layer).is_empty());
                assert_eq!(points(layer), points(copy));
            }
            let vertices: usize =
                ["1", "8", "11", "14"].iter().flat_map(|&l| of(l)).map(|l| l.2.len()).sum();
            let points = |layers: &[&str]| {
                let points = part.iter().filter(|e| e.0 == "POINT");
                points.filter(|e| layers.contains(&value(e, 8).unwrap())).collect::<Vec<_>>()
            };
            assert_eq!(points(&["2", "3"]).len(), vertices);
            // Seam ends are turn points: two on the sew line, ends of the three folds.
            assert_eq!(points(&["2"]).len(), 2 + 6);
            assert_eq!(points(&["13"]).len(), 1);
            let notches = points(&["4"]);
            assert_eq!(notches.len(), 6);
            for notch in notches {
                // Slits of 3 mm less the wave of the outline, into the piece.
                let foot = [number(notch, 10), number(notch, 20)];
                assert!(
                    boundary[0].2.iter().any(|p| (0..2).all(|a| (p[a] - foot[a]).abs() < 1e-3))
                );
                assert!((1.0..3.1).contains(&number(notch, 30)) && value(notch, 39).is_none());
                let angle = number(notch, 50).to_radians();
                let inside = [foot[0] + angle.cos(), foot[1] + angle.sin()];
                let middle = [0, 1].map(|a| {
                    boundary[0].2.iter().map(|p| p[a]).sum::<f64>() / boundary[0].2.len() as f64
                });
                let far = |p: [f64; 2]| (p[0] - middle[0]).hypot(p[1] - middle[1]);
                assert!(far(inside) < far(foot) - 0.5);
            }
            let grain = part.iter().filter(|e| e.0 == "LINE" && value(e, 8) == Some("7"));
            assert_eq!(grain.count(), 1);
        }
    }
}
