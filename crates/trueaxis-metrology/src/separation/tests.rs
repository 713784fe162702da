//! True values: cosine sums evaluated at each probe's position, and the linkage solved by bisection of its sine rule.

use super::*;
use core::f64::consts::TAU;
use trueaxis::roundness::{Arm, ProbeAngles};
use trueaxis_testing::machine::ARM;
use trueaxis_testing::noise::Noise;

const BAND: Band = Band { first: 2, last: 100 };

struct Truth {
    /// Amplitude and phase of harmonics 2, 3, ….
    harmonics: Vec<[f64; 2]>,
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Truth {
    /// Several µm in each harmonic up to the band's last; motion of 50 µm once per revolution, with other frequencies and
    /// noise.
    fn new(points: usize, seed: u64) -> Truth {
        let mut noise = Noise::new(seed);
        let harmonics = BAND.iter().map(|_| [3.0 + 2.0 * noise.signed(), TAU * noise.signed()]).collect();
        let mut motion = |phase: f64| {
            let wave = |i: usize, k: f64| (TAU * k * i as f64 / points as f64 + phase).cos();
            (0..points).map(|i| 7.0 + 50.0 * wave(i, 1.0) + 4.0 * wave(i, 2.3) + 0.5 * noise.signed()).collect()
        };
        let (x, y) = (motion(0.4), motion(2.0));
        Truth { harmonics, x, y }
    }

    fn profile(&self, theta: f64) -> f64 {
        (2..).zip(&self.harmonics).map(|(k, [a, phase])| a * (f64::from(k) * theta + phase).cos()).sum()
    }

    /// h1, h2, h3 with the arm angle at every θ.
    fn readings(&self, [phi2, phi3]: [f64; 2], beta: impl Fn(f64) -> f64) -> [Vec<f64>; 3] {
        [0.0, phi2, phi2 + phi3].map(|phi| self.reading(phi, &beta))
    }

    /// Readings of a probe at `phi`.
    fn reading(&self, phi: f64, beta: impl Fn(f64) -> f64) -> Vec<f64> {
        let points = self.x.len();
        let at = |i: usize| {
            let theta = TAU * i as f64 / points as f64;
            let (sin, cos) = (phi + beta(theta)).sin_cos();
            self.profile(theta + phi) + self.y[i] * cos + self.x[i] * sin
        };
        (0..points).map(at).collect()
    }
}

/// β such that α + β = θ and R sin α = (R_S + R_W) sin β.
fn solved_arm(ratio: f64, theta: f64) -> f64 {
    let (mut low, mut high) = (-ratio.asin(), ratio.asin());
    for _ in 0..80 {
        let beta = 0.5 * (low + high);
        // β − asin(λ sin(θ − β)) rises with β for λ < 1.
        if beta.sin() < ratio * (theta - beta).sin() { low = beta } else { high = beta }
    }
    0.5 * (low + high)
}

fn largest_difference(a: &[f64], b: impl Iterator<Item = f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn slots(p: u16, q: u16) -> ProbeAngles {
    ProbeAngles::Slots { p, q }
}

fn degrees(phi2: f64, phi3: f64) -> ProbeAngles {
    ProbeAngles::Degrees { phi2, phi3 }
}

#[test]
fn noise_free_readings_are_taken_apart() {
    let published = [degrees(90.0, 181.05), degrees(60.82, 240.12)];
    let arrangements = [
        (1024, published.to_vec()),
        (
            1024,
            [slots(188, 667), slots(169, 188), slots(256, 515), degrees(66.1234, 234.5), degrees(-66.1, 125.4)]
                .to_vec(),
        ),
        (512, published.to_vec()),
        (512, [slots(155, 172), slots(94, 333)].to_vec()),
    ];
    let following = Arm { crank_mm: 60.0, wheel_mm: 300.0, pin_mm: 30.0 }.ratio().unwrap();
    let mut worst = 0.0f64;
    for (points, angles) in arrangements {
        let truth = Truth::new(points, points as u64);
        for angles in angles {
            for ratio in [0.0, following] {
                let gain = angles.resolve(points).unwrap();
                let readings = truth.readings([gain.phi2(), gain.phi3()], |theta| solved_arm(ratio, theta));
                let separator = Separator::new(gain, BAND, NOISE_GAIN_LIMIT, ratio).unwrap();
                let found = separator.separate(&[&readings[0], &readings[1], &readings[2]]).unwrap();
                let theta = (0..points).map(|i| TAU * i as f64 / points as f64);
                let errors = [
                    largest_difference(&found.profile, theta.map(|theta| truth.profile(theta))),
                    largest_difference(&found.x, truth.x.iter().copied()),
                    largest_difference(&found.y, truth.y.iter().copied()),
                ];
                std::println!(
                    "N {points} {angles:?} λ {ratio:.3}: r, R_X, R_Y {} µm",
                    errors.map(|e| std::format!("{e:.1e}")).join(" ")
                );
                for error in errors {
                    assert!(error < 1e-6, "{angles:?} {ratio} {errors:?}");
                    worst = worst.max(error);
                }
                for (harmonic, [amplitude, phase]) in
                    separator.harmonics(&found.profile).unwrap().iter().zip(&truth.harmonics)
                {
                    assert!((harmonic.amplitude - amplitude).abs() < 1e-9, "{harmonic:?}");
                    let turn = (harmonic.phase - phase).rem_euclid(TAU);
                    assert!(turn.min(TAU - turn) < 1e-9, "{harmonic:?} {phase}");
                    assert!(!harmonic.suppressed);
                }
            }
        }
    }
    std::println!("largest error {worst:.1e} µm");
}

/// With β = 0 and small motion a wrong sign of β would go unnoticed; here the error is as large as the motion.
#[test]
fn the_arm_matters() {
    let (points, angles) = (512, slots(155, 172));
    let truth = Truth::new(points, 3);
    let gain = angles.resolve(points).unwrap();
    let readings = truth.readings([gain.phi2(), gain.phi3()], |theta| solved_arm(0.2, theta));
    let still = Separator::new(gain, BAND, NOISE_GAIN_LIMIT, 0.0).unwrap();
    let found = still.separate(&[&readings[0], &readings[1], &readings[2]]).unwrap();
    assert!(largest_difference(&found.x, truth.x.iter().copied()) > 5.0);
    // s does not contain the motion, whatever β is.
    let theta = (0..points).map(|i| TAU * i as f64 / points as f64);
    assert!(largest_difference(&found.profile, theta.map(|theta| truth.profile(theta))) < 1e-6);
}

/// A part larger than the master on which the probes were zeroed.
#[test]
fn the_size_of_the_part_is_no_motion() {
    let ratio = ARM.ratio().unwrap();
    let gain = slots(188, 667).resolve(1024).unwrap();
    let truth = Truth::new(1024, 5);
    let readings = truth.readings([gain.phi2(), gain.phi3()], |theta| solved_arm(ratio, theta));
    let larger = readings.map(|h| h.iter().map(|h| h + 12.0).collect::<Vec<_>>());
    let [h1, h2, h3] = &larger;
    let parts = Separator::new(gain, BAND, NOISE_GAIN_LIMIT, ratio).unwrap().separate(&[h1, h2, h3]).unwrap();
    assert!(largest_difference(&parts.x, truth.x.iter().copied()) < 1e-9);
    assert!(largest_difference(&parts.y, truth.y.iter().copied()) < 1e-9);
}

#[test]
fn suppressed_harmonics_are_left_out_and_marked() {
    // 90° and 181.05°: the largest noise gain is 19, so a limit of 10 suppresses some harmonics, not all.
    let gain = degrees(90.0, 181.05).resolve(1024).unwrap();
    let truth = Truth::new(1024, 5);
    let readings = truth.readings([gain.phi2(), gain.phi3()], |_| 0.0);
    let separator = Separator::new(gain, BAND, 10.0, 0.0).unwrap();
    let suppressed: Vec<u16> = separator.suppressed().collect();
    let expected: Vec<u16> = BAND.iter().filter(|k| gain.noise_gain(usize::from(*k)) > 10.0).collect();
    assert_eq!(suppressed, expected);
    assert!(!suppressed.is_empty() && suppressed.len() < 30, "{suppressed:?}");
    let found = separator.separate(&[&readings[0], &readings[1], &readings[2]]).unwrap();
    for (harmonic, [amplitude, _]) in separator.harmonics(&found.profile).unwrap().iter().zip(&truth.harmonics) {
        let kept = !suppressed.contains(&harmonic.k);
        assert_eq!(harmonic.suppressed, !kept);
        let expected = if kept { *amplitude } else { 0.0 };
        assert!((harmonic.amplitude - expected).abs() < 1e-9, "{harmonic:?}");
    }
}

#[test]
fn the_filter_halves_its_cut_off() {
    let gain = slots(188, 667).resolve(1024).unwrap();
    let separator = Separator::new(gain, BAND, NOISE_GAIN_LIMIT, 0.0).unwrap();
    let wave = |k: f64, i: i32| (TAU * k * f64::from(i) / 1024.0).cos();
    let profile: Vec<f64> = (0..1024).map(|i| 4.0 * wave(50.0, i) + 3.0 * wave(100.0, i)).collect();
    let filtered = separator.filtered(&profile, 50).unwrap();
    let expected = (0..1024).map(|i| 2.0 * wave(50.0, i) + 3.0 / 16.0 * wave(100.0, i));
    assert!(largest_difference(&filtered, expected) < 1e-12);
    assert!(separator.filtered(&profile, 51).is_err() && separator.filtered(&profile[1..], 50).is_err());
}

/// Any number of points, and nothing of the profile but the filter's share is lost: not the mean, not the eccentricity.
#[test]
fn a_trace_alone_is_filtered_as_a_profile_is() {
    for points in [360_u32, 721, 1024] {
        let wave = |k: f64, i: u32| (TAU * k * f64::from(i) / f64::from(points)).cos();
        let trace: Vec<f64> = (0..points).map(|i| 25.0 + wave(1.0, i) + 4.0 * wave(50.0, i)).collect();
        let filtered = filtered(&trace, 50).unwrap();
        let first = 2.0_f64.powf(-1.0 / 2500.0);
        let expected = (0..points as i32).map(|i| 25.0 + first * wave(1.0, i as u32) + 2.0 * wave(50.0, i as u32));
        assert!(largest_difference(&filtered, expected) < 1e-12, "{points}");
    }
    assert!(filtered(&[1.0; 360], 51).is_err() && filtered(&[1.0; 2], 50).is_err());
}

#[test]
fn inseparable_harmonics_are_refused() {
    let refused = |angles: ProbeAngles, band, limit, ratio| {
        Separator::new(angles.resolve(1024).unwrap(), band, limit, ratio).err().unwrap()
    };
    let few = Band { first: 2, last: 10 };
    let blind = refused(degrees(120.0, 120.0), few, 100.0, 0.0);
    assert_eq!(blind, NoSeparation::Blind([2, 4, 5, 7, 8, 10].to_vec()));
    assert!(std::format!("{blind}").contains("harmonics 2, 4, 5, 7, 8, 10:"));
    let setting = |error: &NoSeparation| matches!(error, NoSeparation::Setting(_));
    assert!(setting(&refused(slots(188, 667), Band { first: 2, last: 512 }, 100.0, 0.0)));
    assert!(setting(&refused(slots(188, 667), few, 0.0, 0.0)));
    assert!(setting(&refused(slots(188, 667), few, f64::NAN, 0.0)));
    assert!(setting(&refused(slots(188, 667), few, 100.0, 1.0)));
    let separator = Separator::new(slots(188, 667).resolve(1024).unwrap(), few, 100.0, 0.0).unwrap();
    let right = [0.0; 1024];
    let error = separator.separate(&[&right, &right[1..], &right]).unwrap_err();
    assert_eq!((error.index, error.found), (Some(1), 1023.0));
}

/// Independent noise of standard deviation σ in each probe causes a mean square amplitude of 4 σ² g²/N in a harmonic of noise
/// gain g.
#[test]
fn noise_grows_by_the_noise_gain() {
    let (points, revolutions) = (128, 600);
    let band = Band { first: 2, last: 40 };
    let gain = degrees(90.0, 181.05).resolve(points).unwrap();
    let separator = Separator::new(gain, band, NOISE_GAIN_LIMIT, 0.1).unwrap();
    let mut noise = Noise::new(11);
    let mut squares = std::vec![0.0; band.iter().count()];
    for _ in 0..revolutions {
        let probes = [(); 3].map(|()| (0..points).map(|_| noise.signed()).collect::<Vec<f64>>());
        let found = separator.separate(&[&probes[0], &probes[1], &probes[2]]).unwrap();
        for (square, harmonic) in squares.iter_mut().zip(separator.harmonics(&found.profile).unwrap()) {
            *square += harmonic.amplitude * harmonic.amplitude / f64::from(revolutions);
        }
    }
    for (k, square) in band.iter().zip(squares) {
        // σ² of numbers distributed uniformly over −1..1 is 1/3.
        let expected = 4.0 / 3.0 * gain.noise_gain(usize::from(k)).powi(2) / points as f64;
        // The mean of 600 exponentially distributed squares scatters by 4 %.
        assert!((square / expected - 1.0).abs() < 0.2, "{k}: {square} {expected}");
    }
}

/// Angles in degrees with a worst noise gain from 2 to 100 below 1.6; the last ones on no point of 1024.
const PLACES: [&[f64]; 4] = [
    &[0.0, 140.9765625, 299.8828125, 331.5234375],
    &[0.0, 51.1, 123.4, 201.7],
    &[0.0, 39.2, 101.3, 158.9, 243.3],
    &[0.0, 39.2, 101.3, 158.9, 243.3, 290.1],
];

fn slices(probes: &[Vec<f64>]) -> Vec<&[f64]> {
    probes.iter().map(Vec::as_slice).collect()
}

#[test]
fn noise_free_readings_of_four_to_six_probes_are_taken_apart() {
    let following = Arm { crank_mm: 60.0, wheel_mm: 300.0, pin_mm: 30.0 }.ratio().unwrap();
    for (points, degrees) in [512, 1024].into_iter().flat_map(|points| PLACES.map(|degrees| (points, degrees))) {
        for ratio in [0.0, following] {
            let truth = Truth::new(points, points as u64);
            let places = ProbePlaces::new(degrees).unwrap();
            let separator = Separator::of_places(&places, points, BAND, NOISE_GAIN_LIMIT, ratio).unwrap();
            // The part is larger than the master; its size must not appear as motion.
            let probes: Vec<Vec<f64>> = degrees
                .iter()
                .map(|phi| truth.reading(phi.to_radians(), |theta| solved_arm(ratio, theta)))
                .map(|h| h.into_iter().map(|h| h + 12.0).collect())
                .collect();
            let found = separator.separate(&slices(&probes)).unwrap();
            let theta = (0..points).map(|i| TAU * i as f64 / points as f64);
            let errors = [
                largest_difference(&found.profile, theta.map(|theta| truth.profile(theta))),
                largest_difference(&found.x, truth.x.iter().copied()),
                largest_difference(&found.y, truth.y.iter().copied()),
            ];
            assert!(errors.iter().all(|error| *error < 1e-10), "{points} {degrees:?} {ratio} {errors:?}");
            let agreement = separator.agreement(&slices(&probes)).unwrap().unwrap();
            assert!(agreement.noise < 1e-11 && agreement.disagreeing.is_none(), "{agreement:?}");
        }
    }
}

/// The profile is; the motion is not, since the closed form takes it from two probes.
#[test]
fn least_squares_of_three_probes_give_the_profile_of_the_closed_form() {
    let gain = degrees(60.82, 240.12).resolve(1024).unwrap();
    let places = ProbePlaces::new(&[0.0, 60.82, 300.94]).unwrap();
    let mut noise = Noise::new(8);
    let probes = [(); 3].map(|()| (0..1024).map(|_| noise.signed()).collect::<Vec<f64>>());
    let probes: [&[f64]; 3] = [&probes[0], &probes[1], &probes[2]];
    let closed = Separator::new(gain, BAND, NOISE_GAIN_LIMIT, 0.1).unwrap().separate(&probes).unwrap();
    let least = Separator::of_places(&places, 1024, BAND, NOISE_GAIN_LIMIT, 0.1).unwrap();
    assert_eq!(least.agreement(&probes).unwrap(), None);
    let least = least.separate(&probes).unwrap();
    assert!(largest_difference(&closed.profile, least.profile.into_iter()) < 1e-11);
}

/// As with three probes: 4 σ² g²/N in a harmonic of noise gain g.
#[test]
fn noise_of_four_probes_grows_by_the_noise_gain() {
    let (points, revolutions) = (128, 600);
    let band = Band { first: 2, last: 40 };
    let places = ProbePlaces::new(&[0.0, 90.0, 181.05, 300.0]).unwrap();
    let separator = Separator::of_places(&places, points, band, NOISE_GAIN_LIMIT, 0.0).unwrap();
    let mut noise = Noise::new(12);
    let mut squares = std::vec![0.0; band.iter().count()];
    for _ in 0..revolutions {
        let probes = [(); 4].map(|()| (0..points).map(|_| noise.signed()).collect::<Vec<f64>>());
        let found = separator.separate(&slices(&probes)).unwrap();
        for (square, harmonic) in squares.iter_mut().zip(separator.harmonics(&found.profile).unwrap()) {
            *square += harmonic.amplitude * harmonic.amplitude / f64::from(revolutions);
        }
    }
    for (k, square) in band.iter().zip(squares) {
        let expected = 4.0 / 3.0 * places.noise_gain(usize::from(k)).powi(2) / points as f64;
        assert!((square / expected - 1.0).abs() < 0.2, "{k}: {square} {expected}");
    }
}

/// Readings of probes mounted at other angles and with other sensitivities than stated: deviations over 60 records are those
/// of the standard errors, and nothing is named.
#[test]
fn errors_of_mounting_are_found_within_their_standard_errors() {
    for stated in [PLACES[0], PLACES[3]] {
        let truth = Truth::new(512, 9);
        let places = ProbePlaces::new(stated).unwrap();
        let separator = Separator::of_places(&places, 512, BAND, NOISE_GAIN_LIMIT, 0.0).unwrap();
        let angles = [0.0, 2e-5, -3e-5, 1e-5, 4e-5, -2e-5];
        let sensitivities = [0.0, 4e-5, 2e-5, -5e-5, 1e-5, 3e-5];
        let mut noise = Noise::new(31);
        let (mut squares, mut count) = (0.0, 0.0);
        for _ in 0..60 {
            let probes: Vec<Vec<f64>> = (0..stated.len())
                .map(|i| {
                    let readings = truth.reading(stated[i].to_radians() + angles[i], |_| 0.0);
                    readings.into_iter().map(|h| h * (1.0 + sensitivities[i]) + 0.1 * noise.signed()).collect()
                })
                .collect();
            let agreement = separator.agreement(&slices(&probes)).unwrap().unwrap();
            assert_eq!(agreement.disagreeing, None);
            for (probe, found) in (1..).zip(&agreement.mounting) {
                for ([value, error], truth) in [(found.angle, angles[probe]), (found.sensitivity, sensitivities[probe])]
                {
                    squares += ((value - truth) / error).powi(2);
                    count += 1.0;
                }
            }
        }
        let ratio = (squares / count).sqrt();
        assert!((0.85..1.15).contains(&ratio), "{stated:?}: {ratio}");
    }
}

/// Few harmonics above the noise: the noise in the others must not bias the sensitivities.
#[test]
fn noise_does_not_bias_the_sensitivities() {
    let stated = PLACES[3];
    let separator = Separator::of_places(&ProbePlaces::new(stated).unwrap(), 512, BAND, NOISE_GAIN_LIMIT, 0.0).unwrap();
    let mut noise = Noise::new(77);
    let (mut means, mut squares) = ([0.0; 5], [0.0; 5]);
    for _ in 0..200 {
        let probes: Vec<Vec<f64>> = stated
            .iter()
            .map(|phi| {
                let theta = |i: usize| TAU * i as f64 / 512.0 + phi.to_radians();
                let waves = |i: usize| (2..8).map(|k| (f64::from(k) * theta(i) + f64::from(k * k)).cos()).sum::<f64>();
                (0..512).map(|i| waves(i) + noise.signed()).collect()
            })
            .collect();
        let agreement = separator.agreement(&slices(&probes)).unwrap().unwrap();
        for (probe, found) in agreement.mounting.iter().enumerate() {
            means[probe] += found.sensitivity[0] / 200.0;
            squares[probe] += found.sensitivity[1].powi(2) / 200.0;
        }
    }
    for (mean, square) in means.iter().zip(squares) {
        // Means of 200 records scatter by a fourteenth of a standard error.
        assert!(mean.abs() < 4.0 * (square / 200.0).sqrt(), "{mean} {}", square.sqrt());
    }
}

/// Without noise the error of a hundredth of a degree is found to the second order.
#[test]
fn a_probe_beside_its_angle_is_found() {
    let truth = Truth::new(1024, 2);
    let stated = PLACES[1];
    let separator =
        Separator::of_places(&ProbePlaces::new(stated).unwrap(), 1024, BAND, NOISE_GAIN_LIMIT, 0.0).unwrap();
    let true_degrees = [0.0, 51.1, 123.41, 201.7];
    let probes: Vec<Vec<f64>> = true_degrees.iter().map(|phi| truth.reading(f64::to_radians(*phi), |_| 0.0)).collect();
    let agreement = separator.agreement(&slices(&probes)).unwrap().unwrap();
    let found = agreement.mounting[1].angle[0].to_degrees();
    assert!((found - 0.01).abs() < 2e-4, "{found}");
}

#[test]
fn five_probes_name_the_one_that_disagrees_and_four_do_not() {
    let truth = Truth::new(512, 4);
    let mut noise = Noise::new(5);
    for (degrees, wrong) in
        [PLACES[1], PLACES[2], PLACES[3]].into_iter().flat_map(|of| (0..of.len()).map(move |i| (of, i)))
    {
        let mut probes: Vec<Vec<f64>> = degrees
            .iter()
            .map(|phi| {
                truth.reading(phi.to_radians(), |_| 0.0).into_iter().map(|h| h + 0.02 * noise.signed()).collect()
            })
            .collect();
        let plan = Separator::of_places(&ProbePlaces::new(degrees).unwrap(), 512, BAND, NOISE_GAIN_LIMIT, 0.0).unwrap();
        assert_eq!(plan.agreement(&slices(&probes)).unwrap().unwrap().disagreeing, None);
        let quiet = plan.agreement(&slices(&probes)).unwrap().unwrap().noise;
        // σ of numbers distributed uniformly over ±0.02.
        assert!((quiet / (0.02 / 3.0_f64.sqrt()) - 1.0).abs() < 0.25, "{quiet}");
        for (i, h) in probes[wrong].iter_mut().enumerate() {
            *h += 0.3 * (TAU * 17.0 * i as f64 / 512.0).sin();
        }
        let agreement = plan.agreement(&slices(&probes)).unwrap().unwrap();
        assert!(agreement.noise > 3.0 * quiet, "{degrees:?} {wrong} {agreement:?}");
        assert_eq!(agreement.disagreeing, (degrees.len() > 4).then_some(wrong), "{degrees:?} {agreement:?}");
    }
}
