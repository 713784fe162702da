//! A plugin for the interpolator of an open motion controller.
#![no_std]
#![forbid(unsafe_code)]

pub mod compensation;
pub mod contour;
pub mod error;
pub mod limiter;
pub mod machine;
pub mod position;
pub mod real;
pub mod tcomp;

pub use machine::{Axis, Row};
pub use position::{Micro, Position};
pub use real::Real;
