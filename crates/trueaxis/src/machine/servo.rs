//! Settings of the servo: drive figures, friction, feed-forward, contour feedback, cross-talk.
//!
//! For a rotary axis every `mm` reads `degree`. Every part is off unless it is configured.

use super::Limits;
use crate::axis::Axis;
use heapless::Vec;

/// Largest number of cross-talk entries of a machine.
pub const CROSSTALK_CAPACITY: usize = 6;
/// Largest number of points in one entry's table.
pub const CROSSTALK_POINTS: usize = 8;

/// Figures of an axis' servo drive: a position loop around a velocity loop around a current loop.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveFigures {
    /// Gain of the position loop K_v, 1/s.
    pub position_gain_per_s: f64,
    /// Proportional gain of the velocity loop K_vp, 1/s: acceleration per velocity error.
    pub velocity_gain_per_s: f64,
    /// Reset time of the velocity loop τ, s.
    pub reset_time_s: f64,
    /// Share k_ff of the commanded velocity that is fed forward, 0 to 1.
    pub velocity_feed_forward: f64,
    /// Time constant of the current loop, s.
    pub current_loop_s: f64,
    /// Dead time t_d from a command to the position loop and back through the reading, s.
    pub dead_time_s: f64,
    /// Resonance of motor and load against each other, both free, Hz; 0: not stated.
    pub resonance_hz: f64,
    /// Damping of the resonance, share of critical; 0: not stated.
    pub resonance_damping: f64,
    /// Frequency below which the axis has no resonance, Hz; 0: not stated, which assumes 100 Hz unless the resonance is
    /// stated.
    pub lowest_resonance_hz: f64,
    /// Factor by which the resonance lets the gains of the contour feedback grow without a notch there; 0: no notch. Decided
    /// where a machine is compiled ([`crate::check::decide_notches`]), not stated in `machine.toml`.
    pub gain_without_notch: f64,
}

impl DriveFigures {
    /// Creates a drive with these gains (1/s) and this reset time (s), the rest at its defaults: no feed-forward, a
    /// current loop of 0.25 ms, no dead time, nothing stated about resonances.
    pub const fn with_defaults(position_gain_per_s: f64, velocity_gain_per_s: f64, reset_time_s: f64) -> DriveFigures {
        DriveFigures {
            position_gain_per_s,
            velocity_gain_per_s,
            reset_time_s,
            velocity_feed_forward: 0.0,
            current_loop_s: 2.5e-4,
            dead_time_s: 0.0,
            resonance_hz: 0.0,
            resonance_damping: 0.0,
            lowest_resonance_hz: 0.0,
            gain_without_notch: 0.0,
        }
    }

    /// Whether the resonance, or the lowest one, is stated.
    pub fn states_resonance(&self) -> bool {
        self.resonance_hz > 0.0 || self.lowest_resonance_hz > 0.0
    }

    /// Lag of the drive at a constant velocity without its dead time, (1 − k_ff)/K_v, s.
    pub fn lag_s(&self) -> f64 {
        (1.0 - self.velocity_feed_forward) / self.position_gain_per_s
    }
}

/// Friction of an axis for the reversal feed-forward. Forces are divided by the moved mass and by K_vp, so that they are
/// velocities: the error of the velocity loop until its integrator supplies the force.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrictionSettings {
    /// Coulomb friction F_c/K_vp, mm/s.
    pub coulomb_per_s: f64,
    /// Static friction above Coulomb friction as a share of it, s.
    pub stribeck_share: f64,
    /// Velocity v_s at which half of that share remains, mm/s.
    pub stribeck_velocity_per_s: f64,
    /// Pre-sliding z: travel over which friction reverses by 63 %, mm.
    pub presliding: f64,
    /// Viscous friction d/K_vp, mm/s per mm/s.
    pub viscous: f64,
    /// Friction is computed for the velocity commanded this much later, s, extrapolated with the commanded acceleration.
    pub lead_s: f64,
    /// Share of the identified figures by which Coulomb friction and pre-sliding may follow the spikes that are left at
    /// reversals; 0: not at all. A compiled file stores it behind the settings.
    pub adapt: f64,
}

impl FrictionSettings {
    /// Creates friction from Coulomb friction F_c/K_vp (mm/s) and pre-sliding (mm), the rest at its defaults: no Stribeck
    /// and no viscous part, no lead, no adaptation.
    pub const fn with_defaults(coulomb_per_s: f64, presliding: f64) -> FrictionSettings {
        FrictionSettings {
            coulomb_per_s,
            stribeck_share: 0.0,
            stribeck_velocity_per_s: 2.0,
            presliding,
            viscous: 0.0,
            lead_s: 0.0,
            adapt: 0.0,
        }
    }
}

/// Dynamic correction that the step adds to an axis' command in addition to the geometric correction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DynamicSettings {
    /// Limits of the dynamic correction; its sum with the geometric one also keeps the limits of the axis.
    pub limits: Limits,
    /// Compensates the following error of the velocity that the drive does not feed forward.
    pub lag: bool,
    /// Feeds forward the velocity error that the commanded acceleration requires of the velocity loop.
    pub acceleration: bool,
    /// Takes up lost motion from the reversal of the command, without waiting for the hysteresis.
    pub take_up: bool,
    /// Lag that is compensated, s: position offset per velocity. 0: the drive's own, (1 − k_ff)/K_v. A compiled file
    /// stores it behind the settings.
    pub lag_s: f64,
}

impl DynamicSettings {
    /// The stated defaults, also used if an axis has friction, cross-talk or feedback but no such section: limits of
    /// 50 µm, 5 mm/s, 5 m/s² (rotary 1000 µrad, 5 deg/s, 5000 deg/s²), everything off.
    pub fn with_defaults(axis: Axis) -> DynamicSettings {
        let magnitude = if axis.is_rotary() { 1000e-6_f64.to_degrees() } else { 0.05 };
        DynamicSettings {
            limits: Limits { magnitude, slope_per_s: 5.0, acceleration_per_s2: 5000.0 },
            lag: false,
            acceleration: false,
            take_up: false,
            lag_s: 0.0,
        }
    }

    /// Lag that is compensated on an axis with this drive, s.
    pub fn lag_s(&self, drive: &DriveFigures) -> f64 {
        if self.lag_s > 0.0 { self.lag_s } else { drive.lag_s() }
    }
}

/// The servo of an axis: each part is off if it is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisServo {
    /// The drive.
    pub drive: Option<DriveFigures>,
    /// Friction, for the reversal feed-forward.
    pub friction: Option<FrictionSettings>,
    /// Limits of the dynamic correction, and its other parts.
    pub dynamic: Option<DynamicSettings>,
}

/// Contour feedback: u = −(K_p e + K_i ∫e dt), e the contour error of the estimated tip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FeedbackSettings {
    /// Proportional gain K_p.
    pub proportional: f64,
    /// Integral gain K_i, 1/s.
    pub integral_per_s: f64,
    /// Highest speed of the command with feedback, mm/s; above it (rapid motion) the feedback is off.
    pub max_feed_per_s: f64,
    /// A contour error that repeatedly changes its sign, each time exceeding this, is an oscillation: the feedback is
    /// ramped out, mm.
    pub watch_mm: f64,
}

impl Default for FeedbackSettings {
    /// K_p 0.3 and K_i 10/s, for position loops of about 110/s; up to 10 m/min; the watch detects
    /// oscillations above 10 µm.
    fn default() -> Self {
        FeedbackSettings { proportional: 0.3, integral_per_s: 10.0, max_feed_per_s: 1e4 / 60.0, watch_mm: 0.01 }
    }
}

/// Acceleration cross-talk: the tip moves by k a in direction `tip` while axis `from` accelerates by a.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CrosstalkSettings {
    /// Linear axis along which the tip moves, and which corrects it.
    pub tip: Axis,
    /// Axis that accelerates.
    pub from: Axis,
    /// Axis whose position determines k.
    pub over: Axis,
    /// Position (mm, deg) and k (s²: mm per mm/s²; mm per deg/s²), positions increasing, linear between points, constant
    /// beyond the ends. A single point is a constant.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub points: Vec<[f64; 2], CROSSTALK_POINTS>,
}
