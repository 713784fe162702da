//! CSV trace of the compensated run.

use crate::simulate::Sample;
use anyhow::{Context, Result};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use trueaxis::Output;
use trueaxis_tables::output::Staged;

/// Writes a line every so many cycles. The file is in its place when [`Trace::finish`] has put it there.
#[derive(Debug)]
pub struct Trace {
    file: BufWriter<Staged>,
    path: PathBuf,
    every: u64,
    count: u64,
    failure: Option<std::io::Error>,
}

const HEADER: &str = "time_s,line,command_x_mm,command_y_mm,command_z_mm,drive_x_mm,drive_y_mm,drive_z_mm,\
feedback_x_mm,feedback_y_mm,feedback_z_mm,correction_x_um,correction_y_um,correction_z_um,true_error_um,\
true_error_x_um,true_error_y_um,true_error_z_um,estimated_error_um,encoder_error_um,lag_um,fault,status,limited,at_edge,\
a_deg,b_deg,c_deg,true_orientation_urad,estimated_orientation_urad";

impl Trace {
    /// Begins the file and writes its header.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn create(path: &Path, every: u64) -> Result<Trace> {
        let file = Staged::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        let mut trace =
            Trace { file: BufWriter::new(file), path: path.into(), every: every.max(1), count: 0, failure: None };
        writeln!(trace.file, "{HEADER}").with_context(|| format!("cannot write {}", path.display()))?;
        Ok(trace)
    }

    /// Takes one cycle; a failure to write is kept for [`Trace::finish`].
    pub fn row<const N: usize>(&mut self, time_s: f64, line: u32, sample: &Sample, output: &Output<f64, f64, N>) {
        let due = self.count.is_multiple_of(self.every);
        self.count += 1;
        if !due || self.failure.is_some() {
            return;
        }
        let r = &output.record;
        let [dx, dy, dz] = sample.deviation_um;
        let [cx, cy, cz] = sample.correction_um;
        let [a, b, c] = sample.rotary_deg;
        let size = (dx * dx + dy * dy + dz * dz).sqrt();
        let result = writeln!(
            self.file,
            "{time_s:.7},{line},{:.7},{:.7},{:.7},{:.7},{:.7},{:.7},{:.7},{:.7},{:.7},{cx:.5},{cy:.5},{cz:.5},\
             {size:.5},{dx:.5},{dy:.5},{dz:.5},{:.5},{:.5},{:.5},{},{},{},{},\
             {a:.4},{b:.4},{c:.4},{:.4},{:.4}",
            r.command[0],
            r.command[1],
            r.command[2],
            output.drive[0],
            output.drive[1],
            output.drive[2],
            r.feedback[0],
            r.feedback[1],
            r.feedback[2],
            sample.estimated_um,
            r.encoder.error * 1e3,
            r.tip.lag * 1e3,
            r.fault as u8,
            r.status.0,
            r.limited,
            r.at_edge,
            sample.orientation_urad,
            sample.estimated_orientation_urad,
        );
        self.failure = result.err();
    }

    /// Puts the file into its place.
    ///
    /// # Errors
    /// Something could not be written.
    pub fn finish(mut self) -> Result<PathBuf> {
        let result = match self.failure.take() {
            Some(error) => Err(error),
            None => self.file.into_inner().map_err(|error| error.into_error()).and_then(Staged::commit),
        };
        result.with_context(|| format!("cannot write {}", self.path.display()))?;
        Ok(self.path)
    }
}
