//! Tables measured away from zero, moved to where a format without a place of measurement has them.

use crate::Machine;
use glam::DVec3;
use std::borrow::Cow;
use trueaxis::check::links;
use trueaxis::machine::{Axis, AxisSettings, Twist};

use crate::Table;

/// The table as it would have been measured with the other linear axes at zero: e = e_measured − w × l at every line, both
/// directions, and l from `measured_at_mm`.
///
/// l = Σ m_j n_j over the linear axes j between the moved frame of the axis and the tool; it does not change along the table, so
/// every line is exact (1 ulp), and between lines what is interpolated linearly. A cubic goes through the same lines, with other
/// slopes. The own position of an axis that carries the workpiece enters its lever at zero as well and stays as it is.
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
    if lever == DVec3::ZERO {
        return Cow::Borrowed(table);
    }
    let moved = |[ex, ey, ez, ea, eb, ec]: Twist| {
        let [x, y, z] = (DVec3::new(ex, ey, ez) - DVec3::new(ea, eb, ec).cross(lever)).to_array();
        [x, y, z, ea, eb, ec]
    };
    let mut table = table.clone();
    for row in &mut table.rows {
        (row.forward, row.reverse) = (moved(row.forward), moved(row.reverse));
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
