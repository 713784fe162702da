//! Rehearsals: the record that a task would give on a machine of stated errors, with stated noise and drift, so that the task
//! and its evaluation can be practised before a machine is touched.
//!
//! ```text
//! task, nominal machine ─► program ─┐
//! true machine ─► exact transforms ─┴─► touches ─► log        (knows nothing of the evaluation)
//! ```
//!
//! The true position of the tip is the product of rigid transforms of [`trueaxis_tables::exact`]; the evaluations fit
//! first-order terms. Both share the structural code and its nominal transforms, and nothing else.

mod ballbar;
mod dial;
mod drawn;
mod feature;
mod friction;
mod instrument;
mod probing;
mod scan;
mod shop;

pub use ballbar::Circles;
pub use dial::{FilledSheet, dial};
pub use drawn::{drawn, is_stated};
pub use feature::ProbedFeature;
pub use friction::{ENCODER_UM, FrictionCircles};
pub use instrument::{Instrument, NOISE_UM};
pub use probing::{calibrate, keep};
pub use scan::Scan;
pub use shop::{Diagonals, FollowedBall, TracedPoints};

use crate::range::OutOfRange;
use anyhow::{Result, bail};
use glam::DVec3;
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_tables::Machine;

/// Drift of the workpiece relative to the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drift {
    /// Its size, µm/h, in a direction that the seed determines.
    Size(f64),
    /// In X, Y and Z, µm/h.
    Along([f64; 3]),
}

/// What disturbs the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Standard deviation of a reading, µm; `None`: as the task states it.
    pub noise_um: Option<f64>,
    /// The drift.
    pub drift: Drift,
    /// Seed of noise and of everything that is drawn.
    pub seed: u64,
    /// Number of the set-up: the artefacts' true sizes and places and the tip are drawn from it.
    pub set_up: u64,
}

/// Streams of one seed.
#[derive(Clone, Copy)]
enum Stream {
    Machine,
    SetUp,
    Tip,
    Drift,
}

impl Conditions {
    /// Checks the figures.
    ///
    /// # Errors
    /// Noise outside 0 to 1000 µm, drift outside ±1000 µm/h.
    pub fn check(&self) -> Result<(), OutOfRange> {
        OutOfRange::check("noise_um", self.noise_um, 0.0..=1000.0, "um")?;
        let (rates, least) = match self.drift {
            Drift::Size(size) => ([size; 3], 0.0),
            Drift::Along(rates) => (rates, -1000.0),
        };
        rates.into_iter().try_for_each(|rate| OutOfRange::check("drift_um_per_h", rate, least..=1000.0, "um/h"))
    }

    fn draws(&self, stream: Stream) -> Draws {
        let seed = if matches!(stream, Stream::SetUp | Stream::Tip) { self.set_up } else { self.seed };
        Draws::new(seed, stream as u64)
    }

    /// Rate of the drift, mm/h.
    fn rate(&self) -> DVec3 {
        match self.drift {
            Drift::Along(rates) => 1e-3 * DVec3::from(rates),
            Drift::Size(size) => {
                let mut draws = self.draws(Stream::Drift);
                1e-3 * size * DVec3::from_array([0; 3].map(|_| draws.normal())).normalize_or_zero()
            }
        }
    }
}

/// The true machine for a task of `nominal`: with the tool of the task, which is no error.
///
/// # Errors
/// Another structure: chain or axes.
pub fn truth_of(nominal: &Machine, truth: &Machine) -> Result<Machine> {
    let words = |machine: &Machine| machine.settings.chain.split_whitespace().collect::<Vec<_>>().join(" ");
    let [own, needed] = [truth, nominal].map(words);
    if own != needed {
        bail!(
            "found the chain {own:?}, needed {needed:?}: the true machine and the one that corrects it have one structure"
        );
    }
    let mut truth = truth.clone();
    truth.settings.tool_mm = nominal.settings.tool_mm;
    Ok(truth)
}
