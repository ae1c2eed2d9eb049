//! Nearest points of a surface, and what a ray meets, by one tree of boxes.
//!
//! Guaranteed: answers do not depend on the order of questions or on the hint, except between faces at exactly the same distance; a ray
//! through an edge or a vertex meets the surface. Not guaranteed: that a ray within a face's plane meets that face.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Point3, Vector3};

use crate::mesh::{FaceId, Mesh};

/// Faces in a leaf. One or two make the tree deep, sixteen measure too many triangles in vain.
const LEAF: usize = 4;

/// How far outside a triangle, in barycentric weight, a ray still meets it. Without it a ray slips through between two faces by
/// rounding; 1e-6 would make thin triangles visibly wider.
const RIM: f64 = 1e-10;

struct Node {
    low: Point3<f64>,
    high: Point3<f64>,
    /// Faces `first..first + count` of the order; with a count of 0 an inner node, whose second child is `first` and whose first
    /// child is the next node.
    first: u32,
    count: u32,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// The face that it lies on.
    pub face: FaceId,
    /// Its weights at the face's corners.
    pub weights: [f64; 3],
    /// Its place.
    pub point: Point3<f64>,
    /// Squared distance from the point that was asked for.
    pub squared: f64,
}

/// A surface prepared for questions.
pub struct Nearest {
    corners: Vec<[Point3<f64>; 3]>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl Nearest {
    /// **Takes** a place for every vertex. **Costs** O(F log F).
    pub fn new(mesh: &Mesh, positions: &[Point3<f64>]) -> Self {
        let place = |t: &[_; 3]| t.map(|v: crate::mesh::VertexId| positions[v.index()]);
        Self::from_corners(mesh.triangles().iter().map(place).collect())
    }

    /// The same for triangles that form no mesh; faces are numbered in their order.
    pub fn from_corners(corners: Vec<[Point3<f64>; 3]>) -> Self {
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        let centres: Vec<Vector3<f64>> =
            corners.iter().map(|c| (c[0].coords + c[1].coords + c[2].coords) / 3.0).collect();
        let mut tree = Self { corners, order: Vec::new(), nodes: Vec::new() };
        if !order.is_empty() {
            tree.build(&mut order, 0, &centres);
        }
        tree.order = order;
        tree
    }

    fn build(&mut self, faces: &mut [u32], offset: usize, centres: &[Vector3<f64>]) {
        let (mut low, mut high) =
            (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for corner in faces.iter().flat_map(|&f| &self.corners[f as usize]) {
            low = low.inf(&corner.coords);
            high = high.sup(&corner.coords);
        }
        let node = self.nodes.len();
        let count = if faces.len() <= LEAF { faces.len() as u32 } else { 0 };
        self.nodes.push(Node { low: low.into(), high: high.into(), first: offset as u32, count });
        if count > 0 {
            return;
        }
        let axis = (high - low).imax();
        let half = faces.len() / 2;
        faces.select_nth_unstable_by(half, |&f, &g| {
            centres[f as usize][axis].total_cmp(&centres[g as usize][axis]).then(f.cmp(&g))
        });
        let (left, right) = faces.split_at_mut(half);
        self.build(left, offset, centres);
        self.nodes[node].first = self.nodes.len() as u32;
        self.build(right, offset + half, centres);
    }

    /// The nearest point; none only where there are no faces.
    ///
    /// **Costs** O(log F) near the surface.
    pub fn find(&self, point: Point3<f64>) -> Option<Hit> {
        self.find_among(point, None, |_| true)
    }

    /// The nearest point on those faces that `accept` takes, none where it takes none.
    ///
    /// **Takes** a face to begin with: the nearer the faster. **Costs** O(log F) near those faces.
    pub fn find_among(
        &self,
        point: Point3<f64>,
        hint: Option<FaceId>,
        accept: impl Fn(FaceId) -> bool,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let measure = |face: FaceId, best: &mut Option<Hit>| {
            if !accept(face) {
                return;
            }
            let (weights, place) = closest(&self.corners[face.index()], point);
            let squared = (place - point).norm_squared();
            if best.is_none_or(|b| squared < b.squared) {
                *best = Some(Hit { face, weights, point: place, squared });
            }
        };
        if let Some(face) = hint {
            measure(face, &mut best);
        }
        // Each inner node leaves one more to do, and halving 2³² faces ends after 32 levels.
        let mut stack = [0u32; 64];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let index = stack[waiting];
            let node = &self.nodes[index as usize];
            if best.is_some_and(|b| node.squared(point) >= b.squared) {
                continue;
            }
            let first = node.first;
            if node.count > 0 {
                for i in first..first + node.count {
                    measure(FaceId(self.order[i as usize]), &mut best);
                }
                continue;
            }
            let children = [index + 1, first];
            let [l, r] = children.map(|n| self.nodes[n as usize].squared(point));
            let [near, far] = if l <= r { children } else { [first, index + 1] };
            stack[waiting] = far;
            stack[waiting + 1] = near;
            waiting += 2;
        }
        best
    }

    /// Whether the points `origin + t direction` with `from` < t < `to` meet a face, seen from either side.
    ///
    /// **Takes** 0 ≤ `from`, in multiples of the direction, and `skip` for faces to look through: those around a vertex that the ray
    /// starts from. **Costs** O(log F) for a ray that is stopped or leaves soon.
    pub fn is_hit(
        &self,
        origin: Point3<f64>,
        direction: Vector3<f64>,
        from: f64,
        to: f64,
        skip: impl Fn(FaceId) -> bool,
    ) -> bool {
        let inverse = direction.map(|x| 1.0 / x);
        let mut stack = [0u32; 64];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let index = stack[waiting];
            let node = &self.nodes[index as usize];
            if !node.is_met(origin, direction, inverse, from, to) {
                continue;
            }
            let first = node.first;
            if node.count == 0 {
                stack[waiting] = first;
                stack[waiting + 1] = index + 1;
                waiting += 2;
                continue;
            }
            let faces = &self.order[first as usize..(first + node.count) as usize];
            let is_met = |f: u32| {
                meets(&self.corners[f as usize], origin, direction)
                    .is_some_and(|t| t > from && t < to)
            };
            if faces.iter().any(|&f| is_met(f) && !skip(FaceId(f))) {
                return true;
            }
        }
        false
    }
}

impl Node {
    /// Squared distance from the box.
    fn squared(&self, p: Point3<f64>) -> f64 {
        let outside = |i: usize| (self.low[i] - p[i]).max(p[i] - self.high[i]).max(0.0);
        [0, 1, 2].map(|i| outside(i) * outside(i)).iter().sum()
    }

    /// Whether a ray passes through the box.
    fn is_met(
        &self,
        origin: Point3<f64>,
        direction: Vector3<f64>,
        inverse: Vector3<f64>,
        from: f64,
        to: f64,
    ) -> bool {
        let (mut near, mut far) = (from, to);
        for i in 0..3 {
            let [low, high] = [self.low[i], self.high[i]].map(|x| (x - origin[i]) * inverse[i]);
            if inverse[i].is_finite() {
                near = near.max(low.min(high));
                far = far.min(low.max(high));
            } else if direction[i].abs() <= 0.0
                && !(origin[i] >= self.low[i] && origin[i] <= self.high[i])
            {
                return false;
            }
        }
        // Boxes of flat parts have no thickness: rounding must not let a ray miss them.
        near <= far + 1e-12 * far.abs()
    }
}

/// Where a ray meets a triangle, in multiples of its direction; none where it misses it or lies in its plane.
fn meets(corners: &[Point3<f64>; 3], origin: Point3<f64>, direction: Vector3<f64>) -> Option<f64> {
    let [a, b, c] = *corners;
    let (ab, ac) = (b - a, c - a);
    let normal = direction.cross(&ac);
    let inverse = 1.0 / ab.dot(&normal);
    let from = origin - a;
    let u = from.dot(&normal) * inverse;
    let side = from.cross(&ab);
    let v = direction.dot(&side) * inverse;
    let t = ac.dot(&side) * inverse;
    (u >= -RIM && v >= -RIM && u + v <= 1.0 + RIM && t.is_finite()).then_some(t)
}

/// The point of a triangle nearest to another, and its weights at the corners: the foot of the perpendicular where that lies
/// inside, else the best point of the three sides. A triangle without area has its sides.
pub fn closest(corners: &[Point3<f64>; 3], p: Point3<f64>) -> ([f64; 3], Point3<f64>) {
    let [a, b, c] = *corners;
    let n = (b - a).cross(&(c - a));
    let doubled = n.norm_squared();
    let wedge = |u: Point3<f64>, v: Point3<f64>| (u - p).cross(&(v - p)).dot(&n) / doubled;
    let weights = [wedge(b, c), wedge(c, a), wedge(a, b)];
    let sum: f64 = weights.iter().sum();
    // In a triangle that is hardly any rounding decides: its sides are all that there is.
    if weights.iter().all(|w| *w >= 0.0) && (sum - 1.0).abs() < 1e-3 {
        let weights = weights.map(|w| w / sum);
        let point = a.coords * weights[0] + b.coords * weights[1] + c.coords * weights[2];
        return (weights, point.into());
    }
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0], a);
    for i in 0..3 {
        let (u, v) = (corners[i], corners[(i + 1) % 3]);
        let t = along(u, v, p);
        let point = u + (v - u) * t;
        let squared = (point - p).norm_squared();
        if squared < best.0 {
            let mut weights = [0.0; 3];
            weights[i] = 1.0 - t;
            weights[(i + 1) % 3] = t;
            best = (squared, weights, point);
        }
    }
    (best.1, best.2)
}

/// How far along a segment its point nearest to `p` lies, from 0 to 1.
fn along(u: Point3<f64>, v: Point3<f64>, p: Point3<f64>) -> f64 {
    let t = (p - u).dot(&(v - u)) / (v - u).norm_squared();
    if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 }
}
