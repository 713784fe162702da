//! What is written into a machine of what a test has found: one rule for every command, the desk and Python.

use serde::{Serialize, Serializer};
use std::fmt;
use toml_edit::{Item, TableLike};
use trueaxis::machine::Axis;

/// Two values agree, and a value is none, within so many standard uncertainties.
pub const AGREE: f64 = 2.0;
/// What a fit leaves may be so many times the stated noise: by chance one degree of freedom goes beyond it once in 370 fits.
pub const MISFIT: f64 = 3.0;
/// What negative lost motion comes from; said wherever it is found.
pub const OVERCOMPENSATED: &str =
    "lost motion below zero is over-compensation: the control takes up too much. Lower its backlash setting by that";
/// Nothing is written finer: a nanometre, a nanoradian, a thousandth of a ppm.
const FINEST: f64 = 1e-3;

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

    /// Value and uncertainty rounded to a tenth of the uncertainty, a power of ten from there down, 0.001 at the finest;
    /// an uncertainty is never rounded to zero.
    #[must_use]
    pub fn rounded(self) -> Known {
        let tenth = self.uncertainty.map_or(0.0, |u| 0.1 * u);
        let decimals = if tenth > FINEST { (-(tenth.log10() + 1e-9).floor()) as i32 } else { 3 };
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
            Why::SameRecord => write!(f, "agrees: this record is in it already"),
            Why::Moved => write!(f, "by the test's own statistics"),
            Why::Unknown => write!(f, "found without an uncertainty"),
            Why::OverCompensated => {
                write!(f, "{}; to correct it here all the same, state a hysteresis above it", OVERCOMPENSATED)
            }
            Why::Misfit(left) => write!(f, "misfit: {left}"),
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
    (Some(weighted(stated, before, found, own).rounded()), Why::Combined)
}

/// The mean of two values by their weights.
fn weighted(a: Known, u_a: f64, b: Known, u_b: f64) -> Known {
    let weight = |u: f64| 1.0 / u.max(1e-6).powi(2);
    let (to_a, to_b) = (weight(u_a), weight(u_b));
    let all = to_a + to_b;
    // Each share of the mean's variance is its weight's share.
    let part = |weight: f64, known: Known| known.degrees_of_freedom.map_or(0.0, |of| (weight / all).powi(2) / of);
    let parts = part(to_a, a) + part(to_b, b);
    Known {
        value: (to_a * a.value + to_b * b.value) / all,
        uncertainty: Some(all.powf(-0.5)),
        degrees_of_freedom: (parts > 0.0).then(|| 1.0 / parts),
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
    /// Of errors of a table: positions, and the translations X, Y, Z at each, mm, that are added to it.
    pub curve: Vec<(f64, [f64; 3])>,
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
    /// What the machine states; `None`: nothing.
    pub stated: Option<Known>,
    /// What was found, in all.
    pub found: Known,
    /// What is written; `None`: what is stated stays.
    pub written: Option<Known>,
    /// Why.
    pub why: Why,
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
