//! Building and starting a servo loop.

use crate::Real;
use crate::axes::AXES_MAX;
use crate::built::{Built, Loop, State};
use crate::error::{Error, Refusal, explained};
use crate::opaque;
use crate::pointer::{apart, memory, slice};
use crate::result::{self, ERROR_ARGUMENT, ERROR_AXES, ResultCode};
use crate::tables::{loop_bytes, memory_bytes};
use core::ffi::c_void;
use trueaxis::Fault;
use trueaxis::machine::{GRIDS, GridData};
use trueaxis::tcomp::Tcomp;

/// Builds a loop from a compiled table file of 3 to 6 axes.
///
/// `file`, `length`: bytes of the `.tcomp`; the loop does not use them afterwards, since the nodes of grids are copied
/// into `memory`. `machine_id`: the machine that the file must be for, 0: any. `period_ns`: 1,000 to 100,000,000.
/// `memory`: at least `trueaxis_tables_info_t.memory_bytes`, 8-byte aligned; it must outlive the loop and its copies,
/// unchanged.
///
/// To exchange tables in motion, build a second loop in other memory and pass it to `trueaxis_step`; the limiter makes
/// the change smooth. Not real-time; 26 to 38 KiB of stack. After a refusal the loop is unchanged, but `memory` may
/// have been written: do not step a loop that was built in the same memory.
///
/// Errors: `_TABLES`, `_MACHINE`, `_CONFIG` (also the period), `_MEMORY`, `_ARGUMENT` (memory overlaps file or loop).
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes; `memory` remains valid as required above.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_loop_build(
    r#loop: *mut Loop,
    loop_size: usize,
    file: *const u8,
    length: usize,
    machine_id: u32,
    period_ns: u32,
    memory: *mut c_void,
    memory_size: usize,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        let place = opaque::place(r#loop, loop_size)?;
        let start = self::memory(memory, memory_size)?;
        // SAFETY: the caller's promise.
        let file = unsafe { slice(file, length) }?;
        let lent = (start.addr(), memory_size);
        if !apart(lent, (file.as_ptr().addr(), length)) || !apart(lent, (r#loop.addr(), loop_size)) {
            return Err(ERROR_ARGUMENT.into());
        }
        let mut tables = Tcomp::empty();
        tables.read(file)?;
        if machine_id != 0 {
            tables.expect_machine(machine_id)?;
        }
        let scalars = tables.requirement();
        let (numbers, bytes) = (memory_bytes(scalars), loop_bytes(&tables));
        if bytes > memory_size {
            return Err(Refusal::Memory(memory_size, bytes));
        }
        // SAFETY: as many bytes are lent, and ours alone by the caller's promise; after zeroing, every one of them is
        // part of a number.
        let (lent, behind) = unsafe {
            start.write_bytes(0, bytes);
            let behind = start.cast::<u8>().add(numbers);
            (
                core::slice::from_raw_parts_mut(start.cast::<Real>(), scalars),
                core::slice::from_raw_parts_mut(behind, bytes - numbers),
            )
        };
        let grids = copied(tables.grids(), behind);
        let grids = grids.get(..tables.grids().len()).unwrap_or_default();
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill_with(place, |built| Built::build_at(built, &tables, grids, period_ns, lent))? };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Copies the grids into the caller's memory, each in its stored size.
fn copied(grids: &[GridData<'_>], room: &'static mut [u8]) -> [GridData<'static>; GRIDS] {
    let mut copies = [GridData::default(); GRIDS];
    let mut rest = room;
    for (place, grid) in copies.iter_mut().zip(grids) {
        let [positions, nodes] = grid.stored_bytes();
        let Some((own, behind)) = rest.split_at_mut_checked(grid.size()) else { break };
        let stored = positions.iter().chain(nodes);
        own.iter_mut().zip(stored).for_each(|(to, from)| *to = *from);
        rest = behind;
        if let Some((copy, _)) = GridData::new(*grid.header(), own) {
            *place = copy;
        }
    }
    copies
}

/// Largest number of axes of a loop.
const MOST_AXES: u32 = if cfg!(all(feature = "rotary", not(feature = "three"))) { AXES_MAX as u32 } else { 3 };

/// Builds a loop that passes every command uncorrected and reports the reason in every record, for operation without
/// tables.
///
/// `axes`: 3 to 6; 3 in a library for three axes only. `reason`: `TRUEAXIS_FAULT_PERIOD_MISMATCH`, `_TABLES_REFUSED`,
/// `_CAPACITY_TOO_SMALL` or `_ABI_MISMATCH`. `period_ns`: 1,000 to 100,000,000. After an invalid command the loop holds
/// the last valid one (before the first: the position read), and requests a stop until the next valid one.
///
/// Real-time safe. Errors: `_AXES`, `_ARGUMENT` (reason, period).
///
/// # Safety
/// `loop` is null or points to an object of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_loop_bypass(
    r#loop: *mut Loop,
    loop_size: usize,
    axes: u32,
    reason: u8,
    period_ns: u32,
) -> ResultCode {
    let work = || {
        let place = opaque::place(r#loop, loop_size)?;
        if !(3..=MOST_AXES).contains(&axes) {
            return Err(ERROR_AXES);
        }
        let reason = match Fault::try_from(reason) {
            Ok(reason) if reason.refuses() && (1_000..=100_000_000).contains(&period_ns) => reason,
            _ => return Err(ERROR_ARGUMENT),
        };
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, Built::bypass(axes as usize, reason, period_ns)) };
        Ok(())
    };
    result::of(work())
}

/// Starts a new state for a loop, if the host's period is that of the loop within 0.1 %.
///
/// Real-time safe. Errors: `_PERIOD`.
///
/// # Safety
/// Pointers are null or point to objects of their types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_start(
    r#loop: *const Loop,
    state: *mut State,
    state_size: usize,
    period_ns: u32,
) -> ResultCode {
    let work = || {
        let place = opaque::place(state, state_size)?;
        // SAFETY: the caller's promise.
        let running = unsafe { opaque::content(r#loop) }?.start(period_ns)?;
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, running) };
        Ok(())
    };
    result::of(work())
}
