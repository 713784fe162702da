//! Recorded servo cycles: the inputs of the step, with identical bits on a host and in a bare-metal image.
//!
//! A recording contains the programmed path and, cycle by cycle, the inputs of the step: commands and encoder readings
//! as integers of 1e-6 mm (1e-6 degree), alarms, switches, the position on the path, and the probes of a gauge, if any.
//! It is read in place, without allocation, from flash or a file:
//!
//! ```text
//! magic "TAXISREC" | version u16 | length u32 | header, spans of the path (postcard) | cycles | CRC-32
//! ```
//!
//! `length` counts the bytes between itself and the checksum; the checksum covers everything before it. Numbers are
//! little-endian; a cycle of N axes takes 8 N + 16 bytes, 20 more with a gauge (see [`RecordedCycle`]).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "std"))]
extern crate std;

pub mod adversary;
mod cycle;
pub mod outputs;
mod read;
#[cfg(feature = "std")]
mod received;
pub mod warming;
#[cfg(feature = "std")]
mod write;

pub use cycle::{Integer, Probe, RecordedCycle};
pub use read::{Header, Recording, RecordingRefusal};
#[cfg(feature = "std")]
pub use received::Received;
#[cfg(feature = "std")]
pub use write::Writer;

/// First bytes of a recording.
pub const MAGIC: [u8; 8] = *b"TAXISREC";
/// Version of the layout.
pub const VERSION: u16 = 1;

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
