//! The simulated drive that matches a plugin's figures.

use super::drive::DriveSettings;
use super::variation::Variation;
use trueaxis::machine::MachineSettings;

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
    let stated = DriveSettings {
        position_gain_per_s: drive.position_gain_per_s / gain_factor,
        velocity_gain_per_s: drive.velocity_gain_per_s / gain_factor,
        velocity_feed_forward: drive.velocity_feed_forward,
        reset_time_s: drive.reset_time_s,
        current_loop_s: drive.current_loop_s,
        dead_time_s: drive.dead_time_s,
        ..default
    };
    let Some(friction) = own.servo.friction else { return stated };
    DriveSettings {
        coulomb_mm_per_s2: friction.coulomb_per_s * drive.velocity_gain_per_s / friction_factor,
        viscous_per_s: friction.viscous * drive.velocity_gain_per_s,
        stribeck_share: friction.stribeck_share,
        stribeck_velocity_mm_per_s: friction.stribeck_velocity_per_s,
        presliding_mm: friction.presliding,
        ..stated
    }
}
