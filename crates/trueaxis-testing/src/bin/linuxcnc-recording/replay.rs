//! Runs the recorded commands and readings through the library itself.

use crate::recording::Recording;
use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use trueaxis::contour::CommandWindow;
use trueaxis::tcomp::Tcomp;
use trueaxis::{Axis, HostServo, Input};

/// Difference between component and library.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Agreement {
    /// Samples compared, of every joint.
    pub(crate) samples: usize,
    /// Number of those that are equal to the last bit.
    pub(crate) same_bits: usize,
    /// Largest difference of a position sent to a drive, mm (deg).
    pub(crate) largest_difference: f64,
    /// Sample and joint where that is.
    pub(crate) at: (usize, usize),
    /// Largest correction in the recording, mm (deg).
    pub(crate) largest_correction: f64,
    /// Largest dynamic correction in it, mm (deg).
    pub(crate) largest_dynamic: f64,
}

/// Spans of the window of the last commands, and the distance of its points, mm: as in the component.
const WINDOW: (usize, f64) = (64, 0.005);

/// Columns of one joint.
struct Joint {
    place: usize,
    pos_cmd: usize,
    motor_cmd: usize,
    drive: usize,
}

/// Runs a recording through the library, in which every encoder read the position sent in the cycle before.
pub(crate) fn replay(
    file: &[u8],
    recording: &Recording,
    joints: &str,
    instance: &str,
    period_ns: u32,
) -> Result<Agreement> {
    let tables = Tcomp::parse(file).map_err(|error| anyhow!("{error}"))?;
    match tables.settings().step_axes().count() {
        3 => of::<3>(&tables, recording, joints, instance, period_ns),
        4 => of::<4>(&tables, recording, joints, instance, period_ns),
        5 => of::<5>(&tables, recording, joints, instance, period_ns),
        _ => of::<6>(&tables, recording, joints, instance, period_ns),
    }
}

fn columns(tables: &Tcomp<'_>, recording: &Recording, joints: &str, instance: &str) -> Result<Vec<Joint>> {
    let axes: Vec<Axis> = tables.settings().step_axes().collect();
    joints
        .chars()
        .enumerate()
        .map(|(j, letter)| {
            let place = axes.iter().position(|axis| axis.letter() == letter);
            Ok(Joint {
                place: place.with_context(|| format!("the tables have no axis {letter}"))?,
                pos_cmd: recording.place(&format!("joint.{j}.pos-cmd"))?,
                motor_cmd: recording.place(&format!("joint.{j}.motor-pos-cmd"))?,
                drive: recording.place(&format!("{instance}.joint.{j}.motor-pos-cmd-out"))?,
            })
        })
        .collect()
}

fn of<const N: usize>(
    tables: &Tcomp<'_>,
    recording: &Recording,
    joints: &str,
    instance: &str,
    period_ns: u32,
) -> Result<Agreement> {
    let joints = columns(tables, recording, joints, instance)?;
    let active = recording.place(&format!("{instance}.active"))?;
    let mut memory = vec![0.0; tables.requirement()];
    let servo = HostServo::<N>::load(tables, period_ns, &mut memory).map_err(|error| anyhow!("{error}"))?;
    let mut state = servo.start();
    let window = CommandWindow::<f64, f64, { WINDOW.0 }>::new([0.0, 0.0, 1.0], WINDOW.1);
    let mut window = window.map_err(|error| anyhow!("{error}"))?;
    let mut agreement = Agreement::default();
    let (mut before, mut was_homed): (Option<&[f64]>, bool) = (None, false);
    for (sample, row) in recording.rows().enumerate() {
        let mut input = Input::<f64, N>::at_rest(period_ns);
        input.homed = row[active] != 0.0;
        input.enable = true;
        if input.homed && !was_homed {
            window.restart();
        }
        was_homed = input.homed;
        let answered = before.unwrap_or(row);
        for joint in &joints {
            input.command[joint.place] = row[joint.pos_cmd];
            let offset = answered[joint.motor_cmd] - answered[joint.pos_cmd];
            input.feedback[joint.place] = answered[joint.drive] - offset;
        }
        let output = servo.step(&mut state, &input, &mut window, ());
        if output.stop_requested() {
            bail!("the library stops with {:?} at sample {}", output.record.fault, output.record.sequence);
        }
        for (place, joint) in joints.iter().enumerate() {
            let dynamic = output.record.dynamic.map_or(0.0, |parts| parts.sent[joint.place]);
            let correction = output.record.correction[joint.place] + dynamic;
            agreement.largest_dynamic = agreement.largest_dynamic.max(dynamic.abs());
            let expected = if correction == 0.0 { row[joint.motor_cmd] } else { row[joint.motor_cmd] + correction };
            agreement.samples += 1;
            agreement.same_bits += usize::from(expected.to_bits() == row[joint.drive].to_bits());
            let difference = (expected - row[joint.drive]).abs();
            if difference > agreement.largest_difference {
                (agreement.largest_difference, agreement.at) = (difference, (sample, place));
            }
            agreement.largest_correction = agreement.largest_correction.max(correction.abs());
        }
        before = Some(row);
    }
    Ok(agreement)
}
