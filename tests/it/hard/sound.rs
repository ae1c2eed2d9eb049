//! What must be true of whatever a session says, shows and writes.

use cutflow::mesh::read;
use cutflow::mesh::{Mesh, OpenedMesh};
use cutflow::session::{Event, File, Scene, Session};

/// Whether a text has a number that is none, outside quotation marks.
pub fn has_bad_number(text: &str) -> bool {
    let bytes = text.as_bytes();
    let is_word = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b'"' => {
                at += 1;
                while at < bytes.len() && bytes[at] != b'"' {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                at += 1;
            }
            b if is_word(&b) => {
                let length = bytes[at..].iter().position(|b| !is_word(b));
                let end = length.map_or(bytes.len(), |length| at + length);
                if matches!(&text[at..end], "NaN" | "nan" | "inf" | "Infinity" | "infinity") {
                    return true;
                }
                at = end;
            }
            _ => at += 1,
        }
    }
    false
}

/// Numbers are numbers, and errors have their three parts.
pub fn check_events(events: &[Event]) -> Result<(), String> {
    for event in events {
        // Panels of parameters are long, and their numbers are those of the settings.
        if let Event::Parameters { values, .. } = event {
            let text = format!("{values:?}");
            if has_bad_number(&text) {
                return Err(format!("a parameter is no number: {text}"));
            }
            continue;
        }
        if let Event::Error { what, place, what_to_do } = event
            && [what, place, what_to_do].iter().any(|part| part.trim().is_empty())
        {
            return Err(format!("an error without words: {event:?}"));
        }
        let text = format!("{event:?}");
        if has_bad_number(&text) {
            let at = text.find("NaN").or_else(|| text.find("inf")).unwrap_or(0);
            let part = text.get(at.saturating_sub(200)..(at + 100).min(text.len()));
            return Err(format!("an event has a number that is none: {}", part.unwrap_or(&text)));
        }
    }
    Ok(())
}

fn need(holds: bool, what: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what.to_owned()) }
}

/// What `session::scene` guarantees.
pub fn check_scene(scene: &Scene) -> Result<(), String> {
    let n = scene.vertex_count();
    let finite = |values: &[f32]| values.iter().all(|x| x.is_finite());
    need(finite(&scene.positions), "a position of the scene is no number")?;
    need(finite(&scene.normals), "a normal of the scene is no number")?;
    need(finite(&scene.sheet), "the sheet of the scene has no size")?;
    need(finite(&scene.mark_points) && finite(&scene.mark_segments), "a mark is nowhere")?;
    need(finite(&scene.cone_points) && finite(&scene.cone_angles), "a cone is nowhere")?;
    need(scene.normals.len() == 3 * n && scene.charts.len() == 2 * n, "arrays of other lengths")?;
    need(scene.vertex_patches.len() == n, "patches of other vertices")?;
    need(scene.values.is_empty() || scene.values.len() == n, "values of other vertices")?;
    need(scene.triangles.iter().all(|&v| (v as usize) < n), "a triangle of no vertices")?;
    need(scene.triangles.len() == 3 * scene.triangle_faces.len(), "triangles without faces")?;
    need(scene.rims.iter().all(|&v| (v as usize) < n), "a rim of no vertices")?;
    need(scene.rims.len() == 2 * scene.rim_partners.len(), "rims without partners")?;
    let rims = scene.rim_partners.len() as u32;
    need(scene.rim_partners.iter().all(|&p| p == u32::MAX || p < rims), "a partner of no rim")?;
    for (v, &patch) in scene.vertex_patches.iter().enumerate() {
        let Some(patch) = scene.patches.get(patch as usize) else {
            return Err(format!("vertex {v} of the scene is of no patch"));
        };
        need(!patch.has_chart || finite(&scene.charts[2 * v..2 * v + 2]), "a chart is nowhere")?;
    }
    for patch in &scene.patches {
        need(patch.area_fraction.is_finite(), "a patch has no area")?;
        need(!patch.has_chart || finite(&patch.anchor), "a patch has no place for its number")?;
    }
    if let Some(field) = &scene.field {
        let numbers = [&field.range[..], &field.extremes, &[field.mean], &field.histogram];
        need(numbers.iter().all(|x| finite(x)), &format!("{field:?} has no range"))?;
    }
    if let Some(layers) = &scene.layers {
        let all = [&layers.positions, &layers.normals, &layers.uvs, &layers.weights];
        need(all.iter().all(|x| finite(x)) && finite(&layers.sheet), "a layer is nowhere")?;
        let n = layers.positions.len() / 3;
        need(layers.triangles.iter().all(|&v| (v as usize) < n), "a layer's triangle")?;
    }
    Ok(())
}

/// Connectivity as `mesh::halfedge` promises it.
pub fn check_mesh(mesh: &Mesh) -> Result<(), String> {
    for f in mesh.faces() {
        let [a, b, c] = mesh.face_halfedges(f);
        need(mesh.next(a) == b && mesh.next(b) == c && mesh.next(c) == a, "next does not close")?;
        for h in [a, b, c] {
            need(mesh.face(h) == Some(f), "a halfedge of another face")?;
            need(mesh.prev(mesh.next(h)) == h, "prev is not the inverse of next")?;
            need(mesh.tail(h) == mesh.tip(h.twin()), "twins do not run against each other")?;
            need(mesh.tail(h) != mesh.tip(h), "an edge with one end")?;
        }
    }
    for v in mesh.vertices() {
        for h in mesh.outgoing(v) {
            need(mesh.tail(h) == v, "a halfedge that begins elsewhere")?;
        }
    }
    for &start in mesh.boundary_loops() {
        for h in mesh.boundary_loop(start) {
            need(mesh.face(h).is_none(), "a boundary with a face")?;
        }
    }
    Ok(())
}

fn check_opened(opened: &OpenedMesh) -> Result<(), String> {
    check_mesh(&opened.mesh)?;
    let patches = opened.patch_count as u32;
    need(opened.face_patches.len() == opened.mesh.face_count(), "patches of other faces")?;
    need(opened.face_patches.iter().all(|&p| p < patches), "a face of no patch")?;
    for f in opened.mesh.faces() {
        for h in opened.mesh.face_halfedges(f) {
            if let Some(partner) = opened.partner(h) {
                need(opened.partner(partner) == Some(h), "a seam whose partner has another")?;
            }
        }
    }
    Ok(())
}

/// The surface, and the layout where there is one, are sound.
pub fn check_session(session: &mut Session) -> Result<(), String> {
    if let Some(surface) = session.document().and_then(|d| d.surface.as_ref()) {
        check_mesh(&surface.mesh)?;
        let is_finite = surface.geometry.positions.iter().all(|p| p.iter().all(|x| x.is_finite()));
        need(is_finite, "a point of the surface is nowhere")?;
    }
    match session.layout() {
        Ok(layout) => {
            check_opened(&layout.opened)?;
            let points = layout.points.iter().all(|p| p.iter().all(|x| x.is_finite()));
            need(points, "a point of the cut is nowhere")
        }
        Err(problem) => {
            let parts = [problem.what, problem.place, problem.what_to_do];
            need(parts.iter().all(|part| !part.is_empty()), "a refusal without words")
        }
    }
}

/// Every kind of file that a session writes.
pub const KINDS: [&str; 15] = [
    "Mesh (OBJ)",
    "UV mesh (OBJ)",
    "UV mesh (GLB)",
    "Flat mesh (OBJ)",
    "Cut surface (PLY)",
    "Cut curves (OBJ)",
    "Cut (JSON)",
    "Cones (JSON)",
    "Folded surface (OBJ)",
    "Pattern (SVG)",
    "Pattern (DXF)",
    "Pattern (PDF)",
    "Report (JSON)",
    "Project (JSON)",
    "All files (ZIP)",
];

/// A written file can be read, and its numbers are numbers.
pub fn check_file(kind: &str, file: &File) -> Result<(), String> {
    let wrong = |what: &str| Err(format!("{kind}, {}: {what}", file.name));
    let name = &file.name;
    if name.is_empty() || name.contains(['/', '\\', ':']) || name.contains(char::is_control) {
        return wrong("a name that no file should have");
    }
    match kind {
        // Curves and folded surfaces without faces are no meshes; the others are.
        "Mesh (OBJ)" | "UV mesh (OBJ)" | "Flat mesh (OBJ)" | "UV mesh (GLB)"
        | "Cut surface (PLY)" => {
            if let Err(error) = read::read(name, &file.bytes) {
                return wrong(&format!("our own reader says {error}"));
            }
        }
        "Pattern (PDF)" => {
            if !file.bytes.starts_with(b"%PDF-") || !file.bytes.trim_ascii_end().ends_with(b"%%EOF")
            {
                return wrong("no PDF");
            }
            return streams(&file.bytes).iter().try_for_each(|text| {
                // Text is within parentheses there, and names after slashes.
                let numbers = text.split(|&b| b == b'\n').filter(|line| !line.contains(&b'('));
                let bad = numbers.map(String::from_utf8_lossy).find(|line| has_bad_number(line));
                bad.map_or(Ok(()), |line| wrong(&line))
            });
        }
        "All files (ZIP)" => {
            return if file.bytes.starts_with(b"PK\x03\x04") { Ok(()) } else { wrong("no ZIP") };
        }
        _ => {}
    }
    if kind.contains("GLB") || kind.contains("PLY") {
        return Ok(());
    }
    let Ok(text) = std::str::from_utf8(&file.bytes) else { return wrong("no text") };
    if kind.contains("JSON") && serde_json::from_str::<serde_json::Value>(text).is_err() {
        return wrong("no JSON");
    }
    match text.lines().find(|line| !line.starts_with(['#', 'o', 'g']) && has_bad_number(line)) {
        Some(line) => wrong(&format!("a number that is none: {}", &line[..line.len().min(200)])),
        None => Ok(()),
    }
}

/// The inflated streams of a PDF.
fn streams(pdf: &[u8]) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    let mut rest = pdf;
    let find = |text: &[u8], word: &[u8]| text.windows(word.len()).position(|w| w == word);
    while let Some(at) = find(rest, b"stream\n") {
        rest = &rest[at + 7..];
        let Some(end) = find(rest, b"endstream") else { break };
        if let Ok(text) =
            miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(&rest[..end], 1 << 26)
            // Fonts and pictures are no text.
            && text.is_ascii()
        {
            found.push(text);
        }
        rest = &rest[end + 9..];
    }
    found
}

#[test]
fn numbers_that_are_none_are_found_and_words_are_not() {
    for text in ["Row { now: NaN }", "[inf, 1]", "v 0 -inf 1", "Some(nan)"] {
        assert!(has_bad_number(text), "{text}");
    }
    for text in ["info: 3", "\"NaN is out of range\"", "\"a \\\" NaN\"", "infinite", "v 1 2 3"] {
        assert!(!has_bad_number(text), "{text}");
    }
}
