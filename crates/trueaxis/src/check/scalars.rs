//! Checks every scalar of a machine against its physical range.

use crate::error::{ConfigError, Field};
use crate::machine::{
    Axis, AxisServo, AxisSettings, CompensationSettings, ContourSettings, CrosstalkSettings, DriveFigures,
    DynamicSettings, FaultSettings, FeedbackSettings, FrictionSettings, KinematicsSettings, Limits, LocationErrors,
    MachineSettings, PeriodicSettings, ThermalGrowth,
};
use crate::range::{
    ACCELERATION, ADAPT, BACKLASH, COMMON_LAG, COULOMB, CROSSTALK, CURRENT_LOOP, DEAD_TIME, ENCODER_STEP, EXPANSION,
    FADE, FEED, FEEDBACK_GAIN, FEEDBACK_INTEGRAL, GAIN_WITHOUT_NOTCH, HYSTERESIS, JOINT, JUMP_FACTOR, LAG, LENGTH,
    MAGNITUDE, PERIOD, PLAUSIBLE, POSITION, POSITION_GAIN, PRESLIDING, RESET_TIME, RESONANCE, RESONANCE_DAMPING,
    ROTATION, SHARE, SINGULAR_CONE, SLOPE, STRIBECK_SHARE, STRIBECK_VELOCITY, TEMPERATURE, THERMAL_OFFSET, TOOL_AXIS,
    TRANSLATION, VELOCITY_GAIN, VISCOUS, WATCH,
};

/// Checks every scalar of a machine; [`gauge`] checks the gauge's. A new field does not compile until it is listed here.
pub(super) fn machine(machine: &MachineSettings) -> Result<(), ConfigError> {
    let MachineSettings {
        name: _,
        chain: _,
        tool_mm,
        reference_temperature_c,
        location,
        faults,
        contour: ContourSettings { max_lag_mm, feedback },
        compensation: CompensationSettings { model: _, orientation: _, fade_deg },
        kinematics: KinematicsSettings { tool_axis, singular_cone_deg },
        axes,
        roundness: _,
        crosstalk,
        periodic,
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
    axes.iter().try_for_each(of_axis)?;
    feedback.as_ref().map_or(Ok(()), of_feedback)?;
    crosstalk.iter().enumerate().try_for_each(|(index, entry)| of_crosstalk(entry).map_err(|error| error.at(index)))?;
    for (index, entry) in periodic.iter().enumerate() {
        let number = periodic.iter().take(index).filter(|other| other.axis == entry.axis).count();
        of_period(entry).map_err(|error| error.at(number))?;
    }
    Ok(())
}

fn of_axis(settings: &AxisSettings) -> Result<(), ConfigError> {
    let AxisSettings {
        axis,
        interpolation: _,
        lookup: _,
        cross_lookup: _,
        // One of two values, checked with the axes.
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
        servo,
    } = settings;
    let (axis, on) = (*axis, Some(*axis));
    POSITION.of(axis).all(travel, Field::Travel, on)?;
    LENGTH.all(offset_mm, Field::Offset, on)?;
    LENGTH.all(measured_at_mm, Field::MeasuredAt, on)?;
    FEED.of(axis).check(*max_feed_per_s, Field::MaxFeed, on)?;
    // Before the joint, whose default is the travel widened by this limit.
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
    POSITION.of(axis).check(*datum, Field::ThermalDatum, on)?;
    of_servo(servo, axis)
}

fn of_servo(servo: &AxisServo, axis: Axis) -> Result<(), ConfigError> {
    let (AxisServo { drive, friction, dynamic }, on) = (servo, Some(axis));
    if let Some(drive) = drive {
        let DriveFigures {
            position_gain_per_s,
            velocity_gain_per_s,
            reset_time_s,
            velocity_feed_forward,
            current_loop_s,
            dead_time_s,
            resonance_hz,
            resonance_damping,
            lowest_resonance_hz,
            gain_without_notch,
        } = drive;
        POSITION_GAIN.check(*position_gain_per_s, Field::PositionGain, on)?;
        VELOCITY_GAIN.check(*velocity_gain_per_s, Field::VelocityGain, on)?;
        RESET_TIME.check(*reset_time_s, Field::ResetTime, on)?;
        SHARE.check(*velocity_feed_forward, Field::VelocityAhead, on)?;
        CURRENT_LOOP.check(*current_loop_s, Field::CurrentLoop, on)?;
        DEAD_TIME.check(*dead_time_s, Field::DeadTime, on)?;
        for (range, figure, field) in [
            (RESONANCE, resonance_hz, Field::Resonance),
            (RESONANCE_DAMPING, resonance_damping, Field::ResonanceDamping),
            (RESONANCE, lowest_resonance_hz, Field::LowestResonance),
        ] {
            // 0: not stated.
            if *figure != 0.0 {
                range.check(*figure, field, on)?;
            }
        }
        GAIN_WITHOUT_NOTCH.check(*gain_without_notch, Field::Resonance, on)?;
    }
    if let Some(friction) = friction {
        let FrictionSettings {
            coulomb_per_s,
            stribeck_share,
            stribeck_velocity_per_s,
            presliding,
            viscous,
            lead_s,
            adapt,
        } = friction;
        COULOMB.of(axis).check(*coulomb_per_s, Field::Coulomb, on)?;
        STRIBECK_SHARE.check(*stribeck_share, Field::StribeckShare, on)?;
        STRIBECK_VELOCITY.of(axis).check(*stribeck_velocity_per_s, Field::StribeckVelocity, on)?;
        PRESLIDING.of(axis).check(*presliding, Field::Presliding, on)?;
        VISCOUS.check(*viscous, Field::Viscous, on)?;
        DEAD_TIME.check(*lead_s, Field::FrictionLead, on)?;
        ADAPT.check(*adapt, Field::FrictionAdapt, on)?;
    }
    let Some(DynamicSettings { limits, lag: _, acceleration: _, take_up: _, lag_s }) = dynamic else { return Ok(()) };
    let Limits { magnitude, slope_per_s, acceleration_per_s2 } = limits;
    COMMON_LAG.check(*lag_s, Field::CommonLag, on)?;
    MAGNITUDE.of(axis).check(*magnitude, Field::DynamicMagnitude, on)?;
    SLOPE.of(axis).check(*slope_per_s, Field::DynamicSlope, on)?;
    ACCELERATION.of(axis).check(*acceleration_per_s2, Field::DynamicAcceleration, on)
}

fn of_feedback(feedback: &FeedbackSettings) -> Result<(), ConfigError> {
    let FeedbackSettings { proportional, integral_per_s, max_feed_per_s, watch_mm } = feedback;
    FEEDBACK_GAIN.check(*proportional, Field::Proportional, None)?;
    FEEDBACK_INTEGRAL.check(*integral_per_s, Field::Integral, None)?;
    FEED.linear.check(*max_feed_per_s, Field::FeedbackFeed, None)?;
    WATCH.check(*watch_mm, Field::Watch, None)
}

fn of_crosstalk(entry: &CrosstalkSettings) -> Result<(), ConfigError> {
    // The axes of an entry are checked where those of the machine are known.
    let CrosstalkSettings { tip: _, from, over, points } = entry;
    let field = if points.len() == 1 { Field::CrosstalkConstant } else { Field::CrosstalkTable };
    points.iter().try_for_each(|[position, k]| {
        POSITION.of(*over).check(*position, Field::CrosstalkTable, None)?;
        CROSSTALK.of(*from).check(*k, field, Some(*from))
    })
}

fn of_period(entry: &PeriodicSettings) -> Result<(), ConfigError> {
    let PeriodicSettings { axis, period, harmonics, reverse } = entry;
    let on = Some(*axis);
    PERIOD.of(*axis).check(*period, Field::PeriodLength, on)?;
    for (list, field) in [(harmonics, Field::PeriodHarmonics), (reverse, Field::PeriodReverse)] {
        list.iter().flatten().try_for_each(|figure| BACKLASH.of(*axis).check(*figure, field, on))?;
    }
    Ok(())
}
