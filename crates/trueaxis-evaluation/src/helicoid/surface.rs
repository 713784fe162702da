//! The flank as points to draw, and displacements along a line on it.

use super::grid::Range;
use super::job::{Job, five};
use super::request::Passes;
use anyhow::{Result, ensure};
use std::f64::consts::TAU;
use trueaxis_metrology::helicoid::Branch;

/// Maximum number of points along a line.
pub(super) const LONGEST: usize = 10_000;
/// Number of points of a base circle, and of another tooth's flank.
const CIRCLE: usize = 120;
const FLANK: usize = 10;
/// Maximum number of teeth drawn.
const TEETH: u32 = 400;

/// `count` values over the whole of a range.
pub(super) fn over(range: Range, count: usize) -> Range {
    if range.count == 1 { range } else { Range { count, ..range } }
}

impl Job {
    /// Points of the flank over the grid's range, in the gear's frame, mm: `rows` of θ, each of `columns` of u, X Y Z per
    /// point.
    ///
    /// One row or column if the range has a single value. `lift_mm` moves the points outward along the normal, for lines that
    /// are to be visible on the flank.
    pub fn mesh(&self, rows: usize, columns: usize, lift_mm: f64) -> Vec<f32> {
        let us: Vec<f64> = over(self.u, columns).values().collect();
        let lifted = |u: f64, theta: f64| {
            let (point, normal) = (self.surface.point(u, theta), self.surface.normal(u, theta));
            [0, 1, 2].map(|i| (point[i] + lift_mm * normal[i]) as f32)
        };
        let thetas = over(self.theta, rows).values();
        thetas.flat_map(|theta| us.iter().flat_map(move |u| lifted(*u, theta))).collect()
    }

    /// Surroundings of the flank, as pairs of points in the gear's frame, mm: base circles and the flanks of the other teeth
    /// at both ends of θ, and the gear's axis between them.
    pub fn surroundings(&self) -> Vec<f32> {
        let mut lines = Vec::new();
        let mut line = |points: &mut dyn Iterator<Item = [f64; 3]>| {
            let mut last: Option<[f64; 3]> = None;
            for point in points {
                if let Some(last) = last.replace(point) {
                    lines.extend(last.into_iter().chain(point).map(|value| value as f32));
                }
            }
        };
        let ends = [self.theta.start, if self.theta.count == 1 { self.theta.start } else { self.theta.stop }];
        let teeth = self.gear.map_or(0, |(gear, _)| gear.teeth.min(TEETH));
        for theta in ends {
            // The involute starts on the base cylinder, u = 0; the next tooth has the same flank, turned.
            let level = |u: f64, turn: f64| {
                let [x, y, _] = self.surface.point(u, theta + turn);
                [x, y, self.surface.point(u, theta)[2]]
            };
            line(&mut (0..=CIRCLE).map(|i| level(0.0, TAU * i as f64 / CIRCLE as f64)));
            for tooth in 1..teeth {
                let turn = TAU * f64::from(tooth) / f64::from(teeth);
                line(&mut over(self.u, FLANK).values().map(|u| level(u, turn)));
            }
        }
        line(&mut ends.into_iter().map(|theta| [0.0, 0.0, self.surface.point(0.0, theta)[2]]));
        lines
    }

    /// Places along a line on the flank: `count` values of one parameter over its range, the other fixed at `held`.
    ///
    /// # Errors
    /// Zero or too many values.
    pub(super) fn line(&self, along: Passes, held: f64, count: usize) -> Result<Vec<[f64; 2]>> {
        ensure!((1..=LONGEST).contains(&count), "found {count} points of a line, needed 1 to {LONGEST}");
        Ok(match along {
            Passes::Theta => over(self.theta, count).values().map(|theta| [held, theta]).collect(),
            Passes::U => over(self.u, count).values().map(|u| [u, held]).collect(),
        })
    }

    /// Displacements along a line on the flank, as eleven consecutive columns: the parameter (rad), then X, Y, Z (mm), A and C
    /// (degrees) of branch 1 and of branch 2.
    ///
    /// # Errors
    /// Zero or too many values; u or θ beyond the flank.
    pub fn curve(&self, along: Passes, held: f64, count: usize) -> Result<Vec<f64>> {
        let places = self.line(along, held, count)?;
        let mut rows = Vec::with_capacity(places.len());
        for [u, theta] in places {
            let [first, second] = [Branch::First, Branch::Second].map(|branch| self.place(u, theta, branch));
            let ([a, b], parameter) = ([five(&first?), five(&second?)], if along == Passes::Theta { theta } else { u });
            let mut row = [parameter; 11];
            row[1..6].copy_from_slice(&a);
            row[6..].copy_from_slice(&b);
            rows.push(row);
        }
        Ok((0..11).flat_map(|column| rows.iter().map(move |row| row[column])).collect())
    }
}
