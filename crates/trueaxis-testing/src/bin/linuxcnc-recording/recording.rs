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

    /// Index of a pin's column.
    pub(crate) fn place(&self, pin: &str) -> Result<usize> {
        self.columns.iter().position(|column| column == pin).with_context(|| format!("{pin} was not recorded"))
    }

    /// The rows, in the order of time.
    pub(crate) fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(name: &str, head: &str, numbers: &[f64]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        std::fs::write(path.with_extension("json"), head).unwrap();
        std::fs::write(path.with_extension("f64"), bytes).unwrap();
        (folder, path)
    }

    #[test]
    fn rows_come_back_as_they_were_written() {
        let numbers = [1.0, -0.0, f64::MIN_POSITIVE, 4.0, 5.0, f64::NAN];
        let (_folder, path) = written("run", r#"{"columns": ["a", "b", "c"], "rows": 2}"#, &numbers);
        let recording = Recording::load(&path).unwrap();
        let rows: Vec<Vec<u64>> = recording.rows().map(|row| row.iter().map(|x| x.to_bits()).collect()).collect();
        assert_eq!(rows.concat(), numbers.map(f64::to_bits));
        assert_eq!(recording.place("c").unwrap(), 2);
        assert!(recording.place("d").is_err());
    }

    #[test]
    fn a_recording_that_was_cut_off_is_refused() {
        let (_folder, path) = written("run", r#"{"columns": ["a", "b"], "rows": 2}"#, &[1.0, 2.0, 3.0]);
        assert!(Recording::load(&path).unwrap_err().to_string().contains("found 24 bytes, needed 32"));
    }
}
