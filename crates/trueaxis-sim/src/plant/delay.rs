//! Pure delay of commands.

use std::collections::VecDeque;

/// A delay line of whole and fractional cycles; linear between commands.
#[derive(Clone, Debug)]
pub struct Delay {
    /// Commands, the latest last.
    entered: VecDeque<f64>,
    cycles: f64,
}

impl Delay {
    /// Delays by `cycles`, 0 or more; all earlier commands were `position`.
    pub fn new(position: f64, cycles: f64) -> Delay {
        let cycles = cycles.max(0.0);
        Delay { entered: VecDeque::from(vec![position; cycles as usize + 2]), cycles }
    }

    /// The command that is due when `command` is entered.
    pub fn next(&mut self, command: f64) -> f64 {
        if self.cycles == 0.0 {
            return command;
        }
        self.entered.push_back(command);
        self.entered.pop_front();
        let newest = self.entered.len() - 1;
        let at = |age: usize| self.entered.get(newest.saturating_sub(age)).copied().unwrap_or(command);
        let (whole, part) = (self.cycles as usize, self.cycles.fract());
        if part == 0.0 { at(whole) } else { at(whole) + part * (at(whole + 1) - at(whole)) }
    }
}
