//! Prepares a program for LinuxCNC's interpreter.

use super::ProgramError;
use super::error::Refusal;
use super::text;

/// Numbers the lines of a program for [`Canonical`](super::canonical::Canonical); `file` appears in errors only.
///
/// # Errors
/// A comment that is not closed, a byte outside a comment that RS274/NGC does not know, UTF-16.
pub fn numbered(bytes: &[u8], file: &str) -> Result<String, ProgramError> {
    number(bytes).map_err(|refusal| refusal.in_file(file))
}

/// The program with an N word that gives every line its number in the file, so that errors name the right line, and without
/// comments: LinuxCNC's can write files.
fn number(bytes: &[u8]) -> Result<String, Refusal> {
    text::refuse_utf16(bytes)?;
    let mut program = String::new();
    let mut text = String::new();
    let mut ends = false;
    for (line, bytes) in text::lines(bytes) {
        match text::clean(line, bytes, &mut text) {
            Err(refusal) if !ends => return Err(refusal),
            // After the end any text is allowed, also subprograms.
            Err(_) => text.clear(),
            Ok(()) => {}
        }
        let (slash, rest) = match text.strip_prefix('/') {
            Some(rest) => ("/", rest),
            None => ("", text.as_str()),
        };
        let own_number = rest.strip_prefix('N').map(|r| r.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.'));
        let words = own_number.unwrap_or(rest);
        ends |= words.split('M').skip(1).any(|word| {
            let number = word.trim_start_matches('0');
            let digits = number.find(|c: char| !c.is_ascii_digit()).unwrap_or(number.len());
            matches!(number.get(..digits), Some("2" | "30"))
        });
        if words.is_empty() || words.starts_with(['%', 'O']) {
            program += words;
        } else {
            program += &format!("{slash}N{line} {words}");
        }
        program.push('\n');
    }
    // Programs here may end without a word; rs274 requires one.
    if !ends && !program.trim_start().starts_with('%') {
        program += "M2\n";
    }
    Ok(program)
}
