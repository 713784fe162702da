//! Simulated machines (feature `simulation`), and the loops of [`calibrate`](crate::calibrate) and [`keep`](crate::keep) on
//! them (feature `simulated`): what a task is worth before it is set up on a machine.
//!
//! The true machines, their probing and their drift come from `trueaxis_sim`, which knows nothing of the evaluation.

#[cfg(feature = "simulated")]
pub mod calibration;
pub mod friction;
#[cfg(feature = "simulated")]
pub mod keeping;
