//! Replays the same recording on the host and in the bare-metal image, and compares the outputs.
//!
//! In the same scalar, host and image must agree bit for bit. Corrections and contour errors in single and double precision
//! are compared in nanometres.

pub mod host;
pub mod image;
mod outcome;
pub mod outputs;
pub mod warming;

pub use outcome::{Comparison, Difference, Grown, Outcome};

use anyhow::{Result, anyhow, bail};
use image::{Core, Flash, Sent};
use outputs::{Row, bytes, decode};
use std::path::{Path, PathBuf};
use trueaxis::Fault;
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::Frame;
use trueaxis_recording::outputs::Wire;
use trueaxis_recording::{Received, Recording};
use trueaxis_tables::output::Outputs;

/// Inputs of a comparison.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The recording.
    pub recording: Vec<u8>,
    /// Compiled tables.
    pub tables: Vec<u8>,
    /// Tables that the recording requests in motion.
    pub second: Option<Vec<u8>>,
    /// Thermal growth with sensor readings ([`trueaxis_recording::warming`]).
    pub warming: Option<Vec<u8>>,
}

/// Contents of an image's flash: tables, the tables requested in motion, thermal growth, the recording.
const FLASH: [&str; 4] = ["tables-a.tcomp", "tables-b.tcomp", "warming.bin", "recording.rec"];

impl Inputs {
    /// The files that [`Inputs::compare`] writes to `folder`.
    pub fn files(folder: &Path) -> Vec<PathBuf> {
        let sent = [Core::M4f, Core::M7]
            .into_iter()
            .flat_map(|core| image::FILES.map(|name| folder.join(core.name()).join(name)));
        FLASH.into_iter().map(|name| folder.join(name)).chain(sent).collect()
    }

    /// Runs the recording on the host and on every given core with its image; the files are in `folder` afterwards.
    ///
    /// # Errors
    /// QEMU is missing, an image fails or refuses its tables, or a file does not fit.
    pub fn compare(&self, images: &[(Core, &Path)], folder: &Path) -> Result<Outcome> {
        let [tables, second, warming, recording] = FLASH.map(|name| folder.join(name));
        let (second, warming) = (self.second.as_ref().map(|_| second), self.warming.as_ref().map(|_| warming));
        let flash = Flash { tables, second, warming, recording };
        let mut outputs = Outputs::default();
        outputs.folder(folder)?;
        outputs.put(&flash.tables, &self.tables)?;
        for (file, bytes) in [(&flash.second, &self.second), (&flash.warming, &self.warming)] {
            if let (Some(file), Some(bytes)) = (file, bytes) {
                outputs.put(file, bytes)?;
            }
        }
        outputs.put(&flash.recording, &self.recording)?;
        outputs.commit()?;
        let header = Recording::<{ outputs::AXES }>::parse(&self.recording)
            .map_err(|e| anyhow!("recording: {e}"))?
            .header()
            .clone();
        let mut comparisons = Vec::new();
        for (core, elf) in images {
            let sent = image::run(*core, elf, &flash, &folder.join(core.name()))?;
            comparisons.push(match core {
                Core::M4f => self.one::<f32>(*core, &sent, header.gauge)?,
                Core::M7 => self.one::<f64>(*core, &sent, header.gauge)?,
            });
        }
        Ok(Outcome { header, comparisons })
    }

    fn one<R: Wire>(&self, core: Core, sent: &Sent, gauge: bool) -> Result<Comparison> {
        let on_image = decode::<R>(&sent.outputs, gauge);
        if let Some(code) = on_image.first().map(|row| row.fault).filter(|code| *code >= Fault::PeriodMismatch as u8) {
            bail!("{}: found tables refused with code {code}, needed tables that the image accepts", core.title());
        }
        // A cycle requests the exchange and a task carries it out; the records show in which cycle.
        let exchange = match &self.second {
            None => None,
            Some(bytes) => {
                let crc = Tcomp::parse(bytes).map_err(|e| anyhow!("second tables: {e}"))?.crc();
                on_image.iter().find(|row| row.tables_crc == crc).map(|row| (bytes.as_slice(), row.sequence))
            }
        };
        let warming = self.warming.as_deref();
        let on_host = host::replay::<R>(&self.recording, &self.tables, exchange, warming)?;
        let size = bytes::<R>(gauge);
        let outputs = &on_host.outputs;
        let differing = outputs.chunks_exact(size).zip(sent.outputs.chunks_exact(size)).filter(|(a, b)| a != b).count();
        let double = host::replay::<f64>(&self.recording, &self.tables, exchange, warming)?;
        let double = decode::<f64>(&double.outputs, gauge);
        let received = Received::read(&sent.frames);
        Ok(Comparison {
            core,
            cycles: on_image.len(),
            cycles_on_host: outputs.len() / size,
            differing,
            exchange_at: exchange.map(|(_, at)| at),
            frames: received.frames.len(),
            frames_damaged: received.damaged,
            frames_contradicting: contradicting(&received.frames, &on_image),
            revolutions: received.revolutions.len(),
            revolutions_equal: received.revolutions == on_host.revolutions,
            growth: warming.map(|_| outcome::Grown::of(&on_host.growths)),
            took: sent.took,
            against_double: Difference::between(&on_image, &double),
            faults: outcome::faults(&on_image),
            image: on_image,
            host: decode::<R>(outputs, gauge),
            double,
        })
    }
}

/// Number of frames that contradict the raw outputs of their cycle.
fn contradicting(frames: &[Frame], rows: &[Row]) -> usize {
    let says = |frame: &&Frame| {
        rows.get(frame.sequence as usize).is_none_or(|row| {
            let correction = frame.axes.iter().zip(row.correction).all(|(axis, c)| axis.correction == c as f32);
            let code = frame.fault as u8 == row.fault && frame.status.0 == row.status;
            !(correction && code && frame.tables_crc == row.tables_crc && frame.tip.error == row.tip as f32)
        })
    };
    frames.iter().filter(says).count()
}
