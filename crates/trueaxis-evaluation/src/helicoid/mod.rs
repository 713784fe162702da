//! Involute helicoids on five axes: a request, checked; displacements over a grid, as document, CSV and program; the tool at
//! one place of the flank, and what a machine's geometry makes of it.
//!
//! The mathematics is that of [`trueaxis_metrology::helicoid`].

//pub mod curve;
pub mod document;
//mod flank;
mod grid;
mod job;
//mod machine;
mod program;
mod request;
//pub mod surface;
//pub mod tool;
//pub mod travel;

//pub use curve::Along;
pub use document::{Document, Point};
//pub use flank::{Flanked, flank};
pub use grid::{MOST, Range, is_coarse};
pub use job::Job;
//pub use machine::{Fit, adapted, fit};
pub use program::Passes;
pub use request::Request;
