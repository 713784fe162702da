//! Periods that a test has found, decided and written as sections `[[axis.X.periodic]]`.

use crate::Machine;
use crate::document::{section, set};
use crate::error::FileError;
use crate::finding::{AGREE, Decision, Known, Why};
use crate::origin::Origin;
use crate::text::short;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, TableLike, Value};
use trueaxis::machine::Axis;

/// Two periods are one if their numbers of waves over a length differ by less.
const SAME: f64 = 0.01;

/// Cosine and sine of harmonics 1, 2, …, µm or µrad.
type Harmonics = Vec<[f64; 2]>;

/// The error of an axis within a period, as a test has found it.
///
/// It is decided as a whole: coefficients that all agree with the stated ones are combined with them by one weight; if one
/// differs by more than [`AGREE`] combined standard uncertainties, all are written as found. Value of the decision is the root
/// of the sum of the squares of all coefficients of positive travel.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundPeriod {
    /// The axis.
    pub axis: Axis,
    /// The period, mm or degrees.
    pub period: f64,
    /// Range of the record's positions, mm or degrees: it tells periods apart whose numbers of waves over it differ by one.
    pub length: f64,
    /// Harmonics in positive travel, and in negative travel unless `reverse` has others.
    pub harmonics: Harmonics,
    /// Harmonics in negative travel; empty: as in positive travel.
    pub reverse: Harmonics,
    /// Whether the record travels in negative direction only, or in positive only; `None`: in both.
    pub one_way: Option<bool>,
    /// Numbers of the harmonics that were tried; any other stated one stays.
    pub tried: Vec<usize>,
    /// Standard uncertainty of a coefficient.
    pub uncertainty: f64,
    /// Degrees of freedom of the uncertainty.
    pub degrees_of_freedom: usize,
    /// Whether they are what the machine's figures leave, to be added to them.
    pub on_top: bool,
}

/// What a machine states of a period.
struct Stated {
    harmonics: Harmonics,
    reverse: Harmonics,
    uncertainty: Option<f64>,
}

fn size(harmonics: &[[f64; 2]]) -> f64 {
    harmonics.iter().flatten().map(|own| own * own).sum::<f64>().sqrt()
}

/// Calls `of` for each coefficient of both; missing ones are zero.
fn joined(a: &[[f64; 2]], b: &[[f64; 2]], of: impl Fn(f64, f64) -> f64) -> Harmonics {
    let at = |all: &[[f64; 2]], h: usize, c: usize| all.get(h).map_or(0.0, |pair| pair[c]);
    (0..a.len().max(b.len())).map(|h| [0, 1].map(|c| of(at(a, h, c), at(b, h, c)))).collect()
}

impl FoundPeriod {
    fn letter(&self) -> char {
        self.axis.letter()
    }

    /// Unit of the period, and of its error.
    fn units(&self) -> [&'static str; 2] {
        if self.axis.is_rotary() { ["deg", "urad"] } else { ["mm", "um"] }
    }

    /// Sections of the axis in a document.
    fn sections<'d>(&self, document: &'d DocumentMut) -> Option<&'d ArrayOfTables> {
        document.get("axis")?.get(self.letter().to_string())?.get("periodic")?.as_array_of_tables()
    }

    /// Number of the section with this period.
    fn place(&self, document: &DocumentMut) -> Option<usize> {
        let near = |stated: f64| self.waves_apart(stated, self.length) < SAME;
        self.sections(document)?.iter().position(|table| self.period_of(table).is_some_and(near))
    }

    /// The period that a section states.
    fn period_of(&self, section: &toml_edit::Table) -> Option<f64> {
        section.get(&format!("period_{}", self.units()[0])).and_then(number)
    }

    /// Difference to another period in waves over a length.
    fn waves_apart(&self, period: f64, length: f64) -> f64 {
        (1.0 / self.period - 1.0 / period).abs() * length
    }

    fn stated(&self, document: &DocumentMut) -> Option<Stated> {
        Some(self.stated_in(self.sections(document)?.get(self.place(document)?)?))
    }

    fn stated_in(&self, table: &toml_edit::Table) -> Stated {
        let micro = self.units()[1];
        let list = |key: &str| table.get(&format!("{key}_{micro}")).map(pairs).unwrap_or_default();
        let uncertainty = table.get(&format!("standard_uncertainty_{micro}")).and_then(number);
        Stated { harmonics: list("harmonics"), reverse: list("reverse"), uncertainty }
    }

    /// Stated harmonics to which the found ones are added: all if these are a residual, otherwise those that were not tried.
    fn staying(&self, stated: &[[f64; 2]]) -> Harmonics {
        let stays = |number: usize| self.on_top || !self.tried.contains(&number);
        let count = (1..=stated.len()).rev().find(|number| stays(*number)).unwrap_or(0);
        (1..=count).map(|number| if stays(number) { stated[number - 1] } else { [0.0; 2] }).collect()
    }

    /// Found harmonics in total: a residual is added to the stated ones, a harmonic that was not tried and a direction that was
    /// not travelled keep their own.
    fn total(&self, stated: Option<&Stated>) -> [Harmonics; 2] {
        let found = [self.harmonics.clone(), self.reverse.clone()];
        let Some(stated) = stated else { return found };
        let either = |forward: &Harmonics, reverse: &Harmonics| {
            if reverse.is_empty() { forward.clone() } else { reverse.clone() }
        };
        let sum = |own: &Harmonics, stated: &Harmonics| joined(own, stated, |own, stated| own + stated);
        // Without harmonics, negative travel would have those of positive travel.
        let some = |own: Harmonics| if own.is_empty() { vec![[0.0; 2]] } else { own };
        let [forward, reverse] = [&stated.harmonics, &either(&stated.harmonics, &stated.reverse)];
        let staying = [forward, reverse].map(|own| self.staying(own));
        let same = stated.reverse.is_empty() || !self.on_top && staying[0] == staying[1];
        match self.one_way {
            Some(true) if !stated.reverse.is_empty() => [forward.clone(), some(sum(&found[0], &staying[1]))],
            Some(false) if !stated.reverse.is_empty() => [sum(&found[0], &staying[0]), reverse.clone()],
            _ if self.reverse.is_empty() && same => [sum(&found[0], &staying[0]), Vec::new()],
            _ => [sum(&found[0], &staying[0]), some(sum(&either(&found[0], &found[1]), &staying[1]))],
        }
    }

    /// The weight of the found coefficients in the written ones, `None` to write nothing, and why.
    fn weighed(&self, stated: Option<&Stated>, independent: bool) -> (Option<f64>, Why) {
        let Some(stated) = stated else {
            return if self.harmonics.is_empty() { (None, Why::Nothing) } else { (Some(1.0), Why::New) };
        };
        let Some(before) = stated.uncertainty else { return (Some(1.0), Why::BetterKnown) };
        let [forward, reverse] = self.total(Some(stated));
        let combined = self.uncertainty.hypot(before).max(f64::MIN_POSITIVE);
        let sides = [(&forward, &stated.harmonics), (&reverse, &stated.reverse)];
        let away = sides.into_iter().flat_map(|(a, b)| joined(a, b, |a, b| (a - b).abs() / combined));
        let away = away.flatten().fold(0.0, f64::max);
        if away > AGREE || reverse.is_empty() != stated.reverse.is_empty() {
            return (Some(1.0), Why::Differs(away));
        }
        if !independent {
            return (None, Why::SameRecord);
        }
        let own = self.uncertainty.max(f64::MIN_POSITIVE);
        (Some(1.0 / (1.0 + (own / before.max(f64::MIN_POSITIVE)).powi(2))), Why::Combined)
    }

    /// Coefficients that a weight of the found ones gives, rounded to a tenth of their uncertainty, and that uncertainty.
    fn written(&self, stated: Option<&Stated>, share: f64) -> ([Harmonics; 2], f64) {
        let [forward, reverse] = self.total(stated);
        let none = Stated { harmonics: Vec::new(), reverse: Vec::new(), uncertainty: None };
        let stated = stated.unwrap_or(&none);
        let before = stated.uncertainty.unwrap_or_default();
        let uncertainty = (share * self.uncertainty).hypot((1.0 - share) * before);
        let round = |value: f64| self.known(value, uncertainty).rounded().value;
        let mean = |found: f64, stated: f64| round(stated + share * (found - stated));
        let both = [joined(&forward, &stated.harmonics, mean), joined(&reverse, &stated.reverse, mean)];
        let [forward, reverse] =
            if share < 1.0 { both } else { [forward, reverse].map(|own| joined(&own, &[], |own, _| round(own))) };
        ([forward, reverse], self.known(0.0, uncertainty).rounded().uncertainty.unwrap_or_default())
    }

    fn known(&self, value: f64, uncertainty: f64) -> Known {
        Known::new(value, uncertainty, self.degrees_of_freedom)
    }

    /// The decision on the period; `not`: a reason for which nothing is written.
    pub(crate) fn decided(&self, document: &DocumentMut, independent: bool, not: Option<Why>) -> Decision {
        let stated = self.stated(document);
        let [forward, _] = self.total(stated.as_ref());
        let (share, why) = match not {
            Some(why) => (None, why),
            None => self.weighed(stated.as_ref(), independent),
        };
        let written = share.map(|share| {
            let ([forward, _], uncertainty) = self.written(stated.as_ref(), share);
            self.known(size(&forward), uncertainty).rounded()
        });
        Decision {
            key: format!("axis.{}.periodic, {} {}", self.letter(), short(self.period), self.units()[0]),
            stated: stated.map(|own| Known {
                value: size(&own.harmonics),
                uncertainty: own.uncertainty,
                ..Known::default()
            }),
            found: self.known(size(&forward), self.uncertainty),
            written,
            why,
            share: share.unwrap_or(0.0),
        }
    }
}

fn number(item: &Item) -> Option<f64> {
    let value = item.as_value()?;
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}

fn pairs(item: &Item) -> Harmonics {
    let value = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64));
    let pair = |own: &Value| {
        let own = own.as_array()?;
        Some([value(own.get(0)?)?, value(own.get(1)?)?])
    };
    item.as_array().map(|list| list.iter().filter_map(pair).collect()).unwrap_or_default()
}

fn list(harmonics: &[[f64; 2]]) -> Value {
    let pairs = harmonics.iter().map(|pair| Value::Array(pair.iter().copied().collect::<Array>()));
    Value::Array(pairs.collect::<Array>())
}

/// Writes a period whose decision says so, and returns a note.
///
/// # Errors
/// A table of the axis with points so close that it contains a part of the period; sections that are not a list of sections.
pub(crate) fn write(
    period: &FoundPeriod,
    decision: &Decision,
    independent: bool,
    machine: &Machine,
    (document, origin): (&mut DocumentMut, &Origin),
) -> Result<Option<String>, FileError> {
    if decision.written.is_none() {
        return Ok(None);
    }
    let axis = period.axis;
    let [unit, micro] = period.units();
    refuse_fine(period, axis, machine, origin)?;
    let stated = period.stated(document);
    let share = match (&decision.why, period.weighed(stated.as_ref(), independent)) {
        (Why::Forced(_), _) => 1.0,
        (_, (share, _)) => share.unwrap_or(1.0),
    };
    let ([forward, reverse], uncertainty) = period.written(stated.as_ref(), share);
    let place = period.place(document);
    let section = section(document, axis, origin)?;
    let sections = section.entry("periodic").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    let needed = format!("sections [[axis.{}.periodic]]", axis.letter());
    let sections = sections
        .as_array_of_tables_mut()
        .ok_or_else(|| origin.whole("a periodic that is not a list of sections", needed))?;
    let place = place.unwrap_or_else(|| {
        sections.push(toml_edit::Table::new());
        sections.len() - 1
    });
    let Some(table) = sections.get_mut(place) else { return Ok(None) };
    set(table, &format!("period_{unit}"), Value::from(period.period));
    set(table, &format!("harmonics_{micro}"), list(if forward.is_empty() { &[[0.0; 2]] } else { &forward }));
    if reverse.is_empty() {
        TableLike::remove(table, &format!("reverse_{micro}"));
    } else {
        set(table, &format!("reverse_{micro}"), list(&reverse));
    }
    set(table, &format!("standard_uncertainty_{micro}"), Value::from(uncertainty));
    let how = if stated.is_some() { "replaced" } else { "added" };
    Ok(Some(format!("axis {}: period of {} {unit} {how}", axis.letter(), short(period.period))))
}

/// Numbers of the harmonics that are not zero in one of the directions.
fn numbers<'h>(forward: &'h [[f64; 2]], reverse: &'h [[f64; 2]]) -> impl Iterator<Item = usize> + 'h {
    let all = joined(forward, reverse, |one, other| one.hypot(other));
    (1..).zip(all).filter(|(_, own)| *own != [0.0; 2]).map(|(number, _)| number)
}

/// Refuses periods of which a section of the machine states a part, that another section would add once more: `decided` are
/// all periods of the run with whether each is written.
///
/// # Errors
/// A stated period that the record cannot tell from one that is written, or a stated harmonic that it cannot tell from a
/// found one of another period.
pub(crate) fn refuse_double(
    decided: &[(&FoundPeriod, bool)],
    machine: &Machine,
    (document, origin): (&DocumentMut, &Origin),
) -> Result<(), FileError> {
    for (own, _) in decided.iter().filter(|(_, is_written)| *is_written) {
        let (unit, letter) = (own.units()[0], own.letter());
        let travel = machine.settings.axis(own.axis).map_or(0.0, |axis| axis.travel[1] - axis.travel[0]);
        let sections = own.sections(document).into_iter().flatten().enumerate();
        for (place, (period, stated)) in
            sections.filter_map(|(place, of)| Some((place, (own.period_of(of)?, own.stated_in(of)))))
        {
            if own.waves_apart(period, own.length) < 1.0 {
                if own.waves_apart(period, own.length.max(travel)) > SAME {
                    let found = format!("a period of {} {unit}", short(own.period));
                    let needed = format!(
                        "{} {unit}, which [[axis.{letter}.periodic]] states and {} {unit} of record do not tell from it",
                        short(period),
                        short(own.length)
                    );
                    return Err(origin.whole(found, needed));
                }
                continue;
            }
            let of_run = decided.iter().map(|(own, _)| own).find(|other| other.place(document) == Some(place));
            let is_stale = |number: &usize| of_run.is_none_or(|other| !other.tried.contains(number));
            let alike = |number: &usize| {
                let apart = |found: usize| (found as f64 / own.period - *number as f64 / period).abs() * own.length;
                numbers(&own.harmonics, &own.reverse).find(|found| apart(*found) < 1.0)
            };
            // A residual is beside what corrected the record.
            let mut stated = numbers(&stated.harmonics, &stated.reverse).filter(|_| !own.on_top).filter(is_stale);
            let Some((number, found)) = stated.find_map(|number| Some((number, alike(&number)?))) else { continue };
            let found = format!(
                "harmonic {number} of {} {unit} in [[axis.{letter}.periodic]], which the record does not tell from harmonic {found} \
                 of {} {unit}",
                short(period),
                short(own.period)
            );
            let needed = match of_run {
                Some(_) => "zero for it: both would correct the same error".into(),
                None => format!("both evaluated together: give --period-{unit} {} too", short(period)),
            };
            return Err(origin.whole(found, needed));
        }
    }
    Ok(())
}

/// Distance of the closest two points of an axis' own table, mm (deg), if it is so short that the table contains a part of an
/// error of this period.
pub(crate) fn contained_in(machine: &Machine, axis: Axis, period: f64) -> Option<f64> {
    let rows = machine.rows(axis)?;
    let own =
        |k: usize| rows.get(k).and_then(|row| Some((row.forward.get(axis.index())?, row.reverse.get(axis.index())?)));
    let is_flat = (1..rows.len()).all(|k| own(k) == own(0));
    let step = rows.windows(2).map(|pair| pair[1].position - pair[0].position).fold(f64::INFINITY, f64::min);
    (!is_flat && step < 0.5 * period).then_some(step)
}

/// Refuses a table that contains a part of the period: both would be added.
fn refuse_fine(period: &FoundPeriod, axis: Axis, machine: &Machine, origin: &Origin) -> Result<(), FileError> {
    let Some(step) = contained_in(machine, axis, period.period).filter(|_| !period.on_top) else { return Ok(()) };
    let unit = period.units()[0];
    let found = format!("a table of axis {} with points {} {unit} apart", axis.letter(), short(step));
    let needed = format!(
        "{} {unit} at least, half of the period of {} {unit}: this one contains a part of the period, which would be added twice",
        short(0.5 * period.period),
        short(period.period)
    );
    Err(origin.whole(found, needed))
}
