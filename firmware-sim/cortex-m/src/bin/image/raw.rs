//! Outputs bit for bit, for comparison with the same step on a host.
//!
//! UART 1 carries one line of fixed length for every cycle whose record reached the telemetry task; a cycle whose record
//! was dropped is missing here and there. Little-endian, S the scalar (f32, or f64 with the feature `double`), P the
//! position (i32 in 1e-6 mm, or f64 in mm):
//!
//! | bytes | bytes with `double` | |
//! |---|---|---|
//! | 4 | 4 | sequence, u32 |
//! | 4 | 4 | CRC-32 of the tables in force, u32; 0 without tables |
//! | 8 | 8 | fault, place of its axis, status, limited, at edge, evaluations for the tip, flags of the tip, 0; u8 each |
//! | 12 | 24 | drive positions, 3 P |
//! | 12 | 24 | feedback for the host, 3 P |
//! | 12 | 24 | corrections, mm, 3 S |
//! | 12 | 24 | contour error of the tip, its lag, contour error of the encoder, mm, 3 S |
//! | 4 | 8 | where a gauge runs: its infeed, mm, S |
//!
//! Together 64 or 112 bytes, 68 or 120 with a gauge. A gauge runs if the recording has its inputs and the tables were
//! taken and have its settings.

use crate::scalars::{Place, Scalar, StepOutput};
use heapless::Vec;

/// Bytes of the longest line.
pub const LINE_BYTES: usize = 16 + 6 * size_of::<Place>() + 7 * size_of::<Scalar>();

/// The bytes of a cycle.
pub fn line(output: &StepOutput, infeed: Option<Scalar>) -> Vec<u8, LINE_BYTES> {
    let record = &output.record;
    let mut line = Vec::new();
    let mut add = |bytes: &[u8]| {
        // The capacity is that of all fields.
        let _ = line.extend_from_slice(bytes);
    };
    add(&record.sequence.to_le_bytes());
    add(&record.tables_crc.to_le_bytes());
    add(&[
        record.fault.into(),
        record.fault_axis,
        record.status.0,
        record.limited,
        record.at_edge,
        record.tip.evaluations,
        record.tip.flags.bits(),
        0,
    ]);
    for position in output.drive.iter().chain(&output.feedback) {
        #[cfg(not(feature = "double"))]
        let position = position.0;
        add(&position.to_le_bytes());
    }
    let errors = [record.tip.error, record.tip.lag, record.encoder.error];
    for scalar in record.correction.iter().chain(&errors).chain(&infeed) {
        add(&scalar.to_le_bytes());
    }
    line
}
