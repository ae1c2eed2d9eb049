//! One triangulation of the surface with everything that is solved on it. Rounds differ by points added on edges.

use nalgebra::{Complex, Point2, Point3};

use super::error::ConformalError;
use super::part::{Limits, Part, components, shape_of};
use super::place::{flipped_faces, partner_mismatch, place, side_of_halfedges};
use super::repair::{Insertion, plan};
use super::settle::settle;
use super::split::{Origin, Refined, split};
use super::targets::{Condition, balance};
use crate::flatten::{Flattening, NoChart};
use crate::geometry::mollification;
use crate::mesh::{CutMesh, EdgeId, FaceId, Mesh, MeshError, OpenedMesh};

/// By how much two sides of a triangle must be longer than the third, in mean lengths: heights of 1e-5, whose angles have six
/// good digits. What it adds to all lengths is below what isometric charts are held to.
const SLACK: f64 = 1e-10;

/// Partners whose lengths differ by less, relatively, are equal.
const SAME_LENGTH: f64 = 1e-10;

/// A cut surface as it is handed in and out.
#[derive(Clone, Debug)]
pub(super) struct CutSurface {
    pub cut: CutMesh,
    pub positions: Vec<Point3<f64>>,
    pub opened: OpenedMesh,
}

/// A cut surface, what is asked of it, and its parts.
#[derive(Clone, Debug)]
pub(super) struct Round {
    pub surface: CutSurface,
    /// The surface before opening.
    pub whole: Mesh,
    /// Whether patches are solved one by one, or the surface before it is opened.
    pub by_patch: bool,
    pub conditions: Vec<Condition>,
    pub parts: Vec<Part>,
    pub mollified: f64,
}

/// Charts, as far as one round gets.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub surface: CutSurface,
    pub flattening: Flattening,
    pub closure: f64,
    pub partner_mismatch: f64,
    pub flipped_before: usize,
    pub flipped_after: usize,
    /// Vertices that were moved.
    pub moved: usize,
    /// Faces of the round's surface that no point would turn over.
    pub left: Vec<FaceId>,
    pub scale_range: [f64; 2],
}

impl Round {
    /// **Takes** conditions on the vertices of what is solved, with log scale factors to begin with.
    pub fn new(
        surface: CutSurface,
        whole: Mesh,
        by_patch: bool,
        mut conditions: Vec<Condition>,
        start: &[f64],
        limits: Limits,
    ) -> Result<Self, ConformalError> {
        let mesh = if by_patch { &surface.opened.mesh } else { &whole };
        let at = |v: usize| {
            let point = if by_patch { surface.opened.vertex_points[v] as usize } else { v };
            surface.positions[point]
        };
        let lengths: Vec<f64> = mesh
            .edges()
            .map(|e| {
                let [a, b] = mesh.edge_vertices(e).map(|v| at(v.index()));
                (b - a).norm()
            })
            .collect();
        let usable = lengths.iter().filter(|l| l.is_finite());
        let mean = usable.clone().sum::<f64>() / usable.count().max(1) as f64;
        let mollified = mollification(mesh, &lengths, SLACK * mean);
        let shapes = if by_patch { surface.opened.patch_shapes() } else { Vec::new() };
        let mut parts = Vec::new();
        for faces in components(mesh) {
            let patch = surface.opened.face_patches[faces[0].index()] as usize;
            let no_chart = match shapes.get(patch) {
                None | Some((1, 1)) => None,
                Some(&(euler, boundary_loops)) => Some(NoChart::NotADisk { euler, boundary_loops }),
            };
            if no_chart.is_none() {
                let (vertices, needed) = shape_of(mesh, &faces);
                balance(&mut conditions, &vertices, needed)?;
            }
            parts.push(Part::new(
                mesh,
                faces,
                &lengths,
                mollified,
                &conditions,
                start,
                limits,
                no_chart,
            ));
        }
        Ok(Self { surface, whole, by_patch, conditions, parts, mollified })
    }

    /// The surface that is solved on.
    pub fn mesh(&self) -> &Mesh {
        if self.by_patch { &self.surface.opened.mesh } else { &self.whole }
    }

    /// Log scale factor at every vertex of it; NaN where there is none.
    pub fn scale_factors(&self) -> Vec<f64> {
        let mut v = vec![f64::NAN; self.mesh().vertex_count()];
        for part in &self.parts {
            if let Ok(solver) = &part.solver {
                for (vertex, value) in part.vertices.iter().zip(&solver.v) {
                    v[vertex.index()] = *value;
                }
            }
        }
        v
    }

    /// Sides of faces in which a triangle on a seam ended without inequality, for parts that can be helped by points there.
    pub fn degenerate_seams(&self) -> Vec<usize> {
        let opened = &self.surface.opened;
        if !self.by_patch {
            return Vec::new();
        }
        let sides = side_of_halfedges(&opened.mesh);
        let inner = |e: EdgeId| {
            let h = e.halfedge();
            if opened.mesh.face(h).is_some() { h } else { h.twin() }
        };
        let edges = self.parts.iter().filter(|p| !p.is_running()).flat_map(Part::degenerate_edges);
        let seams = edges.map(inner).filter(|h| opened.partner(*h).is_some());
        seams.map(|h| sides[h.index()]).collect()
    }

    /// Begins again, on the surface glued to its mirror image, wherever a boundary stands in the way. **Gives** whether anything did.
    pub fn double(&mut self) -> bool {
        let mut any = false;
        for part in &mut self.parts {
            let failed = part.solver.is_ok() && part.failure().is_some();
            let stuck = failed || !part.degenerate_edges().is_empty();
            if stuck && !part.is_doubled && part.has_boundary() {
                part.double(&self.conditions);
                any = true;
            }
        }
        any
    }

    /// Charts of all parts that are solved, with points inserted where faces lie on their backs.
    pub fn lay_out(&self, base: &Mesh, repair: bool) -> Result<Layout, MeshError> {
        let opened = &self.surface.opened;
        let missing = NoChart::Degenerate { face: FaceId(0) };
        let mut developed = vec![Err(missing); self.whole.face_count()];
        let mut v = self.scale_factors();
        for part in &self.parts {
            let flat = part.develop();
            let scale = match &flat {
                Some(flat) if part.is_floating => self.natural_scale(part, flat),
                _ => 1.0,
            };
            for (i, face) in part.faces.iter().enumerate() {
                developed[face.index()] = match (&flat, part.failure()) {
                    (_, Some(reason)) => Err(reason),
                    (None, None) => Err(missing),
                    (Some(flat), None) => Ok(flat[i].map(|mut side| {
                        side.z *= scale;
                        side
                    })),
                };
            }
            for vertex in &part.vertices {
                v[vertex.index()] += scale.ln();
            }
        }
        let placed = place(opened, &developed);
        let mut u = vec![f64::NAN; opened.mesh.vertex_count()];
        for f in opened.mesh.faces() {
            if placed.charts[opened.face_patches[f.index()] as usize].is_ok() {
                let solved = self.mesh().face_vertices(f);
                for (vertex, own) in opened.mesh.face_vertices(f).into_iter().zip(solved) {
                    u[vertex.index()] = v[own.index()];
                }
            }
        }
        let flipped = flipped_faces(opened, &placed.charts, &placed.uv);
        let range = |u: &[f64]| {
            let finite = u.iter().filter(|u| u.is_finite());
            finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &u| [a.min(u), b.max(u)])
        };
        let mut layout = Layout {
            scale_range: range(&u),
            closure: placed.closure,
            partner_mismatch: partner_mismatch(opened, &placed.uv),
            flipped_before: flipped.len(),
            flipped_after: flipped.len(),
            moved: 0,
            left: flipped.clone(),
            flattening: Flattening {
                charts: placed.charts,
                uv: placed.uv,
                u,
                seams_equal: false,
                angles_exact: !self.by_patch,
                closing: 0.0,
                // The errors of angles are what is told.
                residual: 0.0,
            },
            surface: self.surface.clone(),
        };
        if repair && !flipped.is_empty() {
            let (insertions, left) =
                plan(opened, &layout.flattening.uv, &self.surface.positions, &flipped);
            layout.left = left;
            self.insert(base, &mut layout, &insertions)?;
        }
        layout.flattening.seams_equal = layout.partner_mismatch < SAME_LENGTH;
        Ok(layout)
    }

    /// √ (area of the surface / area of the chart).
    fn natural_scale(&self, part: &Part, flat: &[[super::develop::Developed; 3]]) -> f64 {
        let turned = |a: Complex<f64>, b: Complex<f64>| 0.5 * (a.conj() * b).im;
        let chart: f64 = flat.iter().map(|[a, b, _]| turned(a.z, b.z)).sum();
        let surface: f64 = part
            .faces
            .iter()
            .map(|f| {
                let [a, b, c] =
                    self.whole.face_vertices(*f).map(|p| self.surface.positions[p.index()]);
                0.5 * (b - a).cross(&(c - a)).norm()
            })
            .sum();
        let scale = (surface / chart).sqrt();
        if scale > 0.0 && scale.is_finite() { scale } else { 1.0 }
    }

    /// For each edge of the whole surface where a point is to be put, from the tail of its first halfedge.
    fn points_on(&self, sides: impl Iterator<Item = (usize, f64)>) -> Vec<Option<f64>> {
        let mut at = vec![None; self.whole.edge_count()];
        for (side, t) in sides {
            let h = self.whole.face_halfedges(FaceId::from(side / 3))[side % 3];
            let t = if h == h.edge().halfedge() { t } else { 1.0 - t };
            at[h.edge().index()] = Some(t);
        }
        at
    }

    fn refine(&self, base: &Mesh, at: &[Option<f64>]) -> Refined {
        split(base, &self.surface.cut, &self.surface.positions, &self.whole, at)
    }

    /// Puts points into a layout.
    fn insert(
        &self,
        base: &Mesh,
        layout: &mut Layout,
        insertions: &[Insertion],
    ) -> Result<(), MeshError> {
        let at = self.points_on(insertions.iter().map(|i| (i.side, i.t)));
        let refined = self.refine(base, &at);
        let opened = refined.cut.open()?;
        let old = &layout.flattening;
        let nowhere = Point2::new(f64::NAN, f64::NAN);
        let mut uv = vec![nowhere; opened.mesh.vertex_count()];
        let mut u = vec![f64::NAN; opened.mesh.vertex_count()];
        let mut places = vec![nowhere; 3 * self.whole.face_count()];
        for insertion in insertions {
            places[insertion.side] = insertion.places[0];
            places[insertion.across] = insertion.places[1];
        }
        let was = &self.surface.opened.mesh;
        for (f, origins) in opened.mesh.faces().zip(&refined.origins) {
            for (v, origin) in opened.mesh.face_vertices(f).into_iter().zip(origins) {
                let corner = |c: usize| was.face_vertices(FaceId::from(c / 3))[c % 3].index();
                match *origin {
                    Origin::Corner(c) => {
                        uv[v.index()] = old.uv[corner(c)];
                        u[v.index()] = old.u[corner(c)];
                    }
                    // The first face to come decides; the other one differs by rounding.
                    Origin::Side(s) if uv[v.index()].x.is_nan() => {
                        uv[v.index()] = places[s];
                        let next = 3 * (s / 3) + (s + 1) % 3;
                        u[v.index()] = 0.5 * (old.u[corner(s)] + old.u[corner(next)]);
                    }
                    Origin::Side(_) => {}
                }
            }
        }
        let mut charts = crate::flatten::rims(&opened);
        for (chart, old) in charts.iter_mut().zip(&old.charts) {
            if let Err(reason) = old {
                *chart = Err(*reason);
            }
        }
        let still = flipped_faces(&opened, &charts, &uv);
        if !still.is_empty() {
            layout.moved = settle(&opened, &mut uv, &still);
        }
        layout.flipped_after = flipped_faces(&opened, &charts, &uv).len();
        layout.partner_mismatch = partner_mismatch(&opened, &uv);
        layout.flattening = Flattening { charts, uv, u, ..old.clone() };
        layout.surface = CutSurface { cut: refined.cut, positions: refined.positions, opened };
        Ok(())
    }

    /// The next round: points in the middle of given sides, the surface as it is.
    pub fn refined(
        &self,
        base: &Mesh,
        sides: &[usize],
        limits: Limits,
    ) -> Result<Self, ConformalError> {
        let at = self.points_on(sides.iter().map(|&s| (s, 0.5)));
        let refined = self.refine(base, &at);
        let opened = refined.cut.open()?;
        let whole = Mesh::new(refined.cut.points.len(), &refined.cut.triangles)?;
        let mesh = if self.by_patch { &opened.mesh } else { &whole };
        let was = self.mesh();
        let v = self.scale_factors();
        let start_of = |v: f64| if v.abs() < 5.0 { v } else { 0.0 };
        let mut conditions = vec![Condition::Scale(0.0); mesh.vertex_count()];
        let mut start = vec![0.0; mesh.vertex_count()];
        for (f, origins) in mesh.faces().zip(&refined.origins) {
            for (vertex, origin) in mesh.face_vertices(f).into_iter().zip(origins) {
                let corner = |c: usize| was.face_vertices(FaceId::from(c / 3))[c % 3].index();
                let i = vertex.index();
                match *origin {
                    Origin::Corner(c) => {
                        conditions[i] = self.conditions[corner(c)];
                        start[i] = start_of(v[corner(c)]);
                    }
                    Origin::Side(s) => {
                        let ends = [corner(s), corner(3 * (s / 3) + (s + 1) % 3)];
                        start[i] = start_of(0.5 * (v[ends[0]] + v[ends[1]]));
                        let flat = match mesh.is_boundary_vertex(vertex) {
                            true => std::f64::consts::PI,
                            false => std::f64::consts::TAU,
                        };
                        let given = ends.map(|e| self.conditions[e]);
                        conditions[i] = match given {
                            [Condition::Scale(a), Condition::Scale(b)]
                                if mesh.is_boundary_vertex(vertex) =>
                            {
                                Condition::Scale(0.5 * (a + b))
                            }
                            _ => Condition::Angle(flat),
                        };
                    }
                }
            }
        }
        let surface = CutSurface { cut: refined.cut, positions: refined.positions, opened };
        Self::new(surface, whole, self.by_patch, conditions, &start, limits)
    }
}
