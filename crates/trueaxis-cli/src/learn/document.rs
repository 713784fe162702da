//! The learned correction as printed.

use serde::Serialize;
use std::fmt::Write;
use trueaxis_evaluation::learn::Record;
use trueaxis_metrology::learning::{Law, Lesson};
use trueaxis_tables::text::counted;

/// Magnitudes of an error.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Size {
    pub(crate) max_um: f64,
    pub(crate) rms_um: f64,
}

/// The JSON document.
#[derive(Serialize)]
pub(crate) struct LearnDocument {
    pub(crate) program_id: String,
    pub(crate) machine_id: String,
    pub(crate) length_mm: f64,
    pub(crate) parts: u16,
    pub(crate) nodes: usize,
    pub(crate) spacing_mm: f64,
    pub(crate) gain: f64,
    pub(crate) forget: f64,
    pub(crate) cutoff_mm: f64,
    /// Contour error of the recorded part.
    pub(crate) before: Size,
    /// Contour error with the new correction, if a correction moves the tip by its full amount.
    pub(crate) predicted: Size,
    /// Largest component of the new correction.
    pub(crate) correction_um: f64,
    /// Share of the path without a measured error.
    pub(crate) unmeasured: f64,
}

impl LearnDocument {
    pub(super) fn new(record: &Record, law: Law, lesson: &Lesson) -> LearnDocument {
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

    /// The document as a text table.
    pub(super) fn table(&self) -> Result<String, std::fmt::Error> {
        let mut text = format!(
            "program {}, machine {}, {:.3} mm, {}\n\n",
            self.program_id,
            self.machine_id,
            self.length_mm,
            counted(self.parts.into(), "part")
        );
        writeln!(text, "contour error, µm  {:>10} {:>10}", "largest", "RMS")?;
        for (name, size) in [("this part", self.before), ("predicted", self.predicted)] {
            writeln!(text, "{name:<18} {:>10.4} {:>10.4}", size.max_um, size.rms_um)?;
        }
        writeln!(text, "\ncorrection         at most {:.4} µm", self.correction_um)?;
        let nodes = counted(self.nodes, "node");
        writeln!(text, "nodes              {nodes}, {:.6} mm apart", self.spacing_mm)?;
        writeln!(
            text,
            "law                gain {}, forgetting {}, cut-off {} mm",
            self.gain, self.forget, self.cutoff_mm
        )?;
        writeln!(text, "not measured       {:.1} % of the path", 1e2 * self.unmeasured)?;
        Ok(text)
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
