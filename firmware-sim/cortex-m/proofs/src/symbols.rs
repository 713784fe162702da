//! The step in the forms in which a controller calls it, each under a separate name.
//!
//! Single precision with positions in nanometres, or doubles with the feature `double`.

use crate::Proved;
use trueaxis::contour::{CommandWindow, OrientationError, Path, Reference, ToolPath};
use trueaxis::exchange::Exchange;
use trueaxis::kinematics::{BranchTracker, Kinematics, Tool};
use trueaxis::roundness::{Cycle, Gauge, GaugeState, Probes};
use trueaxis::{Bypass, GaugeRide, Input, OnToolPath, Output, ServoLoop, State};

#[cfg(not(feature = "double"))]
mod scalar {
    pub type R = f32;
    pub type P = trueaxis::Nanometres;
}
#[cfg(feature = "double")]
mod scalar {
    pub type R = f64;
    pub type P = f64;
}
pub use scalar::{P, R};

/// Points of a gauge's revolution.
pub const POINTS: usize = 1024;
/// Pieces in the window of commands.
pub const WINDOW: usize = 16;

pub type Loop<const N: usize> = ServoLoop<'static, R, P, N>;

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_step(
    servo: &Loop<3>,
    state: &mut State<R, P, 3>,
    input: &Input<P, 3>,
    path: &Path<'_, R, P>,
    reference: Reference<R>,
) -> Output<R, P, 3> {
    servo.step(state, input, path.on(reference), ())
}

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_step_with_gauge(
    servo: &Loop<3>,
    state: &mut State<R, P, 3>,
    input: &Input<P, 3>,
    path: &Path<'_, R, P>,
    reference: Reference<R>,
    gauge: (&Gauge<R, POINTS>, &mut GaugeState<R, POINTS>, &Probes<R>),
) -> (Output<R, P, 3>, Cycle<R>) {
    let (gauge, gauge_state, probes) = gauge;
    let mut ride = GaugeRide::new(gauge, gauge_state, probes);
    let output = servo.step(state, input, path.on(reference), &mut ride);
    (output, ride.cycle())
}

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_step_with_tool(
    servo: &Loop<5>,
    state: &mut State<R, P, 5>,
    input: &Input<P, 5>,
    path: &ToolPath<'_, R, P>,
    reference: Reference<R>,
    kinematics: &Kinematics<R>,
) -> (Output<R, P, 5>, OrientationError<R>) {
    let mut on = OnToolPath::new(path, reference, kinematics);
    let output = servo.step(state, input, &mut on, ());
    (output, *on.orientation())
}

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_step_rtcp(
    servo: &Loop<5>,
    state: &mut State<R, P, 5>,
    input: &Input<P, 5>,
    tool: (&Tool<R>, &mut BranchTracker<R>),
    path: &ToolPath<'_, R, P>,
    reference: Reference<R>,
    kinematics: &Kinematics<R>,
) -> (Output<R, P, 5>, OrientationError<R>) {
    let (tool, tracker) = tool;
    let input = servo.rtcp(state, tool, tracker, kinematics, input);
    let mut on = OnToolPath::new(path, reference, kinematics);
    let output = servo.step(state, &input, &mut on, ());
    (output, *on.orientation())
}

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_step_following(
    servo: &Loop<3>,
    state: &mut State<R, P, 3>,
    input: &Input<P, 3>,
    commanded: &mut CommandWindow<R, P, WINDOW>,
) -> Output<R, P, 3> {
    servo.step(state, input, commanded, ())
}

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_bypass(bypass: &mut Bypass<P, 3>, input: &Input<P, 3>) -> Output<R, P, 3> {
    bypass.step(input)
}

#[unsafe(no_mangle)]
#[inline(never)]
pub fn proved_take_into(
    exchange: &Exchange<'static, Loop<3>>,
    active: &mut &'static Loop<3>,
) -> Option<&'static Loop<3>> {
    exchange.take_into(active)
}

/// All of them.
pub static TABLE: [Proved; 7] = [
    Proved(proved_step as *const ()),
    Proved(proved_step_with_gauge as *const ()),
    Proved(proved_step_with_tool as *const ()),
    Proved(proved_step_rtcp as *const ()),
    Proved(proved_step_following as *const ()),
    Proved(proved_bypass as *const ()),
    Proved(proved_take_into as *const ()),
];
