//! Which terms of a network have moved.

use super::Refused;
use super::network::{Network, Solution, Unknown};
use std::vec::Vec;

/// What holds a term at zero: its standard uncertainty, mm or rad.
const HELD: f64 = 1e-9;

/// A network with all of its terms, and with those alone that have moved.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Selection {
    /// Everything free.
    pub all: Solution,
    /// Which terms have moved.
    pub moved: Vec<bool>,
    /// The others held at zero.
    pub chosen: Solution,
}

impl Network {
    /// The terms that differ from zero by more than `factors` of their standard errors, by backward elimination: the least of
    /// those that do not is held at zero, and all others are found again without it, until none is left.
    ///
    /// ```text
    /// |x_i| ≤ k_i s_i  for the i with the least |x_i|/(k_i s_i)  →  x_i = 0, again
    /// ```
    ///
    /// Standard errors are by the stated repeatability at least. A term that did not move takes no part of what another one explains, and no update is made of scatter. `factors`: one a
    /// term, in the order of the unknowns. Cost: as [`Network::solve`], once more for every term that is held.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn moved(&self, factors: &[f64]) -> Result<Selection, Refused> {
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
