//! Converts the bytes of a file to lines without comments and blanks.

use std::borrow::Cow;

use super::error::Refusal;

/// Where the text of a file begins: after a byte order mark.
pub(super) fn beginning(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }
}

/// The lines of a file with their numbers, from 1, without a byte order mark.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (u32, &[u8])> {
    let bytes = bytes.get(beginning(bytes)..).unwrap_or_default();
    (1_u32..).zip(bytes.split(|byte| *byte == b'\n'))
}

/// Refuses text that begins with the byte order mark of UTF-16.
pub(super) fn refuse_utf16(bytes: &[u8]) -> Result<(), Refusal> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(Refusal::new(1, "UTF-16", "UTF-8 or Latin-1"));
    }
    Ok(())
}

/// A line as RS274/NGC reads it: in upper case, without comments, blanks, tabs and carriage returns.
///
/// Comments may contain any bytes (Latin-1 as well as UTF-8); nothing else may.
pub(super) fn clean(line: u32, bytes: &[u8], text: &mut String) -> Result<(), Refusal> {
    text.clear();
    let mut rest = bytes.iter().copied();
    while let Some(byte) = rest.next() {
        match byte {
            b' ' | b'\t' | b'\r' => {}
            b';' => break,
            b'(' => skip_comment(line, &mut rest)?,
            0x21..=0x7e => text.push(char::from(byte).to_ascii_uppercase()),
            _ => {
                let found = format!("the byte 0x{byte:02x} outside a comment");
                return Err(Refusal::new(line, found, "letters, digits, signs and comments in ( ) or after ;"));
            }
        }
    }
    Ok(())
}

fn skip_comment(line: u32, rest: &mut impl Iterator<Item = u8>) -> Result<(), Refusal> {
    let mut seen = Vec::new();
    for byte in rest {
        match byte {
            b')' => return Ok(()),
            b'(' => break,
            _ => seen.push(byte),
        }
    }
    let seen: Cow<'_, str> = String::from_utf8_lossy(&seen);
    let found = format!("`({}`", seen.trim_end().escape_debug());
    Err(Refusal::new(line, found, "a comment closed on its line, without ( inside"))
}
