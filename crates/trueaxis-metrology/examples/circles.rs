//! Times of the reference circles on this machine: `cargo run --release -p trueaxis --features std --example circles`.

use std::f64::consts::TAU;
use std::time::Instant;
use trueaxis_metrology::circles::{
    NoCircle, ReferenceCircle, least_squares, limacon, maximum_inscribed, minimum_circumscribed, minimum_zone,
};

type Circle = fn(&[[f64; 2]]) -> Result<ReferenceCircle, NoCircle>;

/// Even noise in −1..1, the same in every run.
fn noise(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn main() {
    let mut state = 1;
    let mut around = |n: usize, turn: f64, radius: &dyn Fn(f64, &mut u64) -> f64| -> Vec<[f64; 2]> {
        (0..n)
            .map(|i| turn * i as f64 / n as f64)
            .map(|angle| (angle, radius(angle, &mut state)))
            .map(|(angle, r)| [-560.0 + r * angle.cos(), 34.0 + r * angle.sin()])
            .collect()
    };
    println!(
        "times in ms              {:>9}{:>9}{:>9}{:>9}{:>9}{:>9}  zone",
        "n", "LSC", "MCC", "MIC", "MZC", "limaçon"
    );
    for n in [1_000, 4_000, 100_000] {
        let sets = [
            ("noise 1e-3", around(n, TAU, &|_, s| 13.0 + 1e-3 * noise(s))),
            ("noise 1e-9", around(n, TAU, &|_, s| 13.0 + 1e-9 * noise(s))),
            ("five lobes and noise", around(n, TAU, &|a, s| 13.0 + 5e-3 * (5.0 * a).cos() + 1e-4 * noise(s))),
            ("three lobes", around(n, TAU, &|a, _| 13.0 + 5e-3 * (3.0 * a).cos())),
            ("sixty lobes", around(n, TAU, &|a, _| 13.0 + 5e-3 * (60.0 * a).cos())),
            ("perfect circle", around(n, TAU, &|_, _| 13.0)),
            ("ellipse", around(n, TAU, &|a, _| 13.0 / (1.0 + 0.5 * a.cos().powi(2)).sqrt())),
            ("arc of 200 deg", around(n, 3.5, &|_, s| 13.0 + 1e-3 * noise(s))),
            ("arc of 20 deg", around(n, 0.35, &|_, s| 13.0 + 1e-4 * noise(s))),
            ("cloud", around(n, TAU, &|_, s| 13.0 * (0.5 + 0.5 * noise(s)).sqrt())),
        ];
        for (name, points) in sets {
            print!("{name:<25}{n:>9}");
            let mut zone = f64::NAN;
            for circle in [least_squares as Circle, minimum_circumscribed, maximum_inscribed, minimum_zone] {
                let started = Instant::now();
                let found = circle(&points);
                print!("{:>9.2}", started.elapsed().as_secs_f64() * 1e3);
                zone = found.map_or(f64::NAN, |circle| circle.zone);
            }
            let profile: Vec<f64> = points.iter().map(|p| (p[0] + 560.0).hypot(p[1] - 34.0)).collect();
            let started = Instant::now();
            let _ = limacon::minimum_zone(&profile);
            println!("{:>9.2}  {zone:.6e}", started.elapsed().as_secs_f64() * 1e3);
        }
    }
}
