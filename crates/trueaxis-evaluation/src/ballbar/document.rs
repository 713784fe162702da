//! The results of a circular test, as a document.

use super::Test;
use crate::uncertainty::{CovarianceDocument, Estimate, expanded};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use trueaxis::Axis;
use trueaxis_metrology::ballbar::{Cause, Term};
use trueaxis_report::number::significant;
use trueaxis_tables::finding::OVERCOMPENSATED;

/// A value larger than this many standard errors is certain.
const CERTAIN: f64 = 2.0;

/// No machine runs a rounder circle than this, µm: its encoders resolve that.
const ROUNDEST_UM: f64 = 0.1;

/// A value for each axis, by letter: `x`, `y` or `z`.
pub type Pair = BTreeMap<char, Option<f64>>;

/// A value for each direction; null if that direction was not recorded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ways {
    /// Counterclockwise.
    pub ccw: Option<f64>,
    /// Clockwise.
    pub cw: Option<f64>,
}

/// Share of a cause in the deviation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Name of the cause.
    pub cause: String,
    /// Root mean square of the deviation that the cause makes.
    pub rms_um: f64,
    /// Fraction of the sum of squares of all causes, 0 … 1.
    pub share: f64,
}

/// The JSON document; values that the record does not determine are null.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BallbarDocument {
    /// Number of readings in the record.
    pub readings: usize,
    /// Nominal radius.
    pub radius_mm: f64,
    /// G(b): bidirectional circular deviation (ISO 230-4), minimum zone.
    pub g_b_um: Option<f64>,
    /// G: circular deviation, minimum zone.
    pub g_um: Ways,
    /// F: radial deviation of the largest magnitude, about the least-squares centre of its direction; null for an arc.
    pub f_um: Ways,
    /// F max.
    pub f_max_um: Ways,
    /// F min.
    pub f_min_um: Ways,
    /// H: circular hysteresis.
    pub h_um: Option<f64>,
    /// Mean deviation of the radius.
    pub radius_deviation_um: f64,
    /// Offset of the circle's centre.
    pub centre_um: [f64; 2],
    /// The plane, such as `XY`.
    pub plane: String,
    /// C0Y; A0Z in the plane of Y and Z, B0Z in that of X and Z.
    pub squareness_urad: f64,
    /// Name of that squareness.
    pub squareness: &'static str,
    /// Scale of the first axis less that of the second.
    pub scale_mismatch_ppm: f64,
    /// Lag of the first axis less that of the second.
    pub servo_mismatch_um: Option<f64>,
    /// Lost motion.
    pub backlash_um: Pair,
    /// Spikes after reversals, outwards.
    pub reversal_um: Pair,
    /// Width of the spikes.
    pub reversal_width_deg: f64,
    /// Lateral shift at reversals of an axis.
    pub lateral_play_um: Pair,
    /// Bow of an axis over the radius.
    pub straightness_um: Pair,
    /// Amplitude of periodic errors; null if none is visible.
    pub cyclic_um: Pair,
    /// Pitches of the periodic errors.
    pub pitch_mm: Pair,
    /// Standard errors under the names of the values.
    pub standard_errors: Map<String, Value>,
    /// Half-widths of 95 % intervals: standard errors times Student's factor.
    pub expanded_uncertainties: Map<String, Value>,
    /// Covariance of the values that have a standard error, by names as `backlash_um.x` and `centre_um[0]`; its diagonal are the
    /// squares of these. It is conditional on the pitches; spikes of a shape other than the fit's own are not in it.
    pub covariance: CovarianceDocument,
    /// Causes other than radius and centre, largest first.
    pub shares: Vec<Share>,
    /// Standard deviation of a reading, from the residuals.
    pub sigma_um: f64,
    /// Readings less parameters.
    pub degrees_of_freedom: usize,
    /// Condition number of the fit.
    pub condition: f64,
    /// Caveats on the result.
    pub warnings: Vec<String>,
}

/// Name of a cause in sentences.
pub fn name(cause: Cause, axes: [Axis; 2]) -> String {
    let axis = |axis: u8| axes[usize::from(axis != 0)].letter();
    match cause {
        Cause::Radius => "radius".into(),
        Cause::Centre(of) => format!("centre {}", axis(of)),
        Cause::ScaleMismatch => "scale mismatch".into(),
        Cause::Squareness => "squareness".into(),
        Cause::ServoMismatch => "servo mismatch".into(),
        Cause::Backlash(of) => format!("backlash {}", axis(of)),
        Cause::LateralPlay(of) => format!("lateral play {}", axis(of)),
        Cause::Straightness(of) => format!("straightness {}", axis(of)),
        Cause::Reversal(of) => format!("reversal spikes {}", axis(of)),
        Cause::Cyclic(of) => format!("cyclic error {}", axis(of)),
        _ => "another cause".into(),
    }
}

/// Converts mm to µm, rad to µrad, 1 to ppm.
fn micro(cause: Cause, value: f64) -> f64 {
    match cause {
        Cause::Squareness | Cause::ScaleMismatch => 1e6 * value,
        _ => 1e3 * value,
    }
}

/// The squareness of a plane as in ISO 230-1, and its sign relative to the fit: e(first) −= S · second, which a ball bar
/// cannot distinguish from e(second) −= S · first. EXY −= C0Y y, EYZ −= A0Z z, but EXZ += B0Z z.
pub(super) fn squareness(axes: [Axis; 2]) -> (&'static str, f64) {
    if !axes.contains(&Axis::Z) {
        ("C0Y", 1.0)
    } else if axes.contains(&Axis::Y) {
        ("A0Z", 1.0)
    } else {
        ("B0Z", -1.0)
    }
}

impl Test {
    /// The document.
    pub fn document(&self) -> BallbarDocument {
        let found = &self.found;
        let of = |cause: Cause, take: fn(&Term) -> f64| found.term(cause).map(|term| micro(cause, take(term)));
        let value = |cause| of(cause, |term| term.value);
        let error = |cause| of(cause, |term| term.standard_error);
        let letters = self.options.axes.map(|axis| axis.letter().to_ascii_lowercase());
        let pair = |cause: fn(u8) -> Cause| Pair::from([0, 1].map(|i| (letters[i], value(cause(i as u8)))));
        let errors = |cause: fn(u8) -> Cause| json!(Pair::from([0, 1].map(|i| (letters[i], error(cause(i as u8))))));
        let (squareness, sense) = squareness(self.options.axes);
        let um = |value: Option<f64>| value.map(|mm| 1e3 * mm);
        let ways = |take: &dyn Fn([f64; 2]) -> f64| {
            let [ccw, cw] = found.figures.f.map(|ends| um(ends.map(take)));
            Ways { ccw, cw }
        };
        let standard_errors = [
            ("radius_deviation_um", json!(error(Cause::Radius))),
            ("centre_um", json!([error(Cause::Centre(0)), error(Cause::Centre(1))])),
            ("squareness_urad", json!(error(Cause::Squareness))),
            ("scale_mismatch_ppm", json!(error(Cause::ScaleMismatch))),
            ("servo_mismatch_um", json!(error(Cause::ServoMismatch))),
            ("backlash_um", errors(Cause::Backlash)),
            ("reversal_um", errors(Cause::Reversal)),
            ("lateral_play_um", errors(Cause::LateralPlay)),
            ("straightness_um", errors(Cause::Straightness)),
            ("cyclic_um", errors(Cause::Cyclic)),
        ];
        let standard_errors: Map<String, Value> =
            standard_errors.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        let centre = |axis| value(Cause::Centre(axis)).unwrap_or_default();
        BallbarDocument {
            readings: self.readings.len(),
            radius_mm: self.options.radius_mm,
            g_b_um: um(found.figures.g_b),
            g_um: Ways { ccw: um(found.figures.g[0]), cw: um(found.figures.g[1]) },
            f_um: ways(&|[most, least]| if most >= -least { most } else { least }),
            f_max_um: ways(&|ends| ends[0]),
            f_min_um: ways(&|ends| ends[1]),
            h_um: um(found.figures.h),
            radius_deviation_um: value(Cause::Radius).unwrap_or_default(),
            centre_um: [centre(0), centre(1)],
            plane: self.options.axes.iter().map(|axis| axis.letter()).collect(),
            squareness_urad: sense * value(Cause::Squareness).unwrap_or_default(),
            squareness,
            scale_mismatch_ppm: value(Cause::ScaleMismatch).unwrap_or_default(),
            servo_mismatch_um: value(Cause::ServoMismatch),
            backlash_um: pair(Cause::Backlash),
            reversal_um: pair(Cause::Reversal),
            reversal_width_deg: found.spike_width_rad.to_degrees(),
            lateral_play_um: pair(Cause::LateralPlay),
            straightness_um: pair(Cause::Straightness),
            cyclic_um: pair(Cause::Cyclic),
            pitch_mm: Pair::from([0, 1].map(|i| (letters[i], found.pitches_mm[i]))),
            expanded_uncertainties: expanded(&standard_errors, found.degrees_of_freedom as f64),
            standard_errors,
            covariance: self.covariance(),
            shares: self.shares(),
            sigma_um: 1e3 * found.sigma_mm,
            degrees_of_freedom: found.degrees_of_freedom,
            condition: found.condition,
            warnings: self.warnings(),
        }
    }

    fn covariance(&self) -> CovarianceDocument {
        let letter = |axis: u8| self.options.axes[usize::from(axis != 0)].letter().to_ascii_lowercase();
        let (_, sense) = squareness(self.options.axes);
        let estimates = self.found.terms.iter().map(|term| {
            let name = match term.cause {
                Cause::Radius => "radius_deviation_um".into(),
                Cause::Centre(axis) => format!("centre_um[{axis}]"),
                Cause::ScaleMismatch => "scale_mismatch_ppm".into(),
                Cause::Squareness => "squareness_urad".into(),
                Cause::ServoMismatch => "servo_mismatch_um".into(),
                Cause::Backlash(axis) => format!("backlash_um.{}", letter(axis)),
                Cause::LateralPlay(axis) => format!("lateral_play_um.{}", letter(axis)),
                Cause::Straightness(axis) => format!("straightness_um.{}", letter(axis)),
                Cause::Reversal(axis) => format!("reversal_um.{}", letter(axis)),
                Cause::Cyclic(axis) => format!("cyclic_um.{}", letter(axis)),
                _ => name(term.cause, self.options.axes),
            };
            let (unit, sense) = match term.cause {
                Cause::Squareness => ("urad", sense),
                Cause::ScaleMismatch => ("ppm", 1.0),
                _ => ("um", 1.0),
            };
            Estimate { name, unit, factor: sense * micro(term.cause, 1.0), value: term.value }
        });
        CovarianceDocument::of_fitted(estimates.collect(), |i, j| self.found.covariance[i][j])
    }

    /// Warnings about the result, a sentence each.
    fn warnings(&self) -> Vec<String> {
        let found = &self.found;
        let mut warnings = Vec::new();
        if self.of_positions {
            warnings.push(
                "computed from positions: an axis' encoder does not see the squareness, the straightness and the scale error of \
                 the machine, only how the drive follows its command"
                    .into(),
            );
        }
        if !found.both_directions {
            warnings.push(
                "one direction only: G(b), hysteresis, servo mismatch and lateral play are not known, squareness contains \
                 servo mismatch"
                    .into(),
            );
        }
        let roundest =
            found.figures.g_b.into_iter().chain(found.figures.g.into_iter().flatten()).fold(0.0, f64::max) * 1e3;
        if roundest > 0.0 && roundest < ROUNDEST_UM {
            warnings.push(format!(
                "the circles are round to {} µm, where machines and bars reach {ROUNDEST_UM} µm at best: found deviations that may \
                 be in mm, needed µm",
                significant(roundest, 2)
            ));
        }
        for (number, axis) in (0..).zip(self.options.axes) {
            let Some(term) = found.term(Cause::Backlash(number)) else { continue };
            if term.value < -CERTAIN * term.standard_error {
                let um = significant(1e3 * term.value, 3);
                warnings.push(format!("backlash {} is {um} µm: {OVERCOMPENSATED}", axis.letter()));
            }
        }
        if !found.whole_circles {
            warnings.push(
                "an arc, not a whole circle: F is not known, as its centre is defined by a whole circle; G, G(b) and H are those of \
                 the arc, and radius, centre, scale mismatch and straightness are known less well"
                    .into(),
            );
        }
        if found.spikes_of_another_shape {
            warnings.push(
                "the spikes at reversals are not of the shape h (u/w) exp(1 − u/w): the intervals of backlash and scale mismatch \
                 are wider for that, and the spikes' height is that of the shape found"
                    .into(),
            );
        }
        if found.spikes_unresolved {
            let per_turn = self.readings.len() / if found.both_directions { 2 } else { 1 };
            warnings.push(format!(
                "the spikes at reversals are narrower than {per_turn} readings a turn resolve, and higher than the fit found: record \
                 more readings a turn"
            ));
        }
        warnings
    }

    fn shares(&self) -> Vec<Share> {
        let set_up = |cause| matches!(cause, Cause::Radius | Cause::Centre(_));
        let causes: Vec<&Term> = self.found.terms.iter().filter(|term| !set_up(term.cause)).collect();
        let all: f64 = causes.iter().map(|term| term.rms_mm * term.rms_mm).sum();
        let mut shares: Vec<Share> = causes
            .into_iter()
            .map(|term| Share {
                cause: name(term.cause, self.options.axes),
                rms_um: 1e3 * term.rms_mm,
                share: if all > 0.0 { term.rms_mm * term.rms_mm / all } else { 0.0 },
            })
            .collect();
        trueaxis_metrology::order::sort_by_number(&mut shares, |one| -one.share);
        shares
    }
}
