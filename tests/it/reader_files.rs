//! Files for readers that are not ours: `cargo xtask test --readers` runs this, and `tests/readers/` looks at what it writes.
//!
//! Each folder is one example. Beside the files stands `model.json`: what lines and texts the sheet has, which seams belong
//! together, how the vertices of the input read. The readers measure the files, and compare with that.

use std::fs;
use std::path::{Path, PathBuf};

use cutflow::mesh::Soup;
use cutflow::pattern::{
    AstmParams, AtlasImageParams, Channels, CutSurface, DxfParams, Layer, Partner, PdfParams,
    Sheet, SheetParams, SvgParams, SvgProfile, Texture, ZipEntry, atlas_image, cut_obj, dxf,
    flat_obj, pdf, piece_name, png, svg, uv_glb, uv_obj, uv_ply, zip,
};
use cutflow::session::{Command, Session};
use serde_json::json;

use crate::patterns::{Example, box_with_lid, slit_prism};
use crate::scripts::{errors, set};

/// Names the folder to write into.
const FOLDER: &str = "CUTFLOW_READER_FILES";

/// The palette of the page.
const COLOURS: [[u8; 3]; 9] = [
    [0x6b, 0x9a, 0xd8],
    [0xe0, 0x8a, 0x5b],
    [0x7f, 0xb8, 0x6a],
    [0xc9, 0x79, 0xa8],
    [0xd8, 0xbe, 0x5a],
    [0x64, 0xb5, 0xb0],
    [0xa6, 0x8b, 0xd6],
    [0xb0, 0x8f, 0x72],
    [0x8f, 0x9a, 0xa8],
];

/// What an example consists of.
struct Files<'a> {
    folder: PathBuf,
    surface: CutSurface<'a>,
    charts: &'a [[f64; 2]],
    /// Units of the file in one of the charts.
    chart_unit: f64,
    sheet: Sheet,
    /// Whether the pieces unfold without distortion.
    is_developable: bool,
    /// Whether both sides of every seam are as long in the plane as on the surface.
    has_true_rims: bool,
}

impl Files<'_> {
    fn write(&self, name: &str, bytes: &[u8]) {
        fs::create_dir_all(&self.folder).unwrap();
        fs::write(self.folder.join(name), bytes).unwrap();
    }

    /// Every format, and all of them in one archive.
    fn write_all(&self) {
        let Self { surface, charts, chart_unit, .. } = self;
        let atlas = atlas(surface, charts);
        let mm = surface.mm_per_unit.map(|mm| mm * chart_unit);
        let glb = |texture| uv_glb(surface, charts, *chart_unit, "Example \"ä\"", texture).unwrap();
        let mut files = vec![
            ("uv.obj", uv_obj(surface, charts, *chart_unit)),
            ("uv.ply", uv_ply(surface, charts, *chart_unit)),
            ("uv.glb", glb(Texture::Checker)),
            ("atlas.glb", glb(Texture::Png(&atlas))),
            ("flat.obj", flat_obj(surface, charts, mm)),
            ("cut.obj", cut_obj(surface)),
            ("atlas.png", atlas.clone()),
            ("model.json", self.model()),
        ];
        let sheet = &self.sheet;
        let laser = SvgParams { profile: SvgProfile::Laser, ..SvgParams::default() };
        let plain = |is_exploded| DxfParams::Plain { is_exploded, is_strict: is_exploded };
        files.push(("pattern.svg", svg(sheet, &SvgParams::default()).unwrap()));
        files.push(("laser.svg", svg(sheet, &laser).unwrap()));
        files.push(("pattern.dxf", dxf(sheet, &plain(false)).unwrap()));
        files.push(("exploded.dxf", dxf(sheet, &plain(true)).unwrap()));
        files.push(("astm.dxf", dxf(sheet, &DxfParams::Astm(AstmParams::default())).unwrap()));
        files.push(("pattern.pdf", pdf(sheet, &PdfParams::default()).unwrap()));
        for (name, bytes) in &files {
            self.write(name, bytes);
        }
        let mut entries: Vec<ZipEntry> =
            files.iter().map(|(name, bytes)| ZipEntry { name, bytes }).collect();
        // A name that is not ASCII, in a folder.
        entries.push(ZipEntry { name: "pieces/Bär.txt", bytes: b"x" });
        self.write("all.zip", &zip(&entries).unwrap());
    }

    /// What the files must say, in numbers that do not come from them.
    fn model(&self) -> Vec<u8> {
        let surface = &self.surface;
        let soup: &Soup = surface.soup;
        let patches: Vec<u32> = surface.opened.face_patches.clone();
        let mut model = json!({
            "is_developable": self.is_developable,
            "has_true_rims": self.has_true_rims,
            "input_vertices": soup.positions.len(),
            "new_points": surface.cut.points.len() - surface.mesh.vertex_count(),
            "mm_per_unit": surface.mm_per_unit,
            "triangles": surface.cut.triangles.len(),
            "opened_vertices": surface.opened.mesh.vertex_count(),
            "pieces": surface.opened.patch_count,
            "face_pieces": patches.iter().map(|p| p + 1).collect::<Vec<_>>(),
        });
        model["sheet"] = sheet_model(&self.sheet);
        model.to_string().into_bytes()
    }
}

fn atlas(surface: &CutSurface, charts: &[[f64; 2]]) -> Vec<u8> {
    let params = AtlasImageParams {
        size: 512,
        colours: &COLOURS,
        square: None,
        seam_width: 3.0,
        padding: 8,
    };
    let pixels = atlas_image(surface.opened, charts, &params);
    png([512; 2], Channels::Rgb, &pixels, None).unwrap()
}

fn sheet_model(sheet: &Sheet) -> serde_json::Value {
    let piece = |index: Option<usize>| index.map(|i| sheet.pattern.pieces[i].name.clone());
    let lines: Vec<_> = sheet
        .lines
        .iter()
        .map(|line| {
            json!({
                "layer": layer(line.layer),
                "id": line.id,
                "piece": piece(line.piece),
                "closed": line.is_closed,
                "points": line.points,
            })
        })
        .collect();
    let seams: Vec<_> = sheet
        .pattern
        .pieces
        .iter()
        .enumerate()
        .flat_map(|(p, piece)| {
            piece.seams.iter().enumerate().map(move |(s, seam)| (p, piece, s, seam))
        })
        .map(|(p, piece, s, seam)| {
            // As it is drawn: made smooth, where it has a line of its own.
            let mut drawn = sheet.lines.iter().filter(|line| line.layer == Layer::Sew);
            let drawn = drawn.find(|line| line.piece == Some(p) && line.seam == Some(s));
            let points = drawn.map_or_else(
                || piece.seam_points(seam),
                |line| {
                    let first = line.is_closed.then(|| line.points[0]);
                    line.points.iter().copied().chain(first).collect()
                },
            );
            let (partner, is_second) = match seam.partner {
                Partner::Patch(patch) => (piece_name(patch), false),
                Partner::Own { is_second } => (piece.name.clone(), is_second),
            };
            json!({
                "number": seam.number,
                "piece": piece.name,
                "partner": partner,
                "is_second": is_second,
                "closed": seam.is_closed,
                "points": points,
                "start": piece.seam_points(seam)[0],
                "surface_length": seam.surface_length_mm,
            })
        })
        .collect();
    json!({
        "size": sheet.size,
        "lines": lines,
        "texts": sheet.texts.iter().map(|text| text.text.clone()).collect::<Vec<_>>(),
        "seams": seams,
    })
}

/// A layer as the files call it.
fn layer(layer: Layer) -> &'static str {
    match layer {
        Layer::Cut => "CUT",
        Layer::Sew => "SEW",
        Layer::Notch => "NOTCH",
        Layer::Grain => "GRAIN",
        Layer::FoldMountain => "FOLD_M",
        Layer::FoldValley => "FOLD_V",
        Layer::Score => "SCORE",
        Layer::Drill => "DRILL",
        Layer::Internal => "INTERNAL",
        Layer::Text => "TEXT",
        Layer::Control => "CONTROL",
    }
}

/// A surface that unfolds without distortion: partners are equally long in the plane as well.
fn write_example(folder: &Path, name: &str, example: &Example, mm_per_unit: f64) {
    let (pattern, notices) = example.pattern(mm_per_unit);
    assert!(notices.is_empty(), "{notices:?}");
    let params = SheetParams { title: name.to_owned(), ..SheetParams::default() };
    let files = Files {
        folder: folder.join(name),
        surface: CutSurface { mm_per_unit: Some(mm_per_unit), ..example.surface() },
        charts: &example.charts,
        chart_unit: 1.0,
        sheet: example.sheet(&pattern, mm_per_unit, &params),
        is_developable: true,
        has_true_rims: true,
    };
    files.write("input.obj", &cutflow::pattern::mesh_obj(&example.soup, None));
    files.write_all();
}

/// A surface as a person opens it, with the cut that it has at first, made ready for a trade.
fn write_session(folder: &Path, name: &str, session: &mut Session, input: &[u8]) {
    let sheet = session.pattern_sheet().unwrap();
    let (charts, opened) = {
        let layout = session.layout().unwrap();
        (layout.charts.clone(), layout.opened.clone())
    };
    let scale = session.document().unwrap().surface().unwrap().frame.scale;
    // Two centimetres for a unit of the file.
    let mm = 20.0;
    let cut = session.layout().unwrap().cut.clone();
    let given = session.document().unwrap().surface().unwrap();
    let surface = CutSurface {
        soup: &given.soup,
        soup_vertices: &given.soup_vertices,
        face_polygons: &given.face_polygons,
        mm_per_unit: Some(mm),
        mesh: &given.mesh,
        cut: &cut,
        opened: &opened,
    };
    let files = Files {
        folder: folder.join(name),
        surface,
        charts: &charts,
        chart_unit: 1.0 / scale,
        sheet,
        is_developable: false,
        has_true_rims: name == "ball",
    };
    files.write("input.obj", input);
    files.write_all();
}

/// A cube of small squares with hard edges: two groups with awkward names, two materials, a normal for each side, numbers with
/// all their digits, and a vertex that nothing uses.
fn parts() -> String {
    let n = 4u32;
    let mut text = String::from("# parts\nv 0.1 0.2 1e-3\n");
    let mut faces = [String::new(), String::new()];
    let mut grid = std::collections::BTreeMap::new();
    for side in 0..6usize {
        let (axis, is_far) = (side / 2, side % 2 == 1);
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut normal = [0, 0, 0];
        normal[axis] = if is_far { 1 } else { -1 };
        text += &format!("vn {} {} {}\n", normal[0], normal[1], normal[2]);
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let mut corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            if !is_far {
                corners.reverse();
            }
            let face = &mut faces[usize::from(axis == 2)];
            face.push('f');
            for (a, b) in corners {
                let mut at = [0; 3];
                (at[axis], at[p], at[q]) = (if is_far { n } else { 0 }, a, b);
                let count = grid.len() + 2;
                let number = *grid.entry(at).or_insert_with(|| {
                    let [x, y, z] = at.map(|x| f64::from(x) / 3.0 + 0.1);
                    text += &format!("v {x} {y} {z}\n");
                    count
                });
                face.push_str(&format!(" {number}//{}", side + 1));
            }
            face.push('\n');
        }
    }
    for ((group, material), face) in
        [("walls \"a\\b\"", "mat one"), ("floor & <ceiling>", "Stoff ä")].iter().zip(faces)
    {
        text += &format!("g {group}\nusemtl {material}\n{face}");
    }
    text
}

#[test]
#[ignore = "writes files for other programs: cargo xtask test --readers"]
fn files_for_readers_that_are_not_ours() {
    let Ok(folder) = std::env::var(FOLDER) else { panic!("{FOLDER} names no folder") };
    let folder = Path::new(&folder);
    write_example(folder, "box", &box_with_lid(), 80.0);
    write_example(folder, "prism", &slit_prism(), 60.0);

    let text = parts();
    let mut session = Session::new();
    assert_eq!(errors(&session.open("parts.obj", text.as_bytes())), Vec::<String>::new());
    // Folds and glue flaps.
    assert!(errors(&session.handle(Command::ApplyTrade { id: "paper".into() })).is_empty());
    write_session(folder, "parts", &mut session, text.as_bytes());

    let mut session = Session::new();
    assert!(errors(&session.handle(Command::OpenSample { name: "ball".into() })).is_empty());
    set(&mut session, "straighten", cutflow::session::Value::Truth(false));
    // Allowance, notches, grain, smooth curves.
    assert!(errors(&session.handle(Command::ApplyTrade { id: "garment".into() })).is_empty());
    set(&mut session, "stock", cutflow::session::Value::Text("free".into()));
    let soup = session.document().unwrap().surface().unwrap().soup.clone();
    let input = cutflow::pattern::mesh_obj(&soup, None);
    write_session(folder, "ball", &mut session, &input);
}
