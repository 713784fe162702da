//! Watch on the harm of the contour feedback: an oscillation of the contour error is compared with and without it.
//!
//! The feedback corrects slow errors; near a resonance it can only add. With e a component of the contour error,
//!
//! ```text
//! m  <- m + w (e − m)      y = e − m       what varies faster than 16 Hz
//! A   = mean of |y| over four half waves, each above the floor and no longer than 25 ms
//! ```
//!
//! An oscillation whose A grows by a fifth, or does not decay over three such groups, is suspect. The feedback is then held
//! out (its integral stays): from the second group on, A without the feedback is compared with A before. If it is less by
//! a tenth, or the oscillation ends, the feedback is to blame; it is tried once more, and the second time within two
//! seconds it is ramped out for good. If A stays for four groups, its cause is elsewhere: the feedback returns, and
//! the next trial waits twice as long as the last, unless A grows by half.

#![deny(clippy::indexing_slicing)]

use crate::machine::FeedbackSettings;
use crate::real::Real;

/// Floor of an oscillation as a share of the watch's level.
const FLOOR: f64 = 1.0 / 32.0;
/// Time constant of the mean, s.
const MEAN_S: f64 = 0.01;
/// Longest half wave, s.
const LONGEST_S: f64 = 0.025;
/// Half waves of a group, and its shortest time, s.
const GROUP: u8 = 4;
const SHORTEST_S: f64 = 0.01;
/// Half waves in a row that grow by the factor, each of at least so many cycles.
const RISES: u8 = 4;
const RISEN: f64 = 1.08;
const FEWEST: u32 = 3;
/// Comparisons of groups in a row without decay that make an oscillation suspect, and the factor of a decay.
const SUSTAINED: u8 = 2;
const DECAYED: f64 = 0.95;
/// Less without the feedback; far less; more than acquitted.
const LESS: f64 = 0.9;
const FAR_LESS: f64 = 0.4;
const MORE: f64 = 1.5;
/// Groups of a trial.
const TRIAL: u8 = 4;
/// Time within which a second verdict is final, s.
const AGAIN_S: f64 = 0.7;
/// Time over which K_p returns, s.
const RETURN_S: f64 = 0.2;
/// First wait after an acquittal, s, and how often it doubles.
const WAIT_S: f64 = 0.5;
const DOUBLINGS: u8 = 7;

/// A sum of |y| and its number of cycles.
#[derive(Clone, Copy, Debug, Default)]
struct Level<R> {
    sum: R,
    cycles: R,
}

impl<R: Real> Level<R> {
    #[inline(always)]
    fn plus(&self, more: &Self) -> Self {
        Level { sum: self.sum + more.sum, cycles: self.cycles + more.cycles }
    }

    /// Whether the mean is larger than another's by more than `by`.
    #[inline(always)]
    fn exceeds(&self, other: &Self, by: R) -> bool {
        self.sum * other.cycles - other.sum * self.cycles > by * self.cycles * other.cycles
    }

    /// Whether the mean is less than `share` of another's.
    #[inline(always)]
    fn is_below(&self, share: R, of: &Self) -> bool {
        self.sum * of.cycles < share * of.sum * self.cycles
    }
}

/// Constants.
#[derive(Clone, Copy, Debug)]
pub(super) struct Harm<R> {
    /// Share w of the mean.
    share: R,
    floor: R,
    /// Cycles.
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
    /// Sum of |y| in the half wave.
    area: R,
    /// The last half wave and its cycles, the group so far, its first half, and the previous group.
    last: Level<R>,
    last_but_one: Level<R>,
    group: Level<R>,
    early: Level<R>,
    before: Level<R>,
    /// Side of the half wave: −1, 1; initially 0.
    side: i8,
    half_waves: u8,
    lasted: u32,
    rises: u8,
    sustained: u8,
    /// Cycles since the half wave began.
    since: u32,
}

/// What a half wave says.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    Nothing,
    /// The oscillation has ended.
    Ended,
    /// A group has ended.
    Group,
    /// A group has ended that does not decay.
    Sustained,
    /// The half waves grow.
    Growing,
}

/// State of the comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial<R> {
    /// Groups since the feedback is held out; 0 while it acts.
    groups: u8,
    /// Share of K_p that acts.
    share: R,
    /// Direction that is judged, its level with the feedback, and whether it grew.
    slot: u8,
    grew: bool,
    with: Level<R>,
    /// Level at the last acquittal, the number of acquittals.
    acquitted: Level<R>,
    acquittals: u8,
    /// Cycles left: until the next trial, in which a further verdict is final.
    wait: u32,
    again: u32,
}

impl<R: Real> Trial<R> {
    pub(super) fn new() -> Self {
        let none = Level::default();
        Trial {
            groups: 0,
            share: R::ONE,
            slot: 0,
            grew: false,
            with: none,
            acquitted: none,
            acquittals: 0,
            wait: 0,
            again: 0,
        }
    }

    /// Share of K_p that acts.
    #[inline(always)]
    pub(super) fn share(&self) -> R {
        self.share
    }

    /// Whether the feedback is held out.
    #[inline(always)]
    pub(super) fn holds_out(&self) -> bool {
        self.groups != 0
    }
}

impl<R: Real> Harm<R> {
    pub(super) fn new(settings: &FeedbackSettings, period_s: f64) -> Self {
        Harm {
            share: R::of((period_s / MEAN_S).min(1.0)),
            floor: R::of(settings.watch_mm * FLOOR),
            longest: (LONGEST_S / period_s) as u32,
            shortest: R::of(SHORTEST_S / period_s),
            again: (AGAIN_S / period_s) as u32,
            wait: (WAIT_S / period_s) as u32,
            back: R::of(period_s / RETURN_S),
        }
    }

    /// Whether the feedback is to be ramped out; `errors`: of all directions, in a cycle in which they can be acted on.
    #[inline(always)]
    pub(super) fn is_found<const N: usize>(
        &self,
        trial: &mut Trial<R>,
        waves: &mut [Wave<R>; N],
        errors: [R; 3],
        integrals: &[R; N],
    ) -> bool {
        trial.wait = trial.wait.saturating_sub(1);
        trial.again = trial.again.saturating_sub(1);
        if !trial.holds_out() {
            trial.share = (trial.share + self.back).min(R::ONE);
        }
        let mut found = false;
        for (slot, ((wave, error), integral)) in waves.iter_mut().zip(errors).zip(integrals).enumerate() {
            let seen = self.see(wave, error);
            if seen != Seen::Nothing {
                found |= self.judge(trial, wave, slot as u8, seen, *integral);
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
        if side == wave.side {
            return Seen::Nothing;
        }
        self.turn(wave, side)
    }

    /// Begins a half wave.
    #[inline(never)]
    fn turn(&self, wave: &mut Wave<R>, side: i8) -> Seen {
        let since = wave.since;
        let half = Level { sum: wave.area, cycles: R::of_i32(since as i32) };
        let follows = wave.side != 0 && since < self.longest;
        if !follows {
            *wave = Wave { mean: wave.mean, side, ..Wave::default() };
            return Seen::Nothing;
        }
        (wave.side, wave.since, wave.area) = (side, 0, R::ZERO);
        let regular = 3 * since >= 2 * wave.lasted && 2 * since <= 3 * wave.lasted;
        wave.lasted = since;
        let rises = since >= FEWEST && regular && wave.last_but_one.cycles > R::ZERO && wave.last_but_one.is_below(R::of(1.0 / RISEN), &half);
        wave.rises = if rises { wave.rises.saturating_add(1) } else { 0 };
        wave.last_but_one = core::mem::replace(&mut wave.last, half);
        wave.half_waves = wave.half_waves.saturating_add(1);
        wave.group = wave.group.plus(&half);
        if wave.early.cycles == R::ZERO && wave.half_waves >= GROUP / 2 && wave.group.cycles >= R::HALF * self.shortest {
            wave.early = wave.group;
        }
        if wave.half_waves < GROUP || wave.group.cycles < self.shortest {
            return if wave.rises >= RISES { Seen::Growing } else { Seen::Nothing };
        }
        let group = core::mem::take(&mut wave.group);
        let early = core::mem::take(&mut wave.early);
        let before = core::mem::replace(&mut wave.before, group);
        wave.half_waves = 0;
        let decays = R::of(DECAYED);
        let decays = before.cycles == R::ZERO || group.is_below(decays, &before) || group.is_below(decays, &early);
        wave.sustained = if decays { 0 } else { wave.sustained.saturating_add(1) };
        if wave.rises >= RISES {
            Seen::Growing
        } else if wave.sustained >= SUSTAINED {
            Seen::Sustained
        } else {
            Seen::Group
        }
    }

    /// Begins, continues or ends a trial; whether the feedback is found guilty for the second time.
    #[inline(never)]
    fn judge(&self, trial: &mut Trial<R>, wave: &mut Wave<R>, slot: u8, seen: Seen, integral: R) -> bool {
        if !trial.holds_out() {
            let grew = seen == Seen::Growing;
            let level = if grew { wave.last } else { wave.before };
            let more = trial.acquittals == 0 || trial.acquitted.is_below(R::of(1.0 / MORE), &level);
            if grew || seen == Seen::Sustained && (trial.wait == 0 || more) {
                (trial.groups, trial.slot, trial.with, trial.grew) = (1, slot, level, grew);
                trial.share = R::ZERO;
                *wave = Wave { mean: wave.mean, side: wave.side, since: wave.since, area: wave.area, ..Wave::default() };
            }
            return false;
        }
        let ended = seen == Seen::Ended;
        if slot != trial.slot || (seen == Seen::Growing && wave.half_waves != 0) {
            return false;
        }
        let level = wave.before;
        let last = trial.groups >= TRIAL;
        let less = R::of(if last { LESS } else { FAR_LESS });
        let less = ended || (trial.groups > 1 && level.is_below(less, &trial.with));
        let level = if ended { Level { sum: R::ZERO, cycles: R::ONE } } else { level };
        if less && (trial.grew || trial.with.exceeds(&level, integral.abs())) {
            trial.groups = 0;
            return core::mem::replace(&mut trial.again, self.again) != 0;
        }
        trial.groups += 1;
        if last || less {
            trial.groups = 0;
            trial.acquitted = trial.with;
            trial.wait = self.wait << trial.acquittals.min(DOUBLINGS);
            trial.acquittals = trial.acquittals.saturating_add(1);
            trial.again = 0;
        }
        false
    }
}
