//! A plugin for the interpolator of an open motion controller.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "std"))]
extern crate std;

pub mod check;
pub mod compensation;
pub mod contour;
pub mod error;
pub mod limiter;
pub mod machine;
mod output;
pub mod position;
pub mod real;
pub mod sample;
pub mod tcomp;

pub use machine::{Axis, Row};
pub use position::{Micro, Position};
pub use real::Real;
