//! Thermal growth from temperatures, computed by a separate task.

use crate::built::{Loop, State, with_servo};
use crate::error::{Error, explained};
use crate::opaque;
use crate::part::{GROWTH, need};
use crate::pointer::{Sized32, check_sized, read_sized, slice};
use crate::result::{self, ERROR_ARGUMENT, ERROR_AXES, ResultCode};
use trueaxis::Axis;
use trueaxis::temperature::{self, Readings, SENSORS, ThermalState};

/// Largest number of sensors of a `.ttherm` file.
pub const THERMAL_SENSORS_MAX: usize = 16;
/// Words of a `trueaxis_thermal_t`.
pub const THERMAL_WORDS: usize = 10;
/// Words of a `trueaxis_thermal_state_t`.
pub const THERMAL_STATE_WORDS: usize = 176;

const _: () = assert!(THERMAL_SENSORS_MAX == SENSORS);

/// The sensor is good.
pub const SENSOR_GOOD: u8 = 0;
/// The sensor has no reading, or one that is not a number.
pub const SENSOR_MISSING: u8 = 1;
/// The reading is outside the plausible range, or jumped to exactly 85 or 0 degrees Celsius, which mean no reading.
pub const SENSOR_OUT_OF_RANGE: u8 = 2;
/// The reading changed by more than is plausible, and has neither returned since nor remained at its new value for an
/// hour.
pub const SENSOR_JUMPED: u8 = 3;
/// The sensor repeats one reading to the bit although the others change.
pub const SENSOR_STUCK: u8 = 4;
/// The sensor has not yet given three plausible readings that agree, spread over at least two seconds.
pub const SENSOR_STARTING: u8 = 5;

/// Thermal growth, read in place from the bytes of its file (`trueaxis thermal compile`). Immutable; may be copied.
#[repr(C)]
#[derive(Debug)]
pub struct Thermal {
    words: [u64; THERMAL_WORDS],
}

/// State that one update of the task passes to the next. Belongs to the thread that updates it.
#[repr(C)]
#[derive(Debug)]
pub struct ThermalTask {
    words: [u64; THERMAL_STATE_WORDS],
}

/// Readings for one update.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThermalReadings {
    /// `sizeof(trueaxis_thermal_readings_t)`.
    pub size: u32,
    /// Number of temperatures, at most 16; further sensors of the file count as missing.
    pub count: u32,
    /// Time since the previous update, s; 0 in the first.
    pub dt_s: f64,
    /// Temperatures in the order of the file, degrees Celsius; NaN for a missing reading.
    pub temperatures_c: [f64; THERMAL_SENSORS_MAX],
    /// Speed of the spindle, rpm; NaN if unknown.
    pub spindle_rpm: f64,
    /// Length of the tool from the spindle's nose, mm.
    pub tool_mm: f64,
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for ThermalReadings {}

/// Growth after an update. Arrays over axes are in the order X, Y, Z, A, B, C.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// `sizeof(trueaxis_growth_t)`.
    pub size: u32,
    /// Axes that the file names, as bits (bit 0: X).
    pub axes: u32,
    /// Offset of the line, mm (deg). It is an error that is added, actual − ideal.
    pub offset: [f64; 6],
    /// Slope of the line, from the datum of the machine's table file.
    pub slope: [f64; 6],
    /// `TRUEAXIS_SENSOR_…` of every sensor. The contribution of a sensor does not change while it is not good.
    pub sensors: [u8; THERMAL_SENSORS_MAX],
    /// Sensors beyond the ends of their curves, where the edge value applies, as bits (bit 0: the first sensor).
    pub at_edge: u32,
    /// Axes whose growth exceeds the range of the step, as bits (bit 0: X); the previous line remains in force.
    pub beyond: u32,
    /// 1: every sensor has started. Until then the growth is zero.
    pub complete: u8,
    /// 1: the spindle's speed is unknown; its contribution does not change.
    pub spindle_missing: u8,
    /// 1: every sensor and the spindle's speed are good, and the step accepts every growth.
    pub good: u8,
    /// 0.
    pub reserved: [u8; 5],
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Growth {}

/// Builds thermal growth from a `.ttherm` file after checking the whole file and its machine.
///
/// `file`, `length`: bytes of the file, read in place: they must outlive the growth and its copies, unchanged.
/// `machine_id`: the machine that the file must be for (`trueaxis_tables_info_t.machine_id`), 0: any. `sensors`:
/// receives the number of sensors; may be `NULL`. Not real-time.
///
/// Errors: `_THERMAL` (see `error->code`), `_MACHINE`.
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes; `file` remains valid as required above.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_thermal_build(
    thermal: *mut Thermal,
    thermal_size: usize,
    file: *const u8,
    length: usize,
    machine_id: u32,
    sensors: *mut u32,
    error: *mut Error,
) -> ResultCode {
    let work = || {
        need(GROWTH)?;
        let place = opaque::place(thermal, thermal_size)?;
        if !sensors.is_null() {
            crate::pointer::check(sensors)?;
        }
        // SAFETY: the caller's promise.
        let parsed = temperature::Thermal::parse(unsafe { slice(file, length) }?)?;
        if machine_id != 0 {
            parsed.expect_machine(machine_id)?;
        }
        // SAFETY: storage of the size that the caller vouched for; a checked pointer that is writable by its promise.
        unsafe {
            opaque::fill(place, parsed);
            if !sensors.is_null() {
                sensors.write(parsed.sensors() as u32);
            }
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

/// Starts the task: in equilibrium with the first readings, as after a long standstill of the spindle. Not real-time.
///
/// # Safety
/// Pointers are null or point to objects of their types and stated sizes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_thermal_start(task: *mut ThermalTask, task_size: usize) -> ResultCode {
    let work = || {
        need(GROWTH)?;
        let place = opaque::place(task, task_size)?;
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, ThermalState::new()) };
        Ok(())
    };
    result::of(work())
}

/// Computes the growth from readings. Call it about once a second.
///
/// Readings are assumed to be linear in time since the previous update. Bounded time, about 16 exponentials: real-time
/// safe, but preferably called from a slower task. Errors: `_ARGUMENT` (count).
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else uses `task` during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_thermal_update(
    thermal: *const Thermal,
    task: *mut ThermalTask,
    readings: *const ThermalReadings,
    growth: *mut Growth,
) -> ResultCode {
    let work = || {
        need(GROWTH)?;
        // SAFETY: the caller's promise.
        unsafe { check_sized(growth) }?;
        // SAFETY: the caller's promise.
        let given = unsafe { read_sized(readings) }?;
        // SAFETY: the caller's promise.
        let (thermal, task) = unsafe { (opaque::content(thermal)?, opaque::content_mut(task)?) };
        let temperatures = given.temperatures_c.map(Some);
        let now = Readings {
            temperatures_c: temperatures.get(..given.count as usize).ok_or(ERROR_ARGUMENT)?,
            spindle_rpm: Some(given.spindle_rpm),
            tool_mm: given.tool_mm,
        };
        let found = Growth::of(&thermal.update(task, given.dt_s, &now));
        // SAFETY: checked: aligned, of the right size; writable by the caller's promise.
        unsafe { growth.write(found) };
        Ok(())
    };
    result::of(work())
}

/// Accepts the next reading of a sensor (numbered from 0) that has jumped, for example after it was replaced. Real-time
/// safe. Errors: `_ARGUMENT` (no such sensor).
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else uses `task` during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_thermal_believe(task: *mut ThermalTask, sensor: u32) -> ResultCode {
    let work = || {
        need(GROWTH)?;
        // SAFETY: the caller's promise.
        let task = unsafe { opaque::content_mut(task) }?;
        if sensor as usize >= SENSORS {
            return Err(ERROR_ARGUMENT);
        }
        task.accept(sensor as usize);
        Ok(())
    };
    result::of(work())
}

/// Sets the growth of all axes that it names. The growth acts from the next cycle on, through the limiter, and replaces
/// the one set by `trueaxis_set_thermal`: use only one of the two functions. Call it between two cycles. No effect in a
/// bypass. Axes that the step does not have are ignored. Real-time safe. Errors: `_AXES`, `_STATE`, `_ARGUMENT` (growth
/// of more than 10 mm or 1e-3 of the length).
///
/// # Safety
/// Pointers are null or point to objects of their types; nobody else uses `state` during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_set_growth(
    r#loop: *const Loop,
    state: *mut State,
    growth: *const Growth,
) -> ResultCode {
    let work = || {
        need(GROWTH)?;
        // SAFETY: the caller's promise.
        let growth = unsafe { read_sized(growth) }?;
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
        if built.servo.axes() != running.axes() {
            return Err(ERROR_AXES);
        }
        let mut lines = [None; 6];
        for ((axis, line), (offset, slope)) in
            Axis::ALL.into_iter().zip(&mut lines).zip(growth.offset.into_iter().zip(growth.slope))
        {
            if growth.axes >> axis.index() & 1 == 1 {
                let own = trueaxis::compensation::ThermalLine::new(offset, slope).ok_or(ERROR_ARGUMENT)?;
                *line = built.slot(axis).map(|slot| (slot, own));
            }
        }
        for (slot, line) in lines.into_iter().flatten() {
            with_servo!(built, &mut *running,
                servo(_servo, state) => state.set_thermal(slot, line).map_err(|_| ERROR_ARGUMENT),
                bypass(_) => Ok(())
            )??;
        }
        Ok(())
    };
    result::of(work())
}

impl Growth {
    fn of(found: &temperature::Growth) -> Growth {
        let mut growth = Growth {
            size: size_of::<Growth>() as u32,
            axes: 0,
            offset: [0.0; 6],
            slope: [0.0; 6],
            sensors: found.sensors.map(|status| status as u8),
            at_edge: found.at_edge.into(),
            beyond: found.beyond.into(),
            complete: found.complete.into(),
            spindle_missing: found.spindle_missing.into(),
            good: found.is_good().into(),
            reserved: [0; 5],
        };
        let places = growth.offset.iter_mut().zip(&mut growth.slope).zip(found.lines);
        for (axis, ((offset, slope), line)) in places.enumerate() {
            if let Some(line) = line {
                growth.axes |= 1 << axis;
                [*offset, *slope] = line;
            }
        }
        growth
    }
}
