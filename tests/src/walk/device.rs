//! The plugin as a controller runs it: a state, a window of commands, a gauge, and one call per cycle.

use super::combination::Measured;
use super::facts::Facts;
use super::gauge::{AnyGauge, AnyState};
use super::scalar::{Place, Scalar};
use trueaxis::compensation::ThermalLine;
use trueaxis::contour::{CommandWindow, Path, Reference, Span, ToolPath, Turn};
use trueaxis::kinematics::{Kinematics, Tool};
use trueaxis::roundness::{self, Probes};
use trueaxis::{Input, Measure, OnToolPath, Output, Ride, ServoLoop, State};

/// Number of spans in the window of commands.
pub(super) const WINDOW: usize = 24;
/// Spacing of the window's points, mm.
pub(super) const SPACING_MM: f64 = 0.005;

/// Constants of a leg.
#[derive(Debug)]
pub(super) struct Ground<'a, R: Scalar, P: Place, const N: usize> {
    /// Configurations that are exchanged for one another; the first two are identical.
    pub loops: &'a [ServoLoop<'a, R, P, N>],
    /// Facts of each configuration.
    pub facts: &'a [Facts<P, N>],
    /// The path, in machine or workpiece coordinates.
    pub spans: &'a [Span<R, P>],
    /// Direction of the tool on each span.
    pub turns: &'a [Turn<R>],
    /// Whether the path is closed.
    pub closed: bool,
    /// Kinematics of a machine with up to two rotary axes.
    pub kinematics: Option<Kinematics<R>>,
    /// Gauge, if the combination has one.
    pub gauge: Option<AnyGauge<R>>,
    /// Bound of the gauge's infeed, µm.
    pub infeed_limit_um: f64,
}

impl<'a, R: Scalar, P: Place, const N: usize> Ground<'a, R, P, N> {
    /// The path.
    pub(super) fn path(&self) -> Path<'a, R, P> {
        Path::new(self.spans, 0, self.closed)
    }
}

/// Inputs of a cycle.
#[derive(Clone, Debug)]
pub(super) struct Moment<R: Scalar, P, const N: usize> {
    /// Input of the step.
    pub input: Input<P, N>,
    /// Reference of the contour error in this cycle.
    pub measured: Measured,
    /// Position on the path.
    pub reference: Reference<R>,
    /// Input of the gauge.
    pub probes: Probes<R>,
    /// Commanded tool, for which the cycle computes the axes.
    pub tool: Option<Tool<R>>,
    /// New configuration from this cycle.
    pub exchange: Option<usize>,
    /// Thermal growth from this cycle.
    pub thermal: Option<(usize, ThermalLine<R>)>,
    /// Whether the window restarts.
    pub restart: bool,
}

/// State passed from one cycle to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Device<R: Scalar, P: Place, const N: usize> {
    /// State of the step.
    pub state: State<R, P, N>,
    /// Latest commands.
    pub window: CommandWindow<R, P, WINDOW>,
    /// State of the gauge.
    pub gauge: AnyState<R>,
}

/// Outcome of a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome<R: Scalar, P: Place, const N: usize> {
    /// Output of the step.
    pub output: Output<R, P, N>,
    /// Output of the gauge.
    pub gauge_output: roundness::Cycle<R>,
}

impl<R: Scalar, P: Place, const N: usize> Outcome<R, P, N> {
    /// The outcome before the first cycle.
    pub(super) fn none() -> Self {
        Outcome { output: Output::none(), gauge_output: roundness::Cycle::default() }
    }
}

impl<R: Scalar, P: Place, const N: usize> Device<R, P, N> {
    /// Fresh states.
    pub(super) fn new(ground: &Ground<'_, R, P, N>) -> Self {
        let window = CommandWindow::new([0.0, 0.0, 1.0], SPACING_MM).expect("a spacing within the range");
        let gauge = ground.gauge.as_ref().map_or_else(AnyState::none, AnyGauge::start);
        Device { state: ground.loops[0].start(), window, gauge }
    }

    /// Applies the changes between two cycles, then runs a cycle, by `step_into` or by `step`.
    pub(super) fn cycle<const INTO: bool>(
        &mut self,
        ground: &Ground<'_, R, P, N>,
        servo: &ServoLoop<'_, R, P, N>,
        moment: &Moment<R, P, N>,
        outcome: &mut Outcome<R, P, N>,
    ) {
        if let Some((slot, line)) = moment.thermal {
            assert_eq!(self.state.set_thermal(slot, line).is_ok(), slot < N, "growth of slot {slot} of {N}");
        }
        if moment.restart {
            self.window.restart();
        }
        let Device { state, window, gauge } = self;
        let parts = Parts { ground, servo, moment, state, window };
        match &ground.gauge {
            None => parts.step::<INTO>(&mut (), &mut outcome.output),
            Some(settings) => {
                let Outcome { output, gauge_output } = outcome;
                let cycle = settings.run_with(gauge, &moment.probes, |gauge| parts.step::<INTO>(gauge, output));
                *gauge_output = cycle.expect("a state of its gauge");
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
    /// One copy of the step for all measures and gauges: with one copy each, this crate would take minutes to build.
    fn step<const INTO: bool>(self, gauge: &mut dyn Ride<R>, output: &mut Output<R, P, N>) {
        let Parts { ground, servo, moment, state, window } = self;
        let input = &moment.input;
        let by = |measure: &mut dyn Measure<R, P, N>| {
            if INTO {
                servo.step_into(state, input, measure, gauge, output)
            } else {
                *output = servo.step(state, input, measure, gauge)
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
