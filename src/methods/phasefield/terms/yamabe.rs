//! The distortion of one phase by its diffuse scale factor.
//!
//! J = sᵀ M s with (S[y] + λ diag((1 − y) m)) s = y K: minus the log scale factor of the conformal flattening whose rim keeps its
//! length, where the phase's indicator y is 1; where it is 0 a penalty holds s at 0. **From** [PF] eq. 12.
//! **Differs**: K is not taken away from, the adjoint has the sign +2, and boundaries of the mesh have s = 0.

use super::super::domain::Domain;
use crate::linalg::{Factor, LinalgError, dot};

/// Keeps the matrix definite where a closed component lies in the phase as a whole, which nothing can flatten.
const FLOOR: f64 = 1e-6;

/// Solver of scale factors, by one analysis and in the same memory.
#[derive(Default)]
pub(in super::super) struct Yamabe {
    factor: Option<Factor>,
    values: Vec<f64>,
}

impl Yamabe {
    /// J of the phase with the indicator `y` at vertices and `y_faces` on faces; adds its gradient by both, times `factor`.
    ///
    /// **Costs** one numeric factorisation and two solves.
    pub fn add(
        &mut self,
        domain: &Domain,
        [y, y_faces]: [&[f64]; 2],
        lambda: f64,
        factor: f64,
        [by_vertex, by_face]: [&mut [f64]; 2],
    ) -> Result<f64, LinalgError> {
        let s = self.solve(domain, [y, y_faces], lambda)?;
        let Some(solver) = &mut self.factor else { return Ok(0.0) };
        let mut l: Vec<f64> = s.iter().zip(&domain.mass).map(|(s, m)| 2.0 * m * s).collect();
        let loss = 0.5 * dot(&s, &l);
        solver.solve(&mut l, 1);
        for v in 0..s.len() {
            if !domain.is_fixed[v] {
                by_vertex[v] +=
                    factor * l[v] * (domain.defects[v] + lambda * domain.mass[v] * s[v]);
            }
        }
        for (f, g) in by_face.iter_mut().enumerate() {
            *g -= factor * domain.face_product(f, &l, &s);
        }
        Ok(loss)
    }

    /// s of a phase. **Costs** one numeric factorisation and one solve.
    pub fn solve(
        &mut self,
        domain: &Domain,
        [y, y_faces]: [&[f64]; 2],
        lambda: f64,
    ) -> Result<Vec<f64>, LinalgError> {
        let pattern = domain.analysis.pattern();
        let mut values = std::mem::take(&mut self.values);
        values.clear();
        values.resize(pattern.entry_count(), 0.0);
        domain.add_stiffness(&mut values, |f| y_faces[f], |v| domain.is_fixed[v]);
        let mut s = vec![0.0; domain.len()];
        for v in 0..domain.len() {
            if domain.is_fixed[v] {
                values[pattern.diagonal(v)] = 1.0;
            } else {
                values[pattern.diagonal(v)] += lambda * (1.0 - y[v] + FLOOR) * domain.mass[v];
                s[v] = y[v] * domain.defects[v];
            }
        }
        match &mut self.factor {
            Some(solver) => solver.refactor(&values)?,
            none => *none = Some(Factor::new(domain.analysis.clone(), &values)?),
        }
        self.values = values;
        if let Some(solver) = &mut self.factor {
            solver.solve(&mut s, 1);
        }
        Ok(s)
    }
}
