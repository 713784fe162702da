//! What goes into a servo cycle and what comes out of it.

use crate::plugin::{CorePosition, from_core, to_core};
use crate::pointer::Sized32;
use crate::status::{ERROR_NO_OUTPUT, Status};
use crate::{Position, Real};
use trueaxis::contour::ContourError;
use trueaxis::telemetry::Record as CoreRecord;

/// Most axes of a machine.
pub const AXES_MAX: usize = 6;

/// What the host hands over in a servo cycle. Axes stand in the order of `trueaxis_tables_info_t.letters`: X, Y, Z, then
/// the rotary axes of the machine in alphabetical order; places beyond the machine's axes are not looked at.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Input {
    /// `sizeof(trueaxis_input_t)`, set by the caller.
    pub size: u32,
    /// Time since the last cycle as the host measured or knows it, ns. Off by more than a quarter of the period, the
    /// correction freezes for this cycle (`TRUEAXIS_FAULT_LATE_CYCLE`).
    pub elapsed_ns: u32,
    /// Commanded positions, uncorrected.
    pub command: [Position; AXES_MAX],
    /// Raw encoder positions. A reading that is not a number, beyond 1e9, or in single precision `INT32_MIN` or
    /// `INT32_MAX`, is a dropout: convert counts with saturation. The same goes for commands, which are refused then.
    pub feedback: [Position; AXES_MAX],
    /// A bit for every axis whose encoder interface reports an alarm, bit 0 = X.
    pub encoder_alarm: u8,
    /// Not 0: all axes are homed, positions are machine positions.
    pub homed: u8,
    /// Not 0: compensation is wanted.
    pub enable: u8,
    /// Not 0: releases a latched stop request (on its rising edge, near the held position).
    pub reset: u8,
    /// Not looked at.
    pub reserved: [u8; 4],
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Input {}

impl Input {
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
            refusal: trueaxis::sample::Refusal::NONE,
        }
    }
}

#[inline(always)]
fn first<const N: usize>(positions: &[Position; AXES_MAX]) -> [CorePosition; N] {
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

/// A place on a path: a piece of it, and where in the piece. `trueaxis_path_reference` makes it from a segment and its
/// parameter.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference {
    /// Sequence number of the piece.
    pub span: u32,
    /// Parameter in the piece, 0 to 1.
    pub t: Real,
}

/// Contour error in a cycle; lengths in mm.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Contour {
    /// Piece of the path on which the foot lies.
    pub span: u32,
    /// Evaluations of the path that the search took.
    pub evaluations: u8,
    /// `TRUEAXIS_CONTOUR_…` bits: how the foot was found.
    pub flags: u8,
    /// 0.
    pub reserved: u16,
    /// Parameter of the foot in the piece, 0 to 1.
    pub t: Real,
    /// Distance from the path: |actual − foot|, never negative.
    pub error: Real,
    /// Actual − foot along X, Y, Z.
    pub vector: [Real; 3],
    /// Component in the machining plane, positive to the left of the path.
    pub normal: Real,
    /// Component along the plane's normal.
    pub binormal: Real,
    /// Component along the path: 0 but at ends and corners.
    pub tangential: Real,
    /// Arc length from the foot to the reference, positive while the tool lags.
    pub lag: Real,
    /// What is left of the bracket around the foot, arc length.
    pub width: Real,
}

impl Contour {
    fn of(error: &ContourError<Real>) -> Self {
        Contour {
            span: error.span,
            evaluations: error.evaluations,
            flags: error.flags.bits(),
            reserved: 0,
            t: error.t,
            error: error.error,
            vector: error.vector.into(),
            normal: error.normal,
            binormal: error.binormal,
            tangential: error.tangential,
            lag: error.lag,
            width: error.width,
        }
    }
}

/// The foot is a minimum of the distance, bracketed by − and +.
pub const CONTOUR_BRACKETED: u8 = 1;
/// The foot is an end of an open path.
pub const CONTOUR_AT_END: u8 = 2;
/// The foot is a corner between two pieces.
pub const CONTOUR_AT_CORNER: u8 = 4;
/// A second minimum may be near.
pub const CONTOUR_SECOND_MINIMUM: u8 = 8;
/// No foot was known from the last cycle; the way around the reference is being looked over.
pub const CONTOUR_COLD: u8 = 16;
/// No path, or no belief in the readings: nothing was measured, all other members are 0.
pub const CONTOUR_NOT_FOUND: u8 = 32;
/// The reference lay outside its piece and was taken at the nearer end; infinite or not a number, nothing was measured.
pub const CONTOUR_REFERENCE: u8 = 64;

/// Bit of `status`: homed, enabled and believed, corrections are followed.
pub const STATUS_ACTIVE: u8 = 1;
/// Bit of `status`: the correction is frozen because a reading is not believed.
pub const STATUS_FROZEN: u8 = 2;
/// Bit of `status`: the output is held and the host must stop the machine.
pub const STATUS_STOP_REQUEST: u8 = 4;
/// Bit of `status`: the contour error of this cycle was measured.
pub const STATUS_CONTOUR: u8 = 8;
/// Bit of `status`: there is no output, and the step answers `TRUEAXIS_ERROR_NO_OUTPUT`.
pub const STATUS_NO_OUTPUT: u8 = 16;

/// The telemetry of a cycle. Positions in `trueaxis_position_t`, everything else in mm (rotary: degrees).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Counts cycles from 0, wrapping.
    pub sequence: u32,
    /// Identity of the machine that the tables belong to; 0 in a bypass.
    pub machine_id: u32,
    /// CRC-32 of the table file in force; 0 in a bypass.
    pub tables_crc: u32,
    /// `TRUEAXIS_FAULT_…`: what went wrong, 0 if nothing.
    pub fault: u8,
    /// Place of the axis that the fault belongs to.
    pub fault_axis: u8,
    /// `TRUEAXIS_STATUS_…` bits.
    pub status: u8,
    /// A bit for every axis whose correction differs from the wanted one.
    pub limited: u8,
    /// A bit for every axis whose table holds its edge value.
    pub at_edge: u8,
    /// `TRUEAXIS_CONTOUR_…` bits of the orientation error: not found in all steps of this interface.
    pub orientation_flags: u8,
    /// 0.
    pub reserved: [u8; 6],
    /// Command that is in force: as it came, the held one during a stop.
    pub command: [Position; AXES_MAX],
    /// Raw feedback (last good one during a fault).
    pub feedback: [Position; AXES_MAX],
    /// Correction sent: `drive − command` before rounding to a position.
    pub correction: [Real; AXES_MAX],
    /// Contour error of the estimated tool tip.
    pub tip: Contour,
    /// Contour error of the plain encoder position.
    pub encoder: Contour,
    /// Orientation contour error, rad: 0 in all steps of this interface.
    pub orientation: Real,
}

/// What a servo cycle gives back.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// `sizeof(trueaxis_output_t)`, set by the caller once; stays as it is.
    pub size: u32,
    /// Number of axes that count in the arrays.
    pub axes: u32,
    /// Corrected positions for the drives. Not written where the step answers `TRUEAXIS_ERROR_NO_OUTPUT`.
    pub drive: [Position; AXES_MAX],
    /// Feedback for the host, without the correction: it sees no following error that is not there.
    pub feedback: [Position; AXES_MAX],
    /// The cycle's telemetry.
    pub record: Record,
}

// SAFETY: repr(C), `size` first, numbers only.
unsafe impl Sized32 for Output {}

impl Output {
    /// Hands a cycle's output to the caller: all of it, or without a place to send the drives to, all but that.
    ///
    /// # Safety
    /// `to` is aligned and points to a writable structure.
    #[inline(always)]
    pub(crate) unsafe fn deliver(self, to: *mut Output) -> Result<(), Status> {
        if self.record.status & STATUS_NO_OUTPUT == 0 {
            // SAFETY: the caller's promise.
            unsafe { to.write(self) };
            return Ok(());
        }
        // Nothing is read: the caller's structure may hold no value yet.
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
        let mut correction = [0.0; AXES_MAX];
        for (to, from) in correction.iter_mut().zip(&record.correction) {
            *to = *from;
        }
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
                reserved: [0; _],
                command: padded(&record.command),
                feedback: padded(&record.feedback),
                correction,
                tip: Contour::of(&record.tip),
                encoder: Contour::of(&record.encoder),
                orientation: record.orientation,
            },
        }
    }
}
