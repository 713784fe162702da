#![allow(clippy::indexing_slicing)]

use super::*;
use crate::testing::noise::Noise;
use proptest::prelude::*;

const T: f64 = 1e-4;
const LIMITS: Limits = Limits { magnitude: 0.1, slope_per_s: 1.0, acceleration_per_s2: 200.0 };

/// Checks every cycle against the three limits.
struct Checker {
    c: f64,
    v: f64,
    worst: [f64; 3],
}
impl Checker {
    fn new() -> Self {
        Checker { c: 0.0, v: 0.0, worst: [0.0; 3] }
    }
    fn cycle(&mut self, sent: f64, limits: &Limits) {
        let velocity = sent - self.c;
        let (magnitude, slope, acceleration) =
            (limits.magnitude, limits.slope_per_s * T, limits.acceleration_per_s2 * T * T);
        let now = [sent.abs() / magnitude, velocity.abs() / slope, (velocity - self.v).abs() / acceleration];
        for (worst, now) in self.worst.iter_mut().zip(now) {
            *worst = worst.max(now);
        }
        (self.c, self.v) = (sent, velocity);
    }
    fn assert(&self, relative: f64) {
        assert!(self.worst.iter().all(|w| *w <= 1.0 + relative), "{:?} of the limits", self.worst);
    }
}

#[test]
fn a_step_of_50_um_takes_55_4_ms_without_overshoot() {
    let limiter = Limiter::<f64>::new(&LIMITS, T).unwrap();
    let mut state = LimiterState::default();
    let mut check = Checker::new();
    let mut cycles = 0;
    while limiter.follow(&mut state, 0.05) {
        check.cycle(state.sent(), &LIMITS);
        assert!(state.sent() <= 0.05);
        cycles += 1;
        assert!(cycles < 1000);
    }
    check.assert(1e-6);
    // Ideal: 50 ms at full speed plus 5 ms of acceleration.
    assert!((550..=556).contains(&cycles), "{cycles} cycles");
}

#[test]
fn locks_on_to_a_moving_sine_without_overshoot_and_then_passes_it_bit_for_bit() {
    let limiter = Limiter::<f64>::new(&LIMITS, T).unwrap();
    let mut state = LimiterState::default();
    let mut check = Checker::new();
    let sine = |n: u32| 0.03 + 0.02 * (f64::from(n) * T * 20.0).sin(); // peak acceleration 0.04 of the limit
    let mut locked_at = None;
    for n in 0..20_000 {
        let limited = limiter.follow(&mut state, sine(n));
        check.cycle(state.sent(), &LIMITS);
        match locked_at {
            None if !limited => locked_at = Some(n),
            None => assert!(state.sent() < sine(n), "overshoot in cycle {n}"),
            Some(_) => assert!(!limited && state.sent().to_bits() == sine(n).to_bits(), "lock lost in cycle {n}"),
        }
    }
    check.assert(1e-6);
    assert!(locked_at.is_some_and(|n| n < 1500), "{locked_at:?}");
}

/// Ten million cycles of steps, ramps, sines, noise, and freezes; half of them in single precision.
#[test]
fn never_exceeds_a_limit_and_always_settles() {
    fn run<R: Real>(seed: u64, cycles: u32, relative: f64) {
        let mut random = Noise::new(seed);
        let mut done = 0;
        while done < crate::testing::share::share(cycles as usize) as u32 {
            let limits = Limits {
                magnitude: 0.005 + 0.2 * random.unit(),
                slope_per_s: 10f64.powf(-1.0 + 1.5 * random.unit()),
                acceleration_per_s2: 10f64.powf(1.7 + 1.5 * random.unit()),
            };
            let limiter = Limiter::<R>::new(&limits, T).unwrap();
            let mut state = LimiterState::<R>::default();
            let mut check = Checker::new();
            for _ in 0..12 {
                let (level, size) =
                    (1.2 * limits.magnitude * (2.0 * random.unit() - 1.0), limits.magnitude * random.unit());
                let (kind, rate) = ((random.unit() * 6.0) as u32, 200.0 * random.unit());
                let length = 200 + (random.unit() * 4000.0) as u32;
                for n in 0..length {
                    let time = f64::from(n) * T;
                    let wanted = match kind {
                        0 => level,
                        1 => level + size * (rate * time).sin(),
                        2 => level * time * rate,
                        3 => level + 1e-3 * size * random.unit(),
                        4 => 2.0 * limits.magnitude * (2.0 * random.unit() - 1.0),
                        _ => 0.0,
                    };
                    if kind == 5 && n < length / 2 {
                        limiter.freeze(&mut state);
                    } else {
                        limiter.follow(&mut state, R::of(wanted));
                    }
                    check.cycle(state.sent().to_f64(), &limits);
                }
                done += length;
            }
            check.assert(relative);
            // Whatever came before, the correction settles on a target inside the limits.
            let rest = R::of(0.5 * limits.magnitude);
            let longest = (3.0 * limits.magnitude / (limits.slope_per_s * T)
                + 10.0 * limits.slope_per_s / (limits.acceleration_per_s2 * T)) as u32
                + (20.0 * (limits.magnitude / (limits.acceleration_per_s2 * T * T)).sqrt()) as u32;
            let settled = (0..longest).any(|_| !limiter.follow(&mut state, rest));
            assert!(settled && state.sent() == rest, "seed {seed}, {limits:?}: {state:?}");
        }
    }
    run::<f64>(1, 10_000_000, 1e-6);
    // In f32 the difference of two rounded corrections is itself uncertain by a unit in the last place of C.
    run::<f32>(2, 2_000_000, 0.02);
}

#[test]
fn freezing_brakes_within_the_acceleration_and_then_holds() {
    let limiter = Limiter::<f64>::new(&LIMITS, T).unwrap();
    let mut state = LimiterState::default();
    let mut check = Checker::new();
    for _ in 0..100 {
        limiter.follow(&mut state, 0.05);
        check.cycle(state.sent(), &LIMITS);
    }
    for _ in 0..51 {
        limiter.freeze(&mut state);
        check.cycle(state.sent(), &LIMITS);
    }
    let at_rest = state.sent();
    limiter.freeze(&mut state);
    assert_eq!(at_rest.to_bits(), state.sent().to_bits());
    check.assert(1e-6);
}

#[test]
fn limits_lowered_in_motion_are_reached_with_the_acceleration() {
    let wide = Limiter::<f64>::new(&LIMITS, T).unwrap();
    let narrow_limits = Limits { magnitude: 0.02, slope_per_s: 0.5, ..LIMITS };
    let narrow = Limiter::<f64>::new(&narrow_limits, T).unwrap();
    let mut state = LimiterState::default();
    let mut check = Checker::new();
    for _ in 0..400 {
        wide.follow(&mut state, 0.05);
        check.cycle(state.sent(), &LIMITS);
    }
    assert!(state.sent() > 0.02);
    for _ in 0..5000 {
        assert!(narrow.follow(&mut state, 0.05));
        check.cycle(state.sent(), &LIMITS);
    }
    check.assert(1e-6);
    assert!((state.sent() - 0.02).abs() < 1e-12);
}

#[test]
fn refuses_limits_that_are_none() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Limiter::<f64>::new(&Limits { magnitude: bad, ..LIMITS }, T).is_err());
        assert!(Limiter::<f64>::new(&Limits { slope_per_s: bad, ..LIMITS }, T).is_err());
        assert!(Limiter::<f64>::new(&Limits { acceleration_per_s2: bad, ..LIMITS }, T).is_err());
        assert!(Limiter::<f64>::new(&LIMITS, bad).is_err());
    }
    assert!(Limiter::<f32>::new(&Limits { acceleration_per_s2: 1e-6, ..LIMITS }, T).is_err());
}

/// Limits that overflow or vanish in the scalar are refused: 1e39 is infinite in single precision, 1e-46 is zero.
#[test]
fn refuses_limits_that_the_scalar_cannot_hold() {
    use crate::error::Field;
    let large = |x: f64| Limits { magnitude: x, slope_per_s: x / T, acceleration_per_s2: x / T / T };
    let small = Limits { magnitude: 1e-46, slope_per_s: 1e-46 / T, acceleration_per_s2: 1e-46 / T / T };
    let cases = [
        (Limits { acceleration_per_s2: 1e38 / T / T, ..large(1e39) }, Field::Magnitude),
        (Limits { slope_per_s: 1e39 / T, ..large(1e37) }, Field::Slope),
        (Limits { acceleration_per_s2: 1e39 / T / T, ..large(1e37) }, Field::Acceleration),
        // Finite, but the sum of two limits could overflow.
        (large(3e37), Field::Magnitude),
        (small, Field::Magnitude),
        (Limits { slope_per_s: 1e-46 / T, ..LIMITS }, Field::Slope),
    ];
    for (limits, field) in cases {
        let refused = Limiter::<f32>::new(&limits, T).unwrap_err();
        assert_eq!(refused.field, field, "{limits:?}: {refused}");
        assert!(Limiter::<f64>::new(&limits, T).is_ok(), "{limits:?}");
    }
    assert!(Limiter::<f32>::new(&large(2e37), T).is_ok());
    // A product of limits and period that overflows.
    assert!(Limiter::<f64>::new(&Limits { slope_per_s: 1e308, ..LIMITS }, 1e3).is_err());
    let all = |x| Limits { magnitude: x, slope_per_s: x, acceleration_per_s2: x };
    assert!(Limiter::<f64>::new(&all(1.1e307), 1.0).is_ok());
    assert!(Limiter::<f64>::new(&all(1.2e307), 1.0).is_err());
}

proptest! {
    /// A target inside all three limits passes bit for bit from the first cycle.
    #[test]
    fn passes_what_keeps_the_limits(amplitude in 0.0..0.09f64, rate in 0.0..10.0f64) {
        let limiter = Limiter::<f64>::new(&LIMITS, T).unwrap();
        let mut state = LimiterState::default();
        // From rest at zero: amplitude (1 − cos wt), acceleration amplitude w² < a, velocity amplitude w < V.
        let w = rate.min((0.9 * LIMITS.acceleration_per_s2 / amplitude).sqrt()).min(0.9 * LIMITS.slope_per_s / amplitude);
        for n in 0..2000 {
            let r = 0.5 * amplitude * (1.0 - (w * f64::from(n) * T).cos());
            prop_assert!(!limiter.follow(&mut state, r));
            prop_assert_eq!(state.sent().to_bits(), r.to_bits());
        }
    }
}

#[test]
fn the_time_to_ramp_a_step_in_is_the_one_stated() {
    let swift = Limits { magnitude: 0.1, slope_per_s: 5.0, acceleration_per_s2: 5000.0 };
    for limits in [LIMITS, swift] {
        for way in [1e-4, 1e-3, 2.2e-3, 0.01, 0.05, 0.1] {
            let period = 2e-5;
            let limiter = Limiter::<f64>::new(&limits, period).unwrap();
            let mut state = LimiterState::default();
            let cycles = (1..1_000_000).find(|_| !limiter.follow(&mut state, way)).unwrap();
            let (found, stated) = (f64::from(cycles) * period, ramp_in_s(&limits, way));
            // Whole cycles of deceleration, and the last part by rounding.
            assert!((found - stated).abs() <= 0.02 * stated + 4.0 * period, "{way}: {found} {stated}");
        }
    }
}

/// The law as documented in the module, without any of the shortcuts.
fn law(limiter: &Limiter<f64>, state: &LimiterState<f64>, wanted: f64) -> LimiterState<f64> {
    let Limiter { magnitude, velocity: top, acceleration, rounding, .. } = *limiter;
    let LimiterState { sent: c, velocity: v, target: last } = *state;
    let speed = |d: f64, b: f64, eight_over_b: f64| {
        let n = (((1.0 + d * eight_over_b).sqrt() - 1.0) * 0.5).ceil().max(1.0);
        if d <= 0.0 { 0.0 } else { d / n + b * (n - 1.0) * 0.5 }
    };
    let r = wanted.clamp(-magnitude, magnitude);
    let moves = (r - last).clamp(-top, top);
    let gap = r - c - moves;
    let want = moves + gap.signum() * speed(gap.abs(), APPROACH * acceleration, limiter.approach);
    let up = speed(magnitude - c, acceleration, limiter.brake).min(top);
    let down = speed(magnitude + c, acceleration, limiter.brake).min(top);
    let allowed = |x: f64| x.max(-down).min(up).max(v - acceleration).min(v + acceleration);
    let direct = r - c;
    if gap.abs() <= rounding && allowed(direct) == direct {
        return LimiterState { sent: r, velocity: direct, target: r };
    }
    let velocity = allowed(want);
    LimiterState { sent: c + velocity, velocity, target: r }
}

#[test]
fn the_shortcuts_change_no_bit() {
    let mut noise = Noise::new(7);
    for round in 0..200 {
        let limits = Limits {
            magnitude: 10f64.powf(noise.range(-3.0, 0.0)),
            slope_per_s: 10f64.powf(noise.range(-1.0, 1.0)),
            acceleration_per_s2: 10f64.powf(noise.range(1.0, 4.0)),
        };
        let limiter = Limiter::<f64>::new(&limits, T).unwrap();
        // Faster than the limits, as after an exchange for tables with lower ones in motion.
        let mut state = LimiterState { velocity: 3.0 * noise.signed() * limiter.velocity, ..LimiterState::default() };
        let mut wanted = 0.0;
        for cycle in 0..1000 {
            wanted = match noise.below(100) {
                0 => 1.5 * limits.magnitude * noise.signed(),
                1..=3 => wanted + 3.0 * limiter.acceleration * noise.signed(),
                _ => wanted + 0.3 * limiter.velocity,
            };
            let mut next = state;
            limiter.approach(&mut next, wanted);
            assert_eq!(next, law(&limiter, &state, wanted), "{round}, {cycle}: {limits:?} {state:?} {wanted}");
            state = next;
        }
    }
}
