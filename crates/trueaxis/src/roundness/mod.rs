//! Roundness and spindle error, separated by three probes.

#[cfg(feature = "std")]
pub mod circles;
