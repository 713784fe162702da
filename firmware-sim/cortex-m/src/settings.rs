//! Settings of a machine for counts and proofs.

use trueaxis::machine::{AxisSettings, ErrorModel, MachineSettings};

/// The stated defaults with these axes: X, Y and Z carry the tool; with more, C on a trunnion A carries the workpiece.
///
/// # Panics
/// There are more axes than a machine has.
pub fn machine(tool_mm: [f64; 3], model: ErrorModel, axes: impl IntoIterator<Item = AxisSettings>) -> MachineSettings {
    let axes: heapless::Vec<_, _> = axes.into_iter().collect();
    let chain = if axes.len() > 3 { "w C' A' b X Y Z t" } else { "w b X Y Z t" };
    let mut machine = MachineSettings {
        roundness: None,
        crosstalk: Default::default(),
        periodic: Default::default(),
        name: "counted".try_into().unwrap_or_default(),
        chain: chain.try_into().unwrap_or_default(),
        tool_mm,
        reference_temperature_c: 20.0,
        location: Default::default(),
        faults: Default::default(),
        contour: Default::default(),
        compensation: Default::default(),
        kinematics: Default::default(),
        axes,
    };
    machine.compensation.model = model;
    machine
}
