//! Part of a span relative to a point: how many minima of the distance it can have, and whether any point of it is near.
//!
//! With x(t) = c(t)_xyz − w(t) p on the part, mapped to 0..1, both questions depend on the sign of a polynomial:
//!
//! ```text
//! g(s) = (x·x') w − (x·x) w'      the distance falls where it is negative
//! n(s) = x·x − d² w²              a point nearer than d where it is negative
//! ```
//!
//! In Bernstein's basis, by Descartes' rule, a polynomial has at most as many zeros in 0..1 as its coefficients have sign
//! changes, and none without a change; a single change is exactly one zero. The code keeps coefficients multiplied by their
//! binomials: signs stay, and products become plain convolutions.
//!
//! Source: R. T. Farouki and V. T. Rajan, Algorithms for polynomials in Bernstein form, 1988.

use crate::contour::refine::dot;
use crate::real::Real;

/// Rounding error of a coefficient of n, in epsilons of its largest terms.
const ROUNDING: f64 = 256.0;

/// The C coefficients of x and w on the part.
pub(super) struct Part<R, const C: usize> {
    x: [[R; 3]; C],
    w: [R; C],
    /// x·x.
    squares: [R; 11],
}

impl<R: Real, const C: usize> Part<R, C> {
    /// The part `first..last` of a span with these coefficients; `point` is relative to its origin.
    #[inline(always)]
    pub(super) fn new<const RATIONAL: bool>(coefficients: &[[R; 4]; 6], point: &[R; 3], first: R, last: R) -> Self {
        let mut c: [[R; 4]; C] = core::array::from_fn(|k| coefficients[k]);
        let lanes = if RATIONAL { 4 } else { 3 };
        if first != R::ZERO {
            for done in 0..C - 1 {
                for k in (done..C - 1).rev() {
                    for lane in 0..lanes {
                        c[k][lane] += first * c[k + 1][lane];
                    }
                }
            }
        }
        let width = last - first;
        if width != R::ONE {
            let mut power = width;
            for c in c.iter_mut().skip(1) {
                for lane in 0..lanes {
                    c[lane] = c[lane] * power;
                }
                power = power * width;
            }
        }
        let (mut x, mut w) = ([[R::ZERO; 3]; C], [R::ZERO; C]);
        for k in 0..C {
            w[k] = if RATIONAL {
                c[k][3]
            } else if k == 0 {
                R::ONE
            } else {
                R::ZERO
            };
            for lane in 0..3 {
                x[k][lane] = if RATIONAL || k == 0 { c[k][lane] - w[k] * point[lane] } else { c[k][lane] };
            }
        }
        // Σ c_j s^j = Σ C(n, k) b_k s^k (1−s)^(n−k): Horner's scheme in s/(1−s).
        for j in 1..C {
            for k in (1..=j).rev() {
                for lane in 0..3 {
                    x[k][lane] += x[k - 1][lane];
                }
                w[k] += w[k - 1];
            }
        }
        let mut squares = [R::ZERO; 11];
        for i in 0..C {
            squares[2 * i] += dot(&x[i], &x[i]);
            for j in 0..i {
                squares[i + j] += R::TWO * dot(&x[i], &x[j]);
            }
        }
        Part { x, w, squares }
    }

    /// Whether no point is nearer than √`squared` by more than rounding.
    pub(super) fn is_beyond(&self, squared: R) -> bool {
        let mut n = self.squares;
        for i in 0..C {
            for j in 0..C {
                n[i + j] -= squared * self.w[i] * self.w[j];
            }
        }
        let end = self.squares[2 * (C - 1)];
        let rounding = R::of(ROUNDING) * R::EPSILON * (self.squares[0] + end);
        // All points are as far as the nearest one: near the centre of an arc. A zero cannot be distinguished from rounding
        // there, and the distance is the same to rounding.
        let least = if squared > R::of(0.01) * (self.squares[0] + end) { -rounding } else { rounding };
        n.iter().take(2 * C - 1).all(|n| *n >= least)
    }

    /// Number of sign changes of g from one end to the other, where its values are `first` and `last`: an upper bound on its
    /// zeros.
    pub(super) fn changes<const RATIONAL: bool>(&self, first: R, last: R) -> u32 {
        let mut g = [R::ZERO; 15];
        for j in 0..C - 1 {
            let (up, down) = (R::of_i32(j as i32 + 1), R::of_i32((C - 1 - j) as i32));
            let rate: [R; 3] = core::array::from_fn(|lane| up * self.x[j + 1][lane] - down * self.x[j][lane]);
            for i in 0..C {
                g[i + j] += dot(&self.x[i], &rate);
            }
        }
        let mut count = 2 * (C - 1);
        if RATIONAL {
            let along = g;
            g = [R::ZERO; 15];
            for i in 0..count {
                for j in 0..C {
                    g[i + j] += along[i] * self.w[j];
                }
            }
            for j in 0..C - 1 {
                let rate = R::of_i32(j as i32 + 1) * self.w[j + 1] - R::of_i32((C - 1 - j) as i32) * self.w[j];
                for i in 0..2 * C - 1 {
                    g[i + j] -= self.squares[i] * rate;
                }
            }
            count = 3 * (C - 1);
        }
        let mut changes = 0;
        let mut rising = first >= R::ZERO;
        for g in g.iter().take(count - 1).skip(1).chain([&last]) {
            if (*g >= R::ZERO) != rising {
                (rising, changes) = (!rising, changes + 1);
            }
        }
        changes
    }
}
