//! Results of a grinding run: of a cycle, of a turn, of the whole run.

use super::workpiece::Harmonic;
use trueaxis::roundness::{Counts, Evaluation, GaugeFlags};

/// A cycle as an observer sees it.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'m> {
    /// Turns of the spindle since the first index pulse.
    pub turns: f64,
    /// Commands to the drives, X, Y, Z, mm.
    pub drive_mm: [f64; 3],
    /// Correction in it, tables and infeed, mm.
    pub correction_mm: [f64; 3],
    /// Infeed correction that the gauge asks for, mm.
    pub infeed_mm: f64,
    /// GaugeFlags of the gauge.
    pub flags: GaugeFlags,
    /// A revolution has just been evaluated.
    pub finished: bool,
    /// Counts of revolutions evaluated, skipped, discarded.
    pub counts: Counts,
    /// Infeed correction over the surface, µm.
    pub table_um: &'m [f64],
}

/// State of the surface after a turn of the spindle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Revolution {
    /// Harmonics of the true surface at its end, 0 to the last that is corrected.
    pub harmonics: Vec<Harmonic>,
    /// Root mean square of those in the corrected band, µm.
    pub imprint_um: f64,
    /// Peak to valley of the true surface, all harmonics and noise, µm.
    pub roundness_um: f64,
    /// The gauge's latest figures, once it has any: the same band, µm.
    pub gauge_imprint_um: Option<f64>,
    /// Peak to valley as the gauge evaluates it (after its filter), µm.
    pub gauge_roundness_um: Option<f64>,
}

/// Result of one run.
#[derive(Clone, Debug)]
pub struct Run {
    /// One entry a turn of the spindle.
    pub revolutions: Vec<Revolution>,
    /// Harmonics of the true surface, averaged over the last revolutions: asynchronous parts cancel.
    pub average: Vec<Harmonic>,
    /// Number of revolutions averaged.
    pub averaged: usize,
    /// Root mean square of the average in the corrected band, µm.
    pub imprint_um: f64,
    /// Mean peak to valley over the same revolutions, µm.
    pub roundness_um: f64,
    /// Counts of revolutions evaluated, skipped, discarded.
    pub counts: Counts,
    /// The gauge's latest evaluation.
    pub evaluation: Option<Evaluation<f64>>,
    /// Motion of the centre as the gauge sees it in its latest revolution, R_X and R_Y over θ, µm.
    pub motion: [Vec<f64>; 2],
    /// Infeed correction over the surface at the end, µm.
    pub correction: Vec<f64>,
    /// True surface before and after, without mean and first harmonic, µm.
    pub surfaces: [Vec<f64>; 2],
    /// Cycles in which a correction passed its limit of magnitude, slope or acceleration.
    pub limits_exceeded: u64,
    /// Cycles in which the limiter bounded the infeed axis.
    pub limited_cycles: u64,
    /// All flags that the gauge raised.
    pub flags: GaugeFlags,
    /// Servo cycles.
    pub cycles: u64,
    /// Cycles that the work on a revolution takes at most.
    pub cycles_of_work: usize,
}

impl Run {
    /// Before the first turn, with the surface as it is then.
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
