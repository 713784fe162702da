//! The board's CMSDK timer 0 as an instruction counter.

use core::fmt;
use core::hint::black_box;

const TIMER: *mut u32 = 0x4000_0000 as *mut u32;

/// Starts the timer from its largest value, without reload interrupts.
pub fn start() {
    // SAFETY: registers of the board's timer 0: value, reload, control.
    unsafe {
        TIMER.add(2).write_volatile(u32::MAX);
        TIMER.add(1).write_volatile(u32::MAX);
        TIMER.write_volatile(1);
    }
}

/// Current value of the timer, which counts down.
#[inline(always)]
pub fn now() -> u32 {
    // SAFETY: the timer's value register.
    unsafe { TIMER.add(1).read_volatile() }
}

/// Instructions of one call, including the reading of the timer, and the returned value.
#[inline(never)]
pub fn timed<A>(function: fn(&A) -> u32, argument: &A) -> (u32, u32) {
    let function = black_box(function);
    let before = now();
    let result = function(black_box(argument));
    let ticks = before.wrapping_sub(now());
    (instructions(ticks), result)
}

/// Converts ticks, 3.2 per instruction, with rounding.
pub fn instructions(ticks: u32) -> u32 {
    ((u64::from(ticks) * 40 + 64) >> 7) as u32
}

/// Smallest, largest and mean of some counts.
pub struct Tally {
    count: u32,
    sum: u64,
    least: u32,
    most: u32,
}

impl Default for Tally {
    fn default() -> Self {
        Tally { count: 0, sum: 0, least: u32::MAX, most: 0 }
    }
}

impl Tally {
    /// Adds a count.
    pub fn add(&mut self, instructions: u32) {
        self.count += 1;
        self.sum += u64::from(instructions);
        self.least = self.least.min(instructions);
        self.most = self.most.max(instructions);
    }

    /// Number of counts.
    pub fn count(&self) -> u32 {
        self.count
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tenths = self.sum * 10 / u64::from(self.count.max(1));
        write!(f, "worst {} mean {}.{} calls {} sum {}", self.most, tenths / 10, tenths % 10, self.count, self.sum)
    }
}
