//! Zones of the profile and error motion of the spindle in numbers.

use crate::report::range;
use trueaxis_evaluation::roundness::{RoundnessDocument, SpindleDirection, Zones};
use trueaxis_report::{
    Row, Table,
    number::{shortest, significant},
};

/// One zone of a revolution.
type Pick = fn(&Zones) -> f64;

pub(super) fn zones(found: &RoundnessDocument) -> Table {
    let picks: [(&str, Pick); 4] = [
        ("LSC, least squares", |zones| zones.lsc_um),
        ("MZC, minimum zone", |zones| zones.mzc_um),
        ("MIC, maximum inscribed", |zones| zones.mic_um),
        ("MCC, minimum circumscribed", |zones| zones.mcc_um),
    ];
    let rows = picks.map(|(name, pick)| {
        let single = range(found.per_revolution.iter().map(|revolution| pick(&revolution.zones)));
        let single = single.map(|um| significant(um, 3)).join(" to ");
        Row::new(name, [significant(pick(&found.zones), 3), single])
    });
    Table::new(["circle", "mean profile", "single revolutions"], rows).caption("Roundness, peak to valley in µm")
}

pub(super) fn spindle(found: &RoundnessDocument) -> Table {
    let row = |name: &str, of: &SpindleDirection| {
        let [synchronous, total, once] =
            [of.synchronous_um, of.total_um, of.once_per_revolution_um].map(|um| significant(um, 3));
        let asynchronous = of.asynchronous_um.map_or("–".to_owned(), |um| significant(um, 3));
        let phase = shortest(of.once_per_revolution_phase_deg.round());
        Row::new(name, [synchronous, asynchronous, total, format!("{once} at {phase}°")])
    };
    let rows = [row("X, across probe 1", &found.spindle.x), row("Y, along probe 1", &found.spindle.y)];
    Table::new(["", "synchronous", "asynchronous", "total", "once per revolution"], rows)
        .caption("Spindle error motion in µm")
}
