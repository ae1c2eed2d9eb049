//! What comes after merging: cuts inside patches that are not needed, the check, and what the pipeline takes over.

use nalgebra::Point2;

use super::flow::{Member, MergeFlow};
use super::mirror::same_edges;
use super::state::MergePhase;
use super::trial::Map;
use crate::flatten::disks::log_scales;
use crate::flatten::fixed::Interior;
use crate::flatten::lpfb::lpfb_with;
use crate::flatten::{Flattening, NoChart, measure, rims, small};
use crate::geometry::Geometry;
use crate::mesh::{CutMesh, EdgeId, FaceId, MeshError, OpenedMesh};
use crate::methods::flow::SolveError;

/// Measures of a patch flattened anew agree to this: both maps solve the same systems, numbered differently.
const SAME: f64 = 1e-6;

impl MergeFlow {
    /// Shortens the cuts inside one patch, or one and its image, as far as its limits let.
    pub(super) fn zip_step(&mut self) {
        while self.next_zip < self.members.len() {
            let index = self.next_zip;
            self.next_zip += 1;
            // A pair of images is zipped at once.
            let image = self.image_of(small(index)).map(|image| image as usize);
            if let Some(image) = image.filter(|&image| image >= index)
                && self.members[index].as_ref().is_some_and(|m| m.map.is_some())
            {
                self.zip_member([index, image]);
                self.picture();
                return;
            }
        }
        self.state.phase = MergePhase::Checking;
    }

    /// **Takes** a patch and its image, itself where there is no symmetry.
    fn zip_member(&mut self, [index, image]: [usize; 2]) {
        let mut is_inside = vec![false; self.bench.mesh.face_count()];
        for f in self.members[index].iter().flat_map(|m| &m.faces) {
            is_inside[f.index()] = true;
        }
        // Whole curves first, then tips by halves.
        let curves: Vec<Vec<EdgeId>> = self
            .curves
            .iter()
            .map(|c| &c.edges)
            .filter(|edges| self.is_within(edges[0], &is_inside))
            .cloned()
            .collect();
        for edges in curves {
            self.try_to_glue([index, image], &edges);
        }
        loop {
            let chains = self.tip_chains(index, &is_inside);
            let mut has_glued = false;
            for chain in chains {
                let mut count = chain.len();
                while count > 0 && !has_glued {
                    has_glued = self.try_to_glue([index, image], &chain[..count]);
                    count /= 2;
                }
            }
            if !has_glued {
                return;
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
    fn tip_chains(&self, index: usize, is_inside: &[bool]) -> Vec<Vec<EdgeId>> {
        let mesh = &self.bench.mesh;
        let mut chains = Vec::new();
        for &f in self.members[index].iter().flat_map(|m| &m.faces) {
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

    /// Glues some edges if the patch still passes, and what can be zipped then; their images too, or neither. Gives whether it does.
    fn try_to_glue(&mut self, [index, image]: [usize; 2], edges: &[EdgeId]) -> bool {
        let mut wanted = edges.to_vec();
        if let Some(mirror) = self.mirror.as_ref().filter(|_| index == image) {
            let Some(images) = mirror.edges(edges) else { return false };
            wanted.extend(images);
            wanted.sort_unstable();
            wanted.dedup();
        }
        let mut removed = self.bench.remove(&wanted);
        if removed.is_empty() {
            return false;
        }
        self.bench.zip(&mut removed);
        // None without a symmetry, and none in it where there are no images.
        let images = self.mirror.as_ref().map(|mirror| mirror.edges(&removed));
        let maps = match images {
            Some(None) => None,
            Some(Some(images)) if index == image => same_edges(&images, &removed)
                .then(|| self.map_again(index))
                .flatten()
                .map(|map| [Some(map), None]),
            Some(Some(images)) => {
                let is_free = images.iter().all(|e| !self.bench.is_kept[e.index()]);
                removed.extend(self.bench.remove(&images));
                let maps = is_free.then(|| [index, image].map(|i| self.map_again(i)));
                maps.filter(|maps| maps.iter().all(Option::is_some))
            }
            None => self.map_again(index).map(|map| [Some(map), None]),
        };
        let Some(maps) = maps else {
            removed.iter().for_each(|&e| self.bench.set_cut(e, true));
            return false;
        };
        for (i, map) in [index, image].into_iter().zip(maps) {
            if let (Some(member), Some(map)) = (&mut self.members[i], map) {
                member.map = Some(map);
            }
        }
        true
    }

    /// A map of a patch along the present cut, if it still passes.
    fn map_again(&mut self, index: usize) -> Option<Map> {
        let member = self.members[index].as_ref()?;
        let limits = self.limits_of(member);
        self.bench.flatten(&member.faces, &limits).ok()
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

    /// What a patch with holes is opened along; an image along the images of what its original is opened along.
    fn openings(&self, index: u32) -> Vec<EdgeId> {
        let of = |i: u32| {
            let map = self.members[i as usize].as_ref().and_then(|m| m.map.as_ref());
            map.map_or_else(Vec::new, |map| map.virtual_edges.clone())
        };
        let original = self.image_of(index).filter(|&image| image < index);
        let images = original.and_then(|i| self.mirror.as_ref()?.edges(&of(i)));
        images.unwrap_or_else(|| of(index))
    }

    fn cut(&self, opens_holes: bool) -> CutMesh {
        let mesh = &self.bench.mesh;
        let mut cut = CutMesh::uncut(mesh);
        let mut edges: Vec<EdgeId> = self.state.cut_edges.clone();
        if opens_holes {
            edges.extend((0..small(self.members.len())).flat_map(|index| self.openings(index)));
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
