//! Shortest ways along a surface between two of its points.
//!
//! A front from one point says roughly where the way runs: a strip of faces. Laid out in the plane, the shortest way inside the strip is
//! a chain of straight lines that bends at vertices only. Where the surface on the other side of such a vertex leaves less than a
//! straight angle, the way becomes shorter when the strip passes the vertex there; when no such vertex is left, no small change makes it shorter.
//!
//! Guaranteed: lengths are those of the polyhedron, exact up to rounding; on a flat convex surface the way is the straight line. Not
//! guaranteed: that no quite different way around the surface is shorter by less than the front's error.

use nalgebra::{Point2, Point3, Vector2};
use std::cell::Cell;
use std::f64::consts::PI;

use super::{GeodesicFront, Geometry};
use crate::mesh::{FaceId, HalfedgeId, Mesh, VertexId};

/// Least weight of an end at a corner of its face. A point in a vertex has no side of it; this near, the length changes by less than rounding
/// of what is drawn.
const INSIDE: f64 = 1e-9;
/// How much less than a straight angle counts, radians: less is rounding.
const STRAIGHT: f64 = 1e-9;

/// A way along a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePath {
    /// Its length, in the geometry's unit.
    pub length: f64,
    /// Its corners and where it crosses edges, from one end to the other.
    pub points: Vec<Point3<f64>>,
}

/// A shortest way between two points of a surface; none where no way joins them.
///
/// **Takes** faces with barycentric weights, not negative, that add up to 1. **Costs** O(V log V) for the part of the surface that is nearer than
/// the other end, and a few passes over the way. **From** the front of [KS98]; strips are laid out and pulled taut as in the plane.
pub fn shortest_path(
    mesh: &Mesh,
    geometry: &Geometry,
    from: (FaceId, [f64; 3]),
    to: (FaceId, [f64; 3]),
) -> Option<SurfacePath> {
    let [from, to] = [from, to].map(|(face, weights)| End::new(mesh, geometry, face, weights));
    if from.face == to.face {
        let length = (to.place - from.place).norm();
        return Some(SurfacePath { length, points: vec![from.place, to.place] });
    }
    // Fronts from either end may come by different sides of a bump.
    let there = one_way(mesh, geometry, &from, &to)?;
    let mut back = one_way(mesh, geometry, &to, &from)?;
    back.points.reverse();
    Some(if back.length < there.length { back } else { there })
}

/// The way that a front from the first end begins with.
fn one_way(mesh: &Mesh, geometry: &Geometry, from: &End, to: &End) -> Option<SurfacePath> {
    let mut strip = first_strip(mesh, geometry, from, to)?;
    let mut best: Option<Taut> = None;
    loop {
        let taut = Taut::new(mesh, geometry, &strip, from, to)?;
        if best.as_ref().is_some_and(|known| taut.length >= known.length) {
            break;
        }
        let next = around(mesh, geometry, &strip, &taut);
        best = Some(taut);
        match next {
            Some(next) => strip = next,
            None => break,
        }
    }
    let taut = best?;
    Some(SurfacePath { length: taut.length, points: taut.points(geometry, from, to) })
}

struct End {
    face: FaceId,
    weights: [f64; 3],
    place: Point3<f64>,
}

impl End {
    fn new(mesh: &Mesh, geometry: &Geometry, face: FaceId, weights: [f64; 3]) -> Self {
        let weights = weights.map(|w| w.max(INSIDE));
        let sum: f64 = weights.iter().sum();
        let weights = weights.map(|w| w / sum);
        let corners = mesh.face_vertices(face).map(|v| geometry.positions[v.index()].coords);
        let place = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        Self { face, weights, place: place.into() }
    }

    fn distance(&self, geometry: &Geometry, v: VertexId) -> f64 {
        (geometry.positions[v.index()] - self.place).norm()
    }

    fn in_plane(&self, corners: [Point2<f64>; 3]) -> Point2<f64> {
        let [a, b, c] = corners.map(|p| p.coords);
        (a * self.weights[0] + b * self.weights[1] + c * self.weights[2]).into()
    }
}

/// Faces from one end to the other, each beside the one before, along the edges that a front has come by.
fn first_strip(mesh: &Mesh, geometry: &Geometry, from: &End, to: &End) -> Option<Vec<FaceId>> {
    let starts = mesh.face_vertices(from.face);
    let goals = mesh.face_vertices(to.face);
    let sources: Vec<(VertexId, f64)> =
        starts.iter().map(|&v| (v, from.distance(geometry, v))).collect();
    let mut front = GeodesicFront::new(mesh.vertex_count());
    let missing = Cell::new(goals.len());
    front.spread(mesh, geometry, &sources, |v, _| {
        if goals.contains(&v) {
            missing.set(missing.get().saturating_sub(1));
        }
        missing.get() > 0
    });
    let whole = |v: &VertexId| front.distance(*v) + to.distance(geometry, *v);
    let [first, others @ ..] = goals;
    let mut v = others.into_iter().fold(first, |a, b| if whole(&b) < whole(&a) { b } else { a });
    if !front.distance(v).is_finite() {
        return None;
    }
    let mut strip = vec![to.face];
    while !starts.contains(&v) {
        let nearer = mesh
            .outgoing(v)
            .filter(|&h| front.distance(mesh.tip(h)) < front.distance(v))
            .min_by(|&g, &h| {
                let whole =
                    |h: HalfedgeId| front.distance(mesh.tip(h)) + geometry.edge_length(h.edge());
                whole(g).total_cmp(&whole(h))
            })?;
        let beside = [mesh.face(nearer), mesh.face(nearer.twin())];
        turn_about(mesh, v, &mut strip, |face| beside.contains(&Some(face)))?;
        v = mesh.tip(nearer);
    }
    turn_about(mesh, v, &mut strip, |face| face == from.face)?;
    strip.reverse();
    Some(without_loops(strip))
}

/// The faces around a vertex, counter-clockwise.
fn fan(mesh: &Mesh, v: VertexId) -> Vec<FaceId> {
    mesh.outgoing(v).filter_map(|h| mesh.face(h)).collect()
}

/// Goes on around a vertex from the last face of a strip to one that is wanted, by the fewer faces.
fn turn_about(
    mesh: &Mesh,
    v: VertexId,
    strip: &mut Vec<FaceId>,
    is_wanted: impl Fn(FaceId) -> bool,
) -> Option<()> {
    let fan = fan(mesh, v);
    let last = *strip.last()?;
    let at = fan.iter().position(|&face| face == last)?;
    let is_closed = !mesh.is_boundary_vertex(v);
    let n = fan.len();
    for steps in 0..n {
        for is_left in [true, false] {
            let there = if is_left { at + steps } else { at + n - steps };
            let inside = if is_left { there < n } else { there >= n };
            if !(is_closed || inside) || !is_wanted(fan[there % n]) {
                continue;
            }
            let step = |i: usize| if is_left { (at + i) % n } else { (at + n - i) % n };
            strip.extend((1..=steps).map(|i| fan[step(i)]));
            return Some(());
        }
    }
    None
}

/// A way that comes back to a face is shorter without what is between.
fn without_loops(strip: Vec<FaceId>) -> Vec<FaceId> {
    let mut result: Vec<FaceId> = Vec::with_capacity(strip.len());
    let mut seen = std::collections::BTreeMap::new();
    for face in strip {
        if let Some(&at) = seen.get(&face) {
            for gone in result.drain(at + 1..) {
                seen.remove(&gone);
            }
        } else {
            seen.insert(face, result.len());
            result.push(face);
        }
    }
    result
}

/// The edge between two faces of a strip, in the plane.
#[derive(Clone, Copy)]
struct Portal {
    vertices: [VertexId; 2],
    /// Left and right of the way.
    places: [Point2<f64>; 2],
}

/// The shortest way inside a strip, laid out in the plane.
struct Taut {
    length: f64,
    portals: Vec<Portal>,
    /// The ends, and between them where it bends: the portal, and on which side of it.
    corners: Vec<(Point2<f64>, usize, usize)>,
}

impl Taut {
    /// None only where the faces of the strip are no neighbours.
    fn new(
        mesh: &Mesh,
        geometry: &Geometry,
        strip: &[FaceId],
        from: &End,
        to: &End,
    ) -> Option<Self> {
        let (portals, start, goal) = lay_out(mesh, geometry, strip, from, to)?;
        let corners = funnel(&portals, start, goal);
        let length = corners.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).sum();
        Some(Self { length, portals, corners })
    }

    fn points(&self, geometry: &Geometry, from: &End, to: &End) -> Vec<Point3<f64>> {
        let mut points = vec![from.place];
        for (k, pair) in self.corners.windows(2).enumerate() {
            let [(start, first, _), (end, last, side)] = [pair[0], pair[1]];
            let way = end - start;
            let begin = if k == 0 { 0 } else { first + 1 };
            for portal in &self.portals[begin.min(last)..last] {
                let [left, right] = portal.places;
                let across = left - right;
                let turn = way.perp(&across);
                let t = if turn.abs() > 0.0 { way.perp(&(start - right)) / turn } else { 0.0 };
                let [left, right] = portal.vertices.map(|v| geometry.positions[v.index()]);
                points.push(right + (left - right) * t.clamp(0.0, 1.0));
            }
            if last < self.portals.len() {
                points.push(geometry.positions[self.portals[last].vertices[side].index()]);
            }
        }
        points.push(to.place);
        points.dedup_by(|a, b| (*a - *b).norm() < 1e-9);
        points
    }
}

/// The portals of a strip and both ends in one plane.
fn lay_out(
    mesh: &Mesh,
    geometry: &Geometry,
    strip: &[FaceId],
    from: &End,
    to: &End,
) -> Option<(Vec<Portal>, Point2<f64>, Point2<f64>)> {
    let length = |h: HalfedgeId| geometry.edge_length(h.edge());
    let first = mesh.face_halfedges(*strip.first()?);
    let b = Point2::new(length(first[0]), 0.0);
    let mut corners =
        [Point2::origin(), b, apex(Point2::origin(), b, length(first[2]), length(first[1]))];
    let start = from.in_plane(corners);
    let mut portals = Vec::with_capacity(strip.len());
    for pair in strip.windows(2) {
        let sides = mesh.face_halfedges(pair[0]);
        let side = (0..3).find(|&i| mesh.face(sides[i].twin()) == Some(pair[1]))?;
        let h = sides[side];
        let (tail, tip) = (corners[side], corners[(side + 1) % 3]);
        portals.push(Portal { vertices: [mesh.tip(h), mesh.tail(h)], places: [tip, tail] });
        // Across, the edge runs the other way round.
        let next = mesh.face_halfedges(pair[1]);
        let twin = (0..3).find(|&i| next[i] == h.twin())?;
        let [along, back] = [next[(twin + 1) % 3], next[(twin + 2) % 3]].map(length);
        corners[twin] = tip;
        corners[(twin + 1) % 3] = tail;
        corners[(twin + 2) % 3] = apex(tip, tail, back, along);
    }
    Some((portals, start, to.in_plane(corners)))
}

/// The corner to the left of `a` → `b` that is so far from both.
fn apex(a: Point2<f64>, b: Point2<f64>, from_a: f64, from_b: f64) -> Point2<f64> {
    let base = b - a;
    let size = base.norm().max(1e-300);
    let x = (from_a * from_a - from_b * from_b + size * size) / (2.0 * size);
    let y = (from_a * from_a - x * x).max(0.0).sqrt();
    let along = base / size;
    a + along * x + Vector2::new(-along.y, along.x) * y
}

/// The chain of straight lines through all portals: a funnel that narrows from portal to portal, and moves its tip to where it would close.
fn funnel(
    portals: &[Portal],
    start: Point2<f64>,
    goal: Point2<f64>,
) -> Vec<(Point2<f64>, usize, usize)> {
    let turn = |a: Point2<f64>, b: Point2<f64>, c: Point2<f64>| (b - a).perp(&(c - a));
    let mut corners = vec![(start, 0, 0)];
    let mut tip = start;
    // Left and right of the funnel, and the portals that they are of.
    let mut sides = [start, start];
    let mut at = [0, 0];
    let mut i = 0;
    while i <= portals.len() {
        let places = portals.get(i).map_or([goal, goal], |portal| portal.places);
        let mut closed = None;
        for (side, sign) in [(1, 1.0), (0, -1.0)] {
            let other = 1 - side;
            if sign * turn(tip, sides[side], places[side]) < 0.0 {
                continue;
            }
            let is_open = tip == sides[side] || sign * turn(tip, sides[other], places[side]) <= 0.0;
            if is_open {
                sides[side] = places[side];
                at[side] = i;
            } else {
                closed = Some(other);
                break;
            }
        }
        if let Some(side) = closed {
            tip = sides[side];
            i = at[side];
            corners.push((tip, i, side));
            sides = [tip, tip];
            at = [i, i];
        }
        i += 1;
    }
    corners.push((goal, portals.len(), 0));
    corners
}

/// The strip that passes the vertices at which the way bends on their other sides, where that is shorter; none where it nowhere is.
fn around(mesh: &Mesh, geometry: &Geometry, strip: &[FaceId], taut: &Taut) -> Option<Vec<FaceId>> {
    let mut result = strip.to_vec();
    let mut has_changed = false;
    // From the end, so that what is before keeps its place.
    let mut limit = strip.len();
    for k in (1..taut.corners.len() - 1).rev() {
        let (place, portal, side) = taut.corners[k];
        let v = taut.portals[portal].vertices[side];
        if mesh.is_boundary_vertex(v) {
            continue;
        }
        let has_v = |&i: &usize| taut.portals[i].vertices.contains(&v);
        let first = (0..portal).rev().take_while(has_v).last().unwrap_or(portal);
        let last = (portal + 1..taut.portals.len()).take_while(has_v).last().unwrap_or(portal);
        // Portal i lies between faces i and i + 1.
        if last + 1 >= limit {
            continue;
        }
        let far = |portal: &Portal| portal.places[usize::from(portal.vertices[0] == v)] - place;
        let before = taut.corners[k - 1].0 - place;
        let after = taut.corners[k + 1].0 - place;
        let through: f64 = (first + 1..=last)
            .map(|i| {
                let corner = mesh.face_vertices(strip[i]).iter().position(|&c| c == v);
                corner.map_or(0.0, |corner| geometry.corner_angles[strip[i].index()][corner])
            })
            .sum::<f64>()
            + angle(before, far(&taut.portals[first]))
            + angle(far(&taut.portals[last]), after);
        let around = fan(mesh, v);
        let whole: f64 = around
            .iter()
            .filter_map(|&face| {
                let corner = mesh.face_vertices(face).iter().position(|&c| c == v)?;
                Some(geometry.corner_angles[face.index()][corner])
            })
            .sum();
        if whole - through >= PI - STRAIGHT {
            continue;
        }
        let n = around.len();
        let index = |face: FaceId| around.iter().position(|&other| other == face);
        let (Some(a), Some(b), Some(second)) =
            (index(strip[first]), index(strip[last + 1]), index(strip[first + 1]))
        else {
            continue;
        };
        let goes_left = (a + 1) % n == second;
        let steps = if goes_left { (a + n - b) % n } else { (b + n - a) % n };
        let step = |i: usize| if goes_left { (a + n - i) % n } else { (a + i) % n };
        let other_side = (1..=steps).map(|i| around[step(i)]);
        result.splice(first + 1..last + 2, other_side);
        limit = first + 1;
        has_changed = true;
    }
    has_changed.then(|| without_loops(result))
}

fn angle(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.perp(&b).abs().atan2(a.dot(&b))
}

#[cfg(test)]
mod tests;
