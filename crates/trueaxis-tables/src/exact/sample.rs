//! Machines for the tests.

use crate::{Machine, Table};
use trueaxis::machine::{Axis, AxisSettings, MachineSettings, Row, Twist};

/// A machine without tables or errors; axes in the order X Y Z A B C.
pub(super) fn machine(chain: &str) -> Machine {
    let mut settings = MachineSettings {
        roundness: None,
        name: "sample".parse().unwrap(),
        chain: chain.parse().unwrap(),
        tool_mm: [0.0; 3],
        reference_temperature_c: 20.0,
        location: Default::default(),
        faults: Default::default(),
        contour: Default::default(),
        compensation: Default::default(),
        kinematics: Default::default(),
        axes: Default::default(),
    };
    // Codes that make no sense are wanted, too.
    for axis in Axis::ALL.into_iter().filter(|axis| chain.contains(axis.letter())) {
        let primed = chain.contains(&format!("{}'", axis.letter()));
        settings.axes.push(AxisSettings::with_defaults(axis, primed)).unwrap();
    }
    let tables = vec![None; settings.axes.len()];
    Machine { settings, tables }
}

/// Place of `axis` among the machine's axes.
pub(super) fn slot(machine: &Machine, axis: Axis) -> usize {
    machine.settings.axes.iter().position(|own| own.axis == axis).unwrap()
}

/// Gives `axis` a table from (position, errors) pairs.
pub(super) fn set_table(machine: &mut Machine, axis: Axis, rows: &[(f64, Twist)]) {
    let slot = slot(machine, axis);
    let rows: Vec<Row> =
        rows.iter().map(|&(position, errors)| Row { position, forward: errors, reverse: errors }).collect();
    machine.tables[slot] = Some(Table { given: [true; 6], bidirectional: false, rows });
}

/// Gives `axis` the same errors everywhere.
pub(super) fn set_constant(machine: &mut Machine, axis: Axis, errors: Twist) {
    set_table(machine, axis, &[(-1000.0, errors), (1000.0, errors)]);
}
