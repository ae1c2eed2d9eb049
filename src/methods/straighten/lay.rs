//! Curves that are told by their points, laid into a mesh.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::flat::{Flat, Place};
use super::network::Network;
use super::refine::refine;
use crate::geometry::Geometry;
use crate::mesh::{CutMesh, EdgeId, FaceId, Mesh, SurfacePoint};

/// The mesh refined along straight pieces of curves, which become its cut.
///
/// **Takes** different places on the mesh, and pieces as pairs of them, each within one face or along an edge. **Gives** nothing where
/// two places of a piece have no face in common, or where pieces cross, lie in a face without reaching its sides, or are so close that
/// it cannot be divided between them. Places on edges are rounded to 2⁻⁴⁰ of the edge, where those of [`super::straighten`] are already.
pub fn cut_along(
    mesh: &Mesh,
    geometry: &Geometry,
    places: &[SurfacePoint],
    pieces: &[[u32; 2]],
) -> Option<CutMesh> {
    let flat = Flat::new(mesh, geometry);
    let mut net = Network::empty(flat);
    for &place in places {
        let place = match place {
            SurfacePoint::Vertex(v) => Place::Vertex(v),
            SurfacePoint::Edge(e, t) => Place::Edge(e, t),
            SurfacePoint::Face(f, weights) => Place::Face(f, net.flat.place_of_weights(f, weights)),
        };
        net.add_node(place);
    }
    let mut along: Vec<(EdgeId, [u32; 2])> = Vec::new();
    let mut pieces: Vec<[u32; 2]> =
        pieces.iter().map(|&[a, b]| [a.min(b), a.max(b)]).filter(|[a, b]| a != b).collect();
    pieces.sort_unstable();
    pieces.dedup();
    for ends in pieces {
        let [a, b] = ends.map(|n| places.get(n as usize).copied());
        let shared = common(mesh, a?, b?);
        match shared {
            Common::Edge(e) => along.push((e, ends)),
            Common::Face(f) => net.add_segment(ends, f, false),
            Common::Nothing => return None,
        }
    }
    // Where each place on an edge comes among those on it: 0 is the tail.
    let order: Vec<Vec<u32>> = net.edge_nodes.clone();
    let (mut cut, _) = refine(&mut net)?;
    let mut numbers = Vec::with_capacity(places.len());
    let mut next = mesh.vertex_count() as u32;
    for place in places {
        numbers.push(match place {
            SurfacePoint::Vertex(v) => v.0,
            _ => {
                next += 1;
                next - 1
            }
        });
    }
    for (e, ends) in along {
        let [tail, tip] = mesh.edge_vertices(e);
        let row: Vec<u32> = std::iter::once(tail.0)
            .chain(order[e.index()].iter().map(|&n| numbers[n as usize]))
            .chain([tip.0])
            .collect();
        let [i, j] = ends.map(|n| row.iter().position(|&p| p == numbers[n as usize]));
        let (i, j) = (i?.min(j?), i?.max(j?));
        cut.cut_edges.extend(row[i..=j].windows(2).map(|pair| [pair[0], pair[1]]));
    }
    // A piece that hangs together with no side of its face has been passed over.
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut sides: Vec<[u32; 2]> =
        cut.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(sorted)).collect();
    sides.sort_unstable();
    let is_laid = |&ends: &[u32; 2]| sides.binary_search(&sorted(ends)).is_ok();
    cut.cut_edges.iter().all(is_laid).then_some(cut)
}

/// What two places have in common.
enum Common {
    Edge(EdgeId),
    Face(FaceId),
    Nothing,
}

fn common(mesh: &Mesh, a: SurfacePoint, b: SurfacePoint) -> Common {
    let touches = |p: SurfacePoint, e: EdgeId| match p {
        SurfacePoint::Vertex(v) => mesh.edge_vertices(e).contains(&v),
        SurfacePoint::Edge(own, _) => own == e,
        SurfacePoint::Face(..) => false,
    };
    let holds = |f: FaceId, p: SurfacePoint| match p {
        SurfacePoint::Vertex(v) => mesh.face_vertices(f).contains(&v),
        SurfacePoint::Edge(e, _) => mesh.face_halfedges(f).iter().any(|h| h.edge() == e),
        SurfacePoint::Face(own, _) => own == f,
    };
    let around: Vec<FaceId> = match a {
        SurfacePoint::Vertex(v) => {
            mesh.outgoing(v).flat_map(|h| [mesh.face(h), mesh.face(h.twin())]).flatten().collect()
        }
        SurfacePoint::Edge(e, _) => {
            let h = e.halfedge();
            [mesh.face(h), mesh.face(h.twin())].into_iter().flatten().collect()
        }
        SurfacePoint::Face(f, _) => vec![f],
    };
    for f in around {
        if !holds(f, b) {
            continue;
        }
        let sides = mesh.face_halfedges(f).map(|h| h.edge());
        return match sides.into_iter().find(|&e| touches(a, e) && touches(b, e)) {
            Some(e) => Common::Edge(e),
            None => Common::Face(f),
        };
    }
    Common::Nothing
}
