//! Roundness and spindle error, separated by three probes.

mod angles;
mod arm;
#[cfg(feature = "std")]
pub mod circles;
pub mod filter;
#[cfg(feature = "rustfft")]
pub mod offline;
#[cfg(feature = "std")]
pub mod pair_search;
#[cfg(feature = "std")]
pub mod spindle_offline;

pub use angles::{Band, Gain, ProbeAngles};
pub use arm::{Arm, arm_angle};
