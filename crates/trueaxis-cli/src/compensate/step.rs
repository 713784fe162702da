//! Nine terms and twists: the models of the servo step.

use super::{Arguments, Evaluated, Written};
use crate::csv_in::Rows;
use crate::model::{passes, rise, thermal, with_compensation};
use anyhow::{Result, anyhow};
use std::convert::Infallible;
use trueaxis::compensation::Direction;
use trueaxis::compensation::Query;
use trueaxis::machine::AxisOrder;
use trueaxis_evaluation::positions::{Travel, next};
use trueaxis_tables::Machine;

pub(super) fn evaluate<const N: usize>(
    arguments: &Arguments,
    machine: &Machine,
    positions: &mut Rows<6>,
    result: &mut Written<'_>,
) -> Result<()> {
    let settings = &machine.settings;
    let axes = AxisOrder::<N>::of(settings).map_err(|error| anyhow!("{error}"))?.axes();
    let passes = passes(machine, arguments.inverse_passes)?;
    let thermal = thermal(machine, &axes, rise(arguments.temperature_c, machine)?);
    let mut directions = [Direction::of(arguments.reverse); N];
    let mut travel = arguments.in_order.then(|| Travel::new(machine, axes.into_iter()));
    with_compensation::<N, _>(machine, passes, |compensation| {
        result.header(arguments, machine, positions)?;
        while let Some(row) = next(machine, positions)? {
            let command: [f64; N] = std::array::from_fn(|slot| row.values[axes[slot].index()]);
            let at = compensation.coordinates(&command);
            if let Some(travel) = &mut travel {
                let sent = |directions: &[Direction; N]| {
                    Ok::<_, Infallible>(compensation.correction(&Query::at(&at, directions, &thermal), &mut 0))
                };
                let Ok(settled) = travel.arrive(&command, sent);
                directions = settled;
            }
            let mut clamped = 0;
            let error = compensation.pose_error(&Query::at(&at, &directions, &thermal), &mut clamped);
            let correction = compensation.correction(&Query::at(&at, &directions, &thermal), &mut 0);
            let mut corrected = row.values;
            for (axis, (q, correction)) in axes.iter().zip(command.iter().zip(correction)) {
                corrected[axis.index()] = q + correction;
            }
            let clamped = clamped != 0;
            let at = Evaluated { error: error.tip.into(), orientation: error.orientation.into(), corrected, clamped };
            result.row(arguments, positions, &at)?;
        }
        Ok(())
    })
}
