//! What measurements leave of the uncertainty of quantities.

use super::Correlations;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::vec::Vec;

/// Quantities z of unit variance with correlation C after a measurement y = D z + ε with covariance R of ε.
///
/// ```text
/// P = (C⁻¹ + Dᵀ R⁻¹ D)⁻¹ = C − C Dᵀ S⁻¹ D C,   S = D C Dᵀ + R       the second also if C is singular
/// z − ẑ = z − C Dᵀ S⁻¹ (D z + ε)               has the covariance P
/// ```
///
/// Source: Särkkä, Bayesian Filtering and Smoothing, 2013, section 4.3; for the draws Chilès and Delfiner, Geostatistics,
/// 2nd ed., section 7.3.
#[derive(Clone, Debug)]
pub struct Update {
    design: DMatrix<f64>,
    /// D C.
    seen: DMatrix<f64>,
    prior: Correlations,
    /// Lower factor of R.
    noise: DMatrix<f64>,
    sum: Cholesky<f64, Dyn>,
}

impl Update {
    /// The rows of D, R row by row, and the correlation of the quantities; `None` if R or S is not positive definite or a row
    /// has another length.
    pub fn new(design: &[Vec<f64>], noise: &[Vec<f64>], prior: &Correlations) -> Option<Update> {
        let seen: Vec<Vec<f64>> = design.iter().map(|row| prior.times(row)).collect();
        let [design, noise] = matrices(design, noise)?;
        let seen = DMatrix::from_fn(design.nrows(), design.ncols(), |row, column| seen[row][column]);
        let sum = Cholesky::new(&seen * design.transpose() + &noise)?;
        Some(Update { design, seen, prior: prior.clone(), noise: Cholesky::new(noise)?.l(), sum })
    }

    /// Number of readings.
    pub fn readings(&self) -> usize {
        self.noise.nrows()
    }

    /// Weights w of the readings in the estimate of d · z: w = S⁻¹ D C d.
    pub fn weights(&self, d: &[f64]) -> Vec<f64> {
        self.sum.solve(&(&self.seen * DVector::from_column_slice(d))).as_slice().to_vec()
    }

    /// Variance of d · z before the measurement: d C dᵀ.
    pub fn before(&self, d: &[f64]) -> f64 {
        self.prior.times(d).iter().zip(d).map(|(common, part)| common * part).sum()
    }

    /// Variance of d · z after the measurement: d P dᵀ.
    pub fn variance(&self, d: &[f64]) -> f64 {
        let seen = &self.seen * DVector::from_column_slice(d);
        (self.before(d) - seen.dot(&self.sum.solve(&seen))).max(0.0)
    }

    /// Variance of every quantity after the measurement.
    pub fn variances(&self) -> Vec<f64> {
        let solved = self.sum.solve(&self.seen);
        let of = |column: usize| (1.0 - self.seen.column(column).dot(&solved.column(column))).max(0.0);
        (0..self.seen.ncols()).map(of).collect()
    }

    /// Whether the readings say something of a quantity, also by way of those that it is correlated with.
    pub fn sees(&self, quantity: usize) -> bool {
        self.seen.column(quantity).amax() > 1e-9
    }

    /// Readings of drawn quantities, with noise from standard normal numbers, one for each reading.
    pub fn read(&self, z: &[f64], normal: &[f64]) -> Vec<f64> {
        let read = &self.design * DVector::from_column_slice(z) + &self.noise * DVector::from_column_slice(normal);
        read.as_slice().to_vec()
    }

    /// The estimate of all quantities from readings.
    pub fn estimate(&self, readings: &[f64]) -> Vec<f64> {
        let solved = self.sum.solve(&DVector::from_column_slice(readings));
        (self.seen.transpose() * solved).as_slice().to_vec()
    }
}

/// D and R as matrices; `None` if there is no row or one of another length.
fn matrices(design: &[Vec<f64>], noise: &[Vec<f64>]) -> Option<[DMatrix<f64>; 2]> {
    let (rows, count) = (design.len(), design.first()?.len());
    let is_whole = noise.len() == rows && design.iter().all(|row| row.len() == count);
    let whole = |of: &[Vec<f64>], columns| DMatrix::from_fn(rows, columns, |row, column| of[row][column]);
    (is_whole && noise.iter().all(|row| row.len() == rows)).then(|| [whole(design, count), whole(noise, rows)])
}

/// Singular value of a whitened design below which a combination of readings says nothing: it would leave 99.9 % of a variance.
const NOTHING: f64 = 0.03;

/// As few independent readings of unit variance as say the same about quantities of unit variance, independent or correlated:
/// the rows of their design. `None` as in [`Update::new`].
pub fn condensed(design: &[Vec<f64>], noise: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let [design, noise] = matrices(design, noise)?;
    let white = Cholesky::new(noise)?.l().solve_lower_triangular(&design)?;
    // Of the smaller of the two Gram matrices: rows are fewer than quantities.
    let own = (&white * white.transpose()).symmetric_eigen();
    let shows = (0..white.nrows()).filter(|k| own.eigenvalues[*k] > NOTHING * NOTHING);
    Some(shows.map(|k| (own.eigenvectors.column(k).transpose() * &white).as_slice().to_vec()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn none() -> Correlations {
        Correlations::default()
    }

    /// One reading a z₁ + b z₂ with noise r: P is the inverse of [[1 + a²/r², ab/r²], [ab/r², 1 + b²/r²]], by Cramer's rule.
    #[test]
    fn two_quantities_and_one_reading_in_closed_form() {
        let (a, b, r) = (3.0, -2.0, 0.5_f64);
        let update = Update::new(&[Vec::from([a, b])], &[Vec::from([r * r])], &none()).unwrap();
        let [p11, p12, p22] = [1.0 + a * a / (r * r), a * b / (r * r), 1.0 + b * b / (r * r)];
        let determinant = p11 * p22 - p12 * p12;
        for d in [[1.0, 0.0], [0.0, 1.0], [0.7, 1.9]] {
            let wanted = (p22 * d[0] * d[0] - 2.0 * p12 * d[0] * d[1] + p11 * d[1] * d[1]) / determinant;
            assert!((update.variance(&d) - wanted).abs() < 1e-12, "{} for {wanted}", update.variance(&d));
        }
        let [first, second] = [p22 / determinant, p11 / determinant];
        assert!((update.variances()[0] - first).abs() < 1e-12 && (update.variances()[1] - second).abs() < 1e-12);
        // d · ẑ by the weights of the readings and by the estimate.
        let (reading, d) = (Vec::from([1.7]), [0.7, 1.9]);
        let estimate = update.estimate(&reading);
        let by_weights = update.weights(&d)[0] * reading[0];
        assert!((estimate[0] * d[0] + estimate[1] * d[1] - by_weights).abs() < 1e-12);
    }

    /// Of two quantities with coefficient c one is read: P = [[1 − w, c (1 − w)], [., 1 − c² w]], w = a²/(a² + r²), by the
    /// regression of the second on the first; at c = ±1 the second is known as well as the first.
    #[test]
    fn a_reading_of_one_quantity_shows_a_correlated_one() {
        let (a, r) = (3.0, 0.5_f64);
        for c in [0.6, -0.9, 1.0, -1.0] {
            let prior = Correlations::new(&[([0, 2], c)], &[f64::INFINITY; 3]).unwrap();
            let update = Update::new(&[Vec::from([a, 0.0, 0.0])], &[Vec::from([r * r])], &prior).unwrap();
            let w = a * a / (a * a + r * r);
            let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-9, "{c}: {found} for {wanted}");
            let variances = update.variances();
            [1.0 - w, 1.0, 1.0 - c * c * w].into_iter().zip(variances).for_each(|(wanted, found)| near(found, wanted));
            let (p, q) = (0.7, -1.9);
            let wanted = p * p * (1.0 - w) + 2.0 * p * q * c * (1.0 - w) + q * q * (1.0 - c * c * w);
            near(update.variance(&[p, 0.0, q]), wanted);
            near(update.before(&[p, 0.0, q]), p * p + q * q + 2.0 * c * p * q);
            let estimate = update.estimate(&[1.7]);
            near(estimate[2], c * estimate[0]);
            near(estimate[0], 1.7 * w / a);
            near(update.weights(&[p, 0.0, q])[0] * 1.7, p * estimate[0] + q * estimate[2]);
            assert!(update.sees(0) && !update.sees(1) && update.sees(2));
        }
    }

    /// Readings that share a noise, and one of them twice.
    #[test]
    fn condensed_readings_say_the_same() {
        let design = [Vec::from([2.0, 1.0, 0.0]), Vec::from([0.5, -1.0, 0.0]), Vec::from([2.0, 1.0, 0.0])];
        let noise = [Vec::from([2.0, 1.0, 1.0]), Vec::from([1.0, 2.0, 1.0]), Vec::from([1.0, 1.0, 2.0])];
        let all = Update::new(&design, &noise, &none()).unwrap();
        let few = condensed(&design, &noise).unwrap();
        assert_eq!(few.len(), 2);
        let unit = [Vec::from([1.0, 0.0]), Vec::from([0.0, 1.0])];
        let few = Update::new(&few, &unit, &none()).unwrap();
        for d in [[1.0, 0.0, 0.0], [0.3, -2.0, 0.0], [0.0, 0.0, 1.0]] {
            assert!((all.variance(&d) - few.variance(&d)).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_no_measurement_is_none() {
        assert!(Update::new(&[], &[], &none()).is_none());
        assert!(Update::new(&[Vec::from([1.0])], &[Vec::from([-2.0])], &none()).is_none());
        assert!(Update::new(&[Vec::from([1.0])], &[Vec::from([1.0, 0.0])], &none()).is_none());
    }
}
