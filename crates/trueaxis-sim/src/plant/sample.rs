//! Machines for the tests of the plant.

use trueaxis::machine::{Axis, AxisSettings, MachineSettings, Row, Twist};
use trueaxis_tables::{Machine, Table};

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
    let mut links = trueaxis::machine::links(chain).unwrap();
    links.sort_unstable_by_key(|link| link.axis);
    for link in links {
        settings.axes.push(AxisSettings::with_defaults(link.axis, link.carries_workpiece)).unwrap();
    }
    let tables = vec![None; settings.axes.len()];
    Machine { settings, tables }
}

/// Gives `axis` a table from (position, errors) pairs.
pub(super) fn set_table(machine: &mut Machine, axis: Axis, rows: &[(f64, Twist)]) {
    let slot = machine.settings.axes.iter().position(|own| own.axis == axis).unwrap();
    let rows: Vec<Row> =
        rows.iter().map(|&(position, errors)| Row { position, forward: errors, reverse: errors }).collect();
    machine.tables[slot] = Some(Table { given: [true; 6], bidirectional: false, rows });
}
