//! Validation shared by the options of several commands.

use anyhow::{Result, bail};
use std::path::Path;
use trueaxis_tables::text::read_text;

/// Refuses an option's value that is negative, above `most`, or NaN.
pub(crate) fn up_to(most: f64, option: &str, value: f64) -> Result<()> {
    if !(0.0..=most).contains(&value) {
        bail!("{option}: found {value}, needed 0 to {most}");
    }
    Ok(())
}

/// Refuses an odd value of an option.
pub(crate) fn even(option: &str, value: u32) -> Result<()> {
    if !value.is_multiple_of(2) {
        bail!("{option}: found {value}, needed an even number");
    }
    Ok(())
}

/// The text of a file or, without a file, the built-in text.
pub(crate) fn text_or(given: Option<&Path>, own: &str) -> Result<String> {
    match given {
        Some(file) => Ok(read_text(file, &[])?),
        None => Ok(own.to_owned()),
    }
}
