//! A published benchmark: the NACA 2415 profile as a NURBS on two axes with published transfer functions.
//!
//! `docs/benchmark-naca.md` lists the figures beside the published ones; `UPDATE_DOCS=1` writes them.

mod course;
mod cross_coupling;
mod learned;
mod plant;
mod plugin;
mod table;

use course::{Nothing, Outcome, profile, run};
use cross_coupling::{CrossCoupling, Estimate};
use plugin::{Gains, Off, Plugin, machine, with_servo};
use trueaxis_tests::course::Course;

/// Programmed feeds, mm/min.
const FEEDS: [f64; 3] = [3_000.0, 6_000.0, 12_000.0];
/// Gains of the contour feedback, near the largest that the margins permit on these axes.
const GAINS: Gains = [0.15, 5.0];
/// Gains of the cross-coupling: the same, and higher ones that no margin check covers.
const CROSS_COUPLED: [Gains; 3] = [GAINS, [0.3, 10.0], [0.6, 60.0]];

fn course(feed: f64) -> Course {
    profile(feed, &machine(None, None))
}

fn cross_coupled(course: &Course, estimate: Estimate, [proportional, integral]: Gains) -> Outcome {
    run(course, &mut CrossCoupling::new(estimate, proportional, integral))
}

fn compensated(course: &Course, gains: Option<Gains>, feed_forward: Option<Off>) -> Outcome {
    with_servo(&machine(gains, feed_forward), course, |servo| run(course, &mut Plugin::new(servo)))
}

/// The reference that the plugin is compared with is effective: it reduces the error, and more so with more gain.
#[test]
fn cross_coupling_reduces_the_error() {
    for course in FEEDS.map(course) {
        let alone = run(&course, &mut Nothing);
        for estimate in [Estimate::Tangent, Estimate::Circle] {
            let mut before = alone;
            for gains in CROSS_COUPLED {
                let with = cross_coupled(&course, estimate, gains);
                assert!(with.largest < 0.8 * before.largest && with.rms < 0.8 * before.rms, "{with:?} {before:?}");
                before = with;
            }
        }
    }
}

/// Published: the largest error 65 % below that of cross-coupling with the tangent, 50 % below that with the circle of
/// curvature (doi 10.1177/00202940241239227); by learning, the largest error 45 % and the mean error 54 % lower (doi
/// 10.1177/1687814019868108).
#[test]
fn the_published_reductions_are_beaten() {
    for course in FEEDS.map(course) {
        let alone = run(&course, &mut Nothing);
        let [same, twice, _] = CROSS_COUPLED.map(|gains| {
            let by = |estimate| cross_coupled(&course, estimate, gains).largest;
            by(Estimate::Tangent).min(by(Estimate::Circle))
        });
        let ours = compensated(&course, Some(GAINS), Some(Off::BY_NOTHING));
        assert!(ours.largest < 0.15 * same && ours.largest < 0.2 * twice, "{ours:?} {same} {twice}");
        assert!(ours.largest < 0.07 * alone.largest && ours.mean < 0.04 * alone.mean, "{ours:?} {alone:?}");
        let wrong = compensated(&course, Some(GAINS), Some(Off::AS_USUAL));
        assert!(wrong.largest < 0.39 * same && wrong.largest < 0.55 * twice, "{wrong:?} {same} {twice}");
        assert!(wrong.largest < 0.18 * alone.largest && wrong.mean < 0.13 * alone.mean, "{wrong:?} {alone:?}");
    }
}

#[test]
fn each_part_helps_and_both_together_most() {
    for course in FEEDS.map(course) {
        let alone = run(&course, &mut Nothing);
        let feedback = compensated(&course, Some(GAINS), None);
        let feed_forward = compensated(&course, None, Some(Off::BY_NOTHING));
        let both = compensated(&course, Some(GAINS), Some(Off::BY_NOTHING));
        assert!(feedback.largest < 0.97 * alone.largest && feedback.rms < 0.76 * alone.rms, "{feedback:?} {alone:?}");
        assert!(feed_forward.rms < 0.2 * feedback.rms, "{feed_forward:?} {feedback:?}");
        assert!(both.largest < feed_forward.largest && both.rms < 0.8 * feed_forward.rms, "{both:?} {feed_forward:?}");
    }
}

/// Gains, reset time, friction, each 30 % off in either direction: still far better than no correction.
#[test]
fn figures_far_off_do_no_harm() {
    // Permitted even with the worst of these figures.
    const GENTLE: Gains = [0.075, 2.5];
    let right = Off::BY_NOTHING;
    for course in FEEDS.map(course) {
        let alone = run(&course, &mut Nothing);
        for by in [0.7, 1.3] {
            for off in [Off { gains: by, ..right }, Off { reset: by, ..right }, Off { friction: by, ..right }] {
                let ours = compensated(&course, Some(GENTLE), Some(off));
                assert!(ours.largest < 0.5 * alone.largest && ours.rms < 0.4 * alone.rms, "{off:?} {ours:?} {alone:?}");
            }
        }
    }
}

/// Published: learning reduces the largest error by 45 % and the mean error by 54 % (doi 10.1177/1687814019868108). Tested
/// after three parts, with contour feedback alone, and with everything enabled and wrong figures.
#[test]
fn three_parts_teach_more_than_the_published_ones() {
    for feed in FEEDS {
        let course = course(feed);
        for feed_forward in [None, Some(Off::AS_USUAL)] {
            let parts = learned::parts(&course, feed, feed_forward, 4);
            for pair in parts.windows(2) {
                let [before, after] = pair else { unreachable!() };
                assert!(after.largest < before.largest && after.rms < before.rms, "{before:?} {after:?}");
            }
            let (first, last) = (&parts[0], &parts[3]);
            assert!(last.largest < 0.35 * first.largest && last.mean < 0.32 * first.mean, "{first:?} {last:?}");
        }
    }
}
