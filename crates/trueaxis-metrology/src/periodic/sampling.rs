//! What the positions of a record determine: length, spacing, and the harmonics that they separate.

use super::refused::AliasOf;
use super::{LEAST_PERIODS, LEAST_POINTS, MOST_HARMONICS, PeriodicRefusal, Reading};
use std::vec::Vec;

/// Positions closer together than this share of the shortest period count as one.
const SAME: f64 = 0.02;
/// Points are equidistant if each step differs from a multiple of the median by less than this share of it.
const EVEN: f64 = 0.05;
/// Room for rounding in a comparison of lengths.
const ROUNDED: f64 = 1e-9;

/// A harmonic of a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Index of the period.
    pub(super) of: usize,
    pub(super) period: f64,
    pub(super) number: usize,
}

impl Line {
    pub(super) fn frequency(&self) -> f64 {
        self.number as f64 / self.period
    }
}

/// The sampling of a record.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sampling {
    pub(super) length: f64,
    pub(super) spacing: f64,
    is_even: bool,
    /// Harmonics that are fitted, the lowest of all periods first.
    pub(super) lines: Vec<Line>,
    /// Harmonics that coincide with one of another period, which is fitted.
    pub(super) coincide: Vec<(Line, Line)>,
}

/// Checks the positions for these periods; `harmonics` of each if stated, otherwise as many as the points permit.
pub(super) fn sampling(
    readings: &[Reading],
    periods: &[f64],
    harmonics: Option<usize>,
) -> Result<Sampling, PeriodicRefusal> {
    check(readings, periods, harmonics)?;
    let shortest = periods.iter().copied().fold(f64::INFINITY, f64::min);
    let [low, high] = readings
        .iter()
        .map(|own| own.own.position)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], own| [low.min(own), high.max(own)]);
    let length = high - low;
    if let Some(period) = periods.iter().copied().find(|period| length < LEAST_PERIODS * period * (1.0 - ROUNDED)) {
        return Err(PeriodicRefusal::TooShort { period, length: length.max(0.0) });
    }
    // Each direction by itself: it may have its own harmonics.
    let of = [false, true].map(|is_negative| spacing(readings, is_negative, SAME * shortest));
    let coarsest = of.into_iter().flatten().reduce(|one, other| if other.0 > one.0 { other } else { one });
    let (spacing, is_even) = coarsest.unwrap_or((length, false));
    let mut found = Sampling { length, spacing, is_even, lines: Vec::new(), coincide: Vec::new() };
    let mut lines = Vec::new();
    for (of, period) in periods.iter().copied().enumerate() {
        let most = (period / (LEAST_POINTS * spacing) * (1.0 + ROUNDED)).floor() as usize;
        let asked = harmonics.unwrap_or(most.clamp(1, MOST_HARMONICS));
        if asked > most {
            return Err(found.refused(periods, of, asked));
        }
        lines.extend((1..=asked).map(|number| Line { of, period, number }));
    }
    lines.sort_by_key(|line| (line.number, line.of));
    for line in lines {
        let near = |other: &&Line| (line.frequency() - other.frequency()).abs() * length < 1.0 - ROUNDED;
        match found.lines.iter().find(near).copied() {
            None => found.lines.push(line),
            Some(other) if line.number == 1 => {
                return Err(PeriodicRefusal::TooClose { periods: [other.period, line.period], length });
            }
            Some(other) => found.coincide.push((line, other)),
        }
    }
    Ok(found)
}

fn check(readings: &[Reading], periods: &[f64], harmonics: Option<usize>) -> Result<(), PeriodicRefusal> {
    if let Some(found) = periods.iter().copied().find(|period| !(period.is_finite() && *period > 0.0)) {
        return Err(PeriodicRefusal::NotAPeriod { found });
    }
    if let Some(found) = harmonics.filter(|asked| !(1..=MOST_HARMONICS).contains(asked)) {
        return Err(PeriodicRefusal::TooMany { found });
    }
    let finite = |own: &Reading| [own.error, own.own.position, own.along].iter().all(|value| value.is_finite());
    readings.iter().position(|own| !finite(own)).map_or(Ok(()), |index| Err(PeriodicRefusal::NotAReading { index }))
}

/// Distance of the points of one direction, and whether they are equidistant; `None` without two of them.
fn spacing(readings: &[Reading], is_negative: bool, same: f64) -> Option<(f64, bool)> {
    let own = readings.iter().filter(|own| own.own.is_negative == is_negative);
    let mut positions: Vec<f64> = own.map(|own| own.own.position).collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup_by(|next, kept| *next - *kept < same);
    let mut steps: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    steps.sort_by(f64::total_cmp);
    let median = *steps.get(steps.len() / 2)?;
    let is_even = steps.iter().all(|step| {
        let times = (step / median).round();
        times >= 1.0 && (step / median - times).abs() < EVEN
    });
    Some(if is_even { (median, true) } else { (mean, false) })
}

impl Sampling {
    /// The refusal of a harmonic with too few points in a period.
    fn refused(&self, periods: &[f64], of: usize, number: usize) -> PeriodicRefusal {
        let (period, spacing) = (periods[of], self.spacing);
        if !self.is_even {
            return PeriodicRefusal::TooCoarse { period, number, spacing };
        }
        let folded = |frequency: f64| (frequency - (frequency * spacing).round() / spacing).abs();
        let own = folded(number as f64 / period);
        let like = |frequency: f64| (own - frequency).abs() * self.length < 1.0;
        let lines = periods.iter().enumerate().flat_map(|(other, period)| {
            (1..=MOST_HARMONICS).map(move |number| Line { of: other, period: *period, number })
        });
        let other = lines
            .filter(|line| (line.of, line.number) != (of, number))
            .filter(|line| like(folded(line.frequency())))
            .min_by_key(|line| (line.of == of, line.number));
        let of = match other {
            _ if like(0.0) => AliasOf::Constant,
            Some(line) => AliasOf::Harmonic { period: line.period, number: line.number },
            None if own < number as f64 / period * (1.0 - ROUNDED) => AliasOf::Wave(1.0 / own),
            None => return PeriodicRefusal::TooCoarse { period, number, spacing },
        };
        PeriodicRefusal::Aliased { period, number, spacing, of }
    }
}
