//! The dynamic correction: what the step adds to a command so that the servo, and not only the geometry, comes out true.
//!
//! Each part is off unless it is configured, and is switched in any cycle ([`Dynamics`]):
//!
//! - [`feed_forward`]: friction at reversals, following error, acceleration, from where the axes are to go;
//! - [`feedback`]: the contour error of the estimated tip as a control input;
//! - [`crosstalk`]: what an axis' acceleration moves in the others' directions;
//! - a learned correction that the host looks up along its path ([`crate::Input::learned`]).
//!
//! Their sum d has a limiter of its own; the geometric correction and d together pass that of the axis. Neither of them, nor
//! any switch, exchange or fault, makes a drive jump.
//!
//! Source: Dahl's pre-sliding friction and Stribeck's curve; contour feedback after Y. Koren, Cross-coupled biaxial computer
//! control for manufacturing systems, J. Dyn. Syst. Meas. Control 102 (1980), here on the true distance from the path.

#![deny(clippy::indexing_slicing)]

mod crosstalk;
mod feed_forward;
mod feedback;
mod parts;
mod stage;
mod state;
mod watch;

pub use parts::{DynamicParts, Dynamics};
pub(crate) use stage::{DynamicStage, Moment};
pub(crate) use state::DynamicState;
