//! Histogram of the step's latency.

use super::{
    Report, Section,
    figure::{Figure, Key, Mark, Scale, colour, framed},
    number::count,
};
use crate::latency::LatencyBucket;

/// Columns per decade of latency.
const COLUMNS: i32 = 24;

pub(super) fn section(report: &Report) -> Option<Section> {
    let columns = columns(&report.latency_buckets);
    let html = if columns.is_empty() {
        "<p class=\"empty\">No latencies were recorded.</p>\n".to_owned()
    } else {
        histogram(report, &columns)
    };
    Some(Section { heading: "Latency of the servo step", html })
}

/// Adds the histogram's fine buckets up into columns of equal width in the logarithm: `(low, high, count)`, ns.
fn columns(buckets: &[LatencyBucket]) -> Vec<(f64, f64, u64)> {
    let mut columns: Vec<(f64, f64, u64)> = Vec::new();
    for bucket in buckets.iter().filter(|bucket| bucket.count > 0) {
        let middle = bucket.low_ns.midpoint(bucket.high_ns).max(1) as f64;
        let number = (middle.log10() * f64::from(COLUMNS)).floor();
        // Times are whole nanoseconds: edges between them are moved up to the next one.
        let edge = |number: f64| 10_f64.powf(number / f64::from(COLUMNS)).ceil();
        let (low, high) = (edge(number), edge(number + 1.0).max(edge(number) + 1.0));
        match columns.last_mut() {
            Some(last) if middle < last.1 => last.2 = last.2.saturating_add(bucket.count),
            _ => columns.push((low.min(middle.floor()), high, bucket.count)),
        }
    }
    columns
}

fn histogram(report: &Report, columns: &[(f64, f64, u64)]) -> String {
    let latency = &report.latency;
    let mut marks: Vec<Mark> = [
        ("p50", latency.p50_ns, colour::NEUTRAL, false),
        ("p99", latency.p99_ns, colour::NEUTRAL, false),
        ("p99.99", latency.p99_99_ns, colour::NEUTRAL, false),
        ("budget", latency.budget_ns, colour::LIMIT, true),
        ("period", latency.period_ns, colour::LIMIT, true),
    ]
    .into_iter()
    .filter(|mark| mark.1 > 0)
    .map(|(name, ns, colour, dashed)| Mark {
        x: (ns as f64).log10(),
        text: format!("{name} {} ns", count(ns)),
        colour,
        dashed,
    })
    .collect();
    marks.sort_by(|a, b| a.x.total_cmp(&b.x));

    let lowest = columns.iter().map(|column| column.0).fold(f64::INFINITY, f64::min).max(1.0).log10();
    let highest = columns.iter().map(|column| column.1).fold(1.0, f64::max).log10();
    let low = marks.iter().map(|mark| mark.x).fold(lowest, f64::min);
    let high = marks.iter().map(|mark| mark.x).fold(highest, f64::max);
    // Room on the right for the label of the last line.
    let span = (high - low).max(0.5);
    let x = Scale::logarithmic("latency in ns (logarithmic)", low - 0.04 * span, high + 0.17 * span, span < 4.5);
    let most = columns.iter().map(|column| column.2).max().unwrap_or(1) as f64;
    let y = Scale::logarithmic("steps (logarithmic)", 0.6_f64.log10(), (most * 2.0).log10(), most < 100.0);

    let figure = Figure {
        description: "Histogram of the latency of the servo step".to_owned(),
        width: 1120,
        height: 320,
        head: 0,
        x,
        y,
        marks,
    };
    let svg = figure.draw(|plot| {
        columns.iter().try_for_each(|&(a, b, n)| plot.column(a.log10(), b.log10(), (n as f64).log10(), colour::NEUTRAL))
    });
    let keys = [
        Key { colour: colour::NEUTRAL, dashed: false, text: "steps; percentiles" },
        Key { colour: colour::LIMIT, dashed: true, text: "budget and servo period" },
    ];
    let caption = format!(
        "{} steps, from {} to {} ns; {} longer than the budget, {} longer than the period (missed deadlines). \
         Measured as wall time on a shared host: shown, not gated. On an ordinary kernel the longest of them show what the \
         kernel does, not what the step does.",
        count(latency.steps),
        count(latency.min_ns),
        count(latency.max_ns),
        count(latency.over_budget),
        count(latency.missed_deadlines)
    );
    framed("full", &keys, &svg, &caption)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_hold_every_step_once_and_do_not_overlap() {
        let mut latency = crate::latency::Latency::new(1, 1);
        (0..3_000_u64).for_each(|k| latency.record(k * k + k % 7));
        let buckets: Vec<_> = latency.buckets().collect();
        let columns = columns(&buckets);
        assert_eq!(columns.iter().map(|column| column.2).sum::<u64>(), 3_000);
        assert!(columns.iter().all(|column| column.0 < column.1));
        assert!(columns.windows(2).all(|pair| pair[0].1 <= pair[1].0), "{columns:?}");
    }
}
