//! Counts over the plants of a trial.

use super::{Case, PARTS, Shape};
use serde::Serialize;
use std::fmt;
use trueaxis_sim::plant::drive::ScaleAt;

/// Ratio from which an error counts as worse than without any part.
const WORSE: f64 = 1.05;

/// Effect of one combination of parts on a group of plants, compared with no part.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The parts.
    pub parts: &'static str,
    /// Plants.
    pub plants: usize,
    /// Plants whose p99.9 or RMS is more than 5 % larger.
    pub worse: usize,
    /// Plants on which either is more than twice as large.
    pub doubled: usize,
    /// Plants that vibrate at the end of the run but not without the plugin.
    pub unstable: usize,
    /// Plants with more motion at the frequency of their chatter.
    pub chatter: usize,
    /// Plants on which the watch led the feedback out.
    pub led_out: usize,
    /// Largest ratio of the errors, and the plant's number.
    pub largest: (f64, usize),
    /// Median ratio of p99.9 and of RMS.
    pub median: [f64; 2],
}

/// Rows of a group of plants.
#[derive(Clone, Debug, Serialize)]
pub struct Tally {
    /// The group.
    pub group: String,
    /// One row for each of [`PARTS`].
    pub rows: Vec<Row>,
}

impl Tally {
    /// All plants, then groups by one property each.
    pub fn of(cases: &[Case]) -> Vec<Tally> {
        let group = |name: &str, member: &dyn Fn(&Case) -> bool| {
            let members: Vec<&Case> = cases.iter().filter(|case| member(case)).collect();
            let rows = PARTS.iter().enumerate().map(|(i, (parts, _))| row(parts, i, &members)).collect();
            Tally { group: name.to_owned(), rows }
        };
        let stated = |case: &Case| case.plant.stated;
        // What lag asks of an axis, against its limit of 50 µm.
        let lag_um = |case: &Case| {
            let s = stated(case);
            1e3 * (1.0 - s.velocity_feed_forward) * case.feed_mm_per_s / s.position_gain_per_s
        };
        vec![
            group("all", &|_| true),
            group("circles", &|case| case.shape == Shape::Circle),
            group("lines", &|case| case.shape == Shape::Line),
            group("lag below 50 µm", &|case| lag_um(case) < 50.0),
            group("lag above 50 µm", &|case| lag_um(case) >= 50.0),
            group("lag below 50 µm, circles", &|case| lag_um(case) < 50.0 && case.shape == Shape::Circle),
            group("lag below 50 µm, lines", &|case| lag_um(case) < 50.0 && case.shape == Shape::Line),
            group("resonance below 60 Hz", &|case| RESONANCES[0].1(case)),
            group("resonance 60 to 120 Hz", &|case| RESONANCES[1].1(case)),
            group("resonance above 120 Hz", &|case| RESONANCES[2].1(case)),
            group("scale on the motor", &|case| stated(case).scale_at == ScaleAt::Motor),
            group("scale on the load", &|case| stated(case).scale_at == ScaleAt::Load),
            group("dead time below a cycle", &|case| stated(case).dead_time_s < case.plant.period_s),
            group("dead time above a cycle", &|case| stated(case).dead_time_s >= case.plant.period_s),
            group("feed below 1.5 m/min", &|case| FEEDS[0].1(case)),
            group("feed 1.5 to 6 m/min", &|case| FEEDS[1].1(case)),
            group("feed above 6 m/min", &|case| FEEDS[2].1(case)),
            group("neither side load nor chatter", &|case| !case.cut.is_loaded() && !case.cut.chatters()),
            group("side load", &|case| case.cut.is_loaded()),
            group("chatter", &|case| case.cut.chatters()),
        ]
    }
}

/// A band of the family: name and member.
type Band = (&'static str, fn(&Case) -> bool);

/// Bands of the lower resonance.
const RESONANCES: [Band; 3] = [
    ("below 60 Hz", |case| lowest_hz(case) < 60.0),
    ("60 to 120 Hz", |case| (60.0..120.0).contains(&lowest_hz(case))),
    ("above 120 Hz", |case| lowest_hz(case) >= 120.0),
];

/// Bands of the feed.
const FEEDS: [Band; 3] = [
    ("below 1.5 m/min", |case| case.feed_mm_per_s < 25.0),
    ("1.5 to 6 m/min", |case| (25.0..100.0).contains(&case.feed_mm_per_s)),
    ("above 6 m/min", |case| case.feed_mm_per_s >= 100.0),
];

fn lowest_hz(case: &Case) -> f64 {
    case.plant.drives.map(|drive| drive.resonance_hz).into_iter().fold(f64::MAX, f64::min)
}

/// Improvement with everything on in bands of resonance and feed: plants without chatter, which no servo loop takes away.
#[derive(Clone, Debug, Serialize)]
pub struct Bands {
    /// All bands together.
    pub all: Improvement,
    /// For each band of the resonance and of the feed.
    pub cells: [[Improvement; FEEDS.len()]; RESONANCES.len()],
}

/// Improvement of a group of plants.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Improvement {
    /// Plants.
    pub plants: usize,
    /// Median improvement of p99.9 and of RMS, share of the error without any part.
    pub median: [f64; 2],
    /// Plants whose RMS is less than half.
    pub halved: usize,
}

impl Bands {
    /// The bands of a trial.
    pub fn of(cases: &[Case]) -> Bands {
        let quiet = |member: &dyn Fn(&Case) -> bool| {
            Improvement::of(&cases.iter().filter(|case| !case.cut.chatters() && member(case)).collect::<Vec<_>>())
        };
        let cells =
            RESONANCES.map(|(_, resonance)| FEEDS.map(|(_, feed)| quiet(&|case| resonance(case) && feed(case))));
        Bands { all: quiet(&|_| true), cells }
    }
}

impl Improvement {
    fn of(cases: &[&Case]) -> Improvement {
        let halved = |case: &&&Case| case.with[0].error_um.rms < 0.5 * case.off.error_um.rms;
        let median = row(PARTS[0].0, 0, cases).median.map(|ratio| 1.0 - ratio);
        Improvement { plants: cases.len(), median, halved: cases.iter().filter(halved).count() }
    }
}

impl fmt::Display for Improvement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.plants == 0 {
            return f.write_str("–");
        }
        // Adding 0 turns −0 into 0.
        let [p999, rms] = self.median.map(|share| (100.0 * share).round() + 0.0);
        write!(f, "{p999} %; {rms} %; {} of {}", self.halved, self.plants)
    }
}

impl fmt::Display for Bands {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = "median of p99.9; median of RMS; plants whose RMS is less than half";
        writeln!(f, "Improvement with everything on, plants without chatter ({what}): {}", self.all)?;
        let bands = || {
            RESONANCES.iter().zip(&self.cells).flat_map(|(resonance, cells)| {
                FEEDS.iter().zip(cells).map(move |(feed, cell)| (resonance.0, feed.0, cell))
            })
        };
        let above: Vec<String> = bands()
            .filter(|(.., cell)| cell.median.into_iter().any(|share| share > 0.5))
            .map(|(resonance, feed, _)| format!("resonance {resonance}, feed {feed}"))
            .collect();
        let above = if above.is_empty() { "nowhere".to_owned() } else { above.join("; ") };
        writeln!(f, "Median improvement of p99.9 or RMS above 50 %: {above}\n")?;
        let feeds = FEEDS.map(|(name, _)| format!("feed {name}"));
        writeln!(f, "| resonance | {} |\n|---|{}", feeds.join(" | "), "---|".repeat(FEEDS.len()))?;
        for ((name, _), cells) in RESONANCES.iter().zip(&self.cells) {
            writeln!(f, "| {name} | {} |", cells.map(|cell| cell.to_string()).join(" | "))?;
        }
        Ok(())
    }
}

fn row(parts: &'static str, i: usize, cases: &[&Case]) -> Row {
    let ratios = || cases.iter().map(|case| (case.with[i].against(case.without(i)), case.number));
    let above = |limit: f64| ratios().filter(|(ratio, _)| *ratio > limit).count();
    let p999 = cases.iter().map(|case| case.with[i].error_um.p999 / case.without(i).error_um.p999);
    let rms = cases.iter().map(|case| case.with[i].error_um.rms / case.without(i).error_um.rms);
    Row {
        parts,
        plants: cases.len(),
        worse: above(WORSE),
        doubled: above(2.0),
        unstable: cases.iter().filter(|case| case.with[i].is_unstable(case.without(i))).count(),
        chatter: cases.iter().filter(|case| case.with[i].chatters_above(case.without(i))).count(),
        led_out: cases.iter().filter(|case| case.with[i].led_out).count(),
        largest: ratios().fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a }),
        median: [median(p999.collect()), median(rms.collect())],
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plants = self.rows.first().map_or(0, |row| row.plants);
        writeln!(f, "{}: {plants} plants", self.group)?;
        writeln!(
            f,
            "  {:<20}{:>8}{:>10}{:>10}{:>9}{:>9}{:>10}{:>9}  {:>13}{:>8}",
            "parts", "worse", "over 2x", "unstable", "chatter", "led out", "largest", "plant", "median p99.9", "RMS"
        )?;
        for row in &self.rows {
            let (largest, number) = row.largest;
            writeln!(
                f,
                "  {:<20}{:>8}{:>10}{:>10}{:>9}{:>9}{largest:>10.2}{number:>9}  {:>13.3}{:>8.3}",
                row.parts, row.worse, row.doubled, row.unstable, row.chatter, row.led_out, row.median[0], row.median[1]
            )?;
        }
        Ok(())
    }
}
