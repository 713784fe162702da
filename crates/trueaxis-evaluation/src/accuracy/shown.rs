//! Tables of the figures after ISO 230-2.

use super::{AccuracyDocument, of_table};
use crate::shown::{Cell, Quantity, Shown, Table, Uncertainty, unit};
use trueaxis_metrology::accuracy::Accuracy;
use trueaxis_metrology::uncertainty::{FIGURES, Verdict};
use trueaxis_report::number::shortest;
use trueaxis_tables::Machine;
use trueaxis_tables::text::counted;

/// Names of [`FIGURES`], in their order.
const NAMES: [&str; FIGURES.len()] = [
    "A, bidirectional accuracy",
    "A↑, positive approach",
    "A↓, negative approach",
    "E, bidirectional systematic error",
    "E↑, positive approach",
    "E↓, negative approach",
    "R, bidirectional repeatability",
    "R↑, positive approach",
    "R↓, negative approach",
    "M, range of the mean deviation",
    "B, reversal error",
    "B̄, mean reversal error",
];
/// Positions and runs that the standard asks for.
const FEW: usize = 5;

impl AccuracyDocument {
    /// The figures as measured, with their uncertainties if these are known, and after compensation; the verdict.
    pub fn shown(&self) -> Shown {
        let measured = &self.measured;
        let (positions, runs) = (measured.positions.len(), measured.runs);
        let unit = unit(measured.unit);
        let mut notes = Vec::new();
        if self.uncertainty.as_ref().is_some_and(|bands| bands.drowned) {
            notes.push(
                "the readings scatter no more than the instrument alone: the bands of A, R and B may be too narrow"
                    .into(),
            );
        }
        if positions < FEW {
            notes.push("ISO 230-2 asks for five target positions a metre, and five at least.".into());
        }
        if runs < FEW {
            notes.push("ISO 230-2 asks for five runs in each direction.".into());
        }
        let verdict = self.verdict.map(|judged| {
            let words = match judged.verdict {
                Verdict::Pass => "kept, uncertainty included: pass",
                Verdict::Fail => "exceeded, uncertainty included: fail",
                Verdict::Undecided => "within the uncertainty: no verdict",
            };
            vec![judged.figure.into(), Cell::shortest(judged.tolerance_um), words.into()]
        });
        Shown {
            title: format!("Accuracy of axis {}", measured.axis),
            summary: vec![
                counted(positions, "target position"),
                counted(runs, "run"),
                format!("ISO 230-2:2014, values in {unit}"),
            ],
            notes,
            tables: vec![
                self.figures(unit),
                Table::new("Verdict", ["figure", &format!("at most, {unit}"), "verdict"], verdict),
            ],
            ..Shown::default()
        }
    }

    fn figures(&self, unit: &'static str) -> Table {
        let mut header = vec!["figure".to_owned(), "measured".into()];
        if let Some(bands) = &self.uncertainty {
            header.extend([format!("± {} %", shortest(100.0 * bands.coverage)), "from".into(), "to".into()]);
        }
        header.extend(self.compensated.iter().map(|_| "corrected".to_owned()));
        let rows = FIGURES.iter().zip(NAMES).filter_map(|((symbol, of), name)| {
            let value = of(&self.measured)?;
            let mut row = vec![name.into()];
            if let Some(bands) = &self.uncertainty {
                let band = bands.of(symbol);
                let known = Uncertainty::expanded(band.map(|band| band.expanded));
                row.extend(Quantity::new(name, unit, value, known).decimals(2).cells());
                row.extend(
                    [band.map(|band| band.interval.low), band.map(|band| band.interval.high)]
                        .map(|end| known.value(end)),
                );
            } else {
                row.push(Cell::fixed(value, 2));
            }
            row.extend(self.compensated.iter().map(|after| Cell::fixed(of(after), 2)));
            Some(row)
        });
        Table::new(format!("ISO 230-2:2014, axis {}, {unit}", self.measured.axis), header, rows)
    }
}

/// Figures of the tables themselves, an axis a column, without those of scatter.
pub fn of_tables(machine: &Machine) -> Table {
    let axes: Vec<Accuracy> = machine.settings.axes.iter().filter_map(|own| of_table(machine, own.axis)).collect();
    let header = axes.iter().map(|own| format!("{}, {}", own.axis, unit(own.unit)));
    let rows = FIGURES.iter().zip(NAMES).filter(|((symbol, _), _)| !symbol.starts_with(['A', 'R']));
    let rows = rows.map(|((_, of), name)| {
        std::iter::once(name.into()).chain(axes.iter().map(|own| Cell::fixed(of(own), 2))).collect()
    });
    Table::new(
        "The tables themselves, uncorrected, without scatter",
        std::iter::once("figure".to_owned()).chain(header),
        rows,
    )
}
