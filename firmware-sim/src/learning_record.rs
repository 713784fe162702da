//! The contour error of a run over path length, in the format that `trueaxis learn` reads.

use std::io::{self, Write};
use trueaxis_sim::learning::{Identity, Recorder};
use trueaxis_sim::run::{Moment, Sample, Sink};

/// Writes a line per cycle, in order.
#[derive(Debug)]
pub struct LearningRecord<W> {
    out: W,
    /// Index of the run.
    run: usize,
    recorder: Recorder,
    failure: Option<io::Error>,
}

impl<W: Write> LearningRecord<W> {
    /// Writes the header, which identifies program and machine.
    ///
    /// # Errors
    /// The writer fails.
    pub fn new(mut out: W, run: usize, identity: &Identity, recorder: Recorder) -> io::Result<LearningRecord<W>> {
        let Identity { machine_id, program_id, length_mm } = identity;
        writeln!(
            out,
            "# program_id = {program_id:08x}\n# machine_id = {machine_id:08x}\n# length_mm = {length_mm:.6}"
        )?;
        writeln!(out, "s_mm,ex_um,ey_um,ez_um,measured")?;
        Ok(LearningRecord { out, run, recorder, failure: None })
    }

    /// Returns the writer.
    ///
    /// # Errors
    /// A write failed.
    pub fn finish(mut self) -> io::Result<W> {
        match self.failure.take() {
            Some(error) => Err(error),
            None => self.out.flush().map(|()| self.out),
        }
    }
}

impl<W: Write> Sink for LearningRecord<W> {
    /// Stores a write error for [`LearningRecord::finish`].
    fn cycle(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        if self.failure.is_none()
            && let Some(Some(sample)) = runs.get(self.run)
        {
            let row = self.recorder.row(moment, sample);
            let [x, y, z] = row.error_mm.unwrap_or_default().map(|value| 1e3 * value);
            let known = u8::from(row.error_mm.is_some());
            self.failure = writeln!(self.out, "{:.6},{x:.5},{y:.5},{z:.5},{known}", row.length_mm).err();
        }
    }
}
