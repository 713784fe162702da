//! Random numbers from a seed, identical on every target.

use trueaxis::Real;

/// Xorshift, 32 bit, with multiplied output.
#[derive(Clone, Debug)]
pub(super) struct Random(u32);

impl Random {
    /// Starts from the number of a course or a scene.
    pub(super) fn new(seed: u32) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9) | 1);
        for _ in 0..4 {
            random.bits();
        }
        random
    }

    fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0.wrapping_mul(0x85eb_ca6b)
    }

    /// 0 … `count` − 1.
    pub(super) fn below(&mut self, count: u32) -> u32 {
        ((u64::from(self.bits()) * u64::from(count)) >> 32) as u32
    }

    /// Uniform in 0 … 1.
    pub(super) fn unit<R: Real>(&mut self) -> R {
        R::of_i32((self.bits() >> 8) as i32) * R::of(1.0 / 16_777_216.0)
    }

    /// Uniform in −1 … 1.
    pub(super) fn signed<R: Real>(&mut self) -> R {
        R::TWO * self.unit::<R>() - R::ONE
    }

    /// Picks one of several.
    pub(super) fn one_of<T: Copy + Default>(&mut self, choices: &[T]) -> T {
        choices.get(self.below(choices.len() as u32) as usize).copied().unwrap_or_default()
    }
}
