//! Latency and throughput of the step alone, without the simulated machine.

use crate::latency::{Latency, LatencySummary};
use crate::motion::Motion;
use crate::path::PlannedPath;
use crate::scenario::Scenario;
use crate::simulate::with_loop;
use anyhow::{Result, anyhow};
use std::hint::black_box;
use std::time::Instant;
use trueaxis::contour::Reference;
use trueaxis::machine::step_axes;
use trueaxis::{Input, State};

/// What the bench gives.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Latency of single steps, the clock's own reading included.
    pub latency: LatencySummary,
    /// Steps a second on one core, from a second pass without a clock between the steps.
    pub steps_per_s: f64,
}

/// Steps through the scenario's program `cycles` times round, with a deviation of a few micrometres on the readings.
///
/// # Errors
/// The machine's tables do not build.
pub fn run<const N: usize>(
    scenario: &Scenario,
    motion: &Motion<'_>,
    path: &PlannedPath,
    cycles: u64,
) -> Result<Outcome> {
    let mut span = 0;
    let kinematics = scenario.kinematics()?;
    let axes = step_axes::<N>(&scenario.machine.settings).map_err(|e| anyhow!("{e}"))?;
    let prepared: Vec<(Input<f64, N>, Reference<f64>)> = motion
        .setpoints()
        .map(|setpoint| {
            let mut command = [0.0; N];
            let positions = scenario.axis_positions(&setpoint);
            for (to, axis) in command.iter_mut().zip(axes) {
                *to = positions[axis.index()];
            }
            let mut feedback = command;
            // A deterministic wobble of some micrometres, so that the contour search has something to find.
            let phase = setpoint.length * 7.0;
            feedback[0] += 3e-3 * phase.sin() - 4e-5 * setpoint.velocity[0];
            feedback[1] += 3e-3 * phase.cos() - 4e-5 * setpoint.velocity[1];
            feedback[2] -= 4e-5 * setpoint.velocity[2];
            let input = Input {
                command,
                feedback,
                encoder_alarm: 0,
                elapsed_ns: scenario.period_ns(),
                homed: true,
                enable: true,
                reset: false,
            };
            (input, path.reference(setpoint.move_index, setpoint.u, &mut span))
        })
        .collect();
    with_loop::<N, _>(&scenario.machine, scenario.period_ns(), |servo| {
        let (view, tool_view) = (path.view(), path.tool_view());
        let step = |state: &mut State<f64, f64, N>, input: &Input<f64, N>, reference: Reference<f64>| match &kinematics
        {
            Some(kinematics) => servo.step_with_tool(state, input, &tool_view, reference, kinematics).0,
            None => servo.step(state, input, view.on(reference), ()),
        };
        let rounds = || (0..cycles).zip(prepared.iter().cycle());
        let fresh =
            || servo.start(scenario.period_ns()).map_err(|fault| anyhow!("the step refused to start: {fault:?}"));
        let mut latency = Latency::new(scenario.budget_ns, scenario.period_ns().into());
        let mut state = fresh()?;
        for (_, (input, reference)) in rounds() {
            let start = Instant::now();
            black_box(step(&mut state, black_box(input), *reference));
            latency.record(start.elapsed().as_nanos() as u64);
        }
        let mut state = fresh()?;
        let start = Instant::now();
        for (_, (input, reference)) in rounds() {
            black_box(step(&mut state, black_box(input), *reference));
        }
        let steps_per_s = cycles as f64 / start.elapsed().as_secs_f64();
        Ok(Outcome { latency: latency.summary(), steps_per_s })
    })
}
