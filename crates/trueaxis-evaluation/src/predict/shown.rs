//! Tables of a predicted part.

use super::advise::document::Advice;
use super::servo::ServoDocument;
use super::temperature::TemperatureDocument;
use super::{Known, PredictDocument, Predicted};
use crate::shown::{Cell, EXPANDED, Shown, Table};
use trueaxis_metrology::uncertainty::Interval;
use trueaxis_report::number::{decimals, shortest};

/// The interval itself: that of a zone is not centred on the predicted width, which uncertainties mostly widen.
const WITHIN: &str = "95 % of draws";

/// Keys named of those that are not stated.
const KEYS: usize = 12;
/// Contributions shown of each characteristic.
const LARGEST: usize = 3;

impl PredictDocument {
    /// Tables of the document: verdicts, and the largest contributions.
    pub fn shown(&self) -> Shown {
        let known: Vec<(&Predicted, &Known)> =
            self.features.iter().filter_map(|of| Some((of, of.known.as_ref()?))).collect();
        let count = |verdict: &str| known.iter().filter(|(_, known)| known.verdict == verdict).count();
        let mut notes = self.warnings.clone();
        let beyond = self.not_stated.len().saturating_sub(KEYS);
        let not_stated = self.not_stated.iter().take(KEYS).cloned().collect::<Vec<_>>().join(", ");
        let more = if beyond > 0 { format!(" and {beyond} more, listed by --json") } else { String::new() };
        let not_stated = format!("{not_stated}{more}");
        let result = if known.is_empty() {
            notes.push(format!("machine.toml states none of these keys: {not_stated}"));
            String::from("No verdict: the machine states no standard uncertainty.")
        } else {
            if !not_stated.is_empty() {
                notes.push(format!("not stated, taken as zero: {not_stated}"));
            }
            let verdicts = [
                ("conforms", ["conforms", "conform"]),
                ("does not conform", ["does not conform", "do not conform"]),
                ("undecided", ["is undecided", "are undecided"]),
            ];
            let counts = verdicts.map(|(verdict, words)| (count(verdict), words));
            let counts = counts.into_iter().filter(|(count, _)| *count > 0);
            let parts =
                counts.map(|(count, [one, several])| format!("{count} {}", if count == 1 { one } else { several }));
            let advice = self.advice.as_ref().map_or_else(String::new, |advice| format!(" {}.", advice.sentence()));
            format!("{}.{advice}", parts.collect::<Vec<_>>().join(", "))
        };
        notes.push(format!("{} and process are not included", self.not_included()));
        notes.extend(self.advice.iter().flat_map(Advice::notes));
        let [x, y, z] = self.at_mm.map(shortest);
        Shown {
            title: "Part before it is cut".into(),
            summary: [
                self.part.clone(),
                format!("program {}", self.program),
                format!("machine {}", self.machine),
                format!("program zero at X {x}, Y {y}, Z {z} mm"),
                format!("intervals of {} %", self.confidence_percent),
            ]
            .into_iter()
            .chain(self.servo.iter().map(ServoDocument::summary))
            .chain(self.temperature.iter().flat_map(TemperatureDocument::summary))
            .collect(),
            result,
            notes,
            tables: std::iter::once(self.verdicts())
                .chain((!known.is_empty()).then(|| budget(&known)))
                .chain(self.advice.iter().flat_map(Advice::tables))
                .collect(),
            ..Shown::default()
        }
    }

    /// What the prediction leaves out.
    fn not_included(&self) -> String {
        let temperature = self.temperature.as_ref();
        let is_grown = temperature.is_some_and(|of| !of.sensors.is_empty());
        let is_part = temperature.is_some_and(|of| of.part_c.is_some());
        let temperature = match [is_grown, is_part] {
            [true, true] => None,
            [false, false] => Some("temperature while cutting"),
            [true, false] => Some("temperature of the part"),
            [false, true] => Some("temperature of the machine"),
        };
        let servo = match &self.servo {
            None => Some("servo"),
            Some(of) if of.figures.is_empty() => Some("uncertainty of the drives"),
            Some(_) => None,
        };
        [servo, temperature, Some("bending")].into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    fn verdicts(&self) -> Table {
        let has_known = self.features.iter().any(|of| of.known.is_some());
        let has_servo = self.servo.is_some();
        let head = ["feature", "tolerance", "uncorrected", "corrected"].into_iter();
        let head = head
            .chain(has_servo.then_some("everything on"))
            .chain(if has_known { &[EXPANDED, WITHIN, "in tolerance, %", "verdict"][..] } else { &[] }.iter().copied());
        let rows = self.features.iter().map(|of| {
            let mut row: Vec<Cell> = vec![of.title().into(), of.limits().into()];
            let values = [of.uncorrected_um, of.corrected_um].into_iter().chain(of.everything_um);
            row.extend(values.map(|um| Cell::fixed(um, 2)));
            if let Some(known) = &of.known {
                let share = Cell::percent(known.conformance);
                let Interval { low, high } = known.interval_um;
                let within = [low, high].map(|um| decimals(um, 2)).join(" to ");
                row.extend([Cell::fixed(known.expanded_um, 2), within.into(), share, known.verdict.into()]);
            }
            row
        });
        Table::new("Features, µm", head, rows.collect::<Vec<_>>())
    }
}

impl Predicted {
    /// Feature, characteristic and datums.
    pub(super) fn title(&self) -> String {
        let minimum = if self.association == Some("minimum zone") { ", minimum zone" } else { "" };
        match (self.kind, self.datums.is_empty()) {
            (_, true) => format!("{}, {}{minimum}", self.feature, self.kind),
            ("distance", _) => format!("{}, distance from {}", self.feature, self.datums.join(", ")),
            _ => format!("{}, {} to {}", self.feature, self.kind, self.datums.join(", ")),
        }
    }

    /// The tolerance as written: a width, or two limits.
    fn limits(&self) -> String {
        match self.limits_um {
            [None, Some(width)] => shortest(width),
            limits => limits.map(|um| um.map_or_else(String::new, shortest)).join(" to "),
        }
    }
}

fn budget(known: &[(&Predicted, &Known)]) -> Table {
    let rows = known.iter().flat_map(|(of, known)| {
        known.budget.iter().take(LARGEST).map(|one| {
            let um = Cell::number(one.standard_um, 3);
            vec![of.title().into(), one.term.as_str().into(), Cell::percent(one.share), um]
        })
    });
    let head = ["feature", "term", "share, %", "standard uncertainty, µm"];
    Table::new("Largest contributions", head, rows.collect::<Vec<_>>()).bars(2)
}
