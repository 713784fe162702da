//! The infeed axis, which follows its commands with delay and lag.

use crate::plant::delay::Delay;

/// A drive that follows its command after a pure delay and a first-order lag; for slow motion both add to the delay.
#[derive(Clone, Debug)]
pub struct InfeedDrive {
    delay: Delay,
    /// Share of the remaining distance that the axis moves in a cycle.
    share: f64,
    position: f64,
}

impl InfeedDrive {
    /// A drive at rest at `position` (mm). A delay below one period counts as one period.
    pub fn new(position: f64, delay_s: f64, lag_s: f64, period_s: f64) -> InfeedDrive {
        let delay = (delay_s / period_s).max(1.0);
        let share = if lag_s > 0.0 { -libm::expm1(-period_s / lag_s) } else { 1.0 };
        // At the end of the period the latest command is one period old.
        InfeedDrive { delay: Delay::new(position, delay - 1.0), share, position }
    }

    /// Position, mm.
    pub fn position(&self) -> f64 {
        self.position
    }

    /// Simulates one servo period: takes the command of its beginning and returns the position at its end.
    pub fn cycle(&mut self, command: f64) -> f64 {
        let due = self.delay.next(command);
        self.position += self.share * (due - self.position);
        self.position
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_followed_after_delay_and_lag() {
        for (delay_s, lag_s) in [(0.002, 0.0005), (0.001_23, 0.0), (0.0, 0.0)] {
            let mut drive = InfeedDrive::new(5.0, delay_s, lag_s, 1e-4);
            let mut position = 5.0;
            for i in 0..1000 {
                position = drive.cycle(5.0 + 0.01 * f64::from(i));
            }
            // 100 mm/s, commanded up to 9.99 mm at 99.9 ms; it is now 100 ms. A lag in steps takes effect from the beginning
            // of a step.
            let delay = f64::max(delay_s, 1e-4) + if lag_s > 0.0 { lag_s - 0.5e-4 } else { 0.0 };
            let expected = 5.0 + 100.0 * (0.1 - delay);
            assert!((position - expected).abs() < 1e-3, "{position} {expected}");
        }
    }
}
