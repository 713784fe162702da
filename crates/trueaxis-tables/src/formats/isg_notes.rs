//! Settings with which the other control applies an ISG CSV as this crate applies the tables.

use super::losses;
use trueaxis::machine::{AxisSettings, Interpolation, MachineSettings};

/// Note on the line of measurement.
pub(super) fn measured(settings: &AxisSettings) -> String {
    let cubic = if settings.interpolation == Interpolation::Cubic { "; a cubic differs between the lines" } else { "" };
    format!(
        "measured_at_mm {} of axis {} is applied: the translations written are valid with the other linear axes at 0, exact at every \
         line{cubic}",
        losses::numbers(&settings.measured_at_mm),
        settings.axis.letter()
    )
}

/// Settings that the control needs in addition to the file.
pub(super) fn machine(settings: &MachineSettings, notes: &mut Vec<String>) {
    let links = trueaxis::machine::links(&settings.chain).unwrap_or_default();
    let workpiece: Vec<String> =
        links.iter().filter(|link| link.carries_workpiece).map(|link| link.axis.letter().to_string()).collect();
    let workpiece = if workpiece.is_empty() { String::from("none") } else { workpiece.join(" ") };
    notes.push(format!(
        "the control skips the trueaxis comments; set its kinematics to the chain {}, axes that carry the workpiece: {workpiece}",
        settings.chain
    ));
    notes.push(String::from(
        "translations are valid for a tool of length 0 with the other linear axes and the rotary axes at 0; errors act at the origin \
         of the axis' frame, whose lever to the tool is the control's",
    ));
    if settings.tool_mm != [0.0; 3] {
        notes.push(format!(
            "tool tip {} mm from the last frame: set it on the control",
            losses::numbers(&settings.tool_mm)
        ));
    }
    for axis in &settings.axes {
        let letter = axis.axis.letter();
        if axis.offset_mm != [0.0; 3] {
            let offset = losses::numbers(&axis.offset_mm);
            notes.push(format!("axis {letter} is {offset} mm from its carrier: set it in the control's kinematics"));
        }
        if axis.axis.is_rotary() {
            let sense = axis.direction;
            notes.push(format!("axis {letter} turns its carriage right-handed by {sense} times its position"));
        }
    }
}
