//! A quantity with its uncertainty.

use super::Cell;
use crate::uncertainty::band_factor;
use trueaxis_report::number::{as_far_as, significant};

/// Heading of a column of expanded uncertainties.
pub const EXPANDED: &str = "± 95 %";

/// Significant digits of an uncertainty.
const DIGITS: i32 = 2;
/// Significant digits of a value whose uncertainty is not known.
const ALONE: i32 = 4;

/// How well a value is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Uncertainty {
    /// Half of the interval that contains the true value with 95 %, in the value's unit.
    Expanded(f64),
    /// The value was fixed, not determined; the word that says so.
    Held(&'static str),
    /// Not known.
    Unknown,
}

impl Uncertainty {
    /// Expands a standard error by Student's factor; by that of a normal distribution below one degree of freedom, where the
    /// standard error does not come from residuals (JCGM 100:2008, G.3). [`Unknown`](Uncertainty::Unknown) for a standard error
    /// of zero below one degree of freedom: no residual shows the scatter.
    pub fn of(standard_error: f64, degrees_of_freedom: f64) -> Uncertainty {
        if standard_error == 0.0 && degrees_of_freedom < 1.0 {
            return Uncertainty::Unknown;
        }
        Uncertainty::expanded(half_width(standard_error, degrees_of_freedom))
    }

    /// Expands a standard error that follows from a stated repeatability, whose degrees of freedom count as infinite.
    pub fn foreseen(standard_error: f64) -> Uncertainty {
        Uncertainty::of(standard_error, f64::INFINITY)
    }

    /// An expanded uncertainty; [`Unknown`](Uncertainty::Unknown) unless it is finite.
    pub fn expanded(half_width: impl Into<Option<f64>>) -> Uncertainty {
        let known = half_width.into().filter(|half_width| half_width.is_finite());
        known.map_or(Uncertainty::Unknown, Uncertainty::Expanded)
    }

    /// The uncertainty as a cell.
    pub fn cell(self) -> Cell {
        match self {
            Uncertainty::Expanded(half_width) => Cell::number(half_width, DIGITS),
            Uncertainty::Held(word) => word.into(),
            Uncertainty::Unknown => "–".into(),
        }
    }

    /// A value with this uncertainty: rounded to the place of the uncertainty's last digit, or to four significant digits if
    /// there is none.
    pub fn value(self, value: impl Into<Option<f64>>) -> Cell {
        Cell::written(value.into(), |value| match self {
            Uncertainty::Expanded(half_width) => as_far_as(value, half_width, DIGITS),
            _ => significant(value, ALONE),
        })
    }
}

/// Half of a 95 % interval from a standard error, as [`Uncertainty::of`].
pub fn half_width(standard_error: f64, degrees_of_freedom: f64) -> f64 {
    standard_error * band_factor(if degrees_of_freedom < 1.0 { f64::INFINITY } else { degrees_of_freedom })
}

/// A quantity found, with its uncertainty: a row of [`Table::quantities`](super::Table::quantities).
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Name of the quantity.
    pub quantity: String,
    /// Its symbol in the model, or "".
    pub symbol: &'static str,
    /// Unit of value and uncertainty, or "".
    pub unit: &'static str,
    /// The value; `None` if the record does not determine it.
    pub value: Option<f64>,
    /// How well the value is known.
    pub uncertainty: Uncertainty,
    /// Decimals of the value if its uncertainty is not known; four significant digits if they are not set.
    pub decimals: Option<i32>,
    /// Remark on the value, or "".
    pub note: String,
}

impl Quantity {
    /// A quantity without symbol and note.
    pub fn new(
        quantity: impl Into<String>,
        unit: &'static str,
        value: impl Into<Option<f64>>,
        uncertainty: Uncertainty,
    ) -> Quantity {
        let (quantity, value) = (quantity.into(), value.into());
        Quantity { quantity, symbol: "", unit, value, uncertainty, decimals: None, note: String::new() }
    }

    /// Adds a symbol.
    #[must_use]
    pub fn symbol(self, symbol: &'static str) -> Quantity {
        Quantity { symbol, ..self }
    }

    /// Sets the number of decimals if the uncertainty is not known.
    #[must_use]
    pub fn decimals(self, count: i32) -> Quantity {
        Quantity { decimals: Some(count), ..self }
    }

    /// Adds a note.
    #[must_use]
    pub fn noted(self, note: impl Into<String>) -> Quantity {
        Quantity { note: note.into(), ..self }
    }

    /// Quantity and symbol.
    pub fn name(&self) -> String {
        if self.symbol.is_empty() { self.quantity.clone() } else { format!("{} {}", self.quantity, self.symbol) }
    }

    /// Quantity, symbol and unit.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.name() } else { format!("{}, {}", self.name(), self.unit) }
    }

    /// Value and uncertainty.
    pub fn cells(&self) -> [Cell; 2] {
        // The uncertainty of a value that is missing says nothing.
        let uncertainty = if self.value.is_some() { self.uncertainty } else { Uncertainty::Unknown };
        let value = match (self.decimals, uncertainty) {
            (Some(count), Uncertainty::Unknown | Uncertainty::Held(_)) => Cell::fixed(self.value, count),
            _ => uncertainty.value(self.value),
        };
        [value, uncertainty.cell()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_the_digits_of_its_uncertainty() {
        let shown = |value: f64, uncertainty: Uncertainty| {
            let of = Quantity::new("gain", "1/s", value, uncertainty).symbol("K_v");
            assert_eq!(of.label(), "gain K_v, 1/s");
            of.cells().map(|cell| cell.text().to_owned())
        };
        assert_eq!(shown(0.510_54, Uncertainty::Expanded(0.2204)), ["0.51", "0.22"]);
        assert_eq!(shown(110.0, Uncertainty::Expanded(23.4)), ["110", "23"]);
        assert_eq!(shown(-0.0004, Uncertainty::Expanded(0.0996)), ["0.000", "0.100"]);
        assert_eq!(shown(2.0, Uncertainty::Held("held")), ["2.000", "held"]);
        assert_eq!(shown(2.0, Uncertainty::of(f64::NAN, 4.0)), ["2.000", "–"]);
        assert_eq!(
            Quantity::new("", "", None, Uncertainty::Expanded(1.0)).cells().map(|cell| cell.text().len()),
            [3, 3]
        );
    }

    #[test]
    fn a_standard_error_is_expanded_by_its_degrees_of_freedom() {
        // Student's t for 97.5 %: tables of ISO 3534-1.
        for (degrees, factor) in [(1.0, 12.7062), (4.0, 2.7764), (6.0, 2.4469), (0.0, 1.95996), (1e9, 1.95996)] {
            let Uncertainty::Expanded(found) = Uncertainty::of(3.0, degrees) else { panic!("unknown") };
            assert!((found / 3.0 - factor).abs() < 1e-4, "{degrees}: {found}");
        }
        assert_eq!(Uncertainty::of(0.0, 0.0), Uncertainty::Unknown);
        assert_eq!(Uncertainty::of(0.0, 4.0), Uncertainty::Expanded(0.0));
    }
}
