//! Digest of the bits of an outcome.

use super::device::Outcome;
use super::scalar::{Place, Scalar};
use trueaxis::contour::ContourError;

/// Digest of everything that two runs must have in common; equal digests mean equal bits, except for a chance of one in 2⁶⁴.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Digest(pub(super) u64);

impl Digest {
    pub(super) const EMPTY: Digest = Digest(0x9e37_79b9_7f4a_7c15);

    #[inline(always)]
    pub(super) fn word(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0xd6e8_feb8_6659_fd93);
        self.0 ^= self.0 >> 32;
    }

    /// Adds everything except the ids of the tables. Span and cycle numbers, which only grow, are added if `counted`.
    pub(super) fn add<R: Scalar, P: Place, const N: usize>(&mut self, outcome: &Outcome<R, P, N>, counted: bool) {
        let (output, record) = (&outcome.output, &outcome.output.record);
        for positions in [&output.drive, &output.feedback, &record.command, &record.feedback] {
            positions.iter().for_each(|position| self.word(position.bits()));
        }
        record.correction.iter().for_each(|c| self.word(c.bits()));
        if let Some(parts) = &record.dynamic {
            for part in [&parts.sent, &parts.feed_forward, &parts.feedback, &parts.crosstalk, &parts.learned] {
                part.iter().for_each(|x| self.word(x.bits()));
            }
        }
        let [status, limited, at_edge, axis] =
            [record.status.0, record.limited, record.at_edge, record.fault_axis].map(u64::from);
        self.word(u64::from(record.fault as u8) | status << 8 | limited << 16 | at_edge << 24 | axis << 32);
        if counted {
            self.word(u64::from(record.sequence) | u64::from(record.tip.span) << 32);
        }
        self.contour(&record.tip);
        self.contour(&record.encoder);
        self.word(record.orientation.bits());
        self.word(u64::from(record.orientation_flags.bits()));
        self.word(outcome.gauge_output.infeed.bits());
        self.word(u64::from(outcome.gauge_output.flags.0) | u64::from(outcome.gauge_output.finished) << 16);
    }

    /// Adds only the drives, which is cheap.
    #[inline(always)]
    pub(super) fn drives<R: Scalar, P: Place, const N: usize>(&mut self, outcome: &Outcome<R, P, N>) {
        outcome.output.drive.iter().for_each(|drive| self.word(drive.bits()));
    }

    fn contour<R: Scalar>(&mut self, error: &ContourError<R>) {
        let [x, y, z]: [R; 3] = error.vector.into();
        let parts = [error.normal, error.binormal, error.tangential, error.lag, error.width];
        for scalar in [error.t, error.error, x, y, z].into_iter().chain(parts) {
            self.word(scalar.bits());
        }
        self.word(u64::from(error.evaluations) | u64::from(error.flags.bits()) << 8);
    }
}
