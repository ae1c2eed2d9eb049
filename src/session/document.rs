//! An opened mesh: the file, what the doctor found in it, and the surface that methods work on once nothing stands in the way.

use std::rc::Rc;

use nalgebra::Vector3;

use super::message::{MeshSummary, NoticeText};
use super::samples;
use super::surface::Surface;
use super::text::{Problem, capital, plural, shown_name};
use crate::geometry::doctor::{self, Examination};
use crate::mesh::Soup;
use crate::mesh::doctor::{FindingKind, Repair};
use crate::mesh::read::{self, ReadNotice};
use crate::methods::flow::SolveError;

/// Largest polygon that is divided: a second's work for all that look at it.
const MOST_CORNERS: usize = 5000;

/// Bytes that a triangle takes while its surface is cut: 1500 with 100 000 triangles, a little more with each doubling as
/// factors fill up. Were it smaller, a browser would stop in the middle of the first cut instead of saying why.
const BYTES_PER_TRIANGLE: u64 = 1_800;

/// What 32 bits can address, less room for Undo and exports.
const ROOM_OF_32_BITS: u64 = 7 << 29;

/// A mesh as it was opened, repaired or prepared.
#[derive(Clone, Debug)]
pub struct Document {
    /// File or sample.
    pub name: String,
    /// The sample, if it is one.
    pub sample: Option<String>,
    /// `OBJ`, `PLY`, `STL`, `OFF`, `glTF` or `sample`.
    pub format: &'static str,
    /// The polygons.
    pub soup: Rc<Soup>,
    /// The polygons divided, with the soup's vertices, and the polygon of each.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its polygon.
    pub triangle_polygons: Vec<u32>,
    /// What the doctor found.
    pub examination: Examination,
    /// What methods work on; none while something that blocks is not repaired.
    pub surface: Option<Surface>,
    /// Corners of the bounding box of the used vertices, in units of the file.
    pub bounds: [[f64; 3]; 2],
    /// Millimetres of one unit, where the file says so in the words of our own exports.
    pub mm_per_unit: Option<f64>,
    /// What was passed over in reading.
    pub reading: Vec<NoticeText>,
    /// What was found.
    pub summary: MeshSummary,
}

impl Document {
    /// Opens a generated surface.
    pub fn from_sample(name: &str) -> Result<Self, Problem> {
        let Some(soup) = samples::generate(name) else {
            let known = samples::SAMPLES.iter().map(|s| s.name).collect::<Vec<_>>().join(", ");
            return Err(Problem::new(
                format!("There is no sample called “{name}”."),
                "In the choice of a sample.",
                format!("Choose one of {known}."),
            ));
        };
        let label = samples::SAMPLES.iter().find(|s| s.name == name).map_or(name, |s| s.label);
        let mut document = Self::from_soup(label, "sample", soup, Vec::new())?;
        document.sample = Some(name.to_owned());
        Ok(document)
    }

    /// Reads a file.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, Problem> {
        let name = &shown_name(name);
        let content = read::read(name, bytes).map_err(|error| Problem::read(name, &error))?;
        let reading = content.notices.iter().map(notice).collect();
        let mut document = Self::from_soup(name, content.format.name(), content.soup, reading)?;
        document.mm_per_unit = stated_size(bytes);
        Ok(document)
    }

    /// The text of a solve on the surface that could not be done.
    pub(super) fn unsolved(&self, error: &SolveError) -> Problem {
        let vertex = |row| self.surface.as_ref()?.soup_vertices.get(row).copied();
        Problem::solve_at(&self.name, error, vertex)
    }

    /// Says which format it came in, by its name; a format that there is none of changes nothing.
    pub(super) fn restore_format(&mut self, name: &str) {
        if let Some(format) = ["OBJ", "PLY", "STL", "OFF", "glTF"].iter().find(|f| **f == name) {
            self.format = format;
            self.summary.format = (*format).to_owned();
        }
    }

    /// The same document after its polygons were repaired or divided anew.
    pub fn with_soup(&self, soup: Soup) -> Result<Self, Problem> {
        // What was passed over in reading stays true of the file; the lines of its faces are of no use any more.
        let mut document = Self::from_soup(&self.name, self.format, soup, self.reading.clone())?;
        document.sample.clone_from(&self.sample);
        document.mm_per_unit = self.mm_per_unit;
        Ok(document)
    }

    fn from_soup(
        name: &str,
        format: &'static str,
        soup: Soup,
        reading: Vec<NoticeText>,
    ) -> Result<Self, Problem> {
        check_polygons(name, &soup)?;
        check_room(name, soup.corners.len().saturating_sub(2 * soup.polygon_count()))?;
        let bounds = used_bounds(&soup);
        let examination = doctor::examine(&soup);
        let (triangles, triangle_polygons) = doctor::triangles(&soup);
        let soup = Rc::new(soup);
        let mut surface = None;
        super::doctor::refuse_hopeless(name, &examination)?;
        if examination.is_solvable {
            // Closed parts that are inside out are solved the right way round; the file stays as it is.
            let inward = inward_polygons(&examination);
            let mut outward = triangles.clone();
            for (t, &polygon) in outward.iter_mut().zip(&triangle_polygons) {
                if inward.get(polygon as usize) == Some(&true) {
                    t.swap(1, 2);
                }
            }
            surface = Some(Surface::new(name, soup.clone(), outward, triangle_polygons.clone())?);
        }
        let mut notices = reading.clone();
        let polygons = (0..soup.polygon_count()).filter(|&i| soup.polygon(i).len() > 3).count();
        if polygons > 0 {
            let text = format!("{} were divided into triangles.", plural(polygons, "polygon"));
            notices.push(NoticeText::new("polygons", polygons, text));
        }
        notices.extend(super::doctor::notices(&examination));
        let summary = MeshSummary {
            name: name.to_owned(),
            format: format.to_owned(),
            vertices: soup.positions.len(),
            faces: soup.polygon_count(),
            triangles: triangles.len(),
            components: examination.components.len(),
            boundary_loops: examination.boundary_loops.len(),
            genus: examination.genus,
            euler: examination.euler,
            area: examination.area,
            isolated_vertices: soup.positions.len() - examination.vertices,
            solvable: surface.is_some(),
            notices,
        };
        Ok(Self {
            name: name.to_owned(),
            sample: None,
            format,
            soup,
            triangles,
            triangle_polygons,
            examination,
            surface,
            bounds,
            mm_per_unit: None,
            reading,
            summary,
        })
    }

    /// The same document after all repairs that stand in the way of methods.
    pub fn repaired(&self) -> Result<Self, Problem> {
        let (soup, done) = doctor::repair_all(&self.soup);
        // A healthy mesh is not made anew.
        if done.is_empty() {
            return Ok(self.clone());
        }
        let has_welded = done.iter().any(|(repair, _)| matches!(repair, Repair::Weld { .. }));
        self.with_soup(if has_welded { without_orphans(&self.soup, soup) } else { soup })
    }

    /// The same document after one repair, and what Undo calls it.
    pub fn repaired_by(&self, id: &str) -> Result<(Self, String), Problem> {
        let Some(repair) = Repair::from_id(id) else {
            return Err(Problem::new(
                format!("There is no repair called “{id}”."),
                "In the choice of a repair.",
                format!("Choose one of {}.", self.offered_repairs()),
            ));
        };
        let name = super::doctor::repair_name(&repair);
        let (soup, changes) = doctor::repair(&self.soup, repair);
        if changes == 0 {
            return Err(Problem::new(
                format!("There is nothing to repair: “{name}” would change nothing."),
                format!("{}.", self.name),
                "Choose another repair.",
            ));
        }
        let drops_parts = matches!(
            repair,
            Repair::Weld { .. }
                | Repair::KeepLargest
                | Repair::KeepComponent { .. }
                | Repair::DropSmallComponents
        );
        let soup = if drops_parts { without_orphans(&self.soup, soup) } else { soup };
        Ok((self.with_soup(soup)?, name))
    }

    /// Identifiers of the repairs that the findings offer.
    fn offered_repairs(&self) -> String {
        let offered = self.examination.findings.iter().flat_map(|f| &f.repairs);
        let list: Vec<String> = offered.map(Repair::id).collect();
        if list.is_empty() { "none: nothing is wrong".into() } else { list.join(", ") }
    }

    /// What methods work on, or why they cannot.
    pub fn surface(&self) -> Result<&Surface, Problem> {
        self.surface.as_ref().ok_or_else(|| super::doctor::blocked(&self.name, &self.examination))
    }

    /// Sides of the bounding box, in units of the file.
    pub fn size(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| self.bounds[1][i] - self.bounds[0][i])
    }

    /// Longest side of the bounding box, in units of the file.
    pub fn largest_side(&self) -> f64 {
        Vector3::from(self.size()).max()
    }
}

/// For each polygon whether it belongs to a closed component that is inside out; empty where none does.
pub(super) fn inward_polygons(examination: &Examination) -> Vec<bool> {
    let Some(finding) = examination.find(FindingKind::InsideOut) else { return Vec::new() };
    let components = &examination.face_components;
    let mut is_inward = vec![false; examination.components.len()];
    for &face in &finding.faces {
        is_inward[components[face as usize] as usize] = true;
    }
    components.iter().map(|&c| is_inward.get(c as usize) == Some(&true)).collect()
}

/// The size that our own exports note among the first lines of an OBJ file.
fn stated_size(bytes: &[u8]) -> Option<f64> {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(1000)]);
    let mut lines = head.lines().filter_map(|line| line.strip_prefix("# real size: 1 unit = "));
    let mm: f64 = lines.next()?.strip_suffix(" mm")?.parse().ok()?;
    (mm > 0.0 && mm.is_finite()).then_some(mm)
}

/// Takes out the vertices that a repair has made useless; those that nothing used before stay.
fn without_orphans(before: &Soup, after: Soup) -> Soup {
    let uses = |soup: &Soup| {
        let mut is_used = vec![false; after.positions.len().max(soup.positions.len())];
        soup.corners.iter().for_each(|&v| is_used[v as usize] = true);
        is_used
    };
    let (old, new) = (uses(before), uses(&after));
    let stays = |v: usize| new[v] || (v < before.positions.len() && !old[v]);
    let mut numbers = Vec::with_capacity(after.positions.len());
    let mut count = 0;
    for v in 0..after.positions.len() {
        numbers.push(count);
        count += u32::from(stays(v));
    }
    let kept = after.positions.iter().enumerate().filter(|&(v, _)| stays(v));
    let positions = kept.map(|(_, &p)| p).collect();
    let corners = after.corners.iter().map(|&v| numbers[v as usize]).collect();
    Soup { positions, corners, ..after }
}

/// Refuses what there is no room for before any of it is taken. Natively the machine decides.
fn check_room(name: &str, triangles: usize) -> Result<(), Problem> {
    if usize::BITS > 32 { Ok(()) } else { check_room_of(name, triangles, ROOM_OF_32_BITS) }
}

fn check_room_of(name: &str, triangles: usize, room: u64) -> Result<(), Problem> {
    let needed = (triangles as u64).saturating_mul(BYTES_PER_TRIANGLE);
    if needed <= room {
        return Ok(());
    }
    let most = room / BYTES_PER_TRIANGLE / 10_000 * 10_000;
    let gibibytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    Err(Problem::new(
        format!(
            "The mesh has {triangles} triangles: cutting it takes about {:.1} GiB of memory, and a browser gives {:.1}.",
            gibibytes(needed),
            gibibytes(room)
        ),
        format!("{name}."),
        format!(
            "Reduce it to {most} triangles or fewer in a modelling program, or use the cutflow command."
        ),
    ))
}

/// Refuses polygons that would take forever to divide: the time grows with the square of their corners.
fn check_polygons(name: &str, soup: &Soup) -> Result<(), Problem> {
    let corners = |i: usize| soup.polygon(i).len();
    match (0..soup.polygon_count()).find(|&i| corners(i) > MOST_CORNERS) {
        None => Ok(()),
        Some(i) => Err(Problem::new(
            format!("A face has {} corners, more than {MOST_CORNERS}.", corners(i)),
            format!("{name}, face {i} (counted from 0)."),
            "Divide large faces into smaller ones in a modelling program.",
        )),
    }
}

/// Something that was passed over in reading.
fn notice(notice: &ReadNotice) -> NoticeText {
    NoticeText::new(notice.kind, notice.count, capital(&notice.to_string()) + ".")
}

/// Corners of the box around the vertices that faces use.
fn used_bounds(soup: &Soup) -> [[f64; 3]; 2] {
    let mut used = vec![false; soup.positions.len()];
    for &v in &soup.corners {
        used[v as usize] = true;
    }
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for (p, _) in soup.positions.iter().zip(&used).filter(|&(_, &used)| used) {
        for i in 0..3 {
            bounds[0][i] = bounds[0][i].min(p[i]);
            bounds[1][i] = bounds[1][i].max(p[i]);
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_that_no_memory_holds_is_refused_in_three_parts() {
        assert_eq!(check_room_of("small.obj", 1_000_000, ROOM_OF_32_BITS), Ok(()));
        let problem = check_room_of("large.obj", 3_000_000, ROOM_OF_32_BITS).unwrap_err();
        assert!(problem.what.contains("3000000 triangles") && problem.what.contains("GiB"));
        assert_eq!(problem.place, "large.obj.");
        assert!(
            problem.what_to_do.contains("2080000 triangles or fewer"),
            "{}",
            problem.what_to_do
        );
        assert!(check_room_of("huge.obj", usize::MAX, ROOM_OF_32_BITS).is_err());
    }
}
