//! Contributions to the uncertainty of a point, and their sum.

use super::{Correlations, chi_squared_quantile, student_factor};
use std::vec;
use std::vec::Vec;

/// Contribution of one quantity to the uncertainty of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Derivative of the point with respect to the quantity, times its standard uncertainty, mm.
    pub vector: [f64; 3],
    /// Degrees of freedom of the standard uncertainty; infinite if it is well known.
    pub degrees_of_freedom: f64,
}

impl Contribution {
    /// Returns the variance, summed over the directions, mm².
    pub fn variance(&self) -> f64 {
        self.vector.iter().map(|part| part * part).sum()
    }
}

/// Covariance of a point with its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance {
    /// Σ, mm².
    pub matrix: [[f64; 3]; 3],
    /// Effective degrees of freedom of each coordinate.
    pub degrees_of_freedom: [f64; 3],
    /// Effective degrees of freedom of the trace.
    pub degrees_of_freedom_of_all: f64,
}

impl Covariance {
    /// Sums contributions; effective degrees of freedom after Welch and Satterthwaite (JCGM 100:2008, G.4.1).
    ///
    /// ```text
    /// u² = Σ_k c_k,  c_k = s_k Σ_l r_kl s_l       ∂u²/∂u_k = 2 c_k/u_k,  u(u_k)² = u_k²/(2 ν_k)
    /// ν = u⁴ / Σ_k (c_k²/ν_k)
    /// ```
    ///
    /// Without correlation c_k is s_k², and that is the known formula. Standard uncertainties of one fit are wrong by one
    /// factor: their c_k are summed before they are squared.
    pub fn of(contributions: &[Contribution], correlations: &Correlations) -> Covariance {
        let common: [Vec<f64>; 3] = core::array::from_fn(|i| {
            correlations.times(&contributions.iter().map(|one| one.vector[i]).collect::<Vec<_>>())
        });
        let mut matrix = [[0.0; 3]; 3];
        let mut parts = vec![[0.0; 3]; contributions.len()];
        for (k, one) in contributions.iter().enumerate() {
            for (row, a) in matrix.iter_mut().zip(one.vector) {
                for (cell, of) in row.iter_mut().zip(&common) {
                    *cell += a * of[k];
                }
            }
            let sum = &mut parts[correlations.first(k)];
            sum.iter_mut().zip(one.vector).zip(&common).for_each(|((sum, a), of)| *sum += a * of[k]);
        }
        let (mut fourth, mut fourth_of_all) = ([0.0; 3], 0.0);
        for (one, part) in contributions.iter().zip(&parts) {
            for (sum, part) in fourth.iter_mut().zip(part) {
                *sum += part * part / one.degrees_of_freedom;
            }
            fourth_of_all += part.iter().sum::<f64>().powi(2) / one.degrees_of_freedom;
        }
        let variances: [f64; 3] = core::array::from_fn(|i| matrix[i][i].max(0.0));
        let effective =
            |variance: f64, fourth: f64| if fourth > 0.0 { variance * variance / fourth } else { f64::INFINITY };
        Covariance {
            matrix,
            degrees_of_freedom: core::array::from_fn(|i| effective(variances[i], fourth[i])),
            degrees_of_freedom_of_all: effective(variances.iter().sum(), fourth_of_all),
        }
    }

    /// Returns the standard uncertainties of the coordinates, mm.
    pub fn standard(&self) -> [f64; 3] {
        core::array::from_fn(|i| self.matrix[i][i].max(0.0).sqrt())
    }

    /// Returns the coverage factors of the coordinates for a coverage of `p`: Student's, with the effective degrees of
    /// freedom.
    pub fn factors(&self, p: f64) -> [f64; 3] {
        self.degrees_of_freedom.map(|nu| student_factor(p, nu))
    }

    /// Returns the radius about the point that contains it with coverage `p`, mm.
    ///
    /// ```text
    /// |d|² ≈ g χ²_h      g = tr Σ²/tr Σ,  h = (tr Σ)²/tr Σ²,      radius = √(g χ²_h,p) · t_p(ν)/t_p(∞)
    /// ```
    ///
    /// The approximation matches mean and variance of |d|²; it is exact if Σ has one direction or is equal in all three.
    /// Source: F. E. Satterthwaite, 10.2307/3002019; J. P. Imhof, 10.1093/biomet/48.3-4.419, section 4.
    pub fn radius(&self, p: f64) -> f64 {
        let trace: f64 = (0..3).map(|i| self.matrix[i][i]).sum();
        let squared: f64 = self.matrix.iter().flatten().map(|cell| cell * cell).sum();
        if trace <= 0.0 || squared <= 0.0 {
            return 0.0;
        }
        let few = student_factor(p, self.degrees_of_freedom_of_all) / student_factor(p, f64::INFINITY);
        (squared / trace * chi_squared_quantile(p, trace * trace / squared)).sqrt() * few
    }
}
