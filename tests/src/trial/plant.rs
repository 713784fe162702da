//! Plants of the family, and whether their drives are sound without the plugin.

use serde::Serialize;
use trueaxis::machine::{DriveFigures, FrictionSettings};
use trueaxis_sim::plant::drive::{Drive, DriveSettings, ScaleAt};
use trueaxis_testing::noise::Noise;

/// Step that a sound drive follows, mm: without friction and within the motor's force, the size does not matter.
const STEP_MM: f64 = 1e-3;
/// Largest overshoot of a sound drive, share of the step.
const OVERSHOOT: f64 = 0.4;
/// Largest motion of a sound drive 0.3 s after a step, share of the step.
const LEFT: f64 = 0.02;

/// Resonances as stated to the plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resonance {
    /// Nothing: any resonance above 100 Hz is assumed.
    Unknown,
    /// Frequency and damping of each drive.
    Stated,
}

/// Both drives as stated to the plugin, and as they are.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Plant {
    /// Servo period, s.
    pub period_s: f64,
    /// Figures stated for both axes.
    pub stated: DriveSettings,
    /// X and Y.
    pub drives: [DriveSettings; 2],
}

impl Plant {
    /// The next plant of the family whose drives are sound without the plugin: a servo at 1 or 2 kHz, resonances of 25 to 300 Hz with
    /// 1 to 10 % damping, load shares of 0.2 to 0.8, friction ±50 %, gains ±10 %, play of 0 to 10 µm, dead time of 0 to 3
    /// cycles. `refused` counts those that are not.
    pub fn draw(random: &mut Noise, refused: &mut usize) -> Plant {
        loop {
            let plant = Plant::any(random);
            if plant.drives.iter().all(|drive| is_sound(drive, plant.period_s)) {
                return plant;
            }
            *refused += 1;
        }
    }

    fn any(random: &mut Noise) -> Plant {
        let period_s = [1e-3, 0.5e-3][random.below(2)];
        let position_gain_per_s = 20.0 * 6.0_f64.powf(random.unit());
        let velocity_gain_per_s = position_gain_per_s * random.range(5.0, 10.0);
        let scale_at = [ScaleAt::Motor, ScaleAt::Load][random.below(2)];
        let stated = DriveSettings {
            position_gain_per_s,
            velocity_gain_per_s,
            velocity_feed_forward: random.unit(),
            reset_time_s: random.range(4.0, 10.0) / velocity_gain_per_s,
            current_loop_s: random.range(0.05, 0.2) / velocity_gain_per_s,
            dead_time_s: random.range(0.0, 3.0) * period_s,
            scale_at,
            ..DriveSettings::default()
        };
        let resonance_hz = 25.0 * 12.0_f64.powf(random.unit());
        let mut drive = || {
            let friction = random.range(0.5, 1.5);
            DriveSettings {
                position_gain_per_s: position_gain_per_s * random.range(0.9, 1.1),
                velocity_gain_per_s: velocity_gain_per_s * random.range(0.9, 1.1),
                coulomb_mm_per_s2: stated.coulomb_mm_per_s2 * friction,
                viscous_per_s: stated.viscous_per_s * friction,
                resonance_hz: (resonance_hz * random.range(0.8, 1.25)).clamp(25.0, 300.0),
                resonance_damping: 0.01 * 10.0_f64.powf(random.unit()),
                load_share: random.range(0.2, 0.8),
                gear_play_mm: random.range(0.0, 0.01),
                ..stated
            }
        };
        Plant { period_s, stated, drives: [drive(), drive()] }
    }

    /// The figures of drive X (0) or Y (1) as the plugin gets them.
    pub fn figures(&self, drive: usize, resonance: Resonance) -> DriveFigures {
        let s = &self.stated;
        let [resonance_hz, resonance_damping] = match (resonance, self.drives.get(drive)) {
            (Resonance::Stated, Some(drive)) => [drive.resonance_hz, drive.resonance_damping],
            _ => [0.0; 2],
        };
        DriveFigures {
            resonance_hz,
            resonance_damping,
            velocity_feed_forward: s.velocity_feed_forward,
            current_loop_s: s.current_loop_s,
            dead_time_s: s.dead_time_s,
            ..DriveFigures::with_defaults(s.position_gain_per_s, s.velocity_gain_per_s, s.reset_time_s)
        }
    }

    /// The friction as the plugin gets it.
    pub fn friction(&self) -> FrictionSettings {
        let s = &self.stated;
        FrictionSettings {
            stribeck_share: s.stribeck_share,
            stribeck_velocity_per_s: s.stribeck_velocity_mm_per_s,
            viscous: s.viscous_per_s / s.velocity_gain_per_s,
            ..FrictionSettings::with_defaults(s.coulomb_mm_per_s2 / s.velocity_gain_per_s, s.presliding_mm)
        }
    }
}

/// Whether a drive follows a step without feed-forward, friction and play well damped.
fn is_sound(drive: &DriveSettings, period_s: f64) -> bool {
    let linear = DriveSettings { coulomb_mm_per_s2: 0.0, gear_play_mm: 0.0, velocity_feed_forward: 0.0, ..*drive };
    let mut drive = Drive::new(linear, period_s);
    let cycles = (0.4 / period_s) as usize;
    let (mut top, mut low, mut high) = (0.0_f64, f64::MAX, f64::MIN);
    for k in 0..cycles {
        drive.cycle(STEP_MM, drive.position(), 1.0);
        let at = drive.load_position() / STEP_MM;
        top = top.max(at);
        if k > 3 * cycles / 4 {
            (low, high) = (low.min(at), high.max(at));
        }
    }
    top < 1.0 + OVERSHOOT && high - low < LEFT
}
