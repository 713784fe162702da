//! The examples in docs/commands.md match the program's output.

#[path = "../../tests/src/documentation.rs"]
mod shown;

use std::path::Path;

#[test]
fn the_commands_print_what_is_shown() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let program = Path::new(env!("CARGO_BIN_EXE_firmware-sim"));
    shown::check(&root, "docs/commands.md", program, |command| {
        // Needs QEMU and builds the image; covered by its own tests.
        !command.starts_with("firmware-sim compare")
    });
}
