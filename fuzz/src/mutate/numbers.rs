//! Numbers at which readers and formulas fail.

use super::Mutator;
use rand_chacha::rand_core::RngCore;
use std::ops::Range;

/// Numbers as text.
const WORDS: [&str; 40] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-3",
    "1e-9",
    "1e-300",
    "4.9e-324",
    "1e308",
    "-1e308",
    "1.8e308",
    "1e999",
    "-1e999",
    "NaN",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "Infinity",
    "255",
    "256",
    "65535",
    "65536",
    "1000000",
    "1000001",
    "2147483647",
    "-2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "99999999999999999999999999",
    "1e9",
    "999999999.999",
    "360",
    "0.1000000000000000055511151231257827",
    "1,5",
];

/// Numbers as binary doubles.
const DOUBLES: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-9,
    1e9,
    1e308,
    -1e308,
    5e-324,
    f64::EPSILON,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    360.0,
];
const INTEGERS: [u64; 12] =
    [0, 1, 2, 6, 0x7f, 0x80, 0xff, 0xffff, 0x7fff_ffff, 0xffff_ffff, 0x7fff_ffff_ffff_ffff, u64::MAX];

impl Mutator {
    /// Replaces a number in the text.
    pub(super) fn number_word(&mut self, input: &mut Vec<u8>) {
        let from = self.below(input.len() + 1);
        let Some(found) = number(input, from).or_else(|| number(input, 0)) else { return self.insert(input) };
        match self.below(4) {
            0 | 1 => {
                let word = WORDS[self.below(WORDS.len())];
                input.splice(found, word.bytes());
            }
            2 => {
                let at = found.start + self.below(found.len());
                input[at] = b"0123456789-.e"[self.below(13)];
            }
            _ => {
                let text = std::str::from_utf8(&input[found.clone()]).ok();
                let Some(number) = text.and_then(|text| text.parse::<f64>().ok()) else { return };
                let changed = match self.below(6) {
                    0 => -number,
                    1 => number * 1e3,
                    2 => number * 1e-3,
                    3 => number + 1.0,
                    4 => number.next_up(),
                    _ => number * (2.0 * self.below(1 << 20) as f64 / f64::from(1 << 20)),
                };
                input.splice(found, changed.to_string().into_bytes());
            }
        }
    }

    /// Replaces 1, 2, 4 or 8 bytes with a little-endian number.
    pub(super) fn number_bytes(&mut self, input: &mut [u8]) {
        let width = [1, 2, 4, 8, 8, 8][self.below(6)];
        if input.len() < width {
            return self.flip(input);
        }
        let at = self.below(input.len() - width + 1);
        let bytes = match self.below(4) {
            0 => self.rng.next_u64().to_le_bytes(),
            1 => INTEGERS[self.below(INTEGERS.len())].to_le_bytes(),
            2 => DOUBLES[self.below(DOUBLES.len())].to_le_bytes(),
            _ => {
                let mut bytes = [0; 8];
                bytes[..width].copy_from_slice(&input[at..at + width]);
                if width == 8 && self.once_in(2) {
                    (f64::from_le_bytes(bytes) * [-1.0, 0.5, 2.0, 1e-6, 1e6][self.below(5)]).to_le_bytes()
                } else {
                    (u64::from_le_bytes(bytes)).wrapping_add(self.below(33) as u64).wrapping_sub(16).to_le_bytes()
                }
            }
        };
        input[at..at + width].copy_from_slice(&bytes[..width]);
    }
}

/// The first number at or after `from`.
fn number(input: &[u8], from: usize) -> Option<Range<usize>> {
    let start = from + input.get(from..)?.iter().position(u8::is_ascii_digit)?;
    let begin = start - usize::from(start > from && input[start - 1] == b'-');
    let mut end = start;
    while let Some(byte) = input.get(end) {
        let exponent = matches!(byte, b'e' | b'E')
            && input.get(end + 1).is_some_and(|next| next.is_ascii_digit() || *next == b'-');
        let sign = *byte == b'-' && matches!(input[end - 1], b'e' | b'E');
        if !(byte.is_ascii_digit() || *byte == b'.' || exponent || sign) {
            break;
        }
        end += 1;
    }
    Some(begin..end)
}

#[test]
fn a_number_is_found_with_sign_and_exponent() {
    for (text, found) in [("X-1.5e-3,", "-1.5e-3"), ("a=7 8", "7"), ("G1", "1"), ("9end", "9"), ("-4", "-4")] {
        assert_eq!(&text[number(text.as_bytes(), 0).unwrap()], found);
    }
    assert_eq!(number(b"none", 0), None);
    assert_eq!(number(b"1", 1), None);
}
