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
//! `[axis.X.thermal]` of a machine, one temperature with offset and expansion ([`ThermalLine::for_axis`]), is the special
//! case of one sensor without lag and a straight curve through zero at the reference temperature. Both set the same line:
//! the later one replaces the earlier, they are not added, and a host uses only one of them.
//!
//! A sensor starts with [`START_READINGS`] plausible readings that agree, over at least [`START_S`]; until all have
//! started, the growth is zero. A step is rejected until it has lasted for [`PERSISTS_S`], and then enters through the
//! lag.
//!
//! # File
//!
//! All numbers are little-endian integers, so that nothing in the file can be NaN or infinite:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | magic `TRUETHRM` |
//! | 2 | format version, 1 |
//! | 4 | machine id, as in the table file ([`crate::tcomp::machine_id`]) |
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
mod sensor;
mod task;

pub use error::ThermalError;
pub use file::Thermal;
pub use lag::{Decay, place};
pub use sensor::SensorStatus;
pub use task::{Growth, Readings, ThermalState};

#[cfg(doc)]
use crate::compensation::ThermalLine;

/// First eight bytes of the file.
pub const MAGIC: [u8; 8] = *b"TRUETHRM";
/// Format version.
pub const VERSION: u16 = 1;
/// Maximum number of sensors.
pub const SENSORS: usize = 16;
/// Maximum number of knots of a curve.
pub const KNOTS: usize = 8;
/// Longest lag and longest time of a stuck sensor, ms: eleven days.
pub const LONGEST_MS: u32 = 1_000_000_000;
/// Coldest temperature of the file, mK from 0 °C.
pub const COLDEST_MK: i32 = -100_000;
/// Warmest temperature of the file, mK from 0 °C.
pub const WARMEST_MK: i32 = 300_000;
/// Highest speed of the file, rpm.
pub const FASTEST_RPM: u32 = 1_000_000;
/// Largest slope of a knot, 10⁻¹²: [`crate::compensation::ThermalLine::SLOPE_LIMIT`].
pub const STEEPEST: i32 = 1_000_000_000;
/// Longest tool used with the spindle's tilt, mm.
pub const LONGEST_TOOL_MM: f64 = 1e4;
/// Readings that mean no reading, °C: the power-on value of a DS18B20, and an input that its driver has not written. They
/// are accepted if they are within the plausible immediate change of the last accepted reading. −127 °C, a disconnected
/// DS18B20, is outside every plausible range.
pub const FAILURES_C: [f64; 2] = [85.0, 0.0];
/// Readings with which a sensor starts: plausible, each within the plausible change from the previous one.
pub const START_READINGS: u8 = 3;
/// Shortest time over which they are spread, s.
pub const START_S: f64 = 2.0;
/// Time after which a step is accepted, s, if as many readings as for a start, each within the plausible change from the
/// previous one, confirm it and are not all bitwise equal.
pub const PERSISTS_S: f64 = 3600.0;
/// Longest time between two updates, s: a day; after a longer time the task restarts.
pub const LONGEST_UPDATE_S: f64 = 86_400.0;

#[cfg(test)]
mod tests;
