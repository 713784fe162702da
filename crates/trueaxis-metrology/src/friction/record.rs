//! A record of two axes: its validation, and its reversals.

use super::refused::FrictionRefusal;
use std::format;
use std::vec::Vec;
use trueaxis::Axis;

/// Least number of samples: two circles of a second at 1 kHz.
const FEWEST: usize = 2000;
/// A time stamp may be off by this share of a period.
const JITTER: f64 = 0.1;
/// Least number of reversals of an axis.
const FEWEST_REVERSALS: usize = 4;
/// Speed at which an axis counts as moving, as a share of its fastest.
const MOVING: f64 = 0.01;
/// Largest ratio of the accelerations of circles that count as one size.
const ONE_SIZE: f64 = 1.5;
/// Least speed of the other axis at a reversal, as a share of its fastest: below it, the motion is a stop.
const PASSING: f64 = 0.05;
/// The path speed counts as even within this share, over this time, s; the third value is the settling time after a change, s.
const EVEN: f64 = 0.01;
const EVEN_OVER_S: f64 = 0.02;
const SETTLED_S: f64 = 0.1;
/// An axis counts as at rest if it moves at less than this share of its fastest speed for this time, s.
const RESTING: f64 = 1e-4;
const RESTING_S: f64 = 0.01;

/// One axis of a record: commanded positions and encoder readings at the same times, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// The axis.
    pub axis: Axis,
    /// Positions sent to the drive, mm.
    pub command: Vec<f64>,
    /// Readings of the encoder, mm.
    pub reading: Vec<f64>,
}

/// Two axes on circles, sampled evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time between two samples, s.
    pub period_s: f64,
    /// The axes of the plane of the circles.
    pub axes: [Recorded; 2],
    /// Time from the moment at which a row's command takes effect to the encoder's reading, s; negative if it is read before.
    /// `None` if unknown. With stated figures of the drive, the fit determines this time and ignores the value.
    pub read_after_s: Option<f64>,
}

/// Reversal of an axis in motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reversal {
    /// Nearest sample.
    pub(super) index: usize,
    /// Acceleration, mm/s²; positive from negative to positive travel.
    pub(super) acceleration: f64,
    /// Whether the circle was travelled counterclockwise in the plane of first and second axis.
    pub(super) counterclockwise: bool,
}

impl Record {
    /// Checks the time stamps and combines them with the axes.
    ///
    /// # Errors
    /// Too few samples; stamps that are uneven by more than a tenth of a period; a period outside 10 µs to 2 ms.
    pub fn new(times_s: &[f64], axes: [Recorded; 2]) -> Result<Record, FrictionRefusal> {
        let count =
            axes.iter().flat_map(|axis| [axis.command.len(), axis.reading.len()]).fold(times_s.len(), usize::min);
        if count < FEWEST {
            return Err(FrictionRefusal::TooFewSamples { found: count, needed: FEWEST });
        }
        let mut steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = steps.len() / 2;
        let period_s = *steps.clone().select_nth_unstable_by(middle, f64::total_cmp).1;
        if !(1e-5..=2e-3).contains(&period_s) {
            return Err(FrictionRefusal::Period { found_s: period_s });
        }
        // Stamps are often rounded: the mean over the record is more accurate.
        let mean = (times_s[count - 1] - times_s[0]) / (count - 1) as f64;
        if let Some(index) = steps.iter().position(|step| (step - period_s).abs() > JITTER * period_s) {
            return Err(FrictionRefusal::Uneven { index, found_s: steps.swap_remove(index), period_s });
        }
        Ok(Record { period_s: mean, axes, read_after_s: None })
    }

    /// Reversals of both axes, after all checks that need no fit.
    pub(super) fn reversals(&self) -> Result<[Vec<Reversal>; 2], FrictionRefusal> {
        let [first, second] = &self.axes;
        for axis in [first, second] {
            self.check_units(axis)?;
        }
        let found = [self.turns(first, second, 1.0), self.turns(second, first, -1.0)];
        for (axis, turns) in [first, second].into_iter().zip(&found) {
            check_circles(axis.axis, turns)?;
        }
        Ok(found)
    }

    fn check_units(&self, recorded: &Recorded) -> Result<(), FrictionRefusal> {
        let axis = recorded.axis;
        let refuse = |found, needed| Err(FrictionRefusal::Unit { axis, found, needed });
        let travel = |values: &[f64]| {
            let [low, high] = values.iter().fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(*v), high.max(*v)]);
            high - low
        };
        let [sent, read] = [travel(&recorded.command), travel(&recorded.reading)];
        if !(0.5..=20_000.0).contains(&sent) {
            return refuse(format!("commands over {sent} mm"), "0.5 to 20000 mm: positions in mm");
        }
        let ratio = read / sent;
        if !(0.9..=1.1).contains(&ratio) {
            let found = format!("readings over {read} mm with commands over {sent} mm");
            return refuse(found, "the same within a tenth: both in mm, of the same axis");
        }
        let fastest = self.fastest(recorded);
        if fastest > 2000.0 {
            return refuse(
                format!("commands at up to {fastest:.0} mm/s"),
                "at most 2000 mm/s: t_s in s, positions in mm",
            );
        }
        let pairs = || recorded.command.iter().zip(&recorded.reading).map(|(command, reading)| command - reading);
        let mean = pairs().sum::<f64>() / recorded.command.len() as f64;
        let largest = pairs().fold(0.0, |top: f64, error| top.max((error - mean).abs()));
        if largest == 0.0 {
            return refuse("readings that equal the commands".into(), "readings of the encoder");
        }
        if largest > 0.1 * sent {
            let found = format!("a following error of up to {largest:.3} mm on circles of {sent:.3} mm");
            return refuse(found, "at most a tenth of them: both in mm, sampled at the same time");
        }
        Ok(())
    }

    fn velocities<'r>(&'r self, recorded: &'r Recorded) -> impl Iterator<Item = f64> + 'r {
        recorded.command.windows(2).map(|pair| (pair[1] - pair[0]) / self.period_s)
    }

    /// Sign changes of the commanded velocity while the other axis keeps moving; `sense` is −1 for the second axis of the
    /// plane.
    fn turns(&self, recorded: &Recorded, other: &Recorded, sense: f64) -> Vec<Reversal> {
        let moving = MOVING * self.fastest(recorded);
        let passing = PASSING * self.fastest(other);
        let mut last: Option<(usize, f64)> = None;
        let mut turns = Vec::new();
        for (k, velocity) in self.velocities(recorded).enumerate() {
            if velocity.abs() <= moving {
                continue;
            }
            if let Some((left, before)) = last
                && velocity * before < 0.0
            {
                let aside = (other.command[k + 1] - other.command[left]) / (self.period_s * (k + 1 - left) as f64);
                if aside.abs() >= passing {
                    // Linear between the samples at which the axis fell below its speed threshold and exceeded it again.
                    let share = -before / (velocity - before);
                    let index = left + (share * (k - left) as f64).round() as usize;
                    let acceleration = (velocity - before) / (self.period_s * (k - left) as f64);
                    turns.push(Reversal { index, acceleration, counterclockwise: aside * acceleration * sense < 0.0 });
                }
            }
            last = Some((k, velocity));
        }
        turns
    }

    /// Samples at which the path speed equals that at the nearest reversal, and has done so for a while: no start, no stop, no
    /// change of feed.
    pub(super) fn even(&self, turns: &[Reversal]) -> Vec<bool> {
        let [first, second] = &self.axes;
        let count = first.command.len();
        let half = ((EVEN_OVER_S / 2.0 / self.period_s) as usize).max(1);
        let speed = |k: usize| {
            let [from, to] = [k.saturating_sub(half), (k + half).min(count - 1)];
            let way = |axis: &Recorded| axis.command[to] - axis.command[from];
            way(first).hypot(way(second)) / (self.period_s * (to - from) as f64)
        };
        let settling = (SETTLED_S / self.period_s) as usize;
        let mut even = Vec::with_capacity(count);
        let [mut next, mut since] = [0, 0];
        for k in 0..count {
            while next + 1 < turns.len() && turns[next].index.abs_diff(k) > turns[next + 1].index.abs_diff(k) {
                next += 1;
            }
            let nominal = turns.get(next).map_or(0.0, |turn| speed(turn.index));
            since = if (speed(k) - nominal).abs() <= EVEN * nominal { since + 1 } else { 0 };
            even.push(since > settling);
        }
        even
    }

    fn fastest(&self, recorded: &Recorded) -> f64 {
        self.velocities(recorded).fold(0.0, |top: f64, v| top.max(v.abs()))
    }

    /// Whether the axis is at rest during the record's first samples.
    pub(super) fn rests(&self, recorded: &Recorded) -> bool {
        let few = (RESTING_S / self.period_s).ceil() as usize;
        let still = RESTING * self.fastest(recorded);
        self.velocities(recorded).take(few).all(|velocity| velocity.abs() <= still)
    }
}

fn check_circles(axis: Axis, turns: &[Reversal]) -> Result<(), FrictionRefusal> {
    if turns.len() < FEWEST_REVERSALS {
        return Err(FrictionRefusal::Reversals { axis, found: turns.len(), needed: FEWEST_REVERSALS });
    }
    let counterclockwise = turns.iter().filter(|turn| turn.counterclockwise).count();
    let clockwise = turns.len() - counterclockwise;
    if clockwise < 2 || counterclockwise < 2 {
        return Err(FrictionRefusal::OneDirection { axis, clockwise, counterclockwise });
    }
    let sizes = turns.iter().map(|turn| turn.acceleration.abs());
    let [low, high] = sizes.fold([f64::MAX, 0.0], |[low, high]: [f64; 2], a| [low.min(a), high.max(a)]);
    if high < ONE_SIZE * low {
        return Err(FrictionRefusal::OneSize { axis, low_mm_per_s2: low, high_mm_per_s2: high });
    }
    Ok(())
}
