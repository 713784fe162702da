//! First-order lags and places on a curve.

/// The response of a first-order lag over one interval, exact for an input that is linear in time within it.
///
/// ```text
/// x' = (u − x)/τ,  u from u0 to u1 over dt:
/// x1 = u1 + (x0 − u0) e − (u1 − u0) g,   e = exp(−dt/τ),   g = (1 − e) τ/dt
/// ```
///
/// Intervals may be divided at will: the result does not depend on how. Cost: one exponential for all inputs with this lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Share of the old deviation that is left: e.
    e: f64,
    /// Share of the change of the input that has not arrived yet: g.
    g: f64,
}

impl Decay {
    /// Over `dt_s` with a lag of `lag_s`, both s and not negative; without a lag the output is the input.
    pub fn new(dt_s: f64, lag_s: f64) -> Decay {
        let intervals = dt_s / lag_s;
        // Also without a lag, and for what is no number.
        if intervals.is_nan() || intervals >= 700.0 {
            return Decay { e: 0.0, g: 0.0 };
        }
        // Below, the quotient loses its digits; the first two terms of the series do not.
        if intervals < 1e-8 {
            return Decay { e: 1.0 - intervals, g: 1.0 - 0.5 * intervals };
        }
        let gone = -libm::expm1(-intervals);
        Decay { e: 1.0 - gone, g: gone / intervals }
    }

    /// The output after the interval, from the output `x0` before it.
    #[inline]
    pub fn respond(&self, x0: f64, u0: f64, u1: f64) -> f64 {
        u1 + (x0 - u0) * self.e - (u1 - u0) * self.g
    }
}

/// Where a value stands among ascending knots: the cell, and the share of the way through it, 0 to 1. Beyond the ends the
/// nearest one; whether that was so comes with it. What is no number stands at the first knot.
pub fn place(knots: impl Iterator<Item = f64>, value: f64) -> (usize, f64, bool) {
    let mut before: Option<f64> = None;
    let mut found = (0, 0.0, false);
    for (k, knot) in knots.enumerate() {
        let Some(from) = before.replace(knot) else {
            found.2 = value.is_nan() || value < knot;
            continue;
        };
        // Cells ascend: the last one that begins at or below the value holds it.
        if value >= from {
            let share = (value - from) / (knot - from);
            found = (k.saturating_sub(1), share.min(1.0), share > 1.0);
        }
    }
    found
}
