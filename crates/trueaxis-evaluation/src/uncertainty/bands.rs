//! Expanded uncertainties beside standard errors.

use serde_json::{Map, Value};
use trueaxis_metrology::uncertainty::student_factor;

/// Coverage of the bands.
const COVERAGE: f64 = 0.95;

/// Student's factor for a coverage of 95 %.
pub fn band_factor(degrees_of_freedom: f64) -> f64 {
    student_factor(COVERAGE, degrees_of_freedom)
}

/// Standard errors times Student's factor for a coverage of 95 %, under the same names; null remains null.
///
/// With ν degrees of freedom of the scatter the factor is t_ν, not 2 (JCGM 100:2008, G.3): with ν = 4 a band of ± 2 s covers
/// 88 %, not 95.
pub fn expanded(standard_errors: &Map<String, Value>, degrees_of_freedom: f64) -> Map<String, Value> {
    let factor = band_factor(degrees_of_freedom);
    standard_errors.iter().map(|(name, value)| (name.clone(), times(value, factor))).collect()
}

fn times(value: &Value, factor: f64) -> Value {
    match value {
        Value::Number(number) => Value::from(number.as_f64().map(|number| number * factor)),
        Value::Array(list) => list.iter().map(|value| times(value, factor)).collect(),
        Value::Object(fields) => {
            Value::Object(fields.iter().map(|(name, value)| (name.clone(), times(value, factor))).collect())
        }
        other => other.clone(),
    }
}
