//! Input and output of a servo cycle.

use crate::axes::{AXES_MAX, padded_numbers};
use crate::contour::Contour;
use crate::dynamic::Dynamic;
use crate::plugin::{CorePosition, from_core, to_core};
use crate::pointer::{Sized32, read_sized};
use crate::result::{ERROR_ARGUMENT, ERROR_NO_OUTPUT, ResultCode};
use crate::{Position, Real};
use trueaxis::sample::Refusal;
use trueaxis::telemetry::Record as CoreRecord;
use trueaxis::{Dynamics, Fault};

/// Command and readings of a servo cycle. Axes are in the order of `trueaxis_tables_info_t.letters`; elements beyond
/// the machine's axes are ignored.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Input {
    /// `sizeof(trueaxis_input_t)`.
    pub size: u32,
    /// Time since the last cycle, ns: as measured, or the period. The correction freezes for this cycle, with
    /// `TRUEAXIS_FAULT_LATE_CYCLE`, if the time differs from the period by more than a quarter, or if less than 0.999
    /// of a period has passed for each cycle's worth of motion of the correction (one cycle's worth may be saved up).
    /// The limits of the correction therefore apply per second, however the cycles arrive. 0: no time has passed and
    /// nothing moves. The value in the first cycle is ignored. `trueaxis_elapsed_ns` converts a 64-bit time.
    pub elapsed_ns: u32,
    /// Commanded positions, uncorrected.
    pub command: [Position; AXES_MAX],
    /// Raw encoder positions. A value that is not finite, is beyond 1e9, or in single precision equals `INT32_MIN` or
    /// `INT32_MAX` is a dropout, so convert counts with saturation. In `command` such a value is a fault.
    pub feedback: [Position; AXES_MAX],
    /// Bit 0 = X, …: the encoder interface of the axis reports an alarm.
    pub encoder_alarm: u8,
    /// Not 0: all axes are homed.
    pub homed: u8,
    /// Not 0: compensate.
    pub enable: u8,
    /// A rising edge releases a latched stop request if the machine is near the held position.
    pub reset: u8,
    /// Fault with which `trueaxis_rtcp` rejected the tool (`TRUEAXIS_FAULT_COMMAND_NOT_FINITE` …); otherwise 0.
    pub refusal: u8,
    /// Axis of that fault.
    pub refusal_axis: u8,
    /// `TRUEAXIS_DYNAMICS_…` bits of the parts of the dynamic correction that are off in this cycle; 0: all parts that
    /// the tables configure are on. The limiter ramps each part in and out. `TRUEAXIS_DYNAMICS_ON_TRIAL` puts those
    /// that are on to the trial.
    pub dynamics_off: u8,
    /// Ignored.
    pub reserved: u8,
    /// Learned correction of X, Y, Z at this point of the program (`trueaxis_learned_at`), as positions counted from 0;
    /// 0 without one. An unusable position counts as 0. No effect in a bypass.
    pub learned: [Position; 3],
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Input {}

/// Converts a 64-bit time since the last cycle to `elapsed_ns`.
///
/// A time that does not fit, or that is negative because a clock was set back, becomes `UINT32_MAX`. That is late at
/// any period: the correction freezes for that cycle. Real-time safe.
#[unsafe(no_mangle)]
pub extern "C" fn trueaxis_elapsed_ns(host_ns: i64) -> u32 {
    u32::try_from(host_ns).unwrap_or(u32::MAX)
}

impl Input {
    /// A copy of the caller's input, refused if its `refusal` is not a fault that stops the machine.
    ///
    /// # Safety
    /// As for [`read_sized`].
    #[inline(always)]
    pub(crate) unsafe fn read(input: *const Input) -> Result<Input, ResultCode> {
        // SAFETY: the caller's promise.
        let input = unsafe { Input::read_unrefused(input) }?;
        if input.refusal == 0 || Fault::try_from(input.refusal).is_ok_and(Fault::stops) {
            Ok(input)
        } else {
            Err(ERROR_ARGUMENT)
        }
    }

    /// A copy of the caller's input, with any `refusal`.
    ///
    /// # Safety
    /// As for [`read_sized`].
    #[inline(always)]
    pub(crate) unsafe fn read_unrefused(input: *const Input) -> Result<Input, ResultCode> {
        // SAFETY: the caller's promise.
        unsafe { read_sized(input) }
    }

    #[inline(always)]
    pub(crate) fn to_core<const N: usize>(self) -> trueaxis::Input<CorePosition, N> {
        trueaxis::Input {
            command: first(&self.command),
            feedback: first(&self.feedback),
            encoder_alarm: self.encoder_alarm,
            elapsed_ns: self.elapsed_ns,
            homed: self.homed != 0,
            enable: self.enable != 0,
            reset: self.reset != 0,
            refusal: Refusal { fault: Fault::try_from(self.refusal).unwrap_or(Fault::None), slot: self.refusal_axis },
            // The trial is off by default, the parts are on: a bit that is set changes either.
            dynamics: Dynamics(Dynamics::ALL.0 ^ self.dynamics_off),
            learned: self.learned.map(to_core),
        }
    }

    /// Copies command and refusal from the core's input.
    pub(crate) fn command_of<const N: usize>(&mut self, input: &trueaxis::Input<CorePosition, N>) {
        for (to, from) in self.command.iter_mut().zip(&input.command) {
            *to = from_core(*from);
        }
        (self.refusal, self.refusal_axis) = (input.refusal.fault.into(), input.refusal.slot);
    }
}

#[inline(always)]
pub(crate) fn first<const N: usize>(positions: &[Position]) -> [CorePosition; N] {
    let mut axes = [CorePosition::default(); N];
    for (axis, position) in axes.iter_mut().zip(positions) {
        *axis = to_core(*position);
    }
    axes
}

#[inline(always)]
fn padded<const N: usize>(axes: &[CorePosition; N]) -> [Position; AXES_MAX] {
    let mut positions = [Position::default(); AXES_MAX];
    for (position, axis) in positions.iter_mut().zip(axes) {
        *position = from_core(*axis);
    }
    positions
}

/// Bit of `record.status`: the machine is homed and enabled, the readings are valid, and the correction follows the
/// tables.
pub const STATUS_ACTIVE: u8 = 1;
/// Bit of `record.status`: the correction is frozen after a faulty reading.
pub const STATUS_FROZEN: u8 = 2;
/// Bit of `record.status`: the output holds, and the host must stop the machine.
pub const STATUS_STOP_REQUEST: u8 = 4;
/// Bit of `record.status`: the contour error was measured.
pub const STATUS_CONTOUR: u8 = 8;
/// Bit of `record.status`: `drive` was not written (`TRUEAXIS_ERROR_NO_OUTPUT`).
pub const STATUS_NO_OUTPUT: u8 = 16;
/// Bit of `record.status`: the contour feedback oscillated and is ramped out, until `enable` falls, a reset comes, or
/// the feedback is switched off.
pub const STATUS_FEEDBACK_OUT: u8 = 32;
/// Bit of `record.status`: on trial (`TRUEAXIS_DYNAMICS_ON_TRIAL`) the friction part made the contour error larger and
/// acts with a smaller share, until the error shows that it helps, a reset comes, or friction, lag and acceleration are
/// switched off.
pub const STATUS_FRICTION_OUT: u8 = 64;
/// Bit of `record.status`: the same of the lag or the acceleration part.
pub const STATUS_LAG_OUT: u8 = 128;

/// Telemetry of a cycle. Positions are of type `trueaxis_position_t`, all other lengths in mm (rotary axes: degrees).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Number of the cycle, counted from 0, wrapping.
    pub sequence: u32,
    /// Machine identity from the tables; 0 in a bypass.
    pub machine_id: u32,
    /// CRC-32 of the table file; 0 in a bypass.
    pub tables_crc: u32,
    /// `TRUEAXIS_FAULT_…`.
    pub fault: u8,
    /// Axis of the fault.
    pub fault_axis: u8,
    /// `TRUEAXIS_STATUS_…` bits.
    pub status: u8,
    /// One bit per axis: the correction differs from the wanted one because of a limit.
    pub limited: u8,
    /// One bit per axis: the position is outside the axis' table, and the value at the edge applies.
    pub at_edge: u8,
    /// `TRUEAXIS_CONTOUR_…` bits of the orientation error.
    pub orientation_flags: u8,
    /// 1: the tables configure a dynamic correction, and `dynamic` is that of this cycle. 0: `dynamic` is all 0.
    pub has_dynamic: u8,
    /// 0.
    pub reserved: [u8; 5],
    /// Command in force: that of this cycle, or the held one.
    pub command: [Position; AXES_MAX],
    /// Raw feedback; after a fault the last good one.
    pub feedback: [Position; AXES_MAX],
    /// Geometric correction sent: `drive − command` before rounding to a position, minus `dynamic.sent`.
    pub correction: [Real; AXES_MAX],
    /// The dynamic correction sent in addition, and the parts that make it up.
    pub dynamic: Dynamic,
    /// Contour error of the estimated tip.
    pub tip: Contour,
    /// Contour error of the encoder position.
    pub encoder: Contour,
    /// Orientation contour error, rad; 0 except with `TRUEAXIS_MEASURE_TOOL`.
    pub orientation: Real,
}

/// Output of a servo cycle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// `sizeof(trueaxis_output_t)`.
    pub size: u32,
    /// Number of axes.
    pub axes: u32,
    /// Corrected positions for the drives; not written with `TRUEAXIS_ERROR_NO_OUTPUT`.
    pub drive: [Position; AXES_MAX],
    /// Feedback for the host, minus the correction sent, so that the correction does not appear as a following error.
    pub feedback: [Position; AXES_MAX],
    /// Telemetry of the cycle.
    pub record: Record,
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Output {}

impl Output {
    /// Passes a cycle's output to the caller, without the drive positions if the cycle has none.
    ///
    /// # Safety
    /// `to` is aligned and points to a writable structure.
    #[inline(always)]
    pub(crate) unsafe fn deliver(self, to: *mut Output) -> Result<(), ResultCode> {
        if self.record.status & STATUS_NO_OUTPUT == 0 {
            // SAFETY: the caller's promise.
            unsafe { to.write(self) };
            return Ok(());
        }
        // Nothing is read, because the caller's structure may be uninitialised.
        // SAFETY: the caller's promise.
        unsafe {
            (&raw mut (*to).size).write(self.size);
            (&raw mut (*to).axes).write(self.axes);
            (&raw mut (*to).feedback).write(self.feedback);
            (&raw mut (*to).record).write(self.record);
        }
        Err(ERROR_NO_OUTPUT)
    }

    #[inline(always)]
    pub(crate) fn of<const N: usize>(output: &trueaxis::Output<Real, CorePosition, N>) -> Self {
        let record: &CoreRecord<Real, CorePosition, N> = &output.record;
        Output {
            size: size_of::<Output>() as u32,
            axes: N as u32,
            drive: padded(&output.drive),
            feedback: padded(&output.feedback),
            record: Record {
                sequence: record.sequence,
                machine_id: record.machine_id,
                tables_crc: record.tables_crc,
                fault: record.fault.into(),
                fault_axis: record.fault_axis,
                status: record.status.0,
                limited: record.limited,
                at_edge: record.at_edge,
                orientation_flags: record.orientation_flags.bits(),
                has_dynamic: record.dynamic.is_some().into(),
                reserved: [0; _],
                command: padded(&record.command),
                feedback: padded(&record.feedback),
                correction: padded_numbers(&record.correction),
                dynamic: record.dynamic.as_ref().map_or(Dynamic::NONE, Dynamic::of),
                tip: Contour::of(&record.tip),
                encoder: Contour::of(&record.encoder),
                orientation: record.orientation,
            },
        }
    }
}
