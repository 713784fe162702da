//! A learned correction, and the id of the program that it belongs to.

use crate::Position;
use crate::error::{Error, explained};
use crate::opaque;
use crate::part::{DYNAMIC, need};
use crate::plugin::{CorePosition, from_core};
use crate::pointer::{check, slice};
use crate::result::{self, ERROR_ARGUMENT, ResultCode};
use trueaxis::Position as _;
use trueaxis::learned::{self, ProgramId};

/// Words of a `trueaxis_program_t`.
pub const PROGRAM_WORDS: usize = 4;
/// Words of a `trueaxis_learned_t`.
#[cfg(not(feature = "single"))]
pub const LEARNED_WORDS: usize = 12;
/// Words of a `trueaxis_learned_t`.
#[cfg(feature = "single")]
pub const LEARNED_WORDS: usize = 11;

/// The path of a program while its id is being computed.
#[repr(C)]
#[derive(Debug)]
pub struct Program {
    words: [u64; PROGRAM_WORDS],
}

/// A learned correction, read in place from the bytes of its file (`trueaxis learn`). Immutable; may be copied.
#[repr(C)]
#[derive(Debug)]
pub struct Learned {
    words: [u64; LEARNED_WORDS],
}

/// Starts computing the id of a program.
///
/// `length_mm`: length of its path. Not real-time. Errors: `_ARGUMENT` (not finite, negative).
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_program_start(
    program: *mut Program,
    program_size: usize,
    length_mm: f64,
) -> ResultCode {
    let work = || {
        need(DYNAMIC)?;
        let place = opaque::place(program, program_size)?;
        if !(0.0..=1e12).contains(&length_mm) {
            return Err(ERROR_ARGUMENT);
        }
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, ProgramId::new(length_mm)) };
        Ok(())
    };
    result::of(work())
}

/// Adds the next point of the path. Points are those at every whole mm of path length from 0, then the end.
///
/// `coordinates`: X, Y, Z in mm, A, B, C in degrees as the program commands them, 0 for an axis that the program does
/// not have. Not real-time. Errors: `_ARGUMENT` (not finite).
///
/// # Safety
/// Pointers are null or point to objects of their types, `coordinates` to six numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_program_point(program: *mut Program, coordinates: *const f64) -> ResultCode {
    let work = || {
        need(DYNAMIC)?;
        // SAFETY: the caller's promise.
        let (program, coordinates) = unsafe { (opaque::content_mut(program)?, slice(coordinates, 6)?) };
        let coordinates: [f64; 6] = coordinates.try_into().map_err(|_| ERROR_ARGUMENT)?;
        if !coordinates.iter().all(|x| x.is_finite()) {
            return Err(ERROR_ARGUMENT);
        }
        program.point(coordinates);
        Ok(())
    };
    result::of(work())
}

/// Writes the id of the program whose points were added. Another program can be started afterwards. Not real-time.
///
/// # Safety
/// Pointers are null or point to objects of their types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_program_id(program: *mut Program, id: *mut u32) -> ResultCode {
    let work = || {
        need(DYNAMIC)?;
        check(id)?;
        // SAFETY: the caller's promise.
        let points = core::mem::replace(unsafe { opaque::content_mut(program) }?, ProgramId::new(0.0));
        // SAFETY: checked; writable by the caller's promise.
        unsafe { id.write(points.finish()) };
        Ok(())
    };
    result::of(work())
}

/// Builds a learned correction from its file after checking the whole file, its machine and its program.
///
/// `file`, `length`: bytes of the file, read in place: they must outlive the correction and its copies, unchanged.
/// `machine_id`: the machine that the file must be for (`trueaxis_tables_info_t.machine_id`), 0: any. `program_id`,
/// `length_mm`: the program that is about to run; path lengths that differ by up to 1 µm count as equal. Not real-time.
///
/// Errors: `_LEARNED` (see `error->code`), `_MACHINE`, `_ARGUMENT` (length not finite).
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes; `file` remains valid as required above.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_learned_build(
    learned: *mut Learned,
    learned_size: usize,
    file: *const u8,
    length: usize,
    machine_id: u32,
    program_id: u32,
    length_mm: f64,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        need(DYNAMIC)?;
        let place = opaque::place(learned, learned_size)?;
        if !length_mm.is_finite() {
            return Err(ERROR_ARGUMENT.into());
        }
        // SAFETY: the caller's promise.
        let parsed = learned::Learned::parse(unsafe { slice(file, length) }?)?;
        if machine_id != 0 {
            parsed.expect_machine(machine_id)?;
        }
        parsed.expect_program(program_id, length_mm)?;
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, parsed) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Computes the correction at a path length, for `trueaxis_input_t.learned`: linear between nodes; 0 beyond the ends,
/// and for a length that is NaN.
///
/// `correction`: three positions. Real-time safe: bounded time.
///
/// # Safety
/// Pointers are null or point to objects of their types, `correction` to three positions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_learned_at(
    learned: *const Learned,
    length_mm: f64,
    correction: *mut Position,
) -> ResultCode {
    let work = || {
        need(DYNAMIC)?;
        check(correction)?;
        // SAFETY: the caller's promise.
        let found = unsafe { opaque::content(learned) }?.at(length_mm);
        let found = found.map(|x| from_core(CorePosition::default().moved(CorePosition::offset(x))));
        // SAFETY: checked; three writable positions by the caller's promise.
        unsafe { correction.cast::<[Position; 3]>().write(found) };
        Ok(())
    };
    result::of(work())
}
