//! Errors that a calibration adds to those in a machine's files.

use crate::correlated;
use crate::document::{Edited, editable, section, set};
use crate::edit::table_name;
use crate::error::FileError;
use crate::exact::table::ErrorTable;
use crate::files::Source;
use crate::finding::{self, Decision, Finding, Fit, Why};
use crate::formats::write_axis_csv_known;
use crate::limits::widened;
use crate::origin::Origin;
use crate::periods::{self, FoundPeriod};
use crate::read::{Current, path_from};
use crate::text::micro;
use crate::uncertainty::{Correlation, Uncertainties};
use crate::{Machine, Table};
use std::path::Path;
use toml_edit::{DocumentMut, Item, TableLike, Value};
use trueaxis::machine::{Axis, Row, Twist};

/// Closest two positions of a table, mm or degrees.
const CLOSEST: f64 = 1e-3;

/// Degrees of freedom of a well-known value: the most that the file accepts.
const WELL_KNOWN: f64 = 1e9;

/// Positions of an axis, and the six errors EX to EC at each.
type Points = Vec<(f64, Twist)>;

/// Errors found in addition to those that the machine's files state: actual − ideal, mm and rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Additions {
    /// For each axis: positions and the six errors EX to EC at them; linear in between, constant beyond the ends.
    pub curves: Vec<(Axis, Points)>,
    /// Findings of a test; [`finding::decide`] decides which are written.
    pub findings: Vec<Finding>,
    /// Coefficients of correlation between findings, by their keys; of those that are written they replace the stated ones.
    pub correlations: Vec<Correlation>,
    /// Periods of axes; [`FoundPeriod`] says how each is decided.
    pub periods: Vec<FoundPeriod>,
    /// Residual of the test's fit; with a misfit no finding is written.
    pub fit: Option<Fit>,
    /// Number of the record that the findings are based on ([`Additions::of_record`]); `None`: the record has no number.
    pub record: Option<String>,
    /// Whether the machine's tables corrected it during the recording. A record that the machine already includes is then not
    /// added a second time.
    pub compensated: bool,
    /// Whether to write the findings regardless of the rule, which is reported. Still refused: results that the controller
    /// would refuse, and additions that the machine already includes.
    pub force: bool,
}

impl Additions {
    /// Sets the record to the one with these bytes. Periods of each axis have their own number: a ballbar's record also gives
    /// squareness and the periods of a second axis.
    #[must_use]
    pub fn of_record(self, bytes: &[u8]) -> Additions {
        let of = self.periods.first().map(|own| format!("periodic {}", own.axis.letter())).unwrap_or_default();
        Additions { record: Some(finding::record_number(&[bytes, of.as_bytes()].concat())), ..self }
    }

    /// Decides on every finding for a machine; `name` is that of its `machine.toml`. Nothing is written.
    ///
    /// # Errors
    /// A machine that cannot be read.
    pub fn decide(&self, machine: &dyn Source, name: &Path) -> Result<Vec<Decision>, FileError> {
        let before = Machine::read_from(machine, name, &mut |_| {})?;
        let known = Uncertainties::read_from(machine, name)?;
        let document = editable(&Current::read(machine, name)?.text, &Origin::new(&machine.path(name)))?;
        Ok(self.decided(&before, &known, &document))
    }

    fn decided(&self, before: &Machine, known: &Uncertainties, document: &DocumentMut) -> Vec<Decision> {
        let misfit = self.fit.and_then(|fit| fit.misfit(known.reading()));
        let again = self.is_again(known);
        let below = |key: &str, written: &finding::Known| {
            let axis = finding::axis_of(key).and_then(|axis| before.settings.axis(axis));
            let hysteresis = axis.map_or(0.0, |own| micro(own.axis, own.hysteresis));
            key.contains(".backlash_") && -written.value > hysteresis
        };
        let decision = |finding: &Finding| {
            let stated = finding::stated(document.as_table(), finding);
            // A residual is added to the figure; a whole lost motion includes that of the axis' table.
            let known_already = match finding.on_top {
                true => stated.map_or(0.0, |stated| stated.value),
                false => -lost_motion_of_table(before, &finding.key),
            };
            let found = finding::Known { value: known_already + finding.found.value, ..finding.found };
            let (written, why) = match &misfit {
                Some(left) => (None, Why::Misfit(left.clone())),
                None if again && self.compensated => (None, Why::SameRecord),
                None if finding.moved => (Some(found.rounded()), Why::Moved),
                None => finding::decide(stated, found, !again),
            };
            let (written, why) = match written {
                Some(value) if below(&finding.key, &value) => (None, Why::OverCompensated),
                written => (written, why),
            };
            Decision::new(finding.key.clone(), stated, found, (written, why))
        };
        let mut decisions: Vec<Decision> = self.findings.iter().map(decision).collect();
        finding::together(&self.findings, &mut decisions);
        let why = |on_top: bool| match &misfit {
            Some(left) => Some(Why::Misfit(left.clone())),
            None => (again && (self.compensated || on_top)).then_some(Why::SameRecord),
        };
        decisions.extend(self.periods.iter().map(|own| own.decided(document, !again, why(own.on_top))));
        // A period that neither the record nor the machine has is no value.
        let is_value = |own: &&mut Decision| own.why != Why::Nothing || own.found.value != 0.0;
        for own in decisions.iter_mut().filter(|_| self.force && !(again && self.compensated)).filter(is_value) {
            if below(&own.key, &own.found) {
                (own.written, own.why) = (None, Why::OverCompensated);
            } else {
                own.force();
            }
        }
        decisions
    }

    /// Whether the machine includes the record already.
    fn is_again(&self, known: &Uncertainties) -> bool {
        self.record.as_ref().is_some_and(|record| known.records.contains(record))
    }

    /// The changes that add the errors to a machine; `name` is that of its `machine.toml`. Comments, order and all other
    /// settings stay. The result is checked as [`Machine::read`] does. Nothing is written.
    ///
    /// # Errors
    /// A machine that cannot be read, a table that cannot be written under its name, or a result that the controller would
    /// refuse.
    pub fn edit(&self, machine: &dyn Source, name: &Path) -> Result<Edited, FileError> {
        let before = Machine::read_from(machine, name, &mut |_| {})?;
        let current = Current::read(machine, name)?;
        let known = Uncertainties::read_from(machine, name)?;
        let origin = Origin::new(&machine.path(name));
        let mut document = editable(&current.text, &origin)?;
        let mut edited = Edited { files: Vec::new(), notes: Vec::new() };
        let decisions = self.decided(&before, &known, &document);
        let of_periods = self.periods.iter().zip(&decisions[self.findings.len()..]);
        let with: Vec<_> = of_periods.clone().map(|(own, decision)| (own, decision.written.is_some())).collect();
        periods::refuse_double(&with, &before, (&document, &origin))?;
        for (period, decision) in of_periods {
            edited.notes.extend(periods::write(
                period,
                decision,
                !self.is_again(&known),
                &before,
                (&mut document, &origin),
            )?);
        }
        for (axis, curve) in self.curves.iter().chain(&taken_curves(&self.findings, &decisions)) {
            let table = summed(&before, *axis, curve);
            let csv = table_name(*axis, &current, &origin)?;
            let new = before.rows(*axis).is_none();
            let section = section(&mut document, *axis, &origin)?;
            set(section, "table", Value::from(csv.as_str()));
            if new && !section.contains_key("interpolation") {
                set(section, "interpolation", Value::from("cubic"));
            }
            let how = if new { "table added" } else { "errors added to the table" };
            edited.notes.push(format!("axis {}: {how}, {} lines", axis.letter(), table.rows.len()));
            let uncertainty = kept(&known, &before, *axis, &table);
            edited.files.push((path_from(name, &csv), write_axis_csv_known(&table, *axis, &uncertainty)));
        }
        write(&self.findings, &decisions, self.record.as_deref(), &mut document, &origin)?;
        correlated::write(&known, &decisions, &self.correlations, &mut document, &origin)?;
        let Edited { files, notes } = &mut edited;
        let text =
            widened(&document, &current.text, files, (machine, name), Some(&before), notes).map_err(|error| {
                let needed = format!("{} (in the machine with the found values; nothing is written)", error.needed);
                FileError { needed, ..error }
            })?;
        if text != current.text {
            edited.files.push((name.into(), text));
        }
        Ok(edited)
    }
}

/// Mean lost motion of the axis' table, negative less positive travel, in the unit of the key; zero for any other key.
fn lost_motion_of_table(machine: &Machine, key: &str) -> f64 {
    let axis = finding::axis_of(key).filter(|_| key.contains(".backlash_"));
    let Some((axis, rows)) = axis.and_then(|axis| Some((axis, machine.rows(axis)?))) else { return 0.0 };
    let lost = rows.iter().map(|row| row.reverse[axis.index()] - row.forward[axis.index()]);
    let micro = if axis.is_rotary() { 1e6 } else { 1e3 };
    micro * lost.sum::<f64>() / rows.len().max(1) as f64
}

/// Curves of the findings that are written, each scaled by the share written, one per axis.
fn taken_curves(findings: &[Finding], decisions: &[Decision]) -> Vec<(Axis, Points)> {
    let mut curves: Vec<(Axis, Points)> = Vec::new();
    for (finding, decision) in findings.iter().zip(decisions).filter(|(finding, _)| !finding.curve.is_empty()) {
        let (Some(axis), Some(written)) = (finding::axis_of(&finding.key), decision.written) else { continue };
        if written.value == 0.0 || finding.found.value == 0.0 {
            continue;
        }
        let whole = written.value == finding.found.rounded().value;
        let share = if whole { 1.0 } else { written.value / finding.found.value };
        let taken = finding.curve.iter().map(|(position, errors)| (*position, errors.map(|error| share * error)));
        match curves.iter_mut().find(|(own, _)| *own == axis) {
            None => curves.push((axis, taken.collect())),
            Some((_, sum)) => {
                let mut all: Points = taken.collect();
                for (position, errors) in &mut all {
                    let own = at(sum, *position);
                    errors.iter_mut().zip(own).for_each(|(error, own)| *error += own);
                }
                let far = |position: f64| all.iter().all(|(other, _)| (other - position).abs() >= CLOSEST);
                let more: Points = sum.iter().filter(|(position, _)| far(*position)).copied().collect();
                let more = more.into_iter().map(|(position, own)| {
                    let new = at(&finding.curve, position);
                    (position, std::array::from_fn(|k| own[k] + share * new[k]))
                });
                all.extend(more.collect::<Vec<_>>());
                all.sort_by(|a, b| a.0.total_cmp(&b.0));
                *sum = all;
            }
        }
    }
    curves
}

/// Writes the decided values, with their standard uncertainties, degrees of freedom and the record.
fn write(
    findings: &[Finding],
    decisions: &[Decision],
    record: Option<&str>,
    document: &mut DocumentMut,
    origin: &Origin,
) -> Result<(), FileError> {
    let put = |document: &mut DocumentMut, key: &str, value: Option<Value>| -> Result<(), FileError> {
        let (path, last) = key.rsplit_once('.').unwrap_or(("", key));
        let mut to: &mut dyn TableLike = document.as_table_mut();
        for part in path.split('.').filter(|part| !part.is_empty()) {
            to = table_at(to, part, origin)?;
        }
        match value {
            Some(value) => set(to, last, value),
            None => drop(to.remove(last)),
        }
        Ok(())
    };
    let any = decisions.iter().any(|decision| decision.written.is_some());
    for (finding, decision) in findings.iter().zip(decisions) {
        let Some(written) = decision.written else { continue };
        if finding.curve.is_empty() {
            put(document, &finding.key, Some(Value::from(written.value)))?;
        }
        let [uncertainty, degrees] = finding::uncertainty_keys(&finding.key);
        put(document, &uncertainty, written.uncertainty.map(Value::from))?;
        // Without a separate entry, the value would get the section's degrees of freedom.
        let section = degrees.rsplit_once('.').map_or("", |(section, _)| section);
        let of_others = finding::number(document.as_table(), &format!("{section}.degrees_of_freedom"));
        let of = written.degrees_of_freedom.or(of_others.map(|_| WELL_KNOWN));
        put(document, &degrees, of.map(|of| Value::from(of.min(WELL_KNOWN) as i64)))?;
    }
    let Some(record) = record.filter(|_| any) else { return Ok(()) };
    let section = table_at(document.as_table_mut(), "uncertainty", origin)?;
    let list = section.entry("records").or_insert_with(|| Item::Value(toml_edit::Array::new().into()));
    let list = list.as_array_mut().ok_or_else(|| origin.whole("records that are not a list", "a list of records"))?;
    if list.iter().all(|own| own.as_str() != Some(record)) {
        list.push(record);
    }
    Ok(())
}

/// A section of a table, created if absent; one that only contains sections gets no header.
fn table_at<'d>(table: &'d mut dyn TableLike, name: &str, origin: &Origin) -> Result<&'d mut dyn TableLike, FileError> {
    let new = || {
        let mut new = toml_edit::Table::new();
        new.set_implicit(true);
        Item::Table(new)
    };
    let refused = || origin.whole(format!("a {name} that is not a section"), format!("a section [{name}]"));
    table.entry(name).or_insert_with(new).as_table_like_mut().ok_or_else(refused)
}

/// Standard uncertainties of the points in the axis' CSV, at the points of its new table: linear between the old points,
/// constant beyond the ends.
fn kept(known: &Uncertainties, before: &Machine, axis: Axis, table: &Table) -> [Option<Vec<f64>>; 6] {
    let (Some(own), Some(rows)) = (known.of(axis), before.rows(axis)) else { return Default::default() };
    std::array::from_fn(|component| {
        let points = own.points.get(component)?.as_ref()?;
        let stated: Points =
            rows.iter().zip(points).map(|(row, value)| (row.position, [*value, 0.0, 0.0, 0.0, 0.0, 0.0])).collect();
        Some(table.rows.iter().map(|row| at(&stated, row.position)[0]).collect())
    })
}

impl Machine {
    /// The six errors EX to EC, mm and rad, that the files state for an axis at a position: its table averaged over both
    /// directions of travel, the edge value outside it, and location errors of a rotary axis.
    pub fn stated_errors(&self, axis: Axis, position: f64) -> Twist {
        let found = self.axes().find(|(own, _)| own.axis == axis);
        let table = found.and_then(|(own, table)| Some(ErrorTable::new(own, &table?.rows).at(position, 0.5)));
        let mut rotary = self.settings.location.rotary.iter().zip([Axis::A, Axis::B, Axis::C]);
        let constant = rotary.find(|(_, of)| *of == axis).map_or([0.0; 6], |(errors, _)| *errors);
        let table = table.unwrap_or_default();
        std::array::from_fn(|k| table[k] + constant[k])
    }
}

/// The axis' table plus the curve, at the positions of both.
fn summed(machine: &Machine, axis: Axis, curve: &[(f64, Twist)]) -> Table {
    let found = machine.axes().find(|(own, _)| own.axis == axis);
    let old = found.and_then(|(own, table)| Some((ErrorTable::new(own, &table?.rows), table?)));
    let own = old.iter().flat_map(|(_, table)| table.rows.iter().map(|row| row.position));
    let mut positions: Vec<f64> = own.clone().collect();
    let far = |position: &f64| own.clone().all(|other| (other - position).abs() >= CLOSEST);
    positions.extend(curve.iter().map(|(position, _)| *position).filter(far));
    positions.sort_by(f64::total_cmp);
    let mut given: [bool; 6] = old.as_ref().map_or([false; 6], |(_, table)| table.given);
    for (k, given) in given.iter_mut().enumerate() {
        *given |= curve.iter().any(|(_, error)| error[k] != 0.0);
    }
    let rows: Vec<Row> = positions
        .into_iter()
        .map(|position| {
            let by = at(curve, position);
            let [forward, reverse] = [0.0, 1.0].map(|reverse| {
                let mut errors = old.as_ref().map_or([0.0; 6], |(table, _)| table.at(position, reverse));
                // To a hundredth of a nanometre or nanoradian.
                (0..6).for_each(|k| {
                    let scale = if k < 3 { 1e8 } else { 1e11 };
                    errors[k] = ((errors[k] + by[k]) * scale).round() / scale;
                });
                errors
            });
            Row { position, forward, reverse }
        })
        .collect();
    let bidirectional = rows.iter().any(|row| row.forward != row.reverse);
    Table { given, bidirectional, rows }
}

fn at(curve: &[(f64, Twist)], position: f64) -> Twist {
    let right = curve.partition_point(|(q, _)| *q <= position);
    match (right.checked_sub(1).and_then(|left| curve.get(left)), curve.get(right)) {
        (Some((from, a)), Some((to, b))) => {
            let share = (position - from) / (to - from);
            std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
        }
        (Some((_, edge)), None) | (None, Some((_, edge))) => *edge,
        (None, None) => [0.0; 6],
    }
}
