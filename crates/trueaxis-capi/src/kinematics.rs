//! Kinematics of a machine, for tool paths and tool positions.

use crate::Real;
use crate::axes::AXES_MAX;
use crate::built::Built;
use crate::error::{Error, explained};
use crate::opaque;
use crate::part::{TOOLPATH, need};
use crate::pointer::{check, slice, vector};
use crate::result::{self, ERROR_ARGUMENT, ERROR_MACHINE, ResultCode};
use crate::steps::{ToolStep, tool_step};
use trueaxis::Axis;
use trueaxis::kinematics;
use trueaxis::tcomp::Tcomp;

/// Words of a `trueaxis_kinematics_t`.
#[cfg(not(feature = "single"))]
pub const KINEMATICS_WORDS: usize = 48;
/// Words of a `trueaxis_kinematics_t`.
#[cfg(feature = "single")]
pub const KINEMATICS_WORDS: usize = 32;

/// A machine's kinematic chain and its tool. Immutable except for the tool; may be copied and may be read from any
/// thread.
#[repr(C)]
#[derive(Debug)]
pub struct Kinematics {
    words: [u64; KINEMATICS_WORDS],
}

/// Content of a [`Kinematics`].
pub(crate) struct Chain {
    pub(crate) step: ToolStep,
    pub(crate) kinematics: kinematics::Kinematics<Real>,
    machine_id: u32,
    /// Indices of the step's axes in the order X Y Z A B C.
    axes: [u8; AXES_MAX],
    count: u8,
}

impl Chain {
    /// Refuses a loop of another machine; a bypass belongs to none.
    pub(crate) fn check_machine(&self, built: &Built) -> Result<(), ResultCode> {
        if built.machine_id == self.machine_id || built.machine_id == 0 { Ok(()) } else { Err(ERROR_MACHINE) }
    }

    /// Positions of the step's axes, arranged in the order X Y Z A B C.
    ///
    /// # Safety
    /// `axes` is null, misaligned, or points to as many numbers as the machine has axes.
    pub(crate) unsafe fn joints(&self, axes: *const f64) -> Result<[Real; AXES_MAX], ResultCode> {
        // SAFETY: the caller's promise.
        let positions = unsafe { slice(axes, self.count.into()) }?;
        if !positions.iter().all(|x| x.abs() <= 1e9) {
            return Err(ERROR_ARGUMENT);
        }
        let mut joints = [0.0; AXES_MAX];
        for (index, position) in self.axes.iter().zip(positions) {
            if let Some(joint) = joints.get_mut(usize::from(*index)) {
                *joint = *position as Real;
            }
        }
        Ok(joints)
    }
}

/// A tool in workpiece coordinates.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Tool {
    /// Position of the tip, mm.
    pub tip: [Real; 3],
    /// Unit vector from the tip towards the spindle.
    pub axis: [Real; 3],
}

impl Tool {
    pub(crate) fn to_core(self) -> kinematics::Tool<Real> {
        kinematics::Tool { tip: self.tip.into(), axis: self.axis.into() }
    }
}

/// Builds the kinematics of the machine in a table file: X, Y, Z and up to two rotary axes.
///
/// Arguments as for `trueaxis_loop_build`. Not real-time. Errors: `_TABLES`, `_CONFIG` (the chain is not supported).
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_kinematics_build(
    kinematics: *mut Kinematics,
    kinematics_size: usize,
    file: *const u8,
    length: usize,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        let place = opaque::place(kinematics, kinematics_size)?;
        // SAFETY: the caller's promise.
        let file = unsafe { slice(file, length) }?;
        let mut tables = Tcomp::empty();
        tables.read(file)?;
        let (mut axes, mut count) = ([0; AXES_MAX], 0);
        for (index, (axis, _)) in axes.iter_mut().zip(crate::tables::slots(&tables)) {
            (*index, count) = (Axis::index(axis) as u8, count + 1);
        }
        let kinematics = tables.kinematics()?;
        let chain = Chain { step: tool_step, kinematics, machine_id: tables.machine_id(), axes, count };
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, chain) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Sets the tool: position of its tip relative to the last tool-side frame with all axes at zero, three numbers, mm.
/// Call it between two cycles; real-time safe. Errors: `_ARGUMENT` (not finite).
///
/// # Safety
/// Pointers are null or point to objects of their types, `tool_mm` to three numbers; nobody else uses the kinematics.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_kinematics_set_tool(kinematics: *mut Kinematics, tool_mm: *const f64) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        // SAFETY: the caller's promise.
        let (tool, chain) = unsafe { (vector(tool_mm)?, opaque::content_mut(kinematics)?) };
        if !tool.iter().all(|x| x.abs() <= 1e9) {
            return Err(ERROR_ARGUMENT);
        }
        chain.kinematics = chain.kinematics.with_tool(tool.map(|x| x as Real));
        Ok(())
    };
    result::of(work())
}

/// Computes the tool from the positions of the axes.
///
/// `axes`: as many numbers as the machine has axes, in the step's order, mm and degrees. Real-time safe. Errors:
/// `_ARGUMENT` (not finite).
///
/// # Safety
/// Pointers are null or point to objects of their types, `axes` to as many numbers as the machine has axes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_kinematics_forward(
    kinematics: *const Kinematics,
    axes: *const f64,
    tool: *mut Tool,
) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        check(tool)?;
        // SAFETY: the caller's promise.
        let chain = unsafe { opaque::content(kinematics) }?;
        // SAFETY: the caller's promise.
        let joints = unsafe { chain.joints(axes) }?;
        let found = chain.kinematics.forward(&joints);
        // SAFETY: checked; writable by the caller's promise.
        unsafe { tool.write(Tool { tip: found.tip.into(), axis: found.axis.into() }) };
        Ok(())
    };
    result::of(work())
}
