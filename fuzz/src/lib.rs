//! Every untrusted input of trueaxis under attack: one [`Target`] each, run by a seeded loop or by libFuzzer.

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
    /// Name on the command line, of its corpus and of its dictionary.
    pub name: &'static str,
    /// What is attacked, in a few words.
    pub about: &'static str,
    /// Reads the input as the product does, and panics if a promise about it is broken: not only that nothing panics,
    /// but what an accepted input must keep and what a refusal must say ([`outcome::refused`]).
    pub run: fn(&[u8]),
    /// Inputs that are accepted, to begin from; the corpus comes on top.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Makes lengths and check sums right again after a mutation, so that the attack gets past them; leaves alone what
    /// it does not recognise.
    pub repair: fn(&mut Vec<u8>),
    /// Words of the format, as libFuzzer's dictionaries have them.
    pub dictionary: &'static str,
    /// An execution that takes longer is a finding; [`SLOWEST`](execution::SLOWEST) unless what is attacked is known to take
    /// its time.
    pub slowest: Duration,
}

/// For formats without a check sum.
pub fn no_repair(_: &mut Vec<u8>) {}

/// Longest input of a target that has only small seeds, bytes.
const LONGEST: usize = 4096;

impl Target {
    /// Longest input that is tried, bytes: 4 KiB, or a half more than its longest seed.
    pub fn longest(&self) -> usize {
        let seed = (self.seeds)().iter().map(Vec::len).max().unwrap_or(0);
        LONGEST.max(seed + seed / 2)
    }
}
