//! Numbers on the command line; clap names the option in errors.

use trueaxis_tables::text::counted;

/// A finite number.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("found {text:?}, needed a finite number")),
    }
}

/// A list of numbers; an alias, because clap reads a plain `Vec` as an option that may be repeated.
pub(crate) type Numbers = Vec<f64>;

/// Parses finite numbers separated by commas.
pub(crate) fn numbers(text: &str) -> Result<Numbers, String> {
    text.split(',').map(number).collect()
}

/// Three finite numbers: X,Y,Z.
pub(crate) fn triple(text: &str) -> Result<[f64; 3], String> {
    let values = numbers(text)?;
    let count = counted(values.len(), "number");
    values.try_into().map_err(|_| format!("found {count}, needed three: X,Y,Z"))
}

/// One finite number, or three: X,Y,Z.
pub(crate) fn one_or_triple(text: &str) -> Result<Numbers, String> {
    let values = numbers(text)?;
    match values.len() {
        1 | 3 => Ok(values),
        count => Err(format!("found {}, needed one or three: X,Y,Z", counted(count, "number"))),
    }
}

/// Parses the sense of an axis.
pub(crate) fn sense(text: &str) -> Result<i8, String> {
    match text.trim() {
        "1" | "+1" => Ok(1),
        "-1" => Ok(-1),
        _ => Err(format!("found {text:?}, needed 1 or -1")),
    }
}
