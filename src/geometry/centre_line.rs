//! Centre lines of painted bands: the edges that someone who drew a stroke with a wide brush meant.
//!
//! Guaranteed: lines run along edges of the band; a band that closes around something gives a closed line around it, and two strokes that cross
//! give lines that cross; a band of single edges is its own line. Not guaranteed: lines as straight as geodesics, they have the mesh's edges to
//! run along; and where a stroke ends, to within its width.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::{GeodesicFront, Geometry};
use crate::mesh::{EdgeId, FaceId, HalfedgeId, Mesh, VertexId, chains};

/// How much longer than the band is deep a branch must be, or it leads from the line to the rim and no further.
const BRANCH: f64 = 1.5;
/// The same for a whole line and twice the depth: one dab is no stroke.
const STROKE: f64 = 1.5;
/// Mean edges that are added to the length of a twig, and that a line has at least.
const TWIG: f64 = 1.5;
const LEAST: f64 = 2.5;
/// What a place at the rim costs beside one in the middle.
const RIM: f64 = 3.0;

/// The lines in the middle of the bands that painted vertices make.
///
/// Triangles of the band are taken away from its rim inwards, always at the shallowest free edge, which changes no connection; what is
/// left are trees and loops. Twigs no longer than the band is wide are pruned, and what remains is pulled straight inside the band. From
/// loose ends lines go on to the nearest vertex that `is_goal` accepts, or to another line, where that is no further than half the
/// band is wide and `most` beyond.
///
/// **Takes** whether each vertex is painted. **Gives** edges in increasing order; none where everything is painted. **Costs**
/// about O(n log n) for n painted vertices.
pub fn centre_lines(
    mesh: &Mesh,
    geometry: &Geometry,
    is_painted: &[bool],
    is_goal: impl Fn(VertexId) -> bool,
    most: f64,
) -> Vec<EdgeId> {
    let mut band = Band::new(mesh, geometry, is_painted);
    band.thin();
    band.prune();
    let lines = band.straighten();
    let lines = band.trim(lines);
    band.reach(lines, is_goal, most)
}

/// Of each vertex on edges one that stands for all that they join it to.
fn components(mesh: &Mesh, edges: &[EdgeId]) -> Vec<Option<VertexId>> {
    let mut component = vec![None; mesh.vertex_count()];
    let mut is_line = vec![false; mesh.edge_count()];
    edges.iter().for_each(|e| is_line[e.index()] = true);
    let mut stack = Vec::new();
    for &start in edges {
        let [lowest, _] = mesh.edge_vertices(start);
        if component[lowest.index()].is_some() {
            continue;
        }
        component[lowest.index()] = Some(lowest);
        stack.push(lowest);
        while let Some(v) = stack.pop() {
            for h in mesh.outgoing(v).filter(|h| is_line[h.edge().index()]) {
                let tip = mesh.tip(h);
                if component[tip.index()].is_none() {
                    component[tip.index()] = Some(lowest);
                    stack.push(tip);
                }
            }
        }
    }
    component
}

/// The cheapest way along edges from a vertex to one that is wanted; none above `most`.
fn cheapest_way(
    mesh: &Mesh,
    from: VertexId,
    is_goal: impl Fn(VertexId) -> bool,
    cost: impl Fn(HalfedgeId) -> Option<f64>,
    most: f64,
) -> Option<Vec<EdgeId>> {
    // By vertex, the cost and the way that it came.
    let mut known = BTreeMap::from([(from, (0.0, None::<HalfedgeId>))]);
    let mut queue = BinaryHeap::from([Reverse((0u64, from))]);
    while let Some(Reverse((bits, v))) = queue.pop() {
        let so_far = f64::from_bits(bits);
        if so_far > known[&v].0 {
            continue;
        }
        if so_far > most {
            return None;
        }
        if is_goal(v) {
            let mut way = Vec::new();
            let mut at = v;
            while let Some(h) = known[&at].1 {
                way.push(h.edge());
                at = mesh.tail(h);
            }
            return Some(way);
        }
        for h in mesh.outgoing(v) {
            let Some(more) = cost(h) else { continue };
            let (tip, total) = (mesh.tip(h), so_far + more);
            if known.get(&tip).is_none_or(|&(old, _)| total < old) {
                known.insert(tip, (total, Some(h)));
                // Costs are not negative: their bits sort like their values.
                queue.push(Reverse((total.to_bits(), tip)));
            }
        }
    }
    None
}

/// What is painted, and what is left of it.
struct Band<'a> {
    mesh: &'a Mesh,
    geometry: &'a Geometry,
    /// Distance from the rim inside of the band, infinite elsewhere.
    depths: Vec<f64>,
    /// Edges that are left.
    is_left: Vec<bool>,
    /// Number of edges left at each vertex.
    degrees: Vec<u32>,
    mean_edge: f64,
}

impl<'a> Band<'a> {
    fn new(mesh: &'a Mesh, geometry: &'a Geometry, is_painted: &[bool]) -> Self {
        assert_eq!(is_painted.len(), mesh.vertex_count());
        let is_in = |v: VertexId| is_painted[v.index()];
        let rim: Vec<(VertexId, f64)> = mesh
            .vertices()
            .filter(|&v| is_in(v) && mesh.outgoing(v).any(|h| !is_in(mesh.tip(h))))
            .map(|v| (v, 0.0))
            .collect();
        let mut front = GeodesicFront::new(mesh.vertex_count());
        front.spread(mesh, geometry, &rim, |v, _| is_in(v));
        let depth = |v: VertexId| if is_in(v) { front.distance(v) } else { f64::INFINITY };
        let depths: Vec<f64> = mesh.vertices().map(depth).collect();
        let is_left: Vec<bool> = mesh
            .edges()
            .map(|e| mesh.edge_vertices(e).iter().all(|v| depths[v.index()].is_finite()))
            .collect();
        let mut degrees = vec![0; mesh.vertex_count()];
        for e in mesh.edges().filter(|e| is_left[e.index()]) {
            mesh.edge_vertices(e).iter().for_each(|v| degrees[v.index()] += 1);
        }
        Self { mesh, geometry, depths, is_left, degrees, mean_edge: geometry.mean_edge_length() }
    }

    fn depth(&self, v: VertexId) -> f64 {
        self.depths[v.index()]
    }

    fn remove(&mut self, e: EdgeId) {
        self.is_left[e.index()] = false;
        for v in self.mesh.edge_vertices(e) {
            self.degrees[v.index()] -= 1;
        }
    }

    fn left_at(&self, v: VertexId) -> impl Iterator<Item = HalfedgeId> + '_ {
        self.mesh.outgoing(v).filter(|h| self.is_left[h.edge().index()])
    }

    /// Takes triangles away together with a free edge each, until none is left.
    fn thin(&mut self) {
        let mesh = self.mesh;
        let is_whole = |f: FaceId| mesh.face_vertices(f).iter().all(|&v| self.depth(v).is_finite());
        let mut is_there: Vec<bool> = mesh.faces().map(is_whole).collect();
        let mut faces_at = vec![0u8; mesh.edge_count()];
        for f in mesh.faces().filter(|f| is_there[f.index()]) {
            mesh.face_halfedges(f).iter().for_each(|h| faces_at[h.edge().index()] += 1);
        }
        let key = |band: &Self, e: EdgeId| {
            let [a, b] = mesh.edge_vertices(e).map(|v| band.depth(v));
            // Not negative: bits sort like values.
            Reverse((a.min(b).to_bits(), a.max(b).to_bits(), e))
        };
        let mut queue: BinaryHeap<_> =
            mesh.edges().filter(|e| faces_at[e.index()] == 1).map(|e| key(self, e)).collect();
        while let Some(Reverse((_, _, e))) = queue.pop() {
            if faces_at[e.index()] != 1 {
                continue;
            }
            let sides = [e.halfedge(), e.halfedge().twin()].map(|h| mesh.face(h));
            let Some(f) = sides.into_iter().flatten().find(|f| is_there[f.index()]) else {
                continue;
            };
            is_there[f.index()] = false;
            self.remove(e);
            for h in mesh.face_halfedges(f) {
                let other = &mut faces_at[h.edge().index()];
                *other -= 1;
                if *other == 1 {
                    queue.push(key(self, h.edge()));
                }
            }
        }
    }

    /// Follows what is left from a vertex through others with two edges. **Gives** where that ends, and the edges.
    fn walk(&self, from: VertexId, first: HalfedgeId) -> (VertexId, Vec<EdgeId>) {
        let mut edges = vec![first.edge()];
        let mut h = first;
        loop {
            let v = self.mesh.tip(h);
            if v == from || self.degrees[v.index()] != 2 {
                return (v, edges);
            }
            let Some(next) = self.left_at(v).find(|next| next.edge() != h.edge()) else {
                return (v, edges);
            };
            edges.push(next.edge());
            h = next;
        }
    }

    fn length(&self, edges: &[EdgeId]) -> f64 {
        edges.iter().map(|&e| self.geometry.edge_length(e)).sum()
    }

    /// Removes twigs, the shortest first: when others at its fork are gone, what is left of a line is longer.
    fn prune(&mut self) {
        let mut queue = BinaryHeap::new();
        let from = |band: &Self, leaf: VertexId| {
            let first = band.left_at(leaf).next()?;
            let (end, edges) = band.walk(leaf, first);
            Some((band.length(&edges), end, edges))
        };
        for leaf in self.mesh.vertices().filter(|v| self.degrees[v.index()] == 1) {
            if let Some((length, ..)) = from(self, leaf) {
                queue.push(Reverse((length.to_bits(), leaf)));
            }
        }
        while let Some(Reverse((bits, leaf))) = queue.pop() {
            if self.degrees[leaf.index()] != 1 {
                continue;
            }
            let Some((length, end, edges)) = from(self, leaf) else { continue };
            if length.to_bits() != bits {
                // A fork has gone; it stands in the queue anew.
                continue;
            }
            let is_line = self.degrees[end.index()] == 1;
            let is_twig = if is_line {
                let deepest = edges.iter().flat_map(|&e| self.mesh.edge_vertices(e));
                let deepest = deepest.map(|v| self.depth(v)).fold(0.0, f64::max);
                length <= (2.0 * STROKE * deepest).max(LEAST * self.mean_edge)
            } else {
                length <= BRANCH * self.depth(end) + TWIG * self.mean_edge
            };
            if !is_twig {
                continue;
            }
            edges.into_iter().for_each(|e| self.remove(e));
            if self.degrees[end.index()] == 2 {
                let ways: Vec<HalfedgeId> = self.left_at(end).collect();
                for h in ways {
                    let (tip, _) = self.walk(end, h);
                    if self.degrees[tip.index()] == 1
                        && let Some((length, ..)) = from(self, tip)
                    {
                        queue.push(Reverse((length.to_bits(), tip)));
                    }
                }
            }
        }
    }

    /// Lines between forks and ends, each pulled straight among the vertices of the band that are nearest to it.
    fn straighten(&self) -> Vec<EdgeId> {
        let left = self.mesh.edges().filter(|e| self.is_left[e.index()]);
        let pairs: Vec<[u32; 2]> = left.map(|e| self.mesh.edge_vertices(e).map(|v| v.0)).collect();
        let mut lines = Vec::new();
        for chain in chains(&pairs, |_| false) {
            // What comes back to where it began, or nearly, has to stay a loop: two halves.
            if chain.len() > 4 && self.are_near(chain[0], chain[chain.len() - 1])
                || chain.first() == chain.last()
            {
                let middle = chain.len() / 2;
                lines.push(chain[..=middle].to_vec());
                lines.push(chain[middle..].to_vec());
            } else {
                lines.push(chain);
            }
        }
        let nearest = self.nearest(&lines);
        let mut edges = Vec::new();
        for (i, line) in lines.iter().enumerate() {
            let (Some(&from), Some(&to)) = (line.first(), line.last()) else { continue };
            let deepest = line.iter().map(|&v| self.depths[v as usize]).fold(0.0, f64::max);
            let cost = |h: HalfedgeId| {
                let tip = self.mesh.tip(h);
                // The edge between both ends may be another line.
                let is_short = self.mesh.tail(h).0 == from && tip.0 == to && line.len() > 2;
                let is_own = !is_short && (tip.0 == to || nearest[tip.index()] as usize == i);
                let shallow = 1.0 - (self.depth(tip) / deepest).min(1.0);
                let factor = if deepest > 0.0 { 1.0 + (RIM - 1.0) * shallow } else { 1.0 };
                is_own.then(|| factor * self.geometry.edge_length(h.edge()))
            };
            let goal = |v: VertexId| v.0 == to;
            // The line itself is such a way.
            edges.extend(
                cheapest_way(self.mesh, VertexId(from), goal, cost, f64::INFINITY)
                    .into_iter()
                    .flatten(),
            );
        }
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Whether two vertices are one, or have an edge or a neighbour in common.
    fn are_near(&self, a: u32, b: u32) -> bool {
        let around = |v: u32| self.mesh.outgoing(VertexId(v)).map(|h| self.mesh.tip(h));
        a == b || around(a).any(|v| v.0 == b || around(b).any(|w| v == w))
    }

    /// Lines without what leads from the middle of a stroke's round end to some place of its rim.
    fn trim(&self, mut lines: Vec<EdgeId>) -> Vec<EdgeId> {
        let mut is_line = vec![false; self.mesh.edge_count()];
        lines.iter().for_each(|e| is_line[e.index()] = true);
        let mut ends: Vec<VertexId> =
            lines.iter().flat_map(|&e| self.mesh.edge_vertices(e)).collect();
        ends.retain(|&v| self.mesh.outgoing(v).filter(|h| is_line[h.edge().index()]).count() == 1);
        for mut end in ends {
            // Inwards as long as it becomes no shallower and is no further than the rim; up to where it became deeper last.
            let (mut passed, mut gone) = (Vec::new(), 0);
            let (mut before, mut length) = (None, 0.0);
            loop {
                let left = self.mesh.outgoing(end).filter(|h| is_line[h.edge().index()]);
                let mut onward = left.filter(|h| Some(h.edge()) != before);
                let (Some(h), None) = (onward.next(), onward.next()) else { break };
                let next = self.mesh.tip(h);
                length += self.geometry.edge_length(h.edge());
                let is_end = length <= BRANCH * self.depth(next) + self.mean_edge;
                if self.depth(next) < self.depth(end) || !is_end {
                    break;
                }
                passed.push(h.edge());
                if self.depth(next) > self.depth(end) {
                    gone = passed.len();
                }
                (end, before) = (next, Some(h.edge()));
            }
            passed[..gone].iter().for_each(|e| is_line[e.index()] = false);
        }
        lines.retain(|e| is_line[e.index()]);
        lines
    }

    /// Lines with ways from their loose ends to where they may end.
    fn reach(
        &self,
        lines: Vec<EdgeId>,
        is_goal: impl Fn(VertexId) -> bool,
        most: f64,
    ) -> Vec<EdgeId> {
        let component = components(self.mesh, &lines);
        let mut degrees = vec![0u32; self.mesh.vertex_count()];
        let mut deepest: f64 = 0.0;
        for v in lines.iter().flat_map(|&e| self.mesh.edge_vertices(e)) {
            degrees[v.index()] += 1;
            deepest = deepest.max(self.depth(v));
        }
        let mut all = lines;
        for end in self.mesh.vertices().filter(|v| degrees[v.index()] == 1 && !is_goal(*v)) {
            let own = component[end.index()];
            let is_other = |v: VertexId| component[v.index()].is_some_and(|c| Some(c) != own);
            let length = |h: HalfedgeId| {
                let is_own = component[self.mesh.tip(h).index()] == own;
                (!is_own).then(|| self.geometry.edge_length(h.edge()))
            };
            let goal = |v: VertexId| is_goal(v) || is_other(v);
            let way = cheapest_way(self.mesh, end, goal, length, most + deepest);
            all.extend(way.into_iter().flatten());
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    /// For each vertex of the band the line that is nearest along its edges; no line is [`u32::MAX`], and so have the ends of lines.
    fn nearest(&self, lines: &[Vec<u32>]) -> Vec<u32> {
        let mut nearest = vec![u32::MAX; self.mesh.vertex_count()];
        let mut distances = vec![f64::INFINITY; self.mesh.vertex_count()];
        let mut queue = BinaryHeap::new();
        for (i, line) in (0u32..).zip(lines) {
            for &v in &line[1..line.len() - 1] {
                distances[v as usize] = 0.0;
                nearest[v as usize] = i;
                queue.push(Reverse((0u64, VertexId(v))));
            }
        }
        // No way may pass through the ends of other lines.
        let mut is_end = vec![false; self.mesh.vertex_count()];
        for v in lines.iter().flat_map(|line| [line.first(), line.last()]).flatten() {
            is_end[*v as usize] = true;
        }
        while let Some(Reverse((bits, v))) = queue.pop() {
            if f64::from_bits(bits) > distances[v.index()] {
                continue;
            }
            for h in self.mesh.outgoing(v) {
                let tip = self.mesh.tip(h);
                let distance = distances[v.index()] + self.geometry.edge_length(h.edge());
                let is_in = self.depth(tip).is_finite() && !is_end[tip.index()];
                if is_in && distance < distances[tip.index()] {
                    distances[tip.index()] = distance;
                    nearest[tip.index()] = nearest[v.index()];
                    queue.push(Reverse((distance.to_bits(), tip)));
                }
            }
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    const N: u32 = 24;

    /// A square of n × n smaller ones of side 1, divided by turns; closed around the y axis if asked for.
    fn sheet(is_tube: bool) -> (Mesh, Geometry) {
        let around = if is_tube { N } else { N + 1 };
        let mut points = Vec::new();
        for j in 0..=N {
            for i in 0..around {
                let (x, y) = (f64::from(i), f64::from(j));
                let angle = std::f64::consts::TAU * x / f64::from(N);
                let r = f64::from(N) / std::f64::consts::TAU;
                points.push(if is_tube {
                    Point3::new(r * angle.cos(), y, -r * angle.sin())
                } else {
                    Point3::new(x, y, 0.0)
                });
            }
        }
        let at = |i: u32, j: u32| j * around + i % around;
        let mut triangles = Vec::new();
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let both =
                if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            triangles.extend(both);
        }
        let mesh = Mesh::new(points.len(), &triangles).unwrap();
        let geometry = Geometry::measure(&mesh, points);
        (mesh, geometry)
    }

    fn painted(geometry: &Geometry, is_in: impl Fn(f64, f64) -> bool) -> Vec<bool> {
        geometry.positions.iter().map(|p| is_in(p.x, p.y)).collect()
    }

    /// Number of edges at each vertex, of those that have some.
    fn degrees(mesh: &Mesh, edges: &[EdgeId]) -> BTreeMap<VertexId, usize> {
        let mut degrees = BTreeMap::new();
        for v in edges.iter().flat_map(|&e| mesh.edge_vertices(e)) {
            *degrees.entry(v).or_insert(0) += 1;
        }
        degrees
    }

    fn count(degrees: &BTreeMap<VertexId, usize>, degree: usize) -> usize {
        degrees.values().filter(|&&d| d == degree).count()
    }

    fn length(geometry: &Geometry, edges: &[EdgeId]) -> f64 {
        edges.iter().map(|&e| geometry.edge_length(e)).sum()
    }

    fn lines_of(mesh: &Mesh, geometry: &Geometry, is_painted: &[bool]) -> Vec<EdgeId> {
        centre_lines(mesh, geometry, is_painted, |_| false, 0.0)
    }

    /// Number of independent loops of edges.
    fn loops(mesh: &Mesh, edges: &[EdgeId]) -> usize {
        let components = components(mesh, edges);
        let roots = mesh.vertices().filter(|v| components[v.index()] == Some(*v)).count();
        edges.len() + roots - degrees(mesh, edges).len()
    }

    #[test]
    fn a_stroke_that_crosses_itself_keeps_its_loop() {
        let (mesh, geometry) = sheet(false);
        for k in 0..40 {
            // An α: in from the left, around, and out again.
            let turn = 0.13 * f64::from(k);
            let stroke: Vec<[f64; 2]> = (0..=200)
                .map(|i| {
                    let t = f64::from(i) / 200.0 * 7.6 - 3.8;
                    let (x, y) = (4.0 - 0.9 * t * t + 6.0, 0.42 * t * (t * t - 7.0));
                    let (x, y) = (0.8 * (x - 4.0), 0.8 * y);
                    [12.0 + turn.cos() * x - turn.sin() * y, 12.0 + turn.sin() * x + turn.cos() * y]
                })
                .collect();
            let width = 0.8 + 0.02 * f64::from(k);
            let is_in = painted(&geometry, |x, y| {
                stroke.iter().any(|p| (p[0] - x).hypot(p[1] - y) < width)
            });
            let before = {
                let mut band = Band::new(&mesh, &geometry, &is_in);
                band.thin();
                let left: Vec<EdgeId> = mesh.edges().filter(|e| band.is_left[e.index()]).collect();
                loops(&mesh, &left)
            };
            let lines = lines_of(&mesh, &geometry, &is_in);
            assert_eq!(loops(&mesh, &lines), before, "α number {k}");
        }
        // Around a rod of three sides.
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for j in 0..9 {
            for i in 0..3 {
                let angle = std::f64::consts::TAU * f64::from(i) / 3.0;
                points.push(Point3::new(angle.cos(), angle.sin(), f64::from(j)));
            }
        }
        for j in 0..8u32 {
            for i in 0..3u32 {
                let at = |i: u32, j: u32| 3 * j + i % 3;
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        let mesh = Mesh::new(points.len(), &triangles).unwrap();
        let geometry = Geometry::measure(&mesh, points);
        for rows in [1.1, 2.1] {
            let is_in: Vec<bool> =
                geometry.positions.iter().map(|p| (p.z - 4.0).abs() < rows).collect();
            let lines = lines_of(&mesh, &geometry, &is_in);
            assert_eq!((lines.len(), loops(&mesh, &lines)), (3, 1));
        }
    }

    #[test]
    fn a_stroke_gives_its_middle() {
        let (mesh, geometry) = sheet(false);
        let is_in = painted(&geometry, |x, y| (y - 12.0).abs() < 2.5 && (3.0..21.5).contains(&x));
        let lines = lines_of(&mesh, &geometry, &is_in);
        let degrees = degrees(&mesh, &lines);
        assert_eq!((count(&degrees, 1), count(&degrees, 2)), (2, degrees.len() - 2));
        // Straight, and it ends where the stroke is as wide as elsewhere.
        let middle = degrees.keys().map(|v| geometry.positions[v.index()]);
        let places: Vec<[f64; 2]> = middle.map(|p| [p.x, p.y]).collect();
        let is_middle = places.iter().all(|p| (p[1] - 12.0).abs() < 0.1);
        assert!(is_middle && places.len() >= 13, "{places:?}");
        assert!((12.0..19.0).contains(&length(&geometry, &lines)));
    }

    #[test]
    fn strokes_that_cross_give_lines_that_cross_and_a_dab_gives_none() {
        let (mesh, geometry) = sheet(false);
        let cross = painted(&geometry, |x, y| {
            let band = |a: f64, b: f64| (a - 12.0).abs() < 1.5 && (2.0..22.5).contains(&b);
            band(x, y) || band(y, x)
        });
        let lines = lines_of(&mesh, &geometry, &cross);
        let degrees = degrees(&mesh, &lines);
        // One fork of four, or two of three beside each other.
        assert_eq!(count(&degrees, 1), 4, "{degrees:?}");
        assert!(matches!((count(&degrees, 4), count(&degrees, 3)), (1, 0) | (0, 2)));
        let dab = painted(&geometry, |x, y| (x - 12.0).hypot(y - 12.0) < 5.0);
        assert_eq!(lines_of(&mesh, &geometry, &dab), []);
        assert_eq!(lines_of(&mesh, &geometry, &vec![true; mesh.vertex_count()]), []);
        assert_eq!(lines_of(&mesh, &geometry, &vec![false; mesh.vertex_count()]), []);
    }

    #[test]
    fn a_stroke_around_a_tube_closes() {
        let (mesh, geometry) = sheet(true);
        let ring = painted(&geometry, |_, y| (y - 12.0).abs() < 2.5);
        let lines = lines_of(&mesh, &geometry, &ring);
        let degrees = degrees(&mesh, &lines);
        assert_eq!(count(&degrees, 2), degrees.len());
        assert!(degrees.keys().all(|v| (geometry.positions[v.index()].y - 12.0).abs() < 0.1));
        assert_eq!(lines.len(), N as usize);
    }

    #[test]
    fn a_band_of_single_edges_is_its_own_line_and_reaches_a_border_nearby() {
        let (mesh, geometry) = sheet(false);
        let is_in = painted(&geometry, |x, y| {
            let band = |a: f64, b: f64| (a - b).abs() < 0.1;
            (band(y, 5.0) && (2.0..=10.0).contains(&x))
                || (band(x, 10.0) && (5.0..=15.0).contains(&y))
        });
        let lines = lines_of(&mesh, &geometry, &is_in);
        // An edge more or less at the corner, where a diagonal may cut it.
        assert!((18.0 - length(&geometry, &lines)).abs() < 0.7, "{}", length(&geometry, &lines));
        let is_goal = |v: VertexId| mesh.is_boundary_vertex(v);
        let all = centre_lines(&mesh, &geometry, &is_in, is_goal, 3.0);
        assert!((length(&geometry, &all) - length(&geometry, &lines) - 2.0).abs() < 1e-9);
        assert_eq!(centre_lines(&mesh, &geometry, &is_in, is_goal, 1.0), lines);
        // A triangle of paint is no line, and two strokes with a gap are joined.
        let triangle =
            painted(&geometry, |x, y| (x - 5.5).abs() < 0.6 && y < 5.1 - x + 5.0 && y > 3.9);
        assert!(triangle.iter().filter(|p| **p).count() < 5);
        assert_eq!(lines_of(&mesh, &geometry, &triangle), []);
        let gap = painted(&geometry, |x, y| {
            (y - 9.0).abs() < 0.1 && (x - 12.0).abs() > 0.9 && x > 3.9 && x < 20.1
        });
        let [apart, joined] =
            [0.5, 2.5].map(|most| centre_lines(&mesh, &geometry, &gap, |_| false, most));
        assert_eq!((apart.len(), joined.len()), (14, 16));
    }
}
