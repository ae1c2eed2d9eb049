//! Reading STL and glTF: what loads, what is passed over, what is refused and with which words.
//!
//! Here is what makes files, welding, the collection beside the checkout (a test says so where there is none), and damaged
//! copies of good files; below are the two formats by themselves.

mod gltf_files;
mod stl_files;

use std::fs;
use std::path::PathBuf;

use cutflow::mesh::read::{Content, ReadError, ReadFault, gltf, stl};
use cutflow::mesh::{Soup, Welder};

use crate::mutation::{SplitMix64, mutate};

type Triangle = [[f32; 3]; 3];

/// A sphere of 20 · 4ⁿ triangles about `centre`, seen counter-clockwise from outside; the poles are corners.
fn sphere(n: usize, centre: [f32; 3]) -> Vec<Triangle> {
    let ring = |k: usize, z: f32| {
        let angle = k as f32 * std::f32::consts::PI / 5.0;
        let r = (1.0 - z * z).sqrt();
        [r * angle.cos(), r * angle.sin(), z]
    };
    let z = 0.2_f32.sqrt();
    let (top, bottom) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
    let mut triangles = Vec::new();
    for k in 0..5 {
        // Numbers modulo ten, so that equal corners have equal bits.
        let upper = |j: usize| ring(2 * j % 10, z);
        let lower = |j: usize| ring((2 * j + 1) % 10, -z);
        triangles.push([top, upper(k), upper(k + 1)]);
        triangles.push([upper(k), lower(k), upper(k + 1)]);
        triangles.push([lower(k), lower(k + 1), upper(k + 1)]);
        triangles.push([bottom, lower(k + 1), lower(k)]);
    }
    for _ in 0..n {
        // Sums of two do not depend on their order, so that both sides of an edge have the same middle.
        let middle = |a: [f32; 3], b: [f32; 3]| {
            let m = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
            let length = m.iter().map(|c| c * c).sum::<f32>().sqrt();
            m.map(|c| c / length)
        };
        let split = |[a, b, c]: Triangle| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    let moved = |p: [f32; 3]| [0, 1, 2].map(|k| p[k] + centre[k]);
    triangles.into_iter().map(|t| t.map(moved)).collect()
}

fn binary_stl(header: &str, triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, 0);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0x12, 0x34]);
    }
    bytes
}

fn text_stl(name: &str, triangles: &[Triangle]) -> String {
    let mut text = format!("solid {name}\n");
    for triangle in triangles {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for [x, y, z] in triangle {
            text += &format!("      vertex {x:e} {y:e} {z:e}\n");
        }
        text += "    endloop\n  endfacet\n";
    }
    text + &format!("endsolid {name}\n")
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut chunks = (json.len() as u32).to_le_bytes().to_vec();
    chunks.extend(b"JSON");
    chunks.extend(json);
    if !binary.is_empty() {
        let mut binary = binary.to_vec();
        binary.resize(binary.len().next_multiple_of(4), 0);
        chunks.extend((binary.len() as u32).to_le_bytes());
        chunks.extend(b"BIN\0");
        chunks.extend(binary);
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((12 + chunks.len() as u32).to_le_bytes());
    bytes.extend(chunks);
    bytes
}

/// The different places of corners, and the number of each corner's place.
fn welded(corners: &[[f64; 3]]) -> (Vec<[f64; 3]>, Vec<u32>) {
    let mut welder = Welder::default();
    let numbers = corners.iter().map(|&corner| welder.add(corner)).collect();
    (welder.into_places(), numbers)
}

/// Positions and 16-bit indices of a sphere of 42 vertices and 80 faces, one after the other.
fn sphere_buffer() -> Vec<u8> {
    let corners = sphere(1, [0.0; 3]).concat();
    let (places, indices) = welded(&corners.iter().map(|p| p.map(f64::from)).collect::<Vec<_>>());
    assert_eq!((places.len(), indices.len()), (42, 240));
    let positions = places.as_flattened().iter().flat_map(|&c| (c as f32).to_le_bytes());
    positions.chain(indices.iter().flat_map(|&i| (i as u16).to_le_bytes())).collect()
}

const NODES: &str = r#""scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"#;
const MESHES: &str =
    r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4}]}],"#;
const VIEWS: &str = r#""buffers":[{"byteLength":984}],"bufferViews":[{"buffer":0,"byteLength":504,"target":34962},
    {"buffer":0,"byteOffset":504,"byteLength":480,"target":34963}],"#;
const ACCESSORS: &str = r#""accessors":[{"bufferView":0,"componentType":5126,"count":42,"type":"VEC3"},
    {"bufferView":1,"componentType":5123,"count":240,"type":"SCALAR"}]"#;

/// The sphere as GLB, with parts of its JSON replaced.
fn sphere_glb(changes: &[(&str, &str)]) -> Vec<u8> {
    let mut json = format!(r#"{{"asset":{{"version":"2.0"}},{NODES}{MESHES}{VIEWS}{ACCESSORS}}}"#);
    for (from, to) in changes {
        assert!(json.contains(from), "{from}");
        json = json.replacen(from, to, 1);
    }
    glb(&json, &sphere_buffer())
}

fn triangles_of(soup: &Soup) -> Vec<Vec<u32>> {
    (0..soup.polygon_count()).map(|i| soup.polygon(i).to_vec()).collect()
}

fn texts(content: &Content) -> Vec<&str> {
    content.notices.iter().map(|n| n.text.as_str()).collect()
}

fn counts(result: &Result<Content, ReadError>) -> (usize, usize) {
    let soup = &result.as_ref().unwrap().soup;
    (soup.positions.len(), soup.polygon_count())
}

/// The text of a refusal; each has its advice.
fn refusal(result: Result<Content, ReadError>) -> String {
    let error = result.map(|content| content.soup.polygon_count()).unwrap_err();
    assert!(error.fault.advice().len() > 20, "{error}");
    error.to_string()
}

/// Six times the volume within the faces of one group, positive where they face outwards.
fn volume(soup: &Soup, group: u32) -> f64 {
    (0..soup.polygon_count())
        .filter(|&i| soup.polygon_groups.is_empty() || soup.polygon_groups[i] == group)
        .map(|i| {
            let &[a, b, c] = soup.polygon(i) else { panic!("not a triangle") };
            let [a, b, c] = [a, b, c].map(|v| soup.positions[v as usize]);
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        })
        .sum()
}

/// What every reader promises of every soup.
fn assert_sound(content: &Content) {
    let Content { soup, notices, .. } = content;
    let polygons = soup.polygon_count();
    assert!(polygons > 0 && soup.starts[0] == 0);
    assert!(soup.starts.windows(2).all(|w| w[1] >= w[0] + 3));
    assert_eq!(*soup.starts.last().unwrap() as usize, soup.corners.len());
    assert!(soup.corners.iter().all(|&v| (v as usize) < soup.positions.len()));
    let largest = f64::from(f32::MAX);
    assert!(soup.positions.as_flattened().iter().all(|c| c.abs() <= largest));
    assert!(soup.texture_coordinates.as_flattened().iter().all(|c| c.is_finite()));
    assert!(soup.normals.as_flattened().iter().all(|c| c.is_finite()));
    let refers = |numbers: &[u32], targets: usize, length: usize| {
        assert!(numbers.is_empty() || numbers.len() == length);
        assert!(numbers.iter().all(|&i| i == u32::MAX || (i as usize) < targets));
    };
    refers(&soup.texture_corners, soup.texture_coordinates.len(), soup.corners.len());
    refers(&soup.normal_corners, soup.normals.len(), soup.corners.len());
    refers(&soup.polygon_groups, soup.groups.len(), polygons);
    refers(&soup.polygon_materials, soup.materials.len(), polygons);
    assert!(soup.lines.is_empty() || soup.lines.len() == polygons);
    assert!(notices.iter().all(|n| n.count > 0 && !n.text.is_empty()));
}

// Welding

#[test]
fn welding_numbers_places_in_order_of_first_appearance() {
    let corners = [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-0.0, 0.0, -0.0], [1.0, -0.0, 0.0], [2.0; 3]];
    let (places, numbers) = welded(&corners);
    assert_eq!(places, [[1.0, 0.0, 0.0], [0.0; 3], [2.0; 3]]);
    assert_eq!(numbers, [0, 1, 1, 0, 2]);
    assert!(places[1].iter().all(|c| c.is_sign_positive()));
    assert_eq!(welded(&[]), (vec![], vec![]));
}

#[test]
fn welding_agrees_with_a_search_tree() {
    let mut random = SplitMix64::new(1);
    for spread in [1, 7, 100, 100_000] {
        // Whole numbers and their neighbours: bits that differ at the top only, and at the bottom only.
        let mut number = || random.below(spread) as f64 + (random.below(3) as f64) * f64::EPSILON;
        let corners: Vec<_> = (0..20_000).map(|_| [number(), number(), number()]).collect();
        let (places, numbers) = welded(&corners);
        let mut tree = std::collections::BTreeMap::new();
        for (corner, &n) in corners.iter().zip(&numbers) {
            let next = tree.len() as u32;
            assert_eq!(*tree.entry(corner.map(f64::to_bits)).or_insert(next), n);
            assert_eq!(places[n as usize], *corner);
        }
        assert_eq!(tree.len(), places.len());
    }
}

// The collection

fn shared(file: &str) -> Option<Vec<u8>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes").join(file);
    let bytes = fs::read(&path).ok();
    if bytes.is_none() {
        println!("skipped: {} is not there", path.display());
    }
    bytes
}

#[test]
fn each_hostile_stl_and_glb_has_its_expected_outcome() {
    for (file, expected) in [
        ("random-bytes.stl", Err("not an STL file")),
        ("stl-named.ply", Ok((162, 320))),
        ("truncated.stl", Err("ends early: 200 of 320 facets")),
        ("huge-count.stl", Err("ends early: 4 of 4294967295 facets")),
        ("solid-binary.stl", Ok((162, 320))),
        ("ascii-two-solids.stl", Ok((84, 160))),
        // Corners that almost coincide are not for a reader to join.
        ("jittered.stl", Ok((960, 320))),
        ("truncated.glb", Err("file is 2661 bytes, header says 4436")),
        ("index-out-of-range.glb", Err("mesh 0, primitive 0: face 7 uses vertex 60000 of 42")),
        ("draco-required.glb", Err("needs KHR_draco_mesh_compression, not supported")),
        ("meshopt-required.glb", Err("needs EXT_meshopt_compression, not supported")),
        (
            "accessor-overrun.glb",
            Err("accessor 0: 1000000 elements of 12 bytes from byte 0 of a view of 504 bytes"),
        ),
        ("cyclic-nodes.glb", Err("node 0 is reached twice: a cycle, or two parents")),
        ("external-buffer.glb", Err("buffer 1 is in another file, ../../../etc/hostname")),
        ("bad-json.glb", Err("JSON chunk: EOF while parsing a list at line 1 column 52")),
        ("version-1.glb", Err("byte 4: glTF 1 is not supported")),
        ("strip-no-indices.glb", Ok((12, 10))),
        ("mirrored-instances.glb", Ok((126, 160))),
        ("lines-only.glb", Err("no triangles, only points or lines")),
    ] {
        let Some(bytes) = shared(&format!("bad/{file}")) else { return };
        let result = if file.ends_with("glb") { gltf::read(&bytes) } else { stl::read(&bytes) };
        match expected {
            Ok(expected) => {
                assert_eq!(counts(&result), expected, "{file}");
                assert_sound(&result.unwrap());
            }
            Err(expected) => assert_eq!(refusal(result), expected, "{file}"),
        }
    }
}

#[test]
fn the_good_solids_load_with_their_counts() {
    let Some(koala) = shared("koala.stl") else { return };
    let koala = stl::read(&koala).unwrap();
    assert_eq!((koala.soup.positions.len(), koala.soup.polygon_count()), (3560, 7116));
    let Some(truck) = shared("milk-truck.glb") else { return };
    let truck = gltf::read(&truck).unwrap();
    assert_sound(&truck);
    let soup = &truck.soup;
    assert_eq!((soup.positions.len(), soup.polygon_count()), (1840, 3624));
    assert_eq!(soup.materials, ["truck", "glass", "window_trim", "wheels"]);
    assert_eq!(soup.groups, ["Cesium_Milk_Truck", "Wheels"]);
    // Five primitives drawn: three of the truck, one in either pair of wheels.
    assert_eq!(soup.polygon_materials.chunk_by(|a, b| a == b).count(), 4);
    let wheels = soup.polygon_groups.iter().filter(|g| **g == 1).count();
    assert_eq!(wheels, 2 * 768);
}

// Damage

/// A damaged copy of a GLB: any bytes of it, or one of its two chunks with the lengths put right, so that the damage gets
/// past the container.
fn mutate_glb(seed: u64, bytes: &[u8]) -> Vec<u8> {
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let (json, binary) = (&bytes[20..20 + length], &bytes[28 + length..]);
    match seed % 4 {
        0 => mutate(seed, bytes),
        1 => glb(&String::from_utf8_lossy(json), &mutate(seed, binary)),
        _ => glb(&String::from_utf8_lossy(&mutate(seed, json)), binary),
    }
}

fn good_solids() -> (Vec<Vec<u8>>, Vec<Vec<u8>>) {
    let few = sphere(0, [0.5, -1.25, 3.0]);
    let stls = vec![
        binary_stl("binary", &few),
        text_stl("some solid", &few[..8]).into_bytes(),
        (text_stl("a", &few[..3]) + &text_stl("", &few[3..6])).into_bytes(),
    ];
    let nodes = r#"{"mesh":0,"scale":[1,-2,1],"children":[1,2]},{"mesh":0,"rotation":[0,0.6,0,0.8],
        "name":"n"},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,7,8,9,1]}"#;
    let rich = r#"[{"attributes":{"POSITION":0,"NORMAL":0,"TEXCOORD_0":2},"indices":1,"mode":5,
        "material":0},{"attributes":{"POSITION":0},"mode":6},{"attributes":{"POSITION":3},"indices":1}]"#;
    let more = r#""type":"SCALAR"},{"bufferView":0,"byteOffset":8,"componentType":5121,"normalized":true,
        "count":42,"type":"VEC2"},{"bufferView":0,"componentType":5122,"count":42,"type":"VEC3","sparse":
        {"count":2,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0}}}],
        "materials":[{"name":"m"}]"#;
    let primitive = r#"[{"attributes":{"POSITION":0},"indices":1,"mode":4}]"#;
    let gltfs = vec![
        sphere_glb(&[]),
        sphere_glb(&[(r#"{"mesh":0}"#, nodes), (primitive, rich), ("\"type\":\"SCALAR\"}]", more)]),
    ];
    for bytes in &stls {
        assert!(stl::read(bytes).is_ok());
    }
    for bytes in &gltfs {
        gltf::read(bytes).unwrap();
    }
    (stls, gltfs)
}

fn try_mutants(count: u64) {
    let (stls, gltfs) = good_solids();
    let (mut read, mut refused) = (0, 0);
    let mut check = |result: Result<Content, ReadError>| match result {
        Ok(content) => {
            assert_sound(&content);
            read += 1;
        }
        Err(error) => {
            let text = error.to_string();
            assert!(!text.contains(char::is_control) && text.chars().count() < 200, "{text}");
            assert!(!matches!(error.fault, ReadFault::Empty) || text == "the file is empty");
            refused += 1;
        }
    };
    for seed in 0..count {
        check(stl::read(&mutate(seed, &stls[seed as usize % stls.len()])));
        check(gltf::read(&mutate_glb(seed, &gltfs[seed as usize / 4 % gltfs.len()])));
    }
    // A test in which nothing is read, or nothing refused, would test nothing.
    println!("{read} read, {refused} refused");
    assert!(read > count / 10 && refused > count / 10, "{read} read, {refused} refused");
}

#[test]
fn no_damage_makes_the_readers_of_solids_panic() {
    try_mutants(2000);
}

#[test]
#[ignore = "minutes"]
fn a_million_mutants_do_not_make_the_readers_of_solids_panic() {
    try_mutants(1_000_000);
}
