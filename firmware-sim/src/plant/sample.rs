//! Machines for the tests of the plant.

use trueaxis::machine::{
    Axis, AxisSettings, ContourSettings, FaultSettings, Interpolation, Limits, LocationErrors, Lookup, MachineSettings,
    Row, ThermalGrowth, Twist,
};
use trueaxis_tables::{Machine, Table};

/// A machine without tables or errors; axes in the order X Y Z A B C.
pub(super) fn machine(chain: &str) -> Machine {
    let mut settings = MachineSettings {
        roundness: None,
        name: "sample".parse().unwrap(),
        chain: chain.parse().unwrap(),
        tool_mm: [0.0; 3],
        reference_temperature_c: 20.0,
        location: LocationErrors::default(),
        faults: FaultSettings {
            resume: [0.05; 2],
            command_jump_factor: 2.0,
            feedback_jump: [0.02; 2],
            stuck: [0.2; 2],
        },
        contour: ContourSettings { max_lag_mm: 1.0 },
        compensation: Default::default(),
        kinematics: Default::default(),
        axes: Default::default(),
    };
    for axis in Axis::ALL.into_iter().filter(|axis| chain.contains(axis.letter())) {
        let primed = chain.contains(&format!("{}'", axis.letter()));
        let settings_of_axis = AxisSettings {
            axis,
            interpolation: Interpolation::Linear,
            lookup: Lookup::Command,
            cross_lookup: Lookup::Command,
            direction: if primed && axis.is_rotary() { -1 } else { 1 },
            travel: [-1e6, 1e6],
            joint: [-1e6, 1e6],
            measured_at_mm: [0.0; 3],
            max_feed_per_s: 500.0,
            backlash: 0.0,
            hysteresis: 1e-3,
            limits: Limits { magnitude: 0.1, slope_per_s: 1.0, acceleration_per_s2: 200.0 },
            thermal: ThermalGrowth::default(),
        };
        settings.axes.push(settings_of_axis).unwrap();
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
