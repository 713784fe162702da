//! Settings of a machine: axes, limits, location errors.
//!
//! Lengths are mm, angles of rotary *positions* are degrees, angular *errors* are radians; time is seconds.
//! For a rotary axis every `mm` of an axis-own quantity (travel, backlash, correction limits) reads `degree`.
//!
//! [`crate::tcomp`] defines how a compiled file stores them; the order of these fields is free.

mod chain;
mod curve;
mod grid;
mod order;
pub mod pchip;
mod periodic;
mod rows;
mod servo;

pub use crate::axis::{AXES, Axis};
pub use chain::{Link, carries_workpiece, is_turned, links};
pub(crate) use chain::{MOST_CARRIERS, nine_terms};
pub(crate) use curve::lost;
pub use curve::{Curve, wraps};
pub use grid::{GRID_NODES, GRIDS, GridAxis, GridData, GridExtremes, GridHeader};
pub use order::AxisOrder;
pub use periodic::{PERIODIC_CAPACITY, PERIODIC_HARMONICS, PeriodicSettings};
pub(crate) use rows::Lines;
pub use rows::Rows;
pub use servo::{
    AxisServo, CROSSTALK_CAPACITY, CROSSTALK_POINTS, CrosstalkSettings, DriveFigures, DynamicSettings,
    FeedbackSettings, FrictionSettings,
};

use crate::part;
use crate::roundness::GaugeSettings;
use heapless::{String, Vec};

/// Largest length of a machine name, in bytes of UTF-8.
pub const NAME_CAPACITY: usize = 64;
/// Largest length of a structural code, in bytes.
pub const CHAIN_CAPACITY: usize = 48;

/// Interpolation between the points of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Interpolation {
    /// Straight lines between the points; the slope steps at every point.
    #[default]
    Linear,
    /// Monotone cubic (PCHIP, Fritsch and Butland's weighted harmonic mean): continuous slope, no overshoot of the
    /// points.
    Cubic,
}

/// Position at which a table is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Lookup {
    /// At the commanded position (with exact inverse).
    #[default]
    Command,
    /// At the raw feedback.
    Feedback,
}

/// Limits of one axis' correction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Largest |correction|, mm (rotary: degrees).
    pub magnitude: f64,
    /// Largest |rate of change|, mm/s (deg/s).
    pub slope_per_s: f64,
    /// Largest |acceleration|, mm/s² (deg/s²).
    pub acceleration_per_s2: f64,
}

/// Thermal growth of one axis: error added at temperature T and position q is
/// `(T − T_ref) · (offset_per_k + expansion_per_k · (q − datum))`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ThermalGrowth {
    /// Offset, mm/K (deg/K).
    pub offset_per_k: f64,
    /// Expansion, 1/K.
    pub expansion_per_k: f64,
    /// Position that does not grow, mm (deg).
    pub datum: f64,
}

/// Settings of one axis, without its table values.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisSettings {
    /// Which axis.
    pub axis: Axis,
    /// Interpolation between table points.
    pub interpolation: Interpolation,
    /// Lookup position of the axis' own positioning error.
    pub lookup: Lookup,
    /// Lookup position of the other components.
    pub cross_lookup: Lookup,
    /// Sense of a rotary axis, +1 or −1 (linear: +1).
    pub direction: i8,
    /// Declared travel, low and high, mm (deg). A command outside it is a fault; so is a reading more than 1 mm (1°)
    /// outside the joint.
    pub travel: [f64; 2],
    /// Range in which command + correction must stay, mm (deg).
    pub joint: [f64; 2],
    /// Origin of the axis' frame from its carrier's, in bed directions with all axes at zero, mm. For a rotary axis: a
    /// point of its axis of rotation.
    pub offset_mm: [f64; 3],
    /// Position of the *other* linear axes (and of the measuring point) when the table was measured, mm. Zero: not
    /// stated; the table's translations apply at the origin of the axis' moved frame.
    pub measured_at_mm: [f64; 3],
    /// Highest feed of the axis, mm/s (deg/s).
    pub max_feed_per_s: f64,
    /// Added to the axis' own error during negative travel, mm (deg); positive = lost motion. Needs no table.
    pub backlash: f64,
    /// A reversal counts once the drive, command plus correction, has moved back by more than this, mm (deg). On an axis
    /// with lost motion it must be at least [`crate::check::HYSTERESIS_PER_STEP`] steps of the encoder, if they are
    /// known, and wider than any step that a correction makes against the travel: see [`crate::check::reversal`].
    pub hysteresis: f64,
    /// Smallest step of the position reading, mm (deg), or its peak-to-peak noise if that is larger; `None` if not
    /// stated. Bounds the hysteresis from below, and determines the changes that a dead encoder may show
    /// ([`FaultSettings::stuck`]). Stored at the end of a compiled file ([`crate::tcomp`]).
    pub encoder_resolution: Option<f64>,
    /// Limits of the correction.
    pub limits: Limits,
    /// Thermal growth.
    pub thermal: ThermalGrowth,
    /// Drive, friction and dynamic correction.
    pub servo: AxisServo,
}

impl AxisSettings {
    /// Whether the table contains readings along a line in the machine. On a slide that carries the workpiece, whose
    /// frame moves away from that line, its own travel then contributes no lever.
    pub fn is_measured_along_a_line(&self) -> bool {
        self.measured_at_mm != [0.0; 3]
    }

    /// The stated defaults of an axis; `carries_workpiece` for the workpiece side of the chain.
    ///
    /// Travel not declared (±1e6 mm, ±1e9 degrees), linear interpolation, lookup at the command, 0.3 µm (6 µrad) of
    /// reversal hysteresis, limits 100 µm, 5 mm/s, 5 m/s² (rotary 2000 µrad, 5 deg/s, 5000 deg/s²).
    ///
    /// With these limits an axis crosses 2 µm of lost motion within 1.5 ms. Lower limits would do more harm than they
    /// prevent, by leaving lost motion uncorrected after a reversal. The rotary limits correspond to a radius of some
    /// 50 mm. In single precision the acceleration is 10 times the resolution of the correction at servo rates up to
    /// 200 kHz.
    pub fn with_defaults(axis: Axis, carries_workpiece: bool) -> Self {
        let rotary = axis.is_rotary();
        let reach = if rotary { 1e9 } else { 1e6 };
        let magnitude = if rotary { 2000e-6_f64.to_degrees() } else { 0.1 };
        AxisSettings {
            axis,
            interpolation: Interpolation::Linear,
            lookup: Lookup::Command,
            cross_lookup: Lookup::Command,
            direction: if rotary && carries_workpiece { -1 } else { 1 },
            travel: [-reach, reach],
            joint: [-reach - magnitude, reach + magnitude],
            offset_mm: [0.0; 3],
            measured_at_mm: [0.0; 3],
            max_feed_per_s: if rotary { 600.0 } else { 500.0 },
            backlash: 0.0,
            hysteresis: if rotary { 6e-6_f64.to_degrees() } else { 0.3e-3 },
            encoder_resolution: None,
            limits: Limits { magnitude, slope_per_s: 5.0, acceleration_per_s2: 5000.0 },
            thermal: ThermalGrowth::default(),
            servo: AxisServo::default(),
        }
    }
}

/// Location errors of the axes, all zero for a perfect machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LocationErrors {
    /// Squareness `A0Z` of Z to Y, rad.
    pub a0z: f64,
    /// Squareness `B0Z` of Z to X, rad.
    pub b0z: f64,
    /// Squareness `C0Y` of Y to X, rad.
    pub c0y: f64,
    /// For A, B, C in this order: `EX0r, EY0r, EZ0r` (mm), `EA0r, EB0r, EC0r` (rad).
    pub rotary: [[f64; 6]; 3],
}

impl LocationErrors {
    /// Returns the location errors of a rotary axis: `EX0r, EY0r, EZ0r` (mm), `EA0r, EB0r, EC0r` (rad); `None` for a
    /// linear one.
    pub fn of(&self, axis: Axis) -> Option<&Twist> {
        self.rotary.get(axis.index().checked_sub(Axis::A.index())?)
    }
}

/// Conditions for accepting a reading or a command. Pairs are for linear (mm) and rotary (degrees) axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultSettings {
    /// After a stop request the step resumes only if the command is within this distance of the held one: mm, degrees.
    pub resume: [f64; 2],
    /// Largest plausible change of the command as a multiple of `max_feed · period`.
    pub command_jump_factor: f64,
    /// Largest plausible change of the feedback in a cycle beyond `command_jump_factor · max_feed · period`: mm, degrees.
    pub feedback_jump: [f64; 2],
    /// The encoder is stuck when the command has moved this far without a change of the reading: mm, degrees.
    ///
    /// If the resolution of the encoder is stated, a reading that stays within three steps of it (at most a quarter of
    /// this) has not changed, and a command has not moved if it stays within that distance plus the backlash.
    pub stuck: [f64; 2],
}

impl Default for FaultSettings {
    fn default() -> Self {
        FaultSettings { resume: [0.05; 2], command_jump_factor: 2.0, feedback_jump: [0.02; 2], stuck: [0.2; 2] }
    }
}

/// Settings of the contour search.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ContourSettings {
    /// Half-window of a cold search, arc length, mm.
    pub max_lag_mm: f64,
    /// Contour feedback, if configured.
    pub feedback: Option<FeedbackSettings>,
}

impl Default for ContourSettings {
    fn default() -> Self {
        ContourSettings { max_lag_mm: 1.0, feedback: None }
    }
}

/// Which errors the step corrects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ErrorModel {
    /// Axis-wise: the translations of every axis and a rotary axis' own error; angular errors have no lever.
    #[default]
    Nine,
    /// Volumetric: the twist of every axis, transferred to the tool tip by its lever.
    Volumetric,
}

/// Which errors are corrected, and by which axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CompensationSettings {
    /// The error model.
    pub model: ErrorModel,
    /// Volumetric: whether the rotary axes correct the direction of the tool. The linear axes always correct the tip.
    pub orientation: bool,
    /// The correction of the direction is full while the tool is at least this far from the axis of the rotary axis next
    /// to the workpiece (its singular pose), and fades to zero towards it: degrees.
    pub fade_deg: f64,
}

impl CompensationSettings {
    /// Whether the model is volumetric; always `false` in a build without that model.
    pub(crate) fn is_volumetric(&self) -> bool {
        part::VOLUMETRIC.is_some() && self.model == ErrorModel::Volumetric
    }
}

impl Default for CompensationSettings {
    fn default() -> Self {
        CompensationSettings { model: ErrorModel::Nine, orientation: false, fade_deg: 5.0 }
    }
}

/// Settings of the transformation between axis positions and the tool in workpiece coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KinematicsSettings {
    /// Tool axis with all axes at zero, from the tip to the spindle, in bed directions; normalised at use.
    pub tool_axis: [f64; 3],
    /// If the tool is closer than this to the singular pose, the rotary axis nearest the workpiece stops or is limited,
    /// and the tool's direction may deviate by at most as much: degrees; 0: exact everywhere.
    pub singular_cone_deg: f64,
}

impl Default for KinematicsSettings {
    fn default() -> Self {
        KinematicsSettings { tool_axis: [0.0, 0.0, 1.0], singular_cone_deg: 0.1 }
    }
}

/// Settings of a machine, without its table values.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MachineSettings {
    /// Name of the machine.
    pub name: String<NAME_CAPACITY>,
    /// Structural code after ISO 10791-6, from the workpiece through the bed to the tool, e.g. `w X' b Y Z t`.
    pub chain: String<CHAIN_CAPACITY>,
    /// Tool tip from the last tool-side frame at all axes zero, mm.
    pub tool_mm: [f64; 3],
    /// Temperature at which the tables are valid, °C.
    pub reference_temperature_c: f64,
    /// Location errors.
    pub location: LocationErrors,
    /// Plausibility limits.
    pub faults: FaultSettings,
    /// Contour search.
    pub contour: ContourSettings,
    /// Error model and its correction.
    pub compensation: CompensationSettings,
    /// Tool axis and singular pose.
    pub kinematics: KinematicsSettings,
    /// The axes in the chain, each once, in the order X Y Z A B C.
    pub axes: Vec<AxisSettings, AXES>,
    /// Three-probe gauge, if the machine has one.
    pub roundness: Option<GaugeSettings>,
    /// Acceleration cross-talk.
    pub crosstalk: Vec<CrosstalkSettings, CROSSTALK_CAPACITY>,
    /// Errors that repeat within a period of an axis. Stored at the end of a compiled file ([`crate::tcomp`]).
    pub periodic: Vec<PeriodicSettings, PERIODIC_CAPACITY>,
}

impl MachineSettings {
    /// A machine without name and axes, as a place to decode settings into.
    pub(crate) const EMPTY: MachineSettings = MachineSettings {
        name: String::new(),
        chain: String::new(),
        tool_mm: [0.0; 3],
        reference_temperature_c: 0.0,
        location: LocationErrors { a0z: 0.0, b0z: 0.0, c0y: 0.0, rotary: [[0.0; 6]; 3] },
        faults: FaultSettings { resume: [0.0; 2], command_jump_factor: 0.0, feedback_jump: [0.0; 2], stuck: [0.0; 2] },
        contour: ContourSettings { max_lag_mm: 0.0, feedback: None },
        compensation: CompensationSettings { model: ErrorModel::Nine, orientation: false, fade_deg: 0.0 },
        kinematics: KinematicsSettings { tool_axis: [0.0; 3], singular_cone_deg: 0.0 },
        axes: Vec::new(),
        roundness: None,
        crosstalk: Vec::new(),
        periodic: Vec::new(),
    };

    /// The periods of an axis.
    pub fn periods_of(&self, axis: Axis) -> impl Iterator<Item = &PeriodicSettings> {
        self.periodic.iter().filter(move |period| period.axis == axis)
    }

    /// Upper bound of an axis' errors within its periods (`order` 0), of their slope (1) or curvature (2), mm per mm^order
    /// (deg): [`PeriodicSettings::bound`].
    pub fn repeats(&self, axis: Axis, order: i32) -> f64 {
        self.periods_of(axis).map(|period| period.bound(order)).sum()
    }
}

/// The six errors of an axis at one position: translations along X, Y, Z (mm), rotations about X, Y, Z (rad).
pub type Twist<R = f64> = [R; 6];

/// One line of an error table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Row {
    /// Axis position, mm (deg).
    pub position: f64,
    /// Errors in positive travel, or in either direction.
    pub forward: Twist,
    /// Errors in negative travel; equal to `forward` unless the table is bidirectional.
    pub reverse: Twist,
}
