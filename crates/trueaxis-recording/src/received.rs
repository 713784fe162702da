//! Telemetry as it was received.

use std::vec::Vec;
use trueaxis::telemetry::{Frame, RoundnessFrame};

/// Records of a stream of COBS frames, each kind in the order of arrival.
#[derive(Clone, Debug, Default)]
pub struct Received {
    /// Records of cycles.
    pub frames: Vec<Frame>,
    /// Records of revolutions.
    pub revolutions: Vec<RoundnessFrame>,
    /// Number of frames that are neither.
    pub damaged: usize,
}

impl Received {
    /// Splits a stream at its zeros. Also reads a complete last frame without a trailing zero.
    pub fn read(bytes: &[u8]) -> Received {
        let mut received = Received::default();
        for frame in bytes.split(|byte| *byte == 0).filter(|frame| !frame.is_empty()) {
            let [mut first, mut second] = [frame.to_vec(), frame.to_vec()];
            if let Ok(frame) = Frame::decode(&mut first) {
                received.frames.push(frame);
            } else if let Ok(revolution) = RoundnessFrame::decode(&mut second) {
                received.revolutions.push(revolution);
            } else {
                received.damaged += 1;
            }
        }
        received
    }
}
