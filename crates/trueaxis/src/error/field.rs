//! The settings that can be wrong, each with its key in `machine.toml`.

macro_rules! fields {
    ($($(#[$doc:meta])* $field:ident $(: $linear:literal $(| $rotary:literal)?)?;)*) => {
        /// A setting that can be wrong.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        pub enum Field {
            $($(#[$doc])* $(#[doc = concat!(" `", $linear, "`")])? $field,)*
        }

        impl Field {
            /// Every setting.
            pub const ALL: &[Field] = &[$(Field::$field),*];

            /// Number of the setting, from 0, in the order of [`Field::ALL`]; what a build without texts reports. New
            /// settings are appended, so that numbers keep their meaning.
            pub const fn code(self) -> u8 {
                self as u8
            }

            /// Key in `machine.toml` for linear axes and for rotary ones; `*` is the letter of the axis.
            pub(super) const fn pattern(self) -> Option<[&'static str; 2]> {
                match self {
                    $(Field::$field => fields!(@pattern $($linear $(| $rotary)?)?),)*
                }
            }
        }
    };
    (@pattern) => { None };
    (@pattern $both:literal) => { Some([$both; 2]) };
    (@pattern $linear:literal | $rotary:literal) => { Some([$linear, $rotary]) };
}

fields! {
    /// Machine name.
    Name: "name";
    /// Structural code.
    Chain: "chain";
    /// The set of axes.
    Axes: "axis.*";
    /// Tool vector.
    Tool: "tool_mm";
    /// Reference temperature.
    ReferenceTemperature: "reference_temperature_c";
    /// Squareness of Z and Y.
    LocationA0Z: "location.A0Z_urad";
    /// Squareness of Z and X.
    LocationB0Z: "location.B0Z_urad";
    /// Squareness of Y and X.
    LocationC0Y: "location.C0Y_urad";
    /// Offset in X of a rotary axis.
    LocationEx: "location.EX0*_um";
    /// Offset in Y of a rotary axis.
    LocationEy: "location.EY0*_um";
    /// Offset in Z of a rotary axis.
    LocationEz: "location.EZ0*_um";
    /// Tilt about X of a rotary axis.
    LocationEa: "location.EA0*_urad";
    /// Tilt about Y of a rotary axis.
    LocationEb: "location.EB0*_urad";
    /// Tilt about Z of a rotary axis.
    LocationEc: "location.EC0*_urad";
    /// Error table.
    Table: "axis.*.table";
    /// Declared travel.
    Travel: "axis.*.travel_mm" | "axis.*.travel_deg";
    /// Range of the joint.
    Joint: "axis.*.joint_mm" | "axis.*.joint_deg";
    /// Line of measurement.
    MeasuredAt: "axis.*.measured_at_mm";
    /// Origin of an axis' frame.
    Offset: "axis.*.offset_mm";
    /// Highest feed.
    MaxFeed: "axis.*.max_feed_mm_per_min" | "axis.*.max_feed_deg_per_min";
    /// Sense of a rotary axis.
    Direction: "axis.*.direction";
    /// Backlash.
    Backlash: "axis.*.backlash_um" | "axis.*.backlash_urad";
    /// Reversal hysteresis.
    Hysteresis: "axis.*.hysteresis_um" | "axis.*.hysteresis_urad";
    /// Step of the axis' encoder.
    EncoderResolution: "axis.*.encoder_resolution_um" | "axis.*.encoder_resolution_urad";
    /// Magnitude limit of the correction.
    Magnitude: "axis.*.limits.magnitude_um" | "axis.*.limits.magnitude_urad";
    /// Slope limit of the correction.
    Slope: "axis.*.limits.slope_mm_per_s" | "axis.*.limits.slope_deg_per_s";
    /// Acceleration limit of the correction.
    Acceleration: "axis.*.limits.acceleration_mm_per_s2" | "axis.*.limits.acceleration_deg_per_s2";
    /// Thermal growth, uniform along the axis.
    ThermalOffset: "axis.*.thermal.offset_um_per_k" | "axis.*.thermal.offset_urad_per_k";
    /// Thermal growth in proportion to the distance from the datum.
    ThermalExpansion: "axis.*.thermal.expansion_um_per_m_k" | "axis.*.thermal.expansion_urad_per_rad_k";
    /// Datum of the thermal growth.
    ThermalDatum: "axis.*.thermal.datum_mm" | "axis.*.thermal.datum_deg";
    /// Gain of the position loop.
    PositionGain: "axis.*.drive.position_gain_per_s";
    /// Gain of the velocity loop.
    VelocityGain: "axis.*.drive.velocity_gain_per_s";
    /// Reset time of the velocity loop.
    ResetTime: "axis.*.drive.reset_time_s";
    /// Share of the velocity that is fed forward.
    VelocityAhead: "axis.*.drive.velocity_feed_forward";
    /// Time constant of the current loop.
    CurrentLoop: "axis.*.drive.current_loop_s";
    /// Dead time of the drive.
    DeadTime: "axis.*.drive.dead_time_s";
    /// Friction as a whole.
    Friction: "axis.*.friction";
    /// Coulomb friction.
    Coulomb: "axis.*.friction.coulomb_mm_per_s" | "axis.*.friction.coulomb_deg_per_s";
    /// Pre-sliding.
    Presliding: "axis.*.friction.presliding_um" | "axis.*.friction.presliding_urad";
    /// Static friction above Coulomb friction.
    StribeckShare: "axis.*.friction.stribeck_share";
    /// Velocity at which half of that share remains.
    StribeckVelocity: "axis.*.friction.stribeck_velocity_mm_per_s" | "axis.*.friction.stribeck_velocity_deg_per_s";
    /// Viscous friction.
    Viscous: "axis.*.friction.viscous";
    /// Lead of the friction model.
    FrictionLead: "axis.*.friction.lead_s";
    /// Magnitude limit of the dynamic correction.
    DynamicMagnitude: "axis.*.dynamic.magnitude_um" | "axis.*.dynamic.magnitude_urad";
    /// Slope limit of the dynamic correction.
    DynamicSlope: "axis.*.dynamic.slope_mm_per_s" | "axis.*.dynamic.slope_deg_per_s";
    /// Acceleration limit of the dynamic correction.
    DynamicAcceleration: "axis.*.dynamic.acceleration_mm_per_s2" | "axis.*.dynamic.acceleration_deg_per_s2";
    /// Compensation of the following error.
    Lag: "axis.*.dynamic.lag";
    /// Feed-forward of the acceleration.
    AccelerationAhead: "axis.*.dynamic.acceleration";
    /// Distance from the held position within which a linear axis resumes.
    ResumeMm: "faults.resume_mm";
    /// Distance from the held position within which a rotary axis resumes.
    ResumeDeg: "faults.resume_deg";
    /// Largest change of a linear encoder in a cycle.
    FeedbackJumpMm: "faults.feedback_jump_mm";
    /// Largest change of a rotary encoder in a cycle.
    FeedbackJumpDeg: "faults.feedback_jump_deg";
    /// Commanded distance after which a linear encoder must have moved.
    StuckMm: "faults.stuck_mm";
    /// Commanded distance after which a rotary encoder must have moved.
    StuckDeg: "faults.stuck_deg";
    /// Largest change of a command, as a multiple of the travel at the highest feed.
    CommandJumpFactor: "faults.command_jump_factor";
    /// Largest lag of the contour search.
    MaxLag: "contour.max_lag_mm";
    /// Contour feedback as a whole.
    Feedback: "contour.feedback";
    /// Proportional gain of the contour feedback.
    Proportional: "contour.feedback.proportional";
    /// Integral gain of the contour feedback.
    Integral: "contour.feedback.integral_per_s";
    /// Fastest motion with contour feedback.
    FeedbackFeed: "contour.feedback.max_feed_mm_per_min";
    /// Contour error above which the watch detects oscillations.
    Watch: "contour.feedback.watch_um";
    /// Axis along which cross-talk moves the tip.
    CrosstalkTip: "crosstalk.tip";
    /// Axis that accelerates.
    CrosstalkFrom: "crosstalk.from";
    /// Axis on whose position a cross-talk depends.
    CrosstalkOver: "crosstalk.over";
    /// Points of a cross-talk.
    CrosstalkTable: "crosstalk.table";
    /// Constant cross-talk; the unit depends on the axis that accelerates.
    CrosstalkConstant: "crosstalk.k_um_per_m_per_s2" | "crosstalk.k_um_per_deg_per_s2";
    /// Model of the errors.
    Model: "compensation.model";
    /// Errors on a grid.
    GridTable: "grid.table";
    /// Axes over which a grid extends.
    GridAxes: "grid.axes";
    /// Heights between which a grid fades.
    GridFade: "grid.fade_mm";
    /// Position of the other axes at which a grid was measured.
    GridMeasuredAt: "grid.measured_at_mm";
    /// Resolution of a grid's errors.
    GridResolution: "grid.resolution_um";
    /// Fading of the correction of the tool's direction.
    Fade: "compensation.fade_deg";
    /// Direction of the tool.
    ToolAxis: "kinematics.tool_axis";
    /// Singular cone.
    SingularCone: "kinematics.singular_cone_deg";
    /// Points of a revolution.
    Points: "roundness.points";
    /// Band of harmonics.
    Harmonics: "roundness.harmonics";
    /// Slots between the probes.
    ProbeSlots: "roundness.probe_slots";
    /// Angles between the probes.
    ProbeAngles: "roundness.probe_angles_deg";
    /// Noise gain from which harmonics are suppressed.
    NoiseGain: "roundness.noise_gain_limit";
    /// Gain of a probe.
    ProbeGain: "roundness.probe_gain_um";
    /// Zero of a probe.
    ProbeZero: "roundness.probe_zero";
    /// Low end of a probe's range.
    ProbeLow: "roundness.probe_low";
    /// High end of a probe's range.
    ProbeHigh: "roundness.probe_high";
    /// Counts of the spindle's encoder.
    SpindleCounts: "roundness.spindle_counts_per_revolution";
    /// Sense of the spindle's encoder.
    SpindleDirection: "roundness.spindle_direction";
    /// Tolerance of the index pulse.
    SpindleIndexTolerance: "roundness.spindle_index_tolerance_counts";
    /// Time after which the spindle counts as stopped.
    Stop: "roundness.stop_s";
    /// Gaussian filter.
    Filter: "roundness.filter_upr";
    /// Revolutions of an evaluation of the spindle.
    Revolutions: "roundness.revolutions";
    /// Slices of an evaluation in a cycle.
    UnitsPerCycle: "roundness.units_per_cycle";
    /// Crank throw of the following arm.
    ArmCrank: "roundness.arm.crank_mm";
    /// Wheel radius of the following arm.
    ArmWheel: "roundness.arm.wheel_mm";
    /// Pin radius of the following arm.
    ArmPin: "roundness.arm.pin_mm";
    /// Counts of the arm's encoder.
    ArmCounts: "roundness.arm.counts_per_revolution";
    /// Sense of the arm's encoder.
    ArmDirection: "roundness.arm.direction";
    /// Tolerance of the arm's angle.
    ArmTolerance: "roundness.arm.tolerance_deg";
    /// Axis of the infeed correction.
    InfeedAxis: "roundness.infeed.axis";
    /// Sense of the infeed correction.
    InfeedDirection: "roundness.infeed.direction";
    /// Harmonics of the infeed correction.
    InfeedHarmonics: "roundness.infeed.harmonics";
    /// Gain of the infeed correction.
    InfeedGain: "roundness.infeed.gain";
    /// Delay of the infeed correction.
    InfeedDelay: "roundness.infeed.delay_revolutions";
    /// Angle of contact.
    InfeedContact: "roundness.infeed.contact_deg";
    /// Delay of the infeed drive.
    InfeedDriveDelay: "roundness.infeed.drive_delay_s";
    /// Limit of the infeed correction.
    InfeedLimit: "roundness.infeed.limit_um";
    /// Noise gain limit of the infeed correction.
    InfeedNoiseGain: "roundness.infeed.noise_gain_limit";
    /// Servo period of the host.
    Period;
    /// Exact inverse: all tables together.
    Inverse;
    /// Scale or offset of an encoder of the host.
    Encoder;
    /// Memory lent for the tables.
    Memory;
    /// Plane or spacing of a command window.
    CommandWindow;
    /// Lag that all axes compensate in common.
    CommonLag: "axis.*.dynamic.lag_s";
    /// Resonance of an axis.
    Resonance: "axis.*.drive.resonance_hz";
    /// Damping of the resonance of an axis.
    ResonanceDamping: "axis.*.drive.resonance_damping";
    /// Frequency below which an axis has no resonance.
    LowestResonance: "axis.*.drive.lowest_resonance_hz";
    /// Interval in which the friction adapts.
    FrictionAdapt: "axis.*.friction.adapt";
    /// Period of an axis' own error.
    PeriodLength: "axis.*.periodic.period_mm" | "axis.*.periodic.period_deg";
    /// Harmonics of a period.
    PeriodHarmonics: "axis.*.periodic.harmonics_um" | "axis.*.periodic.harmonics_urad";
    /// Harmonics of a period in negative travel.
    PeriodReverse: "axis.*.periodic.reverse_um" | "axis.*.periodic.reverse_urad";
}
