//! Makes the triangles of a surface even: long edges are split, short ones collapsed, others flipped, vertices moved
//! along the surface.
//!
//! Guaranteed: the surface stays an oriented manifold with the topology it had, and the result is the same each time
//! (edges are taken in the order of their vertex numbers). Angles are good in practice, not by proof: the tests of the
//! samples measure them.
//!
//! From: Botsch, Kobbelt: *A Remeshing Approach to Multiresolution Modeling*, 2004, §4.

use nalgebra::Vector3;

use super::grids::to_u32;

/// Brings a point back onto the surface; the second argument tells on which walls it stands.
pub(super) type Project<'a> = &'a dyn Fn(Vector3<f64>, u8) -> Vector3<f64>;

/// A triangulated surface under change.
pub(super) struct Patch {
    /// Places of the vertices.
    pub positions: Vec<Vector3<f64>>,
    /// For each vertex a bit for each wall that it stands on. A boundary vertex stands on one at least, a corner of
    /// the boundary on two.
    pub walls: Vec<u8>,
    /// Triangles; `GONE` where one was removed while remeshing.
    pub faces: Vec<[u32; 3]>,
    /// For each vertex the triangles about it, in no order; empty but while remeshing.
    around: Vec<Vec<u32>>,
}

const GONE: [u32; 3] = [u32::MAX; 3];

/// Rounds of splitting, collapsing, flipping and moving, then rounds of flipping and moving alone. With fewer than six
/// of the first the grid that the surface was cut from still shows; more than ten of either change nothing to see.
const ROUNDS: usize = 8;
const LAST_ROUNDS: usize = 6;

impl Patch {
    /// A surface of these triangles.
    pub(super) fn new(positions: Vec<Vector3<f64>>, walls: Vec<u8>, faces: Vec<[u32; 3]>) -> Self {
        Self { positions, walls, faces, around: Vec::new() }
    }

    /// Even triangles with edges of about `step`, all vertices brought onto the surface.
    pub(super) fn remesh(&mut self, step: f64, project: Project) {
        self.around = vec![Vec::new(); self.positions.len()];
        for (f, face) in self.faces.iter().enumerate() {
            face.iter().for_each(|&v| self.around[v as usize].push(to_u32(f)));
        }
        for _ in 0..ROUNDS {
            self.split_long(4.0 / 3.0 * step, project);
            self.collapse_short(4.0 / 5.0 * step, 4.0 / 3.0 * step, project);
            self.flip_towards(|patch, edge, apexes| patch.valences_gain(edge, apexes));
            self.relax(project);
        }
        for _ in 0..LAST_ROUNDS {
            self.flip_towards(Self::is_not_delaunay);
            self.relax(project);
        }
        self.flip_towards(Self::is_not_delaunay);
        self.compact();
    }

    fn at(&self, v: u32) -> Vector3<f64> {
        self.positions[v as usize]
    }

    /// All edges, lower vertex first.
    fn edges(&self) -> Vec<[u32; 2]> {
        let live = self.faces.iter().filter(|&&face| face != GONE);
        let mut edges: Vec<_> = live
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The triangles at an edge, each with its third vertex: first the one that runs from `a` to `b`. None where there
    /// is no such edge.
    fn sides(&self, a: u32, b: u32) -> [Option<(u32, u32)>; 2] {
        let mut sides = [None, None];
        for &f in &self.around[a as usize] {
            let face = self.faces[f as usize];
            for i in 0..3 {
                let third = face[(i + 2) % 3];
                match [face[i], face[(i + 1) % 3]] {
                    way if way == [a, b] => sides[0] = Some((f, third)),
                    way if way == [b, a] => sides[1] = Some((f, third)),
                    _ => {}
                }
            }
        }
        sides
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let faces = self.around[v as usize].iter().flat_map(|&f| self.faces[f as usize]);
        let mut neighbours: Vec<u32> = faces.filter(|&w| w != v).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// Twice the area times the unit normal.
    fn normal(&self, [a, b, c]: [u32; 3]) -> Vector3<f64> {
        (self.at(b) - self.at(a)).cross(&(self.at(c) - self.at(a)))
    }

    fn replace(&mut self, f: u32, face: [u32; 3]) {
        for v in self.faces[f as usize] {
            if v != u32::MAX && !face.contains(&v) {
                self.around[v as usize].retain(|&g| g != f);
            }
        }
        for v in face {
            if v != u32::MAX && !self.around[v as usize].contains(&f) {
                self.around[v as usize].push(f);
            }
        }
        self.faces[f as usize] = face;
    }

    fn split_long(&mut self, longest: f64, project: Project) {
        for [a, b] in self.edges() {
            if (self.at(a) - self.at(b)).norm() <= longest {
                continue;
            }
            let sides = self.sides(a, b);
            let on_boundary = sides.iter().any(Option::is_none);
            let walls =
                if on_boundary { self.walls[a as usize] & self.walls[b as usize] } else { 0 };
            let middle = to_u32(self.positions.len());
            self.positions.push(project((self.at(a) + self.at(b)) / 2.0, walls));
            self.walls.push(walls);
            self.around.push(Vec::new());
            for (f, _) in sides.into_iter().flatten() {
                let face = self.faces[f as usize];
                let new = to_u32(self.faces.len());
                self.faces.push(GONE);
                self.replace(f, face.map(|v| if v == b { middle } else { v }));
                self.replace(new, face.map(|v| if v == a { middle } else { v }));
            }
        }
    }

    /// Collapses edges shorter than `shortest` where that keeps the topology, folds nothing over, and makes no edge
    /// longer than `longest`.
    fn collapse_short(&mut self, shortest: f64, longest: f64, project: Project) {
        for [a, b] in self.edges() {
            let sides = self.sides(a, b);
            let count = sides.iter().flatten().count();
            if count == 0 || (self.at(a) - self.at(b)).norm() >= shortest {
                continue;
            }
            let [at_a, at_b] = [a, b].map(|v| self.walls[v as usize]);
            // The vertex that stays stands on all walls of both; an inner edge must not join two boundary vertices.
            let (stay, go) = if at_b & !at_a == 0 { (a, b) } else { (b, a) };
            let [walls, lost] = [stay, go].map(|v| self.walls[v as usize]);
            if lost & !walls != 0 || lost != 0 && count == 2 {
                continue;
            }
            let place = if walls == lost {
                project((self.at(a) + self.at(b)) / 2.0, walls)
            } else {
                self.at(stay)
            };
            let [near_stay, near_go] = [stay, go].map(|v| self.neighbours(v));
            let shared = near_stay.iter().filter(|v| near_go.contains(v)).count();
            let is_long =
                near_stay.iter().chain(&near_go).any(|&v| (self.at(v) - place).norm() > longest);
            if shared != count || is_long || self.folds([stay, go], place) {
                continue;
            }
            self.positions[stay as usize] = place;
            for f in self.around[go as usize].clone() {
                let face = self.faces[f as usize];
                let new = if face.contains(&stay) {
                    GONE
                } else {
                    face.map(|v| if v == go { stay } else { v })
                };
                self.replace(f, new);
            }
        }
    }

    /// Whether a triangle turns by more than about 60 degrees when the ends of an edge are moved to `place`.
    fn folds(&self, ends: [u32; 2], place: Vector3<f64>) -> bool {
        let faces = ends.iter().flat_map(|&v| &self.around[v as usize]);
        faces.map(|&f| self.faces[f as usize]).any(|face| {
            let moved = face.iter().filter(|v| ends.contains(v)).count();
            let [a, b, c] = face.map(|v| if ends.contains(&v) { place } else { self.at(v) });
            let (before, after) = (self.normal(face), (b - a).cross(&(c - a)));
            moved == 1 && before.dot(&after) < 0.5 * before.norm() * after.norm()
        })
    }

    /// Flips the edges for which `gains` says so, where the new edge is new and nothing folds over. `gains` gets the
    /// ends of the edge and the vertices across.
    fn flip_towards(&mut self, gains: impl Fn(&Self, [u32; 2], [u32; 2]) -> bool) {
        for [a, b] in self.edges() {
            let [Some((f, c)), Some((g, d))] = self.sides(a, b) else { continue };
            let is_new = || self.sides(c, d) == [None, None];
            if !gains(self, [a, b], [c, d]) || !is_new() {
                continue;
            }
            let before = self.normal([a, b, c]) + self.normal([b, a, d]);
            let after = [[a, d, c], [b, c, d]];
            let is_flat = |&face: &[u32; 3]| {
                let normal = self.normal(face);
                normal.dot(&before) > 0.8 * normal.norm() * before.norm()
            };
            if after.iter().all(is_flat) {
                self.replace(f, after[0]);
                self.replace(g, after[1]);
            }
        }
    }

    /// Whether a flip brings valences closer to 6, or 4 at the boundary.
    fn valences_gain(&self, edge: [u32; 2], apexes: [u32; 2]) -> bool {
        let off = |v: u32, gained: usize, lost: usize| {
            // At the boundary there are three triangles for four edges.
            let full = if self.walls[v as usize] == 0 { 6 } else { 3 };
            (self.around[v as usize].len() + gained).abs_diff(full + lost).pow(2)
        };
        let sum = |gained: usize, lost: usize| {
            let [at_edge, across] =
                [edge.map(|v| off(v, 0, lost)), apexes.map(|v| off(v, gained, 0))];
            at_edge.iter().chain(&across).sum::<usize>()
        };
        sum(1, 1) < sum(0, 0)
    }

    /// Whether the angles across an edge add up to more than π: their cotangents to less than 0. The small margin
    /// keeps edges of squares from being flipped back and forth.
    fn is_not_delaunay(&self, [a, b]: [u32; 2], apexes: [u32; 2]) -> bool {
        let cotangent = |apex: u32| {
            let (u, v) = (self.at(a) - self.at(apex), self.at(b) - self.at(apex));
            u.dot(&v) / u.cross(&v).norm()
        };
        apexes.map(cotangent).iter().sum::<f64>() < -1e-6
    }

    /// Moves each vertex along the surface to the centroid of the triangles about it, and boundary vertices along the
    /// boundary between their neighbours.
    fn relax(&mut self, project: Project) {
        for v in 0..to_u32(self.positions.len()) {
            let (here, walls) = (self.at(v), self.walls[v as usize]);
            if self.around[v as usize].is_empty() {
                continue;
            }
            let target = if walls.count_ones() > 1 {
                here
            } else if walls == 0 {
                let (mut sum, mut area, mut normal) = (Vector3::zeros(), 0.0, Vector3::zeros());
                for &f in &self.around[v as usize] {
                    let face = self.faces[f as usize];
                    let cross = self.normal(face);
                    let [a, b, c] = face.map(|w| self.at(w));
                    sum += (a + b + c) * (cross.norm() / 3.0);
                    area += cross.norm();
                    normal += cross;
                }
                let way = sum / area - here;
                here + way - normal * (normal.dot(&way) / normal.norm_squared())
            } else {
                let near = self.neighbours(v);
                let rim = near.iter().filter(|&&w| self.sides(v, w).contains(&None));
                rim.map(|&w| self.at(w)).sum::<Vector3<f64>>() / 2.0
            };
            self.positions[v as usize] = project(target, walls);
        }
    }

    /// Drops removed triangles and vertices without triangles.
    fn compact(&mut self) {
        let mut number = vec![u32::MAX; self.positions.len()];
        let mut kept = 0;
        for v in 0..self.positions.len() {
            if !self.around[v].is_empty() {
                number[v] = to_u32(kept);
                self.positions[kept] = self.positions[v];
                self.walls[kept] = self.walls[v];
                kept += 1;
            }
        }
        self.positions.truncate(kept);
        self.walls.truncate(kept);
        self.around.clear();
        self.faces.retain(|&face| face != GONE);
        self.faces.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
    }
}
