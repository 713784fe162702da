//! Cycles that pass the quick check, and arbitrary input.

use super::*;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop_assert_eq};
use std::format;
use std::string::String;
use std::vec;

/// A stretch of cycles.
#[derive(Clone, Copy, Debug)]
enum Stretch {
    /// Constant speed, turns per cycle; negative is backwards.
    Turn(f64),
    /// The speed changes uniformly to this one.
    Change(f64),
    /// A flicker of this many turns.
    Flicker(f64),
    /// This many counts are lost at once.
    Lost(i32),
    /// No index pulses.
    Deaf,
    /// A reading.
    Reading(usize, f64),
    /// The infeed was not followed, or the wheel is not grinding.
    Ineffective(Followed, bool),
    NewPart,
}

fn stretches() -> impl Strategy<Value = Stretch> {
    let speed = || (-12.0f64..-5.0).prop_map(libm::exp2);
    proptest::prop_oneof![
        4 => speed().prop_map(Stretch::Turn),
        1 => speed().prop_map(|speed| Stretch::Turn(-speed)),
        2 => speed().prop_map(Stretch::Change),
        1 => Just(Stretch::Turn(0.0)),
        1 => speed().prop_map(Stretch::Flicker),
        1 => any::<i32>().prop_map(Stretch::Lost),
        1 => (1..1 << 16).prop_map(Stretch::Lost),
        1 => Just(Stretch::Deaf),
        1 => (0..3usize, any::<f64>()).prop_map(|(probe, value)| Stretch::Reading(probe, value)),
        1 => (0..3usize, -1200.0..1200.0).prop_map(|(probe, value)| Stretch::Reading(probe, value)),
        1 => any::<bool>().prop_map(|idle| Stretch::Ineffective(Followed::Limited, idle)),
        1 => Just(Stretch::NewPart),
    ]
}

/// Runs two states over the same cycles, one of them with a full check of each.
struct Both {
    quick: Run<f64, 64>,
    full: Run<f64, 64>,
    truth: Truth,
    lost: i32,
    direction: i32,
    quickly_checked: usize,
}

impl Both {
    fn cycle(&mut self, step: f64, change: impl Fn(&mut Probes<f64>) -> Followed) -> Result<(), String> {
        let before = self.quick.alpha;
        self.quick.alpha += step * TAU;
        let mut probes = probes(&self.truth, self.quick.alpha, before);
        probes.spindle = probes.spindle.wrapping_add(self.lost).wrapping_mul(self.direction);
        probes.index = probes.index.map(|index| index.wrapping_add(self.lost).wrapping_mul(self.direction));
        let followed = change(&mut probes);
        let plain = self.quick.state.resampler.plain;
        self.full.state.resampler.plain = 0;
        let [a, b] = [&mut self.quick, &mut self.full].map(|run| run.gauge.update(&mut run.state, &probes, followed));
        let (a, b, quick, full) = (a, b, &self.quick.state, &self.full.state);
        self.quickly_checked += usize::from(plain != 0);
        let (mut quick_resampler, full_resampler) = (quick.resampler, full.resampler);
        quick_resampler.plain = full_resampler.plain;
        let same = a == b
            && quick_resampler == full_resampler
            && quick.sampling == full.sampling
            && quick.counts == full.counts;
        if same {
            Ok(())
        } else {
            Err(format!("{a:?} {b:?}\n{quick_resampler:?}\n{full_resampler:?}\n{:?}", quick.sampling))
        }
    }
}

proptest::proptest! {
    #![proptest_config(ProptestConfig::with_cases(crate::testing::share::share(150) as u32))]

    /// The quick check gives the result of the full check, bit for bit: over random speeds, reversals, lost counts, missing
    /// pulses, readings outside their range, with and without an arm.
    #[test]
    fn the_quick_check_gives_what_the_full_check_gives(
        arm in any::<bool>(), index in any::<bool>(), backward in any::<bool>(), shifted in any::<bool>(),
        stretches in proptest::collection::vec((stretches(), 1..400usize), 1..12),
    ) {
        let (mut settings, truth) = if arm { (super::settings(64, small().0.angles, true), None) } else { let (s, t) = small(); (s, Some(t)) };
        settings.band.last = 12;
        (settings.stop_s, settings.spindle.index) = (0.02, index);
        settings.spindle.direction = if backward { -1 } else { 1 };
        if shifted {
            settings.probes[1].range = [-20.0, 400.0];
        }
        let truth = truth.unwrap_or_else(|| Truth::new(&settings, 12));
        let mut both = Both {
            quick: Run::new(&settings), full: Run::new(&settings), truth, lost: 0,
            direction: if backward { -1 } else { 1 }, quickly_checked: 0,
        };
        let mut speed = 1.0 / 900.0;
        for (stretch, cycles) in [(Stretch::Turn(speed), 1800)].into_iter().chain(stretches) {
            let target = match stretch {
                Stretch::Turn(turns) => { speed = turns; turns }
                Stretch::Change(to) => to,
                _ => speed,
            };
            if let Stretch::Lost(counts) = stretch {
                both.lost = both.lost.wrapping_add(counts);
            }
            let rate = (target - speed) / cycles as f64;
            for cycle in 0..cycles {
                speed += rate;
                let step = match stretch {
                    Stretch::Flicker(turns) => if cycle % 2 == 0 { turns } else { -turns },
                    _ => speed,
                };
                let done = both.cycle(step, |probes| match stretch {
                    Stretch::Deaf => { probes.index = None; Followed::Whole }
                    Stretch::Reading(probe, value) => { if cycle == 0 { probes.readings[probe] = value; } Followed::Whole }
                    Stretch::Ineffective(followed, idle) => { probes.idle = idle; followed }
                    Stretch::NewPart => { probes.new_part = cycle == 0; Followed::Whole }
                    _ => Followed::Whole,
                });
                prop_assert_eq!(done, Ok(()), "{:?} cycle {}", stretch, cycle);
            }
        }
        let [a, b] = [&both.quick.state, &both.full.state];
        prop_assert_eq!(a.sums, b.sums);
        prop_assert_eq!(a.motion(), b.motion());
        proptest::prop_assert!(both.quickly_checked > 800, "{}", both.quickly_checked);
    }
}

proptest::proptest! {
    #![proptest_config(ProptestConfig::with_cases(crate::testing::share::share(200) as u32))]

    /// Arbitrary readings and counts never cause a panic, nor an infeed beyond its bound.
    #[test]
    fn no_input_breaks_the_gauge(
        seed in proptest::collection::vec((proptest::num::f64::ANY, proptest::num::i32::ANY, 0u8..8), 50..400),
    ) {
        let (mut settings, truth) = small();
        settings.infeed = Some(InfeedSettings {
            axis: crate::Axis::X, direction: 1, band: Band { first: 2, last: 8 }, gain: 0.25, delay_revolutions: 1,
            contact_deg: 10.0, drive_delay_s: 0.001, limit_um: 3.0, noise_gain_limit: 10.0,
        });
        let mut run = Run::<f32, 64>::new(&settings);
        run.turn(&truth, 3.0, |_| TAU / 700.0);
        for (reading, count, kind) in seed {
            let before = run.alpha;
            run.alpha += TAU / 300.0;
            let mut probes = probes(&truth, run.alpha, before);
            match kind {
                0 => probes.readings[1] = reading,
                1 => probes.spindle = count,
                2 => probes.index = Some(count),
                3 => probes.arm = count,
                4 => probes.new_part = count % 97 == 0,
                _ => {}
            }
            let cycle = run.cycle(&probes);
            // Between the points the cubic may exceed them slightly.
            proptest::prop_assert!(cycle.infeed.abs() <= 3.0e-3 * 1.3, "{}", cycle.infeed);
        }
    }
}
