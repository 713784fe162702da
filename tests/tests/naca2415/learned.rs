//! Consecutive parts, each learning from the record of the previous one.

use super::course::{Outcome, run};
use super::plugin::{Plugin, machine, with_servo};
use super::{GAINS, Off};
use trueaxis::learned::Learned;
use trueaxis_metrology::learning::{Identity, Law, Lesson};
use trueaxis_tests::course::Course;

/// Time in which the axes can respond to a correction, s: shorter waves at the programmed feed are not learned.
const ANSWER_S: f64 = 0.04;

/// Outcome of each of `parts` parts; the first has no learned correction.
pub(crate) fn parts(course: &Course, feed_mm_per_min: f64, feed_forward: Option<Off>, parts: usize) -> Vec<Outcome> {
    let law = Law { cutoff_mm: ANSWER_S * feed_mm_per_min / 60.0, ..Law::default() };
    let identity = Identity { machine_id: 1, program_id: 1, length_mm: course.program.length() };
    let machine = machine(Some(GAINS), feed_forward);
    with_servo(&machine, course, |servo| {
        let (mut file, mut outcomes): (Option<Vec<u8>>, _) = (None, Vec::new());
        for _ in 0..parts {
            let before = file.as_deref().map(|file| Learned::parse(file).unwrap());
            let mut plugin = Plugin::new(servo);
            plugin.learned = before;
            outcomes.push(run(course, &mut plugin));
            let lesson = Lesson::learn(&law, &identity, before.as_ref(), &plugin.record).unwrap();
            file = Some(lesson.to_bytes().unwrap());
        }
        outcomes
    })
}
