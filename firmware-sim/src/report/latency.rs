//! Histogram of the step's latency.

use super::{Report, Section};
use maud::Render;
use trueaxis_report::{Colour, Figure, Mark, Scale, Stroke, colour, columns, missing, number::count};

/// Columns per decade of latency.
const COLUMNS: u32 = 24;

pub(super) fn section(report: &Report) -> Option<Section> {
    let buckets = report.latency_buckets.iter().map(|bucket| (bucket.low_ns, bucket.high_ns, bucket.count));
    let columns = columns(buckets, COLUMNS);
    let content =
        if columns.is_empty() { missing("No latencies were recorded.") } else { histogram(report, &columns).render() };
    Some(Section { heading: "Latency of the servo step", content })
}

fn marks(report: &Report) -> Vec<Mark> {
    let latency = &report.latency;
    let mark = |(name, ns, colour): (&str, u64, Colour)| Mark {
        x: ns as f64,
        text: format!("{name} {} ns", count(ns)),
        colour,
        dashed: colour == colour::LIMIT,
    };
    let mut marks: Vec<Mark> = [
        ("p50", latency.p50_ns, colour::NEUTRAL),
        ("p99", latency.p99_ns, colour::NEUTRAL),
        ("p99.99", latency.p99_99_ns, colour::NEUTRAL),
        ("budget", latency.budget_ns, colour::LIMIT),
        ("period", latency.period_ns, colour::LIMIT),
    ]
    .into_iter()
    .filter(|mark| mark.1 > 0)
    .map(mark)
    .collect();
    marks.sort_by(|a, b| a.x.total_cmp(&b.x));
    marks
}

fn histogram(report: &Report, columns: &[(f64, f64, u64)]) -> Figure {
    let latency = &report.latency;
    let marks = marks(report);
    let times = || columns.iter().flat_map(|column| [column.0, column.1]).chain(marks.iter().map(|mark| mark.x));
    let low = times().fold(f64::INFINITY, f64::min).max(1.0).log10();
    let high = times().fold(1.0, f64::max).log10();
    // Leave room on the right for the label of the last line.
    let span = (high - low).max(0.5);
    let [left, right] = [low - 0.04 * span, high + 0.17 * span].map(|end| 10_f64.powf(end));
    let most = columns.iter().map(|column| column.2).max().unwrap_or(1) as f64;
    let x = Scale::logarithmic("latency in ns (logarithmic)", left, right);
    let y = Scale::logarithmic("steps (logarithmic)", 0.6, 2.0 * most);
    let mut figure = Figure::full("Histogram of the latency of the servo step", 320, x, y);
    for (low, high, steps) in columns {
        figure.columns([[*low, *steps as f64]], [0.0, high - low], colour::NEUTRAL);
    }
    for mark in marks {
        figure.mark(mark);
    }
    figure
        .area_key("steps; percentiles", colour::NEUTRAL)
        .key("budget and servo period", Stroke::new(colour::LIMIT, 1.3).dashed())
        .caption(format!(
            "{} steps, from {} to {} ns; {} longer than the budget, {} longer than the period (missed deadlines). \
             Measured as wall time on a shared host: shown, not gated. On an ordinary kernel the longest of them show \
             what the kernel does, not what the step does.",
            count(latency.steps),
            count(latency.min_ns),
            count(latency.max_ns),
            count(latency.over_budget),
            count(latency.missed_deadlines)
        ));
    figure
}
