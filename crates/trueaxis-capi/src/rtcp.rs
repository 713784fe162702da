//! Rotation about the tool centre point: the host commands the tool in workpiece coordinates.

use crate::Real;
use crate::built::{Loop, State, with_servo};
use crate::cycle::Input;
use crate::error::{Error, Refusal, explained};
use crate::kinematics::{Kinematics, Tool};
use crate::opaque;
use crate::part::{TOOLPATH, need};
use crate::pointer::check;
use crate::result::{self, ERROR_ARGUMENT, ERROR_STATE, ResultCode};
use trueaxis::kinematics;

/// Words of a `trueaxis_branch_tracker_t`.
#[cfg(not(feature = "single"))]
pub const BRANCH_TRACKER_WORDS: usize = 20;
/// Words of a `trueaxis_branch_tracker_t`.
#[cfg(feature = "single")]
pub const BRANCH_TRACKER_WORDS: usize = 10;

/// Tracks the branch of the rotary axes. Belongs to the thread that steps it.
#[repr(C)]
#[derive(Debug)]
pub struct BranchTracker {
    words: [u64; BRANCH_TRACKER_WORDS],
}

/// Starts tracking at the machine's present pose.
///
/// `axes`: as for `trueaxis_kinematics_forward`. `max_step_deg`: largest step of a rotary axis in one cycle, degrees,
/// above 0 and at most 360. Not real-time. Errors: `_POSE`, `_ARGUMENT` (not finite, step out of range).
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes, `axes` to as many numbers as the machine has
/// axes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_branch_tracker_start(
    tracker: *mut BranchTracker,
    tracker_size: usize,
    kinematics: *const Kinematics,
    axes: *const f64,
    max_step_deg: f64,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        let place = opaque::place(tracker, tracker_size)?;
        // SAFETY: the caller's promise.
        let chain = unsafe { opaque::content(kinematics) }?;
        // SAFETY: the caller's promise.
        let joints = unsafe { chain.joints(axes) }?;
        if !(max_step_deg > 0.0 && max_step_deg <= 360.0) {
            return Err(ERROR_ARGUMENT.into());
        }
        let tool = chain.kinematics.forward(&joints);
        let start = chain.kinematics.inverse(&tool, &joints).map_err(Refusal::Pose)?;
        let tracker = kinematics::BranchTracker::new(&start, max_step_deg as Real);
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, tracker) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Reads the angle between the requested tool direction and that of the last positions computed, degrees: at most the
/// machine's `singular_cone_deg`, and 0 outside that cone except on the way out. Real-time safe.
///
/// # Safety
/// Pointers are null or point to objects of their types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_branch_tracker_direction_error(
    tracker: *const BranchTracker,
    error_deg: *mut Real,
) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        check(error_deg)?;
        // SAFETY: the caller's promise.
        let tracker = unsafe { opaque::content(tracker) }?;
        // SAFETY: checked; writable by the caller's promise.
        unsafe { error_deg.write(tracker.direction_error_deg()) };
        Ok(())
    };
    result::of(work())
}

/// Computes the axis positions for a tool and writes them to `input->command` for the next `trueaxis_step`, on the
/// branch that `tracker` follows.
///
/// `input->elapsed_ns` must be set. For a tool that has no such positions the fault is written to `input->refusal`: the
/// step then holds the output and reports the fault, and a reset near the held pose releases it. Within the machine's
/// `singular_cone_deg` of the singular pose the axis next to the workpiece stays still or turns by at most the
/// tracker's `max_step_deg` per cycle; the tip remains exact, and `trueaxis_branch_tracker_direction_error` returns the
/// remaining error of the direction. Call it once per cycle, for homed axes.
///
/// Real-time safe. Errors: `_AXES`, `_STATE` (also: a bypass, which has no kinematics), `_MACHINE`.
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else uses tracker or input, or writes the others.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_rtcp(
    r#loop: *const Loop,
    state: *const State,
    tool: *const Tool,
    tracker: *mut BranchTracker,
    kinematics: *const Kinematics,
    input: *mut Input,
) -> ResultCode {
    let work = || {
        need(TOOLPATH)?;
        // SAFETY: the caller's promise.
        let mut result = unsafe { Input::read_unrefused(input) }?;
        check(tool)?;
        // SAFETY: not null, aligned; any bits are numbers; readable by the caller's promise.
        let tool = unsafe { tool.read() }.to_core();
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content(state)?) };
        // SAFETY: the caller's promise.
        let chain = unsafe { opaque::content(kinematics) }?;
        // SAFETY: the caller's promise.
        let tracker = unsafe { opaque::content_mut(tracker) }?;
        chain.check_machine(built)?;
        with_servo!(built, running,
            servo(servo, state) => {
                let given = result.to_core();
                result.command_of(&servo.rtcp(state, &tool, tracker, &chain.kinematics, &given));
                Ok(())
            },
            bypass(_) => Err(ERROR_STATE)
        )??;
        // SAFETY: checked: aligned, of the right size; writable by the caller's promise.
        unsafe { input.write(result) };
        Ok(())
    };
    result::of(work())
}
