//! Tables and plots of an R-test.

use super::{RTestDocument, RTestFit, Record};
use crate::shown::{Cell, EXPANDED, Look, Plot, Shown, Table, Uncertainty, unit};

impl RTestDocument {
    /// Tables and plots of the record and the errors found.
    pub fn shown(&self, record: &Record, found: &RTestFit) -> Shown {
        let terms = self.terms.iter().map(|of| {
            let uncertainty = Uncertainty::of(of.standard_error, self.degrees_of_freedom as f64);
            let before = Cell::number(of.before, 4);
            vec![of.name.as_str().into(), uncertainty.value(of.value), uncertainty.cell(), before, unit(of.unit).into()]
        });
        let place = |name: String, um: &[f64; 3]| {
            std::iter::once(name.into()).chain(um.map(|um| Cell::number(um, 4))).collect::<Vec<Cell>>()
        };
        let mut places = vec![place("range of the readings, machine's directions".into(), &self.range_um)];
        for (number, ball) in record.balls.iter().zip(&self.balls_um) {
            let ball_of = if self.balls > 1 { format!("ball {number}") } else { "ball".into() };
            places.push(place(format!("{ball_of} off its place, workpiece's frame"), ball));
        }
        places.extend(self.sensor_um.iter().map(|zero| place("zero of the nest, tool's frame".into(), zero)));
        let fit = [
            ("readings, RMS, µm", Cell::number(self.rms_um, 3)),
            ("left, RMS, µm", Cell::number(self.left_rms_um, 3)),
            ("largest residual, µm", Cell::number(self.left_max_um, 3)),
            ("in line", Cell::count(self.left_max_line as usize)),
            ("sigma of a coordinate, µm", Cell::number(self.sigma_um, 3)),
            ("degrees of freedom", Cell::count(self.degrees_of_freedom)),
            ("rank: all unknowns", Cell::count(self.rank)),
            ("condition number", Cell::number(self.condition, 3)),
        ];
        let displacements: Vec<[f64; 3]> = record.readings.iter().map(|reading| reading.displacement_mm).collect();
        Shown {
            title: "R-test".into(),
            summary: vec![format!("{} readings", self.readings), format!("rank {}", self.rank)],
            notes: self.notes.clone(),
            tables: vec![
                Table::new("Location errors", ["location error", "found", EXPANDED, "machine has", "unit"], terms),
                Table::new("Places", ["µm", "X", "Y", "Z"], places),
                Table::figures("Fit", fit),
            ],
            plots: vec![
                over_readings("Displacement", "Displacement of the tool from the ball", "displacement", &displacements),
                over_readings("Residuals", "Residuals of the location errors", "left", &found.left_mm),
            ],
            ..Shown::default()
        }
    }
}

fn over_readings(section: &'static str, title: &str, name: &'static str, rows_mm: &[[f64; 3]]) -> Plot {
    let rows: Vec<[f64; 3]> = rows_mm.iter().map(|row| row.map(|mm| 1e3 * mm)).collect();
    Plot {
        section,
        title: title.into(),
        x: ("reading".into(), ""),
        y: (name, "µm"),
        look: Look::Dotted,
        caption: "In the order of the record, in the machine's directions.",
        at: (1..=rows.len()).map(|number| number as f64).collect(),
        curves: Plot::along(&rows),
        ..Plot::default()
    }
}
