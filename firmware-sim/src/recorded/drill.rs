//! Disturbances that a controller encounters, written over the recorded cycles.

use trueaxis::Nanometres;
use trueaxis_recording::RecordedCycle;
use trueaxis_sim::Scenario;

/// A fixed script, in cycles of the recording:
///
/// | cycles | |
/// |---|---|
/// | 0 to 19 | not homed |
/// | 20 to 39 | homed, not enabled |
/// | 60 | X is commanded twice as far away as a command may jump; reset 20 cycles later |
/// | 100 | Y is commanded beyond its travel; reset 20 cycles later |
/// | 140 to 149 | the encoder of Z has an alarm |
/// | 160 | X reads 5 mm too much |
/// | 170 to 173 | the cycle takes 2.5 periods |
/// | 200 to 239 | disabled, then enabled again |
/// | every 5000 | three readings of an axis missing, in motion; one late cycle 100 cycles on, one glitch after 200 |
///
/// The machine is at rest in the first of them, so that a stop can be reset near the held position.
#[derive(Clone, Debug)]
pub struct Drill {
    period_ns: u32,
    jump: i32,
    beyond: i32,
}

impl Drill {
    /// The drill for a scenario's machine and rate.
    pub fn new(scenario: &Scenario) -> Drill {
        let settings = &scenario.machine.settings;
        let fastest = settings.axes.iter().map(|a| a.max_feed_per_s).fold(0.0, f64::max);
        let highest = settings.axes.iter().map(|a| a.travel[1]).fold(0.0, f64::max);
        let factor = 2.0 * settings.faults.command_jump_factor;
        Drill {
            period_ns: scenario.period_ns(),
            jump: (factor * fastest * scenario.period_s() * 1e6) as i32,
            beyond: ((highest + 1.0) * 1e6) as i32,
        }
    }

    /// Disturbs cycle `number`.
    pub fn disturb(&self, number: u32, cycle: &mut RecordedCycle<3>) {
        cycle.homed = number >= 20;
        cycle.enable = number >= 40 && !(200..240).contains(&number);
        cycle.reset = matches!(number, 80 | 120);
        match number {
            60 => cycle.command[0].0 += self.jump,
            100 => cycle.command[1] = Nanometres(self.beyond),
            140..150 => cycle.encoder_alarm |= 4,
            160 => cycle.feedback[0].0 += 5_000_000,
            170..174 => cycle.elapsed_ns = self.period_ns / 2 * 5,
            _ => {}
        }
        let (round, within) = (number / 5000, number % 5000);
        let axis = (round % 3) as usize;
        match within {
            _ if round == 0 => {}
            0..3 => cycle.encoder_alarm |= 1 << axis,
            100 => cycle.elapsed_ns = self.period_ns / 2 * 5,
            200 => cycle.feedback[axis].0 += 5_000_000,
            _ => {}
        }
    }
}
