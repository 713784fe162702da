//! A published benchmark: the NACA 2415 profile as a NURBS on the published transfer functions of two axes.

mod course;
mod cross_coupling;
mod plant;

use course::{Nothing, profile, run};
use cross_coupling::{CrossCoupling, Estimate};
use trueaxis_testing::machine::Machine;

/// Programmed feeds, mm/min.
const FEEDS: [f64; 3] = [3_000.0, 6_000.0, 12_000.0];

/// The measure that the plugin is compared with is no straw man: it reduces the error, and more so with more gain.
#[test]
fn cross_coupling_reduces_the_error() {
    let machine = Machine::three_axis().settings();
    for feed in FEEDS {
        let course = profile(feed, &machine);
        let alone = run(&course, &mut Nothing);
        for estimate in [Estimate::Tangent, Estimate::Circle] {
            let [gentle, sharp] = [(0.3, 10.0), (1.0, 120.0)]
                .map(|(proportional, integral)| run(&course, &mut CrossCoupling::new(estimate, proportional, integral)));
            assert!(gentle.largest < 0.6 * alone.largest && gentle.rms < 0.5 * alone.rms, "{gentle:?} {alone:?}");
            assert!(sharp.largest < 0.3 * gentle.largest && sharp.rms < 0.3 * gentle.rms, "{sharp:?} {gentle:?}");
        }
    }
}
