//! The settings as the file stores them: **the file format**.
//!
//! Each structure below lists the fields of a public type in the order of the file, in postcard. The order of the
//! public fields themselves is free. A change of an order, a type or a variant *here* is another version of the
//! format. A public field that is missing here does not compile.
//!
//! Nothing is converted: serde fills the public type itself ("remote" derive), which takes no stack beyond it.

use super::{read, read_list, read_stored};
use crate::axis::{AXES, Axis};
use crate::machine::{
    AxisServo, AxisSettings, CHAIN_CAPACITY, CROSSTALK_CAPACITY, CROSSTALK_POINTS, CompensationSettings,
    ContourSettings, CrosstalkSettings, DriveFigures, DynamicSettings, ErrorModel, FaultSettings, FeedbackSettings,
    FrictionSettings, GridAxis, GridHeader, Interpolation, KinematicsSettings, Limits, LocationErrors, Lookup,
    MachineSettings, NAME_CAPACITY, PERIODIC_CAPACITY, PERIODIC_HARMONICS, PeriodicSettings, ThermalGrowth, Twist,
};
use crate::roundness::{
    Arm, ArmSettings, Band, GaugeSettings, InfeedSettings, ProbeAngles, ProbeSettings, SpindleEncoder,
};
use heapless::{String, Vec};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The payload's first part.
///
/// [`read_settings`] reads the same fields in the same order.
#[derive(Serialize, Deserialize)]
#[serde(remote = "MachineSettings")]
struct StoredMachine {
    name: String<NAME_CAPACITY>,
    chain: String<CHAIN_CAPACITY>,
    tool_mm: [f64; 3],
    reference_temperature_c: f64,
    #[serde(with = "Layout")]
    location: LocationErrors,
    #[serde(with = "Layout")]
    faults: FaultSettings,
    #[serde(with = "Layout")]
    contour: ContourSettings,
    #[serde(with = "Layout")]
    compensation: CompensationSettings,
    #[serde(with = "Layout")]
    kinematics: KinematicsSettings,
    #[serde(with = "Layout")]
    axes: Vec<AxisSettings, AXES>,
    #[serde(with = "Layout")]
    roundness: Option<GaugeSettings>,
    #[serde(with = "Layout")]
    crosstalk: Vec<CrosstalkSettings, CROSSTALK_CAPACITY>,
    /// At the end of the payload, in version 8.
    #[serde(skip)]
    periodic: Vec<PeriodicSettings, PERIODIC_CAPACITY>,
}

/// Decodes settings in postcard, field by field into their places: serde copies a whole structure at every level that
/// returns it, which takes 20 kB of stack.
pub(super) fn read_settings(rest: &mut &[u8], to: &mut MachineSettings) -> Option<()> {
    let MachineSettings {
        name,
        chain,
        tool_mm,
        reference_temperature_c,
        location,
        faults,
        contour,
        compensation,
        kinematics,
        axes,
        roundness,
        crosstalk,
        periodic: _,
    } = to;
    read(rest, name)?;
    read(rest, chain)?;
    read(rest, tool_mm)?;
    read(rest, reference_temperature_c)?;
    read_stored(rest, location)?;
    read_stored(rest, faults)?;
    read_stored(rest, contour)?;
    read_stored(rest, compensation)?;
    read_stored(rest, kinematics)?;
    read_list(rest, axes)?;
    read_stored(rest, roundness)?;
    read_list(rest, crosstalk)
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "LocationErrors")]
struct StoredLocation {
    a0z: f64,
    b0z: f64,
    c0y: f64,
    rotary: [[f64; 6]; 3],
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "FaultSettings")]
struct StoredFaults {
    resume: [f64; 2],
    command_jump_factor: f64,
    feedback_jump: [f64; 2],
    stuck: [f64; 2],
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ContourSettings")]
struct StoredContour {
    max_lag_mm: f64,
    #[serde(with = "Layout")]
    feedback: Option<FeedbackSettings>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "FeedbackSettings")]
struct StoredFeedback {
    proportional: f64,
    integral_per_s: f64,
    max_feed_per_s: f64,
    watch_mm: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "CompensationSettings")]
struct StoredCompensation {
    #[serde(with = "Layout")]
    model: ErrorModel,
    orientation: bool,
    fade_deg: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ErrorModel")]
enum StoredModel {
    Nine,
    Volumetric,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "KinematicsSettings")]
struct StoredKinematics {
    tool_axis: [f64; 3],
    singular_cone_deg: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "AxisSettings")]
struct StoredAxis {
    #[serde(with = "Layout")]
    axis: Axis,
    #[serde(with = "Layout")]
    interpolation: Interpolation,
    #[serde(with = "Layout")]
    lookup: Lookup,
    #[serde(with = "Layout")]
    cross_lookup: Lookup,
    direction: i8,
    travel: [f64; 2],
    joint: [f64; 2],
    offset_mm: [f64; 3],
    measured_at_mm: [f64; 3],
    max_feed_per_s: f64,
    backlash: f64,
    hysteresis: f64,
    /// At the end of the payload, from version 6 on.
    #[serde(skip)]
    encoder_resolution: Option<f64>,
    #[serde(with = "Layout")]
    limits: Limits,
    #[serde(with = "Layout")]
    thermal: ThermalGrowth,
    #[serde(with = "Layout")]
    servo: AxisServo,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Axis")]
enum StoredLetter {
    X,
    Y,
    Z,
    A,
    B,
    C,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Interpolation")]
enum StoredInterpolation {
    Linear,
    Cubic,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Lookup")]
enum StoredLookup {
    Command,
    Feedback,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Limits")]
struct StoredLimits {
    magnitude: f64,
    slope_per_s: f64,
    acceleration_per_s2: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ThermalGrowth")]
struct StoredGrowth {
    offset_per_k: f64,
    expansion_per_k: f64,
    datum: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "AxisServo")]
struct StoredServo {
    #[serde(with = "Layout")]
    drive: Option<DriveFigures>,
    #[serde(with = "Layout")]
    friction: Option<FrictionSettings>,
    #[serde(with = "Layout")]
    dynamic: Option<DynamicSettings>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "DriveFigures")]
struct StoredDrive {
    position_gain_per_s: f64,
    velocity_gain_per_s: f64,
    reset_time_s: f64,
    velocity_feed_forward: f64,
    current_loop_s: f64,
    dead_time_s: f64,
    /// These three at the end of the payload, in version 7.
    #[serde(skip)]
    resonance_hz: f64,
    #[serde(skip)]
    resonance_damping: f64,
    #[serde(skip)]
    lowest_resonance_hz: f64,
    /// Behind those, if a drive has a notch.
    #[serde(skip)]
    gain_without_notch: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "FrictionSettings")]
struct StoredFriction {
    coulomb_per_s: f64,
    stribeck_share: f64,
    stribeck_velocity_per_s: f64,
    presliding: f64,
    viscous: f64,
    lead_s: f64,
    /// At the end of the payload, in version 7.
    #[serde(skip)]
    adapt: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "DynamicSettings")]
struct StoredDynamic {
    #[serde(with = "Layout")]
    limits: Limits,
    lag: bool,
    /// At the end of the payload, in version 7.
    #[serde(skip)]
    lag_s: f64,
    acceleration: bool,
    take_up: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "GaugeSettings")]
struct StoredGauge {
    points: u16,
    #[serde(with = "Layout")]
    angles: ProbeAngles,
    #[serde(with = "Layout")]
    band: Band,
    noise_gain_limit: f64,
    #[serde(with = "Layout")]
    probes: [ProbeSettings; 3],
    #[serde(with = "Layout")]
    spindle: SpindleEncoder,
    #[serde(with = "Layout")]
    arm: Option<ArmSettings>,
    filter: Option<u16>,
    revolutions: u16,
    slices_per_cycle: u8,
    stop_s: f64,
    #[serde(with = "Layout")]
    infeed: Option<InfeedSettings>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ProbeAngles")]
enum StoredAngles {
    Slots { p: u16, q: u16 },
    Degrees { phi2: f64, phi3: f64 },
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Band")]
struct StoredBand {
    first: u16,
    last: u16,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ProbeSettings")]
struct StoredProbe {
    gain_um: f64,
    zero: f64,
    range: [f64; 2],
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SpindleEncoder")]
struct StoredSpindle {
    counts: u32,
    direction: i8,
    index: bool,
    index_tolerance: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ArmSettings")]
struct StoredArm {
    #[serde(with = "Layout")]
    lengths: Arm,
    counts: u32,
    direction: i8,
    tolerance_deg: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Arm")]
struct StoredLinkage {
    crank_mm: f64,
    wheel_mm: f64,
    pin_mm: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "InfeedSettings")]
struct StoredInfeed {
    #[serde(with = "Layout")]
    axis: Axis,
    direction: i8,
    #[serde(with = "Layout")]
    band: Band,
    gain: f64,
    delay_revolutions: u8,
    contact_deg: f64,
    drive_delay_s: f64,
    limit_um: f64,
    noise_gain_limit: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "CrosstalkSettings")]
struct StoredCrosstalk {
    #[serde(with = "Layout")]
    tip: Axis,
    #[serde(with = "Layout")]
    from: Axis,
    #[serde(with = "Layout")]
    over: Axis,
    points: Vec<[f64; 2], CROSSTALK_POINTS>,
}

/// At the end of the payload, in version 8.
#[derive(Serialize, Deserialize)]
#[serde(remote = "PeriodicSettings")]
struct StoredPeriod {
    #[serde(with = "Layout")]
    axis: Axis,
    period: f64,
    harmonics: Vec<[f64; 2], PERIODIC_HARMONICS>,
    reverse: Vec<[f64; 2], PERIODIC_HARMONICS>,
}

/// Before the nodes of each grid.
#[derive(Serialize, Deserialize)]
#[serde(remote = "GridHeader")]
struct StoredGrid {
    #[serde(with = "Layout")]
    axes: [GridAxis; 3],
    given: u8,
    scales: Twist,
    fade: Option<[f64; 2]>,
    measured_at_mm: [f64; 3],
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "GridAxis")]
struct StoredNodes {
    nodes: u16,
    ends: [f64; 2],
    free: bool,
}

/// A type that a structure above lays out, or an option, list or triple of such.
pub trait Layout: Sized {
    /// Writes the value.
    ///
    /// # Errors
    /// Errors of the serializer.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error>;
    /// Reads a value.
    ///
    /// # Errors
    /// Errors of the deserializer.
    fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error>;
}

/// A value in its layout, for serde.
pub struct Stored<T>(pub T);

impl<T: Layout> Serialize for Stored<&T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'a, T: Layout> Deserialize<'a> for Stored<T> {
    fn deserialize<D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(deserializer).map(Stored)
    }
}

macro_rules! lay_out {
    ($($public:ty: $stored:ty,)+) => {
        $(impl Layout for $public {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                <$stored>::serialize(self, serializer)
            }
            fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
                <$stored>::deserialize(deserializer)
            }
        })+
    };
}

lay_out! {
    MachineSettings: StoredMachine,
    LocationErrors: StoredLocation,
    FaultSettings: StoredFaults,
    ContourSettings: StoredContour,
    FeedbackSettings: StoredFeedback,
    CompensationSettings: StoredCompensation,
    ErrorModel: StoredModel,
    KinematicsSettings: StoredKinematics,
    AxisSettings: StoredAxis,
    Axis: StoredLetter,
    Interpolation: StoredInterpolation,
    Lookup: StoredLookup,
    Limits: StoredLimits,
    ThermalGrowth: StoredGrowth,
    AxisServo: StoredServo,
    DriveFigures: StoredDrive,
    FrictionSettings: StoredFriction,
    DynamicSettings: StoredDynamic,
    GaugeSettings: StoredGauge,
    ProbeAngles: StoredAngles,
    Band: StoredBand,
    ProbeSettings: StoredProbe,
    SpindleEncoder: StoredSpindle,
    ArmSettings: StoredArm,
    Arm: StoredLinkage,
    InfeedSettings: StoredInfeed,
    CrosstalkSettings: StoredCrosstalk,
    PeriodicSettings: StoredPeriod,
    GridHeader: StoredGrid,
    GridAxis: StoredNodes,
}

impl<T: Layout> Layout for Option<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Serialize::serialize(&self.as_ref().map(Stored), serializer)
    }
    fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        let value: Option<Stored<T>> = Deserialize::deserialize(deserializer)?;
        Ok(value.map(|Stored(value)| value))
    }
}

impl<T: Layout> Layout for [T; 3] {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Serialize::serialize(&self.each_ref().map(Stored), serializer)
    }
    fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        let values: [Stored<T>; 3] = Deserialize::deserialize(deserializer)?;
        Ok(values.map(|Stored(value)| value))
    }
}

impl<T: Layout, const N: usize> Layout for Vec<T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter().map(Stored))
    }
    fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        let values: Vec<Stored<T>, N> = Deserialize::deserialize(deserializer)?;
        Ok(values.into_iter().map(|Stored(value)| value).collect())
    }
}
