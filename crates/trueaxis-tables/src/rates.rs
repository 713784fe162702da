//! Rates and accelerations of the corrections at a feed, and their limits.

use crate::{Machine, Table};
use trueaxis::check;
use trueaxis::machine::{Axis, AxisSettings, Curve, ErrorModel};

/// Upper bounds of the change of a drive's correction with every axis at a feed, at its worst position.
///
/// For a rotary axis, read every mm as degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DriveRate {
    /// The drive.
    pub axis: Axis,
    /// Largest rate of the wanted correction, mm/s.
    pub rate: f64,
    /// Slope limit, mm/s.
    pub limit: f64,
    /// Moving axis with the largest share.
    pub moving: Axis,
    /// That share, mm/s.
    pub part: f64,
    /// Largest acceleration at a steady feed, mm/s², from the errors of the tables without their levers; `None` if one of the
    /// tables is linear or a grid moves the drive, since both step the velocity.
    pub acceleration: Option<f64>,
    /// Acceleration limit, mm/s².
    pub acceleration_limit: f64,
}

/// The drives whose corrections change while every axis moves at `feed_per_s` mm/s, or at its top feed if that is lower or
/// `feed_per_s` is `None`.
///
/// The rates include grids. `rate = Σ max |dE/dq| · v`, `acceleration = Σ max |d²E/dq²| · v²` over the moving axes.
pub fn rates(machine: &Machine, feed_per_s: Option<f64>) -> Vec<DriveRate> {
    let mut machine = machine.clone();
    for axis in &mut machine.settings.axes {
        axis.max_feed_per_s = feed_per_s.map_or(axis.max_feed_per_s, |feed| feed.min(axis.max_feed_per_s));
    }
    machine.settings.axes.iter().filter_map(|drive| drive_rate(&machine, drive)).collect()
}

/// A drive's correction with all axes at top feed.
pub(crate) fn drive_rate(machine: &Machine, drive: &AxisSettings) -> Option<DriveRate> {
    let links = trueaxis::machine::links(&machine.settings.chain).ok()?;
    let component = drive.axis.index();
    let volumetric = machine.settings.compensation.model == ErrorModel::Volumetric;
    if volumetric && drive.axis.is_rotary() {
        return None;
    }
    let grids = check::GridBounds::of(&machine.grids());
    let (mut rate, mut most, mut acceleration) = (0.0, None::<(Axis, f64)>, Some(0.0));
    for (moving, table) in machine.axes() {
        // A rotary axis may turn the errors into any direction.
        let turned = trueaxis::machine::is_turned(&links, moving.axis) && !drive.axis.is_rotary();
        if drive.axis.is_rotary() && moving.axis != drive.axis {
            continue;
        }
        let slope = if volumetric {
            check::tip_rate(&machine.settings, |axis| machine.rows(axis), &grids, moving)
        } else {
            let slopes = table.map_or([0.0; 6], |table| check::slopes(moving, table.rows.as_slice()));
            if drive.axis.is_rotary() {
                slopes[component].to_degrees()
            } else if turned {
                let anywhere = slopes[..3].iter().map(|slope| slope * slope).sum::<f64>().sqrt();
                anywhere + grids.slope(moving.axis, component)
            } else {
                let tilt = check::tilt(&machine.settings, moving.axis, component).abs();
                slopes[component] + tilt + grids.slope(moving.axis, component)
            }
        };
        let own = moving.axis == drive.axis;
        let repeats = |order| if own { machine.settings.repeats(drive.axis, order) } else { 0.0 };
        let part = (slope + repeats(1)) * moving.max_feed_per_s;
        rate += part;
        if most.is_none_or(|(_, largest)| part > largest) {
            most = Some((moving.axis, part));
        }
        let bent = table.map_or(Some(0.0), |table| bent(moving, table, component, turned));
        // The slope of a grid steps at its nodes.
        let bent = bent.filter(|_| drive.axis.is_rotary() || grids.slope(moving.axis, component) == 0.0);
        let own = bent.map(|bent| (bent + repeats(2)) * moving.max_feed_per_s * moving.max_feed_per_s);
        acceleration = acceleration.zip(own).map(|(sum, own)| sum + own);
    }
    let (moving, part) = most?;
    let (axis, limits) = (drive.axis, &drive.limits);
    let acceleration_limit = limits.acceleration_per_s2;
    Some(DriveRate { axis, rate, limit: limits.slope_per_s, moving, part, acceleration, acceleration_limit })
}

/// Largest second derivative of the errors of a table that move a drive; `None` for a linear table.
fn bent(moving: &AxisSettings, table: &Table, component: usize, turned: bool) -> Option<f64> {
    let column = |component: usize| {
        let [forward, reverse] = [false, true].map(|back| Curve::new(moving, table.rows.as_slice(), component, back));
        Some(forward.most_bent()?.max(reverse.most_bent()?))
    };
    if turned {
        let [x, y, z] = [column(0)?, column(1)?, column(2)?];
        return Some((x * x + y * y + z * z).sqrt());
    }
    let bent = column(component)?;
    Some(if component < 3 { bent } else { bent.to_degrees() })
}
