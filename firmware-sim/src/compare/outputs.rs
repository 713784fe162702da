//! What the step gives back in a cycle, byte for byte, as the image sends it.
//!
//! | bytes | |
//! |---|---|
//! | 4 | sequence number |
//! | 4 | CRC-32 of the tables in force |
//! | 8 | fault, its axis, status, limited, at edge, evaluations and flags of the tip's search, 0 |
//! | 3 P | drive positions |
//! | 3 P | feedback without the correction |
//! | 3 R | corrections |
//! | 3 R | contour error of the tip, its lag, contour error of the encoder position |
//! | R | with a gauge: infeed |
//!
//! Little-endian. Single precision: P is an integer of 1e-6 mm in 4 bytes, R a float of 4; double: both doubles.

use trueaxis::{Micro, Output, Position, Real};

/// Number of axes.
pub const AXES: usize = 3;

/// A scalar and its position on the wire.
pub trait Wire: Real {
    /// Positions that belong to it.
    type Place: trueaxis_recording::Integer;
    /// Bytes of either.
    const BYTES: usize;
    /// Writes a scalar.
    fn put(self, into: &mut Vec<u8>);
    /// Reads a scalar.
    fn get(bytes: &[u8]) -> f64;
    /// Writes a position.
    fn put_place(place: Self::Place, into: &mut Vec<u8>);
    /// Reads a position, mm.
    fn get_place(bytes: &[u8]) -> f64;
}

fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}

impl Wire for f32 {
    type Place = Micro;
    const BYTES: usize = 4;
    fn put(self, into: &mut Vec<u8>) {
        into.extend(self.to_le_bytes());
    }
    fn get(bytes: &[u8]) -> f64 {
        f64::from(f32::from_le_bytes(array(bytes)))
    }
    fn put_place(place: Micro, into: &mut Vec<u8>) {
        into.extend(place.0.to_le_bytes());
    }
    fn get_place(bytes: &[u8]) -> f64 {
        Micro(i32::from_le_bytes(array(bytes))).to_f64()
    }
}

impl Wire for f64 {
    type Place = f64;
    const BYTES: usize = 8;
    fn put(self, into: &mut Vec<u8>) {
        into.extend(self.to_le_bytes());
    }
    fn get(bytes: &[u8]) -> f64 {
        f64::from_le_bytes(array(bytes))
    }
    fn put_place(place: f64, into: &mut Vec<u8>) {
        into.extend(place.to_le_bytes());
    }
    fn get_place(bytes: &[u8]) -> f64 {
        f64::from_le_bytes(array(bytes))
    }
}

/// Bytes of a cycle in scalar `R`.
pub const fn bytes<R: Wire>(gauge: bool) -> usize {
    16 + (4 * AXES + if gauge { 1 } else { 0 }) * R::BYTES
}

/// Writes a cycle as the image does; the infeed where there is a gauge.
pub fn encode<R: Wire>(output: &Output<R, R::Place, AXES>, infeed: Option<R>, into: &mut Vec<u8>) {
    let record = &output.record;
    into.extend(record.sequence.to_le_bytes());
    into.extend(record.tables_crc.to_le_bytes());
    let tip = &record.tip;
    let small =
        [record.fault as u8, record.fault_axis, record.status.0, record.limited, record.at_edge, tip.evaluations];
    into.extend(small);
    into.extend([tip.flags.bits(), 0]);
    for place in output.drive.iter().chain(&output.feedback) {
        R::put_place(*place, into);
    }
    for scalar in record.correction.iter().chain(&[tip.error, tip.lag, record.encoder.error]) {
        scalar.put(into);
    }
    if let Some(infeed) = infeed {
        infeed.put(into);
    }
}

/// A cycle as numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Counts cycles.
    pub sequence: u32,
    /// CRC-32 of the tables in force, 0 where they were refused.
    pub tables_crc: u32,
    /// Code of the fault.
    pub fault: u8,
    /// Status bits.
    pub status: u8,
    /// Flags of the tip's search.
    pub flags: u8,
    /// Drive positions, mm.
    pub drive: [f64; AXES],
    /// Corrections, mm.
    pub correction: [f64; AXES],
    /// Contour error of the tip, mm.
    pub tip: f64,
    /// Lag of the tip, mm.
    pub lag: f64,
    /// Contour error of the encoder position, mm.
    pub encoder: f64,
}

/// All whole cycles in what was received.
pub fn decode<R: Wire>(received: &[u8], gauge: bool) -> Vec<Row> {
    received.chunks_exact(bytes::<R>(gauge)).map(row::<R>).collect()
}

fn row<R: Wire>(bytes: &[u8]) -> Row {
    let at = |from: usize| bytes.get(from..).unwrap_or_default();
    let scalars = 16 + 2 * AXES * R::BYTES;
    let scalar = |k: usize| R::get(at(scalars + k * R::BYTES));
    Row {
        sequence: u32::from_le_bytes(array(at(0))),
        tables_crc: u32::from_le_bytes(array(at(4))),
        fault: at(8).first().copied().unwrap_or(0),
        status: at(10).first().copied().unwrap_or(0),
        flags: at(14).first().copied().unwrap_or(0),
        drive: std::array::from_fn(|k| R::get_place(at(16 + k * R::BYTES))),
        correction: std::array::from_fn(scalar),
        tip: scalar(AXES),
        lag: scalar(AXES + 1),
        encoder: scalar(AXES + 2),
    }
}
