//! Geodesic distance by fast marching.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Geometry;
use crate::mesh::{Mesh, VertexId};

/// A distance that orders: all distances here are finite and not negative, so their bits sort like their values.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Distance(u64);

/// Distance of every vertex from the nearest of the sources, infinite on other components.
///
/// A front runs over the surface; a vertex is reached through a triangle by the plane wave that fits the distances at the
/// other two corners, or along an edge where that wave would come from outside the triangle.
///
/// **Gives** one length for each vertex, of the geometry's unit. First-order accurate; never shorter than the polyhedral
/// distance minus that error. **Costs** O(V log V). **From** [KS98]; obtuse triangles are not unfolded, edges bound their error.
pub fn geodesic_distances(mesh: &Mesh, geometry: &Geometry, sources: &[VertexId]) -> Vec<f64> {
    let sources: Vec<(VertexId, f64)> = sources.iter().map(|&v| (v, 0.0)).collect();
    let mut front = GeodesicFront::new(mesh.vertex_count());
    front.spread(mesh, geometry, &sources, |_, _| true);
    front.distances
}

/// Distance of every vertex from where the sources have the given distances already; sources keep theirs.
///
/// Triangles are crossed by straight fronts, as they leave a curve, where [`geodesic_distances`] has circles around a point: a
/// circle through two points that are closer to its centre than half their distance does not exist.
///
/// **Takes** finite distances, none negative.
pub fn geodesic_distances_from(
    mesh: &Mesh,
    geometry: &Geometry,
    sources: &[(VertexId, f64)],
) -> Vec<f64> {
    let mut front = GeodesicFront::new(mesh.vertex_count());
    front.wave = straight_front;
    front.spread(mesh, geometry, sources, |_, _| true);
    front.distances
}

/// A front that can be sent over a surface many times, each time only as far as wanted. **See** [`geodesic_distances`].
pub struct GeodesicFront {
    distances: Vec<f64>,
    fixed: Vec<bool>,
    /// Sources.
    given: Vec<bool>,
    reached: Vec<VertexId>,
    queue: BinaryHeap<Reverse<(Distance, VertexId)>>,
    /// Arrival at the apex of a triangle, from distances at the base, the base and the sides.
    wave: fn(f64, f64, f64, f64, f64) -> Option<f64>,
}

impl GeodesicFront {
    /// A front that has reached nothing.
    pub fn new(vertex_count: usize) -> Self {
        Self {
            distances: vec![f64::INFINITY; vertex_count],
            fixed: vec![false; vertex_count],
            given: vec![false; vertex_count],
            reached: Vec::new(),
            queue: BinaryHeap::new(),
            wave: plane_wave,
        }
    }

    /// The vertices that the last front has reached, in its order.
    pub fn reached(&self) -> &[VertexId] {
        &self.reached
    }

    /// Distance of a vertex from the last sources; infinite if it was not reached.
    pub fn distance(&self, v: VertexId) -> f64 {
        self.distances[v.index()]
    }

    /// Spreads from sources, on from those vertices that `goes_on(v, distance)` accepts.
    ///
    /// **Takes** sources with the distances that they have already, finite, none negative; they keep them. **Costs** O(n log n) for n vertices reached.
    pub fn spread(
        &mut self,
        mesh: &Mesh,
        geometry: &Geometry,
        sources: &[(VertexId, f64)],
        goes_on: impl Fn(VertexId, f64) -> bool,
    ) {
        for v in self.reached.drain(..) {
            self.distances[v.index()] = f64::INFINITY;
            self.fixed[v.index()] = false;
            self.given[v.index()] = false;
        }
        let Self { distances, fixed, given, reached, queue, wave } = self;
        for &(v, distance) in sources {
            given[v.index()] = true;
            distances[v.index()] = distance;
            // Not −0: its bits would come last.
            queue.push(Reverse((Distance((distance + 0.0).to_bits()), v)));
        }
        while let Some(Reverse((_, v))) = queue.pop() {
            if std::mem::replace(&mut fixed[v.index()], true) {
                continue;
            }
            reached.push(v);
            if !goes_on(v, distances[v.index()]) {
                continue;
            }
            for h in mesh.outgoing(v) {
                let tip = mesh.tip(h);
                let distance = distances[v.index()] + geometry.edge_length(h.edge());
                if !given[tip.index()] && !fixed[tip.index()] && distance < distances[tip.index()] {
                    distances[tip.index()] = distance;
                    queue.push(Reverse((Distance(distance.to_bits()), tip)));
                }
            }
            for h in mesh.outgoing(v).filter(|&h| mesh.face(h).is_some()) {
                let (next, prev) = (mesh.next(h), mesh.prev(h));
                let (p, q) = (mesh.tip(h), mesh.tip(next));
                let [vp, pq, qv] = [h, next, prev].map(|g| geometry.edge_length(g.edge()));
                // Either far corner may be the one that the other two reach.
                for (from, to, base, side_v, side_from) in [(p, q, vp, qv, pq), (q, p, qv, vp, pq)]
                {
                    if given[to.index()] || fixed[to.index()] || !fixed[from.index()] {
                        continue;
                    }
                    let (a, b) = (distances[v.index()], distances[from.index()]);
                    if let Some(distance) = wave(a, b, base, side_v, side_from)
                        && distance < distances[to.index()]
                    {
                        distances[to.index()] = distance;
                        queue.push(Reverse((Distance(distance.to_bits()), to)));
                    }
                }
            }
        }
    }
}

/// Arrival at the apex of a triangle of a straight front that passes the ends of its base at `a` and `b`; `None` where the
/// front does not come through the base.
fn plane_wave(a: f64, b: f64, base: f64, side_a: f64, side_b: f64) -> Option<f64> {
    // Base from (0,0) to (base,0), apex (x,y) above; the virtual source lies below at distances a and b.
    let x = (side_a * side_a - side_b * side_b + base * base) / (2.0 * base);
    let y = (side_a * side_a - x * x).max(0.0).sqrt();
    let source_x = (a * a - b * b + base * base) / (2.0 * base);
    let below = a * a - source_x * source_x;
    if below < 0.0 {
        return None;
    }
    let source_y = -below.sqrt();
    // Where the ray from the source to the apex crosses the base.
    let crossing = source_x + (x - source_x) * (-source_y) / (y - source_y).max(1e-300);
    if !(0.0..=base).contains(&crossing) {
        return None;
    }
    let arrival = ((x - source_x).powi(2) + (y - source_y).powi(2)).sqrt();
    arrival.is_finite().then_some(arrival)
}

/// The same for a front that is a straight line.
fn straight_front(a: f64, b: f64, base: f64, side_a: f64, side_b: f64) -> Option<f64> {
    let x = (side_a * side_a - side_b * side_b + base * base) / (2.0 * base);
    let y = (side_a * side_a - x * x).max(0.0).sqrt();
    let along = (b - a) / base;
    let across = (1.0 - along * along).max(0.0).sqrt();
    // Where the ray to the apex crosses the base, times `across`.
    let crossing = x * across - y * along;
    if !(crossing >= 0.0 && crossing <= base * across) {
        return None;
    }
    let arrival = a + along * x + across * y;
    arrival.is_finite().then_some(arrival)
}
