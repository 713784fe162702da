//! Remarks on telemetry as it was received.

use std::path::Path;
use trueaxis_recording::Received;
use trueaxis_tables::text::counted;

/// Reports the number of damaged frames and of records missing from the sequence; `file` is named.
pub fn notes(file: &Path, received: &Received) -> Vec<String> {
    let mut notes = Vec::new();
    if received.damaged > 0 {
        notes.push(format!("{}: {}, left out", file.display(), counted(received.damaged, "damaged frame")));
    }
    let pairs = received.frames.iter().zip(received.frames.iter().skip(1));
    let (mut gaps, mut lost) = (0, 0_u64);
    for (before, after) in pairs {
        let missing = after.sequence.wrapping_sub(before.sequence).wrapping_sub(1);
        // A restarted controller counts from 0.
        if missing > 0 && after.sequence != 0 {
            gaps += 1;
            lost += u64::from(missing);
        }
    }
    if gaps > 0 {
        let (lost, gaps) = (counted(lost as usize, "record"), counted(gaps, "gap"));
        notes.push(format!("{}: {lost} missing in {gaps} of the sequence", file.display()));
    }
    notes
}
