//! Writes keys and sections of a TOML file.

use super::decimal::shortest;
use std::fmt::Write;

/// Keys and values, one per line.
#[derive(Default)]
pub(super) struct Lines(pub(super) String);

impl Lines {
    pub(super) fn put(&mut self, key: &str, value: impl std::fmt::Display) {
        let _ = writeln!(self.0, "{key} = {value}");
    }

    pub(super) fn number(&mut self, key: &str, value: f64, default: f64) {
        if value != default {
            let _ = writeln!(self.0, "{key} = {value:?}");
        }
    }

    pub(super) fn numbers(&mut self, key: &str, value: &[f64], default: &[f64]) {
        if value != default {
            let _ = writeln!(self.0, "{key} = {value:?}");
        }
    }

    /// Writes a number in 1/`scale` of its unit, which the reader divides by `scale`.
    pub(super) fn scaled(&mut self, key: &str, value: f64, default: f64, scale: f64) {
        if value != default {
            let _ = writeln!(self.0, "{key} = {:?}", shortest(value, scale));
        }
    }
}

/// Writes a section if it is not empty.
pub(super) fn section(text: &mut String, name: &str, lines: &str) {
    if !lines.is_empty() {
        let _ = write!(text, "\n[{name}]\n{lines}");
    }
}
