//! The prescribed area of the positive phase, kept exactly: fields are moved along a direction until they have it.
//!
//! A(u) = Σ m w χ(u) = T. With a direction p ≥ 0 the number c(v) with A(v + c p) = T is unique, and v ↦ F(v + c(v) p) is a problem
//! without a constraint, whose gradient is g − (g·p) / (a·p) a with a = m w χ′. **Differs** from [PF], which has a quadratic
//! penalty, or an interior-point method.

use super::super::profile::indicator;
use crate::linalg::sums;

/// Moves `u` along `direction` until Σ mw χ(u) = target. A direction w χ′(u) moves the interface by the same distance everywhere
/// and leaves the phases as they are.
///
/// **Takes** weights mw ≥ 0, their sum, a target between 0 and that, and a direction that is positive where weights are. **Gives** the area
/// that is missing, rounding unless there is no weight. **Costs** about three passes.
pub(in super::super) fn project(
    mw: &[f64],
    [whole, target]: [f64; 2],
    direction: &[f64],
    u: &mut [f64],
) -> f64 {
    let n = u.len();
    let area_at = |c: f64| {
        let (u, direction, mw) = (&u[..n], &direction[..n], &mw[..n]);
        let [area, slope] = sums(n, |i| {
            let (chi, slope) = indicator(u[i] + c * direction[i]);
            [mw[i] * chi, mw[i] * slope * direction[i]]
        });
        (area - target, slope)
    };
    let tolerance = 1e-13 * whole;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut c, mut stride) = (0.0, 1.0);
    let mut excess = 0.0;
    for _ in 0..100 {
        let (value, slope) = area_at(c);
        excess = value;
        if !(excess.abs() > tolerance) {
            break;
        }
        if excess > 0.0 {
            high = c
        } else {
            low = c
        }
        let newton = c - excess / slope;
        c = if newton > low && newton < high && (newton - c).abs() <= stride {
            newton
        } else if low.is_finite() && high.is_finite() {
            0.5 * (low + high)
        } else {
            c - stride * excess.signum()
        };
        if high - low <= 1e-16 * c.abs() {
            break;
        }
        stride *= 2.0;
    }
    if c.abs() > 0.0 {
        for (u, p) in u.iter_mut().zip(direction) {
            *u += c * p;
        }
    }
    excess
}
