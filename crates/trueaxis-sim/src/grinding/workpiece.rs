//! The surface of the pin: radius deviation over a fine grid of angles, and its harmonics.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use std::f64::consts::TAU;

/// Cells around the pin; linear interpolation between them is within 0.02 % for harmonic 50.
pub const CELLS: usize = 8192;

/// Amplitudes of cos ks and sin ks, µm.
pub type Harmonic = [f64; 2];

/// A pin: radius deviation in µm over the angle s of its surface; high is positive.
#[derive(Clone, Debug)]
pub struct Workpiece {
    cells: Vec<f64>,
}

/// Angle s to a position on the grid, 0 to `CELLS`.
fn place(angle: f64) -> f64 {
    (angle / TAU).rem_euclid(1.0) * CELLS as f64
}

impl Workpiece {
    /// A perfectly round pin.
    pub fn round() -> Workpiece {
        Workpiece { cells: vec![0.0; CELLS] }
    }

    /// A rough-turned pin: lobes of 2 to 60 undulations, 2 µm for the second and falling with k^1.5, and 0.05 µm of noise. The
    /// highest point is at 0.
    pub fn turned(seed: u64) -> Workpiece {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(100);
        let mut cells = vec![0.0; CELLS];
        if let Ok(phases) = Uniform::new(0.0, TAU) {
            for k in 2..=60 {
                let (amplitude, phase) = (2.0 * libm::pow(2.0 / f64::from(k), 1.5), phases.sample(&mut random));
                for (j, cell) in cells.iter_mut().enumerate() {
                    *cell += amplitude * libm::cos(f64::from(k) * TAU * j as f64 / CELLS as f64 + phase);
                }
            }
        }
        for cell in &mut cells {
            let normal: f64 = StandardNormal.sample(&mut random);
            *cell += 0.05 * normal;
        }
        let highest = cells.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        cells.iter_mut().for_each(|cell| *cell -= highest);
        Workpiece { cells }
    }

    /// Returns the pin, larger by some µm.
    pub fn raised(mut self, by_um: f64) -> Workpiece {
        self.cells.iter_mut().for_each(|cell| *cell += by_um);
        self
    }

    /// The grid, cell j at the angle 2π j / `CELLS`.
    pub fn cells(&self) -> &[f64] {
        &self.cells
    }

    /// Radius deviation at an angle, linear between the cells.
    pub fn at(&self, angle: f64) -> f64 {
        let at = place(angle);
        let low = at as usize % CELLS;
        let (a, b) = (self.cells[low], self.cells[(low + 1) % CELLS]);
        a + at.fract() * (b - a)
    }

    /// Removes the material above the wheel's edge, on the cells that the contact has swept.
    ///
    /// `from` and `to`: angle (rad, counted over all turns) and level (µm) of the edge at the beginning and at the end; the
    /// level is linear in between. Either sense of rotation; a sweep of more than a turn is cut to one.
    pub fn grind(&mut self, from: [f64; 2], to: [f64; 2]) {
        let scale = CELLS as f64 / TAU;
        let swept = (to[0] - from[0]) * scale;
        if swept == 0.0 || !swept.is_finite() {
            return;
        }
        let (a, b) = (from[0] * scale, to[0] * scale);
        let (first, last) = ((a.min(b)).floor() + 1.0, a.max(b).floor());
        let count = (last - first + 1.0).clamp(0.0, CELLS as f64) as usize;
        for i in 0..count {
            let at = first + i as f64;
            let level = from[1] + (at - a) / swept * (to[1] - from[1]);
            let cell = &mut self.cells[at.rem_euclid(CELLS as f64) as usize % CELLS];
            *cell = cell.min(level);
        }
    }

    /// Harmonics 0 to `last` by direct summation; the mean is harmonic 0's cosine.
    pub fn harmonics(&self, last: usize) -> Vec<Harmonic> {
        let table: Vec<(f64, f64)> = (0..CELLS).map(|j| libm::sincos(TAU * j as f64 / CELLS as f64)).collect();
        let scale = |k: usize| if k == 0 { 1.0 } else { 2.0 } / CELLS as f64;
        let of = |k: usize| {
            let (mut cos, mut sin) = (0.0, 0.0);
            for (j, cell) in self.cells.iter().enumerate() {
                let (s, c) = table[k * j % CELLS];
                cos += cell * c;
                sin += cell * s;
            }
            [cos * scale(k), sin * scale(k)]
        };
        (0..=last).map(of).collect()
    }

    /// Peak to valley about the least-squares circle, µm.
    pub fn roundness(&self) -> f64 {
        let about = self.about_the_circle();
        let high = about.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        high - about.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The surface without mean and first harmonic.
    pub fn about_the_circle(&self) -> Vec<f64> {
        let [[mean, _], [a, b]] = self.harmonics(1)[..] else { return Vec::new() };
        let circle = |j: usize| {
            let (sin, cos) = libm::sincos(TAU * j as f64 / CELLS as f64);
            mean + a * cos + b * sin
        };
        self.cells.iter().enumerate().map(|(j, cell)| cell - circle(j)).collect()
    }
}

/// Root mean square of the harmonics from `first` up, µm: √(Σ (a² + b²)/2).
pub fn imprint(harmonics: &[Harmonic], first: usize) -> f64 {
    (harmonics.iter().skip(first).map(|[a, b]| 0.5 * (a * a + b * b)).sum::<f64>()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_that_undulates_leaves_its_harmonics() {
        let level = |s: f64| -5.0 + 1.5 * (3.0 * s).cos() - 0.4 * (11.0 * s).sin() + 2.0 * s.sin();
        let mut pin = Workpiece::round();
        let step = TAU / 3000.7;
        for i in -3..3010 {
            let (a, b) = (f64::from(i) * step, f64::from(i + 1) * step);
            pin.grind([a, level(a)], [b, level(b)]);
        }
        let harmonics = pin.harmonics(20);
        for (k, [a, b]) in harmonics.iter().enumerate() {
            let [x, y] = match k {
                0 => [-5.0, 0.0],
                1 => [0.0, 2.0],
                3 => [1.5, 0.0],
                11 => [0.0, -0.4],
                _ => [0.0, 0.0],
            };
            assert!((a - x).abs() < 1e-4 && (b - y).abs() < 1e-4, "harmonic {k}: {a} {b}");
        }
        assert!((imprint(&harmonics, 2) - (0.5_f64 * (1.5 * 1.5 + 0.16)).sqrt()).abs() < 1e-4);
        let range = (0..100_000).map(|i| TAU * f64::from(i) / 1e5).map(|s| level(s) - 2.0 * s.sin());
        let (low, high) = range.fold((f64::MAX, f64::MIN), |(l, h), r| (l.min(r), h.max(r)));
        assert!((pin.roundness() - (high - low)).abs() < 1e-3);
        for s in [0.3, 4.0, 6.2829, -0.0001] {
            assert!((pin.at(s) - level(s)).abs() < 1e-3, "{s}");
        }
    }

    #[test]
    fn only_what_is_higher_is_removed_in_either_sense() {
        let mut pin = Workpiece::turned(3);
        let before = pin.cells().to_vec();
        let not_raised = |pin: &Workpiece| pin.cells().iter().zip(&before).all(|(after, before)| after <= before);
        pin.grind([1.0, 1.0], [7.0, 1.0]);
        assert_eq!(pin.cells(), &before[..]);
        pin.grind([7.0, -30.0], [6.0, -30.0]);
        assert!(not_raised(&pin));
        let cut = pin.cells().iter().zip(&before).filter(|(after, before)| after < before).count();
        assert!((1303..=1304).contains(&cut), "a radian has 1303.8 cells: {cut}");
        pin.grind([6.0, -30.0], [6.0, -40.0]);
        assert!(pin.cells().iter().all(|cell| *cell >= -30.0), "a standing spindle cuts nothing");
    }
}
