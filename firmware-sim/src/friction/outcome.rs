//! What was found, what is true in the simulation, and the spikes before and after.

use super::circles::Circles;
use super::{AXES, Passes};
use anyhow::{Result, anyhow};
use serde::Serialize;
use std::fmt;
use trueaxis_metrology::friction::{Identified, Size};
use trueaxis_report::number::significant;
use trueaxis_sim::Settings;
use trueaxis_sim::run::ErrorSize;

/// The JSON document.
#[derive(Serialize)]
pub(super) struct Outcome {
    radius_mm: f64,
    feeds_mm_per_min: [f64; 2],
    turns: u32,
    servo_rate_hz: f64,
    cycles: u64,
    axes: Vec<AxisOutcome>,
    /// Of the true tip, geometry included.
    contour_error_um: Pair,
}

#[derive(Serialize)]
struct AxisOutcome {
    axis: char,
    reversals: usize,
    drive_found: bool,
    identified: Figures<f64>,
    standard_errors: Figures<Option<f64>>,
    r#true: Figures<f64>,
    glitch_um: Spikes,
}

/// Keys as in `machine.toml`.
#[derive(Serialize)]
struct Figures<T> {
    coulomb_mm_per_s: T,
    presliding_um: T,
    stribeck_share: T,
    stribeck_velocity_mm_per_s: T,
    viscous: T,
    position_gain_per_s: T,
    velocity_gain_per_s: T,
    reset_time_s: T,
    velocity_feed_forward: T,
}

#[derive(Serialize)]
struct Spikes {
    before: Deviation,
    predicted: Deviation,
    /// As the model expects it with the feed-forward.
    expected: Deviation,
    after: Deviation,
}

#[derive(Serialize)]
struct Pair {
    before: Deviation,
    after: Deviation,
}

#[derive(Serialize)]
struct Deviation {
    max: f64,
    rms: f64,
}

impl From<Size> for Deviation {
    fn from(size: Size) -> Deviation {
        Deviation { max: 1e3 * size.largest, rms: 1e3 * size.rms }
    }
}

impl From<ErrorSize> for Deviation {
    fn from(size: ErrorSize) -> Deviation {
        Deviation { max: size.max_um, rms: size.rms_um }
    }
}

impl Outcome {
    pub(super) fn new(
        circles: &Circles,
        settings: &Settings,
        [before, after]: Passes<'_>,
        found: &[Identified; 2],
    ) -> Result<Outcome> {
        let again = after.path()?;
        let mut axes = Vec::new();
        for (i, found) in found.iter().enumerate() {
            let left = found.spikes(&again, i).map_err(|refused| anyhow!("the circles recorded again: {refused}"))?;
            axes.push(AxisOutcome {
                axis: AXES[i].letter(),
                reversals: found.reversals,
                drive_found: found.drive_errors.is_some(),
                identified: identified(found),
                standard_errors: standard_errors(found),
                r#true: truth(settings, found),
                glitch_um: Spikes {
                    before: found.glitch.before.into(),
                    predicted: found.glitch.predicted.into(),
                    expected: found.glitch.after.into(),
                    after: left.into(),
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

/// The simulated drive's own figures.
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

impl<T: Copy> Figures<T> {
    fn rows(&self) -> [T; 9] {
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

/// What the rows of [`Figures`] are called.
const NAMES: [&str; 9] = [
    "F_c/K_vp, mm/s",
    "pre-sliding z, µm",
    "Stribeck share s",
    "v_s, mm/s",
    "viscous d/K_vp",
    "K_v, 1/s",
    "K_vp, 1/s",
    "τ, s",
    "k_ff",
];

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [fast, slow] = self.feeds_mm_per_min;
        writeln!(
            f,
            "circles  R {} mm at {fast} and {slow} mm/min, {} turns each way, {} cycles at {} Hz",
            self.radius_mm, self.turns, self.cycles, self.servo_rate_hz
        )?;
        for own in &self.axes {
            writeln!(f, "\naxis {}, {} reversals", own.axis, own.reversals)?;
            writeln!(f, "{:<22}{:>12}{:>14}{:>12}", "", "identified", "std. error", "true")?;
            let rows = NAMES.iter().zip(own.identified.rows()).zip(own.standard_errors.rows()).zip(own.r#true.rows());
            for (k, (((name, value), error), truth)) in rows.enumerate() {
                let held = if k >= 5 && !own.drive_found { "the machine's" } else { "held" };
                let error = error.map_or_else(|| held.to_owned(), |error| significant(error, 2));
                writeln!(f, "{name:<22}{:>12}{error:>14}{:>12}", significant(value, 4), significant(truth, 4))?;
            }
            let spikes = &own.glitch_um;
            for (name, size) in [
                ("before", &spikes.before),
                ("predicted", &spikes.predicted),
                ("expected after", &spikes.expected),
                ("after", &spikes.after),
            ] {
                let [max, rms] = [size.max, size.rms].map(|um| significant(um, 3));
                writeln!(f, "spikes {name:<15}{max:>12} µm largest, {rms} µm RMS")?;
            }
        }
        let Pair { before, after } = &self.contour_error_um;
        let [a, b, c, d] = [before.max, before.rms, after.max, after.rms].map(|um| significant(um, 3));
        writeln!(f, "\ncontour error of the tip, geometry included: {a}/{b} µm largest/RMS before, {c}/{d} µm after")
    }
}
