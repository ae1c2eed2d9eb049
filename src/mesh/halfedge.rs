//! Halfedges with `twin(h) = h ^ 1`.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

/// Defines an element id: a `u32` that cannot be mistaken for another kind of element.
macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        pub struct $name(pub u32);

        impl $name {
            /// The id as an array index.
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl From<usize> for $name {
            /// Meshes hold fewer than 2³² elements of a kind: [`Mesh::new`] checks.
            #[inline]
            fn from(index: usize) -> Self {
                Self(index as u32)
            }
        }
    };
}

id!(
    /// A vertex.
    VertexId
);
id!(
    /// A directed edge. Its twin runs the other way: `twin(h) = h ^ 1`.
    HalfedgeId
);
id!(
    /// An undirected edge: halfedges `2e` and `2e + 1`.
    EdgeId
);
id!(
    /// A triangle.
    FaceId
);

impl HalfedgeId {
    /// The same edge in the other direction.
    #[inline]
    pub fn twin(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// The undirected edge.
    #[inline]
    pub fn edge(self) -> EdgeId {
        EdgeId(self.0 >> 1)
    }
}

impl EdgeId {
    /// The first of the edge's two halfedges. Always inside a face.
    #[inline]
    pub fn halfedge(self) -> HalfedgeId {
        HalfedgeId(self.0 << 1)
    }
}

const NONE: u32 = u32::MAX;

/// Why triangles do not form an oriented manifold. Lists name every place, in increasing order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// There is no triangle.
    #[error("the mesh has no faces")]
    NoFaces,
    /// More elements than 32-bit ids can tell apart.
    #[error("the mesh has {faces} faces, more than this program can number")]
    TooLarge {
        /// Number of triangles.
        faces: usize,
    },
    /// A triangle names a vertex twice.
    #[error("{} faces use a vertex twice, the first is face {}", .faces.len(), .faces[0].0)]
    RepeatedVertices {
        /// The triangles.
        faces: Vec<FaceId>,
    },
    /// Three or more triangles share an edge.
    #[error("{} edges belong to three or more faces, the first joins vertices {} and {}", .edges.len(), .edges[0][0].0, .edges[0][1].0)]
    NonManifoldEdges {
        /// End vertices of the edges.
        edges: Vec<[VertexId; 2]>,
        /// The triangles at these edges.
        faces: Vec<FaceId>,
    },
    /// Two neighbours run through their common edge in the same direction.
    #[error("{} edges join faces of opposite orientation, the first joins vertices {} and {}", .edges.len(), .edges[0][0].0, .edges[0][1].0)]
    InconsistentOrientation {
        /// End vertices of the edges.
        edges: Vec<[VertexId; 2]>,
    },
    /// The triangles around a vertex form more than one fan (a bow-tie).
    #[error("{} vertices join parts that touch in that point only, the first is vertex {}", .vertices.len(), .vertices[0].0)]
    NonManifoldVertices {
        /// The vertices.
        vertices: Vec<VertexId>,
    },
}

/// An oriented triangulated manifold.
///
/// Inside a face `next` runs counter-clockwise; on the boundary it runs along the loop with the surface on the right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    halfedge_tails: Vec<VertexId>,
    halfedge_nexts: Vec<HalfedgeId>,
    halfedge_faces: Vec<u32>,
    vertex_halfedges: Vec<u32>,
    face_vertices: Vec<[VertexId; 3]>,
    face_halfedges: Vec<[HalfedgeId; 3]>,
    loop_halfedges: Vec<HalfedgeId>,
}

/// Global shape of a surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    /// For each face the component that it belongs to, numbered by first face.
    pub face_components: Vec<u32>,
    /// Number of components.
    pub components: usize,
    /// Number of boundary loops.
    pub boundary_loops: usize,
    /// V − E + F, isolated vertices not counted.
    pub euler: i64,
    /// Sum over the components of the genus with holes capped.
    pub genus: usize,
}

impl Mesh {
    /// Connects triangles.
    ///
    /// **Takes** counter-clockwise vertex triples, indices below `vertex_count`; isolated vertices are allowed. **Gives** a
    /// mesh whose face `i` is `triangles[i]` with the same first vertex.
    /// **Fails** if the triangles do not form an oriented manifold. **Costs** O(V + F).
    ///
    /// ```
    /// use cutflow::mesh::{FaceId, Mesh};
    /// let mesh = Mesh::new(3, &[[0, 1, 2]])?;
    /// let [a, b, _] = mesh.face_halfedges(FaceId(0));
    /// assert_eq!((mesh.tail(a).0, mesh.tip(a).0, mesh.next(a)), (0, 1, b));
    /// # Ok::<(), cutflow::mesh::MeshError>(())
    /// ```
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::NoFaces);
        }
        if triangles.len() > (u32::MAX / 8) as usize {
            return Err(MeshError::TooLarge { faces: triangles.len() });
        }
        let repeated: Vec<FaceId> = (0..triangles.len())
            .filter(|&f| {
                let [a, b, c] = triangles[f];
                a == b || b == c || c == a
            })
            .map(FaceId::from)
            .collect();
        if !repeated.is_empty() {
            return Err(MeshError::RepeatedVertices { faces: repeated });
        }
        let mut mesh = Self::pair_halfedges(vertex_count, triangles)?;
        mesh.link_boundary();
        mesh.check_vertex_fans()?;
        Ok(mesh)
    }

    /// Finds the twin of every side of every triangle, by buckets of the smaller vertex.
    fn pair_halfedges(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        let sides = 3 * triangles.len();
        let ends = |face: usize, i: usize| (triangles[face][i], triangles[face][(i + 1) % 3]);
        let mut starts = vec![0u32; vertex_count + 1];
        for face in 0..triangles.len() {
            for i in 0..3 {
                let (a, b) = ends(face, i);
                starts[a.min(b) as usize + 1] += 1;
            }
        }
        for v in 0..vertex_count {
            starts[v + 1] += starts[v];
        }
        // The larger vertex of each side, the side's number, and whether it begins at the larger one: sorted as one number.
        let mut bucket = vec![0u64; sides];
        for face in 0..triangles.len() {
            for i in 0..3 {
                let (a, b) = ends(face, i);
                let slot = &mut starts[a.min(b) as usize];
                let name = 2 * (3 * face + i) as u64 + u64::from(a > b);
                bucket[*slot as usize] = u64::from(a.max(b)) << 32 | name;
                *slot += 1;
            }
        }

        let side = |s: u64| (s as u32 >> 1) as usize;
        let mut side_halfedges = vec![NONE; sides];
        let mut halfedge_tails = Vec::with_capacity(sides + sides / 8);
        let mut crowded = Vec::new();
        let mut twisted = Vec::new();
        let mut begin = 0;
        for v in 0..vertex_count {
            let end = starts[v] as usize;
            let group = &mut bucket[begin..end];
            begin = end;
            group.sort_unstable();
            for same in group.chunk_by(|s, t| s >> 32 == t >> 32) {
                let name = [VertexId(v as u32), VertexId((same[0] >> 32) as u32)];
                if same.len() > 2 {
                    crowded.push((name, same.iter().map(|&s| side(s)).collect::<Vec<_>>()));
                    continue;
                }
                let h = halfedge_tails.len() as u32;
                let from_larger = same[0] & 1;
                let [tail, tip] = if from_larger == 0 { name } else { [name[1], name[0]] };
                halfedge_tails.push(tail);
                halfedge_tails.push(tip);
                side_halfedges[side(same[0])] = h;
                if let Some(&other) = same.get(1) {
                    if other & 1 == from_larger {
                        twisted.push(name);
                    }
                    side_halfedges[side(other)] = h + 1;
                }
            }
        }
        if !crowded.is_empty() {
            let mut faces: Vec<FaceId> =
                crowded.iter().flat_map(|(_, sides)| sides).map(|&s| FaceId::from(s / 3)).collect();
            faces.sort_unstable();
            faces.dedup();
            let edges = crowded.into_iter().map(|(name, _)| name).collect();
            return Err(MeshError::NonManifoldEdges { edges, faces });
        }
        if !twisted.is_empty() {
            return Err(MeshError::InconsistentOrientation { edges: twisted });
        }

        let halfedges = halfedge_tails.len();
        let mut mesh = Self {
            halfedge_tails,
            halfedge_nexts: vec![HalfedgeId(NONE); halfedges],
            halfedge_faces: vec![NONE; halfedges],
            vertex_halfedges: vec![NONE; vertex_count],
            face_vertices: triangles.iter().map(|t| t.map(VertexId)).collect(),
            face_halfedges: Vec::with_capacity(triangles.len()),
            loop_halfedges: Vec::new(),
        };
        for face in 0..triangles.len() {
            let own = [0, 1, 2].map(|i| HalfedgeId(side_halfedges[3 * face + i]));
            for i in 0..3 {
                mesh.halfedge_nexts[own[i].index()] = own[(i + 1) % 3];
                mesh.halfedge_faces[own[i].index()] = face as u32;
                let tail = mesh.tail(own[i]);
                mesh.vertex_halfedges[tail.index()] = own[i].0;
            }
            mesh.face_halfedges.push(own);
        }
        Ok(mesh)
    }

    /// Chains the halfedges without a face into loops and lets every boundary vertex start its fan at the boundary.
    fn link_boundary(&mut self) {
        // The boundary halfedge that leaves a vertex; at a bow-tie one of several, which the fan check then refuses.
        let mut leaving = vec![NONE; self.vertex_count()];
        for h in 0..self.halfedge_count() {
            if self.halfedge_faces[h] == NONE {
                let h = HalfedgeId::from(h);
                leaving[self.tail(h).index()] = h.0;
                // The twin arrives from outside and has the boundary on its right: the first of the fan.
                let tip = self.tip(h);
                self.vertex_halfedges[tip.index()] = h.twin().0;
            }
        }
        let mut seen = vec![false; self.halfedge_count()];
        for h in 0..self.halfedge_count() {
            if self.halfedge_faces[h] == NONE {
                let h = HalfedgeId::from(h);
                let next = leaving[self.tip(h).index()];
                self.halfedge_nexts[h.index()] = HalfedgeId(next);
            }
        }
        for start in 0..self.halfedge_count() {
            if self.halfedge_faces[start] != NONE || seen[start] {
                continue;
            }
            self.loop_halfedges.push(HalfedgeId::from(start));
            let mut h = start;
            while !seen[h] {
                seen[h] = true;
                h = self.halfedge_nexts[h].index();
            }
        }
    }

    /// Every vertex must see all its corners in one turn.
    fn check_vertex_fans(&self) -> Result<(), MeshError> {
        let mut corners = vec![0u32; self.vertex_count()];
        for vertices in &self.face_vertices {
            for v in vertices {
                corners[v.index()] += 1;
            }
        }
        let vertices: Vec<VertexId> = self
            .vertices()
            .filter(|&v| {
                let fan = self.outgoing(v).filter(|&h| self.face(h).is_some()).count();
                fan != corners[v.index()] as usize
            })
            .collect();
        if vertices.is_empty() { Ok(()) } else { Err(MeshError::NonManifoldVertices { vertices }) }
    }

    /// Number of vertices, isolated ones included.
    #[inline]
    pub fn vertex_count(&self) -> usize {
        self.vertex_halfedges.len()
    }

    /// Number of halfedges, twice the edges.
    #[inline]
    pub fn halfedge_count(&self) -> usize {
        self.halfedge_tails.len()
    }

    /// Number of edges.
    #[inline]
    pub fn edge_count(&self) -> usize {
        self.halfedge_tails.len() / 2
    }

    /// Number of faces.
    #[inline]
    pub fn face_count(&self) -> usize {
        self.face_vertices.len()
    }

    /// All vertices.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = VertexId> + use<> {
        (0..self.vertex_count() as u32).map(VertexId)
    }

    /// All edges.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = EdgeId> + use<> {
        (0..self.edge_count() as u32).map(EdgeId)
    }

    /// All faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceId> + use<> {
        (0..self.face_count() as u32).map(FaceId)
    }

    /// All boundary loops, each by one of its halfedges (outside the surface).
    pub fn boundary_loops(&self) -> &[HalfedgeId] {
        &self.loop_halfedges
    }

    /// The halfedges of the boundary loop through `h`, starting there; the surface lies to their right.
    pub fn boundary_loop(&self, h: HalfedgeId) -> impl Iterator<Item = HalfedgeId> + '_ {
        let mut current = Some(h);
        std::iter::from_fn(move || {
            let result = current?;
            let next = self.next(result);
            current = (next != h).then_some(next);
            Some(result)
        })
    }

    /// Where a halfedge starts.
    #[inline]
    pub fn tail(&self, h: HalfedgeId) -> VertexId {
        self.halfedge_tails[h.index()]
    }

    /// Where a halfedge ends.
    #[inline]
    pub fn tip(&self, h: HalfedgeId) -> VertexId {
        self.halfedge_tails[h.twin().index()]
    }

    /// The following halfedge of the same face, or of the same boundary loop.
    #[inline]
    pub fn next(&self, h: HalfedgeId) -> HalfedgeId {
        self.halfedge_nexts[h.index()]
    }

    /// The preceding halfedge of the same face. Inside faces only.
    #[inline]
    pub fn prev(&self, h: HalfedgeId) -> HalfedgeId {
        debug_assert!(self.face(h).is_some());
        self.next(self.next(h))
    }

    /// The face on the left, none outside the boundary.
    #[inline]
    pub fn face(&self, h: HalfedgeId) -> Option<FaceId> {
        let face = self.halfedge_faces[h.index()];
        (face != NONE).then_some(FaceId(face))
    }

    /// The corners of a face, counter-clockwise.
    #[inline]
    pub fn face_vertices(&self, f: FaceId) -> [VertexId; 3] {
        self.face_vertices[f.index()]
    }

    /// The corners of all faces.
    pub fn triangles(&self) -> &[[VertexId; 3]] {
        &self.face_vertices
    }

    /// The halfedges of a face: number `i` leaves corner `i`.
    #[inline]
    pub fn face_halfedges(&self, f: FaceId) -> [HalfedgeId; 3] {
        self.face_halfedges[f.index()]
    }

    /// The end vertices of an edge.
    #[inline]
    pub fn edge_vertices(&self, e: EdgeId) -> [VertexId; 2] {
        let h = e.halfedge();
        [self.tail(h), self.tip(h)]
    }

    /// Whether only one face has this edge.
    #[inline]
    pub fn is_boundary_edge(&self, e: EdgeId) -> bool {
        let h = e.halfedge().index();
        self.halfedge_faces[h] == NONE || self.halfedge_faces[h ^ 1] == NONE
    }

    /// One halfedge that leaves the vertex; on the boundary the first of the fan. None for isolated vertices.
    #[inline]
    pub fn halfedge(&self, v: VertexId) -> Option<HalfedgeId> {
        let h = self.vertex_halfedges[v.index()];
        (h != NONE).then_some(HalfedgeId(h))
    }

    /// Whether the vertex lies on the boundary.
    #[inline]
    pub fn is_boundary_vertex(&self, v: VertexId) -> bool {
        self.halfedge(v).is_some_and(|h| self.face(h.twin()).is_none())
    }

    /// The halfedges that leave a vertex, counter-clockwise; on the boundary from one rim to the other.
    pub fn outgoing(&self, v: VertexId) -> impl Iterator<Item = HalfedgeId> + '_ {
        let first = self.halfedge(v);
        let mut current = first;
        std::iter::from_fn(move || {
            let h = current?;
            // Counter-clockwise: leave against the side of the face on the left that arrives here.
            current = match self.face(h) {
                Some(_) => Some(self.prev(h).twin()).filter(|&n| Some(n) != first),
                None => None,
            };
            Some(h)
        })
    }

    /// Components, boundary loops, Euler characteristic, genus. **Costs** O(V + F).
    pub fn topology(&self) -> Topology {
        let mut face_components = vec![NONE; self.face_count()];
        let mut components = 0usize;
        let mut stack = Vec::new();
        for seed in self.faces() {
            if face_components[seed.index()] != NONE {
                continue;
            }
            face_components[seed.index()] = components as u32;
            stack.push(seed);
            while let Some(f) = stack.pop() {
                for h in self.face_halfedges(f) {
                    if let Some(g) = self.face(h.twin())
                        && face_components[g.index()] == NONE
                    {
                        face_components[g.index()] = components as u32;
                        stack.push(g);
                    }
                }
            }
            components += 1;
        }
        let used = self.vertices().filter(|&v| self.halfedge(v).is_some()).count();
        let euler = used as i64 - self.edge_count() as i64 + self.face_count() as i64;
        let boundary_loops = self.loop_halfedges.len();
        // χ = Σ (2 − 2 g − b) over the components.
        let genus = (2 * components as i64 - boundary_loops as i64 - euler) / 2;
        Topology {
            face_components,
            components,
            boundary_loops,
            euler,
            genus: usize::try_from(genus).unwrap_or(0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tetrahedron_is_closed_and_every_turn_has_three_faces() {
        let mesh = Mesh::new(4, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).unwrap();
        assert_eq!((mesh.edge_count(), mesh.boundary_loops().len()), (6, 0));
        for v in mesh.vertices() {
            let turn: Vec<_> = mesh.outgoing(v).collect();
            assert_eq!(turn.len(), 3);
            assert!(turn.iter().all(|&h| mesh.tail(h) == v && !mesh.is_boundary_vertex(v)));
        }
        let topology = mesh.topology();
        assert_eq!((topology.components, topology.euler, topology.genus), (1, 2, 0));
    }

    #[test]
    fn a_square_has_one_loop_with_the_surface_on_the_right() {
        let mesh = Mesh::new(5, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let boundary = mesh.boundary_loops();
        assert_eq!(boundary.len(), 1);
        let around: Vec<u32> = mesh.boundary_loop(boundary[0]).map(|h| mesh.tail(h).0).collect();
        assert_eq!(around.len(), 4);
        let at_two = around.iter().position(|&v| v == 2).unwrap();
        assert_eq!(around[(at_two + 1) % 4], 1, "clockwise");
        assert!(mesh.is_boundary_vertex(VertexId(0)) && mesh.halfedge(VertexId(4)).is_none());
        assert_eq!(
            mesh.outgoing(VertexId(0)).map(|h| mesh.tip(h).0).collect::<Vec<_>>(),
            [1, 2, 3]
        );
    }

    #[test]
    fn defects_are_named_by_their_ids() {
        let edge = Mesh::new(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert_eq!(
            edge,
            Err(MeshError::NonManifoldEdges {
                edges: vec![[VertexId(0), VertexId(1)]],
                faces: vec![FaceId(0), FaceId(1), FaceId(2)],
            })
        );
        let bow_tie = Mesh::new(5, &[[0, 1, 2], [0, 3, 4]]);
        assert_eq!(bow_tie, Err(MeshError::NonManifoldVertices { vertices: vec![VertexId(0)] }));
        let twisted = Mesh::new(4, &[[0, 1, 2], [0, 1, 3]]);
        assert_eq!(
            twisted,
            Err(MeshError::InconsistentOrientation { edges: vec![[VertexId(0), VertexId(1)]] })
        );
        let repeated = Mesh::new(3, &[[0, 1, 2], [0, 0, 2]]);
        assert_eq!(repeated, Err(MeshError::RepeatedVertices { faces: vec![FaceId(1)] }));
        assert_eq!(Mesh::new(3, &[]), Err(MeshError::NoFaces));
    }
}
