//! The judged shift: sensors, task, step and limiter, and the true drift.

use super::bodies::Bodies;
use super::drift::drift;
use super::duty::Shift;
use super::instruments::{SENSORS, Sensors};
use super::outcome::{Judged, Moment};
use super::{SHIFT_S, STEP_S, Warming};
use crate::error::Result;
use crate::limit_watch::LimitWatch;
use crate::servo::{step, with_loop};
use trueaxis::Axis;
use trueaxis::machine::AxisOrder;
use trueaxis::temperature::{Readings, Thermal, ThermalState};
use trueaxis_metrology::thermal::{Fit, ThermalRefusal};
use trueaxis_tables::Machine;

/// Places at which the shift is judged: X, Y, Z and length of the tool, mm. The record contains none of them.
const JUDGED: [[f64; 4]; 4] = [
    [-250.0, -150.0, -50.0, 120.0],
    [250.0, 150.0, -350.0, 120.0],
    [0.0, 0.0, -120.0, 120.0],
    [150.0, -80.0, -300.0, 120.0],
];

/// Cycles of the step after every update, a millisecond each: a first growth of 50 µm ramps in within them.
const CYCLES: u32 = 200;
const PERIOD_NS: u32 = 1_000_000;

/// The machine with only the geometric step.
fn still(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    machine.settings.crosstalk = Default::default();
    machine.settings.contour.feedback = None;
    machine.settings.roundness = None;
    machine.settings.axes.iter_mut().for_each(|axis| axis.servo = Default::default());
    machine
}

pub(super) fn run(of: &Warming, bodies: &mut Bodies, shift: &Shift, found: &Fit, bytes: &[u8]) -> Result<Judged> {
    let thermal = Thermal::parse(bytes)
        .map_err(|error| ThermalRefusal::Encoding(trueaxis_metrology::thermal::NotEncoded::Refused(error)))?;
    let machine = still(&of.machine);
    with_loop::<3, _, _>(&machine, PERIOD_NS, |servo| {
        let axes = AxisOrder::<3>::of(&machine.settings)?.axes();
        let limits = axes.map(|axis| machine.settings.axis(axis).map(|settings| settings.limits));
        let mut states = JUDGED.map(|_| servo.start());
        let mut sensors = Sensors::new(of.seed ^ 0x5eed, bodies, shift);
        // The control is switched on before the shift begins: its sensors have started.
        let mut task = ThermalState::new();
        (0..found.sensors.len()).for_each(|sensor| task.accept(sensor));
        let zero = JUDGED.map(|point| drift(bodies, point));
        let mut first = [[0.0_f64; 3]; JUDGED.len()];
        let mut judged = Judged::default();
        let mut watches = JUDGED.map(|_| LimitWatch::new(limits, 1e-9 * f64::from(PERIOD_NS)));
        for t in (0..=SHIFT_S).step_by(STEP_S as usize) {
            if t.is_multiple_of(of.update_s) {
                let readings = sensors.read();
                let failed = |sensor: usize| of.fails == Some(sensor) && t >= SHIFT_S / 2;
                let temperatures: Vec<Option<f64>> =
                    found.sensors.iter().map(|&sensor| Some(readings[sensor]).filter(|_| !failed(sensor))).collect();
                let now = Readings {
                    temperatures_c: &temperatures,
                    spindle_rpm: Some(shift.at(t).rpm),
                    tool_mm: JUDGED[0][3],
                };
                let dt_s = if t == 0 { 0.0 } else { f64::from(of.update_s) };
                let growth = thermal.update(&mut task, dt_s, &now);
                judged.reported |= !growth.is_good();
                let mut moment = Moment { t_s: f64::from(t), rpm: shift.at(t).rpm, ..Moment::default() };
                for (place, (point, state)) in JUDGED.iter().zip(&mut states).enumerate() {
                    for (slot, axis) in axes.into_iter().enumerate() {
                        if let Some(line) = growth.line(axis) {
                            state.set_thermal(slot, line).expect("a slot of the step");
                        }
                    }
                    let command = [0, 1, 2].map(|slot| point[slot_of(axes[slot])]);
                    for cycle in 0..CYCLES {
                        let output = step(servo, state, &servo.input(command, command), &mut (), &mut ());
                        let correction = output.record.correction;
                        watches[place].take(correction);
                        judged.unsettled |= cycle + 1 == CYCLES && output.record.limited != 0;
                        judged.stopped |= output.stop_requested();
                    }
                    if t == 0 {
                        first[place] = watches[place].last;
                    }
                    let now = drift(bodies, *point);
                    for (slot, axis) in axes.into_iter().enumerate() {
                        let axis = slot_of(axis);
                        let drifted = now[axis] - zero[place][axis];
                        let left = drifted + watches[place].last[slot] - first[place][slot];
                        moment.take(place, axis, drifted, left);
                    }
                }
                moment.temperatures_c = readings;
                judged.moments.push(moment);
            }
            bodies.pass(f64::from(STEP_S), &shift.at(t));
            sensors.follow(f64::from(STEP_S), bodies, &shift.at(t));
        }
        for watch in &watches {
            judged.of_limits = judged.of_limits.max(watch.of_limits);
            judged.largest_step_mm = judged.largest_step_mm.max(watch.largest_step);
        }
        judged.failed = of.fails.map(|sensor| SENSORS[sensor]);
        Ok(judged)
    })
}

fn slot_of(axis: Axis) -> usize {
    axis.index().min(2)
}
