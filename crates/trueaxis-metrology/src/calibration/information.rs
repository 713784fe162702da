//! What planned touches tell about some unknowns of a network, as a sum over independent placements.

use super::network::Network;
use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// Share of a diagonal that keeps directions that no touch sees from being divided by zero.
const LEAST: f64 = 1e-12;

/// An information matrix, the inverse of a covariance; those of independent touches add up.
#[derive(Clone, Debug, PartialEq)]
pub struct Information(DMatrix<f64>);

impl Information {
    /// Quantities that are known within standard deviations, independently of each other.
    pub fn of_ranges(ranges: &[f64]) -> Information {
        let own = ranges.iter().map(|range| 1.0 / (range * range).max(f64::MIN_POSITIVE));
        Information(DMatrix::from_diagonal(&DVector::from_iterator(ranges.len(), own)))
    }

    /// The same about quantities of a longer list of `count`, at these indices of it.
    #[must_use]
    pub fn spread(&self, to: &[usize], count: usize) -> Information {
        let mut all = DMatrix::zeros(count, count);
        for (row, i) in to.iter().enumerate() {
            for (column, j) in to.iter().enumerate() {
                all[(*i, *j)] = self.0[(row, column)];
            }
        }
        Information(all)
    }

    /// Adds what independent touches tell about the same quantities.
    pub fn add(&mut self, other: &Information) {
        self.0 += &other.0;
    }

    /// The covariance, row by row; `None` if a combination is unknown.
    pub fn covariance(&self) -> Option<Vec<Vec<f64>>> {
        let inverse = self.0.clone().cholesky()?.inverse();
        Some(inverse.row_iter().map(|row| row.iter().copied().collect()).collect())
    }

    /// Σ G ∘ P: the sum of the variances of some linear figures, with the covariance P and the Gram matrix G of their
    /// derivatives with respect to the first quantities; infinite if a combination is unknown. Cost: one inverse.
    pub fn variance(&self, gram: &[Vec<f64>]) -> f64 {
        let Some(inverse) = self.0.clone().cholesky().map(|factor| factor.inverse()) else { return f64::INFINITY };
        let of_row =
            |(i, row): (usize, &Vec<f64>)| row.iter().enumerate().map(|(j, g)| g * inverse[(i, j)]).sum::<f64>();
        gram.iter().enumerate().map(of_row).sum()
    }
}

impl Network {
    /// What the touches tell about some unknowns, linearised where the network starts; the others are free or known within
    /// their uncertainty: N₁₁ − N₁₂ N₂₂⁻¹ N₂₁ of the normal matrix N. Uncertainties of the kept unknowns do not enter.
    pub fn information(&self, keep: &[usize]) -> Information {
        let start: Vec<f64> = self.unknowns.iter().map(|unknown| unknown.start).collect();
        let others: Vec<usize> = (0..start.len()).filter(|index| !keep.contains(index)).collect();
        let mut column = Vec::from([0; 0]);
        column.resize(start.len(), 0);
        keep.iter().chain(&others).enumerate().for_each(|(at, index)| column[*index] = at);
        let mut design: DMatrix<f64> = DMatrix::zeros(self.touches.len(), start.len());
        for (index, touch) in self.touches.iter().enumerate() {
            for (unknown, derivative) in touch.row(&start, self.tip).derivatives {
                design[(index, column[unknown])] += derivative / self.repeatability_mm;
            }
        }
        let mut normal = design.transpose() * &design;
        for (at, index) in others.iter().enumerate() {
            let known = self.unknowns[*index].uncertainty.map_or(0.0, |known| 1.0 / (known * known));
            let place = keep.len() + at;
            normal[(place, place)] = (normal[(place, place)] + known) * (1.0 + LEAST) + LEAST;
        }
        let (count, rest) = (keep.len(), others.len());
        let own = normal.view((0, 0), (count, count)).into_owned();
        let across = normal.view((0, count), (count, rest)).into_owned();
        let eliminated = normal.view((count, count), (rest, rest)).into_owned().cholesky();
        Information(match eliminated {
            Some(factor) => own - &across * factor.solve(&across.transpose()),
            // Nothing is said for sure.
            None => DMatrix::zeros(count, count),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Surface, Touch, Unknown};
    use super::*;

    /// Faces at x of positions that one unknown offset shifts: a slope b in x ↦ x + b x is known to σ² / Σ (x − x̄)², as by
    /// the line of least squares.
    #[test]
    fn an_eliminated_offset_leaves_the_variance_of_a_slope() {
        let at = [0.0, 10.0, 25.0, 70.0];
        let unknown = |uncertainty| Unknown { start: 0.0, uncertainty };
        let touch = |&x: &f64| Touch {
            tip_mm: [x, 0.0, 0.0],
            surface: Surface::Face {
                normal: [1.0, 0.0, 0.0],
                outward: 1.0,
                known_mm: x,
                parts: Vec::from([super::super::Part { unknown: 2, factor: 1.0, along: None }]),
            },
            response: Vec::from([[x, 0.0, 0.0]]),
            drift: Vec::new(),
            own_tip: None,
            weight: 1.0,
        };
        let network = Network {
            unknowns: Vec::from([unknown(None), unknown(Some(1e-6)), unknown(None)]),
            terms: 1,
            tip: 1,
            touches: at.iter().map(touch).collect(),
            repeatability_mm: 2e-3,
        };
        let mean = at.iter().sum::<f64>() / 4.0;
        let wanted = 4e-6 / at.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        let information = network.information(&[0]);
        assert!((information.variance(&[Vec::from([1.0])]) / wanted - 1.0).abs() < 1e-6);
        let mut with_range = information.clone();
        with_range.add(&Information::of_ranges(&[wanted.sqrt()]));
        assert!((with_range.variance(&[Vec::from([1.0])]) / (0.5 * wanted) - 1.0).abs() < 1e-6);
        let spread = with_range.spread(&[1], 2);
        assert_eq!(spread.covariance(), None, "of the other quantity nothing is known");
    }
}
