//! Drives, friction, dynamic correction, contour feedback and cross-talk of a compiled file.

use crate::text::{micro, short};
use serde::Serialize;
use std::fmt;
use trueaxis::machine::{Axis, AxisServo, CrosstalkSettings, FeedbackSettings};

/// The servo settings of an axis. Lengths in the axis' unit, mm or degrees, small ones in µm or µrad.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ServoSummary {
    /// Parameters of the drive.
    pub drive: Option<DriveSummary>,
    /// Friction of the reversal feed-forward.
    pub friction: Option<FrictionSummary>,
    /// Dynamic correction.
    pub dynamic: Option<DynamicSummary>,
}

/// Parameters of a drive: those of [`trueaxis::machine::DriveFigures`], in its units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveSummary {
    /// K_v, 1/s.
    pub position_gain_per_s: f64,
    /// K_vp, 1/s.
    pub velocity_gain_per_s: f64,
    /// Reset time of the velocity loop, s.
    pub reset_time_s: f64,
    /// Share of the commanded velocity that is fed forward.
    pub velocity_feed_forward: f64,
    /// Time constant of the current loop, s.
    pub current_loop_s: f64,
    /// Dead time, s.
    pub dead_time_s: f64,
}

/// Friction of an axis, divided by the gain of its velocity loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrictionSummary {
    /// Coulomb friction, per s.
    pub coulomb_per_s: f64,
    /// Pre-sliding, µm or µrad.
    pub presliding_micro: f64,
    /// Static friction above Coulomb friction, as a share of it.
    pub stribeck_share: f64,
    /// Velocity at which half of that remains, per s.
    pub stribeck_velocity_per_s: f64,
    /// Viscous friction.
    pub viscous: f64,
    /// Lead, s.
    pub lead_s: f64,
}

/// Dynamic correction of an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DynamicSummary {
    /// Largest |correction|, µm or µrad.
    pub magnitude_micro: f64,
    /// Largest rate, per s.
    pub slope_per_s: f64,
    /// Largest acceleration, per s².
    pub acceleration_per_s2: f64,
    /// Whether the following error is compensated.
    pub lag: bool,
    /// Whether acceleration is fed forward.
    pub acceleration: bool,
    /// Whether the correction takes up lost motion at the command's reversal.
    pub take_up: bool,
}

/// Contour feedback.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeedbackSummary {
    /// K_p.
    pub proportional: f64,
    /// K_i, 1/s.
    pub integral_per_s: f64,
    /// Fastest motion with feedback, mm/min.
    pub max_feed_mm_per_min: f64,
    /// Contour error above which the feedback watches for an oscillation, µm.
    pub watch_um: f64,
}

/// A cross-talk term.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrosstalkSummary {
    /// Axis along which the tip moves.
    pub tip: char,
    /// Accelerating axis.
    pub from: char,
    /// Axis whose position k depends on.
    pub over: char,
    /// Unit of k: um per m/s2 or um per deg/s2.
    pub unit: &'static str,
    /// Position and k; a single point applies everywhere.
    pub points: Vec<[f64; 2]>,
}

/// The servo settings of an axis that has any.
pub(super) fn servo(axis: Axis, servo: &AxisServo) -> Option<ServoSummary> {
    let drive = servo.drive.map(|drive| DriveSummary {
        position_gain_per_s: drive.position_gain_per_s,
        velocity_gain_per_s: drive.velocity_gain_per_s,
        reset_time_s: drive.reset_time_s,
        velocity_feed_forward: drive.velocity_feed_forward,
        current_loop_s: drive.current_loop_s,
        dead_time_s: drive.dead_time_s,
    });
    let friction = servo.friction.map(|friction| FrictionSummary {
        coulomb_per_s: friction.coulomb_per_s,
        presliding_micro: micro(axis, friction.presliding),
        stribeck_share: friction.stribeck_share,
        stribeck_velocity_per_s: friction.stribeck_velocity_per_s,
        viscous: friction.viscous,
        lead_s: friction.lead_s,
    });
    let dynamic = servo.dynamic.map(|dynamic| DynamicSummary {
        magnitude_micro: micro(axis, dynamic.limits.magnitude),
        slope_per_s: dynamic.limits.slope_per_s,
        acceleration_per_s2: dynamic.limits.acceleration_per_s2,
        lag: dynamic.lag,
        acceleration: dynamic.acceleration,
        take_up: dynamic.take_up,
    });
    let any = drive.is_some() || friction.is_some() || dynamic.is_some();
    any.then_some(ServoSummary { drive, friction, dynamic })
}

pub(super) fn feedback(settings: &FeedbackSettings) -> FeedbackSummary {
    FeedbackSummary {
        proportional: settings.proportional,
        integral_per_s: settings.integral_per_s,
        max_feed_mm_per_min: settings.max_feed_per_s * 60.0,
        watch_um: settings.watch_mm * 1e3,
    }
}

pub(super) fn crosstalk(settings: &CrosstalkSettings) -> CrosstalkSummary {
    let (unit, scale) = if settings.from.is_rotary() { ("um per deg/s2", 1e3) } else { ("um per m/s2", 1e6) };
    CrosstalkSummary {
        tip: settings.tip.letter(),
        from: settings.from.letter(),
        over: settings.over.letter(),
        unit,
        points: settings.points.iter().map(|[position, k]| [*position, k * scale]).collect(),
    }
}

impl ServoSummary {
    /// Writes the lines of an axis' section; `unit` is mm or deg, `micro` µm or µrad.
    pub(super) fn lines(&self, f: &mut fmt::Formatter<'_>, unit: &str, micro: &str) -> fmt::Result {
        if let Some(drive) = &self.drive {
            let [kv, kvp] = [drive.position_gain_per_s, drive.velocity_gain_per_s].map(short);
            let [reset, current, dead] =
                [drive.reset_time_s, drive.current_loop_s, drive.dead_time_s].map(|time| short(time * 1e3));
            let ahead = short(drive.velocity_feed_forward * 100.0);
            write!(f, "\n  drive      K_v {kv}/s, K_vp {kvp}/s, reset time {reset} ms, feed-forward {ahead} %")?;
            write!(f, ", current loop {current} ms, dead time {dead} ms")?;
        }
        if let Some(friction) = &self.friction {
            let [coulomb, velocity] = [friction.coulomb_per_s, friction.stribeck_velocity_per_s].map(short);
            write!(f, "\n  friction   {coulomb} {unit}/s, pre-sliding {} {micro}", short(friction.presliding_micro))?;
            write!(f, ", Stribeck {} % below {velocity} {unit}/s", short(friction.stribeck_share * 100.0))?;
            write!(f, ", viscous {}, lead {} ms", short(friction.viscous), short(friction.lead_s * 1e3))?;
        }
        let Some(dynamic) = &self.dynamic else { return Ok(()) };
        let [slope, acceleration] = [dynamic.slope_per_s, dynamic.acceleration_per_s2].map(short);
        let magnitude = dynamic.magnitude_micro;
        write!(f, "\n  dynamic    {magnitude:.1} {micro}, {slope} {unit}/s, {acceleration} {unit}/s²")?;
        let parts =
            [(dynamic.lag, "lag"), (dynamic.acceleration, "acceleration"), (dynamic.take_up, "lost motion taken up")];
        parts.into_iter().filter(|(on, _)| *on).try_for_each(|(_, name)| write!(f, ", {name}"))
    }
}

impl fmt::Display for FeedbackSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [p, i, feed, watch] =
            [self.proportional, self.integral_per_s, self.max_feed_mm_per_min, self.watch_um].map(short);
        write!(f, "\n\ncontour feedback   K_p {p}, K_i {i}/s, up to {feed} mm/min, watched from {watch} µm on")
    }
}

impl fmt::Display for CrosstalkSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\n\ncross-talk   {} moves the tip in {}: ", self.from, self.tip)?;
        match self.points.as_slice() {
            [[_, k]] => write!(f, "{}", short(*k))?,
            points => {
                let all: Vec<String> =
                    points.iter().map(|[at, k]| format!("{} at {} {}", short(*k), self.over, short(*at))).collect();
                write!(f, "{}", all.join(", "))?;
            }
        }
        write!(f, " {}", self.unit.replace("um", "µm").replace('2', "²"))
    }
}
