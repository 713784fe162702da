//! The result as a document.

use crate::uncertainty::{CovarianceDocument, Estimate, band_factor};
use serde::Serialize;
use trueaxis_metrology::friction::{FIGURES, Figure, Identified, NoResonance, Record, Resonance, Size};
use trueaxis_report::number::significant;

/// Friction and drives of a record.
#[derive(Clone, Debug, Serialize)]
pub struct FrictionDocument {
    /// Samples of the record.
    pub samples: usize,
    /// Sampling period, s.
    pub period_s: f64,
    /// Both axes, in the requested order.
    pub axes: Vec<AxisFound>,
    /// Covariance of the figures fitted, by names as `X.coulomb_mm_per_s`; its diagonal has the squares of their standard errors.
    /// It is conditional on the figures that were fixed or stated; the axes are fitted separately, so that figures of one have
    /// none with those of the other. Figures of the resonance come from a second fit, and are not in it.
    pub covariance: CovarianceDocument,
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
    /// Resonance of motor and load against each other; null if the record shows none.
    pub resonance: Option<ResonanceFound>,
    /// Why the record shows no resonance; null if it does, or if nobody has searched for it.
    pub resonance_not_found: Option<String>,
}

/// Resonance of an axis; first keys as in `machine.toml`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ResonanceFound {
    /// Frequency with both masses free, Hz.
    pub resonance_hz: f64,
    /// Damping, share of critical.
    pub resonance_damping: f64,
    /// Mass of the load over that of motor and load.
    pub load_share: f64,
    /// Whether the readings are those of a scale on the load; null if an encoder on the motor explains them as well.
    pub on_load: Option<bool>,
    /// Whether the record determines the damping; only then are frequency and damping written into a machine.
    pub damping_known: bool,
    /// Standard errors of frequency, damping and share.
    pub standard_errors: ResonanceErrors,
    /// Half-widths of 95 % intervals.
    pub expanded_uncertainties: ResonanceErrors,
}

/// Errors of the figures of a resonance.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ResonanceErrors {
    /// Standard uncertainty of the frequency, Hz.
    pub resonance_hz: f64,
    /// Standard uncertainty of the damping, share of critical.
    pub resonance_damping: f64,
    /// Standard uncertainty of the load's share.
    pub load_share: f64,
}

impl From<&Resonance> for ResonanceFound {
    fn from(found: &Resonance) -> ResonanceFound {
        let errors = |factor: f64| {
            let of = |figure: Figure| factor * figure.standard_error.unwrap_or(f64::NAN);
            ResonanceErrors {
                resonance_hz: of(found.frequency_hz),
                resonance_damping: of(found.damping),
                load_share: of(found.load_share),
            }
        };
        ResonanceFound {
            resonance_hz: found.frequency_hz.value,
            resonance_damping: found.damping.value,
            load_share: found.load_share.value,
            on_load: found.on_load,
            damping_known: found.is_damping_known(),
            standard_errors: errors(1.0),
            expanded_uncertainties: errors(band_factor(found.degrees_of_freedom)),
        }
    }
}

/// Why a record shows no resonance, as a part of a sentence: found, needed.
fn not_found(why: &NoResonance) -> String {
    let hz = |hz: f64| significant(hz, 3);
    match *why {
        NoResonance::NotSeen { gain, needed } => format!(
            "found a gain of {} variances of a reading by a second mass, needed {needed}: starts and stops with more acceleration, \
             or less noise",
            significant(gain, 2)
        ),
        NoResonance::Uncertain { frequency_hz, standard_error_hz } => format!(
            "found {} Hz with a standard error of {} Hz, needed at most a tenth: more starts, stops and reversals",
            hz(frequency_hz),
            significant(standard_error_hz, 2)
        ),
        NoResonance::Blurred { frequency_hz, damping_error } => format!(
            "found {} Hz with a damping uncertain by {} % of critical (standard error), needed at most 10 %: more starts, stops and \
             reversals",
            hz(frequency_hz),
            significant(100.0 * damping_error, 2)
        ),
        NoResonance::OutOfRange { limit_hz } => format!(
            "found the best one beyond the range, which ends at {} Hz, needed one within: from 10 Hz to a fifth of the record's \
             rate, at most 320 Hz",
            hz(limit_hz)
        ),
        NoResonance::OnePartOnly { frequency_hz } => format!(
            "found {} Hz in one half of the record only, needed in both: no other disturbance in the record",
            hz(frequency_hz)
        ),
        NoResonance::Misfit { frequency_hz, residual_rms } => format!(
            "found {} Hz with {} µm RMS left that are not noise, needed an axis of two masses: play, a second resonance or \
             another disturbance is in the record",
            hz(frequency_hz),
            significant(1e3 * residual_rms, 2)
        ),
        _ => "found a fit of two masses that does not settle, needed a record with more starts, stops and reversals"
            .into(),
    }
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
        resonance: found.mechanics.and_then(|own| own.resonance.ok()).as_ref().map(ResonanceFound::from),
        resonance_not_found: found.mechanics.and_then(|own| own.resonance.err()).as_ref().map(not_found),
    }
}

/// Key, unit and factor of the figures in the order of [`FIGURES`].
const KEYS: [(&str, &str, f64); FIGURES.len()] = [
    ("coulomb_mm_per_s", "mm/s", 1.0),
    ("stribeck_share", "", 1.0),
    ("stribeck_velocity_mm_per_s", "mm/s", 1.0),
    ("presliding_um", "um", 1e3),
    ("viscous", "", 1.0),
    ("position_gain_per_s", "1/s", 1.0),
    ("velocity_gain_per_s", "1/s", 1.0),
    ("reset_time_s", "s", 1.0),
    ("velocity_feed_forward", "", 1.0),
    ("dead_time_s", "s", 1.0),
];

fn covariance(found: &[Identified]) -> CovarianceDocument {
    let estimates = found.iter().flat_map(|own| {
        let (f, d) = (&own.friction, &own.drive);
        let values = [
            f.coulomb_per_s,
            f.stribeck_share,
            f.stribeck_velocity_per_s,
            f.presliding,
            f.viscous,
            d.position_gain_per_s,
            d.velocity_gain_per_s,
            d.reset_time_s,
            d.velocity_feed_forward,
            d.dead_time_s,
        ];
        let letter = own.axis.letter();
        let estimate =
            move |((key, unit, factor), value)| Estimate { name: format!("{letter}.{key}"), unit, factor, value };
        KEYS.into_iter().zip(values).map(estimate)
    });
    // The reading's lag is a figure of the drive only if the drive was fitted.
    let is_shown = |figure: usize, own: &Identified| figure + 1 < FIGURES.len() || own.drive_errors.is_some();
    let entry = |i: usize, j: usize| {
        let (own, [one, other]) = (&found[i / FIGURES.len()], [i, j].map(|figure| figure % FIGURES.len()));
        let is_apart = i / FIGURES.len() != j / FIGURES.len();
        if is_apart || !is_shown(one, own) || !is_shown(other, own) { 0.0 } else { own.covariance[one][other] }
    };
    CovarianceDocument::of_fitted(estimates.collect(), entry)
}

/// Notes on the resonance's figures.
fn resonance_note(own: &AxisFound) -> Option<String> {
    let letter = &own.axis;
    if let Some(why) = &own.resonance_not_found {
        return Some(format!("axis {letter}: resonance not found: {why}"));
    }
    let unknown = own.resonance.filter(|found| !found.damping_known)?;
    Some(format!(
        "axis {letter}: the record does not determine the damping of the resonance ({} % with a standard error of {} %): neither is \
         written into a machine",
        significant(100.0 * unknown.resonance_damping, 2),
        significant(100.0 * unknown.standard_errors.resonance_damping, 2)
    ))
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
        warnings.extend(axes.iter().filter_map(resonance_note));
        FrictionDocument {
            samples: record.axes[0].command.len(),
            period_s: record.period_s,
            axes,
            covariance: covariance(found),
            warnings,
        }
    }
}
