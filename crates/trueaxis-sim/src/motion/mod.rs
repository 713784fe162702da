//! Planning of a program's motion, down to setpoints at the servo period.
//!
//! The path is divided into sections of one speed limit: the feed, or the speed at which the normal acceleration reaches its
//! limit. Between moves the speed is low enough that the velocity vector steps by no more than a permitted amount. Backward
//! and forward passes make the speeds at the section ends reachable, and each section becomes a time-optimal jerk-limited
//! profile between them, with zero acceleration at its ends. The limits of acceleration and jerk apply along the path; the
//! limit of normal acceleration, across it. A move of rotary axes only is measured in degrees; for it, read degree for mm
//! throughout.

mod arc_length;
mod ceiling;
mod profile;
mod setpoints;

use arc_length::ArcLength;
use ceiling::Section;
use profile::Planner;

use crate::placement::Placement;
use crate::program::{Move, Program};
use crate::range::Range;
use serde::{Deserialize, Serialize};

pub use setpoints::{Setpoint, Setpoints, Walk};

/// Cycles at rest before the first and after the last move.
pub const DWELL_CYCLES: u64 = 200;

/// Longest motion that is planned, in cycles (more than a day at 10 kHz).
pub const MOST_CYCLES: f64 = 1.0e9;

/// Limits of the motion along the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionSettings {
    /// Servo period, s; in a scenario it follows from the servo rate.
    #[serde(skip)]
    pub period_s: f64,
    /// Feed override, %: programmed feeds are scaled by it; G0 is not.
    pub feed_percent: f64,
    /// Largest acceleration along the path, mm/s².
    pub acceleration_mm_per_s2: f64,
    /// Largest jerk along the path, mm/s³.
    pub jerk_mm_per_s3: f64,
    /// Speed of G0, mm/min.
    pub rapid_mm_per_min: f64,
    /// Largest acceleration across the path, v² times curvature, mm/s².
    pub normal_acceleration_mm_per_s2: f64,
    /// Largest step of the velocity vector between two moves, mm/s; with 0 the motion stops at every corner.
    pub junction_mm_per_s: f64,
}

impl Default for MotionSettings {
    /// A finishing cut: 10 kHz, 1 m/s², 10 m/s³, 10 m/min rapid, 0.5 m/s² across the path, 0.3 mm/s at corners. Harder
    /// settings leave the corners to the servo: 2 m/s² and 50 m/s³ double its contour error.
    fn default() -> Self {
        MotionSettings {
            period_s: 1.0e-4,
            feed_percent: 100.0,
            acceleration_mm_per_s2: 1.0e3,
            jerk_mm_per_s3: 1.0e4,
            rapid_mm_per_min: 1.0e4,
            normal_acceleration_mm_per_s2: 5.0e2,
            junction_mm_per_s: 0.3,
        }
    }
}

/// Reason why a program cannot be turned into motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// The program has no move.
    #[error("the program has no move")]
    Empty,
    /// A setting is out of range.
    #[error("{setting}: found {found}; needed: {needed}")]
    Setting {
        /// Field of [`MotionSettings`].
        setting: &'static str,
        /// The value found.
        found: f64,
        /// Range accepted.
        needed: String,
    },
    /// The motion takes too many cycles.
    #[error("the motion takes {0:e} servo cycles; at most {MOST_CYCLES:e} are planned")]
    TooLong(f64),
    /// The planner found no speed profile for a section.
    #[error("no speed profile at {length_mm} mm of the path: {reason}")]
    Planner {
        /// Arc length at the beginning of the section, mm.
        length_mm: f64,
        /// Message of the planner.
        reason: String,
    },
}

/// A planned program: speeds at the ends of its sections. The profile of a section is planned again when the motion reaches
/// it, so that memory does not grow with cycles, and little with moves.
#[derive(Clone, Debug)]
pub struct Motion {
    settings: MotionSettings,
    /// Arc length at the beginning of each move.
    starts: Vec<f64>,
    length: f64,
    sections: Vec<Section>,
    /// Speeds at the ends of the sections: that at the start, then one per section.
    speeds: Vec<f64>,
    duration: f64,
    cycles: u64,
}

impl Motion {
    /// Plans the whole program without regard to the machine: programmed feeds, curvature and corners.
    pub fn plan(program: &Program, settings: MotionSettings) -> Result<Motion, MotionError> {
        Motion::plan_with(program, settings, None)
    }

    /// Plans the whole program for a machine: where rotary axes turn or the tool centre point is programmed, the speeds and
    /// corners of the axes also count. For a program of X, Y, Z alone the motion equals that of [`Motion::plan`].
    pub fn plan_on(program: &Program, settings: MotionSettings, machine: &Placement) -> Result<Motion, MotionError> {
        Motion::plan_with(program, settings, Some(machine))
    }

    fn plan_with(
        program: &Program,
        settings: MotionSettings,
        machine: Option<&Placement>,
    ) -> Result<Motion, MotionError> {
        settings.check()?;
        let mut starts = Vec::with_capacity(program.moves.len());
        let mut sections = Vec::new();
        let mut length = 0.0;
        for (i, element) in program.moves.iter().enumerate() {
            let own = ArcLength::of(element).length();
            starts.push(length);
            length += own;
            ceiling::add_sections(element, own, &settings, machine, &mut sections);
            if let (Some(next), Some(section)) = (program.moves.get(i + 1), sections.last_mut()) {
                let step = settings.junction_mm_per_s;
                section.end_limit = match machine.filter(|_| element.is_five_axis() || next.is_five_axis()) {
                    Some(machine) => ceiling::corner_speed_of_axes(element, next, machine, step),
                    None => ceiling::corner_speed(&element.curve, &next.curve, step),
                };
                if element.stop {
                    section.end_limit = 0.0;
                }
            }
        }
        if sections.is_empty() {
            return Err(MotionError::Empty);
        }
        let (sections, speeds) = profile::plan(&sections, &settings);
        let mut planner = Planner::new(&settings);
        let mut phases = Vec::new();
        for (section, ends) in sections.iter().zip(speeds.windows(2)) {
            planner.section(section, [ends[0], ends[1]], &mut phases)?;
        }
        let duration = planner.time;
        let cycles = (duration / settings.period_s).ceil();
        // Also refuses NaN.
        if !(0.0..=MOST_CYCLES).contains(&cycles) {
            return Err(MotionError::TooLong(cycles));
        }
        let cycles = cycles as u64 + 1 + 2 * DWELL_CYCLES;
        Ok(Motion { settings, starts, length, sections, speeds, duration, cycles })
    }

    /// The setpoints from the first cycle on; `program` must be the planned one.
    pub fn setpoints<'m>(&'m self, program: &'m Program) -> Setpoints<'m> {
        Setpoints::new(self, program)
    }

    /// Passes X, Y, Z (mm) and A, B, C (degrees) of the program to `take`, at every `every_mm` of path length from 0 and at
    /// the end.
    pub fn points(&self, program: &Program, every_mm: f64, mut take: impl FnMut([f64; 3], [f64; 3])) {
        let mut next = 0_u64;
        for (element, start) in program.moves.iter().zip(&self.starts) {
            let (table, polar, mut node) = (ArcLength::of(element), element.curve.polar(), 0);
            let mut point = |along: f64| {
                let u = table.parameter(along, &mut node);
                take(element.curve.point_by(polar.as_ref(), u).into(), element.rotary(u));
            };
            while next as f64 * every_mm < start + table.length() {
                point((next as f64 * every_mm - start).max(0.0));
                next += 1;
            }
        }
        if let Some(last) = program.moves.last() {
            let u = last.curve.domain().1;
            take(last.curve.point_by(last.curve.polar().as_ref(), u).into(), last.rotary(u));
        }
    }

    /// Number of setpoints, the cycles at rest included.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Length of the path: mm, or degrees in moves measured in degrees ([`Move::in_degrees`](crate::program::Move)).
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Time from the beginning of the first move to the end of the last one, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }
}

impl MotionSettings {
    /// Speed of a move along its length, mm/s (deg/s): rapid for G0, otherwise the programmed feed with its override.
    pub fn speed(&self, element: &Move) -> f64 {
        let programmed = || element.planned_feed_per_min() * (self.feed_percent / 100.0);
        (if element.rapid { self.rapid_mm_per_min } else { programmed() }) / 60.0
    }

    /// Name, value, and range of every setting except the period.
    pub(crate) fn ranges(&self) -> [Range<'static>; 6] {
        let range = |key, found, low, high, unit| Range { key, found, low, high, unit };
        [
            range("feed_percent", self.feed_percent, 1.0, 1.0e3, "%"),
            range("acceleration_mm_per_s2", self.acceleration_mm_per_s2, 1.0, 1.0e6, "mm/s²"),
            range("jerk_mm_per_s3", self.jerk_mm_per_s3, 1.0, 1.0e9, "mm/s³"),
            range("rapid_mm_per_min", self.rapid_mm_per_min, 1.0, 1.0e6, "mm/min"),
            range("normal_acceleration_mm_per_s2", self.normal_acceleration_mm_per_s2, 1.0, 1.0e6, "mm/s²"),
            range("junction_mm_per_s", self.junction_mm_per_s, 0.0, 1.0e6, "mm/s"),
        ]
    }

    fn check(&self) -> Result<(), MotionError> {
        let period = Range { key: "period_s", found: self.period_s, low: 1.0e-6, high: 0.1, unit: "s" };
        match [period].into_iter().chain(self.ranges()).find(|range| !range.holds()) {
            Some(range) => Err(MotionError::Setting { setting: range.key, found: range.found, needed: range.needed() }),
            None => Ok(()),
        }
    }
}
