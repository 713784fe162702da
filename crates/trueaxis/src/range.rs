//! The physical range of every scalar in a machine's description: one list for the bench and the controller.
//!
//! A value outside its range indicates a slip of unit (mm written as µm, degrees as µrad), of a sign or a decimal, or a
//! damaged file, not a real machine. Ranges are generous: several times the values of the worst machine in service. They
//! are in the units of the core (mm, degrees, rad, s); the texts also name the units of the files.

use crate::axis::Axis;
use crate::error::{ConfigError, Field};
use crate::part;

/// A range, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// The range in words, with the unit of the files.
    pub needed: &'static str,
}

impl Range {
    const fn new(least: f64, most: f64, needed: &'static str) -> Range {
        Range { least, most, needed: part::text(needed) }
    }

    /// Whether a value lies in the range; `false` for NaN.
    pub const fn contains(&self, value: f64) -> bool {
        value >= self.least && value <= self.most
    }

    /// Refuses a value outside the range.
    ///
    /// # Errors
    /// The value found, with the range as the one needed.
    pub fn check(&self, value: f64, field: Field, axis: Option<Axis>) -> Result<(), ConfigError> {
        if self.contains(value) {
            return Ok(());
        }
        Err(ConfigError { axis, ..ConfigError::new(field, value, self.needed) })
    }

    pub(crate) fn all(&self, values: &[f64], field: Field, axis: Option<Axis>) -> Result<(), ConfigError> {
        values.iter().enumerate().try_for_each(|(index, value)| {
            self.check(*value, field, axis).map_err(|error| if values.len() > 1 { error.at(index) } else { error })
        })
    }
}

/// Pair of ranges for a quantity measured in mm on linear axes and degrees on rotary axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByKind {
    /// X, Y, Z.
    pub linear: Range,
    /// A, B, C.
    pub rotary: Range,
}

impl ByKind {
    const fn new(linear: Range, rotary: Range) -> ByKind {
        ByKind { linear, rotary }
    }

    /// The range for an axis.
    pub const fn of(&self, axis: Axis) -> &Range {
        if axis.is_rotary() { &self.rotary } else { &self.linear }
    }
}

const fn degrees(urad: f64) -> f64 {
    (urad / 1e6).to_degrees()
}

/// Positions: travel, lines of a table, the datum of thermal growth. A kilometre exceeds the longest gantry; 1e9 degrees,
/// the limit of an axis without a declared travel, are two months of a spindle at 30 rpm.
pub const POSITION: ByKind =
    ByKind::new(Range::new(-1e6, 1e6, "-1e6 to 1e6 mm"), Range::new(-1e9, 1e9, "-1e9 to 1e9 degrees"));
/// The joint: a travel plus the largest correction on either side.
pub const JOINT: ByKind = ByKind::new(
    Range::new(-1_000_010.0, 1_000_010.0, "-1000010 to 1000010 mm"),
    Range::new(-1_000_000_010.0, 1_000_000_010.0, "-1000000010 to 1000000010 degrees"),
);
/// Lengths between the parts of a machine: tool, offsets of frames, position of measurement.
pub const LENGTH: Range = Range::new(-1e6, 1e6, "-1e6 to 1e6 mm");
/// Distance between two lines of a table, mm or degrees: a micrometre, finer than any instrument sets.
pub const LEAST_PITCH: f64 = 1e-3;
/// A translation in a table, and a location error. Corrected machines have some 0.3 mm at most; above 1 mm the unit is
/// wrong (3.1 µm written as 3,100) or the machine is.
pub const TRANSLATION: Range = Range::new(-1.0, 1.0, "-1000 to 1000 um (1 mm; is the unit right?)");
/// A translation at a node of a grid: a printer's bed is a few millimetres off before its Z offset is set. Equals the
/// largest magnitude limit.
pub const GRID_TRANSLATION: Range = Range::new(-10.0, 10.0, "-10000 to 10000 um (10 mm; is the unit right?)");
/// A rotation in a table, and a squareness: 10 mrad are 10 mm on a metre, a hundred times what standards permit.
pub const ROTATION: Range = Range::new(-0.01, 0.01, "-10000 to 10000 urad (10 mrad; is the unit right?)");
/// Value of a stored 1 of a grid: a thousandth of a nanometre to a micrometre, with which 16 bits hold 33 mm.
pub const GRID_STEP: Range = Range::new(1e-6 / 1e3, 1.0 / 1e3, "a resolution of 1e-6 to 1 um");
/// Value of a stored 1 of a grid, for a rotation.
pub const GRID_TURN: Range = Range::new(1e-6 / 1e6, 1.0 / 1e6, "a resolution of 1e-6 to 1 urad");
/// Lost motion: worn screws have 0.2 mm, worn worms 5 mrad. Negative if a drive itself overcompensates it.
pub const BACKLASH: ByKind = ByKind::new(
    Range::new(-1.0, 1.0, "-1000 to 1000 um (1 mm; is the unit right?)"),
    Range::new(degrees(-10_000.0), degrees(10_000.0), "-10000 to 10000 urad (10 mrad; is the unit right?)"),
);
/// Distance back that counts as a reversal: some counts of an encoder plus the noise of a command.
pub const HYSTERESIS: ByKind = ByKind::new(
    Range::new(0.0, 0.1, "0 to 100 um (0.1 mm)"),
    Range::new(0.0, degrees(2_000.0), "0 to 2000 urad (0.11 degrees)"),
);
/// Magnitude limit of the correction: ten times the largest value of an axis table, the largest of a grid; at least a
/// nanometre.
pub const MAGNITUDE: ByKind = ByKind::new(
    Range::new(1e-6, 10.0, "0.001 to 10000 um (10 mm)"),
    Range::new(degrees(0.001), degrees(100_000.0), "0.001 to 100000 urad (5.7 degrees)"),
);
/// Slope limit of the correction: up to 1 m/s, faster than most axes.
pub const SLOPE: ByKind =
    ByKind::new(Range::new(1e-6, 1e3, "1e-6 to 1000 mm/s"), Range::new(1e-6, 1e3, "1e-6 to 1000 degrees/s"));
/// Acceleration limit of the correction: up to 1 km/s², a hundred times gravity.
pub const ACCELERATION: ByKind =
    ByKind::new(Range::new(1e-3, 1e6, "0.001 to 1e6 mm/s2"), Range::new(1e-3, 1e6, "0.001 to 1e6 degrees/s2"));
/// Highest feed, per second: up to 16.7 m/s, three times that of a linear motor, and 27,778 rpm, as for a fast spindle.
pub const FEED: ByKind = ByKind::new(
    Range::new(1e-3 / 60.0, 1e6 / 60.0, "0.001 to 1e6 mm/min"),
    Range::new(1e-3 / 60.0, 1e7 / 60.0, "0.001 to 1e7 degrees/min"),
);
/// Step of an encoder: a hundredth of a nanometre to a millimetre; the same numbers in degrees.
pub const ENCODER_STEP: ByKind = ByKind::new(
    Range::new(1e-8, 1.0, "0.00001 to 1000 um"),
    Range::new(degrees(1e-5), degrees(2e4), "0.00001 to 20000 urad"),
);
/// Thermal shift per kelvin: 0.1 mm corresponds to 9 m of steel.
pub const THERMAL_OFFSET: ByKind = ByKind::new(
    Range::new(-0.1, 0.1, "-100 to 100 um/K"),
    Range::new(degrees(-1_000.0), degrees(1_000.0), "-1000 to 1000 urad/K"),
);
/// Expansion: steel has 11.5 µm/(m K), aluminium 23, plastics 200.
pub const EXPANSION: Range = Range::new(-1e-3, 1e-3, "-1000 to 1000 millionths per K");
/// Temperature at which tables are valid: from a cold store to a hall or an oven.
pub const TEMPERATURE: Range = Range::new(-50.0, 150.0, "-50 to 150 degrees Celsius");
/// Plausible jumps, the stuck distance, the resume distance, mm or degrees: a nanometre to a metre.
pub const PLAUSIBLE: Range = Range::new(1e-6, 1e3, "1e-6 to 1000 mm or degrees");
/// Command jump as a multiple of the travel at the highest feed.
pub const JUMP_FACTOR: Range = Range::new(1.0, 1e3, "a factor of 1 to 1000");
/// Half-window of the contour search: the range that the search accepts.
pub const LAG: Range = Range::new(1e-3, 1e3, "a max_lag_mm of 0.001 to 1000 mm");
/// Cone in which the correction of the direction fades: up to half a right angle.
pub const FADE: Range = Range::new(0.0, 45.0, "a fade_deg of 0 to 45 degrees");
/// Cone around the singular pose: up to half a right angle.
pub const SINGULAR_CONE: Range = Range::new(0.0, 45.0, "a singular_cone_deg of 0 to 45 degrees");
/// Gain of a position loop: large machines have 10/s, linear motors 500.
pub const POSITION_GAIN: Range = Range::new(0.1, 1e4, "a gain of 0.1 to 10000 1/s");
/// Gain of a velocity loop, acceleration per velocity.
pub const VELOCITY_GAIN: Range = Range::new(1.0, 1e6, "a gain of 1 to 1e6 1/s");
/// Reset time of a velocity loop; a long one if it has no integrator.
pub const RESET_TIME: Range = Range::new(1e-5, 1e3, "a time of 0.00001 to 1000 s");
/// Time constant of a current loop.
pub const CURRENT_LOOP: Range = Range::new(1e-6, 0.1, "a time of 1e-6 to 0.1 s");
/// Dead time of a drive, and the lead of a friction model.
pub const DEAD_TIME: Range = Range::new(0.0, 0.1, "a time of 0 to 0.1 s");
/// Lag that all axes compensate in common: that of the slowest position loop at most.
pub const COMMON_LAG: Range = Range::new(0.0, 10.0, "a lag of 0 to 10 s");
/// Resonance of an axis: a large gantry has some hertz, a linear motor some hundred.
pub const RESONANCE: Range = Range::new(1.0, 1e4, "a frequency of 1 to 10000 Hz");
/// Factor on the gains of the contour feedback without a notch at the resonance.
pub const GAIN_WITHOUT_NOTCH: Range = Range::new(0.0, 1e3, "a factor of 0 to 1000 on the gains without a notch");
/// Damping of a resonance, share of critical.
pub const RESONANCE_DAMPING: Range = Range::new(1e-3, 0.9, "a share of critical damping of 0.001 to 0.9");
/// Share of a velocity that is fed forward.
pub const SHARE: Range = Range::new(0.0, 1.0, "a share of 0 to 1");
/// Coulomb friction over the gain of the velocity loop: a velocity.
pub const COULOMB: ByKind =
    ByKind::new(Range::new(0.0, 1e3, "0 to 1000 mm/s"), Range::new(0.0, 1e3, "0 to 1000 degrees/s"));
/// Static friction above Coulomb friction, as a share of it.
pub const STRIBECK_SHARE: Range = Range::new(0.0, 10.0, "a share of 0 to 10");
/// Share of its identified figures by which friction adapts; beyond the end of it, no pre-sliding would be left.
pub const ADAPT: Range = Range::new(
    0.0,
    0.9,
    "a share of 0 (off) to 0.9 by which the figures may leave the identified ones, so that these lie in the interval",
);
/// Velocity at which half of that share remains.
pub const STRIBECK_VELOCITY: ByKind =
    ByKind::new(Range::new(1e-3, 1e3, "0.001 to 1000 mm/s"), Range::new(1e-3, 1e3, "0.001 to 1000 degrees/s"));
/// Travel over which friction reverses: micrometres; some hundred if a belt or a long screw yields.
pub const PRESLIDING: ByKind = ByKind::new(
    Range::new(1e-5, 1.0, "0.01 to 1000 um"),
    Range::new(degrees(0.01), degrees(20_000.0), "0.01 to 20000 urad"),
);
/// Viscous friction over the gain of the velocity loop.
pub const VISCOUS: Range = Range::new(0.0, 10.0, "0 to 10");
/// Proportional gain of the contour feedback.
pub const FEEDBACK_GAIN: Range = Range::new(0.0, 10.0, "a gain of 0 to 10");
/// Integral gain of the contour feedback.
pub const FEEDBACK_INTEGRAL: Range = Range::new(0.0, 1e4, "a gain of 0 to 10000 1/s");
/// Contour error above which oscillation is detected: a nanometre to 10 mm.
pub const WATCH: Range = Range::new(1e-6, 10.0, "0.001 to 10000 um (10 mm)");
/// Cross-talk of an accelerating linear axis, s², and of a rotary one, mm per degree/s². A slender column has some µm per
/// m/s².
pub const CROSSTALK: ByKind = ByKind::new(
    Range::new(-1e-3, 1e-3, "-1000 to 1000 um per m/s2"),
    Range::new(-1.0, 1.0, "-1000 to 1000 um per degree/s2"),
);
/// Period of an axis' own error: from the step of a motor on a fine screw to longer than any rack's pitch.
pub const PERIOD: ByKind =
    ByKind::new(Range::new(0.01, 1e4, "0.01 to 10000 mm"), Range::new(1e-3, 360.0, "0.001 to 360 degrees"));
/// Components of the tool axis; its length is 1e-3 to 1e3.
pub const TOOL_AXIS: Range = Range::new(-1e3, 1e3, "-1000 to 1000");

/// Noise gain from which a harmonic is omitted: by Cauchy no gain is below 0.57.
pub const NOISE_GAIN: Range = Range::new(0.1, 1e6, "a noise gain limit of 0.1 to 1e6");
/// Size of a probe's gain, µm per unit: fractions of a nanometre per count to a metre per unit.
pub const PROBE_GAIN: Range = Range::new(1e-9, 1e6, "a gain of 1e-9 to 1e6 um per unit, or as much below 0");
/// Raw value of a probe: more than a 30-bit converter.
pub const PROBE_RAW: Range = Range::new(-1e9, 1e9, "-1e9 to 1e9");
/// Throw of a crank: 2 m in a ship's engine.
pub const CRANK: Range = Range::new(0.0, 1e4, "0 to 10000 mm");
/// Radius of a wheel or a pin.
pub const RADIUS: Range = Range::new(1e-3, 1e4, "0.001 to 10000 mm");
/// Difference between an arm's reading and the linkage.
pub const ARM_TOLERANCE: Range = Range::new(1e-6, 90.0, "a tolerance of 1e-6 to 90 degrees");
/// Time after which a spindle counts as stopped.
pub const STOP: Range = Range::new(1e-3, 60.0, "a time of 0.001 to 60 s");
/// Angles between probes, and from a probe to the wheel: up to a turn in either direction.
pub const ANGLE: Range = Range::new(-360.0, 360.0, "-360 to 360 degrees");
/// Delay of a drive.
pub const DRIVE_DELAY: Range = Range::new(0.0, 0.1, "a delay of 0 to 0.1 s");
/// Largest infeed correction: a nanometre to 10 mm.
pub const INFEED: Range = Range::new(1e-3, 1e4, "a limit of 0.001 to 10000 um");
/// Gain of the infeed law, below its stability limit.
pub const INFEED_GAIN: Range = Range::new(1e-6, 1.0, "a gain of 1e-6 to 1");
