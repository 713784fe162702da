//! Text as a terminal may show it.

/// Text with its control characters, line feeds excepted, written out: `\r` would overwrite the line on a terminal.
pub fn printable(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && c != '\n' { out.extend(c.escape_default()) } else { out.push(c) }
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
        if c.is_control() {
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
