//! Encoder scales, and the glance against the whole decision.

#![allow(clippy::indexing_slicing)]

mod model;

use super::*;
use crate::position::Nanometres;
use crate::testing::machine::Machine;
use crate::testing::noise::Noise;
use crate::testing::share::share;
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
    // A coarse encoder over all its counts: 2^32 turns of the integer would be lost.
    let coarse = EncoderScale::<Nanometres>::new(-1000.0, 1.0).unwrap();
    for counts in [i32::MAX, i32::MIN, 4295, 8590] {
        assert_eq!(coarse.position(counts), coarse.nanometres(counts), "{counts}");
    }
    assert_eq!(coarse.nanometres(3000), Nanometres(2_000_000_000));
}

/// A cycle of a random program: mostly smooth, with every kind of fault now and then.
fn random_cycle<P: Position>(random: &mut Noise, command: &mut [f64; 3], feedback: &mut [f64; 3]) -> Input<P, 3> {
    let rarely = |random: &mut Noise, share: f64| random.unit() < share;
    let bad = [f64::NAN, f64::INFINITY, -1e12, 2_147.483_647, 1e9, -0.0];
    let mut elapsed_ns = PERIOD_NS;
    if rarely(random, 0.01) {
        elapsed_ns = (f64::from(PERIOD_NS) * 20.0 * random.unit()) as u32;
    }
    for (command, feedback) in command.iter_mut().zip(feedback.iter_mut()) {
        // Jumps at the limit of 0.1 mm, and to it from both sides.
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

fn a_glance_says_what_a_look_says<R: Real, P: Position>(seed: u64) {
    let machine = Machine::three_axis().travel([0.0, 100.0], 1.0).settings();
    let order = AxisOrder::<3>::of(&machine).unwrap();
    let sampler = Sampler::<R, P, 3>::new(&order, &machine, PERIOD_NS);
    let mut random = Noise::new(seed);
    let (mut quick, mut thorough) = (SampleState::<P, 3>::new(), SampleState::<P, 3>::new());
    let (mut command, mut feedback) = ([50.0; 3], [50.0; 3]);
    let mut glances = 0;
    let mut faults = std::collections::BTreeSet::new();
    for cycle in 0..share(100_000) {
        let input = random_cycle::<P>(&mut random, &mut command, &mut feedback);
        let calm = sampler.glance(&mut quick, &input);
        glances += usize::from(calm);
        let mut believed = [[[P::default(); 3]; 2]; 2];
        let [by_glance, by_look] = &mut believed;
        let seen = if calm { Sample::calm(&input) } else { sampler.look(&mut quick, &input, by_glance) };
        let looked = sampler.look(&mut thorough, &input, by_look);
        assert_eq!(format!("{seen:?}"), format!("{looked:?}"), "{cycle}: {input:?}");
        faults.insert(seen.fault as u8);
        if random.unit() < 0.001 {
            quick.latch(Fault::JointRange, 1);
            thorough.latch(Fault::JointRange, 1);
        } else {
            quick.accept(looked.command);
            thorough.accept(looked.command);
        }
        assert_eq!(format!("{quick:?}"), format!("{thorough:?}"), "{cycle}: {input:?}");
        // The next command goes on from the held one, so that a reset finds it near.
        command = looked.command.map(P::to_f64);
    }
    assert!((share(10_000)..share(90_000)).contains(&glances), "{glances}");
    assert!(faults.len() > 8, "{faults:?}");
}

#[test]
fn a_glance_says_what_a_look_says_in_either_form() {
    a_glance_says_what_a_look_says::<f64, f64>(1);
    a_glance_says_what_a_look_says::<f32, Nanometres>(2);
    a_glance_says_what_a_look_says::<f32, f64>(3);
}
