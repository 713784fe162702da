//! Selection of the terms of a network that have moved.

use super::CalibrationRefusal;
use super::network::{Network, Solution, Unknown};
use std::vec::Vec;

/// Standard uncertainty that fixes a term at zero, mm or rad.
const HELD: f64 = 1e-9;

/// Solutions of a network with all of its terms, and with only the moved ones.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Selection {
    /// Solution with all terms free.
    pub all: Solution,
    /// Which terms have moved.
    pub moved: Vec<bool>,
    /// Solution with the other terms fixed at zero.
    pub chosen: Solution,
}

impl Network {
    /// Selects the terms that differ from zero by more than `factors` of their standard errors, by backward elimination: the
    /// least significant term below its limit is fixed at zero and all others are solved again, until every remaining term
    /// exceeds its limit.
    ///
    /// ```text
    /// |x_i| ≤ k_i s_i  for the i with the least |x_i|/(k_i s_i)  →  x_i = 0, again
    /// ```
    ///
    /// Standard errors use at least the stated repeatability. A term that did not move cannot absorb part of another one's
    /// effect, and scatter causes no update. `factors`: one per term, in the order of the unknowns. Cost: as
    /// [`Network::solve`], once more for each fixed term.
    ///
    /// # Errors
    /// [`CalibrationRefusal`].
    pub fn moved(&self, factors: &[f64]) -> Result<Selection, CalibrationRefusal> {
        let all = self.solve_with_care()?;
        let mut network = self.clone();
        let mut moved: Vec<bool> = (0..self.terms).map(|_| true).collect();
        let mut chosen = all.clone();
        loop {
            let share = |index: usize| {
                let limit = factors.get(index).copied().unwrap_or(0.0) * chosen.standard_errors[index];
                chosen.values[index].abs() / limit.max(f64::MIN_POSITIVE)
            };
            let free = (0..self.terms).filter(|index| moved[*index]);
            let least = free.map(|index| (index, share(index))).min_by(|one, other| one.1.total_cmp(&other.1));
            let Some((index, _)) = least.filter(|(_, share)| *share <= 1.0) else { break };
            moved[index] = false;
            network.unknowns[index] = Unknown { start: 0.0, uncertainty: Some(HELD) };
            chosen = network.solve_with_care()?;
        }
        Ok(Selection { all, moved, chosen })
    }
}
