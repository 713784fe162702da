//! Tuned drives under a name.

use super::settings::{DriveSettings, ScaleAt};
use trueaxis_tables::text::one_of;

/// A drive with two masses whose loops are tuned to its mechanics: stable and damped without the plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// A short, stiff axis with a scale: a light table on a linear motor.
    Stiff,
    /// A machining centre's axis: ball screw, scale on the table.
    Usual,
    /// A long or belt-driven axis read on the motor, without velocity feed-forward, as on hobby machines.
    Soft,
    /// An old axis read on the motor: play, more friction, torque ripple, little damping.
    Worn,
}

impl Variant {
    /// All variants, the stiffest first.
    pub const ALL: [Variant; 4] = [Variant::Stiff, Variant::Usual, Variant::Soft, Variant::Worn];

    /// Name in settings and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Variant::Stiff => "stiff",
            Variant::Usual => "usual",
            Variant::Soft => "soft",
            Variant::Worn => "worn",
        }
    }

    /// The variant of a name.
    ///
    /// # Errors
    /// For an unknown name, the known ones.
    pub fn named(name: &str) -> Result<Variant, String> {
        let known = Variant::ALL.into_iter().find(|variant| variant.name() == name);
        known.ok_or_else(|| one_of(name, Variant::ALL.map(Variant::name), ", "))
    }

    /// The figures.
    pub fn settings(self) -> DriveSettings {
        let common = DriveSettings::default();
        match self {
            Variant::Stiff => DriveSettings {
                resonance_hz: 250.0,
                resonance_damping: 0.03,
                load_share: 0.3,
                scale_at: ScaleAt::Load,
                ..common
            },
            Variant::Usual => DriveSettings {
                position_gain_per_s: 60.0,
                velocity_feed_forward: 0.9,
                velocity_gain_per_s: 350.0,
                reset_time_s: 0.012,
                resonance_hz: 120.0,
                resonance_damping: 0.03,
                load_share: 0.4,
                scale_at: ScaleAt::Load,
                ..common
            },
            Variant::Soft => DriveSettings {
                position_gain_per_s: 25.0,
                velocity_feed_forward: 0.0,
                velocity_gain_per_s: 150.0,
                reset_time_s: 0.03,
                current_loop_s: 5e-4,
                resonance_hz: 45.0,
                resonance_damping: 0.04,
                load_share: 0.5,
                scale_at: ScaleAt::Motor,
                ..common
            },
            Variant::Worn => DriveSettings {
                position_gain_per_s: 35.0,
                velocity_feed_forward: 0.9,
                velocity_gain_per_s: 250.0,
                reset_time_s: 0.018,
                coulomb_mm_per_s2: 650.0,
                stribeck_share: 0.5,
                resonance_hz: 80.0,
                resonance_damping: 0.02,
                load_share: 0.4,
                scale_at: ScaleAt::Motor,
                gear_play_mm: 0.006,
                torque_ripple_mm_per_s2: 60.0,
                ripple_period_mm: 10.0,
                ..common
            },
        }
    }
}
