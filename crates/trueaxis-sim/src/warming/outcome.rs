//! Results of a warming.

use super::instruments::SENSORS;
use serde::Serialize;
use trueaxis_metrology::thermal::{Fit, HeldOut, Record};

/// Number of places at which a shift is judged.
const PLACES: usize = 4;

/// Drift and residual at one place, in X, Y, Z, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PointError {
    /// Without the task, relative to the beginning of the shift.
    pub drift_mm: [f64; 3],
    /// With the task: the residual.
    pub left_mm: [f64; 3],
}

/// A moment of the judged shift.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Time since the shift began, s.
    pub t_s: f64,
    /// Spindle speed, rpm.
    pub rpm: f64,
    /// Readings of the sensors, °C.
    pub temperatures_c: [f64; SENSORS.len()],
    /// Drift and residual at every place.
    pub places: [PointError; PLACES],
}

impl Moment {
    pub(super) fn take(&mut self, place: usize, axis: usize, drift_mm: f64, left_mm: f64) {
        let of = &mut self.places[place];
        (of.drift_mm[axis], of.left_mm[axis]) = (drift_mm, left_mm);
    }
}

/// The judged shift.
#[derive(Clone, Debug, Default)]
pub(super) struct Judged {
    pub(super) moments: Vec<Moment>,
    /// Largest change of a correction from cycle to cycle, mm; largest share of the limiter's slope or acceleration.
    pub(super) largest_step_mm: f64,
    pub(super) of_limits: f64,
    pub(super) unsettled: bool,
    pub(super) stopped: bool,
    pub(super) reported: bool,
    pub(super) failed: Option<&'static str>,
}

/// Results of a warming.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Outcome {
    /// The recorded shifts.
    pub record: Record,
    /// The fit to the record.
    pub found: Fit,
    /// Drift and residual in the recorded shifts, the last of them held out.
    pub recorded: Vec<HeldOut>,
    /// The judged shift.
    pub moments: Vec<Moment>,
    /// Largest drift of the judged shift over places, axes and time, and largest residual, mm.
    pub largest_mm: [f64; 2],
    /// Root mean squares of drift and residual, mm.
    pub rms_mm: [f64; 2],
    /// Largest drift and largest residual in X, Y, Z, mm.
    pub axes_mm: [[f64; 2]; 3],
    /// Largest change of a correction from one cycle of the step to the next, mm.
    pub largest_step_mm: f64,
    /// Largest share of the limiter's slope or acceleration that a correction used.
    pub of_limits: f64,
    /// Whether a correction had not settled within the cycles after an update.
    pub unsettled: bool,
    /// Whether the step requested a stop.
    pub stopped: bool,
    /// Whether the task reported anything but a good state.
    pub reported: bool,
    /// The sensor that failed.
    pub failed: Option<&'static str>,
}

impl Outcome {
    pub(super) fn new(record: Record, found: Fit, recorded: Vec<HeldOut>, judged: Judged) -> Outcome {
        let places = || judged.moments.iter().flat_map(|moment| moment.places);
        let most = |of: &dyn Fn(&PointError) -> f64| places().map(|place| of(&place).abs()).fold(0.0, f64::max);
        let axes_mm = [0, 1, 2].map(|axis| [most(&|place| place.drift_mm[axis]), most(&|place| place.left_mm[axis])]);
        let count = (3 * places().count()).max(1) as f64;
        let rms = |of: &dyn Fn(&PointError) -> [f64; 3]| {
            (places().flat_map(|place| of(&place)).map(|mm| mm * mm).sum::<f64>() / count).sqrt()
        };
        Outcome {
            largest_mm: [0, 1].map(|which| axes_mm.iter().map(|axis| axis[which]).fold(0.0, f64::max)),
            rms_mm: [rms(&|place| place.drift_mm), rms(&|place| place.left_mm)],
            axes_mm,
            record,
            found,
            recorded,
            largest_step_mm: judged.largest_step_mm,
            of_limits: judged.of_limits,
            unsettled: judged.unsettled,
            stopped: judged.stopped,
            reported: judged.reported,
            failed: judged.failed,
            moments: judged.moments,
        }
    }

    /// Largest residual divided by the largest drift.
    pub fn left_share(&self) -> f64 {
        self.largest_mm[1] / self.largest_mm[0].max(f64::MIN_POSITIVE)
    }
}
