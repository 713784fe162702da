//! The sum at the end of a file.

use trueaxis::tcomp::checksum;

/// Puts CRC-32/ISO-HDLC over all bytes but the last four into these; nothing where there are fewer.
pub fn seal(bytes: &mut [u8]) {
    if let Some((content, sum)) = bytes.split_last_chunk_mut::<4>() {
        *sum = checksum(content).to_le_bytes();
    }
}
