//! Cuts moved onto edges of the mesh: no new vertices.
//!
//! Every face belongs to the patch that holds most of it. Faces of a patch that do not hang together with most of it go to their
//! neighbours, and the staircase is smoothed: a face that meets another patch along two sides changes over to it, if that
//! changes no shape and the cut went through the face.
//!
//! Guaranteed: the cut runs along mesh edges; every patch keeps a face and hangs together, or is named as lost. Not guaranteed: that patches keep their number of
//! boundary loops (told); slits inside a patch are lost, because no two patches lie beside them.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use crate::geometry::Geometry;
use crate::mesh::{CutMesh, FaceId, Mesh, MeshError, SurfacePoint, VertexId};

const NONE: u32 = u32::MAX;

/// A cut along mesh edges.
#[derive(Clone, Debug)]
pub struct Snapped {
    /// The mesh, not refined, and the edges that are cut.
    pub cut: CutMesh,
    /// For each face its patch, by the numbers of the given cut opened.
    pub face_patches: Vec<u32>,
    /// Patches too narrow to hold most of any face: they have become parts of their neighbours.
    pub lost: Vec<u32>,
    /// Whether all patches have the Euler characteristics and boundary loops that they had.
    pub keeps_shapes: bool,
}

/// Moves a cut onto the edges of its mesh.
///
/// **Takes** a cut as a flow gives it, without the slits that make disks. **Gives** `points` = the mesh's vertices and nothing
/// else. Patches that no face can stand for are named in [`Snapped::lost`].
/// **Fails** if the given triangles are no manifold. **Costs** O(F) for each round of cleaning, of which there are few.
pub fn snap_to_edges(
    mesh: &Mesh,
    geometry: &Geometry,
    cut: &CutMesh,
) -> Result<Snapped, MeshError> {
    let opened = cut.open()?;
    let shares = shares(mesh, cut, &opened.face_patches);
    let mut labels: Vec<u32> = shares.iter().map(|list| list[0].0).collect();
    join_strays(mesh, geometry, &mut labels, opened.patch_count);
    smooth(mesh, geometry, &shares, &mut labels);
    join_strays(mesh, geometry, &mut labels, opened.patch_count);

    let mut snapped = CutMesh::uncut(mesh);
    for e in mesh.edges() {
        let h = e.halfedge();
        if let (Some(f), Some(g)) = (mesh.face(h), mesh.face(h.twin()))
            && labels[f.index()] != labels[g.index()]
        {
            snapped.cut_edges.push(mesh.edge_vertices(e).map(|v| v.0));
        }
    }
    let mut held = vec![false; opened.patch_count];
    for &l in &labels {
        held[l as usize] = true;
    }
    let lost = (0..opened.patch_count as u32).filter(|&l| !held[l as usize]).collect();
    let (mut before, mut after) = (opened.patch_shapes(), snapped.open()?.patch_shapes());
    before.sort_unstable();
    after.sort_unstable();
    let keeps_shapes = before == after;
    Ok(Snapped { cut: snapped, face_patches: labels, lost, keeps_shapes })
}

/// For each face the patches in it with their shares of its area, the largest first.
fn shares(mesh: &Mesh, cut: &CutMesh, patches: &[u32]) -> Vec<Vec<(u32, f64)>> {
    let mut shares: Vec<Vec<(u32, f64)>> = vec![Vec::new(); mesh.face_count()];
    for ((t, &f), &patch) in cut.triangles.iter().zip(&cut.triangle_faces).zip(patches) {
        let [a, b, c] = t.map(|p| weights(mesh, f, cut.points[p as usize]));
        let area = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
        let list = &mut shares[f.index()];
        match list.iter_mut().find(|s| s.0 == patch) {
            Some(share) => share.1 += area,
            None => list.push((patch, area)),
        }
    }
    for list in &mut shares {
        list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    }
    shares
}

/// Barycentric coordinates of a point in a face that holds it.
fn weights(mesh: &Mesh, f: FaceId, point: SurfacePoint) -> [f64; 3] {
    let corners = mesh.face_vertices(f);
    let mut weights = [0.0; 3];
    let mut add = |v: VertexId, w: f64| {
        if let Some(i) = corners.iter().position(|&c| c == v) {
            weights[i] += w;
        }
    };
    match point {
        SurfacePoint::Vertex(v) => add(v, 1.0),
        SurfacePoint::Edge(e, t) => {
            let [a, b] = mesh.edge_vertices(e);
            add(a, 1.0 - t);
            add(b, t);
        }
        SurfacePoint::Face(_, w) => return w,
    }
    weights
}

/// Gives all faces of a label but the largest bunch that hangs together to the neighbours that they share most length with.
fn join_strays(mesh: &Mesh, geometry: &Geometry, labels: &mut [u32], count: usize) {
    loop {
        let (bunches, mut sizes) = (bunches(mesh, labels), Vec::new());
        for (f, &b) in bunches.iter().enumerate() {
            sizes.resize(sizes.len().max(b as usize + 1), 0.0);
            sizes[b as usize] += geometry.face_areas[f];
        }
        let mut largest = vec![NONE; count];
        for (f, &b) in bunches.iter().enumerate() {
            let best = &mut largest[labels[f] as usize];
            if *best == NONE || sizes[b as usize] > sizes[*best as usize] {
                *best = b;
            }
        }
        // The smallest stray first, since it may complete others.
        let is_stray = |f: usize| largest[labels[f] as usize] != bunches[f];
        let stray = (0..labels.len()).filter(|&f| is_stray(f)).map(|f| bunches[f]);
        let Some(stray) =
            stray.min_by(|&a, &b| sizes[a as usize].total_cmp(&sizes[b as usize]).then(a.cmp(&b)))
        else {
            return;
        };
        let mut shared = vec![0.0; count];
        for f in mesh.faces().filter(|f| bunches[f.index()] == stray) {
            for h in mesh.face_halfedges(f) {
                if let Some(g) = mesh.face(h.twin()).filter(|g| bunches[g.index()] != stray) {
                    shared[labels[g.index()] as usize] += geometry.edge_length(h.edge());
                }
            }
        }
        let best = (0..count).max_by(|&a, &b| shared[a].total_cmp(&shared[b]).then(b.cmp(&a)));
        // A component of the surface of its own has no neighbour; it is a patch.
        let Some(best) = best.filter(|&b| shared[b] > 0.0) else { return };
        for (f, label) in labels.iter_mut().enumerate() {
            if bunches[f] == stray {
                *label = best as u32;
            }
        }
    }
}

/// Numbers the sets of faces of one label that hang together across edges.
fn bunches(mesh: &Mesh, labels: &[u32]) -> Vec<u32> {
    let mut bunches = vec![NONE; labels.len()];
    let mut count = 0;
    for seed in mesh.faces() {
        if bunches[seed.index()] != NONE {
            continue;
        }
        bunches[seed.index()] = count;
        let mut stack = vec![seed];
        while let Some(f) = stack.pop() {
            for h in mesh.face_halfedges(f) {
                if let Some(g) = mesh.face(h.twin())
                    && labels[g.index()] == labels[f.index()]
                    && bunches[g.index()] == NONE
                {
                    bunches[g.index()] = count;
                    stack.push(g);
                }
            }
        }
        count += 1;
    }
    bunches
}

/// Lets faces change over to the label across two of their sides.
fn smooth(mesh: &Mesh, geometry: &Geometry, shares: &[Vec<(u32, f64)>], labels: &mut [u32]) {
    // Each change shortens the cut, so that it ends by itself; the bound is for rounding.
    for _ in 0..10 {
        let mut has_changed = false;
        for f in mesh.faces().filter(|f| shares[f.index()].len() > 1) {
            has_changed |= change_over(mesh, geometry, shares, labels, f).is_some();
        }
        if !has_changed {
            return;
        }
    }
}

fn change_over(
    mesh: &Mesh,
    geometry: &Geometry,
    shares: &[Vec<(u32, f64)>],
    labels: &mut [u32],
    f: FaceId,
) -> Option<()> {
    let own = labels[f.index()];
    let halfedges = mesh.face_halfedges(f);
    let across = halfedges.map(|h| mesh.face(h.twin()).map(|g| labels[g.index()]));
    for i in 0..3 {
        // Sides i and i + 1 meet the other label, the third meets the own one.
        let (Some(a), Some(b), Some(c)) = (across[i], across[(i + 1) % 3], across[(i + 2) % 3])
        else {
            return None;
        };
        if a != b || a == own || c != own || !shares[f.index()].iter().any(|s| s.0 == a) {
            continue;
        }
        let side = |k: usize| geometry.edge_length(halfedges[k % 3].edge());
        // Around their common vertex all other faces must have the other label: it becomes an inner one of that patch.
        let v = mesh.tip(halfedges[i]);
        let is_inner = !mesh.is_boundary_vertex(v)
            && mesh
                .outgoing(v)
                .all(|h| mesh.face(h).is_some_and(|g| g == f || labels[g.index()] == a));
        if is_inner && side(i + 2) < side(i) + side(i + 1) {
            labels[f.index()] = a;
            return Some(());
        }
    }
    None
}
