//! Text that comes in and goes out: files, counts, numbers, what was found in a file.

pub use crate::printable::printable;

use crate::error::FileError;
use std::path::Path;

/// Reads a whole file of UTF-8, without a byte order mark.
///
/// # Errors
/// It cannot be read, or has other bytes: with the first line that has one.
pub fn read_text(file: &Path) -> Result<String, FileError> {
    let wrong = |line, found: String, needed: &str| FileError {
        file: file.to_path_buf(),
        line,
        column: None,
        found,
        needed: needed.to_owned(),
    };
    let bytes = std::fs::read(file).map_err(|error| wrong(None, error.to_string(), "a readable file"))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let good = error.as_bytes().get(..error.utf8_error().valid_up_to()).unwrap_or_default();
        let line = 1 + good.iter().filter(|byte| **byte == b'\n').count();
        wrong(u32::try_from(line).ok(), "bytes that are not UTF-8".into(), "text in UTF-8")
    })?;
    // Spreadsheets put a byte order mark in front.
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

/// A count and what is counted: `1 warning`, `2 warnings`.
pub fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// A number with the decimals that it needs, at most six.
pub fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_numbers_read_as_printed() {
        assert_eq!([0, 1, 2].map(|n| counted(n, "row")), ["0 rows", "1 row", "2 rows"]);
        let numbers = [1e3 / 3.0, 0.1 + 0.2, -0.0, 20.0, 1000.0, -1e-9, 2.5];
        assert_eq!(numbers.map(short), ["333.333333", "0.3", "0", "20", "1000", "0", "2.5"]);
        assert_eq!(printable("a\rb\u{1b}[2J\nc µ"), "a\\rb\\u{1b}[2J\nc µ");
    }

    #[test]
    fn bytes_of_another_encoding_are_told_with_their_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("latin.csv");
        std::fs::write(&file, b"a,b\n1,2\n3,\xb5m\n").unwrap();
        let told = read_text(&file).unwrap_err().to_string();
        assert!(told.ends_with("latin.csv:3: found bytes that are not UTF-8, needed text in UTF-8"), "{told}");
        std::fs::write(&file, "\u{feff}µ").unwrap();
        assert_eq!(read_text(&file).unwrap(), "µ");
    }
}
