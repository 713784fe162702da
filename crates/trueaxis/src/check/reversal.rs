//! Checks of the reversal hysteresis: it must be wider than the encoder's steps, and than the correction's steps
//! against the travel.

use super::bounds::{Step, sense, width};
use super::grid::GridBounds;
use super::inverse::jacobian_norm;
use super::periodic;
use super::volumetric;
use crate::error::{ConfigError, Field};
use crate::machine::{AXES, Axis, AxisSettings, MachineSettings, Rows, is_turned, links, lost};

/// Number of encoder steps that a hysteresis must span. Between two counts the reading may show either, and the drive,
/// which closes its loop on it, moves back and forth by that much.
pub const HYSTERESIS_PER_STEP: f64 = 3.0;

/// A step below this moves nothing: mm, degrees.
const NOTHING: f64 = 1e-9;

/// Lost motion of an axis, mm (deg): smallest and largest difference of its positioning error between negative and
/// positive travel, backlash included; without a table, the backlash alone.
pub fn lost_motion<T: Rows + ?Sized>(settings: &AxisSettings, rows: Option<&T>) -> [f64; 2] {
    let (least, most) = rows.map_or((0.0, 0.0), |rows| lost(settings, rows, settings.axis.index()));
    let own = |error: f64| if settings.axis.is_rotary() { error.to_degrees() } else { error };
    [own(least) + settings.backlash, own(most) + settings.backlash]
}

/// Checks that the hysteresis of every axis with lost motion spans the steps of its encoder, if they are stated, and
/// that no reversal can undo itself.
///
/// The direction is the drive's, and a reversal steps the corrections. Positive lost motion steps the axis' own
/// correction in the new direction of travel and confirms it. Negative lost motion steps it back. If the reversal of
/// one axis steps the correction of another, that one may reverse too and step the first one back. Either sequence
/// repeats for ever if every step in it is wider than the hysteresis of the axis that it moves. The steps are upper
/// bounds over all positions; thermal growth and grids do not depend on the direction.
///
/// # Errors
/// [`Field::Hysteresis`] with the hysteresis found and, as bound, its lower limit.
pub fn reversal<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
    grids: &GridBounds,
) -> Result<(), ConfigError> {
    let rows: &dyn Fn(Axis) -> Option<&'r T> = &rows;
    let mut steps = [[[0.0; 2]; AXES]; AXES];
    for (moving, steps) in machine.axes.iter().zip(&mut steps) {
        *steps = steps_of(machine, &rows, moving);
    }
    if steps.iter().flatten().all(|step| width(step) == 0.0) {
        return Ok(());
    }
    // The exact inverse looks up at the corrected position, which amplifies the steps.
    let gain = 1.0 / (1.0 - jacobian_norm(machine, rows, grids).min(0.999));
    for (moving, steps) in machine.axes.iter().zip(&mut steps) {
        for step in steps.iter_mut() {
            *step = step.map(|step| step * gain);
        }
        if let Some(resolution) = moving.encoder_resolution
            && steps.iter().any(|step| width(step) > 0.0)
        {
            let least = HYSTERESIS_PER_STEP * resolution;
            // Two decimals whose quotient is exactly the limit pass, whatever their rounding.
            if moving.hysteresis < least * (1.0 - 1e-9) {
                return Err(narrow(moving, "at least three steps of the encoder", least));
            }
        }
    }
    // Pairs in which a reversal of `from` may reverse `to` too, with the sign.
    let mut couplings = [[Coupling::default(); AXES]; AXES];
    let mut sums = [0.0; AXES];
    for ((to, axis), sum) in machine.axes.iter().enumerate().zip(&mut sums) {
        let into = |from: usize| steps.get(from).and_then(|steps| steps.get(to)).copied().unwrap_or_default();
        // All others may reverse in the same cycle.
        for from in 0..AXES {
            *sum += if from == to { into(from)[0].min(0.0).abs() } else { width(&into(from)) };
        }
        if *sum <= axis.hysteresis {
            continue;
        }
        for (from, couplings) in couplings.iter_mut().enumerate() {
            let [least, most] = into(from);
            if let Some(couplings) = couplings.get_mut(to) {
                *couplings = Coupling { same: most > NOTHING && from != to, opposite: least < -NOTHING };
            }
        }
    }
    for by in 0..AXES {
        for from in 0..AXES {
            for to in 0..AXES {
                let coupling = |from: usize, to: usize| couplings.get(from).and_then(|to_| to_.get(to)).copied();
                let (Some(first), Some(second)) = (coupling(from, by), coupling(by, to)) else { continue };
                if let Some(couplings) = couplings.get_mut(from).and_then(|couplings| couplings.get_mut(to)) {
                    couplings.add(first.then(second));
                }
            }
        }
    }
    for ((index, axis), sum) in machine.axes.iter().enumerate().zip(sums) {
        if couplings.get(index).and_then(|couplings| couplings.get(index)).is_some_and(|couplings| couplings.opposite) {
            return Err(narrow(axis, "more than its correction steps against the travel at a reversal", sum));
        }
    }
    Ok(())
}

fn narrow(axis: &AxisSettings, needed: &'static str, bound: f64) -> ConfigError {
    ConfigError { bound: Some(bound), ..ConfigError::new(Field::Hysteresis, axis.hysteresis, needed).on(axis.axis) }
}

/// Directions in which a reversal can cause another one.
#[derive(Clone, Copy, Default)]
struct Coupling {
    same: bool,
    opposite: bool,
}

impl Coupling {
    fn then(self, next: Coupling) -> Coupling {
        Coupling {
            same: (self.same && next.same) || (self.opposite && next.opposite),
            opposite: (self.same && next.opposite) || (self.opposite && next.same),
        }
    }

    fn add(&mut self, other: Coupling) {
        *self = Coupling { same: self.same || other.same, opposite: self.opposite || other.opposite };
    }
}

/// Steps of all drives that the reversal of one axis causes, in the order of the machine's axes.
fn steps_of<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    moving: &AxisSettings,
) -> [Step; AXES] {
    let mut steps = [[0.0; 2]; AXES];
    let table = rows(moving.axis);
    let twist: [Step; 6] = core::array::from_fn(|component| {
        let (least, most) = table.map_or((0.0, 0.0), |table| lost(moving, table, component));
        let own = component == moving.axis.index();
        let lost = match (own, moving.axis.is_rotary()) {
            (false, _) => 0.0,
            (true, false) => moving.backlash,
            (true, true) => moving.backlash.to_radians(),
        };
        let within = if own { periodic::most_lost(machine, moving.axis) } else { 0.0 };
        let within = if moving.axis.is_rotary() { within.to_radians() } else { within };
        [least + lost - within, most + lost + within]
    });
    if twist.iter().all(|step| width(step) == 0.0) {
        return steps;
    }
    if machine.compensation.is_volumetric() {
        return volumetric::reversal_steps(machine, rows, moving, &twist);
    }
    for (drive, step) in machine.axes.iter().zip(&mut steps) {
        *step = nine_step(machine, moving, &twist, drive);
    }
    steps
}

/// The step of a drive under the nine terms.
fn nine_step(machine: &MachineSettings, moving: &AxisSettings, twist: &[Step; 6], drive: &AxisSettings) -> Step {
    let component = |index: usize| twist.get(index).copied().unwrap_or_default();
    if drive.axis.is_rotary() {
        if drive.axis != moving.axis {
            return [0.0; 2];
        }
        // The backlash counts in the sense of the reading.
        let backlash = moving.backlash;
        let [least, most] = component(drive.axis.index()).map(|error| error.to_degrees() - backlash);
        let sense = sense(machine, drive);
        return if sense < 0.0 { [backlash - most, backlash - least] } else { [least + backlash, most + backlash] };
    }
    let links = links(&machine.chain).unwrap_or_default();
    if is_turned(&links, moving.axis) {
        let [x, y, z, ..] = twist.map(|step| width(&step));
        let length = libm::sqrt(x * x + y * y + z * z);
        return [-length, length];
    }
    component(drive.axis.index())
}
