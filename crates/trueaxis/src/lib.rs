//! Geometric error compensation and true contour error inside the servo step of an open CNC controller.
//!
//! Once per servo period the host calls [`ServoLoop::step`] with the commanded positions, the encoder readings and the
//! position on the programmed path; it returns the drive commands and the distance of the tool from its path:
//!
//! ```text
//! command ──► sample ──► compensation ───────────────────────► output ──► drives
//! encoders ─►  finite,    nine-term lookup,                     limiter,     │
//!              plausible  exact inverse      contour ► dynamic   hold        ├► feedback for the host
//!                │                             ▲                             │
//!                └──── estimated tool tip ─────┘                             └► telemetry record
//! ```
//!
//! - sample: validates commands and encoder readings: positions to work with, or a [`Fault`];
//! - compensation: error tables, direction of travel, thermal growth, exact inverse;
//! - [`contour`]: distance of the estimated tool tip, and of the plain encoder position, from the path;
//! - [`kinematics`]: on five axes, before the contour stage the tool in workpiece coordinates ([`OnToolPath`]), before the
//!   step the axes for a tool commanded there ([`ServoLoop::rtcp`]);
//! - [`roundness`]: three probes on a turning workpiece, evaluated in slices ([`GaugeRide`]);
//! - dynamic: reversal friction, following error and the contour error itself as corrections ([`Dynamics`]);
//! - limiter: magnitude, slope and acceleration of the correction; nothing ever jumps;
//! - [`telemetry`]: one fixed record per cycle;
//! - [`temperature`]: growth from temperatures, in a slow task beside the step.
//!
//! A table file ([`Tcomp`]) is checked once and built into an immutable [`ServoLoop`]; the [`State`] is separate, so that
//! tables can be exchanged in motion ([`exchange`]). The step allocates nothing, cannot panic, and its cost is bounded.
//!
//! # Stability
//!
//! What this documentation shows follows semantic versioning; `API.txt` lists it. Items that it hides, among them all
//! that the feature `bench` adds, serve the other crates of the repository and may change in any release. Vectors in
//! the interface are those of [`glam`] 0.34, so that a host's own vectors pass unchanged, and codecs report the errors
//! of postcard 1: another version of either is another version of this crate.
//!
//! # Example
//!
//! ```
#![doc = include_str!("../examples/embed.rs")]
//! ```
#![no_std]
#![forbid(unsafe_code)]
// What only the other crates of this repository use.
#![cfg_attr(not(feature = "bench"), allow(dead_code, unreachable_pub, unused_imports))]
// A build that leaves parts out does not use the code that only they call.
#![cfg_attr(
    not(all(
        feature = "grids",
        feature = "volumetric",
        feature = "rotary",
        feature = "dynamic",
        feature = "gauge",
        feature = "curves"
    )),
    allow(dead_code, unreachable_code, unreachable_patterns, unused_variables)
)]

#[cfg(any(test, feature = "std"))]
extern crate std;

/// Re-exports what only the other crates of this repository use: public and hidden with the feature `bench`, otherwise
/// of this crate alone.
macro_rules! bench {
    (use $($path:tt)+) => {
        #[cfg(feature = "bench")]
        #[doc(hidden)]
        pub use $($path)+;
        #[cfg(not(feature = "bench"))]
        pub(crate) use $($path)+;
    };
}

mod alias;
mod axis;
pub mod contour;
mod dynamic;
pub mod error;
pub mod exchange;
pub mod kinematics;
pub mod learned;
mod output;
mod part;
mod position;
mod real;
pub mod roundness;
mod step;
pub mod telemetry;
pub mod temperature;
#[cfg(test)]
#[allow(dead_code, unreachable_pub)] // `machine` is public, and in use, in `trueaxis-testing`.
mod testing;
mod vector;

// Modules of which an integrator needs no more than is re-exported below.
#[cfg(not(feature = "bench"))]
mod check;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod check;
#[cfg(not(feature = "bench"))]
mod compensation;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod compensation;
#[cfg(not(feature = "bench"))]
mod limiter;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod limiter;
#[cfg(not(feature = "bench"))]
mod machine;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod machine;
#[cfg(not(feature = "bench"))]
mod range;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod range;
#[cfg(not(feature = "bench"))]
mod sample;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod sample;
#[cfg(not(feature = "bench"))]
mod tcomp;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod tcomp;

pub use alias::{HostPath, HostServo, McuServo};
pub use axis::Axis;
pub use compensation::{Direction, PoseError, ThermalLine};
pub use dynamic::{DynamicParts, Dynamics};
pub use error::{ConfigError, Fault};
pub use glam;
pub use position::{Nanometres, Position};
pub use real::Real;
pub use sample::{EncoderScale, Input, WrappingCounter};
pub use step::{Bypass, Conditions, GaugeRide, Measure, OnToolPath, Output, Ride, ServoLoop, State};
pub use tcomp::{Tcomp, TcompError};

bench!(use machine::Row);
bench!(use part::Part);
bench!(use step::{Config, Stage});
