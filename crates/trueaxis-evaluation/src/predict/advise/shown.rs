//! Tables and sentences of the advice.

use super::document::{Advice, Advised, Elsewhere};
use crate::shown::{Cell, Table};
use trueaxis_report::number::{decimals, shortest};

impl Advice {
    /// The measurements, and every feature before and after them.
    pub(in super::super) fn tables(&self) -> Vec<Table> {
        let number = |k: usize| Cell::from((k + 1).to_string());
        let rows = self.measurements.iter().enumerate().map(|(k, of)| {
            let how = if of.in_task { "calibrate plan" } else { "" };
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
        notes.extend(self.elsewhere.iter().flat_map(Elsewhere::notes));
        notes.extend(self.corrected.iter().map(|of| format!("with the correction on, {of}")));
        notes.extend(self.left_out.iter().map(|why| format!("not compared, {why}")));
        notes
    }

    /// What the measurements bring.
    pub(in super::super) fn sentence(&self) -> String {
        let undecided =
            |verdict: fn(&Advised) -> &str| self.features.iter().filter(|of| verdict(of) == "undecided").count();
        let [before, after] = [undecided(|of| of.verdict_before), undecided(|of| of.verdict_after)];
        let minutes = decimals(self.minutes, 0);
        match (before, after, self.measurements.is_empty()) {
            (0, ..) => "Nothing has to be measured".into(),
            (_, _, true) => {
                format!("No set of the {} measurements brings one more feature to a verdict", self.compared.len())
            }
            (_, 0, _) => format!("{minutes} minutes of measuring bring every feature to a verdict"),
            _ => format!(
                "{minutes} minutes of measuring leave {after} of {before} features undecided, the fewest possible"
            ),
        }
    }
}

impl Elsewhere {
    fn notes(&self) -> Vec<String> {
        let percent = |share: f64| decimals(100.0 * share, 0);
        let place = self.place.as_ref().map_or_else(
            || String::from("no other place in X and Y is better by 5 % or more"),
            |of| {
                let [x, y, _] = of.at_mm.map(shortest);
                let [here, there] = [of.here, of.there].map(percent);
                let compared = of.compared;
                format!(
                    "better at X {x}, Y {y}: the largest deviation with its uncertainty is {there} % of its tolerance there, \
                     {here} % here ({compared} places compared)"
                )
            },
        );
        let directions = self.directions.iter().map(|of| {
            let (feature, kind, [here, there]) = (&of.feature, of.kind, [of.here, of.there].map(percent));
            format!(
                "{feature} cut the other way round: {kind} {there} % of its tolerance, as programmed {here} % (lost motion; \
                 the process is not included)"
            )
        });
        std::iter::once(place).chain(directions).collect()
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
