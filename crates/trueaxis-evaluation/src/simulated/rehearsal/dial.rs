//! Sheets of a dial indicator, filled on a machine of stated errors.
//!
//! Faces are exact lines and planes with their own form, the spindle and the bar are exact rotations; the evaluation fits
//! first-order terms.

use super::instrument::{Instrument, WALK_S};
use super::{Conditions, Stream, truth_of};
use crate::calibrate::{Artefact, Dial, DialKind, Plan, Reading, Task, perfect, reading, sheet};
use anyhow::Result;
use glam::{DMat3, DQuat, DVec3};
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_tables::Machine;

/// Standard deviations of quantities of which nothing is stated: form of a face, mm; angle, slope and tilt, rad.
const FORM_MM: f64 = 5e-3;
const ANGLE: f64 = 50e-6;
/// Standard deviations of a set-up: alignment, rad, and zero of the dial, mm.
const ASKEW: f64 = 2e-4;
const ZERO_MM: f64 = 0.05;
/// Standard deviations of a bar's run-out: eccentricity, mm, and inclination, rad.
const RUN_OUT: [f64; 2] = [5e-3, 3e-5];
/// Distance along Z at which the tool is tilted to read how the machine turns it, mm.
const LEVER_MM: f64 = 100.0;

/// A filled sheet, with the truth that the machine's files do not state.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledSheet {
    /// The sheet.
    pub text: String,
    /// Tilts of the spindle about X and Y relative to the machine's carriage, rad.
    pub spindle: [f64; 2],
}

/// Fills the sheet of a task with dials on `truth`, which the tables of `machine` correct if the task says so.
///
/// # Errors
/// Any error of planning; a true machine of another structure.
pub fn dial(task: &Task, machine: &Machine, truth: &Machine, conditions: &Conditions) -> Result<FilledSheet> {
    let plan = Plan::new(task, &perfect(machine))?;
    let truth = truth_of(machine, truth)?;
    let known = task.compensated.then_some(machine);
    let noise = Some(conditions.noise_um.unwrap_or(1e3 * task.probe.repeatability_mm));
    let instrument = Instrument::new(&truth, known, Conditions { noise_um: noise, ..*conditions })?;
    let readings: Vec<(&Dial, &Reading)> = plan.touches.iter().filter_map(|touch| reading(task, touch)).collect();
    let frames = frames(&instrument, &readings)?;
    let mut draws = conditions.draws(Stream::SetUp);
    let spindle = [0; 2].map(|_| ANGLE * draws.normal());
    let tilt = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(spindle[0], spindle[1], 0.0)));
    let mut all = Vec::new();
    for dial in task.artefacts.iter().filter_map(Artefact::dial) {
        let real = Real::new(dial, &mut draws);
        let own = &frames[all.len()..all.len() + dial.readings.len()];
        all.extend(dial.readings.iter().zip(own).map(|(reading, frame)| 1e3 * (real.read(dial, reading, frame, tilt))));
    }
    for (um, frame) in all.iter_mut().zip(&frames) {
        *um += 1e3 * frame.scatter;
    }
    Ok(FilledSheet { text: sheet(task, &plan, Some(&all)), spindle })
}

/// The carriage of the spindle at a reading: tip, and the directions of its frame, in workpiece coordinates.
struct Frame {
    tip: DVec3,
    directions: DMat3,
    scatter: f64,
}

/// Walks the machine with tools of several offsets: their differences are the directions of the carriage.
fn frames(instrument: &Instrument<'_>, readings: &[(&Dial, &Reading)]) -> Result<Vec<Frame>> {
    let mut walks = Vec::new();
    for offset in [DVec3::ZERO, LEVER_MM * DVec3::X, LEVER_MM * DVec3::Y] {
        let mut truth = instrument.truth.clone();
        let tool = DVec3::from(truth.settings.tool_mm) + offset;
        truth.settings.tool_mm = tool.into();
        let walked = instrument.of(&truth).walk(|walk| {
            let mut tips = Vec::new();
            for (_, reading) in readings {
                let [x, y, z] = reading.at_mm;
                // A millimetre back, so that every axis arrives in positive travel.
                walk.go([x - 1.0, y - 1.0, z - 1.0, 0.0, 0.0, 0.0], WALK_S);
                walk.go([x, y, z, 0.0, 0.0, 0.0], WALK_S);
                tips.push((walk.tip(), walk.scatter()));
            }
            Ok(tips)
        })?;
        walks.push(walked);
    }
    let frame = |index: usize| {
        let [(tip, scatter), (x, _), (y, _)] = [walks[0][index], walks[1][index], walks[2][index]];
        let (x, y) = ((x - tip).normalize(), (y - tip).normalize());
        Frame { tip, directions: DMat3::from_cols(x, y, x.cross(y)), scatter }
    };
    Ok((0..readings.len()).map(frame).collect())
}

/// A set-up with its true values.
enum Real {
    Face { lines: Vec<[f64; 2]>, form: Vec<f64> },
    Square { angle: f64, turns: Vec<f64>, zeros: Vec<[f64; 2]> },
    Table { slope: [f64; 2], zero: f64 },
    Bar { eccentric: DVec3, inclined: DVec3, taper: f64, zeros: [f64; 2], height: f64 },
}

impl Real {
    fn new(dial: &Dial, draws: &mut Draws) -> Real {
        let mut normal = |size: f64| size * draws.normal();
        match dial.kind {
            DialKind::Straightness { form, points, .. } => Real::Face {
                lines: (0..dial.placements).map(|_| [normal(ZERO_MM), normal(ASKEW)]).collect(),
                form: (0..points).map(|_| normal(form.unwrap_or(FORM_MM))).collect(),
            },
            DialKind::Squareness { angle, .. } => Real::Square {
                angle: normal(angle.unwrap_or(ANGLE)),
                turns: (0..dial.placements).map(|_| normal(ASKEW)).collect(),
                zeros: (0..dial.placements).map(|_| [normal(ZERO_MM), normal(ZERO_MM)]).collect(),
            },
            DialKind::Tram { table, .. } => {
                let size = table.unwrap_or(ANGLE);
                Real::Table { slope: [normal(size), normal(size)], zero: normal(ZERO_MM) }
            }
            DialKind::Bar { taper } => Real::Bar {
                eccentric: DVec3::new(normal(RUN_OUT[0]), normal(RUN_OUT[0]), 0.0),
                inclined: DVec3::new(normal(RUN_OUT[1]), normal(RUN_OUT[1]), 0.0),
                taper: normal(taper),
                zeros: [normal(ZERO_MM), normal(ZERO_MM)],
                height: dial.readings.iter().map(|reading| reading.at_mm[2]).fold(f64::NEG_INFINITY, f64::max),
            },
        }
    }

    /// The reading without scatter, mm; `tilt`: of the spindle in its carriage.
    fn read(&self, dial: &Dial, reading: &Reading, frame: &Frame, tilt: DMat3) -> f64 {
        let at = |axis: usize| frame.tip[axis];
        let first = dial.readings[0].at_mm;
        match (self, dial.kind) {
            (Real::Face { lines, form }, DialKind::Straightness { moves, reads, .. }) => {
                let [zero, turn] = lines[reading.placement];
                let line = first[reads] + zero + (at(moves) - first[moves]) * turn.tan();
                reading.side * (line + reading.side * form[reading.index] - at(reads))
            }
            (Real::Square { angle, turns, zeros }, DialKind::Squareness { arms: [u, v], .. }) => {
                let (turn, over) = (turns[reading.placement], if reading.placement > 0 { -1.0 } else { 1.0 });
                let zero = zeros[reading.placement][reading.line];
                let line = match reading.line {
                    0 => first[v] + zero + (at(u) - first[u]) * turn.tan(),
                    _ => first[u] + zero - (at(v) - first[v]) * (turn + over * angle).tan(),
                };
                reading.side * (line - at(reading.reads))
            }
            (Real::Table { slope, zero }, DialKind::Tram { .. }) => {
                let contact = tilt * DVec3::from(dial.contact(reading));
                let spindle = frame.directions * tilt;
                let point = frame.tip + frame.directions * contact;
                // Along the spindle to the table.
                let normal = DVec3::new(-slope[0], -slope[1], 1.0);
                let away = normal.dot(point - DVec3::from(first)) - zero;
                -away / normal.dot(spindle.z_axis)
            }
            (Real::Bar { eccentric, inclined, taper, zeros, height }, _) => {
                let turned = DMat3::from_rotation_z(reading.spindle_deg.to_radians());
                let spindle = frame.directions * tilt;
                let axis = spindle * turned * (DVec3::Z + *inclined);
                let foot = frame.tip + spindle * turned * *eccentric;
                // The dial is at a fixed height: the higher the machine, the lower it is on the bar.
                let above = height - foot.z;
                let centre = foot + axis * (above / axis.z);
                let radius = taper * above;
                reading.side * (centre[reading.reads] - first[reading.reads] - zeros[reading.line]) + radius
            }
            _ => 0.0,
        }
    }
}
