//! Ballbar readings from recorded positions: from a grid encoder, or from the axes' own encoders.

use super::{BallbarRefusal, Reading};
use crate::circles::least_squares;
use std::f64::consts::TAU;
use std::vec::Vec;

/// A commanded and an actual position at the same time, in the two axes of the plane, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Position sent to the drives.
    pub command: [f64; 2],
    /// Position read at the same time.
    pub actual: [f64; 2],
}

/// A command belongs to the circle if it is off by less than this share of the radius.
const ON_CIRCLE: f64 = 1e-3;
/// Tolerance for a radius to count as the nominal one before the centre is known, as a share of it.
const ALIKE: f64 = 0.02;
/// Distance between the commands used for the first centre, as a share of the radius.
const APART: f64 = 0.1;
/// Number of stretches per circle over which positions are averaged: a tenth of a degree each.
const STRETCHES: f64 = 3600.0;

/// Converts positions into the readings of a bar of length `radius_mm` about the centre of the commanded circles.
///
/// `Δr = |p − m| − R`, with p the actual position, m the least-squares centre of the commands, at the commanded angle and in
/// the commanded direction. The conversion omits approach, departure and standstill, and averages positions within a tenth of
/// a degree.
///
/// Readings from the axes' own encoders show servo errors, friction and the lost motion in front of the encoder, but neither
/// squareness nor straightness.
///
/// Cost: linear in the positions.
///
/// # Errors
/// [`BallbarRefusal::NotAReading`], [`BallbarRefusal::NoCircle`].
pub fn readings(radius_mm: f64, positions: &[Position]) -> Result<Vec<Reading>, BallbarRefusal> {
    let finite = |p: &Position| p.command.iter().chain(&p.actual).all(|value| value.is_finite());
    if let Some(index) = positions.iter().position(|position| !finite(position)) {
        return Err(BallbarRefusal::NotAReading { index });
    }
    let first = first_centre(radius_mm, positions)?;
    let near = |centre: [f64; 2], p: &&Position| {
        ((p.command[0] - centre[0]).hypot(p.command[1] - centre[1]) / radius_mm - 1.0).abs() < ON_CIRCLE
    };
    let own: Vec<[f64; 2]> = positions.iter().filter(|p| near(first, p)).map(|p| p.command).collect();
    let centre = least_squares(&own).map_or(first, |circle| circle.centre);
    let mut stretches: Vec<Stretch> = Vec::new();
    for (before, position) in positions.iter().zip(positions.iter().skip(1)) {
        let [from, to] = [before, position].map(|p| [p.command[0] - centre[0], p.command[1] - centre[1]]);
        let turned = from[0] * to[1] - from[1] * to[0];
        if turned == 0.0 || !near(centre, &position) || !near(centre, &before) {
            continue;
        }
        let counterclockwise = turned > 0.0;
        let angle = to[1].atan2(to[0]).rem_euclid(TAU);
        let number = (angle / TAU * STRETCHES) as u32;
        let [x, y] = [position.actual[0] - centre[0], position.actual[1] - centre[1]];
        let deviation = x.hypot(y) - radius_mm;
        match stretches.last_mut() {
            Some(last) if last.number == number && last.counterclockwise == counterclockwise => {
                last.count += 1.0;
                last.angle += angle;
                last.deviation += deviation;
            }
            _ => stretches.push(Stretch { number, counterclockwise, count: 1.0, angle, deviation }),
        }
    }
    Ok(stretches.into_iter().map(Stretch::mean).collect())
}

/// Consecutive positions within a tenth of a degree.
struct Stretch {
    number: u32,
    counterclockwise: bool,
    count: f64,
    angle: f64,
    deviation: f64,
}

impl Stretch {
    fn mean(self) -> Reading {
        Reading {
            angle_rad: self.angle / self.count,
            deviation_mm: self.deviation / self.count,
            counterclockwise: self.counterclockwise,
        }
    }
}

/// Median centre of the circles through three commands each that have about the given radius.
fn first_centre(radius: f64, positions: &[Position]) -> Result<[f64; 2], BallbarRefusal> {
    let mut apart: Vec<[f64; 2]> = Vec::new();
    for position in positions {
        let [x, y] = position.command;
        if apart.last().is_none_or(|last| (x - last[0]).hypot(y - last[1]) >= APART * radius) {
            apart.push([x, y]);
        }
    }
    let (mut centres, mut radii): (Vec<[f64; 2]>, Vec<f64>) = (Vec::new(), Vec::new());
    for (a, (b, c)) in apart.iter().zip(apart.iter().skip(1).zip(apart.iter().skip(2))) {
        let Some((centre, own)) = through([*a, *b, *c]) else { continue };
        radii.push(own);
        if (own / radius - 1.0).abs() < ALIKE {
            centres.push(centre);
        }
    }
    if centres.len() < 3 {
        return Err(BallbarRefusal::NoCircle { radius_mm: radius, found_mm: median(&mut radii) });
    }
    let [mut x, mut y] = [0, 1].map(|axis| centres.iter().map(|centre| centre[axis]).collect::<Vec<f64>>());
    match (median(&mut x), median(&mut y)) {
        (Some(x), Some(y)) => Ok([x, y]),
        _ => Err(BallbarRefusal::NoCircle { radius_mm: radius, found_mm: None }),
    }
}

/// Circle through three points; `None` if they are collinear.
fn through([a, b, c]: [[f64; 2]; 3]) -> Option<([f64; 2], f64)> {
    let [u, v] = [[b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]];
    let twice = 2.0 * (u[0] * v[1] - u[1] * v[0]);
    let [uu, vv] = [u, v].map(|w| w[0] * w[0] + w[1] * w[1]);
    if twice.abs() < 1e-6 * uu.max(vv) {
        return None;
    }
    let from = [(v[1] * uu - u[1] * vv) / twice, (u[0] * vv - v[0] * uu) / twice];
    Some(([a[0] + from[0], a[1] + from[1]], from[0].hypot(from[1])))
}

fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
