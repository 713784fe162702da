//! Checks that the desk's types of a shown result are those generated from the Rust types.

use std::{env, fs, path::Path};

/// Sources of the serialised types.
const SOURCES: [&str; 2] = ["src/shown/mod.rs", "src/shown/plot.rs"];
const TARGET: &str = "../../desk/src/core/shown-types.ts";
const HEAD: &str = "\
// Generated from crates/trueaxis-evaluation/src/shown:
// TRUEAXIS_WRITE_TYPES=1 cargo test -p trueaxis-evaluation --test evaluation shown_types
";

/// A Rust type in TypeScript; `null` if its numbers may be null.
fn typescript(rust: &str, null: bool) -> String {
    let inside = |open: &str, close: &str| rust.strip_prefix(open)?.strip_suffix(close);
    if let Some(of) = inside("Vec<", ">") {
        let of = typescript(of, null);
        return if of.contains('|') { format!("({of})[]") } else { format!("{of}[]") };
    }
    if let Some(of) = inside("Option<", ">") {
        return format!("{} | null", typescript(of, null));
    }
    if let Some((of, count)) = inside("[", "]").and_then(|of| of.rsplit_once("; ")) {
        return format!("[{}]", vec![typescript(of, null); count.parse().unwrap()].join(", "));
    }
    if let Some(parts) = inside("(", ")") {
        return format!("[{}]", parts.split(", ").map(|of| typescript(of, null)).collect::<Vec<_>>().join(", "));
    }
    match rust {
        "f64" if null => "number | null".into(),
        "f64" | "usize" => "number".into(),
        "bool" => "boolean".into(),
        "String" | "&'static str" => "string".into(),
        name => name.into(),
    }
}

/// A line `name: Type,` as a field.
fn field(line: &str, comment: &str) -> Option<String> {
    let (name, of) = line.strip_prefix("pub ").unwrap_or(line).strip_suffix(',')?.split_once(": ")?;
    Some(format!("{name}: {};", typescript(of, comment.contains("(null)"))))
}

/// The serialised types of a source: structs with named fields, enums of words, untagged enums.
fn types(source: &str) -> String {
    let (mut text, mut comment, mut serialised) = (String::new(), String::new(), false);
    let mut lines = source.lines();
    while let Some(line) = lines.next() {
        if let Some(of) = line.strip_prefix("/// ") {
            comment += if comment.is_empty() { "" } else { " " };
            comment += of;
        } else if line.starts_with("#[derive(") {
            serialised = line.contains("Serialize");
        } else if let Some(declared) = line.strip_prefix("pub ").filter(|_| serialised && line.ends_with('{')) {
            let name = declared.split(' ').nth(1).unwrap();
            let body = lines.by_ref().take_while(|line| *line != "}").collect::<Vec<_>>();
            text += &format!("\n/** {comment} */\n");
            text += &if declared.starts_with("struct") { interface(name, &body) } else { union(name, &body) };
            serialised = false;
        } else if !line.starts_with('#') {
            comment.clear();
        }
    }
    text
}

fn interface(name: &str, body: &[&str]) -> String {
    let mut text = format!("export interface {name} {{\n");
    for line in body.iter().map(|line| line.trim()) {
        match line.strip_prefix("/// ") {
            Some(comment) => text += &format!("  /** {comment} */\n"),
            None => text += &format!("  {}\n", field(line, text.lines().last().unwrap()).unwrap()),
        }
    }
    text + "}\n"
}

fn union(name: &str, body: &[&str]) -> String {
    let mut variants: Vec<String> = Vec::new();
    for line in body.iter().map(|line| line.trim()).filter(|line| !line.starts_with("///") && !line.starts_with('#')) {
        let last = variants.last_mut().filter(|last| last.starts_with('{') && !last.ends_with('}'));
        match (last, line) {
            (Some(last), "},") => *last = format!("{} }}", last.trim_end_matches(';')),
            (Some(last), line) => *last += &format!(" {}", field(line, "").unwrap()),
            (None, line) if line.ends_with('{') => variants.push("{".into()),
            (None, line) => variants.push(match line.trim_end_matches("),").split_once('(') {
                Some((_, of)) => typescript(of, false),
                None => format!("\"{}\"", line.trim_end_matches(',').to_lowercase()),
            }),
        }
    }
    format!("export type {name} = {};\n", variants.join(" | "))
}

#[test]
fn the_desk_has_the_types_of_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sources = SOURCES.map(|source| types(&fs::read_to_string(root.join(source)).unwrap()));
    let needed = format!("{HEAD}{}", sources.concat());
    if env::var_os("TRUEAXIS_WRITE_TYPES").is_some() {
        fs::write(root.join(TARGET), &needed).unwrap();
    }
    let found = fs::read_to_string(root.join(TARGET)).unwrap();
    assert!(found == needed, "desk/src/core/shown-types.ts is not what the source gives: see its head");
}
