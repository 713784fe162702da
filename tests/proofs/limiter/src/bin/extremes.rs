//! Measures how far a rounded correction can exceed its magnitude; the proof that it never does assumes exact arithmetic.
//!
//! Drives the limiter against its ends over the whole grid of limits, with targets that jump between them, creep up to them
//! and stop the approach in each cycle. Prints the largest |c|/C − 1 for every scalar, and the preceding number of braking
//! cycles; fails above the stated bound, (N + 8) units of rounding for N cycles of braking.

use trueaxis::Real;
use trueaxis::limiter::{Limiter, LimiterState};
use trueaxis::machine::Limits;

/// Random numbers that do not depend on any input: xorshift.
struct Random(u64);
impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Prints the largest excess over C and its share of the stated bound; returns whether the bound holds.
fn run<R: Real>(name: &str, unit: f64, longest: f64) -> bool {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut worst, mut cycles_behind, mut share) = (0.0f64, 0.0, 0.0f64);
    for _ in 0..4000 {
        let magnitude = 10f64.powf(-3.0 + 3.0 * random.unit());
        // Number of braking cycles from full speed, and full speed as a share of the largest that the magnitude
        // permits.
        let brake = 10f64.powf(longest.log10() * random.unit());
        let slope = magnitude / brake * 2.0 * random.unit().max(1e-3);
        let limits = Limits { magnitude, slope_per_s: slope, acceleration_per_s2: slope / brake };
        let Ok(limiter) = Limiter::<R>::new(&limits, 1.0) else { continue };
        let top = limiter.magnitude().to_f64();
        let mut state = LimiterState::<R>::default();
        let mut sign = 1.0;
        let (mut left, mut target) = (0.0, 0.0);
        for _ in 0..20_000 {
            if left <= 0.0 {
                left = 3.0 * brake * random.unit();
                sign = if random.unit() < 0.3 { -sign } else { sign };
                target = sign * magnitude * (1.0 + 0.5 * (random.unit() - 0.3));
            }
            left -= 1.0;
            limiter.follow(&mut state, R::of(target));
            let beyond = state.sent().to_f64().abs() / top - 1.0;
            share = share.max(beyond / ((brake + 8.0) * unit));
            if beyond > worst {
                (worst, cycles_behind) = (beyond, brake);
            }
        }
    }
    println!(
        "{name}: at most {worst:.2e} beyond C, after {cycles_behind:.0} cycles of braking; {share:.3} of the stated bound"
    );
    share <= 1.0
}

fn main() {
    let kept = [run::<f32>("f32", 2f64.powi(-24), 1e3), run::<f64>("f64", 2f64.powi(-53), 1e4)];
    std::process::exit(i32::from(kept.contains(&false)));
}
