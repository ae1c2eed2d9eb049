//! Triangles on the zero level of a function, cut off at walls and mirrored.
//!
//! The function is sampled on a grid of cubes, each cube split into six tetrahedra; so the surface between negative
//! and other corners is a manifold whatever the function does. Walls cut it open, [`super::remesh`] makes its triangles
//! even, and mirrors complete it.
//!
//! Guaranteed: with functions made of + − × ÷ and √ alone, the result has the same bits on all targets. Not guaranteed:
//! that parts thinner than a grid cell are found, and the topology of a surface that closes in on itself within one.

use nalgebra::Vector3;

use super::grids::{Vertices, to_u32};
use super::remesh::Patch;
use crate::mesh::Soup;

/// A function over space, negative inside, with a gradient near its zero level. A distance is best.
pub(super) type Field<'a> = &'a dyn Fn(Vector3<f64>) -> f64;

/// The part of a zero level where all walls are negative.
pub(super) struct Shape<'a> {
    /// The surface is where this is zero.
    pub field: Field<'a>,
    /// What cuts the surface open, eight at most.
    pub walls: &'a [Field<'a>],
    /// The box to look in: its middle and half its sides.
    pub bounds: [[f64; 3]; 2],
}

impl Shape<'_> {
    /// Even triangles with edges of about `step`.
    pub(super) fn triangulate(&self, step: f64) -> Patch {
        // Cells of 1.7 steps give nearly as many vertices as are wanted in the end.
        let mut patch = self.extract(1.7 * step);
        for wall in 0..self.walls.len() {
            patch = self.cut(&patch, wall);
        }
        patch.remesh(step, &|p, walls| self.project(p, walls));
        patch
    }

    /// The point of the zero level, and of the walls given as bits, that Newton steps lead to.
    fn project(&self, mut p: Vector3<f64>, walls: u8) -> Vector3<f64> {
        // One function converges at once; several, which take turns, by the angle between them.
        let rounds = if walls == 0 { 2 } else { 6 };
        for _ in 0..rounds {
            p = newton(self.field, p);
            for (i, wall) in self.walls.iter().enumerate() {
                if walls >> i & 1 == 1 {
                    p = newton(wall, p);
                }
            }
        }
        p
    }

    fn extract(&self, cell: f64) -> Patch {
        let [middle, half] = self.bounds.map(Vector3::from);
        let counts: [u32; 3] = std::array::from_fn(|a| {
            (1..).find(|&n| f64::from(n) * cell > 2.0 * half[a]).unwrap_or(1) + 1
        });
        let [row, layer] = [counts[0], counts[0] * counts[1]];
        let place = |node: u32| {
            let [i, j, k] = [node % row, node % layer / row, node / layer].map(f64::from);
            middle - half + Vector3::new(i, j, k) * cell
        };
        let values: Vec<f64> =
            (0..layer * counts[2]).map(|node| (self.field)(place(node))).collect();
        let is_inside = |node: u32| values[node as usize] < 0.0;
        let mut vertices = Vertices::default();
        let mut faces = Vec::new();
        let mut on = |a: u32, b: u32| {
            vertices.at([a.min(b), a.max(b)], || {
                let [x, y] = [a, b].map(|node| values[node as usize]);
                between(place(a), place(b), x, y)
            })
        };
        for node in 0..layer * counts[2] {
            let cube = [node % row, node % layer / row, node / layer];
            if (0..3).any(|a| cube[a] + 1 == counts[a]) {
                continue;
            }
            for (x, y, z) in [(1, row, layer), (row, layer, 1), (layer, 1, row)] {
                // Three ways along the edges of the cube to its far corner, and the same with two steps swapped,
                // which turns the tetrahedron inside out.
                for (x, y, is_turned) in [(x, y, false), (y, x, true)] {
                    let mut corners = [node, node + x, node + x + y, node + x + y + z];
                    if is_turned {
                        corners.swap(2, 3);
                    }
                    let outer: Vec<usize> = (0..4).filter(|&i| !is_inside(corners[i])).collect();
                    for face in separating(&outer) {
                        faces.push(face.map(|[i, j]| on(corners[i], corners[j])));
                    }
                }
            }
        }
        let positions: Vec<_> = vertices.positions.into_iter().map(Vector3::from).collect();
        let walls = vec![0; positions.len()];
        Patch::new(positions, walls, faces)
    }

    /// The part of a patch where a wall is negative.
    fn cut(&self, patch: &Patch, wall: usize) -> Patch {
        let values: Vec<f64> = patch.positions.iter().map(|&p| self.walls[wall](p)).collect();
        let mut walls: Vec<u8> = Vec::new();
        let mut vertices = Vertices::default();
        let mut faces = Vec::new();
        let mut on = |a: u32, b: u32| {
            let [i, j] = [a.min(b), a.max(b)].map(|v| v as usize);
            let [p, q] = [i, j].map(|v| patch.positions[v]);
            let is_cut = i != j;
            let v = vertices
                .at([i, j], || if is_cut { between(p, q, values[i], values[j]) } else { p });
            if v as usize == walls.len() {
                let new = if is_cut { 1 << wall } else { 0 };
                walls.push(patch.walls[i] & patch.walls[j] | new);
            }
            v
        };
        for &face in &patch.faces {
            let is_kept = face.map(|v| values[v as usize] < 0.0);
            // Turned so that the odd one comes first.
            let odd = (0..3).find(|&i| {
                is_kept[i] != is_kept[(i + 1) % 3] && is_kept[i] != is_kept[(i + 2) % 3]
            });
            let Some(odd) = odd else {
                if is_kept[0] {
                    faces.push(face.map(|v| on(v, v)));
                }
                continue;
            };
            let [a, b, c] = [0, 1, 2].map(|i| face[(odd + i) % 3]);
            if is_kept[odd] {
                faces.push([on(a, a), on(a, b), on(a, c)]);
            } else {
                faces.push([on(a, b), on(b, b), on(c, c)]);
                faces.push([on(a, b), on(c, c), on(a, c)]);
            }
        }
        let positions = vertices.positions.into_iter().map(Vector3::from).collect();
        Patch::new(positions, walls, faces)
    }
}

impl Patch {
    /// Adds the mirror image across the plane where coordinate `axis` is 0, joined at the vertices of the wall of that
    /// number.
    pub(super) fn mirror(mut self, axis: usize, wall: usize) -> Self {
        let mut image = Vec::new();
        for v in 0..self.positions.len() {
            if self.walls[v] >> wall & 1 == 1 {
                self.positions[v][axis] = 0.0;
                image.push(to_u32(v));
            } else {
                image.push(to_u32(self.positions.len()));
                let mut p = self.positions[v];
                p[axis] = -p[axis];
                self.positions.push(p);
                self.walls.push(self.walls[v]);
            }
        }
        for f in 0..self.faces.len() {
            let [a, b, c] = self.faces[f].map(|v| image[v as usize]);
            self.faces.push([a, c, b]);
        }
        self
    }

    /// The surface as a soup.
    pub(super) fn into_soup(self) -> Soup {
        let positions = self.positions.into_iter().map(<[f64; 3]>::from).collect();
        Soup::from_triangles(positions, &self.faces)
    }
}

/// The triangles between the corners of a tetrahedron that are outside and the others, each vertex on the edge
/// between two corners; towards the outer corners if the tetrahedron is right-handed.
fn separating(outer: &[usize]) -> Vec<[[usize; 2]; 3]> {
    // The other three corners of a right-handed tetrahedron, counter-clockwise seen from corner i.
    const OTHERS: [[usize; 3]; 4] = [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]];
    match *outer {
        [i] => vec![OTHERS[i].map(|j| [i, j])],
        [i, j] => {
            // The two that are not i and j, in the order that they have about i after j.
            let from = OTHERS[i].iter().position(|&k| k == j).unwrap_or(0);
            let [k, l] = [1, 2].map(|step| OTHERS[i][(from + step) % 3]);
            vec![[[i, k], [i, l], [j, l]], [[i, k], [j, l], [j, k]]]
        }
        [i, j, k] => {
            let inner = 6 - i - j - k;
            let [a, b, c] = OTHERS[inner].map(|j| [inner, j]);
            vec![[a, c, b]]
        }
        _ => Vec::new(),
    }
}

/// The zero between two points with values of different sign, kept off the ends by a quarter: no triangle is thin
/// from the start, and projecting brings the point to its place.
fn between(p: Vector3<f64>, q: Vector3<f64>, x: f64, y: f64) -> Vector3<f64> {
    let t = (x / (x - y)).clamp(0.25, 0.75);
    p + (q - p) * t
}

/// One Newton step towards the zero level, 0.1 long at most.
fn newton(field: Field, p: Vector3<f64>) -> Vector3<f64> {
    // Differences over a tetrahedron: four values give the gradient and, as their mean, the value. Shorter differences
    // lose digits, longer ones blur: 1e-4 of the size of a shape leaves errors near 1e-8.
    const REACH: f64 = 1e-4;
    let ways = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let (mut value, mut gradient) = (0.0, Vector3::zeros());
    for way in ways.map(Vector3::from) {
        let v = field(p + way * REACH);
        value += v / 4.0;
        gradient += way * (v / (4.0 * REACH));
    }
    let step = gradient * (value / gradient.norm_squared().max(1e-6));
    p - step * (0.1 / step.norm().max(0.1))
}
