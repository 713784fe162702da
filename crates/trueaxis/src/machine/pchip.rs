//! Slopes of the monotone piecewise cubic (PCHIP).
//!
//! Fritsch and Butland, A method for constructing local monotone piecewise cubic interpolants, SIAM J. Sci. Stat.
//! Comput. 5 (1984) 300; end condition as in Moler, Numerical Computing with Matlab (2004), section 3.6.

/// Slope at an inner point between a cell of width `h0` and secant `d0` and the next of width `h1` and secant `d1`:
/// the weighted harmonic mean `(w0 + w1) / (w0/d0 + w1/d1)`, `w0 = 2 h1 + h0`, `w1 = h1 + 2 h0`; zero at an extremum.
///
/// Units: `d` in value per position, any; widths positive.
pub fn slope(h0: f64, d0: f64, h1: f64, d1: f64) -> f64 {
    if d0 * d1 <= 0.0 {
        return 0.0;
    }
    let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
    (w0 + w1) / (w0 / d0 + w1 / d1)
}

/// Slope at the end of a grid whose first cell (from the end) has width `h0` and secant `d0`, the second `h1`, `d1`:
/// the three-point formula, limited so that the curve stays monotone.
pub fn end_slope(h0: f64, d0: f64, h1: f64, d1: f64) -> f64 {
    let m = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if m * d0 <= 0.0 {
        0.0
    } else if d0 * d1 <= 0.0 && m.abs() > 3.0 * d0.abs() {
        3.0 * d0
    } else {
        m
    }
}
