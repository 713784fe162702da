//! Host simulator of compensated servo cycles.
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
//! Plant and truth are written independently of the plugin; neither uses its code.

// print! and similar macros panic when the other end of a pipe is closed.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod bench;
pub mod compare;
pub mod figures;
pub mod latency;
pub mod learning_record;
pub mod outcome;
pub mod pace;
pub mod recorded;
pub mod report;
pub mod rs274;
pub mod samples;
pub mod series;
pub mod soak;
pub mod stopwatch;
pub mod trace;

pub use trueaxis_sim::{ball_test, grinding};
