//! Where settings stand in a file, for errors that are found later.

use super::section::Found;
use trueaxis::error::Field;
use trueaxis::machine::Axis;

/// Where a setting stands in the file.
pub(super) struct Place {
    pub(super) field: Field,
    pub(super) axis: Option<Axis>,
    pub(super) line: u32,
    pub(super) key: String,
    /// As written.
    pub(super) text: String,
    /// As it became in the settings.
    pub(super) values: Vec<f64>,
}

/// The places of all settings, collected while they are read.
#[derive(Default)]
pub(super) struct Places(Vec<Place>);

impl Places {
    /// One that is kept as text.
    pub(super) fn push(&mut self, place: Place) {
        self.0.push(place);
    }

    /// All of them, in the order of the file's reading.
    pub(super) fn into_all(self) -> Vec<Place> {
        self.0
    }

    /// Stores a number, converted, where the key is given.
    pub(super) fn number(
        &mut self,
        to: &mut f64,
        found: Option<Found<f64>>,
        field: Field,
        axis: Option<Axis>,
        convert: impl Fn(f64) -> f64,
    ) {
        if let Some(Found { value, line, key, text }) = found {
            *to = convert(value);
            self.0.push(Place { field, axis, line, key, text, values: vec![*to] });
        }
    }

    /// Stores a list of numbers where the key is given.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        to: &mut [f64; N],
        found: Option<Found<[f64; N]>>,
        field: Field,
        axis: Option<Axis>,
    ) -> bool {
        let given = found.is_some();
        if let Some(Found { value, line, key, text }) = found {
            *to = value;
            self.0.push(Place { field, axis, line, key, text, values: value.to_vec() });
        }
        given
    }
}
