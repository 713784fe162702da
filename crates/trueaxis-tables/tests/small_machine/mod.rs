//! A machine small enough to be calculated by hand.

use trueaxis::machine::{Axis, Limits, LocationErrors, Row};
use trueaxis_tables::{Machine, Table};

/// `w C' X' b Z t`.
/// X: 0, 50, 100 mm; EXX +10, −20, +1.5 µm forward, 1 µm more in reverse and 3 µm backlash; EYX 4 µm, ECX −7 µrad at 100.
/// C: full circle in steps of 180 degrees; ECC π/180 · 1e-3 rad (1 mdeg) at 180, EXC 2 µm at 180. Z: backlash only.
pub(crate) fn machine() -> Machine {
    let row = |position: f64, forward: [f64; 6], reverse: [f64; 6]| Row { position, forward, reverse };
    let x = Table {
        given: [true, true, false, false, false, true],
        bidirectional: true,
        rows: vec![
            row(0.0, [0.010, 0.0, 0.0, 0.0, 0.0, 0.0], [0.011, 0.0, 0.0, 0.0, 0.0, 0.0]),
            row(50.0, [-0.020, 0.0, 0.0, 0.0, 0.0, 0.0], [-0.019, 0.0, 0.0, 0.0, 0.0, 0.0]),
            row(100.0, [0.0015, 0.004, 0.0, 0.0, 0.0, -7e-6], [0.0025, 0.004, 0.0, 0.0, 0.0, -7e-6]),
        ],
    };
    let mdeg = std::f64::consts::PI / 180_000.0;
    let half = [0.002, 0.0, 0.0, 0.0, 0.0, mdeg];
    let c = Table {
        given: [true, false, false, false, false, true],
        bidirectional: false,
        rows: vec![row(0.0, [0.0; 6], [0.0; 6]), row(180.0, half, half), row(360.0, [0.0; 6], [0.0; 6])],
    };
    let limits = Limits { magnitude: 0.1, slope_per_s: 1.0, acceleration_per_s2: 200.0 };
    let settings = trueaxis_testing::machine::Machine::new("w C' X' b Z t")
        .name("small")
        .travel([-500.0, 500.0], 1.0)
        .hysteresis(0.001)
        .limits(limits)
        .each(|axis| axis.max_feed_per_s = 500.0)
        .axis(Axis::X, |x| {
            x.backlash = 0.003;
            x.thermal.expansion_per_k = 11.5e-6;
        })
        .axis(Axis::Z, |z| z.backlash = 0.002)
        .with(|machine| {
            machine.location = LocationErrors { b0z: 2e-5, c0y: -3.5e-5, ..LocationErrors::default() };
            machine.location.rotary[2] = [0.012, 0.0, 0.0, 0.0, -1.4e-5, 0.0];
        })
        .settings();
    Machine { settings, tables: vec![Some(x), None, Some(c)], grids: Vec::new() }
}
