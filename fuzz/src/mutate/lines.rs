//! Mutations of whole lines of a text.

use super::Mutator;
use std::ops::Range;

impl Mutator {
    /// Removes, duplicates or moves a line, or takes one from the other text.
    pub(super) fn line(&mut self, input: &mut Vec<u8>, other: &[u8]) {
        let lines = lines(input);
        if lines.is_empty() {
            return input.extend_from_slice(other);
        }
        let one = lines[self.below(lines.len())].clone();
        let to = lines[self.below(lines.len())].start;
        let copy = input[one.clone()].to_vec();
        match self.below(5) {
            0 => {
                input.drain(one);
            }
            1 => {
                input.splice(to..to, copy);
            }
            2 => {
                input.drain(one.clone());
                let to = if to > one.start { to - one.len() } else { to };
                input.splice(to..to, copy);
            }
            kind => {
                let others = self::lines(other);
                if others.is_empty() {
                    return;
                }
                let taken = others[self.below(others.len())].clone();
                let place = if kind == 3 { one } else { to..to };
                input.splice(place, other[taken].iter().copied());
            }
        }
    }
}

/// Every line including its line feed.
fn lines(text: &[u8]) -> Vec<Range<usize>> {
    let mut end = 0;
    text.split_inclusive(|byte| *byte == b'\n')
        .map(|line| {
            let start = end;
            end += line.len();
            start..end
        })
        .collect()
}
