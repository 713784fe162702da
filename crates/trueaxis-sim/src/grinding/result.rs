//! Results of a grinding run: per cycle, per turn, and for the whole run.

use super::workpiece::Harmonic;
use trueaxis::roundness::{Counts, Evaluation, GaugeFlags};

/// A cycle as passed to an observer.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'m> {
    /// Turns of the spindle since the first index pulse.
    pub turns: f64,
    /// Commands to the drives, X, Y, Z, mm.
    pub drive_mm: [f64; 3],
    /// Correction contained in the commands, tables and infeed, mm.
    pub correction_mm: [f64; 3],
    /// Infeed correction that the gauge requests, mm.
    pub infeed_mm: f64,
    /// Flags of the gauge.
    pub flags: GaugeFlags,
    /// Whether a revolution has just been evaluated.
    pub finished: bool,
    /// Counts of evaluated, skipped and discarded revolutions.
    pub counts: Counts,
    /// Infeed correction over the surface, µm.
    pub table_um: &'m [f64],
}

/// State of the surface after a turn of the spindle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Revolution {
    /// Harmonics of the true surface at the end of the turn, 0 to the last corrected one.
    pub harmonics: Vec<Harmonic>,
    /// Root mean square of the harmonics in the corrected band, µm.
    pub imprint_um: f64,
    /// Peak to valley of the true surface, all harmonics and noise, µm.
    pub roundness_um: f64,
    /// Root mean square of the same band as the gauge last evaluated it, once available, µm.
    pub gauge_imprint_um: Option<f64>,
    /// Peak to valley as the gauge evaluates it (after its filter), µm.
    pub gauge_roundness_um: Option<f64>,
}

/// Result of one run.
#[derive(Clone, Debug)]
pub struct Run {
    /// One entry per turn of the spindle.
    pub revolutions: Vec<Revolution>,
    /// Harmonics of the true surface, averaged over the last revolutions: asynchronous parts cancel.
    pub average: Vec<Harmonic>,
    /// Number of revolutions averaged.
    pub averaged: usize,
    /// Root mean square of the average in the corrected band, µm.
    pub imprint_um: f64,
    /// Mean peak to valley over the averaged revolutions, µm.
    pub roundness_um: f64,
    /// Counts of evaluated, skipped and discarded revolutions.
    pub counts: Counts,
    /// The gauge's latest evaluation.
    pub evaluation: Option<Evaluation<f64>>,
    /// Motion of the centre measured by the gauge in its latest revolution, R_X and R_Y over θ, µm.
    pub motion: [Vec<f64>; 2],
    /// Infeed correction over the surface at the end, µm.
    pub correction: Vec<f64>,
    /// True surface before and after, without mean and first harmonic, µm.
    pub surfaces: [Vec<f64>; 2],
    /// Cycles in which a correction exceeded its limit of magnitude, slope or acceleration.
    pub limits_exceeded: u64,
    /// Cycles in which the limiter bounded the infeed axis.
    pub limited_cycles: u64,
    /// All flags that the gauge raised.
    pub flags: GaugeFlags,
    /// Servo cycles.
    pub cycles: u64,
    /// Most cycles that the work on a revolution takes.
    pub cycles_of_work: usize,
}

impl Run {
    /// A run before its first turn, with the initial surface.
    pub(super) fn begun(surface: Vec<f64>, cycles_of_work: usize) -> Run {
        Run {
            revolutions: Vec::new(),
            average: Vec::new(),
            averaged: 0,
            imprint_um: 0.0,
            roundness_um: 0.0,
            counts: Counts::default(),
            evaluation: None,
            motion: [Vec::new(), Vec::new()],
            correction: Vec::new(),
            surfaces: [surface, Vec::new()],
            limits_exceeded: 0,
            limited_cycles: 0,
            flags: GaugeFlags::default(),
            cycles: 0,
            cycles_of_work,
        }
    }
}
