//! Errors that repeat within a pitch, on records computed from stated harmonics.

use std::f64::consts::TAU;
use trueaxis_metrology::periodic::{Found, PeriodicRefusal, Place, Reading, identify, least_amplitude};
use trueaxis_metrology::uncertainty::Draws;

/// A period and its harmonics a, b.
type Wave<'w> = (f64, &'w [[f64; 2]]);

fn error(waves: &[Wave<'_>], q: f64) -> f64 {
    let harmonic = |(h, of): (usize, &[f64; 2]), period: f64| {
        let at = TAU * (h as f64 + 1.0) * q / period;
        of[0] * at.cos() + of[1] * at.sin()
    };
    waves.iter().flat_map(|(period, of)| of.iter().enumerate().map(move |of| harmonic(of, *period))).sum()
}

fn scanned(positions: impl IntoIterator<Item = f64>, is_negative: bool, of: impl FnMut(f64) -> f64) -> Vec<Reading> {
    let mut of = of;
    let reading = |position: f64| Reading {
        own: Place { position, is_negative, share: 1.0 },
        other: None,
        along: position,
        pass: usize::from(is_negative),
        error: of(position),
    };
    positions.into_iter().map(reading).collect()
}

fn every(step: f64, length: f64) -> impl Iterator<Item = f64> {
    (0..=(length / step).round() as usize).map(move |k| k as f64 * step)
}

/// Deviations of kept harmonics from the true ones, in their standard errors; a true harmonic that is not kept fails.
fn deviations(found: &Found, truth: &[Wave<'_>], deviations: &mut Vec<f64>) {
    for (period, (_, waves)) in found.periods.iter().zip(truth) {
        assert!(period.reverse.is_none(), "{period:?}");
        for (own, truth) in period.forward.iter().zip(waves.iter()) {
            assert!(own.is_kept, "{own:?} of {truth:?}");
            for c in 0..2 {
                deviations.push((own.value[c] - truth[c]) / own.standard_error[c]);
            }
        }
    }
}

/// Bends every 40 to 60 mm, linear between them.
fn table(draws: &mut Draws, length: f64) -> Vec<[f64; 2]> {
    let mut points = vec![[0.0, 0.0]];
    while let Some([at, error]) = points.last().copied().filter(|[at, _]| *at < length) {
        points.push([at + 50.0 + 10.0 * draws.normal().clamp(-1.0, 1.0), error + 2.0 * draws.normal()]);
    }
    points
}

fn at(table: &[[f64; 2]], q: f64) -> f64 {
    let pair = table.windows(2).find(|pair| q <= pair[1][0]).unwrap();
    pair[0][1] + (pair[1][1] - pair[0][1]) * (q - pair[0][0]) / (pair[1][0] - pair[0][0])
}

#[test]
fn random_records_are_found_within_their_standard_errors() {
    let mut all = Vec::new();
    let mut false_ones = 0;
    for seed in 0..200 {
        let mut draws = Draws::new(seed, 0);
        let length = 200.0 + 40.0 * draws.normal().clamp(-1.0, 1.0);
        let slow = table(&mut draws, length);
        let (first, second) = (5.0, 1.3 + 0.2 * draws.normal().clamp(-1.0, 1.0));
        let mut wave = |size: f64| {
            let phase = 10.0 * draws.normal();
            [size * phase.cos(), size * phase.sin()]
        };
        let (one, other) = ([wave(1.5), wave(0.4)], [wave(0.3)]);
        let truth: [Wave<'_>; 2] = [(first, &one), (second, &other)];
        let noise = 0.1 + 0.1 * draws.normal().abs().min(2.0);
        // Even points every other record, otherwise with steps of 0.1 to 0.3 mm.
        let mut at_random = 0.0;
        let positions: Vec<f64> = match seed % 2 {
            0 => every(0.2, length).collect(),
            _ => std::iter::from_fn(|| {
                at_random += 0.2 + 0.1 * draws.normal().clamp(-1.0, 1.0);
                (at_random < length).then_some(at_random)
            })
            .collect(),
        };
        let readings = scanned(positions, false, |q| at(&slow, q) + error(&truth, q) + noise * draws.normal());
        let found = identify(&readings, &[first, second], None).unwrap();
        deviations(&found, &truth, &mut all);
        let beyond = found.periods.iter().zip(truth).flat_map(|(own, (_, of))| own.forward.iter().skip(of.len()));
        false_ones += beyond.filter(|own| own.is_kept).count();
    }
    let rms = (all.iter().map(|own| own * own).sum::<f64>() / all.len() as f64).sqrt();
    println!(
        "periodic: deviations are {rms:.2} of their standard errors, {false_ones} harmonics found that are not there"
    );
    assert_eq!(all.len(), 200 * 6);
    assert!((0.85..1.15).contains(&rms), "RMS {rms}");
    // Of some 1,700 harmonics that are not there, 0.3 % exceed three standard deviations.
    assert!(false_ones < 15, "{false_ones}");
}

/// A cubic and exact harmonics, different in the two directions: nothing but rounding is left.
#[test]
fn without_noise_the_coefficients_are_exact() {
    let forward: [Wave<'_>; 2] = [(5.0, &[[1.9, -0.4], [0.3, 0.2]]), (1.7, &[[-0.25, 0.1]])];
    let reverse: [Wave<'_>; 2] = [(5.0, &[[1.8, -0.5], [0.1, 0.2]]), (1.7, &[[-0.25, 0.1]])];
    let slow = |q: f64| 3.0 + 0.02 * q - 1e-4 * q * q + 1e-6 * q * q * q;
    let mut readings = scanned(every(0.2, 100.0), false, |q| slow(q) + error(&forward, q));
    readings.extend(scanned(every(0.2, 100.0), true, |q| slow(q) - 4.0 + error(&reverse, q)));
    let found = identify(&readings, &[5.0, 1.7], None).unwrap();
    let values = |of: &[trueaxis_metrology::periodic::Harmonic], truth: &[[f64; 2]]| {
        for (own, truth) in of.iter().zip(truth) {
            assert!((0..2).all(|c| (own.value[c] - truth[c]).abs() < 1e-9), "{own:?} for {truth:?}");
        }
    };
    values(&found.periods[0].forward, forward[0].1);
    values(found.periods[0].reverse.as_ref().unwrap(), reverse[0].1);
    values(&found.periods[1].forward, forward[1].1);
    assert_eq!((found.periods[0].highest(), found.periods[1].highest()), (2, 1));
    assert!(found.left < 1e-10 && found.explained > 1.0 - 1e-12 && found.remains.is_none(), "{found:?}");
    let shown = &found.periods[0].forward[0];
    assert!((shown.amplitude() - 1.9_f64.hypot(0.4)).abs() < 1e-9);
    assert!((shown.phase_rad() + (0.4_f64 / 1.9).atan()).abs() < 1e-9);
    // A cos x + B cos 2x about its mean, by hand: from −A + B to A + B.
    let of = trueaxis_metrology::periodic::Period {
        forward: vec![harmonic(1, 2.0), harmonic(2, 0.25)],
        ..found.periods[1].clone()
    };
    assert!((of.peak_to_valley(false) - 4.0).abs() < 1e-9, "{}", of.peak_to_valley(false));
}

fn harmonic(number: usize, cosine: f64) -> trueaxis_metrology::periodic::Harmonic {
    trueaxis_metrology::periodic::Harmonic { number, value: [cosine, 0.0], is_kept: true, ..Default::default() }
}

/// A screw of 5 mm with 3 µm and two harmonics, 0.1 µm of noise.
#[test]
fn a_screw_is_found_within_a_twentieth_of_a_micrometre() {
    let truth: [Wave<'_>; 1] = [(5.0, &[[2.6, -1.5], [0.5, 0.4]])];
    for seed in 0..20 {
        let mut draws = Draws::new(seed, 1);
        let slow = table(&mut draws, 400.0);
        let readings = scanned(every(0.25, 400.0), false, |q| at(&slow, q) + error(&truth, q) + 0.1 * draws.normal());
        let found = identify(&readings, &[5.0], None).unwrap();
        let own = &found.periods[0];
        assert!(
            (0..2000).map(|k| 0.0025 * f64::from(k)).all(|q| { (own.error(q, false) - error(&truth, q)).abs() < 0.05 }),
            "{own:?}"
        );
    }
}

/// Drift like a random walk raises the power at long periods: the standard errors follow.
#[test]
fn standard_errors_contain_the_power_near_the_harmonic() {
    let truth: [Wave<'_>; 1] = [(20.0, &[[1.0, 0.5]])];
    let (mut all, mut widened) = (Vec::new(), 0.0);
    for seed in 0..60 {
        let (mut draws, mut walk) = (Draws::new(seed, 2), 0.0);
        let readings = scanned(every(0.5, 400.0), false, |q| {
            walk = 0.97 * walk + 0.05 * draws.normal();
            error(&truth, q) + walk + 0.02 * draws.normal()
        });
        let found = identify(&readings, &[20.0], Some(1)).unwrap();
        deviations(&found, &truth, &mut all);
        widened += found.widened / 60.0;
    }
    let rms = (all.iter().map(|own| own * own).sum::<f64>() / all.len() as f64).sqrt();
    assert!((0.7..1.3).contains(&rms) && widened > 1.5, "RMS {rms}, widened {widened}");
}

/// The chirp of a screw's error on a circle, beside squareness, scales and lost motion.
#[test]
fn a_circle_shows_the_period_of_each_axis() {
    let (radius, centre) = (100.0, [310.2, 120.7]);
    let (x, y): ([Wave<'_>; 1], [Wave<'_>; 1]) = ([(5.0, &[[1.5, -0.8], [0.3, 0.1]])], [(5.0, &[[-0.7, 0.9]])]);
    let mut all = Vec::new();
    for seed in 0..25 {
        let mut draws = Draws::new(seed, 3);
        let mut readings = Vec::new();
        for (pass, sense) in [(0, 1.0), (1, -1.0)] {
            for degrees in (0..1800).map(|k| 0.2 * f64::from(k) + 0.1) {
                let angle = f64::to_radians(degrees);
                let (sin, cos) = angle.sin_cos();
                let place = |c: usize, share: f64, rate: f64| Place {
                    position: centre[c] + radius * share,
                    is_negative: sense * rate < 0.0,
                    share,
                };
                let own = place(0, cos, -sin);
                let other = place(1, sin, cos);
                let lost = 1.5 * cos * sin.signum() + 0.8 * sense * (2.0 * angle).sin() + 5.0 * (2.0 * angle).cos();
                let error = lost + cos * error(&x, own.position) + sin * error(&y, other.position);
                let error = error + 12.0 * cos + 0.1 * draws.normal();
                readings.push(Reading { own, other: Some(other), along: degrees, pass, error });
            }
        }
        let found = identify(&readings, &[5.0], Some(2)).unwrap();
        deviations(&found, &x, &mut all);
        assert!((found.length - 2.0 * radius).abs() < 0.1);
    }
    let rms = (all.iter().map(|own| own * own).sum::<f64>() / all.len() as f64).sqrt();
    println!("periodic: deviations on circles are {rms:.2} of their standard errors");
    assert!((0.8..1.2).contains(&rms), "RMS {rms}");
}

#[test]
fn periods_that_the_points_do_not_determine_are_refused() {
    let truth: [Wave<'_>; 1] = [(5.0, &[[1.5, -0.8]])];
    let refused = |step: f64, length: f64, periods: &[f64], harmonics: Option<usize>| {
        let readings = scanned(every(step, length), false, |q| error(&truth, q) + 1e-3 * (q * 1e3).sin());
        identify(&readings, periods, harmonics).unwrap_err().to_string()
    };
    assert_eq!(
        refused(5.0, 100.0, &[5.0], None),
        "found points every 5, at which harmonic 1 of the period 5 looks like a constant, needed points every 1.25 at most"
    );
    assert_eq!(
        refused(2.5, 100.0, &[5.0], Some(2)),
        "found points every 2.5, at which harmonic 2 of the period 5 looks like a constant, needed points every 0.625 at most"
    );
    assert_eq!(
        refused(2.0, 100.0, &[10.0, 2.5], Some(1)),
        "found points every 2, at which harmonic 1 of the period 2.5 looks like harmonic 1 of the period 10, needed points every 0.625 at most"
    );
    assert!(refused(4.5, 100.0, &[5.0], None).contains("looks like a wave of 45, needed points every 1.25 at most"));
    assert_eq!(refused(0.2, 14.0, &[5.0], None), "found positions over 14, needed 15 at least, three periods of 5");
    assert_eq!(
        refused(0.2, 50.0, &[5.0, 5.2], None),
        "found the periods 5 and 5.2 over 50, needed 130 at least to separate them"
    );
    assert_eq!(refused(0.2, 50.0, &[5.0, 5.0], None), "found the periods 5 and 5 over 50, needed two that differ");
    assert_eq!(refused(0.2, 50.0, &[-5.0], None), "found a period of -5, needed one above 0");
    let with_unit = PeriodicRefusal::TooShort { period: 5.0, length: 14.0 }.in_unit("mm");
    assert_eq!(with_unit, "found positions over 14 mm, needed 15 mm at least, three periods of 5 mm");
    assert_eq!(refused(0.2, 50.0, &[5.0], Some(9)), "found 9 harmonics, needed 1 to 6");
    let uneven = scanned(every(1.0, 100.0).map(|q| 2.0 * q + (1.7 * q).sin()), false, |q| error(&truth, q));
    let needed = ", needed 1.25 at most: four in a period of harmonic 1 of 5";
    assert!(identify(&uneven, &[5.0], None).unwrap_err().to_string().ends_with(needed));
    let mut wrong = scanned(every(0.2, 50.0), false, |q| error(&truth, q));
    wrong[17].error = f64::NAN;
    assert_eq!(identify(&wrong, &[5.0], None).unwrap_err(), PeriodicRefusal::NotAReading { index: 17 });
}

/// The second harmonic of one period is the first of another: it counts for the other.
#[test]
fn a_harmonic_of_two_periods_is_fitted_once() {
    let truth: [Wave<'_>; 2] = [(5.0, &[[1.5, -0.8]]), (2.5, &[[0.5, 0.2]])];
    let readings = scanned(every(0.2, 100.0), false, |q| error(&truth, q));
    let found = identify(&readings, &[5.0, 2.5], None).unwrap();
    assert_eq!(found.periods[0].coincide[0], (2, (2.5, 1)));
    assert!((found.periods[1].forward[0].value[0] - 0.5).abs() < 1e-9);
    assert!(found.periods[0].forward.iter().all(|own| own.number != 2));
}

/// A period that nobody stated is named.
#[test]
fn what_is_left_is_named() {
    let truth: [Wave<'_>; 2] = [(5.0, &[[1.5, -0.8]]), (1.27, &[[0.3, 0.4]])];
    let mut draws = Draws::new(5, 5);
    let readings = scanned(every(0.1, 200.0), false, |q| error(&truth, q) + 0.2 * draws.normal());
    let left = identify(&readings, &[5.0], None).unwrap().remains.unwrap();
    assert!((left.period - 1.27).abs() < 0.01 && (left.amplitude - 0.5).abs() < 0.1, "{left:?}");
}

/// Quantiles of chi-squared for 99.73 %: 11.829 of two degrees of freedom, 16.251 of four (a table).
#[test]
fn a_harmonic_in_both_directions_is_kept_from_a_smaller_amplitude() {
    for (directions, squares) in [(1, 11.829_f64), (2, 16.251 / 2.0)] {
        let least = least_amplitude(0.5, directions, 1_000_000);
        assert!((least - 0.5 * squares.sqrt()).abs() < 1e-3, "{least}");
    }
    assert!(least_amplitude(0.5, 1, 5) > 1.5 * least_amplitude(0.5, 1, 1_000_000));
}
