//! Figures of the drives that are not exactly known: what the plant has in place of those that the controller is told.

use super::super::cut::Cut;
use super::super::kinds::FeatureKind;
use anyhow::{Result, bail};
use trueaxis::machine::{AXES, Axis, AxisServo, MachineSettings};
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_sim::plant::drive::DriveSettings;
use trueaxis_sim::plant::stated;
use trueaxis_tables::uncertainty::{Figure, Uncertainties};

/// Travel within a feature above which an axis moves in it, mm or degrees.
const MOVES: f64 = 1e-3;
/// Largest standard uncertainty of a gain or of a reset time as a share of it: the loops stay loops.
const MOST: f64 = 0.3;
/// Least gain or reset time of a drawn plant, as a share of the stated one.
const LEAST: f64 = 0.2;

/// A figure of an axis and its standard uncertainty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Uncertain {
    axis: Axis,
    figure: Figure,
    u: f64,
    pub(super) degrees_of_freedom: f64,
}

/// The figures of the axes that move in the features, and keys of those that are not stated.
///
/// # Errors
/// A gain or reset time that is hardly known at all.
pub(super) fn uncertain(
    machine: &MachineSettings,
    known: &Uncertainties,
    cuts: &[Cut],
) -> Result<(Vec<Uncertain>, Vec<String>)> {
    let (mut found, mut not_stated) = (Vec::new(), Vec::new());
    for own in machine.axes.iter().filter(|own| moves(cuts, own.axis)) {
        let (axis, letter) = (own.axis, own.axis.letter());
        let of = known.of(axis);
        for (index, figure) in Figure::ALL.into_iter().enumerate() {
            let mut servo = own.servo;
            let Some(value) = value(&mut servo, figure).map(|value| *value) else { continue };
            let section = figure.section();
            let key = format!("axis.{letter}.{section}.uncertainty.{}", figure.key(axis));
            let Some(u) = of.and_then(|of| of.servo[index]) else {
                // Dead time and friction that a drive does not have need no uncertainty.
                not_stated.extend((value != 0.0).then_some(key));
                continue;
            };
            if is_positive(figure) && u > MOST * value {
                bail!(
                    "{}: key {key}: found {u}, needed at most {} % of {value}, the figure: --servo simulates it one standard \
                     uncertainty off",
                    machine.name,
                    100.0 * MOST
                );
            }
            let degrees = of.map_or([None; 2], |of| of.servo_degrees_of_freedom);
            let degrees_of_freedom = degrees[usize::from(section == "friction")].unwrap_or(f64::INFINITY);
            if u > 0.0 {
                found.push(Uncertain { axis, figure, u, degrees_of_freedom });
            }
        }
    }
    Ok((found, not_stated))
}

/// Whether an axis moves in a feature. Along a hole no characteristic depends on where the tool is.
fn moves(cuts: &[Cut], axis: Axis) -> bool {
    let travel = |cut: &Cut, axis: Axis| {
        let at = || cut.points.iter().map(|point| point.command[axis.index()]);
        at().fold(f64::MIN, f64::max) - at().fold(f64::MAX, f64::min)
    };
    let counts = |cut: &Cut| {
        let alone = Axis::ALL.into_iter().filter(|own| travel(cut, *own) > MOVES).count() == 1;
        travel(cut, axis) > MOVES && !(cut.kind == FeatureKind::Hole && alone)
    };
    cuts.iter().any(counts)
}

fn value(servo: &mut AxisServo, figure: Figure) -> Option<&mut f64> {
    let AxisServo { drive, friction, .. } = servo;
    match figure {
        Figure::PositionGain => drive.as_mut().map(|of| &mut of.position_gain_per_s),
        Figure::VelocityGain => drive.as_mut().map(|of| &mut of.velocity_gain_per_s),
        Figure::ResetTime => drive.as_mut().map(|of| &mut of.reset_time_s),
        Figure::VelocityFeedForward => drive.as_mut().map(|of| &mut of.velocity_feed_forward),
        Figure::DeadTime => drive.as_mut().map(|of| &mut of.dead_time_s),
        Figure::Coulomb => friction.as_mut().map(|of| &mut of.coulomb_per_s),
        Figure::Presliding => friction.as_mut().map(|of| &mut of.presliding),
        Figure::StribeckShare => friction.as_mut().map(|of| &mut of.stribeck_share),
        Figure::StribeckVelocity => friction.as_mut().map(|of| &mut of.stribeck_velocity_per_s),
        Figure::Viscous => friction.as_mut().map(|of| &mut of.viscous),
    }
}

/// Whether a drive with zero in its place is none.
fn is_positive(figure: Figure) -> bool {
    matches!(figure, Figure::PositionGain | Figure::VelocityGain | Figure::ResetTime)
}

impl Uncertain {
    pub(super) fn name(&self) -> String {
        format!("{} of {}", self.figure.name(), self.axis.letter())
    }

    /// Puts the figure so many standard uncertainties beside the stated one, as far as a drive can have it. What it is then
    /// off, in standard uncertainties.
    fn shift(&self, machine: &mut MachineSettings, z: f64) -> f64 {
        let own = machine.axes.iter_mut().find(|own| own.axis == self.axis);
        let Some(to) = own.and_then(|own| value(&mut own.servo, self.figure)) else { return 0.0 };
        let stated = *to;
        let [least, most] = match self.figure {
            Figure::VelocityFeedForward => [0.0, 1.0],
            figure if is_positive(figure) || matches!(figure, Figure::Presliding | Figure::StribeckVelocity) => {
                [LEAST * stated, f64::INFINITY]
            }
            _ => [0.0, f64::INFINITY],
        };
        *to = (stated + z * self.u).clamp(least, most);
        (*to - stated) / self.u
    }
}

/// Drives as the machine states them.
///
/// # Errors
/// A moving axis without figures of its drive.
pub(super) fn drives(machine: &MachineSettings, is_five_axis: bool) -> Result<[DriveSettings; AXES]> {
    for own in machine.axes.iter().filter(|own| is_five_axis || !own.axis.is_rotary()) {
        if own.servo.drive.is_none() {
            let letter = own.axis.letter();
            bail!(
                "{}: key axis.{letter}.drive: found nothing, needed position_gain_per_s, velocity_gain_per_s and \
                 reset_time_s of the drive, which --servo simulates",
                machine.name
            );
        }
    }
    Ok(of_all(machine))
}

fn of_all(machine: &MachineSettings) -> [DriveSettings; AXES] {
    Axis::ALL.map(|axis| {
        let own = stated(machine, axis);
        let has_friction = machine.axis(axis).is_some_and(|own| own.servo.friction.is_some());
        if has_friction {
            return own;
        }
        DriveSettings { coulomb_mm_per_s2: 0.0, stribeck_share: 0.0, viscous_per_s: 0.0, ..own }
    })
}

/// A plant, and how far each figure is off, in standard uncertainties.
pub(super) struct Plant {
    pub(super) drives: [DriveSettings; AXES],
    pub(super) off: Vec<f64>,
}

impl Plant {
    fn of(machine: &MachineSettings, figures: &[Uncertain], z: &[f64]) -> Plant {
        let mut machine = machine.clone();
        let off = figures.iter().zip(z).map(|(of, z)| of.shift(&mut machine, *z)).collect();
        Plant { drives: of_all(&machine), off }
    }

    /// One figure alone, on the side where a drive can have more of it.
    pub(super) fn alone(machine: &MachineSettings, figures: &[Uncertain], index: usize, side: f64) -> Plant {
        let z = |side: f64| (0..figures.len()).map(|k| if k == index { side } else { 0.0 }).collect::<Vec<_>>();
        let here = Plant::of(machine, figures, &z(side));
        let there = Plant::of(machine, figures, &z(-side));
        if here.off[index].abs() + 1e-9 >= there.off[index].abs() { here } else { there }
    }

    /// All figures drawn at once.
    pub(super) fn drawn(machine: &MachineSettings, figures: &[Uncertain], seed: u64, number: u64) -> Plant {
        let mut draws = Draws::new(seed, number);
        let z: Vec<f64> = figures.iter().map(|of| draws.student(of.degrees_of_freedom)).collect();
        Plant { off: z.clone(), ..Plant::of(machine, figures, &z) }
    }
}
