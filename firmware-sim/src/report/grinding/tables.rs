//! The two runs in numbers.

use crate::grinding::{Outcome, Run};
use trueaxis::roundness::ErrorMotion;
use trueaxis_report::{
    Row, Table,
    number::{count, decimals, quantity},
};

pub(super) fn runs(outcome: &Outcome) -> Table {
    let row = |name: &str, value: &dyn Fn(&Run) -> String| {
        Row::new(name, [value(&outcome.uncorrected), value(&outcome.corrected)])
    };
    let um = |value: f64| quantity(value, "µm");
    let seen = |value: Option<f64>| value.map_or("–".to_owned(), um);
    let rows = [
        row("synchronous imprint", &|run| um(run.imprint_um)),
        row("out of roundness, mean", &|run| um(run.roundness_um)),
        row("last revolution: imprint, true", &|run| seen(run.revolutions.last().map(|r| r.imprint_um))),
        row("imprint, gauge", &|run| seen(run.revolutions.last().and_then(|r| r.gauge_imprint_um))),
        row("out of roundness, true", &|run| seen(run.revolutions.last().map(|r| r.roundness_um))),
        row("out of roundness, gauge", &|run| seen(run.revolutions.last().and_then(|r| r.gauge_roundness_um))),
        row("revolutions evaluated", &|run| count(run.counts.evaluated.into())),
        row("revolutions skipped", &|run| count(run.counts.skipped.into())),
        row("revolutions discarded", &|run| count(run.counts.discarded.into())),
        row("cycles of work on a revolution, at most", &|run| count(run.cycles_of_work as u64)),
        row("cycles in which the limiter acted", &|run| count(run.limited_cycles)),
        row("cycles beyond a limit of the correction", &|run| count(run.limits_exceeded)),
    ];
    Table::new(["", "without", "with correction"], rows).caption("The two runs")
}

pub(super) fn motions(outcome: &Outcome) -> Table {
    let row = |name: &str, motion: &ErrorMotion<f64>| {
        let [a, b] = motion.once_per_revolution_um;
        let cells = [motion.synchronous_um, motion.asynchronous_um, a.hypot(b)];
        Row::new(name, cells.map(|um| decimals(um, 3)))
    };
    let [x, y] = &outcome.motion;
    let measured = outcome.corrected.evaluation.filter(|evaluation| evaluation.revolutions > 0);
    let mut rows = vec![row("X, true", x)];
    rows.extend(measured.map(|of| row("X, gauge", &of.x)));
    rows.push(row("Y, true", y));
    rows.extend(measured.map(|of| row("Y, gauge", &of.y)));
    Table::new(["", "synchronous", "asynchronous", "once per revolution"], rows)
        .caption("Error motion of the pin's centre in µm, with correction")
}
