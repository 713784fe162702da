//! Covariance of the terms of a fit.

use serde::Serialize;

/// Covariance of terms, in the order of a fit's document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CovarianceDocument {
    /// Names of the terms.
    pub names: Vec<String>,
    /// Units of the terms; an entry of the matrix has the product of two.
    pub units: Vec<&'static str>,
    /// Variances and covariances, row by row.
    pub matrix: Vec<Vec<f64>>,
}

impl CovarianceDocument {
    /// The covariance of terms with their name, unit and factor to that unit; `entry` gives it before the factors.
    pub fn of(terms: Vec<(String, &'static str, f64)>, entry: impl Fn(usize, usize) -> f64) -> CovarianceDocument {
        let factors: Vec<f64> = terms.iter().map(|(_, _, factor)| *factor).collect();
        let row = |(i, a): (usize, &f64)| factors.iter().enumerate().map(|(j, b)| a * b * entry(i, j)).collect();
        let matrix = factors.iter().enumerate().map(row).collect();
        let (names, units) = terms.into_iter().map(|(name, unit, _)| (name, unit)).unzip();
        CovarianceDocument { names, units, matrix }
    }
}
