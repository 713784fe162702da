//! Keys and sections of a TOML file, written.

use super::decimal::shortest;
use std::fmt::Write;

/// Keys and values, one a line.
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

    /// A number that is written in 1/`scale` of its unit and divided by it when it is read.
    pub(super) fn scaled(&mut self, key: &str, value: f64, default: f64, scale: f64) {
        if value != default {
            let _ = writeln!(self.0, "{key} = {:?}", shortest(value, scale));
        }
    }
}

/// A section, where there is something in it.
pub(super) fn section(text: &mut String, name: &str, lines: &str) {
    if !lines.is_empty() {
        let _ = write!(text, "\n[{name}]\n{lines}");
    }
}
