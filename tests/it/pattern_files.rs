//! Mesh files of a cut surface, read back: by this crate's own readers, and number by number where those do not keep what counts.

use cutflow::mesh::read::{Content, gltf, obj, ply};
use cutflow::mesh::{CutMesh, Mesh, Soup, SurfacePoint, VertexId};
use cutflow::pattern::{
    AtlasImageParams, CutSurface, Texture, atlas_image, flat_obj, uv_glb, uv_obj, uv_ply,
};
use serde_json::Value;

use crate::patterns::{Example, box_with_lid, cut_square, pillow, slit_prism};

/// The two chunks of a GLB.
struct Glb {
    json: Value,
    binary: Vec<u8>,
}

impl Glb {
    fn new(bytes: &[u8]) -> Self {
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], number(4), number(8)), (&b"glTF"[..], 2, bytes.len()));
        let length = number(12);
        assert_eq!((length % 4, &bytes[16..20]), (0, &b"JSON"[..]));
        let json = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        let rest = 20 + length;
        let binary = if rest < bytes.len() { bytes[rest + 8..].to_vec() } else { Vec::new() };
        Self { json, binary }
    }

    fn number(&self, path: &str) -> usize {
        self.json.pointer(path).unwrap_or_else(|| panic!("{path}")).as_u64().unwrap() as usize
    }

    /// Rows of an accessor.
    fn rows(&self, accessor: usize) -> Vec<Vec<f64>> {
        let at = format!("/accessors/{accessor}");
        let view = self.number(&format!("{at}/bufferView"));
        let offset =
            |path: &str| self.json.pointer(path).map_or(0, |x| x.as_u64().unwrap() as usize);
        let start = offset(&format!("/bufferViews/{view}/byteOffset"))
            + offset(&format!("{at}/byteOffset"));
        let columns = match self.json.pointer(&format!("{at}/type")).unwrap().as_str().unwrap() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            other => panic!("{other}"),
        };
        let kind = self.number(&format!("{at}/componentType"));
        let size = if kind == 5123 { 2 } else { 4 };
        assert_eq!(start % size, 0);
        let value = |i: usize| {
            let bytes = &self.binary[start + i * size..start + (i + 1) * size];
            match kind {
                5123 => f64::from(u16::from_le_bytes(bytes.try_into().unwrap())),
                5125 => f64::from(u32::from_le_bytes(bytes.try_into().unwrap())),
                5126 => f64::from(f32::from_le_bytes(bytes.try_into().unwrap())),
                other => panic!("{other}"),
            }
        };
        let count = self.number(&format!("{at}/count"));
        (0..count).map(|row| (0..columns).map(|c| value(row * columns + c)).collect()).collect()
    }

    fn attribute(&self, mesh: usize, primitive: usize, name: &str) -> Vec<Vec<f64>> {
        self.rows(self.number(&format!("/meshes/{mesh}/primitives/{primitive}/attributes/{name}")))
    }
}

fn glb(example: &Example, mm_per_unit: Option<f64>) -> Glb {
    let surface = CutSurface { mm_per_unit, ..example.surface() };
    Glb::new(&uv_glb(&surface, &example.charts, 1.0, "a \"name\"\n\\", Texture::Checker).unwrap())
}

/// A mesh of two squares in the plane with hard normals, two groups and three materials, some polygons without any.
const PARTS: &str = "\
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 2 0 0
v 2 1 0
vn 0 0 2
vn 0 0 0
vn 0.6 0 0.8
g left \"quoted\"
usemtl red
f 1//1 2//1 3//1
f 1//1 3//1 4//2
g right
f 2//3 5//3 6//3
usemtl blue
f 2//3 6//3 3
";

/// The surface of [`PARTS`], cut through the middle of its first square.
fn with_parts(act: impl FnOnce(&CutSurface, &[[f64; 2]])) {
    let soup: Soup = obj::read(PARTS.as_bytes()).unwrap().soup;
    let triangles: Vec<[u32; 3]> = (0..4).map(|i| soup.polygon(i).try_into().unwrap()).collect();
    let mesh = Mesh::new(6, &triangles).unwrap();
    let middle = |a: u32, b: u32| {
        let h = mesh.outgoing(VertexId(a)).find(|&h| mesh.tip(h) == VertexId(b)).unwrap();
        SurfacePoint::Edge(h.edge(), 0.5)
    };
    let mut cut = CutMesh::uncut(&mesh);
    cut.points.extend([middle(0, 1), middle(0, 2), middle(2, 3)]);
    cut.triangles = vec![
        [0, 6, 7],
        [6, 1, 2],
        [6, 2, 7],
        [0, 7, 8],
        [7, 2, 8],
        [0, 8, 3],
        [1, 4, 5],
        [1, 5, 2],
    ];
    cut.triangle_faces = [0, 0, 0, 1, 1, 1, 2, 3].map(cutflow::mesh::FaceId).to_vec();
    cut.cut_edges = vec![[6, 7], [7, 8]];
    let opened = cut.open().unwrap();
    assert_eq!(opened.patch_count, 2);
    let surface = CutSurface {
        soup: &soup,
        soup_vertices: &[],
        face_polygons: &[0, 1, 2, 3],
        mm_per_unit: Some(10.0),
        mesh: &mesh,
        cut: &cut,
        opened: &opened,
    };
    let patches = opened.vertex_patches();
    let charts: Vec<[f64; 2]> = (0..opened.mesh.vertex_count())
        .map(|v| {
            let [x, y, _] = surface.place(cut.points[opened.vertex_points[v] as usize]);
            [x + f64::from(patches[v]), y]
        })
        .collect();
    act(&surface, &charts);
}

#[test]
fn positions_of_a_glb_are_those_of_the_file_and_the_node_makes_metres_of_them() {
    for example in [box_with_lid(), pillow(), slit_prism(), cut_square()] {
        let file = glb(&example, Some(250.0));
        assert_eq!(file.json["nodes"][0]["scale"], serde_json::json!([0.25, 0.25, 0.25]));
        assert_eq!(file.json["nodes"][0]["name"], "a \"name\"\n\\");
        let positions = file.attribute(0, 0, "POSITION");
        let sources = file.attribute(0, 0, "_SOURCE_VERTEX");
        let pieces = file.attribute(0, 0, "_PIECE");
        let own = example.soup.positions.len();
        let points = example.mesh.vertex_count();
        let mut is_used = vec![false; own];
        for (place, source) in positions.iter().zip(&sources) {
            let source = source[0] as usize;
            let exact = match source < own {
                true => example.soup.positions[source],
                false => example.surface().place(example.cut.points[source - own + points]),
            };
            assert_eq!(place[..], exact.map(|x| f64::from(x as f32)));
            if source < own {
                is_used[source] = true;
            }
        }
        let expected = example.mesh.vertices().map(|v| example.mesh.halfedge(v).is_some());
        assert!(expected.eq(is_used), "all vertices that a face uses");
        // One vertex for each point and place: no more than the surface opened.
        assert_eq!(
            positions.len(),
            example
                .opened
                .mesh
                .vertices()
                .filter(|&v| example.opened.mesh.halfedge(v).is_some())
                .count()
        );
        let indices = file.rows(file.number("/meshes/0/primitives/0/indices"));
        let mut next = 0.0;
        for index in &indices {
            assert!(index[0] <= next, "numbered as they are used first");
            next = f64::max(next, index[0] + 1.0);
        }
        for (face, corners) in indices.chunks_exact(3).enumerate() {
            for corner in corners {
                let piece = pieces[corner[0] as usize][0] as u32;
                assert_eq!(piece, example.opened.face_patches[face] + 1);
            }
        }
        let limit = |key: &str, i: usize| {
            file.json["accessors"][file.number("/meshes/0/primitives/0/attributes/POSITION")][key]
                [i]
                .as_f64()
                .unwrap()
        };
        for i in 0..3 {
            let values = || positions.iter().map(|p| p[i]);
            assert_eq!(limit("min", i), values().fold(f64::INFINITY, f64::min));
            assert_eq!(limit("max", i), values().fold(f64::NEG_INFINITY, f64::max));
        }
    }
    assert_eq!(glb(&box_with_lid(), None).json["nodes"][0].get("scale"), None);
}

#[test]
fn all_three_mesh_files_have_the_same_map() {
    for example in [box_with_lid(), slit_prism(), cut_square()] {
        let surface = example.surface();
        let text = uv_obj(&surface, &example.charts, 1.0);
        let Content { soup: from_obj, .. } = obj::read(&text).unwrap();
        let Content { soup: from_ply, .. } =
            ply::read(&uv_ply(&surface, &example.charts, 1.0)).unwrap();
        let file = glb(&example, None);
        let indices = file.rows(file.number("/meshes/0/primitives/0/indices"));
        let uvs = file.attribute(0, 0, "TEXCOORD_0");
        // By triangle: the OBJ has them by piece.
        let mut by_piece: Vec<usize> = (0..example.opened.face_patches.len()).collect();
        by_piece.sort_by_key(|&face| example.opened.face_patches[face]);
        for (k, &face) in by_piece.iter().enumerate() {
            for corner in 0..3 {
                let [u, v] =
                    from_obj.texture_coordinates[from_obj.texture_corners[3 * k + corner] as usize];
                let at = indices[3 * face + corner][0] as usize;
                assert_eq!(uvs[at], [f64::from(u as f32), f64::from((1.0 - v) as f32)]);
                let at = from_ply.texture_corners[3 * face + corner] as usize;
                assert_eq!(from_ply.texture_coordinates[at], [u, v].map(|x| f64::from(x as f32)));
                let position = from_ply.positions[from_ply.corners[3 * face + corner] as usize];
                let expected = from_obj.positions[from_obj.corners[3 * k + corner] as usize];
                assert_eq!(position.map(f64::to_bits), expected.map(f64::to_bits), "bit for bit");
            }
        }
    }
}

#[test]
fn a_glb_read_back_is_the_surface_in_metres() {
    let example = slit_prism();
    let surface = CutSurface { mm_per_unit: Some(1000.0), ..example.surface() };
    let bytes = uv_glb(&surface, &example.charts, 1.0, "prism", Texture::Checker).unwrap();
    let Content { soup, .. } = gltf::read(&bytes).unwrap();
    assert_eq!(soup.positions.len(), example.soup.positions.len(), "welded again");
    assert_eq!(soup.polygon_count(), example.cut.triangles.len());
    for p in &soup.positions {
        // Single precision.
        let near = |q: &[f64; 3]| (0..3).all(|i| (p[i] - q[i]).abs() < 1e-6);
        assert!(example.soup.positions.iter().any(near));
    }
}

#[test]
fn normals_groups_and_materials_come_along() {
    with_parts(|surface, charts| {
        let bytes = uv_glb(surface, charts, 1.0, "parts", Texture::Checker).unwrap();
        let file = Glb::new(&bytes);
        let json = &file.json;
        assert_eq!(json["nodes"][0]["children"], serde_json::json!([1, 2]));
        assert_eq!(json["nodes"][1]["name"], surface.soup.groups[0]);
        assert_eq!(json["meshes"][1]["name"], "right");
        let materials: Vec<&str> = json["materials"]
            .as_array()
            .unwrap()
            .iter()
            .map(|m| m["name"].as_str().unwrap())
            .collect();
        assert_eq!(materials, ["red", "blue"]);
        let primitives = |mesh: usize| json["meshes"][mesh]["primitives"].as_array().unwrap().len();
        assert_eq!([primitives(0), primitives(1)], [1, 2]);
        let normals = file.attribute(0, 0, "NORMAL");
        for n in &normals {
            // Single precision.
            assert!((n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-6);
        }
        // Vertex 2 has two normals, and lies in one piece: two vertices. Without normal of their own corners get their faces'.
        let sources = file.attribute(0, 0, "_SOURCE_VERTEX");
        let of = |v: f64| {
            sources
                .iter()
                .zip(&normals)
                .filter(|(s, _)| s[0] == v)
                .map(|(_, n)| n.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(
            of(1.0),
            [vec![0.0, 0.0, 1.0], vec![f64::from(0.6_f32), 0.0, f64::from(0.8_f32)]]
        );
        assert_eq!(of(3.0), [vec![0.0, 0.0, 1.0]]);
        let Content { soup, .. } = ply::read(&uv_ply(surface, charts, 1.0)).unwrap();
        assert_eq!(soup.positions.len(), sources.len());
        assert!(!soup.normals.is_empty());
    });
}

#[test]
fn faces_without_chart_have_neither_texture_nor_a_place() {
    let mut example = box_with_lid();
    let patches = example.opened.vertex_patches();
    for (place, patch) in example.charts.iter_mut().zip(patches) {
        if *patch == 1 {
            *place = [f64::NAN; 2];
        }
    }
    let file = glb(&example, None);
    let primitives = file.json["meshes"][0]["primitives"].as_array().unwrap();
    let has_uv: Vec<bool> =
        primitives.iter().map(|p| p["attributes"].get("TEXCOORD_0").is_some()).collect();
    assert_eq!(has_uv, [true, false]);
    for (primitive, &has_uv) in primitives.iter().zip(&has_uv) {
        let material = primitive["material"].as_u64().unwrap() as usize;
        let pbr = &file.json["materials"][material]["pbrMetallicRoughness"];
        assert_eq!(pbr.get("baseColorTexture").is_some(), has_uv);
    }
    let flat = String::from_utf8(flat_obj(&example.surface(), &example.charts, None)).unwrap();
    assert!(flat.contains("1 of 2 pieces") && !flat.contains("piece_2") && !flat.contains("NaN"));
    // Without any chart at all there is no map.
    example.charts.fill([f64::NAN; 2]);
    let file = glb(&example, None);
    assert!(
        file.json.get("images").is_none()
            && file.json["nodes"][0]["extras"].get("uv_scale").is_none()
    );
    let _ = uv_ply(&example.surface(), &example.charts, 1.0);
}

#[test]
fn the_flat_mesh_is_in_millimetres_and_its_vertices_are_the_places_in_the_map() {
    let example = box_with_lid();
    let surface = example.surface();
    let Content { soup: flat, .. } =
        obj::read(&flat_obj(&surface, &example.charts, Some(100.0))).unwrap();
    let Content { soup: map, .. } = obj::read(&uv_obj(&surface, &example.charts, 1.0)).unwrap();
    assert_eq!(flat.positions.len(), map.texture_coordinates.len());
    assert_eq!(flat.corners, map.texture_corners);
    let area = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    };
    let mut total = 0.0;
    for triangle in flat.corners.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| flat.positions[triangle[i] as usize]);
        assert!(area(a, b, c) > 0.0, "outer side up");
        total += area(a, b, c);
    }
    // Six sides of 100 mm; rounding of coordinates about 100.
    assert!((total - 60_000.0).abs() < 1e-6);
    let scale = flat.positions.iter().map(|p| p[0].max(p[1])).fold(0.0, f64::max);
    for (p, uv) in flat.positions.iter().zip(&map.texture_coordinates) {
        assert_eq!(p[2], 0.0);
        assert!((p[0] - uv[0] * scale).abs() < 1e-9 && (p[1] - uv[1] * scale).abs() < 1e-9);
    }
}

fn atlas(example: &Example, seam_width: f64, padding: u32) -> Vec<[u8; 3]> {
    let params = AtlasImageParams {
        size: 128,
        colours: &[[200, 0, 0], [0, 200, 0]],
        square: None,
        seam_width,
        padding,
    };
    let bytes = atlas_image(&example.opened, &example.charts, &params);
    bytes.chunks_exact(3).map(|p| p.try_into().unwrap()).collect()
}

#[test]
fn the_atlas_shows_every_piece_where_the_map_has_it() {
    let example = box_with_lid();
    let pixels = atlas(&example, 0.0, 0);
    let count = |colour: [u8; 3]| pixels.iter().filter(|&&p| p == colour).count() as f64;
    // The cross of five squares is 3 wide, the lid 1, and 0.1 lies between: a square has (128 / 4.1)² pixels.
    let square = (128.0_f64 / 4.1).powi(2);
    let [cross, lid] = [count([200, 0, 0]), count([0, 200, 0])];
    // Half a pixel along the outlines at most.
    assert!(
        (cross - 5.0 * square).abs() < 12.0 * 31.2 && (lid - square).abs() < 4.0 * 31.2,
        "{cross} {lid}"
    );
    assert_eq!(cross + lid + count([255; 3]), 128.0 * 128.0);
    // Seen from the outer side, v up: the lid is on the right, and the top of the square is empty.
    let at = |u: f64, v: f64| pixels[(((1.0 - v) * 128.0) as usize) * 128 + (u * 128.0) as usize];
    let Content { soup, .. } =
        obj::read(&uv_obj(&example.surface(), &example.charts, 1.0)).unwrap();
    for (k, triangle) in soup.texture_corners.chunks_exact(3).enumerate() {
        let middle = [0, 1].map(|a| {
            triangle.iter().map(|&t| soup.texture_coordinates[t as usize][a]).sum::<f64>() / 3.0
        });
        let colour = if k < 10 { [200, 0, 0] } else { [0, 200, 0] };
        assert_eq!(at(middle[0], middle[1]), colour);
    }
}

#[test]
fn padding_goes_on_with_the_colours_and_seams_lie_inside() {
    let example = box_with_lid();
    let plain = atlas(&example, 0.0, 0);
    let padded = atlas(&example, 0.0, 2);
    let mut grown = 0;
    for (at, (a, b)) in plain.iter().zip(&padded).enumerate() {
        if a == b {
            continue;
        }
        assert_eq!(*a, [255; 3], "only the background changes");
        let (x, y) = ((at % 128) as i32, (at / 128) as i32);
        let near = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| (x + dx, y + dy)));
        let near = near.filter(|(x, y)| (0..128).contains(x) && (0..128).contains(y));
        assert!(near.into_iter().any(|(x, y)| plain[(y * 128 + x) as usize] == *b));
        grown += 1;
    }
    assert!(grown > 100);
    let full = atlas(&example, 0.0, 128);
    assert!(full.iter().all(|p| *p != [255; 3]), "as far as one likes");
    let seamed = atlas(&example, 4.0, 0);
    for (a, b) in plain.iter().zip(&seamed) {
        assert_eq!(*a == [255; 3], *b == [255; 3], "lines do not leave the pieces");
    }
    assert!(seamed.iter().filter(|p| **p == [50, 0, 0] || **p == [0, 50, 0]).count() > 300);
}

#[test]
fn squares_have_the_size_that_was_asked_for_and_slivers_are_seen() {
    // A strip of 1000 by 1 and a square far above it: much less than a pixel high.
    let example = {
        let mut example = pillow();
        let patches = example.opened.vertex_patches();
        for (place, patch) in example.charts.iter_mut().zip(patches) {
            if *patch == 1 {
                *place = [place[0], place[1] * 1e-6 + 0.513];
            }
        }
        example
    };
    let pixels = atlas(&example, 0.0, 0);
    assert!(pixels.contains(&[0, 200, 0]), "a sliver");
    let example = box_with_lid();
    let colours = [[200; 3]];
    let params = AtlasImageParams {
        size: 82,
        colours: &colours,
        square: Some(0.5),
        seam_width: 0.0,
        padding: 0,
    };
    let bytes = atlas_image(&example.opened, &example.charts, &params);
    // 82 pixels are 4.1 units: a square of half a unit is 10 pixels. Along the middle of the cross.
    let row: Vec<u8> = (0..82).map(|x| bytes[3 * (82 * (81 - 10) + x)]).collect();
    let shades: Vec<u8> = row.into_iter().filter(|&x| x != 255).collect();
    let runs: Vec<usize> = shades.chunk_by(|a, b| a == b).map(<[u8]>::len).collect();
    // The first and the last may be parts of squares.
    assert!(runs.len() >= 3 && runs[1..runs.len() - 1].iter().all(|&n| n == 10), "{runs:?}");
}
