//! Text as a terminal may show it.

/// Text with its control characters, line feeds excepted, written out: `\r` would overwrite the line on a terminal.
pub fn printable(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && c != '\n' { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}
