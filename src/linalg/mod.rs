//! Sparse symmetric positive definite systems: *analyse a pattern once, factor changing values often, solve often.*
//!
//! The floor's problem is A x = b with A = Aᵀ > 0 whose pattern is that of a surface mesh. A fill-reducing ordering and
//! the symbolic factorisation cost about as much as the numbers, so they are a value of their own ([`Analysis`]) that any
//! number of [`Factor`]s share.
//!
//! Guaranteed: no shift is ever added to a matrix; a matrix that is not positive definite is an error that names the row.
//! Not guaranteed: accuracy on ill-conditioned systems; callers who need a certificate check the residual with
//! [`Factor::solve_measured`] or [`Pattern::multiply`].
//!
//! Only the direct way is here, because it won wherever it was measured. On a sphere cut along a wavy curve that moves by a third of
//! an edge, one factorisation and one solve took 13, 77, 351 and 529 ms at 10 k, 41 k, 164 k and 202 k vertices; conjugate gradients from the
//! solution before, preconditioned by an incomplete Cholesky factor of the same pattern, took 26, 202, 1750 and 2410 ms to a
//! residual of 1e-10 (83 to 346 iterations), and 18, 130, 1110 and 1540 ms to 1e-6. A step has up to five solves with one factor.
//!
//! This is the only module that names a linear-algebra crate (faer).

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

mod dense;
mod solve;
mod vector;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};

pub use dense::DenseCholesky;
pub(crate) use vector::{add, dot, sums, widely};

/// What can go wrong on this floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinalgError {
    /// The matrix is not positive definite; elimination met a pivot ≤ 0 (or not a number) in this row.
    #[error("the matrix is not positive definite (row {row})")]
    NotPositiveDefinite {
        /// Row in the caller's numbering.
        row: usize,
    },
    /// Memory for the factor could not be had.
    #[error("out of memory while factoring a matrix of {size} rows")]
    OutOfMemory {
        /// Number of rows.
        size: usize,
    },
}

/// Which entries of a symmetric matrix may be nonzero: its lower triangle, diagonal included, column by column.
///
/// Values live apart, one `f64` for each entry, so that one pattern serves many matrices.
#[derive(Clone, Debug)]
pub struct Pattern {
    size: usize,
    column_starts: Vec<u32>,
    rows: Vec<u32>,
}

impl Pattern {
    /// The pattern with a full diagonal and the given off-diagonal pairs (either order, repeats allowed).
    ///
    /// **Takes** pairs of different indices below `size`. **Gives** the pattern and for each pair the slot of its entry in
    /// the value array.
    pub fn new(size: usize, pairs: &[[u32; 2]]) -> (Self, Vec<u32>) {
        // Two counting sorts: by row, then stably by column. Linear in the number of pairs.
        let ordered = |p: &[u32; 2]| (p[0].min(p[1]) as usize, p[0].max(p[1]) as usize);
        let mut row_starts = vec![0u32; size + 1];
        for pair in pairs {
            row_starts[ordered(pair).1 + 1] += 1;
        }
        for i in 0..size {
            row_starts[i + 1] += row_starts[i];
        }
        let mut by_row = vec![0u32; pairs.len()];
        for (index, pair) in pairs.iter().enumerate() {
            let row = ordered(pair).1;
            by_row[row_starts[row] as usize] = index as u32;
            row_starts[row] += 1;
        }
        let mut starts = vec![0u32; size + 1];
        for pair in pairs {
            starts[ordered(pair).0 + 1] += 1;
        }
        for i in 0..size {
            starts[i + 1] += starts[i];
        }
        let mut by_column = vec![0u32; pairs.len()];
        let mut next = starts.clone();
        for &index in &by_row {
            let column = ordered(&pairs[index as usize]).0;
            by_column[next[column] as usize] = index;
            next[column] += 1;
        }
        let mut column_starts = Vec::with_capacity(size + 1);
        let mut rows: Vec<u32> = Vec::with_capacity(size + pairs.len());
        let mut slots = vec![0u32; pairs.len()];
        for column in 0..size {
            column_starts.push(rows.len() as u32);
            rows.push(column as u32);
            for &index in &by_column[starts[column] as usize..starts[column + 1] as usize] {
                let row = ordered(&pairs[index as usize]).1 as u32;
                if rows.last() != Some(&row) {
                    rows.push(row);
                }
                slots[index as usize] = rows.len() as u32 - 1;
            }
        }
        column_starts.push(rows.len() as u32);
        (Self { size, column_starts, rows }, slots)
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Number of stored entries: the length of a value array.
    pub fn entry_count(&self) -> usize {
        self.rows.len()
    }

    /// Slot of the diagonal entry of row `i`.
    pub fn diagonal(&self, i: usize) -> usize {
        self.column_starts[i] as usize
    }

    /// y = A x for the symmetric matrix with these values.
    pub fn multiply(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for column in 0..self.size {
            let range =
                self.column_starts[column] as usize..self.column_starts[column + 1] as usize;
            let x_column = x[column];
            let mut sum = values[range.start] * x_column;
            for slot in range.start + 1..range.end {
                let row = self.rows[slot] as usize;
                y[row] += values[slot] * x_column;
                sum += values[slot] * x[row];
            }
            y[column] += sum;
        }
    }

    fn symbolic(&self) -> SymbolicSparseColMatRef<'_, u32> {
        SymbolicSparseColMatRef::new_checked(
            self.size,
            self.size,
            &self.column_starts,
            None,
            &self.rows,
        )
    }
}

/// Operations for each entry of a factor, as a part of faer's own threshold, from which on it is made in blocks: on disks of ten thousand
/// vertices, which faer would leave to its simplicial code, blocks take two thirds of the time.
const SUPERNODAL: f64 = 0.4;

/// Rows below which that gains nothing.
const SMALL: usize = 4096;

/// Ordering and symbolic Cholesky factorisation of a [`Pattern`]: once for each pattern.
#[derive(Debug)]
pub struct Analysis {
    pattern: Pattern,
    symbolic: SymbolicCholesky<u32>,
    factorisations: AtomicUsize,
}

impl Analysis {
    /// Analyses a pattern.
    ///
    /// **Costs** about as much as one numeric factorisation, most of it for the ordering.
    pub fn new(pattern: Pattern) -> Result<Self, LinalgError> {
        Self::with(pattern, SymmetricOrdering::Amd)
    }

    /// Analyses a pattern in a known order, such as that of a pattern with nearly the same entries: any order is right, and that of
    /// a pattern far from this one makes a factor with many entries.
    pub fn ordered(pattern: Pattern, order: &Elimination) -> Result<Self, LinalgError> {
        let [rows, places] = &*order.arrays;
        let order = PermRef::new_checked(rows, places, pattern.size);
        Self::with(pattern, SymmetricOrdering::Custom(order))
    }

    /// Analyses a pattern whose rows are in a good order already.
    pub fn in_place(pattern: Pattern) -> Result<Self, LinalgError> {
        // As an order like any other: faer's `Identity` takes the lower triangle for the upper one.
        let natural: Vec<u32> = (0..pattern.size as u32).collect();
        let order = PermRef::new_checked(&natural, &natural, pattern.size);
        Self::with(pattern, SymmetricOrdering::Custom(order))
    }

    fn with(pattern: Pattern, order: SymmetricOrdering<'_, u32>) -> Result<Self, LinalgError> {
        let symbolic = factorize_symbolic_cholesky(
            pattern.symbolic(),
            Side::Lower,
            order,
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: match pattern.size < SMALL {
                    true => SupernodalThreshold::AUTO,
                    false => SupernodalThreshold(SUPERNODAL),
                },
                ..Default::default()
            },
        )
        .map_err(|_| LinalgError::OutOfMemory { size: pattern.size })?;
        Ok(Self { pattern, symbolic, factorisations: AtomicUsize::new(0) })
    }

    /// The order of its rows.
    pub fn order(&self) -> Elimination {
        let arrays = match self.symbolic.perm() {
            Some(perm) => [perm.arrays().0.to_vec(), perm.arrays().1.to_vec()],
            None => [0, 1].map(|_| (0..self.pattern.size as u32).collect()),
        };
        Elimination { arrays: Arc::new(arrays) }
    }

    /// The analysed pattern.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Number of entries of the factor, zeros inside its blocks included: a solve costs about four times as many operations.
    pub fn factor_entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Numeric factorisations that were begun with it so far: what a step of a method is measured in.
    pub fn factorisation_count(&self) -> usize {
        self.factorisations.load(Ordering::Relaxed)
    }
}

/// In which order rows are eliminated.
#[derive(Clone, Debug)]
pub struct Elimination {
    /// The row that comes at each place, and the place of each row.
    arrays: Arc<[Vec<u32>; 2]>,
}

impl Elimination {
    /// When each row is eliminated.
    pub fn places(&self) -> &[u32] {
        &self.arrays[1]
    }
}

/// A numeric Cholesky factor and the memory to compute it again and again.
pub struct Factor {
    analysis: Arc<Analysis>,
    values: Vec<f64>,
    scratch: MemBuffer,
}

impl Factor {
    /// Factors the matrix with these values.
    pub fn new(analysis: Arc<Analysis>, matrix_values: &[f64]) -> Result<Self, LinalgError> {
        let size = analysis.pattern.size;
        let request =
            analysis.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let scratch = MemBuffer::try_new(request).map_err(|_| LinalgError::OutOfMemory { size })?;
        let values = vec![0.0; analysis.symbolic.len_val()];
        let mut factor = Self { analysis, values, scratch };
        factor.refactor(matrix_values)?;
        Ok(factor)
    }

    /// Factors another matrix of the same pattern in the same memory. After an error the factor must not be solved with.
    pub fn refactor(&mut self, matrix_values: &[f64]) -> Result<(), LinalgError> {
        let analysis = &*self.analysis;
        assert_eq!(matrix_values.len(), analysis.pattern.entry_count());
        analysis.factorisations.fetch_add(1, Ordering::Relaxed);
        let result = analysis.symbolic.factorize_numeric_llt(
            &mut self.values,
            SparseColMatRef::new(analysis.pattern.symbolic(), matrix_values),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
        match result {
            Ok(_) => Ok(()),
            Err(LltError::NonPositivePivot { index }) => {
                // faer counts from 1 in its simplicial code and from 0 in its supernodal code.
                let pivot = match analysis.symbolic.raw() {
                    SymbolicCholeskyRaw::Simplicial(_) => index - 1,
                    SymbolicCholeskyRaw::Supernodal(_) => index,
                };
                let row = match analysis.symbolic.perm() {
                    Some(perm) => perm.arrays().0[pivot] as usize,
                    None => pivot,
                };
                Err(LinalgError::NotPositiveDefinite { row })
            }
        }
    }

    /// Solves A X = B in place for `columns` right-hand sides, one after the other in `rhs`.
    pub fn solve(&mut self, rhs: &mut [f64], columns: usize) {
        let size = self.analysis.pattern.size;
        assert_eq!(rhs.len(), size * columns);
        let symbolic = &self.analysis.symbolic;
        let order = symbolic.perm().map(|perm| perm.arrays().0);
        let mut rest = rhs;
        while !rest.is_empty() {
            let count = (rest.len() / size).min(4);
            let (now, later) = rest.split_at_mut(count * size);
            match count {
                1 => solve::solve::<1>(symbolic.raw(), &self.values, order, now),
                2 => solve::solve::<2>(symbolic.raw(), &self.values, order, now),
                3 => solve::solve::<3>(symbolic.raw(), &self.values, order, now),
                _ => solve::solve::<4>(symbolic.raw(), &self.values, order, now),
            }
            rest = later;
        }
    }

    /// [`Factor::solve`], and how well the solutions fit.
    ///
    /// **Takes** the values that were factored. **Gives** max |A x − b| / max |b| over all columns, 0 for b = 0; NaN or infinite where the
    /// solution is. **Costs** one product with A for each column.
    pub fn solve_measured(&mut self, values: &[f64], rhs: &mut [f64], columns: usize) -> f64 {
        let wanted = rhs.to_vec();
        self.solve(rhs, columns);
        let pattern = self.analysis.pattern();
        let mut product = vec![0.0; pattern.size];
        let (mut error, mut size) = (0.0, 0.0);
        let largest = |most: f64, x: f64| worse(most, x.abs());
        for (x, b) in rhs.chunks_exact(pattern.size).zip(wanted.chunks_exact(pattern.size)) {
            pattern.multiply(values, x, &mut product);
            error = product.iter().zip(b).map(|(p, b)| p - b).fold(error, largest);
            size = b.iter().copied().fold(size, largest);
        }
        if error == 0.0 { 0.0 } else { error / size }
    }

    /// The analysis that this factor belongs to.
    pub fn analysis(&self) -> &Arc<Analysis> {
        &self.analysis
    }
}

/// The larger of two residuals, and what is no number before any: `f64::max` would drop it.
pub(crate) fn worse(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shifted graph Laplacian of a grid: the pattern of a mesh without a mesh.
    fn grid(n: u32, shift: f64) -> (Pattern, Vec<f64>) {
        let mut pairs = Vec::new();
        for i in 0..n {
            for j in 0..n {
                if i + 1 < n {
                    pairs.push([i * n + j, (i + 1) * n + j]);
                }
                if j + 1 < n {
                    pairs.push([i * n + j + 1, i * n + j]);
                }
            }
        }
        let (pattern, slots) = Pattern::new((n * n) as usize, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        for (pair, &slot) in pairs.iter().zip(&slots) {
            values[slot as usize] -= 1.0;
            values[pattern.diagonal(pair[0] as usize)] += 1.0;
            values[pattern.diagonal(pair[1] as usize)] += 1.0;
        }
        for i in 0..pattern.size() {
            values[pattern.diagonal(i)] += shift;
        }
        (pattern, values)
    }

    #[test]
    fn solutions_of_several_right_hand_sides_have_small_residuals() {
        let (pattern, values) = grid(40, 0.1);
        let n = pattern.size();
        let analysis = Arc::new(Analysis::new(pattern).unwrap());
        let mut factor = Factor::new(analysis.clone(), &values).unwrap();
        let rhs: Vec<f64> = (0..3 * n).map(|i| ((i * 7919) % 101) as f64 - 50.0).collect();
        for scale in [1.0, 3.0] {
            let scaled: Vec<f64> = values.iter().map(|v| v * scale).collect();
            factor.refactor(&scaled).unwrap();
            let mut x = rhs.clone();
            factor.solve(&mut x, 3);
            let mut product = vec![0.0; n];
            for c in 0..3 {
                analysis.pattern().multiply(&scaled, &x[c * n..(c + 1) * n], &mut product);
                let error = product.iter().zip(&rhs[c * n..]).map(|(a, b)| (a - b).abs());
                // Condition number about 80: a few ulps of 50.
                assert!(error.fold(0.0, f64::max) < 1e-11);
            }
            let mut again = rhs.clone();
            assert!(factor.solve_measured(&scaled, &mut again, 3) < 1e-13);
            assert_eq!(again, x);
            // Against another matrix it is off by as much as the matrices differ.
            let doubled: Vec<f64> = scaled.iter().map(|v| 2.0 * v).collect();
            let off = factor.solve_measured(&doubled, &mut rhs.clone(), 3);
            assert!((off - 1.0).abs() < 1e-12, "{off}");
            let mut nothing = vec![0.0; 3 * n];
            assert!(factor.solve_measured(&scaled, &mut nothing, 3) <= 0.0);
            nothing[7] = f64::NAN;
            assert!(factor.solve_measured(&scaled, &mut nothing, 3).is_nan());
        }
    }

    #[test]
    fn what_is_no_number_is_the_worst_residual() {
        assert_eq!((worse(1.0, 2.0), worse(2.0, 1.0)), (2.0, 2.0));
        assert!(worse(f64::NAN, 1.0).is_nan() && worse(1.0, f64::NAN).is_nan());
    }

    #[test]
    fn any_number_of_right_hand_sides_is_solved_like_one_of_them() {
        // Large enough for blocks of columns to pay.
        let (pattern, values) = grid(200, 0.1);
        let n = pattern.size();
        let analysis = Arc::new(Analysis::new(pattern).unwrap());
        assert!(matches!(analysis.symbolic.raw(), SymbolicCholeskyRaw::Supernodal(_)));
        let mut factor = Factor::new(analysis.clone(), &values).unwrap();
        for columns in 1..=6 {
            let rhs: Vec<f64> =
                (0..columns * n).map(|i| ((i * 7919) % 101) as f64 - 50.0).collect();
            let mut x = rhs.clone();
            factor.solve(&mut x, columns);
            let mut product = vec![0.0; n];
            for (x, rhs) in x.chunks_exact(n).zip(rhs.chunks_exact(n)) {
                analysis.pattern().multiply(&values, x, &mut product);
                let error = product.iter().zip(rhs).map(|(a, b)| (a - b).abs());
                assert!(error.fold(0.0, f64::max) < 1e-11, "{columns} columns");
            }
        }
    }

    #[test]
    fn an_indefinite_matrix_is_an_error_that_names_its_row() {
        // Small grids are factored row by row, large ones by supernodes.
        for n in [6, 90] {
            let (pattern, mut values) = grid(n, 0.1);
            values[pattern.diagonal(17)] = -5.0;
            let analysis = Arc::new(Analysis::new(pattern).unwrap());
            let error = Factor::new(analysis, &values).err().unwrap();
            assert_eq!(error, LinalgError::NotPositiveDefinite { row: 17 });
        }
    }

    #[test]
    fn repeated_pairs_share_one_slot_and_rows_are_sorted() {
        let (pattern, slots) = Pattern::new(4, &[[3, 0], [0, 1], [0, 3], [2, 1]]);
        assert_eq!(slots[0], slots[2]);
        assert_eq!(pattern.rows, vec![0, 1, 3, 1, 2, 2, 3]);
        assert_eq!(pattern.entry_count(), 7);
    }
}
