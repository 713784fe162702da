//! Outputs of the step in one cycle as bytes, sent by one build and compared by another.
//!
//! | bytes | |
//! |---|---|
//! | 4 | sequence number |
//! | 4 | CRC-32 of the tables in force, 0 without tables |
//! | 8 | fault, its axis, status, limited, at edge, evaluations and flags of the tip's search, 0 |
//! | N P | drive positions |
//! | N P | feedback without the correction |
//! | N R | corrections |
//! | 3 R | contour error of the tip, its lag, contour error of the encoder position |
//! | R | with a gauge: infeed |
//!
//! Little-endian. In single precision P is an integer of 1e-6 mm in 4 bytes and R a 4-byte float; in double both are doubles.

use crate::cycle::Integer;
use heapless::Vec;
use trueaxis::{Nanometres, Output, Position, Real};

/// A scalar and its position in the byte format.
pub trait Wire: Real {
    /// Position type of the scalar.
    type Place: Integer;
    /// Number of bytes of a scalar and of a position.
    const BYTES: usize;
    /// Passes the bytes of a scalar to `add`.
    fn put(self, add: impl FnMut(&[u8]));
    /// Reads a scalar; missing bytes are zero.
    fn get(bytes: &[u8]) -> f64;
    /// Passes the bytes of a position to `add`.
    fn put_place(place: Self::Place, add: impl FnMut(&[u8]));
    /// Reads a position, mm.
    fn get_place(bytes: &[u8]) -> f64;
}

fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}

impl Wire for f32 {
    type Place = Nanometres;
    const BYTES: usize = 4;
    fn put(self, mut add: impl FnMut(&[u8])) {
        add(&self.to_le_bytes());
    }
    fn get(bytes: &[u8]) -> f64 {
        f64::from(f32::from_le_bytes(array(bytes)))
    }
    fn put_place(place: Nanometres, mut add: impl FnMut(&[u8])) {
        add(&place.0.to_le_bytes());
    }
    fn get_place(bytes: &[u8]) -> f64 {
        Nanometres(i32::from_le_bytes(array(bytes))).to_f64()
    }
}

impl Wire for f64 {
    type Place = f64;
    const BYTES: usize = 8;
    fn put(self, mut add: impl FnMut(&[u8])) {
        add(&self.to_le_bytes());
    }
    fn get(bytes: &[u8]) -> f64 {
        f64::from_le_bytes(array(bytes))
    }
    fn put_place(place: f64, add: impl FnMut(&[u8])) {
        place.put(add);
    }
    fn get_place(bytes: &[u8]) -> f64 {
        f64::get(bytes)
    }
}

/// Number of bytes of a cycle of `axes` axes in scalar `R`.
pub const fn line_bytes<R: Wire>(axes: usize, gauge: bool) -> usize {
    16 + (3 * axes + 3 + if gauge { 1 } else { 0 }) * R::BYTES
}

/// Number of bytes of the longest line: six axes in doubles, with a gauge.
pub const LINE_BYTES: usize = line_bytes::<f64>(6, true);

/// The bytes of a cycle; `infeed` of the gauge, if any.
pub fn line<R: Wire, const N: usize>(output: &Output<R, R::Place, N>, infeed: Option<R>) -> Vec<u8, LINE_BYTES> {
    line_of_axes(output, N, infeed)
}

/// [`line()`] of a step with spare slots, of whose slots the first `axes` are written.
pub(crate) fn line_of_axes<R: Wire, const N: usize>(
    output: &Output<R, R::Place, N>,
    axes: usize,
    infeed: Option<R>,
) -> Vec<u8, LINE_BYTES> {
    let record = &output.record;
    let mut line = Vec::new();
    let mut add = |bytes: &[u8]| {
        // The capacity covers all fields.
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
    for place in output.drive.iter().take(axes).chain(output.feedback.iter().take(axes)) {
        R::put_place(*place, &mut add);
    }
    let errors = [record.tip.error, record.tip.lag, record.encoder.error];
    for scalar in record.correction.iter().take(axes).chain(&errors).chain(&infeed) {
        scalar.put(&mut add);
    }
    line
}

/// A decoded cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<const N: usize> {
    /// Sequence number of the cycle.
    pub sequence: u32,
    /// CRC-32 of the tables in force, 0 if they were refused.
    pub tables_crc: u32,
    /// Code of the fault.
    pub fault: u8,
    /// Status bits.
    pub status: u8,
    /// Flags of the tip's search.
    pub flags: u8,
    /// Drive positions, mm.
    pub drive: [f64; N],
    /// Corrections, mm.
    pub correction: [f64; N],
    /// Contour error of the tip, mm.
    pub tip: f64,
    /// Lag of the tip, mm.
    pub lag: f64,
    /// Contour error of the encoder position, mm.
    pub encoder: f64,
}

impl<const N: usize> Line<N> {
    /// Reads the bytes of a cycle in scalar `R`; missing bytes are zero.
    pub fn read<R: Wire>(bytes: &[u8]) -> Self {
        let at = |from: usize| bytes.get(from..).unwrap_or_default();
        let scalars = 16 + 2 * N * R::BYTES;
        let scalar = |k: usize| R::get(at(scalars + k * R::BYTES));
        let small: [u8; 8] = array(at(8));
        Line {
            sequence: u32::from_le_bytes(array(at(0))),
            tables_crc: u32::from_le_bytes(array(at(4))),
            fault: small[0],
            status: small[2],
            flags: small[6],
            drive: core::array::from_fn(|k| R::get_place(at(16 + k * R::BYTES))),
            correction: core::array::from_fn(scalar),
            tip: scalar(N),
            lag: scalar(N + 1),
            encoder: scalar(N + 2),
        }
    }
}
