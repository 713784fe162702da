//! Covariance of the terms of a fit.

use serde::Serialize;

/// Covariance of terms, in the order of a fit's document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CovarianceDocument {
    /// Names of the terms.
    pub names: Vec<String>,
    /// Units of the terms; an entry of the matrix has the product of two.
    pub units: Vec<&'static str>,
    /// Estimates of the terms.
    pub estimates: Vec<f64>,
    /// Variances and covariances, row by row.
    pub matrix: Vec<Vec<f64>>,
}

/// A term of a covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name of the term.
    pub name: String,
    /// Unit of the term in the document.
    pub unit: &'static str,
    /// Factor from the fit's unit to `unit`.
    pub factor: f64,
    /// Value of the term, in the fit's unit.
    pub value: f64,
}

impl CovarianceDocument {
    /// The covariance of terms; `entry` gives it in the fit's units.
    pub fn of(terms: Vec<Estimate>, entry: impl Fn(usize, usize) -> f64) -> CovarianceDocument {
        let factors: Vec<f64> = terms.iter().map(|term| term.factor).collect();
        let row = |(i, a): (usize, &f64)| factors.iter().enumerate().map(|(j, b)| a * b * entry(i, j)).collect();
        let matrix = factors.iter().enumerate().map(row).collect();
        let estimates = terms.iter().map(|term| term.factor * term.value).collect();
        let (names, units) = terms.into_iter().map(|term| (term.name, term.unit)).unzip();
        CovarianceDocument { names, units, estimates, matrix }
    }

    /// The covariance of those terms that have a variance: a fit without one has fixed the term. `entry` gives the covariance of
    /// all terms, in the fit's units.
    pub fn of_fitted(terms: Vec<Estimate>, entry: impl Fn(usize, usize) -> f64) -> CovarianceDocument {
        let fitted = terms.into_iter().enumerate().filter(|(i, _)| entry(*i, *i) > 0.0);
        let (places, terms): (Vec<usize>, Vec<Estimate>) = fitted.unzip();
        CovarianceDocument::of(terms, |i, j| entry(places[i], places[j]))
    }
}
