//! Circles in a controller's telemetry.

use crate::received::notes;
use anyhow::{Result, bail};
use std::path::Path;
use trueaxis::Axis;
use trueaxis::telemetry::{AxisFrame, Frame};
use trueaxis_metrology::ballbar::Position;
use trueaxis_recording::Received;

/// Whether bytes are COBS frames: every frame ends with a zero byte, and text has none.
pub(super) fn is_telemetry(bytes: &[u8]) -> bool {
    bytes.contains(&0)
}

/// Commands and encoder readings of two axes, cycle by cycle.
pub(super) fn positions(bytes: &[u8], file: &Path, axes: [Axis; 2], note: impl FnMut(String)) -> Result<Vec<Position>> {
    let received = Received::read(bytes);
    if received.frames.is_empty() {
        bail!("{}: found no whole record of a cycle, needed text or telemetry as in docs/telemetry.md", file.display());
    }
    notes(file, &received).into_iter().for_each(note);
    let position = |frame: &Frame| {
        let own = axes.map(|axis| frame.axes.get(axis.index()));
        let of = |take: fn(&AxisFrame) -> f64| own.map(|axis| axis.map_or(f64::NAN, take));
        Position { command: of(|axis| axis.command), actual: of(|axis| axis.feedback) }
    };
    Ok(received.frames.iter().map(position).collect())
}
