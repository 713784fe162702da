//! Key of a machine's volumetric model.

use crate::compensation::key::Key;
use crate::machine::{Axis, AxisOrder, Interpolation, Lines, Lookup, MachineSettings, Rows};

/// Key of everything that the volumetric model is built from; never 0.
pub(super) fn of<'r, T: Rows + ?Sized + 'r, const N: usize>(
    order: &AxisOrder<N>,
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
) -> u64 {
    let mut key = Key(0);
    machine.chain.bytes().for_each(|byte| key.add(byte.into()));
    let location = &machine.location;
    key.add_all(&machine.tool_mm);
    key.add_all(&[location.a0z, location.b0z, location.c0y]);
    key.add_all(location.rotary.iter().flatten());
    key.add_all(&machine.kinematics.tool_axis);
    for (axis, settings) in order.axes().into_iter().zip(order.settings(machine)) {
        key.add(axis.index() as u64);
        let Some(settings) = settings else { continue };
        key.add(
            u64::from(settings.lookup == Lookup::Feedback) + 2 * u64::from(settings.cross_lookup == Lookup::Feedback),
        );
        key.add_all(&[f64::from(settings.direction), settings.backlash, settings.thermal.datum]);
        key.add_all(&settings.offset_mm);
        key.add_all(&settings.measured_at_mm);
        let Some((lines, settings)) = Lines::of(machine, &rows, settings) else { continue };
        key.add(u64::from(settings.interpolation == Interpolation::Cubic));
        for row in (0..lines.len()).filter_map(|index| lines.row(index)) {
            key.add_all(&[row.position]);
            key.add_all(row.forward.iter().chain(&row.reverse));
        }
    }
    key.0 | 1
}
