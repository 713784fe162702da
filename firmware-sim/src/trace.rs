//! CSV trace of a run.

use std::io::{self, Write};
use trueaxis::machine::{Axis, MachineSettings};
use trueaxis_sim::run::{Kind, Moment, Sample, Sink};

/// Writes a line every so many cycles, as they come.
#[derive(Debug)]
pub struct Trace<W> {
    out: W,
    every: u64,
    /// Index of the run in [`Kind::ALL`].
    run: usize,
    /// Axes whose dynamic correction is written, in its parts.
    dynamic: Vec<Axis>,
    /// Rotary axes of the machine.
    rotary: Vec<Axis>,
    failure: Option<io::Error>,
}

const HEADER: &str = "time_s,line,command_x_mm,command_y_mm,command_z_mm,drive_x_mm,drive_y_mm,drive_z_mm,\
feedback_x_mm,feedback_y_mm,feedback_z_mm,correction_x_um,correction_y_um,correction_z_um,true_error_um,\
true_error_x_um,true_error_y_um,true_error_z_um,estimated_error_um,encoder_error_um,lag_um,fault,status,limited,at_edge,\
a_deg,b_deg,c_deg,true_orientation_urad,estimated_orientation_urad";

impl<W: Write> Trace<W> {
    /// Writes the header. A line is written in every `every`th cycle of the run of that kind; a machine with rotary axes
    /// has their command, drive, feedback (degrees) and correction (µrad) at its end, the full run the dynamic correction of
    /// every axis and its parts (µm, µrad) after those.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(mut out: W, every: u64, kind: Kind, machine: &MachineSettings) -> io::Result<Trace<W>> {
        write!(out, "{HEADER}")?;
        let mut rotary: Vec<Axis> = machine.axes.iter().map(|a| a.axis).filter(|axis| axis.is_rotary()).collect();
        rotary.sort_unstable();
        for axis in &rotary {
            let a = axis.letter().to_ascii_lowercase();
            write!(out, ",command_{a}_deg,drive_{a}_deg,feedback_{a}_deg,correction_{a}_urad")?;
        }
        let mut dynamic: Vec<Axis> = Vec::new();
        if kind == Kind::Full {
            dynamic.extend(machine.axes.iter().map(|a| a.axis));
            dynamic.sort_unstable();
        }
        for axis in &dynamic {
            let (a, unit) = (axis.letter().to_ascii_lowercase(), if axis.is_rotary() { "urad" } else { "um" });
            for part in ["dynamic", "feed_forward", "contour_feedback", "crosstalk"] {
                write!(out, ",{part}_{a}_{unit}")?;
            }
        }
        writeln!(out)?;
        let run = Kind::ALL.iter().position(|of| *of == kind).unwrap_or(Kind::ALL.len());
        Ok(Trace { out, every: every.max(1), run, rotary, dynamic, failure: None })
    }

    fn row(&mut self, moment: &Moment, s: &Sample) -> io::Result<()> {
        let [dx, dy, dz] = s.deviation_um;
        let [cx, cy, cz, ..] = s.correction;
        let [a, b, c] = moment.rotary_deg;
        write!(
            self.out,
            "{:.7},{},{:.7},{:.7},{:.7},{:.7},{:.7},{:.7},{:.7},{:.7},{:.7},{cx:.5},{cy:.5},{cz:.5},\
             {:.5},{dx:.5},{dy:.5},{dz:.5},{:.5},{:.5},{:.5},{},{},{},{},\
             {a:.4},{b:.4},{c:.4},{:.4},{:.4}",
            moment.time_s,
            moment.line,
            s.command[0],
            s.command[1],
            s.command[2],
            s.drive[0],
            s.drive[1],
            s.drive[2],
            s.feedback[0],
            s.feedback[1],
            s.feedback[2],
            s.error_um(),
            s.estimated_um,
            s.encoder_um,
            s.lag_um,
            s.fault,
            s.status,
            s.limited,
            s.at_edge,
            s.orientation_urad,
            s.estimated_orientation_urad,
        )?;
        for axis in &self.rotary {
            let i = axis.index();
            let (command, drive, feedback) = (s.command[i], s.drive[i], s.feedback[i]);
            write!(self.out, ",{command:.9},{drive:.9},{feedback:.9},{:.5}", s.correction[i])?;
        }
        for axis in &self.dynamic {
            let (i, d) = (axis.index(), &s.dynamic);
            let [sent, forward] = [d.sent[i], d.feed_forward[i]];
            let [feedback, crosstalk] = [d.feedback[i], d.crosstalk[i]];
            write!(self.out, ",{sent:.5},{forward:.5},{feedback:.5},{crosstalk:.5}")?;
        }
        writeln!(self.out)
    }

    /// Hands back what was written to.
    ///
    /// # Errors
    /// Something could not be written.
    pub fn finish(mut self) -> io::Result<W> {
        match self.failure.take() {
            Some(error) => Err(error),
            None => self.out.flush().map(|()| self.out),
        }
    }
}

impl<W: Write> Sink for Trace<W> {
    /// A failure to write is kept for [`Trace::finish`].
    fn cycle(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        if moment.cycle.is_multiple_of(self.every)
            && self.failure.is_none()
            && let Some(Some(sample)) = runs.get(self.run)
        {
            self.failure = self.row(moment, sample).err();
        }
    }
}
