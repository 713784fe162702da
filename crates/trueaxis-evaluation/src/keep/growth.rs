//! Adds the growth that a probing finds to the text of a `thermal.toml`.

use crate::calibrate::{Term, Terms};
use std::path::Path;
use toml_edit::{Array, DocumentMut, Item, TableLike, Value};
use trueaxis::machine::Axis;
use trueaxis_tables::Machine;
use trueaxis_tables::error::FileError;

/// Returns the text with the growth of `values` (mm, 1) added; comments and order are unchanged.
///
/// One probing cannot show which sensor's curve is wrong. This function therefore adds the same value to all knots of the
/// axis' first curve, which adds a constant to the sum of all curves at every temperature.
///
/// ```text
/// O(θ) ← O(θ) + v₀ + v₁ (q0 − z)        S(θ) ← S(θ) + v₁        z: where the expansion is zero
/// ```
///
/// # Errors
/// A text that is not a thermal model of the machine, before or after; an axis without a sensor's curve.
pub(super) fn grown(
    text: &str,
    file: &Path,
    machine: &Machine,
    terms: &Terms,
    values: &[f64],
) -> Result<String, FileError> {
    let refused =
        |found: String, needed: String| FileError { file: file.into(), line: None, column: None, found, needed };
    crate::thermal::model(text, file, &machine.settings)?;
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| refused(error.message().into(), "a TOML file".into()))?;
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let of = |wanted: u8| {
            let own =
                |term: &Term| matches!(*term, Term::Curve { axis: of, degree, .. } if of == axis && degree == wanted);
            terms.terms.iter().position(own).and_then(|index| values.get(index)).copied().unwrap_or(0.0)
        };
        let (offset, slope) = (of(0), of(1));
        if offset == 0.0 && slope == 0.0 {
            continue;
        }
        let datum = machine.settings.axis(axis).map_or(0.0, |own| own.thermal.datum);
        let offset = offset + slope * (datum - terms.zero_mm[axis.index() % 3]);
        let letter = axis.letter().to_string();
        let sensors =
            document.get_mut("axis").and_then(|axes| axes.get_mut(&letter)).and_then(|own| own.get_mut("sensor"));
        let names = sensors.and_then(Item::as_table_like_mut);
        let first =
            names.and_then(|table| table.iter_mut().find_map(|(_, item)| item.as_table_like_mut().filter(has_curve)));
        let curve = first.ok_or_else(|| {
            let needed = format!("a curve of a sensor, [axis.{letter}.sensor.NAME] with offset_um or slope_um_per_m");
            refused(format!("no curve of axis {letter} to take the growth"), needed)
        })?;
        let count = ["offset_um", "slope_um_per_m"]
            .iter()
            .find_map(|key| curve.get(key).and_then(Item::as_array).map(Array::len))
            .unwrap_or(0);
        for (key, by, decimals) in [("offset_um", 1e3 * offset, 1e3), ("slope_um_per_m", 1e6 * slope, 1e3)] {
            if by != 0.0 {
                add(curve, key, count, by, decimals);
            }
        }
    }
    let text = document.to_string();
    crate::thermal::model(&text, file, &machine.settings)?;
    Ok(text)
}

fn has_curve(curve: &&mut dyn TableLike) -> bool {
    ["offset_um", "slope_um_per_m"].iter().any(|key| curve.get(key).is_some_and(Item::is_array))
}

/// Adds to all values of a list; creates the list if it is missing.
fn add(curve: &mut dyn TableLike, key: &str, count: usize, by: f64, decimals: f64) {
    let old = curve.get(key).and_then(Item::as_array);
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    let values: Vec<f64> = match old {
        Some(list) => list.iter().map(|value| number(value).unwrap_or(0.0)).collect(),
        None => vec![0.0; count],
    };
    let sum: Array = values.into_iter().map(|value| ((value + by) * decimals).round() / decimals).collect();
    match curve.get_mut(key).and_then(Item::as_value_mut) {
        Some(value) => {
            let decor = value.decor().clone();
            *value = Value::Array(sum);
            *value.decor_mut() = decor;
        }
        None => {
            curve.insert(key, Item::Value(Value::Array(sum)));
        }
    }
}
