use super::*;
use core::f64::consts::TAU;
use std::string::ToString;
use trueaxis::learned::{Learned, LearnedHeader};

/// Feed along the path, mm/s, and spacing, mm: 1,000 nodes a second.
const FEED: f64 = 25.0;
const SPACING: f64 = 0.025;

/// A drive as a linear plant in time, integrated independently of the law: K (K_v + k s)/(s + K_v) and a first-order lag, by
/// the exact step response of each pole between nodes.
struct Plant {
    gain: f64,
    position_per_s: f64,
    feed_forward: f64,
    lag_s: f64,
}

impl Plant {
    fn response(&self, input: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let (mut behind, mut lagged) = ([0.0; 3], [0.0; 3]);
        let step = SPACING / FEED;
        let (a, b) = ((-step / self.lag_s).exp(), (-step * self.position_per_s).exp());
        let each = |u: &[f64; 3]| {
            core::array::from_fn(|i| {
                lagged[i] = a * lagged[i] + (1.0 - a) * u[i];
                behind[i] = b * behind[i] + (1.0 - b) * lagged[i];
                self.gain * (self.feed_forward * lagged[i] + (1.0 - self.feed_forward) * behind[i])
            })
        };
        input.iter().map(each).collect()
    }

    fn at(&self, wavelength: f64) -> Complex<f64> {
        let s = Complex::new(0.0, TAU * FEED / wavelength);
        let (k, kv) = (self.feed_forward, self.position_per_s);
        self.gain * (kv + s * k) / (s + kv) / (1.0 + s * self.lag_s)
    }
}

fn plants() -> impl Iterator<Item = Plant> {
    [0.6, 0.8, 1.0, 1.2, 1.4].into_iter().flat_map(|gain| {
        [0.0005, 0.0015].map(move |lag_s| Plant { gain, position_per_s: 110.0, feed_forward: 0.93, lag_s })
    })
}

fn wave(wavelength: f64, amplitude: f64, nodes: usize) -> Vec<[f64; 3]> {
    let at = |k: usize| amplitude * (TAU * k as f64 * SPACING / wavelength).sin();
    (0..nodes).map(|k| [at(k), 0.5 * at(k + 7), 0.0]).collect()
}

/// Root mean square away from the ends, where the correction is faded in.
fn rms(values: &[[f64; 3]]) -> f64 {
    let inside = &values[100..values.len() - 100];
    (inside.iter().flatten().map(|v| v * v).sum::<f64>() / inside.len() as f64).sqrt()
}

fn added(one: &[[f64; 3]], other: &[[f64; 3]]) -> Vec<[f64; 3]> {
    one.iter().zip(other).map(|(a, b)| core::array::from_fn(|i| a[i] + b[i])).collect()
}

/// Residual of a disturbance after each of `parts` parts, the first without correction.
fn parts(law: &Law, plant: &Plant, disturbance: &[[f64; 3]], parts: usize) -> Vec<f64> {
    let mut correction = std::vec![[0.0; 3]; disturbance.len()];
    let mut left = Vec::new();
    for _ in 0..parts {
        let error = added(disturbance, &plant.response(&correction));
        left.push(rms(&error));
        correction = law.update(Some(&correction), &error, SPACING).unwrap();
    }
    left
}

/// Whether the residual decreases from part to part, down to the 4 % of the first that forgetting may leave.
fn falls(left: &[f64]) -> bool {
    left.windows(2).all(|pair| pair[1] < pair[0].max(0.04 * left[0]))
}

#[test]
fn the_residual_falls_with_every_part_for_gains_forty_percent_off() {
    let law = Law::default();
    for plant in plants() {
        for wavelength in [0.8, 1.6, 5.0, 20.0] {
            let factor = law.contraction(wavelength, plant.at(wavelength));
            assert!(factor < 1.0, "{} {wavelength}: {factor}", plant.gain);
            let left = parts(&law, &plant, &wave(wavelength, 1e-3, 4000), 4);
            assert!(falls(&left), "{} {wavelength}: {left:?}", plant.gain);
        }
        // Spikes at two reversals, 10 ms wide, like a quadrant glitch.
        let spike = |k: usize, at: f64| (-((k as f64 * SPACING - at) / 0.25).powi(2)).exp() * 2e-3;
        let spikes: Vec<[f64; 3]> = (0..4000).map(|k| [spike(k, 30.0), -spike(k, 62.0), 0.0]).collect();
        let left = parts(&law, &plant, &spikes, 4);
        assert!(falls(&left), "{}: {left:?}", plant.gain);
        assert!(left[2] < 0.5 * left[0], "{}: {left:?}", plant.gain);
    }
}

#[test]
fn the_factor_is_the_one_stated() {
    let law = Law { forget: 1.0, ..Law::default() };
    for plant in plants() {
        for wavelength in [0.8, 2.0, 10.0] {
            let left = parts(&law, &plant, &wave(wavelength, 1e-3, 8000), 3);
            let factor = law.contraction(wavelength, plant.at(wavelength));
            // The plant is integrated with a hold of one node.
            let found = left[1] / left[0];
            assert!((found - factor).abs() < 0.06, "{} {wavelength}: {found} {factor}", plant.gain);
        }
    }
}

#[test]
fn beyond_the_stated_gain_what_is_left_grows() {
    let law = Law { gain: 1.6, ..Law::default() };
    let plant = Plant { gain: 1.4, position_per_s: 110.0, feed_forward: 0.93, lag_s: 0.0005 };
    assert!(law.contraction(5.0, plant.at(5.0)) > 1.0);
    let left = parts(&law, &plant, &wave(5.0, 1e-3, 4000), 4);
    assert!(left.windows(2).all(|pair| pair[1] > pair[0]), "{left:?}");
}

/// Noise that differs from part to part adds at most the share that the law's gain admits.
#[test]
fn noise_is_not_gathered_up() {
    let (law, plant) = (Law::default(), plants().nth(4).unwrap());
    let mut seed = 1_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut correction = std::vec![[0.0; 3]; 4000];
    let mut levels = Vec::new();
    for _ in 0..30 {
        let noise: Vec<[f64; 3]> = (0..4000).map(|_| [1e-3 * noise(), 0.0, 0.0]).collect();
        let error = added(&plant.response(&correction), &noise);
        levels.push(rms(&error) / rms(&noise));
        correction = law.update(Some(&correction), &error, SPACING).unwrap();
    }
    assert!(levels[3..].iter().all(|level| *level < 1.15), "{levels:?}");
}

#[test]
fn the_low_pass_has_no_phase_and_the_stated_transmission() {
    for wavelength in [0.2, 0.4, 0.8, 4.0] {
        let input = wave(wavelength, 1.0, 2000);
        let output = low_pass(&input, SPACING, 0.4);
        let expected = transmission(wavelength, 0.4);
        for (a, b) in input.iter().zip(&output).skip(100).take(1800) {
            assert!((b[0] - expected * a[0]).abs() < 2e-5, "{wavelength}: {} {}", b[0], expected * a[0]);
        }
    }
    assert!((transmission(0.4, 0.4) - 0.5).abs() < 1e-15);
}

fn row(length_mm: f64, x: f64) -> MeasuredError {
    MeasuredError { length_mm, error_mm: Some([x, 0.0, -x]) }
}

#[test]
fn nodes_get_the_mean_of_the_rows_about_them_and_straight_lines_between() {
    let rows = [row(0.0, 1e-3), row(0.009, 3e-3), row(0.1, 0.0), row(0.2, 4e-3), row(0.4, 8e-3)];
    let found = resample(&rows, 0.4, 0.1, 0.25).unwrap();
    let x: Vec<f64> = found.errors_mm.iter().map(|error| error[0]).collect();
    for (found, expected) in x.iter().zip([2e-3, 0.0, 4e-3, 6e-3, 8e-3]) {
        assert!((found - expected).abs() < 1e-15, "{x:?}");
    }
    // Unmeasured stretches are zero, and may be of any length.
    let none = |length_mm| MeasuredError { length_mm, error_mm: None };
    let rows = [row(0.0, 1e-3), none(0.05), none(0.8), row(0.9, 1e-3), row(1.0, 1e-3)];
    let found = resample(&rows, 1.0, 0.1, 0.25).unwrap();
    assert!(found.errors_mm[1..9].iter().all(|error| *error == [0.0; 3]), "{found:?}");
}

#[test]
fn records_that_cannot_be_taken_are_refused_with_the_row() {
    let refused = |rows: &[MeasuredError]| resample(rows, 1.0, 0.1, 0.25).unwrap_err();
    let even: Vec<MeasuredError> = (0..=10).map(|k| row(0.1 * f64::from(k), 1e-3)).collect();
    assert!(resample(&even, 1.0, 0.1, 0.25).is_ok());
    let changed = |index: usize, with: MeasuredError| {
        let mut rows = even.clone();
        rows[index] = with;
        refused(&rows)
    };
    assert!(matches!(changed(4, row(0.2, 0.0)), NotLearned::Backwards { index: 4, .. }));
    assert!(matches!(changed(4, row(f64::NAN, 0.0)), NotLearned::OffThePath { index: 4, .. }));
    assert!(matches!(changed(10, row(25.4, 0.0)), NotLearned::OffThePath { index: 10, .. }));
    assert!(matches!(changed(3, row(0.3, 1.1)), NotLearned::TooLarge { index: 3, .. }));
    assert!(matches!(changed(3, row(0.3, f64::NAN)), NotLearned::TooLarge { index: 3, .. }));
    assert!(matches!(refused(&even[..6]), NotLearned::Gap { index: 5, .. }));
    assert!(matches!(refused(&even[6..]), NotLearned::Gap { index: 0, .. }));
    let gap: Vec<MeasuredError> = even.iter().copied().filter(|row| !(0.35..0.65).contains(&row.length_mm)).collect();
    let error = refused(&gap);
    assert!(matches!(error, NotLearned::Gap { index: 4, .. }));
    assert!(error.to_string().contains("0.3") && error.to_string().contains("0.25"), "{error}");
    assert_eq!(refused(&[]), NotLearned::Empty);
    let none: Vec<MeasuredError> = even.iter().map(|row| MeasuredError { error_mm: None, ..*row }).collect();
    assert_eq!(refused(&none), NotLearned::Empty);
    assert!(matches!(resample(&even, 1.0, 1e-9, 0.25), Err(NotLearned::TooLong { .. })));
}

#[test]
fn figures_of_the_law_are_checked() {
    for (gain, forget, cutoff_mm) in [
        (0.0, 1.0, 0.4),
        (2.0, 1.0, 0.4),
        (f64::NAN, 1.0, 0.4),
        (0.7, 0.0, 0.4),
        (0.7, 1.01, 0.4),
        (0.7, f64::NAN, 0.4),
        (0.7, 1.0, 0.0),
        (0.7, 1.0, 1e4),
        (0.7, 1.0, f64::NAN),
    ] {
        let law = Law { gain, forget, cutoff_mm };
        assert!(matches!(law.update(None, &[[0.0; 3]; 4], 0.1), Err(NotLearned::Setting { .. })), "{law:?}");
    }
    let other = Law::default().update(Some(&[[0.0; 3]; 3]), &[[0.0; 3]; 4], 0.1);
    assert_eq!(other, Err(NotLearned::Nodes { found: 3, needed: 4 }));
}

#[test]
fn a_correction_comes_back_from_its_file_to_half_a_resolution() {
    let law = Law::default();
    let length_mm = 50.037;
    let spacing_mm = law.spacing_mm(length_mm);
    assert!(spacing_mm <= 0.025 + 1e-6);
    let nodes = super::table::nodes(length_mm, spacing_mm).unwrap();
    let correction = law.update(None, &wave(3.0, 2e-3, nodes), spacing_mm).unwrap();
    let header = LearnedHeader {
        parts: 1,
        machine_id: 1,
        program_id: 2,
        length_nm: 50_037_000,
        spacing_nm: (spacing_mm * 1e6).round() as u32,
        resolution_pm: 1,
    };
    let bytes = encode(header, &correction).unwrap();
    let learned = Learned::<f64>::parse(&bytes).unwrap();
    // 2 µm times the gain over 32,767 counts: 43 pm.
    assert!(learned.header().resolution_pm <= 45);
    for (a, b) in learned.nodes().zip(&correction) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.51e-9 * 45.0), "{a:?} {b:?}");
    }
    assert!(matches!(encode(header, &correction[1..]), Err(NotLearned::Nodes { .. })));
    let mut strong = correction.clone();
    strong[9] = [40.0, 0.0, 0.0];
    assert!(matches!(encode(header, &strong), Err(NotLearned::TooStrong { .. })));
    strong[9] = [f64::NAN, 0.0, 0.0];
    assert!(matches!(encode(header, &strong), Err(NotLearned::TooStrong { .. })));
}
