//! Makes text safe to print on a terminal.

/// Whether a character affects the text around it: control characters, line and paragraph separators, and direction marks,
/// which can make a name appear different (`gnp.exe` as `exe.png`).
pub fn acts(c: char) -> bool {
    let of_direction =
        matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || of_direction || matches!(c, '\u{2028}' | '\u{2029}')
}

/// Text with the characters that [act](acts) on it, except line feeds, escaped: `\r` would overwrite the line on a terminal.
pub fn printable(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if acts(c) && c != '\n' { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

/// Text on one line, safe for a terminal, of at most `most` characters: for quoting a file in a message, which may have a
/// megabyte without a line feed. A longer text is cut and ends with `…`.
pub fn one_line(text: &str, most: usize) -> String {
    let (mut out, mut length) = (String::new(), 0);
    for c in text.chars() {
        if length >= most {
            out.push('…');
            break;
        }
        if acts(c) {
            let escaped = c.escape_default();
            length += escaped.len();
            out.extend(escaped);
        } else {
            length += 1;
            out.push(c);
        }
    }
    out
}
