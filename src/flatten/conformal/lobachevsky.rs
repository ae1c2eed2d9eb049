//! Milnor's Lobachevsky function: volumes of ideal simplices, and what makes angle sums a gradient.

use std::f64::consts::PI;

/// ζ(2k) / (k (2k + 1)) for k = 1 …: with |t / π| ≤ ½ the terms fall by four each, and 27 of them reach the last bit.
const SERIES: [f64; 27] = [
    0.5483113556160755,
    0.10823232337111383,
    0.0484449077135452,
    0.02789103767216512,
    0.01819990136596033,
    0.012823667776324462,
    0.009524392839381512,
    0.007353053546025064,
    0.005847975539726696,
    0.004761909304581114,
    0.00395257011245258,
    0.0033333335320272967,
    0.002849002891457421,
    0.002463054196367818,
    0.0021505376364114566,
    0.001893939394380362,
    0.0016806722690053911,
    0.0015015015015233512,
    0.0013495276653220486,
    0.0012195121951230604,
    0.0011074197120711266,
    0.0010101010101010676,
    0.0009250693802035284,
    0.0008503401360544248,
    0.0007843137254901968,
    0.0007256894049346882,
    0.0006734006734006734,
];

/// Л at each of three angles, Л(t) = −∫₀ᵗ ln |2 sin s| ds: odd, of period π. Their sum is the volume of an ideal tetrahedron.
///
/// Л(t) = t (1 − ln 2t + Σ ζ(2k) / (k (2k + 1)) (t / π)²ᵏ) on (0, π / 2]. **Gives** all but the last bit.
pub(super) fn lobachevsky(angles: [f64; 3]) -> [f64; 3] {
    let reduced = angles.map(|t| t - PI * (t / PI).round());
    let squares = reduced.map(|t| (t / PI) * (t / PI));
    // Odd and even terms of all three side by side: sums that wait for each other are what this costs.
    let (mut odd, mut even) = ([SERIES[26]; 3], [0.0; 3]);
    for k in (0..13).rev() {
        for i in 0..3 {
            let fourth = squares[i] * squares[i];
            odd[i] = SERIES[2 * k] + fourth * odd[i];
            even[i] = SERIES[2 * k + 1] + fourth * even[i];
        }
    }
    [0, 1, 2].map(|i| {
        let sum = squares[i] * (odd[i] + squares[i] * even[i]);
        if reduced[i] == 0.0 {
            0.0
        } else {
            reduced[i] * (1.0 - (2.0 * reduced[i].abs()).ln() + sum)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobachevsky(t: f64) -> f64 {
        super::lobachevsky([t, 0.0, 1.0])[0]
    }

    /// ∫₀ᵗ ln |2 sin s| ds with s = w², which takes the edge off the singularity, by Gauss's five points on many pieces.
    fn by_quadrature(t: f64) -> f64 {
        const NODES: [(f64, f64); 5] = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
            (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
            (0.906_179_845_938_664, 0.236_926_885_056_189_1),
            (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
        ];
        let pieces = 400;
        // Graded: s = t w⁴, so that even s ln s is smooth enough at 0.
        let f = |w: f64| (2.0 * (t * w.powi(4)).sin()).abs().ln() * 4.0 * t * w.powi(3);
        let half = 0.5 / f64::from(pieces);
        let mut sum = 0.0;
        for i in 0..pieces {
            let middle = (f64::from(i) + 0.5) / f64::from(pieces);
            sum +=
                NODES.iter().map(|(x, weight)| weight * f(middle + half * x)).sum::<f64>() * half;
        }
        -sum
    }

    #[test]
    fn the_series_is_the_integral() {
        for i in 1..=160 {
            let t = f64::from(i) * PI / 320.0;
            let (series, integral) = (lobachevsky(t), by_quadrature(t));
            // 400 pieces of ninth degree near s ln s: 1e-14 is what the quadrature reaches.
            assert!((series - integral).abs() < 1e-14, "{t}: {series} {integral}");
        }
    }

    #[test]
    fn it_is_odd_and_periodic_and_three_sixths_of_a_turn_cancel() {
        assert_eq!(lobachevsky(0.0).to_bits(), 0);
        for t in [0.1, 0.7, 1.3] {
            assert_eq!(lobachevsky(-t).to_bits(), (-lobachevsky(t)).to_bits());
            assert!((lobachevsky(t + PI) - lobachevsky(t)).abs() < 1e-15);
            // Л(2t) = 2 Л(t) + 2 Л(t + π / 2).
            let doubled = 2.0 * (lobachevsky(t) + lobachevsky(t + 0.5 * PI));
            assert!((lobachevsky(2.0 * t) - doubled).abs() < 1e-15, "{t}");
        }
        // Volume of the regular ideal tetrahedron.
        assert!((3.0 * lobachevsky(PI / 3.0) - 1.014_941_606_409_653_6).abs() < 1e-15);
    }
}
