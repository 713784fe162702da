//! The check sum at the end of a file.

use trueaxis::tcomp::checksum;

/// Writes the CRC-32/ISO-HDLC of all bytes except the last four into those four; does nothing to fewer than four bytes.
pub fn seal(bytes: &mut [u8]) {
    if let Some((content, sum)) = bytes.split_last_chunk_mut::<4>() {
        *sum = checksum(content).to_le_bytes();
    }
}
