//! Checks of refusals that may repeat any part of a text without quotes, as a terminal shows them.

use crate::outcome;
use trueaxis_tables::text::printable;

/// Checks a message: one line that begins with the file's name, states the value found and the one needed, and names
/// only lines that exist in the file.
///
/// # Panics
/// If the message does not meet this.
pub fn of_file(message: &str, file: &str, text: &[u8]) {
    let message = &printable(message);
    assert!(!message.contains('\n'), "a refusal of more than a line: {message:?}");
    let rest = message.strip_prefix(file).and_then(|rest| rest.strip_prefix(':'));
    let Some(rest) = rest else { panic!("a refusal that does not name {file}: {message}") };
    let said = message.contains("found ").then(|| message.rsplit_once("needed ")).flatten();
    let Some((_, needed)) = said else { panic!("found what, needed what? {message}") };
    let line = rest.split_once(':').and_then(|(number, _)| number.parse::<usize>().ok());
    let lines = 1 + text.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count();
    assert!(line.is_none_or(|line| (1..=lines).contains(&line)), "of {lines} lines: {message}");
    outcome::saw((line.is_some(), words(needed)));
}

/// Checks a refusal without a file: words on one line.
///
/// # Panics
/// If the message does not meet this.
pub fn in_words(message: &str) {
    let message = &printable(message);
    assert!(!message.trim().is_empty() && !message.contains('\n'), "a refusal of more than a line: {message:?}");
    let said = message.rsplit_once("needed ").map_or(message.as_str(), |(_, needed)| needed);
    outcome::saw(words(said));
}

/// The words without figures and quotations.
fn words(text: &str) -> String {
    let plain = text.split(['"', '`']).step_by(2).flat_map(str::chars);
    plain.filter(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-' | '+' | 'e')).take(60).collect()
}
