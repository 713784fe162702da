//! Results of a circular test as settings of a machine.

use super::Test;
use super::document::{CERTAIN, squareness};
use trueaxis::Axis;
use trueaxis::machine::LocationErrors;
use trueaxis_metrology::ballbar::{Cause, Term};
use trueaxis_tables::{Additions, Machine};

impl Test {
    /// Squareness of the plane and backlash of its axes, as additions to what a machine's files state, with their standard
    /// uncertainties; beside them what is left out and why. `compensated`: the machine was corrected by its tables while the
    /// circles were run, so that they show what those leave; else what was found takes the place of what the files state.
    ///
    /// A scale mismatch is the difference of two scales and says nothing of either; where a bow lies along the axis, the test
    /// does not tell; lag, play and cyclic error have no place in a table.
    pub fn additions(&self, machine: &Machine, compensated: bool) -> (Additions, Vec<String>) {
        let (mut additions, mut notes) = (Additions::default(), Vec::new());
        let before = &machine.settings.location;
        let (name, sense) = squareness(self.options.axes);
        let certain = |name: &str, term: Option<&Term>, notes: &mut Vec<String>| {
            let term = term.copied()?;
            let certain = term.value.abs() > CERTAIN * term.standard_error;
            if !certain {
                notes.push(format!(
                    "{name} is left as it is: what was found is within {CERTAIN} of its standard errors"
                ));
            }
            certain.then_some(term)
        };
        if let Some(term) = certain(name, self.found.term(Cause::Squareness), &mut notes) {
            let found = sense * term.value;
            let of = |own: f64| if compensated { found } else { found - own };
            let mut location = LocationErrors::default();
            match name {
                "A0Z" => location.a0z = of(before.a0z),
                "B0Z" => location.b0z = of(before.b0z),
                _ => location.c0y = of(before.c0y),
            }
            additions.location = location;
            additions.set.push((format!("uncertainty.location.{name}_urad"), 1e6 * term.standard_error));
        }
        for (number, axis) in (0..).zip(self.options.axes) {
            let term = self.found.term(Cause::Backlash(number));
            let Some(term) = certain(&format!("backlash of {}", axis.letter()), term, &mut notes) else { continue };
            let own = machine.settings.axis(axis).map_or(0.0, |own| own.backlash);
            additions.backlash.push((axis, if compensated { term.value } else { term.value - own }));
            additions.set.push((uncertainty_key(axis), 1e3 * term.standard_error));
        }
        (additions, notes)
    }
}

fn uncertainty_key(axis: Axis) -> String {
    format!("axis.{}.uncertainty.backlash_um", axis.letter())
}
