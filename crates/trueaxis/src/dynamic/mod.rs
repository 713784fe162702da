//! The dynamic correction, with which the step corrects the errors of the servo in addition to those of the geometry.
//!
//! Each part is off unless it is configured, and can be switched in any cycle ([`Dynamics`]):
//!
//! - [`feed_forward`]: friction at reversals, following error, acceleration, from the intended motion of the axes;
//! - [`feedback`]: the contour error of the estimated tip as a control input;
//! - [`crosstalk`]: displacement by an axis' acceleration in the directions of other axes;
//! - a learned correction that the host looks up along its path ([`crate::Input::learned`]).
//!
//! A separate limiter limits their sum d; the axis limiter then limits the geometric correction and d together. Neither
//! correction, nor any switch, exchange or fault, makes a drive jump.
//!
//! Source: Dahl's pre-sliding friction and Stribeck's curve; contour feedback after Y. Koren, Cross-coupled biaxial computer
//! control for manufacturing systems, J. Dyn. Syst. Meas. Control 102 (1980), here on the true distance from the path.

#![deny(clippy::indexing_slicing)]

mod adapt;
mod adaptation;
mod adapted;
mod common;
mod crosstalk;
mod evidence;
mod feed_forward;
mod feedback;
mod harm;
mod parts;
mod spike;
mod stage;
mod state;
mod watch;

pub use parts::{DynamicParts, Dynamics};
pub(crate) use stage::{DynamicStage, Moment};
pub(crate) use state::DynamicState;
