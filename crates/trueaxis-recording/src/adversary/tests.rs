//! Checks that the cycles drawn are those that the documents promise.

use super::*;
use std::boxed::Box;
use std::vec::Vec;

const PERIOD_NS: u32 = 1_000_000;

fn courses() -> &'static [Course<f64, f64>] {
    Box::leak((0..COURSES).map(Course::new).collect::<Vec<_>>().into_boxed_slice())
}

#[test]
fn every_course_is_a_path() {
    for (number, course) in courses().iter().enumerate() {
        assert!(course.len() >= 4, "course {number}: {} spans", course.len());
        let path = course.path();
        for k in 1..course.len() {
            let (Some(before), Some(after)) = (path.span(k - 1), path.span(k)) else { panic!("course {number}") };
            let gap = before.position(1.0).into_iter().zip(after.position(0.0)).map(|(a, b)| (a - b).abs());
            assert!(gap.fold(0.0, f64::max) < 1e-9, "course {number}, before span {k}");
        }
    }
}

#[test]
fn a_scene_begins_anywhere_alike() {
    let mut whole = Adversary::new(courses(), PERIOD_NS);
    let mut late = Adversary::new(courses(), PERIOD_NS);
    for number in 0..4 * SCENE {
        let moment = whole.cycle(number);
        assert_eq!(moment.cold, number % SCENE == 0);
        if number >= 3 * SCENE {
            // Missing readings are NaN, so the comparison is by printed text.
            assert_eq!(std::format!("{moment:?}"), std::format!("{:?}", late.cycle(number)));
        }
    }
}

#[test]
fn everything_happens_and_commands_stay_plausible() {
    let mut adversary = Adversary::new(courses(), PERIOD_NS);
    let (mut seen, mut before) = (0u16, None::<Moment<f64, f64>>);
    let mut driven = 0;
    for number in 0..20_000 {
        let moment = adversary.cycle(number);
        seen |= moment.events.0;
        let may_jump = [Events::COLD, Events::PROGRAM, Events::NOT_HOMED, Events::DISABLED, Events::BAD_COMMAND];
        if let Some(before) = before
            && !may_jump.iter().any(|event| moment.events.has(*event) || before.events.has(*event))
        {
            driven += 1;
            for (a, b) in moment.input.command.iter().zip(&before.input.command) {
                assert!((a - b).abs() <= FARTHEST + 1e-6, "cycle {number}: {a} after {b}");
            }
        }
        before = Some(moment);
    }
    assert_eq!(seen, u16::MAX);
    assert!(driven > 10_000);
}
