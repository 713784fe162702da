//! The result as a document.

use crate::uncertainty::band_factor;
use serde::Serialize;
use trueaxis_metrology::friction::{Figure, Identified, Record, Size};

/// Friction and drives of a record.
#[derive(Clone, Debug, Serialize)]
pub struct FrictionDocument {
    /// Samples of the record.
    pub samples: usize,
    /// Sampling period, s.
    pub period_s: f64,
    /// Both axes, in the requested order.
    pub axes: Vec<AxisFound>,
    /// Figures that the record does not determine, and the values at which they are fixed.
    pub warnings: Vec<String>,
}

/// One axis.
#[derive(Clone, Debug, Serialize)]
pub struct AxisFound {
    /// Letter of the axis.
    pub axis: String,
    /// Friction of the axis.
    pub friction: Friction<f64>,
    /// Drive of the axis.
    pub drive: Drive<f64>,
    /// Whether the drive's figures come from the record; otherwise the machine states them.
    pub drive_found: bool,
    /// Null for a figure that was fixed rather than fitted.
    pub standard_errors: Errors,
    /// Half-widths of 95 % intervals: standard errors times Student's factor, counting each stretch round a reversal as one
    /// observation.
    pub expanded_uncertainties: Errors,
    /// Delay of the reading beyond the drive's own lag, s.
    pub reading_lag_s: f64,
    /// Spikes at the reversals, µm.
    pub glitch_um: Glitch,
    /// Share of the spikes' mean square that the model explains.
    pub explained: f64,
    /// Root mean square of the residuals of the fit, µm.
    pub residual_um: f64,
    /// Number of fitted parameters.
    pub fitted: usize,
    /// Condition number of the fit.
    pub condition: f64,
    /// Number of reversals in motion.
    pub reversals: usize,
}

/// Figures of friction; keys as in `machine.toml`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Friction<T> {
    /// F_c/K_vp, mm/s.
    pub coulomb_mm_per_s: T,
    /// z, µm.
    pub presliding_um: T,
    /// Stribeck share s.
    pub stribeck_share: T,
    /// v_s, mm/s.
    pub stribeck_velocity_mm_per_s: T,
    /// d/K_vp.
    pub viscous: T,
}

/// Figures of a drive; keys as in `machine.toml`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Drive<T> {
    /// K_v, 1/s.
    pub position_gain_per_s: T,
    /// K_vp, 1/s.
    pub velocity_gain_per_s: T,
    /// τ, s.
    pub reset_time_s: T,
    /// k_ff.
    pub velocity_feed_forward: T,
    /// Delay between a command and the position loop, s.
    pub dead_time_s: T,
}

/// Standard errors; `None` for a figure that was fixed rather than fitted.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Errors {
    /// Standard errors of friction.
    #[serde(flatten)]
    pub friction: Friction<Option<f64>>,
    /// Standard errors of the drive.
    #[serde(flatten)]
    pub drive: Drive<Option<f64>>,
}

impl Errors {
    fn times(&self, factor: f64) -> Errors {
        let of = |error: Option<f64>| error.map(|error| factor * error);
        let (f, d) = (&self.friction, &self.drive);
        Errors {
            friction: Friction {
                coulomb_mm_per_s: of(f.coulomb_mm_per_s),
                presliding_um: of(f.presliding_um),
                stribeck_share: of(f.stribeck_share),
                stribeck_velocity_mm_per_s: of(f.stribeck_velocity_mm_per_s),
                viscous: of(f.viscous),
            },
            drive: Drive {
                position_gain_per_s: of(d.position_gain_per_s),
                velocity_gain_per_s: of(d.velocity_gain_per_s),
                reset_time_s: of(d.reset_time_s),
                velocity_feed_forward: of(d.velocity_feed_forward),
                dead_time_s: of(d.dead_time_s),
            },
        }
    }
}

/// Spikes at the reversals, µm.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Glitch {
    /// Recorded spikes.
    pub before: Deviation,
    /// Spikes that the model predicts.
    pub predicted: Deviation,
    /// Spikes expected with the feed-forward.
    pub after: Deviation,
}

/// Size of a deviation, µm.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Deviation {
    /// Largest magnitude.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

impl From<Size> for Deviation {
    fn from(size: Size) -> Deviation {
        Deviation { max: 1e3 * size.largest, rms: 1e3 * size.rms }
    }
}

fn friction<T>(found: &Identified, of: impl Fn(Figure, f64) -> T) -> Friction<T> {
    Friction {
        coulomb_mm_per_s: of(found.coulomb_per_s, 1.0),
        presliding_um: of(found.presliding, 1e3),
        stribeck_share: of(found.stribeck_share, 1.0),
        stribeck_velocity_mm_per_s: of(found.stribeck_velocity_per_s, 1.0),
        viscous: of(found.viscous, 1.0),
    }
}

/// Degrees of freedom of an axis' figures: each stretch round a reversal counts as one observation.
pub(super) fn degrees_of_freedom(found: &Identified) -> f64 {
    found.reversals.saturating_sub(found.fitted).max(1) as f64
}

pub(super) fn axis(found: &Identified) -> AxisFound {
    let drive = &found.drive;
    let errors = found.drive_errors.map(|errors| errors.map(Some)).unwrap_or_default();
    let [position_gain_per_s, velocity_gain_per_s, reset_time_s, velocity_feed_forward] = errors;
    let lag = found.reading_lag_s;
    let dead_time_s = lag.standard_error.filter(|_| found.drive_errors.is_some());
    let standard_errors = Errors {
        friction: friction(found, |figure, scale| figure.standard_error.map(|error| scale * error)),
        drive: Drive { position_gain_per_s, velocity_gain_per_s, reset_time_s, velocity_feed_forward, dead_time_s },
    };
    AxisFound {
        axis: found.axis.letter().to_string(),
        friction: friction(found, |figure, scale| scale * figure.value),
        drive: Drive {
            position_gain_per_s: drive.position_gain_per_s,
            velocity_gain_per_s: drive.velocity_gain_per_s,
            reset_time_s: drive.reset_time_s,
            velocity_feed_forward: drive.velocity_feed_forward,
            dead_time_s: drive.dead_time_s,
        },
        drive_found: found.drive_errors.is_some(),
        expanded_uncertainties: standard_errors.times(band_factor(degrees_of_freedom(found))),
        standard_errors,
        reading_lag_s: lag.value,
        glitch_um: Glitch {
            before: found.glitch.before.into(),
            predicted: found.glitch.predicted.into(),
            after: found.glitch.after.into(),
        },
        explained: found.glitch.explained,
        residual_um: 1e3 * found.residual_rms,
        fitted: found.fitted,
        condition: found.condition,
        reversals: found.reversals,
    }
}

impl FrictionDocument {
    /// The document of the figures found in a record.
    pub fn new(record: &Record, found: &[Identified]) -> FrictionDocument {
        let axes: Vec<AxisFound> = found.iter().map(axis).collect();
        let mut warnings = Vec::new();
        for own in &axes {
            let letter = &own.axis;
            if own.drive_found && own.standard_errors.drive.dead_time_s.is_none() && record.read_after_s.is_none() {
                warnings.push(format!(
                    "axis {letter}: the record does not determine when in its cycle the encoder was read; the uncertainties are valid \
                     for every time within half a cycle of the command (--read-after-us states it)"
                ));
            }
            for (held, name, value) in [
                (own.standard_errors.friction.stribeck_share.is_none(), "Stribeck share", "0"),
                (own.standard_errors.friction.stribeck_velocity_mm_per_s.is_none(), "Stribeck velocity", "2 mm/s"),
                (own.standard_errors.friction.viscous.is_none(), "viscous friction", "0"),
            ] {
                if held {
                    warnings.push(format!(
                        "axis {letter}: the record does not determine the {name}, which is fixed at {value}"
                    ));
                }
            }
        }
        FrictionDocument { samples: record.axes[0].command.len(), period_s: record.period_s, axes, warnings }
    }
}
