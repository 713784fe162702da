//! The fit.

use super::design::Design;
use super::{Basis, Observation, SMOOTHING, VolumetricFit, VolumetricRefusal};
use crate::linear_fit::LinearFit;
use std::vec;
use std::vec::Vec;

/// Fits the errors of three axes by the module's model.
///
/// Cost: 2 n² multiplications per coordinate for n unknowns (200 for a machine with 11 nodes per axis: 0.1 ms), and one
/// singular value decomposition of n × n.
///
/// # Errors
/// [`VolumetricRefusal`].
pub fn fit(observations: &[Observation], basis: &Basis) -> Result<VolumetricFit, VolumetricRefusal> {
    let design = Design::new(basis);
    let conventions = design.conventions();
    let needed = design.unknowns - conventions.len();
    let coordinates = 3 * observations.len();
    if coordinates <= needed {
        return Err(VolumetricRefusal::TooFew { found: coordinates, needed });
    }
    let mut fit = LinearFit::new(design.unknowns);
    let mut weights = 0.0;
    for of in observations {
        let weight = 1.0 / of.sigma_mm;
        weights += weight * weight;
        for (row, value) in design.rows(of).iter().zip(of.deviation_mm) {
            fit.add(row, value, weight);
        }
    }
    let weight = (weights / observations.len() as f64).sqrt();
    for (row, size) in &conventions {
        fit.add(row, 0.0, weight * size);
    }
    for (entries, size) in design.smoothing() {
        let mut row = vec![0.0; design.unknowns];
        for (unknown, value) in entries {
            row[unknown] = value;
        }
        fit.add(&row, 0.0, SMOOTHING * weight * size);
    }
    let solution = fit.solve();
    if !solution.unseen.is_empty() {
        let mut names: Vec<_> = solution.unseen.iter().map(|&unknown| design.name(unknown)).collect();
        names.dedup();
        return Err(VolumetricRefusal::Indistinct { names, rank: solution.rank, unknowns: design.unknowns });
    }
    let values = &solution.values;
    let mut squares = 0.0;
    let left_mm: Vec<[f64; 3]> = observations
        .iter()
        .map(|of| {
            let rows = design.rows(of);
            let left: [f64; 3] = std::array::from_fn(|c| {
                let modelled: f64 = rows[c].iter().zip(values).map(|(a, x)| a * x).sum();
                of.deviation_mm[c] - modelled
            });
            squares += left.iter().map(|mm| (mm / of.sigma_mm).powi(2)).sum::<f64>();
            left
        })
        .collect();
    let degrees_of_freedom = coordinates - needed;
    let sigma = (squares / degrees_of_freedom as f64).sqrt();
    let of = |from: &[f64], scale: f64| -> [[Vec<f64>; 6]; 3] {
        std::array::from_fn(|axis| {
            std::array::from_fn(|component| {
                let count = basis.nodes_mm[axis].len();
                let start = design.start(axis, component);
                start.map_or_else(|| vec![0.0; count], |s| from[s..s + count].iter().map(|v| scale * v).collect())
            })
        })
    };
    // A condition enters as a row with the scatter of a reading, but it is exact: what that scatter adds is subtracted.
    let exact: Vec<Vec<f64>> = conventions
        .iter()
        .map(|(row, size)| solution.covariance_with(row).into_iter().map(|value| weight * size * value).collect())
        .collect();
    let factor = |i: usize, j: usize| {
        solution.covariance_factor(i, j) - exact.iter().map(|condition| condition[i] * condition[j]).sum::<f64>()
    };
    let factors: Vec<f64> = (0..design.unknowns).map(|i| factor(i, i).max(0.0).sqrt()).collect();
    Ok(VolumetricFit {
        errors: of(values, 1.0),
        standard_errors: of(&factors, sigma),
        squareness: std::array::from_fn(|k| values[design.squareness + k]),
        squareness_errors: std::array::from_fn(|k| sigma * factors[design.squareness + k]),
        squareness_covariance: std::array::from_fn(|i| {
            std::array::from_fn(|j| sigma * sigma * factor(design.squareness + i, design.squareness + j))
        }),
        placement: std::array::from_fn(|k| values[design.placement + k]),
        offsets_mm: values[design.offsets..].chunks_exact(3).map(|o| [o[0], o[1], o[2]]).collect(),
        left_mm,
        sigma,
        degrees_of_freedom,
        unknowns: design.unknowns,
        conventions: conventions.len(),
        rank: solution.rank,
        condition: solution.condition,
    })
}
