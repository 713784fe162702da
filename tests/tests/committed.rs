//! Files in the tree that are made from other files in the tree.

use std::path::Path;
use trueaxis_tables::{Machine, compile};

/// The embedding example's tables are the sample mill, compiled. `TRUEAXIS_BLESS=1` writes them anew.
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
