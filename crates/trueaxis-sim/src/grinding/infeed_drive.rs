//! The infeed axis: what it is told, a while later.

use std::collections::VecDeque;

/// A drive that follows its command after a pure delay and a first-order lag; for slow motion both add to the delay.
#[derive(Clone, Debug)]
pub struct InfeedDrive {
    /// Commands, the latest last.
    told: VecDeque<f64>,
    /// Delay in cycles, at least 1.
    delay: f64,
    /// Share of the way that the lag lets pass in a cycle.
    share: f64,
    position: f64,
}

impl InfeedDrive {
    /// At rest at `position` (mm); a delay below one period is one period.
    pub fn new(position: f64, delay_s: f64, lag_s: f64, period_s: f64) -> InfeedDrive {
        let delay = (delay_s / period_s).max(1.0);
        let share = if lag_s > 0.0 { -(-period_s / lag_s).exp_m1() } else { 1.0 };
        InfeedDrive { told: VecDeque::from(vec![position; delay as usize + 2]), delay, share, position }
    }

    /// Position, mm.
    pub fn position(&self) -> f64 {
        self.position
    }

    /// One servo period: `command` is given at its beginning; returns the position at its end.
    pub fn cycle(&mut self, command: f64) -> f64 {
        self.told.push_back(command);
        self.told.pop_front();
        // At the end of the period the latest command is one period old.
        let back = self.delay - 1.0;
        let newest = self.told.len() - 1;
        let at = |age: usize| self.told.get(newest.saturating_sub(age)).copied().unwrap_or(self.position);
        let (whole, part) = (back as usize, back.fract());
        let due = at(whole) + part * (at(whole + 1) - at(whole));
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
            // 100 mm/s, told up to 9.99 mm at 99.9 ms, now it is 100 ms. A lag in steps takes effect from a step's
            // beginning on.
            let delay = f64::max(delay_s, 1e-4) + if lag_s > 0.0 { lag_s - 0.5e-4 } else { 0.0 };
            let expected = 5.0 + 100.0 * (0.1 - delay);
            assert!((position - expected).abs() < 1e-3, "{position} {expected}");
        }
    }
}
