//! Functions of one value: the double well, and the indicator of the positive phase.

/// Half width of the plateau that the indicator cuts off: where |u| > 1 − δ a vertex belongs to one phase alone. Larger values
/// make charts smaller than their phases; with 0 no vertex belongs to one phase alone, and every chart is the whole surface.
const DELTA: f64 = 0.01;

/// The optimal profile of an interface is tanh of this times the distance over ε.
pub(super) const STEEPNESS: f64 = 1.0607;

/// Ψ(u) = 9/16 (u² − 1)² and its derivative.
#[inline]
pub(super) fn well(u: f64) -> (f64, f64) {
    let d = u * u - 1.0;
    (0.5625 * d * d, 2.25 * d * u)
}

/// χ(u): 0 below −A, 1 above A = 1 − δ, and between them (u + A)² (2A − u) / 4A³; χ(u) + χ(−u) = 1. And χ′.
#[inline]
pub(super) fn indicator(u: f64) -> (f64, f64) {
    const A: f64 = 1.0 - DELTA;
    let x = u.clamp(-A, A);
    let scale = 1.0 / (4.0 * A * A * A);
    ((x + A) * (x + A) * (2.0 * A - x) * scale, 3.0 * (A * A - x * x) * scale)
}

/// How much of a place belongs to the flattening of a phase where the border's own place shall count: 0 below −0.6, 1 above 0.4, a
/// smoothstep between them. And its derivative.
///
/// χ begins to fall at 0.99 already, where the well costs nothing: a phase that turns a little grey at its spikes holds s at 0 there.
/// At 0.4 that costs 0.4 / ε of its area. Beginning at 0 would do, too, but then the loss depends on the width of the interface so
/// much that it becomes too thin to move.
#[inline]
pub(super) fn reach(u: f64) -> (f64, f64) {
    smoothstep(u + 0.6)
}

/// 0 below 0, 1 above 1, 3x² − 2x³ between them, and its derivative.
#[inline]
pub(super) fn smoothstep(x: f64) -> (f64, f64) {
    let x = x.clamp(0.0, 1.0);
    (x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_functions_and_indicators_add_up_to_one() {
        for k in -30..=30 {
            let u = 0.0501 * f64::from(k);
            for f in [well, indicator, reach, smoothstep] {
                let difference = (f(u + 1e-6).0 - f(u - 1e-6).0) / 2e-6;
                // Central differences at 1e-6: rounding 1e-10, and a kink of the second derivative gives 1e-5.
                assert!((difference - f(u).1).abs() < 2e-5, "{u}: {difference}");
            }
            // A few ulps.
            assert!((indicator(u).0 + indicator(-u).0 - 1.0).abs() < 1e-15);
        }
    }
}
