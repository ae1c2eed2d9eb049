//! Nearest points of a surface, by a tree of boxes.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::{NONE, Surface};

/// Faces in a leaf. One or two make the tree deep, sixteen measure too many triangles in vain.
const LEAF: usize = 4;

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
pub(super) struct Hit {
    /// The face that it lies on.
    pub face: u32,
    /// Its weights at the face's corners.
    pub weights: [f64; 3],
    /// Its place.
    pub point: Point3<f64>,
    /// Squared distance from the point that was asked for.
    pub squared: f64,
}

/// A surface prepared for questions.
pub(super) struct Nearest {
    corners: Vec<[Point3<f64>; 3]>,
    normals: Vec<Vector3<f64>>,
    /// Only faces of the region asked for are hit.
    regions: Vec<u32>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl Nearest {
    /// **Takes** a surface and a region number for each face. **Costs** O(F log F).
    pub fn new(surface: &Surface, regions: Vec<u32>) -> Self {
        let corners: Vec<[Point3<f64>; 3]> = surface
            .mesh
            .triangles()
            .iter()
            .map(|t| t.map(|v| surface.positions[v.index()]))
            .collect();
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        let centres: Vec<Vector3<f64>> =
            corners.iter().map(|c| (c[0].coords + c[1].coords + c[2].coords) / 3.0).collect();
        let mut tree = Self {
            corners,
            normals: surface.face_vectors(),
            regions,
            order: Vec::new(),
            nodes: Vec::new(),
        };
        tree.build(&mut order, 0, &centres);
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

    /// The nearest point on the faces of a region whose normals do not look away from `normal` (zero: on all of them).
    ///
    /// **Takes** a face to begin with, or `NONE`: the nearer the faster. **Costs** O(log F) near the surface.
    pub fn find(
        &self,
        point: Point3<f64>,
        normal: Vector3<f64>,
        region: u32,
        hint: u32,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let measure = |f: u32, best: &mut Option<Hit>| {
            if self.regions[f as usize] != region || self.normals[f as usize].dot(&normal) < 0.0 {
                return;
            }
            let (weights, place) = closest(&self.corners[f as usize], point);
            let squared = (place - point).norm_squared();
            if best.is_none_or(|b| squared < b.squared) {
                *best = Some(Hit { face: f, weights, point: place, squared });
            }
        };
        if hint != NONE {
            measure(hint, &mut best);
        }
        // Each inner node leaves one more to do, and halving 2³² faces ends after 32 levels.
        let mut stack = [0u32; 64];
        let mut waiting = 1;
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
                    measure(self.order[i as usize], &mut best);
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
}

impl Node {
    /// Squared distance from the box.
    fn squared(&self, p: Point3<f64>) -> f64 {
        let outside = |i: usize| (self.low[i] - p[i]).max(p[i] - self.high[i]).max(0.0);
        [0, 1, 2].map(|i| outside(i) * outside(i)).iter().sum()
    }
}

/// The point of a triangle nearest to another, and its weights at the corners: the foot of the perpendicular where that lies
/// inside, else the best point of the three sides. A triangle without area has its sides.
pub(super) fn closest(corners: &[Point3<f64>; 3], p: Point3<f64>) -> ([f64; 3], Point3<f64>) {
    let [a, b, c] = *corners;
    let n = (b - a).cross(&(c - a));
    let doubled = n.norm_squared();
    let wedge = |u: Point3<f64>, v: Point3<f64>| (u - p).cross(&(v - p)).dot(&n) / doubled;
    let weights = [wedge(b, c), wedge(c, a), wedge(a, b)];
    if weights.iter().all(|w| *w >= 0.0) {
        let sum: f64 = weights.iter().sum();
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
pub(super) fn along(u: Point3<f64>, v: Point3<f64>, p: Point3<f64>) -> f64 {
    let t = (p - u).dot(&(v - u)) / (v - u).norm_squared();
    if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 }
}
