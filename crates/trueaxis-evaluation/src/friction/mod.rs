//! Friction of two axes and their drives' figures from recorded circles.
//!
//! ```text
//! CSV ─► Recording ─► fit ─► FrictionDocument, sections of a machine.toml, additions to a machine, curves
//! ```
//!
//! The mathematics is in [`trueaxis_metrology::friction`]; this module reads records with their lines and writes the report
//! and the settings.

mod curves;
mod document;
mod recording;
mod settings;
mod shown;

pub use curves::{Trace, circles, circles_again, spikes, spikes_again};
pub use document::{
    AxisFound, Deviation, Drive, Errors, Friction, FrictionDocument, Glitch, ResonanceErrors, ResonanceFound,
};
pub use recording::{Recording, columns};
pub use settings::{additions, sections};
pub use shown::{against, deviations};

use anyhow::{Result, anyhow};
use trueaxis::Axis;
use trueaxis::machine::DriveFigures;
use trueaxis_metrology::friction::{FrictionRefusal, Identified, Progress, identify};
use trueaxis_tables::Machine;

/// Two different linear axes from `X,Y`.
///
/// # Errors
/// Any other text; the error states the text found and the text needed.
///
/// ```
/// use trueaxis::Axis;
/// assert_eq!(trueaxis_evaluation::friction::pair("Z, x"), Ok([Axis::Z, Axis::X]));
/// assert!(trueaxis_evaluation::friction::pair("X,X").is_err());
/// ```
pub fn pair(text: &str) -> Result<[Axis; 2], String> {
    let needed = || format!("found {text:?}, needed two of X, Y and Z with a comma between");
    let axis = |part: &str| match part.trim() {
        "X" | "x" => Ok(Axis::X),
        "Y" | "y" => Ok(Axis::Y),
        "Z" | "z" => Ok(Axis::Z),
        _ => Err(needed()),
    };
    let (first, second) = text.split_once(',').ok_or_else(needed)?;
    let axes = [axis(first)?, axis(second)?];
    if axes[0] == axes[1] { Err(needed()) } else { Ok(axes) }
}

/// Delay of the encoder reading after the command of its row, s, from µs; −100,000 to 20,000 µs.
///
/// # Errors
/// A delay outside that range.
pub fn read_after_s(us: f64) -> Result<f64, String> {
    let is_possible = (-100_000.0..=20_000.0).contains(&us);
    is_possible.then_some(1e-6 * us).ok_or_else(|| format!("found {us} µs, needed -100000 to 20000 µs"))
}

/// The drives' figures that a machine states for the recorded axes; `name` names the machine in the error.
///
/// # Errors
/// An axis that the machine does not have.
pub fn drives(machine: &Machine, name: &str, axes: [Axis; 2]) -> Result<[Option<DriveFigures>; 2]> {
    let mut given = [None; 2];
    for (figures, axis) in given.iter_mut().zip(axes) {
        let Some(own) = machine.settings.axis(axis) else {
            return Err(anyhow!("{name}: found no axis {}, needed the axes that were recorded", axis.letter()));
        };
        *figures = own.servo.drive;
    }
    Ok(given)
}

/// Friction, drives and the document of a record; `given` are the drives' figures if known, `progress` receives the axis and
/// the number of steps of its fits so far.
///
/// # Errors
/// A record that determines nothing ([`trueaxis_metrology::friction::FrictionRefusal`]), with the name of its file.
///
/// Cost: [`identify`], some seconds for a minute of 10 kHz.
pub fn fit(
    recording: &Recording,
    given: [Option<DriveFigures>; 2],
    progress: &mut Progress<'_>,
) -> Result<([Identified; 2], FrictionDocument)> {
    let found = identify(&recording.record, given, progress).map_err(|refused| named(recording, &refused))?;
    let document = FrictionDocument::new(&recording.record, &found);
    Ok((found, document))
}

/// Recorded minus modelled following error of both axes, mm, and the time between two values, s; the first is that of the record's
/// first row.
///
/// # Errors
/// As [`fit`].
///
/// Cost: three simulations of the record for each axis.
pub fn residuals(recording: &Recording, found: &[Identified; 2]) -> Result<(f64, [Vec<f64>; 2])> {
    let mut sample_s = 0.0;
    let mut of_axis = |index: usize| -> Result<Vec<f64>> {
        let found = found[index].deviation(&recording.record, index).map_err(|refused| named(recording, &refused))?;
        sample_s = found.sample_s;
        Ok(found.before.iter().zip(&found.predicted).map(|(before, predicted)| before - predicted).collect())
    };
    let residuals = [of_axis(0)?, of_axis(1)?];
    Ok((sample_s, residuals))
}

/// Searches the record for the resonances of the axes whose friction was found in it, and renews the document.
///
/// # Errors
/// As [`fit`].
///
/// Cost: for each axis several times that of [`fit`].
pub fn resonances(
    recording: &Recording,
    found: &mut [Identified; 2],
    progress: &mut Progress<'_>,
) -> Result<FrictionDocument> {
    for (index, own) in found.iter_mut().enumerate() {
        let axis = own.axis;
        let mut steps = 0;
        let mut on_step = || {
            steps += 1;
            progress(axis, steps);
        };
        let searched = own.find_resonance(&recording.record, index, &mut on_step);
        searched.map_err(|refused| named(recording, &refused))?;
    }
    Ok(FrictionDocument::new(&recording.record, found))
}

fn named(recording: &Recording, refused: &FrictionRefusal) -> anyhow::Error {
    anyhow!("{}: {refused}", recording.file.display())
}
