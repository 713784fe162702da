//! The step with each measure, for any number of axes.
//!
//! A path, a window and the kinematics store a pointer to their step, so a program links only the steps of the objects
//! that it starts.

use crate::Real;
use crate::built::{Built, Running, cycle};
use crate::cycle::{Input, Output};
use crate::gauge_ride::Riding;
use crate::plugin::{CorePosition, Window};
use crate::result::ResultCode;
use trueaxis::OnToolPath;
use trueaxis::contour::{self, OnPath, ToolPath};

/// A step that measures against a path, for any number of axes.
pub(crate) type PathStep =
    fn(&Built, &mut Running, &Input, OnPath<'_, Real, CorePosition>, &mut Riding<'_>) -> Result<Output, ResultCode>;
/// A step that measures against the last commands.
pub(crate) type WindowStep =
    fn(&Built, &mut Running, &Input, &mut Window, &mut Riding<'_>) -> Result<Output, ResultCode>;
/// A step that measures against a tool path; also returns the error of the direction.
pub(crate) type ToolStep =
    fn(&Built, &mut Running, &Input, OnTool<'_>, &mut Riding<'_>) -> Result<(Output, [Real; 3]), ResultCode>;

/// A tool path, the position of the command on it, and the kinematics.
pub(crate) struct OnTool<'a> {
    pub(crate) path: ToolPath<'a, Real, CorePosition>,
    pub(crate) reference: contour::Reference<Real>,
    pub(crate) kinematics: &'a trueaxis::kinematics::Kinematics<Real>,
}

pub(crate) fn path_step(
    built: &Built,
    running: &mut Running,
    input: &Input,
    on: OnPath<'_, Real, CorePosition>,
    gauge: &mut Riding<'_>,
) -> Result<Output, ResultCode> {
    cycle(built, running, input, on, gauge)
}

pub(crate) fn window_step(
    built: &Built,
    running: &mut Running,
    input: &Input,
    window: &mut Window,
    gauge: &mut Riding<'_>,
) -> Result<Output, ResultCode> {
    cycle(built, running, input, window, gauge)
}

pub(crate) fn tool_step(
    built: &Built,
    running: &mut Running,
    input: &Input,
    on: OnTool<'_>,
    gauge: &mut Riding<'_>,
) -> Result<(Output, [Real; 3]), ResultCode> {
    let mut on = OnToolPath::new(&on.path, on.reference, on.kinematics);
    let output = cycle(built, running, input, &mut on, gauge)?;
    Ok((output, on.orientation().vector.into()))
}
