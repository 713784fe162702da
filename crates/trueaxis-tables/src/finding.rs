//! Decides which results of a test are written into a machine: one rule for every command, the desk and Python.

use crate::text::aligned;
use serde::{Serialize, Serializer};
use std::fmt;
use toml_edit::{Item, TableLike};
use trueaxis::machine::{Axis, Twist};

/// Two values agree, and a value counts as zero, within this many standard uncertainties.
pub const AGREE: f64 = 2.0;
/// A fit may leave this many times the stated noise: by chance one degree of freedom exceeds it once in 370 fits.
pub const MISFIT: f64 = 3.0;
/// Cause of negative lost motion, as every command reports it.
pub const OVERCOMPENSATED: &str =
    "lost motion below zero is over-compensation: the control takes up too much. Lower its backlash setting by that";
/// Finest step written: a nanometre, a nanoradian, a thousandth of a ppm; for values below one, a thousandth of the value.
const FINEST: f64 = 1e-3;
/// Absolute lower limit of that step, in the unit of the key.
const SMALLEST: f64 = 1e-6;

/// A value and its uncertainty, in the unit of its key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Known {
    /// The value.
    pub value: f64,
    /// Standard uncertainty (k = 1); `None`: not known.
    pub uncertainty: Option<f64>,
    /// Degrees of freedom of the uncertainty; `None`: well known.
    pub degrees_of_freedom: Option<f64>,
}

impl Known {
    /// A value with its standard uncertainty; zero degrees of freedom become `None`.
    pub fn new(value: f64, uncertainty: f64, degrees_of_freedom: usize) -> Known {
        let degrees_of_freedom = Some(degrees_of_freedom as f64).filter(|degrees| *degrees >= 1.0);
        Known { value, uncertainty: Some(uncertainty), degrees_of_freedom }
    }

    /// Value and uncertainty rounded to a tenth of the uncertainty, down to the next power of ten; not finer than 0.001, or
    /// than a thousandth of a value below one, and never finer than 0.000001. An uncertainty is never rounded to zero.
    #[must_use]
    pub fn rounded(self) -> Known {
        let own = self.uncertainty.unwrap_or_default();
        let size = self.value.abs().max(own);
        let finest = if size > 0.0 { (FINEST * size).clamp(SMALLEST, FINEST) } else { FINEST };
        let step = finest.max(0.1 * own);
        let decimals = (-(step.log10() + 1e-9).floor()) as i32;
        // A step below one is not exact in binary: with its reciprocal, 0.3 stays 0.3.
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

/// Displayed as `32 (u 3)`: u is the standard uncertainty. ± marks expanded uncertainties.
impl fmt::Display for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Known { value, uncertainty, .. } = self.rounded();
        match uncertainty {
            Some(uncertainty) => write!(f, "{value} (u {uncertainty})"),
            None => write!(f, "{value}"),
        }
    }
}

/// Why a value is written, or not.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Why {
    /// Nothing is stated, and the value exceeds its scatter.
    New,
    /// It differs from the stated value by more than [`AGREE`] combined standard uncertainties; by how many.
    Differs(f64),
    /// The stated value has no uncertainty.
    BetterKnown,
    /// Both agree; written is the mean weighted by 1/u².
    Combined,
    /// Nothing is stated, and the value is within [`AGREE`] of its standard uncertainties.
    Nothing,
    /// Known only together with a value that replaces a stated one.
    Together,
    /// Both agree, and the stated value comes from this record.
    SameRecord,
    /// The uncertainty of the value is not known.
    Unknown,
    /// Decided by the test's own statistics.
    Moved,
    /// Lost motion below zero by more than the hysteresis.
    OverCompensated,
    /// The record does not fit the machine; the residual.
    Misfit(String),
    /// Written regardless of the rule; what the rule decided and why.
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
            Why::Combined => write!(f, "agrees: weighted mean of both"),
            Why::Nothing => write!(f, "within {AGREE} standard uncertainties of zero"),
            Why::Together => write!(f, "known only together with a value that differs"),
            Why::SameRecord => write!(f, "agrees: this record is already included"),
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

/// Decides on a stated value given a found one: returns the value to write, or `None` if the stated value stays.
/// `independent`: the found value comes from a different measurement than the stated one.
///
/// With d = |found − stated| and u² = u(found)² + u(stated)²: if d > 2 u, or without u(stated), the found value replaces the
/// stated one. Otherwise both estimate the same quantity; if they are independent, their mean weighted by 1/u² replaces it,
/// with the standard uncertainty (Σ 1/u²)^(−1/2) and degrees of freedom after Welch and Satterthwaite. If nothing is stated, a
/// value within 2 u of zero is not written.
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

/// Ratio of the found uncertainty to the stated one.
fn ratio(before: f64, own: f64) -> f64 {
    own.max(SMALLEST) / before.max(SMALLEST)
}

/// Weight of a found value in the mean weighted by 1/u²; `ratio`: its uncertainty over the stated one's.
fn share(ratio: f64) -> f64 {
    1.0 / (1.0 + ratio.powi(2))
}

/// Mean of two values, with the weight of the found one.
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

/// Decides on values that are known only together ([`Finding::together`]), starting from the decision on each alone. If one of
/// a group replaces its stated value, the whole group is written as found, including values that the fit held fixed. If all
/// agree, all are combined with one weight, from the geometric mean of their uncertainties' ratios, so that the group stays
/// consistent.
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
                of.share = 1.0;
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
            of.share = share;
        }
    }
}

/// A value that a test has found for a key of `machine.toml`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// Full name of the key, `location.C0Y_urad`; errors of a table by `axis.X.scale_ppm` and `axis.X.EYX_um`.
    pub key: String,
    /// The found value, in the unit of the key; for a curve its root mean square.
    pub found: Known,
    /// Whether it is the residual of the machine's figures, to which their value is to be added.
    pub on_top: bool,
    /// Whether it is written as found: a test against all earlier measurements shows that it has moved, or it is one of
    /// several that are known together much better than each alone.
    pub moved: bool,
    /// For errors of a table: positions, and the six errors EX to EC at each, mm and rad, that are added to the table.
    pub curve: Vec<(f64, Twist)>,
    /// Name of its group: findings of one group are written all or none. Empty: known alone.
    pub together: String,
}

/// How well a fit explains its record: root mean squares, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Before the fit.
    pub before_mm: f64,
    /// Residual of the fit.
    pub left_mm: f64,
    /// Stated standard deviation of a reading; `None`: as in the machine's `[uncertainty]`.
    pub noise_mm: Option<f64>,
    /// Whether the figures are angles, mrad instead of mm, with which the machine's noise of lengths is not compared.
    pub is_angle: bool,
}

impl Fit {
    /// Describes the misfit if the residual exceeds [`MISFIT`] times the noise or, without a stated noise, half of the mean
    /// square. `noise_mm`: the machine's noise.
    pub(crate) fn misfit(&self, noise_mm: Option<f64>) -> Option<String> {
        let unit = if self.is_angle { "µrad" } else { "µm" };
        let um = |mm: f64| format!("{:.2} {unit}", 1e3 * mm);
        let noise_mm = noise_mm.filter(|_| !self.is_angle);
        let left = || format!("{} of {} RMS remain", um(self.left_mm), um(self.before_mm));
        match self.noise_mm.or(noise_mm) {
            Some(noise) => (self.left_mm > MISFIT * noise).then(|| format!("{}, the noise is {}", left(), um(noise))),
            None => (self.left_mm.powi(2) > 0.5 * self.before_mm.powi(2)).then(|| match self.is_angle {
                true => left(),
                false => {
                    format!("{}; where that is noise, state it: eve_um of [uncertainty] or repeatability_um", left())
                }
            }),
        }
    }
}

/// Decision on a finding; in JSON `why` is a sentence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Decision {
    /// Full name of the key.
    pub key: String,
    /// The value that the machine states, `old` in JSON; `None`: nothing.
    #[serde(rename = "old")]
    pub stated: Option<Known>,
    /// The found value in total.
    pub found: Known,
    /// The value written; `None`: the stated value stays.
    pub written: Option<Known>,
    /// Reason.
    pub why: Why,
    /// Share of the found value in the written one, 0 … 1.
    #[serde(skip)]
    pub(crate) share: f64,
}

impl Decision {
    /// What [`decide`] has decided.
    pub(crate) fn new(
        key: String,
        stated: Option<Known>,
        found: Known,
        (written, why): (Option<Known>, Why),
    ) -> Decision {
        let uncertainties = stated.and_then(|stated| stated.uncertainty).zip(found.uncertainty);
        let share = match (&why, uncertainties) {
            _ if written.is_none() => 0.0,
            (Why::Combined, Some((before, own))) => share(ratio(before, own)),
            _ => 1.0,
        };
        Decision { key, stated, found, written, why, share }
    }

    /// Writes the found value regardless of the decision; an uncertainty that is not finite becomes unknown.
    pub(crate) fn force(&mut self) {
        let found = self.found;
        let forced = Known { uncertainty: found.uncertainty.filter(|own| own.is_finite()), ..found }.rounded();
        let rule = match self.written {
            Some(written) if written == forced => String::from("the same"),
            Some(written) => written.to_string(),
            None => String::from("nothing"),
        };
        self.written = Some(forced);
        self.share = 1.0;
        self.why = Why::Forced(format!("{rule}: {}", self.why));
    }
}

/// The decision in one sentence.
impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Decision { key, stated, found, written, why, .. } = self;
        let stated = stated.map_or_else(|| String::from("nothing"), |stated| stated.to_string());
        let written = written.map_or_else(|| String::from("nothing"), |written| written.to_string());
        write!(f, "{key}: found {found} where {stated} is stated, written {written} ({why})")
    }
}

/// The decisions as a table: key, old, found, written and why; without decisions, an empty text. The rule compares standard
/// uncertainties u, which the machine states, and the table has these.
pub fn table(decisions: &[Decision]) -> String {
    if decisions.is_empty() {
        return String::new();
    }
    let shown = |known: &Option<Known>| known.map_or_else(|| String::from("–"), |known| known.to_string());
    let rows: Vec<[String; 5]> = decisions
        .iter()
        .map(|of| [of.key.clone(), shown(&of.stated), of.found.to_string(), shown(&of.written), of.why.to_string()])
        .collect();
    let head = vec!["key", "old", "found", "written", "why; u: standard uncertainty"];
    let lines = std::iter::once(head).chain(rows.iter().map(|row| row.iter().map(String::as_str).collect()));
    aligned(&lines.collect::<Vec<_>>(), |_| true).trim_end().to_owned()
}

/// Number that identifies a record: FNV-1a of its bytes.
pub fn record_number(bytes: &[u8]) -> String {
    let number = bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{number:016x}")
}

/// Keys that accompany a key: its standard uncertainty and the degrees of freedom of that.
pub(crate) fn uncertainty_keys(key: &str) -> [String; 2] {
    let (path, last) = key.rsplit_once('.').unwrap_or(("", key));
    let section = if path == "location" { String::from("uncertainty.location") } else { format!("{path}.uncertainty") };
    // All values of a drive or of friction come from one fit.
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

/// A number of a document by its full key.
pub(crate) fn number(document: &dyn TableLike, key: &str) -> Option<f64> {
    let mut at = document;
    let (path, last) = key.rsplit_once('.').unwrap_or(("", key));
    for part in path.split('.').filter(|part| !part.is_empty()) {
        at = at.get(part)?.as_table_like()?;
    }
    let value = at.get(last).and_then(Item::as_value)?;
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}

/// The value that a document states for a finding.
pub(crate) fn stated(document: &dyn TableLike, finding: &Finding) -> Option<Known> {
    let [uncertainty_key, degrees_key] = uncertainty_keys(&finding.key);
    let section = uncertainty_key.rsplit_once('.').map_or("", |(section, _)| section);
    let uncertainty = number(document, &uncertainty_key);
    // A key with an uncertainty but no value counts as zero: an omitted location error, or the residual of a table.
    let value = number(document, &finding.key).filter(|_| finding.curve.is_empty());
    let value = value.or(uncertainty.map(|_| 0.0))?;
    let degrees = number(document, &degrees_key);
    let degrees = degrees.or_else(|| number(document, &format!("{section}.degrees_of_freedom")));
    Some(Known { value, uncertainty, degrees_of_freedom: degrees.filter(|_| uncertainty.is_some()) })
}
