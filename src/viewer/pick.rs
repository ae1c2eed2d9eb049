//! What lies under the pointer: a bounding volume hierarchy over triangles, and a ray through it.
//!
//! Both views use it. A chart is a triangle mesh in the plane z = 0, met by a ray straight down.

use super::camera::Ray;
use glam::Vec3;

/// Triangles per leaf: fewer make the tree deep, more make a leaf slow.
const LEAF: usize = 8;

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle.
    pub triangle: u32,
    /// Multiple of the ray's direction.
    pub distance: f32,
    /// Weights of the three corners.
    pub weights: [f32; 3],
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// First triangle of a leaf, or the second child; the first child follows its parent.
    start: u32,
    /// Number of triangles; 0 for an inner node.
    count: u32,
}

/// A hierarchy over the triangles of one mesh. Owns no positions: they are handed to each query.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Hierarchy {
    /// Splits at the median of the longest side: `O(n log n)`, 10 ms for 50 000 triangles, which
    /// is why callers build it only when somebody points at something.
    ///
    /// Triangles with a corner that is not finite are left out.
    pub fn new(triangles: &[[u32; 3]], position: impl Fn(u32) -> Vec3) -> Self {
        let boxes: Vec<(Vec3, Vec3)> = triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(&position);
                (a.min(b).min(c), a.max(b).max(c))
            })
            .collect();
        let finite =
            |i: &u32| triangles[*i as usize].iter().all(|&corner| position(corner).is_finite());
        let mut order: Vec<u32> = (0..triangles.len() as u32).filter(finite).collect();
        let mut nodes = Vec::with_capacity(2 * order.len() / LEAF + 1);
        if !order.is_empty() {
            let count = order.len();
            build(&mut nodes, &mut order, 0, count, &boxes);
        }
        Self { nodes, order }
    }

    /// The nearest triangle on the ray; the later one of two at the same place, since it was drawn
    /// over the other.
    pub fn cast(
        &self,
        ray: Ray,
        triangles: &[[u32; 3]],
        position: impl Fn(u32) -> Vec3,
    ) -> Option<Hit> {
        self.cast_where(ray, triangles, position, |_| true)
    }

    /// The same among hits that `accept` takes: not those that are cut away or hidden.
    pub fn cast_where(
        &self,
        ray: Ray,
        triangles: &[[u32; 3]],
        position: impl Fn(u32) -> Vec3,
        accept: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let inverse = ray.direction.recip();
        let mut stack = Vec::with_capacity(64);
        stack.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let limit = best.map_or(f32::INFINITY, |hit| hit.distance);
            if !meets_box(ray.origin, inverse, node, limit) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.start as usize, index + 1]);
                continue;
            }
            let start = node.start as usize;
            for &triangle in &self.order[start..start + node.count as usize] {
                let corners = triangles[triangle as usize].map(&position);
                let Some(hit) = meets_triangle(ray, corners, triangle) else { continue };
                let is_better = best.is_none_or(|best| {
                    (hit.distance, best.triangle) < (best.distance, hit.triangle)
                });
                if is_better && accept(&hit) {
                    best = Some(hit);
                }
            }
        }
        best
    }
}

fn build(
    nodes: &mut Vec<Node>,
    order: &mut [u32],
    start: usize,
    end: usize,
    boxes: &[(Vec3, Vec3)],
) {
    let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let join = |(low, high): (Vec3, Vec3), i: &u32| {
        let (l, h) = boxes[*i as usize];
        (low.min(l), high.max(h))
    };
    let (low, high) = order[start..end].iter().fold(empty, join);
    let index = nodes.len();
    let count = end - start;
    nodes.push(Node { low, high, start: start as u32, count: count as u32 });
    if count <= LEAF {
        return;
    }
    let axis = (high - low).max_position();
    let key = |i: &u32| {
        let (l, h) = boxes[*i as usize];
        l[axis] + h[axis]
    };
    let middle = start + count / 2;
    order[start..end].select_nth_unstable_by(count / 2, |a, b| key(a).total_cmp(&key(b)));
    build(nodes, order, start, middle, boxes);
    nodes[index].count = 0;
    nodes[index].start = nodes.len() as u32;
    build(nodes, order, middle, end, boxes);
}

/// Slab test. Flat boxes are met because the comparison admits equality.
fn meets_box(origin: Vec3, inverse: Vec3, node: &Node, limit: f32) -> bool {
    let mut enter = 0.0_f32;
    let mut leave = limit;
    for axis in 0..3 {
        let a = (node.low[axis] - origin[axis]) * inverse[axis];
        let b = (node.high[axis] - origin[axis]) * inverse[axis];
        // 0 × ∞: along the face of the box, which belongs to it.
        if a.is_nan() || b.is_nan() {
            continue;
        }
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter <= leave
}

/// Möller and Trumbore's test, both sides.
fn meets_triangle(ray: Ray, [a, b, c]: [Vec3; 3], triangle: u32) -> Option<Hit> {
    let (ab, ac) = (b - a, c - a);
    let p = ray.direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let to_origin = ray.origin - a;
    let v = to_origin.dot(p) / determinant;
    let q = to_origin.cross(ab);
    let w = ray.direction.dot(q) / determinant;
    let distance = ac.dot(q) / determinant;
    let inside = v >= 0.0 && w >= 0.0 && v + w <= 1.0 && distance >= 0.0;
    inside.then_some(Hit { triangle, distance, weights: [1.0 - v - w, v, w] })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A height field of `2 n²` triangles over the unit square.
    fn hills(n: u32) -> (Vec<[u32; 3]>, Vec<Vec3>) {
        let row = n + 1;
        let points = (0..row * row)
            .map(|i| {
                let (x, y) = ((i % row) as f32 / n as f32, (i / row) as f32 / n as f32);
                Vec3::new(x, y, 0.1 * (7.0 * x).sin() * (5.0 * y).cos())
            })
            .collect();
        let triangles = (0..n * n)
            .flat_map(|i| {
                let corner = i / n * row + i % n;
                [[corner, corner + 1, corner + row + 1], [corner, corner + row + 1, corner + row]]
            })
            .collect();
        (triangles, points)
    }

    #[test]
    fn the_tree_finds_what_trying_every_triangle_finds() {
        let (triangles, points) = hills(12);
        let position = |i: u32| points[i as usize];
        let tree = Hierarchy::new(&triangles, position);
        for i in 0..400 {
            let x = (i as f32 * 0.618).fract() * 1.2 - 0.1;
            let y = (i as f32 * 0.383).fract() * 1.2 - 0.1;
            let origin = Vec3::new(x, y, 3.0);
            let direction = Vec3::new((y - x) * 0.3, (x * y - 0.4) * 0.2, -1.0);
            let ray = Ray { origin, direction };
            let slow = triangles
                .iter()
                .zip(0..)
                .filter_map(|(corners, i)| meets_triangle(ray, corners.map(position), i))
                .map(|hit| hit.distance)
                .min_by(f32::total_cmp);
            assert_eq!(tree.cast(ray, &triangles, position).map(|hit| hit.distance), slow);
        }
    }

    #[test]
    fn weights_rebuild_the_point_and_a_ray_straight_down_meets_a_flat_sheet() {
        let (triangles, mut points) = hills(8);
        points.iter_mut().for_each(|point| point.z = 0.0);
        let position = |i: u32| points[i as usize];
        let tree = Hierarchy::new(&triangles, position);
        // On a grid line as well, where the slabs of the boxes are grazed.
        for target in [Vec3::new(0.31, 0.77, 0.0), Vec3::new(0.5, 0.25, 0.0)] {
            let ray = Ray { origin: target + Vec3::Z, direction: Vec3::NEG_Z };
            let hit = tree.cast(ray, &triangles, position).expect("the sheet is under the pointer");
            let corners = triangles[hit.triangle as usize].map(position);
            let point: Vec3 = corners.iter().zip(hit.weights).map(|(&p, w)| p * w).sum();
            assert!(point.distance(target) < 1e-6);
        }
        let beside = Ray { origin: Vec3::new(1.5, 0.5, 1.0), direction: Vec3::NEG_Z };
        assert_eq!(tree.cast(beside, &triangles, position), None);
    }

    #[test]
    fn of_two_triangles_in_one_place_the_one_drawn_last_is_met() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let position = |i: u32| points[i as usize];
        let triangles = [[0, 1, 2], [0, 2, 1], [1, 2, 0]];
        let tree = Hierarchy::new(&triangles, position);
        let ray = Ray { origin: Vec3::new(0.2, 0.2, 1.0), direction: Vec3::NEG_Z };
        assert_eq!(tree.cast(ray, &triangles, position).map(|hit| hit.triangle), Some(2));
    }

    #[test]
    fn a_ray_goes_on_through_what_is_not_accepted() {
        let points =
            [0.0, 1.0, 2.0].map(|z| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p + z * Vec3::Z));
        let position = |i: u32| points.as_flattened()[i as usize];
        let triangles = [[0, 1, 2], [3, 4, 5], [6, 7, 8]];
        let tree = Hierarchy::new(&triangles, position);
        let ray = Ray { origin: Vec3::new(0.2, 0.2, 5.0), direction: Vec3::NEG_Z };
        let met = |accept: &dyn Fn(&Hit) -> bool| {
            tree.cast_where(ray, &triangles, position, accept).map(|hit| hit.triangle)
        };
        assert_eq!(met(&|hit| hit.distance > 3.5), Some(1));
        assert_eq!(met(&|hit| hit.triangle == 0), Some(0));
        assert_eq!(met(&|_| false), None);
    }

    #[test]
    fn triangles_without_a_place_are_never_met() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::NAN];
        let tree = Hierarchy::new(&[[0, 1, 2]], |i| points[i as usize]);
        let ray = Ray { origin: Vec3::Z, direction: Vec3::NEG_Z };
        assert_eq!(tree.cast(ray, &[[0, 1, 2]], |i| points[i as usize]), None);
        let none = Hierarchy::new(&[], |_| Vec3::ZERO);
        assert_eq!(none.cast(ray, &[], |_| Vec3::ZERO), None);
    }
}
