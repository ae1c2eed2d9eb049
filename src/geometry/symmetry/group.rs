//! The group that symmetries generate, and where each of its elements maps the vertices of a surface.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use super::fit::Shape;
use super::{Symmetry, SymmetryKind};
use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh, VertexId};

/// Matrices closer than this (Frobenius) are one element: turns of 4°. Products of fitted generators differ by a degree; turns
/// of an axis of order 80 by 4.5°.
const SAME: f64 = 0.1;

/// How far planes and axes may miss their common point, over the diameter: fitted ones miss it by their deviation.
const MISS: f64 = 0.03;

/// Barycentric weight above which an image is a vertex.
const AT_VERTEX: f64 = 1.0 - 1e-6;

/// Why symmetries make no group to work with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SymmetryError {
    /// No generators.
    #[error("there are no symmetries to make a group of")]
    None,
    /// A generator without a direction, or with an order below 2.
    #[error("symmetry {generator} has no direction or an order below 2")]
    Malformed {
        /// Its place in the list.
        generator: usize,
    },
    /// The planes and axes do not pass through one point.
    #[error("the planes and axes do not meet: number {generator} misses the others by {distance}")]
    NoCentre {
        /// The one that misses most.
        generator: usize,
        /// By how much, in the unit of the geometry.
        distance: f64,
    },
    /// Symmetries at odd angles generate many or infinitely many.
    #[error("together the symmetries make more than {most} ways to map the surface to itself")]
    TooLarge {
        /// What was allowed.
        most: usize,
    },
}

/// One element of a group with the images of all vertices.
#[derive(Clone, Debug)]
pub struct SymmetryMap {
    /// The orthogonal matrix: reflections and odd products of them have determinant −1.
    pub matrix: Matrix3<f64>,
    /// The point that stays.
    pub centre: Point3<f64>,
    images: Vec<([VertexId; 3], [f64; 3])>,
}

impl SymmetryMap {
    /// Where a vertex is mapped: the corners of a face and its weights there, one of them 1 where the image is a vertex.
    pub fn image(&self, v: VertexId) -> ([VertexId; 3], [f64; 3]) {
        self.images[v.index()]
    }

    /// A function of the vertices, interpolated at the image of a vertex: f(S v).
    pub fn pull(&self, values: &[f64], v: VertexId) -> f64 {
        let (corners, weights) = self.image(v);
        (0..3).map(|i| values[corners[i].index()] * weights[i]).sum()
    }

    /// The product of two that map vertices to vertices: first `first`, then this one.
    fn after(&self, first: &Self, matrix: Matrix3<f64>) -> Self {
        let then = |(corners, weights): &([VertexId; 3], [f64; 3])| {
            let at = weights.iter().position(|w| *w >= 1.0).unwrap_or(0);
            self.images[corners[at].index()]
        };
        let images = first.images.iter().map(then).collect();
        Self { matrix, centre: self.centre, images }
    }

    /// Whether the images of all vertices are vertices.
    pub fn is_exact(&self) -> bool {
        self.images.iter().all(|(_, weights)| weights.iter().any(|w| *w >= 1.0))
    }
}

/// All products of some symmetries, without the identity, each with the images of the vertices.
///
/// **Takes** planes and axes through a common point, and the largest group allowed, identity counted: 120 is the icosahedron's.
/// **Gives** generators first, then products in the order of their length. **Fails** where planes and axes miss each other by
/// more than 3 % of the diameter, or the group is larger. **Costs** O(V log F) an element.
pub fn symmetry_group(
    mesh: &Mesh,
    geometry: &Geometry,
    generators: &[Symmetry],
    most: usize,
) -> Result<Vec<SymmetryMap>, SymmetryError> {
    let is_malformed = |s: &Symmetry| {
        let is_turn = !matches!(s.kind, SymmetryKind::Rotation { order: 0 | 1 });
        let place_is_finite = s.point.iter().all(|x| x.is_finite());
        !((s.direction.norm() - 1.0).abs() < 1e-6 && is_turn && place_is_finite)
    };
    if let Some(generator) = generators.iter().position(is_malformed) {
        return Err(SymmetryError::Malformed { generator });
    }
    let Some(shape) = Shape::new(mesh, geometry).filter(|_| !generators.is_empty()) else {
        return Err(SymmetryError::None);
    };
    let centre = common_point(&shape, generators)?;
    let mut maps: Vec<SymmetryMap> = Vec::new();
    for element in closure(generators, most)? {
        let exact = |i: usize| maps.get(i).filter(|map| map.is_exact());
        let map = match element.factors.map(|[a, b]| (exact(a), exact(b))) {
            // Permutations of the vertices need no search.
            Some((Some(a), Some(b))) => a.after(b, element.matrix),
            _ => correspond(mesh, &shape, element.matrix, centre),
        };
        maps.push(map);
    }
    Ok(maps)
}

/// The point nearest to all planes and axes; where these leave it free, the nearest such one to the centroid.
fn common_point(shape: &Shape, generators: &[Symmetry]) -> Result<Point3<f64>, SymmetryError> {
    // What keeps only the offset that a plane or axis cares about.
    let across = |s: &Symmetry| {
        let along = s.direction * s.direction.transpose();
        if s.kind == SymmetryKind::Mirror { along } else { Matrix3::identity() - along }
    };
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for s in generators {
        matrix += across(s);
        right += across(s) * (s.point - shape.centre);
    }
    let eigen = SymmetricEigen::new(matrix);
    let mut offset = Vector3::zeros();
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        // Planes that differ by a degree or two are meant to be one: no point far away where they meet.
        if *value > 1e-3 {
            offset += vector * (vector.dot(&right) / value);
        }
    }
    let centre = shape.centre + offset;
    let mut worst = (0, 0.0);
    for (i, s) in generators.iter().enumerate() {
        let distance = (across(s) * (s.point - centre)).norm();
        if distance > worst.1 {
            worst = (i, distance);
        }
    }
    if worst.1 > MISS * shape.diameter {
        return Err(SymmetryError::NoCentre { generator: worst.0, distance: worst.1 });
    }
    Ok(centre)
}

/// An element of a group, and the two earlier ones whose product it is.
struct Element {
    matrix: Matrix3<f64>,
    factors: Option<[usize; 2]>,
}

/// The products of matrices, generators first, without the identity.
fn closure(generators: &[Symmetry], most: usize) -> Result<Vec<Element>, SymmetryError> {
    let mut elements: Vec<Element> = Vec::new();
    let add = |element: Element, elements: &mut Vec<Element>| {
        let is_near = |m: &Matrix3<f64>| (m - element.matrix).norm() < SAME;
        if is_near(&Matrix3::identity()) || elements.iter().any(|e| is_near(&e.matrix)) {
            return Ok(());
        }
        elements.push(element);
        // The identity is not in the list.
        if elements.len() < most { Ok(()) } else { Err(SymmetryError::TooLarge { most }) }
    };
    for s in generators {
        add(Element { matrix: s.matrix(), factors: None }, &mut elements)?;
    }
    let count = elements.len();
    let mut next = 0;
    while next < elements.len() {
        for i in 0..count {
            let matrix = elements[i].matrix * elements[next].matrix;
            add(Element { matrix, factors: Some([i, next]) }, &mut elements)?;
        }
        next += 1;
    }
    Ok(elements)
}

/// Images of all vertices.
fn correspond(
    mesh: &Mesh,
    shape: &Shape,
    matrix: Matrix3<f64>,
    centre: Point3<f64>,
) -> SymmetryMap {
    let mut faces: Vec<Option<FaceId>> = vec![None; mesh.vertex_count()];
    let mut images = Vec::with_capacity(mesh.vertex_count());
    for v in mesh.vertices() {
        // Neighbours have their images near each other.
        let hint = mesh.outgoing(v).find_map(|h| faces[mesh.tip(h).index()]);
        // Isolated vertices have no image; they stay.
        let hit = mesh.halfedge(v).and_then(|_| shape.image(v, &matrix, centre, hint));
        images.push(match hit {
            Some(hit) => {
                faces[v.index()] = Some(hit.face);
                let is_vertex = hit.weights.iter().position(|w| *w > AT_VERTEX);
                let weights = match is_vertex {
                    Some(at) => [0, 1, 2].map(|i| if i == at { 1.0 } else { 0.0 }),
                    None => hit.weights,
                };
                (mesh.face_vertices(hit.face), weights)
            }
            None => ([v; 3], [1.0, 0.0, 0.0]),
        });
    }
    SymmetryMap { matrix, centre, images }
}
