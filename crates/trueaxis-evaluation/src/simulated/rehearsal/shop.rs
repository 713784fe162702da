//! Records of tests with instruments: points of a tracer, R-tests, diagonals.

use super::instrument::{Instrument, WALK_S};
use crate::calibrate::Ideal;
use crate::model::is_declared;
use anyhow::{Result, anyhow, bail};
use glam::DVec3;
use std::fmt::Write;
use trueaxis::Axis;
use trueaxis::machine::AXES;

/// Standard deviations of the place of an instrument of points, mm and rad.
const INSTRUMENT: [f64; 2] = [0.05, 50e-6];
/// Standard deviation of a ball's place, mm.
const BALL_OFF_MM: f64 = 0.02;
const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// Declared travels of X, Y and Z, mm.
fn travels(of: &Instrument<'_>) -> Result<[[f64; 2]; 3]> {
    let mut travels = [[0.0; 2]; 3];
    for (travel, axis) in travels.iter_mut().zip(LINEAR) {
        let letter = axis.letter();
        let own = of.truth.settings.axis(axis).ok_or_else(|| anyhow!("found a machine without {letter}, needed it"))?;
        if !is_declared(own) {
            bail!("found no axis.{letter}.travel_mm, needed it");
        }
        *travel = own.travel;
    }
    Ok(travels)
}

fn along([low, high]: [f64; 2], k: usize, count: usize) -> f64 {
    low + (high - low) * k as f64 / (count - 1) as f64
}

/// Points of a tracer or tracker throughout the travels.
#[derive(Clone, Debug, PartialEq)]
pub struct TracedPoints {
    /// Points along X, Y and Z, 2 to 41.
    pub points: [usize; 3],
    /// Offsets of the reflector from the last tool-side frame, mm; empty: the machine's tool alone.
    pub reflectors_mm: Vec<[f64; 3]>,
}

impl TracedPoints {
    /// The record in the format that `trueaxis evaluate points` reads. Every point is approached in positive travel; the
    /// instrument is some 0.05 mm and 50 µrad off its place.
    ///
    /// # Errors
    /// Numbers of points out of their range, an axis without travel.
    pub fn record(&self, of: &Instrument<'_>) -> Result<String> {
        if let Some(count) = self.points.iter().find(|count| !(2..=41).contains(*count)) {
            bail!("--points: found {count}, needed 2 to 41 along each axis");
        }
        let travels = travels(of)?;
        let mut draws = of.conditions.set_up_draws();
        let mut vector = |size: f64| size * DVec3::from_array([0; 3].map(|_| draws.normal()));
        let [shift, turn] = INSTRUMENT.map(&mut vector);
        let own = [of.truth.settings.tool_mm];
        let reflectors = if self.reflectors_mm.is_empty() { &own[..] } else { &self.reflectors_mm };
        let mut text = String::from("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm");
        text.push_str(if self.reflectors_mm.is_empty() { "\n" } else { ",tool_x_mm,tool_y_mm,tool_z_mm\n" });
        for reflector in reflectors {
            let mut truth = of.truth.clone();
            truth.settings.tool_mm = *reflector;
            of.of(&truth).walk(|walk| {
                let [nx, ny, nz] = self.points;
                for index in 0..nx * ny * nz {
                    let counts = [index % nx, index / nx % ny, index / (nx * ny)];
                    let at: [f64; 3] = std::array::from_fn(|k| along(travels[k], counts[k], self.points[k]));
                    // A millimetre back, so that every axis arrives in positive travel.
                    walk.go([at[0] - 1.0, at[1] - 1.0, at[2] - 1.0, 0.0, 0.0, 0.0], WALK_S);
                    walk.go([at[0], at[1], at[2], 0.0, 0.0, 0.0], 1.0);
                    let place = DVec3::from(at);
                    let seen = place + walk.error() + shift + turn.cross(place + DVec3::from(*reflector));
                    let seen = seen + DVec3::new(walk.scatter(), walk.scatter(), walk.scatter());
                    let _ = write!(text, "{},{},{},{:.6},{:.6},{:.6}", at[0], at[1], at[2], seen.x, seen.y, seen.z);
                    if !self.reflectors_mm.is_empty() {
                        let [x, y, z] = reflector;
                        let _ = write!(text, ",{x},{y},{z}");
                    }
                    text.push('\n');
                }
                Ok(())
            })?;
        }
        Ok(text)
    }
}

/// A ball on the table, followed while rotary axes turn.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowedBall {
    /// Axis positions X, Y, Z at which the tool is at the ball with the rotary axes at zero, mm.
    pub ball_mm: [f64; 3],
    /// Angles of A, B, C, degrees.
    pub angles_deg: Vec<[f64; 3]>,
}

impl FollowedBall {
    /// The record in the format that `trueaxis evaluate r-test` reads: the displacement of the true tool from a ball some
    /// 20 µm off its place, in the machine's directions. The commands are those of RTCP on a perfect machine.
    ///
    /// # Errors
    /// No rotary axis, an angle of an axis that the machine lacks, a command outside the travel.
    pub fn record(&self, of: &Instrument<'_>) -> Result<String> {
        let settings = &of.truth.settings;
        let rotary: Vec<Axis> = settings.axes.iter().map(|own| own.axis).filter(|axis| axis.is_rotary()).collect();
        if rotary.is_empty() {
            bail!("found the chain {:?}, needed rotary axes", settings.chain.as_str());
        }
        let missing = |angles: &[f64; 3]| {
            [Axis::A, Axis::B, Axis::C]
                .into_iter()
                .zip(*angles)
                .find(|(axis, deg)| *deg != 0.0 && !rotary.contains(axis))
        };
        if let Some((axis, deg)) = self.angles_deg.iter().find_map(missing) {
            bail!("--angles-deg: found {deg} of {}, needed an axis of the machine", axis.letter());
        }
        let ideal = Ideal::new(of.truth)?;
        let [x, y, z] = self.ball_mm;
        let point = ideal.tip(&[x, y, z, 0.0, 0.0, 0.0]);
        let mut commands = Vec::new();
        for [a, b, c] in &self.angles_deg {
            let command = ideal.reach(&[x, y, z, *a, *b, *c], point);
            within(of, &command)?;
            commands.push(command);
        }
        let mut draws = of.conditions.set_up_draws();
        let off = DVec3::from_array([0; 3].map(|_| BALL_OFF_MM * draws.normal()));
        let columns: String =
            rotary.iter().map(|axis| format!(",{}_deg", axis.letter().to_ascii_lowercase())).collect();
        let mut text = format!("x_mm,y_mm,z_mm{columns},dx_um,dy_um,dz_um\n");
        of.walk(|walk| {
            for command in &commands {
                walk.go(*command, WALK_S);
                // The ball turns with the table: seen from the machine, its offset is that of its commanded place.
                let turned = DVec3::from(ideal.turned(command, off.to_array()));
                let d = 1e3 * (walk.error() - turned);
                let d = [d.x, d.y, d.z].map(|um| um + 1e3 * walk.scatter());
                let [x, y, z, ..] = command;
                let _ = write!(text, "{x:.6},{y:.6},{z:.6}");
                rotary.iter().for_each(|axis| {
                    let _ = write!(text, ",{}", command[axis.index()]);
                });
                let _ = writeln!(text, ",{:.4},{:.4},{:.4}", d[0], d[1], d[2]);
            }
            Ok(text)
        })
    }
}

/// Refuses a command outside the travel.
fn within(of: &Instrument<'_>, command: &[f64; AXES]) -> Result<()> {
    for own in &of.truth.settings.axes {
        let (at, [low, high]) = (command[own.axis.index()], own.travel);
        if !(low..=high).contains(&at) {
            let letter = own.axis.letter();
            bail!("found {letter} at {at:.3} under RTCP, needed a ball within its travel, {low} to {high}");
        }
    }
    Ok(())
}

/// Displacements along the four body diagonals of the travels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diagonals {
    /// Whether X, Y and Z move one after the other.
    pub steps: bool,
    /// Steps along a diagonal, 2 to 100.
    pub targets: usize,
    /// Runs, 1 to 20.
    pub runs: u32,
    /// Standard deviation of the alignment of beam and mirror on each diagonal, rad.
    pub alignment: f64,
    /// Distance from the ends of the travels, mm.
    pub margin_mm: f64,
}

/// Signs of X, Y, Z along the diagonals.
const SIGNS: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]];

impl Diagonals {
    /// The record in the format that `trueaxis evaluate step-diagonal` reads: the way of the true tip along the normal of a
    /// plane mirror, less the commanded way along the beam.
    ///
    /// # Errors
    /// Numbers out of their range, an axis without travel, a margin that leaves no box.
    pub fn record(&self, of: &Instrument<'_>) -> Result<String> {
        if !(2..=100).contains(&self.targets) {
            bail!("--targets: found {}, needed 2 to 100", self.targets);
        }
        let mut bounds = travels(of)?;
        for ([low, high], axis) in bounds.iter_mut().zip(LINEAR) {
            (*low, *high) = (*low + self.margin_mm, *high - self.margin_mm);
            if *high - *low < 10.0 {
                bail!("--margin-mm: found {}, needed at least 10 mm of {} within it", self.margin_mm, axis.letter());
            }
        }
        let mut draws = of.conditions.set_up_draws();
        let tilts = SIGNS.map(|_| self.alignment * DVec3::from_array([0; 3].map(|_| draws.normal())));
        let mut text = String::from("diagonal,run,direction,x_mm,y_mm,z_mm,deviation_um\n");
        of.walk(|walk| {
            for (number, (signs, tilt)) in (1..).zip(SIGNS.into_iter().zip(tilts)) {
                let way = self.way(&bounds, signs);
                let (from, to) = (way[0], way[way.len() - 1]);
                let beam = (to - from).normalize();
                // The mirror measures along its own normal, the laser commands along the beam.
                let normal = beam + tilt - tilt.dot(beam) * beam;
                let back: Vec<DVec3> = way.iter().rev().copied().collect();
                for run in 1..=self.runs {
                    for (direction, targets, beyond) in [(1, &way, -beam), (-1, &back, beam)] {
                        walk.go(position(targets[0] + beyond), WALK_S);
                        for target in targets {
                            walk.go(position(*target), WALK_S);
                            let seen = (*target - from + walk.error()).dot(normal);
                            let deviation = seen - (*target - from).dot(beam) + walk.scatter();
                            let DVec3 { x, y, z } = *target;
                            let _ = writeln!(text, "{number},{run},{direction},{x},{y},{z},{:.4}", 1e3 * deviation);
                        }
                    }
                }
            }
            Ok(text)
        })
    }

    fn way(&self, bounds: &[[f64; 2]; 3], signs: [f64; 3]) -> Vec<DVec3> {
        let end = |axis: usize, k: usize| {
            let [low, high] = bounds[axis];
            let ends = if signs[axis] > 0.0 { [low, high] } else { [high, low] };
            along(ends, k, self.targets + 1)
        };
        let mut at = DVec3::new(end(0, 0), end(1, 0), end(2, 0));
        let mut way = vec![at];
        for k in 1..=self.targets {
            for axis in 0..3 {
                at[axis] = end(axis, k);
                if self.steps || axis == 2 {
                    way.push(at);
                }
            }
        }
        way
    }
}

fn position(of: DVec3) -> [f64; AXES] {
    [of.x, of.y, of.z, 0.0, 0.0, 0.0]
}
