//! Tables and sentences of the advice.

use super::document::{Advice, Advised, Elsewhere};
use super::search::EXACT;
use crate::shown::{Cell, Table};
use std::fmt::Write as _;
use trueaxis_report::number::{decimals, shortest};

impl Advice {
    /// The measurements, and every feature before and after them.
    pub(in super::super) fn tables(&self) -> Vec<Table> {
        let number = |k: usize| Cell::from((k + 1).to_string());
        let rows = self.measurements.iter().enumerate().map(|(k, of)| {
            let how = match &of.file {
                Some(file) => format!("calibrate plan {file}"),
                None if of.in_task => "calibrate plan".into(),
                None => String::new(),
            };
            vec![number(k), of.name.as_str().into(), Cell::fixed(of.minutes, 0), how.into()]
        });
        let measure = Table::new("What to measure", ["", "measurement", "minutes", "by"], rows.collect::<Vec<_>>());
        let head = ["feature", "± before, µm", "± after, µm", "± with all, µm", "verdict before", "expected after"];
        let rows = self.features.iter().map(|of| {
            let um = [of.before_um, of.after_um, of.least_um].map(|um| Cell::fixed(um, 2));
            std::iter::once(Cell::from(of.title.as_str()))
                .chain(um)
                .chain([of.verdict_before.into(), of.verdict_after.into()])
                .collect()
        });
        let effect = Table::new("Before and after", head, rows.collect::<Vec<Vec<Cell>>>());
        (!self.measurements.is_empty()).then_some(measure).into_iter().chain([effect]).collect()
    }

    /// What the tables do not say.
    pub(in super::super) fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.features.iter().filter_map(Advised::still).collect();
        notes.extend(self.independent.iter().map(|of| {
            format!(
                "what is common to the uses of {of} along several axes, such as its wavelength, is taken as independent"
            )
        }));
        notes.extend(self.elsewhere.iter().flat_map(Elsewhere::notes));
        notes.extend(self.corrected.iter().cloned());
        notes.extend(self.left_out.iter().map(|why| format!("not compared, {why}")));
        notes
    }

    /// What the measurements bring.
    pub(in super::super) fn sentence(&self) -> String {
        let undecided =
            |verdict: fn(&Advised) -> &str| self.features.iter().filter(|of| verdict(of) == "undecided").count();
        let [before, after] = [undecided(|of| of.verdict_before), undecided(|of| of.verdict_after)];
        let minutes = match decimals(self.minutes, 0) {
            one if one == "1" => "1 minute of measuring".into(),
            several => format!("{several} minutes of measuring"),
        };
        let s = if decimals(self.minutes, 0) == "1" { "s" } else { "" };
        match (before, after, self.measurements.is_empty()) {
            (0, ..) => "Nothing has to be measured".into(),
            (_, _, true) => self.nothing_helps(),
            (_, 0, _) => format!("{minutes} bring{s} every characteristic to a verdict, {}", self.how_short()),
            _ => format!("{minutes} leave{s} {after} of {before} characteristics undecided, {}", self.how_short()),
        }
    }

    /// What the search proves about the set.
    fn how_short(&self) -> &'static str {
        match (self.exact, self.compared.len() + self.left_out.len() > EXACT) {
            (true, _) => "the shortest of all sets",
            (_, true) => "a short set found by adding measurements one at a time",
            _ => "the shortest of the sets that were drawn",
        }
    }

    fn nothing_helps(&self) -> String {
        let more = "one more characteristic to a verdict";
        match (self.compared.len(), self.exact) {
            (0, _) => "None of the measurements is possible".into(),
            (1, _) => format!("The one measurement does not bring {more}"),
            (count, true) => format!("No set of the {count} measurements brings {more}"),
            (count, _) => format!("No set of the {count} measurements that was tried brings {more}"),
        }
    }
}

impl Elsewhere {
    fn notes(&self) -> Vec<String> {
        let percent = |share: f64| decimals(100.0 * share, 0);
        let mut compared = format!("{} places compared before the measurements", self.places_compared);
        if self.places_refused > 0 {
            let _ = write!(compared, ", {} refused for travel", self.places_refused);
        }
        let place = self.place.as_ref().map_or_else(
            || format!("no other place in X and Y is better by 5 % or more ({compared})"),
            |of| {
                let [x, y, _] = of.at_mm.map(shortest);
                let [here, there] = [of.here, of.there].map(percent);
                let [now, then] = of.conform;
                format!(
                    "better at X {x}, Y {y}: characteristics that conform {then}, here {now}; the largest deviation with its \
                     uncertainty is {there} % of its tolerance there, {here} % here ({compared})"
                )
            },
        );
        let directions = self.directions.iter().map(|of| {
            let (feature, kind, [here, there]) = (&of.feature, of.kind, [of.here, of.there].map(percent));
            format!(
                "{feature} cut in the other direction: {kind} {there} % of its tolerance, as programmed {here} % (lost motion; \
                 the process is not included)"
            )
        });
        let servo = "places and directions are compared without the servo, which leaves about the same everywhere";
        std::iter::once(place).chain(directions).chain(self.without_servo.then(|| servo.into())).collect()
    }
}

impl Advised {
    /// Why a feature stays undecided.
    fn still(&self) -> Option<String> {
        let terms = self.left.iter().map(|of| {
            let seen = if of.is_measured { "" } else { ", not measured" };
            format!("{} ({} %{seen})", of.term, decimals(100.0 * of.share, 0))
        });
        let terms: Vec<String> = terms.collect();
        (!terms.is_empty()).then(|| format!("{} stays undecided by {}", self.title, terms.join(", ")))
    }
}
