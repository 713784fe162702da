//! A machine under an instrument: it goes from position to position, and the instrument reads its true tool.
//!
//! The tool comes from exact products of rigid transforms; lost motion is taken up along each move, drift grows with time.
//! Drives have no lag and encoders no noise: an instrument that records slowly sees neither.

use crate::calibration::{Drift, Sent, with_correction};
use crate::error::Result;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis::machine::AXES;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// The machine, and what disturbs the instrument.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'m> {
    /// The machine with its true errors.
    pub machine: &'m Machine,
    /// The machine whose tables correct it; `None` if it is not corrected.
    pub known: Option<&'m Machine>,
    /// Drift of the workpiece from the tool.
    pub drift: Drift,
    /// Standard deviation of a reading, mm.
    pub noise_mm: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Measured<'_> {
    /// Lends out the machine at the zero of all axes, after positive travel.
    ///
    /// # Errors
    /// A machine whose geometry or tables are refused, or an error of `user`.
    pub fn walk<T>(&self, user: impl FnOnce(&mut Walk<'_>) -> Result<T>) -> Result<T> {
        match self.known {
            None => user(&mut self.started(&|position, _| *position)?),
            Some(known) => with_correction(&self.machine.settings, known, |sent| user(&mut self.started(sent)?)),
        }
    }

    fn started<'w>(&self, sent: &'w Sent<'w>) -> Result<Walk<'w>> {
        Ok(Walk {
            sent,
            geometry: Geometry::new(self.machine, 0.0)?,
            slots: self.machine.settings.axes.iter().map(|own| own.axis.index()).collect(),
            plays: plays(self.machine),
            drift: self.drift,
            noise_mm: self.noise_mm,
            noise: ChaCha8Rng::seed_from_u64(self.seed),
            at: [0.0; AXES],
            behind: [0.0; AXES],
            time_s: 0.0,
        })
    }
}

fn plays(machine: &Machine) -> [f64; AXES] {
    let mut plays = [0.0; AXES];
    machine.settings.axes.iter().for_each(|own| plays[own.axis.index()] = own.backlash.abs());
    plays
}

/// The machine at a position. Positions are X, Y, Z, A, B, C, mm and degrees.
pub struct Walk<'w> {
    sent: &'w Sent<'w>,
    geometry: Geometry,
    /// Letter of every axis of the machine, as an index.
    slots: Vec<usize>,
    plays: [f64; AXES],
    drift: Drift,
    noise_mm: f64,
    noise: ChaCha8Rng,
    at: [f64; AXES],
    /// Share of its play by which each axis lags: 0 after positive, 1 after negative travel.
    behind: [f64; AXES],
    time_s: f64,
}

impl Walk<'_> {
    /// Goes straight to a position in a time, s.
    pub fn go(&mut self, to: [f64; AXES], seconds: f64) {
        for (axis, end) in to.into_iter().enumerate() {
            let by = (end - self.at[axis]) / self.plays[axis].max(1e-6);
            self.behind[axis] = (self.behind[axis] - by).clamp(0.0, 1.0);
        }
        self.at = to;
        self.time_s += seconds;
    }

    /// Waits, s.
    pub fn wait(&mut self, seconds: f64) {
        self.time_s += seconds;
    }

    fn ordered(&self, by_letter: &[f64; AXES]) -> [f64; AXES] {
        let mut ordered = [0.0; AXES];
        for (to, letter) in ordered.iter_mut().zip(&self.slots) {
            *to = by_letter[*letter];
        }
        ordered
    }

    /// The true tip in workpiece coordinates, mm.
    pub fn tip(&self) -> DVec3 {
        let reverse = self.ordered(&self.behind);
        let sent = (self.sent)(&self.ordered(&self.at), &reverse);
        DVec3::from(self.geometry.actual_pose(&sent, &reverse).tip_mm) + self.drift.at(self.time_s)
    }

    /// The tip of a perfect machine in workpiece coordinates, mm.
    pub fn ideal(&self) -> DVec3 {
        DVec3::from(self.geometry.ideal_pose(&self.ordered(&self.at)).tip_mm)
    }

    /// True less perfect tip, in the machine's directions, mm.
    pub fn error(&self) -> DVec3 {
        let reverse = self.ordered(&self.behind);
        let at = self.ordered(&self.at);
        let sent = (self.sent)(&at, &reverse);
        let error = self.geometry.pose_error_of(&self.geometry.commanded(&at), &sent, &reverse);
        DVec3::from(error.tip_mm) + self.drift.at(self.time_s)
    }

    /// Scatter of a reading, mm.
    pub fn scatter(&mut self) -> f64 {
        let drawn: f64 = StandardNormal.sample(&mut self.noise);
        self.noise_mm * drawn
    }
}
