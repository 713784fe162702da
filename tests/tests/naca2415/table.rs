//! The table of `docs/benchmark-naca.md`.

use super::course::{Nothing, Outcome, run};
use super::cross_coupling::Estimate;
use super::plugin::Off;
use super::{CROSS_COUPLED, FEEDS, GAINS, compensated, course, cross_coupled, learned};
use std::fmt::Write;
use std::path::Path;

const BEGIN: &str = "<!-- measured by tests/naca2415 -->\n";
const END: &str = "<!-- end -->\n";

fn row(text: &mut String, name: &str, outcome: &Outcome, alone: &Outcome) {
    let Outcome { largest, mean, rms, axes: [x, y] } = outcome;
    let less = |part: f64, whole: f64| match 100.0 * (part / whole - 1.0) {
        0.0 => String::new(),
        percent => format!("{percent:.0} %").replace('-', "−"),
    };
    let (of_largest, of_mean) = (less(*largest, alone.largest), less(*mean, alone.mean));
    writeln!(
        text,
        "| {name} | {largest:.2} | {of_largest} | {mean:.2} | {of_mean} | {rms:.2} | {:.1} / {:.1} | {:.1} / {:.1} |",
        x[0], x[1], y[0], y[1]
    )
    .unwrap();
}

fn measured() -> String {
    let mut text = String::new();
    for feed in FEEDS {
        let course = course(feed);
        let alone = run(&course, &mut Nothing);
        writeln!(text, "\n{} m/min:\n", feed / 1000.0).unwrap();
        writeln!(text, "| | largest | | mean | | RMS | X | Y |\n|---|---|---|---|---|---|---|---|").unwrap();
        let mut add = |name: &str, outcome: &Outcome| row(&mut text, name, outcome, &alone);
        add("nothing", &alone);
        for gains @ [p, i] in CROSS_COUPLED {
            add(&format!("cross-coupling, tangent ({p}, {i}/s)"), &cross_coupled(&course, Estimate::Tangent, gains));
            add(&format!("cross-coupling, circle ({p}, {i}/s)"), &cross_coupled(&course, Estimate::Circle, gains));
        }
        let [p, i] = GAINS;
        add(&format!("trueaxis: feedback alone ({p}, {i}/s)"), &compensated(&course, Some(GAINS), None));
        add("trueaxis: feed-forward alone", &compensated(&course, None, Some(Off::BY_NOTHING)));
        add("**trueaxis: both**", &compensated(&course, Some(GAINS), Some(Off::BY_NOTHING)));
        let wrong = learned::parts(&course, feed, Some(Off::AS_USUAL), 4);
        add("**the same, figures wrong**", &wrong[0]);
        add("**figures wrong, learned from three parts**", &wrong[3]);
    }
    text + "\n"
}

#[test]
fn the_documentation_has_the_figures() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/benchmark-naca.md");
    let text = std::fs::read_to_string(&file).unwrap();
    let (before, rest) = text.split_once(BEGIN).unwrap();
    let (shown, after) = rest.split_once(END).unwrap();
    let measured = measured();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&file, [before, BEGIN, &measured, END, after].concat()).unwrap();
    } else {
        assert!(shown == measured, "docs/benchmark-naca.md shows\n{shown}\nmeasured\n{measured}");
    }
}
