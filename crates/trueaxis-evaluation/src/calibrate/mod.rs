//! Calibration with a touch probe: a task file becomes a probing program, and its log yields the errors of the machine.
//!
//! ```text
//! task.toml ─► Task ─► Plan ─► program ─► (control) ─► log ─► trips ─► network ─► Calibration ─► additions to the machine
//! ```
//!
//! The mathematics is [`trueaxis_metrology::calibration`].

mod artefact;
mod document;
mod figures;
mod foreseen;
mod kinematics;
mod log;
mod observed;
mod plan;
mod planning;
mod program;
pub(crate) mod ranges;
mod reach;
mod shown;
mod solve;
mod task;
mod terms;
mod touches;
mod trips;

pub use artefact::{Artefact, Kind, Place};
pub use document::{Document, Drift, Found, Size};
pub use figures::{Residuals, residuals};
pub use foreseen::{Expected, Foreseen, Planning, solved};
pub use kinematics::Ideal;
pub use log::{Log, Logged, read_log};
pub use observed::{Observed, observe, observe_terms};
pub use plan::{Plan, Planned, Step, Visit};
pub use program::program;
pub use solve::{Calibration, calibrate, foresee, foresee_observed, planned, settle};
pub use task::{Dialect, Probe, Reference, Task, Wanted};
pub use terms::{Pose, Term, Terms, perfect};
pub use trips::trips;
