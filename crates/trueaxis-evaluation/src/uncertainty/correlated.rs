//! Correlation of the terms of a machine.

use super::terms::{Correlated, Term, Terms};
use trueaxis_metrology::uncertainty::{Correlations, Pair};
use trueaxis_tables::uncertainty::Correlation;

/// Units at the end of a key in `machine.toml`, which the key of a term may omit.
const UNITS: [&str; 2] = ["_um", "_urad"];

impl Terms {
    /// Correlates the terms as stated; those that are not among them, such as growth without a temperature, are left out.
    /// To be called when all terms are known.
    pub(crate) fn correlate(&mut self, stated: &[Correlation]) {
        let place = |key: &str| {
            let is_own = |own: &str| key.strip_prefix(own).is_some_and(|unit| unit.is_empty() || UNITS.contains(&unit));
            let found = self.keys.iter().find(|(own, _)| !own.is_empty() && is_own(own));
            found.map(|(_, term)| *term).filter(|term| *term < self.all.len())
        };
        let pair = |own: &Correlation| {
            let [one, other] = &own.between;
            Some(([place(one)?, place(other)?], own.coefficient))
        };
        let pairs: Vec<Pair> = stated.iter().filter_map(pair).collect();
        let terms = correlations(&pairs, self.all.iter());
        for group in terms.groups() {
            let names: Vec<&str> = group.iter().map(|term| self.all[*term].name.as_str()).collect();
            self.warnings.push(format!(
                "{} are correlated: each share includes half of what two have in common, and may be negative",
                names.join(", ")
            ));
        }
        self.correlated = Correlated { pairs, terms };
    }
}

impl Correlated {
    /// Correlation of quantities of which each belongs to the term at this index; terms that are correlated have one.
    #[cfg_attr(not(feature = "simulation"), expect(dead_code, reason = "predicted parts alone have others than terms"))]
    pub(crate) fn of_quantities(&self, terms: &Terms, of: &[usize]) -> Correlations {
        let place = |term: usize| of.iter().position(|own| *own == term);
        let pair = |([a, b], coefficient): &Pair| Some(([place(*a)?, place(*b)?], *coefficient));
        let pairs: Vec<Pair> = self.pairs.iter().filter_map(pair).collect();
        correlations(&pairs, of.iter().map(|term| &terms.all[*term]))
    }
}

/// The reader has checked the coefficients, and those of some of the terms are as possible as those of all.
fn correlations<'t>(pairs: &[Pair], terms: impl Iterator<Item = &'t Term>) -> Correlations {
    Correlations::new(pairs, &terms.map(|term| term.degrees_of_freedom).collect::<Vec<_>>()).unwrap_or_default()
}
