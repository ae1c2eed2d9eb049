//! glTF: containers, promises of accessors, transforms, attributes.

use cutflow::mesh::Soup;
use cutflow::mesh::read::gltf;

use super::{
    NODES, assert_sound, counts, glb, refusal, sphere_buffer, sphere_glb, texts, triangles_of,
    volume,
};

/// A glTF of one mesh of one primitive: positions, indices, and the rest of the primitive.
fn small(positions: &[[f32; 3]], indices: Option<(&[u8], u32, usize)>, rest: &str) -> Vec<u8> {
    let mut binary: Vec<u8> =
        positions.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    let (first, vertices) = (binary.len(), positions.len());
    let mut accessors =
        format!(r#"{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3"}}"#);
    let mut views = format!(r#"{{"buffer":0,"byteLength":{first}}}"#);
    let mut primitive = r#""attributes":{"POSITION":0}"#.to_owned();
    if let Some((bytes, component, count)) = indices {
        let length = bytes.len();
        binary.extend(bytes);
        views += &format!(r#",{{"buffer":0,"byteOffset":{first},"byteLength":{length}}}"#);
        accessors += &format!(
            r#",{{"bufferView":1,"componentType":{component},"count":{count},"type":"SCALAR"}}"#
        );
        primitive += r#","indices":1"#;
    }
    let length = binary.len();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{{primitive}{rest}}}]}}],
            "buffers":[{{"byteLength":{length}}}],"bufferViews":[{views}],"accessors":[{accessors}]}}"#
    );
    glb(&json, &binary)
}

#[test]
fn a_glb_loads_in_all_its_forms() {
    let plain = gltf::read(&sphere_glb(&[])).unwrap();
    assert_eq!((plain.soup.positions.len(), plain.soup.polygon_count()), (42, 80));
    assert!(plain.notices.is_empty(), "{:?}", plain.notices);
    assert_eq!(plain.soup.groups, ["node 0"]);
    assert!(volume(&plain.soup, 0) > 0.0);
    assert_sound(&plain);
    // Without scene, without nodes; with what the house does not read.
    for changes in [
        [(r#""scene":0,"scenes":[{"nodes":[0]}],"#, "")],
        [(NODES, "")],
        [(r#""scene":0,"#, r#""extras":"x","cameras":[],"#)],
        [(r#""type":"SCALAR""#, r#""type":"SCALAR","min":[0],"max":[41],"extras":[1]"#)],
    ] {
        assert_eq!(gltf::read(&sphere_glb(&changes)).unwrap().soup.corners, plain.soup.corners);
    }
    // As text, the buffer in base64.
    let glb = sphere_glb(&[(
        r#"{"byteLength":984}"#,
        &format!(
            r#"{{"byteLength":984,"uri":"data:application/octet-stream;base64,{}"}}"#,
            base64(&sphere_buffer())
        ),
    )]);
    let length = u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
    let text = gltf::read(&glb[20..20 + length]).unwrap();
    assert_eq!(text, plain);
    let mut longer = sphere_glb(&[]);
    longer.extend(b"tail");
    assert_eq!(texts(&gltf::read(&longer).unwrap()), ["4 bytes after the end ignored"]);
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let group = three.iter().fold(0, |g, &b| g << 8 | u32::from(b)) << (8 * (3 - three.len()));
        for k in 0..4 {
            let is_padding = k > three.len();
            let letter = LETTERS[(group >> (18 - 6 * k) & 63) as usize] as char;
            text.push(if is_padding { '=' } else { letter });
        }
    }
    text
}

#[test]
fn damaged_containers_are_refused_with_their_sizes() {
    let bytes = sphere_glb(&[]);
    let length = bytes.len();
    let expected = format!("file is 1000 bytes, header says {length}");
    assert_eq!(refusal(gltf::read(&bytes[..1000])), expected);
    assert_eq!(refusal(gltf::read(&bytes[..7])), "ends early: 7 of 12 bytes of the header");
    let mut first = bytes.clone();
    first[4] = 1;
    assert_eq!(refusal(gltf::read(&first)), "byte 4: glTF 1 is not supported");
    let mut long = bytes.clone();
    long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    let expected = format!("byte 12: chunk of 4294967295 bytes where {} are left", length - 20);
    assert_eq!(refusal(gltf::read(&long)), expected);
    let mut other = bytes.clone();
    other[16..20].copy_from_slice(b"JSOM");
    assert_eq!(refusal(gltf::read(&other)), "no JSON chunk");
    assert_eq!(refusal(gltf::read(b"")), "the file is empty");
    assert_eq!(refusal(gltf::read(b"v 0 0 0")), "not a glTF file");
    assert_eq!(refusal(gltf::read(b"{\"a\":1}")), "not a glTF file");
    let old = br#"{"asset":{"version":"1.1"},"nodes":{"a":{}}}"#;
    assert_eq!(refusal(gltf::read(old)), "glTF 1.1 is not supported");
    let old = br#"{"asset":{},"nodes":{"a":{}}}"#;
    assert_eq!(refusal(gltf::read(old)), "glTF 1 is not supported");
}

#[test]
fn json_of_any_depth_or_number_is_refused_in_words() {
    // The version is told without making anything of what follows the first type that does not fit.
    let deep = "[".repeat(1_000_000) + &"]".repeat(1_000_000);
    let old = format!(r#"{{"asset":{{"version":"1.0"}},"nodes":{{"a":{deep}}}}}"#);
    assert_eq!(refusal(gltf::read(old.as_bytes())), "glTF 1 is not supported");
    let cut = glb(r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":["#, &[]);
    let expected = "JSON chunk: EOF while parsing a list at line 1 column 52";
    assert_eq!(refusal(gltf::read(&cut)), expected);
    // Deep in what is read, in an extension, and in what is skipped.
    for key in ["nodes", "extensions", "extras", "unknown"] {
        let deep = format!(r#"{{"asset":{{"version":"2.0"}},"{key}":{}"#, "[".repeat(1_000_000));
        let error = refusal(gltf::read(deep.as_bytes()));
        assert!(error.starts_with("JSON: "), "{error}");
        let deep =
            format!(r#"{{"asset":{{"version":"2.0"}},"{key}":{}"#, r#"{"a":"#.repeat(900_000));
        let error = refusal(gltf::read(deep.as_bytes()));
        assert!(error.starts_with("JSON: "), "{error}");
    }
    let long = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":"{}"}}]}}"#,
        "\u{7}x\\n".repeat(9999)
    );
    let error = refusal(gltf::read(long.as_bytes()));
    assert!(error.chars().count() < 140 && !error.contains(char::is_control), "{error}");
    let many =
        format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{}{{}}]}}"#, "{},".repeat(1_000_000));
    let expected = "1000003 JSON objects, more than 1000000";
    assert_eq!(refusal(gltf::read(many.as_bytes())), expected);
}

#[test]
fn compressed_meshes_are_refused_by_the_name_of_the_extension() {
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"]
    {
        let required = format!(r#""asset":{{"version":"2.0"}},"extensionsRequired":["{name}"]"#);
        let bytes = sphere_glb(&[(r#""asset":{"version":"2.0"}"#, &required)]);
        let error = gltf::read(&bytes).unwrap_err();
        assert_eq!(error.to_string(), format!("needs {name}, not supported"));
        assert!(error.fault.advice().contains("without compression"));
    }
    // Merely used, but with nothing else to read.
    let draco = r#""mode":4,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}"#;
    let used = |name: &str| format!(r#""asset":{{"version":"2.0"}},"extensionsUsed":["{name}"]"#);
    let asset = r#""asset":{"version":"2.0"}"#;
    let draco_used = (asset, &*used("KHR_draco_mesh_compression"));
    let bytes = sphere_glb(&[
        draco_used,
        (r#""mode":4"#, draco),
        (r#""bufferView":0,"componentType""#, r#""componentType""#),
    ]);
    assert_eq!(refusal(gltf::read(&bytes)), "needs KHR_draco_mesh_compression, not supported");
    // With plain accessors beside it, these are read.
    assert_eq!(counts(&gltf::read(&sphere_glb(&[draco_used, (r#""mode":4"#, draco)]))), (42, 80));
    let meshopt = r#""byteLength":504,"extensions":{"EXT_meshopt_compression":{"buffer":0}}"#;
    let bytes = sphere_glb(&[
        (asset, &used("EXT_meshopt_compression")),
        (r#""bufferViews":[{"buffer":0"#, r#""bufferViews":[{"buffer":1"#),
        (r#"[{"byteLength":984}]"#, r#"[{"byteLength":984},{"byteLength":984}]"#),
        (r#""byteLength":504"#, meshopt),
    ]);
    assert_eq!(refusal(gltf::read(&bytes)), "needs EXT_meshopt_compression, not supported");
    for (name, is_read) in
        [("KHR_mesh_quantization", true), ("KHR_materials_unlit", true), ("ACME_voxels", false)]
    {
        let required = format!(r#""asset":{{"version":"2.0"}},"extensionsRequired":["{name}"]"#);
        let bytes = sphere_glb(&[(r#""asset":{"version":"2.0"}"#, &required)]);
        assert_eq!(gltf::read(&bytes).is_ok(), is_read, "{name}");
    }
}

#[test]
fn no_byte_outside_the_file_is_asked_for() {
    let view = r#""bufferViews":[{"buffer":0"#;
    let other = r#"[{"byteLength":984},{"uri":"../../../etc/hostname","byteLength":16}]"#;
    let external =
        sphere_glb(&[(view, r#""bufferViews":[{"buffer":1"#), (r#"[{"byteLength":984}]"#, other)]);
    assert_eq!(
        refusal(gltf::read(&external)),
        "buffer 1 is in another file, ../../../etc/hostname"
    );
    // One that nothing is drawn from does no harm.
    assert_eq!(counts(&gltf::read(&sphere_glb(&[(r#"[{"byteLength":984}]"#, other)]))), (42, 80));
    for (from, to, expected) in [
        (
            "\"count\":42",
            "\"count\":1000000",
            "accessor 0: 1000000 elements of 12 bytes from byte 0 of a view of 504 bytes",
        ),
        (
            "\"count\":240",
            "\"count\":241",
            "accessor 1: 241 elements of 2 bytes from byte 0 of a view of 480 bytes",
        ),
        (
            "\"count\":42",
            "\"count\":18446744073709551615",
            "accessor 0: 18446744073709551615 elements of 12 bytes from byte 0 of a view of 504 bytes",
        ),
        (
            "\"bufferView\":0",
            "\"bufferView\":0,\"byteOffset\":1",
            "accessor 0: 42 elements of 12 bytes from byte 1 of a view of 504 bytes",
        ),
        ("\"bufferView\":0", "\"bufferView\":7", "buffer view 7: does not exist"),
        ("\"bufferView\":0,", "", "accessor 0: has no buffer view"),
        (
            "\"byteLength\":504",
            "\"byteLength\":504,\"byteStride\":13",
            "accessor 0: 42 elements of 12 bytes from byte 0 of a view of 504 bytes",
        ),
        (
            "\"byteLength\":504",
            "\"byteLength\":504,\"byteStride\":4",
            "accessor 0: elements of 12 bytes every 4 bytes",
        ),
        (
            "\"byteOffset\":504",
            "\"byteOffset\":505",
            "buffer view 1: 480 bytes from byte 505 of buffer 0, which has 984",
        ),
        (
            "\"byteOffset\":504",
            "\"byteOffset\":18446744073709551615",
            "buffer view 1: 480 bytes from byte 18446744073709551615 of buffer 0, which has 984",
        ),
        ("[{\"byteLength\":984}]", "[]", "buffer view 0: buffer 0 does not exist"),
        (
            "[{\"byteLength\":984}]",
            "[{\"byteLength\":983}]",
            "buffer view 1: 480 bytes from byte 504 of buffer 0, which has 983",
        ),
        (
            "[{\"byteLength\":984}]",
            "[{\"byteLength\":984,\"uri\":\"data:,x\"}]",
            "buffer 0: its data URI is not in base64",
        ),
        (
            "[{\"byteLength\":984}]",
            "[{\"byteLength\":984,\"uri\":\"data:;base64,A\"}]",
            "buffer 0: its data URI is not valid base64",
        ),
        (
            "\"componentType\":5126",
            "\"componentType\":5125",
            "accessor 0: positions should be three floats or short integers each",
        ),
        (
            "\"VEC3\"",
            "\"VEC2\"",
            "accessor 0: positions should be three floats or short integers each",
        ),
        (
            "\"componentType\":5123",
            "\"componentType\":5126",
            "accessor 1: indices should be single unsigned integers",
        ),
        ("\"componentType\":5123", "\"componentType\":5124", "accessor 1: its type is unknown"),
        ("\"indices\":1", "\"indices\":2", "accessor 2: does not exist"),
        ("\"mode\":4", "\"mode\":7", "mesh 0, primitive 0: unknown mode"),
        ("\"mode\":4", "\"mode\":1", "no triangles, only points or lines"),
        ("{\"mesh\":0}", "{\"mesh\":1}", "node 0: mesh 1 does not exist"),
        ("{\"nodes\":[0]}", "{\"nodes\":[3]}", "node 3: does not exist, there are 1"),
        ("\"scene\":0", "\"scene\":5", "scene 5: does not exist"),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"children\":[0]}",
            "node 0 is reached twice: a cycle, or two parents",
        ),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"children\":[1]},{\"children\":[0]}",
            "node 0 is reached twice: a cycle, or two parents",
        ),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"translation\":[3e38,0,0],\"children\":[1]},{\"mesh\":0,\"translation\":[3e38,0,0]}",
            "node 1: moves a vertex beyond 3.4e38",
        ),
    ] {
        assert_eq!(refusal(gltf::read(&sphere_glb(&[(from, to)]))), expected);
    }
    // How far the parser of numbers goes depends on its build: infinity, or a refusal of its own.
    let huge =
        refusal(gltf::read(&sphere_glb(&[("{\"mesh\":0}", "{\"mesh\":0,\"scale\":[1e39,1,1]}")])));
    assert!(huge.contains("not finite") || huge.contains("out of range"), "{huge}");
    let mut bytes = sphere_glb(&[]);
    let end = bytes.len();
    bytes[end - 480 + 2 * 22..][..2].copy_from_slice(&60000_u16.to_le_bytes());
    let expected = "mesh 0, primitive 0: face 7 uses vertex 60000 of 42";
    assert_eq!(refusal(gltf::read(&bytes)), expected);
    bytes[end - 984 + 12 * 3..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    bytes[end - 480 + 2 * 22..][..2].copy_from_slice(&3_u16.to_le_bytes());
    let expected = "mesh 0, primitive 0: vertex 3: coordinate inf is not a finite number";
    assert_eq!(refusal(gltf::read(&bytes)), expected);
}

#[test]
fn strips_and_fans_have_one_side_up_with_and_without_indices() {
    let zigzag: Vec<[f32; 3]> = (0..12).map(|i| [(i % 2) as f32, (i / 2) as f32, 0.0]).collect();
    let is_up = |soup: &Soup, triangle: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|i| soup.positions[triangle[i] as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
    };
    let ids: Vec<u8> = (0..12).collect();
    let short: Vec<u8> = (0..12_u16).flat_map(u16::to_le_bytes).collect();
    let long: Vec<u8> = (0..12_u32).flat_map(u32::to_le_bytes).collect();
    for indices in
        [None, Some((&*ids, 5121, 12)), Some((&*short, 5123, 12)), Some((&*long, 5125, 12))]
    {
        let content = gltf::read(&small(&zigzag, indices, r#","mode":5"#)).unwrap();
        assert_eq!((content.soup.positions.len(), content.soup.polygon_count()), (12, 10));
        assert!(triangles_of(&content.soup).iter().all(|t| is_up(&content.soup, t)));
    }
    // Two strips of four: joined by repeated indices, and by a restart.
    let joined = [0, 1, 2, 3, 3, 6, 6, 7, 8, 9];
    let soup = gltf::read(&small(&zigzag, Some((&joined, 5121, 10)), r#","mode":5"#)).unwrap().soup;
    assert_eq!(soup.polygon_count(), 4);
    assert!(triangles_of(&soup).iter().all(|t| is_up(&soup, t)));
    let restarted = [0, 1, 2, 3, 255, 6, 7, 8, 9];
    let soup =
        gltf::read(&small(&zigzag, Some((&restarted, 5121, 9)), r#","mode":5"#)).unwrap().soup;
    assert_eq!(soup.polygon_count(), 4);
    assert!(triangles_of(&soup).iter().all(|t| is_up(&soup, t)));
    // A list with the number of a restart refers to a vertex that is not there.
    let error = refusal(gltf::read(&small(&zigzag, Some((&[0, 1, 255], 5121, 3)), "")));
    assert_eq!(error, "mesh 0, primitive 0: face 0 uses vertex 255 of 12");

    let fan = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let soup = gltf::read(&small(&fan, None, r#","mode":6"#)).unwrap().soup;
    assert_eq!(triangles_of(&soup), [[0, 1, 2], [0, 2, 3]]);
    let list = gltf::read(&small(&fan, None, "")).unwrap();
    assert_eq!(list.soup.polygon_count(), 1);
    assert_eq!(texts(&list), ["an incomplete last face left out in 1 primitive"]);
}

#[test]
fn copies_stay_apart_and_outside_stays_outside() {
    let nodes = r#"{"mesh":0,"scale":[1,-2,1],"translation":[5,0,0]},
        {"mesh":0,"rotation":[0,0.7071068,0,0.7071068]},{"mesh":0,"scale":[0,0,0]}"#;
    let bytes =
        sphere_glb(&[(r#"{"mesh":0}"#, nodes), (r#"{"nodes":[0]}"#, r#"{"nodes":[0,1,2]}"#)]);
    let content = gltf::read(&bytes).unwrap();
    assert_sound(&content);
    let soup = &content.soup;
    assert_eq!((soup.positions.len(), soup.polygon_count()), (126, 160));
    assert_eq!(texts(&content), ["80 faces without area left out"]);
    let one = volume(&gltf::read(&sphere_glb(&[])).unwrap().soup, 0);
    // Positions and the rotation are of single precision, 1e-7.
    assert!((volume(soup, 0) / one - 2.0).abs() < 1e-6, "{}", volume(soup, 0) / one);
    assert!((volume(soup, 1) / one - 1.0).abs() < 1e-6, "{}", volume(soup, 1) / one);
    let flat = sphere_glb(&[(r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[0,0,0]}"#)]);
    assert_eq!(refusal(gltf::read(&flat)), "no triangles, only faces without area");
}

#[test]
fn nested_transforms_are_products_and_scenes_choose() {
    let nodes = r#"{"name":"outer","translation":[10,0,0],"children":[1]},
        {"name":"inner","matrix":[0,2,0,0,-2,0,0,0,0,0,2,0,0,1,0,1],"mesh":0},
        {"name":"unused","mesh":0}"#;
    let content = gltf::read(&sphere_glb(&[(r#"{"mesh":0}"#, nodes)])).unwrap();
    let plain = gltf::read(&sphere_glb(&[])).unwrap().soup;
    assert_eq!(content.soup.groups, ["inner"]);
    assert_eq!(texts(&content), ["1 node with a mesh left out, not in the scene"]);
    for (moved, p) in content.soup.positions.iter().zip(&plain.positions) {
        let expected = [10.0 - 2.0 * p[1], 1.0 + 2.0 * p[0], 2.0 * p[2]];
        // A few roundings of numbers up to 12.
        assert!(moved.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-14), "{moved:?}");
    }
    let projective = r#"{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0.5,0,0,0,1]}"#;
    let bytes = sphere_glb(&[(r#"{"mesh":0}"#, projective)]);
    assert_eq!(refusal(gltf::read(&bytes)), "node 0: its matrix is not affine");
    // As deep as there are nodes.
    let chain: Vec<_> = (1..=100_000).map(|i| format!(r#"{{"children":[{i}]}},"#)).collect();
    let bytes = sphere_glb(&[(r#"{"mesh":0}"#, &(chain.concat() + r#"{"mesh":0}"#))]);
    assert_eq!(counts(&gltf::read(&bytes)), (42, 80));
}

#[test]
fn meshes_drawn_far_too_often_are_refused_before_they_are_made() {
    let nodes = [r#"{"mesh":0}"#; 60_000].join(",");
    let bytes =
        sphere_glb(&[(r#"{"mesh":0}"#, &nodes), (r#""scene":0,"scenes":[{"nodes":[0]}],"#, "")]);
    let most = 4_000_000 + bytes.len() / 2;
    let expected = format!("draws 4800000 triangles, more than {most} for a file of this size");
    assert_eq!(refusal(gltf::read(&bytes)), expected);
    let same = r#"{"attributes":{"POSITION":0},"indices":1,"mode":4}"#;
    let primitives = [same; 90_000].join(",");
    let error = refusal(gltf::read(&sphere_glb(&[(same, &primitives)])));
    assert!(error.starts_with("draws 7200000 triangles"), "{error}");
}

/// A quad of two primitives that share an edge: its attributes in all forms.
#[test]
fn texture_coordinates_normals_materials_and_names_are_kept() {
    let floats =
        |numbers: &[f32]| numbers.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>();
    let mut binary =
        floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 0., 0., 1., 1., 0., 0., 1., 0.]);
    binary.extend(floats(&[0., 0., 1., 0., 1., 1.])); // 72: uv of the first, floats
    binary.extend([0, 0, 255, 255, 0, 255, 0, 0]); // 96: uv of the second, normalised bytes
    binary.extend(floats(&[0., 0., 1., 0., 0., 1., 0., 0., 2.])); // 104: normals of the first
    binary.extend([0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 0x80, 0]); // 140: of the second, every four bytes
    let json = r#"{"asset":{"version":"2.0"},
        "nodes":[{"mesh":0,"scale":[2,1,-1],"name":"left\nwing"},{"mesh":0,"translation":[0,0,9]}],
        "materials":[{"name":"unused"},{"name":"paint"},{}],
        "animations":[],
        "meshes":[{"name":"quad","primitives":[
            {"attributes":{"POSITION":0,"TEXCOORD_0":2,"NORMAL":4},"material":2},
            {"attributes":{"POSITION":1,"TEXCOORD_0":3,"NORMAL":5},"material":1,"targets":[{"POSITION":1}]},
            {"attributes":{"POSITION":1},"mode":0},
            {"attributes":{}}]}],
        "buffers":[{"byteLength":152}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36},
            {"buffer":0,"byteOffset":72,"byteLength":24},{"buffer":0,"byteOffset":96,"byteLength":8},
            {"buffer":0,"byteOffset":104,"byteLength":36},
            {"buffer":0,"byteOffset":140,"byteLength":12,"byteStride":4}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
            {"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"},
            {"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"},
            {"bufferView":3,"componentType":5121,"normalized":true,"count":3,"type":"VEC2"},
            {"bufferView":4,"componentType":5126,"count":3,"type":"VEC3"},
            {"bufferView":5,"componentType":5120,"normalized":true,"count":3,"type":"VEC3"}]}"#;
    let content = gltf::read(&glb(json, &binary)).unwrap();
    assert_sound(&content);
    let soup = &content.soup;
    assert_eq!(soup.groups, ["left\u{fffd}wing", "quad"]);
    assert_eq!(soup.materials, ["material 2", "paint"]);
    assert_eq!(
        (&*soup.polygon_groups, &*soup.polygon_materials),
        (&[0, 0, 1, 1][..], &[0, 1, 0, 1][..])
    );
    // One pool for both primitives, turned in the mirrored copy.
    assert_eq!(triangles_of(soup), [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]]);
    assert_eq!(soup.positions[2], [2.0, 1.0, 0.0]);
    // From the bottom left, and shared by the copies.
    let uv = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    assert_eq!(soup.texture_coordinates, uv);
    assert_eq!(soup.texture_corners, [0, 2, 1, 3, 5, 4, 0, 1, 2, 3, 4, 5]);
    // Of length 1, and along with the faces.
    let (down, up) = ([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    assert_eq!(soup.normals, [down, down, down, down, down, up, up, up, up, up, up, down]);
    assert_eq!(soup.normal_corners, [0, 2, 1, 3, 5, 4, 6, 7, 8, 9, 10, 11]);
    assert_eq!(
        texts(&content),
        [
            "6 vertices at 4 places",
            "1 primitive of points or lines left out",
            "1 primitive without positions left out",
            "morph targets of 1 primitive ignored",
        ]
    );
    // What is wrong with them is forgiven.
    let bad = json.replace(r#""TEXCOORD_0":3,"NORMAL":5"#, r#""TEXCOORD_0":9,"NORMAL":1000"#);
    let content = gltf::read(&glb(&bad, &binary)).unwrap();
    assert_eq!(content.soup.texture_corners[..6], [0, 2, 1, u32::MAX, u32::MAX, u32::MAX]);
    assert!(texts(&content).contains(&"texture coordinates of 1 primitive unreadable, ignored"));
    assert!(texts(&content).contains(&"normals of 1 primitive unreadable, ignored"));
    let mut bytes = binary.clone();
    bytes[72..76].copy_from_slice(&f32::NAN.to_le_bytes());
    let content = gltf::read(&glb(json, &bytes)).unwrap();
    assert_eq!(content.soup.texture_corners[..3], [u32::MAX, 1, 0]);
    assert!(texts(&content).contains(&"1 texture coordinate not a number, ignored"));
}

#[test]
fn quantised_and_sparse_positions_are_read() {
    // Three corners as normalised shorts; then the third replaced by a sparse element.
    let shorts = [0_i16, 0, 0, 32767, 0, 0, 0, -32768, 0];
    let mut binary: Vec<u8> = shorts.iter().flat_map(|c| c.to_le_bytes()).collect();
    binary.extend([2, 0]);
    binary.extend([0_i16, 16384, 0].iter().flat_map(|c| c.to_le_bytes()));
    let json = |sparse: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":["KHR_mesh_quantization"],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"buffers":[{{"byteLength":26}}],
            "bufferViews":[{{"buffer":0,"byteLength":18}},{{"buffer":0,"byteOffset":18,"byteLength":2}},
                {{"buffer":0,"byteOffset":20,"byteLength":6}}],
            "accessors":[{{"bufferView":0,"componentType":5122,"normalized":true,"count":3,"type":"VEC3"{sparse}}}]}}"#
        )
    };
    let soup = gltf::read(&glb(&json(""), &binary)).unwrap().soup;
    assert_eq!(soup.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
    let sparse = r#","sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":2}}"#;
    let soup = gltf::read(&glb(&json(sparse), &binary)).unwrap().soup;
    assert_eq!(soup.positions[2], [0.0, 16384.0 / 32767.0, 0.0]);
    for (from, to, expected) in [
        (
            "\"count\":1",
            "\"count\":2",
            "accessor 0: 2 elements of 2 bytes from byte 0 of a view of 2 bytes",
        ),
        ("5123}", "5126}", "accessor 0: the type of its sparse indices is unknown"),
        ("\"count\":1", "\"count\":99999999", "too many sparse elements for a file of this size"),
    ] {
        let json = json(&sparse.replacen(from, to, 1));
        assert_eq!(refusal(gltf::read(&glb(&json, &binary))), expected);
    }
    binary[18] = 3;
    let expected = "accessor 0: its sparse element 3 is one of 3";
    assert_eq!(refusal(gltf::read(&glb(&json(sparse), &binary))), expected);
    let zeros =
        json(sparse).replace(r#""bufferView":0,"componentType":5122"#, r#""componentType":5122"#);
    let many = zeros.replace(r#""count":3"#, r#""count":5000000000"#);
    assert_eq!(
        refusal(gltf::read(&glb(&many, &binary))),
        "accessor 0: 5000000000 elements without bytes"
    );
}
