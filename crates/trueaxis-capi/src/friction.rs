//! Friction that adapts: frozen, reset, reported.

use crate::Real;
use crate::built::{Loop, State, with_servo};
use crate::opaque;
use crate::pointer::check;
use crate::result::{self, ERROR_ARGUMENT, ERROR_AXES, ResultCode};

/// Command to the adaptation of friction, for all axes.
#[derive(Clone, Copy)]
enum Order {
    Freeze(bool),
    Reset,
}

/// Freezes the friction of all axes where it is (`frozen` not 0), or lets it adapt again. Call it between two cycles. No
/// effect in a bypass and on axes without `adapt`. Real-time safe. Errors: `_AXES`, `_STATE`.
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else uses `state` during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_friction_freeze(r#loop: *const Loop, state: *mut State, frozen: u8) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { obey(r#loop, state, Order::Freeze(frozen != 0)) })
}

/// Returns the friction of all axes to the identified figures, through the limiter, and forgets faults 12 and 13. Call it
/// between two cycles. No effect in a bypass. Real-time safe. Errors: `_AXES`, `_STATE`.
///
/// # Safety
/// As for `trueaxis_friction_freeze`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_friction_reset(r#loop: *const Loop, state: *mut State) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { obey(r#loop, state, Order::Reset) })
}

/// # Safety
/// As for `trueaxis_friction_freeze`.
unsafe fn obey(r#loop: *const Loop, state: *mut State, order: Order) -> Result<(), ResultCode> {
    // SAFETY: the caller's promise.
    let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
    if built.servo.axes() != running.axes() {
        return Err(ERROR_AXES);
    }
    with_servo!(built, running,
        servo(_servo, state) => match order {
            Order::Freeze(frozen) => state.freeze_friction(frozen),
            Order::Reset => state.reset_friction(),
        },
        bypass(_) => ()
    )
}

/// Reads the factors in use on the identified friction of an axis: of Coulomb friction, and of pre-sliding.
///
/// `axis`: index in the step's order (0 = X). `coulomb`, `presliding`: one number each; 1 in a bypass. Real-time safe.
/// Errors: `_AXES`, `_STATE`, `_ARGUMENT` (no such axis, or one without `adapt`).
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else writes `state` during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_friction_factors(
    r#loop: *const Loop,
    state: *mut State,
    axis: u32,
    coulomb: *mut Real,
    presliding: *mut Real,
) -> ResultCode {
    let work = || {
        check(coulomb)?;
        check(presliding)?;
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
        if built.servo.axes() != running.axes() {
            return Err(ERROR_AXES);
        }
        let factors = with_servo!(built, running,
            servo(servo, state) => servo.friction_factors(state, axis as usize).ok_or(ERROR_ARGUMENT),
            bypass(_) => Ok([1.0; 2])
        )?;
        let [level, wider] = factors?;
        // SAFETY: checked; writable by the caller's promise.
        unsafe {
            coulomb.write(level);
            presliding.write(wider);
        }
        Ok(())
    };
    result::of(work())
}
