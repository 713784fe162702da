//! The plugin as a controller runs it: a state, a window of commands, a gauge, and the one call a cycle.

use super::combination::Measured;
use super::facts::Facts;
use super::gauge::{AnyGauge, AnyState};
use super::scalar::{Place, Scalar};
use trueaxis::compensation::ThermalLine;
use trueaxis::contour::{CommandWindow, Path, Reference, Span, ToolPath, Turn};
use trueaxis::kinematics::{Kinematics, Tool};
use trueaxis::roundness::{self, Probes};
use trueaxis::{Input, Measure, OnToolPath, Output, Ride, ServoLoop, State};

/// Spans of the window of commands.
pub(super) const WINDOW: usize = 24;
/// Distance of its points, mm.
pub(super) const SPACING_MM: f64 = 0.005;

/// What does not change during a leg.
#[derive(Debug)]
pub(super) struct Ground<'a, R: Scalar, P: Place, const N: usize> {
    /// Configurations that are exchanged for one another: the first two say the same.
    pub loops: &'a [ServoLoop<'a, R, P, N>],
    /// What they say.
    pub facts: &'a [Facts<P, N>],
    /// The path, in machine or workpiece coordinates.
    pub spans: &'a [Span<R, P>],
    /// Direction of the tool on each span.
    pub turns: &'a [Turn<R>],
    /// The path is closed.
    pub closed: bool,
    /// Up to two rotary axes.
    pub kinematics: Option<Kinematics<R>>,
    /// Where the combination has one.
    pub gauge: Option<AnyGauge<R>>,
    /// Bound of its infeed, µm.
    pub infeed_limit_um: f64,
}

impl<'a, R: Scalar, P: Place, const N: usize> Ground<'a, R, P, N> {
    /// The path.
    pub(super) fn path(&self) -> Path<'a, R, P> {
        Path::new(self.spans, 0, self.closed)
    }
}

/// What a cycle is given.
#[derive(Clone, Debug)]
pub(super) struct Moment<R: Scalar, P, const N: usize> {
    /// Of the step.
    pub input: Input<P, N>,
    /// What is measured in this cycle.
    pub measured: Measured,
    /// Where on the path.
    pub reference: Reference<R>,
    /// Of the gauge.
    pub probes: Probes<R>,
    /// The tool is commanded, and the axes are found in the cycle.
    pub tool: Option<Tool<R>>,
    /// Another configuration, from this cycle on.
    pub exchange: Option<usize>,
    /// Thermal growth, from this cycle on.
    pub thermal: Option<(usize, ThermalLine<R>)>,
    /// The window begins anew.
    pub restart: bool,
}

/// What one cycle hands to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Device<R: Scalar, P: Place, const N: usize> {
    /// Of the step.
    pub state: State<R, P, N>,
    /// Last commands.
    pub window: CommandWindow<R, P, WINDOW>,
    /// Of the gauge.
    pub gauge: AnyState<R>,
}

/// Outcome of a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome<R: Scalar, P: Place, const N: usize> {
    /// Of the step.
    pub output: Output<R, P, N>,
    /// Of the gauge.
    pub ride: roundness::Cycle<R>,
}

impl<R: Scalar, P: Place, const N: usize> Outcome<R, P, N> {
    /// Before the first cycle.
    pub(super) fn none() -> Self {
        Outcome { output: Output::none(), ride: roundness::Cycle::default() }
    }
}

impl<R: Scalar, P: Place, const N: usize> Device<R, P, N> {
    /// Fresh.
    pub(super) fn new(ground: &Ground<'_, R, P, N>) -> Self {
        let window = CommandWindow::new([0.0, 0.0, 1.0], SPACING_MM).expect("a spacing within the range");
        let gauge = ground.gauge.as_ref().map_or_else(AnyState::none, AnyGauge::start);
        Device { state: ground.loops[0].start(), window, gauge }
    }

    /// What is done between two cycles, then a cycle: by `step_into`, or by `step`.
    pub(super) fn cycle<const INTO: bool>(
        &mut self,
        ground: &Ground<'_, R, P, N>,
        servo: &ServoLoop<'_, R, P, N>,
        moment: &Moment<R, P, N>,
        outcome: &mut Outcome<R, P, N>,
    ) {
        if let Some((slot, line)) = moment.thermal {
            self.state.set_thermal(slot, line);
        }
        if moment.restart {
            self.window.restart();
        }
        let Device { state, window, gauge } = self;
        let parts = Parts { ground, servo, moment, state, window };
        match &ground.gauge {
            None => parts.step::<INTO>(&mut (), &mut outcome.output),
            Some(settings) => {
                let Outcome { output, ride } = outcome;
                let cycle = settings.ride(gauge, &moment.probes, |gauge| parts.step::<INTO>(gauge, output));
                *ride = cycle.expect("a state of its gauge");
            }
        }
    }
}

struct Parts<'c, 'a, R: Scalar, P: Place, const N: usize> {
    ground: &'c Ground<'a, R, P, N>,
    servo: &'c ServoLoop<'a, R, P, N>,
    moment: &'c Moment<R, P, N>,
    state: &'c mut State<R, P, N>,
    window: &'c mut CommandWindow<R, P, WINDOW>,
}

impl<R: Scalar, P: Place, const N: usize> Parts<'_, '_, R, P, N> {
    /// One copy of the step for every measure and gauge: with one each this crate would build for minutes.
    fn step<const INTO: bool>(self, ride: &mut dyn Ride<R>, output: &mut Output<R, P, N>) {
        let Parts { ground, servo, moment, state, window } = self;
        let input = &moment.input;
        let by = |measure: &mut dyn Measure<R, P, N>| {
            if INTO {
                servo.step_into(state, input, measure, ride, output)
            } else {
                *output = servo.step(state, input, measure, ride)
            }
        };
        match (moment.measured, &ground.kinematics) {
            (Measured::Path, _) => by(&mut ground.path().on(moment.reference)),
            (Measured::Window, _) => by(&mut &mut *window),
            (Measured::ToolPath, Some(kinematics)) => {
                let path = ToolPath::new(ground.path(), ground.turns);
                by(&mut &mut OnToolPath::new(&path, moment.reference, kinematics))
            }
            _ => by(&mut ()),
        }
    }
}
