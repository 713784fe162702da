//! A family of plants about the figures that a machine states.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use serde::Serialize;
use std::fmt;
use trueaxis::machine::{AXES, Axis, MachineSettings};
use trueaxis_sim::SimError;
use trueaxis_sim::error::Result;
use trueaxis_sim::plant::drive::DriveSettings;
use trueaxis_sim::plant::stated;

/// Figures of a drive that the family varies.
pub(super) const FIGURES: usize = 6;

/// How far the drives of a family are from their figures; every figure of every axis varies independently.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Family {
    /// Gains of position and velocity loop, share of the figure.
    pub gains: f64,
    /// Coulomb and viscous friction.
    pub friction: f64,
    /// Pre-sliding.
    pub presliding: f64,
    /// Resonance of motor and load on every axis, Hz; 0: rigid drives.
    pub resonance_hz: f64,
    /// Damping of the resonance, share of critical.
    pub resonance_damping: f64,
    /// The resonance's frequency.
    pub resonance: f64,
    /// The resonance's damping.
    pub damping: f64,
}

impl Default for Family {
    /// Rigid drives: gains ±10 %, friction ±50 %, pre-sliding ±30 %; a resonance, if stated, ±10 %, its damping ±50 %.
    fn default() -> Family {
        Family {
            gains: 0.1,
            friction: 0.5,
            presliding: 0.3,
            resonance_hz: 0.0,
            resonance_damping: 0.03,
            resonance: 0.1,
            damping: 0.5,
        }
    }
}

/// Where each figure of each axis is within the family, −1 to 1.
pub(super) type Place = [[f64; FIGURES]; AXES];

impl Family {
    /// Refuses a family out of range.
    ///
    /// # Errors
    /// The first such figure, with its option's name.
    pub(super) fn check(&self) -> Result<()> {
        let spreads = [
            ("--gains", self.gains),
            ("--friction", self.friction),
            ("--presliding", self.presliding),
            ("--resonance", self.resonance),
            ("--damping", self.damping),
        ];
        if let Some((name, spread)) = spreads.into_iter().find(|(_, spread)| !(0.0..=0.9).contains(spread)) {
            let found = format!("{} %", 100.0 * spread);
            return Err(unsuited(name, found, "0 to 90 % of the figure"));
        }
        let hz = self.resonance_hz;
        if hz != 0.0 && !(10.0..=2000.0).contains(&hz) {
            return Err(unsuited("--resonance-hz", format!("{hz} Hz"), "10 to 2000 Hz"));
        }
        let damping = self.resonance_damping;
        if !(0.005..=0.5).contains(&damping) {
            return Err(unsuited("--resonance-damping", damping.to_string(), "0.005 to 0.5 of critical"));
        }
        if self.spreads().iter().all(|spread| *spread == 0.0) {
            return Err(unsuited("the family", "one plant".into(), "a figure that varies"));
        }
        Ok(())
    }

    /// The spread of each figure, in the order of a [`Place`].
    fn spreads(&self) -> [f64; FIGURES] {
        let of_resonance = |spread| if self.resonance_hz > 0.0 { spread } else { 0.0 };
        let (resonance, damping) = (of_resonance(self.resonance), of_resonance(self.damping));
        [self.gains, self.gains, self.friction, self.presliding, resonance, damping]
    }

    /// Axis and figure of everything that varies, on these axes.
    pub(super) fn varied(&self, axes: &[Axis]) -> Vec<(usize, usize)> {
        let varies = |figure: &usize| self.spreads()[*figure] > 0.0;
        axes.iter().flat_map(|axis| (0..FIGURES).filter(varies).map(|figure| (axis.index(), figure))).collect()
    }

    /// The drives at a place of the family.
    pub(super) fn drives(&self, about: &[DriveSettings; AXES], place: &Place) -> [DriveSettings; AXES] {
        let spreads = self.spreads();
        std::array::from_fn(|axis| {
            let factor = |figure: usize| 1.0 + spreads[figure] * place[axis][figure];
            let own = about[axis];
            DriveSettings {
                position_gain_per_s: own.position_gain_per_s * factor(0),
                velocity_gain_per_s: own.velocity_gain_per_s * factor(1),
                coulomb_mm_per_s2: own.coulomb_mm_per_s2 * factor(2),
                viscous_per_s: own.viscous_per_s * factor(2),
                presliding_mm: own.presliding_mm * factor(3),
                resonance_hz: own.resonance_hz * factor(4),
                resonance_damping: own.resonance_damping * factor(5),
                ..own
            }
        })
    }

    /// Places drawn from the family, every figure evenly.
    pub(super) fn draw(seed: u64, count: usize) -> Vec<Place> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut signed = || 2.0 * (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 1.0;
        (0..count).map(|_| std::array::from_fn(|_| std::array::from_fn(|_| signed()))).collect()
    }

    /// The drives about which the family lies: those that the machine states, each axis its own.
    pub(super) fn about(&self, machine: &MachineSettings) -> [DriveSettings; AXES] {
        Axis::ALL.map(|axis| {
            let (resonance_hz, resonance_damping) = (self.resonance_hz, self.resonance_damping);
            DriveSettings { resonance_hz, resonance_damping, ..stated(machine, axis) }
        })
    }
}

fn unsuited(what: &str, found: String, needed: &str) -> SimError {
    SimError::Unsuited { what: what.into(), found, needed: needed.into() }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [gains, friction, presliding, resonance, damping] =
            [self.gains, self.friction, self.presliding, self.resonance, self.damping].map(|of| (100.0 * of).round());
        write!(f, "gains ±{gains} %, friction ±{friction} %, pre-sliding ±{presliding} % of the machine's figures")?;
        if self.resonance_hz > 0.0 {
            let (hz, of_critical) = (self.resonance_hz, 100.0 * self.resonance_damping);
            return write!(f, ", resonance {hz} Hz ±{resonance} % with {of_critical:.1} % damping ±{damping} %");
        }
        write!(f, ", rigid drives")
    }
}
