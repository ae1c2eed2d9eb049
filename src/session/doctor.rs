//! The doctor as a person meets it: findings in plain words, their marks on the surface, and the repairs on offer.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: readers refuse larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::document::{Document, inward_polygons};
use super::message::{DoctorReport, Event, FindingText, NoticeText, RepairChoice};
use super::scene::{PatchScene, Scene};
use super::text::{Problem, plural};
use super::{Session, nothing_open, size};
use crate::geometry::doctor::Examination;
use crate::mesh::doctor::{Finding, FindingKind, Repair, Severity};

/// Longest list of places that is marked: more would hide the surface.
const MARKS: usize = 20_000;

/// The report of a document.
pub fn report(document: &Document, shown: Option<&str>) -> DoctorReport {
    let examination = &document.examination;
    let findings: Vec<FindingText> = sorted(examination).into_iter().map(finding_text).collect();
    let solvable = document.surface.is_some();
    let warnings = findings.iter().filter(|f| f.severity == "warning").count();
    let headline = if !solvable {
        "Needs repair before it can be cut.".to_owned()
    } else if !examination.recommended().is_empty() {
        "Can be cut, but it has fallen into parts: repair it first.".to_owned()
    } else if warnings > 0 {
        format!("Can be cut; {} to look at.", plural(warnings, "thing"))
    } else {
        "Healthy: ready to be cut.".to_owned()
    };
    let repair_all =
        examination.recommended().iter().map(|repair| repair_choice(repair).label).collect();
    DoctorReport { solvable, headline, repair_all, shown: shown.map(str::to_owned), findings }
}

/// The findings that a report lists besides what was passed over in reading.
pub fn notices(examination: &Examination) -> Vec<NoticeText> {
    let notice = |finding: &Finding| NoticeText {
        kind: finding.kind.id().to_owned(),
        count: finding.count,
        text: sentence(finding),
        repairs: finding.repairs.iter().map(Repair::id).collect(),
    };
    sorted(examination).into_iter().map(notice).collect()
}

/// Why methods cannot work on a mesh yet.
pub fn blocked(name: &str, examination: &Examination) -> Problem {
    let first = examination.findings.iter().find(|f| f.severity == Severity::Blocks);
    let what = first.map_or("The mesh is no surface that can be cut.".to_owned(), sentence);
    let place = first.map(place).filter(|place| !place.is_empty());
    Problem::new(
        what,
        place.map_or_else(|| format!("{name}."), |place| format!("{name}, {place}.")),
        "Let the mesh doctor repair it: Repair all in the Mesh panel, or --repair on the command line.",
    )
}

/// Refuses what no repair can make a surface of.
pub fn refuse_hopeless(name: &str, examination: &Examination) -> Result<(), Problem> {
    let place = format!("{name}.");
    let check = "Check the export; the scale or one of the directions may have been lost.";
    if examination.find(FindingKind::NoExtent).is_some() {
        return Err(Problem::new("The mesh has no extent: all its points coincide.", place, check));
    }
    if examination.find(FindingKind::NoFaces).is_some() {
        let what = "The mesh has no faces.";
        return Err(Problem::new(
            what,
            place,
            "Export a surface with faces: points and lines cannot be cut.",
        ));
    }
    let flat = examination.find(FindingKind::DegenerateFaces);
    match flat.filter(|f| f.severity == Severity::Blocks).map(|f| f.count) {
        None => Ok(()),
        Some(1) => Err(Problem::new("The only face has zero area.", place, check)),
        Some(n) => Err(Problem::new(
            format!("All {n} faces have zero area: the points lie on lines."),
            place,
            check,
        )),
    }
}

/// The gravest first; as found where they are alike.
fn sorted(examination: &Examination) -> Vec<&Finding> {
    let mut findings: Vec<&Finding> = examination.findings.iter().collect();
    findings.sort_by_key(|f| f.severity);
    findings
}

/// Whether a finding names places. The first face of a component says nothing about where its defect is.
fn can_show(finding: &Finding) -> bool {
    let places = finding.faces.len() + finding.edges.len() + finding.vertices.len();
    places > 0 && !matches!(finding.kind, FindingKind::Components | FindingKind::HugeRatio)
}

fn finding_text(finding: &Finding) -> FindingText {
    let severity = match finding.severity {
        Severity::Blocks => "blocks",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    FindingText {
        id: finding.kind.id().to_owned(),
        severity,
        count: finding.count,
        text: sentence(finding),
        place: place(finding),
        can_show: can_show(finding),
        repairs: finding.repairs.iter().map(repair_choice).collect(),
    }
}

/// What was found, as a sentence.
fn sentence(finding: &Finding) -> String {
    let n = finding.count;
    let some =
        |one: &str, many: &str| if n == 1 { format!("1 {one}") } else { format!("{n} {many}") };
    let verb = |one: &'static str, many: &'static str| if n == 1 { one } else { many };
    let worst = finding.worst.unwrap_or(0.0);
    match finding.kind {
        FindingKind::NoFaces => "The mesh has no faces.".into(),
        FindingKind::NoExtent => "The mesh has no extent: all its points coincide.".into(),
        FindingKind::RepeatedVertices => {
            format!("{} {} a vertex twice.", some("face", "faces"), verb("uses", "use"))
        }
        FindingKind::DuplicateFaces => format!(
            "{}: the same corners as another face.",
            some("duplicate face", "duplicate faces")
        ),
        FindingKind::DegenerateFaces => format!(
            "{} without area: corners on one line or in one point.",
            some("degenerate face", "degenerate faces")
        ),
        FindingKind::NonManifoldEdges => format!(
            "{}: three or more faces meet there.",
            some("non-manifold edge", "non-manifold edges")
        ),
        FindingKind::NonManifoldVertices => format!(
            "{}: parts touch in that point only (a bow-tie).",
            some("non-manifold vertex", "non-manifold vertices")
        ),
        FindingKind::NotOrientable => format!(
            "Not orientable: {} only one side, like a Möbius strip.",
            some("component has", "components have")
        ),
        FindingKind::Orientation => format!(
            "Faces look in opposite directions: {} between neighbours that disagree.",
            some("edge", "edges")
        ),
        FindingKind::FoldedPolygons => format!(
            "{} that cannot be divided into triangles as {}.",
            some("folded polygon", "folded polygons"),
            verb("it is", "they are")
        ),
        FindingKind::CoincidentVertices => {
            let closable = finding.closable.unwrap_or(0);
            format!(
                "{} at the place of another: merging would close {}.",
                some("vertex", "vertices"),
                plural(closable, "open edge")
            )
        }
        FindingKind::Slivers => format!(
            "{}, very thin; the smallest angle is {}. Cuts are computed on better triangles of the same surface, but flat pieces may fold there: “Remesh evenly” helps.",
            some("sliver", "slivers"),
            degrees(worst)
        ),
        FindingKind::InsideOut => {
            "Inside out: the faces of a closed part look inwards. Cutting turns them around, the file stays as it is.".into()
        }
        FindingKind::HugeRatio => format!(
            "The longest edge is {worst:.0e} times as long as the shortest: results may be rough."
        ),
        FindingKind::FarFromOrigin => format!(
            "The mesh lies {worst:.0e} times its size away from the origin; it is brought there for computing only."
        ),
        FindingKind::Isolated => format!(
            "{} used by no face: ignored here, kept in exports.",
            some("vertex is", "vertices are")
        ),
        FindingKind::Components => format!("{n} components that are not connected."),
        FindingKind::BoundaryLoops => {
            format!("{}: the surface is open there.", some("boundary loop", "boundary loops"))
        }
    }
}

/// An angle in radians for people.
fn degrees(radians: f64) -> String {
    let degrees = radians.to_degrees();
    if degrees < 0.01 { format!("{degrees:.0e}°") } else { format!("{degrees:.2}°") }
}

/// Where: the first place, and how many more.
fn place(finding: &Finding) -> String {
    let more = |n: usize| if n > 1 { format!(" and {} more", n - 1) } else { String::new() };
    let one_place = match finding.kind {
        FindingKind::Components | FindingKind::BoundaryLoops => return String::new(),
        FindingKind::NonManifoldEdges | FindingKind::Orientation | FindingKind::NotOrientable => {
            finding.edges.first().map(|[a, b]| {
                format!("edge from vertex {a} to vertex {b}{}", more(finding.edges.len()))
            })
        }
        _ => None,
    };
    let face = || finding.faces.first().map(|f| format!("face {f}{}", more(finding.faces.len())));
    let vertex =
        || finding.vertices.first().map(|v| format!("vertex {v}{}", more(finding.vertices.len())));
    let text = match finding.kind {
        FindingKind::NonManifoldVertices
        | FindingKind::CoincidentVertices
        | FindingKind::Isolated => vertex(),
        _ => one_place.or_else(face).or_else(vertex),
    };
    text.map_or(String::new(), |text| format!("{text} (counted from 0)"))
}

/// A repair as a button says it.
fn repair_choice(repair: &Repair) -> RepairChoice {
    let (label, help): (String, &str) = match repair {
        Repair::DropRepeated => (
            "Clean faces".into(),
            "Takes repeated corners out of faces and drops what is no face then.",
        ),
        Repair::DropDuplicates => {
            ("Drop duplicates".into(), "Keeps the first of each set of equal faces.")
        }
        Repair::DropDegenerate => (
            "Drop degenerate".into(),
            "Drops or collapses faces without area so that no hole opens.",
        ),
        Repair::Weld { tolerance } if *tolerance > 0.0 => (
            "Weld".into(),
            "Merges open vertices that are closer than a millionth of the model's size.",
        ),
        Repair::Weld { .. } => {
            ("Weld equal".into(), "Merges open vertices at the very same place.")
        }
        Repair::SplitEdges => (
            "Split edges".into(),
            "Leaves each edge to the two faces that continue each other there; the others become parts of their own.",
        ),
        Repair::SplitVertices => {
            ("Split vertices".into(), "Gives each part its own copy of the vertex.")
        }
        Repair::OpenOneSided => (
            "Cut open".into(),
            "Cuts one-sided parts along a line, after which they have two sides.",
        ),
        Repair::Orient => (
            "Orient".into(),
            "Turns faces so that neighbours agree and closed parts look outwards.",
        ),
        Repair::SplitPolygons => {
            ("Divide polygons".into(), "Replaces folded polygons by triangles.")
        }
        Repair::DropIsolated => {
            ("Remove".into(), "Removes the unused vertices; the others are numbered anew.")
        }
        Repair::KeepLargest => {
            ("Keep largest".into(), "Keeps the component with the largest area, drops the others.")
        }
        Repair::KeepComponent { component } => {
            (format!("Keep component {}", component + 1), "Keeps this component, drops the others.")
        }
        Repair::DropSmallComponents => {
            ("Drop small".into(), "Drops components with less than a hundredth of the area.")
        }
        Repair::FillHoles { max_edges: Some(n) } => (
            format!("Fill small holes (up to {n} edges)"),
            "Closes each of these holes with a face.",
        ),
        Repair::FillHoles { max_edges: None } => {
            ("Fill all holes".into(), "Closes every hole with a face where that gives a sound one.")
        }
        Repair::TurnInsideOut => ("Turn all faces".into(), "Turns every face to its other side."),
    };
    RepairChoice { id: repair.id(), label, help: help.into() }
}

/// The label of a repair, in lower case, for Undo.
pub fn repair_name(repair: &Repair) -> String {
    repair_choice(repair).label.to_lowercase()
}

/// What is drawn in red.
struct Marks {
    /// Triangles of the document.
    triangles: Vec<bool>,
    points: Vec<u32>,
    segments: Vec<[u32; 2]>,
}

impl Marks {
    /// Of a finding, none where it names no place that can be seen.
    fn of(document: &Document, finding: &Finding) -> Option<Self> {
        if !can_show(finding) {
            return None;
        }
        let mut polygons = vec![false; document.soup.polygon_count()];
        let inward = finding.kind == FindingKind::InsideOut;
        if inward {
            polygons = inward_polygons(&document.examination);
        } else {
            for &face in &finding.faces {
                polygons[face as usize] = true;
            }
        }
        let triangles: Vec<bool> =
            document.triangle_polygons.iter().map(|&p| polygons[p as usize]).collect();
        let mut segments: Vec<[u32; 2]> = finding.edges.iter().copied().take(MARKS).collect();
        if !inward {
            // Thin faces are seen by their outlines only.
            for &face in finding.faces.iter().take(MARKS / 4) {
                let corners = document.soup.polygon(face as usize);
                segments.extend(
                    (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]),
                );
            }
        }
        Some(Self {
            triangles,
            points: finding.vertices.iter().copied().take(MARKS).collect(),
            segments,
        })
    }

    /// Of everything that blocks.
    fn of_all_that_blocks(document: &Document) -> Self {
        let mut all = Self {
            triangles: vec![false; document.triangles.len()],
            points: Vec::new(),
            segments: Vec::new(),
        };
        let blocking =
            document.examination.findings.iter().filter(|f| f.severity == Severity::Blocks);
        for marks in blocking.filter_map(|finding| Self::of(document, finding)) {
            all.triangles.iter_mut().zip(marks.triangles).for_each(|(a, b)| *a |= b);
            all.points.extend(marks.points);
            all.segments.extend(marks.segments);
        }
        all.points.truncate(MARKS);
        all.segments.truncate(MARKS);
        all
    }
}

/// A picture of the mesh as it stands, in grey, with the places of one finding in red, or of everything that blocks.
pub fn scene(document: &Document, shown: Option<&str>, revision: u32) -> Scene {
    let finding =
        shown.and_then(|id| document.examination.findings.iter().find(|f| f.kind.id() == id));
    let marks = match finding {
        Some(finding) => Marks::of(document, finding),
        None => Some(Marks::of_all_that_blocks(document)),
    };
    let marks = marks.unwrap_or_else(|| Marks {
        triangles: vec![false; document.triangles.len()],
        points: Vec::new(),
        segments: Vec::new(),
    });
    let place = placing(document);
    let positions = &document.soup.positions;
    // One copy of each used vertex for the grey faces and one for the red: a vertex has one colour.
    let mut copies = [vec![u32::MAX; positions.len()], vec![u32::MAX; positions.len()]];
    let mut result = Scene { revision, ..Scene::default() };
    let mut normals: Vec<Vector3<f64>> = Vec::new();
    for (t, &is_marked) in document.triangles.iter().zip(&marks.triangles) {
        let patch = usize::from(is_marked);
        let corners = t.map(|v| place(positions[v as usize]));
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a));
        for (&v, p) in t.iter().zip(corners) {
            let copy = &mut copies[patch][v as usize];
            if *copy == u32::MAX {
                *copy = normals.len() as u32;
                normals.push(Vector3::zeros());
                result.positions.extend(p.iter().map(|&x| x as f32));
                result.vertex_patches.push(patch as u32);
            }
            normals[*copy as usize] += normal;
            result.triangles.push(*copy);
        }
    }
    result.normals = normals
        .iter()
        .flat_map(|n| {
            let unit = n.try_normalize(1e-300).unwrap_or_else(Vector3::z);
            [unit.x as f32, unit.y as f32, unit.z as f32]
        })
        .collect();
    result.charts = vec![f32::NAN; 2 * normals.len()];
    result.triangle_faces = (0..document.triangles.len() as u32).collect();
    let patch = |color| PatchScene { color, anchor: [f32::NAN; 2], ..PatchScene::default() };
    result.patches = vec![patch(PatchScene::NEUTRAL), patch(PatchScene::MARKED)];
    let at = |v: u32| <[f32; 3]>::from(place(positions[v as usize]).map(|x| x as f32));
    // Unused vertices may lie anywhere; those out of sight need no mark.
    let is_near = |v: &u32| at(*v).iter().all(|x| x.abs() < 1e3);
    result.mark_points = marks.points.iter().filter(|v| is_near(v)).flat_map(|&v| at(v)).collect();
    result.mark_segments = marks.segments.iter().flatten().flat_map(|&v| at(v)).collect();
    result
}

/// From the file to the frame of the scene: the same as that of the pieces, to the last bit, so that the camera stays and
/// the viewer knows the shade of a place already.
fn placing(document: &Document) -> impl Fn([f64; 3]) -> Point3<f64> {
    let [low, high] = document.bounds.map(Vector3::from);
    let mut centre = (low + high) / 2.0;
    let (mut scale, mut unit) = (1.0, 1.0);
    match &document.surface {
        Some(surface) => {
            centre = surface.frame.centre.coords;
            scale = surface.frame.scale;
            unit = 1.0 / surface.radius().max(1e-300);
        }
        None => {
            // As far as the farthest used vertex, as there.
            let radius = document
                .triangles
                .iter()
                .flatten()
                .map(|&v| (Vector3::from(document.soup.positions[v as usize]) - centre).norm())
                .fold(0.0, f64::max);
            if radius > 0.0 {
                unit = 1.0 / radius;
            }
        }
    }
    move |p| Point3::from((Vector3::from(p) - centre) * scale * unit)
}

impl Session {
    /// Marks a finding on the surface, or goes back to the pieces.
    pub(super) fn show_finding(
        &mut self,
        id: Option<String>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let known =
            |id: &String| work.document.examination.findings.iter().any(|f| f.kind.id() == id);
        self.shown = id.filter(known);
        self.scene_is_new = true;
        events.extend(self.doctor_event());
        events.push(Event::Scene);
        Ok(())
    }

    /// One repair, or all that are recommended.
    pub(super) fn repair(
        &mut self,
        id: Option<&str>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let (document, label) = match id {
            Some(id) => work.document.repaired_by(id)?,
            None if work.document.examination.recommended().is_empty() => {
                return Err(Problem::new(
                    "There is nothing to repair: the mesh can be cut as it is.",
                    format!("{}.", work.document.name),
                    "Choose one of the repairs that a finding offers, if you wish.",
                ));
            }
            None => (work.document.repaired()?, "repair".to_owned()),
        };
        let mut settings = work.settings.clone();
        size::keep(&work.document, &document, &mut settings);
        self.change_to(document, settings, &label, events);
        Ok(())
    }

    /// Goes back to the pieces, for somebody who goes on cutting.
    pub(super) fn unmark(&mut self, events: &mut Vec<Event>) {
        if self.shown.take().is_some() {
            self.scene_is_new = true;
            events.extend(self.doctor_event());
        }
    }
}
