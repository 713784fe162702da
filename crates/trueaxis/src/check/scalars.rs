//! Every scalar of a machine in its physical range.

use crate::error::{ConfigError, Field};
use crate::machine::{
    Axis, AxisSettings, CompensationSettings, ContourSettings, FaultSettings, KinematicsSettings, Limits,
    LocationErrors, MachineSettings, ThermalGrowth,
};
use crate::range::{
    ACCELERATION, BACKLASH, ENCODER_STEP, EXPANSION, FADE, FEED, HYSTERESIS, JOINT, JUMP_FACTOR, LAG, LENGTH,
    MAGNITUDE, PLAUSIBLE, POSITION, ROTATION, SINGULAR_CONE, SLOPE, TEMPERATURE, THERMAL_OFFSET, TOOL_AXIS,
    TRANSLATION,
};

/// Every scalar of a machine, the gauge's by [`gauge`]. No field is left out: a new one does not compile before it is here.
pub(super) fn machine(machine: &MachineSettings) -> Result<(), ConfigError> {
    let MachineSettings {
        name: _,
        chain: _,
        tool_mm,
        reference_temperature_c,
        location,
        faults,
        contour: ContourSettings { max_lag_mm, feedback: _ },
        compensation: CompensationSettings { model: _, orientation: _, fade_deg },
        kinematics: KinematicsSettings { tool_axis, singular_cone_deg },
        axes,
        roundness: _,
        crosstalk: _,
    } = machine;
    LENGTH.all(tool_mm, Field::Tool, None)?;
    TEMPERATURE.check(*reference_temperature_c, Field::ReferenceTemperature, None)?;
    let LocationErrors { a0z, b0z, c0y, rotary } = location;
    for (error, field) in [(a0z, Field::LocationA0Z), (b0z, Field::LocationB0Z), (c0y, Field::LocationC0Y)] {
        ROTATION.check(*error, field, None)?;
    }
    for ([ex, ey, ez, ea, eb, ec], axis) in rotary.iter().zip([Axis::A, Axis::B, Axis::C]) {
        for (error, field) in [(ex, Field::LocationEx), (ey, Field::LocationEy), (ez, Field::LocationEz)] {
            TRANSLATION.check(*error, field, Some(axis))?;
        }
        for (error, field) in [(ea, Field::LocationEa), (eb, Field::LocationEb), (ec, Field::LocationEc)] {
            ROTATION.check(*error, field, Some(axis))?;
        }
    }
    let FaultSettings { resume, command_jump_factor, feedback_jump, stuck } = faults;
    for ([mm, deg], in_mm, in_deg) in [
        (resume, Field::ResumeMm, Field::ResumeDeg),
        (feedback_jump, Field::FeedbackJumpMm, Field::FeedbackJumpDeg),
        (stuck, Field::StuckMm, Field::StuckDeg),
    ] {
        PLAUSIBLE.check(*mm, in_mm, None)?;
        PLAUSIBLE.check(*deg, in_deg, None)?;
    }
    JUMP_FACTOR.check(*command_jump_factor, Field::CommandJumpFactor, None)?;
    LAG.check(*max_lag_mm, Field::MaxLag, None)?;
    FADE.check(*fade_deg, Field::Fade, None)?;
    TOOL_AXIS.all(tool_axis, Field::ToolAxis, None)?;
    SINGULAR_CONE.check(*singular_cone_deg, Field::SingularCone, None)?;
    axes.iter().try_for_each(of_axis)
}

fn of_axis(settings: &AxisSettings) -> Result<(), ConfigError> {
    let AxisSettings {
        axis,
        interpolation: _,
        lookup: _,
        cross_lookup: _,
        // One of two words, checked where axes are.
        direction: _,
        travel,
        joint,
        offset_mm,
        measured_at_mm,
        max_feed_per_s,
        backlash,
        hysteresis,
        encoder_resolution,
        limits: Limits { magnitude, slope_per_s, acceleration_per_s2 },
        thermal: ThermalGrowth { offset_per_k, expansion_per_k, datum },
        servo: _,
    } = settings;
    let (axis, on) = (*axis, Some(*axis));
    POSITION.of(axis).all(travel, Field::Travel, on)?;
    LENGTH.all(offset_mm, Field::Offset, on)?;
    LENGTH.all(measured_at_mm, Field::MeasuredAt, on)?;
    FEED.of(axis).check(*max_feed_per_s, Field::MaxFeed, on)?;
    // Before the joint, whose default is the travel widened by it.
    MAGNITUDE.of(axis).check(*magnitude, Field::Magnitude, on)?;
    SLOPE.of(axis).check(*slope_per_s, Field::Slope, on)?;
    ACCELERATION.of(axis).check(*acceleration_per_s2, Field::Acceleration, on)?;
    JOINT.of(axis).all(joint, Field::Joint, on)?;
    BACKLASH.of(axis).check(*backlash, Field::Backlash, on)?;
    HYSTERESIS.of(axis).check(*hysteresis, Field::Hysteresis, on)?;
    if let Some(step) = encoder_resolution {
        ENCODER_STEP.of(axis).check(*step, Field::EncoderResolution, on)?;
    }
    THERMAL_OFFSET.of(axis).check(*offset_per_k, Field::ThermalOffset, on)?;
    EXPANSION.check(*expansion_per_k, Field::ThermalExpansion, on)?;
    POSITION.of(axis).check(*datum, Field::ThermalDatum, on)
}
