//! Quantiles of Student's and the chi-squared distribution.

use libm::{erf, lgamma};

/// Degrees of freedom from which Student's distribution is replaced by the normal: the factors differ by less than 3e-9.
const NORMAL_FROM: f64 = 1e9;
/// Most halvings of a bracket: to the last bit of a double.
const HALVINGS: usize = 200;
/// Most terms of a continued fraction or series; they converge within √ν terms.
const TERMS: usize = 100_000;

/// Returns the coverage factor k of a two-sided interval of coverage `p`, after Student with `degrees_of_freedom` ν (infinite:
/// normal).
///
/// ```text
/// P(|t_ν| ≤ k) = p,      1 − p = I_{ν/(ν + k²)}(ν/2, 1/2)
/// ```
///
/// `p` in 0 … 1, ν > 0; other arguments give NaN. Relative error below 1e-9. Cost: some 10⁴ operations.
///
/// ```
/// use trueaxis_metrology::uncertainty::student_factor;
/// assert!((student_factor(0.95, f64::INFINITY) - 1.959_964).abs() < 1e-6);
/// assert!((student_factor(0.95, 4.0) - 2.776_445).abs() < 1e-6);
/// ```
///
/// Source: JCGM 100:2008, table G.2; M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, 26.5.27 and 26.5.8.
pub fn student_factor(p: f64, degrees_of_freedom: f64) -> f64 {
    if !(0.0..1.0).contains(&p) || degrees_of_freedom.is_nan() || degrees_of_freedom <= 0.0 {
        return f64::NAN;
    }
    let inside = |k: f64| {
        if degrees_of_freedom >= NORMAL_FROM {
            return erf(k / core::f64::consts::SQRT_2);
        }
        let nu = degrees_of_freedom;
        // The form that does not cancel.
        let x = nu / (nu + k * k);
        if x > 0.5 { beta(0.5, 0.5 * nu, 1.0 - x) } else { 1.0 - beta(0.5 * nu, 0.5, x) }
    };
    inverse(p, inside)
}

/// Returns x with P(χ² ≤ x) = `p` of a chi-squared distribution; `degrees_of_freedom` need not be an integer.
///
/// `p` in 0 … 1, ν > 0; other arguments give NaN. Relative error below 1e-9.
///
/// Source: Abramowitz and Stegun, 26.4.19, 6.5.29 and 6.5.31.
pub fn chi_squared_quantile(p: f64, degrees_of_freedom: f64) -> f64 {
    if !(0.0..1.0).contains(&p) || degrees_of_freedom.is_nan() || degrees_of_freedom <= 0.0 {
        return f64::NAN;
    }
    inverse(p, |x| gamma(0.5 * degrees_of_freedom, 0.5 * x))
}

/// Argument at which a distribution that rises from 0 at 0 reaches `p`.
fn inverse(p: f64, distribution: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while distribution(high) < p && high < 1e300 {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if distribution(middle) < p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Regularised incomplete beta function I_x(a, b), by its continued fraction.
fn beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta(b, a, 1.0 - x);
    }
    let front = libm::exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * libm::log(x) + b * libm::log1p(-x)) / a;
    // Lentz's method; keeps its divisors away from zero.
    let clear = |value: f64| if value.abs() < 1e-300 { 1e-300 } else { value };
    let (mut c, mut d) = (1.0, 1.0 / clear(1.0 - (a + b) * x / (a + 1.0)));
    let mut value = d;
    for m in 1..TERMS {
        let m = m as f64;
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / clear(1.0 + even * d);
        c = clear(1.0 + even / c);
        value *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / clear(1.0 + odd * d);
        c = clear(1.0 + odd / c);
        value *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * value
}

/// Regularised incomplete gamma function P(a, x): series below a + 1, continued fraction above.
fn gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = libm::exp(a * libm::log(x) - x - lgamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..TERMS {
            term *= x / (a + n as f64);
            sum += term;
            if term < sum * 1e-16 {
                break;
            }
        }
        return front * sum;
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut value = d;
    for n in 1..TERMS {
        let n = n as f64;
        let a_n = -n * (n - a);
        b += 2.0;
        d = 1.0 / (a_n * d + b);
        c = b + a_n / c;
        value *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    1.0 - front * value
}
