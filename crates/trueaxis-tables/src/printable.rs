//! Text as a terminal may show it.

/// Whether a character acts on what stands around it: control characters, separators of lines and paragraphs, and marks of
/// direction, behind which a name reads otherwise than it is (`gnp.exe` for `exe.png`).
pub fn acts(c: char) -> bool {
    let of_direction =
        matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || of_direction || matches!(c, '\u{2028}' | '\u{2029}')
}

/// Text with the characters that [act](acts) on it, line feeds excepted, written out: `\r` would overwrite the line on a
/// terminal.
pub fn printable(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if acts(c) && c != '\n' { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

/// Text on one line, as a terminal may show it, of at most so many characters: what a message repeats of a file, which may
/// have a megabyte without a line feed. Of a longer one the beginning, then `…`.
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
