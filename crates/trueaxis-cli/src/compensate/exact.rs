//! Exact transforms.

use super::{Arguments, Evaluated, Written};
use crate::csv_in::Rows;
use crate::model::rise;
use anyhow::{Result, anyhow};
use trueaxis::compensation::Direction;
use trueaxis::machine::AXES;
use trueaxis_evaluation::positions::{COLUMNS, Travel, next};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::{CorrectionSettings, Geometry};

pub(super) fn evaluate(
    arguments: &Arguments,
    machine: &Machine,
    positions: &mut Rows<6>,
    result: &mut Written<'_>,
) -> Result<()> {
    let axes = &machine.settings.axes;
    let geometry = Geometry::new(machine, rise(arguments.temperature_c, machine)?)
        .map_err(|error| anyhow!("{}: {error}", arguments.machine.display()))?;
    let compensation = &machine.settings.compensation;
    let settings = CorrectionSettings {
        passes: arguments.inverse_passes,
        fade_deg: compensation.orientation.then_some(compensation.fade_deg),
    };
    let mut reverse = [if arguments.reverse { 1.0 } else { 0.0 }; AXES];
    let mut travel = arguments.in_order.then(|| Travel::new(machine, axes.iter().map(|own| own.axis)));
    // Ends of the tables that do not wrap.
    let ends: Vec<Option<[f64; 2]>> = machine
        .axes()
        .map(|(own, table)| {
            let rows =
                table.map(|table| table.rows.as_slice()).filter(|rows| !trueaxis::machine::wraps(own.axis, *rows))?;
            Some([rows.first()?.position, rows.last()?.position])
        })
        .collect();
    result.header(arguments, machine, positions)?;
    while let Some(row) = next(machine, positions)? {
        let values = row.values;
        let mut at = [0.0; AXES];
        for (q, own) in at.iter_mut().zip(axes) {
            *q = values[own.axis.index()];
        }
        let sent = |reverse: &[f64; AXES]| {
            let found = "a pose in which the linear axes cannot take the error away";
            let error = || positions.error(row.line, COLUMNS[0].name, found, "linear axes that span space");
            geometry.correction(&at, reverse, settings).ok_or_else(error)
        };
        if let Some(travel) = &mut travel {
            let share = |direction| if direction == Direction::POSITIVE { 0.0 } else { 1.0 };
            reverse = travel.arrive(&at, |directions: &[Direction; AXES]| sent(&directions.map(share)))?.map(share);
        }
        let error = geometry.pose_error(&at, &reverse);
        let correction = sent(&reverse)?;
        let mut corrected = values;
        for (own, correction) in axes.iter().zip(correction) {
            corrected[own.axis.index()] += correction;
        }
        let clamped = ends.iter().zip(at).any(|(ends, q)| ends.is_some_and(|[low, high]| q < low || q > high));
        let at = Evaluated { error: error.tip_mm, orientation: error.orientation, corrected, clamped };
        result.row(arguments, positions, &at)?;
    }
    Ok(())
}
