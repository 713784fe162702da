//! The gauge's stages, N = 1024, at nine and a half cycles per point.

use crate::arena::Arena;
use core::hint::black_box;
use cortex_m_semihosting::hprintln;

use trueaxis::roundness::{
    Arm, ArmSettings, Band, Followed, Gauge, GaugeSettings, GaugeState, InfeedSettings, ProbeAngles, Probes,
};
use trueaxis::{Axis, Real};
use trueaxis_cortex_m::timer::{Tally, timed};

const POINTS: usize = 1024;
/// Units of work: forward transform, pairs, harmonics kept and inverse of 1024 points, and the eleven units between them.
const TRANSFORM_UNITS: usize = 512 + 256 + 127 + 512 + 11;

fn settings(whole: bool) -> GaugeSettings {
    let mut settings = GaugeSettings::with_defaults(POINTS as u16, ProbeAngles::Slots { p: 188, q: 667 }, 1 << 22);
    settings.revolutions = 1;
    if whole {
        settings.angles = ProbeAngles::Degrees { phi2: 66.1, phi3: 234.5 };
        settings.filter = Some(50);
        let lengths = Arm { crank_mm: 45.0, wheel_mm: 300.0, pin_mm: 27.5 };
        settings.arm = Some(ArmSettings { lengths, counts: 1 << 22, direction: 1, tolerance_deg: 90.0 });
        settings.infeed = Some(InfeedSettings {
            axis: Axis::X,
            direction: 1,
            band: Band { first: 2, last: 50 },
            gain: 0.25,
            delay_revolutions: 2,
            contact_deg: 180.0,
            drive_delay_s: 0.001,
            limit_um: 1000.0,
            noise_gain_limit: 10.0,
        });
    }
    settings
}

/// A stage with all its data.
struct Stage<'a, R: Real> {
    gauge: &'a Gauge<R, POINTS>,
    state: *mut GaugeState<R, POINTS>,
    probes: Probes<R>,
}

impl<R: Real> Stage<'_, R> {
    #[allow(clippy::mut_from_ref)]
    fn state(&self) -> &mut GaugeState<R, POINTS> {
        // SAFETY: one stage at a time, in one thread.
        unsafe { &mut *self.state }
    }
}

#[inline(never)]
fn nothing<R: Real>(stage: &Stage<'_, R>) -> u32 {
    black_box(stage);
    0
}

#[inline(never)]
fn sample<R: Real>(stage: &Stage<'_, R>) -> u32 {
    u32::from(stage.gauge.sample(stage.state(), &stage.probes, Followed::Whole).0)
}

#[inline(never)]
fn work<R: Real>(stage: &Stage<'_, R>) -> u32 {
    u32::from(stage.gauge.work(stage.state()))
}

#[inline(never)]
fn infeed<R: Real>(stage: &Stage<'_, R>) -> u32 {
    stage.gauge.infeed(stage.state()).to_i32() as u32
}

fn count<R: Real>(name: &str, whole: bool, gauge: &mut Gauge<R, POINTS>, state: &mut GaugeState<R, POINTS>) {
    match Gauge::build(&settings(whole), 100_000) {
        Ok(built) => *gauge = built,
        Err(error) => panic!("{}", error),
    }
    gauge.restart(state);
    let mut stage = Stage { gauge, state, probes: Probes::default() };
    let frame = timed(nothing, &stage).0;
    let (mut sampling, mut slices, mut transform, mut feeding) =
        (Tally::default(), Tally::default(), Tally::default(), Tally::default());
    let mut finished = 0;
    // Nine and a half cycles per point.
    for cycle in 0i32..32_000 {
        let counts = cycle * 431 - 1000;
        let before = counts - 431;
        stage.probes.spindle = counts;
        stage.probes.index =
            (counts.div_euclid(1 << 22) != before.div_euclid(1 << 22)).then_some(counts & !((1 << 22) - 1));
        stage.probes.readings = [R::of_i32(cycle & 63), R::of_i32(cycle & 31), R::of_i32(cycle & 127)];
        let idle = stage.state().is_settled();
        let taken = timed(sample, &stage).0 - frame;
        if cycle > 100 {
            sampling.add(taken);
        }
        let was_idle = stage.state().is_settled();
        let (taken, evaluated) = timed(work, &stage);
        if !was_idle {
            slices.add(taken - frame);
            if slices.count() <= TRANSFORM_UNITS as u32 {
                transform.add(taken - frame);
            }
        }
        finished += evaluated;
        feeding.add(timed(infeed, &stage).0 - frame);
        if finished == 1 && idle {
            break;
        }
    }
    let arm = if whole { "_whole" } else { "" };
    hprintln!("{} sampling{} {}", name, arm, sampling);
    hprintln!("{} slice{} {}", name, arm, slices);
    if whole {
        hprintln!("{} infeed {}", name, feeding);
    } else {
        hprintln!("{} transform {}", name, transform);
    }
}

/// Counts the stages with the default settings and with every option of a gauge.
pub fn all<R: Real>(name: &str, arena: &mut Arena) {
    let gauge = match Gauge::build(&settings(false), 100_000) {
        Ok(gauge) => gauge,
        Err(error) => panic!("{}", error),
    };
    let gauge = arena.keep(gauge);
    let state = arena.keep(GaugeState::new());
    count::<R>(name, false, gauge, state);
    count::<R>(name, true, gauge, state);
}
