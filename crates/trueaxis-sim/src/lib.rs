//! Simulation of compensated servo cycles, as a library without a clock or a thread; only [`program::Source`] and
//! [`program::ReadOptions::from_files`] open files.
//!
//! A G-code program is interpolated at the servo rate, every cycle goes through the plugin's `step` against a simulated
//! machine, and the machine's *true* tool tip is compared with the programmed path:
//!
//! ```text
//! program ─► motion ─► step (the plugin) ─► plant: drives, exact geometry, encoders ─► true tip ─► truth: contour error
//!                        ▲                                     │
//!                        └───────────── readings ◄─────────────┘
//! ```
//!
//! Plant and truth are independent of the plugin; neither uses its code.
//!
//! [`run`] simulates a part program, [`grinding`] a crankpin under the three-probe gauge, [`ball_test`] the test of a
//! five-axis head, [`friction`] circles from which friction is identified, [`warming`] shifts over which a machine grows,
//! [`exchange`] new tables in motion, [`measured`] a machine under an instrument. Equal inputs and seeds give equal
//! results on every host, including browsers: angles and exponentials come from libm, not from the host.
//!
//! The crate's README shows a run from tables to figures.

// print! and similar macros panic when the other end of a pipe is closed.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod ball_test;
pub mod calibration;
pub mod error;
pub mod event;
pub mod exchange;
pub mod friction;
pub mod grinding;
mod learned;
pub mod learning;
mod limit_watch;
pub mod measured;
mod message;
pub mod motion;
pub mod path;
pub mod placement;
pub mod plant;
pub mod program;
mod range;
pub mod run;
pub mod scenario;
pub mod script;
pub mod servo;
pub mod settings;
pub mod truth;
pub mod warming;

pub use error::SimError;
pub use scenario::Scenario;
pub use settings::Settings;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
