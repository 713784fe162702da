//! The result, as printed.

use serde::Serialize;
use std::fmt::Write;
use trueaxis_metrology::friction::{Figure, Identified, Record, Size};
use trueaxis_report::number::significant;

/// The JSON document.
#[derive(Serialize)]
pub(crate) struct Document {
    pub(crate) samples: usize,
    pub(crate) period_s: f64,
    pub(crate) axes: Vec<AxisFound>,
    pub(crate) warnings: Vec<String>,
}

/// One axis.
#[derive(Serialize)]
pub(crate) struct AxisFound {
    pub(crate) axis: String,
    pub(crate) friction: Friction<f64>,
    pub(crate) drive: Drive<f64>,
    /// Whether the drive's figures were found in the record; else they are the machine's.
    pub(crate) drive_found: bool,
    /// Null where a figure was held and not fitted.
    pub(crate) standard_errors: Errors,
    pub(crate) reading_lag_s: f64,
    pub(crate) glitch_um: Glitch,
    /// Share of the spikes' mean square that the model explains.
    pub(crate) explained: f64,
    pub(crate) residual_um: f64,
    pub(crate) fitted: usize,
    pub(crate) condition: f64,
    pub(crate) reversals: usize,
}

/// Keys as in `machine.toml`.
#[derive(Serialize)]
pub(crate) struct Friction<T> {
    pub(crate) coulomb_mm_per_s: T,
    pub(crate) presliding_um: T,
    pub(crate) stribeck_share: T,
    pub(crate) stribeck_velocity_mm_per_s: T,
    pub(crate) viscous: T,
}

/// Keys as in `machine.toml`.
#[derive(Serialize)]
pub(crate) struct Drive<T> {
    pub(crate) position_gain_per_s: T,
    pub(crate) velocity_gain_per_s: T,
    pub(crate) reset_time_s: T,
    pub(crate) velocity_feed_forward: T,
    pub(crate) dead_time_s: T,
}

#[derive(Serialize)]
pub(crate) struct Errors {
    #[serde(flatten)]
    pub(crate) friction: Friction<Option<f64>>,
    #[serde(flatten)]
    pub(crate) drive: Drive<Option<f64>>,
}

#[derive(Serialize)]
pub(crate) struct Glitch {
    pub(crate) before: Deviation,
    pub(crate) predicted: Deviation,
    pub(crate) after: Deviation,
}

#[derive(Serialize)]
pub(crate) struct Deviation {
    pub(crate) max: f64,
    pub(crate) rms: f64,
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

fn axis(found: &Identified) -> AxisFound {
    let drive = &found.drive;
    let errors = found.drive_errors.map(|errors| errors.map(Some)).unwrap_or_default();
    let [position_gain_per_s, velocity_gain_per_s, reset_time_s, velocity_feed_forward] = errors;
    let lag = found.reading_lag_s;
    let dead_time_s = lag.standard_error.filter(|_| found.drive_errors.is_some());
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
        standard_errors: Errors {
            friction: friction(found, |figure, scale| figure.standard_error.map(|error| scale * error)),
            drive: Drive { position_gain_per_s, velocity_gain_per_s, reset_time_s, velocity_feed_forward, dead_time_s },
        },
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

impl Document {
    pub(super) fn new(record: &Record, found: &[Identified]) -> Document {
        let axes: Vec<AxisFound> = found.iter().map(axis).collect();
        let mut warnings = Vec::new();
        for own in &axes {
            let letter = &own.axis;
            for (held, name, value) in [
                (own.standard_errors.friction.stribeck_share.is_none(), "Stribeck share", "0"),
                (own.standard_errors.friction.stribeck_velocity_mm_per_s.is_none(), "Stribeck velocity", "2 mm/s"),
                (own.standard_errors.friction.viscous.is_none(), "viscous friction", "0"),
            ] {
                if held {
                    warnings
                        .push(format!("axis {letter}: the record does not tell the {name}, which is held at {value}"));
                }
            }
        }
        Document { samples: record.axes[0].command.len(), period_s: record.period_s, axes, warnings }
    }

    /// A table to read.
    pub(super) fn table(&self) -> Result<String, std::fmt::Error> {
        let mut text = format!("{} samples at {} Hz\n", self.samples, significant(1.0 / self.period_s, 4));
        for own in &self.axes {
            let (f, fe) = (&own.friction, &own.standard_errors.friction);
            let (d, de) = (&own.drive, &own.standard_errors.drive);
            writeln!(text, "\naxis {}, {} reversals", own.axis, own.reversals)?;
            let mut row = |name: &str, value: f64, error: Option<f64>, held: &str| {
                let error = error.map_or_else(|| held.to_owned(), |error| format!("± {}", significant(error, 2)));
                writeln!(text, "  {name:<36} {:>9}  {error}", significant(value, 4))
            };
            row("Coulomb friction F_c/K_vp, mm/s", f.coulomb_mm_per_s, fe.coulomb_mm_per_s, "held")?;
            row("pre-sliding z, µm", f.presliding_um, fe.presliding_um, "held")?;
            row("Stribeck share s", f.stribeck_share, fe.stribeck_share, "held")?;
            row("Stribeck velocity v_s, mm/s", f.stribeck_velocity_mm_per_s, fe.stribeck_velocity_mm_per_s, "held")?;
            row("viscous friction d/K_vp", f.viscous, fe.viscous, "held")?;
            let given = if own.drive_found { "held" } else { "the machine's" };
            row("position gain K_v, 1/s", d.position_gain_per_s, de.position_gain_per_s, given)?;
            row("velocity gain K_vp, 1/s", d.velocity_gain_per_s, de.velocity_gain_per_s, given)?;
            row("reset time τ, s", d.reset_time_s, de.reset_time_s, given)?;
            row("velocity feed-forward k_ff", d.velocity_feed_forward, de.velocity_feed_forward, given)?;
            writeln!(
                text,
                "  fit: {} µm left, {} % of the spikes explained, {} parameters, condition number {}",
                significant(own.residual_um, 3),
                significant(100.0 * own.explained, 4),
                own.fitted,
                significant(own.condition, 3)
            )?;
            let g = &own.glitch_um;
            for (name, size) in [("before", &g.before), ("predicted", &g.predicted), ("after", &g.after)] {
                writeln!(
                    text,
                    "  spikes {name:<9} {:>7} µm largest, {:>7} µm RMS",
                    significant(size.max, 3),
                    significant(size.rms, 3)
                )?;
            }
        }
        for warning in &self.warnings {
            writeln!(text, "note: {warning}")?;
        }
        Ok(text)
    }
}
