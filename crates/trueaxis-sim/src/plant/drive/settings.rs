//! Figures of a drive and its axis, their ranges, and which of them agree with each other.

use crate::range::{Range, number};
use serde::{Deserialize, Serialize};

/// Lowest resonance of a drive with two masses, Hz.
const LOWEST_RESONANCE_HZ: f64 = 1.0;
/// Highest resonance, Hz.
const HIGHEST_RESONANCE_HZ: f64 = 2000.0;
/// Least damping of a resonance, share of critical. With less, the contacts of a play would gain energy from their integration.
const LEAST_DAMPING: f64 = 0.002;

/// A drive and its axis. For a rotary axis, read degree for mm. Forces are per moved mass (motor and load together).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DriveSettings {
    /// Gain of the position loop Kv, 1/s.
    pub position_gain_per_s: f64,
    /// Share of the commanded velocity that is fed forward, 0 to 1: at constant velocity v the axis lags by
    /// (1 − share) · v / Kv.
    pub velocity_feed_forward: f64,
    /// Proportional gain of the velocity loop, 1/s (acceleration per velocity error).
    pub velocity_gain_per_s: f64,
    /// Reset time of the velocity loop, s.
    pub reset_time_s: f64,
    /// Time constant of the current loop, s.
    pub current_loop_s: f64,
    /// Largest acceleration that the motor can provide, mm/s².
    pub force_limit_mm_per_s2: f64,
    /// Coulomb friction, mm/s².
    pub coulomb_mm_per_s2: f64,
    /// Static friction above Coulomb friction, as a share of it.
    pub stribeck_share: f64,
    /// Velocity at which half of that share remains, mm/s.
    pub stribeck_velocity_mm_per_s: f64,
    /// Pre-sliding: travel over which friction reverses by 63 %, mm.
    pub presliding_mm: f64,
    /// Viscous friction, 1/s.
    pub viscous_per_s: f64,
    /// Dead time between a command and the position loop, s.
    pub dead_time_s: f64,
    /// Resonance of motor and load against each other, both free, Hz; 0: one rigid mass.
    pub resonance_hz: f64,
    /// Damping of the resonance, share of critical.
    pub resonance_damping: f64,
    /// Mass of the load over that of motor and load.
    pub load_share: f64,
    /// Side whose position is read and closes the position loop.
    pub scale_at: ScaleAt,
    /// Play between motor and load, mm: in negative travel the load stays behind by this amount.
    pub gear_play_mm: f64,
    /// Amplitude of the motor's torque ripple, mm/s².
    pub torque_ripple_mm_per_s2: f64,
    /// Travel over which the torque ripple repeats, mm.
    pub ripple_period_mm: f64,
}

/// Side of a drive's position encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ScaleAt {
    /// An encoder on the motor.
    #[default]
    Motor,
    /// A scale on the load.
    Load,
}

impl ScaleAt {
    /// Names in settings.
    pub(crate) const NAMES: [&'static str; 2] = ["motor", "load"];
}

impl Default for DriveSettings {
    /// A tuned machine tool axis: lag 10 to 12 µm per 1000 mm/min; quadrant glitches of 1 to 3 µm on a circle of 50 mm
    /// radius at 1500 mm/min. One rigid mass without ripple.
    fn default() -> DriveSettings {
        DriveSettings {
            position_gain_per_s: 110.0,
            velocity_feed_forward: 0.93,
            velocity_gain_per_s: 800.0,
            reset_time_s: 0.006,
            current_loop_s: 2.5e-4,
            force_limit_mm_per_s2: 10_000.0,
            coulomb_mm_per_s2: 420.0,
            stribeck_share: 0.3,
            stribeck_velocity_mm_per_s: 2.0,
            presliding_mm: 0.006,
            viscous_per_s: 4.0,
            dead_time_s: 0.0,
            resonance_hz: 0.0,
            resonance_damping: 0.03,
            load_share: 0.5,
            scale_at: ScaleAt::Motor,
            gear_play_mm: 0.0,
            torque_ripple_mm_per_s2: 0.0,
            ripple_period_mm: 10.0,
        }
    }
}

/// Figures that do not agree with each other: key, value found, and value needed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Disagreement {
    /// Key of the figure, without its table.
    pub key: &'static str,
    /// Value as found.
    pub found: String,
    /// Accepted values.
    pub needed: String,
}

impl DriveSettings {
    /// Antiresonance, Hz: the load's natural frequency with the motor locked. 0 for one rigid mass.
    ///
    /// ```text
    /// f_a = f_r √(1 − load_share)
    /// ```
    pub fn antiresonance_hz(&self) -> f64 {
        self.resonance_hz * (1.0 - self.load_share).sqrt()
    }

    /// Name, value and range of every number.
    pub(crate) fn ranges(&self) -> [Range<'static>; 18] {
        let range = |key, found, low, high, unit| Range { key, found, low, high, unit };
        [
            range("position_gain_per_s", self.position_gain_per_s, 1.0, 1000.0, "1/s"),
            range("velocity_feed_forward", self.velocity_feed_forward, 0.0, 1.0, ""),
            range("velocity_gain_per_s", self.velocity_gain_per_s, 10.0, 4000.0, "1/s"),
            range("reset_time_s", self.reset_time_s, 1e-3, 10.0, "s"),
            range("current_loop_s", self.current_loop_s, 1e-6, 0.1, "s"),
            range("force_limit_mm_per_s2", self.force_limit_mm_per_s2, 1.0, 1e6, "mm/s²"),
            range("coulomb_mm_per_s2", self.coulomb_mm_per_s2, 0.0, 1e5, "mm/s²"),
            range("stribeck_share", self.stribeck_share, 0.0, 10.0, ""),
            range("stribeck_velocity_mm_per_s", self.stribeck_velocity_mm_per_s, 1e-3, 1000.0, "mm/s"),
            range("presliding_mm", self.presliding_mm, 1e-6, 1.0, "mm"),
            range("viscous_per_s", self.viscous_per_s, 0.0, 1000.0, "1/s"),
            range("dead_time_s", self.dead_time_s, 0.0, 0.1, "s"),
            range("resonance_hz", self.resonance_hz, 0.0, HIGHEST_RESONANCE_HZ, "Hz"),
            range("resonance_damping", self.resonance_damping, 0.0, 0.9, "of critical"),
            range("load_share", self.load_share, 0.05, 0.95, ""),
            range("gear_play_mm", self.gear_play_mm, 0.0, 1.0, "mm"),
            range("torque_ripple_mm_per_s2", self.torque_ripple_mm_per_s2, 0.0, 1e5, "mm/s²"),
            range("ripple_period_mm", self.ripple_period_mm, 1e-3, 1000.0, "mm"),
        ]
    }

    /// Refuses figures that are each in range and do not agree with each other or with the servo period.
    ///
    /// # Errors
    /// The first such figure.
    pub fn agree(&self, period_s: f64) -> Result<(), Disagreement> {
        let refuse = |key, found: f64, needed| Err(Disagreement { key, found: found.to_string(), needed });
        if self.torque_ripple_mm_per_s2 >= self.force_limit_mm_per_s2 {
            let needed = format!("less than force_limit_mm_per_s2, {}", number(self.force_limit_mm_per_s2));
            return refuse("torque_ripple_mm_per_s2", self.torque_ripple_mm_per_s2, needed);
        }
        if self.resonance_hz == 0.0 {
            let rigid = "with the rigid drive of resonance_hz = 0";
            if self.gear_play_mm != 0.0 {
                return refuse("gear_play_mm", self.gear_play_mm, format!("0 {rigid}, or a resonance_hz"));
            }
            if self.scale_at == ScaleAt::Load {
                let needed = format!("\"motor\" {rigid}, or a resonance_hz");
                return Err(Disagreement { key: "scale_at", found: "\"load\"".into(), needed });
            }
            return Ok(());
        }
        // Half the servo rate: the readings show a faster oscillation as a slower one, which the position loop answers.
        let highest = HIGHEST_RESONANCE_HZ.min(0.5 / period_s);
        if !(LOWEST_RESONANCE_HZ..=highest).contains(&self.resonance_hz) {
            let needed = format!(
                "0 (rigid) or {LOWEST_RESONANCE_HZ} to {} Hz, half the servo rate at most",
                number(highest.floor())
            );
            return refuse("resonance_hz", self.resonance_hz, needed);
        }
        if self.resonance_damping < LEAST_DAMPING {
            let needed = format!("{LEAST_DAMPING} to 0.9 of critical with a resonance_hz of {}", self.resonance_hz);
            return refuse("resonance_damping", self.resonance_damping, needed);
        }
        Ok(())
    }
}
