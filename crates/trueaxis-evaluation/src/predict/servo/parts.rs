//! Which part of what acts on the servo gives a characteristic its verdict.

use super::super::cut::Followed;
use super::figures::drives;
use super::runs::{Driven, Ran};
use anyhow::Result;
use trueaxis_sim::run::Kind;
use trueaxis_tables::Machine;

/// A controller with one part beside the geometric correction, and what the axes do at the points of the features.
pub(in crate::predict) struct Alone {
    pub(in crate::predict) name: &'static str,
    pub(in crate::predict) errors: Vec<Option<Followed>>,
}

/// Runs the features with every part by itself; nothing if the machine has only one, or if one of these runs stops.
///
/// # Errors
/// A machine or program that the simulator refuses.
pub(in crate::predict) fn alone(machine: &Machine, ran: &Ran<'_>) -> Result<Vec<Alone>> {
    let drives = drives(&machine.settings, ran.program.is_five_axis())?;
    let parts = [
        ("friction", of_part(machine, true, false, false)),
        ("lag and acceleration", of_part(machine, false, true, false)),
        ("contour feedback", of_part(machine, false, false, true)),
    ];
    let nothing = of_part(machine, false, false, false);
    let parts: Vec<(&'static str, Machine)> = parts.into_iter().filter(|(_, own)| *own != nothing).collect();
    if parts.len() < 2 {
        return Ok(Vec::new());
    }
    let driven = |(_, machine): &'_ (&'static str, Machine)| (machine.clone(), Kind::Configured, vec![drives]);
    let all: Vec<_> = parts.iter().map(driven).collect();
    let all: Vec<Driven<'_>> =
        all.iter().map(|(machine, kind, drives)| Driven { machine, kind: *kind, drives: drives.clone() }).collect();
    let outcome = ran.run(&all, &mut |_, _| {})?;
    if outcome.stopped.iter().any(Option::is_some) {
        return Ok(Vec::new());
    }
    Ok(parts.iter().zip(outcome.errors).map(|((name, _), errors)| Alone { name, errors }).collect())
}

/// The machine with what acts on the servo reduced to some of its parts.
fn of_part(machine: &Machine, friction: bool, ahead: bool, feedback: bool) -> Machine {
    let mut machine = machine.clone();
    for own in &mut machine.settings.axes {
        own.servo.friction = own.servo.friction.filter(|_| friction);
        if let Some(dynamic) = &mut own.servo.dynamic {
            (dynamic.lag, dynamic.acceleration) = (dynamic.lag && ahead, dynamic.acceleration && ahead);
            dynamic.take_up = false;
        }
    }
    let contour = &mut machine.settings.contour;
    contour.feedback = contour.feedback.filter(|_| feedback);
    machine.settings.crosstalk.clear();
    machine
}
