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
//! - [`sample`]: validates commands and encoder readings: positions to work with, or a [`Fault`];
//! - [`compensation`]: error tables, direction of travel, thermal growth, exact inverse;
//! - [`contour`]: distance of the estimated tool tip, and of the plain encoder position, from the path;
//! - [`kinematics`]: on five axes, before the contour stage the tool in workpiece coordinates ([`OnToolPath`]), before the
//!   step the axes for a tool commanded there ([`ServoLoop::rtcp`]);
//! - [`roundness`]: three probes on a turning workpiece, evaluated in slices ([`GaugeRide`]);
//! - dynamic: reversal friction, following error and the contour error itself as corrections ([`Dynamics`]);
//! - [`limiter`]: magnitude, slope and acceleration of the correction; nothing ever jumps;
//! - [`telemetry`]: one fixed record per cycle;
//! - [`temperature`]: growth from temperatures, in a slow task beside the step.
//!
//! A [`Config`] is checked once and built into an immutable [`ServoLoop`]; the [`State`] is separate, so that tables
//! can be exchanged in motion ([`exchange`]). The step allocates nothing, cannot panic, and its cost is bounded.
//!
//! # Example
//!
//! ```
#![doc = include_str!("../examples/embed.rs")]
//! ```
#![no_std]
#![forbid(unsafe_code)]
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

mod axis;
pub mod check;
pub mod compensation;
pub mod contour;
mod dynamic;
pub mod error;
pub mod exchange;
pub mod kinematics;
pub mod learned;
pub mod limiter;
pub mod machine;
mod output;
mod part;
pub mod position;
pub mod range;
pub mod real;
pub mod roundness;
pub mod sample;
mod step;
pub mod tcomp;
pub mod telemetry;
pub mod temperature;
#[cfg(test)]
#[allow(dead_code, unreachable_pub)] // `machine` is public, and in use, in `trueaxis-testing`.
mod testing;
mod vector;

pub use glam;

mod alias;
pub use alias::{HostInput, HostPath, HostServo, HostState, McuInput, McuPath, McuServo, McuState};
pub use dynamic::{DynamicParts, Dynamics};
pub use error::{ConfigError, Fault};
pub use machine::{Axis, Row};
pub use part::Part;
pub use position::{Nanometres, Position};
pub use real::Real;
pub use sample::Input;
pub use step::{Bypass, Conditions, Config, GaugeRide, Measure, OnToolPath, Output, Ride, ServoLoop, Stage, State};
