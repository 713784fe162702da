//! Watch on harm of the feed-forward: estimates from the contour error how much of each part helps.
//!
//! With r the displacement that a part would cause on its own at its full figures, h its missing velocity error (for lag
//! (1 − k_ff) v) and e the contour error, all axes together:
//!
//! ```text
//! r' = h − K_v r                                  t: direction of motion
//! S  = <e, r>      N = <r, r> − <t, r>²           sums that forget over 0.3 s, lag and acceleration 0.1 s
//! p  = w − S/N                                    the share at which the part would leave least, w: its present one
//! R² = (w N − S)²/(N (<e, e> − 2 w S + w² N))     what the part explains of the error that would be without it
//! ```
//!
//! e is normal to the path, so <e, r> needs no projection. At the share w a part leaves (w − p)² N and without it p² N. While
//! the host has the parts on trial ([`super::Dynamics::ON_TRIAL`]), all shares start at 0. A share rises, at most 100/s, to
//! 0.8 p where the part explains 80 % of the error (there it counts as helping again), and falls as fast to 0.8 p for p < 0.9
//! w, if r explains a tenth of <e, e>. Nothing is judged while r is below 0.3 µm (RMS over the time of the sums). After a move
//! of w the sums are those of the new share, so that p stays. The share of friction ends where a reversal reaches the limit of
//! d: beyond it d would be longer than the spike, not higher. Parts that are not on trial act in full; the step then
//! multiplies no shares and advances nothing here. A trial that begins in motion begins at rest: r, all sums and all shares
//! are 0.
//!
//! One share serves all axes: where several reverse at once, on a line, their spikes cancel in part, and taking out one
//! alone would uncover the other. The share multiplies ΔF of friction and acceleration: a share that moves displaces
//! nothing by itself. One part is advanced and judged a cycle, in turn.

#![deny(clippy::indexing_slicing)]

use super::feed_forward::{Drift, Shares};
use crate::machine::{AxisServo, AxisSettings, DriveFigures, DynamicSettings, FrictionSettings};
use crate::real::Real;

/// Parts: friction, lag, acceleration.
const PARTS: usize = 3;
/// Times over which the sums forget, s.
const FORGET_S: [f64; PARTS] = [0.3, 0.1, 0.1];
/// Smallest RMS of r that is judged, mm (deg).
const FLOOR: f64 = 3e-4;
/// Share of <e, e> that r must explain before a part is led out.
const SEEN: f64 = 0.1;
/// R² from which a share may rise.
const EXPLAINED: f64 = 0.8;
/// Fewest turns in motion before a judgement, and their shortest time, s: a few errors explain themselves.
const FEWEST: f64 = 12.0;
const SHORTEST_S: f64 = 0.015;
/// Rate of a share, per s.
const RATE_PER_S: f64 = 100.0;

/// A part harms if p is below this multiple of w.
const HARMS: f64 = 0.9;
/// Multiple of p towards which w moves.
const TOWARDS: f64 = 0.8;

/// How an axis follows an offset over [`PARTS`] cycles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach<R> {
    /// e^(−3T/τ).
    decay: R,
    /// e^(−3 K_v T), and (1 − e^(−3 K_v T))/(K_v T).
    keep: R,
    gain: R,
}

/// r of a part on an axis.
#[derive(Clone, Copy, Debug, Default)]
struct Regressor<R> {
    force: R,
    missing: R,
    offset: R,
}

/// Constants of the estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence<R> {
    keep: [R; PARTS],
    floor: [R; PARTS],
    /// Largest shares.
    most: [R; PARTS],
    rate: R,
    fewest: u32,
}

/// Sums and share of a part.
#[derive(Clone, Copy, Debug)]
struct Part<R> {
    /// S, N, <e, e>.
    along: R,
    square: R,
    error: R,
    /// w.
    share: R,
    /// Turns in motion.
    turns: u32,
    /// Whether harm has lowered the share, and it has not risen since to what helps.
    out: bool,
    /// Whether the next force counts as supplied already.
    fresh: bool,
}

/// State of the estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Worth<R> {
    /// Of the directions of the tip.
    regressors: [[Regressor<R>; 3]; PARTS],
    parts: [Part<R>; PARTS],
    turn: u8,
    on_trial: bool,
}

impl<R: Real> Reach<R> {
    /// An axis without drive figures follows nothing.
    pub(super) fn new(drive: Option<&DriveFigures>, period_s: f64) -> Self {
        let Some(drive) = drive else { return Reach { decay: R::ZERO, keep: R::ZERO, gain: R::ZERO } };
        let (turns, gain) = (PARTS as f64 * period_s, drive.position_gain_per_s);
        let keep = libm::exp(-gain * turns);
        Reach {
            decay: R::of(libm::exp(-turns / drive.reset_time_s)),
            keep: R::of(keep),
            gain: R::of((1.0 - keep) / (gain * period_s)),
        }
    }
}

impl<R: Real> Worth<R> {
    pub(super) fn new(on_trial: bool) -> Self {
        let (zero, share) = (R::ZERO, if on_trial { R::ZERO } else { R::ONE });
        let part = Part { along: zero, square: zero, error: zero, share, turns: 0, out: false, fresh: true };
        Worth { regressors: Default::default(), parts: [part; PARTS], turn: 0, on_trial }
    }

    /// The drives already supply the present forces.
    #[inline(always)]
    pub(super) fn supplied(&mut self) {
        self.parts.iter_mut().for_each(|part| part.fresh = true);
    }

    /// Shares that act; `None` while the parts are not on trial: they act in full, and the straight path multiplies nothing.
    #[inline(always)]
    pub(super) fn acting(&self) -> Option<Shares<R>> {
        self.on_trial.then(|| self.shares())
    }

    #[inline(always)]
    fn shares(&self) -> Shares<R> {
        let [friction, lag, acceleration] = &self.parts;
        Shares { friction: friction.share, lag: lag.share, acceleration: acceleration.share }
    }

    /// Whether harm has lowered the share of friction; of lag or acceleration.
    #[inline(always)]
    pub(super) fn out(&self) -> [bool; 2] {
        let [friction, lag, acceleration] = &self.parts;
        [friction.out, lag.out | acceleration.out]
    }

    /// Whether the parts are on trial.
    #[inline(always)]
    pub(super) fn is_on_trial(&self) -> bool {
        self.on_trial
    }
}

impl<R: Real> Evidence<R> {
    /// The estimate of these axes; `None` if none has drive figures.
    pub(super) fn new<'m>(axes: impl Iterator<Item = &'m AxisSettings>, period_s: f64) -> Option<Self> {
        let (mut any, mut friction) = (false, 1.0);
        for settings in axes {
            let AxisServo { drive, friction: stated, dynamic } = &settings.servo;
            any |= drive.is_some();
            if let (Some(drive), Some(stated)) = (drive, stated) {
                let dynamic = dynamic.unwrap_or(DynamicSettings::with_defaults(settings.axis));
                friction = f64::min(friction, dynamic.limits.magnitude / reversal(drive, stated));
            }
        }
        let turns = PARTS as f64 * period_s;
        let forgets = FORGET_S.map(|time_s| (turns / time_s).min(1.0));
        any.then(|| Evidence {
            keep: forgets.map(|share| R::of(1.0 - share)),
            floor: forgets.map(|share| R::of(FLOOR * FLOOR / share)),
            rate: R::of((RATE_PER_S * turns).min(1.0)),
            most: [R::of(friction), R::ONE, R::ONE],
            fewest: FEWEST.max(SHORTEST_S / turns) as u32,
        })
    }

    /// Advances the part whose turn it is and judges it if the contour error can be acted on.
    #[inline(never)]
    pub(super) fn judge<'a>(
        &self,
        worth: &mut Worth<R>,
        axes: impl Iterator<Item = (&'a Reach<R>, &'a Drift<R>)>,
        error: Option<[R; 3]>,
    ) where
        R: 'a,
    {
        let turn = worth.turn;
        worth.turn = if turn == 2 { 0 } else { turn + 1 };
        let constants = self.keep.iter().zip(&self.floor).zip(&self.most);
        let mut states = worth.regressors.iter_mut().zip(&mut worth.parts).zip(constants);
        let Some(((regressors, part), ((keep, floor), most))) = states.nth(usize::from(turn)) else { return };
        let e = error.unwrap_or_default();
        let (mut along, mut square, mut forwards, mut way, mut size) = (R::ZERO, R::ZERO, R::ZERO, R::ZERO, R::ZERO);
        for ((regressor, (reach, drift)), e) in regressors.iter_mut().zip(axes).zip(e) {
            let v = drift.velocity();
            if turn == 1 {
                regressor.missing = drift.lag();
            } else {
                let force = if turn == 0 { drift.sliding() } else { drift.accelerating() };
                let rise = if part.fresh { R::ZERO } else { force - regressor.force };
                regressor.missing = (regressor.missing + rise) * reach.decay;
                regressor.force = force;
            }
            let r = regressor.offset * reach.keep + regressor.missing * reach.gain;
            regressor.offset = r;
            along = along.add_product(e, r);
            square = square.add_product(r, r);
            forwards = forwards.add_product(v, r);
            way = way.add_product(v, v);
            size = size.add_product(e, e);
        }
        part.fresh = false;
        if error.is_none() || way == R::ZERO {
            return;
        }
        part.along = part.along * *keep + along;
        part.square = part.square * *keep + (square - forwards * forwards / way).max(R::ZERO);
        part.error = part.error * *keep + size;
        part.turns = part.turns.saturating_add(1);
        if part.square > *floor && part.turns >= self.fewest {
            self.lead(part, *most);
        }
    }

    /// Moves the share of a part by what the sums say, up to `most`.
    #[inline(always)]
    fn lead(&self, part: &mut Part<R>, most: R) {
        let Part { along, square, error, share, .. } = *part;
        // p N and w N.
        let (best, present) = (share * square - along, share * square);
        let (harms, towards) = (R::of(HARMS), R::of(TOWARDS));
        let share = if best < harms * present {
            let is_seen = along * along > R::of(SEEN) * square * error;
            if share == R::ZERO || !is_seen || towards * best >= present {
                return;
            }
            part.out = true;
            (towards * best / square).max(share - self.rate).max(R::ZERO)
        } else {
            let without = error - share * (along + along - present);
            if towards * best <= present || best * best <= R::of(EXPLAINED) * square * without {
                return;
            }
            // A change of the machine may have lowered `most` below the present share.
            let wanted = (towards * best / square).min(most);
            let share = wanted.min(share + self.rate);
            part.out &= share < wanted;
            share
        };
        // The sums as they would be had the new share acted all the time: p stays.
        let moved = share - part.share;
        part.share = share;
        part.along = along.add_product(moved, square);
        part.error = error + moved * (along + part.along);
    }
}

/// Largest offset of the feed-forward at a reversal of friction, mm (deg): with h = ΔF e^(−t/τ) the top of
/// k_ff u' = h − K_v u.
fn reversal(drive: &DriveFigures, friction: &FrictionSettings) -> f64 {
    let change = 2.0 * friction.coulomb_per_s * (1.0 + friction.stribeck_share);
    // Both rates in 1/s; never equal, and finite without velocity feed-forward.
    let slow = 1.0 / drive.reset_time_s;
    let fast = drive.position_gain_per_s / drive.velocity_feed_forward.max(1e-6) + 1e-6 * slow;
    change / drive.position_gain_per_s * libm::exp(libm::log(slow / fast) * slow / (fast - slow))
}

#[cfg(test)]
#[allow(clippy::indexing_slicing)]
mod tests {
    use super::super::Dynamics;
    use super::super::feed_forward::FeedForward;
    use super::*;
    use crate::axis::Axis;
    use crate::testing::noise::Noise;

    use std::vec::Vec;

    const T: f64 = 1e-3;
    const KV: f64 = 60.0;
    const SHARED: f64 = 0.5;
    const FEED: f64 = 25.0;
    const RADIUS: f64 = 10.0;

    /// A position loop with velocity feed-forward: what an offset displaces.
    #[derive(Clone, Copy, Default)]
    struct Loop {
        at: f64,
        before: f64,
    }

    impl Loop {
        fn moved(&mut self, offset: f64) -> f64 {
            self.at += KV * T * (offset - self.at) + SHARED * (offset - self.before);
            self.before = offset;
            self.at
        }
    }

    struct Run {
        /// Shares of friction, lag and acceleration after each cycle, and whether any is reported as led out.
        shares: Vec<([f64; 3], bool)>,
    }

    fn drive() -> DriveFigures {
        DriveFigures { velocity_feed_forward: SHARED, ..DriveFigures::with_defaults(KV, 400.0, 0.02) }
    }

    fn servo() -> AxisServo {
        let friction = Some(FrictionSettings::with_defaults(1.0, 0.006));
        AxisServo { drive: Some(drive()), friction, ..AxisServo::default() }
    }

    fn law() -> FeedForward<f64> {
        let settings = DynamicSettings { lag: true, acceleration: true, ..DynamicSettings::with_defaults(Axis::X) };
        FeedForward::new(&servo(), &settings, T)
    }

    /// Position on a circle after k cycles.
    fn at(k: u32) -> [f64; 2] {
        let angle = f64::from(k) * T * FEED / RADIUS - 0.5;
        [RADIUS * angle.cos(), RADIUS * angle.sin()]
    }

    /// A circle on which `parts` are on trial and needed only to the share `needed` of a cycle; noise of this size on the error,
    /// mm.
    fn circle(parts: Dynamics, needed: impl Fn(u32) -> f64, noise: f64, cycles: u32) -> Run {
        let (law, reach) = (law(), Reach::new(Some(&drive()), T));
        let axis = AxisSettings { servo: servo(), ..AxisSettings::with_defaults(Axis::X, false) };
        let evidence = Evidence::new(core::iter::once(&axis), T).unwrap();
        let mut worth = Worth::new(true);
        let (mut acting, mut whole) = ([Drift::default(); 2], [Drift::default(); 2]);
        let (mut sent, mut all) = ([Loop::default(); 2], [Loop::default(); 2]);
        let (mut run, mut random) = (Run { shares: Vec::new() }, Noise::new(1));
        for k in 0..cycles {
            let (to, from) = (at(k + 1), at(k));
            let (shares, needed) = (worth.shares(), needed(k));
            let mut e = [0.0; 3];
            for i in 0..2 {
                let way = to[i] - from[i];
                let moved = sent[i].moved(law.offset(&mut acting[i], way, parts, k == 0, Some(&shares)));
                let could = all[i].moved(law.offset(&mut whole[i], way, parts, k == 0, None));
                e[i] = moved - needed * could + noise * random.range(-1.0, 1.0);
            }
            let normal = (e[0] * to[0] + e[1] * to[1]) / RADIUS;
            let error = [normal * to[0] / RADIUS, normal * to[1] / RADIUS, 0.0];
            evidence.judge(&mut worth, core::iter::repeat_n(&reach, 2).zip(&acting), Some(error));
            let shares = worth.shares();
            run.shares.push(([shares.friction, shares.lag, shares.acceleration], worth.out() != [false; 2]));
        }
        run
    }

    #[test]
    fn a_part_that_no_longer_helps_is_led_out_and_says_so() {
        for (part, parts) in [Dynamics::FRICTION, Dynamics::LAG].into_iter().enumerate() {
            let run = circle(parts, |k| if k < 6000 { 1.0 } else { 0.1 }, 0.0, 10_000);
            let [(before, _), (after, out)] = [run.shares[5999], run.shares[9999]];
            assert!(before[part] >= 0.6 && after[part] <= 0.12 && out, "{parts:?}: {before:?}, {after:?}, {out}");
        }
    }

    #[test]
    fn harm_is_led_out_within_30_ms_of_a_reversal_and_120_ms_of_lag() {
        // The first reversal after the change is in cycle 6483. A share of 0.225 leaves 1.25 times the error without the part.
        for (part, parts, begins, longest) in [(0, Dynamics::FRICTION, 6483, 30), (1, Dynamics::LAG, 6000, 120)] {
            let run = circle(parts, |k| if k < 6000 { 1.0 } else { 0.1 }, 0.0, 10_000);
            let last = run.shares.iter().rposition(|(shares, _)| shares[part] > 0.225).unwrap();
            assert!((begins..begins + longest).contains(&last), "{parts:?}: cycle {last}");
        }
    }

    #[test]
    fn a_part_that_helps_again_is_no_longer_reported_as_led_out() {
        for parts in [Dynamics::FRICTION, Dynamics::LAG] {
            let run = circle(parts, |k| if (6000..12_000).contains(&k) { 0.1 } else { 1.0 }, 0.0, 18_000);
            let [during, after] = [run.shares[11_999], run.shares[17_999]];
            assert!(during.1 && !after.1, "{parts:?}: {during:?}, {after:?}");
        }
    }

    #[test]
    fn on_trial_a_part_rises_only_where_it_helps() {
        for (part, parts) in [Dynamics::FRICTION, Dynamics::LAG].into_iter().enumerate() {
            let last = |needed| circle(parts, |_| needed, 2e-4, 6000).shares[5999].0;
            let helps = last(1.0);
            assert!(helps[part] >= 0.6, "{parts:?}: {helps:?}");
            assert_eq!(last(0.0), [0.0; 3], "{parts:?}");
        }
    }

    #[test]
    fn noise_moves_no_share() {
        let run = circle(Dynamics::ALL, |_| 0.0, 2e-3, 100_000);
        assert!(run.shares.iter().all(|seen| *seen == ([0.0; 3], false)));
    }

    #[test]
    fn at_full_shares_the_law_is_the_straight_one_to_the_bit() {
        let (law, full) = (law(), Shares { friction: 1.0, lag: 1.0, acceleration: 1.0 });
        let (mut straight, mut shared) = (Drift::default(), Drift::default());
        for k in 0..10_000 {
            let way = at(k + 1)[0] - at(k)[0];
            let offset = law.offset(&mut straight, way, Dynamics::ALL, k == 0, None);
            let with = law.offset(&mut shared, way, Dynamics::ALL, k == 0, Some(&full));
            assert_eq!(offset.to_bits(), with.to_bits(), "cycle {k}");
        }
    }

    #[test]
    fn a_reversal_is_as_high_as_the_law_makes_it() {
        for (shared, reset_s) in [(0.0, 0.02), (0.5, 0.02), (0.97, 0.02), (0.5, 0.2), (1.0, 1.0 / KV)] {
            let drive =
                DriveFigures { velocity_feed_forward: shared, ..DriveFigures::with_defaults(KV, 400.0, reset_s) };
            // So short that friction has changed sides at once, and slower than the Stribeck velocity.
            let friction = FrictionSettings { viscous: 0.0, ..FrictionSettings::with_defaults(1.0, 1e-6) };
            let servo = AxisServo { drive: Some(drive), friction: Some(friction), ..AxisServo::default() };
            let law = FeedForward::<f64>::new(&servo, &DynamicSettings::with_defaults(Axis::X), 1e-4);
            let (mut drift, mut largest) = (Drift::default(), 0.0_f64);
            for k in 0..40_000 {
                let way = if k < 20_000 { 1e-5 } else { -1e-5 };
                let offset = law.offset(&mut drift, way, Dynamics::FRICTION, k == 0, None);
                largest = largest.max(if k < 20_000 { 0.0 } else { offset.abs() });
            }
            let stated = reversal(&drive, &friction);
            assert!((largest / stated - 1.0).abs() < 0.03, "{shared}, {reset_s}: {largest}, stated {stated}");
        }
    }
}
