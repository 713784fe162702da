//! Committed files that are generated from other committed files.

use std::path::Path;
use trueaxis_tables::{Machine, compile};

/// The embedding example's tables are the compiled sample mill. `TRUEAXIS_BLESS=1` rewrites them.
#[test]
fn the_examples_tables_are_the_sample_machine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let machine = Machine::read(&root.join("compensation-tables/mill-3axis")).unwrap();
    let bytes = compile(&machine).unwrap();
    let file = root.join("crates/trueaxis/tests/data/mill-3axis.tcomp");
    if std::env::var_os("TRUEAXIS_BLESS").is_some() {
        std::fs::write(&file, &bytes).unwrap();
    }
    assert_eq!(std::fs::read(file).unwrap(), bytes);
}

/// The embedding example in the README equals the one that is compiled and run as a documentation test.
#[test]
fn the_readme_shows_the_embedding_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = |name: &str| std::fs::read_to_string(root.join(name)).unwrap();
    let example = text("crates/trueaxis/examples/embed.rs");
    let code: String =
        example.lines().filter(|line| !line.starts_with("//!")).map(|line| format!("{line}\n")).collect();
    assert!(code.lines().count() > 15, "the example is read");
    assert!(text("README.md").contains(&format!("```rust\n{code}```\n")), "README.md differs from examples/embed.rs");
}
