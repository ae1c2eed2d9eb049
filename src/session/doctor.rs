//! The doctor as a person meets it: findings in plain words, their marks on the surface, and the repairs on offer.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: readers refuse larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::document::Document;
use super::message::{DoctorReport, FindingText, NoticeText, RepairChoice};
use super::scene::{PatchScene, Scene};
use super::text::{Problem, plural};
use crate::geometry::doctor::{Diagnosis, Finding, FindingKind, Repair, Severity};
use crate::mesh::Soup;

/// Longest list of places that is marked: more would hide the surface.
const MARKS: usize = 20_000;

/// The report of a document.
pub fn report(document: &Document, shown: Option<&str>) -> DoctorReport {
    let diagnosis = &document.diagnosis;
    let mut findings: Vec<FindingText> =
        diagnosis.findings.iter().map(|finding| finding_text(document, finding)).collect();
    findings.sort_by_key(|f| match f.severity {
        "blocks" => 0,
        "warning" => 1,
        _ => 2,
    });
    let solvable = document.surface.is_some();
    let warnings = findings.iter().filter(|f| f.severity == "warning").count();
    let headline = if !solvable {
        "Needs repair before it can be cut.".to_owned()
    } else if warnings > 0 {
        format!("Can be cut; {} to look at.", plural(warnings, "thing"))
    } else {
        "Healthy: ready to be cut.".to_owned()
    };
    let repair_all = diagnosis.recommended().iter().map(|r| repair_choice(*r).label).collect();
    DoctorReport { solvable, headline, repair_all, shown: shown.map(str::to_owned), findings }
}

/// The findings that a report lists besides what was passed over in reading.
pub fn notices(diagnosis: &Diagnosis) -> Vec<NoticeText> {
    diagnosis
        .findings
        .iter()
        .map(|finding| NoticeText {
            kind: finding.kind.id().to_owned(),
            count: finding.count,
            text: sentence(finding),
        })
        .collect()
}

/// Why methods cannot work on a mesh yet.
pub fn blocked(name: &str, diagnosis: &Diagnosis) -> Problem {
    let first = diagnosis.findings.iter().find(|f| f.severity == Severity::Blocks);
    Problem::new(
        first.map_or("The mesh is no surface that can be cut.".to_owned(), sentence),
        first.map_or_else(|| format!("{name}."), |f| format!("{name}, {}.", place(f))),
        "Let the mesh doctor repair it: Repair all in the Mesh panel, or --repair on the command line.",
    )
}

fn finding_text(document: &Document, finding: &Finding) -> FindingText {
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
        can_show: can_show(document, finding),
        repairs: finding.repairs().into_iter().map(repair_choice).collect(),
    }
}

/// What was found, as a sentence.
fn sentence(finding: &Finding) -> String {
    let n = finding.count;
    let subject = |noun: &str, one: &str, many: &str| {
        format!("{} {}", plural(n, noun), if n == 1 { one } else { many })
    };
    match finding.kind {
        FindingKind::RepeatedVertices => {
            format!("{} a vertex twice.", subject("face", "uses", "use"))
        }
        FindingKind::DegenerateFaces => {
            let noun = if n == 1 { "1 degenerate face".into() } else { format!("{n} degenerate faces") };
            format!("{noun}: without area, corners on one line or in one point.")
        }
        FindingKind::DuplicateFaces => {
            let noun = if n == 1 { "1 duplicate face".into() } else { format!("{n} duplicate faces") };
            format!("{noun}: the same corners as another face.")
        }
        FindingKind::NonManifoldEdges => {
            let noun = if n == 1 { "1 non-manifold edge".into() } else { format!("{n} non-manifold edges") };
            format!("{noun}: three or more faces meet there.")
        }
        FindingKind::NonManifoldVertices => {
            let noun = if n == 1 { "1 non-manifold vertex".into() } else { format!("{n} non-manifold vertices") };
            format!("{noun}: parts touch in that point only (a bow-tie).")
        }
        FindingKind::Orientation => {
            format!("Faces look in opposite directions: {} between neighbours that disagree.", plural(n, "edge"))
        }
        FindingKind::InsideOut => "The surface is inside out: all faces look inwards. It is turned around for cutting.".into(),
        FindingKind::NotOrientable => {
            format!("Not orientable: {} one side only, like a Möbius strip.", subject("component", "has", "have"))
        }
        FindingKind::Isolated => {
            format!("{} used by no face: ignored here, kept in exports.", subject("vertex", "is", "are"))
        }
        FindingKind::Components => format!("{n} components that are not connected."),
        FindingKind::BoundaryLoops => {
            format!("{}: the surface is open there.", plural(n, "boundary loop"))
        }
        FindingKind::Slivers => format!("{} with very small angles (slivers).", plural(n, "face")),
        FindingKind::FarFromOrigin => "The mesh lies far from the origin for its size; it is moved there for computing.".into(),
        _ => String::new(),
    }
}
