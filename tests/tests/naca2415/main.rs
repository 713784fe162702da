//! A published benchmark: the NACA 2415 profile as a NURBS on the published transfer functions of two axes.
//!
//! `docs/benchmark-naca.md` has the figures beside the published ones; `UPDATE_DOCS=1` writes them.

mod course;
mod cross_coupling;
mod plant;
mod plugin;
mod table;

use course::{Nothing, Outcome, profile, run};
use cross_coupling::{CrossCoupling, Estimate};
use plugin::{Gains, Off, Plugin, machine, with_servo};
use trueaxis_tests::course::Course;

/// Programmed feeds, mm/min.
const FEEDS: [f64; 3] = [3_000.0, 6_000.0, 12_000.0];
/// The default gains of contour feedback, and sharper ones.
const GAINS: [Gains; 2] = [[0.3, 10.0], [0.6, 60.0]];

fn course(feed: f64) -> Course {
    profile(feed, &machine(None, None))
}

fn cross_coupled(course: &Course, estimate: Estimate, [proportional, integral]: Gains) -> Outcome {
    run(course, &mut CrossCoupling::new(estimate, proportional, integral))
}

fn compensated(course: &Course, gains: Option<Gains>, feed_forward: Option<Off>) -> Outcome {
    with_servo(&machine(gains, feed_forward), course, |servo| run(course, &mut Plugin::new(servo)))
}

/// The measure that the plugin is compared with is no straw man: it reduces the error, and more so with more gain.
#[test]
fn cross_coupling_reduces_the_error() {
    for course in FEEDS.map(course) {
        let alone = run(&course, &mut Nothing);
        for estimate in [Estimate::Tangent, Estimate::Circle] {
            let [gentle, sharp] = GAINS.map(|gains| cross_coupled(&course, estimate, gains));
            assert!(gentle.largest < 0.6 * alone.largest && gentle.rms < 0.5 * alone.rms, "{gentle:?} {alone:?}");
            assert!(sharp.largest < 0.5 * gentle.largest && sharp.rms < 0.4 * gentle.rms, "{sharp:?} {gentle:?}");
        }
    }
}

/// Published: the largest error 65 % below that of cross-coupling with the tangent, 50 % below that with the circle of
/// curvature (doi 10.1177/00202940241239227); by learning, the largest 45 % and the mean 54 % down (doi
/// 10.1177/1687814019868108). Here with the same gains for both.
#[test]
fn the_published_reductions_are_beaten() {
    for course in FEEDS.map(course) {
        let alone = run(&course, &mut Nothing);
        for gains in GAINS {
            let tangent = cross_coupled(&course, Estimate::Tangent, gains);
            let circle = cross_coupled(&course, Estimate::Circle, gains);
            let ours = compensated(&course, Some(gains), Some(Off::BY_NOTHING));
            assert!(ours.largest < 0.2 * tangent.largest.min(circle.largest), "{ours:?} {tangent:?} {circle:?}");
            assert!(ours.largest < 0.06 * alone.largest && ours.mean < 0.04 * alone.mean, "{ours:?} {alone:?}");
            // Figures that are wrong.
            let ours = compensated(&course, Some(gains), Some(Off::AS_USUAL));
            assert!(ours.largest < 0.4 * tangent.largest.min(circle.largest), "{ours:?} {tangent:?} {circle:?}");
            assert!(ours.largest < 0.13 * alone.largest && ours.mean < 0.1 * alone.mean, "{ours:?} {alone:?}");
        }
    }
}

#[test]
fn each_part_helps_and_both_together_most() {
    for course in FEEDS.map(course) {
        let alone = run(&course, &mut Nothing);
        let feedback = compensated(&course, Some(GAINS[0]), None);
        let feed_forward = compensated(&course, None, Some(Off::BY_NOTHING));
        let both = compensated(&course, Some(GAINS[0]), Some(Off::BY_NOTHING));
        assert!(feedback.largest < 0.7 * alone.largest && feedback.rms < 0.6 * alone.rms, "{feedback:?} {alone:?}");
        assert!(feed_forward.rms < 0.2 * feedback.rms, "{feed_forward:?} {feedback:?}");
        assert!(both.largest < feed_forward.largest && both.rms < 0.8 * feed_forward.rms, "{both:?} {feed_forward:?}");
    }
}

/// Every figure 30 % off, in all combinations of sign: still better than nothing.
#[test]
fn figures_far_off_do_no_harm() {
    for course in FEEDS.map(course) {
        let alone = run(&course, &mut Nothing);
        for signs in 0..8 {
            let by = |bit: u32| if signs & bit == 0 { 0.7 } else { 1.3 };
            let off = Off { gains: by(1), reset: by(2), friction: by(4) };
            let ours = compensated(&course, Some(GAINS[0]), Some(off));
            assert!(ours.largest < 0.9 * alone.largest && ours.rms < 0.75 * alone.rms, "{off:?} {ours:?} {alone:?}");
        }
    }
}
