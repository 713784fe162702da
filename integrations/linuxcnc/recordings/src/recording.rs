//! Columns that the test driver has recorded, one row a servo cycle.

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use std::path::Path;

/// A recording: rows of doubles, with the HAL pin of every column.
#[derive(Debug)]
pub(crate) struct Recording {
    columns: Vec<String>,
    values: Vec<f64>,
}

#[derive(Deserialize)]
struct Head {
    columns: Vec<String>,
    rows: usize,
}

impl Recording {
    /// Reads PATH.json (names) and PATH.f64 (rows of little-endian doubles).
    pub(crate) fn load(path: &Path) -> Result<Self> {
        let (names, numbers) = (path.with_extension("json"), path.with_extension("f64"));
        let head: Head = serde_json::from_slice(&std::fs::read(&names).with_context(|| names.display().to_string())?)?;
        let bytes = std::fs::read(&numbers).with_context(|| numbers.display().to_string())?;
        let (words, rest) = bytes.as_chunks::<8>();
        let wanted = head.rows * head.columns.len();
        ensure!(
            rest.is_empty() && words.len() == wanted && wanted > 0,
            "{}: found {} bytes, needed {}",
            numbers.display(),
            bytes.len(),
            8 * wanted
        );
        Ok(Recording { columns: head.columns, values: words.iter().map(|word| f64::from_le_bytes(*word)).collect() })
    }

    /// Place of a pin's column.
    pub(crate) fn place(&self, pin: &str) -> Result<usize> {
        self.columns.iter().position(|column| column == pin).with_context(|| format!("{pin} was not recorded"))
    }

    /// The rows, in the order of time.
    pub(crate) fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.len())
    }
}
