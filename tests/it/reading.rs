//! Reading mesh files: what a file is taken for, the collection of hostile files beside the checkout, and damage.
//!
//! What each format understands and refuses is in the files beside this one, on files that they make themselves. The
//! tests of the collection say so where there is none.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cutflow::geometry::polygon::triangulate;
use cutflow::mesh::Soup;
use cutflow::mesh::read::{self, Content, Format, ReadError};

use super::mutation::{SplitMix64, mutate};
use super::{reading_obj, reading_off, reading_ply};

/// What a reader makes of a file.
#[derive(Debug, PartialEq)]
pub enum Outcome {
    /// Vertices, faces, and the texts of the notices.
    Loads(usize, usize, Vec<String>),
    /// The text of the error.
    Refused(String),
}

pub fn loads(vertices: usize, faces: usize) -> Outcome {
    Outcome::Loads(vertices, faces, Vec::new())
}

pub fn loads_with(vertices: usize, faces: usize, notice: &str) -> Outcome {
    Outcome::Loads(vertices, faces, vec![notice.to_owned()])
}

pub fn refused(text: &str) -> Outcome {
    Outcome::Refused(text.to_owned())
}

/// What becomes of a file of this name, all guarantees checked.
pub fn outcome(name: &str, bytes: &[u8]) -> Outcome {
    outcome_of(&read::read(name, bytes), bytes.len())
}

/// The outcome of reading so many bytes.
pub fn outcome_of(result: &Result<Content, ReadError>, length: usize) -> Outcome {
    match result {
        Ok(Content { soup, notices, .. }) => {
            assert_sound(soup);
            // Text takes 2 bytes for a number at least, binary 1 (PLY of `uchar`): 24 bytes of memory are for 3 numbers, and
            // texture coordinates, normals and room to grow come on top.
            assert!(memory(soup) <= 48 * length + 4096, "{} for {length}", memory(soup));
            assert!(notices.is_sorted_by_key(|notice| notice.place));
            let notices = notices.iter().map(ToString::to_string).collect();
            Outcome::Loads(soup.positions.len(), soup.polygon_count(), notices)
        }
        Err(error) => {
            assert!(!error.fault.advice().is_empty());
            let text = error.to_string();
            assert!(text.len() < 400 && !text.contains(char::is_control), "{text:?}");
            Outcome::Refused(text)
        }
    }
}

/// All that the readers guarantee of a soup.
pub fn assert_sound(soup: &Soup) {
    assert!(soup.positions.iter().flatten().all(|x| x.abs() <= f64::from(f32::MAX)));
    assert_eq!(soup.starts.first(), Some(&0));
    assert_eq!(soup.starts.last().map(|&end| end as usize), Some(soup.corners.len()));
    assert!(soup.starts.windows(2).all(|pair| pair[1] >= pair[0] + 3));
    assert!(soup.lines.is_empty() || soup.lines.len() == soup.polygon_count());
    assert!(soup.lines.is_sorted());
    assert!(soup.corners.iter().all(|&v| (v as usize) < soup.positions.len()));
    assert!(soup.texture_coordinates.iter().flatten().all(|x| x.is_finite()));
    assert!(soup.normals.iter().flatten().all(|x| x.is_finite()));
    assert_indices(&soup.texture_corners, soup.corners.len(), soup.texture_coordinates.len());
    assert_indices(&soup.normal_corners, soup.corners.len(), soup.normals.len());
    assert_indices(&soup.polygon_groups, soup.polygon_count(), soup.groups.len());
    assert_indices(&soup.polygon_materials, soup.polygon_count(), soup.materials.len());
}

/// Empty, or as many as there should be, each in range or none.
fn assert_indices(indices: &[u32], length: usize, range: usize) {
    assert!(indices.is_empty() || indices.len() == length);
    assert!(indices.iter().all(|&i| i == u32::MAX || (i as usize) < range));
}

/// Bytes that the arrays of a soup hold, used or not.
pub fn memory(soup: &Soup) -> usize {
    let indices = [
        &soup.corners,
        &soup.starts,
        &soup.lines,
        &soup.texture_corners,
        &soup.normal_corners,
        &soup.polygon_groups,
        &soup.polygon_materials,
    ];
    24 * (soup.positions.capacity() + soup.normals.capacity())
        + 16 * soup.texture_coordinates.capacity()
        + 4 * indices.iter().map(|array| array.capacity()).sum::<usize>()
        + 24 * (soup.groups.capacity() + soup.materials.capacity())
        + soup.groups.iter().chain(&soup.materials).map(String::capacity).sum::<usize>()
}

/// A binary STL of so many facets.
fn binary_stl(facets: u32, header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(facets.to_le_bytes());
    bytes.extend((0..50 * facets).map(|i| i as u8));
    bytes
}

#[test]
fn content_decides_what_a_file_is() {
    let cases: [(&[u8], Format); 20] = [
        (b"v 0 0 0\n", Format::Obj),
        (b"# long ago\n\n  f 1/2 2 3", Format::Obj),
        (b"ply\nformat ascii 1.0\n", Format::Ply),
        (b"ply\r\nformat ascii 1.0\r\n", Format::Ply),
        (b"ply\rformat", Format::Ply),
        (b"OFF\n3 1 0\n", Format::Off),
        (b"# comment\n  COFF 3 1 0\n", Format::Off),
        (b"STCNOFF\n", Format::Off),
        (b"4OFF\n", Format::Off),
        (b"nOFF\n4\n", Format::Off),
        (b"8 6 12\n0 0 0\n", Format::Off),
        (b"8 6\n-1.5 0 0\n", Format::Off),
        (b"solid thing\n facet normal 0 0 1\n", Format::Stl),
        (b"SOLID\nFACET", Format::Stl),
        (&binary_stl(3, b"COLOR=..."), Format::Stl),
        (&binary_stl(3, b"solid"), Format::Stl),
        (&binary_stl(3, b"ply\nformat"), Format::Stl),
        (b"glTF\x02\0\0\0", Format::Gltf),
        (b"{\"asset\": {\"version\": \"2.0\"}}", Format::Gltf),
        (b" \n{ \"scene\": 0, \"asset\": {}}", Format::Gltf),
    ];
    for (bytes, format) in cases {
        assert_eq!(read::sniff(bytes), Some(format), "{:.40}", String::from_utf8_lossy(bytes));
    }
    let unknown: [&[u8]; 5] = [b"", b"# v 1 2 3\n", b"v one two three\n", b"1 2 3", b"OFFICE"];
    for bytes in unknown {
        assert_eq!(read::sniff(bytes), None, "{}", String::from_utf8_lossy(bytes));
    }
    // Content wins over the name, and the name over nothing.
    let text = reading_obj::sphere();
    for name in ["ball.obj", "ball.ply", "ball", "ball.OFF", "a b/ü\".txt"] {
        assert_eq!(outcome(name, text.as_bytes()), loads(42, 80));
    }
    assert_eq!(outcome("BALL.OFF", b"# nothing\n"), refused("no vertices, no faces"));
    assert_eq!(outcome("ball.ply", b"# nothing\n"), refused("no PLY header"));
    assert_eq!(outcome("ball.off", b"nothing\n"), refused("line 1: no OFF header"));
}

#[test]
fn files_without_a_mesh_are_refused_by_name() {
    let mut random = SplitMix64::new(1);
    let noise = Vec::from_iter((0..6000).map(|_| random.next() as u8));
    let not_read = |what| format!("not a mesh file that can be read (looks like {what})");
    let cases: [(&[u8], &str); 23] = [
        (b"\n <!DOCTYPE html>\n<pre>\nf 1 2 3\nv 1 2\n", "HTML"),
        (b"<html lang=\"de\">", "HTML"),
        (b"<?xml version=\"1.0\"?><COLLADA>", "XML"),
        (b"{\"v\": 1}", "JSON"),
        (b"PK\x03\x04....", "a ZIP archive"),
        (b"PK\x03\x04....3D/3dmodel.model..", "3MF"),
        (b"\x1f\x8b\x08....", "a gzip archive"),
        (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive"),
        (b"%PDF-1.7\n", "PDF"),
        (b"\x89PNG\r\n", "a picture"),
        (b"\xff\xd8\xff\xe0", "a picture"),
        (b"ISO-10303-21;\n", "STEP"),
        (b"Kaydara FBX Binary  \0", "FBX"),
        (b"; FBX 7.3.0 project file\n", "FBX"),
        (b"BLENDER-v300", "a Blender file"),
        (b"\xff\xfev\0 \x000\0", "text in UTF-16"),
        (b"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer"),
        (b"#VRML V2.0 utf8\n", "VRML"),
        (b"v 0 0 0\0\0\0\0", "binary data"),
        (&noise, "binary data"),
        (b"7z\xbc\xaf", "a 7-Zip archive"),
        (b"BZh9", "a bzip2 archive"),
        (b"Rar!\x1a\x07", "a RAR archive"),
    ];
    for (bytes, what) in cases {
        for name in ["thing.obj", "thing.off", "thing"] {
            assert_eq!(outcome(name, bytes), refused(&not_read(what)), "{what}");
        }
        let advice = read::read("x.ply", bytes).unwrap_err().fault.advice();
        for format in ["OBJ", "PLY", "STL", "OFF", "glTF"] {
            assert!(advice.contains(format), "{advice}");
        }
    }
    for name in ["thing.obj", "thing.ply", "thing.stl", "thing.off", "thing.glb", "thing"] {
        assert_eq!(outcome(name, b""), refused("the file is empty"));
    }
    assert_eq!(outcome("list.xyz", b"0 0 0\n1 1 1\n"), refused(&not_read("text")));
}

/// Reads damaged copies of good files: any panic, overflow or lack of memory fails.
fn survives(mutants: u64, files: &[Vec<u8>], read: impl Fn(&[u8]) -> Result<Content, ReadError>) {
    let mut loaded = 0;
    for seed in 0..mutants {
        let file = &files[seed as usize % files.len()];
        let mutant = mutate(seed, file);
        read::sniff(&mutant);
        if let Outcome::Loads(..) = outcome_of(&read(&mutant), mutant.len()) {
            loaded += 1;
        }
    }
    eprintln!("{loaded} of {mutants} mutants of {} files load", files.len());
    // Otherwise the damage is so heavy that it tests the first lines only.
    assert!(loaded > mutants / 50 && loaded < mutants, "{loaded} of {mutants}");
}

#[test]
fn damaged_obj_files_are_read_or_refused() {
    survives(2000, &reading_obj::good_files(), read::obj::read);
}

#[test]
fn damaged_ply_files_are_read_or_refused() {
    survives(2000, &reading_ply::good_files(), read::ply::read);
}

#[test]
fn damaged_off_files_are_read_or_refused() {
    survives(2000, &reading_off::good_files(), read::off::read);
}

#[test]
#[ignore = "a million mutants: minutes"]
fn a_million_damaged_obj_files_are_read_or_refused() {
    survives(1_000_000, &reading_obj::good_files(), read::obj::read);
}

#[test]
#[ignore = "a million mutants: minutes"]
fn a_million_damaged_ply_files_are_read_or_refused() {
    survives(1_000_000, &reading_ply::good_files(), read::ply::read);
}

#[test]
#[ignore = "a million mutants: minutes"]
fn a_million_damaged_off_files_are_read_or_refused() {
    survives(1_000_000, &reading_off::good_files(), read::off::read);
}

// The collection beside the checkout.

/// A folder beside the checkout, or nothing, said aloud.
fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(folder);
    if !path.is_dir() {
        eprintln!("SKIPPED: there is no {}", path.display());
        return None;
    }
    Some(path)
}

/// The files of a folder in these formats, by name.
fn files(folder: &Path, extensions: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        if extensions.iter().any(|e| extension == **e) {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            files.insert(name, std::fs::read(&path).unwrap());
        }
    }
    files
}

#[test]
fn each_hostile_file_has_its_expected_outcome() {
    let Some(folder) = shared("meshes/bad") else { return };
    let mut expected = BTreeMap::from([
        ("empty.obj", refused("the file is empty")),
        ("comments-only.obj", refused("no vertices, no faces")),
        ("html.obj", refused("not a mesh file that can be read (looks like HTML)")),
        ("random-bytes.obj", refused("not a mesh file that can be read (looks like binary data)")),
        ("truncated.obj", loads_with(162, 200, "line 363: face with 1 corner ignored")),
        ("nan-coord.obj", refused("line 11: coordinate nan is not a finite number")),
        ("overflow-coord.obj", refused("line 21: coordinate 1e400 is not a finite number")),
        ("comma-decimal.obj", refused("line 1: -0,525731 is not a number (decimal comma?)")),
        ("huge-offset.obj", loads(162, 320)),
        ("tiny-scale.obj", loads(162, 320)),
        ("anisotropic.obj", loads(162, 320)),
        ("all-same-point.obj", loads(12, 20)),
        ("all-collinear.obj", loads(64, 98)),
        ("index-out-of-range.obj", refused("line 51: vertex 999 of 42")),
        ("negative-indices.obj", loads(54, 83)),
        (
            "mixed-refs.obj",
            Outcome::Loads(
                6,
                4,
                vec!["line 14: vt 77 of 3, ignored".into(), "line 14: vn 88 of 1, ignored".into()],
            ),
        ),
        ("nonmanifold-edge.obj", loads(5, 3)),
        ("fin-on-sphere.obj", loads(43, 81)),
        ("bowtie-vertex.obj", loads(5, 2)),
        ("two-tetra-one-vertex.obj", loads(7, 8)),
        ("touching-holes.obj", loads(81, 124)),
        ("flipped-faces.obj", loads(162, 320)),
        ("inside-out.obj", loads(162, 320)),
        ("moebius.obj", loads(200, 320)),
        ("klein-bottle.obj", loads(512, 1024)),
        ("duplicate-faces.obj", loads(162, 360)),
        ("degenerate-faces.obj", loads(44, 84)),
        ("isolated-vertices.obj", loads(77, 80)),
        ("components.obj", loads(548, 1053)),
        ("triangle-dust.obj", loads(1200, 400)),
        ("single-triangle.obj", loads(3, 1)),
        ("two-spheres-crossing.obj", loads(324, 640)),
        ("polygon-200.obj", loads(400, 202)),
        ("concave-ngons.obj", loads(110, 4)),
        ("nonplanar-ngons.obj", loads(16, 2)),
        ("crlf.obj", loads(42, 80)),
        ("cr-only.obj", loads(42, 80)),
        ("bom-tabs-unicode.obj", loads(42, 80)),
        ("long-line.obj", loads(42, 80)),
        ("continuation-colours.obj", loads(42, 80)),
        ("lines-only.obj", refused("no faces, only 3 vertices and 2 line or point elements")),
        ("UPPER.OBJ", loads(42, 80)),
        ("truncated.ply", refused("ends early: 126 of 320 faces")),
        ("huge-count.ply", refused("ends early: 10 of 4000000000 vertices")),
        ("huge-list.ply", refused("ends early: 0 of 1 faces")),
        ("no-end-header.ply", refused("header has no end_header")),
        ("inf-coord.ply", refused("vertex 5: coordinate inf is not a finite number")),
        ("index-out-of-range.ply", refused("face 3: vertex -1 of 42")),
        ("odd-big-endian.ply", loads(42, 80)),
        ("crlf-header.ply", loads(42, 80)),
        ("ascii-one-line.ply", loads(42, 80)),
        ("tristrips.ply", loads(60, 90)),
        ("point-cloud.ply", refused("no faces (point cloud)")),
        // What it holds is STL.
        ("stl-named.ply", loads_with(162, 320, "960 corners at 162 places")),
        ("truncated.off", refused("ends early: 30 of 42 vertices")),
        ("variants.off", loads(8, 6)),
    ]);
    for (name, bytes) in files(&folder, &["obj", "ply", "off"]) {
        let expected =
            expected.remove(&*name).unwrap_or_else(|| panic!("{name} is not in the table"));
        assert_eq!(outcome(&name, &bytes), expected, "{name}");
    }
    assert!(expected.is_empty(), "not in the folder: {expected:?}");
}

#[test]
fn the_good_meshes_load_with_their_counts() {
    let Some(folder) = shared("meshes") else { return };
    let files = files(&folder, &["obj", "ply", "off"]);
    for (name, vertices, faces) in [
        ("spot.obj", 2930, 5856),
        ("spot-control.obj", 188, 180),
        ("stanford-bunny.obj", 35947, 69451),
        ("bunny-closed.obj", 14290, 28576),
        ("face.obj", 17157, 34144),
        ("beetle.obj", 30024, 58738),
        ("hood.obj", 3998, 7660),
        ("hand.obj", 7993, 15982),
        ("armadillo.obj", 14587, 29170),
        ("homer.obj", 6002, 12000),
        ("cheburashka.obj", 6669, 13334),
        ("fandisk.obj", 6475, 12946),
        ("rocker-arm.obj", 10044, 20088),
        ("torus.obj", 4608, 9216),
        ("double-torus.obj", 5644, 11292),
        ("chair.obj", 7020, 14044),
        ("nefertiti.ply", 35002, 70000),
        ("igea.ply", 134_345, 268_686),
        ("fertility.off", 4494, 9000),
    ] {
        assert_eq!(outcome(name, &files[name]), loads(vertices, faces), "{name}");
    }
    let spot = read::read("spot.obj", &files["spot.obj"]).unwrap().soup;
    assert_eq!(spot.texture_coordinates.len(), 3225);
    assert!(spot.texture_corners.iter().all(|&t| t != u32::MAX));
    let nefertiti = read::read("nefertiti.ply", &files["nefertiti.ply"]).unwrap().soup;
    assert_eq!(nefertiti.normals.len(), 35002);
    let length = |n: &[f64; 3]| n.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Unit normals, in the digits of `f32`.
    assert!(nefertiti.normals.iter().all(|n| (length(n) - 1.0).abs() < 1e-5));
    assert_eq!(nefertiti.normal_corners, nefertiti.corners);
    let control = read::read("spot-control.obj", &files["spot-control.obj"]).unwrap().soup;
    assert_eq!(control.polygon_groups.len(), 180);
    assert_eq!(control.polygon_materials.len(), 180);
}

/// All triangles of a soup, face by face.
fn triangles_of_faces(soup: &Soup) -> Vec<Vec<[u32; 3]>> {
    let triangles = |i| {
        let mut out = Vec::new();
        triangulate(&soup.positions, soup.polygon(i), &mut out);
        out
    };
    (0..soup.polygon_count()).map(triangles).collect()
}

fn signed_area_xy(soup: &Soup, triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| soup.positions[v as usize]);
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
}

#[test]
fn polygons_of_files_become_all_their_triangles() {
    let Some(folder) = shared("meshes") else { return };
    for (name, triangles) in [
        ("spot-control.obj", 372),
        ("bad/polygon-200.obj", 796),
        ("bad/concave-ngons.obj", 102),
        ("bad/nonplanar-ngons.obj", 12),
    ] {
        let soup = read::read(name, &std::fs::read(folder.join(name)).unwrap()).unwrap().soup;
        let faces = triangles_of_faces(&soup);
        assert_eq!(faces.iter().map(Vec::len).sum::<usize>(), triangles, "{name}");
        for (i, face) in faces.iter().enumerate() {
            let mut used = face.concat();
            let mut corners = soup.polygon(i).to_vec();
            used.sort_unstable();
            used.dedup();
            corners.sort_unstable();
            assert_eq!(used, corners, "{name}: each corner of face {i} is used");
        }
    }
}

#[test]
fn concave_polygons_of_a_file_have_their_exact_areas() {
    let Some(folder) = shared("meshes/bad") else { return };
    let bytes = std::fs::read(folder.join("concave-ngons.obj")).unwrap();
    let soup = read::read("concave-ngons.obj", &bytes).unwrap().soup;
    // The areas in the head of the file, to their six digits.
    for (face, expected) in triangles_of_faces(&soup).iter().zip([0.759297, 5.11, 1.231161, 1.2]) {
        let areas = Vec::from_iter(face.iter().map(|&t| signed_area_xy(&soup, t)));
        assert!(areas.iter().all(|&area| area > 0.0), "no triangle is turned over: {areas:?}");
        assert!(
            (areas.iter().sum::<f64>() - expected).abs() < 1e-6,
            "{}",
            areas.iter().sum::<f64>()
        );
    }
}
