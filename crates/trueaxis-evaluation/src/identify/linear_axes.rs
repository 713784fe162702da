//! Contribution of the linear axes to the ball's deviation, predicted by a machine's tables.

use super::Readings;
use crate::response::tip_errors;
use anyhow::Result;
use trueaxis::Axis;
use trueaxis::machine::{AXES, carries_workpiece};
use trueaxis_metrology::identification::{Ball, lever};
use trueaxis_tables::Machine;

/// Subtracts the linear axes' own errors from the readings; true if a position was beyond a table's end.
///
/// RTCP moves the linear axes so that the ball of every set-up stays in one place: `start_mm` is the position of X, Y, Z in
/// the first set-up at the first angle. With a head the linear axes move against the lever, with a table they follow it.
/// Tables are read in positive travel, at the reference temperature; the lever from the linear axes to the ball is the
/// volumetric model's.
pub(super) fn remove(
    readings: &mut Readings,
    machine: &Machine,
    axis: Axis,
    direction: f64,
    start_mm: [f64; 3],
) -> Result<bool> {
    let on_workpiece = carries_workpiece(&machine.settings.chain, axis);
    let mut known = machine.clone();
    known.settings.location.rotary = Default::default();
    known.settings.periodic.retain(|period| !period.axis.is_rotary());
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
        let position = |angle_deg: f64| {
            let arm = arm(ball, angle_deg);
            std::array::from_fn(|i| start_mm[i] + sense * (arm[i] - origin[i]))
        };
        let places: Vec<[f64; AXES]> = readings
            .angles_deg
            .iter()
            .map(|&angle| {
                let [x, y, z] = position(angle);
                let mut place = [x, y, z, 0.0, 0.0, 0.0];
                place[axis.index()] = angle;
                place
            })
            .collect();
        let (errors, clamped) = tip_errors(&known, &places)?;
        beyond |= clamped;
        for (deviations, error) in readings.deviations_mm.iter_mut().zip(errors) {
            if let Some(deviation) = deviations.get_mut(s) {
                *deviation = std::array::from_fn(|i| deviation[i] - error[i]);
            }
        }
    }
    Ok(beyond)
}
