//! Where the artefacts of a task really stand, and how large they are.

use anyhow::{Result, bail};
use trueaxis::machine::Axis;
use trueaxis_evaluation::calibrate::{Ideal, Kind, Task};
use trueaxis_sim::calibration::Artefact;
use trueaxis_tables::Machine;

/// What stands on the machine in every set-up of a task: its own artefact, and the reference in all of them.
pub(super) fn stand(
    task: &Task,
    nominal: &Machine,
    misplaced_mm: f64,
    normal: &mut impl FnMut() -> f64,
) -> Result<Vec<Vec<Artefact>>> {
    let ideal = Ideal::new(nominal)?;
    let mut set_ups = Vec::new();
    let mut reference = None;
    let mut places = Vec::new();
    for (index, artefact) in task.artefacts.iter().enumerate() {
        let off = artefact.uncertainty.unwrap_or_default() * normal();
        for place in &artefact.places {
            let [x, y, z] = place.at_mm;
            let at: [f64; 3] = std::array::from_fn(|k| [x, y, z][k] + misplaced_mm * normal().clamp(-2.0, 2.0));
            let centre = ideal.tip(&[at[0], at[1], at[2], 0.0, 0.0, 0.0]).into();
            let standing = match artefact.kind {
                Kind::Ring { diameter_mm, .. } => {
                    // Half a milliradian askew.
                    let mut axis: [f64; 3] = std::array::from_fn(|_| 5e-4 * normal());
                    axis[match place.normal {
                        Axis::X => 0,
                        Axis::Y => 1,
                        _ => 2,
                    }] = 1.0;
                    Artefact::Ring { centre, axis: glam::DVec3::from(axis).normalize(), diameter: diameter_mm + off }
                }
                Kind::Ball { diameter_mm } => Artefact::Ball { centre, diameter: diameter_mm + off },
                _ => bail!("{}: found an artefact that is not simulated, needed rings and balls", artefact.name),
            };
            if task.reference.as_ref().is_some_and(|reference| reference.artefact == index) {
                reference = Some(standing);
            }
            places.push((index, standing));
        }
    }
    for (index, standing) in places {
        let is_reference = task.reference.as_ref().is_some_and(|reference| reference.artefact == index);
        set_ups.push(reference.filter(|_| !is_reference).into_iter().chain([standing]).collect());
    }
    Ok(set_ups)
}
