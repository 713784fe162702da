//! Tables and plots of errors that repeat.

use super::{PeriodicDocument, Test};
use crate::shown::{Cell, Curve, EXPANDED, Look, Plot, Shown, Table, Uncertainty, unit};
use trueaxis_metrology::periodic::{Period, spectrum};
use trueaxis_report::number::significant;

/// Most points of a plot of points: a page draws no more.
const POINTS: usize = 200;
/// Indices of the curves' colours.
const MEASURED: usize = 8;
const FIT: usize = 6;
const LEFT: usize = 5;

impl PeriodicDocument {
    /// The harmonics, what is left, and with the test the error folded to each period, the residual and the spectrum.
    pub fn shown(&self, test: &Test) -> Shown {
        let figures = [
            ("readings", Cell::count(self.readings)),
            ("bends of the slow error", Cell::count(self.bends)),
            ("RMS without harmonics", Cell::number(self.before, 3)),
            ("RMS left", Cell::number(self.left, 3)),
            ("explained, %", Cell::number(100.0 * self.explained, 4)),
            ("degrees of freedom", Cell::count(self.degrees_of_freedom)),
            ("uncertainty widened by", Cell::number(self.widened, 3)),
        ];
        let micro = unit(self.error_unit);
        Shown {
            title: format!("Errors of axis {} that repeat", self.axis),
            summary: vec![
                format!("{} readings over {} {}", self.readings, significant(self.length, 4), self.unit),
                format!("every {} {}", significant(self.spacing, 3), self.unit),
            ],
            result: self.verdict.clone(),
            notes: self.warnings.clone(),
            tables: vec![self.harmonics(micro), Table::figures(&format!("Fit, {micro}"), figures)],
            plots: test.plots(micro),
            ..Shown::default()
        }
    }

    fn harmonics(&self, micro: &str) -> Table {
        let rows = self.periods.iter().flat_map(|own| {
            own.tried.iter().filter(|tried| tried.kept).map(|tried| {
                let known = Uncertainty::expanded(tried.expanded_uncertainty);
                vec![
                    format!("{} {}", own.period, self.unit).into(),
                    Cell::count(tried.harmonic),
                    tried.direction.into(),
                    known.value(tried.amplitude),
                    Cell::fixed(tried.phase_deg, 1),
                    known.value(tried.cosine),
                    known.value(tried.sine),
                    known.cell(),
                ]
            })
        });
        let header = ["period", "harmonic", "travel", "amplitude", "phase, °", "cosine", "sine", EXPANDED];
        Table::new(format!("Harmonics that are kept, {micro}"), header, rows)
    }
}

/// Indices of at most [`POINTS`] of so many values, evenly.
fn some(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(POINTS).max(1))
}

impl Test {
    fn plots(&self, micro: &'static str) -> Vec<Plot> {
        let periods = self.found.periods.iter().filter(|own| own.highest() > 0);
        let folded = periods.flat_map(|own| {
            let sides: &[Option<bool>] = if own.reverse.is_some() { &[Some(false), Some(true)] } else { &[None] };
            sides.iter().map(|side| self.folded(own, *side, micro)).collect::<Vec<_>>()
        });
        let mut plots: Vec<Plot> = folded.collect();
        plots.push(self.along(micro));
        plots.push(self.spectrum(micro));
        plots
    }

    /// Readings less slow error and other periods over the position within a period, one direction or both.
    fn folded(&self, own: &Period, side: Option<bool>, micro: &'static str) -> Plot {
        let all = self.readings.iter().zip(&self.found.residual);
        let all: Vec<_> = all.filter(|(reading, _)| side.is_none_or(|side| side == reading.own.is_negative)).collect();
        let kept: Vec<_> = some(all.len()).map(|k| all[k]).collect();
        let at: Vec<f64> = kept.iter().map(|(reading, _)| reading.own.position.rem_euclid(own.period)).collect();
        let (at, order) = Plot::ascending(&at);
        let fit = |k: &usize| own.error(kept[*k].0.own.position, kept[*k].0.own.is_negative);
        // On a circle a reading contains only a share of the error.
        let left = |k: &usize| *kept[*k].1 / kept[*k].0.own.share.abs().max(0.1);
        let curve =
            |name: &str, colour, of: &dyn Fn(&usize) -> f64| Curve::new(name, colour, order.iter().map(of).collect());
        let unit = self.options.unit();
        let travel = side.map_or("", |is_negative| if is_negative { ", negative travel" } else { ", positive travel" });
        Plot {
            section: "Error within a period",
            title: format!("Period of {} {unit}{travel}", own.period),
            x: (format!("position within {} {unit}{travel}", own.period), unit),
            y: ("error", micro),
            look: Look::Points,
            caption: "Readings less the slow error and other periods, the harmonics fitted, and what is left.",
            at,
            curves: vec![
                curve("readings", MEASURED, &|k| fit(k) + left(k)),
                curve("left", LEFT, &left),
                curve("fit", FIT, &fit),
            ],
            ..Plot::default()
        }
    }

    /// The residual along the axis.
    fn along(&self, micro: &'static str) -> Plot {
        let positions: Vec<f64> = self.readings.iter().map(|own| own.own.position).collect();
        let (at, order) = Plot::ascending(&positions);
        let of = |is_negative: bool| -> Vec<f64> {
            let value = |k: usize| {
                if self.readings[k].own.is_negative == is_negative { self.found.residual[k] } else { f64::NAN }
            };
            order.iter().map(|k| value(*k)).collect()
        };
        let sides = [(false, "positive travel", 0), (true, "negative travel", 1)];
        let there = sides.iter().filter(|(side, ..)| self.readings.iter().any(|own| own.own.is_negative == *side));
        Plot {
            section: "What is left",
            title: "Residual along the axis".into(),
            x: ("position".into(), self.options.unit()),
            y: ("residual", micro),
            caption: "Readings less slow error and harmonics.",
            at,
            curves: there.map(|(side, name, colour)| Curve::new(*name, *colour, of(*side))).collect(),
            ..Plot::default()
        }
    }

    fn spectrum(&self, micro: &'static str) -> Plot {
        let found = &self.found;
        let positions: Vec<f64> = self.readings.iter().map(|own| own.own.position).collect();
        let before: Vec<f64> = self.readings.iter().zip(&found.slow).map(|(own, slow)| own.error - slow).collect();
        let [before, after] =
            [&before, &found.residual].map(|values| spectrum(&positions, values, found.length, found.spacing));
        Plot {
            section: "Spectrum",
            title: "Amplitude over waves per length".into(),
            x: (format!("waves per {}", self.options.unit()), ""),
            y: ("amplitude", micro),
            caption: "A peak that the fit leaves is a period that was not stated: its inverse is the period.",
            at: before.frequency,
            curves: vec![Curve::new("before", MEASURED, before.amplitude), Curve::new("left", LEFT, after.amplitude)],
            ..Plot::default()
        }
    }
}
