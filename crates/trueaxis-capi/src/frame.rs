//! Telemetry on the wire.

use crate::axes::AXES_MAX;
use crate::contour::Contour;
use crate::cycle::Output;
use crate::dynamic::Dynamic;
use crate::plugin::to_core;
use crate::pointer::{Buffer, read_sized};
use crate::result::{self, ERROR_ARGUMENT, ResultCode};
use trueaxis::telemetry::{self, AxisFrame, ContourFrame, DynamicFrame, Frame};
use trueaxis::{Fault, Position as _};

/// Largest telemetry frame of a record, bytes.
pub const FRAME_BYTES: usize = 384;
const _: () = assert!(FRAME_BYTES == telemetry::FRAME_BYTES);

/// Writes the telemetry frame of a record: postcard in COBS, terminated by 0; the same bytes in every build and
/// precision.
///
/// `output`: output of a step. `written`: number of bytes written. Not real-time. Errors: `_BUFFER`, `_ARGUMENT`
/// (`output` does not come from a step).
///
/// # Safety
/// Pointers are null or point to objects of their types, `buffer` to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_frame_encode(
    output: *const Output,
    buffer: *mut u8,
    size: usize,
    written: *mut usize,
) -> ResultCode {
    let work = || {
        // SAFETY: the caller's promise.
        let output = unsafe { read_sized(output) }?;
        let buffer = Buffer::new(buffer, size, written)?;
        let mut whole = [0; FRAME_BYTES];
        let frame = frame(&output).ok_or(ERROR_ARGUMENT)?.encode(&mut whole).map_err(|_| ERROR_ARGUMENT)?;
        // SAFETY: the caller's promise; the bytes are this function's own.
        unsafe { buffer.fill(frame) }
    };
    result::of(work())
}

fn frame(output: &Output) -> Option<Frame> {
    let axes = usize::try_from(output.axes).ok().filter(|axes| (3..=AXES_MAX).contains(axes))?;
    let record = &output.record;
    let corrections = record.correction.iter().zip(dynamics(&record.dynamic));
    let positions = record.command.iter().zip(&record.feedback).zip(corrections).take(axes);
    let has_dynamic = record.has_dynamic != 0;
    Some(Frame {
        version: telemetry::FRAME_VERSION,
        sequence: record.sequence,
        machine_id: record.machine_id,
        tables_crc: record.tables_crc,
        fault: Fault::try_from(record.fault).ok()?,
        fault_axis: record.fault_axis,
        status: telemetry::Status(record.status),
        limited: record.limited,
        at_edge: record.at_edge,
        axes: positions
            .map(|((command, feedback), (correction, dynamic))| AxisFrame {
                command: to_core(*command).to_f64(),
                feedback: to_core(*feedback).to_f64(),
                correction: single(*correction),
                dynamic: has_dynamic.then_some(dynamic),
            })
            .collect(),
        tip: contour(&record.tip),
        encoder: contour(&record.encoder),
        orientation: single(record.orientation),
        orientation_flags: record.orientation_flags,
    })
}

/// The dynamic correction of every axis.
fn dynamics(parts: &Dynamic) -> impl Iterator<Item = DynamicFrame> + '_ {
    let wanted = parts.feedback.iter().zip(&parts.crosstalk).zip(&parts.learned);
    let axes = parts.sent.iter().zip(&parts.feed_forward).zip(wanted);
    axes.map(|((sent, feed_forward), ((feedback, crosstalk), learned))| DynamicFrame {
        sent: single(*sent),
        feed_forward: single(*feed_forward),
        feedback: single(*feedback),
        crosstalk: single(*crosstalk),
        learned: single(*learned),
    })
}

fn contour(error: &Contour) -> ContourFrame {
    ContourFrame {
        error: single(error.error),
        normal: single(error.normal),
        binormal: single(error.binormal),
        lag: single(error.lag),
        flags: error.flags,
    }
}

fn single(x: crate::Real) -> f32 {
    trueaxis::Real::to_f64(x) as f32
}
