//! Encodes a correction as the file that the host reads.

use super::NotLearned;
use std::vec::Vec;
use trueaxis::learned::{COARSEST_RESOLUTION_PM, LearnedHeader};
use trueaxis::tcomp::checksum;

/// Most nodes of a correction: 120 MB of file.
pub const MOST_NODES: usize = 20_000_000;

/// Largest count of an i16, of either sign.
const COUNTS: f64 = 32_767.0;
const PM_PER_MM: f64 = 1e9;

/// Number of nodes of a path, from 0 to its end.
pub(super) fn nodes(length_mm: f64, spacing_mm: f64) -> Result<usize, NotLearned> {
    // In whole nm, as in the file.
    let (length, spacing) = ((length_mm * 1e6).round(), (spacing_mm * 1e6).round());
    let nodes = (length / spacing).ceil() + 1.0;
    // Also refuses NaN.
    if !(2.0..=MOST_NODES as f64).contains(&nodes) {
        return Err(NotLearned::TooLong { found: nodes, most: MOST_NODES });
    }
    Ok(nodes as usize)
}

/// Encodes a correction at the header's nodes, mm, as a file; sets `header.resolution_pm` to the finest sufficient resolution.
///
/// # Errors
/// The number of nodes differs from the header's; the correction is too large or not finite.
pub fn encode(header: LearnedHeader, correction_mm: &[[f64; 3]]) -> Result<Vec<u8>, NotLearned> {
    let needed = header.nodes().and_then(|nodes| usize::try_from(nodes).ok()).unwrap_or(0);
    if correction_mm.len() != needed {
        return Err(NotLearned::Nodes { found: correction_mm.len(), needed });
    }
    let components = || correction_mm.iter().flatten();
    let largest = components().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let coarsest = f64::from(COARSEST_RESOLUTION_PM);
    if largest * PM_PER_MM > COUNTS * coarsest || components().any(|value| !value.is_finite()) {
        return Err(NotLearned::TooStrong { found_mm: largest, most_mm: COUNTS * coarsest / PM_PER_MM });
    }
    let resolution = (largest * PM_PER_MM / COUNTS).ceil().max(1.0);
    let header = LearnedHeader { resolution_pm: resolution as u32, ..header };
    let mut bytes = header.to_bytes().to_vec();
    for value in components() {
        let count = (value * PM_PER_MM / resolution).round() as i16;
        bytes.extend(count.to_le_bytes());
    }
    bytes.extend(checksum(&bytes).to_le_bytes());
    Ok(bytes)
}
