//! libFuzzer's dictionaries: one word per line, in quotes, with or without a name; `\\`, `\"` and `\xAB` inside.

/// The words of a dictionary.
///
/// # Panics
/// An invalid line: dictionaries are part of the program.
pub fn dictionary(text: &str) -> Vec<Vec<u8>> {
    let lines = text.lines().map(str::trim).enumerate();
    let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    lines.map(|(number, line)| word(line).unwrap_or_else(|| panic!("line {}: {line}", number + 1))).collect()
}

fn word(line: &str) -> Option<Vec<u8>> {
    let (_, quoted) = line.split_once('"')?;
    let mut rest = quoted.strip_suffix('"')?.bytes();
    let mut word = Vec::new();
    while let Some(byte) = rest.next() {
        word.push(match byte {
            b'\\' => match rest.next()? {
                b'x' => {
                    let digits = [rest.next()?, rest.next()?];
                    u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?
                }
                byte @ (b'\\' | b'"') => byte,
                _ => return None,
            },
            b'"' => return None,
            byte => byte,
        });
    }
    if word.is_empty() { None } else { Some(word) }
}

#[test]
fn a_dictionary_has_names_escapes_and_comments() {
    let words = dictionary("# words\nkw=\"G0\"\n\n\"\\x0a\\\\\\\"\"\n");
    assert_eq!(words, [b"G0".to_vec(), b"\n\\\"".to_vec()]);
    for wrong in ["G0", "\"G0", "\"\"", "\"\\n\"", "\"\\x0\""] {
        assert!(word(wrong).is_none(), "{wrong}");
    }
}
