//! The loops of [`calibrate`](crate::calibrate) and [`keep`](crate::keep) on simulated machines (feature `simulated`), what a
//! task is worth before it is set up on a machine; and a bound of what the servo leaves.
//!
//! The true machines, their probing and their drift come from `trueaxis_sim`, which knows nothing of the evaluation.

pub mod calibration;
pub mod keeping;
pub mod servo;
