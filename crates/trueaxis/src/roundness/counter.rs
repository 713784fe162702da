//! Converts encoder counts to angles.
//!
//! Angles are 32-bit fractions of a turn: 2^32 is 360°, one unit 1.5 nrad. They add and wrap like physical angles, over any
//! number of revolutions, without a division and without loss.

use super::flags::GaugeFlags;
use super::settings::{ArmSettings, SpindleEncoder};

/// Converts counts of one turn to a fraction of 2^32: x + x·f/2^32, with x = counts · 2^k, f = ⌊2^(64−k)/counts per
/// turn − 2^32⌉.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    /// 2^k, as far as the counts of a turn can be shifted within 32 bits.
    power: u32,
    factor: u32,
}

impl Scale {
    fn new(counts: u32) -> Self {
        let counts = counts.max(1);
        let shift = (counts - 1).leading_zeros().min(31);
        let turn = u64::from(counts) << shift;
        let factor = ((1u128 << 64) + u128::from(turn / 2)) / u128::from(turn) - (1u128 << 32);
        Scale { power: 1 << shift, factor: u32::try_from(factor).unwrap_or(u32::MAX) }
    }

    /// Angle of a count, to within two units.
    #[inline(always)]
    fn angle(self, counts: u32) -> u32 {
        let x = counts.wrapping_mul(self.power);
        x.wrapping_add(((u64::from(x) * u64::from(self.factor)) >> 32) as u32)
    }
}

/// Tracks the spindle encoder from cycle to cycle: immutable half.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpindleCounter {
    scale: Scale,
    /// ±1.
    direction: i32,
    counts: u32,
    /// Counts per cycle beyond which the encoder has jumped.
    most: u32,
    /// Counts without an index pulse after which the pulse is missing.
    overdue: u32,
    index: bool,
    tolerance: u32,
}

/// Tracks the spindle encoder from cycle to cycle: its state. Counts are in the sense of θ and wrap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpindleState {
    last: i32,
    /// Count at which α is zero in this turn.
    zero: i32,
    /// Count at the last index pulse.
    pulse: i32,
    pub(super) started: bool,
    referenced: bool,
    /// Zero was known, and counting has continued since: sufficient to apply a correction, not to measure.
    counting: bool,
    /// The last index pulse contradicted the previous one: the next must agree.
    doubtful: bool,
}

impl SpindleState {
    pub(super) const NEW: SpindleState = SpindleState {
        last: 0,
        zero: 0,
        pulse: 0,
        started: false,
        referenced: false,
        counting: false,
        doubtful: false,
    };

    /// Counts since α = 0, below one turn.
    #[inline(always)]
    fn in_turn(&self) -> u32 {
        self.last.wrapping_sub(self.zero) as u32
    }
}

impl SpindleCounter {
    pub(super) fn new(encoder: &SpindleEncoder) -> Self {
        let counts = encoder.counts;
        SpindleCounter {
            scale: Scale::new(counts),
            direction: i32::from(encoder.direction),
            counts,
            most: counts / 4,
            overdue: if encoder.index { counts + counts / 4 } else { u32::MAX },
            index: encoder.index,
            tolerance: encoder.index_tolerance,
        }
    }

    /// Count in the sense of θ, and the counts since α = 0.
    #[inline(always)]
    pub(super) fn read(&self, state: &SpindleState, raw: i32) -> (i32, u32) {
        let raw = raw.wrapping_mul(self.direction);
        (raw, raw.wrapping_sub(state.zero) as u32)
    }

    /// α at a count below one turn.
    #[inline(always)]
    pub(super) fn angle(&self, in_turn: u32) -> u32 {
        self.scale.angle(in_turn)
    }

    /// Whether a count is less than a quarter turn ahead of the last.
    #[inline(always)]
    pub(super) fn follows(&self, state: &SpindleState, raw: i32) -> bool {
        raw.wrapping_sub(state.last) as u32 <= self.most
    }

    /// Accepts a count below [`SpindleCounter::plain`].
    #[inline(always)]
    pub(super) fn follow(state: &mut SpindleState, raw: i32) {
        state.last = raw;
    }

    /// Counts from α = 0 below which a count that continues needs no further test until the next pulse: the turn does
    /// not end there, and no pulse is missing. 0 while zero is in doubt.
    pub(super) fn plain(&self, state: &SpindleState) -> u32 {
        if !state.referenced {
            return 0;
        }
        if !self.index {
            return self.counts;
        }
        if state.last.wrapping_sub(state.pulse) < 0 {
            return 0;
        }
        let until_overdue = i64::from(self.overdue) + 1 - i64::from(state.zero.wrapping_sub(state.pulse));
        u32::try_from(until_overdue).map_or(0, |counts| counts.min(self.counts))
    }

    /// α in this cycle, if known, even if only by counting since the last reliable zero; adds flags for any fault.
    #[inline(always)]
    pub(super) fn update(
        &self,
        state: &mut SpindleState,
        raw: i32,
        pulse: Option<i32>,
        flags: &mut GaugeFlags,
    ) -> Option<u32> {
        let raw = raw.wrapping_mul(self.direction);
        let moved = raw.wrapping_sub(state.last);
        let in_turn = self.advanced(state.in_turn(), moved);
        (state.last, state.zero) = (raw, raw.wrapping_sub(in_turn as i32));
        let plain = state.referenced && moved.unsigned_abs() <= self.most && pulse.is_none();
        if !(plain && self.is_in_time(state)) {
            let moved = self.exceptional(state, raw, moved, pulse, flags);
            if moved || !(state.referenced || state.counting) {
                return None;
            }
        }
        Some(self.scale.angle(state.in_turn()))
    }

    /// Whether no index pulse is missing.
    #[inline(always)]
    fn is_in_time(&self, state: &SpindleState) -> bool {
        state.last.wrapping_sub(state.pulse).unsigned_abs() <= self.overdue
    }

    /// Counts within the turn after a motion of less than one turn.
    #[inline(always)]
    fn advanced(&self, in_turn: u32, moved: i32) -> u32 {
        let sum = in_turn.wrapping_add_signed(moved);
        if sum < self.counts {
            sum
        } else if moved < 0 {
            sum.wrapping_add(self.counts)
        } else {
            sum.wrapping_sub(self.counts)
        }
    }

    /// Handles everything but a plain motion: first cycle, jump, index pulse, missing pulse. Returns true if zero has
    /// moved, which makes the angles before and after incomparable.
    #[inline(never)]
    fn exceptional(
        &self,
        state: &mut SpindleState,
        raw: i32,
        moved: i32,
        pulse: Option<i32>,
        flags: &mut GaugeFlags,
    ) -> bool {
        if !state.started || moved.unsigned_abs() > self.most {
            if state.started {
                flags.set(GaugeFlags::SPINDLE_JUMP);
            }
            self.restart(state, raw);
        }
        if !self.index {
            return false;
        }
        let mut zero_moved = false;
        if let Some(latched) = pulse {
            zero_moved = self.at_index(state, raw, latched, flags);
        } else if state.referenced && !self.is_in_time(state) {
            // The count may have slipped by any amount.
            state.referenced = false;
            flags.set(GaugeFlags::INDEX_MISSING);
        }
        if !state.referenced || zero_moved {
            flags.set(GaugeFlags::NO_INDEX);
        }
        zero_moved
    }

    #[cold]
    fn restart(&self, state: &mut SpindleState, raw: i32) {
        // Without an index the count itself is absolute.
        let in_turn = i64::from(raw).checked_rem_euclid(i64::from(self.counts)).map_or(0, |rest| rest as i32);
        *state = SpindleState {
            last: raw,
            zero: raw.wrapping_sub(in_turn),
            pulse: raw,
            started: true,
            referenced: !self.index,
            ..SpindleState::NEW
        };
    }

    #[cold]
    fn at_index(&self, state: &mut SpindleState, raw: i32, latched: i32, flags: &mut GaugeFlags) -> bool {
        let latched = latched.wrapping_mul(self.direction);
        let since = raw.wrapping_sub(latched);
        if since.unsigned_abs() > self.most {
            // Latched more than a quarter turn ago: not this cycle's pulse.
            flags.set(GaugeFlags::INDEX_SHIFTED);
            return false;
        }
        let now = self.advanced(0, since);
        let apart = now.abs_diff(state.in_turn());
        let agrees = apart.min(self.counts.wrapping_sub(apart)) <= self.tolerance;
        state.pulse = latched;
        if state.referenced && agrees {
            return false;
        }
        if state.referenced {
            flags.set(GaugeFlags::INDEX_SHIFTED);
        }
        let first = !state.referenced && !state.doubtful;
        state.doubtful = !(first || agrees);
        (state.referenced, state.counting) = (!state.doubtful, !state.doubtful);
        state.zero = raw.wrapping_sub(now as i32);
        true
    }
}

/// Converts the counts of the arm's encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ArmCounter {
    /// ±2^k, and half the factor of a [`Scale`]: signed numbers have one bit less.
    power: i32,
    factor: i32,
    /// A quarter turn, in counts.
    most: u32,
}

impl ArmCounter {
    pub(super) fn new(arm: &ArmSettings) -> Self {
        let Scale { power, factor } = Scale::new(arm.counts);
        ArmCounter {
            power: (power as i32).wrapping_mul(i32::from(arm.direction)),
            factor: (factor >> 1) as i32,
            most: arm.counts / 4,
        }
    }

    /// β, a signed fraction of 2^32 to within four units, if it lies within ±90°.
    #[inline(always)]
    pub(super) fn angle(&self, raw: i32) -> Option<i32> {
        if raw.wrapping_add(self.most as i32) as u32 > 2 * self.most {
            return None;
        }
        let x = raw.wrapping_mul(self.power);
        let more = (i64::from(x) * i64::from(self.factor)) >> 32;
        Some(x.wrapping_add((more as i32) << 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoder(counts: u32) -> SpindleEncoder {
        SpindleEncoder { counts, direction: 1, index: true, index_tolerance: 2 }
    }

    #[test]
    fn counts_become_angles_within_two_units() {
        for counts in [64, 1000, 4096, 3_600_000, 1 << 28, 1_000_003] {
            let scale = Scale::new(counts);
            for i in 0..2000u64 {
                let count = (i * 7919 * u64::from(counts) / 2000) % u64::from(counts);
                let exact = (count << 32) as f64 / f64::from(counts);
                let found = f64::from(scale.angle(count as u32));
                assert!((found - exact).abs() <= 2.0, "{counts} {count}: {found} {exact}");
            }
        }
    }

    /// Every count of every encoder up to 2048 a turn, and of 2^12 and 2^16; larger ones by the bound of the two roundings,
    /// half a unit and one.
    #[test]
    fn every_count_has_an_angle_of_its_own() {
        for counts in (1..=2048).chain([1 << 12, 1 << 16]) {
            let scale = Scale::new(counts);
            let mut last = None;
            for count in 0..counts {
                let found = scale.angle(count);
                let exact = (u64::from(count) << 32) / u64::from(counts);
                assert!(u64::from(found).abs_diff(exact) <= 2, "{counts} {count}: {found} {exact}");
                assert!(last.is_none_or(|last| last < found), "{counts} {count}");
                last = Some(found);
            }
        }
    }

    /// Turns at 10 counts a cycle, with the pulse of a revolution `pulse(revolution)` counts late; returns all flags seen.
    fn turn(
        counter: &SpindleCounter,
        state: &mut SpindleState,
        from: i32,
        cycles: i32,
        pulse: fn(i32) -> Option<i32>,
    ) -> GaugeFlags {
        let mut seen = GaugeFlags::default();
        for i in 1..=cycles {
            let (before, now) = (from + 10 * (i - 1), from + 10 * i);
            let turn = now.div_euclid(1000);
            let crossed = turn != before.div_euclid(1000);
            let latched = if crossed { pulse(turn).map(|off| turn * 1000 + off) } else { None };
            counter.update(state, now, latched, &mut seen);
        }
        seen
    }

    #[test]
    fn zero_is_at_the_index_over_many_turns() {
        let counter = SpindleCounter::new(&encoder(1000));
        let mut state = SpindleState::NEW;
        let mut flags = GaugeFlags::default();
        assert_eq!(counter.update(&mut state, 137, None, &mut flags), None);
        assert!(flags.has(GaugeFlags::NO_INDEX));
        turn(&counter, &mut state, 137, 100, |_| Some(0));
        let seen = turn(&counter, &mut state, 1137, 5000, |_| Some(0));
        assert_eq!(seen, GaugeFlags::default());
        let alpha = counter.update(&mut state, 51_150, None, &mut flags).unwrap();
        assert!((f64::from(alpha) / 4_294_967_296.0 - 0.15).abs() < 1e-9);
    }

    #[test]
    fn a_missing_index_is_noticed_and_the_next_one_taken() {
        let counter = SpindleCounter::new(&encoder(1000));
        let mut state = SpindleState::NEW;
        turn(&counter, &mut state, 0, 250, |_| Some(0));
        let seen = turn(&counter, &mut state, 2500, 100, |_| None);
        assert!(seen.has(GaugeFlags::INDEX_MISSING) && seen.has(GaugeFlags::NO_INDEX));
        let seen = turn(&counter, &mut state, 3500, 60, |_| Some(0));
        assert!(!seen.has(GaugeFlags::INDEX_SHIFTED));
        assert!(state.referenced);
    }

    #[test]
    fn a_shifted_index_has_to_be_confirmed() {
        let counter = SpindleCounter::new(&encoder(1000));
        let mut state = SpindleState::NEW;
        turn(&counter, &mut state, 0, 250, |_| Some(0));
        // Lost counts: the pulse comes 4 counts late, and stays there.
        let seen = turn(&counter, &mut state, 2500, 60, |_| Some(4));
        assert!(seen.has(GaugeFlags::INDEX_SHIFTED) && !state.referenced);
        turn(&counter, &mut state, 3100, 100, |_| Some(4));
        assert!(state.referenced);
        let seen = turn(&counter, &mut state, 4100, 200, |_| Some(4));
        assert_eq!(seen, GaugeFlags::default());
    }

    #[test]
    fn a_jump_needs_a_new_index() {
        let counter = SpindleCounter::new(&encoder(1000));
        let mut state = SpindleState::NEW;
        turn(&counter, &mut state, 0, 250, |_| Some(0));
        let mut flags = GaugeFlags::default();
        assert_eq!(counter.update(&mut state, i32::MIN, None, &mut flags), None);
        assert!(flags.has(GaugeFlags::SPINDLE_JUMP) && flags.has(GaugeFlags::NO_INDEX));
    }

    #[test]
    fn without_an_index_the_count_is_absolute_in_both_directions() {
        for direction in [1, -1] {
            let counter = SpindleCounter::new(&SpindleEncoder { index: false, direction, ..encoder(1024) });
            let mut state = SpindleState::NEW;
            let mut flags = GaugeFlags::default();
            for raw in (-5000..5000).step_by(37) {
                let alpha = counter.update(&mut state, raw, None, &mut flags).unwrap();
                let exact = (raw * i32::from(direction)).rem_euclid(1024) as u32;
                assert_eq!(alpha, exact << 22, "{raw}");
            }
            assert_eq!(flags, GaugeFlags::default());
        }
    }

    #[test]
    fn counts_of_the_arm_are_signed() {
        for (counts, direction) in [(5, 1), (4096, 1), (1_000_003, -1), (1 << 27, 1), (1 << 28, -1)] {
            let lengths = super::super::Arm { crank_mm: 1.0, wheel_mm: 1.0, pin_mm: 1.0 };
            let arm = ArmCounter::new(&ArmSettings { lengths, counts, direction, tolerance_deg: 1.0 });
            let most = i64::from(counts) / 4;
            for i in -1000..=1000 {
                let raw = most * i / 1000;
                let exact = (raw * i64::from(direction)) as f64 * 4_294_967_296.0 / f64::from(counts);
                let found = f64::from(arm.angle(raw as i32).unwrap());
                assert!((found - exact).abs() <= 4.0, "{counts} {raw}: {found} {exact}");
            }
        }
        let settings = ArmSettings {
            lengths: super::super::Arm { crank_mm: 1.0, wheel_mm: 1.0, pin_mm: 1.0 },
            counts: 4096,
            direction: -1,
            tolerance_deg: 1.0,
        };
        let arm = ArmCounter::new(&settings);
        assert_eq!(arm.angle(256), Some(-(1 << 28)));
        assert_eq!(arm.angle(-256), Some(1 << 28));
        assert_eq!(arm.angle(1025), None);
        assert_eq!(arm.angle(i32::MIN), None);
    }
}
