//! Settings of a gauge of three probes.

use super::angles::{Band, Gain, ProbeAngles};
use super::arm::Arm;
use super::filter;
use crate::axis::Axis;
use crate::error::{ConfigError, Field};
use crate::range::{ANGLE, ARM_TOLERANCE, DRIVE_DELAY, INFEED, INFEED_GAIN, NOISE_GAIN, PROBE_GAIN, PROBE_RAW, STOP};

/// Default noise gain above which harmonics are suppressed.
pub const NOISE_GAIN_LIMIT: f64 = 100.0;
/// Fewest points of a revolution.
pub const FEWEST_POINTS: usize = 64;
/// Most points of a revolution.
pub const MOST_POINTS: usize = 4096;
/// Most counts of an encoder in a revolution.
pub const MOST_COUNTS: u32 = 1 << 28;

/// One displacement probe: reading in µm = gain · (raw − zero).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProbeSettings {
    /// µm per unit of the raw value; negative if the raw value falls as the surface approaches.
    pub gain_um: f64,
    /// Raw value at zero.
    pub zero: f64,
    /// Range of raw values that are accepted.
    pub range: [f64; 2],
}

impl Default for ProbeSettings {
    fn default() -> Self {
        ProbeSettings { gain_um: 1.0, zero: 0.0, range: [-1000.0, 1000.0] }
    }
}

/// Encoder of the spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SpindleEncoder {
    /// Counts per revolution of the workpiece, after quadrature.
    pub counts: u32,
    /// +1 if counts rise with θ, −1 otherwise.
    pub direction: i8,
    /// Whether the encoder has an index pulse, which marks α = 0; without one, α is zero where the count is zero.
    pub index: bool,
    /// An index pulse more than this many counts off its position is an error.
    pub index_tolerance: u32,
}

/// The following arm and its encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ArmSettings {
    /// Lengths of the linkage.
    pub lengths: Arm,
    /// Counts of the arm's encoder per full turn.
    pub counts: u32,
    /// +1 if counts rise with β.
    pub direction: i8,
    /// Largest permitted difference between the arm's reading and the linkage, degrees.
    pub tolerance_deg: f64,
}

/// Settings for the infeed correction of the next revolutions from the separated profile.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InfeedSettings {
    /// Axis that feeds in.
    pub axis: Axis,
    /// +1 if the axis moves toward the workpiece in positive direction.
    pub direction: i8,
    /// Harmonics that are corrected.
    pub band: Band,
    /// Gain g of the law c ← c + g r̂.
    pub gain: f64,
    /// D, revolutions from a change of the correction to the first update that observes it.
    pub delay_revolutions: u8,
    /// ψ, from probe 1 to the contact with the wheel, in the sense of θ, degrees.
    pub contact_deg: f64,
    /// τ, from the command to the motion of the drive, s; at most 0.1.
    pub drive_delay_s: f64,
    /// Largest |c|, µm; the command is c/cos β.
    pub limit_um: f64,
    /// Harmonics with a higher noise gain are measured, but not corrected.
    pub noise_gain_limit: f64,
}

/// Default noise gain above which harmonics are not corrected: changes of the surface during a revolution enter the
/// profile with that gain too.
pub const INFEED_NOISE_GAIN_LIMIT: f64 = 10.0;

/// Stability limit of the gain of an integrating law with D updates of delay: 2 sin(π/(2(2D + 1))).
///
/// c ← c + g r̂ with r̂ = d − c of D updates ago has the characteristic polynomial z^D (z − 1) + g, whose roots leave the unit
/// circle at this gain: 1, 0.618, 0.445 for D = 1, 2, 3.
pub fn gain_limit(delay_revolutions: u8) -> f64 {
    2.0 * libm::sin(core::f64::consts::PI / (2.0 * (2.0 * f64::from(delay_revolutions) + 1.0)))
}

/// A gauge of three probes at a turning workpiece.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GaugeSettings {
    /// Points of a revolution, a power of two from 64 to 4096.
    pub points: u16,
    /// Angles between the probes.
    pub angles: ProbeAngles,
    /// Harmonics of the profile that are separated; the others are treated as zero.
    pub band: Band,
    /// Harmonics with a higher noise gain are suppressed.
    pub noise_gain_limit: f64,
    /// Probes 1, 2, 3.
    pub probes: [ProbeSettings; 3],
    /// Encoder of the spindle.
    pub spindle: SpindleEncoder,
    /// Following arm; `None` for an ordinary shaft.
    pub arm: Option<ArmSettings>,
    /// Cut-off of the Gaussian filter applied before the evaluation of roundness, UPR.
    pub filter: Option<u16>,
    /// Revolutions over which synchronous and asynchronous motion of the spindle are separated.
    pub revolutions: u16,
    /// Slices of work done in a cycle.
    pub slices_per_cycle: u8,
    /// Time without passing a point after which the spindle counts as stopped, s.
    pub stop_s: f64,
    /// Infeed correction; `None` to measure only.
    pub infeed: Option<InfeedSettings>,
}

impl GaugeSettings {
    /// Returns the documented defaults: band 2 to 100 (or up to half the points), noise gain limit 100, probes of 1 µm per
    /// unit in ±1000, index pulse within a thousandth of a turn, eight revolutions, one slice per cycle, stopped after 1 s.
    pub fn with_defaults(points: u16, angles: ProbeAngles, counts: u32) -> Self {
        GaugeSettings {
            points,
            angles,
            band: Band { first: 2, last: 100.min((points / 2).saturating_sub(1)) },
            noise_gain_limit: NOISE_GAIN_LIMIT,
            probes: [ProbeSettings::default(); 3],
            spindle: SpindleEncoder { counts, direction: 1, index: true, index_tolerance: counts / 1000 + 1 },
            arm: None,
            filter: None,
            revolutions: 8,
            slices_per_cycle: 1,
            stop_s: 1.0,
            infeed: None,
        }
    }

    /// Checks everything and resolves the angles.
    ///
    /// # Errors
    /// The first setting that is wrong. For a harmonic in the band that the probes cannot see, the error names the angles or
    /// slots and the harmonic; [`Gain::singular`] lists all such harmonics.
    pub fn check(&self) -> Result<Gain, ConfigError> {
        let points = usize::from(self.points);
        let need = |holds: bool, field, found: f64, needed| {
            if holds { Ok(()) } else { Err(ConfigError::new(field, found, needed)) }
        };
        let power = points.is_power_of_two() && (FEWEST_POINTS..=MOST_POINTS).contains(&points);
        need(power, Field::Points, f64::from(self.points), "a power of two from 64 to 4096")?;
        self.band.check(points)?;
        let gain = self.angles.resolve(points)?;
        if let Some(harmonic) = gain.singular(self.band).next() {
            let needed = "angles that see every harmonic of the band";
            return Err(ConfigError::new(self.angles.field(), f64::from(harmonic), needed));
        }
        scalars(self)?;
        for (index, probe) in self.probes.iter().enumerate() {
            let [low, high] = probe.range;
            if low >= high {
                return Err(ConfigError::new(Field::ProbeHigh, high, "a range from low to high").at(index));
            }
        }
        encoder(self.spindle.counts, self.spindle.direction, [Field::SpindleCounts, Field::SpindleDirection])?;
        let counts = f64::from(self.spindle.counts);
        need(counts >= f64::from(self.points), Field::SpindleCounts, counts, "at least as many counts as points")?;
        let tolerance = self.spindle.index_tolerance;
        need(
            tolerance < self.spindle.counts / 4,
            Field::SpindleIndexTolerance,
            f64::from(tolerance),
            "an index tolerance below a quarter turn",
        )?;
        if let Some(arm) = &self.arm {
            let ratio = arm.lengths.ratio()?;
            let needed = "a crank throw R of at most 0.99 (R_S + R_W): the arm would turn by nearly 90°";
            need(ratio <= 0.99, Field::ArmCrank, arm.lengths.crank_mm, needed)?;
            encoder(arm.counts, arm.direction, [Field::ArmCounts, Field::ArmDirection])?;
        }
        self.filter.map_or(Ok(()), filter::check)?;
        let revolutions = f64::from(self.revolutions);
        need((1..=10_000).contains(&self.revolutions), Field::Revolutions, revolutions, "1 to 10,000 revolutions")?;
        let units = f64::from(self.slices_per_cycle);
        need((1..=16).contains(&self.slices_per_cycle), Field::UnitsPerCycle, units, "1 to 16 units per cycle")?;
        if let Some(infeed) = &self.infeed {
            infeed.check(points)?;
            for harmonic in [infeed.band.first, infeed.band.last] {
                let inside = self.band.contains(harmonic);
                need(inside, Field::InfeedHarmonics, f64::from(harmonic), "harmonics within those that are separated")?;
            }
        }
        Ok(gain)
    }
}

fn encoder(counts: u32, direction: i8, [of_counts, of_direction]: [Field; 2]) -> Result<(), ConfigError> {
    if !(1..=MOST_COUNTS).contains(&counts) {
        return Err(ConfigError::new(of_counts, f64::from(counts), "1 to 2^28 counts per revolution"));
    }
    if !matches!(direction, 1 | -1) {
        return Err(ConfigError::new(of_direction, f64::from(direction), "a direction of +1 or -1"));
    }
    Ok(())
}

impl InfeedSettings {
    /// Returns the documented defaults for an axis that moves toward the workpiece in positive direction: gain 0.25 with a
    /// delay of two revolutions, contact at 180°, a drive without delay, at most 20 µm, noise gain limit 10.
    pub fn with_defaults(axis: Axis, band: Band) -> Self {
        InfeedSettings {
            axis,
            direction: 1,
            band,
            gain: 0.25,
            delay_revolutions: 2,
            contact_deg: 180.0,
            drive_delay_s: 0.0,
            limit_um: 20.0,
            noise_gain_limit: INFEED_NOISE_GAIN_LIMIT,
        }
    }

    fn check(&self, points: usize) -> Result<(), ConfigError> {
        let need = |holds: bool, field, found: f64, needed| {
            if holds { Ok(()) } else { Err(ConfigError::new(field, found, needed)) }
        };
        need(!self.axis.is_rotary(), Field::InfeedAxis, self.axis.index() as f64, "a linear axis")?;
        need(
            matches!(self.direction, 1 | -1),
            Field::InfeedDirection,
            f64::from(self.direction),
            "a direction of +1 or -1",
        )?;
        self.band.check(points).map_err(|error| ConfigError { field: Field::InfeedHarmonics, ..error })?;
        // Interpolation between the slots uses four points: accurate enough up to an eighth of them.
        need(
            8 * usize::from(self.band.last) <= points,
            Field::InfeedHarmonics,
            f64::from(self.band.last),
            "harmonics up to N/8",
        )?;
        need(
            (1..=16).contains(&self.delay_revolutions),
            Field::InfeedDelay,
            f64::from(self.delay_revolutions),
            "a delay of 1 to 16 revolutions",
        )?;
        // Half the stability limit: a margin for effects that the process model omits.
        let most = 0.5 * gain_limit(self.delay_revolutions);
        need(self.gain <= most, Field::InfeedGain, self.gain, "a gain above 0 and at most sin(π/(2(2D + 1)))")
    }
}

/// Checks every scalar of a gauge except the whole numbers, which are checked separately.
fn scalars(settings: &GaugeSettings) -> Result<(), ConfigError> {
    let GaugeSettings {
        points: _,
        // Checked where they are resolved.
        angles: _,
        band: _,
        noise_gain_limit,
        probes,
        spindle: _,
        arm,
        filter: _,
        revolutions: _,
        slices_per_cycle: _,
        stop_s,
        infeed,
    } = settings;
    NOISE_GAIN.check(*noise_gain_limit, Field::NoiseGain, None)?;
    for (index, ProbeSettings { gain_um, zero, range: [low, high] }) in probes.iter().enumerate() {
        for (raw, field) in [(zero, Field::ProbeZero), (low, Field::ProbeLow), (high, Field::ProbeHigh)] {
            PROBE_RAW.check(*raw, field, None).map_err(|error| error.at(index))?;
        }
        if !PROBE_GAIN.contains(gain_um.abs()) {
            return Err(ConfigError::new(Field::ProbeGain, *gain_um, PROBE_GAIN.needed).at(index));
        }
    }
    if let Some(ArmSettings { lengths, counts: _, direction: _, tolerance_deg }) = arm {
        lengths.check()?;
        ARM_TOLERANCE.check(*tolerance_deg, Field::ArmTolerance, None)?;
    }
    STOP.check(*stop_s, Field::Stop, None)?;
    let Some(infeed) = infeed else { return Ok(()) };
    let InfeedSettings {
        axis: _,
        direction: _,
        band: _,
        gain,
        delay_revolutions: _,
        contact_deg,
        drive_delay_s,
        limit_um,
        noise_gain_limit,
    } = infeed;
    INFEED_GAIN.check(*gain, Field::InfeedGain, None)?;
    ANGLE.check(*contact_deg, Field::InfeedContact, None)?;
    DRIVE_DELAY.check(*drive_delay_s, Field::InfeedDriveDelay, None)?;
    INFEED.check(*limit_um, Field::InfeedLimit, None)?;
    NOISE_GAIN.check(*noise_gain_limit, Field::InfeedNoiseGain, None)
}
