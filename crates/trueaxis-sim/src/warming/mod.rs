//! Simulates a machine that warms up over several shifts, fits its thermal growth to a record, and runs a shift of another
//! kind with the task and the step in the loop.
//!
//! ```text
//! duty ─► bodies (lumped masses) ─► drift at the tip ─► probed: record ─► fit ─► task ─► step ─► residual drift
//!                      └──────────► sensors ──────────────┘               ▲
//! another duty ─► bodies ─► sensors ──────────────────────────────────────┘
//! ```
//!
//! Each body has two nodes, skin and core, which exchange heat with each other, other bodies, air and coolant. The drift is a
//! sum over lengths and their expansion. The simulation deliberately differs in form from the fitted model: it contains
//! neither a lag of a single time constant nor a curve over a sensor's temperature.

mod bodies;
mod corrected;
mod drift;
mod duty;
mod instruments;
mod iso_test;
mod outcome;

pub use instruments::SENSORS;
pub use iso_test::{IsoTest, Load};
pub use outcome::{Moment, Outcome, PointError};

use crate::error::Result;
use bodies::Bodies;
use duty::{Kind, Shift};
use instruments::{Probe, Sensors};
use std::fmt::Write;
use trueaxis::Axis;
use trueaxis_metrology::thermal::{Record, Sample, Settings, fit, held_out};
use trueaxis_tables::Machine;

/// Length of a shift, s.
pub const SHIFT_S: u32 = 28_800;
/// Rest between two shifts, s.
pub const NIGHT_S: u32 = 57_600;
/// Interval between two moments of the record, s.
pub const PROBED_EVERY_S: u32 = 300;
/// Measuring points of the record: X, Y, Z and length of the tool, mm.
pub const POINTS: [[f64; 4]; 4] =
    [[-200.0, 0.0, -200.0, 60.0], [200.0, 0.0, -200.0, 60.0], [0.0, 0.0, -380.0, 60.0], [0.0, 0.0, -200.0, 220.0]];

/// Time step of the heat simulation, s.
const STEP_S: u32 = 2;

/// Drift of an uncorrected machine over a shift, relative to its state when the shift began: every `every_s` seconds (an even
/// number) at points X, Y, Z and length of the tool, mm; error of the tool relative to the workpiece, mm.
pub fn drift_of_shift(seed: u64, every_s: u32, points: &[[f64; 4]]) -> Vec<Vec<[f64; 3]>> {
    let shift = Shift::drawn(seed, 0, Kind::Judged);
    let mut bodies = Bodies::at(shift.at(0).air_c);
    let zero: Vec<[f64; 3]> = points.iter().map(|point| drift::drift(&bodies, *point)).collect();
    let mut moments = Vec::new();
    for t in (0..=SHIFT_S).step_by(STEP_S as usize) {
        if t.is_multiple_of(every_s.max(STEP_S)) {
            let at = |(point, zero): (&[f64; 4], &[f64; 3])| {
                let now = drift::drift(&bodies, *point);
                std::array::from_fn(|axis| now[axis] - zero[axis])
            };
            moments.push(points.iter().zip(&zero).map(at).collect());
        }
        bodies.pass(f64::from(STEP_S), &shift.at(t));
    }
    moments
}

/// Settings of the simulation.
#[derive(Clone, Debug)]
pub struct Warming {
    /// The machine whose step corrects; three linear axes.
    pub machine: Machine,
    /// Seed of duty cycles and noise.
    pub seed: u64,
    /// Number of recorded shifts, of which the fit omits the last.
    pub shifts: u32,
    /// Standard deviation of a reading of the probe, µm.
    pub noise_um: f64,
    /// Interval between two updates of the task, s.
    pub update_s: u32,
    /// Index in [`SENSORS`] of a sensor that fails half-way through the judged shift.
    pub fails: Option<usize>,
}

impl Warming {
    /// Records shifts, fits a model, and runs a shift of another kind with it; reports each stage to the callback.
    ///
    /// # Errors
    /// A machine whose tables do not build; a record that the fit refuses.
    pub fn run(&self, progress: &mut dyn FnMut(&str)) -> Result<Outcome> {
        progress("recording");
        let mut bodies = Bodies::at(STARTS_C);
        let record = recorded(&Recording::of(self), &mut bodies);
        let datum = |axis: Axis| self.machine.settings.axis(axis).map_or(0.0, |of| of.thermal.datum);
        let settings = Settings {
            reference_c: self.machine.settings.reference_temperature_c,
            datum_mm: [Axis::X, Axis::Y, Axis::Z].map(datum),
            held_out: Vec::new(),
            rate_k_per_min: None,
        };
        let found = fit(&record, &settings, &mut |cause| progress(&format!("fitting: {cause}")))?;
        let bytes = found.model.encode(0).map_err(trueaxis_metrology::thermal::ThermalRefusal::Encoding)?;
        let (figures, _) = held_out(&record, &found, &bytes);
        progress("the judged shift");
        let shift = Shift::drawn(self.seed, self.shifts, Kind::Judged);
        let judged = corrected::run(self, &mut bodies, &shift, &found, &bytes)?;
        Ok(Outcome::new(record, found, figures, judged))
    }
}

/// The record of a warming: shifts, measuring points, noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Seed of duty cycles and noise.
    pub seed: u64,
    /// Number of shifts.
    pub shifts: u32,
    /// Standard deviation of a reading of the probe, µm.
    pub noise_um: f64,
    /// Measuring points: X, Y, Z and length of the tool, mm.
    pub points: Vec<[f64; 4]>,
}

/// Temperature of all bodies at the start, °C.
const STARTS_C: f64 = 20.5;

impl Recording {
    fn of(warming: &Warming) -> Recording {
        let Warming { seed, shifts, noise_um, .. } = *warming;
        Recording { seed, shifts, noise_um, points: POINTS.to_vec() }
    }

    /// Records the shifts.
    pub fn record(&self) -> Record {
        recorded(self, &mut Bodies::at(STARTS_C))
    }
}

fn recorded(of: &Recording, bodies: &mut Bodies) -> Record {
    let mut samples = Vec::new();
    let mut probe = Probe::new(of.seed, of.noise_um);
    for number in 0..of.shifts {
        let shift = Shift::drawn(of.seed, number, Kind::Recorded);
        let begins = f64::from(number) * f64::from(SHIFT_S + NIGHT_S);
        let mut sensors = Sensors::new(of.seed ^ (u64::from(number) << 8), bodies, &shift);
        // The instrument is zeroed when the shift begins.
        let zero: Vec<[f64; 3]> = of.points.iter().map(|point| drift::drift(bodies, *point)).collect();
        for t in (0..=SHIFT_S).step_by(STEP_S as usize) {
            if t.is_multiple_of(PROBED_EVERY_S) {
                let temperatures_c = sensors.read();
                for (point, zero) in of.points.iter().zip(&zero) {
                    let [x, y, z, tool_mm] = *point;
                    let now = drift::drift(bodies, *point);
                    samples.push(Sample {
                        t_s: begins + f64::from(t),
                        temperatures_c: temperatures_c.to_vec(),
                        spindle_rpm: shift.at(t).rpm,
                        cycle: number + 1,
                        position_mm: [x, y, z],
                        tool_mm,
                        error_mm: (0..3).map(|axis| probe.read(now[axis] - zero[axis])).collect(),
                    });
                }
            }
            bodies.pass(f64::from(STEP_S), &shift.at(t));
            sensors.follow(f64::from(STEP_S), bodies, &shift.at(t));
        }
        bodies.rest(&shift);
    }
    let sensors = SENSORS.map(String::from).to_vec();
    Record { sensors, axes: vec![Axis::X, Axis::Y, Axis::Z], samples }
}

/// A record in the format that `trueaxis thermal fit` reads; sensors T1 to T9 in the order of [`SENSORS`].
pub fn csv(record: &Record) -> String {
    let mut text = String::from("t_s,cycle,spindle_rpm,x_mm,y_mm,z_mm,tool_mm,ex_um,ey_um,ez_um");
    for (number, _) in (1..).zip(&record.sensors) {
        let _ = write!(text, ",T{number}_c");
    }
    text.push('\n');
    for sample in &record.samples {
        let [x, y, z] = sample.position_mm;
        let _ = write!(text, "{},{},{},{x},{y},{z},{}", sample.t_s, sample.cycle, sample.spindle_rpm, sample.tool_mm);
        for error in &sample.error_mm {
            let _ = write!(text, ",{:.3}", 1e3 * error);
        }
        for temperature in &sample.temperatures_c {
            let _ = write!(text, ",{temperature}");
        }
        text.push('\n');
    }
    text
}
