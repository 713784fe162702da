//! The contour error of one part over path length: `trueaxis learn`.

use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome, refusal};
use std::path::Path;
use trueaxis::learned::Learned;
use trueaxis_evaluation::learn::{COLUMNS, Record};
use trueaxis_evaluation::rows::Rows;
use trueaxis_metrology::learning::{Law, Lesson};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "learn",
    about: "records of a part (CSV with comments), and the correction learned from them",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/csv.dict"),
    slowest: SLOWEST,
};

const FILE: &str = "record.csv";
/// A longer path has too many nodes to process here, mm.
const LONGEST_MM: f64 = 60.0;

fn run(bytes: &[u8]) {
    let open = || Rows::new(bytes, Path::new(FILE), &COLUMNS, outcome::refused);
    let record = match Record::read(bytes, Path::new(FILE), open) {
        Ok(record) => record,
        Err(error) => return refusal::of_file(&format!("{error:#}"), FILE, bytes),
    };
    assert!((1e-3..=1e9).contains(&record.identity.length_mm) && !record.rows.is_empty());
    if record.identity.length_mm > LONGEST_MM {
        return;
    }
    let law = Law { gain: 0.7, forget: 0.98, cutoff_mm: 4.0 };
    let lesson = |before: Option<&Learned<'_, f64>>| Lesson::learn(&law, &record.identity, before, &record.rows);
    let learned = lesson(None).and_then(|lesson| Ok((lesson.to_bytes()?, lesson)));
    let (file, first) = match learned {
        Ok(learned) => learned,
        Err(refused) => return refusal::of_file(&record.refused(&refused).to_string(), FILE, bytes),
    };
    let correction = belongs(&file, &record, &first);
    outcome::accepted();
    outcome::saw((first.correction_mm.len().ilog2(), record.rows.iter().any(|row| row.error_mm.is_none())));
    // A second part, made with the correction learned from the first.
    let second = lesson(Some(&correction)).expect("a record from which was learned");
    assert_eq!(second.header.parts, 2);
    belongs(&second.to_bytes().expect("a correction of two parts"), &record, &second);
}

/// The file of a lesson belongs to this machine and program, and agrees within half a step of its resolution.
fn belongs<'b>(file: &'b [u8], record: &Record, lesson: &Lesson) -> Learned<'b, f64> {
    let learned = Learned::<f64>::parse(file).expect("a file that was learned");
    assert_eq!(learned.expect_machine(record.identity.machine_id), Ok(()));
    assert_eq!(learned.expect_program(record.identity.program_id, record.identity.length_mm), Ok(()));
    assert_eq!(learned.nodes().len(), lesson.correction_mm.len());
    let step = 1e-9 * f64::from(learned.header().resolution_pm);
    for (written, meant) in learned.nodes().zip(&lesson.correction_mm) {
        let off = written.iter().zip(meant).fold(0.0_f64, |off, (written, meant)| off.max((written - meant).abs()));
        assert!(off <= 0.5001 * step, "{written:?} for {meant:?}, resolution {step}");
    }
    // No correction is larger than the errors it is learned from; rows of up to 1 mm are accepted.
    assert!(lesson.correction_mm.iter().flatten().all(|value| value.abs() <= 0.7 + 0.98 * 0.7 + 1e-9));
    learned
}

fn seeds() -> Vec<Vec<u8>> {
    let comments = "# program_id = 1a2b3c4d\n# machine_id = 0x5e6f\n# length_mm = 4.000000\n";
    let mut good = format!("{comments}s_mm,ex_um,ey_um,ez_um,measured\n");
    let mut plain =
        format!("#length_mm=2\n{comments}s_mm;ex_um;ey_um;ez_um\n").replacen("# length_mm = 4.000000\n", "", 1);
    for i in 0..=4 {
        good += &format!("{i},{},0.5,-1,{}\n", i % 3, u8::from(i != 3));
        plain += &format!("{};{},5;0;1\n", i / 2, i % 3);
    }
    [good, plain, format!("{comments}ex_um,ey_um,ez_um,s_mm\n1,2,3,0\n1,2,3,2\n1,2,3,4\n")]
        .map(String::into_bytes)
        .into()
}
