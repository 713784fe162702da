//! Machines for the tests of the plant.

use trueaxis::machine::{Axis, Row, Twist};
use trueaxis_tables::{Machine, Table};

/// A machine without tables or errors; axes in the order X Y Z A B C.
pub(super) fn machine(chain: &str) -> Machine {
    let settings = trueaxis_testing::machine::Machine::new(chain).settings();
    let tables = vec![None; settings.axes.len()];
    Machine { settings, tables, grids: Vec::new() }
}

/// Gives `axis` a table from (position, errors) pairs.
pub(super) fn set_table(machine: &mut Machine, axis: Axis, rows: &[(f64, Twist)]) {
    let slot = machine.settings.axes.iter().position(|own| own.axis == axis).unwrap();
    let rows = rows.iter().map(|&(position, errors)| Row { position, forward: errors, reverse: errors }).collect();
    machine.tables[slot] = Some(Table { given: [true; 6], bidirectional: false, rows });
}
