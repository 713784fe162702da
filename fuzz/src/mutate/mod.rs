//! Mutants made from other inputs: bytes, words of the format, numbers, lines and lengths.

mod lines;
mod numbers;
mod words;

pub use words::dictionary;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use std::ops::Range;

/// Bytes with a meaning in the formats.
const INTERESTING: [u8; 16] = *b"\0\x01\x7f\x80\xff\n\r\t \",;.-(0";

/// A seeded source of mutants.
pub struct Mutator {
    rng: ChaCha8Rng,
    words: Vec<Vec<u8>>,
    longest: usize,
}

impl Mutator {
    /// Creates a source of mutants of at most `longest` bytes, with these words of the format.
    pub fn new(seed: u64, words: Vec<Vec<u8>>, longest: usize) -> Mutator {
        Mutator { rng: ChaCha8Rng::seed_from_u64(seed), words, longest }
    }

    /// A whole number below `count`; 0 if `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.rng.next_u64()) * count as u128) >> 64) as usize
    }

    /// True once in `times`.
    pub fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    /// Changes `input` in one or a few places; `other` is another input to take parts from.
    pub fn mutate(&mut self, input: &mut Vec<u8>, other: &[u8]) {
        loop {
            self.change(input, other);
            if self.once_in(2) {
                break;
            }
        }
        if self.once_in(64) {
            self.stretch(input);
        }
        input.truncate(self.longest);
    }

    fn change(&mut self, input: &mut Vec<u8>, other: &[u8]) {
        let text = !input.contains(&0);
        match self.below(16) {
            0 => self.flip(input),
            1 => self.byte(input),
            2 => self.insert(input),
            3 => self.delete(input),
            4 => self.duplicate(input),
            5 => self.splice(input, other),
            6 => self.transplant(input, other),
            7 | 8 => self.word(input),
            9..13 if text => self.number_word(input),
            13.. if text => self.line(input, other),
            9..15 => self.number_bytes(input),
            _ => self.flip(input),
        }
    }

    fn at(&mut self, input: &[u8]) -> Option<usize> {
        if input.is_empty() { None } else { Some(self.below(input.len())) }
    }

    /// A part of the input, usually a short one.
    fn part(&mut self, input: &[u8]) -> Range<usize> {
        let start = self.below(input.len());
        let left = input.len() - start;
        let most = if self.once_in(4) { left } else { left.min(16) };
        start..start + (1 + self.below(most)).min(left)
    }

    fn flip(&mut self, input: &mut [u8]) {
        if let Some(at) = self.at(input) {
            input[at] ^= 1 << self.below(8);
        }
    }

    fn byte(&mut self, input: &mut [u8]) {
        let Some(at) = self.at(input) else { return };
        input[at] = match self.below(3) {
            0 => INTERESTING[self.below(INTERESTING.len())],
            1 => input[at].wrapping_add(1 + self.below(16) as u8).wrapping_sub(8),
            _ => self.rng.next_u32() as u8,
        };
    }

    fn insert(&mut self, input: &mut Vec<u8>) {
        let at = self.below(input.len() + 1);
        let count = 1 + self.below(8);
        let interesting = self.once_in(2);
        let bytes: Vec<u8> = (0..count)
            .map(|_| if interesting { INTERESTING[self.below(INTERESTING.len())] } else { self.rng.next_u32() as u8 })
            .collect();
        input.splice(at..at, bytes);
    }

    fn delete(&mut self, input: &mut Vec<u8>) {
        let part = self.part(input);
        input.drain(part);
    }

    fn duplicate(&mut self, input: &mut Vec<u8>) {
        let part = self.part(input);
        let copy = input[part].to_vec();
        let at = self.below(input.len() + 1);
        input.splice(at..at, copy);
    }

    /// Joins the beginning of this input and the end of the other.
    fn splice(&mut self, input: &mut Vec<u8>, other: &[u8]) {
        input.truncate(self.below(input.len() + 1));
        input.extend_from_slice(&other[self.below(other.len() + 1)..]);
    }

    /// Inserts a part of the other input, or replaces a part of this one with it.
    fn transplant(&mut self, input: &mut Vec<u8>, other: &[u8]) {
        let taken = self.part(other);
        let place = if self.once_in(2) {
            let at = self.below(input.len() + 1);
            at..at
        } else {
            self.part(input)
        };
        input.splice(place, other[taken].iter().copied());
    }

    fn word(&mut self, input: &mut Vec<u8>) {
        if self.words.is_empty() {
            return self.byte(input);
        }
        let number = self.below(self.words.len());
        let word = self.words[number].clone();
        let at = self.below(input.len() + 1);
        let over = if self.once_in(2) { (at + word.len()).min(input.len()) } else { at };
        input.splice(at..over, word);
    }

    /// Changes the length, up to both limits.
    fn stretch(&mut self, input: &mut Vec<u8>) {
        match self.below(4) {
            0 => input.clear(),
            1 => input.truncate(self.below(input.len() + 1)),
            _ if !input.is_empty() => {
                let part = self.part(input);
                let piece = input[part.clone()].to_vec();
                let most = self.longest.saturating_sub(input.len()) / piece.len();
                // Rarely to the limit: such an input is slow.
                let times = if self.once_in(4) { most } else { most.min(self.below(64)) };
                input.splice(part.end..part.end, piece.repeat(times));
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_mutants_again_and_none_is_too_long() {
        let words = vec![b"G2".to_vec()];
        let make = |seed| {
            let mut mutator = Mutator::new(seed, words.clone(), 100);
            let mut input = b"G1 X1.5 Y2\nG0 X0\n".to_vec();
            let mut all = Vec::new();
            for _ in 0..20_000 {
                mutator.mutate(&mut input, b"F100\nG3 X1 I5\n");
                assert!(input.len() <= 100);
                all.push(input.clone());
            }
            all
        };
        let one = make(1);
        assert!(one == make(1) && one != make(2));
        let has = |what: &[u8]| one.iter().any(|input| input.windows(what.len()).any(|part| part == what));
        assert!(has(b"G2") && has(b"NaN") && has(b"1e308") && has(b"-0"));
        assert!(one.iter().any(Vec::is_empty) && one.iter().any(|input| input.len() == 100));
    }

    #[test]
    fn nothing_is_too_small_to_be_changed() {
        let mut mutator = Mutator::new(3, Vec::new(), 16);
        for _ in 0..20_000 {
            mutator.mutate(&mut Vec::new(), b"");
            mutator.mutate(&mut vec![0], b"\n");
        }
    }
}
