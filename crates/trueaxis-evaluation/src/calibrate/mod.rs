//! Calibration with a touch probe: a task file becomes a probing program, and its log yields the errors of the machine.
//!
//! ```text
//! task.toml ─► Task ─► Plan ─► program ─► (control) ─► log ─► trips ─► network ─► Calibration ─► additions to the machine
//! ```
//!
//! The mathematics is [`trueaxis_metrology::calibration`].

mod angles;
mod artefact;
mod block;
mod chosen;
mod dial;
mod document;
mod faces;
mod figures;
mod foreseen;
mod grid;
mod kinematics;
mod log;
mod middles;
mod observed;
mod place;
mod plan;
mod planning;
mod program;
pub(crate) mod ranges;
mod reach;
mod shapes;
mod sheet;
mod shown;
mod solve;
mod source;
pub(crate) mod stylus;
mod target;
mod task;
mod terms;
mod touches;
mod trips;
mod unseen;
mod wishes;

pub use artefact::{Artefact, Kind};
pub use block::{ANGLES, Block, directions};
pub use chosen::{CentreLine, Choice, Chosen, ChosenDocument, chosen};
pub use dial::{Dial, DialKind, Reading};
pub use document::{CalibrationDocument, Drift, Size, SolvedTerm};
pub use figures::{Residuals, residuals};
pub use foreseen::{Expected, Foreseen, Planning, foresee, foresee_observed, planned};
pub use grid::Grid;
pub use kinematics::Ideal;
pub use log::{Log, Logged, read_log};
pub use observed::{Observed, observe, observe_terms};
pub use place::Place;
pub use plan::{Plan, Planned, Step, Visit};
pub use program::program;
#[cfg(feature = "simulated")]
pub(crate) use sheet::{reading, sheet};
pub use solve::{Calibration, calibrate, settle, solved};
pub use task::{Dialect, Probe, Reference, Task, Wanted};
pub use terms::{Pose, Term, Terms, perfect};
pub use trips::trips;
pub use wishes::Wishes;
