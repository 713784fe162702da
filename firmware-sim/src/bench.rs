//! Latency and throughput of the step alone, and throughput of the step with the simulated machine.

use crate::latency::{Latency, LatencySummary, timed};
use anyhow::{Result, anyhow, bail};
use std::hint::black_box;
use std::sync::Arc;
use trueaxis::contour::Reference;
use trueaxis::machine::AxisOrder;
use trueaxis::sample::Refusal;
use trueaxis::{Axis, Input, OnToolPath, State};
use trueaxis_sim::Scenario;
use trueaxis_sim::motion::{Motion, Setpoints};
use trueaxis_sim::path::{self, SlidingPath};
use trueaxis_sim::run::{Kind, Run};
use trueaxis_sim::servo::{self, Axes, Compiled, with_loop};

/// Results of the benchmark.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Latency of single steps, including the overhead of reading the clock.
    pub latency: LatencySummary,
    /// Steps per second on one core, without a clock between them: the best of [`REPEATS`] passes.
    pub steps_per_s: f64,
    /// Steps per second of a corrected run: with the plant, the program and the true error of every cycle.
    pub steps_per_s_with_plant: f64,
}

/// Number of passes. The fastest counts, since other load on the computer can only slow a pass down.
pub const REPEATS: u64 = 5;

/// Number of inputs prepared at a time, outside the timed section.
const BLOCK: u64 = 4096;

type Prepared<const N: usize> = (Input<f64, N>, Reference<f64>);

/// The inputs of a scenario's program, a block at a time, repeated endlessly.
struct Inputs<'c, const N: usize> {
    scenario: &'c Scenario,
    motion: &'c Motion,
    axes: [Axis; N],
    setpoints: Setpoints<'c>,
    path: SlidingPath,
    span: u32,
    block: Vec<Prepared<N>>,
}

impl<'c, const N: usize> Inputs<'c, N> {
    fn new(scenario: &'c Scenario, motion: &'c Motion) -> Result<Self> {
        Ok(Inputs {
            scenario,
            motion,
            axes: AxisOrder::<N>::with_spare_slots(&scenario.machine.settings).map_err(|e| anyhow!("{e}"))?.axes(),
            setpoints: motion.setpoints(&scenario.program),
            path: SlidingPath::new(scenario),
            span: 0,
            block: Vec::new(),
        })
    }

    /// Prepares at most `most` inputs, and at least one; a block never extends past the end of the program.
    fn prepare(&mut self, most: u64) -> Result<()> {
        self.block.clear();
        let mut first = None;
        while (self.block.len() as u64) < most {
            let Some(setpoint) = self.setpoints.next() else {
                if self.block.is_empty() {
                    (self.setpoints, self.path) =
                        (self.motion.setpoints(&self.scenario.program), SlidingPath::new(self.scenario));
                    self.span = 0;
                    continue;
                }
                break;
            };
            let first = *first.get_or_insert(setpoint.move_index);
            self.path.cover(self.scenario, [first, setpoint.move_index])?;
            let positions = self.scenario.axis_positions(&setpoint);
            let command = self.axes.map(|axis| positions[axis.index()]);
            let mut feedback = command;
            // A deterministic ripple of a few micrometres, so that the contour search has an error to find.
            let phase = setpoint.length * 7.0;
            feedback[0] += 3e-3 * phase.sin() - 4e-5 * setpoint.velocity[0];
            feedback[1] += 3e-3 * phase.cos() - 4e-5 * setpoint.velocity[1];
            feedback[2] -= 4e-5 * setpoint.velocity[2];
            let input = Input {
                command,
                feedback,
                encoder_alarm: 0,
                elapsed_ns: self.scenario.period_ns(),
                homed: true,
                enable: true,
                reset: false,
                refusal: Refusal::NONE,
                ..Input::at_rest(self.scenario.period_ns())
            };
            self.block.push((input, self.path.reference(setpoint.move_index, setpoint.u, &mut self.span)));
        }
        Ok(())
    }
}

/// Runs `cycles` steps, on `N` slots, of the scenario's program, repeating it, with a deviation of a few micrometres on the readings.
///
/// # Errors
/// The machine's tables do not build.
pub fn run<const N: usize>(scenario: &Scenario, budget_ns: u64, cycles: u64) -> Result<Outcome>
where
    Axes: Compiled<N>,
{
    let motion = &scenario.motion()?;
    path::check(scenario)?;
    let kinematics = scenario.kinematics()?;
    with_loop::<N, _, _>(&scenario.machine, scenario.period_ns(), |servo| {
        let step = |state: &mut State<f64, f64, N>, path: &SlidingPath, (input, reference): &Prepared<N>| {
            let (input, reference) = (black_box(input), *reference);
            match &kinematics {
                Some(kinematics) => {
                    let path = path.tool_view();
                    let mut on = OnToolPath::new(&path, reference, kinematics);
                    servo::step(servo, state, input, &mut &mut on, &mut ())
                }
                None => servo::step(servo, state, input, &mut path.view().on(reference), &mut ()),
            }
        };
        // Passes every block to `steps`, starting from a fresh state.
        let pass = |steps: &mut dyn FnMut(&mut State<f64, f64, N>, &Inputs<'_, N>)| -> Result<()> {
            let mut state = servo.start();
            let mut inputs = Inputs::new(scenario, motion)?;
            let mut left = cycles;
            while left > 0 {
                inputs.prepare(left.min(BLOCK))?;
                steps(&mut state, &inputs);
                left -= inputs.block.len() as u64;
            }
            Ok(())
        };
        let mut latency = Latency::new(budget_ns, scenario.period_ns().into());
        pass(&mut |state, inputs| {
            for prepared in &inputs.block {
                let (output, nanoseconds) = timed(|| step(state, &inputs.path, prepared));
                black_box(output);
                latency.record(nanoseconds);
            }
        })?;
        let mut steps_per_s: f64 = 0.0;
        for _ in 0..REPEATS {
            let mut nanoseconds = 0;
            pass(&mut |state, inputs| {
                let work = || {
                    for prepared in &inputs.block {
                        black_box(step(state, &inputs.path, prepared));
                    }
                };
                nanoseconds += timed(work).1;
            })?;
            steps_per_s = steps_per_s.max(rate(cycles, nanoseconds));
        }
        let steps_per_s_with_plant = with_plant(scenario, cycles)?;
        Ok(Outcome { latency: latency.summary(), steps_per_s, steps_per_s_with_plant })
    })
}

fn rate(cycles: u64, nanoseconds: u64) -> f64 {
    cycles as f64 * 1e9 / nanoseconds.max(1) as f64
}

/// Steps per second of a run with the plugin as the machine configures it, from the program's first cycle.
fn with_plant(scenario: &Scenario, cycles: u64) -> Result<f64> {
    let scenario = Arc::new(scenario.clone());
    let mut best: f64 = 0.0;
    for _ in 0..REPEATS {
        let (mut done, mut nanoseconds) = (0, 0);
        while done < cycles {
            let mut run = Run::of(scenario.clone(), &[Kind::Configured])?;
            // Settling precedes the first cycle and is not timed.
            run.advance(0, &mut ());
            nanoseconds += timed(|| run.advance(cycles - done, &mut ())).1;
            done += run.cycle();
            if run.cycle() == 0 {
                bail!("program: found no cycle, needed at least one");
            }
        }
        best = best.max(rate(cycles, nanoseconds));
    }
    Ok(best)
}
