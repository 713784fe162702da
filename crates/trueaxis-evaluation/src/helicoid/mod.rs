//! Involute helicoids on five axes: checks a request; computes displacements over a grid, as document, CSV and program; shows
//! the tool at one place of the flank, and the effects of a machine's travel and geometry.
//!
//! The mathematics is [`trueaxis_metrology::helicoid`].

mod apart;
pub mod document;
mod flank;
mod grid;
mod job;
mod machine;
mod plots;
mod program;
mod request;
mod shown;
mod surface;
mod tool;
mod travel;

pub use document::{HelicoidDocument, Point};
pub use flank::{Errors, Flanked, flank};
pub use grid::{MOST, Range, is_coarse};
pub use job::Job;
pub use machine::{Fit, adapted, fit};
pub use request::{Passes, Request};
pub use tool::{BranchPose, Singular, Tool};
pub use travel::{AxisReach, Beyond, Limits, Reach};
