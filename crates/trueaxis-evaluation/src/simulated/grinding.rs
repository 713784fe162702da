//! Tables and plots of a pin ground uncorrected and corrected.

use crate::shown::{Cell, Curve, Plot, Shown, Table};
use trueaxis::roundness::{ErrorMotion, GaugeFlags};
use trueaxis_report::number::{count, quantity, significant};
use trueaxis_sim::SimError;
use trueaxis_sim::grinding::{Grinding, Outcome, Revolution, Run};

/// Names of the two runs.
pub const RUNS: [&str; 2] = ["uncorrected", "corrected"];

/// Both runs revolution by revolution, and the motion of the pin's centre.
///
/// # Errors
/// The machine has no gauge.
pub fn shown(grinding: &Grinding, outcome: &Outcome) -> Result<Shown, SimError> {
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
            "Corrected, {} % of the synchronous imprint remains: {} instead of {}.",
            significant(100.0 * outcome.imprint_ratio(), 2),
            quantity(after.imprint_um, "µm"),
            quantity(before.imprint_um, "µm")
        ),
        notes,
        tables: vec![runs(outcome), motions(outcome)],
        plots: plots([&before.revolutions, &after.revolutions]).into(),
        ..Shown::default()
    })
}

/// Roundness and imprint after every revolution, uncorrected and corrected; for runs that have not ended, as far as they are.
pub fn plots([before, after]: [&[Revolution]; 2]) -> [Plot; 2] {
    let longest = before.len().max(after.len());
    let plot = |title: &str, y, caption, value: fn(&Revolution) -> f64| {
        let values = |run: &[Revolution]| (0..longest).map(|n| run.get(n).map_or(f64::NAN, value)).collect();
        Plot {
            section: "Roundness, revolution by revolution",
            title: title.into(),
            x: ("revolution".into(), ""),
            y,
            logarithmic: true,
            caption,
            at: (1..=longest).map(|n| n as f64).collect(),
            curves: vec![Curve::new(RUNS[0], 5, values(before)), Curve::new(RUNS[1], 6, values(after))],
            ..Plot::default()
        }
    };
    [
        plot(
            "Roundness of the ground pin",
            ("peak to valley", "µm"),
            "Of the true surface about its least-squares circle, all harmonics. The first revolutions still show the rough pin.",
            |of| of.roundness_um,
        ),
        plot(
            "Imprint of the spindle in the corrected band",
            ("root mean square", "µm"),
            "Corrected harmonics of the true surface of each single revolution, asynchronous motion included.",
            |of| of.imprint_um,
        ),
    ]
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
    Table::new("The two runs", ["", RUNS[0], RUNS[1]], rows)
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
    Table::new("Error motion of the pin's centre, corrected", head, rows)
}
