//! `[axis.*.drive]`, `[axis.*.friction]`, `[axis.*.dynamic]` and `[contour.feedback]` of `machine.toml`.

use super::common_lag::DriveUncertainty;
use super::section::Section;
use super::uncertainty_toml::{of_resonance, uncertainties_of};
use super::units::{degrees_from_urad, from_um, per_second, same};
use crate::error::FileError;
use trueaxis::machine::{Axis, AxisServo, DriveFigures, DynamicSettings, FeedbackSettings, FrictionSettings};
use trueaxis::range::{RESONANCE, RESONANCE_DAMPING};

/// Units of an axis in the names of its keys: positions, errors, and the conversion of errors to the unit of the core.
struct Units {
    unit: &'static str,
    micro: &'static str,
    small: fn(f64) -> f64,
}

impl Units {
    fn of(axis: Axis) -> Units {
        match axis.is_rotary() {
            true => Units { unit: "deg", micro: "urad", small: degrees_from_urad },
            false => Units { unit: "mm", micro: "um", small: from_um },
        }
    }
}

/// A number without a default.
fn required(section: &Section<'_>, key: &str, needed: &str) -> Result<f64, FileError> {
    Ok(section.number(key)?.ok_or_else(|| section.missing(key, needed))?.value)
}

/// Reads those sections of an axis that it has, and how well the drive's figures are known.
pub(super) fn read_axis(section: &Section<'_>, axis: Axis) -> Result<(AxisServo, DriveUncertainty), FileError> {
    let units = Units::of(axis);
    let (drive, uncertain) = section.section("drive")?.map(read_drive).transpose()?.unzip();
    let friction = section.section("friction")?.map(|friction| read_friction(friction, &units)).transpose()?;
    let dynamic = section.section("dynamic")?.map(|dynamic| read_dynamic(dynamic, axis, &units)).transpose()?;
    Ok((AxisServo { drive, friction, dynamic }, uncertain.unwrap_or_default()))
}

fn read_drive(section: Section<'_>) -> Result<(DriveFigures, DriveUncertainty), FileError> {
    let mut drive = DriveFigures::with_defaults(
        required(&section, "position_gain_per_s", "the gain K_v of the position loop, 1/s")?,
        required(&section, "velocity_gain_per_s", "the gain K_vp of the velocity loop, 1/s")?,
        required(&section, "reset_time_s", "the reset time of the velocity loop, s")?,
    );
    section.store(&mut drive.velocity_feed_forward, "velocity_feed_forward", same)?;
    section.store(&mut drive.current_loop_s, "current_loop_s", same)?;
    section.store(&mut drive.dead_time_s, "dead_time_s", same)?;
    let [position_gain_per_s, velocity_feed_forward, ..] = uncertainties_of(
        &section,
        [
            "position_gain_per_s",
            "velocity_feed_forward",
            "velocity_gain_per_s",
            "reset_time_s",
            "dead_time_s",
            "resonance_hz",
            "resonance_damping",
        ],
    )?;
    read_resonance(&section, &mut drive)?;
    section.finish(None)?;
    Ok((drive, DriveUncertainty { position_gain_per_s, velocity_feed_forward }))
}

/// Reads the statements about the resonance; in the core, 0 means not stated.
fn read_resonance(section: &Section<'_>, drive: &mut DriveFigures) -> Result<(), FileError> {
    let resonance = section.number("resonance_hz")?;
    let damping = section.number("resonance_damping")?;
    let lowest = section.number("lowest_resonance_hz")?;
    if resonance.is_some() && damping.is_none() {
        let needed = "the damping of the resonance, a share of critical: without it resonance_hz bounds no gain";
        return Err(section.missing_here("resonance_damping", needed));
    }
    for (figure, found, range) in [
        (&mut drive.resonance_hz, &resonance, RESONANCE),
        (&mut drive.resonance_damping, &damping, RESONANCE_DAMPING),
        (&mut drive.lowest_resonance_hz, &lowest, RESONANCE),
    ] {
        let Some(found) = found else { continue };
        if found.value == 0.0 {
            return Err(section.wrong(found, range.needed));
        }
        *figure = found.value;
    }
    for (uncertainty, (key, of)) in
        of_resonance(section)?.into_iter().zip([("resonance_hz", resonance), ("resonance_damping", damping)])
    {
        let Some(uncertainty) = uncertainty else { continue };
        // The expanded uncertainty, k = 2, must leave a figure above zero.
        if of.is_none_or(|of| 2.0 * uncertainty.value >= of.value) {
            let needed = format!("less than half of {key}, as the drive states it");
            return Err(section.wrong(&uncertainty, needed));
        }
    }
    Ok(())
}

fn read_friction(section: Section<'_>, units: &Units) -> Result<FrictionSettings, FileError> {
    let Units { unit, micro, small } = units;
    let coulomb = required(&section, &format!("coulomb_{unit}_per_s"), "Coulomb friction over K_vp")?;
    let presliding =
        required(&section, &format!("presliding_{micro}"), "the travel over which friction reverses by 63 %")?;
    let mut friction = FrictionSettings::with_defaults(coulomb, small(presliding));
    section.store(&mut friction.stribeck_share, "stribeck_share", same)?;
    section.store(&mut friction.stribeck_velocity_per_s, &format!("stribeck_velocity_{unit}_per_s"), same)?;
    section.store(&mut friction.viscous, "viscous", same)?;
    section.store(&mut friction.lead_s, "lead_s", same)?;
    section.store(&mut friction.adapt, "adapt", same)?;
    let [coulomb, presliding, velocity] =
        [format!("coulomb_{unit}_per_s"), format!("presliding_{micro}"), format!("stribeck_velocity_{unit}_per_s")];
    uncertainties_of(&section, [&coulomb, &presliding, "stribeck_share", &velocity, "viscous"])?;
    section.finish(None)?;
    Ok(friction)
}

fn read_dynamic(section: Section<'_>, axis: Axis, units: &Units) -> Result<DynamicSettings, FileError> {
    let Units { unit, micro, small } = units;
    let mut dynamic = DynamicSettings::with_defaults(axis);
    let limits = &mut dynamic.limits;
    section.store(&mut limits.magnitude, &format!("magnitude_{micro}"), small)?;
    section.store(&mut limits.slope_per_s, &format!("slope_{unit}_per_s"), same)?;
    section.store(&mut limits.acceleration_per_s2, &format!("acceleration_{unit}_per_s2"), same)?;
    for (to, key) in
        [(&mut dynamic.lag, "lag"), (&mut dynamic.acceleration, "acceleration"), (&mut dynamic.take_up, "take_up")]
    {
        *to = section.boolean(key)?.unwrap_or(*to);
    }
    section.store(&mut dynamic.lag_s, "lag_s", same)?;
    section.finish(None)?;
    Ok(dynamic)
}

/// Reads `[contour.feedback]`; `None` if the file has none.
pub(super) fn read_feedback(contour: &Section<'_>) -> Result<Option<FeedbackSettings>, FileError> {
    let Some(section) = contour.section("feedback")? else { return Ok(None) };
    let mut feedback = FeedbackSettings::default();
    section.store(&mut feedback.proportional, "proportional", same)?;
    section.store(&mut feedback.integral_per_s, "integral_per_s", same)?;
    section.store(&mut feedback.max_feed_per_s, "max_feed_mm_per_min", per_second)?;
    section.store(&mut feedback.watch_mm, "watch_um", from_um)?;
    section.finish(None)?;
    Ok(Some(feedback))
}
