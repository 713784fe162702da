//! Thermal growth of the linear axes from a recorded warm-up (ISO 230-3), for the task of [`trueaxis::temperature`].
//!
//! ```text
//! e(t, q, L) = c + Σ_j [O_j(θ_j) + S_j(θ_j) (q − q0)] + Σ_k x_k (G_k + Θ_k L)
//! ```
//!
//! e is the drift of the tool relative to the workpiece along one axis at a measuring point (q, L): the axis' position and
//! the length from the spindle's nose; θ and x as in [`trueaxis::temperature`]; c a zero of every measuring point in every
//! cycle, since instruments are set to zero when a cycle begins. For given lags it is linear in everything else: least
//! squares by QR. The lags are searched one at a time, first on a grid, then by golden section. A sensor comes in when it
//! makes the cycles predict one another better: the largest gain first, each cycle predicted from the others. Curves
//! are zero at the reference temperature.
//!
//! Where only one position of an axis was measured its slope stays zero, and with one tool length the tilt.

mod basis;
mod check;
mod fit;
mod held_out;
mod linear;
mod missing;
mod model;
mod search;

pub use check::{RATE_K_PER_MIN, Refused};
pub use fit::{Coefficient, Fit, LeftOut, OfAxis, fit};
pub use held_out::{HeldOut, Series, held_out};
pub use missing::Missing;
pub use model::{AxisCurves, Model, NotEncoded, SensorCurve, Spindle};

use std::string::String;
use std::vec::Vec;
use trueaxis::Axis;

/// One reading of everything.
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

/// What a fit is told beside the record.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Temperature at which the machine's tables hold, °C.
    pub reference_c: f64,
    /// Position of X, Y, Z from which the slope counts, mm.
    pub datum_mm: [f64; 3],
    /// Cycles that take no part in the fit; the last one where none is named.
    pub held_out: Vec<u32>,
    /// Change of a sensor in a minute, K, above which, with 5 K more, it is refused as one that jumps; it becomes what is
    /// plausible of every sensor where it is above what is usual. [`RATE_K_PER_MIN`] is that of a machine tool.
    pub rate_k_per_min: f64,
}

/// Cycles that a fit needs at least: one held out, and two that predict each other.
pub const LEAST_CYCLES: usize = 3;
/// Rows of a cycle that a fit needs at least.
pub const LEAST_ROWS: usize = 12;
/// A sensor that moves less, K, has nothing to tell.
pub const LEAST_RANGE_K: f64 = 1.0;
/// Longest lag that is tried, s.
pub const LONGEST_LAG_S: f64 = 21_600.0;
/// After a longer pause, s, lags begin in equilibrium again; a pause that is neither short nor this long is refused.
pub const REST_S: f64 = 14_400.0;
/// Longest pause within a cycle, s.
pub const LONGEST_GAP_S: f64 = 1_800.0;
/// Two sensors whose readings correlate more closely tell nothing apart.
pub const COLLINEAR: f64 = 0.9995;

impl Record {
    /// Numbers of the cycles in the order of time.
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

    /// Whether the lags begin anew at a row.
    fn begins(&self, row: usize) -> bool {
        row == 0 || self.samples[row].t_s - self.samples[row - 1].t_s >= REST_S
    }

    /// Group of every row whose zero is its own: measuring point and cycle.
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
