//! What comes after merging: cuts inside patches that are not needed, the check, and what the pipeline takes over.

use nalgebra::Point2;

use super::flow::{Member, MergeFlow};
use super::state::MergePhase;
use super::trial::{Limits, Map};
use crate::flatten::disks::log_scales;
use crate::flatten::fixed::Interior;
use crate::flatten::lpfb::lpfb_with;
use crate::flatten::{Flattening, NoChart, measure, rims};
use crate::geometry::Geometry;
use crate::mesh::{CutMesh, EdgeId, FaceId, MeshError, OpenedMesh};
use crate::methods::flow::SolveError;

/// Measures of a patch flattened anew agree to this: both maps solve the same systems, numbered differently.
const SAME: f64 = 1e-6;

impl MergeFlow {
    /// Shortens the cuts inside one patch as far as its limits let.
    pub(super) fn zip_step(&mut self) {
        while self.next_zip < self.members.len() {
            let index = self.next_zip;
            self.next_zip += 1;
            if let Some(member) = self.members[index].take() {
                let has_map = member.map.is_some();
                let zipped = if has_map { self.zip_member(member) } else { member };
                self.members[index] = Some(zipped);
                if has_map {
                    self.picture();
                    return;
                }
            }
        }
        self.state.phase = MergePhase::Checking;
    }

    fn zip_member(&mut self, mut member: Member) -> Member {
        let limits = self.limits_of(&member);
        let mut is_inside = vec![false; self.bench.mesh.face_count()];
        member.faces.iter().for_each(|f| is_inside[f.index()] = true);
        // Whole curves first, then tips by halves.
        let curves: Vec<Vec<EdgeId>> = self
            .curves
            .iter()
            .map(|c| &c.edges)
            .filter(|edges| self.is_within(edges[0], &is_inside))
            .cloned()
            .collect();
        for edges in curves {
            self.try_to_glue(&mut member, &edges, &limits);
        }
        loop {
            let chains = self.tip_chains(&member, &is_inside);
            let mut has_glued = false;
            for chain in chains {
                let mut count = chain.len();
                while count > 0 && !has_glued {
                    has_glued = self.try_to_glue(&mut member, &chain[..count], &limits);
                    count /= 2;
                }
            }
            if !has_glued {
                return member;
            }
        }
    }

    fn is_within(&self, e: EdgeId, is_inside: &[bool]) -> bool {
        let mesh = &self.bench.mesh;
        [e.halfedge(), e.halfedge().twin()]
            .iter()
            .all(|&h| mesh.face(h).is_some_and(|f| is_inside[f.index()]))
    }

    /// Cuts that end inside the patch, from their tips to where they meet others.
    fn tip_chains(&self, member: &Member, is_inside: &[bool]) -> Vec<Vec<EdgeId>> {
        let mesh = &self.bench.mesh;
        let mut chains = Vec::new();
        for &f in &member.faces {
            for h in mesh.face_halfedges(f) {
                let mut v = mesh.tail(h);
                let is_tip = self.bench.tip_at(v) == Some(h.edge());
                if !is_tip || !self.is_within(h.edge(), is_inside) {
                    continue;
                }
                let mut chain = vec![h.edge()];
                v = mesh.tip(h);
                while self.bench.valence(v) == 2 && !mesh.is_boundary_vertex(v) {
                    let last = chain[chain.len() - 1];
                    let on = mesh
                        .outgoing(v)
                        .find(|g| self.bench.is_cut()[g.edge().index()] && g.edge() != last);
                    let Some(on) = on else { break };
                    chain.push(on.edge());
                    v = mesh.tip(on);
                }
                chains.push(chain);
            }
        }
        chains
    }

    /// Glues some edges if the patch still passes, and what can be zipped then. Gives whether it does.
    fn try_to_glue(&mut self, member: &mut Member, edges: &[EdgeId], limits: &Limits) -> bool {
        let mut removed = self.bench.remove(edges);
        if removed.is_empty() {
            return false;
        }
        self.bench.zip(&mut removed);
        match self.bench.flatten(&member.faces, limits) {
            Ok(map) => {
                member.map = Some(map);
                true
            }
            Err(_) => {
                removed.iter().for_each(|&e| self.bench.set_cut(e, true));
                false
            }
        }
    }

    /// Flattens all patches anew, opened as they will be, by the code that everyone else uses, and compares.
    ///
    /// **Fails** on the first patch that is not what it was said to be.
    pub(super) fn check(&mut self) -> Result<(), SolveError> {
        let opened = self.cut(false).open()?;
        let geometry = self.opened_geometry(&opened);
        let (charts, reports) =
            lpfb_with(&opened, &geometry, &[self.interior()]).map_err(SolveError::Linalg)?;
        let measures = measure(&opened, &geometry, &charts);
        for member in self.members.iter().flatten() {
            let Some(map) = &member.map else { continue };
            let patch = opened.face_patches[member.faces[0].index()];
            let limits = self.limits_of(member);
            let holds = measures.charts[patch as usize].as_ref().is_some_and(|m| {
                let change = match limits.measure {
                    super::AreaMeasure::Total => m.area_change.abs(),
                    super::AreaMeasure::Absolute => m.area_change_abs,
                };
                m.faces == member.faces.len()
                    && m.flipped == 0
                    && m.overlaps == 0
                    && reports[patch as usize].crossings == 0
                    && change <= limits.area + SAME
                    && m.l2_stretch <= limits.l2 + SAME
                    && (m.area_change_abs - map.measures.area_absolute).abs() < SAME
            });
            if !holds {
                return Err(SolveError::PatchCheck { face: member.faces[0] });
            }
        }
        Ok(())
    }

    /// The interior that measures belong to.
    pub fn interior(&self) -> Interior {
        match self.params.strategy {
            super::MergeStrategy::BestFirst if self.params.rigid_steps > 0 => {
                Interior::Rigid { steps: self.params.rigid_steps }
            }
            _ => Interior::Harmonic,
        }
    }

    fn cut(&self, opens_holes: bool) -> CutMesh {
        let mesh = &self.bench.mesh;
        let mut cut = CutMesh::uncut(mesh);
        let mut edges: Vec<EdgeId> = self.state.cut_edges.clone();
        if opens_holes {
            let maps = self.members.iter().flatten().filter_map(|m| m.map.as_ref());
            edges.extend(maps.flat_map(|map| map.virtual_edges.iter().copied()));
            edges.sort_unstable();
            edges.dedup();
        }
        cut.cut_edges = edges.into_iter().map(|e| mesh.edge_vertices(e).map(|v| v.0)).collect();
        cut
    }

    /// The uncut mesh and the edges of the cut, darts and what opens patches with holes included: every patch with a map is a disk.
    pub fn cut_mesh(&self) -> CutMesh {
        self.cut(true)
    }

    fn opened_geometry(&self, opened: &OpenedMesh) -> Geometry {
        let positions = &self.bench.geometry.positions;
        let places = opened.vertex_points.iter().map(|&p| positions[p as usize]).collect();
        Geometry::measure(&opened.mesh, places)
    }

    /// The opened mesh of [`MergeFlow::cut_mesh`], its measures, and the very maps that patches were accepted with.
    pub fn flattening(&self) -> Result<(OpenedMesh, Geometry, Flattening), MeshError> {
        let opened = self.cut_mesh().open()?;
        let geometry = self.opened_geometry(&opened);
        let nowhere = Point2::new(f64::NAN, f64::NAN);
        let mut uv = vec![nowhere; opened.mesh.vertex_count()];
        let mut charts = rims(&opened);
        let places: Vec<(&Member, &Map)> =
            self.members.iter().flatten().filter_map(|m| Some((m, m.map.as_ref()?))).collect();
        for (member, map) in places {
            for (&f, corners) in member.faces.iter().zip(&map.places) {
                for (v, place) in opened.mesh.face_vertices(f).into_iter().zip(corners) {
                    uv[v.index()] = *place;
                }
            }
        }
        for member in self.members.iter().flatten().filter(|m| m.map.is_none()) {
            let face: FaceId = member.faces[0];
            charts[opened.face_patches[face.index()] as usize] = Err(NoChart::Degenerate { face });
        }
        // A patch without rim has no chart, whatever was said of its places.
        for (v, &patch) in opened.vertex_patches().iter().enumerate() {
            if charts[patch as usize].is_err() {
                uv[v] = nowhere;
            }
        }
        let u = log_scales(&opened, &geometry, &uv);
        // Maps whose solves left more than rounding were not accepted.
        let residual = 0.0;
        let flattening = Flattening::of_places(charts, uv, u, true, residual);
        Ok((opened, geometry, flattening))
    }
}
