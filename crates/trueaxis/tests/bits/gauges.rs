//! The gauge.

use super::{Sum, check};
use trueaxis::Real;
use trueaxis::machine::Axis;
use trueaxis::roundness::{ArmSettings, Band, Followed, Gauge, GaugeSettings, InfeedSettings, ProbeAngles, Probes};
use trueaxis_testing::machine::ARM;
use trueaxis_testing::noise::Noise;

fn gauge_sum<R: Real, const N: usize>(angles: ProbeAngles, arm: bool) -> u64 {
    const COUNTS: u32 = 1 << 20;
    let mut settings = GaugeSettings::with_defaults(N as u16, angles, COUNTS);
    settings.band.last = 12;
    settings.stop_s = 0.05;
    if arm {
        settings.arm = Some(ArmSettings { lengths: ARM, counts: COUNTS, direction: 1, tolerance_deg: 0.5 });
    }
    let gauge = Gauge::<R, N>::build(&settings, 1_000_000).expect("a gauge");
    let (mut state, mut noise, mut sum) = (Box::new(gauge.start()), Noise::new(66), Sum::new());
    let mut spindle = -1000_i32;
    for cycle in 0..9000 {
        let moved = [5003, 5003, 4200, 5003, 0, 5003, 9000, -300][cycle / 120 % 8 * usize::from(cycle > 6000)];
        let before = spindle;
        spindle += moved;
        let turn = std::f64::consts::TAU * f64::from(spindle) / f64::from(COUNTS);
        let crossed = before.div_euclid(COUNTS as i32) != spindle.div_euclid(COUNTS as i32);
        let index = (crossed && cycle % 1013 != 0).then(|| spindle.div_euclid(COUNTS as i32) * COUNTS as i32);
        let beta = if arm { libm::asin(libm::sin(turn) * 0.134) } else { 0.0 };
        let readings = [0.0, 1.0, 2.3].map(|phi| {
            let angle = turn + phi;
            R::of(
                3.0 * libm::sin(2.0 * angle)
                    + libm::cos(5.0 * angle + 0.3)
                    + 10.0 * libm::cos(phi)
                    + 0.01 * noise.signed(),
            )
        });
        let arm = (beta / std::f64::consts::TAU * f64::from(COUNTS)) as i32;
        let probes = Probes { readings, spindle, index, arm, new_part: cycle == 5000, idle: cycle / 400 == 7 };
        let followed = if cycle / 300 == 9 { Followed::Not } else { Followed::Whole };
        sum.add(&(gauge.update(&mut state, &probes, followed), gauge.infeed(&mut state)));
        if cycle % 200 == 0 {
            sum.add(&(state.latest(), state.counts(), state.profile(), state.motion(), state.correction()));
        }
    }
    assert!(state.latest().is_some(), "no revolution was evaluated");
    sum.0
}

#[test]
fn gauges() {
    let small = ProbeAngles::Slots { p: 11, q: 15 };
    let sums =
        [gauge_sum::<f64, 64>(small, false), gauge_sum::<f64, 64>(small, true), gauge_sum::<f32, 64>(small, true)];
    check(&sums, &[0x6f8f_719b_4414_5f52, 0x6f81_55e4_c6d8_eeb1, 0x92fc_743e_c724_1382]);
}

/// Everything configured: filter, infeed, a wheel, windows of some revolutions, several slices per cycle.
fn full_sum<R: Real, const N: usize>(slices: u8, filter: Option<u16>) -> u64 {
    const COUNTS: u32 = 1 << 20;
    let angles = ProbeAngles::Degrees { phi2: 60.82, phi3: 240.12 };
    let mut settings = GaugeSettings::with_defaults(N as u16, angles, COUNTS);
    settings.band.last = 15;
    (settings.slices_per_cycle, settings.filter, settings.revolutions) = (slices, filter, 3);
    settings.arm = Some(ArmSettings { lengths: ARM, counts: COUNTS, direction: -1, tolerance_deg: 0.5 });
    settings.infeed = Some(InfeedSettings {
        axis: Axis::X,
        direction: -1,
        band: Band { first: 2, last: 9 },
        gain: 0.4,
        delay_revolutions: 1,
        contact_deg: 33.0,
        drive_delay_s: 0.004,
        limit_um: 6.0,
        noise_gain_limit: 100.0,
    });
    let gauge = Gauge::<R, N>::build(&settings, 1_000_000).expect("a gauge");
    let (mut state, mut sum) = (Box::new(gauge.start()), Sum::new());
    let mut noise = Noise::new(67);
    for harmonic in 0..16 {
        sum.add(&gauge.is_suppressed(harmonic));
    }
    sum.add(&(gauge.gain(), gauge.band(), gauge.cycles_of_work(), gauge.infeed_slot()));
    let (mut spindle, mut revolution) = (0_i32, 0);
    for cycle in 0..6000 {
        spindle += 7001;
        let turns = spindle.div_euclid(COUNTS as i32);
        let index = (turns != revolution).then_some(turns * COUNTS as i32);
        revolution = turns;
        let alpha = std::f64::consts::TAU * f64::from(spindle) / f64::from(COUNTS);
        let beta = libm::asin(libm::sin(alpha) * 0.137_404_58);
        let readings = [0.0, 1.061_51, 5.252_34].map(|phi| {
            let at = alpha + beta + phi;
            R::of(
                libm::sin(2.0 * at) + 0.5 * libm::cos(5.0 * at) + 7.0 * libm::cos(phi + beta) + 0.005 * noise.signed(),
            )
        });
        let arm = -(beta / std::f64::consts::TAU * f64::from(COUNTS)) as i32;
        let probes = Probes { readings, spindle, index, arm, new_part: cycle == 4200, idle: cycle / 200 == 17 };
        let followed = [Followed::Whole, Followed::Limited][usize::from(cycle / 500 == 5)];
        if cycle == 2500 {
            sum.add(&gauge.set_wheel(&mut state, 297.0));
        }
        sum.add(&(gauge.update(&mut state, &probes, followed), gauge.infeed(&mut state)));
        if cycle % 250 == 0 {
            sum.add(&(state.latest(), state.counts(), state.profile(), state.motion(), state.correction()));
            for harmonic in 0..16 {
                sum.add(&state.harmonic(harmonic));
            }
        }
    }
    assert!(state.latest().is_some());
    sum.0
}

#[test]
fn gauges_with_everything() {
    let sums = [full_sum::<f64, 128>(1, Some(15)), full_sum::<f64, 256>(4, None), full_sum::<f32, 128>(16, None)];
    check(&sums, &[0x2e19_4c41_1e7d_42cc, 0x2e31_ddc3_8fe6_e86d, 0xeed4_bca4_7940_0af4]);
}
