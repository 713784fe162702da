//! Figures that a run accumulates.

use super::sample::Moment;
use super::withdrawn::{Withdrawals, Withdrawn};
use trueaxis::machine::AXES;
use trueaxis::{Axis, Fault};
use trueaxis_recording::adversary::Digest;
use trueaxis_tables::limits::Clipped;

/// Size of an error over a run, in µm.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ErrorSize {
    /// Largest magnitude in µm.
    pub max_um: f64,
    /// Root mean square in µm.
    pub rms_um: f64,
}

/// Size of an angle over a run, in µrad.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AngleSize {
    /// Largest in µrad.
    pub max_urad: f64,
    /// Root mean square in µrad.
    pub rms_urad: f64,
}

/// A fault that the plugin reported, over consecutive cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultSpan {
    /// Fault code.
    pub fault: Fault,
    /// Faulty axis.
    pub axis: Axis,
    /// First cycle, counted from the start of the program.
    pub cycle: u64,
    /// Number of cycles.
    pub cycles: u64,
    /// Program line.
    pub line: u32,
}

/// Most stretches of faults that a run lists; later ones are only counted.
pub const MOST_FAULT_SPANS: usize = 1000;

/// Figures of one machine over the cycles run so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Tallies {
    /// Contour error of the true tip while cutting.
    pub error: ErrorSize,
    /// Angle between the true tool direction and the programmed one while cutting; zero for a program of X, Y, Z alone.
    pub orientation: AngleSize,
    /// Contour error of the tip that the step itself reports, while cutting.
    pub estimated: ErrorSize,
    /// Orientation error that the step itself reports, while cutting.
    pub estimated_orientation: AngleSize,
    /// Faults reported, at most [`MOST_FAULT_SPANS`] stretches.
    pub faults: Vec<FaultSpan>,
    /// Cycles with a fault outside that list.
    pub more_faults: u64,
    /// Cycles in which an axis' correction was limited.
    pub limited_cycles: u64,
    /// Amount that the magnitude limits cut off the corrections.
    pub clipped: Clipped,
    /// Whether a stop request stopped the machine.
    pub stopped: bool,
    /// Parts of the dynamic correction that the step's watch withdrew.
    pub withdrawn: Vec<Withdrawn>,
    /// The last [`super::Sample::friction`].
    pub friction: [[f32; 2]; AXES],
    /// Digest of every output of the step since the program began ([`Digest`]).
    pub digest: u32,
}

impl Tallies {
    /// Cycles with a fault, listed or not.
    pub fn fault_cycles(&self) -> u64 {
        self.faults.iter().map(|span| span.cycles).sum::<u64>() + self.more_faults
    }
}

/// Largest and root mean square of the values added.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    max: f64,
    squares: f64,
    count: u64,
}

impl Tally {
    pub(super) fn add(&mut self, value: f64) {
        self.max = self.max.max(value);
        self.squares += value * value;
        self.count += 1;
    }

    fn rms(&self) -> f64 {
        if self.count > 0 { (self.squares / self.count as f64).sqrt() } else { 0.0 }
    }

    fn length(&self) -> ErrorSize {
        ErrorSize { max_um: self.max, rms_um: self.rms() }
    }

    fn angle(&self) -> AngleSize {
        AngleSize { max_urad: self.max, rms_urad: self.rms() }
    }
}

/// Running sums for [`Tallies`].
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    pub(super) error: Tally,
    pub(super) orientation: Tally,
    pub(super) estimated: Tally,
    pub(super) estimated_orientation: Tally,
    pub(super) limited_cycles: u64,
    pub(super) clipped: Clipped,
    pub(super) stopped: bool,
    pub(super) digest: Digest,
    pub(super) withdrawals: Withdrawals,
    pub(super) friction: [[f32; 2]; AXES],
    faults: Vec<FaultSpan>,
    more_faults: u64,
}

impl Sums {
    /// Counts a cycle with a fault; consecutive ones become one stretch.
    pub(super) fn fault(&mut self, fault: Fault, axis: Axis, moment: &Moment) {
        if let Some(last) = self.faults.last_mut()
            && (last.fault, last.axis, last.cycle + last.cycles) == (fault, axis, moment.cycle)
        {
            last.cycles += 1;
        } else if self.faults.len() < MOST_FAULT_SPANS {
            self.faults.push(FaultSpan { fault, axis, cycle: moment.cycle, cycles: 1, line: moment.line });
        } else {
            self.more_faults += 1;
        }
    }

    pub(super) fn tallies(&self) -> Tallies {
        Tallies {
            error: self.error.length(),
            orientation: self.orientation.angle(),
            estimated: self.estimated.length(),
            estimated_orientation: self.estimated_orientation.angle(),
            faults: self.faults.clone(),
            more_faults: self.more_faults,
            limited_cycles: self.limited_cycles,
            clipped: self.clipped.clone(),
            stopped: self.stopped,
            withdrawn: self.withdrawals.found.clone(),
            friction: self.friction,
            digest: self.digest.value(),
        }
    }
}
