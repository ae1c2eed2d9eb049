//! What cannot be written, and what is mended.

use cutflow::pattern::{
    AstmParams, DxfParams, Layer, Line, Paper, PdfParams, Sheet, SheetNotice, SvgParams,
    WriteError, check, dxf, pdf, svg, tiles,
};

use super::{attribute, drawing, hollow, small};

#[test]
fn what_cannot_be_written_is_refused_by_every_writer() {
    let refused = |sheet: &Sheet, error: &WriteError| {
        assert_eq!(check(sheet).as_ref(), Err(error));
        assert_eq!(svg(sheet, &SvgParams::default()).as_ref(), Err(error));
        assert_eq!(dxf(sheet, &DxfParams::default()).as_ref(), Err(error));
        let astm = DxfParams::Astm(AstmParams::default());
        assert_eq!(dxf(sheet, &astm).as_ref(), Err(error));
        assert_eq!(pdf(sheet, &PdfParams::default()).as_ref(), Err(error));
        assert_eq!(tiles(sheet, &PdfParams::default()).as_ref(), Err(error));
    };
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let mut sheet = small();
        sheet.lines[3].points[5][1] = bad;
        refused(&sheet, &WriteError::NotFinite { id: sheet.lines[3].id.clone() });
        let mut sheet = small();
        let curved = sheet.lines.iter_mut().find(|line| !line.curve.is_empty()).unwrap();
        curved.curve[1][0][0] = bad;
        let id = curved.id.clone();
        refused(&sheet, &WriteError::NotFinite { id });
        let mut sheet = small();
        sheet.texts[1].at[0] = bad;
        refused(&sheet, &WriteError::NotFinite { id: sheet.texts[1].id.clone() });
    }
    let mut sheet = small();
    sheet.size[0] = 0.0;
    refused(&sheet, &WriteError::NoSize { size: sheet.size });
    let mut sheet = small();
    sheet.lines[0].points.truncate(1);
    refused(&sheet, &WriteError::FewPoints { id: sheet.lines[0].id.clone(), points: 1 });
    let mut sheet = small();
    sheet.lines.iter_mut().filter(|l| l.piece == Some(1)).for_each(|line| line.is_closed = false);
    let astm = DxfParams::Astm(AstmParams::default());
    assert_eq!(dxf(&sheet, &astm), Err(WriteError::NoOutline { piece: 1 }));
}

#[test]
fn pages_without_room_and_absurd_numbers_of_them_are_refused() {
    let sheet = small();
    let no_room = |margin_mm, overlap_mm| {
        let params = PdfParams { margin_mm, overlap_mm, ..PdfParams::default() };
        assert!(matches!(tiles(&sheet, &params), Err(WriteError::NoRoom { .. })), "{margin_mm}");
        assert!(pdf(&sheet, &params).is_err());
    };
    no_room(90.0, 12.0);
    no_room(10.0, 200.0);
    no_room(-1.0, 12.0);
    no_room(f64::NAN, 12.0);
    no_room(10.0, f64::INFINITY);
    let roll = PdfParams { paper: Paper::Roll { width_mm: 20.0 }, ..PdfParams::default() };
    assert!(matches!(tiles(&sheet, &roll), Err(WriteError::NoRoom { .. })));
    let vast = hollow(1e6);
    assert!(matches!(tiles(&vast, &PdfParams::default()), Err(WriteError::TooManyPages { .. })));
}

#[test]
fn what_will_be_mended_or_cannot_be_cut_is_told() {
    let mut sheet = small();
    assert_eq!(check(&sheet), Ok(Vec::new()));
    let line = |id: &str, is_closed, points: &[[f64; 2]]| Line {
        layer: Layer::Cut,
        id: id.into(),
        piece: None,
        seam: None,
        is_closed,
        points: points.to_vec(),
        curve: Vec::new(),
    };
    sheet.lines.push(line("slit", true, &[[5.0, 5.0], [9.0, 5.0]]));
    sheet.lines.push(line("eight", true, &[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]));
    sheet.lines.push(line("speck", false, &[[1.0, 1.0], [1.000_01, 1.0]]));
    sheet.lines.push(line("twice", false, &[[1.0, 1.0], [1.0, 1.0], [2.0, 1.0]]));
    let told = check(&sheet).unwrap();
    assert_eq!(
        told,
        [
            SheetNotice::Slit { id: "slit".into() },
            SheetNotice::LeftOut { id: "speck".into() },
            SheetNotice::ZeroEdges { id: "twice".into(), count: 1 },
            SheetNotice::Crosses { id: "eight".into(), crossings: 1, at: [2.0, 2.0] },
        ]
    );
    let drawn = drawing(&sheet, &SvgParams::default());
    assert!(!drawn.contains("id=\"speck\""));
    let slit = drawn.lines().find(|line| line.contains("\"slit\"")).unwrap();
    assert_eq!(attribute(slit, "d").unwrap().matches(['L', 'Z']).count(), 1);
}
