//! The profile and motion found, compared with the sums of harmonics that generated them.

use super::*;
use crate::error::Field;

/// Separation from time samples: eight or more per point, whole-slot and other angles, arm still and following.
fn separates<const N: usize>(angles: ProbeAngles, arm: bool, noise_gain: f64) {
    let settings = settings(N as u16, angles, arm);
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, N>::new(&settings);
    run.turn(&truth, 3.95, |_| TAU / (N as f64 * 9.3));
    assert_eq!(run.state.latest().unwrap().revolution, 2, "{angles:?}");
    assert!(run.state.is_settled());
    let (profile, motion) = (run.profile_error(&truth), run.motion_error(&truth));
    std::println!("N {N} {angles:?} arm {arm}: profile {profile:.1e} um, motion {motion:.1e} um");
    assert!(profile < 1e-3 && motion < 1e-3, "{angles:?} {arm}: {profile:e} {motion:e}");
    // The parabola is more accurate than that where the probes see well.
    assert!(profile < 3e-5 * noise_gain && motion < 3e-5 * noise_gain, "{angles:?} {arm}: {profile:e} {motion:e}");
    for (k, amplitude, phase) in &truth.profile {
        let [a, b] = run.state.harmonic(*k as usize);
        assert!((a - amplitude * phase.cos()).abs() < 1e-4, "{k}");
        assert!((b + amplitude * phase.sin()).abs() < 1e-4, "{k}");
    }
}

#[test]
fn separates_within_a_nanometre_from_time_samples() {
    for arm in [false, true] {
        separates::<1024>(BEST_1024, arm, 3.2);
        separates::<512>(BEST_512, arm, 3.4);
        for (phi2, phi3) in [(90.0, 181.05), (60.82, 240.12)] {
            separates::<1024>(ProbeAngles::Degrees { phi2, phi3 }, arm, 20.0);
            separates::<512>(ProbeAngles::Degrees { phi2, phi3 }, arm, 20.0);
        }
        separates::<1024>(ProbeAngles::Degrees { phi2: 66.1, phi3: 234.47 }, arm, 3.5);
    }
}

#[test]
fn single_precision_separates_to_ten_nanometres() {
    let settings = settings(1024, BEST_1024, true);
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f32, 1024>::new(&settings);
    run.turn(&truth, 3.95, |_| TAU / 9500.0);
    let (profile, motion) = (run.profile_error(&truth), run.motion_error(&truth));
    std::println!("f32: profile {profile:.1e} um, motion {motion:.1e} um");
    assert!(profile < 1e-4 && motion < 1e-4, "{profile:e} {motion:e}");
}

#[test]
fn a_changing_speed_is_flagged_and_costs_nothing() {
    let settings = settings(512, BEST_512, false);
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, 512>::new(&settings);
    // From 8 to 24 cycles per point within every turn.
    run.turn(&truth, 3.95, |alpha| TAU / 512.0 / (16.0 + 8.0 * alpha.sin()));
    assert!(run.state.latest().unwrap().flags.has(GaugeFlags::SPEED));
    let (profile, motion) = (run.profile_error(&truth), run.motion_error(&truth));
    assert!(profile < 5e-5 && motion < 5e-5, "{profile:e} {motion:e}");
    let mut steady = Run::<f64, 512>::new(&settings);
    steady.turn(&truth, 3.95, |_| TAU / 5000.0);
    assert!(steady.state.latest().unwrap().flags.is_empty());
}

#[test]
fn peak_to_valley_is_that_of_the_filtered_profile() {
    for (filter, transmission) in [(None, 1.0), (Some(15), 0.5_f64)] {
        let mut settings = settings(512, BEST_512, false);
        settings.filter = filter;
        let mut truth = Truth::new(&settings, 50);
        truth.profile = std::vec![(15.0, 1.0, 0.3)];
        let mut run = Run::<f64, 512>::new(&settings);
        run.turn(&truth, 2.95, |_| TAU / 6000.0);
        // 512 points do not hit every crest of fifteen waves exactly.
        let found = run.state.latest().unwrap().peak_to_valley_um;
        assert!((found - 2.0 * transmission).abs() < 4e-3, "{filter:?} {found}");
        assert!((run.state.profile()[0] - 0.3_f64.cos()).abs() < 1e-4, "the profile itself is not filtered");
    }
}

#[test]
fn blind_harmonics_are_suppressed_and_blind_bands_refused() {
    let close = ProbeAngles::Degrees { phi2: 90.0, phi3: 135.02 };
    let mut settings = settings(512, close, false);
    settings.noise_gain_limit = 30.0;
    let gauge = Gauge::<f64, 512>::build(&settings, 100_000).unwrap();
    let suppressed: Vec<usize> = (2..=50).filter(|k| gauge.is_suppressed(*k)).collect();
    assert!(suppressed.contains(&7) && suppressed.contains(&9) && suppressed.len() < 14, "{suppressed:?}");
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, 512>::new(&settings);
    run.turn(&truth, 2.95, |_| TAU / 6000.0);
    for k in 2..=50 {
        assert_eq!(run.state.harmonic(k) == [0.0; 2], suppressed.contains(&k), "{k}");
    }
    settings.angles = ProbeAngles::Degrees { phi2: 90.0, phi3: 135.0 };
    let error = Gauge::<f64, 512>::build(&settings, 100_000).unwrap_err();
    assert_eq!((error.field, error.found), (Field::ProbeAngles, 7.0));
    settings.angles = BEST_512;
    assert!(Gauge::<f64, 1024>::build(&settings, 100_000).is_err(), "another capacity");
    assert!(Gauge::<f64, 512>::build(&settings, 10).is_err(), "period");
}

/// A shrinking radius is not a profile, and a nonzero radius is not a motion, with and without the arm.
#[test]
fn size_and_its_change_enter_neither_profile_nor_motion() {
    for arm in [false, true] {
        let settings = settings(512, BEST_512, arm);
        let truth = Truth::new(&settings, 50);
        let mut run = Run::<f64, 512>::new(&settings);
        let end = run.alpha + 4.95 * TAU;
        while run.alpha < end {
            let before = run.alpha;
            run.alpha += TAU / 6000.0;
            let mut probes = probes(&truth, run.alpha, before);
            let theta = run.alpha + truth.beta(run.alpha);
            probes.readings = probes.readings.map(|h| h + 30.0 - 2.0 * theta / TAU);
            run.cycle(&probes);
        }
        let (profile, motion) = (run.profile_error(&truth), run.motion_error(&truth));
        assert!(profile < 1e-4 && motion < 1e-4, "{arm} {profile:e} {motion:e}");
    }
}
