//! Writing a recording on the host.

use crate::cycle::RecordedCycle;
use crate::read::Header;
use crate::{CRC, MAGIC, VERSION};
use std::vec::Vec;
use trueaxis::contour::Span;

/// Collects cycles into a recording of `N` axes.
#[derive(Clone, Debug)]
pub struct Writer<const N: usize> {
    header: Header,
    pieces: Vec<u8>,
    cycles: Vec<u8>,
}

impl<const N: usize> Writer<N> {
    /// Begins a recording; fills in the header's numbers of axes, cycles and spans.
    ///
    /// # Errors
    /// As postcard, if a span cannot be written.
    pub fn new(header: Header, path: &[Span<f64, f64>]) -> postcard::Result<Self> {
        let mut pieces = Vec::new();
        let mut buffer = [0; 512];
        for span in path {
            pieces.extend_from_slice(postcard::to_slice(span, &mut buffer)?);
        }
        let header = Header { axes: N as u8, cycles: 0, pieces: path.len() as u32, ..header };
        Ok(Writer { header, pieces, cycles: Vec::new() })
    }

    /// Adds a cycle.
    pub fn add(&mut self, cycle: &RecordedCycle<N>) {
        cycle.encode(self.header.gauge, &mut self.cycles);
        self.header.cycles += 1;
    }

    /// Number of cycles so far.
    pub fn cycles(&self) -> u32 {
        self.header.cycles
    }

    /// The recording's bytes.
    ///
    /// # Errors
    /// As postcard, if the header cannot be written.
    pub fn finish(self) -> postcard::Result<Vec<u8>> {
        let mut buffer = [0; 128];
        let header = postcard::to_slice(&self.header, &mut buffer)?;
        let length = (header.len() + self.pieces.len() + self.cycles.len()) as u32;
        let mut bytes = Vec::with_capacity(18 + length as usize);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(length.to_le_bytes());
        bytes.extend_from_slice(header);
        bytes.extend(self.pieces);
        bytes.extend(self.cycles);
        let sum = CRC.checksum(&bytes);
        bytes.extend(sum.to_le_bytes());
        Ok(bytes)
    }
}
