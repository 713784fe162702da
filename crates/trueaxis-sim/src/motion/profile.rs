//! Speed along the path: look-ahead over sections, then jerk-limited phases by the `rsruckig` crate.

use rsruckig::prelude::{InputParameter, Ruckig, RuckigResult, ThrowErrorHandler, Trajectory};

use super::ceiling::Section;
use super::{MotionError, MotionSettings};

/// A stretch of time with constant jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Phase {
    /// End, s from the beginning of the motion.
    pub(super) end: f64,
    /// Beginning, s.
    pub(super) start: f64,
    /// Arc length (mm), speed, acceleration and jerk at the beginning.
    pub(super) length: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) jerk: f64,
}

impl Phase {
    /// Arc length and speed at time t, s.
    pub(super) fn at(&self, t: f64) -> (f64, f64) {
        let t = t - self.start;
        let (a, j) = (self.acceleration, self.jerk);
        (self.length + t * (self.speed + t * (a / 2.0 + t * j / 6.0)), self.speed + t * (a + t * j / 2.0))
    }
}

/// Length in mm in which the speed changes from v to v + d, with zero acceleration at both ends.
///
/// It takes T = 2 √(d/j), or d/a + a/j if the acceleration limit a is reached (d ≥ a²/j), and covers (2 v + d) T / 2.
fn change_distance(v: f64, d: f64, settings: &MotionSettings) -> f64 {
    let (a, j) = (settings.acceleration_mm_per_s2, settings.jerk_mm_per_s3);
    let time = if d < a * a / j { 2.0 * (d / j).sqrt() } else { d / a + a / j };
    (v + 0.5 * d) * time
}

/// Highest speed after `length` mm from speed v, both with zero acceleration; computed by bisection, from below.
fn reachable(v: f64, length: f64, settings: &MotionSettings, highest: f64) -> f64 {
    let distance = |d: f64| change_distance(v, d, settings);
    // Slightly less than the full length, so that rounding never requests more than the limits.
    let length = length * (1.0 - 1.0e-6);
    let (mut low, mut high) = (0.0, highest - v);
    if high <= 0.0 || distance(high) <= length {
        return highest;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if distance(middle) <= length {
            low = middle;
        } else {
            high = middle;
        }
    }
    v + low
}

/// Speeds at the ends of the sections: the lowest of both ceilings and the corner speed, then limited by braking (backward
/// pass) and acceleration (forward pass). Starts and ends at rest.
fn boundary_speeds(sections: &[Section], settings: &MotionSettings) -> Vec<f64> {
    let mut speeds = Vec::with_capacity(sections.len() + 1);
    speeds.push(0.0);
    for pair in sections.windows(2) {
        speeds.push(pair[0].ceiling.min(pair[1].ceiling).min(pair[0].end_limit));
    }
    speeds.push(0.0);
    for i in (0..sections.len()).rev() {
        speeds[i] = speeds[i].min(reachable(speeds[i + 1], sections[i].length, settings, sections[i].ceiling));
    }
    for i in 0..sections.len() {
        speeds[i + 1] = speeds[i + 1].min(reachable(speeds[i], sections[i].length, settings, sections[i].ceiling));
    }
    speeds
}

/// Cuts sections longer than acceleration from rest and braking to rest together take, so that the middle is run at constant
/// speed. The motion does not change, and the planner, which fails on profiles longer than about two hours, only gets short
/// ones.
fn split(sections: &[Section], settings: &MotionSettings) -> Vec<Section> {
    let mut parts = Vec::with_capacity(sections.len());
    for section in sections {
        let end = (1.0 + 1.0e-3) * change_distance(0.0, section.ceiling, settings);
        if section.length > 2.0 * end + 1.0 {
            let part = |length, end_limit| Section { length, ceiling: section.ceiling, end_limit };
            parts.push(part(end, f64::INFINITY));
            parts.push(part(section.length - 2.0 * end, f64::INFINITY));
            parts.push(part(end, section.end_limit));
        } else {
            parts.push(*section);
        }
    }
    parts
}

/// The sections as run, and the speeds at their ends: that at the start, then one per section.
pub(super) fn plan(sections: &[Section], settings: &MotionSettings) -> (Vec<Section>, Vec<f64>) {
    let sections = split(sections, settings);
    let speeds = boundary_speeds(&sections, settings);
    (sections, speeds)
}

/// Plans the sections one after the other; the caller keeps the result and needs one section at a time.
pub(super) struct Planner {
    ruckig: Ruckig<1, ThrowErrorHandler>,
    input: InputParameter<1>,
    trajectory: Trajectory<1>,
    /// Time (s) and arc length (mm) at the end of the last planned section.
    pub(super) time: f64,
    pub(super) length: f64,
}

impl Planner {
    pub(super) fn new(settings: &MotionSettings) -> Planner {
        let mut input = InputParameter::<1>::new(None);
        input.max_acceleration[0] = settings.acceleration_mm_per_s2;
        input.max_jerk[0] = settings.jerk_mm_per_s3;
        Planner {
            ruckig: Ruckig::new(None, settings.period_s),
            input,
            trajectory: Trajectory::new(None),
            time: 0.0,
            length: 0.0,
        }
    }

    /// Replaces `phases` by the phases of the next section.
    pub(super) fn section(
        &mut self,
        section: &Section,
        ends: [f64; 2],
        phases: &mut Vec<Phase>,
    ) -> Result<(), MotionError> {
        phases.clear();
        if ends == [section.ceiling; 2] {
            let (start, length) = (self.time, self.length);
            self.time += section.length / section.ceiling;
            self.length += section.length;
            let speed = section.ceiling;
            phases.push(Phase { end: self.time, start, length, speed, acceleration: 0.0, jerk: 0.0 });
            return Ok(());
        }
        let begins = self.length;
        let failed = |reason: String| MotionError::Planner { length_mm: begins, reason };
        let Planner { ruckig, input, trajectory, time, length } = self;
        input.current_velocity[0] = ends[0];
        input.target_velocity[0] = ends[1];
        input.target_position[0] = section.length;
        input.max_velocity[0] = section.ceiling;
        // Prevents backward motion, which a state-to-state planner may use.
        input.min_velocity = None;
        let result = ruckig.calculate(input, trajectory).map_err(|error| failed(error.to_string()))?;
        let profile = match trajectory.get_profiles().first() {
            Some(profiles) if matches!(result, RuckigResult::Working | RuckigResult::Finished) => &profiles[0],
            _ => return Err(failed(format!("{result:?}"))),
        };
        if profile.brake.duration > 0.0 || profile.v.iter().any(|v| *v < -1.0e-6) {
            return Err(failed("no monotone profile".to_owned()));
        }
        for i in 0..profile.t.len() {
            if profile.t[i] > 0.0 {
                phases.push(Phase {
                    end: *time + profile.t[i],
                    start: *time,
                    length: *length + profile.p[i],
                    speed: profile.v[i],
                    acceleration: profile.a[i],
                    jerk: profile.j[i],
                });
                *time += profile.t[i];
            }
        }
        *length += section.length;
        Ok(())
    }
}

impl std::fmt::Debug for Planner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Planner").field("time", &self.time).field("length", &self.length).finish_non_exhaustive()
    }
}
