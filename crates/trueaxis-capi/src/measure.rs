//! Paths against which a cycle measures the contour error.

use crate::Real;
use crate::built::Built;
use crate::command_window::CommandWindow;
use crate::contour::Reference;
use crate::kinematics::Kinematics;
use crate::opaque;
use crate::part::{TOOLPATH, need};
use crate::path::Path;
use crate::plugin::{CorePosition, Window};
use crate::pointer::{Sized32, read_sized};
use crate::result::{ERROR_ARGUMENT, ResultCode};
use crate::steps::{OnTool, PathStep, ToolStep, WindowStep};
use trueaxis::contour::{self, OnPath};

/// Measure nothing.
pub const MEASURE_NOTHING: u32 = 0;
/// Measure against `path` at `reference`.
pub const MEASURE_PATH: u32 = 1;
/// Measure against the last commands: X, Y, Z of each valid command are appended to `window`.
pub const MEASURE_COMMANDS: u32 = 2;
/// Measure tip and direction of the tool against `path` at `reference`, in workpiece coordinates, using `kinematics`.
pub const MEASURE_TOOL: u32 = 3;

/// The path to measure against. Only the members that `kind` needs are read.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// `sizeof(trueaxis_measure_t)`.
    pub size: u32,
    /// `TRUEAXIS_MEASURE_…`.
    pub kind: u32,
    /// The path; for a tool a path started by `trueaxis_path_start_tool`.
    pub path: *const Path,
    /// Position of this cycle's command on the path.
    pub reference: Reference,
    /// The last commands.
    pub window: *mut CommandWindow,
    /// The machine's kinematics.
    pub kinematics: *const Kinematics,
    /// Written by a step with `TRUEAXIS_MEASURE_TOOL`: ideal × actual direction, a small rotation in rad, workpiece
    /// coordinates.
    pub direction_error: [Real; 3],
}

// SAFETY: repr(C), `size` first, numbers and pointers only.
unsafe impl Sized32 for Measure {}

/// A measure whose pointers have been checked, with the step that uses it.
pub(crate) enum Against<'a> {
    Nothing,
    Path(PathStep, OnPath<'a, Real, CorePosition>),
    Commands(WindowStep, &'a mut Window),
    Tool(ToolStep, OnTool<'a>),
}

impl Against<'_> {
    /// # Safety
    /// `measure` is null, misaligned, or points to a measure in which the members that its kind needs are null,
    /// misaligned, or point to whole objects that nobody else writes while this lives; nor does anybody else read the
    /// window.
    #[inline(always)]
    pub(crate) unsafe fn of(measure: *const Measure, built: &Built) -> Result<Self, ResultCode> {
        if measure.is_null() {
            return Ok(Against::Nothing);
        }
        // SAFETY: the caller's promise.
        let measure = unsafe { read_sized(measure) }?;
        let reference = contour::Reference { span: measure.reference.span, t: measure.reference.t };
        match measure.kind {
            MEASURE_NOTHING => Ok(Against::Nothing),
            MEASURE_PATH => {
                // SAFETY: the caller's promise.
                let path = unsafe { opaque::content(measure.path) }?;
                Ok(Against::Path(path.path_step, path.path().on(reference)))
            }
            MEASURE_COMMANDS => {
                // SAFETY: the caller's promise.
                let window = unsafe { opaque::content_mut(measure.window) }?;
                Ok(Against::Commands(window.step, &mut window.commands))
            }
            MEASURE_TOOL => {
                need(TOOLPATH)?;
                // SAFETY: the caller's promise.
                let (path, kinematics) =
                    unsafe { (opaque::content(measure.path)?, opaque::content(measure.kinematics)?) };
                kinematics.check_machine(built)?;
                let on = OnTool { path: path.tool_path(), reference, kinematics: &kinematics.kinematics };
                Ok(Against::Tool(kinematics.step, on))
            }
            _ => Err(ERROR_ARGUMENT),
        }
    }
}
