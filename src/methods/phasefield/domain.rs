//! The surface at area 4π, and what every term needs of it.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::geometry::{Geometry, Laplacian, angle_defects};
use crate::linalg::{Analysis, LinalgError};
use crate::mesh::{FaceId, Mesh};

/// No face there.
pub(super) const NONE: u32 = u32::MAX;

/// Everything that does not change while fields do. Lengths and areas are those of the surface scaled to area 4π, as the unit
/// sphere has.
pub(super) struct Domain {
    pub mesh: Arc<Mesh>,
    pub geometry: Arc<Geometry>,
    /// Length here of a length in the given geometry.
    pub scale: f64,
    /// A third of the area of the faces at each vertex.
    pub mass: Vec<f64>,
    /// Area of each face.
    pub areas: Vec<f64>,
    /// Corners of each face.
    pub triangles: Vec<[u32; 3]>,
    /// For each side `i` of a face, from corner `i` to the next, half the cotangent of the angle opposite.
    pub half_cots: Vec<[f64; 3]>,
    /// For each side of a face its entry in a value array of the pattern.
    pub side_slots: Vec<[u32; 3]>,
    /// The face across each side, [`NONE`] on the boundary.
    pub neighbours: Vec<[u32; 3]>,
    /// Longest side of each face.
    pub diameters: Vec<f64>,
    /// Integrated curvature of each vertex.
    pub defects: Vec<f64>,
    /// Vertices on the boundary or without faces, where a scale factor is 0.
    pub is_fixed: Vec<bool>,
    /// The one symbolic analysis.
    pub analysis: Arc<Analysis>,
    /// Mean edge length.
    pub mean_edge: f64,
}

/// Length at area 4π of a length in this geometry.
pub(super) fn scale_of(geometry: &Geometry) -> f64 {
    (4.0 * PI / geometry.total_area()).sqrt()
}

impl Domain {
    /// Measures and analyses. **Costs** one symbolic analysis.
    pub fn new(mesh: Arc<Mesh>, geometry: Arc<Geometry>) -> Result<Self, LinalgError> {
        let scale = scale_of(&geometry);
        let Laplacian { pattern, edge_slots, .. } = Laplacian::new(&mesh, &geometry);
        let areas: Vec<f64> = geometry.face_areas.iter().map(|a| a * scale * scale).collect();
        let mut mass = vec![0.0; mesh.vertex_count()];
        let mut triangles = Vec::with_capacity(areas.len());
        let (mut half_cots, mut side_slots) = (Vec::new(), Vec::new());
        let (mut neighbours, mut diameters) = (Vec::new(), Vec::new());
        for f in mesh.faces() {
            let corners = mesh.face_vertices(f).map(|v| v.0);
            for v in corners {
                mass[v as usize] += areas[f.index()] / 3.0;
            }
            triangles.push(corners);
            let cots = geometry.corner_cotangents[f.index()];
            half_cots.push([0.5 * cots[2], 0.5 * cots[0], 0.5 * cots[1]]);
            let sides = mesh.face_halfedges(f);
            side_slots.push(sides.map(|h| edge_slots[h.edge().index()]));
            neighbours.push(sides.map(|h| mesh.face(h.twin()).map_or(NONE, |f: FaceId| f.0)));
            let longest = sides.map(|h| geometry.edge_length(h.edge()) * scale);
            diameters.push(longest.into_iter().fold(0.0, f64::max));
        }
        let is_fixed = mesh
            .vertices()
            .map(|v| mesh.halfedge(v).is_none() || mesh.is_boundary_vertex(v))
            .collect();
        Ok(Self {
            scale,
            mass,
            areas,
            triangles,
            half_cots,
            side_slots,
            neighbours,
            diameters,
            defects: angle_defects(&mesh, &geometry),
            is_fixed,
            analysis: Arc::new(Analysis::new(pattern)?),
            mean_edge: geometry.mean_edge_length() * scale,
            mesh,
            geometry,
        })
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.mass.len()
    }

    /// The mean of a field over the corners of a face.
    #[inline]
    pub fn face_mean(&self, f: usize, u: &[f64]) -> f64 {
        let [a, b, c] = self.triangles[f];
        (u[a as usize] + u[b as usize] + u[c as usize]) / 3.0
    }

    /// The same for all faces.
    pub fn face_means(&self, u: &[f64]) -> Vec<f64> {
        (0..self.triangles.len()).map(|f| self.face_mean(f, u)).collect()
    }

    /// lᵀ kᶠ s for the stiffness kᶠ of a face: ∫ ∇l·∇s over it.
    #[inline]
    pub fn face_product(&self, face: usize, l: &[f64], s: &[f64]) -> f64 {
        let t = self.triangles[face].map(|v| v as usize);
        let k = self.half_cots[face];
        k[0] * (l[t[0]] - l[t[1]]) * (s[t[0]] - s[t[1]])
            + k[1] * (l[t[1]] - l[t[2]]) * (s[t[1]] - s[t[2]])
            + k[2] * (l[t[2]] - l[t[0]]) * (s[t[2]] - s[t[0]])
    }

    /// Adds the stiffness of the whole surface with a factor for each face to a value array of the pattern. Sides at vertices
    /// that `is_left_out` names lose their entry off the diagonal, and those vertices their diagonal.
    pub fn add_stiffness(
        &self,
        values: &mut [f64],
        weight: impl Fn(usize) -> f64,
        is_left_out: impl Fn(usize) -> bool,
    ) {
        let pattern = self.analysis.pattern();
        for f in 0..self.triangles.len() {
            let w = weight(f);
            for i in 0..3 {
                let [a, b] = [i, (i + 1) % 3].map(|k| self.triangles[f][k] as usize);
                let k = w * self.half_cots[f][i];
                let (out_a, out_b) = (is_left_out(a), is_left_out(b));
                if !out_a {
                    values[pattern.diagonal(a)] += k;
                }
                if !out_b {
                    values[pattern.diagonal(b)] += k;
                }
                if !out_a && !out_b {
                    values[self.side_slots[f][i] as usize] -= k;
                }
            }
        }
    }
}
