//! Several files in one input: each begins with its name on a separate line, `== machine.toml ==`.

/// Joins these files into an input.
pub fn joined(files: &[(&str, &str)]) -> Vec<u8> {
    files.iter().flat_map(|(name, text)| format!("== {name} ==\n{text}").into_bytes()).collect()
}

/// The files of an input with their names; any text before the first name belongs to `first`.
pub fn split<'i>(input: &'i [u8], first: &'i str) -> Vec<(&'i str, Vec<u8>)> {
    let mut files: Vec<(&str, Vec<u8>)> = Vec::new();
    for line in input.split_inclusive(|byte| *byte == b'\n') {
        let name = line.strip_prefix(b"== ").and_then(|rest| rest.strip_suffix(b" ==\n"));
        match (name.and_then(|name| std::str::from_utf8(name).ok()), files.last_mut()) {
            (Some(name), _) => files.push((name, Vec::new())),
            (None, Some((_, text))) => text.extend_from_slice(line),
            (None, None) => files.push((first, line.to_vec())),
        }
    }
    files
}

#[test]
fn joined_files_are_split() {
    let files = [("a.toml", "x = 1\n"), ("b.csv", "1,2\n==\n")];
    let input = joined(&files);
    let split = split(&input, "first");
    assert_eq!(split, files.map(|(name, text)| (name, text.as_bytes().to_vec())));
    assert_eq!(super::parts::split(b"G0\n", "first"), [("first", b"G0\n".to_vec())]);
}
