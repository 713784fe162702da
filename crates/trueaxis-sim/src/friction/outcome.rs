//! Figures identified, figures of the simulation, and the spikes before and after.

use super::{Circles, Pass};
use crate::Settings;
use crate::error::{Result, SimError};
use crate::run::Size;
use serde::Serialize;
use trueaxis_metrology::friction::{self, Identified};

/// Outcome of the whole sequence: recorded, identified, configured, recorded again.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Radius of the circles.
    pub radius_mm: f64,
    /// The two feeds of the circles.
    pub feeds_mm_per_min: [f64; 2],
    /// Turns of every circle.
    pub turns: u32,
    /// Servo rate.
    pub servo_rate_hz: f64,
    /// Cycles per pass.
    pub cycles: u64,
    /// Both axes of the plane.
    pub axes: Vec<AxisOutcome>,
    /// Contour error of the true tip, geometry included.
    pub contour_error_um: Pair,
}

/// One axis.
#[derive(Clone, Debug, Serialize)]
pub struct AxisOutcome {
    /// Axis letter.
    pub axis: char,
    /// Reversals in motion.
    pub reversals: usize,
    /// Whether the drive's figures were identified; otherwise they are the machine's.
    pub drive_found: bool,
    /// Identified figures.
    pub identified: Figures<f64>,
    /// Standard errors of the identified figures; `None` for a figure that the fit fixed.
    pub standard_errors: Figures<Option<f64>>,
    /// Figures of the simulated drive.
    pub r#true: Figures<f64>,
    /// Spikes at the reversals, µm.
    pub glitch_um: Spikes,
}

/// Figures of friction and drive; keys as in `machine.toml`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Figures<T> {
    /// F_c/K_vp, mm/s.
    pub coulomb_mm_per_s: T,
    /// z, µm.
    pub presliding_um: T,
    /// s.
    pub stribeck_share: T,
    /// v_s, mm/s.
    pub stribeck_velocity_mm_per_s: T,
    /// d/K_vp.
    pub viscous: T,
    /// K_v, 1/s.
    pub position_gain_per_s: T,
    /// K_vp, 1/s.
    pub velocity_gain_per_s: T,
    /// τ, s.
    pub reset_time_s: T,
    /// k_ff.
    pub velocity_feed_forward: T,
}

/// Spikes at the reversals, µm.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Spikes {
    /// Recorded without the feed-forward.
    pub before: Size,
    /// Predicted by the model without the feed-forward.
    pub predicted: Size,
    /// Expected by the model with the feed-forward.
    pub expected: Size,
    /// Recorded again with the feed-forward.
    pub after: Size,
}

/// Without and with the feed-forward, µm.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Pair {
    /// Without the feed-forward.
    pub before: Size,
    /// With the feed-forward.
    pub after: Size,
}

/// Converts mm to µm.
impl From<friction::Size> for Size {
    fn from(size: friction::Size) -> Size {
        Size { max: 1e3 * size.largest, rms: 1e3 * size.rms }
    }
}

impl Outcome {
    /// Compares the two passes of the circles, without and with the figures `found` in the first.
    ///
    /// # Errors
    /// A second pass that cannot be evaluated.
    pub fn new(
        circles: &Circles,
        settings: &Settings,
        [before, after]: [&Pass; 2],
        found: &[Identified; 2],
    ) -> Result<Outcome> {
        let again = after.path()?;
        let mut axes = Vec::new();
        for (i, found) in found.iter().enumerate() {
            let left = found.spikes(&again, i).map_err(SimError::friction("the circles recorded again"))?;
            axes.push(AxisOutcome {
                axis: found.axis.letter(),
                reversals: found.reversals,
                drive_found: found.drive_errors.is_some(),
                identified: identified(found),
                standard_errors: standard_errors(found),
                r#true: truth(settings, found),
                glitch_um: Spikes {
                    before: found.glitch.before.into(),
                    predicted: found.glitch.predicted.into(),
                    expected: found.glitch.after.into(),
                    after: left.before.into(),
                },
            });
        }
        Ok(Outcome {
            radius_mm: circles.radius_mm,
            feeds_mm_per_min: circles.feeds_mm_per_min,
            turns: circles.turns,
            servo_rate_hz: settings.rate_hz,
            cycles: before.cycles,
            axes,
            contour_error_um: Pair { before: before.error.into(), after: after.error.into() },
        })
    }
}

impl Figures<f64> {
    /// In the order of the fields.
    #[must_use]
    pub fn in_order(&self) -> [f64; 9] {
        [
            self.coulomb_mm_per_s,
            self.presliding_um,
            self.stribeck_share,
            self.stribeck_velocity_mm_per_s,
            self.viscous,
            self.position_gain_per_s,
            self.velocity_gain_per_s,
            self.reset_time_s,
            self.velocity_feed_forward,
        ]
    }
}

fn identified(found: &Identified) -> Figures<f64> {
    let (friction, drive) = (&found.friction, &found.drive);
    Figures {
        coulomb_mm_per_s: friction.coulomb_per_s,
        presliding_um: 1e3 * friction.presliding,
        stribeck_share: friction.stribeck_share,
        stribeck_velocity_mm_per_s: friction.stribeck_velocity_per_s,
        viscous: friction.viscous,
        position_gain_per_s: drive.position_gain_per_s,
        velocity_gain_per_s: drive.velocity_gain_per_s,
        reset_time_s: drive.reset_time_s,
        velocity_feed_forward: drive.velocity_feed_forward,
    }
}

fn standard_errors(found: &Identified) -> Figures<Option<f64>> {
    let [position, velocity, reset, feed] = found.drive_errors.map(|errors| errors.map(Some)).unwrap_or_default();
    Figures {
        coulomb_mm_per_s: found.coulomb_per_s.standard_error,
        presliding_um: found.presliding.standard_error.map(|error| 1e3 * error),
        stribeck_share: found.stribeck_share.standard_error,
        stribeck_velocity_mm_per_s: found.stribeck_velocity_per_s.standard_error,
        viscous: found.viscous.standard_error,
        position_gain_per_s: position,
        velocity_gain_per_s: velocity,
        reset_time_s: reset,
        velocity_feed_forward: feed,
    }
}

/// The simulated drive's true figures.
fn truth(settings: &Settings, found: &Identified) -> Figures<f64> {
    let drive = settings.plant(0.0).drives[found.axis.index()];
    Figures {
        coulomb_mm_per_s: drive.coulomb_mm_per_s2 / drive.velocity_gain_per_s,
        presliding_um: 1e3 * drive.presliding_mm,
        stribeck_share: drive.stribeck_share,
        stribeck_velocity_mm_per_s: drive.stribeck_velocity_mm_per_s,
        viscous: drive.viscous_per_s / drive.velocity_gain_per_s,
        position_gain_per_s: drive.position_gain_per_s,
        velocity_gain_per_s: drive.velocity_gain_per_s,
        reset_time_s: drive.reset_time_s,
        velocity_feed_forward: drive.velocity_feed_forward,
    }
}
