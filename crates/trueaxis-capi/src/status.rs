//! What a function answers.

use core::ffi::{CStr, c_char};

/// Answer of a function: `TRUEAXIS_OK` or one of `TRUEAXIS_ERROR_…`, never negative. `trueaxis_status_text` has words
/// for each.
pub type Status = i32;

/// Done.
pub const OK: Status = 0;
/// A pointer that must be given is `NULL`.
pub const ERROR_NULL: Status = 1;
/// A structure or buffer has another size than this library needs: check `size` members and size arguments, that the
/// header belongs to the library, and that `TRUEAXIS_SINGLE` is defined for a single-precision library and for no other.
pub const ERROR_SIZE: Status = 2;
/// A pointer is not aligned as its type needs; memory for tables and paths: 8 bytes.
pub const ERROR_ALIGNMENT: Status = 3;
/// An object was never built or started, or is of another kind.
pub const ERROR_UNBUILT: Status = 4;
/// Header and library are of different versions or of different precision.
pub const ERROR_ABI: Status = 5;
/// The bytes are not a whole, undamaged `.tcomp` file of this format; details in `trueaxis_error_t`.
pub const ERROR_TABLES: Status = 6;
/// The file is made for another machine.
pub const ERROR_MACHINE: Status = 7;
/// What the file describes cannot be run with this configuration; details in `trueaxis_error_t`.
pub const ERROR_CONFIG: Status = 8;
/// The memory lent is smaller than needed (`trueaxis_tables_info_t.memory_bytes`).
pub const ERROR_MEMORY: Status = 9;
/// The period is not the one that the loop was built for (within 0.1 %).
pub const ERROR_PERIOD: Status = 10;
/// Loop and state have different numbers of axes, or the number is not 3 to 6.
pub const ERROR_AXES: Status = 11;
/// The state was started by a loop of the other kind (bypass or not): start a new one.
pub const ERROR_STATE: Status = 12;
/// An argument is out of its range; the function says which.
pub const ERROR_ARGUMENT: Status = 13;
/// The buffer is smaller than what is to be written.
pub const ERROR_BUFFER: Status = 14;
/// The segment is no path; details in `trueaxis_error_t`.
pub const ERROR_PATH: Status = 15;
/// The machine file has no gauge (no `[roundness]` section), or one of another number of points.
pub const ERROR_GAUGE: Status = 16;
/// There is no value yet.
pub const ERROR_NOT_YET: Status = 17;
/// The cycle was done, but there is nothing to write to the drives: no usable command has ever come, and not every axis
/// has been read. `drive` is left as it was; the rest of the output is written. Leave the drives without power.
pub const ERROR_NO_OUTPUT: Status = 18;

pub(crate) fn text(status: Status) -> &'static CStr {
    match status {
        OK => c"done",
        ERROR_NULL => c"a pointer that must be given is NULL",
        ERROR_SIZE => c"a size is not the one that this library needs (member size, size argument, TRUEAXIS_SINGLE)",
        ERROR_ALIGNMENT => c"a pointer is not aligned as its type needs (memory: 8 bytes)",
        ERROR_UNBUILT => c"an object was never built or started, or is of another kind",
        ERROR_ABI => c"header and library are of different versions or of different precision",
        ERROR_TABLES => c"the table file is refused: damaged, cut off, or not a .tcomp of this format",
        ERROR_MACHINE => c"the table file is made for another machine",
        ERROR_CONFIG => c"the configuration is refused",
        ERROR_MEMORY => c"the memory lent is smaller than needed",
        ERROR_PERIOD => c"the period is not the one that the loop was built for",
        ERROR_AXES => c"loop and state have different numbers of axes, or the number is not 3 to 6",
        ERROR_STATE => c"the state was started by a loop of the other kind (bypass or not): start a new one",
        ERROR_ARGUMENT => c"an argument is out of its range",
        ERROR_BUFFER => c"the buffer is smaller than what is to be written",
        ERROR_PATH => c"the segment is no path",
        ERROR_GAUGE => c"the machine has no gauge, or one of another number of points",
        ERROR_NOT_YET => c"there is no value yet",
        ERROR_NO_OUTPUT => c"no output: no usable command has ever come, and not every axis has been read",
        _ => c"not a status of this library",
    }
}

/// Words for a status: a constant string, never `NULL`, for any number.
///
/// Real-time safe.
#[unsafe(no_mangle)]
pub extern "C" fn trueaxis_status_text(status: Status) -> *const c_char {
    text(status).as_ptr()
}

/// The status of a result.
#[inline(always)]
pub(crate) fn of(result: Result<(), Status>) -> Status {
    match result {
        Ok(()) => OK,
        Err(status) => status,
    }
}
