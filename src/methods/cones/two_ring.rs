//! The matrix B = L_DW M⁻¹ L_WD, whose pattern reaches over two rings of neighbours: one analysis, many factorisations.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::sync::Arc;

use super::system::{NONE, System};
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};

/// B itself, and what is known about it before numbers are put in.
struct Matrix {
    analysis: Arc<Analysis>,
    /// Row and column of every entry.
    ends: Vec<[u32; 2]>,
    values: Vec<f64>,
}

/// B + diag(d) with some rows and columns left out, factored.
pub(super) struct TwoRing {
    matrix: Arc<Matrix>,
    factor: Option<Factor>,
    is_out: Vec<bool>,
    buffer: Vec<f64>,
}

impl TwoRing {
    /// Assembles B and analyses its pattern. **Costs** about as much as one factorisation.
    pub fn new(system: &System) -> Result<Self, LinalgError> {
        let n = system.len();
        // Rows of L, by vertex: dofs with their entries.
        let mut starts = vec![0u32; system.mass.len() + 1];
        let laplacian = &system.laplacian;
        let edges: Vec<([usize; 2], f64)> = laplacian
            .edge_ends
            .iter()
            .zip(&laplacian.edge_slots)
            .map(|(ends, &slot)| (ends.map(|v| v as usize), laplacian.values[slot as usize]))
            .collect();
        for ([a, b], _) in &edges {
            starts[a + 1] += 1;
            starts[b + 1] += 1;
        }
        for v in 0..system.mass.len() {
            starts[v + 1] += starts[v] + 1;
        }
        let mut next: Vec<u32> = starts.clone();
        let mut rings = vec![(NONE, 0.0); starts[system.mass.len()] as usize];
        let mut place = |v: usize, w: usize, value: f64| {
            rings[next[v] as usize] = (system.dof_of[w], value);
            next[v] += 1;
        };
        for v in 0..system.mass.len() {
            place(v, v, laplacian.values[laplacian.pattern.diagonal(v)]);
        }
        for &([a, b], value) in &edges {
            place(a, b, value);
            place(b, a, value);
        }
        let mut pairs = Vec::new();
        let mut amounts = Vec::new();
        let mut diagonal = vec![0.0; n];
        for v in (0..system.mass.len()).filter(|&v| system.is_live[v]) {
            let ring = &rings[starts[v] as usize..starts[v + 1] as usize];
            for (k, &(i, a)) in ring.iter().enumerate().filter(|(_, r)| r.0 != NONE) {
                diagonal[i as usize] += a * a / system.mass[v];
                for &(j, b) in ring[k + 1..].iter().filter(|r| r.0 != NONE) {
                    pairs.push([i, j]);
                    amounts.push(a * b / system.mass[v]);
                }
            }
        }
        let (pattern, slots) = Pattern::new(n, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        let mut ends = vec![[0; 2]; values.len()];
        for ((pair, &slot), amount) in pairs.iter().zip(&slots).zip(&amounts) {
            values[slot as usize] += amount;
            ends[slot as usize] = *pair;
        }
        for (i, d) in diagonal.iter().enumerate() {
            values[pattern.diagonal(i)] = *d;
            ends[pattern.diagonal(i)] = [i as u32; 2];
        }
        let analysis = Arc::new(Analysis::new(pattern)?);
        let buffer = vec![0.0; values.len()];
        let matrix = Arc::new(Matrix { analysis, ends, values });
        Ok(Self { matrix, factor: None, is_out: vec![false; n], buffer })
    }

    /// The same matrix, to be factored in another way.
    pub fn sibling(&self) -> Self {
        Self {
            matrix: self.matrix.clone(),
            factor: None,
            is_out: vec![false; self.is_out.len()],
            buffer: vec![0.0; self.buffer.len()],
        }
    }

    /// Number of entries of the factor.
    pub fn factor_entries(&self) -> usize {
        self.matrix.analysis.factor_entries()
    }

    /// Factors B + diag(`added`) without the rows and columns that are `out`.
    pub fn factor(&mut self, added: &[f64], out: &[bool]) -> Result<(), LinalgError> {
        let matrix = &*self.matrix;
        self.is_out.copy_from_slice(out);
        for ((target, &value), &[i, j]) in
            self.buffer.iter_mut().zip(&matrix.values).zip(&matrix.ends)
        {
            *target = if i == j {
                value + added[i as usize]
            } else if out[i as usize] || out[j as usize] {
                0.0
            } else {
                value
            };
        }
        match &mut self.factor {
            Some(factor) => factor.refactor(&self.buffer),
            None => {
                self.factor = Some(Factor::new(matrix.analysis.clone(), &self.buffer)?);
                Ok(())
            }
        }
    }

    /// Solves with the last factor, in place; rows that are out come back as 0.
    pub fn solve(&mut self, x: &mut [f64], columns: usize) {
        let clear = |x: &mut [f64]| {
            for column in x.chunks_exact_mut(self.is_out.len().max(1)) {
                column.iter_mut().zip(&self.is_out).filter(|p| *p.1).for_each(|p| *p.0 = 0.0);
            }
        };
        clear(x);
        if let Some(factor) = &mut self.factor {
            factor.solve(x, columns);
        }
        clear(x);
    }
}
