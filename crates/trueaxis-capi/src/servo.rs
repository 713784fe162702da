//! The servo loop: tables in force, state, cycle.

use crate::Real;
use crate::cycle::{AXES_MAX, Input, Output, Reference};
use crate::error::{Error, Refusal, explained};
use crate::opaque::{self, Storage};
use crate::path::{self, Path};
use crate::plugin::{CorePosition, Servo, ServoState};
use crate::pointer::{apart, check_sized, memory, read_sized, slice};
use crate::status::{self, ERROR_ARGUMENT, ERROR_AXES, ERROR_PERIOD, Status};
use crate::tables::{axes_of, memory_bytes};
use core::ffi::c_void;
use trueaxis::compensation::ThermalLine;
use trueaxis::machine::ThermalGrowth;
use trueaxis::tcomp::Tcomp;
use trueaxis::{Bypass, ConfigError, Fault};

/// Words of a `trueaxis_loop_t`.
#[cfg(not(feature = "single"))]
pub const LOOP_WORDS: usize = 368;
/// Words of a `trueaxis_loop_t`.
#[cfg(feature = "single")]
pub const LOOP_WORDS: usize = 240;
/// Words of a `trueaxis_state_t`.
#[cfg(not(feature = "single"))]
pub const STATE_WORDS: usize = 104;
/// Words of a `trueaxis_state_t`.
#[cfg(feature = "single")]
pub const STATE_WORDS: usize = 64;

/// The immutable half: tables, limits and settings of a machine, built once. May be copied and read from any thread.
#[repr(C)]
#[derive(Debug)]
pub struct Loop {
    words: [u64; LOOP_WORDS],
}

/// The mutable half: what one cycle hands to the next. Belongs to the thread that steps it; a copy taken between two cycles
/// may be put back, as if the cycles since had not been.
#[repr(C)]
#[derive(Debug)]
pub struct State {
    words: [u64; STATE_WORDS],
}

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for Loop {
    type Content = Built;
    const MAGIC: u32 = 0x5452_0001;
}

// SAFETY: repr(C), one array of u64.
unsafe impl Storage for State {
    type Content = Running;
    const MAGIC: u32 = 0x5452_0002;
}

/// What a `trueaxis_loop_t` holds.
pub(crate) struct Built {
    pub(crate) servo: AnyServo,
    period_ns: u32,
    /// Thermal growth of the axes, in the order of the step.
    growth: [ThermalGrowth; AXES_MAX],
}

/// A servo loop of any number of axes.
#[allow(clippy::large_enum_variant)] // storage has the size of the largest anyway
pub(crate) enum AnyServo {
    Three(Servo<3>),
    Four(Servo<4>),
    Five(Servo<5>),
    Six(Servo<6>),
    /// Commands pass uncorrected.
    Bypass {
        axes: usize,
        reason: Fault,
    },
}

/// What a `trueaxis_state_t` holds.
#[allow(clippy::large_enum_variant)] // as above
pub(crate) enum Running {
    Three(ServoState<3>),
    Four(ServoState<4>),
    Five(ServoState<5>),
    Six(ServoState<6>),
    BypassThree(Bypass<CorePosition, 3>),
    BypassFour(Bypass<CorePosition, 4>),
    BypassFive(Bypass<CorePosition, 5>),
    BypassSix(Bypass<CorePosition, 6>),
}

impl AnyServo {
    pub(crate) fn axes(&self) -> usize {
        match self {
            AnyServo::Three(_) => 3,
            AnyServo::Four(_) => 4,
            AnyServo::Five(_) => 5,
            AnyServo::Six(_) => 6,
            AnyServo::Bypass { axes, .. } => *axes,
        }
    }
}

impl Running {
    pub(crate) fn axes(&self) -> usize {
        match self {
            Running::Three(_) | Running::BypassThree(_) => 3,
            Running::Four(_) | Running::BypassFour(_) => 4,
            Running::Five(_) | Running::BypassFive(_) => 5,
            Running::Six(_) | Running::BypassSix(_) => 6,
        }
    }
}

/// Builds a servo loop from a compiled table file: 3 to 6 axes, as the file says.
///
/// `loop`, `loop_size`: the caller's, `sizeof(trueaxis_loop_t)`. `file`, `length`: the bytes of the `.tcomp`; may be freed
/// afterwards. `machine_id`: the machine that the file must be for (`trueaxis_tables_info_t.machine_id`); 0 takes any.
/// `period_ns`: servo period, 1,000 to 100,000,000 ns. `memory`, `memory_size`: for the tables, 8-byte aligned, at least
/// `trueaxis_tables_info_t.memory_bytes`; the caller's, must outlive every use of the loop and of its copies, and nobody
/// may write to it in that time. `error`: may be `NULL`; written only on refusal.
///
/// To exchange tables in motion, build another loop in other memory and pass that to `trueaxis_step` from some cycle on;
/// the limiter leads the correction over, nothing jumps. The old loop's memory is free from then on.
///
/// Not real-time: time linear in the file's length; takes about 17 KiB of stack. On refusal the loop stays as it was, but
/// `memory` may have been written to.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_TABLES`, `_MACHINE`, `_CONFIG` (also: a period out of range),
/// `_MEMORY`, `_ARGUMENT` (memory overlaps file or loop).
///
/// # Safety
/// Pointers are null or point to what their types and sizes say; `memory` stays as demanded above.
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
) -> Status {
    let work = || {
        let place = opaque::place(r#loop, loop_size)?;
        let start = self::memory(memory, memory_size)?;
        // SAFETY: the caller's promise.
        let file = unsafe { slice(file, length) }?;
        let lent = (start.addr(), memory_size);
        if !apart(lent, (file.as_ptr().addr(), length)) || !apart(lent, (r#loop.addr(), loop_size)) {
            return Err(ERROR_ARGUMENT.into());
        }
        let tables = Tcomp::parse(file)?;
        if machine_id != 0 {
            tables.expect_machine(machine_id)?;
        }
        let need = tables.requirement();
        let bytes = memory_bytes(&tables);
        if bytes > memory_size {
            return Err(Refusal::Memory(memory_size, bytes));
        }
        // SAFETY: as many bytes are lent, and ours alone by the caller's promise; after zeroing every one of them is part
        // of a number.
        let lent = unsafe {
            start.write_bytes(0, bytes);
            core::slice::from_raw_parts_mut(start.cast::<Real>(), need)
        };
        let built = Built::new(&tables, period_ns, lent)?;
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, built) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, work) }
}

impl Built {
    fn new(tables: &Tcomp<'_>, period_ns: u32, memory: &'static mut [Real]) -> Result<Self, ConfigError> {
        let servo = match axes_of(tables) {
            3 => AnyServo::Three(Servo::load(tables, period_ns, memory)?),
            4 => AnyServo::Four(Servo::load(tables, period_ns, memory)?),
            5 => AnyServo::Five(Servo::load(tables, period_ns, memory)?),
            _ => AnyServo::Six(Servo::load(tables, period_ns, memory)?),
        };
        let mut growth = [ThermalGrowth::default(); AXES_MAX];
        for (growth, (_, settings)) in growth.iter_mut().zip(crate::tables::places(tables)) {
            *growth = settings.map_or(*growth, |settings| settings.thermal);
        }
        Ok(Built { servo, period_ns, growth })
    }
}

/// Builds a loop that passes every command uncorrected and says why in every record: for going on without tables.
///
/// `axes`: 3 to 6. `reason`: `TRUEAXIS_FAULT_PERIOD_MISMATCH`, `_TABLES_REFUSED`, `_CAPACITY_TOO_SMALL` or
/// `_ABI_MISMATCH`. `period_ns`: servo period, 1,000 to 100,000,000 ns. It needs no memory. A command that is no usable
/// number is not passed: the last one holds, before the first one the place that is read, and a stop is requested until
/// the next usable one.
///
/// Real-time safe. `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_AXES`, `_ARGUMENT` (reason, period).
///
/// # Safety
/// `loop` is null or points to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_loop_bypass(
    r#loop: *mut Loop,
    loop_size: usize,
    axes: u32,
    reason: u8,
    period_ns: u32,
) -> Status {
    let place = match opaque::place(r#loop, loop_size) {
        Ok(place) => place,
        Err(status) => return status,
    };
    if !(3..=AXES_MAX as u32).contains(&axes) {
        return ERROR_AXES;
    }
    let reason = match Fault::try_from(reason) {
        Ok(reason) if reason.refuses() && (1_000..=100_000_000).contains(&period_ns) => reason,
        _ => return ERROR_ARGUMENT,
    };
    let servo = AnyServo::Bypass { axes: axes as usize, reason };
    // SAFETY: storage of the size that the caller vouched for.
    unsafe { opaque::fill(place, Built { servo, period_ns, growth: [ThermalGrowth::default(); AXES_MAX] }) };
    status::OK
}

/// A fresh state for a loop, if the host runs at the loop's period (within 0.1 %).
///
/// `state`, `state_size`: the caller's, `sizeof(trueaxis_state_t)`. Real-time safe.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PERIOD`.
///
/// # Safety
/// Pointers are null or point to what their types say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_start(
    r#loop: *const Loop,
    state: *mut State,
    state_size: usize,
    period_ns: u32,
) -> Status {
    let work = || {
        let place = opaque::place(state, state_size)?;
        // SAFETY: the caller's promise.
        let built = unsafe { opaque::content(r#loop) }?;
        let running = match &built.servo {
            AnyServo::Three(servo) => servo.check_period(period_ns).map(|()| Running::Three(servo.start())),
            AnyServo::Four(servo) => servo.check_period(period_ns).map(|()| Running::Four(servo.start())),
            AnyServo::Five(servo) => servo.check_period(period_ns).map(|()| Running::Five(servo.start())),
            AnyServo::Six(servo) => servo.check_period(period_ns).map(|()| Running::Six(servo.start())),
            AnyServo::Bypass { .. } if period_ns.abs_diff(built.period_ns) > built.period_ns / 1000 => {
                Err(Fault::PeriodMismatch)
            }
            AnyServo::Bypass { axes: 3, reason } => Ok(Running::BypassThree(Bypass::new(*reason))),
            AnyServo::Bypass { axes: 4, reason } => Ok(Running::BypassFour(Bypass::new(*reason))),
            AnyServo::Bypass { axes: 5, reason } => Ok(Running::BypassFive(Bypass::new(*reason))),
            AnyServo::Bypass { reason, .. } => Ok(Running::BypassSix(Bypass::new(*reason))),
        };
        let running = running.map_err(|_| ERROR_PERIOD)?;
        // SAFETY: storage of the size that the caller vouched for.
        unsafe { opaque::fill(place, running) };
        Ok(())
    };
    status::of(work())
}

/// One servo cycle: what the drives are sent, and how far the tool is from its path.
///
/// The first cycle returns the command; from then on `drive = command + correction`. `path`: what the interpolator
/// follows, `reference`: where on it the command of this cycle lies; either may be `NULL`, then no contour error is
/// measured. `input->size` and `output->size` must be set. Loops may be exchanged between two cycles: pass another one
/// of the same number of axes.
///
/// Real-time safe: no allocation, no lock, no system call, bounded time. On refusal, state and output stay as they were.
///
/// Where neither a usable command has ever come nor every axis been read, there is no place to hold: the answer is
/// `TRUEAXIS_ERROR_NO_OUTPUT` and `output->drive` is not written. Once every axis has been read (without an alarm), its
/// place is held, and a reset near it is heard.
///
/// `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_NO_OUTPUT`. What goes wrong on the
/// machine otherwise is not a status but `output->record.fault`.
///
/// # Safety
/// Pointers are null or point to what their types say; nobody else uses `state` or writes any other of them meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_step(
    r#loop: *const Loop,
    state: *mut State,
    input: *const Input,
    path: *const Path,
    reference: *const Reference,
    output: *mut Output,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        unsafe { check_sized(output) }?;
        // SAFETY: the caller's promise.
        let input = unsafe { read_sized(input) }?;
        // SAFETY: the caller's promise.
        let place = unsafe { path::place(path, reference) }?;
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
        let result = with_servo!(built, running,
            servo(servo, state) => Output::of(&servo.step(state, &input.to_core(), place.path.on(place.reference), ())),
            bypass(bypass) => Output::of(&bypass.step::<Real>(&input.to_core()))
        )?;
        // SAFETY: checked: aligned, of the right size; writable by the caller's promise.
        unsafe { result.deliver(output) }
    };
    status::of(work())
}

/// Runs the same code for every number of axes: for a loop and a state that belong together.
macro_rules! with_servo {
    ($built:expr, $running:expr, servo($servo:ident, $state:ident) => $work:expr, bypass($passing:ident) => $pass:expr) => {{
        use $crate::servo::{AnyServo, Running};
        match (&$built.servo, $running) {
            (AnyServo::Three($servo), Running::Three($state)) => Ok($work),
            (AnyServo::Four($servo), Running::Four($state)) => Ok($work),
            (AnyServo::Five($servo), Running::Five($state)) => Ok($work),
            (AnyServo::Six($servo), Running::Six($state)) => Ok($work),
            (AnyServo::Bypass { axes: 3, .. }, Running::BypassThree($passing)) => Ok($pass),
            (AnyServo::Bypass { axes: 4, .. }, Running::BypassFour($passing)) => Ok($pass),
            (AnyServo::Bypass { axes: 5, .. }, Running::BypassFive($passing)) => Ok($pass),
            (AnyServo::Bypass { axes: 6, .. }, Running::BypassSix($passing)) => Ok($pass),
            (servo, running) if servo.axes() == running.axes() => Err($crate::status::ERROR_STATE),
            _ => Err($crate::status::ERROR_AXES),
        }
    }};
}
pub(crate) use with_servo;

/// Tells the temperature of an axis; its growth, as the table file describes it, takes effect in the next cycle, through
/// the limiter.
///
/// `place`: of the axis, 0 = X. `kelvin`: above the reference temperature of the file. Call it between two cycles, from
/// the thread that steps. In a bypass it does nothing. Real-time safe.
///
/// `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_ARGUMENT` (no such place; `kelvin` not finite or
/// so large that the growth exceeds 10 mm or 1e-3 of the length).
///
/// # Safety
/// Pointers are null or point to what their types say; nobody else uses `state` meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_set_thermal(
    r#loop: *const Loop,
    state: *mut State,
    place: u32,
    kelvin: f64,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let (built, running) = unsafe { (opaque::content(r#loop)?, opaque::content_mut(state)?) };
        if built.servo.axes() != running.axes() {
            return Err(ERROR_AXES);
        }
        let place = place as usize;
        let growth = built.growth.get(place).filter(|_| place < running.axes()).ok_or(ERROR_ARGUMENT)?;
        let line = ThermalLine::for_axis(growth, kelvin).filter(|_| kelvin.is_finite()).ok_or(ERROR_ARGUMENT)?;
        with_servo!(built, running,
            servo(_servo, state) => state.set_thermal(place, line),
            bypass(_bypass) => ()
        )
    };
    status::of(work())
}
