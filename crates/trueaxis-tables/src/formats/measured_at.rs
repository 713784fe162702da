//! Converts tables measured away from zero for formats that state no line of measurement.

use crate::Machine;
use glam::DVec3;
use std::borrow::Cow;
use trueaxis::machine::links;
use trueaxis::machine::{Axis, AxisSettings, Twist};

use crate::Table;

/// The table as it would have been measured with the other linear axes at zero: e = e_measured − w × l at every line, both
/// directions, with l from `measured_at_mm`.
///
/// l = Σ m_j n_j over the linear axes j between the moved frame of the axis and the tool; it does not change along the table,
/// so every line is exact (1 ulp), and so are linearly interpolated values between lines. A cubic passes through the same
/// lines with other slopes. For a slide that carries the workpiece, l contains its own position, so the result is exact at the
/// lines only.
pub(super) fn at_zero<'t>(machine: &Machine, settings: &AxisSettings, table: &'t Table) -> Cow<'t, Table> {
    let links = links(&machine.settings.chain).unwrap_or_default();
    let lever: DVec3 = links
        .iter()
        .skip_while(|link| link.axis != settings.axis)
        .skip(1)
        .filter_map(|link| match (link.axis, settings.measured_at_mm) {
            (Axis::X, [x, _, _]) => Some(DVec3::X * x),
            (Axis::Y, [_, y, _]) => Some(DVec3::Y * y),
            (Axis::Z, [_, _, z]) => Some(DVec3::Z * z),
            _ => None,
        })
        .sum();
    let carries_workpiece = links.iter().any(|link| link.axis == settings.axis && link.carries_workpiece);
    let travels = carries_workpiece && !settings.axis.is_rotary() && settings.is_measured_along_a_line();
    let travel = match settings.axis {
        Axis::X if travels => DVec3::X,
        Axis::Y if travels => DVec3::Y,
        Axis::Z if travels => DVec3::Z,
        _ => DVec3::ZERO,
    };
    if lever == DVec3::ZERO && travel == DVec3::ZERO {
        return Cow::Borrowed(table);
    }
    let moved = |q: f64, [ex, ey, ez, ea, eb, ec]: Twist| {
        let [x, y, z] = (DVec3::new(ex, ey, ez) - DVec3::new(ea, eb, ec).cross(lever + travel * q)).to_array();
        [x, y, z, ea, eb, ec]
    };
    let mut table = table.clone();
    for row in &mut table.rows {
        (row.forward, row.reverse) = (moved(row.position, row.forward), moved(row.position, row.reverse));
    }
    for (component, given) in table.given.iter_mut().enumerate() {
        *given |= table
            .rows
            .iter()
            .flat_map(|row| [&row.forward, &row.reverse])
            .any(|twist| twist.get(component).is_some_and(|value| *value != 0.0));
    }
    Cow::Owned(table)
}
