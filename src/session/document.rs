//! An opened mesh: the file, what the doctor found in it, and the surface that methods work on once nothing stands in the way.

use std::rc::Rc;

use nalgebra::Vector3;

use super::message::{MeshSummary, NoticeText};
use super::samples;
use super::surface::Surface;
use super::text::{Problem, plural};
use crate::geometry::doctor::{Diagnosis, diagnose};
use crate::geometry::polygon;
use crate::mesh::Soup;
use crate::mesh::read::{self, ReadNotice};

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
    pub diagnosis: Diagnosis,
    /// What methods work on; none while something that blocks is not repaired.
    pub surface: Option<Surface>,
    /// Corners of the bounding box of the used vertices, in units of the file.
    pub bounds: [[f64; 3]; 2],
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
        let content = read::read(name, bytes).map_err(|error| Problem::read(name, &error))?;
        let reading = content.notices.iter().map(notice).collect();
        Self::from_soup(name, content.format.name(), content.soup, reading)
    }

    /// The same document after its polygons were repaired or divided anew.
    pub fn with_soup(&self, soup: Soup) -> Result<Self, Problem> {
        // What was passed over in reading stays true of the file; the lines of its faces are of no use any more.
        let mut document = Self::from_soup(&self.name, self.format, soup, self.reading.clone())?;
        document.sample.clone_from(&self.sample);
        Ok(document)
    }

    fn from_soup(
        name: &str,
        format: &'static str,
        soup: Soup,
        reading: Vec<NoticeText>,
    ) -> Result<Self, Problem> {
        let bounds = used_bounds(&soup);
        let size = [0, 1, 2].map(|i| bounds[1][i] - bounds[0][i]);
        let diagnosis = diagnose(&soup);
        let (mut triangles, triangle_polygons, polygons) = triangulate(&soup);
        let soup = Rc::new(soup);
        let mut surface = None;
        if diagnosis.is_solvable() {
            // A closed surface that is inside out is solved the right way round; the file stays as it is.
            if diagnosis.is_inside_out() {
                triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            let own = triangles.clone();
            surface = Some(Surface::new(name, soup.clone(), own, triangle_polygons.clone())?);
        }
        let mut notices = reading.clone();
        if polygons > 0 {
            notices.push(NoticeText {
                kind: "polygons".into(),
                count: polygons,
                text: format!("{} were divided into triangles.", plural(polygons, "polygon")),
            });
        }
        notices.extend(super::doctor::notices(&diagnosis));
        let summary = MeshSummary {
            name: name.to_owned(),
            format: format.to_owned(),
            vertices: soup.positions.len(),
            faces: soup.polygon_count(),
            triangles: triangles.len(),
            components: diagnosis.components,
            boundary_loops: diagnosis.boundary_loops,
            genus: diagnosis.genus,
            euler: diagnosis.euler,
            area: diagnosis.area,
            isolated_vertices: diagnosis.isolated_vertices(),
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
            diagnosis,
            surface,
            bounds,
            reading,
            summary,
        })
    }

    /// What methods work on, or why they cannot.
    pub fn surface(&self) -> Result<&Surface, Problem> {
        self.surface.as_ref().ok_or_else(|| super::doctor::blocked(&self.name, &self.diagnosis))
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
