//! The simulated drive that matches a plugin's figures.

use super::drive::DriveSettings;
use super::variation::Variation;
use trueaxis::machine::{Axis, DriveFigures, FrictionSettings, MachineSettings};

/// Returns the drive settings of all axes that match the figures that the machine states for its first axis with a drive.
///
/// The plugin states forces over moved mass and K_vp, as velocities; the plant per moved mass:
///
/// ```text
/// F = (F/K_vp) · K_vp        d = (d/K_vp) · K_vp
/// ```
///
/// The differences of that axis from the others ([`Variation::of`]) are divided out. Units: mm, s (degrees for a rotary axis).
/// Friction that is not stated keeps its default; for a machine that states no drive, everything does.
pub fn agreed(machine: &MachineSettings) -> DriveSettings {
    let default = DriveSettings::default();
    let Some((own, drive)) = machine.axes.iter().find_map(|own| Some((own, own.servo.drive?))) else { return default };
    let Variation { gain_factor, friction_factor, .. } = Variation::of(own.axis);
    let stated = with_figures(default, drive, own.servo.friction);
    DriveSettings {
        position_gain_per_s: stated.position_gain_per_s / gain_factor,
        velocity_gain_per_s: stated.velocity_gain_per_s / gain_factor,
        coulomb_mm_per_s2: match own.servo.friction {
            Some(_) => stated.coulomb_mm_per_s2 / friction_factor,
            None => default.coulomb_mm_per_s2,
        },
        ..stated
    }
}

/// Returns the drive of an axis exactly as the machine states it, in the plant's units as [`agreed`]; what is not stated has
/// the defaults of the axis.
pub fn stated(machine: &MachineSettings, axis: Axis) -> DriveSettings {
    let servo = machine.axis(axis).map(|own| &own.servo);
    match servo.and_then(|servo| Some((servo.drive?, servo.friction))) {
        Some((drive, friction)) => with_figures(DriveSettings::of(axis), drive, friction),
        None => DriveSettings::of(axis),
    }
}

/// A drive with the figures of a plugin.
fn with_figures(own: DriveSettings, drive: DriveFigures, friction: Option<FrictionSettings>) -> DriveSettings {
    let own = DriveSettings {
        position_gain_per_s: drive.position_gain_per_s,
        velocity_gain_per_s: drive.velocity_gain_per_s,
        velocity_feed_forward: drive.velocity_feed_forward,
        reset_time_s: drive.reset_time_s,
        current_loop_s: drive.current_loop_s,
        dead_time_s: drive.dead_time_s,
        ..own
    };
    let Some(friction) = friction else { return own };
    DriveSettings {
        coulomb_mm_per_s2: friction.coulomb_per_s * drive.velocity_gain_per_s,
        viscous_per_s: friction.viscous * drive.velocity_gain_per_s,
        stribeck_share: friction.stribeck_share,
        stribeck_velocity_mm_per_s: friction.stribeck_velocity_per_s,
        presliding_mm: friction.presliding,
        ..own
    }
}
