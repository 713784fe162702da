//! The grinding machine: spindle, linkage, workpiece, infeed axis, probes and encoders.

use super::{Event, Grinding, InfeedDrive, Linkage, Noise, Turning, Workpiece, counts, probe_angles};
use crate::error::{Result, SimError};
use std::f64::consts::TAU;
use std::sync::Arc;
use trueaxis::machine::AXES;
use trueaxis::roundness::{GaugeSettings, Probes};
use trueaxis_tables::exact::Geometry;

/// The spindle's counter at the index pulse: an incremental encoder starts at an arbitrary count.
const COUNTER_OFFSET: i32 = -271_828;
/// Free travel of the wheel before it can touch anything, µm.
const GAP_UM: f64 = 8.0;
/// Raw value of a probe that is out of its range.
const OUT: f64 = 1.0;

/// Angles and motion at one instant.
#[derive(Clone, Copy, Debug)]
struct Instant {
    alpha: f64,
    beta: f64,
    /// R_X, R_Y with their noise, µm.
    centre: [f64; 2],
    /// Level of the wheel's edge at the contact, µm.
    level: f64,
}

/// State of the machine.
pub(super) struct Cell {
    grinding: Arc<Grinding>,
    gauge: GaugeSettings,
    phi: [f64; 3],
    contact: f64,
    /// +1 if positive motion of the axis is toward the workpiece.
    direction: f64,
    /// Index of the infeed axis among X, Y, Z, and of every axis in the machine's list.
    place: usize,
    listed: Vec<usize>,
    geometry: Geometry,
    linkage: Linkage,
    /// Beginning, radius before and after; whether it is reported to the gauge.
    dressing: Option<([f64; 3], bool)>,
    turning: Turning,
    drive: InfeedDrive,
    noise: Noise,
    probe_noise: Noise,
    pub(super) pin: Workpiece,
    now: Instant,
    turn: i64,
    /// Start of the feed: turns, and total feed before it, µm.
    part: [f64; 2],
    parts: u64,
    /// True position at which the feed is 0, mm.
    datum: f64,
    others: [f64; 3],
    stopped_until: Option<f64>,
    done: Vec<bool>,
    time_s: f64,
}

/// Inputs of the control in a cycle.
pub(super) struct Readings {
    pub(super) probes: Probes<f64>,
    pub(super) command: [f64; 3],
    pub(super) feedback: [f64; 3],
    /// A new wheel radius, mm.
    pub(super) wheel_mm: Option<f64>,
}

impl Cell {
    pub(super) fn new(grinding: Arc<Grinding>) -> Result<Cell> {
        let gauge = *grinding.gauge()?;
        let infeed = gauge.infeed.ok_or_else(|| SimError::unsuited("[roundness]", "no infeed correction", "one"))?;
        let settings = &grinding.machine.settings;
        let linkage = Linkage::of(&gauge);
        let period_s = 1.0 / grinding.rate_hz;
        let others = crate::scenario::middle_of_travel(&grinding.machine);
        let place = infeed.axis.index();
        // The pin begins shortly before the first index pulse.
        let alpha = -0.3;
        let beta = linkage.beta(alpha);
        let mut cell = Cell {
            gauge,
            phi: probe_angles(&gauge),
            contact: infeed.contact_deg.to_radians(),
            direction: f64::from(infeed.direction),
            place,
            listed: settings.axes.iter().map(|a| a.axis.index()).collect(),
            geometry: Geometry::new(&grinding.machine, 0.0)?,
            linkage,
            dressing: None,
            turning: Turning::new(alpha, grinding.speed_rpm, period_s),
            drive: InfeedDrive::new(others[place], grinding.process.delay_s, grinding.process.lag_s, period_s),
            noise: Noise::new(grinding.seed, 101),
            probe_noise: Noise::new(grinding.seed, 102),
            pin: Workpiece::turned(grinding.seed),
            now: Instant { alpha, beta, centre: grinding.process.motion.at(alpha), level: GAP_UM },
            turn: -1,
            part: [0.0; 2],
            parts: 1,
            datum: others[place],
            others,
            stopped_until: None,
            done: vec![false; grinding.events.len()],
            time_s: 0.0,
            grinding,
        };
        cell.now.level = cell.level(&cell.now);
        Ok(cell)
    }

    /// Turns since the first index pulse.
    pub(super) fn turns(&self) -> f64 {
        self.now.alpha / TAU
    }

    /// Total feed so far, over all parts, µm.
    fn fed(&self) -> f64 {
        self.part[1] + self.grinding.fed_um(self.turns() - self.part[0])
    }

    /// True position of the infeed axis, mm.
    fn position(&self) -> f64 {
        let mut at = self.others;
        at[self.place] = self.drive.position();
        let mut listed = [0.0; AXES];
        for (to, axis) in listed.iter_mut().zip(&self.listed) {
            *to = at.get(*axis).copied().unwrap_or(0.0);
        }
        self.drive.position() + self.geometry.tip_error(&listed, &[0.0; AXES])[self.place]
    }

    /// Level of the wheel's edge at the contact, µm of the pin's radius.
    fn level(&self, at: &Instant) -> f64 {
        let toward = 1e3 * self.direction * (self.position() - self.datum);
        GAP_UM - toward * libm::cos(at.beta) - seen(at, self.contact)
    }

    /// Readings of this instant and the commands of this cycle.
    pub(super) fn read(&mut self, new_part: bool, wheel_mm: Option<f64>) -> Readings {
        let Instant { alpha, beta, .. } = self.now;
        let mut readings = [0.0; 3];
        for ((reading, phi), probe) in readings.iter_mut().zip(self.phi).zip(&self.gauge.probes) {
            let um = self.pin.at(alpha + beta + phi) + seen(&self.now, phi);
            let um = um + self.probe_noise.next(self.grinding.process.probe_noise_um);
            *reading = um / probe.gain_um + probe.zero;
        }
        self.knock(&mut readings);
        let spindle = &self.gauge.spindle;
        let count = |angle: f64| counts(angle, spindle.counts, spindle.direction).wrapping_add(COUNTER_OFFSET);
        let turn = self.turns().floor() as i64;
        let index = (turn != self.turn && !self.index_is_missing(turn)).then(|| {
            let at_turn = turn * i64::from(spindle.counts) * i64::from(spindle.direction);
            (at_turn as i32).wrapping_add(COUNTER_OFFSET)
        });
        self.turn = turn;
        let arm = self
            .gauge
            .arm
            .map_or(0, |arm| (beta / TAU * f64::from(arm.counts)).round() as i32 * i32::from(arm.direction));
        let mut command = self.others;
        command[self.place] += self.direction * 1e-3 * self.fed() / libm::cos(beta);
        let mut feedback = self.others;
        feedback[self.place] = self.drive.position();
        Readings {
            probes: Probes { readings, spindle: count(alpha), index, arm, new_part, idle: false },
            command,
            feedback,
            wheel_mm,
        }
    }

    fn knock(&self, readings: &mut [f64; 3]) {
        for event in &self.grinding.events {
            if let Event::ProbeOut { probe, at, turns } = event
                && (*at..at + turns).contains(&self.turns())
                && let (Some(reading), Some(settings)) = (readings.get_mut(*probe), self.gauge.probes.get(*probe))
            {
                *reading = settings.range[1] + OUT;
            }
        }
    }

    fn index_is_missing(&self, turn: i64) -> bool {
        self.grinding.events.contains(&Event::MissingIndex { turn })
    }

    /// Starts the events that are due; returns whether one of them is a new part, and a new wheel radius to report.
    pub(super) fn happen(&mut self) -> (bool, Option<f64>) {
        let mut new_part = false;
        let turns = self.turns();
        for (event, done) in self.grinding.events.iter().zip(&mut self.done) {
            match *event {
                Event::Stop { at, for_s } if turns >= at && !*done => {
                    (*done, self.stopped_until) = (true, Some(self.time_s + for_s));
                }
                Event::NewPart { at } if turns >= at && !*done => {
                    (*done, new_part) = (true, true);
                }
                Event::Wheel { at, wheel_mm, reported } if turns >= at && !*done => {
                    (*done, self.dressing) = (true, Some(([at, self.linkage.wheel_mm, wheel_mm], reported)));
                }
                _ => {}
            }
        }
        if new_part {
            // The highest point of the new pin is where the edge would be without motion of the centre.
            let fed = self.fed();
            self.part = [turns, fed];
            self.pin = Workpiece::turned(self.grinding.seed + self.parts).raised(-fed);
            self.parts += 1;
        }
        (new_part, self.dress())
    }

    fn dress(&mut self) -> Option<f64> {
        let ([at, from, to], reported) = self.dressing?;
        let share = (self.turns() - at).clamp(0.0, 1.0);
        self.linkage.wheel_mm = from + share * (to - from);
        if share < 1.0 {
            return None;
        }
        self.dressing = None;
        reported.then_some(to)
    }

    /// Advances the machine by one period; at rest and off the part while `settling`.
    pub(super) fn advance(&mut self, drive: f64, settling: bool) {
        self.drive.cycle(drive);
        if settling {
            return;
        }
        self.time_s += 1.0 / self.grinding.rate_hz;
        let stopped = self.stopped_until.is_some_and(|until| self.time_s < until);
        self.turning.cycle(!stopped);
        let alpha = self.turning.alpha();
        let motion = &self.grinding.process.motion;
        let mut next = Instant { alpha, beta: self.linkage.beta(alpha), centre: motion.at(alpha), level: 0.0 };
        for part in &mut next.centre {
            *part += self.noise.next(motion.noise_um);
        }
        next.level = self.level(&next);
        let place = |at: &Instant| [at.alpha + at.beta + self.contact, at.level];
        let (from, to) = (place(&self.now), place(&next));
        self.pin.grind(from, to);
        self.now = next;
    }

    /// Index of the infeed axis among X, Y, Z.
    pub(super) fn place(&self) -> usize {
        self.place
    }
}

/// Motion of the centre toward a point at the angle φ from probe 1, µm: R_Y cos(φ + β) + R_X sin(φ + β).
fn seen(at: &Instant, phi: f64) -> f64 {
    let [x, y] = at.centre;
    let (sin, cos) = libm::sincos(phi + at.beta);
    y * cos + x * sin
}
