//! From the final triangulation back to the given one, by taking flips back without looking at shapes.
//!
//! Every face is laid flat in a frame of its own: a complex number z for each halfedge, and a turn r that takes the frame across the
//! edge to its own. To take a flip back, the two faces are brought to one frame, and the edge that was there before is the sum of two
//! sides. No quad contains a cone, so that this is a straight chord in the class of paths of the edge that it stands for, wherever it
//! runs. What comes out are triangles that may lie on their backs.
//!
//! Guaranteed: sides of triangles that share an edge are equal to rounding, across seams too; signed angles about a vertex add up to
//! what they do in the flat metric.

use nalgebra::Complex;

use super::triangle::Triangle;
use super::triangulation::{NONE, Triangulation};

/// A halfedge laid flat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Developed {
    /// From its tail to its tip in the frame of its face.
    pub z: Complex<f64>,
    /// Unit number that takes vectors from the frame of the face across to this one.
    pub r: Complex<f64>,
}

/// Every halfedge of the connectivity before all flips, flat as in the metric scaled by v. **Costs** O(F + flips).
pub(super) fn rewind(triangulation: &Triangulation, v: &[f64]) -> Vec<Developed> {
    let mut tri = triangulation.clone();
    let one = Complex::new(1.0, 0.0);
    let mut out = vec![Developed { z: Complex::new(0.0, 0.0), r: one }; tri.tail.len()];
    let x = tri.scaled(v);
    for f in 0..tri.face_count() {
        let sides = tri.sides(f);
        for (h, z) in sides.into_iter().zip(lay(sides.map(|h| x[(h >> 1) as usize]))) {
            out[h as usize].z = z;
        }
    }
    for e in (0..tri.edge_count()).filter(|e| !tri.is_boundary(*e)) {
        let turn = unit(-(out[2 * e].z * out[2 * e + 1].z.conj()));
        out[2 * e].r = turn;
        out[2 * e + 1].r = turn.conj();
    }
    while let Some(h) = tri.flipped.pop() {
        let t = h ^ 1;
        let (b, c) = (tri.next(t), tri.prev(t));
        let (d, a) = (tri.next(h), tri.prev(h));
        debug_assert!(tri.face[h as usize] != NONE && tri.face[t as usize] != NONE && a != d);
        let turn = out[h as usize].r;
        for q in [t, b, c] {
            out[q as usize].z *= turn;
            out[q as usize].r *= turn;
            out[(q ^ 1) as usize].r *= turn.conj();
        }
        tri.unflip(h);
        let z = -(out[a as usize].z + out[b as usize].z);
        out[h as usize] = Developed { z, r: one };
        out[t as usize] = Developed { z: -z, r: one };
    }
    out
}

/// A triangle in the plane by its log side lengths: its three sides, counter-clockwise.
fn lay(x: [f64; 3]) -> [Complex<f64>; 3] {
    let angles = Triangle::new(x).angles;
    let base = (1..3).fold(0, |best, i| if x[i] > x[best] { i } else { best });
    let [second, third] = [(base + 1) % 3, (base + 2) % 3];
    let mut z = [Complex::new(0.0, 0.0); 3];
    z[base] = Complex::new(x[base].exp(), 0.0);
    // The shortest side by its own length and direction: as a difference of the others it would lose digits.
    if x[second] < x[third] {
        z[second] = Complex::from_polar(x[second].exp(), std::f64::consts::PI - angles[third]);
        z[third] = -(z[base] + z[second]);
    } else {
        z[third] = -Complex::from_polar(x[third].exp(), angles[second]);
        z[second] = -(z[base] + z[third]);
    }
    z
}

/// A number of length 1; 1 where there is no direction.
pub(super) fn unit(z: Complex<f64>) -> Complex<f64> {
    let size = z.norm();
    if size > 0.0 && size.is_finite() { z / size } else { Complex::new(1.0, 0.0) }
}
