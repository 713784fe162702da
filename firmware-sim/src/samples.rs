//! Sample machines.

use std::path::PathBuf;

/// Folder of a sample machine: below the working directory if it exists there, else in the source tree.
pub fn sample_machine(name: &str) -> PathBuf {
    let local = PathBuf::from("compensation-tables").join(name);
    if local.is_dir() {
        return local;
    }
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../compensation-tables")).join(name)
}
