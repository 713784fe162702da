//! The machine and the program used by these tests.

use std::path::Path;
use trueaxis_tables::Machine;

/// Lines, an arc and a rapid.
pub(crate) const PROGRAM: &str = "G21 G90 F1500\nG1 X10\nG2 X10 Y-20 J-10\nG1 X0 Y0\nG0 Z5\n";

/// A sample machine with friction, dynamic correction and contour feedback.
pub(crate) fn machine() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
    Machine::read(&folder).unwrap()
}
