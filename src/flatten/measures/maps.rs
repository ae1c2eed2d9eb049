//! The linear maps of many faces at once, in vectors as wide as the processor has.

use nalgebra::Point2;

use super::super::overlap::orientation;
use crate::linalg::widely;

/// Faces at once: enough for wide vectors, and all of it stays in the nearest memory.
pub(super) const BLOCK: usize = 64;

/// A value for each face of a block.
type Lanes = [f64; BLOCK];

/// Area over the square of the longest side below which a face's cotangents are not those of its shape.
const FLAT: f64 = 1e-8;

/// Rounding of twice an area in the plane over its two products: twice Shewchuk's bound.
const ROUNDING: f64 = 6.7e-16;

/// A face on the surface.
pub(super) struct Face {
    pub area: f64,
    pub sides: [f64; 3],
    /// At its first corner.
    pub angle: f64,
    pub cotangent: f64,
}

impl Face {
    /// The third corner in the plane of the face, where the first is 0 and the second lies on the first axis.
    fn third(&self) -> [f64; 2] {
        let longest = self.sides.iter().fold(0.0, |m: f64, &side| m.max(side));
        if self.area > FLAT * longest * longest {
            let height = 2.0 * self.area / self.sides[0];
            [self.cotangent * height, height]
        } else {
            // By its angle: `Geometry::measure` limits cotangents of a face as flat as this.
            let (sin, cos) = self.angle.sin_cos();
            [self.sides[2] * cos, self.sides[2] * sin]
        }
    }
}

/// What the map of a face does.
pub(super) struct FaceMap {
    /// On the surface.
    pub area: f64,
    /// In the plane, with its exact sign.
    pub flat_area: f64,
    /// σ₁ and σ₂.
    pub singular_values: [f64; 2],
    /// σ₁ / |σ₂|.
    pub angle: f64,
    /// ½ log(σ₁ |σ₂|).
    pub log_scale: f64,
    /// ½ (σ₁⁻² + σ₂⁻²), and its root.
    pub stretch_squared: f64,
    pub stretch: f64,
    /// ¼ (σ₁² + σ₂² + σ₁⁻² + σ₂⁻²).
    pub symmetric_dirichlet: f64,
}

/// Faces with their corners in the plane, and what their maps do.
pub(super) struct Maps {
    areas: Lanes,
    bases: Lanes,
    thirds: [Lanes; 2],
    corners: [[Lanes; 2]; 3],
    singular_values: [Lanes; 2],
    /// σ₁ |σ₂|.
    products: Lanes,
    angles: Lanes,
    stretches: [Lanes; 2],
    symmetric_dirichlet: Lanes,
    /// Twice the areas in the plane, and their rounding.
    doubled: [Lanes; 2],
}

impl Maps {
    pub fn new() -> Self {
        const NONE: Lanes = [0.0; BLOCK];
        Self {
            areas: NONE,
            bases: NONE,
            thirds: [NONE; 2],
            corners: [[NONE; 2]; 3],
            singular_values: [NONE; 2],
            products: NONE,
            angles: NONE,
            stretches: [NONE; 2],
            symmetric_dirichlet: NONE,
            doubled: [NONE; 2],
        }
    }

    /// Puts a face and its corners in the plane in a place of the block.
    pub fn put(&mut self, i: usize, face: &Face, corners: [Point2<f64>; 3]) {
        self.areas[i] = face.area;
        self.bases[i] = face.sides[0];
        [self.thirds[0][i], self.thirds[1][i]] = face.third();
        for (lanes, p) in self.corners.iter_mut().zip(corners) {
            (lanes[0][i], lanes[1][i]) = (p.x, p.y);
        }
    }

    /// Computes the maps in all places.
    pub fn compute(&mut self) {
        widely(
            #[inline(always)]
            || self.compute_lanes(),
        );
    }

    #[inline(always)]
    fn compute_lanes(&mut self) {
        for i in 0..BLOCK {
            let [a, b, c] = self.corners.each_ref().map(|[x, y]| [x[i], y[i]]);
            let inverse = 1.0 / self.bases[i];
            let (x, y) = (self.thirds[0][i], self.thirds[1][i]);
            // Derivatives along the first side and across it, as complex numbers.
            let f_x = [0, 1].map(|k| (b[k] - a[k]) * inverse);
            let f_y = [0, 1].map(|k| (c[k] - a[k] - f_x[k] * x) * (1.0 / y));
            let half = |re: f64, im: f64| 0.5 * (re * re + im * im).sqrt();
            let conformal = half(f_x[0] + f_y[1], f_x[1] - f_y[0]);
            let anticonformal = half(f_x[0] - f_y[1], f_x[1] + f_y[0]);
            let (larger, smaller) = (conformal + anticonformal, conformal - anticonformal);
            let product = larger * smaller.abs();
            // One division for all: they are what this costs.
            let inverse = 1.0 / product;
            let squares = larger * larger + smaller * smaller;
            let stretch = 0.5 * squares * inverse * inverse;
            let stretch = if product <= 0.0 { f64::INFINITY } else { stretch };
            (self.singular_values[0][i], self.singular_values[1][i]) = (larger, smaller);
            self.products[i] = product;
            self.angles[i] = larger * larger * inverse;
            (self.stretches[0][i], self.stretches[1][i]) = (stretch, stretch.sqrt());
            self.symmetric_dirichlet[i] = 0.25 * squares + 0.5 * stretch;
            let left = (a[0] - c[0]) * (b[1] - c[1]);
            let right = (a[1] - c[1]) * (b[0] - c[0]);
            self.doubled[0][i] = left - right;
            self.doubled[1][i] = ROUNDING * (left.abs() + right.abs());
        }
    }

    /// What was computed in a place.
    pub fn get(&self, i: usize) -> FaceMap {
        let [doubled, rounding] = [self.doubled[0][i], self.doubled[1][i]];
        let exact = || {
            let [a, b, c] = self.corners.each_ref().map(|[x, y]| Point2::new(x[i], y[i]));
            orientation(a, b, c)
        };
        FaceMap {
            area: self.areas[i],
            flat_area: 0.5 * if doubled.abs() > rounding { doubled } else { exact() },
            singular_values: [self.singular_values[0][i], self.singular_values[1][i]],
            angle: self.angles[i],
            log_scale: 0.5 * self.products[i].ln(),
            stretch_squared: self.stretches[0][i],
            stretch: self.stretches[1][i],
            symmetric_dirichlet: self.symmetric_dirichlet[i],
        }
    }
}
