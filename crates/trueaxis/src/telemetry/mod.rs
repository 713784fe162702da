//! One fixed record per cycle, and its wire form.
//!
//! The step fills a [`Record`] in the scalars with which it computes. A task of lower priority converts records into
//! [`Frame`]s (SI-near units, identical for every build) and those into COBS frames of postcard: each ends with a zero
//! byte, so that a receiver resynchronizes after a loss, and the sequence number shows how many are missing. A
//! three-probe gauge adds a [`RoundnessFrame`] for every evaluated revolution.

#![deny(clippy::indexing_slicing)]

mod parts;
mod roundness;

pub use roundness::{ROUNDNESS_FRAME_BYTES, ROUNDNESS_FRAME_VERSION, RoundnessFrame};

bench!(use parts::{AxisFrame, ContourFrame, DynamicFrame});

use crate::contour::{ContourError, Flags};
use crate::dynamic::DynamicParts;
use crate::error::Fault;
use crate::machine::AXES;
use crate::position::Position;
use crate::real::Real;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// State of the step in a cycle, as bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status(pub u8);

impl Status {
    /// Homed, enabled, readings accepted: corrections are applied.
    pub const ACTIVE: Status = Status(1);
    /// A reading was refused, and the correction is frozen.
    pub const FROZEN: Status = Status(2);
    /// The output holds, and the step asks the host to stop.
    pub const STOP_REQUEST: Status = Status(4);
    /// The contour error of this cycle was measured.
    pub const CONTOUR: Status = Status(8);
    /// The step gives no output: no usable command has arrived, and not every axis has been read. Do not write `drive`.
    pub const NO_OUTPUT: Status = Status(16);
    /// The contour feedback oscillated and is ramped out, until the compensation is switched off or a reset arrives.
    pub const FEEDBACK_OUT: Status = Status(32);
    /// On trial ([`crate::Dynamics::ON_TRIAL`]) the friction feed-forward made the contour error larger and acts with a smaller
    /// share, until the error shows that it helps, the trial ends, a reset arrives, or friction, lag and acceleration are all
    /// switched off.
    pub const FRICTION_OUT: Status = Status(64);
    /// The same of the lag or the acceleration feed-forward.
    pub const LAG_OUT: Status = Status(128);

    /// Whether all bits of `other` are set.
    pub const fn has(self, other: Status) -> bool {
        self.0 & other.0 == other.0
    }

    pub(crate) const fn with(self, other: Status, set: bool) -> Status {
        if set { Status(self.0 | other.0) } else { self }
    }
}

/// Full data of one servo cycle in the step's own scalars.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(not(feature = "bench"), non_exhaustive)]
pub struct Record<R: Real, P, const N: usize> {
    /// Cycle counter from 0, wrapping.
    pub sequence: u32,
    /// Identity of the machine to which the tables belong.
    pub machine_id: u32,
    /// CRC-32 of the table file in force.
    pub tables_crc: u32,
    /// The fault, if any.
    pub fault: Fault,
    /// Slot of the axis at fault.
    pub fault_axis: u8,
    /// State bits.
    pub status: Status,
    /// One bit for every axis whose correction differs from the wanted one.
    pub limited: u8,
    /// One bit for every axis whose table is at its clamped edge value.
    pub at_edge: u8,
    /// Command as received (the held one during a stop), mm (deg).
    pub command: [P; N],
    /// Raw feedback (last good one during a fault), mm (deg).
    pub feedback: [P; N],
    /// Correction sent, mm (deg); only the geometric part if a dynamic one is configured.
    pub correction: [R; N],
    /// The dynamic correction and its parts; `None` if no part is configured.
    pub dynamic: Option<DynamicParts<R, N>>,
    /// Contour error of the estimated tool tip.
    pub tip: ContourError<R>,
    /// Contour error of the plain encoder position.
    pub encoder: ContourError<R>,
    /// Orientation contour error of the estimated tool, rad; 0 in a step without tool.
    pub orientation: R,
    /// Flags of the orientation search; *not found* in a step without tool.
    pub orientation_flags: Flags,
}

impl<R: Real, P: Position, const N: usize> Record<R, P, N> {
    /// The record before the first cycle.
    #[inline(always)]
    pub(crate) fn none() -> Self {
        Record {
            sequence: 0,
            machine_id: 0,
            tables_crc: 0,
            fault: Fault::None,
            fault_axis: 0,
            status: Status::NO_OUTPUT,
            limited: 0,
            at_edge: 0,
            command: [P::default(); N],
            feedback: [P::default(); N],
            correction: [R::ZERO; N],
            dynamic: None,
            tip: ContourError::none(),
            encoder: ContourError::none(),
            orientation: R::ZERO,
            orientation_flags: Flags::NOT_FOUND,
        }
    }
}

/// Wire form of a [`Record`]: identical layout in every build; its members are in `docs/telemetry.md`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame {
    /// Layout of this record; [`FRAME_VERSION`].
    #[doc(hidden)]
    pub version: u8,
    /// Cycle counter, wrapping.
    #[doc(hidden)]
    pub sequence: u32,
    /// Identity of the machine.
    #[doc(hidden)]
    pub machine_id: u32,
    /// CRC-32 of the tables in force.
    #[doc(hidden)]
    pub tables_crc: u32,
    /// The fault.
    #[doc(hidden)]
    pub fault: Fault,
    /// Slot of the axis at fault.
    #[doc(hidden)]
    pub fault_axis: u8,
    /// State bits.
    #[doc(hidden)]
    pub status: Status,
    /// Axes whose correction is limited.
    #[doc(hidden)]
    pub limited: u8,
    /// Axes whose table is at its clamped edge value.
    #[doc(hidden)]
    pub at_edge: u8,
    /// The axes, in the step's order.
    #[doc(hidden)]
    pub axes: Vec<AxisFrame, AXES>,
    /// Estimated tool tip.
    #[doc(hidden)]
    pub tip: ContourFrame,
    /// Plain encoder position.
    #[doc(hidden)]
    pub encoder: ContourFrame,
    /// Orientation contour error of the estimated tool, rad.
    #[doc(hidden)]
    pub orientation: f32,
    /// Flags of the orientation search ([`crate::contour::Flags`]); *not found* in a step without tool.
    #[doc(hidden)]
    pub orientation_flags: u8,
}

/// Version of the layout that [`Frame`] writes.
pub const FRAME_VERSION: u8 = 3;
/// Buffer size sufficient for the COBS frame of any record.
pub const FRAME_BYTES: usize = 384;

impl Frame {
    /// Converts a record to its wire form. Not part of the step: on a core without double precision this costs some
    /// hundred instructions per axis.
    pub fn of<R: Real, P: Position, const N: usize>(record: &Record<R, P, N>) -> Frame {
        let mut axes = Vec::new();
        let axes_of_record = record.command.iter().zip(&record.feedback).zip(&record.correction);
        for (slot, ((command, feedback), correction)) in axes_of_record.enumerate() {
            // N is at most AXES (checked at build); an excess axis would be omitted, not written wrongly.
            let _ = axes.push(AxisFrame {
                command: command.to_f64(),
                feedback: feedback.to_f64(),
                correction: correction.to_f64() as f32,
                dynamic: record.dynamic.as_ref().map(|parts| dynamic(parts, slot)),
            });
        }
        Frame {
            version: FRAME_VERSION,
            sequence: record.sequence,
            machine_id: record.machine_id,
            tables_crc: record.tables_crc,
            fault: record.fault,
            fault_axis: record.fault_axis,
            status: record.status,
            limited: record.limited,
            at_edge: record.at_edge,
            axes,
            tip: contour(&record.tip),
            encoder: contour(&record.encoder),
            orientation: record.orientation.to_f64() as f32,
            orientation_flags: record.orientation_flags.bits(),
        }
    }

    /// Encodes into `buffer`; returns the part used, its last byte zero.
    ///
    /// # Errors
    /// The buffer is smaller than the frame ([`FRAME_BYTES`] always suffice).
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b mut [u8], postcard::Error> {
        postcard::to_slice_cobs(self, buffer)
    }

    /// Decodes one frame, with or without its closing zero byte; `bytes` is scratch afterwards.
    ///
    /// # Errors
    /// The bytes are not one whole frame, or its version is not [`FRAME_VERSION`].
    pub fn decode(bytes: &mut [u8]) -> Result<Frame, postcard::Error> {
        let frame: Frame = postcard::from_bytes_cobs(bytes)?;
        if frame.version == FRAME_VERSION { Ok(frame) } else { Err(postcard::Error::DeserializeBadEncoding) }
    }
}

fn dynamic<R: Real, const N: usize>(parts: &DynamicParts<R, N>, slot: usize) -> DynamicFrame {
    let single = |part: &[R; N]| part.get(slot).map_or(0.0, |value| value.to_f64() as f32);
    DynamicFrame {
        sent: single(&parts.sent),
        feed_forward: single(&parts.feed_forward),
        feedback: single(&parts.feedback),
        crosstalk: single(&parts.crosstalk),
        learned: single(&parts.learned),
    }
}

fn contour<R: Real>(error: &ContourError<R>) -> ContourFrame {
    let single = |x: R| x.to_f64() as f32;
    ContourFrame {
        error: single(error.error),
        normal: single(error.normal),
        binormal: single(error.binormal),
        lag: single(error.lag),
        flags: error.flags.bits(),
    }
}
