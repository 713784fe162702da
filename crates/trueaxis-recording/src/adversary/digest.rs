//! A digest of outputs.

use crate::outputs::{Wire, line_of_axes};
use trueaxis::Output;

/// Digest of the bytes of every output, in order: two runs with equal digests gave the same bits, except for a chance of one
/// in 2³².
#[derive(Clone, Copy, Debug)]
pub struct Digest(u32);

impl Default for Digest {
    fn default() -> Self {
        Digest(0x811c_9dc5)
    }
}

impl Digest {
    /// Adds an output: its line from [`crate::outputs`], both contour errors in full, and the dynamic correction's parts.
    pub fn add<R: Wire, const N: usize>(&mut self, output: &Output<R, R::Place, N>) {
        self.add_axes(output, N);
    }

    /// [`Digest::add`] of a step with spare slots, of whose slots the first `axes` count: the digest is that of a step
    /// without them.
    pub fn add_axes<R: Wire, const N: usize>(&mut self, output: &Output<R, R::Place, N>, axes: usize) {
        let record = &output.record;
        self.bytes(&line_of_axes(output, axes, None));
        if let Some(parts) = &record.dynamic {
            for list in [&parts.sent, &parts.feed_forward, &parts.feedback, &parts.crosstalk, &parts.learned] {
                list.iter().take(axes).for_each(|scalar| scalar.put(|bytes| self.bytes(bytes)));
            }
        }
        for error in [&record.tip, &record.encoder] {
            let [x, y, z] = error.vector.into();
            let components = [error.normal, error.binormal, error.tangential];
            for scalar in [error.t, error.error, x, y, z, error.lag, error.width].into_iter().chain(components) {
                scalar.put(|bytes| self.bytes(bytes));
            }
            self.word(error.span);
            self.word(u32::from_le_bytes([error.evaluations, error.flags.bits(), 0, 0]));
        }
    }

    /// The digest so far.
    pub fn value(self) -> u32 {
        self.0
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for word in bytes.as_chunks::<4>().0 {
            self.word(u32::from_le_bytes(*word));
        }
    }

    fn word(&mut self, word: u32) {
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b1);
    }
}
