//! Simulated machines and rehearsals on them (feature `simulation`); the loops of [`calibrate`](crate::calibrate) and
//! [`keep`](crate::keep), what a task is worth before it is set up on a machine, and a bound of the servo's remaining error
//! (feature `simulated`).
//!
//! The true machines, their probing and their drift come from `trueaxis_sim`, which knows nothing of the evaluation.

mod artefacts;
#[cfg(feature = "simulated")]
pub mod calibration;
pub mod friction;
pub mod grinding;
#[cfg(feature = "simulated")]
pub mod keeping;
pub mod rehearsal;
#[cfg(feature = "simulated")]
pub mod servo;
