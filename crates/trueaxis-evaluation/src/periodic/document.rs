//! The result as a document.

use super::Test;
use crate::shown::{half_width, unit};
use serde::Serialize;
use trueaxis_metrology::periodic::{Harmonic, Period, least_amplitude};
use trueaxis_report::number::significant;

/// Standard errors widened by more than this by the residual's power near a harmonic are worth a remark.
const WIDENED: f64 = 1.5;

/// Errors of an axis that repeat, and what is left.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PeriodicDocument {
    /// Letter of the axis.
    pub axis: String,
    /// Unit of positions and periods: mm or deg.
    pub unit: &'static str,
    /// Unit of errors: um or urad.
    pub error_unit: &'static str,
    /// Readings of the fit.
    pub readings: usize,
    /// Range of the positions.
    pub length: f64,
    /// Distance between neighbouring points.
    pub spacing: f64,
    /// The periods, in the order given.
    pub periods: Vec<PeriodFound>,
    /// Bends of the slow error, a cubic spline, in each direction.
    pub bends: usize,
    /// Root mean square beside the slow error if no harmonic is fitted.
    pub before: f64,
    /// Root mean square that slow error and harmonics leave.
    pub left: f64,
    /// Share of the mean square of `before` that the harmonics explain.
    pub explained: f64,
    /// Readings less unknowns.
    pub degrees_of_freedom: usize,
    /// Largest factor by which the residual's power near a harmonic widens its standard errors; 1 for white noise.
    pub widened: f64,
    /// Strongest wave that is left, null if noise explains it.
    pub remains: Option<LeftFound>,
    /// The result in a sentence.
    pub verdict: String,
    /// Caveats on the result.
    pub warnings: Vec<String>,
}

/// One period; harmonics and uncertainty as in `[[axis.X.periodic]]` of a machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PeriodFound {
    /// The period.
    pub period: f64,
    /// Cosine and sine of harmonics 1, 2, … up to the highest that is kept, in positive travel.
    pub harmonics: Vec<[f64; 2]>,
    /// The same in negative travel; null if the directions do not differ.
    pub reverse: Option<Vec<[f64; 2]>>,
    /// Standard uncertainty of a coefficient.
    pub standard_uncertainty: f64,
    /// Largest less smallest error within the period, in positive and negative travel.
    pub peak_to_valley: [f64; 2],
    /// Every harmonic that was tried.
    pub tried: Vec<HarmonicFound>,
}

/// A harmonic A cos(2πhq/P − φ).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HarmonicFound {
    /// Direction of travel: both, positive or negative.
    pub direction: &'static str,
    /// h.
    pub harmonic: usize,
    /// Whether it exceeds its scatter; if not, its values are zero.
    pub kept: bool,
    /// Amplitude A.
    pub amplitude: f64,
    /// Phase φ, degrees.
    pub phase_deg: f64,
    /// Coefficient of the cosine.
    pub cosine: f64,
    /// Coefficient of the sine.
    pub sine: f64,
    /// Standard error of a coefficient.
    pub standard_error: f64,
    /// Half-width of its 95 % interval.
    pub expanded_uncertainty: f64,
}

/// A wave that is left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LeftFound {
    /// Its period.
    pub period: f64,
    /// Its amplitude.
    pub amplitude: f64,
}

fn error(own: &Harmonic) -> f64 {
    own.standard_error[0].max(own.standard_error[1])
}

fn pairs(own: &[Harmonic], highest: usize) -> Vec<[f64; 2]> {
    let value = |number: usize| own.iter().find(|own| own.number == number).map_or([0.0; 2], |own| own.value);
    (1..=highest).map(value).collect()
}

impl PeriodFound {
    pub(super) fn new(own: &Period, freedom: f64) -> PeriodFound {
        let directions = match &own.reverse {
            None => vec![("both", &own.forward)],
            Some(reverse) => vec![("positive", &own.forward), ("negative", reverse)],
        };
        let tried = directions.iter().flat_map(|(direction, all)| {
            all.iter().map(|own| HarmonicFound {
                direction,
                harmonic: own.number,
                kept: own.is_kept,
                amplitude: own.amplitude(),
                phase_deg: own.phase_rad().to_degrees(),
                cosine: own.value[0],
                sine: own.value[1],
                standard_error: error(own),
                expanded_uncertainty: half_width(error(own), freedom),
            })
        });
        let tried: Vec<HarmonicFound> = tried.collect();
        let kept = |own: &&HarmonicFound| own.kept || own_highest(&tried) == 0;
        PeriodFound {
            period: own.period,
            harmonics: pairs(&own.forward, own.highest()),
            reverse: own.reverse.as_ref().map(|reverse| pairs(reverse, own.highest())),
            standard_uncertainty: tried.iter().filter(kept).map(|own| own.standard_error).fold(0.0, f64::max),
            peak_to_valley: [false, true].map(|is_negative| own.peak_to_valley(is_negative)),
            tried: tried.clone(),
        }
    }
}

fn own_highest(tried: &[HarmonicFound]) -> usize {
    tried.iter().filter(|own| own.kept).map(|own| own.harmonic).max().unwrap_or(0)
}

impl Test {
    /// The document.
    pub fn document(&self) -> PeriodicDocument {
        let found = &self.found;
        let freedom = found.degrees_of_freedom as f64;
        let mut document = PeriodicDocument {
            axis: self.options.axis.letter().to_string(),
            unit: self.options.unit(),
            error_unit: if self.options.axis.is_rotary() { "urad" } else { "um" },
            readings: self.readings.len(),
            length: found.length,
            spacing: found.spacing,
            periods: found.periods.iter().map(|own| PeriodFound::new(own, freedom)).collect(),
            bends: found.bends,
            before: found.before,
            left: found.left,
            explained: found.explained,
            degrees_of_freedom: found.degrees_of_freedom,
            widened: found.widened,
            remains: found.remains.map(|left| LeftFound { period: left.period, amplitude: left.amplitude }),
            verdict: String::new(),
            warnings: Vec::new(),
        };
        document.verdict = document.sentence(self.directions());
        document.warnings = self.warnings(&document);
        document
    }

    fn warnings(&self, document: &PeriodicDocument) -> Vec<String> {
        let (unit, mut warnings) = (document.unit, Vec::new());
        for own in &self.found.periods {
            for (number, (period, other)) in &own.coincide {
                warnings.push(format!(
                    "harmonic {number} of {} {unit} is not told apart from harmonic {other} of {period} {unit} over {} {unit}: it \
                     counts as the latter",
                    own.period,
                    significant(document.length, 4)
                ));
            }
        }
        if document.widened > WIDENED {
            warnings.push(format!(
                "what is left is not white: drift or vibration near a harmonic widens its uncertainty by a factor of {}",
                significant(document.widened, 2)
            ));
        }
        if self.left_out > 0 {
            warnings.push(format!("{} readings within 3° of a reversal are left out: spikes and play", self.left_out));
        }
        if self.directions() < 2 {
            warnings.push(format!(
                "one direction of travel only: the other one is written the same unless the machine states reverse_{} for it",
                document.error_unit
            ));
        }
        warnings
    }

    /// Number of directions of travel in the record.
    fn directions(&self) -> usize {
        [false, true].into_iter().filter(|side| self.readings.iter().any(|own| own.own.is_negative == *side)).count()
    }
}

impl PeriodicDocument {
    /// What repeats, how much of the error that is, and what is left.
    fn sentence(&self, directions: usize) -> String {
        let micro = unit(self.error_unit);
        let of_period = |own: &PeriodFound| {
            let within = format!("{} {}", own.period, self.unit);
            if own.harmonics.is_empty() {
                let limit = 2.0 * least_amplitude(own.standard_uncertainty, directions, self.degrees_of_freedom);
                return format!(
                    "no harmonic above {} {micro} peak to valley repeats within {within}",
                    significant(limit, 2)
                );
            }
            let [up, down] = own.peak_to_valley.map(|size| significant(size, 3));
            let down = own.reverse.as_ref().map_or(String::new(), |_| format!(", {down} in negative travel"));
            format!("{up} {micro}{down} peak to valley repeat within {within}")
        };
        let parts: Vec<String> = self.periods.iter().map(of_period).collect();
        let share = format!(
            "{} % of what the slow error leaves is explained, {} of {} {micro} RMS are left",
            significant(100.0 * self.explained.max(0.0), 3),
            significant(self.left, 3),
            significant(self.before, 3)
        );
        let rest = match &self.remains {
            None => "as noise".to_owned(),
            Some(left) => format!(
                "with a wave of {} {} and an amplitude of {} {micro} in it",
                significant(left.period, 3),
                self.unit,
                significant(left.amplitude, 2)
            ),
        };
        format!("{}; {share}, {rest}.", parts.join("; "))
    }
}
