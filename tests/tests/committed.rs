//! Committed files that are generated from other committed files.

use std::path::Path;
use trueaxis_tables::{Machine, compile};

/// The embedding example's tables are the compiled sample mill. `TRUEAXIS_BLESS=1` rewrites them.
#[test]
fn the_examples_tables_are_the_sample_machine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let machine = Machine::read(&root.join("compensation-tables/mill-3axis")).unwrap();
    let bytes = compile(&machine).unwrap();
    let file = root.join("crates/trueaxis/mill-3axis.tcomp");
    if std::env::var_os("TRUEAXIS_BLESS").is_some() {
        std::fs::write(&file, &bytes).unwrap();
    }
    assert_eq!(std::fs::read(file).unwrap(), bytes);
}
