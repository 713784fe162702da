//! Checks and bounds of errors that repeat within a period of an axis.

use super::need;
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, Link, MachineSettings, PeriodicSettings, is_turned};

/// Largest difference of a turn from whole periods, as a share of a period: decimals are rounded.
const WHOLE: f64 = 1e-3;

/// Checks the axis and the form of every period.
///
/// # Errors
/// [`Field::PeriodLength`] or [`Field::PeriodHarmonics`], with the number of the period among those of its axis.
pub(super) fn settings(machine: &MachineSettings, links: &[Link]) -> Result<(), ConfigError> {
    for (index, entry) in machine.periodic.iter().enumerate() {
        let before = machine.periodic.iter().take(index).filter(|other| other.axis == entry.axis);
        let number = before.clone().count();
        let wrong = |field, found, needed| ConfigError::new(field, found, needed).on(entry.axis).at(number);
        let length = |needed| wrong(Field::PeriodLength, entry.period, needed);
        need(machine.axis(entry.axis).is_some(), length("an axis of the machine"))?;
        if entry.axis.is_rotary() {
            need(!machine.compensation.is_volumetric(), length("the model \"nine\" for a period of a rotary axis"))?;
            let periods = 360.0 / entry.period;
            need(
                libm::fabs(periods - libm::round(periods)) <= WHOLE,
                length("a whole number of periods in 360 degrees"),
            )?;
        } else {
            need(!is_turned(links, entry.axis), length("a linear axis that no rotary axis carries"))?;
        }
        for other in before {
            need(other.period != entry.period, length("another period than the axis has already"))?;
        }
        let count = wrong(Field::PeriodHarmonics, 0.0, "at least one harmonic");
        need(!entry.harmonics.is_empty(), count)?;
    }
    Ok(())
}

/// Largest difference between the directions of travel within the periods of an axis, mm (deg).
pub(super) fn most_lost(machine: &MachineSettings, axis: Axis) -> f64 {
    machine.periods_of(axis).map(PeriodicSettings::most_lost).sum()
}
