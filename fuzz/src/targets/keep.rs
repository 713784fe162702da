//! Tasks of a machine that keeps itself true (keep.toml) and its history (history.jsonl): `trueaxis keep`.

use crate::choice::one_in;
use crate::{Target, outcome, refusal, small};
use std::path::Path;
use std::time::Duration;
use trueaxis_evaluation::calibrate::program;
use trueaxis_evaluation::keep::{
    BallPlace, Changed, Entry, EntryKind, History, KeepTask, LogFile, Measured, figures, foreseen, plan, sum,
};
use trueaxis_report::Page;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "keep",
    about: "tasks of a machine that keeps itself true, planned and foreseen; histories, sums made right",
    run,
    seeds,
    repair,
    dictionary: include_str!("../../dictionaries/keep.dict"),
    slowest: Duration::from_secs(5),
};

const TASK: &str = "keep.toml";
const HISTORY: &str = "history.jsonl";
/// One in so many valid tasks is planned.
const PLANNED_ONE_IN: u64 = 64;
/// Begins the check sum of a line.
const CHECK: &str = ",\"check\":\"";

fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return outcome::refused("no text") };
    if text.starts_with('{') { history(text) } else { task(text) }
}

fn task(text: &str) {
    let file = Path::new(TASK);
    let task = match KeepTask::read(text, file) {
        Ok(task) => task,
        Err(error) => return refusal::of_file(&error.to_string(), TASK, text.as_bytes()),
    };
    for kept in &task.terms {
        let bounds = kept.bounds;
        assert!(0.0 < bounds.update && bounds.update <= bounds.total && bounds.significance >= 1.0, "{kept:?}");
    }
    assert!(task.ttherm.is_none() || task.thermal.is_some());
    outcome::accepted();
    outcome::saw((task.probing.artefacts.len().min(3), task.terms.len().min(6), task.turns()));
    if !one_in(PLANNED_ONE_IN, text.as_bytes()) {
        return;
    }
    let machine = small::machine("w b X Y Z t");
    match plan(&task, &machine) {
        Err(error) => refusal::in_words(&format!("{error:#}")),
        Ok(planned) => {
            let program = program(&task.probing, &machine, &planned);
            assert!(program.is_ascii() && !program.contains("NaN") && !program.contains("inf"), "{program}");
            match foreseen(&task, &machine, &planned) {
                Err(error) => refusal::in_words(&format!("{error:#}")),
                Ok(errors) => {
                    assert!(errors.len() == task.terms.len() && errors.iter().all(|error| *error > 0.0), "{errors:?}");
                    outcome::saw("foreseen");
                }
            }
        }
    }
}

fn history(text: &str) {
    let file = Path::new(HISTORY);
    let history = match History::read(text, file) {
        Ok(history) => history,
        Err(error) => return refusal::of_file(&error.to_string(), HISTORY, text.as_bytes()),
    };
    outcome::accepted();
    outcome::saw(history.entries.iter().map(|entry| entry.kind as u8).take(4).collect::<Vec<_>>());
    let count = history.entries.len() as u32;
    let now = history.in_effect();
    assert!(now.windows(2).all(|pair| pair[0] < pair[1]) && now.iter().all(|number| (1..=count).contains(number)));
    for asked in [None, Some(0), Some(1), Some(2), Some(count), Some(count.saturating_add(1))] {
        match history.undoable(asked) {
            Ok(number) => {
                assert!((2..=count).contains(&number), "{number} of {count}");
                let back = history.put_back(number);
                assert!(back.iter().all(|(_, entry, _)| (number..=count).contains(entry)));
            }
            Err(error) => refusal::of_file(&error.to_string(), HISTORY, text.as_bytes()),
        }
    }
    if let Err(error) = history.follows("1234abcd", "0000abcd", Some("2026-05-04T06:00:00Z"), Some(7)) {
        refusal::of_file(&error.to_string(), HISTORY, text.as_bytes());
    }
    let page =
        figures(&history.entries).into_iter().fold(Page::new("keep"), |page, figure| page.section("term", figure));
    // The history names the terms, so a name may contain NaN.
    assert!(
        !page.document().contains("NaN") || format!("{:?}", history.entries).contains("NaN"),
        "not a number in a plot"
    );
    if let Some(last) = history.last() {
        // One more entry is read back; without the first line or the end, nothing is.
        let next = Entry { entry: history.next(), ..last.clone() };
        let longer = history.with(&next);
        let read = History::read(&longer, file).expect("what was written is read");
        // The last bit of a number may differ: the reader parses fast.
        let summary = |entry: &Entry| (entry.entry, entry.kind, entry.files.clone(), entry.measured.len());
        assert_eq!(read.entries.last().map(summary), Some(summary(&next)));
        let lines: Vec<&str> = longer.split_inclusive('\n').collect();
        assert!(History::read(&lines[1..].concat(), file).is_err(), "the first line is missing");
        assert!(History::read(&longer[..longer.len() - 2], file).is_err(), "the end is missing");
    }
}

/// Corrects the sums of all lines, each over its line and the previous sum.
fn repair(bytes: &mut Vec<u8>) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if !text.starts_with('{') {
        return;
    }
    let mut check = String::new();
    let mut sealed = String::new();
    for line in text.split_inclusive('\n') {
        match line.rsplit_once(CHECK) {
            None => sealed.push_str(line),
            Some((body, _)) => {
                check = sum(format!("{check}{body}").as_bytes());
                sealed.push_str(&format!("{body}{CHECK}{check}\"}}\n"));
            }
        }
    }
    *bytes = sealed.into_bytes();
}

fn seeds() -> Vec<Vec<u8>> {
    let head = "machine = \"small\"\ndialect = \"linuxcnc\"\nevery_parts = 10\n";
    let probe = "[probe]\ntip_radius_mm = 3.0\nrepeats = 1\ntip_uncertainty_um = 20.0\nrepeatability_um = 0.5\n";
    let ball = "[[artefact]]\nname = \"ball\"\nkind = \"ball\"\ndiameter_mm = 25.0\nuncertainty_um = 0.3\n\
                [[artefact.place]]\nat_mm = [0.0, 0.0, -100.0]\n";
    let term = "[[term]]\nnames = [\"offset X\", \"offset Y\"]\nlargest_update_um = 15.0\nlargest_total_um = 30.0\n";
    let more = "[[term]]\nnames = [\"growth Z\"]\nlargest_update_um = 9\nlargest_total_um = 9\nsignificance = 4\n";
    let files = "tcomp = \"a.tcomp\"\nthermal = \"thermal.toml\"\nttherm = \"a.ttherm\"\n";
    vec![
        format!("{head}{probe}{ball}{term}").into_bytes(),
        format!("{head}{files}{probe}{ball}{term}{more}").into_bytes(),
        grown(&[EntryKind::Begin, EntryKind::Unchanged, EntryKind::Update]),
        grown(&[EntryKind::Begin, EntryKind::Update, EntryKind::Undo, EntryKind::Begin, EntryKind::Update]),
    ]
}

/// A history with these entries.
fn grown(kinds: &[EntryKind]) -> Vec<u8> {
    let mut history = History::read("", Path::new(HISTORY)).expect("an empty history");
    for kind in kinds {
        let place = BallPlace { name: "ball".into(), centre_mm: [0.1, 0.2, -100.0], standard_error_um: [0.1; 3] };
        let changed = Changed { file: "x.csv".into(), before: None, after: Some("0000abcd".into()) };
        let entry = Entry {
            entry: history.next(),
            kind: *kind,
            time: Some("2026-05-04T06:00:00Z".into()),
            parts: Some(7),
            plan: "1234abcd".into(),
            log: Some(LogFile { file: "look.log".into(), crc: format!("{:08x}", history.next()) }),
            undone: (*kind == EntryKind::Undo).then_some(2),
            sigma_um: Some(0.5),
            measured: vec![Measured {
                term: "offset X".into(),
                unit: "µm".into(),
                value: 6.0,
                standard_error: 0.2,
                from: 0.0,
                to: 6.0,
            }],
            balls: if *kind == EntryKind::Undo { Vec::new() } else { vec![place] },
            totals: [("offset X".into(), 6.0)].into(),
            files: if *kind == EntryKind::Update { vec![changed] } else { Vec::new() },
            tables: ["0000abcd".into(), "0000abcd".into()],
        };
        history = History::read(&history.with(&entry), Path::new(HISTORY)).expect("a good history");
    }
    history.text().as_bytes().to_vec()
}
