//! Machines for the tests.

use crate::{Machine, Table};
use trueaxis::machine::{Axis, AxisSettings, Row, Twist};

/// A machine without tables or errors; axes in the order X Y Z A B C.
pub(super) fn machine(chain: &str) -> Machine {
    // Invalid codes are needed, too.
    let carries = |axis: Axis| chain.contains(&format!("{}'", axis.letter()));
    let named = Axis::ALL.into_iter().filter(|axis| chain.contains(axis.letter()));
    let axes: Vec<_> = named.map(|axis| AxisSettings::with_defaults(axis, carries(axis))).collect();
    let settings = trueaxis_testing::machine::Machine::three_axis().axes(&axes);
    let settings = settings.with(|machine| machine.chain = chain.parse().unwrap()).settings();
    let tables = vec![None; settings.axes.len()];
    Machine { settings, tables, grids: Vec::new() }
}

/// Index of `axis` among the machine's axes.
pub(super) fn slot(machine: &Machine, axis: Axis) -> usize {
    machine.settings.axes.iter().position(|own| own.axis == axis).unwrap()
}

/// Gives `axis` a table from (position, errors) pairs.
pub(super) fn set_table(machine: &mut Machine, axis: Axis, rows: &[(f64, Twist)]) {
    let slot = slot(machine, axis);
    let rows = rows.iter().map(|&(position, errors)| Row { position, forward: errors, reverse: errors }).collect();
    machine.tables[slot] = Some(Table { given: [true; 6], bidirectional: false, rows });
}

/// Gives `axis` the same errors everywhere.
pub(super) fn set_constant(machine: &mut Machine, axis: Axis, errors: Twist) {
    set_table(machine, axis, &[(-1000.0, errors), (1000.0, errors)]);
}
