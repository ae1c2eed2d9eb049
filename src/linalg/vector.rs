//! Sums over long vectors, several side by side: one sum waits for itself, since the order of additions is part of the result and the
//! compiler keeps it.

/// Does work that is compiled for wider vectors as well, where the processor has them: the same operations in the same order, so the
/// same result. What it calls must be inlined into it.
#[inline(always)]
pub(crate) fn widely<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Sums side by side: twice what additions take, in vectors of two.
const LANES: usize = 8;

/// aᵀb.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let mut sums = [0.0; LANES];
    let (whole_a, rest_a) = a.as_chunks::<LANES>();
    let (whole_b, rest_b) = b.as_chunks::<LANES>();
    for (a, b) in whole_a.iter().zip(whole_b) {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    halve(sums) + rest
}

/// a += factor · b.
pub(crate) fn add(a: &mut [f64], factor: f64, b: &[f64]) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * b;
    }
}

/// Several sums over i of `0..count` at once.
pub(crate) fn sums<const N: usize>(count: usize, terms: impl Fn(usize) -> [f64; N]) -> [f64; N] {
    /// Of each sum: there are several of them already.
    const SIDES: usize = 4;
    let mut sums = [[0.0; SIDES]; N];
    let whole = count - count % SIDES;
    for i in (0..whole).step_by(SIDES) {
        for k in 0..SIDES {
            for (sum, term) in sums.iter_mut().zip(terms(i + k)) {
                sum[k] += term;
            }
        }
    }
    for i in whole..count {
        for (sum, term) in sums.iter_mut().zip(terms(i)) {
            sum[0] += term;
        }
    }
    sums.map(halve)
}

/// The sum of a power of two of numbers, by halves.
fn halve<const N: usize>(mut sums: [f64; N]) -> f64 {
    let mut half = N / 2;
    while half > 0 {
        for k in 0..half {
            sums[k] += sums[k + half];
        }
        half /= 2;
    }
    sums[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_any_length_have_every_term_once() {
        for n in 0..40 {
            // Whole numbers: exact in any order.
            let a: Vec<f64> = (0..n).map(|i| 1.0 + f64::from(i)).collect();
            let b: Vec<f64> = (0..n).map(|i| f64::from(3 * i % 7) - 2.0).collect();
            let expected: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert!((dot(&a, &b) - expected).abs() < 0.5, "{n}");
            let [both, single] = sums(a.len(), |i| [a[i] * b[i], b[i]]);
            assert!((both - expected).abs() < 0.5, "{n}");
            assert!((single - b.iter().sum::<f64>()).abs() < 0.5, "{n}");
        }
    }
}
