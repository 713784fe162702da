//! Watch on harm of the contour feedback: compares an oscillation of the contour error with K_p and without it.
//!
//! K_p reduces slow errors. Near a resonance of the mechanics it can only excite. With e a component of the contour error
//! and w = T/10 ms,
//!
//! ```text
//! m  <- m + w (e − m)      y = e − m       the part of e above 16 Hz
//! A   = mean of |y| over a half wave, or over a group: at least four half waves and 10 ms
//! ```
//!
//! A half wave exceeds the floor on its side and takes at most 25 ms. An oscillation is suspect if four half waves in a
//! row each exceed the last but one, on the same side, by 8 %, or three by 50 %, at a steady pace, or if A does not decay
//! over three groups. A disturbance from outside raises two half waves and then decays.
//!
//! A suspect oscillation starts a trial: K_p is taken out, while the integral continues. K_p did harm if the oscillation
//! ends or falls below 40 % from the second group on, or below 90 % in the fourth. For an oscillation that did not grow,
//! it must also lose more than the integral corrects: else the feedback helps more than it harms. K_p then returns over
//! 0.2 s, in which harm would show early and slowly. The third harm, each within 0.7 s of the one before, is a verdict:
//! the whole feedback is ramped out. An oscillation that stays has another cause; until the next trial of one that does
//! not grow, 0.5 s pass, then twice as long each time, unless A grows by half.
//!
//! Cost: 135 instructions a cycle on a Cortex-M4F, for three directions; nothing divides.

#![deny(clippy::indexing_slicing)]

use crate::machine::FeedbackSettings;
use crate::real::Real;

/// Floor of an oscillation, as a share of the level of the watch on oscillations.
const FLOOR: f64 = 1.0 / 32.0;
/// Time constant of the mean, s.
const MEAN_S: f64 = 0.01;
/// Longest half wave, s.
const LONGEST_S: f64 = 0.025;
/// Fewest half waves of a group, and its shortest time, s.
const GROUP: u8 = 4;
const SHORTEST_S: f64 = 0.01;
/// Half waves that rise in a row are enough if their weights sum to this. A rise has at least the first factor, a steep one the
/// second; a half wave has at least so many cycles.
const RISES: u8 = 12;
const RISE: u8 = 3;
const STEEP: u8 = 4;
const RISEN: f64 = 1.08;
const RISEN_STEEPLY: f64 = 1.5;
const FEWEST: u32 = 3;
/// Groups in a row that do not decay, and the factor of a decay.
const SUSTAINED: u8 = 2;
const DECAYED: f64 = 0.95;
/// Groups of a trial; what is left at its end, or earlier, if K_p does harm.
const TRIAL: u8 = 4;
const LESS: f64 = 0.9;
const FAR_LESS: f64 = 0.4;
/// Time over which K_p returns, s.
const RETURN_S: f64 = 0.2;
/// Harms that make a verdict, and the longest time between two, s.
const VERDICT: u8 = 3;
const AGAIN_S: f64 = 0.7;
/// First wait after a trial without harm, s; how often it doubles; growth that ends it.
const WAIT_S: f64 = 0.5;
const DOUBLINGS: u8 = 7;
const MORE: f64 = 1.5;

/// Sum of |y| over some cycles: two means are compared without a division.
#[derive(Clone, Copy, Debug, Default)]
struct Level<R> {
    sum: R,
    cycles: R,
}

impl<R: Real> Level<R> {
    fn plus(&self, more: &Self) -> Self {
        Level { sum: self.sum + more.sum, cycles: self.cycles + more.cycles }
    }

    fn is_none(&self) -> bool {
        self.cycles == R::ZERO
    }

    /// Whether the mean is less than `share` of another's.
    fn is_below(&self, share: f64, of: &Self) -> bool {
        self.sum * of.cycles < R::of(share) * of.sum * self.cycles
    }

    /// Whether the mean exceeds another's by more than `by`.
    fn exceeds(&self, other: &Self, by: R) -> bool {
        self.sum * other.cycles - other.sum * self.cycles > by * self.cycles * other.cycles
    }
}

/// Constants of the comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct Harm<R> {
    /// w.
    share: R,
    floor: R,
    /// Times in cycles.
    longest: u32,
    shortest: R,
    again: u32,
    wait: u32,
    /// Growth of the share of K_p per cycle.
    back: R,
}

/// Oscillation of one direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wave<R> {
    mean: R,
    /// Sum of |y| in the half wave so far.
    area: R,
    last: Level<R>,
    last_but_one: Level<R>,
    /// The group so far, its first half, the previous group.
    group: Level<R>,
    early: Level<R>,
    before: Level<R>,
    /// Side of the half wave: −1, 1; initially 0.
    side: i8,
    half_waves: u8,
    rises: u8,
    sustained: u8,
    /// Cycles of the half wave so far, and of the last one.
    since: u32,
    lasted: u32,
}

/// What a cycle shows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    Nothing,
    /// The oscillation has ended.
    Ended,
    /// A group has ended.
    Group,
    /// A group has ended, the third in a row without decay.
    Sustained,
    /// The half waves rise.
    Rising,
}

/// State of the comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial<R> {
    /// Share of K_p that acts.
    share: R,
    /// Groups since K_p is out, the one in progress included; 0 while it acts.
    groups: u8,
    /// Direction under trial.
    slot: u8,
    grew: bool,
    harms: u8,
    /// Trials without harm.
    acquittals: u8,
    /// The oscillation with K_p, and at the last trial without harm.
    with: Level<R>,
    acquitted: Level<R>,
    /// Cycles left of the wait, and in which a further harm counts.
    wait: u32,
    again: u32,
}

impl<R: Real> Trial<R> {
    pub(super) fn new() -> Self {
        let none = Level::default();
        Trial {
            share: R::ONE,
            groups: 0,
            slot: 0,
            grew: false,
            harms: 0,
            acquittals: 0,
            with: none,
            acquitted: none,
            wait: 0,
            again: 0,
        }
    }

    /// Share of K_p that acts, 0 … 1.
    #[inline(always)]
    pub(super) fn share(&self) -> R {
        self.share
    }
}

impl<R: Real> Harm<R> {
    pub(super) fn new(settings: &FeedbackSettings, period_s: f64) -> Self {
        let cycles = |time_s: f64| (time_s / period_s) as u32;
        Harm {
            share: R::of((period_s / MEAN_S).min(1.0)),
            floor: R::of(FLOOR * settings.watch_mm),
            longest: cycles(LONGEST_S),
            shortest: R::of(SHORTEST_S / period_s),
            again: cycles(AGAIN_S),
            wait: cycles(WAIT_S),
            back: R::of(period_s / RETURN_S),
        }
    }

    /// Whether the feedback is to be ramped out; `errors`: contour error, of a cycle in which it can be acted on.
    #[inline(always)]
    pub(super) fn is_found(
        &self,
        trial: &mut Trial<R>,
        waves: &mut [Wave<R>; 3],
        errors: [R; 3],
        integrals: &[R],
    ) -> bool {
        trial.wait = trial.wait.saturating_sub(1);
        trial.again = trial.again.saturating_sub(1);
        if trial.groups == 0 {
            trial.share = (trial.share + self.back).min(R::ONE);
        }
        let mut found = false;
        for (slot, ((wave, error), integral)) in waves.iter_mut().zip(errors).zip(integrals).enumerate() {
            let seen = self.see(wave, error);
            if seen != Seen::Nothing {
                found |= self.judge(trial, wave, slot as u8, seen, integral.abs());
            }
        }
        found
    }

    /// Follows the oscillation of one direction.
    #[inline(always)]
    fn see(&self, wave: &mut Wave<R>, error: R) -> Seen {
        let fast = error - wave.mean;
        wave.mean = wave.mean.add_product(self.share, fast);
        wave.since = wave.since.saturating_add(1);
        let size = fast.abs();
        wave.area += size;
        if size <= self.floor {
            if wave.since == self.longest {
                *wave = Wave { mean: wave.mean, since: wave.since, ..Wave::default() };
                return Seen::Ended;
            }
            return Seen::Nothing;
        }
        let side = if fast < R::ZERO { -1 } else { 1 };
        if side == wave.side { Seen::Nothing } else { self.turn(wave, side) }
    }

    /// Ends a half wave and begins the next.
    #[inline(never)]
    fn turn(&self, wave: &mut Wave<R>, side: i8) -> Seen {
        let cycles = wave.since;
        if wave.side == 0 || cycles >= self.longest {
            *wave = Wave { mean: wave.mean, side, ..Wave::default() };
            return Seen::Nothing;
        }
        let half = Level { sum: wave.area, cycles: R::of_i32(cycles as i32) };
        // Of the same side: a slow error that raises one side and lowers the other is no growth.
        let than = wave.last_but_one;
        let paced = 3 * cycles >= 2 * wave.lasted && 2 * cycles <= 3 * wave.lasted;
        let rises = paced && cycles >= FEWEST && !than.is_none() && than.is_below(1.0 / RISEN, &half);
        let weight = if than.is_below(1.0 / RISEN_STEEPLY, &half) { STEEP } else { RISE };
        wave.rises = if rises { wave.rises.saturating_add(weight) } else { 0 };
        wave.last_but_one = core::mem::replace(&mut wave.last, half);
        (wave.side, wave.lasted, wave.since, wave.area) = (side, cycles, 0, R::ZERO);
        self.group(wave, &half)
    }

    /// Adds a half wave to the group.
    fn group(&self, wave: &mut Wave<R>, half: &Level<R>) -> Seen {
        wave.group = wave.group.plus(half);
        wave.half_waves = wave.half_waves.saturating_add(1);
        let half_full = wave.half_waves >= GROUP / 2 && wave.group.cycles >= R::HALF * self.shortest;
        if wave.early.is_none() && half_full {
            wave.early = wave.group;
        }
        if wave.half_waves < GROUP || wave.group.cycles < self.shortest {
            return if wave.rises >= RISES { Seen::Rising } else { Seen::Nothing };
        }
        let group = core::mem::take(&mut wave.group);
        let early = core::mem::take(&mut wave.early);
        let before = core::mem::replace(&mut wave.before, group);
        wave.half_waves = 0;
        let decays = before.is_none() || group.is_below(DECAYED, &before) || group.is_below(DECAYED, &early);
        wave.sustained = if decays { 0 } else { wave.sustained.saturating_add(1) };
        if wave.rises >= RISES {
            Seen::Rising
        } else if wave.sustained >= SUSTAINED {
            Seen::Sustained
        } else {
            Seen::Group
        }
    }

    /// Begins, continues or ends a trial; `slow`: what the integral corrects. Returns whether it is the last one.
    #[inline(never)]
    fn judge(&self, trial: &mut Trial<R>, wave: &mut Wave<R>, slot: u8, seen: Seen, slow: R) -> bool {
        if trial.groups == 0 {
            self.begin(trial, wave, slot, seen);
            return false;
        }
        let in_group = seen == Seen::Rising && wave.half_waves != 0;
        if slot != trial.slot || in_group {
            return false;
        }
        let ended = seen == Seen::Ended;
        let left = if ended { Level { sum: R::ZERO, cycles: R::ONE } } else { wave.before };
        let at_end = trial.groups >= TRIAL;
        let share = if at_end { LESS } else { FAR_LESS };
        let less = ended || (trial.groups > 1 && left.is_below(share, &trial.with));
        if !less && !at_end {
            trial.groups += 1;
            return false;
        }
        trial.groups = 0;
        if less && (trial.grew || trial.with.exceeds(&left, slow)) {
            trial.harms = if trial.again == 0 { 1 } else { trial.harms.saturating_add(1) };
            trial.again = self.again;
            return trial.harms >= VERDICT;
        }
        (trial.acquitted, trial.again) = (trial.with, 0);
        trial.wait = self.wait << trial.acquittals.min(DOUBLINGS);
        trial.acquittals = trial.acquittals.saturating_add(1);
        false
    }

    /// Begins a trial of a suspect oscillation.
    fn begin(&self, trial: &mut Trial<R>, wave: &mut Wave<R>, slot: u8, seen: Seen) {
        let grew = seen == Seen::Rising;
        let with = if grew { wave.last } else { wave.before };
        let is_new = trial.wait == 0 || trial.acquitted.is_below(1.0 / MORE, &with);
        if grew || (seen == Seen::Sustained && is_new) {
            (trial.groups, trial.slot, trial.grew, trial.with) = (1, slot, grew, with);
            trial.share = R::ZERO;
            let Wave { mean, area, side, since, .. } = *wave;
            *wave = Wave { mean, area, side, since, ..Wave::default() };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    const T: f64 = 1e-4;

    /// An oscillation of amplitude A: A' = (growth · share of K_p − decay) A, by its own disturbance never below a
    /// tenth of a micrometre. Returns the time of the verdict, s, and the largest A, mm.
    fn oscillate(hz: f64, decay: f64, growth: f64) -> (Option<f64>, f64) {
        let harm = Harm::<f64>::new(&FeedbackSettings::default(), T);
        let (mut trial, mut waves) = (Trial::new(), [Wave::default(); 3]);
        let (mut size, mut largest) = (1e-4, 0.0_f64);
        for k in 0..30_000 {
            let t = f64::from(k) * T;
            size = f64::max(size * (1.0 + T * (growth * trial.share() - decay)), 1e-4);
            largest = largest.max(size);
            let error = size * (core::f64::consts::TAU * hz * t).sin();
            if harm.is_found(&mut trial, &mut waves, [0.0, error, 0.0], &[0.0; 3]) {
                return (Some(t), largest);
            }
        }
        (None, largest)
    }

    #[test]
    fn an_oscillation_that_k_p_makes_grow_is_found_while_it_is_small() {
        for hz in [30.0, 103.0, 120.0, 300.0] {
            for growth in [25.0, 60.0, 100.0] {
                let (found, largest) = oscillate(hz, 15.0, growth);
                let case = format!("{hz} Hz, {growth}/s: {found:?}, {largest} mm");
                assert!(found.is_some_and(|t| t < 2.5), "{case}");
                // Growth over the ten half waves that it takes to see it.
                assert!(largest < 8e-4 * (0.5 * 10.0 / hz * (growth - 15.0)).exp(), "{case}");
            }
        }
    }

    /// Verdict on an error over time, s, and whether K_p was ever out.
    fn verdict(seconds: f64, slow: f64, error: impl Fn(f64, f64) -> f64) -> (bool, bool) {
        let harm = Harm::<f64>::new(&FeedbackSettings::default(), T);
        let (mut trial, mut waves) = (Trial::new(), [Wave::default(); 3]);
        let (mut found, mut out) = (false, false);
        for k in 0..(seconds / T) as u32 {
            let e = error(f64::from(k) * T, trial.share());
            found |= harm.is_found(&mut trial, &mut waves, [e, 0.0, 0.0], &[slow; 3]);
            out |= trial.groups != 0;
        }
        (found, out)
    }

    fn sine(hz: f64, t: f64) -> f64 {
        (core::f64::consts::TAU * hz * t).sin()
    }

    #[test]
    fn an_oscillation_of_another_cause_is_no_harm() {
        for hz in [30.0, 80.0, 250.0, 900.0] {
            let chatter = |t: f64, _: f64| 0.009 * sine(hz, t);
            assert_eq!(verdict(5.0, 0.0, chatter), (false, true), "{hz} Hz");
        }
    }

    #[test]
    fn rings_that_decay_and_slow_errors_start_no_trial() {
        // Every quarter of a second a disturbance of 20 µm, then a ring of 5 % damping.
        let ring = |hz: f64| {
            move |t: f64, _: f64| {
                let t = t % 0.25;
                0.02 * (-0.05 * core::f64::consts::TAU * hz * t).exp() * sine(hz, t)
            }
        };
        for hz in [25.0, 60.0, 120.0, 300.0] {
            assert_eq!(verdict(2.0, 0.0, ring(hz)), (false, false), "{hz} Hz");
        }
        assert_eq!(verdict(2.0, 0.0, |t, _| 0.05 * sine(2.0, t)), (false, false));
        assert_eq!(verdict(2.0, 0.0, |t, _| 2e-4 * sine(100.0, t)), (false, false));
    }

    #[test]
    fn what_the_integral_corrects_outweighs_a_small_oscillation() {
        // A vibration from outside that K_p doubles.
        let doubled = |t: f64, share: f64| 0.002 * (1.0 + share) * sine(100.0, t);
        assert_eq!(verdict(3.0, 0.0, doubled), (true, true));
        assert_eq!(verdict(3.0, 0.01, doubled), (false, true));
    }
}
