//! Contribution of the linear axes to the ball's deviation, predicted by a machine's tables.

use super::Readings;
use crate::by_axes;
use crate::model::with_compensation;
use anyhow::{Result, anyhow};
use trueaxis::Axis;
use trueaxis::compensation::Query;
use trueaxis::compensation::{Compensation, Direction, ThermalLine};
use trueaxis::machine::ErrorModel;
use trueaxis::machine::{AxisOrder, carries_workpiece};
use trueaxis_metrology::identification::{Ball, lever};
use trueaxis_tables::Machine;

/// Takes the linear axes' own errors out of the readings; true where a position lay beyond a table's end.
///
/// RTCP moves the linear axes so that the ball of every set-up stays in one place: `start_mm` is where X, Y, Z stand in the first
/// set-up at the first angle. A head's axes go against the lever, a table's tool goes with it. Tables are read in positive travel, at
/// the reference temperature; the lever from the linear axes to the ball is that of the volumetric model.
pub(super) fn remove(
    readings: &mut Readings,
    machine: &Machine,
    axis: Axis,
    direction: f64,
    start_mm: [f64; 3],
) -> Result<bool> {
    let on_workpiece = carries_workpiece(&machine.settings.chain, axis);
    let mut known = machine.clone();
    known.settings.compensation.model = ErrorModel::Volumetric;
    known.settings.location.rotary = Default::default();
    for (settings, table) in known.settings.axes.iter_mut().zip(&mut known.tables) {
        settings.backlash = 0.0;
        if settings.axis.is_rotary() {
            *table = None;
        }
    }
    let sense = if on_workpiece { 1.0 } else { -1.0 };
    let arm = |ball: Ball, angle_deg: f64| lever(axis, (direction * angle_deg).to_radians(), ball).unwrap_or_default();
    let (Some(&first_ball), Some(&first_angle)) = (readings.balls.first(), readings.angles_deg.first()) else {
        return Ok(false);
    };
    let origin = arm(first_ball, first_angle);
    let mut beyond = false;
    for (s, &ball) in readings.balls.iter().enumerate() {
        if !on_workpiece {
            known.settings.tool_mm = arm(ball, 0.0);
        }
        let stands = |angle_deg: f64| {
            let arm = arm(ball, angle_deg);
            std::array::from_fn(|i| start_mm[i] + sense * (arm[i] - origin[i]))
        };
        let poses: Vec<([f64; 3], f64)> = readings.angles_deg.iter().map(|&angle| (stands(angle), angle)).collect();
        let (errors, clamped) = by_axes!(known.settings.step_axes().count(), tip_errors(&known, axis, &poses))?;
        beyond |= clamped;
        for (deviations, error) in readings.deviations_mm.iter_mut().zip(errors) {
            if let Some(deviation) = deviations.get_mut(s) {
                *deviation = std::array::from_fn(|i| deviation[i] - error[i]);
            }
        }
    }
    Ok(beyond)
}

/// Tip errors at poses of X, Y, Z and the turning axis, mm; whether an edge value was clamped.
fn tip_errors<const N: usize>(
    machine: &Machine,
    axis: Axis,
    poses: &[([f64; 3], f64)],
) -> Result<(Vec<[f64; 3]>, bool)> {
    let axes = AxisOrder::<N>::of(&machine.settings).map_err(|error| anyhow!("{error}"))?.axes();
    with_compensation::<N, _>(machine, 1, |compensation: &Compensation<'_, f64, f64, N>| {
        let mut clamped = 0;
        let errors = poses.iter().map(|(position, angle)| {
            let command: [f64; N] = axes.map(|of| match of {
                of if of == axis => *angle,
                of => position.get(of.index()).copied().unwrap_or(0.0),
            });
            let at = compensation.coordinates(&command);
            let error = compensation
                .errors(&Query::at(&at, &[Direction::POSITIVE; N], &[ThermalLine::default(); N]), &mut clamped);
            [error[0], error[1], error[2]]
        });
        let errors = errors.collect();
        Ok((errors, clamped != 0))
    })
}
