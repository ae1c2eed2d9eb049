//! Triangulations whose edges flip, by halfedges with `twin(h) = h ^ 1`: pairs of vertices may have several edges, an edge may join a
//! vertex to itself, a vertex may have one edge only. All of that comes up and needs no case of its own.
//!
//! A flip writes the halfedge into a log, and the log read backwards leads to the connectivity that was given, with the same numbers.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::triangle::Triangle;

pub(super) const NONE: u32 = u32::MAX;

/// By how much the two cosines opposite an edge may add up to less than 0. Without it edges between points on one circle would flip
/// to and fro.
const COCIRCULAR: f64 = 1e-11;

/// Flips beyond this many per edge in one go would be an endless loop, which exact arithmetic excludes and rounding might not.
const FLIPS_PER_EDGE: usize = 200;

/// What a flip leaves as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keeps {
    /// The polyhedral metric: the other diagonal of the two triangles unfolded.
    Surface,
    /// The hyperbolic metric, the same for all scale factors: Ptolemy's theorem, as if the four corners lay on a circle.
    Conformal,
}

/// Connectivity and unscaled log lengths.
#[derive(Clone, Debug, Default)]
pub(super) struct Triangulation {
    pub next: Vec<u32>,
    pub tail: Vec<u32>,
    /// `NONE` outside.
    pub face: Vec<u32>,
    pub face_halfedge: Vec<u32>,
    /// Log length of every edge.
    pub x: Vec<f64>,
    /// The halfedges that were flipped, in order.
    pub flipped: Vec<u32>,
    /// How many of them kept the surface; they come first.
    pub surface_flips: usize,
}

impl Triangulation {
    pub fn edge_count(&self) -> usize {
        self.x.len()
    }

    pub fn face_count(&self) -> usize {
        self.face_halfedge.len()
    }

    pub fn tip(&self, h: u32) -> u32 {
        self.tail[(h ^ 1) as usize]
    }

    pub fn next(&self, h: u32) -> u32 {
        self.next[h as usize]
    }

    pub fn prev(&self, h: u32) -> u32 {
        self.next(self.next(h))
    }

    /// The halfedges of a face.
    pub fn sides(&self, f: usize) -> [u32; 3] {
        let h = self.face_halfedge[f];
        [h, self.next(h), self.prev(h)]
    }

    /// Whether an edge lies between two different faces.
    pub fn is_flippable(&self, e: usize) -> bool {
        let [f, g] = [self.face[2 * e], self.face[2 * e + 1]];
        f != NONE && g != NONE && f != g
    }

    pub fn is_boundary(&self, e: usize) -> bool {
        self.face[2 * e] == NONE || self.face[2 * e + 1] == NONE
    }

    /// Log lengths after scaling: x + (v_i + v_j) / 2.
    pub fn scaled(&self, v: &[f64]) -> Vec<f64> {
        self.x
            .iter()
            .enumerate()
            .map(|(e, x)| {
                let [i, j] = [self.tail[2 * e], self.tail[2 * e + 1]];
                x + 0.5 * (v[i as usize] + v[j as usize])
            })
            .collect()
    }

    /// Lengths after scaling. Steps are bounded, and so are logarithms: what goes beyond the range of numbers anyway makes NaN of its triangles.
    pub fn scaled_lengths(&self, v: &[f64]) -> Vec<f64> {
        let mut lengths = self.scaled(v);
        lengths.iter_mut().for_each(|x| *x = x.exp());
        lengths
    }

    /// Exchanges the edge of h: i → j for the one from the corner on its left to the corner on its right: h becomes k → l.
    fn flip(&mut self, h: u32) {
        let t = h ^ 1;
        let (a, b) = (self.next(h), self.prev(h));
        let (c, d) = (self.next(t), self.prev(t));
        let (f, g) = (self.face[h as usize], self.face[t as usize]);
        self.tail[h as usize] = self.tail[b as usize];
        self.tail[t as usize] = self.tail[d as usize];
        for cycle in [[d, a, h], [b, c, t]] {
            self.link(cycle);
        }
        self.face[d as usize] = f;
        self.face[b as usize] = g;
        self.face_halfedge[f as usize] = h;
        self.face_halfedge[g as usize] = t;
    }

    /// Takes the flip of h back.
    pub fn unflip(&mut self, h: u32) {
        let t = h ^ 1;
        let (b, c) = (self.next(t), self.prev(t));
        let (d, a) = (self.next(h), self.prev(h));
        let (f, g) = (self.face[h as usize], self.face[t as usize]);
        self.tail[h as usize] = self.tail[c as usize];
        self.tail[t as usize] = self.tail[a as usize];
        for cycle in [[h, a, b], [t, c, d]] {
            self.link(cycle);
        }
        self.face[b as usize] = f;
        self.face[d as usize] = g;
        self.face_halfedge[f as usize] = h;
        self.face_halfedge[g as usize] = t;
    }

    fn link(&mut self, [p, q, r]: [u32; 3]) {
        self.next[p as usize] = q;
        self.next[q as usize] = r;
        self.next[r as usize] = p;
    }

    /// Flips until every edge is Delaunay in the metric scaled by v, edges that cannot flip apart.
    ///
    /// The criterion, cos + cos ≥ 0 of the angles opposite, needs no triangle inequality. **Gives** whether it came to an end.
    pub fn make_delaunay(&mut self, v: &[f64], keeps: Keeps) -> bool {
        let mut lengths = self.scaled_lengths(v);
        let mut is_queued = vec![false; self.edge_count()];
        // First in, first out: a stack would make long detours across slivers.
        let mut queue = std::collections::VecDeque::new();
        for e in 0..self.edge_count() {
            if self.wants_flip(&lengths, e) {
                is_queued[e] = true;
                queue.push_back(e as u32);
            }
        }
        let mut left = FLIPS_PER_EDGE * self.edge_count();
        while let Some(e) = queue.pop_front() {
            let e = e as usize;
            is_queued[e] = false;
            if !self.wants_flip(&lengths, e) {
                continue;
            }
            if left == 0 {
                return false;
            }
            left -= 1;
            let h = 2 * e as u32;
            let t = h ^ 1;
            let around = [self.next(h), self.prev(h), self.next(t), self.prev(t)];
            let x = |h: u32| {
                let [i, j] = [self.tail[h as usize], self.tip(h)];
                self.x[(h >> 1) as usize] + 0.5 * (v[i as usize] + v[j as usize])
            };
            let [a, b, c, d] = around.map(x);
            let scaled = match keeps {
                Keeps::Conformal => log_add(a + c, b + d) - x(h),
                Keeps::Surface => unfolded(x(h), [a, b, c, d]),
            };
            self.flip(h);
            let [k, l] = [self.tail[h as usize], self.tail[t as usize]];
            lengths[e] = scaled.exp();
            self.x[e] = scaled - 0.5 * (v[k as usize] + v[l as usize]);
            self.flipped.push(h);
            self.surface_flips += usize::from(keeps == Keeps::Surface);
            for side in around {
                let side = side >> 1;
                if !std::mem::replace(&mut is_queued[side as usize], true) {
                    queue.push_back(side);
                }
            }
        }
        true
    }

    fn wants_flip(&self, lengths: &[f64], e: usize) -> bool {
        if !self.is_flippable(e) {
            return false;
        }
        let c = lengths[e];
        let cosine = |h: u32| {
            let a = lengths[(self.next(h) >> 1) as usize];
            let b = lengths[(self.prev(h) >> 1) as usize];
            // (a² + b² − c²) / 2ab, in quotients that stay within the range of numbers.
            1.0 + 0.5 * (((a - b) - c) / a) * (((a - b) + c) / b)
        };
        let h = 2 * e as u32;
        // Not `!(≥)`: what is no number does not flip.
        cosine(h) + cosine(h ^ 1) < -COCIRCULAR
    }
}

/// ln (eᵃ + eᵇ).
fn log_add(a: f64, b: f64) -> f64 {
    let (high, low) = if a > b { (a, b) } else { (b, a) };
    high + (low - high).exp().ln_1p()
}

/// Log length of the other diagonal of two triangles unfolded across side ij: i, j, k with sides jk, ki and j, i, l with sides il, lj.
fn unfolded(x: f64, [jk, ki, il, lj]: [f64; 4]) -> f64 {
    // At j, opposite ki and il.
    let at_j = Triangle::new([x, jk, ki]).angles[2] + Triangle::new([x, lj, il]).angles[2];
    let largest = jk.max(lj);
    let (p, q) = ((jk - largest).exp(), (lj - largest).exp());
    // A sum of squares does not lose the digits of a short diagonal.
    let squared = (p - q).powi(2) + 4.0 * p * q * (0.5 * at_j).sin().powi(2);
    largest + 0.5 * squared.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles 0 1 2 and 1 0 3 in the plane, glued along 0–1.
    fn quad(places: [[f64; 2]; 4]) -> Triangulation {
        let length = |i: usize, j: usize| {
            let [p, q] = [places[i], places[j]];
            (p[0] - q[0]).hypot(p[1] - q[1]).ln()
        };
        Triangulation {
            // 0: 0→1, 2: 1→2, 4: 2→0, 6: 0→3, 8: 3→1.
            tail: vec![0, 1, 1, 2, 2, 0, 0, 3, 3, 1],
            next: vec![2, 6, 4, NONE, 0, NONE, 8, NONE, 1, NONE],
            face: vec![0, 1, 0, NONE, 0, NONE, 1, NONE, 1, NONE],
            face_halfedge: vec![0, 1],
            x: vec![length(0, 1), length(1, 2), length(2, 0), length(0, 3), length(3, 1)],
            ..Triangulation::default()
        }
    }

    #[test]
    fn a_flip_taken_back_leaves_what_was_there() {
        let before = quad([[0.0, 0.0], [4.0, 0.0], [2.0, 1.0], [2.0, -1.0]]);
        for h in [0, 1] {
            let mut after = before.clone();
            after.flip(h);
            assert_eq!(
                [after.tail[h as usize], after.tip(h)],
                if h == 0 { [2, 3] } else { [3, 2] }
            );
            for f in 0..2 {
                assert!(after.sides(f).iter().all(|&s| after.face[s as usize] == f as u32));
            }
            after.unflip(h);
            assert_eq!(
                (&after.next, &after.tail, &after.face),
                (&before.next, &before.tail, &before.face)
            );
        }
    }

    #[test]
    fn both_lengths_of_the_other_diagonal_agree_on_a_circle_and_only_there() {
        for (apex, same) in [(1.0, true), (0.6, false)] {
            // A long diagonal of a kite; with apex 1 it is a square.
            let kite = quad([[-1.0, 0.0], [1.0, 0.0], [0.0, apex], [0.0, -apex]]);
            let x = [0, 1, 2, 3, 4].map(|e| kite.x[e]);
            let around = [x[1], x[2], x[3], x[4]];
            let euclid = unfolded(x[0], around).exp();
            let ptolemy = (log_add(x[1] + x[3], x[2] + x[4]) - x[0]).exp();
            assert!((euclid - 2.0 * apex).abs() < 1e-15, "{euclid}");
            assert_eq!((euclid - ptolemy).abs() < 1e-15, same, "{ptolemy}");
        }
    }

    #[test]
    fn the_long_diagonal_of_a_kite_flips_and_that_of_a_square_does_not() {
        let mut kite = quad([[-1.0, 0.0], [1.0, 0.0], [0.0, 0.6], [0.0, -0.6]]);
        assert!(kite.make_delaunay(&[0.0; 4], Keeps::Surface));
        assert_eq!((kite.flipped.len(), kite.surface_flips), (1, 1));
        assert!((kite.x[0].exp() - 1.2).abs() < 1e-15);
        let mut square = quad([[-1.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]);
        assert!(square.make_delaunay(&[0.0; 4], Keeps::Conformal));
        assert!(square.flipped.is_empty());
    }
}
