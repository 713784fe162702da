//! Encoder scales, and the quick check compared with the full one.

#![allow(clippy::indexing_slicing)]

mod model;

use super::*;
use crate::error::Field;
use crate::machine::AxisOrder;
use crate::position::Nanometres;
use crate::real::Real;
use crate::testing::machine::Machine;
use crate::testing::noise::Noise;
use crate::testing::share::share;
use proptest::prelude::*;
use std::format;

#[test]
fn counts_become_positions_in_either_form() {
    for (offset, resolution) in [(-12.5, 1e-4), (0.0, 2e-5 / 3.0), (3.0, -1e-3)] {
        let double = EncoderScale::<f64>::new(offset, resolution).unwrap();
        let fixed = EncoderScale::<Nanometres>::new(offset, resolution).unwrap();
        for counts in [0, 1, -1, 77_777, -1_234_567] {
            let truth = offset + f64::from(counts) * resolution;
            assert_eq!(double.position(counts), truth);
            assert!((fixed.nanometres(counts).to_f64() - truth).abs() <= 0.51e-6, "{counts}: {truth}");
        }
    }
    for bad in [0.0, f64::NAN, 2.0, f64::INFINITY] {
        assert!(EncoderScale::<f64>::new(0.0, bad).is_err());
    }
    for bad in [f64::INFINITY, f64::NAN, 2e9] {
        assert!(EncoderScale::<f64>::new(bad, 1e-3).is_err());
    }
    assert!(EncoderScale::<Nanometres>::new(2148.0, 1e-3).is_err());
}

#[test]
fn counts_beyond_the_range_saturate_and_are_no_reading() {
    let scale = EncoderScale::<Nanometres>::new(0.0, 1e-3).unwrap();
    for counts in [3_000_000, -3_000_000, 2_147_484, i32::MAX, i32::MIN] {
        let end = Nanometres(if counts > 0 { i32::MAX } else { i32::MIN });
        assert_eq!((scale.position(counts), scale.nanometres(counts)), (end, end), "{counts}");
        assert!(!end.is_usable());
    }
    // A coarse encoder over its whole count range: an i32 would lose multiples of 2^32 nm.
    let coarse = EncoderScale::<Nanometres>::new(-1000.0, 1.0).unwrap();
    for counts in [i32::MAX, i32::MIN, 4295, 8590] {
        assert_eq!(coarse.position(counts), coarse.nanometres(counts), "{counts}");
    }
    assert_eq!(coarse.nanometres(3000), Nanometres(2_000_000_000));
}

/// Steps of a walk in counts: any allowed step, the largest ones more often.
fn steps(span: i64) -> impl Strategy<Value = std::vec::Vec<i64>> {
    let most = span / 4;
    let one = prop_oneof![Just(most), Just(-most), Just(0), -most..=most, -3i64.min(most)..=3i64.min(most)];
    // Occasionally a long run in one direction, so that the counter wraps repeatedly.
    let straight = (prop_oneof![Just(most), Just(-most)], 1..40usize).prop_map(|(step, n)| std::vec![step; n]);
    prop::collection::vec(prop_oneof![one.prop_map(|step| std::vec![step]), straight], 1..40)
        .prop_map(|walk| walk.concat())
}

/// A counter of `span` counts and a walk on it.
fn walks() -> impl Strategy<Value = (u64, std::vec::Vec<i64>)> {
    prop_oneof![Just(1u64 << 16), Just(1u64 << 32), Just(3_600_000), Just(4), Just(5), 4..=1u64 << 32]
        .prop_flat_map(|span| (Just(span), steps(span as i64)))
}

proptest! {
    /// Compared with a 64-bit counter: wraps in both directions, at the largest allowed speed, at start-up, across
    /// missing and rejected readings, and with both signs of the scale.
    #[test]
    fn a_counter_that_wraps_is_one_of_64_bits(
        (span, walk) in walks(),
        start in -(1i64 << 40)..1 << 40,
        resolution in prop_oneof![Just(1e-6), Just(-1e-6), Just(1e-4), -1e-3..1e-3f64],
        upper in any::<u32>(),
    ) {
        prop_assume!(resolution != 0.0);
        let reading = |truth: i64| {
            let counts = truth.rem_euclid(span as i64) as u32;
            // Bits above the counter's are ignored: the host may extend the sign or not.
            if span.is_power_of_two() && span < 1 << 32 { counts | upper & !(span - 1) as u32 } else { counts }
        };
        let scale = EncoderScale::<f64>::new(-3.25, resolution).unwrap();
        let fixed = EncoderScale::<Nanometres>::new(-3.25, resolution).unwrap();
        let mut counter = WrappingCounter::new(span).unwrap().near(start);
        let mut other = counter;
        let mut truth = start;
        prop_assert_eq!(counter.follow(reading(truth)), Some(truth));
        other.follow(reading(truth));
        for (n, step) in walk.iter().enumerate() {
            truth += step;
            let exact = -3.25 + truth as f64 * resolution;
            prop_assert_eq!(scale.position_beyond(&mut counter, reading(truth)), exact);
            let found = fixed.nanometres_beyond(&mut other, reading(truth));
            if exact.abs() < 2147.0 {
                // 2^-33 nm in the factor per count, over the whole travel.
                let rounding = 0.51 + truth.unsigned_abs() as f64 / 8.5e9;
                prop_assert!((found.to_f64() - exact).abs() <= rounding * 1e-6, "{found:?} {exact}");
            } else if exact.abs() > 2148.0 {
                prop_assert!(!found.is_usable());
            }
            // Just beyond a quarter and as far as possible: rejected, with nothing changed.
            let half = span as i64 / 2;
            for away in [span as i64 / 4 + 1, half].map(|away| away.max(1)) {
                if away <= half && away > span as i64 / 4 {
                    let mut tried = counter;
                    for wrong in [truth + away, truth - away] {
                        prop_assert_eq!(tried.follow(reading(wrong)), None, "{} {}", n, wrong);
                        prop_assert!(scale.position_beyond(&mut tried, reading(wrong)).is_nan());
                        prop_assert!(!fixed.nanometres_beyond(&mut tried, reading(wrong)).is_usable());
                    }
                    prop_assert_eq!(tried, counter);
                }
            }
        }
        prop_assert_eq!(counter, other);
    }
}

#[test]
fn the_first_reading_of_a_counter_is_the_one_nearest() {
    for (counts, signed) in [(0, 0), (0x7fff, 0x7fff), (0x8000, -0x8000), (0xffff, -1), (0xffff_8000, -0x8000)] {
        let mut counter = WrappingCounter::BITS_16;
        assert_eq!(counter.follow(counts), Some(signed), "{counts}");
    }
    for counts in [0, 1, -1, i32::MAX, i32::MIN] {
        let mut counter = WrappingCounter::BITS_32;
        assert_eq!(counter.follow(counts as u32), Some(i64::from(counts)));
        let scale = EncoderScale::<f64>::new(1.0, 1e-6).unwrap();
        assert_eq!(scale.position_beyond(&mut counter, counts as u32), scale.position(counts));
    }
    // A turn of 3,600,000 counts, switched off at 5.25 turns and then turned back slightly by hand.
    let turn = WrappingCounter::new(3_600_000).unwrap();
    assert_eq!(turn.near(18_900_000).follow(800_000), Some(18_800_000));
    assert_eq!(turn.near(18_000_010).follow(3_599_990), Some(17_999_990));
    assert_eq!(turn.near(-10).follow(20), Some(20));
    // A count outside the span.
    assert_eq!(turn.near(0).follow(3_600_000), None);
    // Counts were lost: the counter is restarted.
    let mut counter = WrappingCounter::BITS_16;
    assert_eq!((counter.follow(100), counter.follow(30_000)), (Some(100), None));
    counter = counter.near(30_000);
    assert_eq!((counter.follow(30_001), counter.follow(40_000)), (Some(30_001), Some(40_000)));
    for (span, right) in [(3, false), (4, true), (1 << 32, true), (1 << 32 | 1, false), (0, false), (u64::MAX, false)] {
        assert_eq!(WrappingCounter::new(span).is_ok(), right, "{span}");
    }
}

/// A cycle of a random program: mostly smooth, occasionally with a fault of any kind.
fn random_cycle<P: Position>(random: &mut Noise, command: &mut [f64; 3], feedback: &mut [f64; 3]) -> Input<P, 3> {
    let rarely = |random: &mut Noise, share: f64| random.unit() < share;
    let bad = [f64::NAN, f64::INFINITY, -1e12, 2_147.483_647, 1e9, -0.0];
    let mut elapsed_ns = PERIOD_NS;
    if rarely(random, 0.01) {
        elapsed_ns = (f64::from(PERIOD_NS) * 20.0 * random.unit()) as u32;
    }
    for (command, feedback) in command.iter_mut().zip(feedback.iter_mut()) {
        // Jumps at the limit of 0.1 mm, approached from both sides.
        let way = if rarely(random, 0.02) { 0.1000005 } else { 0.05 };
        *command = (*command + way * random.signed()).clamp(-0.2, 100.2);
        if !rarely(random, 0.3) {
            *feedback = *command + 0.011 * random.signed();
        }
    }
    let mut seen = [*command, *feedback];
    if rarely(random, 0.02) {
        let axis = random.below(3);
        let which = usize::from(rarely(random, 0.7));
        seen[which][axis] = bad[random.below(bad.len())];
    }
    let [command, feedback] = seen.map(|positions| positions.map(P::of));
    Input {
        command,
        feedback,
        homed: !rarely(random, 0.003),
        enable: !rarely(random, 0.003),
        reset: rarely(random, 0.2),
        encoder_alarm: u8::from(rarely(random, 0.01)) << 1,
        refusal: if rarely(random, 0.002) { Refusal { fault: Fault::ToolUnreachable, slot: 2 } } else { Refusal::NONE },
        ..Input::at_rest(elapsed_ns)
    }
}

const PERIOD_NS: u32 = 100_000;

fn the_quick_check_agrees_with_the_full_check<R: Real, P: Position>(seed: u64) {
    let machine = Machine::three_axis().travel([0.0, 100.0], 1.0).settings();
    let order = AxisOrder::<3>::of(&machine).unwrap();
    let sampler = Sampler::<R, P, 3>::new(&order, &machine, PERIOD_NS);
    let mut random = Noise::new(seed);
    let (mut quick, mut thorough) = (SampleState::<R, P, 3>::new(), SampleState::<R, P, 3>::new());
    let (mut command, mut feedback) = ([50.0; 3], [50.0; 3]);
    let mut passed_quickly = 0;
    let mut faults = std::collections::BTreeSet::new();
    for cycle in 0..share(100_000) {
        let input = random_cycle::<P>(&mut random, &mut command, &mut feedback);
        // The drives are sent the commands.
        let sent = thorough.commanded();
        let calm = sampler.quick_check(&mut quick, &input)
            && (sampler.compares_nothing(&mut quick) || !sampler.compare(&mut quick, &input, &sent));
        passed_quickly += usize::from(calm);
        let mut trusted = [[[P::default(); 3]; 2]; 2];
        let [by_quick_check, by_full_check] = &mut trusted;
        let seen =
            if calm { Sample::calm(&input) } else { sampler.full_check(&mut quick, &input, &sent, by_quick_check) };
        let expected = sampler.full_check(&mut thorough, &input, &sent, by_full_check);
        assert_eq!(format!("{seen:?}"), format!("{expected:?}"), "{cycle}: {input:?}");
        faults.insert(seen.fault as u8);
        if random.unit() < 0.001 {
            quick.latch(Fault::JointRange, 1);
            thorough.latch(Fault::JointRange, 1);
        } else {
            quick.accept(expected.command);
            thorough.accept(expected.command);
        }
        assert_eq!(format!("{quick:?}"), format!("{thorough:?}"), "{cycle}: {input:?}");
        // The next command starts from the held one, so that a reset finds it near.
        command = expected.command.map(P::to_f64);
    }
    assert!((share(10_000)..share(90_000)).contains(&passed_quickly), "{passed_quickly}");
    assert!(faults.len() > 8, "{faults:?}");
}

#[test]
fn the_quick_check_agrees_with_the_full_check_in_either_form() {
    the_quick_check_agrees_with_the_full_check::<f64, f64>(1);
    the_quick_check_agrees_with_the_full_check::<f32, Nanometres>(2);
    the_quick_check_agrees_with_the_full_check::<f32, f64>(3);
}
