//! The servo cycle with the commands themselves as the path.

use crate::Real;
use crate::cycle::{Input, Output};
use crate::opaque::{self, Storage};
use crate::plugin::CorePosition;
use crate::pointer::{check_sized, read_sized, vector};
use crate::servo::{Loop, State, with_servo};
use crate::status::{self, ERROR_ARGUMENT, Status};
use trueaxis::contour::CommandWindow;

/// Pieces of the window in a `trueaxis_follow_t`.
pub const FOLLOW_PIECES: usize = 64;
/// Words of a `trueaxis_follow_t`.
#[cfg(not(feature = "single"))]
pub const FOLLOW_WORDS: usize = 4864;
/// Words of a `trueaxis_follow_t`.
#[cfg(feature = "single")]
pub const FOLLOW_WORDS: usize = 2784;

/// A short window of the last commanded points: the path, for a host that knows no other. Belongs to the thread that
/// steps it.
#[repr(C)]
#[derive(Debug)]
pub struct Follow {
    words: [u64; FOLLOW_WORDS],
}

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for Follow {
    type Content = CommandWindow<Real, CorePosition, FOLLOW_PIECES>;
    const MAGIC: u32 = 0x5452_0007;
}

/// Starts an empty window.
///
/// `follow`, `follow_size`: the caller's, `sizeof(trueaxis_follow_t)`. `plane`: normal of the machining plane, three
/// numbers of any length, for the signed components of the contour error; `NULL` for 0, 0, 1 (G17). `spacing_mm`: way
/// between two points at slow feeds, 0.001 to 1 mm; 0.005 is a good one. The window must hold the largest lag of the tool:
/// `TRUEAXIS_FOLLOW_PIECES` times the spacing, or the way in as many cycles, whichever is more.
///
/// Not real-time; takes about 75 KiB of stack, 43 KiB in single precision.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_ARGUMENT` (plane or spacing).
///
/// # Safety
/// Pointers are null or point to what their types and sizes say, `plane` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_follow_start(
    follow: *mut Follow,
    follow_size: usize,
    plane: *const f64,
    spacing_mm: f64,
) -> Status {
    let work = || {
        let place = opaque::place(follow, follow_size)?;
        // SAFETY: the caller's promise.
        let plane = if plane.is_null() { [0.0, 0.0, 1.0] } else { unsafe { vector(plane) }? };
        let window = CommandWindow::new(plane, spacing_mm).map_err(|_| ERROR_ARGUMENT)?;
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, window) };
        Ok(())
    };
    status::of(work())
}

/// Forgets all commands, as after homing: the next one begins anew. Real-time safe.
///
/// `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`.
///
/// # Safety
/// `follow` is null or points to what its type says; nobody else uses it meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_follow_restart(follow: *mut Follow) -> Status {
    // SAFETY: the caller's promise.
    status::of(unsafe { opaque::content_mut(follow) }.map(CommandWindow::restart))
}

/// `trueaxis_step` with the commands themselves as the path: X, Y and Z of this cycle's command, once it is believed, are
/// appended to the window, and the contour errors are measured against that.
///
/// Arguments as there. While `record.tip.flags` lacks `TRUEAXIS_CONTOUR_BRACKETED` the tool is further behind than the
/// window reaches. In a bypass nothing is measured. Real-time safe.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_NO_OUTPUT`.
///
/// # Safety
/// Pointers are null or point to what their types say; nobody else uses state or window or writes any other of them
/// meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_step_following(
    r#loop: *const Loop,
    state: *mut State,
    input: *const Input,
    follow: *mut Follow,
    output: *mut Output,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        unsafe { check_sized(output) }?;
        // SAFETY: the caller's promise.
        let input = unsafe { read_sized(input) }?;
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
        // SAFETY: the caller's promise.
        let window = unsafe { opaque::content_mut(follow) }?;
        let result = with_servo!(built, running,
            servo(servo, state) => Output::of(&servo.step(state, &input.to_core(), &mut *window, ())),
            bypass(bypass) => Output::of(&bypass.step::<Real>(&input.to_core()))
        )?;
        // SAFETY: checked: aligned, of the right size; writable by the caller's promise.
        unsafe { result.deliver(output) }
    };
    status::of(work())
}
