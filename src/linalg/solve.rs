//! Solving with a factor for one to four right-hand sides at a time.
//!
//! On meshes of surfaces most supernodes have a few columns: general kernels spend more time on being called for them than on
//! the numbers, plain loops do not. Where there are no supernodes several right-hand sides share the reading of the factor, which is
//! what takes the time.

use faer::sparse::linalg::cholesky::SymbolicCholeskyRaw;
use faer::sparse::linalg::cholesky::simplicial::SymbolicSimplicialCholesky;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

use super::vector::widely;

/// A supernode of the factor L: consecutive columns with one pattern.
struct Block<'a> {
    /// First column.
    start: usize,
    width: usize,
    /// Rows below the square of the columns themselves.
    rows: &'a [u32],
    /// Column by column, `width + rows.len()` entries each.
    values: &'a [f64],
}

impl<'a> Block<'a> {
    #[inline(always)]
    fn new(symbolic: &'a SymbolicSupernodalCholesky<u32>, values: &'a [f64], s: usize) -> Self {
        let start = symbolic.supernode_begin()[s] as usize;
        let width = symbolic.supernode_end()[s] as usize - start;
        let first = symbolic.col_ptr_for_row_idx()[s] as usize;
        let rows = &symbolic.row_idx()[first..first + symbolic.nnz_per_super()[s] as usize];
        let begin = symbolic.col_ptr_for_val()[s] as usize;
        let values = &values[begin..begin + width * (width + rows.len())];
        Self { start, width, rows, values }
    }

    #[inline(always)]
    fn column(&self, j: usize) -> &'a [f64] {
        let height = self.width + self.rows.len();
        &self.values[j * height..(j + 1) * height]
    }

    /// x ← L⁻¹ x as far as these columns go.
    #[inline(always)]
    fn forward<const N: usize>(&self, x: &mut [[f64; N]], below: &mut Vec<[f64; N]>) {
        let own = self.start..self.start + self.width;
        // Right-hand sides that are zero but for a rim or a few points stay so in most of the tree.
        let Some(first) = x[own.clone()].iter().position(|x| !is_zero(x)) else { return };
        below.clear();
        below.resize(self.rows.len(), [0.0; N]);
        for j in first..self.width {
            let column = self.column(j);
            let pivot = &mut x[own.start + j];
            pivot.iter_mut().for_each(|p| *p /= column[j]);
            let pivot = *pivot;
            let (square, rest) = column.split_at(self.width);
            for (target, l) in x[own.start + j + 1..own.end].iter_mut().zip(&square[j + 1..]) {
                subtract(target, *l, &pivot);
            }
            for (target, l) in below.iter_mut().zip(rest) {
                subtract(target, *l, &pivot);
            }
        }
        for (&row, below) in self.rows.iter().zip(below.iter()) {
            for (target, b) in x[row as usize].iter_mut().zip(below) {
                *target += b;
            }
        }
    }

    /// x ← L⁻ᵀ x as far as these columns go.
    #[inline(always)]
    fn backward<const N: usize>(&self, x: &mut [[f64; N]], below: &mut Vec<[f64; N]>) {
        below.clear();
        below.extend(self.rows.iter().map(|&row| x[row as usize]));
        let own = self.start..self.start + self.width;
        for j in (0..self.width).rev() {
            let column = self.column(j);
            let (square, rest) = column.split_at(self.width);
            let beside = products(&square[j + 1..], &x[own.start + j + 1..own.end]);
            let beneath = products(rest, below);
            for (k, target) in x[own.start + j].iter_mut().enumerate() {
                *target = (*target - beside[k] - beneath[k]) / column[j];
            }
        }
    }
}

#[inline(always)]
fn is_zero<const N: usize>(x: &[f64; N]) -> bool {
    x.iter().all(|x| x.abs() <= 0.0)
}

#[inline(always)]
fn subtract<const N: usize>(target: &mut [f64; N], l: f64, pivot: &[f64; N]) {
    for (target, p) in target.iter_mut().zip(pivot) {
        *target -= l * p;
    }
}

/// Σ l x for each right-hand side, in four sums: the compiler may not reorder one.
#[inline(always)]
fn products<const N: usize>(column: &[f64], x: &[[f64; N]]) -> [f64; N] {
    let mut sums = [[0.0; N]; 4];
    let (columns, xs) = (column.chunks_exact(4), x.chunks_exact(4));
    let rest = columns.remainder().iter().zip(xs.remainder());
    for (l, x) in columns.zip(xs) {
        for i in 0..4 {
            for k in 0..N {
                sums[i][k] += l[i] * x[i][k];
            }
        }
    }
    let mut sum = [0.0; N];
    for k in 0..N {
        sum[k] = (sums[0][k] + sums[1][k]) + (sums[2][k] + sums[3][k]);
    }
    for (l, x) in rest {
        for k in 0..N {
            sum[k] += l * x[k];
        }
    }
    sum
}

/// Solves L Lᵀ X = B in place.
///
/// **Takes** the factor's values, the order of elimination (entry `i` names the row that is eliminated as number `i`), and N
/// right-hand sides one after the other.
pub(super) fn solve<const N: usize>(
    symbolic: &SymbolicCholeskyRaw<u32>,
    values: &[f64],
    order: Option<&[u32]>,
    rhs: &mut [f64],
) {
    let size = rhs.len() / N;
    let row = |i: usize| order.map_or(i, |order| order[i] as usize);
    let mut x: Vec<[f64; N]> =
        (0..size).map(|i| std::array::from_fn(|k| rhs[k * size + row(i)])).collect();
    widely(
        #[inline(always)]
        || match symbolic {
            SymbolicCholeskyRaw::Supernodal(blocks) => by_blocks(blocks, values, &mut x),
            SymbolicCholeskyRaw::Simplicial(columns) => by_columns(columns, values, &mut x),
        },
    );
    for (i, x) in x.iter().enumerate() {
        for (k, value) in x.iter().enumerate() {
            rhs[k * size + row(i)] = *value;
        }
    }
}

#[inline(always)]
fn by_blocks<const N: usize>(
    symbolic: &SymbolicSupernodalCholesky<u32>,
    values: &[f64],
    x: &mut [[f64; N]],
) {
    let mut below = Vec::new();
    for s in 0..symbolic.n_supernodes() {
        Block::new(symbolic, values, s).forward(x, &mut below);
    }
    for s in (0..symbolic.n_supernodes()).rev() {
        Block::new(symbolic, values, s).backward(x, &mut below);
    }
}

/// Every column begins with its diagonal entry.
#[inline(always)]
fn by_columns<const N: usize>(
    symbolic: &SymbolicSimplicialCholesky<u32>,
    values: &[f64],
    x: &mut [[f64; N]],
) {
    let starts = symbolic.col_ptr();
    let column = |j: usize| {
        let range = starts[j] as usize..starts[j + 1] as usize;
        let (rows, values) = (&symbolic.row_idx()[range.clone()], &values[range]);
        (values[0], rows[1..].iter().map(|&row| row as usize).zip(&values[1..]))
    };
    for j in 0..x.len() {
        if is_zero(&x[j]) {
            continue;
        }
        let (diagonal, below) = column(j);
        x[j].iter_mut().for_each(|x| *x /= diagonal);
        let pivot = x[j];
        below.for_each(|(row, l)| subtract(&mut x[row], *l, &pivot));
    }
    for j in (0..x.len()).rev() {
        let (diagonal, below) = column(j);
        let mut rest = x[j];
        below.for_each(|(row, l)| {
            let known = x[row];
            subtract(&mut rest, *l, &known);
        });
        x[j] = rest.map(|x| x / diagonal);
    }
}
