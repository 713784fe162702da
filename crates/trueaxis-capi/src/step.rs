//! The servo cycle.

use crate::built::{Loop, State, cycle, with_servo};
use crate::cycle::{Input, Output};
use crate::gauge_ride::{GaugeRide, Riding};
use crate::measure::{Against, Measure};
use crate::opaque;
use crate::pointer::check_sized;
use crate::result::{self, ERROR_ARGUMENT, ERROR_AXES, ResultCode};

/// Executes one servo cycle: computes drive positions, feedback for the host, and contour error.
///
/// `measure`: the path to measure against; `NULL`: none. `gauge`: a gauge of three probes to run in this cycle; `NULL`:
/// none. Every combination of both is allowed. The first cycle returns the command; from then on
/// `drive = command + correction`. The infeed of a gauge is added to the correction of its axis, before the limiter. A
/// bypass measures against no path, and its gauge measures but feeds nothing in. Between two cycles another loop with
/// the same number of axes may be passed.
///
/// Until either a valid command has come or every axis has been read (without an alarm), the step has no position to
/// hold: the function returns `TRUEAXIS_ERROR_NO_OUTPUT` and does not write `output->drive`. Once every axis has been
/// read, the step holds that position and accepts a reset near it.
///
/// Real-time safe. Errors: `_AXES`, `_STATE`, `_MACHINE` (kinematics), `_ARGUMENT` (kind, refusal), `_NO_OUTPUT`.
/// Faults of the machine are in `output->record.fault`.
///
/// # Safety
/// Pointers are null or point to objects of their types, and so do those in `measure` and `gauge`; nobody else uses the
/// states or writes any other of them during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_step(
    r#loop: *const Loop,
    state: *mut State,
    input: *const Input,
    measure: *mut Measure,
    gauge: *mut GaugeRide,
    output: *mut Output,
) -> ResultCode {
    let work = || {
        // SAFETY: the caller's promise.
        unsafe { check_sized(output) }?;
        // SAFETY: the caller's promise.
        let input = unsafe { Input::read(input) }?;
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
        // SAFETY: the caller's promise.
        let (against, mut riding) = unsafe { (Against::of(measure, built)?, Riding::of(gauge)?) };
        let result = match against {
            Against::Nothing => cycle(built, running, &input, (), &mut riding),
            Against::Path(step, on) => step(built, running, &input, on, &mut riding),
            Against::Commands(step, window) => step(built, running, &input, window, &mut riding),
            Against::Tool(step, tool) => {
                let (result, vector) = step(built, running, &input, tool, &mut riding)?;
                // SAFETY: `Against::of` has checked it; writable by the caller's promise.
                unsafe { (&raw mut (*measure).direction_error).write(vector) };
                Ok(result)
            }
        }?;
        // SAFETY: checked: aligned, of the right size; writable by the caller's promise.
        unsafe {
            riding.deliver(gauge);
            result.deliver(output)
        }
    };
    result::of(work())
}

/// Sets the temperature of an axis. The growth that the table file gives for it acts from the next cycle on, through
/// the limiter.
///
/// `axis`: index in the step's order (0 = X). `kelvin`: temperature above the file's reference. Call it between two
/// cycles. No effect in a bypass. Real-time safe. Errors: `_AXES`, `_STATE`, `_ARGUMENT` (no such axis; growth of more
/// than 10 mm or 1e-3 of the length).
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else uses `state` during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_set_thermal(
    r#loop: *const Loop,
    state: *mut State,
    axis: u32,
    kelvin: f64,
) -> ResultCode {
    let work = || {
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
        if built.servo.axes() != running.axes() {
            return Err(ERROR_AXES);
        }
        let slot = axis as usize;
        let line = built.growth(slot, kelvin).ok_or(ERROR_ARGUMENT)?;
        with_servo!(built, running,
            servo(_servo, state) => state.set_thermal(slot, line).map_err(|_| ERROR_ARGUMENT),
            bypass(_) => Ok(())
        )?
    };
    result::of(work())
}
