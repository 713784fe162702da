//! A servo drive that moves a load through a spring: its transfer function, and its stability.

use crate::machine::DriveFigures;

/// Motor and load, together of mass 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Masses {
    /// ω_r of motor and load against each other, both free, 1/s.
    pub(super) omega: f64,
    /// Its damping ζ, share of critical.
    pub(super) damping: f64,
    /// Mass of the load σ, from 0 to 1.
    pub(super) share: f64,
    /// Stiffness κ of the friction that holds the load, 1/s²; 0: it slides.
    pub(super) stiffness: f64,
    /// Whether a scale on the load closes the position loop, or else an encoder on the motor.
    pub(super) scale: bool,
}

/// Numerator and denominator from a command to the reading, from the constant term on.
///
/// ```text
/// (1 − σ) s² x_M = F − E (x_M − x_L)          E = c s + k,  k = σ (1 − σ) ω_r²,  c = 2 σ (1 − σ) ζ ω_r
///        σ s² x_L = E (x_M − x_L) − κ x_L
/// ```
///
/// F is the motor's force, the position loop is closed by y = x_L (scale) or x_M (encoder on the motor), the velocity loop
/// by s x_M:
///
/// ```text
/// F = V ((K_v + k_ff s) r − K_v y − s x_M),  V = K_vp (1 + 1/(τ s))/(1 + s t_c)
///
/// x_M/F = A_M/Δ,  A_M = σ s² + E + κ          Δ = σ (1 − σ) s⁴ + E s² + κ ((1 − σ) s² + E)
/// x_L/F = A_L/Δ,  A_L = E
///
/// y/r = A_y V (K_v + k_ff s)/(Δ + V (K_v A_y + s A_M))
/// ```
///
/// Both are multiplied by τ s (1 + s t_c). For a stiff spring it is the rigid drive, divided by E.
pub(super) fn transfer(drive: &DriveFigures, masses: &Masses) -> ([f64; 5], [f64; 7]) {
    let DriveFigures {
        position_gain_per_s: kv,
        velocity_gain_per_s: kvp,
        reset_time_s: tau,
        velocity_feed_forward: ahead,
        current_loop_s: tc,
        ..
    } = *drive;
    let Masses { omega, damping, share, stiffness: held, scale } = *masses;
    let motor = 1.0 - share;
    let (k, c) = (share * motor * omega * omega, 2.0 * share * motor * damping * omega);
    let at_motor = [k + held, c, share];
    let read = if scale { [k, c, 0.0] } else { at_motor };
    let free = [held * k, held * c, k + held * motor, c, share * motor];
    let velocity = [kvp, kvp * tau];
    let [a, b, d] = read;
    let [p, q, r] = at_motor;
    let fed_back = [kv * a, kv * b + p, kv * d + q, r];
    let numerator: [f64; 4] = product(&[kv, ahead], &read);
    let motion: [f64; 7] = product(&[0.0, tau, tau * tc], &free);
    let control: [f64; 5] = product(&velocity, &fed_back);
    let mut denominator = motion;
    for (sum, term) in denominator.iter_mut().zip(control) {
        *sum += term;
    }
    (product(&velocity, &numerator), denominator)
}

/// Product of two polynomials; `C` is the sum of their lengths less one.
pub(super) fn product<const A: usize, const B: usize, const C: usize>(a: &[f64; A], b: &[f64; B]) -> [f64; C] {
    let mut product = [0.0; C];
    for (i, a) in a.iter().enumerate() {
        for (sum, b) in product.iter_mut().skip(i).zip(b) {
            *sum += a * b;
        }
    }
    product
}

/// Whether all roots of a polynomial with a positive leading coefficient lie to the left of the imaginary axis (Routh).
pub(super) fn is_stable(&[a0, a1, a2, a3, a4, a5, a6]: &[f64; 7]) -> bool {
    let (mut above, mut row) = ([a6, a4, a2, a0], [a5, a3, a1, 0.0]);
    for _ in 0..5 {
        let [first, b, c, d] = row;
        // Also refuses NaN.
        if first.is_nan() || first <= 0.0 {
            return false;
        }
        let ratio = above[0] / first;
        let next = [above[1] - ratio * b, above[2] - ratio * c, above[3] - ratio * d, 0.0];
        (above, row) = (row, next);
    }
    row[0] > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of the polynomial with these pairs of roots, re ± j im.
    fn with_roots(pairs: [[f64; 2]; 3]) -> [f64; 7] {
        let [a, b, c] = pairs.map(|[re, im]| [re * re + im * im, -2.0 * re, 1.0]);
        let first: [f64; 5] = product(&a, &b);
        product(&first, &c)
    }

    #[test]
    fn stability_is_that_of_the_roots() {
        let left = [[-5.0, 700.0], [-100.0, 0.0], [-900.0, 40.0]];
        assert!(is_stable(&with_roots(left)));
        for place in 0..3 {
            for re in [1e-3, 0.5, 300.0] {
                let mut pairs = left;
                pairs[place][0] = re;
                assert!(!is_stable(&with_roots(pairs)), "{pairs:?}");
                pairs[place][0] = -re;
                assert!(is_stable(&with_roots(pairs)), "{pairs:?}");
            }
        }
    }

    /// The equations of motion and of the loops, solved by elimination at single frequencies.
    #[test]
    fn the_transfer_function_solves_the_equations() {
        type C = [f64; 2];
        let mul = |[a, b]: C, [c, d]: C| [a * c - b * d, a * d + b * c];
        let add = |[a, b]: C, [c, d]: C| [a + c, b + d];
        let neg = |[a, b]: C| [-a, -b];
        let div = |x: C, [c, d]: C| mul(x, [c / (c * c + d * d), -d / (c * c + d * d)]);
        let drive = DriveFigures { velocity_feed_forward: 0.7, ..DriveFigures::with_defaults(60.0, 350.0, 0.012) };
        for scale in [false, true] {
            for stiffness in [0.0, 3e4] {
                let masses = Masses { omega: 754.0, damping: 0.03, share: 0.4, stiffness, scale };
                let (numerator, denominator) = transfer(&drive, &masses);
                for omega in [3.0, 90.0, 584.0, 754.0, 2000.0] {
                    let s: C = [0.0, omega];
                    let at = |p: &[f64]| p.iter().rev().fold([0.0, 0.0], |sum, c| add(mul(sum, s), [*c, 0.0]));
                    let found = div(at(&numerator), at(&denominator));
                    // Unknown: the motor for a command of 1. First the load from the motor, then the forces.
                    let (m, l) = (0.6, 0.4);
                    let spring = add([m * l * 754.0 * 754.0, 0.0], mul(s, [2.0 * m * l * 0.03 * 754.0, 0.0]));
                    let load = div(spring, add(add(mul(s, mul(s, [l, 0.0])), spring), [stiffness, 0.0]));
                    let lag = add([1.0, 0.0], mul(s, [drive.current_loop_s, 0.0]));
                    let velocity = div(mul([350.0, 0.0], add([1.0, 0.0], div([1.0, 0.0], mul(s, [0.012, 0.0])))), lag);
                    let read = if scale { load } else { [1.0, 0.0] };
                    // F for a motor at 1: (1 − σ) s² + E (1 − x_L).
                    let force = add(mul(s, mul(s, [m, 0.0])), mul(spring, add([1.0, 0.0], neg(load))));
                    let back = mul(velocity, add(mul([60.0, 0.0], read), s));
                    let forward = mul(velocity, add([60.0, 0.0], mul(s, [0.7, 0.0])));
                    let expected = mul(read, div(forward, add(force, back)));
                    let apart = add(found, neg(expected));
                    assert!(apart[0].hypot(apart[1]) < 1e-9 * (1.0 + expected[0].hypot(expected[1])), "{omega}");
                }
            }
        }
    }
}
