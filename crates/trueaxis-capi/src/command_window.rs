//! The last commands, used as the path.

use crate::opaque;
use crate::plugin::Window;
use crate::pointer::vector;
use crate::result::{self, ERROR_ARGUMENT, ResultCode};
use crate::steps::{WindowStep, window_step};

/// Number of spans in a `trueaxis_command_window_t`.
pub const COMMAND_WINDOW_SPANS: usize = 64;
/// Words of a `trueaxis_command_window_t`.
#[cfg(not(feature = "single"))]
pub const COMMAND_WINDOW_WORDS: usize = 4864;
/// Words of a `trueaxis_command_window_t`.
#[cfg(feature = "single")]
pub const COMMAND_WINDOW_WORDS: usize = 2784;

/// The last commanded points, used as the path by a host that does not know the programmed one. Belongs to the thread
/// that steps it.
#[repr(C)]
#[derive(Debug)]
pub struct CommandWindow {
    words: [u64; COMMAND_WINDOW_WORDS],
}

/// Content of a [`CommandWindow`].
pub(crate) struct Commands {
    pub(crate) step: WindowStep,
    pub(crate) commands: Window,
}

/// Starts an empty window.
///
/// `plane`: normal of the machining plane, three numbers; `NULL`: 0, 0, 1 (G17). `spacing_mm`: distance between two
/// points at slow feeds, 0.001 to 1 mm, usually 0.005 mm. The window must be longer than the tool's lag. Its length is
/// the larger of `TRUEAXIS_COMMAND_WINDOW_SPANS` spacings and the distance travelled in that many cycles. If the lag
/// exceeds it, `record.tip.flags` lacks `TRUEAXIS_CONTOUR_BRACKETED`.
///
/// Not real-time; about 75 KiB of stack, 43 KiB in single precision. Errors: `_ARGUMENT`.
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes, `plane` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_command_window_start(
    window: *mut CommandWindow,
    window_size: usize,
    plane: *const f64,
    spacing_mm: f64,
) -> ResultCode {
    let work = || {
        let place = opaque::place(window, window_size)?;
        // SAFETY: the caller's promise.
        let plane = if plane.is_null() { [0.0, 0.0, 1.0] } else { unsafe { vector(plane) }? };
        let commands = Window::new(plane, spacing_mm).map_err(|_| ERROR_ARGUMENT)?;
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, Commands { step: window_step, commands }) };
        Ok(())
    };
    result::of(work())
}

/// Discards all commands, for example after homing. Real-time safe.
///
/// # Safety
/// `window` is null or points to an object of its type; nobody else uses it during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_command_window_restart(window: *mut CommandWindow) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { opaque::content_mut(window) }.map(|window| window.commands.restart()))
}
