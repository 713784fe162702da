//! The servo cycle: what the interrupt does, apart from the board.

#![deny(clippy::indexing_slicing)]

use crate::scalars::{AXES, GaugePlan, GaugeState, Loop, LoopState, Piece, Place, Scalar, StepOutput};
use trueaxis::Bypass;
use trueaxis::contour::Path;
use trueaxis::exchange::Exchange;
use trueaxis_recording::Recording;

/// What runs in a cycle. The state is the interrupt's alone: larger than what runs without tables, and never moved.
#[allow(clippy::large_enum_variant)]
pub enum Running {
    /// The step.
    Step(&'static Loop, LoopState),
    /// Commands pass uncorrected, with the reason in every record.
    Bypass(Bypass<Place, AXES>),
}

/// A gauge of three probes.
pub struct Gauge {
    /// What was built.
    pub plan: &'static GaugePlan,
    /// What it remembers.
    pub state: &'static mut GaugeState,
}

/// What a cycle produces for the telemetry.
pub struct Produced {
    /// What the step gave back.
    pub output: StepOutput,
    /// The gauge's infeed, mm, where one runs.
    pub infeed: Option<Scalar>,
    /// A revolution has just been evaluated.
    pub revolution: bool,
}

/// A controller whose commands and readings come out of a recording.
pub struct Servo {
    recording: Recording<'static, AXES>,
    pieces: &'static [Piece],
    running: Running,
    next: u32,
}

impl Servo {
    /// Before the first cycle.
    pub fn new(recording: Recording<'static, AXES>, pieces: &'static [Piece], running: Running) -> Self {
        Servo { recording, pieces, running, next: 0 }
    }

    /// Cycles so far.
    pub fn cycles(&self) -> u32 {
        self.next
    }

    /// The cycle that comes next is the one in which other tables are asked for.
    pub fn is_exchange_due(&self) -> bool {
        self.recording.header().exchange_at == Some(self.next)
    }

    /// One cycle; `None` at the end of the recording.
    pub fn cycle(&mut self, exchange: &Exchange<'static, Loop>, gauge: Option<&mut Gauge>) -> Option<Produced> {
        let cycle = self.recording.cycle(self.next)?;
        self.next += 1;
        let (input, place) = (cycle.input(), cycle.place());
        match &mut self.running {
            Running::Step(servo, state) => {
                exchange.take_into(servo);
                let path = Path::new(self.pieces, 0, false);
                let Some(gauge) = gauge else {
                    let output = servo.step(state, &input, &path, place);
                    return Some(Produced { output, infeed: None, revolution: false });
                };
                let (plan, measured) = (gauge.plan, &mut *gauge.state);
                let (output, cycle) =
                    servo.step_with_gauge(state, &input, &path, place, plan, measured, &cycle.probes());
                Some(Produced { output, infeed: Some(cycle.infeed), revolution: cycle.finished })
            }
            Running::Bypass(bypass) => Some(Produced { output: bypass.step(&input), infeed: None, revolution: false }),
        }
    }
}
