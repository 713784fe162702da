//! Readings that move against the motion sent, or by half or twice as much: what is found, when, and what is not.
//!
//! The drives here are independent of the simulator's: x' = k_ff v + K_v (q − x), some with play before the reading.

use super::*;
use crate::testing::noise::Noise;
use crate::testing::share::share;
use std::format;

/// One axis' drive.
#[derive(Clone, Copy)]
struct Follower {
    gain_per_s: f64,
    feed_forward: f64,
    play: f64,
    sent: f64,
    x: f64,
    /// Position behind the play.
    load: f64,
}

impl Follower {
    fn new(gain_per_s: f64, feed_forward: f64, at: f64) -> Self {
        Follower { gain_per_s, feed_forward, play: 0.0, sent: at, x: at, load: at }
    }

    fn cycle(&mut self, sent: f64) -> f64 {
        self.x += self.feed_forward * (sent - self.sent) + T * self.gain_per_s * (sent - self.x);
        self.sent = sent;
        self.load = self.load.clamp(self.x - 0.5 * self.play, self.x + 0.5 * self.play);
        self.load
    }
}

/// Distance after `t` from rest at an acceleration up to a speed.
fn way(t: f64, speed: f64, acceleration: f64) -> f64 {
    let rise = speed / acceleration;
    if t < rise { 0.5 * acceleration * t * t } else { speed * (t - 0.5 * rise) }
}

const START: f64 = 50.0;
/// Cycles after which a resting axis counts as such: more than 8 T of 0.125 s.
const RESTED: u32 = 10_300;

/// A bench with three equal drives that follow it.
struct Driven {
    bench: Bench,
    drives: [Follower; 3],
    /// Multiple of its motion that the reading of each axis shows.
    scale: [f64; 3],
    zero: [f64; 3],
}

impl Driven {
    /// At rest until the corrections stand.
    fn new(follower: Follower) -> Self {
        let (bench, drives) = (Bench::new(), [follower; 3]);
        let mut driven = Driven { bench, drives, scale: [1.0; 3], zero: [START; 3] };
        driven.rest([START; 3], 1500);
        driven.zero = driven.drives.map(|drive| drive.load);
        driven
    }

    fn rest(&mut self, at: [f64; 3], cycles: u32) {
        for _ in 0..cycles {
            assert_eq!(self.cycle(at, |_| ()).record.fault, Fault::None);
        }
    }

    fn cycle(&mut self, command: [f64; 3], change: impl Fn(&mut Input<f64, 3>)) -> Out {
        let feedback = std::array::from_fn(|k| self.zero[k] + self.scale[k] * (self.drives[k].load - self.zero[k]));
        let mut input = Input { feedback, ..input(command) };
        change(&mut input);
        let out = self.bench.cycle(&input);
        for (drive, sent) in self.drives.iter_mut().zip(out.drive) {
            drive.cycle(sent);
        }
        out
    }
}

#[test]
fn a_wrong_sign_and_a_wrong_scale_are_found_within_the_first_millimetre() {
    let drives = [(110.0, 0.93), (60.0, 0.9), (35.0, 0.9), (110.0, 1.0)];
    for ((gain, feed_forward), (speed, acceleration)) in drives
        .into_iter()
        .flat_map(|drive| [(1.0, 1000.0), (25.0, 800.0), (25.0, 5000.0), (60.0, 5000.0)].map(|feed| (drive, feed)))
    {
        for (scale, most) in [(-1.0, 0.4), (-0.5, 0.6), (0.5, 1.0), (2.0, 0.5), (4.0, 0.4)] {
            for (axis, direction) in [(0, 1.0), (1, -1.0), (2, 1.0)] {
                let mut driven = Driven::new(Follower::new(gain, feed_forward, START));
                driven.scale[axis] = scale;
                let correction = driven.bench.correction;
                let (mut found, mut t) = (None, 0.0);
                while found.is_none_or(|found| way(t, speed, acceleration) < found + 1.0) {
                    t += T;
                    let moved = way(t, speed, acceleration);
                    let mut command = [START; 3];
                    command[axis] += direction * moved;
                    let out = driven.cycle(command, |_| ());
                    let at = found;
                    let case =
                        || format!("{gain}/s {feed_forward}, {speed} mm/s, x{scale}, axis {axis}: {at:?} {moved}");
                    if out.record.fault == Fault::FeedbackRatio {
                        assert_eq!(usize::from(out.record.fault_axis), axis, "{}", case());
                        assert!(out.record.status.has(Status::FROZEN) && !out.stop_requested(), "{}", case());
                        found = found.or(Some(moved));
                    }
                    assert!(found.is_some() || moved < most, "{}", case());
                    // From then on, in every cycle: frozen, with the reading passed on.
                    assert_eq!(found.is_some(), out.record.fault == Fault::FeedbackRatio, "{}", case());
                    assert!(found.is_none() || (out.record.correction[axis] - correction[axis]).abs() < 2e-3);
                }
                assert!(found.is_some_and(|found| found > 0.05), "{found:?}");
            }
        }
    }
}

/// Random moves and stops of one axis, from rest to rest.
fn moves(random: &mut Noise, mut cycle: impl FnMut(f64)) {
    let mut at = START;
    for _ in 0..12 {
        let distance = 0.05 * (800.0_f64).powf(random.unit());
        // Fast enough to take no longer than half a second.
        let speed = (2.0 * distance).max(0.5 * (1000.0_f64).powf(random.unit()));
        let acceleration = (16.0 * distance).max(100.0 * (200.0_f64).powf(random.unit()));
        let direction = if at > START + 20.0 || (at > START - 20.0 && random.below(2) == 0) { -1.0 } else { 1.0 };
        let rise = (speed / acceleration).min((distance / acceleration).sqrt());
        let top = acceleration * rise;
        let lasts = distance / top + rise;
        for k in 1..=(lasts / T) as u32 {
            let t = f64::from(k) * T;
            let moved = way(t, top, acceleration).min(distance - way((lasts - t).max(0.0), top, acceleration));
            let moved = if t < 0.5 * lasts { way(t, top, acceleration) } else { moved };
            cycle(at + direction * moved);
        }
        at += direction * distance;
        let dwell = [0, 30, 600, RESTED][random.below(4)];
        (0..dwell).for_each(|_| cycle(at));
    }
}

#[test]
fn lag_play_reversals_rapid_starts_and_missing_encoders_are_no_wrong_ratio() {
    let mut random = Noise::new(11);
    for round in 0..share(160) {
        // A stepper without encoder repeats its command; else drives from 10/s on, with and without feed-forward.
        let stepper = round % 8 == 0;
        let gain = 10.0 * (20.0_f64).powf(random.unit());
        let feed_forward = if round % 2 == 0 { 0.0 } else { 0.7 + 0.3 * random.unit() };
        let mut follower = Follower::new(gain, feed_forward, START);
        follower.play = 0.1 * random.unit();
        let mut driven = Driven::new(follower);
        let axis = round % 3;
        moves(&mut random, |x| {
            let mut command = [START; 3];
            command[axis] = x;
            let repeat =
                |input: &mut Input<f64, 3>| input.feedback = if stepper { input.command } else { input.feedback };
            let fault = driven.cycle(command, repeat).record.fault;
            // A slow drive's reading may stand still for `faults.stuck`.
            assert!(
                matches!(fault, Fault::None | Fault::EncoderStuck),
                "{round}: {gain}/s, {feed_forward}, {x}: {fault}"
            );
        });
    }
}

#[test]
fn an_axis_that_is_pushed_at_rest_has_no_wrong_ratio() {
    let mut driven = Driven::new(Follower::new(100.0, 0.9, START));
    for k in 0..400 {
        let push = |input: &mut Input<f64, 3>| input.feedback[1] += 0.01 * f64::from(k);
        assert_eq!(driven.cycle([START; 3], push).record.fault, Fault::None, "{k}");
    }
}

#[test]
fn a_wrong_ratio_stays_until_the_compensation_is_off_or_a_reset_arrives() {
    type Change = fn(&mut Input<f64, 3>);
    let off: Change = |input| input.enable = false;
    let unhomed: Change = |input| input.homed = false;
    let reset: Change = |input| input.reset = true;
    for release in [off, unhomed, reset] {
        let mut driven = Driven::new(Follower::new(110.0, 0.93, START));
        driven.scale[2] = -1.0;
        let mut x = START;
        let mut travel = |driven: &mut Driven, from: u32, to: u32| {
            let mut faults = Vec::new();
            for _ in from..to {
                x += 0.02;
                faults.push(driven.cycle([START, START, x], |_| ()).record.fault);
            }
            (x, faults)
        };
        let (_, faults) = travel(&mut driven, 0, 100);
        assert_eq!((faults[0], faults[99]), (Fault::None, Fault::FeedbackRatio));
        let at = [START, START, travel(&mut driven, 0, 1).0];
        for _ in 0..1500 {
            assert_eq!(driven.cycle(at, |_| ()).record.fault, Fault::FeedbackRatio);
        }
        // Another fault of the reading does not hide it for longer than it lasts.
        assert_eq!(driven.cycle(at, |input| input.encoder_alarm = 1).record.fault, Fault::EncoderAlarm);
        assert_eq!(driven.cycle(at, |_| ()).record.fault, Fault::FeedbackRatio);
        driven.cycle(at, release);
        driven.rest(at, RESTED);
        let (_, faults) = travel(&mut driven, 0, 100);
        let found = faults.iter().position(|fault| *fault == Fault::FeedbackRatio);
        assert!(found.is_some_and(|k| (8..25).contains(&k)), "{found:?}, {faults:?}");
    }
}
