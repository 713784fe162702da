//! Thermal growth of the linear axes from a recorded warm-up (ISO 230-3), for the task of [`trueaxis::temperature`].
//!
//! ```text
//! e(t, q, L) = c + Σ_j [O_j(θ_j) + S_j(θ_j) (q − q0)] + Σ_k x_k (G_k + Θ_k L)
//! ```
//!
//! e is the drift of the tool relative to the workpiece along one axis at a measuring point (q, L): the axis' position and the
//! length from the spindle's nose; θ and x as in [`trueaxis::temperature`]; c a zero for each measuring point in each cycle,
//! because instruments are set to zero when a cycle begins. For given lags the model is linear in everything else, and least
//! squares by QR solves it. A search finds each lag on a grid and by golden section, and then optimises all lags together.
//! Sensors enter in order of gain, as long as they improve the prediction of each cycle from the others. Curves are zero at
//! the reference temperature.
//!
//! The slope of an axis stays zero if the record has only one position of it, and the tilt if it has only one tool length.

mod basis;
mod check;
mod fit;
mod held_out;
mod linear;
mod missing;
mod model;
mod repeat;
mod search;

pub use check::{RATE_K_PER_MIN, ThermalRefusal};
pub use fit::{Coefficient, Fit, LeftOut, OfAxis, fit};
pub use held_out::{HeldOut, Series, held_out};
pub use missing::Missing;
pub use model::{AxisCurves, Model, NotEncoded, SensorCurve, Spindle};
pub use repeat::{Repeatability, repeatability};

use std::string::String;
use std::vec::Vec;
use trueaxis::Axis;

/// One row of the record.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Time, s, ascending.
    pub t_s: f64,
    /// Temperatures of the sensors, °C.
    pub temperatures_c: Vec<f64>,
    /// Speed of the spindle, rpm.
    pub spindle_rpm: f64,
    /// Number of the duty cycle.
    pub cycle: u32,
    /// Positions of X, Y, Z at the measuring point, mm.
    pub position_mm: [f64; 3],
    /// Length from the spindle's nose to the measuring point, mm.
    pub tool_mm: f64,
    /// Drift in the recorded axes, in their order, mm: tool relative to workpiece, actual − ideal.
    pub error_mm: Vec<f64>,
}

/// A record.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Names of the sensors, without unit.
    pub sensors: Vec<String>,
    /// Linear axes with a recorded drift.
    pub axes: Vec<Axis>,
    /// Readings in order of time.
    pub samples: Vec<Sample>,
}

/// Settings of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Temperature at which the machine's tables apply, °C.
    pub reference_c: f64,
    /// Position of X, Y, Z at which the slope's contribution is zero, mm.
    pub datum_mm: [f64; 3],
    /// Cycles excluded from the fit; if empty, the last one. If it has every cycle, each is excluded in turn: causes and lags
    /// are those with which the others predict it best, summed over all, and the model is that of all cycles.
    pub held_out: Vec<u32>,
    /// Largest plausible change of a sensor per minute, K: a change that exceeds it by more than 5 K is refused as a jump. If
    /// larger than the usual plausible change, it also becomes that of every sensor in the model. `None`:
    /// [`RATE_K_PER_MIN`], which suits a machine tool, or twice the rate that the sensor itself shows at another time.
    pub rate_k_per_min: Option<f64>,
}

/// Least number of cycles: one held out, and two that predict each other.
pub const LEAST_CYCLES: usize = 3;
/// Least number of rows per cycle.
pub const LEAST_ROWS: usize = 12;
/// A sensor that moves less than this, K, is not used.
pub const LEAST_RANGE_K: f64 = 1.0;
/// Longest lag tried, s.
pub const LONGEST_LAG_S: f64 = 21_600.0;
/// After a pause of at least this, s, lags start in equilibrium again; a pause between [`LONGEST_GAP_S`] and this is refused.
pub const REST_S: f64 = 14_400.0;
/// Longest pause within a cycle, s.
pub const LONGEST_GAP_S: f64 = 1_800.0;
/// Two sensors whose readings correlate more closely than this are inseparable.
pub const COLLINEAR: f64 = 0.9995;

impl Record {
    /// Returns the cycle numbers in order of time.
    pub fn cycles(&self) -> Vec<u32> {
        let mut cycles: Vec<u32> = Vec::new();
        for sample in &self.samples {
            if !cycles.contains(&sample.cycle) {
                cycles.push(sample.cycle);
            }
        }
        cycles
    }

    /// Readings of one sensor.
    fn readings(&self, sensor: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        self.samples.iter().map(move |sample| sample.temperatures_c.get(sensor).copied().unwrap_or(f64::NAN))
    }

    /// Whether the lags restart at a row.
    fn begins(&self, row: usize) -> bool {
        row == 0 || self.samples[row].t_s - self.samples[row - 1].t_s >= REST_S
    }

    /// Group of each row, by measuring point and cycle: each group has a separate zero.
    fn groups(&self) -> Vec<usize> {
        let mut keys: Vec<([u64; 4], u32)> = Vec::new();
        let group = |sample: &Sample| {
            let [x, y, z] = sample.position_mm;
            let key = ([x, y, z, sample.tool_mm].map(f64::to_bits), sample.cycle);
            keys.iter().position(|known| *known == key).unwrap_or_else(|| {
                keys.push(key);
                keys.len() - 1
            })
        };
        self.samples.iter().map(group).collect()
    }
}

fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}
