//! A grinding run: its tables, and the figures of its page.

mod figures;

use crate::grinding::{Grinding, Outcome, Run};
use maud::{Markup, Render};
use trueaxis::roundness::{ErrorMotion, GaugeFlags};
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_report::number::{count, quantity, significant};
use trueaxis_sim::SimError;

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn page(grinding: &Grinding, outcome: &Outcome, shown: &Shown) -> String {
    let sections: [(&str, Markup); 5] = [
        ("Roundness, revolution by revolution", figures::progress(outcome)),
        ("The surface", figures::surfaces(grinding, outcome)),
        ("Harmonics of the surface", figures::harmonics(grinding, outcome).render()),
        ("Infeed correction", figures::correction(grinding, outcome).render()),
        ("Motion of the pin's centre", figures::orbits(outcome)),
    ];
    shown.page("", sections)
}

/// Both runs, which took `wall_s`, and the motion of the pin's centre.
///
/// # Errors
/// The machine has no gauge.
pub fn shown(grinding: &Grinding, outcome: &Outcome, wall_s: f64) -> Result<Shown, SimError> {
    let Outcome { uncorrected: before, corrected: after, .. } = outcome;
    let (settings, gauge) = (&grinding.machine.settings, grinding.gauge()?);
    let mut notes = vec![
        format!(
            "the synchronous imprint is the part that repeats with every turn: the corrected harmonics of the true surface, \
             averaged over the last {} revolutions",
            after.averaged
        ),
        "once-per-revolution motion leaves an eccentric pin, asynchronous motion a random one; neither is corrected"
            .into(),
        "X across probe 1, Y along it; the gauge's asynchronous value holds the probes' noise as well".into(),
        format!("two runs in {wall_s:.1} s"),
    ];
    if after.flags.has(GaugeFlags::INFEED_FROZEN) {
        notes.push("the infeed correction was frozen at least once: it was limited, or near its bound".into());
    }
    let infeed = gauge.infeed.iter().map(|infeed| {
        format!("harmonics {} to {} corrected with gain {}", infeed.band.first, infeed.band.last, infeed.gain)
    });
    let speed = significant(grinding.speed_rpm, 3);
    let summary = [
        format!("{} ({})", settings.name, settings.chain),
        format!("{} revolutions at {speed} rpm", count(grinding.revolutions.into())),
        format!("{} servo cycles at {} Hz", count(after.cycles), grinding.rate_hz),
        format!("{} points a revolution", gauge.points),
    ];
    Ok(Shown {
        title: "Grinding a crankpin".into(),
        summary: summary.into_iter().chain(infeed).collect(),
        result: format!(
            "With correction {} % of the synchronous imprint remains: {} instead of {}.",
            significant(100.0 * outcome.imprint_ratio(), 2),
            quantity(after.imprint_um, "µm"),
            quantity(before.imprint_um, "µm")
        ),
        notes,
        tables: vec![runs(outcome), motions(outcome)],
        ..Shown::default()
    })
}

fn runs(outcome: &Outcome) -> Table {
    let row = |name: &str, value: &dyn Fn(&Run) -> Cell| {
        vec![name.into(), value(&outcome.uncorrected), value(&outcome.corrected)]
    };
    let um = |value: Option<f64>| Cell::number(value, 3);
    let whole = |count: u64| Cell::count(count as usize);
    let rows = [
        row("synchronous imprint, µm RMS", &|run| um(Some(run.imprint_um))),
        row("out of roundness, mean, µm", &|run| um(Some(run.roundness_um))),
        row("last revolution: imprint, true, µm", &|run| um(run.revolutions.last().map(|r| r.imprint_um))),
        row("imprint, gauge, µm", &|run| um(run.revolutions.last().and_then(|r| r.gauge_imprint_um))),
        row("out of roundness, true, µm", &|run| um(run.revolutions.last().map(|r| r.roundness_um))),
        row("out of roundness, gauge, µm", &|run| um(run.revolutions.last().and_then(|r| r.gauge_roundness_um))),
        row("revolutions evaluated", &|run| whole(run.counts.evaluated.into())),
        row("revolutions skipped", &|run| whole(run.counts.skipped.into())),
        row("revolutions discarded", &|run| whole(run.counts.discarded.into())),
        row("cycles of work on a revolution, at most", &|run| Cell::count(run.cycles_of_work)),
        row("cycles in which the limiter acted", &|run| whole(run.limited_cycles)),
        row("cycles beyond a limit of the correction", &|run| whole(run.limits_exceeded)),
    ];
    Table::new("The two runs", ["", "without correction", "with correction"], rows)
}

fn motions(outcome: &Outcome) -> Table {
    let row = |name: &str, motion: &ErrorMotion<f64>| {
        let [a, b] = motion.once_per_revolution_um;
        let um = [motion.synchronous_um, motion.asynchronous_um, a.hypot(b)].map(|um| Cell::fixed(um, 3));
        std::iter::once(name.into()).chain(um).collect::<Vec<_>>()
    };
    let [x, y] = &outcome.motion;
    let measured = outcome.corrected.evaluation.filter(|evaluation| evaluation.revolutions > 0);
    let gauge = measured.iter().flat_map(|of| [row("X, gauge", &of.x), row("Y, gauge", &of.y)]);
    let rows = [row("X, true", x), row("Y, true", y)].into_iter().chain(gauge);
    let head = ["", "synchronous, µm", "asynchronous, µm", "once per revolution, µm"];
    Table::new("Error motion of the pin's centre, with correction", head, rows)
}
