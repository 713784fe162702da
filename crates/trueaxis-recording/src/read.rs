//! Reading a recording in place.

use crate::cycle::RecordedCycle;
use crate::{CRC, MAGIC, VERSION};
use core::fmt;
use heapless::String;
use serde::{Deserialize, Serialize};
use trueaxis::contour::Span;
use trueaxis::{Position, Real};

/// Header of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Name of the recorded program.
    pub name: String<48>,
    /// Id of the recorded machine.
    pub machine_id: u32,
    /// Number of axes, 3 to 6.
    pub axes: u8,
    /// Servo period.
    pub period_ns: u32,
    /// Number of cycles.
    pub cycles: u32,
    /// Number of spans of the path.
    pub pieces: u32,
    /// Whether the gauge's inputs are included.
    pub gauge: bool,
    /// The cycle in which the second table file is requested.
    pub exchange_at: Option<u32>,
}

/// Why a recording is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RecordingRefusal {
    /// Shorter than its header states, or than any valid recording.
    TooShort,
    /// Not a recording.
    Magic,
    /// A different version.
    Version,
    /// Wrong checksum: damaged.
    Checksum,
    /// The header cannot be read.
    Header,
    /// Lengths contradict each other.
    Length,
    /// A number of axes other than the reader's.
    Axes,
}

impl fmt::Display for RecordingRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            RecordingRefusal::TooShort => "shorter than it says",
            RecordingRefusal::Magic => "no recording",
            RecordingRefusal::Version => "a recording of another version",
            RecordingRefusal::Checksum => "damaged: the sum is wrong",
            RecordingRefusal::Header => "the header cannot be read",
            RecordingRefusal::Length => "lengths contradict each other",
            RecordingRefusal::Axes => "of another number of axes",
        })
    }
}

impl core::error::Error for RecordingRefusal {}

/// A checked recording of `N` axes, which borrows the bytes in place.
#[derive(Clone, Debug)]
pub struct Recording<'a, const N: usize> {
    header: Header,
    pieces: &'a [u8],
    cycles: &'a [u8],
}

impl<'a, const N: usize> Recording<'a, N> {
    /// Reads and checks the recording at the start of `bytes`; ignores bytes after it.
    ///
    /// # Errors
    /// The first defect found.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, RecordingRefusal> {
        let (magic, rest) = bytes.split_first_chunk::<8>().ok_or(RecordingRefusal::TooShort)?;
        if *magic != MAGIC {
            return Err(RecordingRefusal::Magic);
        }
        let (version, rest) = rest.split_first_chunk::<2>().ok_or(RecordingRefusal::TooShort)?;
        if u16::from_le_bytes(*version) != VERSION {
            return Err(RecordingRefusal::Version);
        }
        let (length, rest) = rest.split_first_chunk::<4>().ok_or(RecordingRefusal::TooShort)?;
        let length = u32::from_le_bytes(*length) as usize;
        let (content, behind) = rest.split_at_checked(length).ok_or(RecordingRefusal::TooShort)?;
        let (sum, _) = behind.split_first_chunk::<4>().ok_or(RecordingRefusal::TooShort)?;
        let summed = bytes.get(..14 + length).ok_or(RecordingRefusal::TooShort)?;
        if CRC.checksum(summed) != u32::from_le_bytes(*sum) {
            return Err(RecordingRefusal::Checksum);
        }
        let (header, rest) = postcard::take_from_bytes::<Header>(content).map_err(|_| RecordingRefusal::Header)?;
        if usize::from(header.axes) != N {
            return Err(RecordingRefusal::Axes);
        }
        let length = (header.cycles as usize)
            .checked_mul(RecordedCycle::<N>::bytes(header.gauge))
            .ok_or(RecordingRefusal::Length)?;
        let at = rest.len().checked_sub(length).ok_or(RecordingRefusal::Length)?;
        let (pieces, cycles) = rest.split_at_checked(at).ok_or(RecordingRefusal::Length)?;
        let recording = Recording { header, pieces, cycles };
        let mut read = pieces;
        for _ in 0..recording.header.pieces {
            (_, read) = piece(read).ok_or(RecordingRefusal::Length)?;
        }
        if read.is_empty() { Ok(recording) } else { Err(RecordingRefusal::Length) }
    }

    /// The header.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Cycle `number`, from 0.
    pub fn cycle(&self, number: u32) -> Option<RecordedCycle<N>> {
        let bytes = RecordedCycle::<N>::bytes(self.header.gauge);
        let start = (number as usize).checked_mul(bytes)?;
        RecordedCycle::decode(self.cycles.get(start..start.checked_add(bytes)?)?, self.header.gauge)
    }

    /// The spans of the path, in order, in the scalar and the positions of the reader's step.
    pub fn path<R: Real, P: Position>(&self) -> impl Iterator<Item = Span<R, P>> + use<'a, R, P, N> {
        let mut rest = self.pieces;
        core::iter::from_fn(move || {
            let span;
            (span, rest) = piece(rest)?;
            Some(span.rounded())
        })
    }
}

fn piece(bytes: &[u8]) -> Option<(Span<f64, f64>, &[u8])> {
    postcard::take_from_bytes(bytes).ok()
}
