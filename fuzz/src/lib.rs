//! Attacks on every untrusted input of trueaxis: one [`Target`] each, run by a seeded loop or by libFuzzer.

pub mod alone;
pub mod archive;
pub mod campaign;
pub mod choice;
pub mod corpus;
pub mod execution;
pub mod finding;
pub mod machines;
pub mod mutate;
pub mod outcome;
pub mod parts;
pub mod refusal;
pub mod small;
pub mod sum;
pub mod targets;

use std::time::Duration;

/// One untrusted input.
pub struct Target {
    /// Name on the command line, and of the corpus and the dictionary.
    pub name: &'static str,
    /// Short description of the attacked input.
    pub about: &'static str,
    /// Reads the input as the product does, and panics if a promise is broken. The promises cover more than the absence
    /// of panics: conditions on every accepted input, and the content of a refusal ([`outcome::refused`]).
    pub run: fn(&[u8]),
    /// Accepted inputs to begin from, in addition to the corpus.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Corrects lengths and check sums after a mutation, so that the attack gets past them. Leaves unrecognised bytes
    /// unchanged.
    pub repair: fn(&mut Vec<u8>),
    /// Words of the format, in the syntax of libFuzzer's dictionaries.
    pub dictionary: &'static str,
    /// An execution that takes longer is a finding; [`SLOWEST`](execution::SLOWEST) unless the attacked code is known to be
    /// slow.
    pub slowest: Duration,
}

/// The repair for formats without a check sum.
pub fn no_repair(_: &mut Vec<u8>) {}

/// Longest input of a target with only small seeds, bytes.
const LONGEST: usize = 4096;

impl Target {
    /// Longest input tried, bytes: 4 KiB, or one and a half times the longest seed.
    pub fn longest(&self) -> usize {
        let seed = (self.seeds)().iter().map(Vec::len).max().unwrap_or(0);
        LONGEST.max(seed + seed / 2)
    }
}
