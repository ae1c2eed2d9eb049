//! The diffuse length of the interface (Modica–Mortola) inside a segment, and the penalty that keeps a field at 0 outside.
//!
//! P = ε/2 Σ_f (w_f + η) u_fᵀ kᶠ u_f + 1/ε Σ m w Ψ(u), and 1/σ Σ m (1 − w) u². P tends to √2 times the length of the interface as
//! ε does to 0. **From** [PF] eq. 9.

use super::super::domain::Domain;
use super::super::profile::well;
use crate::linalg::{dot, sums};

/// Keeps the matrix definite outside of the segment; any small number does.
const ETA: f64 = 1e-6;

/// Both terms for one weight w.
#[derive(Clone)]
pub(in super::super) struct Perimeter {
    /// ε S^w on the mesh's pattern.
    stiffness: Vec<f64>,
    /// m w / ε.
    wells: Vec<f64>,
    /// m (1 − w) / σ.
    outside: Vec<f64>,
}

impl Perimeter {
    /// Assembles for a weight at the vertices.
    pub fn new(domain: &Domain, weight: &[f64], epsilon: f64, sigma: f64) -> Self {
        let mut stiffness = vec![0.0; domain.analysis.pattern().entry_count()];
        let factor = |f: usize| {
            let t = domain.triangles[f].map(|v| weight[v as usize]);
            epsilon * ((t[0] + t[1] + t[2]) / 3.0 + ETA)
        };
        domain.add_stiffness(&mut stiffness, factor, |_| false);
        let mass = &domain.mass;
        Self {
            stiffness,
            wells: mass.iter().zip(weight).map(|(m, w)| m * w / epsilon).collect(),
            outside: mass.iter().zip(weight).map(|(m, w)| m * (1.0 - w) / sigma).collect(),
        }
    }

    /// P and the penalty; adds the gradient of their sum. **Costs** one product of matrix and vector.
    pub fn add(&self, domain: &Domain, u: &[f64], gradient: &mut [f64]) -> [f64; 2] {
        let mut product = vec![0.0; u.len()];
        domain.analysis.pattern().multiply(&self.stiffness, u, &mut product);
        let rows = self.wells.iter().zip(&self.outside).zip(u.iter().zip(&product));
        for (g, ((wells, outside), (&u, product))) in gradient.iter_mut().zip(rows) {
            *g += product + wells * well(u).1 + 2.0 * outside * u;
        }
        let (n, wells, outside) = (u.len(), &self.wells[..u.len()], &self.outside[..u.len()]);
        let [wells, penalty] = sums(n, |i| [wells[i] * well(u[i]).0, outside[i] * u[i] * u[i]]);
        [0.5 * dot(u, &product) + wells, penalty]
    }

    /// Adds the gradient of the sum by the weight.
    pub fn add_by_weight(
        domain: &Domain,
        u: &[f64],
        epsilon: f64,
        sigma: f64,
        gradient: &mut [f64],
    ) {
        for (f, t) in domain.triangles.iter().enumerate() {
            let third = epsilon / 6.0 * domain.face_product(f, u, u);
            for v in t {
                gradient[*v as usize] += third;
            }
        }
        for ((g, m), &u) in gradient.iter_mut().zip(&domain.mass).zip(u) {
            *g += m * (well(u).0 / epsilon - u * u / sigma);
        }
    }

    /// The curvature of the sum at u = ±1 for one vertex alone: what L-BFGS starts from.
    pub fn curvature(&self, domain: &Domain, i: usize) -> f64 {
        let diagonal = self.stiffness[domain.analysis.pattern().diagonal(i)];
        diagonal + 4.5 * self.wells[i] + 2.0 * self.outside[i]
    }
}
