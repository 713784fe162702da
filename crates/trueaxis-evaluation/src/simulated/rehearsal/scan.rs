//! Records of a fine scan along an axis.

use super::instrument::{Instrument, WALK_S, middle};
use crate::model::is_declared;
use crate::range::OutOfRange;
use anyhow::{Result, bail};
use std::fmt::Write;
use trueaxis::Axis;
use trueaxis::machine::AXES;
use trueaxis_sim::measured::Walk;

/// Travel before the first reading of each direction, mm: lost motion is taken up along it.
const APPROACH_MM: f64 = 1.0;
/// Most readings of a direction.
const MOST: f64 = 1e5;

/// An axis read at equidistant positions, in positive travel and back.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// The axis.
    pub axis: Axis,
    /// First and last position, mm; `None`: the travel.
    pub range_mm: Option<[f64; 2]>,
    /// Distance of the readings, mm.
    pub step_mm: f64,
    /// Feed, mm/min.
    pub feed_mm_per_min: f64,
    /// Whether to read in positive travel only.
    pub is_one_way: bool,
}

impl Scan {
    /// Checks step and feed.
    ///
    /// # Errors
    /// A step outside 0.0001 to 1000 mm, a feed outside 1 to 100000 mm/min.
    pub fn check(&self) -> Result<(), OutOfRange> {
        OutOfRange::check("step_mm", self.step_mm, 1e-4..=1e3, "mm")?;
        OutOfRange::check("feed_mm_per_min", self.feed_mm_per_min, 1.0..=1e5, "mm/min")
    }

    /// The record of an interferometer, in the format that `trueaxis periodic` reads: true less commanded displacement of the
    /// tip along the axis, other axes in the middle of their travels.
    ///
    /// # Errors
    /// A rotary axis or one that the machine lacks, a range outside the travel or of more than 100000 steps, a travel that is not
    /// stated where it is needed.
    pub fn record(&self, of: &Instrument<'_>) -> Result<String> {
        let [low, high] = self.range(of)?;
        let count = ((high - low) / self.step_mm + 1e-9).floor();
        if !(1.0..MOST).contains(&count) {
            bail!("--step-mm: found {} over {} mm, needed 1 to {MOST} steps", self.step_mm, high - low);
        }
        let mut start = [0.0; AXES];
        for own in of.truth.settings.axes.iter().filter(|own| is_declared(own) && !own.axis.is_rotary()) {
            start[own.axis.index()] = middle(own, "")?;
        }
        let up: Vec<f64> = (0..=count as usize).map(|k| low + self.step_mm * k as f64).collect();
        of.walk(|walk| {
            let mut text = String::from("position_mm,error_um,direction\n");
            self.pass(walk, start, low - APPROACH_MM, up.iter(), 1, &mut text);
            if !self.is_one_way {
                self.pass(walk, start, high + APPROACH_MM, up.iter().rev(), -1, &mut text);
            }
            Ok(text)
        })
    }

    fn pass<'p>(
        &self,
        walk: &mut Walk<'_>,
        mut at: [f64; AXES],
        before: f64,
        positions: impl Iterator<Item = &'p f64>,
        direction: i8,
        text: &mut String,
    ) {
        let own = self.axis.index();
        at[own] = before;
        walk.go(at, WALK_S);
        for position in positions {
            at[own] = *position;
            walk.go(at, 60.0 * self.step_mm / self.feed_mm_per_min);
            let error = walk.error()[own] + walk.scatter();
            let rounded = (position * 1e6).round() / 1e6;
            let _ = writeln!(text, "{rounded},{:.4},{direction}", 1e3 * error);
        }
    }

    fn range(&self, of: &Instrument<'_>) -> Result<[f64; 2]> {
        let letter = self.axis.letter();
        if self.axis.is_rotary() {
            bail!("--axis: found {letter}, needed a linear axis for the rehearsal");
        }
        let Some(own) = of.truth.settings.axis(self.axis) else {
            bail!("found a machine without {letter}, needed the axis of the scan");
        };
        let [first, last] = own.travel;
        let range = match self.range_mm {
            Some(range) => range,
            None => {
                middle(own, "--range-mm FROM,TO")?;
                own.travel
            }
        };
        let [low, high] = range;
        if low.is_nan() || high.is_nan() || low >= high || low < first || high > last {
            bail!(
                "--range-mm: found {low} to {high} mm, needed an ascending range within the travel, {first} to {last} mm"
            );
        }
        Ok(range)
    }
}
