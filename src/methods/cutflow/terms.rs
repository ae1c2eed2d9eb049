//! The terms of the objective: what a cut pays for.

use std::sync::Arc;

use crate::geometry::SymmetryMap;
use crate::methods::flow::SolveError;

/// What is integrated of the log scale factor besides its gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pointwise {
    /// b(u) = u²: the Hencky energy.
    #[default]
    Square,
    /// b(u) = u⁴: few places of large distortion cost more than many of small.
    Fourth,
    /// b(u) = |u|ᵖ, p > 1: between the mean and the largest distortion.
    Power(f64),
    /// b(u) = max(u, 0)²: charts that are larger than the surface, material that has to shrink or to fold.
    Stretch,
    /// b(u) = min(u, 0)²: charts that are smaller than the surface, material that has to stretch.
    Compress,
}

impl Pointwise {
    /// b(u).
    pub fn value(self, u: f64) -> f64 {
        match self {
            Self::Square => u * u,
            Self::Fourth => u.powi(4),
            Self::Power(p) => u.abs().powf(p),
            Self::Stretch => u.max(0.0).powi(2),
            Self::Compress => u.min(0.0).powi(2),
        }
    }

    /// b′(u).
    pub fn slope(self, u: f64) -> f64 {
        match self {
            Self::Square => 2.0 * u,
            Self::Fourth => 4.0 * u.powi(3),
            Self::Power(p) => p * u.abs().powf(p - 1.0) * u.signum(),
            Self::Stretch => 2.0 * u.max(0.0),
            Self::Compress => 2.0 * u.min(0.0),
        }
    }

    /// Mean of b over a triangle in which u is linear, and the derivatives of that mean by u's values at the corners.
    ///
    /// Exact for polynomials up to the fourth degree; otherwise the derivative is exact for the rule, so that a descent keeps
    /// its word.
    pub(super) fn mean(self, [a, b, c]: [f64; 3]) -> (f64, [f64; 3]) {
        if self == Self::Square {
            let sum = a + b + c;
            return (mean_square([a, b, c]), [a, b, c].map(|x| (x + sum) / 6.0));
        }
        // Six points of degree 4: two orbits of three.
        const ORBITS: [(f64, f64); 2] = [
            (0.445_948_490_915_964_9, 0.223_381_589_678_011_46),
            (0.091_576_213_509_770_74, 0.109_951_743_655_321_87),
        ];
        let sum = a + b + c;
        let (mut mean, mut slopes) = (0.0, [0.0; 3]);
        for (near, weight) in ORBITS {
            let far = 1.0 - 2.0 * near;
            for i in 0..3 {
                let u = near * sum + (far - near) * [a, b, c][i];
                mean += weight * self.value(u);
                let slope = weight * self.slope(u);
                for (k, s) in slopes.iter_mut().enumerate() {
                    *s += slope * if k == i { far } else { near };
                }
            }
        }
        (mean, slopes)
    }
}

/// Mean of u² over a triangle in which u is linear, by its values at the corners.
#[inline]
pub(super) fn mean_square([a, b, c]: [f64; 3]) -> f64 {
    let sum = a + b + c;
    (a * a + b * b + c * c + sum * sum) / 12.0
}

/// Weights of the objective, for a surface of unit area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights {
    /// w_D of ∫|∇u|², or of ∫r³|∇u|² where it is rescaled.
    pub dirichlet: f64,
    /// w_H of ∫b(u).
    pub hencky: f64,
    /// α of the cut's length.
    pub length: f64,
    /// b.
    pub pointwise: Pointwise,
    /// Whether the Dirichlet energy is rescaled by the cube of the intrinsic feature size r: what is tightly curved counts less,
    /// and the flow is as fast there as elsewhere.
    pub rescaled: bool,
    /// Weight of ∫_γ η, the penalty of places where a cut is not wanted.
    pub penalty: f64,
    /// Reward of the area of region 0.
    pub area: f64,
    /// Whether distortion counts in region 0 only.
    pub one_sided: bool,
}

impl Weights {
    /// J of measured terms.
    pub fn total(&self, energy: &Energy) -> f64 {
        self.distortion(energy) + self.length * energy.length + self.penalty * energy.penalty
            - self.area * energy.area
    }

    /// The part of J that flattening costs.
    pub fn distortion(&self, energy: &Energy) -> f64 {
        let dirichlet = if self.rescaled { energy.rescaled } else { energy.dirichlet };
        let hencky =
            if self.pointwise == Pointwise::Square { energy.hencky } else { energy.pointwise };
        self.dirichlet * dirichlet + self.hencky * hencky
    }

    /// Whether terms measured under the other weights can be weighed by these: only factors differ.
    pub fn measures_like(&self, other: &Self) -> bool {
        self.pointwise == other.pointwise
            && self.rescaled == other.rescaled
            && self.one_sided == other.one_sided
            && (self.area > 0.0) == (other.area > 0.0)
    }
}

/// The objective and its terms (unweighted).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// J.
    pub total: f64,
    /// Σ ∫|∇u|².
    pub dirichlet: f64,
    /// Σ ∫r³|∇u|²; 0 where it is not asked for.
    pub rescaled: f64,
    /// Σ ∫u².
    pub hencky: f64,
    /// Σ ∫b(u); 0 where b(u) = u².
    pub pointwise: f64,
    /// |γ|.
    pub length: f64,
    /// ∫_γ η.
    pub penalty: f64,
    /// Area of region 0; 0 where it does not count.
    pub area: f64,
}

/// What the flow reads on the surface besides its shape.
#[derive(Clone, Debug, Default)]
pub struct CutFields {
    /// What drives u.
    pub source: Source,
    /// η at the vertices, linear between them; empty for none.
    pub penalty: Vec<f64>,
    /// How far each vertex holds the cut beside it, from 0 (free) to 1 (still); empty for nowhere.
    pub pins: Vec<f64>,
    /// The symmetries that the cut keeps: a group without the identity. Acts from a new start on.
    pub symmetry: Arc<Vec<SymmetryMap>>,
}

impl CutFields {
    /// Checks shapes and ranges for a surface with that many vertices.
    pub fn validate(&self, vertex_count: usize) -> Result<(), SolveError> {
        let check = |name, values: &[f64], max: f64| {
            if values.len() != vertex_count {
                let (value, count) = (values.len() as f64, vertex_count as f64);
                return Err(SolveError::Parameter { name, value, min: count, max: count });
            }
            match values.iter().find(|x| !(**x >= 0.0 && **x <= max)) {
                Some(&value) => Err(SolveError::Parameter { name, value, min: 0.0, max }),
                None => Ok(()),
            }
        };
        if !self.penalty.is_empty() {
            check("penalty", &self.penalty, 1e6)?;
        }
        if !self.pins.is_empty() {
            check("pin", &self.pins, 1.0)?;
        }
        if let Source::Heat(density) = &self.source {
            check("heat", density, 1e12)?;
            if !density.iter().any(|x| *x > 0.0) {
                return Err(SolveError::NoSource);
            }
        }
        Ok(())
    }
}

/// K in Δu = −K.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Source {
    /// The Gaussian curvature: u is the log scale factor of the conformal flattening.
    #[default]
    Curvature,
    /// The same everywhere, 4π in all (that of a ball): cuts of uniform density, space-filling curves.
    Uniform,
    /// Proportional to a density at the vertices, none negative, 4π in all: u is the temperature of a surface that is heated so
    /// and cooled along the cut.
    Heat(Vec<f64>),
}
