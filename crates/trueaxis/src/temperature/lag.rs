//! First-order lags, and positions on a curve.

/// The response of a first-order lag over one interval, exact for an input that is linear in time within it.
///
/// ```text
/// x' = (u − x)/τ,  u from u0 to u1 over dt:
/// x1 = u1 + (x0 − u0) e − (u1 − u0) g,   e = exp(−dt/τ),   g = (1 − e) τ/dt
/// ```
///
/// The result does not depend on how the time is divided into intervals. Cost: one exponential for all inputs with this
/// lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Remaining share of the old deviation: e.
    e: f64,
    /// Share of the input's change that has not arrived yet: g.
    g: f64,
}

impl Decay {
    /// Creates the response over `dt_s` with a lag of `lag_s`, both s and not negative; without a lag the output is the
    /// input.
    pub fn new(dt_s: f64, lag_s: f64) -> Decay {
        let intervals = dt_s / lag_s;
        // Also without a lag, and for NaN.
        if intervals.is_nan() || intervals >= 700.0 {
            return Decay { e: 0.0, g: 0.0 };
        }
        // Below this the quotient loses its digits; the first two terms of the series do not.
        if intervals < 1e-8 {
            return Decay { e: 1.0 - intervals, g: 1.0 - 0.5 * intervals };
        }
        let decayed = -libm::expm1(-intervals);
        Decay { e: 1.0 - decayed, g: decayed / intervals }
    }

    /// Returns the output after the interval, given the output `x0` before it.
    #[inline]
    pub fn respond(&self, x0: f64, u0: f64, u1: f64) -> f64 {
        u1 + (x0 - u0) * self.e - (u1 - u0) * self.g
    }
}

/// Finds a value among ascending knots: returns the cell, the fraction 0 to 1 within it, and whether the value is beyond
/// the ends, in which case the nearest end is used. NaN is placed at the first knot.
pub fn place(knots: impl Iterator<Item = f64>, value: f64) -> (usize, f64, bool) {
    let mut before: Option<f64> = None;
    let mut found = (0, 0.0, false);
    for (k, knot) in knots.enumerate() {
        let Some(from) = before.replace(knot) else {
            found.2 = value.is_nan() || value < knot;
            continue;
        };
        // Cells ascend: the last one that begins at or below the value contains it.
        if value >= from {
            let share = (value - from) / (knot - from);
            found = (k.saturating_sub(1), share.min(1.0), share > 1.0);
        }
    }
    found
}
