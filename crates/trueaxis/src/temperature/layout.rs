//! Sizes and ranges of the file, and the times of the sensors' checks.

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
