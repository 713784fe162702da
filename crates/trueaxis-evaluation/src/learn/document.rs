//! The learned correction as a document, a table and plots.

use super::Record;
use crate::shown::{Cell, Curve, Plot, Shown, Table};
use serde::Serialize;
use trueaxis_metrology::learning::{Law, Lesson};
use trueaxis_tables::text::counted;

/// Magnitudes of an error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Largest.
    pub max_um: f64,
    /// Root mean square.
    pub rms_um: f64,
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LearnDocument {
    /// Identifier of the path, hexadecimal.
    pub program_id: String,
    /// Identifier of the machine, hexadecimal.
    pub machine_id: String,
    /// Length of the path.
    pub length_mm: f64,
    /// Parts learned from.
    pub parts: u16,
    /// Number of nodes of the correction.
    pub nodes: usize,
    /// Distance of the nodes.
    pub spacing_mm: f64,
    /// Gain L of the law.
    pub gain: f64,
    /// Forgetting f of the law.
    pub forget: f64,
    /// Cut-off of the low-pass Q along the path.
    pub cutoff_mm: f64,
    /// Contour error of the recorded part.
    pub before: Size,
    /// Contour error with the new correction, if a correction moves the tip by its full amount.
    pub predicted: Size,
    /// Largest component of the new correction.
    pub correction_um: f64,
    /// Share of the path without a measured error.
    pub unmeasured: f64,
}

impl LearnDocument {
    /// The document of a lesson from a record.
    pub fn new(record: &Record, law: Law, lesson: &Lesson) -> LearnDocument {
        let Lesson { header, spacing_mm, before_mm, correction_mm, .. } = lesson;
        let spacing_mm = *spacing_mm;
        let at = |nodes: &[[f64; 3]], length: f64| -> [f64; 3] {
            let place = (length / spacing_mm).max(0.0);
            let (cell, share) = (place as usize, place.fract());
            let node = |k: usize| nodes.get(k).copied().unwrap_or_default();
            let (here, ahead) = (node(cell), node(cell + 1));
            std::array::from_fn(|i| here[i] + share * (ahead[i] - here[i]))
        };
        let measured = || record.rows.iter().filter_map(|row| row.error_mm.map(|error| (row.length_mm, error)));
        let predicted = measured().map(|(length, error)| {
            let (new, old) =
                (at(correction_mm, length), before_mm.as_ref().map_or([0.0; 3], |before| at(before, length)));
            std::array::from_fn(|i| error[i] + new[i] - old[i])
        });
        let gaps = record.rows.windows(2).filter(|pair| pair.iter().any(|row| row.error_mm.is_none()));
        let unmeasured: f64 = gaps.map(|pair| pair[1].length_mm - pair[0].length_mm).sum();
        LearnDocument {
            program_id: format!("{:08x}", header.program_id),
            machine_id: format!("{:08x}", header.machine_id),
            length_mm: record.identity.length_mm,
            parts: header.parts,
            nodes: correction_mm.len(),
            spacing_mm,
            gain: law.gain,
            forget: law.forget,
            cutoff_mm: law.cutoff_mm,
            before: Size::of(measured().map(|(_, error)| error)),
            predicted: Size::of(predicted),
            correction_um: 1e3 * correction_mm.iter().flatten().fold(0.0, |most: f64, value| most.max(value.abs())),
            unmeasured: unmeasured / record.identity.length_mm,
        }
    }

    /// Tables of the errors and the correction, and both over path length.
    pub fn shown(&self, lesson: &Lesson) -> Shown {
        let parts = counted(self.parts.into(), "part");
        let sizes = [("this part", self.before), ("predicted for the next", self.predicted)];
        let sizes = sizes.map(|(name, of)| vec![name.into(), Cell::number(of.max_um, 4), Cell::number(of.rms_um, 4)]);
        let figures = [
            ("largest component, µm", Cell::number(self.correction_um, 4)),
            ("nodes", Cell::count(self.nodes)),
            ("distance of the nodes, mm", Cell::fixed(self.spacing_mm, 6)),
            ("path not measured, %", Cell::percent(self.unmeasured)),
        ];
        Shown {
            title: "Learned correction".into(),
            summary: vec![
                format!("program {}", self.program_id),
                format!("machine {}", self.machine_id),
                format!("{:.3} mm, {parts}", self.length_mm),
                format!("gain {}, forgetting {}, cut-off {} mm", self.gain, self.forget, self.cutoff_mm),
            ],
            tables: vec![
                Table::new("Contour error", ["", "largest, µm", "RMS, µm"], sizes),
                Table::figures("Correction", figures),
            ],
            plots: vec![
                self.over_length("Contour error of this part", "error", &lesson.errors_mm),
                self.over_length("Correction for the next", "correction", &lesson.correction_mm),
            ],
            ..Shown::default()
        }
    }

    fn over_length(&self, section: &'static str, quantity: &'static str, nodes: &[[f64; 3]]) -> Plot {
        let curve = |(i, name)| Curve::new(name, i, nodes.iter().map(|node| 1e3 * node[i]).collect());
        Plot {
            section,
            title: format!("{section}, over path length"),
            x: ("path length".into(), "mm"),
            y: (quantity, "µm"),
            at: (0..nodes.len()).map(|k| k as f64 * self.spacing_mm).collect(),
            curves: ["X", "Y", "Z"].into_iter().enumerate().map(curve).collect(),
            ..Plot::default()
        }
    }
}

impl Size {
    /// Magnitudes of errors in mm.
    fn of(errors: impl Iterator<Item = [f64; 3]>) -> Size {
        let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0_u64);
        for error in errors {
            let square: f64 = error.iter().map(|value| value * value).sum();
            largest = largest.max(square);
            sum += square;
            count += 1;
        }
        Size { max_um: 1e3 * largest.sqrt(), rms_um: 1e3 * (sum / count.max(1) as f64).sqrt() }
    }
}
