//! What is written into a machine of what a test has found: one rule for every command, the desk and Python.

use serde::{Serialize, Serializer};
use std::fmt;
use toml_edit::{Item, TableLike};
use trueaxis::machine::{Axis, Twist};

/// Two values agree, and a value is none, within so many standard uncertainties.
pub const AGREE: f64 = 2.0;
/// What a fit leaves may be so many times the stated noise: by chance one degree of freedom goes beyond it once in 370 fits.
pub const MISFIT: f64 = 3.0;
/// What negative lost motion comes from; said wherever it is found.
pub const OVERCOMPENSATED: &str =
    "lost motion below zero is over-compensation: the control takes up too much. Lower its backlash setting by that";
/// Nothing is written finer: a nanometre, a nanoradian, a thousandth of a ppm; of what is below one, a thousandth of itself.
const FINEST: f64 = 1e-3;
/// Nothing at all is written finer, in the unit of its key.
const SMALLEST: f64 = 1e-6;

/// A figure and how well it is known, in the unit of its key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Known {
    /// The value.
    pub value: f64,
    /// Standard uncertainty (k = 1); `None`: not known.
    pub uncertainty: Option<f64>,
    /// Degrees of freedom of that; `None`: well known.
    pub degrees_of_freedom: Option<f64>,
}

impl Known {
    /// A value with its standard uncertainty; no degrees of freedom are `None`.
    pub fn new(value: f64, uncertainty: f64, degrees_of_freedom: usize) -> Known {
        let degrees_of_freedom = Some(degrees_of_freedom as f64).filter(|degrees| *degrees >= 1.0);
        Known { value, uncertainty: Some(uncertainty), degrees_of_freedom }
    }

    /// Value and uncertainty rounded to a tenth of the uncertainty, a power of ten from there down; at the finest to 0.001, or
    /// to a thousandth of what is below one, never below 0.000001. An uncertainty is never rounded to zero.
    #[must_use]
    pub fn rounded(self) -> Known {
        let own = self.uncertainty.unwrap_or_default();
        let size = self.value.abs().max(own);
        let finest = if size > 0.0 { (FINEST * size).clamp(SMALLEST, FINEST) } else { FINEST };
        let step = finest.max(0.1 * own);
        let decimals = (-(step.log10() + 1e-9).floor()) as i32;
        // A step below one is no number in binary: by its reciprocal 0.3 stays 0.3.
        let scale = 10_f64.powi(decimals.abs());
        let round = |value: f64| match decimals >= 0 {
            true => (value * scale).round() / scale,
            false => (value / scale).round() * scale,
        };
        let least = if decimals >= 0 { 1.0 / scale } else { scale };
        Known {
            value: round(self.value) + 0.0,
            uncertainty: self.uncertainty.map(|u| round(u).max(least)),
            degrees_of_freedom: self.degrees_of_freedom.map(|degrees| degrees.round().max(1.0)),
        }
    }
}

/// `32 ± 3`.
impl fmt::Display for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Known { value, uncertainty, .. } = self.rounded();
        match uncertainty {
            Some(uncertainty) => write!(f, "{value} ± {uncertainty}"),
            None => write!(f, "{value}"),
        }
    }
}

/// Why a value is written, or not.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Why {
    /// Nothing is stated, and the value is more than its scatter.
    New,
    /// Farther from what is stated than [`AGREE`] combined standard uncertainties; how many.
    Differs(f64),
    /// Of what is stated nobody says how well it is known.
    BetterKnown,
    /// Both agree; the mean by their weights 1/u².
    Combined,
    /// Nothing is stated, and the value is within [`AGREE`] of its standard uncertainties.
    Nothing,
    /// Known only together with what is written in place of what was stated.
    Together,
    /// Both agree, and the stated value comes from this record.
    SameRecord,
    /// How well the value is known is not known.
    Unknown,
    /// By the test's own statistics.
    Moved,
    /// Lost motion below zero by more than the hysteresis.
    OverCompensated,
    /// The record does not fit the machine; what is left of it.
    Misfit(String),
    /// Written against the rule, or as it has it; what that is and why.
    Forced(String),
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Why::New => write!(f, "nothing is stated"),
            Why::Differs(times) => {
                write!(f, "differs by {times:.1} combined standard uncertainties")
            }
            Why::BetterKnown => write!(f, "no uncertainty is stated"),
            Why::Combined => write!(f, "agrees: both by their weights"),
            Why::Nothing => write!(f, "within {AGREE} standard uncertainties of none"),
            Why::Together => write!(f, "known only together with what differs"),
            Why::SameRecord => write!(f, "agrees: this record is in it already"),
            Why::Moved => write!(f, "by the test's own statistics"),
            Why::Unknown => write!(f, "found without an uncertainty"),
            Why::OverCompensated => {
                write!(f, "{}; to correct it here all the same, state a hysteresis above it", OVERCOMPENSATED)
            }
            Why::Misfit(left) => write!(f, "misfit: {left}"),
            Why::Forced(rule) => write!(f, "forced, the rule writes {rule}"),
        }
    }
}

impl Serialize for Why {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// What becomes of a stated value in the light of one that was found: the value to be written, or `None` where what is stated
/// stays. `independent`: the found value rests on another measurement than the stated one.
///
/// With d = |found − stated| and u² = u(found)² + u(stated)²: d > 2 u, or no u(stated), and the found value takes its place; else
/// both are estimates of one thing, and where they are independent their mean weighted by 1/u² does, of the standard
/// uncertainty (Σ 1/u²)^(−1/2) and degrees of freedom after Welch and Satterthwaite. Where nothing is stated, what is within 2 u
/// of zero is not written.
pub fn decide(stated: Option<Known>, found: Known, independent: bool) -> (Option<Known>, Why) {
    let Some(own) = found.uncertainty else { return (None, Why::Unknown) };
    let Some(stated) = stated else {
        let is_something = found.value.abs() > AGREE * own;
        return if is_something { (Some(found.rounded()), Why::New) } else { (None, Why::Nothing) };
    };
    let Some(before) = stated.uncertainty else { return (Some(found.rounded()), Why::BetterKnown) };
    let (away, combined) = ((found.value - stated.value).abs(), own.hypot(before));
    if away > AGREE * combined {
        return (Some(found.rounded()), Why::Differs(away / combined));
    }
    if !independent {
        return (None, Why::SameRecord);
    }
    (Some(mean(stated, found, share(ratio(before, own))).rounded()), Why::Combined)
}

/// How many times the other uncertainty an uncertainty is.
fn ratio(before: f64, own: f64) -> f64 {
    own.max(SMALLEST) / before.max(SMALLEST)
}

/// The share of a found value in the mean by weights 1/u²; `ratio`: its uncertainty over that of what is stated.
fn share(ratio: f64) -> f64 {
    1.0 / (1.0 + ratio.powi(2))
}

/// The mean of two values with a share of what was found.
fn mean(stated: Known, found: Known, share: f64) -> Known {
    let parts = [(stated, 1.0 - share), (found, share)];
    let squares = parts.map(|(known, share)| (share * known.uncertainty.unwrap_or_default().max(SMALLEST)).powi(2));
    let all: f64 = squares.iter().sum();
    let of_each = parts.iter().zip(squares);
    let inverse: f64 = of_each
        .map(|((known, _), square)| known.degrees_of_freedom.map_or(0.0, |of| (square / all).powi(2) / of))
        .sum();
    Known {
        value: stated.value + share * (found.value - stated.value),
        uncertainty: Some(all.sqrt()),
        degrees_of_freedom: (inverse > 0.0).then(|| 1.0 / inverse),
    }
}

/// Decisions on what is known only together ([`Finding::together`]), made of those on each alone. Where one of a group takes the
/// place of what is stated, all of it is written as it was found, also what the fit held at its value. Where all agree, all are
/// combined with one share, that of the geometric mean of their uncertainties' ratios, so that what belongs together stays together.
pub(crate) fn together(findings: &[Finding], decisions: &mut [Decision]) {
    let mut groups: Vec<&str> = findings.iter().map(|finding| finding.together.as_str()).collect();
    groups.sort_unstable();
    groups.dedup();
    for group in groups.into_iter().filter(|group| !group.is_empty()) {
        let own = findings.iter().zip(decisions.iter_mut()).filter(|(finding, _)| finding.together == group);
        let mut own: Vec<&mut Decision> = own.map(|(_, decision)| decision).collect();
        let replaces = |of: &Decision| matches!(of.why, Why::New | Why::Differs(_) | Why::BetterKnown);
        if own.iter().any(|of| replaces(of)) {
            for of in own {
                of.written = Some(of.found.rounded());
                if !replaces(of) {
                    of.why = Why::Together;
                }
            }
            continue;
        }
        own.retain(|of| of.why == Why::Combined);
        let ratios = own.iter().filter_map(|of| Some(ratio(of.stated?.uncertainty?, of.found.uncertainty?).ln()));
        let share = share((ratios.sum::<f64>() / own.len().max(1) as f64).exp());
        for of in own {
            of.written = of.stated.map(|stated| mean(stated, of.found, share).rounded());
        }
    }
}

/// A value that a test has found for a key of `machine.toml`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// Full name of the key, `location.C0Y_urad`; errors of a table by `axis.X.scale_ppm` and `axis.X.EYX_um`.
    pub key: String,
    /// What was found, in the unit of the key; of a curve the root of its mean square.
    pub found: Known,
    /// Whether it is what the machine's figures leave, and their value is to be added to it.
    pub on_top: bool,
    /// Whether it is taken as it was found: it has moved by a test against all that was measured before, or it is one of several
    /// that are known together much better than each alone.
    pub moved: bool,
    /// Of errors of a table: positions, and the six errors EX to EC at each, mm and rad, that are added to it.
    pub curve: Vec<(f64, Twist)>,
    /// What it is known together with: findings of one name are written all or none. Empty: known alone.
    pub together: String,
}

/// What a fit leaves of its record: root mean squares, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Before anything is explained.
    pub before_mm: f64,
    /// What is left.
    pub left_mm: f64,
    /// Standard deviation of a reading as it is stated; `None`: as the machine's `[uncertainty]` has it.
    pub noise_mm: Option<f64>,
}

impl Fit {
    /// What is wrong where the record does not fit: more than [`MISFIT`] times the noise is left, or, where none is stated,
    /// more than half of the mean square. `noise_mm`: that of the machine.
    pub(crate) fn misfit(&self, noise_mm: Option<f64>) -> Option<String> {
        let um = |mm: f64| format!("{:.2} µm", 1e3 * mm);
        let left = || format!("{} of {} RMS are left", um(self.left_mm), um(self.before_mm));
        match self.noise_mm.or(noise_mm) {
            Some(noise) => (self.left_mm > MISFIT * noise).then(|| format!("{}, the noise is {}", left(), um(noise))),
            None => (self.left_mm.powi(2) > 0.5 * self.before_mm.powi(2)).then(|| {
                format!("{}; where that is noise, state it: eve_um of [uncertainty] or repeatability_um", left())
            }),
        }
    }
}

/// What is done about a finding; as JSON `why` is a sentence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Decision {
    /// Full name of the key.
    pub key: String,
    /// What the machine states, in JSON `old`; `None`: nothing.
    #[serde(rename = "old")]
    pub stated: Option<Known>,
    /// What was found, in all.
    pub found: Known,
    /// What is written; `None`: what is stated stays.
    pub written: Option<Known>,
    /// Why.
    pub why: Why,
}

impl Decision {
    /// Writes what was found whatever was decided; an uncertainty that is no number is not known.
    pub(crate) fn force(&mut self) {
        let found = self.found;
        let forced = Known { uncertainty: found.uncertainty.filter(|own| own.is_finite()), ..found }.rounded();
        let rule = match self.written {
            Some(written) if written == forced => String::from("the same"),
            Some(written) => written.to_string(),
            None => String::from("nothing"),
        };
        self.written = Some(forced);
        self.why = Why::Forced(format!("{rule}: {}", self.why));
    }
}

/// One sentence.
impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Decision { key, stated, found, written, why } = self;
        let stated = stated.map_or_else(|| String::from("nothing"), |stated| stated.to_string());
        let written = written.map_or_else(|| String::from("nothing"), |written| written.to_string());
        write!(f, "{key}: found {found} where {stated} is stated, written {written} ({why})")
    }
}

/// The decisions as a table: key, old, found, written and why; no text where there are none.
pub fn table(decisions: &[Decision]) -> String {
    let shown = |known: &Option<Known>| known.map_or_else(|| String::from("–"), |known| known.to_string());
    let head = ["key", "old", "found", "written", "why"].map(String::from);
    let rows = decisions
        .iter()
        .map(|of| [of.key.clone(), shown(&of.stated), of.found.to_string(), shown(&of.written), of.why.to_string()]);
    let rows: Vec<[String; 5]> =
        if decisions.is_empty() { Vec::new() } else { [head].into_iter().chain(rows).collect() };
    let widths: [usize; 5] =
        std::array::from_fn(|k| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or_default());
    let line = |row: &[String; 5]| {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Number by which a record is known again: FNV-1a of its bytes.
pub fn record_number(bytes: &[u8]) -> String {
    let number = bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{number:016x}")
}

/// Keys beside a key: its standard uncertainty, and the degrees of freedom of that.
pub(crate) fn beside(key: &str) -> [String; 2] {
    let (path, last) = key.rsplit_once('.').unwrap_or(("", key));
    let section = if path == "location" { String::from("uncertainty.location") } else { format!("{path}.uncertainty") };
    // Figures of a drive or of friction come from one fit.
    if path.ends_with(".drive") || path.ends_with(".friction") {
        return [format!("{section}.{last}"), format!("{section}.degrees_of_freedom")];
    }
    let name = last.rsplit_once('_').map_or(last, |(name, _)| name);
    [format!("{section}.{last}"), format!("{section}.{name}_degrees_of_freedom")]
}

/// The axis of a key `axis.X.…`.
pub(crate) fn axis_of(key: &str) -> Option<Axis> {
    let letter = key.strip_prefix("axis.")?.chars().next()?;
    Axis::ALL.into_iter().find(|axis| axis.letter() == letter)
}

/// A number of a document by its full name.
pub(crate) fn number(document: &dyn TableLike, key: &str) -> Option<f64> {
    let mut at = document;
    let (path, last) = key.rsplit_once('.').unwrap_or(("", key));
    for part in path.split('.').filter(|part| !part.is_empty()) {
        at = at.get(part)?.as_table_like()?;
    }
    let value = at.get(last).and_then(Item::as_value)?;
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}

/// What a document states for a finding.
pub(crate) fn stated(document: &dyn TableLike, finding: &Finding) -> Option<Known> {
    let [uncertainty_key, degrees_key] = beside(&finding.key);
    let section = uncertainty_key.rsplit_once('.').map_or("", |(section, _)| section);
    let uncertainty = number(document, &uncertainty_key);
    // What has an uncertainty and no value is known as zero: a location error that is left out, what a table leaves.
    let value = number(document, &finding.key).filter(|_| finding.curve.is_empty());
    let value = value.or(uncertainty.map(|_| 0.0))?;
    let degrees = number(document, &degrees_key);
    let degrees = degrees.or_else(|| number(document, &format!("{section}.degrees_of_freedom")));
    Some(Known { value, uncertainty, degrees_of_freedom: degrees.filter(|_| uncertainty.is_some()) })
}
