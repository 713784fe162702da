//! Roundness and spindle error, separated by three probes.

mod angles;
mod arm;
#[cfg(feature = "std")]
pub mod circles;
pub mod filter;

pub use angles::{Band, Gain, ProbeAngles};
pub use arm::{Arm, arm_angle};
