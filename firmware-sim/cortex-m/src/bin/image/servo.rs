//! The servo cycle: the interrupt's work, independent of the board.

#![deny(clippy::indexing_slicing)]

use crate::scalars::{AXES, GaugeCycle, GaugePlan, GaugeState, Loop, LoopState, Piece, Place, Scalar, StepOutput};
use trueaxis::contour::Path;
use trueaxis::exchange::Exchange;
use trueaxis::{Bypass, Fault, GaugeRide, Input};
use trueaxis_cortex_m::growth::Growths;
use trueaxis_recording::{RecordedCycle, Recording};

/// The step or bypass that runs in a cycle. Only the interrupt owns the state, which is large and never moved.
#[allow(clippy::large_enum_variant)]
pub enum Running {
    /// The step.
    Step(&'static Loop, LoopState),
    /// Passes commands uncorrected, with the reason in every record.
    Bypass(Bypass<Place, AXES>),
}

/// A gauge of three probes.
pub struct Gauge {
    /// The built gauge.
    pub plan: &'static GaugePlan,
    /// State of the gauge.
    pub state: &'static mut GaugeState,
}

/// Output of a cycle for the telemetry.
#[derive(Clone, Copy)]
pub struct Produced {
    /// Output of the step.
    pub output: StepOutput,
    /// Output of the gauge, if one runs.
    pub gauge: Option<GaugeCycle>,
}

/// A controller whose commands and readings come from a recording.
pub struct Servo {
    recording: Recording<'static, AXES>,
    pieces: &'static [Piece],
    running: Running,
    growths: Growths<Scalar, AXES>,
    next: u32,
    produced: Produced,
}

impl Servo {
    /// The servo before its first cycle.
    pub fn new(
        recording: Recording<'static, AXES>,
        pieces: &'static [Piece],
        running: Running,
        growths: Growths<Scalar, AXES>,
    ) -> Self {
        let nothing = Bypass::<Place, AXES>::new(Fault::None).step(&Input::at_rest(0));
        let produced = Produced { output: nothing, gauge: None };
        Servo { recording, pieces, running, growths, next: 0, produced }
    }

    /// Cycles so far.
    pub fn cycles(&self) -> u32 {
        self.next
    }

    /// The thermal growth taken so far.
    pub fn growths(&self) -> &Growths<Scalar, AXES> {
        &self.growths
    }

    /// Whether the recording requests other tables in the next cycle.
    pub fn is_exchange_due(&self) -> bool {
        self.recording.header().exchange_at == Some(self.next)
    }

    /// Runs one cycle; its output replaces the previous one's. `None` at the end of the recording.
    pub fn cycle(&mut self, exchange: &Exchange<'static, Loop>, gauge: Option<&mut Gauge>) -> Option<&Produced> {
        let number = self.next;
        let cycle = self.recording.cycle(number)?;
        self.next += 1;
        let produced = &mut self.produced;
        produced.gauge = None;
        match &mut self.running {
            Running::Step(servo, state) => {
                exchange.take_into(servo);
                self.growths.take_into(state, number);
                let path = Path::new(self.pieces, 0, false);
                match gauge {
                    None => step(servo, state, &cycle, &path, produced),
                    Some(gauge) => step_with_gauge(servo, state, &cycle, &path, gauge, produced),
                }
            }
            Running::Bypass(bypass) => produced.output = bypass.step(&cycle.input()),
        }
        Some(produced)
    }
}

// The two steps are separate functions, so that neither's stack frame holds the locals of the other.
#[inline(never)]
fn step(
    servo: &Loop,
    state: &mut LoopState,
    cycle: &RecordedCycle<AXES>,
    path: &Path<'_, Scalar, Place>,
    produced: &mut Produced,
) {
    produced.output = servo.step(state, &cycle.input(), path.on(cycle.place()), ());
}

#[inline(never)]
fn step_with_gauge(
    servo: &Loop,
    state: &mut LoopState,
    cycle: &RecordedCycle<AXES>,
    path: &Path<'_, Scalar, Place>,
    gauge: &mut Gauge,
    produced: &mut Produced,
) {
    let probes = cycle.probes();
    let mut ride = GaugeRide::new(gauge.plan, gauge.state, &probes);
    produced.output = servo.step(state, &cycle.input(), path.on(cycle.place()), &mut ride);
    produced.gauge = Some(ride.cycle());
}
