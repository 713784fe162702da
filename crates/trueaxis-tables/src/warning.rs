//! Warnings about settings that work, but not as well as they should.

use crate::lost_motion::{LostMotion, SWIFT_S, lost_motion};
use crate::periods::contained_in;
use crate::rates::{DriveRate, drive_rate};
use crate::{Grid, Machine};
use std::fmt;
use trueaxis::check;
use trueaxis::machine::Curve;
use trueaxis::machine::{Axis, AxisSettings, ErrorModel, Interpolation, LocationErrors};

/// Tip errors below this cause no warning, mm.
const NEGLIGIBLE_MM: f64 = 1e-5;

/// A warning about a machine that can be compiled.
///
/// For a rotary axis, read `mm` as degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The axis' section has no `travel`, so no command counts as out of range.
    TravelNotDeclared {
        /// The axis.
        axis: Axis,
    },
    /// The table ends inside the declared travel; beyond it the edge value applies.
    TravelNotCovered {
        /// The axis.
        axis: Axis,
        /// Ends of the table, mm.
        table: [f64; 2],
        /// Declared travel, mm.
        travel: [f64; 2],
    },
    /// The machine states no table, period, grid, squareness, location error, lost motion or growth, so its correction is zero.
    NoErrorsStated,
    /// At top feed of all axes the correction of a drive changes faster than its slope limit allows.
    SlopeAboveLimit {
        /// The drive.
        axis: Axis,
        /// Rate of the wanted correction, mm/s.
        rate: f64,
        /// Slope limit of the drive, mm/s.
        limit: f64,
        /// Moving axis with the largest share.
        moving: Axis,
        /// That share, mm/s.
        part: f64,
    },
    /// The acceleration limit allows a change per cycle (of the change per cycle) that single precision barely resolves.
    AccelerationBelowResolution {
        /// The drive.
        axis: Axis,
        /// a T², mm.
        per_cycle: f64,
        /// Resolution of the correction in single precision, mm.
        resolution: f64,
    },
    /// A linear table causes velocity steps in the command at its points.
    VelocitySteps {
        /// The moving axis, which has the table.
        axis: Axis,
        /// Component with the largest step, 0 to 5.
        component: usize,
        /// Step at top feed, mm/s (rad/s for a rotation).
        step: f64,
        /// Top feed, mm/s.
        feed: f64,
    },
    /// The slope of a grid along an axis steps at its nodes, and with it the velocity of the command.
    GridVelocitySteps {
        /// Number of the grid, from 0.
        grid: usize,
        /// The moving axis.
        axis: Axis,
        /// Component with the largest step, 0 to 2.
        component: usize,
        /// Step at top feed, mm/s.
        step: f64,
        /// Top feed, mm/s.
        feed: f64,
    },
    /// A grid ends inside the declared travel; beyond it the edge value applies.
    GridNotCovering {
        /// Number of the grid, from 0.
        grid: usize,
        /// The axis.
        axis: Axis,
        /// First and last node, mm.
        nodes: [f64; 2],
        /// Declared travel, mm.
        travel: [f64; 2],
    },
    /// Below the declared feed the lag asks for more than the magnitude of the dynamic correction: from there on the axes
    /// keep a common part of their lag.
    LagAboveLimit {
        /// The axis.
        axis: Axis,
        /// Magnitude that lag needs at the declared feed, mm.
        needed: f64,
        /// Feed at which it meets the limit, mm/s.
        feed: f64,
    },
    /// The axis' own table has points so close that it may contain a part of an error which a period states too.
    PeriodInTable {
        /// The axis.
        axis: Axis,
        /// Distance of the closest two points, mm.
        step: f64,
        /// The period, mm.
        period: f64,
    },
    /// At top feed the correction of an axis' periods accelerates more than its limit allows.
    PeriodAboveLimit {
        /// The axis.
        axis: Axis,
        /// Largest acceleration, mm/s².
        acceleration: f64,
        /// Acceleration limit, mm/s².
        limit: f64,
        /// Feed up to which the limit suffices, mm/s.
        feed: f64,
    },
    /// The limits ramp the correction of lost motion in slowly.
    SlowRampIn(LostMotion),
    /// The error model ignores the machine's angular errors.
    AnglesIgnored {
        /// Upper bound of the tip error that they cause through their levers, mm.
        tip: f64,
    },
    /// Tables and squareness ask for more than the magnitude limit.
    MagnitudeAboveLimit {
        /// The drive.
        axis: Axis,
        /// Largest wanted |correction|, mm.
        correction: f64,
        /// Magnitude limit, mm.
        limit: f64,
        /// The term with the largest share.
        term: Term,
        /// Largest |correction| that this term alone asks for, mm.
        part: f64,
    },
}

/// A part of the correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Term {
    /// The table of an axis.
    Table(Axis),
    /// All grids.
    Grids,
    /// Squareness and location errors.
    Location,
    /// Lost motion of an axis.
    Backlash(Axis),
    /// Errors of an axis that repeat within a period.
    Periods(Axis),
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Term::Table(axis) => write!(f, "the table of {}", axis.letter()),
            Term::Grids => f.write_str("the grids"),
            Term::Location => f.write_str("squareness and location errors"),
            Term::Backlash(axis) => write!(f, "the backlash of {}", axis.letter()),
            Term::Periods(axis) => write!(f, "the periods of {}", axis.letter()),
        }
    }
}

/// A number with its unit, angles in µrad or degrees as in the files.
struct Length {
    axis: Axis,
    value: f64,
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.axis.is_rotary() {
            write!(f, "{:.1} µrad", self.value.to_radians() * 1e6)
        } else {
            write!(f, "{:.2} µm", self.value * 1e3)
        }
    }
}

fn unit(axis: Axis) -> &'static str {
    if axis.is_rotary() { "deg" } else { "mm" }
}

/// A feed to four decimals: 1,000 mm/min are 16.6667 mm/s.
fn rounded(feed: f64) -> f64 {
    (feed * 1e4).round() / 1e4
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Warning::TravelNotDeclared { axis } => {
                let unit = unit(axis);
                write!(f, "axis {}: travel_{unit} is not declared: no command counts as outside", axis.letter())
            }
            Warning::TravelNotCovered { axis, table: [low, high], travel: [from, to] } => {
                let (letter, unit) = (axis.letter(), unit(axis));
                write!(
                    f,
                    "axis {letter}: the table covers {low} to {high} {unit} of a travel of {from} to {to} {unit}; \
                     beyond its ends the edge value is used"
                )
            }
            Warning::NoErrorsStated => f.write_str(
                "no errors are stated (no table, period, grid, squareness, location error, lost motion or growth): no geometry is \
                 corrected",
            ),
            Warning::SlopeAboveLimit { axis, rate, limit, moving, part } => {
                let (letter, unit) = (axis.letter(), unit(axis));
                write!(
                    f,
                    "axis {letter}: at top feed the correction changes by up to {rate:.3} {unit}/s ({part:.3} {unit}/s \
                     from the motion of {}), above the slope limit of {limit} {unit}/s: it will lag",
                    moving.letter()
                )
            }
            Warning::PeriodInTable { axis, step, period } => {
                let (letter, unit) = (axis.letter(), unit(axis));
                write!(
                    f,
                    "axis {letter}: its table has points {step} {unit} apart, closer than half of its period of {period} \
                     {unit}: what the table contains of that error is corrected twice"
                )
            }
            Warning::PeriodAboveLimit { axis, acceleration, limit, feed } => {
                let (letter, unit) = (axis.letter(), unit(axis));
                write!(
                    f,
                    "axis {letter}: at top feed the correction of its periods accelerates by up to {acceleration:.0} \
                     {unit}/s², above its limit of {limit} {unit}/s²: it will lag from {:.0} {unit}/min on",
                    feed * 60.0
                )
            }
            Warning::AccelerationBelowResolution { axis, per_cycle, resolution } => {
                let (letter, unit) = (axis.letter(), unit(axis));
                write!(
                    f,
                    "axis {letter}: the acceleration limit is {per_cycle:.2e} {unit} per cycle and cycle, less than 10 \
                     times the resolution of the correction in single precision, {resolution:.2e} {unit}"
                )
            }
            Warning::VelocitySteps { axis, component, step, feed } => {
                let direction = Axis::ALL.get(component).map_or('?', |axis| axis.letter());
                let (letter, unit, feed) = (axis.letter(), unit(axis), rounded(feed));
                let (step, micro) = if component < 3 { (step * 1e3, "µm/s") } else { (step * 1e6, "µrad/s") };
                write!(
                    f,
                    "axis {letter}: linear interpolation of E{direction}{letter} puts velocity steps of up to \
                     {step:.2} {micro} into the command at {feed} {unit}/s; interpolation = \"cubic\" has none"
                )
            }
            Warning::GridVelocitySteps { grid, axis, component, step, feed } => {
                let (number, letter, feed) = (grid + 1, axis.letter(), rounded(feed));
                let direction = Axis::ALL.get(component).map_or('?', |axis| axis.letter());
                write!(
                    f,
                    "grid {number}: where {letter} passes from cell to cell, E{direction} puts velocity steps of up to {:.2} µm/s \
                     into the command at {feed} mm/s; more nodes there make them smaller",
                    step * 1e3
                )
            }
            Warning::GridNotCovering { grid, axis, nodes: [low, high], travel: [from, to] } => {
                let (number, letter) = (grid + 1, axis.letter());
                write!(
                    f,
                    "grid {number}: its nodes cover {low} to {high} mm of the travel of {letter}, {from} to {to} mm; beyond \
                     them the edge value is used"
                )
            }
            Warning::LagAboveLimit { axis, needed, feed } => {
                let (letter, unit, needed) = (axis.letter(), unit(axis), Length { axis, value: needed });
                write!(
                    f,
                    "axis {letter}: lag meets the magnitude limit of the dynamic correction at {:.0} {unit}/min and needs \
                     {needed} at the declared feed; above that feed all axes keep a common part of their lag, along the path",
                    feed * 60.0
                )
            }
            Warning::SlowRampIn(lost) => {
                write!(f, "{lost}; higher limits of slope and acceleration would take less than {} ms", SWIFT_S * 1e3)
            }
            Warning::AnglesIgnored { tip } => {
                write!(
                    f,
                    "angular errors (EA, EB, EC) are not corrected by the nine terms; over their levers they move the \
                     tip by up to {:.1} µm; [compensation] model = \"volumetric\" corrects it",
                    tip * 1e3
                )
            }
            Warning::MagnitudeAboveLimit { axis, correction, limit, term, part } => {
                let [correction, limit, part] = [correction, limit, part].map(|value| Length { axis, value });
                let letter = axis.letter();
                write!(
                    f,
                    "axis {letter}: the correction reaches {correction}, its magnitude is limited to {limit}; the largest term is \
                     {term}, {part} alone"
                )
            }
        }
    }
}

/// All warnings about a machine, axis by axis.
///
/// `servo_rate_hz`: cycles per second of the controller. Rates and magnitudes are upper bounds: every axis at top feed at
/// once, every other axis at its worst position, temperature at the reference.
pub fn check(machine: &Machine, servo_rate_hz: f64) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let grids = check::GridBounds::of(&machine.grids());
    if !machine.states_errors() {
        warnings.push(Warning::NoErrorsStated);
    }
    if machine.settings.compensation.model == ErrorModel::Nine {
        let tip = check::angular_tip_error(&machine.settings, |axis| machine.rows(axis), &grids);
        if tip > NEGLIGIBLE_MM {
            warnings.push(Warning::AnglesIgnored { tip });
        }
    }
    warnings.extend(lost_motion(machine).into_iter().filter(|lost| lost.ramp_in_s > SWIFT_S).map(Warning::SlowRampIn));
    warnings.extend(machine.settings.axes.iter().filter_map(lag_above_limit));
    warnings.extend(machine.settings.axes.iter().filter_map(|own| period_above_limit(machine, own)));
    warnings.extend(machine.settings.periodic.iter().filter_map(|period| {
        let (axis, period) = (period.axis, period.period);
        contained_in(machine, axis, period).map(|step| Warning::PeriodInTable { axis, step, period })
    }));
    for (settings, table) in machine.axes() {
        let axis = settings.axis;
        let open = AxisSettings::with_defaults(axis, false).travel;
        let ends = table.and_then(|table| Some([table.rows.first()?.position, table.rows.last()?.position]));
        if settings.travel == open {
            warnings.push(Warning::TravelNotDeclared { axis });
        } else if let (Some([low, high]), Some(table)) = (ends, table)
            && !trueaxis::machine::wraps(axis, table.rows.as_slice())
            && (low > settings.travel[0] || high < settings.travel[1])
        {
            warnings.push(Warning::TravelNotCovered { axis, table: [low, high], travel: settings.travel });
        }
        if let Some(warning) = slope(machine, settings) {
            warnings.push(warning);
        }
        let per_cycle = settings.limits.acceleration_per_s2 / (servo_rate_hz * servo_rate_hz);
        let resolution = f64::from(f32::EPSILON) * settings.limits.magnitude;
        if per_cycle < 10.0 * resolution {
            warnings.push(Warning::AccelerationBelowResolution { axis, per_cycle, resolution });
        }
        if let Some(warning) = velocity_steps(machine, settings) {
            warnings.push(warning);
        }
        let own = check::reach(settings, machine.rows(axis));
        let (least, most) = check::error_range(&machine.settings, |axis| machine.rows(axis), &grids, settings, own);
        let (correction, limit) = (least.abs().max(most.abs()), settings.limits.magnitude);
        if correction > limit {
            let (term, part) = largest_term(machine, settings, &grids);
            warnings.push(Warning::MagnitudeAboveLimit { axis, correction, limit, term, part });
        }
    }
    for (number, grid) in machine.grids.iter().enumerate() {
        of_grid(machine, number, grid, &mut warnings);
    }
    warnings
}

/// A warning if the periods of an axis need more acceleration than its limit at the declared feed.
fn period_above_limit(machine: &Machine, own: &AxisSettings) -> Option<Warning> {
    let (axis, limit) = (own.axis, own.limits.acceleration_per_s2);
    let curvature = machine.settings.repeats(axis, 2);
    let acceleration = curvature * own.max_feed_per_s * own.max_feed_per_s;
    let feed = (limit / curvature).sqrt();
    (acceleration > limit * (1.0 + 1e-9)).then_some(Warning::PeriodAboveLimit { axis, acceleration, limit, feed })
}

/// A warning if the lag that an axis compensates exceeds the magnitude limit at the declared feed.
fn lag_above_limit(own: &AxisSettings) -> Option<Warning> {
    let (drive, dynamic) = (own.servo.drive.as_ref()?, own.servo.dynamic.filter(|dynamic| dynamic.lag)?);
    let (lag_s, limit) = (dynamic.lag_s(drive), dynamic.limits.magnitude);
    let needed = lag_s * own.max_feed_per_s;
    (needed > limit * (1.0 + 1e-9)).then(|| Warning::LagAboveLimit { axis: own.axis, needed, feed: limit / lag_s })
}

/// The term that alone asks for the largest correction of a drive, and that correction.
fn largest_term(machine: &Machine, drive: &AxisSettings, grids: &check::GridBounds) -> (Term, f64) {
    let mut bare = machine.settings.clone();
    bare.location = LocationErrors::default();
    bare.axes.iter_mut().for_each(|axis| axis.backlash = 0.0);
    bare.periodic.clear();
    let mut located = bare.clone();
    located.location = machine.settings.location;
    let axes = machine.settings.axes.iter();
    let tables = axes.clone().filter(|axis| machine.rows(axis.axis).is_some()).map(|axis| Term::Table(axis.axis));
    let lost = axes.filter(|axis| axis.backlash != 0.0).map(|axis| Term::Backlash(axis.axis));
    let repeats = machine.settings.repeats(drive.axis, 0);
    let part = |term: Term| {
        let rows = |axis| machine.rows(axis).filter(|_| term == Term::Table(axis));
        let (settings, grids) = match term {
            Term::Table(_) => (bare.clone(), &check::GridBounds::NONE),
            Term::Grids => (bare.clone(), grids),
            Term::Location => (located.clone(), &check::GridBounds::NONE),
            Term::Periods(_) => return (term, repeats),
            Term::Backlash(axis) => {
                let mut settings = bare.clone();
                settings.axes.iter_mut().zip(&machine.settings.axes).for_each(|(own, stated)| {
                    own.backlash = if own.axis == axis { stated.backlash } else { 0.0 };
                });
                (settings, &check::GridBounds::NONE)
            }
        };
        let own = check::reach(drive, machine.rows(drive.axis));
        let (least, most) = check::error_range(&settings, rows, grids, drive, own);
        (term, least.abs().max(most.abs()))
    };
    let terms = tables.chain(lost).chain([Term::Location, Term::Grids, Term::Periods(drive.axis)]).map(part);
    terms.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Term::Location, 0.0))
}

/// Velocity steps that a grid causes, and the travel that it leaves uncovered, axis by axis.
fn of_grid(machine: &Machine, number: usize, grid: &Grid, warnings: &mut Vec<Warning>) {
    for axis in grid.header().letters() {
        let Some(settings) = machine.settings.axis(axis) else { continue };
        let nodes = grid.header().axes[axis.index()].ends;
        let travel = settings.travel;
        let declared = travel != AxisSettings::with_defaults(axis, false).travel;
        if declared && (nodes[0] > travel[0] || nodes[1] < travel[1]) {
            warnings.push(Warning::GridNotCovering { grid: number, axis, nodes, travel });
        }
        let steps = (0..3).map(|component| (component, grid.slope_step(axis.index(), component)));
        let Some((component, step)) = steps.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let (step, feed) = (step * settings.max_feed_per_s, settings.max_feed_per_s);
        // Below a nanometre per second, a step comes from the rounding of the decimals.
        if step > 1e-6 {
            warnings.push(Warning::GridVelocitySteps { grid: number, axis, component, step, feed });
        }
    }
}

/// Rate of a drive's correction with all axes at top feed.
fn slope(machine: &Machine, drive: &AxisSettings) -> Option<Warning> {
    let DriveRate { axis, rate, limit, moving, part, .. } = drive_rate(machine, drive)?;
    (rate > limit).then_some(Warning::SlopeAboveLimit { axis, rate, limit, moving, part })
}

/// Largest velocity step that a linear table causes.
fn velocity_steps(machine: &Machine, settings: &AxisSettings) -> Option<Warning> {
    let rows = machine.rows(settings.axis)?;
    if settings.interpolation != Interpolation::Linear {
        return None;
    }
    let step = |component, reverse| Curve::new(settings, rows, component, reverse).slope_step();
    // Components that reach a drive: the translations, and a rotary axis' own error.
    let own = settings.axis.index();
    let components = (0..3).chain((own >= 3).then_some(own));
    let steps = components.map(|component| (component, step(component, false).max(step(component, true))));
    // A microradian of a rotary axis weighs as much as a micrometre at the tip.
    let weight = |(component, step): &(usize, f64)| if *component < 3 { step * 1e3 } else { step * 1e6 };
    let (component, step) = steps.max_by(|a, b| weight(a).total_cmp(&weight(b)))?;
    let step = step * settings.max_feed_per_s;
    // Below a nanometre per second, a step comes from the rounding of the decimals.
    (weight(&(component, step)) > 1e-3).then_some(Warning::VelocitySteps {
        axis: settings.axis,
        component,
        step,
        feed: settings.max_feed_per_s,
    })
}
