//! Initial cuts along what a file already tells apart: islands of its texture map, groups, materials.

use super::surface::Surface;
use super::text::Problem;
use crate::mesh::uv_islands;
use crate::methods::cutflow::{Initial, initial_labels};

/// What tells the faces of a file apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSource {
    /// Islands of the texture map: its seams become the cut.
    UvIslands,
    /// Groups, objects or nodes.
    Groups,
    /// Materials.
    Materials,
}

impl FaceSource {
    /// In the plural, as part of a sentence.
    fn noun(self) -> &'static str {
        match self {
            Self::UvIslands => "UV islands",
            Self::Groups => "groups",
            Self::Materials => "materials",
        }
    }
}

impl Surface {
    /// A number for each face: its island, group or material; `u32::MAX` for a face without.
    ///
    /// **Fails** if the file has none of them, or if all faces are the same.
    pub fn face_regions(&self, source: FaceSource) -> Result<Vec<u32>, Problem> {
        let noun = source.noun();
        let soup = &self.soup;
        let of_polygons = match source {
            FaceSource::UvIslands => uv_islands(soup),
            FaceSource::Groups => Some(soup.polygon_groups.clone()),
            FaceSource::Materials => Some(soup.polygon_materials.clone()),
        };
        let absent = || {
            let what = match source {
                FaceSource::UvIslands => "The mesh has no texture coordinates to cut along.".into(),
                _ => format!("The mesh has no {noun} to cut along."),
            };
            Problem::new(
                what,
                format!("{}, initial cut.", self.name),
                "Choose another initial cut, or export the mesh with them.",
            )
        };
        let of_polygons =
            of_polygons.filter(|list| list.len() == soup.polygon_count()).ok_or_else(absent)?;
        let of_faces: Vec<u32> =
            self.face_polygons.iter().map(|&p| of_polygons[p as usize]).collect();
        if of_faces.windows(2).all(|pair| pair[0] == pair[1]) {
            if of_faces.first().is_none_or(|&first| first == u32::MAX) {
                return Err(absent());
            }
            return Err(self.empty_cut(noun));
        }
        Ok(of_faces)
    }

    /// The initial cut between regions of faces, on the triangles that methods solve on.
    ///
    /// **Takes** one number for each face. **Gives** also the numbers of connected regions that were too narrow to get a
    /// vertex. **Fails** if nothing is cut.
    pub fn initial_of_faces(&self, regions: Vec<u32>) -> Result<(Initial, Vec<u32>), Problem> {
        let initial = Initial::Faces(regions);
        let start = initial_labels(&self.mesh, &self.geometry, &initial)
            .map_err(|error| Problem::solve(&self.name, &error))?;
        // Flipped edges make other faces; the vertices are the same.
        Ok(match self.solving {
            Some(_) => (Initial::Labels(start.labels), start.lost),
            None => (initial, start.lost),
        })
    }

    fn empty_cut(&self, noun: &str) -> Problem {
        Problem::new(
            format!("The initial cut is empty: there are no two {noun} in the mesh."),
            format!("{}, initial cut.", self.name),
            "Choose another initial cut.",
        )
    }
}
