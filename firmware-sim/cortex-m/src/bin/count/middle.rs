//! Median of many counts.

use crate::arena::Arena;

/// Larger counts are clamped to this value.
const LARGEST: usize = 1 << 14;

/// Frequency of each count, and the first cycle in which it occurred.
pub struct Middle {
    times: &'static mut [u32],
    first: &'static mut [u32],
}

impl Middle {
    pub fn new(arena: &mut Arena) -> Self {
        Middle { times: arena.slice(LARGEST, 0), first: arena.slice(LARGEST, u32::MAX) }
    }

    pub fn add(&mut self, count: u32, cycle: u32) {
        let count = (count as usize).min(LARGEST - 1);
        self.times[count] += 1;
        self.first[count] = self.first[count].min(cycle);
    }

    pub fn value(&self) -> usize {
        let half = self.times.iter().sum::<u32>() / 2;
        let mut below = 0;
        self.times
            .iter()
            .position(|count| {
                below += count;
                below > half
            })
            .unwrap_or(0)
    }

    /// The first cycle whose count was the median.
    pub fn first(&self) -> u32 {
        self.first[self.value()]
    }
}
