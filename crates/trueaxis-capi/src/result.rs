//! Result codes.

use crate::text::TEXT;
use core::ffi::{CStr, c_char};

/// Result code of a function: `TRUEAXIS_OK` or one of `TRUEAXIS_ERROR_…`, never negative.
pub type ResultCode = i32;

/// The function succeeded.
pub const OK: ResultCode = 0;
/// A required pointer is `NULL`.
pub const ERROR_NULL: ResultCode = 1;
/// Wrong `size` member or size argument: not set, from another header, or `TRUEAXIS_SINGLE` is not as the library was
/// built.
pub const ERROR_SIZE: ResultCode = 2;
/// A pointer is not aligned. Memory for tables and paths needs 8 bytes.
pub const ERROR_ALIGNMENT: ResultCode = 3;
/// An object was never built or started, or is of another kind.
pub const ERROR_UNBUILT: ResultCode = 4;
/// Header and library differ in version or precision.
pub const ERROR_ABI: ResultCode = 5;
/// Not a whole, undamaged `.tcomp` file of this format; see `trueaxis_error_t`.
pub const ERROR_TABLES: ResultCode = 6;
/// The file, the kinematics, the learned correction or the thermal growth belong to another machine.
pub const ERROR_MACHINE: ResultCode = 7;
/// The settings are not valid; see `trueaxis_error_t`.
pub const ERROR_CONFIG: ResultCode = 8;
/// The lent memory is too small.
pub const ERROR_MEMORY: ResultCode = 9;
/// The period differs from that of the loop by more than 0.1 %.
pub const ERROR_PERIOD: ResultCode = 10;
/// Loop and state differ in the number of axes, or the number is not 3 to 6.
pub const ERROR_AXES: ResultCode = 11;
/// The state was started by a loop of the other kind (bypass or not): start a new one.
pub const ERROR_STATE: ResultCode = 12;
/// An argument is out of range; the description of the function lists the conditions.
pub const ERROR_ARGUMENT: ResultCode = 13;
/// The buffer is too small.
pub const ERROR_BUFFER: ResultCode = 14;
/// The segment is not valid; see `trueaxis_error_t`.
pub const ERROR_PATH: ResultCode = 15;
/// The machine has no gauge, or one with another number of points.
pub const ERROR_GAUGE: ResultCode = 16;
/// No value is available yet.
pub const ERROR_NOT_YET: ResultCode = 17;
/// The cycle was executed, but has no drive positions: no valid command has come, and not every axis has been read. The
/// whole output except `drive` is written. Leave the drives without power.
pub const ERROR_NO_OUTPUT: ResultCode = 18;
/// The kinematics cannot reach the pose; see `trueaxis_error_t`.
pub const ERROR_POSE: ResultCode = 19;
/// Not a whole, undamaged learned correction of this format, or one of another program; see `trueaxis_error_t`.
pub const ERROR_LEARNED: ResultCode = 20;

/// Not a whole, undamaged `.ttherm` file of this format; see `trueaxis_error_t`.
pub const ERROR_THERMAL: ResultCode = 21;

/// The function, or a setting of the table file, needs a part that this build of the library leaves out; see
/// `trueaxis_error_t`.
pub const ERROR_LEFT_OUT: ResultCode = 22;

pub(crate) fn text(result: ResultCode) -> &'static CStr {
    if !TEXT {
        return c"";
    }
    match result {
        OK => c"done",
        ERROR_NULL => c"a required pointer is NULL",
        ERROR_SIZE => c"a size is not the one that this library needs (member size, size argument, TRUEAXIS_SINGLE)",
        ERROR_ALIGNMENT => c"a pointer is not aligned as its type needs (memory: 8 bytes)",
        ERROR_UNBUILT => c"an object was never built or started, or is of another kind",
        ERROR_ABI => c"header and library differ in version or precision",
        ERROR_TABLES => c"the table file is refused: damaged, cut off, or not a .tcomp of this format",
        ERROR_MACHINE => {
            c"the table file, the kinematics, the learned correction or the thermal growth are of another machine"
        }
        ERROR_CONFIG => c"the settings are refused",
        ERROR_MEMORY => c"the lent memory is too small",
        ERROR_PERIOD => c"the period is not the one that the loop was built for",
        ERROR_AXES => c"loop and state have different numbers of axes, or the number is not 3 to 6",
        ERROR_STATE => c"the state was started by a loop of the other kind (bypass or not): start a new one",
        ERROR_ARGUMENT => c"an argument is out of range",
        ERROR_BUFFER => c"the buffer is too small",
        ERROR_PATH => c"the segment is not valid",
        ERROR_GAUGE => c"the machine has no gauge, or one of another number of points",
        ERROR_NOT_YET => c"no value is available yet",
        ERROR_NO_OUTPUT => c"no output: no valid command has come, and not every axis has been read",
        ERROR_POSE => c"the kinematics have no such pose",
        ERROR_LEARNED => {
            c"the learned correction is refused: damaged, cut off, not of this format, or of another program"
        }
        ERROR_THERMAL => c"the file of thermal growth is refused: damaged, cut off, or not a .ttherm of this format",
        ERROR_LEFT_OUT => c"it needs a part that this build of the library leaves out",
        _ => c"not a result of this library",
    }
}

/// Returns the text of a result: a constant string for any number, empty in a build without the part `text`. Real-time
/// safe.
#[unsafe(no_mangle)]
pub extern "C" fn trueaxis_result_text(result: ResultCode) -> *const c_char {
    text(result).as_ptr()
}

/// Converts a result to its code.
#[inline(always)]
pub(crate) fn of(result: Result<(), ResultCode>) -> ResultCode {
    match result {
        Ok(()) => OK,
        Err(code) => code,
    }
}
