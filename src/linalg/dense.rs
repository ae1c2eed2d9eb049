//! Small dense symmetric positive definite systems whose rows come and go: a Cholesky factor that is updated, not made anew.

use super::vector::dot;

/// The factor C of a dense matrix A = C Cᵀ, row by row.
///
/// **Guaranteed**: no shift is added. **Not guaranteed**: accuracy for ill-conditioned matrices; callers measure residuals.
#[derive(Clone, Debug, Default)]
pub struct DenseCholesky {
    /// Row `i` has i + 1 entries.
    rows: Vec<Vec<f64>>,
}

impl DenseCholesky {
    /// The factor of the matrix without rows.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether the matrix has no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Borders the matrix by one row and column.
    ///
    /// **Takes** the last row of the new matrix, diagonal last. **Gives** whether that is still positive definite; if not,
    /// nothing has changed. **Costs** n²/2.
    pub fn push(&mut self, row: &[f64]) -> bool {
        let n = self.rows.len();
        assert_eq!(row.len(), n + 1);
        let mut new = Vec::with_capacity(n + 1);
        for i in 0..n {
            let known = &self.rows[i];
            let sum = dot(&known[..i], &new);
            new.push((row[i] - sum) / known[i]);
        }
        let rest = row[n] - dot(&new, &new);
        // A pivot below the rounding errors of its own row has no digit.
        if !(rest > 4.0 * f64::EPSILON * row[n]) {
            return false;
        }
        new.push(rest.sqrt());
        self.rows.push(new);
        true
    }

    /// Takes row and column `index` out of the matrix. **Costs** (n − index)² · 3.
    pub fn remove(&mut self, index: usize) {
        self.rows.remove(index);
        let mut turns: Vec<[f64; 2]> = Vec::with_capacity(self.rows.len() - index);
        for i in index..self.rows.len() {
            let row = &mut self.rows[i];
            for (k, &[c, s]) in turns.iter().enumerate() {
                let (a, b) = (row[index + k], row[index + k + 1]);
                row[index + k] = c * a + s * b;
                row[index + k + 1] = c * b - s * a;
            }
            let (a, b) = (row[i], row[i + 1]);
            let length = a.hypot(b);
            turns.push([a / length, b / length]);
            row[i] = length;
            row.pop();
        }
    }

    /// Solves A x = b in place. **Costs** 2 n².
    pub fn solve(&self, x: &mut [f64]) {
        assert_eq!(x.len(), self.rows.len());
        for (i, row) in self.rows.iter().enumerate() {
            x[i] = (x[i] - dot(&row[..i], &x[..i])) / row[i];
        }
        for (i, row) in self.rows.iter().enumerate().rev() {
            x[i] /= row[i];
            let value = x[i];
            for (target, entry) in x[..i].iter_mut().zip(row) {
                *target -= entry * value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(i: usize, j: usize) -> f64 {
        // A Gaussian kernel: positive definite, and badly conditioned enough to notice a wrong rotation.
        (-0.3 * (i as f64 - j as f64).powi(2)).exp()
    }

    #[test]
    fn rows_that_came_and_went_leave_the_factor_of_the_rest() {
        let mut factor = DenseCholesky::new();
        let mut members = Vec::new();
        for i in 0..14 {
            members.push(i);
            let row: Vec<f64> = members.iter().map(|&j| entry(i, j)).collect();
            assert!(factor.push(&row));
            if i % 3 == 2 {
                let index = (5 * i) % members.len();
                members.remove(index);
                factor.remove(index);
            }
        }
        let n = members.len();
        let solution: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
        let mut x: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| entry(members[i], members[j]) * solution[j]).sum())
            .collect();
        factor.solve(&mut x);
        // Condition number below 1e3.
        assert!(x.iter().zip(&solution).all(|(a, b)| (a - b).abs() < 1e-11), "{x:?}");
    }

    #[test]
    fn a_row_that_depends_on_the_others_is_refused() {
        let mut factor = DenseCholesky::new();
        assert!(factor.push(&[2.0]));
        assert!(!factor.push(&[2.0, 2.0]));
        assert_eq!(factor.len(), 1);
        assert!(factor.push(&[2.0, 2.5]));
    }
}
