//! Records of circles for identifying friction: `trueaxis friction` and the desk.

use crate::choice::one_in;
use crate::{Target, no_repair, outcome, refusal, small};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;
use trueaxis::Axis;
use trueaxis_evaluation::friction::{Recording, additions, columns, fit, sections};
use trueaxis_evaluation::rows::Rows;
use trueaxis_sim::Settings;
use trueaxis_sim::friction::{Circles, Plane, Recorder};
use trueaxis_sim::run::Kind;
use trueaxis_tables::files::Memory;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "friction",
    about: "records of circles (CSV), some completed to whole circles after the input, and friction found in some",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/csv.dict"),
    slowest: FITTED,
};

const FILE: &str = "record.csv";
/// A fit that hardly converges follows the record some thousand times.
const FITTED: Duration = Duration::from_secs(10);
const AXES: [Axis; 2] = [Axis::X, Axis::Y];
/// Longer inputs reach nothing new.
const MOST_ROWS: usize = 64;
/// One in so many valid but incomplete inputs is completed; one in so many of these is fitted.
const WHOLE_ONE_IN: u64 = 32;
const FIT_ONE_IN: u64 = 4096;

fn run(bytes: &[u8]) {
    let lines = bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count();
    if lines > MOST_ROWS {
        return;
    }
    let refused = match read(bytes) {
        Ok(recording) => panic!("a record of {} samples", recording.record.axes[0].command.len()),
        Err(error) => format!("{error:#}"),
    };
    refusal::of_file(&refused, FILE, bytes);
    let good = refused.contains("samples");
    if good {
        outcome::accepted();
    }
    if good && bytes.starts_with(HEADER.as_bytes()) && bytes.ends_with(b"\n") && one_in(WHOLE_ONE_IN, bytes) {
        whole(bytes, lines - 1);
    }
}

fn read(bytes: &[u8]) -> anyhow::Result<Recording> {
    let rows = Rows::new(bytes, Path::new(FILE), &columns(AXES), outcome::refused)?;
    Recording::read(rows, AXES)
}

const HEADER: &str = "t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm\n";

/// Circles on a machine with friction, at 1 kHz.
fn record() -> &'static [String] {
    static RECORD: OnceLock<Vec<String>> = OnceLock::new();
    RECORD.get_or_init(|| {
        let circles = Circles::new(Plane::Xy, 4.0, &[1500.0, 4500.0], 1).expect("good circles");
        let settings = Settings { rate_hz: 1000.0, ..Settings::default() };
        let machine = small::machine("w b X Y Z t");
        let mut recorder = Recorder::new(&circles, machine, settings, Kind::Compensated).expect("a good run");
        while recorder.advance(u64::MAX) {}
        let csv = recorder.finish().csv();
        let rows = csv.strip_prefix(HEADER).expect("the columns of the record");
        rows.split_inclusive('\n').map(str::to_owned).collect()
    })
}

/// The input, completed with the rows of a record that follow the first `rows`.
fn whole(bytes: &[u8], rows: usize) {
    let mut text = bytes.to_vec();
    let rest = record().get(rows..).unwrap_or_default();
    rest.iter().for_each(|row| text.extend_from_slice(row.as_bytes()));
    let recording = match read(&text) {
        Ok(recording) => recording,
        Err(error) => return refusal::of_file(&format!("{error:#}"), FILE, &text),
    };
    let record = &recording.record;
    assert!((1e-5..=2e-3).contains(&record.period_s) && record.axes[0].axis == AXES[0]);
    assert!(record.axes.iter().all(|axis| axis.command.len() >= 2000 && axis.command.len() == axis.reading.len()));
    let trace = serde_json::to_string(&recording.trace(50)).expect("a trace");
    assert!(!trace.contains("null"), "{trace}");
    outcome::saw("whole");
    if one_in(FIT_ONE_IN, bytes) {
        fitted(&recording);
    }
}

fn fitted(recording: &Recording) {
    match fit(recording, [None; 2], &mut |_, _| {}) {
        Ok((found, document)) => {
            let text = serde_json::to_string(&document).expect("a document");
            for own in &found {
                let figures = [own.coulomb_per_s, own.presliding, own.stribeck_share, own.viscous];
                assert!(figures.iter().all(|figure| figure.value.is_finite() && figure.value >= 0.0), "{text}");
            }
            assert!(sections(&recording.file, &found).contains("[axis.Y.friction]"));
            let machine = Memory::new([("machine.toml", "name = \"m\"\nchain = \"w b X Y Z t\"\n")]);
            // A figure with a large uncertainty may be rounded out of its range.
            if let Err(error) = additions(&found).edit(&machine, Path::new("machine.toml")) {
                refusal::in_words(&error.to_string());
            }
            outcome::saw("fitted");
        }
        Err(error) => refusal::in_words(&format!("{error:#}")),
    }
}

fn seeds() -> Vec<Vec<u8>> {
    let start = |rows: usize| format!("{HEADER}{}", record()[..rows].concat());
    let semicolons = "x_mm;t_s;x_cmd_mm;y_mm;y_cmd_mm;z_mm\n0,5;0;0,5;1;1;0\n0,5;0,001;0,5;1;1;0\n# end\n";
    [start(1), start(2), start(3), semicolons.into()].map(String::into_bytes).into()
}
