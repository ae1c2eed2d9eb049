//! Pieces and files: what stands in them is what was cut, in real size, and joins up again.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    reason = "tests may panic and read files, are small, and compare what must be equal"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use cutflow::flatten::bff;
use cutflow::geometry::Geometry;
use cutflow::mesh::read::{Content, obj};
use cutflow::mesh::{CutMesh, FaceId, HalfedgeId, Mesh, OpenedMesh, Soup, SurfacePoint, VertexId};
use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial};
use cutflow::methods::cutgraph::cut_to_disks;
use cutflow::pattern::{
    BlankParams, CutSurface, LaidSurface, MarkParams, NestPose, Notice, Partner, Pattern, Placed,
    Sheet, SheetParams, SvgParams, blanks, cut_json, cut_obj, darts, piece_name, svg, uv_obj,
};
use cutflow::session::samples;
use nalgebra::{Point2, Point3, Vector2, Vector3};

/// A surface, cut and flattened: every patch of it can be unfolded without distortion.
pub struct Example {
    pub soup: Soup,
    pub mesh: Mesh,
    pub cut: CutMesh,
    pub opened: OpenedMesh,
    /// Of the points of the cut mesh.
    pub positions: Vec<Point3<f64>>,
    pub charts: Vec<[f64; 2]>,
}

impl Example {
    pub(crate) fn new(
        positions: Vec<[f64; 3]>,
        triangles: &[[u32; 3]],
        cut_edges: &[[u32; 2]],
    ) -> Self {
        let soup = Soup::from_triangles(positions, triangles);
        let mesh = Mesh::new(soup.positions.len(), triangles).unwrap();
        let mut cut = CutMesh::uncut(&mesh);
        cut.cut_edges = cut_edges.to_vec();
        Self::refined(soup, mesh, cut)
    }

    fn refined(soup: Soup, mesh: Mesh, cut: CutMesh) -> Self {
        let opened = cut.open().unwrap();
        let surface = CutSurface {
            soup: &soup,
            soup_vertices: &[],
            face_polygons: &[],
            mm_per_unit: None,
            mesh: &mesh,
            cut: &cut,
            opened: &opened,
        };
        let positions: Vec<Point3<f64>> =
            cut.points.iter().map(|&p| Point3::from(surface.place(p))).collect();
        let charts = unfold(&opened, &positions).into_iter().map(Into::into).collect();
        Self { soup, mesh, cut, opened, positions, charts }
    }

    pub fn surface(&self) -> CutSurface<'_> {
        let Self { soup, mesh, cut, opened, .. } = self;
        CutSurface {
            soup,
            soup_vertices: &[],
            face_polygons: &[],
            mm_per_unit: None,
            mesh,
            cut,
            opened,
        }
    }

    pub fn pattern(&self, mm_per_unit: f64) -> (Pattern, Vec<Notice>) {
        Pattern::new(&self.opened, &self.charts, &self.positions, mm_per_unit)
    }

    fn svg(&self, mm_per_unit: f64) -> String {
        let params = SheetParams {
            title: "Example <&> \"ä\"".into(),
            mm_per_model_unit: Some(mm_per_unit),
            ..SheetParams::default()
        };
        drawing(&self.sheet(&self.pattern(mm_per_unit).0, mm_per_unit, &params))
    }

    /// Outlines and marks of all pieces, as they lie in their charts.
    pub fn sheet(&self, pattern: &Pattern, mm_per_unit: f64, params: &SheetParams) -> Sheet {
        let Self { opened, charts, positions, .. } = self;
        let laid = LaidSurface { opened, charts, positions, mm_per_unit };
        plain_sheet(&laid, pattern, params)
    }
}

/// Outlines and marks of all pieces, as they lie in their charts.
pub fn plain_sheet(laid: &LaidSurface, pattern: &Pattern, params: &SheetParams) -> Sheet {
    let asked = BlankParams { marks: Some(MarkParams::default()), ..BlankParams::default() };
    let made = blanks(laid, pattern, &asked);
    let place =
        |blank| Placed { blank, copy: [0, 1], is_mirrored: false, pose: NestPose::default() };
    let placed: Vec<Placed> = (0..made.pieces.len()).map(place).collect();
    Sheet::new(&made.pieces, &placed, &[], params)
}

fn drawing(sheet: &Sheet) -> String {
    String::from_utf8(svg(sheet, &SvgParams::default()).unwrap()).unwrap()
}

/// Lays triangle beside triangle with the lengths that they have, and the patches in a row.
fn unfold(opened: &OpenedMesh, positions: &[Point3<f64>]) -> Vec<Point2<f64>> {
    let mesh = &opened.mesh;
    let place = |v: VertexId| positions[opened.vertex_points[v.index()] as usize];
    let length = |h: HalfedgeId| (place(mesh.tip(h)) - place(mesh.tail(h))).norm();
    let mut charts = vec![Point2::new(f64::NAN, f64::NAN); mesh.vertex_count()];
    let mut is_done = vec![false; mesh.face_count()];
    let mut right = 0.0;
    for seed in mesh.faces() {
        if is_done[seed.index()] {
            continue;
        }
        let mut own = BTreeSet::new();
        let [first, ..] = mesh.face_halfedges(seed);
        charts[mesh.tail(first).index()] = Point2::origin();
        charts[mesh.tip(first).index()] = Point2::new(length(first), 0.0);
        let mut stack = vec![first];
        while let Some(h) = stack.pop() {
            let face = mesh.face(h).unwrap();
            if std::mem::replace(&mut is_done[face.index()], true) {
                continue;
            }
            let [a, b] = [mesh.tail(h), mesh.tip(h)].map(|v| charts[v.index()]);
            let apex = mesh.tip(mesh.next(h));
            let (c, r, s) = (length(h), length(mesh.prev(h)), length(mesh.next(h)));
            let x = (c * c + r * r - s * s) / (2.0 * c);
            let y = (r * r - x * x).max(0.0).sqrt();
            let along = (b - a) / c;
            let p = a + along * x + Vector2::new(-along.y, along.x) * y;
            if charts[apex.index()].x.is_nan() {
                charts[apex.index()] = p;
            }
            // Unfolding must close up: the example is flat.
            assert!((charts[apex.index()] - p).norm() < 1e-9);
            own.extend(mesh.face_vertices(face));
            stack.extend(
                mesh.face_halfedges(face)
                    .map(HalfedgeId::twin)
                    .iter()
                    .filter(|&&g| mesh.face(g).is_some()),
            );
        }
        let low = own.iter().map(|v| charts[v.index()].x).fold(f64::INFINITY, f64::min);
        let high = own.iter().map(|v| charts[v.index()].x).fold(f64::NEG_INFINITY, f64::max);
        for v in &own {
            charts[v.index()].x += right - low;
        }
        right += high - low + 0.1;
    }
    charts
}

/// A cube of side 1 whose lid (z = 1) is cut off, and whose four standing edges are cut.
pub fn box_with_lid() -> Example {
    let positions = (0..8).map(|i| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)]);
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let cuts = [[4, 5], [5, 7], [7, 6], [6, 4], [0, 4], [1, 5], [3, 7], [2, 6]];
    Example::new(positions.collect(), &Vec::from_iter(triangles), &cuts)
}

/// Two squares on each other, sewn all around: a pillow before it is filled.
pub fn pillow() -> Example {
    let corners = (0..3).flat_map(|i| (0..3).map(move |j| [f64::from(i), f64::from(j), 0.0]));
    let mut positions: Vec<[f64; 3]> = corners.collect();
    positions.push([1.0, 1.0, 0.0]);
    let mut triangles = Vec::new();
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let at = |i: u32, j: u32| 3 * i + j;
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        // Diagonals through the middle, so that no triangle has all corners on the rim.
        let upper = if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        let lower = upper.map(|[p, q, r]| [p, r, q].map(|v| if v == 4 { 9 } else { v }));
        triangles.extend(upper);
        triangles.extend(lower);
    }
    let rim = [0, 1, 2, 5, 8, 7, 6, 3, 0];
    let cuts: Vec<[u32; 2]> = rim.windows(2).map(|w| [w[0], w[1]]).collect();
    Example::new(positions, &triangles, &cuts)
}

/// The side of a prism with open ends, cut from end to end, with a slit on the opposite side that ends inside.
pub fn slit_prism() -> Example {
    let at = |i: u32, j: u32| 5 * (i % 12) + j;
    let mut triangles = Vec::new();
    for (i, j) in (0..12).flat_map(|i| (0..4).map(move |j| (i, j))) {
        triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    let positions = (0..12).flat_map(|i| {
        let angle = TAU * f64::from(i) / 12.0;
        (0..5).map(move |j| [angle.cos(), angle.sin(), 0.5 * f64::from(j)])
    });
    let cuts = [[0, 1], [1, 2], [2, 3], [3, 4], [30, 31], [31, 32]];
    Example::new(positions.collect(), &triangles, &cuts)
}

/// A square of two triangles, cut upright at x = 1/4, with a slit into one face; the file has awkward numbers and two
/// vertices that nothing uses.
pub fn cut_square() -> Example {
    let triangles = [[0, 1, 2], [0, 2, 4]];
    let low = 0.1 + 0.2 - 0.3;
    let positions = vec![
        [low, -0.0, 1e-300],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [1e22, 2e30 / 7.0, 1.0 / 3.0],
        [0.0, 1.0, -1e-17],
        [5e-324, -123_456.789, 2.0_f64.powi(-70)],
    ];
    let soup = Soup::from_triangles(positions, &triangles);
    let mesh = Mesh::new(6, &triangles).unwrap();
    let on_edge = |a: u32, b: u32, t: f64| {
        let h = mesh.outgoing(VertexId(a)).find(|&h| mesh.tip(h) == VertexId(b)).unwrap();
        let is_first = h == h.edge().halfedge();
        SurfacePoint::Edge(h.edge(), if is_first { t } else { 1.0 - t })
    };
    let mut cut = CutMesh::uncut(&mesh);
    cut.points.extend([
        on_edge(0, 1, 0.25),
        on_edge(0, 2, 0.25),
        on_edge(4, 2, 0.25),
        SurfacePoint::Face(FaceId(0), [0.25, 0.5, 0.25]),
    ]);
    cut.triangles = vec![
        [0, 6, 7],
        [6, 1, 9],
        [1, 2, 9],
        [2, 6, 9],
        [6, 2, 7],
        [7, 2, 8],
        [0, 7, 8],
        [0, 8, 4],
    ];
    cut.triangle_faces = [0, 0, 0, 0, 0, 1, 1, 1].map(FaceId).to_vec();
    cut.cut_edges = vec![[6, 7], [8, 7], [6, 9]];
    Example::refined(soup, mesh, cut)
}

#[test]
fn a_box_becomes_a_lid_and_a_cross_with_four_common_seams() {
    let (pattern, notices) = box_with_lid().pattern(100.0);
    assert!(notices.is_empty());
    assert_eq!(pattern.patch_count, 2);
    let names: Vec<&str> = pattern.pieces.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["A", "B"]);
    let [cross, lid] = &pattern.pieces[..] else { panic!("two pieces") };
    // Rounding of coordinates about 100.
    assert!((cross.area_mm2 - 50_000.0).abs() < 1e-6 && (lid.area_mm2 - 10_000.0).abs() < 1e-6);
    assert_eq!((cross.seams.len(), lid.seams.len()), (12, 4));
    assert!(
        lid.seams
            .iter()
            .all(|s| s.partner == Partner::Patch(0) && (s.length_mm - 100.0).abs() < 1e-9)
    );
    assert!(
        (lid.room_mm - 50.0).abs() < 1.0 && (cross.room_mm - 70.7).abs() < 1.5,
        "{}",
        cross.room_mm
    );
    assert!((lid.bounds.high[0] - lid.bounds.low[0] - 100.0).abs() < 1e-9);
}

#[test]
fn seam_partners_are_equally_long_and_name_each_other() {
    for example in [box_with_lid(), pillow(), slit_prism(), cut_square()] {
        let (pattern, _) = example.pattern(250.0);
        let mut sides: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
        for (p, piece) in pattern.pieces.iter().enumerate() {
            for (s, seam) in piece.seams.iter().enumerate() {
                sides.entry(seam.number).or_default().push((p, s));
            }
        }
        assert!(sides.keys().copied().eq(1..=sides.len()), "numbered without gaps");
        for (number, both) in sides {
            let &[(p, s), (q, t)] = &both[..] else {
                panic!("seam {number} has {} sides", both.len())
            };
            let (piece, other) = (&pattern.pieces[p], &pattern.pieces[q]);
            let (seam, across) = (&piece.seams[s], &other.seams[t]);
            // Unfolded without distortion: equal up to rounding in the plane as well.
            assert!((seam.length_mm - across.length_mm).abs() < 1e-9 * seam.length_mm);
            assert!((seam.length_mm - seam.surface_length_mm).abs() < 1e-9 * seam.length_mm);
            assert_eq!((seam.sides, seam.is_closed), (across.sides, across.is_closed));
            let labels = [piece.seam_label(seam), other.seam_label(across)];
            if p == q {
                assert_eq!(
                    labels,
                    [format!("{number}a > {number}b"), format!("{number}b > {number}a")]
                );
            } else {
                assert_eq!(
                    labels,
                    [format!("{number} > {}", other.name), format!("{number} > {}", piece.name)]
                );
            }
            // The same points of the surface, the other way.
            let points = |piece: usize, seam: usize| {
                let piece = &pattern.pieces[piece];
                let seam = &piece.seams[seam];
                let outline = &piece.outlines[seam.outline];
                let vertices = (seam.first..=seam.first + seam.sides)
                    .map(|i| outline.vertices[i % outline.vertices.len()]);
                Vec::from_iter(vertices.map(|v| example.opened.vertex_points[v.index()]))
            };
            let mut backwards = points(q, t);
            backwards.reverse();
            assert_eq!(points(p, s), backwards);
        }
    }
}

#[test]
fn seams_end_at_rims_junctions_and_tips() {
    // The prism: one cut from rim to rim, one slit with a tip; both sewn to the same piece.
    let (pattern, _) = slit_prism().pattern(10.0);
    let piece = &pattern.pieces[0];
    let lengths: Vec<(usize, usize)> = piece.seams.iter().map(|s| (s.number, s.sides)).collect();
    let mut sorted = lengths.clone();
    sorted.sort_unstable();
    assert_eq!(sorted.iter().map(|s| s.1).collect::<BTreeSet<_>>(), BTreeSet::from([2, 4]));
    assert_eq!(lengths.len(), 4, "{lengths:?}");
    // The rest is rim: twice the circumference of the prism.
    let outline = &piece.outlines[0];
    let around: f64 = outline.sides().map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum();
    let sewn: f64 = piece.seams.iter().map(|s| s.length_mm).sum();
    let circumference = 24.0 * (TAU / 24.0).sin() * 10.0;
    assert!((around - sewn - 2.0 * circumference).abs() < 1e-9);
    // The pillow: all around, no ends, both sides begin at the same point.
    let example = pillow();
    let (pattern, _) = example.pattern(10.0);
    assert!(pattern.pieces.iter().all(|p| p.seams.len() == 1 && p.seams[0].is_closed));
}

#[test]
fn pieces_are_called_by_letters() {
    assert_eq!(
        [0, 1, 25, 26, 27, 51, 52, 701, 702].map(piece_name),
        ["A", "B", "Z", "AA", "AB", "AZ", "BA", "ZZ", "AAA"]
    );
}

#[test]
fn a_patch_without_chart_is_told_and_its_neighbours_still_name_it() {
    let mut example = box_with_lid();
    let lid = example.opened.mesh.triangles()[2][0];
    example.charts[lid.index()] = [f64::NAN; 2];
    let (pattern, notices) = example.pattern(100.0);
    assert_eq!(notices, [Notice::NoChart { patch: 1 }]);
    assert_eq!(notices[0].to_string(), "piece 2 (B) is missing: it was not flattened");
    assert_eq!((pattern.pieces.len(), pattern.patch_count), (1, 2));
    assert!(
        pattern.pieces[0].seams.iter().any(|s| pattern.pieces[0].seam_label(s).ends_with("> B"))
    );
    // Turned over, or of no extent: no piece either.
    let mut example = box_with_lid();
    example.charts.iter_mut().for_each(|p| p[0] = -p[0]);
    let (pattern, notices) = example.pattern(100.0);
    assert_eq!(notices, [Notice::NoArea { patch: 0 }, Notice::NoArea { patch: 1 }]);
    let empty = drawing(&example.sheet(&pattern, 100.0, &SheetParams::default()));
    assert!(empty.contains("0 pieces") && !empty.contains("NaN"));
}

#[test]
fn an_outline_that_crosses_itself_is_told() {
    // A strip that goes round in more than a circle on the sheet, as a long piece cut from a helix would.
    let n = 40u32;
    let positions: Vec<[f64; 3]> =
        (0..=n).flat_map(|i| [0.0, 1.0].map(|y| [f64::from(i) * 0.2, y, 0.0])).collect();
    let triangles =
        (0..n).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]]);
    let mut strip = Example::new(positions, &Vec::from_iter(triangles), &[]);
    assert!(strip.pattern(10.0).1.is_empty());
    for (i, p) in strip.charts.iter_mut().enumerate() {
        let (angle, r) = (f64::from(i as u32 / 2) * 0.2, 2.0 - (i % 2) as f64);
        *p = [r * angle.cos(), r * angle.sin()];
    }
    let (pattern, notices) = strip.pattern(10.0);
    let [Notice::CrossesItself { patch: 0, crossings, .. }] = notices[..] else {
        panic!("{notices:?}")
    };
    assert!(crossings >= 2);
    let drawn = drawing(&strip.sheet(&pattern, 10.0, &SheetParams::default()));
    assert!(drawn.contains("outline crosses itself"));
}

#[test]
fn a_flat_surface_opened_along_a_cut_does_not_cross_itself() {
    // The two sides of the cut lie on each other.
    let (pattern, notices) = cut_square().pattern(1000.0 / 3.0);
    assert!(notices.is_empty(), "{notices:?}");
    assert_eq!(pattern.pieces.len(), 2);
}

/// An element of an SVG file: name, attributes, text.
type Element = (String, BTreeMap<String, String>, String);

/// A reader for the XML that we write: tags in pairs, attributes in double quotes.
fn elements(text: &str) -> Vec<Element> {
    let mut open = Vec::new();
    let mut elements: Vec<Element> = Vec::new();
    let body = text.strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>").unwrap();
    for part in body.split('<').skip(1) {
        let (tag, words) = part.split_once('>').unwrap();
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name), "tags are closed in order");
            continue;
        }
        let (tag, is_empty) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
        let (name, mut rest) = tag.split_once(' ').unwrap_or((tag, ""));
        let mut attributes = BTreeMap::new();
        while let Some((key, tail)) = rest.split_once("=\"") {
            let (value, tail) = tail.split_once('"').unwrap();
            let repeated = attributes.insert(key.trim().to_owned(), value.to_owned());
            assert!(repeated.is_none(), "{key} twice in {tag}");
            rest = tail;
        }
        if !is_empty {
            open.push(name.to_owned());
        }
        elements.push((name.to_owned(), attributes, words.trim_end().to_owned()));
    }
    assert!(open.is_empty());
    elements
}

/// The points of a path `M x,y L x,y … Z`, y up again.
fn path_points(d: &str, height: f64) -> Vec<[f64; 2]> {
    let d = d.strip_prefix("M ").unwrap().trim_end_matches(" Z").replace(" L ", " ");
    let point = |pair: &str| {
        let (x, y) = pair.split_once(',').unwrap();
        [x.parse::<f64>().unwrap(), height - y.parse::<f64>().unwrap()]
    };
    d.split(' ').map(point).collect()
}

#[test]
fn the_drawing_has_real_size_and_one_closed_path_for_each_piece() {
    for (example, mm_per_unit) in
        [(box_with_lid(), 100.0), (slit_prism(), 7.5), (cut_square(), 1234.5)]
    {
        let (pattern, _) = example.pattern(mm_per_unit);
        let drawn = example.svg(mm_per_unit);
        let elements = elements(&drawn);
        let (_, root, _) = &elements[0];
        let [width, height] = ["width", "height"].map(|key| root[key].strip_suffix("mm").unwrap());
        assert_eq!(root["viewBox"], format!("0 0 {width} {height}"), "the same decimals");
        assert!(!drawn.contains("transform") && !drawn.contains("NaN") && !drawn.contains("inf"));
        let [width, height]: [f64; 2] = [width, height].map(|text| text.parse().unwrap());

        let ids: Vec<&String> = elements.iter().filter_map(|(_, a, _)| a.get("id")).collect();
        assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "unique ids");
        let layers: Vec<&str> = elements
            .iter()
            .filter(|(name, ..)| name == "g")
            .map(|(_, a, _)| a["inkscape:label"].as_str())
            .collect();
        // The slit of the prism has a tip to be drilled; a slit that turns has none.
        let has_tip = layers.contains(&"DRILL");
        assert!(!has_tip || pattern.pieces.iter().any(|piece| !darts(piece).is_empty()));
        let others: Vec<&str> = layers.into_iter().filter(|layer| *layer != "DRILL").collect();
        assert_eq!(others, ["CUT", "INTERNAL", "TEXT", "CONTROL"]);

        let cuts: Vec<&BTreeMap<String, String>> = elements
            .iter()
            .filter(|(_, a, _)| a.get("id").is_some_and(|id| id.ends_with("-cut")))
            .map(|(_, a, _)| a)
            .collect();
        assert_eq!(cuts.len(), pattern.pieces.len());
        for (attributes, piece) in cuts.iter().zip(&pattern.pieces) {
            assert_eq!(attributes["data-piece"], piece.name);
            let d = &attributes["d"];
            assert!(d.starts_with("M ") && d.ends_with(" Z") && d.matches('M').count() == 1);
            let points = path_points(d, height);
            let shift = |axis: usize, points: &[[f64; 2]]| {
                points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min)
            };
            let outline = &piece.outlines[0].points;
            // Points that coincide to 1e-4 mm are written once.
            assert!(points.len() <= outline.len() && points.len() >= 3);
            let [dx, dy] = [0, 1].map(|axis| shift(axis, &points) - shift(axis, outline));
            for p in outline {
                let is_there = points
                    .iter()
                    .any(|q| (q[0] - p[0] - dx).abs() < 2e-4 && (q[1] - p[1] - dy).abs() < 2e-4);
                assert!(is_there, "{p:?}");
            }
            assert!(points.iter().all(|p| (10.0 - 1e-4..=width - 10.0 + 1e-4).contains(&p[0])));
            assert!(points.iter().all(|p| (10.0 - 1e-4..=height - 10.0 + 1e-4).contains(&p[1])));
            let numbers: BTreeSet<String> =
                piece.seams.iter().map(|s| s.number.to_string()).collect();
            assert_eq!(
                attributes["data-seams"].split(' ').map(str::to_owned).collect::<BTreeSet<_>>(),
                numbers
            );
        }
        let square =
            elements.iter().find(|(_, a, _)| a.get("id").is_some_and(|id| id == "control-square"));
        let square = path_points(&square.unwrap().1["d"], height);
        let sides = (0..4).map(|i| {
            (square[i][0] - square[(i + 1) % 4][0]).hypot(square[i][1] - square[(i + 1) % 4][1])
        });
        assert!(sides.into_iter().all(|side| (side - 50.0).abs() < 1e-9));
        // Partners as they are written down are equally long on the surface.
        let mut lengths: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for (_, a, _) in elements.iter().filter(|(_, a, _)| a.contains_key("data-seam")) {
            lengths.entry(&a["data-seam"]).or_default().insert(&a["data-surface-length-mm"]);
        }
        assert!(!lengths.is_empty() && lengths.values().all(|both| both.len() == 1), "{lengths:?}");
    }
}

#[test]
fn the_drawing_of_a_box_is_the_golden_one() {
    let drawn = box_with_lid().svg(60.0);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/box.svg");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(path, &drawn).unwrap();
    }
    let golden = std::fs::read_to_string(path).unwrap();
    assert_eq!(drawn, golden, "if the change is meant, run again with UPDATE_GOLDEN=1");
}

/// The lines of a text that begin with a word, as their other words.
fn lines<'a>(text: &'a str, key: &str) -> Vec<Vec<&'a str>> {
    let words = text.lines().map(|line| line.split(' ').collect::<Vec<_>>());
    words.filter(|words| words[0] == key).map(|words| words[1..].to_vec()).collect()
}

fn numbers<const N: usize>(words: &[&str]) -> [f64; N] {
    Vec::from_iter(words.iter().map(|word| word.parse::<f64>().unwrap())).try_into().unwrap()
}

#[test]
fn the_uv_mesh_begins_with_the_vertices_of_the_file_bit_for_bit() {
    let example = cut_square();
    let written = String::from_utf8(uv_obj(&example.surface(), &example.charts, 2.0)).unwrap();
    let vertices = lines(&written, "v");
    assert_eq!(vertices.len(), 6 + 4, "the vertices that nothing uses too");
    for (words, position) in vertices.iter().zip(&example.soup.positions) {
        let read: [f64; 3] = numbers(words);
        assert_eq!(read.map(f64::to_bits), position.map(f64::to_bits));
    }
    for (words, p) in vertices.iter().zip(&example.positions).skip(6) {
        assert_eq!(numbers::<3>(words), [p.x, p.y, p.z]);
    }
    let expected = [[0.25, 0.0], [0.25, 0.25], [0.25, 1.0]];
    for (words, [x, y]) in vertices[6..].iter().zip(expected) {
        let [u, v, _] = numbers(words);
        assert!((u - x).abs() < 1e-15 && (v - y).abs() < 1e-15);
    }
    let groups: Vec<&str> = lines(&written, "g").iter().map(|words| words[0]).collect();
    assert_eq!(groups, ["piece_1", "piece_2"]);
}

#[test]
fn the_uv_mesh_has_the_charts_at_one_scale_in_the_unit_square() {
    for example in [box_with_lid(), slit_prism(), cut_square()] {
        let written = String::from_utf8(uv_obj(&example.surface(), &example.charts, 3.0)).unwrap();
        let uv: Vec<[f64; 2]> = lines(&written, "vt").iter().map(|words| numbers(words)).collect();
        assert!(uv.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
        assert!((0..2).any(|axis| uv.iter().any(|p| p[axis] == 1.0)), "as large as they can be");
        let scale: f64 =
            lines(&written, "#").iter().find(|w| w[0] == "uv_scale").unwrap()[1].parse().unwrap();
        // Faces in the order of the patches; every side has its true length.
        let mut faces = example.opened.mesh.faces().collect::<Vec<_>>();
        faces.sort_by_key(|f| example.opened.face_patches[f.index()]);
        let written_faces = lines(&written, "f");
        assert_eq!(written_faces.len(), faces.len());
        for (words, f) in written_faces.iter().zip(faces) {
            let corners: Vec<(usize, usize)> = words
                .iter()
                .map(|word| word.split_once('/').unwrap())
                .map(|(v, t)| (v.parse().unwrap(), t.parse().unwrap()))
                .collect();
            let triangle = example.cut.triangles[f.index()];
            assert!(
                corners.iter().map(|&(v, _)| v as u32 - 1).eq(triangle),
                "order and orientation"
            );
            for i in 0..3 {
                let [p, q] = [i, (i + 1) % 3].map(|i| Point2::from(uv[corners[i].1 - 1]));
                let [a, b] = [i, (i + 1) % 3].map(|i| example.positions[triangle[i] as usize]);
                // The chart's unit is 3 of the file's: lengths in the plane come out threefold.
                let expected = 3.0 * (b - a).norm();
                assert!(((q - p).norm() * scale - expected).abs() < 1e-12 * scale);
            }
        }
        // Our own reader takes it, and finds corners on both sides of a cut apart in the plane only.
        let Content { soup, notices, .. } = obj::read(written.as_bytes()).unwrap();
        assert!(notices.is_empty());
        assert_eq!(soup.polygon_count(), example.cut.triangles.len());
        assert_eq!(soup.texture_corners.len(), 3 * soup.polygon_count());
    }
}

#[test]
fn vertices_of_the_mesh_may_come_from_others_of_the_file() {
    // The mesh has the file's vertices 2, 0, 3 as 0, 1, 2, and vertex 0 once more as 3.
    let positions = vec![[0.0; 3], [9.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let soup = Soup::from_triangles(positions, &[[2, 3, 0], [0, 3, 2]]);
    let mesh = Mesh::new(4, &[[0, 2, 1], [3, 2, 0]]).unwrap();
    let cut = CutMesh::uncut(&mesh);
    let opened = cut.open().unwrap();
    let surface = CutSurface {
        soup: &soup,
        soup_vertices: &[2, 0, 3, 0],
        face_polygons: &[],
        mm_per_unit: None,
        mesh: &mesh,
        cut: &cut,
        opened: &opened,
    };
    let written = String::from_utf8(uv_obj(&surface, &[[f64::NAN; 2]; 4], 1.0)).unwrap();
    assert_eq!(
        lines(&written, "f"),
        [["3", "4", "1"], ["1", "4", "3"]],
        "no chart, no texture coordinates"
    );
    assert!(lines(&written, "vt").is_empty());
    let json: serde_json::Value =
        serde_json::from_slice(&cut_json(&surface, &[5, 6, 7, 6])).unwrap();
    assert_eq!(json["vertex_labels"], serde_json::json!([6, null, 5, 7]));
}

#[test]
fn the_cut_curves_run_from_junction_to_junction() {
    let example = box_with_lid();
    let written = String::from_utf8(cut_obj(&example.surface())).unwrap();
    // All eight corners; at the lid's corners three cuts meet, at the bottom's one ends.
    assert_eq!(lines(&written, "v").len(), 8);
    assert_eq!(lines(&written, "l").len(), 8);
    // A ring without junctions is closed; a cut through is one line.
    let example = pillow();
    let written = String::from_utf8(cut_obj(&example.surface())).unwrap();
    let ring = lines(&written, "l");
    assert_eq!((ring.len(), ring[0].len(), ring[0][0]), (1, 9, ring[0][8]));
    let written = String::from_utf8(cut_obj(&cut_square().surface())).unwrap();
    let places: Vec<[f64; 3]> = lines(&written, "v").iter().map(|words| numbers(words)).collect();
    let mut ends: Vec<usize> = Vec::new();
    let mut total: f64 = 0.0;
    for line in lines(&written, "l") {
        let line: Vec<usize> = line.iter().map(|word| word.parse::<usize>().unwrap() - 1).collect();
        ends.extend([line[0], line[line.len() - 1]]);
        total += line
            .windows(2)
            .map(|w| (Point3::from(places[w[0]]) - Point3::from(places[w[1]])).norm())
            .sum::<f64>();
    }
    assert_eq!(ends.len(), 4, "the way through and the slit, which meet at the rim");
    let slit: f64 = (Point3::new(0.75, 0.25, 0.0) - Point3::new(0.25, 0.0, 0.0)).norm();
    assert!((total - 1.0 - slit).abs() < 1e-12);
}

#[test]
fn the_cut_can_be_read_back_from_its_points_and_labels() {
    let example = cut_square();
    let bytes = cut_json(&example.surface(), &[3, 1, 1, 0, 3, 0]);
    let json: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    assert_eq!(
        (&json["cutflow_cut"], &json["vertices"], &json["patches"]),
        (&1.into(), &6.into(), &2.into())
    );
    assert_eq!(json["vertex_labels"], serde_json::json!([3, 1, 1, null, 3, null]));
    let file = |index: &serde_json::Value| {
        Point3::from(example.soup.positions[index.as_u64().unwrap() as usize])
    };
    let places: Vec<Point3<f64>> = json["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| {
            if let Some(edge) = point.get("edge") {
                let t = point["t"].as_f64().unwrap();
                assert!(t > 0.0 && t < 1.0);
                let (a, b) = (file(&edge[0]), file(&edge[1]));
                a + (b - a) * t
            } else if let Some(face) = point.get("face") {
                let weight = |i: usize| point["weights"][i].as_f64().unwrap();
                Point3::from(
                    (0..3)
                        .map(|i| file(&face[i]).coords * weight(i))
                        .sum::<nalgebra::Vector3<f64>>(),
                )
            } else {
                file(&point["vertex"])
            }
        })
        .collect();
    let segments = json["segments"].as_array().unwrap();
    assert_eq!(segments.len(), 3);
    let left = example.opened.face_patches[0];
    for (segment, [a, b]) in segments.iter().zip(&example.cut.cut_edges) {
        let number = |i: usize| segment[i].as_u64().unwrap();
        for (i, point) in [a, b].into_iter().enumerate() {
            let distance = (places[number(i) as usize] - example.positions[*point as usize]).norm();
            assert!(distance < 1e-15);
        }
        // Upright the small piece is on the left; the slit is within the other.
        let upwards = example.positions[*b as usize].y > example.positions[*a as usize].y;
        let sides = (number(2), number(3));
        let (small, large) = (u64::from(left), u64::from(1 - left));
        let is_slit = example.positions[*b as usize].x > 0.5;
        let expected = match (is_slit, upwards) {
            (true, _) => (large, large),
            (false, true) => (small, large),
            (false, false) => (large, small),
        };
        assert_eq!(sides, expected);
    }
}

#[test]
fn a_ball_cut_in_two_gives_two_round_pieces_with_one_seam() {
    let soup = samples::icosphere(10);
    let triangles = Vec::from_iter((0..soup.polygon_count()).map(|i| {
        let t = soup.polygon(i);
        [t[0], t[1], t[2]]
    }));
    let mesh = Mesh::new(soup.positions.len(), &triangles).unwrap();
    let (geometry, frame) = Geometry::unit_area(&mesh, &soup.positions).unwrap();
    let start = Initial::Plane { point: Point3::new(0.0, 0.01, 0.0), normal: Vector3::y() };
    let flow =
        CutFlow::new(mesh.clone(), geometry.clone(), &start, CutFlowParams::default()).unwrap();
    let mut cut = flow.cut_mesh();
    let positions: Vec<Point3<f64>> =
        cut.points.iter().map(|&p| geometry.locate(&mesh, p)).collect();
    let opened = cut_to_disks(&mut cut, &positions).unwrap().opened;
    let refined = Geometry::new(
        &opened.mesh,
        opened.vertex_points.iter().map(|&p| positions[p as usize]).collect(),
    );
    let flattening = bff(&opened, &refined.unwrap()).unwrap();
    let packing = flattening.pack(&opened, mesh.vertex_count(), 0.02, None);
    let charts = flattening.place(&opened, &packing);
    let charts: Vec<[f64; 2]> = charts.into_iter().map(Into::into).collect();

    // The ball has radius 1 in its file: 50 mm.
    let mm_per_model_unit = 50.0;
    let (pattern, notices) =
        Pattern::new(&opened, &charts, &positions, mm_per_model_unit / frame.scale);
    assert!(notices.is_empty(), "{notices:?}");
    let [a, b] = &pattern.pieces[..] else { panic!("two pieces") };
    let [seam, across] = [a, b].map(|piece| {
        assert_eq!(piece.seams.len(), 1);
        &piece.seams[0]
    });
    assert!(seam.is_closed && across.is_closed);
    // The seam is nearly a great circle; its two sides are equally long by construction of the charts.
    let circle = TAU * 50.0;
    assert!((seam.surface_length_mm / circle - 1.0).abs() < 0.03, "{}", seam.surface_length_mm);
    assert!((seam.length_mm / across.length_mm - 1.0).abs() < 1e-6);
    // A hemisphere flattened with its rim's length kept: a disk of radius 50 mm.
    for piece in [a, b] {
        let disk = TAU / 2.0 * 50.0 * 50.0;
        assert!((piece.area_mm2 / disk - 1.0).abs() < 0.06, "{}", piece.area_mm2);
        assert!((piece.room_mm - 50.0).abs() < 2.0, "{}", piece.room_mm);
    }
    let surface = CutSurface {
        soup: &soup,
        soup_vertices: &[],
        face_polygons: &[],
        mm_per_unit: None,
        mesh: &mesh,
        cut: &cut,
        opened: &opened,
    };
    let written = uv_obj(&surface, &charts, 1.0 / frame.scale);
    let read = obj::read(&written).unwrap().soup;
    assert_eq!(read.positions[..soup.positions.len()], soup.positions);
    let scale = String::from_utf8(written).unwrap();
    let scale: f64 =
        lines(&scale, "#").iter().find(|w| w[0] == "uv_scale").unwrap()[1].parse().unwrap();
    let extent = pattern.bounds.high[0].max(pattern.bounds.high[1]);
    assert!((scale * mm_per_model_unit - extent).abs() < 1e-9 * extent);
}
