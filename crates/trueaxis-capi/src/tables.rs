//! Contents of a compiled table file, and the memory that it needs.

use crate::Real;
use crate::axes::AXES_MAX;
use crate::error::{Error, Refusal, explained};
use crate::pointer::{Sized32, check_sized, slice};
use crate::text::Text;
use core::ffi::c_char;
use trueaxis::machine::{Axis, AxisSettings, GridData};
use trueaxis::tcomp::Tcomp;

/// Contents of a table file. Arrays have `axes` elements in the step's order. For a linear axis that the machine lacks,
/// travel and limits are 0, and its command passes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct TablesInfo {
    /// `sizeof(trueaxis_tables_info_t)`.
    pub size: u32,
    /// Number of axes of the step, 3 to 6.
    pub axes: u32,
    /// Letters of the axes, terminated by 0: X, Y, Z, then the machine's rotary axes in alphabetical order.
    pub letters: [c_char; 8],
    /// Identity of the machine: CRC-32 of its name and chain.
    pub machine_id: u32,
    /// CRC-32 of the file, which identifies the version of the tables.
    pub tables_crc: u32,
    /// Number of passes of the exact inverse per cycle.
    pub inverse_passes: u32,
    /// Points per revolution of the gauge; 0 without a gauge.
    pub gauge_points: u32,
    /// Bytes of memory that `trueaxis_loop_build` needs.
    pub memory_bytes: u64,
    /// Number of rows in the axis' table; 0 without a table.
    pub rows: [u32; AXES_MAX],
    /// Low end of the travel, mm (deg). A command outside the travel is a fault.
    pub travel_low: [f64; AXES_MAX],
    /// High end of the travel, mm (deg).
    pub travel_high: [f64; AXES_MAX],
    /// Limit of the correction, mm (deg).
    pub correction_limit: [f64; AXES_MAX],
    /// Limit of the correction's rate, mm/s (deg/s).
    pub slope_limit_per_s: [f64; AXES_MAX],
    /// Limit of the correction's acceleration, mm/s² (deg/s²).
    pub acceleration_limit_per_s2: [f64; AXES_MAX],
    /// Name of the machine, UTF-8, terminated by 0.
    pub name: [c_char; 72],
    /// Structural code of the machine (ISO 10791-6), terminated by 0.
    pub chain: [c_char; 56],
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for TablesInfo {}

/// Checks a whole table file and describes its contents.
///
/// `file`: of any alignment. Not real-time; about 12 KiB of stack. Errors: `_TABLES` (see `error->code`).
///
/// # Safety
/// Pointers are null or point to objects of their types, `file` to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_tables_info(
    file: *const u8,
    length: usize,
    info: *mut TablesInfo,
    error: *mut Error,
) -> crate::ResultCode {
    let work = || {
        // SAFETY: the caller's promise.
        unsafe { check_sized(info) }?;
        // SAFETY: the caller's promise.
        let file = unsafe { slice(file, length) }?;
        let mut tables = Tcomp::empty();
        tables.read(file)?;
        let contents = TablesInfo::of(&tables)?;
        // SAFETY: checked: aligned, of the right size; writable by the caller's promise.
        unsafe { info.write(contents) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Number of axes of a step with these tables.
pub(crate) fn axes_of(tables: &Tcomp<'_>) -> usize {
    tables.slots().count()
}

/// The axes of the step in order, with their settings (`None` for an axis that the machine lacks).
pub(crate) fn slots<'t>(tables: &'t Tcomp<'_>) -> impl Iterator<Item = (Axis, Option<&'t AxisSettings>)> {
    tables.slots().map(|axis| (axis, tables.settings().axis(axis)))
}

/// Bytes of memory that a loop needs: its scalars, then the nodes of the grids, so that the file may be discarded.
pub(crate) fn loop_bytes(tables: &Tcomp<'_>) -> usize {
    memory_bytes(tables.requirement()).saturating_add(tables.grids().iter().map(GridData::size).sum())
}

/// Bytes of so many scalars.
pub(crate) fn memory_bytes(scalars: usize) -> usize {
    scalars.saturating_mul(size_of::<Real>())
}

impl TablesInfo {
    fn of(tables: &Tcomp<'_>) -> Result<Self, Refusal> {
        let settings = tables.settings();
        let mut info = TablesInfo {
            size: size_of::<TablesInfo>() as u32,
            axes: axes_of(tables) as u32,
            letters: [0; _],
            machine_id: tables.machine_id(),
            tables_crc: tables.crc(),
            inverse_passes: tables.inverse_passes().into(),
            gauge_points: settings.roundness.as_ref().map_or(0, |gauge| gauge.points.into()),
            memory_bytes: loop_bytes(tables) as u64,
            rows: [0; _],
            travel_low: [0.0; _],
            travel_high: [0.0; _],
            correction_limit: [0.0; _],
            slope_limit_per_s: [0.0; _],
            acceleration_limit_per_s2: [0.0; _],
            name: Text::copied(&settings.name),
            chain: Text::copied(&settings.chain),
        };
        fn put<T>(list: &mut [T], slot: usize, value: T) {
            if let Some(element) = list.get_mut(slot) {
                *element = value;
            }
        }
        for (slot, (axis, settings)) in slots(tables).enumerate() {
            put(&mut info.letters, slot, axis.letter() as c_char);
            put(&mut info.rows, slot, tables.table(axis).map_or(0, |table| table.len() as u32));
            let Some(settings) = settings else { continue };
            put(&mut info.travel_low, slot, settings.travel[0]);
            put(&mut info.travel_high, slot, settings.travel[1]);
            put(&mut info.correction_limit, slot, settings.limits.magnitude);
            put(&mut info.slope_limit_per_s, slot, settings.limits.slope_per_s);
            put(&mut info.acceleration_limit_per_s2, slot, settings.limits.acceleration_per_s2);
        }
        Ok(info)
    }
}
