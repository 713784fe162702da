//! A touch probe on a simulated machine: executes a probing program and writes the log that the control would write.
//!
//! ```text
//! program ─► moves ─► exact geometry of the machine, its lost motion, drift ─► true tip ─► first touch of an artefact ─► log
//! ```
//!
//! The tip comes from exact products of rigid transforms, in workpiece coordinates, in which the artefacts are placed. The log
//! gives the axis positions at the trip. [`random_machine`] draws machines, [`volumetric`] computes their residual error.
//! The drives have no lag and the encoders no noise, because a probing move is slow.

pub(crate) mod artefact;
mod correction;
mod execute;
mod random;
mod volumetric;

pub(crate) use correction::{Sent, with_correction};

pub use artefact::Artefact;
pub use execute::{Drift, Host, Probing, execute};
pub use random::{Class, random_five_axis, random_machine};
pub use volumetric::{Errors, remaining, volumetric};
