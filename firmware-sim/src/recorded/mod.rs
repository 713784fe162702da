//! Records a simulated run: the step's inputs, cycle by cycle, for any build of the step to replay.
//!
//! Positions are rounded to 1e-6 mm, as integer interfaces deliver them. A value that a fixed-point position cannot express is
//! encoded as such an interface does: a missing reading becomes an alarm of that encoder, a NaN command the end of the range.

mod drill;
mod gauge;

use anyhow::{Context, Result, anyhow, bail};
pub use drill::Drill;
use gauge::Turned;
use std::sync::Arc;
use trueaxis::contour::Reference;
use trueaxis::tcomp::machine_id;
use trueaxis::{Nanometres, Position};
use trueaxis_recording::{Header, Probe, RecordedCycle, Writer};
use trueaxis_sim::Scenario;
use trueaxis_sim::path::PlannedPath;
use trueaxis_sim::run::{Given, Kind, Moment, Run, Sample, Sink};

/// Settings of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Stop after this many cycles.
    pub cycles: Option<u32>,
    /// Whether to apply the disturbances of [`Drill`] to the recorded cycles.
    pub drill: bool,
    /// Cycle in which other tables are requested.
    pub exchange_at: Option<u32>,
    /// Spindle speed at a gauge.
    pub speed_rpm: f64,
}

/// Cycles between two updates of the progress bar.
const STRETCH: u64 = 4096;

/// Records the run of an X, Y, Z scenario with the plugin as the machine configures it; `progress` gets the fraction done, 0
/// to 1.
///
/// # Errors
/// The program turns rotary axes, or the tables do not build.
pub fn record(scenario: &Arc<Scenario>, settings: &Settings, progress: &mut dyn FnMut(f64)) -> Result<Vec<u8>> {
    let machine = &scenario.machine.settings;
    if scenario.machine.settings.step_axes().count() != 3 || scenario.five_axis {
        bail!("{}: found rotary axes, needed a machine and a program of X, Y, Z alone", machine.name);
    }
    let mut run = Run::of(Arc::clone(scenario), &[Kind::Configured])?;
    let path = PlannedPath::new(&scenario.program, scenario.origin_mm, &scenario.placement)?;
    let writer = Writer::<3>::new(header(scenario, settings)?, &path.spans).context("the path cannot be written")?;
    let mut recorder = Recorder {
        writer,
        turned: machine.roundness.as_ref().map(|gauge| Turned::new(gauge, scenario, settings.speed_rpm)),
        drill: settings.drill.then(|| Drill::new(scenario)),
        most: settings.cycles.unwrap_or(u32::MAX),
        last: [Nanometres(0); 3],
    };
    while run.advance(STRETCH, &mut recorder) {
        progress(run.cycle() as f64 / run.cycles() as f64);
    }
    recorder.writer.finish().context("the recording cannot be written")
}

fn header(scenario: &Scenario, settings: &Settings) -> Result<Header> {
    let machine = &scenario.machine.settings;
    let name = scenario.program.name.chars().filter(char::is_ascii).take(48).collect::<String>();
    Ok(Header {
        name: name.as_str().try_into().map_err(|_| anyhow!("the program's name does not fit"))?,
        machine_id: machine_id(&machine.name, &machine.chain),
        axes: 3,
        period_ns: scenario.period_ns(),
        cycles: 0,
        pieces: 0,
        gauge: machine.roundness.is_some(),
        exchange_at: settings.exchange_at,
    })
}

/// Writes the inputs of every step, including settling.
struct Recorder {
    writer: Writer<3>,
    turned: Option<Turned>,
    drill: Option<Drill>,
    most: u32,
    last: [Nanometres; 3],
}

impl Sink for Recorder {
    fn cycle(&mut self, _moment: &Moment, _machines: &[Option<&Sample>]) {}

    fn before_step(&mut self, given: &Given<'_>) {
        let number = self.writer.cycles();
        if number >= self.most {
            return;
        }
        let mut cycle = rounded(given, &mut self.last);
        if let Some(turned) = &mut self.turned {
            cycle.probe = turned.cycle();
        }
        if let Some(drill) = &self.drill {
            drill.disturb(number, &mut cycle);
        }
        self.writer.add(&cycle);
    }
}

fn rounded(given: &Given<'_>, last: &mut [Nanometres; 3]) -> RecordedCycle<3> {
    let mut cycle = RecordedCycle {
        command: [Nanometres(0); 3],
        feedback: *last,
        elapsed_ns: given.elapsed_ns,
        reference: Reference { span: given.reference.span, t: given.reference.t as f32 },
        homed: true,
        enable: true,
        reset: false,
        encoder_alarm: 0,
        probe: Probe::default(),
    };
    for (axis, (command, reading)) in given.command.iter().zip(given.feedback).take(3).enumerate() {
        cycle.command[axis] = if command.is_finite() { Nanometres::of(*command) } else { Nanometres(i32::MIN) };
        if reading.is_finite() {
            cycle.feedback[axis] = Nanometres::of(*reading);
        } else {
            cycle.encoder_alarm |= 1 << axis;
        }
    }
    *last = cycle.feedback;
    cycle
}
