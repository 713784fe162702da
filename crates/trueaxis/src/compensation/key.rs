//! Keys that distinguish tables, so that a result cached for one is never used for another.

/// An order-dependent hash of words and numbers.
pub(super) struct Key(pub(super) u64);

impl Key {
    pub(super) fn add(&mut self, word: u64) {
        self.0 = mixed(self.0 ^ word);
    }

    pub(super) fn add_number(&mut self, number: f64) {
        self.add(number.to_bits());
    }

    pub(super) fn add_bytes(&mut self, bytes: &[u8]) {
        self.add(bytes.len() as u64);
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.add(u64::from_le_bytes(*word)));
        rest.iter().for_each(|byte| self.add(u64::from(*byte)));
    }

    pub(super) fn add_all<'x>(&mut self, numbers: impl IntoIterator<Item = &'x f64>) {
        numbers.into_iter().for_each(|number| self.add_number(*number));
    }
}

/// Mixes `x` so that every bit of the result depends on all its bits (one step of splitmix64).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// No two keys of single bits and of pairs of bits, in either order, are equal, and half of their bits differ.
    #[test]
    fn words_that_differ_in_a_bit_have_keys_that_differ_in_half() {
        let of = |words: [u64; 2]| {
            let mut key = Key(0);
            words.iter().for_each(|word| key.add(*word));
            key.0
        };
        let mut seen = HashSet::new();
        let (mut differ, mut pairs) = (0, 0);
        for a in 0..64 {
            for b in 0..64 {
                let (one, other) = (of([1 << a, 1 << b]), of([1 << a, (1 << b) ^ 1 << ((b + 17) % 64)]));
                assert!(seen.insert(one), "{a} {b}");
                differ += (one ^ other).count_ones();
                pairs += 1;
            }
        }
        let mean = f64::from(differ) / f64::from(pairs);
        assert!((mean - 32.0).abs() < 0.3, "{mean}");
        // The published first output of splitmix64 from 0.
        assert_eq!(mixed(0), 0xe220_a839_7b1d_cdaf);
    }
}
