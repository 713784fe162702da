//! Settings of an evaluation.

use anyhow::{Result, bail};
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// Settings of an evaluation. Arrays of positions are by [`Axis::index`].
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// A position to evaluate besides the worst one, mm and degrees.
    pub at: Option<[f64; AXES]>,
    /// Working volume along X, Y and Z, mm; by default the travel.
    pub volume_mm: [Option<[f64; 2]>; 3],
    /// Positions of the rotary axes over the working volume, degrees; 0 by default.
    pub pose_deg: Vec<(Axis, f64)>,
    /// Points along each linear axis.
    pub points: usize,
    /// Coverage, 0.5 … 0.9999.
    pub coverage: f64,
    /// Number of machines drawn.
    pub trials: usize,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        let volume_mm = [None; 3];
        Options { at: None, volume_mm, pose_deg: Vec::new(), points: 9, coverage: 0.95, trials: 10_000, seed: 1 }
    }
}

/// Range of coverages accepted.
const COVERAGES: [f64; 2] = [0.5, 0.9999];
/// Range of trials: from enough for a quantile to what takes a minute.
const TRIALS: [usize; 2] = [100, 1_000_000];

impl Options {
    pub(super) fn check(&self, machine: &Machine) -> Result<()> {
        let [low, high] = COVERAGES;
        if !(low..=high).contains(&self.coverage) {
            let percent = 100.0 * self.coverage;
            bail!("confidence: found {percent} %, needed {} to {} %", 100.0 * low, 100.0 * high);
        }
        let [low, high] = TRIALS;
        if !(low..=high).contains(&self.trials) {
            bail!("trials: found {}, needed {low} to {high}", self.trials);
        }
        for (range, letter) in self.volume_mm.iter().zip(['X', 'Y', 'Z']) {
            if let Some([low, high]) = range
                && (low >= high || low.abs().max(high.abs()) > 1e6)
            {
                bail!("volume: found {letter} {low} to {high}, needed a rising range within 1e6 mm");
            }
        }
        for (axis, degrees) in &self.pose_deg {
            let own = machine.settings.axis(*axis).filter(|own| own.axis.is_rotary());
            let Some(own) = own else { bail!("pose: found {}, needed a rotary axis of the machine", axis.letter()) };
            let [low, high] = own.travel;
            if !(low..=high).contains(degrees) {
                bail!("pose: found {} {degrees}, needed its travel, {low} to {high} degrees", axis.letter());
            }
        }
        Ok(())
    }
}
