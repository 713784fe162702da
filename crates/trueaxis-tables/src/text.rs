//! Text input and output: files in UTF-8, counts and numbers in messages.

pub use crate::printable::{acts, one_line, printable};

use crate::error::FileError;
use crate::origin::Origin;
use std::path::Path;
use trueaxis::machine::Axis;

/// Whether a name differs from a known one, of at least four letters, by a typing error or two.
pub(crate) fn near(unknown: &str, known: &str) -> bool {
    known.len() >= 4 && strsim::osa_distance(unknown, known) <= 1 + known.len() / 5
}

/// The known names that an error about an unknown one lists, joined by `separator`, headed by the nearest if it
/// differs by a typing error or two.
pub fn one_of<'n>(unknown: &str, known: impl IntoIterator<Item = &'n str>, separator: &str) -> String {
    let known = Vec::from_iter(known);
    let all = known.join(separator);
    let near = known.iter().filter(|name| near(unknown, name));
    match near.min_by_key(|name| strsim::osa_distance(unknown, name)) {
        Some(nearest) => format!("{nearest}, or another of {all}"),
        None => format!("one of {all}"),
    }
}

/// Reads a file as [`decode`] does.
///
/// # Errors
/// The file cannot be read, or is not UTF-8.
pub fn read_text(file: &Path, comments: &[char]) -> Result<String, FileError> {
    decode(std::fs::read(file).map_err(|error| Origin::new(file).unreadable(&error))?, file, comments)
}

/// Whether the bytes begin with the byte order mark of UTF-16.
pub(crate) fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff])
}

/// Decodes UTF-16 that begins with its byte order mark.
pub(crate) fn from_utf16(bytes: &[u8], origin: &Origin) -> Result<String, FileError> {
    let unit = if bytes.starts_with(&[0xff, 0xfe]) { u16::from_le_bytes } else { u16::from_be_bytes };
    let (pairs, rest) = bytes.as_chunks::<2>();
    let text: Option<String> =
        char::decode_utf16(pairs.iter().skip(1).map(|pair| unit(*pair))).map(Result::ok).collect();
    text.filter(|_| rest.is_empty()).ok_or_else(|| origin.whole("damaged text in UTF-16", "text in UTF-8 or UTF-16"))
}

/// Decodes UTF-8 or, with its byte order mark, UTF-16; removes a byte order mark; `file` is only named in errors.
///
/// Lines that begin with one of `comments` may be in any encoding, as instruments write them.
///
/// # Errors
/// Other bytes, with the first line that has any.
pub fn decode(bytes: Vec<u8>, file: &Path, comments: &[char]) -> Result<String, FileError> {
    if is_utf16(&bytes) {
        return from_utf16(&bytes, &Origin::new(file));
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let is_comment = |line: &[u8]| {
                line.trim_ascii_start().first().is_some_and(|first| comments.contains(&char::from(*first)))
            };
            let mut lines = (1..).zip(error.as_bytes().split(|byte| *byte == b'\n'));
            if let Some((line, _)) = lines.find(|(_, line)| std::str::from_utf8(line).is_err() && !is_comment(line)) {
                return Err(Origin::new(file).at(line, "", "bytes that are not UTF-8", "text in UTF-8"));
            }
            String::from_utf8_lossy(error.as_bytes()).into_owned()
        }
    };
    // Spreadsheets put a byte order mark in front.
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

/// The line, from 1, of a byte offset in a text; 1 beyond its end.
pub fn line_at(text: &str, offset: usize) -> u32 {
    let before = text.as_bytes().get(..offset).unwrap_or_default();
    u32::try_from(1 + before.iter().filter(|byte| **byte == b'\n').count()).unwrap_or(0)
}

/// A count with its noun: `1 warning`, `2 warnings`.
pub fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// `1 degree of freedom`, `8 degrees of freedom`.
pub fn degrees_of_freedom(count: usize) -> String {
    format!("{} of freedom", counted(count, "degree"))
}

/// `1 axis`, `3 axes`.
pub fn axes(count: usize) -> String {
    if count == 1 { "1 axis".to_owned() } else { format!("{count} axes") }
}

/// Lines of cells with their columns aligned, two spaces apart, a line each; a column of words to the left, one of numbers to the
/// right.
pub fn aligned(lines: &[Vec<&str>], is_words: impl Fn(usize) -> bool) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or_default();
    let width = |column: usize| {
        lines.iter().filter_map(|line| Some(line.get(column)?.chars().count())).max().unwrap_or_default()
    };
    let columns: Vec<(usize, bool)> = (0..columns).map(|column| (width(column), is_words(column))).collect();
    let line = |line: &Vec<&str>| {
        let cells = line.iter().zip(&columns).map(|(cell, (width, is_words))| match is_words {
            true => format!("{cell:<width$}"),
            false => format!("{cell:>width$}"),
        });
        format!("{}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    lines.iter().map(line).collect()
}

/// A length of an axis in µm, or an angle in µrad, from mm or degrees.
pub(crate) fn micro(axis: Axis, value: f64) -> f64 {
    if axis.is_rotary() { value.to_radians() * 1e6 } else { value * 1e3 }
}

/// A number with as many decimals as it needs, at most six.
pub fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// A number with fixed decimals and without a sign if it rounds to zero.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|digit| matches!(digit, '0' | '.')) => digits.to_owned(),
        _ => text,
    }
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
        assert_eq!(
            printable("a\u{202e}b\u{2066}\u{61c} \u{200d}\u{2028}ש"),
            "a\\u{202e}b\\u{2066}\\u{61c} \u{200d}\\u{2028}ש"
        );
        assert_eq!(one_line("a\u{202e}b", 20), "a\\u{202e}b");
        assert_eq!([one_line("a\nb µ", 6), one_line("a\nb µm", 6)], ["a\\nb µ", "a\\nb µ…"]);
    }

    #[test]
    fn bytes_of_another_encoding_are_refused_with_their_line() {
        let read = |bytes: &[u8]| decode(bytes.to_vec(), Path::new("latin.csv"), &['#']);
        let refused = read(b"# \xb5m\n1,2\n3,\xb5m\n").unwrap_err().to_string();
        assert_eq!(refused, "latin.csv:3: found bytes that are not UTF-8, needed text in UTF-8");
        assert_eq!(read("\u{feff}µ".as_bytes()).unwrap(), "µ");
        assert_eq!(read(b" # \xb5m\n1").unwrap(), " # \u{fffd}m\n1");
    }
}
