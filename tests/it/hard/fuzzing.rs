//! Damaged files for every reader: an answer in words or something sound, in time and memory that go with the length of the file.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use cutflow::mesh::Soup;
use cutflow::mesh::read::{self, Content, Format, ReadError};
use cutflow::session::{Brought, Command, Event, Session, cut_from_json};

use super::documents;
use super::guarded;
use super::sound::{check_events, check_mesh};
use crate::mutation::{SplitMix64, mutate};

/// The most memory that was held since [`Target::run`] looked last: counted by the allocator of the long run, 0 where nobody counts.
pub static PEAK: AtomicUsize = AtomicUsize::new(0);
/// Memory that is held now.
pub static HELD: AtomicUsize = AtomicUsize::new(0);

/// What reads a damaged file. **Gives** whether something was read.
type Read = Box<dyn FnMut(&[u8]) -> Result<bool, String>>;

/// A reader and files that it can read.
pub struct Target {
    pub name: &'static str,
    files: Vec<Vec<u8>>,
    read: Read,
    /// Bytes of memory for each byte of a file, and for a file of none.
    memory: [usize; 2],
    /// Seconds that a file may take.
    seconds: f64,
    /// Share of the executions of a long run.
    pub share: u64,
    pub executions: u64,
    pub loaded: u64,
}

impl Target {
    fn new(name: &'static str, files: Vec<Vec<u8>>, read: Read) -> Self {
        // Soups, tables of words and texts of notices: what the tests of single formats allow, and room to grow twice.
        let memory = [160, 1 << 16];
        Self { name, files, read, memory, seconds: 0.25, share: 160, executions: 0, loaded: 0 }
    }

    /// Reads a file that was damaged by a number. **Fails** with the number and what was found.
    pub fn run(&mut self, seed: u64) -> Result<(), String> {
        let mut random = SplitMix64::new(seed);
        let file = &self.files[random.below(self.files.len())];
        let other = &self.files[random.below(self.files.len())];
        let bytes = damaged(&mut random, file, other);
        self.executions += 1;
        let held = HELD.load(Ordering::Relaxed);
        PEAK.store(held, Ordering::Relaxed);
        let start = Instant::now();
        let read = &mut self.read;
        let result = guarded(|| read(&bytes));
        let seconds = start.elapsed().as_secs_f64();
        let took = PEAK.load(Ordering::Relaxed).saturating_sub(held);
        let wrong = |what: String| {
            let text: String = String::from_utf8_lossy(&bytes).chars().take(2000).collect();
            Err(format!("{}, seed {seed}, {} bytes: {what}\n{text:?}", self.name, bytes.len()))
        };
        match result {
            Err(what) => return wrong(what),
            Ok(is_loaded) => self.loaded += u64::from(is_loaded),
        }
        if took > self.memory[0] * bytes.len() + self.memory[1] {
            return wrong(format!("{took} bytes of memory"));
        }
        // On a busy machine anything may take long: only processor time counts.
        if seconds > self.seconds {
            let start = super::processor_seconds();
            let _ = guarded(|| read(&bytes));
            let both = start.zip(super::processor_seconds());
            if let Some(seconds) = both.map(|(a, b)| b - a).filter(|&took| took > self.seconds) {
                return wrong(format!("{seconds:.2} s"));
            }
        }
        Ok(())
    }

    /// The undamaged files; each must be read, or the target tests nothing.
    pub fn prove(&mut self) -> Result<(), String> {
        for (i, file) in self.files.iter().enumerate() {
            if !(self.read)(file)? {
                return Err(format!("{}: the undamaged file {i} is refused", self.name));
            }
        }
        Ok(())
    }
}

/// Damage of all kinds: bytes, parts and numbers; words that change places; the head of one file and the tail of another.
fn damaged(random: &mut SplitMix64, file: &[u8], other: &[u8]) -> Vec<u8> {
    let bytes = match random.below(8) {
        0 => swapped(random, file),
        1 => {
            let (head, tail) = (random.below(file.len()), random.below(other.len()));
            [&file[..head], &other[tail..]].concat()
        }
        _ => file.to_vec(),
    };
    // A GLB whose lengths are wrong is refused at its door: mostly only what is within is damaged.
    if bytes.starts_with(b"glTF") && bytes.len() > 28 && random.below(4) != 0 {
        let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
        if 28 + length <= bytes.len() {
            let (json, binary) = (&bytes[20..20 + length], &bytes[28 + length..]);
            return match random.below(3) {
                0 => glb(json, &mutate(random.next(), binary)),
                _ => glb(&mutate(random.next(), json), binary),
            };
        }
    }
    mutate(random.next(), &bytes)
}

/// Two words of a text change places.
fn swapped(random: &mut SplitMix64, file: &[u8]) -> Vec<u8> {
    let mut words: Vec<&[u8]> = file.split_inclusive(|b| b" \n,:/".contains(b)).collect();
    if words.len() > 1 {
        let (a, b) = (random.below(words.len()), random.below(words.len()));
        words.swap(a, b);
    }
    words.concat()
}

/// A GLB of two chunks.
pub fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, binary) = (padded(json, b' '), padded(binary, 0));
    let word = |n: usize| (n as u32).to_le_bytes();
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(word(28 + json.len() + binary.len()));
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        out.extend(word(chunk.len()));
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

/// All that readers guarantee of what they read.
pub fn check_content(result: &Result<Content, ReadError>) -> Result<bool, String> {
    let content = match result {
        Ok(content) => content,
        Err(error) => {
            let text = error.to_string();
            let is_told = !text.is_empty() && !error.fault.advice().is_empty();
            let is_clean = text.len() < 1000 && !text.contains(char::is_control);
            return if is_told && is_clean {
                Ok(false)
            } else {
                Err(format!("refused with {text:?}"))
            };
        }
    };
    let Soup { positions, corners, starts, lines, .. } = &content.soup;
    let soup = &content.soup;
    let polygons = soup.polygon_count();
    let refers = |numbers: &[u32], targets: usize, length: usize| {
        (numbers.is_empty() || numbers.len() == length)
            && numbers.iter().all(|&i| i == u32::MAX || (i as usize) < targets)
    };
    let is_sound = [
        ("no polygons", polygons > 0 && starts[0] == 0),
        ("polygons with two corners", starts.windows(2).all(|w| w[1] >= w[0] + 3)),
        ("corners of no polygon", starts.last().map(|&end| end as usize) == Some(corners.len())),
        ("corners without place", corners.iter().all(|&v| (v as usize) < positions.len())),
        ("places too far", positions.iter().flatten().all(|x| x.abs() <= f64::from(f32::MAX))),
        ("texture nowhere", soup.texture_coordinates.iter().flatten().all(|x| x.is_finite())),
        ("normals nowhere", soup.normals.iter().flatten().all(|x| x.is_finite())),
        (
            "texture of others",
            refers(&soup.texture_corners, soup.texture_coordinates.len(), corners.len()),
        ),
        ("normals of others", refers(&soup.normal_corners, soup.normals.len(), corners.len())),
        ("groups of others", refers(&soup.polygon_groups, soup.groups.len(), polygons)),
        ("materials of others", refers(&soup.polygon_materials, soup.materials.len(), polygons)),
        ("lines of others", lines.is_empty() || lines.len() == polygons),
        ("notices of nothing", content.notices.iter().all(|n| n.count > 0 && !n.text.is_empty())),
    ];
    match is_sound.iter().find(|(_, holds)| !holds) {
        Some((what, _)) => Err(format!("read with {what}")),
        None => Ok(true),
    }
}

fn mesh_target(name: &'static str, format: Format, files: Vec<Vec<u8>>) -> Target {
    let read = move |bytes: &[u8]| {
        read::sniff(bytes);
        check_content(&match format {
            Format::Obj => read::obj::read(bytes),
            Format::Ply => read::ply::read(bytes),
            Format::Stl => read::stl::read(bytes),
            Format::Off => read::off::read(bytes),
            Format::Gltf => read::gltf::read(bytes),
        })
    };
    Target::new(name, files, Box::new(read))
}

const OBJ: &str = "# a thing\nmtllib a.mtl\no thing\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 1e-3\nv 0 1 -2.5E+1\nvt 0 0\nvt 1 .5\nvn 0 0 1\n\
    g one two\nusemtl red\ns 1\nf 1/1/1 2/2/1 3/1/1\nf 1//1 3//1 4//-1 \\\n 2//1\ng\nf -4 -3 -1\nl 1 2\np 1\n";
const OFF: &str = "OFF\n# one\n4 4 6\n0 0 0\n1 0 0\n0 1.5 0\n0 0 1e-2\n3 0 2 1\n3 0 1 3 0.5 0.5 0.5\n3 0 3 2\n3 1 2 3 255 0 0\n";
const STL: &str = "solid a thing\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1e0 0\n  endloop\n endfacet\n\
    facet normal 0 1 0\n outer loop\n vertex 0 0 0\n vertex 0 0 1\n vertex 1 0 0\n endloop\n endfacet\nendsolid a thing\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n\
    property uchar red\nproperty float s\nproperty float t\nelement face 2\nproperty list uchar int vertex_indices\nproperty int flags\nend_header\n\
    0 0 0 255 0 0\n1 0 0 1 1 0\n1 1 .5 1 1 1\n0 1 0 1 0 1\n3 0 1 2 7\n4 0 1 2 3 8\n";

fn binary_ply(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut out = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty short z\nelement face 2\n\
         property list uchar uint vertex_index\nproperty list uchar float texcoord\nend_header\n"
    )
    .into_bytes();
    let mut put = |le: &[u8]| match big {
        true => out.extend(le.iter().rev()),
        false => out.extend(le),
    };
    for [x, y, z] in [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]] {
        put(&(x as f32).to_le_bytes());
        put(&f64::from(y).to_le_bytes());
        put(&(z as i16).to_le_bytes());
    }
    for face in [&[0u32, 1, 2][..], &[0, 1, 2, 3]] {
        put(&[face.len() as u8]);
        face.iter().for_each(|v| put(&v.to_le_bytes()));
        put(&[2 * face.len() as u8]);
        face.iter().for_each(|v| [*v as f32, 0.5].iter().for_each(|x| put(&x.to_le_bytes())));
    }
    out
}

fn strips() -> Vec<u8> {
    b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n\
      property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 1\n6 0 1 2 -1 1 2\n"
        .to_vec()
}

fn binary_stl() -> Vec<u8> {
    let shape = documents::tetrahedron();
    let mut out = vec![b'x'; 80];
    out.extend((shape.faces.len() as u32).to_le_bytes());
    for face in &shape.faces {
        out.extend([0; 12]);
        for &v in face {
            shape.points[v as usize].iter().for_each(|&x| out.extend((x as f32).to_le_bytes()));
        }
        out.extend([0; 2]);
    }
    out
}

fn gltf_files() -> Vec<Vec<u8>> {
    let shape = documents::tetrahedron();
    let mut binary = Vec::new();
    for point in &shape.points {
        point.iter().for_each(|&x| binary.extend((x as f32).to_le_bytes()));
    }
    shape.faces.iter().flatten().for_each(|&v| binary.extend((v as u16).to_le_bytes()));
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":[1,-2,1],"children":[1],"name":"n"},
        {"mesh":0,"rotation":[0,0.6,0,0.8]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4,"material":0},
        {"attributes":{"POSITION":0},"mode":5},{"attributes":{"POSITION":2}}]}],"materials":[{"name":"red"}],
        "buffers":[{"byteLength":72}],"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]},
        {"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"},
        {"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,"indices":{"bufferView":1,"componentType":5121},
        "values":{"bufferView":0}}}]}"#;
    let base64 = |bytes: &[u8]| {
        const DIGITS: &[u8; 64] =
            b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let digit = |word: u32, i: u32| char::from(DIGITS[(word >> (18 - 6 * i) & 63) as usize]);
        // 72 bytes are whole groups of three.
        let word = |b: &[u8]| u32::from(b[0]) << 16 | u32::from(b[1]) << 8 | u32::from(b[2]);
        bytes.chunks(3).flat_map(|b| (0..4).map(move |i| digit(word(b), i))).collect::<String>()
    };
    let uri = format!(
        r#"[{{"byteLength":72,"uri":"data:application/octet-stream;base64,{}"}}]"#,
        base64(&binary)
    );
    let text = json.replace(r#"[{"byteLength":72}]"#, &uri);
    vec![glb(json.as_bytes(), &binary), text.into_bytes()]
}

/// Opens a ball, cuts it, and gives the session.
fn cut_ball() -> Session {
    let mut session = Session::new();
    session.open("ball.obj", &documents::ball(2).obj());
    session.handle(Command::Step);
    session
}

/// A `cut.json` on the surface that it was written for.
fn cut_target() -> Target {
    let mut session = cut_ball();
    let file = session.export("Cut (JSON)").unwrap().bytes;
    let read = move |bytes: &[u8]| {
        let Some(surface) = session.document().and_then(|d| d.surface.as_ref()) else {
            return Err("the ball is gone".into());
        };
        match cut_from_json(surface, "cut.json", bytes) {
            Ok(cut) => {
                let opened = cut.open().map_err(|error| format!("a cut that is none: {error}"))?;
                check_mesh(&opened.mesh)?;
                Ok(true)
            }
            Err(problem) => {
                told(&[problem.what, problem.place, problem.what_to_do]).map(|()| false)
            }
        }
    };
    Target::new("cut.json", vec![file], Box::new(read))
}

fn told(parts: &[String; 3]) -> Result<(), String> {
    match parts.iter().all(|part| !part.trim().is_empty()) {
        true => Ok(()),
        false => Err(format!("a refusal without words: {parts:?}")),
    }
}

fn is_error(events: &[Event]) -> bool {
    events.iter().any(|event| matches!(event, Event::Error { .. }))
}

/// A `cones.json` on the surface that it was written for.
fn cones_target() -> Target {
    let mut session = Session::new();
    session.open("plate.obj", &documents::plate(2).obj());
    session.handle(Command::SetMethod { id: "cones".into() });
    while session.is_running() {
        session.advance(&mut || true);
    }
    let file = session.export("Cones (JSON)").unwrap().bytes;
    let read = move |bytes: &[u8]| {
        let events = session.bring(Brought::Cones { name: "cones.json", bytes });
        check_events(&events)?;
        Ok(!is_error(&events))
    };
    let mut target = Target::new("cones.json", vec![file], Box::new(read));
    // What is read is solved with, and Undo keeps it.
    target.memory = [1 << 12, 1 << 24];
    (target.seconds, target.share) = (2.0, 5);
    target
}

/// A project, opened and done again.
fn project_target() -> Target {
    let mut session = Session::new();
    session.open("two.obj", &documents::two_triangles().obj());
    session.handle(Command::SetParameter {
        id: "size".into(),
        value: cutflow::session::Value::Number(120.0),
    });
    let flat = session.export("Project (JSON)").unwrap().bytes;
    let mut session = Session::new();
    session.open("ball.obj", &documents::tetrahedron().obj());
    session.handle(Command::Run);
    let mut left = 3;
    while session.is_running() && left > 0 {
        session.advance(&mut || false);
        left -= 1;
    }
    session.handle(Command::Pause);
    session.handle(Command::SetUnit { id: "mm".into() });
    let cut = session.export("Project (JSON)").unwrap().bytes;
    let read = |bytes: &[u8]| {
        let mut session = Session::new();
        let events = session.open("p.json", bytes);
        check_events(&events)?;
        let is_refused = is_error(&events);
        // A log may hold any number of steps; what is wrong with one shows in the first few.
        for _ in 0..6 {
            if !session.is_running() {
                break;
            }
            check_events(&session.advance(&mut || false))?;
        }
        Ok(!is_refused)
    };
    let mut target = Target::new("project.json", vec![flat, cut], Box::new(read));
    target.memory = [1 << 12, 1 << 24];
    (target.seconds, target.share) = (3.0, 5);
    target
}

/// A mesh file of any kind, all the way into a document.
fn document_target() -> Target {
    let files = vec![
        documents::two_triangles().obj(),
        documents::tetrahedron().obj(),
        documents::fan().obj(),
        OFF.into(),
        binary_stl(),
        binary_ply(false),
    ];
    let read = |bytes: &[u8]| match cutflow::session::Document::from_bytes("thing", bytes) {
        Ok(document) => {
            if let Some(surface) = &document.surface {
                check_mesh(&surface.mesh)?;
            }
            check_events(&[Event::Mesh(document.summary)])?;
            Ok(true)
        }
        Err(problem) => told(&[problem.what, problem.place, problem.what_to_do]).map(|()| false),
    };
    let mut target = Target::new("document", files, Box::new(read));
    target.memory = [1 << 12, 1 << 22];
    (target.seconds, target.share) = (1.0, 40);
    target
}

/// All targets, the cheap ones first.
pub fn targets() -> Vec<Target> {
    let ply = vec![PLY.into(), binary_ply(false), binary_ply(true), strips()];
    vec![
        mesh_target("OBJ", Format::Obj, vec![OBJ.into(), documents::tetrahedron().obj()]),
        mesh_target("PLY", Format::Ply, ply),
        mesh_target("STL", Format::Stl, vec![STL.into(), binary_stl()]),
        mesh_target("OFF", Format::Off, vec![OFF.into()]),
        mesh_target("glTF", Format::Gltf, gltf_files()),
        cut_target(),
        document_target(),
        cones_target(),
        project_target(),
    ]
}

#[test]
fn damaged_files_of_every_kind_are_read_or_refused_in_words() {
    for mut target in targets() {
        target.prove().unwrap();
        // Documents, cones and projects are solved with: a hundred times as long.
        let most = if target.seconds < 0.5 { 3000 } else { 150 };
        for seed in 0..most {
            target.run(seed).unwrap_or_else(|what| panic!("{what}"));
        }
        println!("{}: {} of {} are read", target.name, target.loaded, target.executions);
        assert!(target.loaded > 0 && target.loaded < target.executions, "{}", target.name);
    }
}
