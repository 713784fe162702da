//! Output of records: frames on UART 0, raw outputs on UART 1 ([`outputs`]), notable events in the log.
//!
//! A cycle whose record was dropped is missing from both.

use crate::board::Uart;
use crate::servo::{Gauge, Produced};
use heapless::spsc::Consumer;
use trueaxis::Fault;
use trueaxis::telemetry::{FRAME_BYTES, Frame, ROUNDNESS_FRAME_BYTES, RoundnessFrame};
use trueaxis_recording::outputs;

/// The telemetry task's end of the queue, and its ports.
pub struct Telemetry {
    produced: Consumer<'static, Produced>,
    frames: Uart,
    raw: Uart,
    fault: Fault,
    tables_crc: u32,
    /// Revolutions whose record could not be sent.
    lost_revolutions: u32,
}

impl Telemetry {
    /// Ready for the first record of tables with this CRC.
    pub fn new(produced: Consumer<'static, Produced>, frames: Uart, raw: Uart, tables_crc: u32) -> Self {
        Telemetry { produced, frames, raw, fault: Fault::None, tables_crc, lost_revolutions: 0 }
    }

    /// The next cycle, if any.
    pub fn next(&mut self) -> Option<Produced> {
        self.produced.dequeue()
    }

    /// Whether no cycle is waiting.
    pub fn is_empty(&self) -> bool {
        !self.produced.ready()
    }

    /// Revolutions whose record could not be sent.
    pub fn lost_revolutions(&self) -> u32 {
        self.lost_revolutions
    }

    /// Sends a cycle.
    pub fn cycle(&mut self, produced: &Produced) {
        let record = &produced.output.record;
        let mut buffer = [0; FRAME_BYTES];
        if let Ok(frame) = Frame::of(record).encode(&mut buffer) {
            self.frames.send(frame);
        }
        self.raw.send(&outputs::line(&produced.output, produced.gauge.map(|gauge| gauge.infeed)));
        if record.tables_crc != self.tables_crc {
            self.tables_crc = record.tables_crc;
            defmt::info!("tables {=u32:08x} in force from cycle {=u32}", record.tables_crc, record.sequence);
        }
        if record.fault != self.fault {
            if self.fault != Fault::None {
                defmt::info!("fault {} ended at cycle {=u32}", self.fault, record.sequence);
            }
            if record.fault != Fault::None {
                let code = u8::from(record.fault);
                let axis = record.fault_axis;
                defmt::warn!(
                    "fault {=u8} {} of axis {=u8} began at cycle {=u32}",
                    code,
                    record.fault,
                    axis,
                    record.sequence
                );
            }
            self.fault = record.fault;
        }
    }

    /// Sends a revolution.
    pub fn revolution(&mut self, frame: Option<RoundnessFrame>) {
        let mut buffer = [0; ROUNDNESS_FRAME_BYTES];
        match frame.as_ref().and_then(|frame| frame.encode(&mut buffer).ok()) {
            Some(frame) => self.frames.send(frame),
            None => self.lost_revolutions += 1,
        }
    }
}

/// The record of the latest revolution, unless the work on the next one has begun.
pub fn latest(machine_id: u32, gauge: &Gauge) -> Option<RoundnessFrame> {
    if gauge.state.is_settled() { RoundnessFrame::of(machine_id, gauge.plan, gauge.state) } else { None }
}
