//! Records of a ballbar.

use super::instrument::{Instrument, WALK_S, middle};
use crate::range::OutOfRange;
use anyhow::{Result, bail};
use std::f64::consts::TAU;
use std::fmt::Write;
use trueaxis::Axis;
use trueaxis::machine::AXES;
use trueaxis_sim::measured::Walk;

/// Standard deviation of the pivot's place, mm.
const OFF_CENTRE_MM: f64 = 0.02;
/// Moves between two readings: lost motion is taken up within them.
const BETWEEN: usize = 16;

/// Circles in both directions about one centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Circles {
    /// Nominal radius, mm.
    pub radius_mm: f64,
    /// The plane: angles count from the first axis towards the second.
    pub axes: [Axis; 2],
    /// Axis positions X, Y, Z of the centre, mm; `None`: the middle of the travels.
    pub centre_mm: Option<[f64; 3]>,
    /// Readings per circle.
    pub readings: usize,
    /// Feed, mm/min.
    pub feed_mm_per_min: f64,
}

impl Circles {
    /// Checks radius and feed.
    ///
    /// # Errors
    /// A radius outside 1 to 10000 mm, a feed outside 1 to 100000 mm/min.
    pub fn check(&self) -> Result<(), OutOfRange> {
        OutOfRange::check("radius_mm", self.radius_mm, 1.0..=1e4, "mm")?;
        OutOfRange::check("feed_mm_per_min", self.feed_mm_per_min, 1.0..=1e5, "mm/min")
    }

    /// The record of a bar, in the format that `trueaxis ballbar` reads: the distance of the true tip from a pivot some
    /// 20 µm beside the centre, less the radius.
    ///
    /// # Errors
    /// A circle that leaves the travel, an axis that the machine lacks, a travel that is not stated where it is needed.
    pub fn record(&self, of: &Instrument<'_>) -> Result<String> {
        let centre = self.centre(of)?;
        let mut draws = of.conditions.set_up_draws();
        let [i, j] = self.axes.map(Axis::index);
        let mut off = [0.0; 3];
        off[i] = OFF_CENTRE_MM * draws.normal();
        off[j] = OFF_CENTRE_MM * draws.normal();
        of.walk(|walk| {
            walk.go(centre, WALK_S);
            let pivot = walk.ideal() + glam::DVec3::from(off);
            let mut text = String::from("angle_deg,deviation_um,direction\n");
            for direction in [1.0, -1.0] {
                self.circle(walk, centre, direction, |walk, degrees| {
                    let deviation = (walk.tip() - pivot).length() - self.radius_mm + walk.scatter();
                    let _ = writeln!(text, "{degrees},{:.4},{direction}", 1e3 * deviation);
                });
            }
            Ok(text)
        })
    }

    /// Half a turn for the approach, then one with readings.
    fn circle(
        &self,
        walk: &mut Walk<'_>,
        centre: [f64; AXES],
        direction: f64,
        mut read: impl FnMut(&mut Walk<'_>, f64),
    ) {
        let [i, j] = self.axes.map(Axis::index);
        let steps = BETWEEN * self.readings;
        let step_s = 60.0 * TAU * self.radius_mm / self.feed_mm_per_min / steps as f64;
        walk.wait(WALK_S);
        for step in 0..steps + steps / 2 {
            // Turns since the readings began; they are half a step beside the axes.
            let turns = (step as f64 + 1.0 - 0.5 * BETWEEN as f64) / steps as f64 - 0.5;
            let angle = direction * TAU * turns;
            let mut to = centre;
            to[i] += self.radius_mm * angle.cos();
            to[j] += self.radius_mm * angle.sin();
            walk.go(to, if step == 0 { WALK_S } else { step_s });
            let since = step + 1;
            let half = steps / 2;
            if since > half && (since - half).is_multiple_of(BETWEEN) {
                let degrees = (angle.to_degrees() * 1e6).round() / 1e6;
                read(walk, (degrees + 720.0) % 360.0);
            }
        }
    }

    fn centre(&self, of: &Instrument<'_>) -> Result<[f64; AXES]> {
        let settings = &of.truth.settings;
        let mut centre = [0.0; AXES];
        for (k, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
            let letter = axis.letter();
            let on_circle = self.axes.contains(&axis);
            let Some(own) = settings.axis(axis) else {
                if on_circle {
                    bail!("found a machine without {letter}, needed the axes of the circle");
                }
                continue;
            };
            centre[k] = match self.centre_mm {
                Some(centre) => centre[k],
                None => middle(own, "--centre-mm X,Y,Z")?,
            };
            let reach = if on_circle { self.radius_mm } else { 0.0 };
            let [low, high] = own.travel;
            if centre[k] - reach < low || centre[k] + reach > high {
                bail!(
                    "found {letter} from {} to {} mm, needed a circle within its travel, {low} to {high} mm",
                    centre[k] - reach,
                    centre[k] + reach
                );
            }
        }
        Ok(centre)
    }
}
