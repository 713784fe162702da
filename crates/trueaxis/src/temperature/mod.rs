//! Thermal growth from temperatures: a slow task beside the step, its settings read in place from their file.
//!
//! A few times per second or minute the host passes its sensor readings to [`Thermal::update`], which returns a growth
//! line for every axis. The host sets these in the step ([`crate::State::set_thermal`]), and the limiter ramps them in.
//!
//! ```text
//! θ_j' = (T_j − θ_j)/τ_j                       temperature behind its lag, a sensor each
//! x_k' = (h_k(n) − x_k)/τ_s                    response to the spindle's speed, at knot k; h_k the share of the knot
//! K(q) = Σ_j O_j(θ_j) + Σ_k x_k (G_k + Θ_k L) + Σ_j S_j(θ_j) (q − q0)
//! ```
//!
//! O_j offset (mm; degrees on a rotary axis) and S_j slope (1) are curves, linear between knots; G growth and Θ tilt
//! (rad) are the steady-state values of a spindle turning at knot k, L the tool's length in mm. Errors as everywhere:
//! actual − ideal of the tool relative to the workpiece.
//!
//! `[axis.X.thermal]` of a machine, one temperature with offset and expansion
//! ([`Tcomp::growth`](crate::Tcomp::growth)), is the special case of one sensor without lag and a straight curve through
//! zero at the reference temperature. Both set the same line: the later one replaces the earlier, they are not added, and
//! a host uses only one of them.
//!
//! A sensor starts with three plausible readings that agree, over at least 2 s; until all have started, the growth is
//! zero. A step is rejected until it has lasted for an hour, and then enters through the lag.
//!
//! # File
//!
//! All numbers are little-endian integers, so that nothing in the file can be NaN or infinite:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | magic `TRUETHRM` |
//! | 2 | format version, 1 |
//! | 4 | machine id, as in the table file ([`crate::Tcomp::machine_id`]) |
//! | 1 | sensors n, 0 to 16 |
//! | 1 | axes, 1 to 6 |
//! | 1 | knots of the spindle's speed s: 0 without a spindle, else 2 to 8 |
//! | 1 | 0 |
//! | 4 | lag τ_s of the spindle's response, ms, up to 10⁹ |
//! | 4 s | the knots: speeds, rpm, ascending from 0 |
//! | | for each sensor: |
//! | 4 | lag τ, ms, up to 10⁹ |
//! | 4, 4 | lowest and highest plausible temperature, mK from 0 °C, signed |
//! | 4, 4 | plausible change: at once, mK, above 0; and in a minute, mK |
//! | 4, 4 | time without any change after which it is stuck, ms, 0: never; change of the others in that time, mK |
//! | 1 | knots k of its curves, 2 to 8 |
//! | 4 k | the knots: temperatures, mK from 0 °C, signed, ascending |
//! | | for each axis: |
//! | 1 | 0 = X to 5 = C, ascending |
//! | 8 | datum q0, 10⁻⁶ mm (degrees), signed |
//! | 8 k, n times | for each sensor at each of its knots: offset O, 10⁻⁶ mm (degrees), and slope S, 10⁻¹², signed |
//! | 8 s | at each speed: growth G, 10⁻⁶ mm (degrees), and tilt Θ, nrad, signed; both 0 at 0 rpm |
//! | 4 | CRC-32/ISO-HDLC of everything before |

#![deny(clippy::indexing_slicing)]

mod bytes;
mod error;
mod file;
mod lag;
mod layout;
mod sensor;
mod task;

pub use error::ThermalError;
pub use file::Thermal;
pub use layout::SENSORS;
pub use sensor::SensorStatus;
pub use task::{Growth, Readings, ThermalState};

bench!(use lag::{Decay, place});
bench!(use layout::{
    COLDEST_MK, FAILURES_C, FASTEST_RPM, KNOTS, LONGEST_MS, LONGEST_TOOL_MM, LONGEST_UPDATE_S, MAGIC, PERSISTS_S,
    START_READINGS, START_S, STEEPEST, VERSION, WARMEST_MK,
});

#[cfg(doc)]
use crate::compensation::ThermalLine;

#[cfg(test)]
mod tests;
