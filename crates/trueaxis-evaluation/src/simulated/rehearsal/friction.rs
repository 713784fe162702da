//! Records of circles on drives with friction.

use super::Conditions;
use crate::calibrate::perfect;
use crate::range::OutOfRange;
use anyhow::{Result, anyhow, bail};
use trueaxis::Axis;
use trueaxis::machine::AxisSettings;
use trueaxis_sim::friction::{Circles, Pass, Plane, Recorder, joined};
use trueaxis_sim::plant::drive::DriveSettings;
use trueaxis_sim::plant::variation::Variation;
use trueaxis_sim::run::Kind;
use trueaxis_sim::{Settings, SimError};
use trueaxis_tables::Machine;

/// Noise of an encoder where none is stated, µm.
pub const ENCODER_UM: f64 = 0.005;
/// Cycles between two reports of the progress.
const STRETCH: u64 = 4096;

/// Circles at two feeds, each in both directions, on the drives that a machine states.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionCircles {
    /// The plane of the circles.
    pub axes: [Axis; 2],
    /// Radius, mm.
    pub radius_mm: f64,
    /// The two feeds, mm/min.
    pub feeds_mm_per_min: Vec<f64>,
    /// Turns of every circle.
    pub turns: u32,
    /// Rate of the record, Hz.
    pub rate_hz: f64,
}

impl FrictionCircles {
    /// The record, in the format that `trueaxis friction` reads: integrated drives with the figures and the friction of
    /// `[axis.X.drive]` and `[axis.X.friction]` of `truth`; noise and seed are those of the encoders.
    ///
    /// # Errors
    /// Figures out of their range, a machine that does not state drive or friction of an axis.
    pub fn record(&self, truth: &Machine, conditions: &Conditions, progress: &dyn Fn(f64)) -> Result<String> {
        let plane = match self.axes {
            [Axis::X, Axis::Y] => Plane::Xy,
            [Axis::Z, Axis::X] => Plane::Zx,
            [Axis::Y, Axis::Z] => Plane::Yz,
            [one, other] => bail!("--axes: found {},{}, needed X,Y, Z,X or Y,Z", one.letter(), other.letter()),
        };
        OutOfRange::check("rate_hz", self.rate_hz, 500.0..=100_000.0, "Hz").map_err(|wrong| wrong.option())?;
        let circles = Circles::new(plane, self.radius_mm, &self.feeds_mm_per_min, self.turns).map_err(named)?;
        let mut machine = perfect(truth);
        machine.settings.axes.iter_mut().for_each(|own| own.servo = Default::default());
        machine.settings.contour.feedback = None;
        machine.settings.crosstalk.clear();
        // The drives do not act on each other: a pass for each axis, with its own drive.
        let mut passes = Vec::new();
        for (done, axis) in self.axes.into_iter().enumerate() {
            let own = truth.settings.axis(axis);
            let own = own.ok_or_else(|| anyhow!("found a machine without {}, needed it", axis.letter()))?;
            let settings = self.settings(drive(own)?, conditions);
            settings.check()?;
            let recorder = Recorder::new(&circles, machine.clone(), settings, Kind::Compensated)?;
            passes.push(recorded(recorder, |share| progress(0.5 * (done as f64 + share))));
        }
        Ok(joined([&passes[0], &passes[1]]))
    }

    fn settings(&self, drive: DriveSettings, conditions: &Conditions) -> Settings {
        let mut settings =
            Settings { rate_hz: self.rate_hz, seed: conditions.seed & (u64::MAX >> 1), drive, ..Settings::default() };
        settings.encoder.linear.noise_rms_mm = 1e-3 * conditions.noise_um.unwrap_or(ENCODER_UM);
        let axes = [&mut settings.axis.x, &mut settings.axis.y, &mut settings.axis.z];
        for own in axes {
            *own = Variation { gain_factor: 1.0, friction_factor: 1.0, ..*own };
        }
        settings
    }
}

/// An argument out of its range, under its command-line name.
fn named(error: SimError) -> anyhow::Error {
    match error {
        SimError::Unsuited { what, found, needed } => {
            anyhow!("--{}: found {found}, needed {needed}", what.replace('_', "-"))
        }
        error => error.into(),
    }
}

fn recorded(mut recorder: Recorder, progress: impl Fn(f64)) -> Pass {
    while recorder.advance(STRETCH) {
        progress(recorder.progress());
    }
    recorder.finish()
}

/// The drive that an axis states, with its friction as a force per moved mass.
fn drive(own: &AxisSettings) -> Result<DriveSettings> {
    let letter = own.axis.letter();
    let needed = |section: &str| anyhow!("found no [axis.{letter}.{section}], needed the true figures there");
    let figures = own.servo.drive.ok_or_else(|| needed("drive"))?;
    let friction = own.servo.friction.ok_or_else(|| needed("friction"))?;
    let gain = figures.velocity_gain_per_s;
    let default = DriveSettings::default();
    let stated = |value: f64, otherwise: f64| if value > 0.0 { value } else { otherwise };
    Ok(DriveSettings {
        position_gain_per_s: figures.position_gain_per_s,
        velocity_feed_forward: figures.velocity_feed_forward,
        velocity_gain_per_s: gain,
        reset_time_s: figures.reset_time_s,
        current_loop_s: figures.current_loop_s,
        dead_time_s: figures.dead_time_s,
        resonance_hz: figures.resonance_hz,
        resonance_damping: stated(figures.resonance_damping, default.resonance_damping),
        coulomb_mm_per_s2: gain * friction.coulomb_per_s,
        stribeck_share: friction.stribeck_share,
        stribeck_velocity_mm_per_s: friction.stribeck_velocity_per_s,
        presliding_mm: friction.presliding,
        viscous_per_s: gain * friction.viscous,
        ..default
    })
}
