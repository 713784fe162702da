//! Parameters of a program: `#1` to `#5602`, `#<name>` of a subprogram, `#<_name>` of all.

use std::collections::BTreeMap;

use super::expression::Parameter;

/// Most names with a value.
pub(super) const MOST_NAMES: usize = 10_000;

/// Parameters that a subprogram has for itself: #1 to #30.
pub(super) const ARGUMENTS: usize = 30;

/// Values that the program has assigned. Those that tell the interpreter's state are not here.
#[derive(Debug, Default)]
pub(super) struct Parameters {
    /// #1 to #30.
    pub(super) arguments: [f64; ARGUMENTS],
    numbered: BTreeMap<u32, f64>,
    global: BTreeMap<String, f64>,
    /// Names of the current subprogram.
    pub(super) local: BTreeMap<String, f64>,
}

impl Parameters {
    pub(super) fn numbered(&self, number: u32) -> f64 {
        match self.arguments.get((number as usize).wrapping_sub(1)) {
            Some(value) => *value,
            None => self.numbered.get(&number).copied().unwrap_or(0.0),
        }
    }

    pub(super) fn named(&self, name: &str) -> Option<f64> {
        if name.starts_with('_') { self.global.get(name) } else { self.local.get(name) }.copied()
    }

    /// Assigns a value; returns whether there was room for the name.
    pub(super) fn set(&mut self, parameter: Parameter<'_>, value: f64) -> bool {
        match parameter {
            Parameter::Number(number) => match self.arguments.get_mut((number as usize).wrapping_sub(1)) {
                Some(place) => *place = value,
                None => {
                    self.numbered.insert(number, value);
                }
            },
            Parameter::Name(name) => {
                let names = if name.starts_with('_') { &mut self.global } else { &mut self.local };
                if let Some(place) = names.get_mut(name) {
                    *place = value;
                } else if names.len() >= MOST_NAMES {
                    return false;
                } else {
                    names.insert(name.to_owned(), value);
                }
            }
        }
        true
    }
}
