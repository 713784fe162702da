//! Reversals of the axes: the parts of the dynamic correction, and the error without and with them.

use crate::report::ReversalReport;
use std::collections::VecDeque;
use trueaxis::Axis;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{DynamicSample, Moment, Sample};

/// Time before and after a reversal, s; the velocity loop's reset time is well within it.
const BEFORE_S: f64 = 0.02;
const AFTER_S: f64 = 0.08;
/// Maximum number of samples per second.
const MOST_HZ: f64 = 10_000.0;
/// An axis has reversed when its command has come back by this distance, mm or degrees.
const TURNED: f64 = 1e-5;

/// The values of a cycle that the figures need.
#[derive(Clone, Copy, Debug)]
struct Instant {
    time_s: f64,
    dynamic: DynamicSample,
    compensated_um: f32,
    full_um: f32,
}

/// Section of a run around a reversal.
#[derive(Clone, Debug, Default)]
struct Stretch {
    turned_s: f64,
    line: u32,
    instants: Vec<Instant>,
    /// Largest error of the corrected run.
    largest_um: f32,
}

/// The furthest command in the direction of travel; the direction is 0 before the first motion.
#[derive(Clone, Copy, Debug)]
struct Furthest {
    command: f64,
    time_s: f64,
    direction: f64,
}

/// One axis: its last reversal, the section being recorded, and the section with the largest error so far.
#[derive(Debug)]
struct Turns {
    axis: Axis,
    furthest: Option<Furthest>,
    recording: Option<Stretch>,
    worst: Option<Stretch>,
}

/// Keeps the reversal with the largest error of every axis.
#[derive(Debug)]
pub(super) struct Reversals {
    every: u64,
    latest: VecDeque<Instant>,
    kept: usize,
    axes: Vec<Turns>,
}

impl Reversals {
    pub(super) fn new(scenario: &Scenario) -> Reversals {
        let every = (scenario.rate_hz() / MOST_HZ).ceil().max(1.0);
        let turns = |axis| Turns { axis, furthest: None, recording: None, worst: None };
        let mut axes: Vec<Axis> = scenario.machine.settings.axes.iter().map(|own| own.axis).collect();
        axes.sort_unstable();
        Reversals {
            every: every as u64,
            latest: VecDeque::new(),
            kept: (BEFORE_S * scenario.rate_hz() / every).ceil() as usize,
            axes: axes.into_iter().map(turns).collect(),
        }
    }

    pub(super) fn add(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        let [_, Some(compensated), _, Some(full)] = runs else { return };
        let now = Instant {
            time_s: moment.time_s,
            dynamic: full.dynamic,
            compensated_um: compensated.error_um(),
            full_um: full.error_um(),
        };
        let sampled = moment.cycle.is_multiple_of(self.every);
        if sampled {
            self.latest.push_back(now);
            if self.latest.len() > self.kept {
                self.latest.pop_front();
            }
        }
        for turns in &mut self.axes {
            turns.record(&now, sampled && moment.cutting, moment.cutting);
            let command = full.command.get(turns.axis.index()).copied().unwrap_or(0.0);
            if let Some(turned_s) = turns.turned(command, moment.time_s)
                && moment.cutting
                && turns.recording.is_none()
            {
                let instants: Vec<Instant> = self.latest.iter().copied().collect();
                turns.recording = Some(Stretch { turned_s, line: moment.line, instants, largest_um: 0.0 });
            }
        }
    }

    /// The reversals of all axes that reversed while cutting.
    pub(super) fn report(&self) -> Vec<ReversalReport> {
        let found = self.axes.iter().filter_map(|turns| Some((turns.axis, turns.worst.as_ref()?)));
        found.map(|(axis, stretch)| report(axis, stretch)).collect()
    }
}

impl Turns {
    /// Adds a cycle to the section being recorded; the end of the cut also ends the section.
    fn record(&mut self, now: &Instant, sampled: bool, cutting: bool) {
        let Some(stretch) = &mut self.recording else { return };
        if sampled {
            stretch.largest_um = stretch.largest_um.max(now.compensated_um);
            stretch.instants.push(*now);
        }
        if now.time_s - stretch.turned_s >= AFTER_S || !cutting {
            let done = self.recording.take();
            let larger = |one: &Stretch, other: &Option<Stretch>| {
                other.as_ref().is_none_or(|other| one.largest_um > other.largest_um)
            };
            if done.as_ref().is_some_and(|done| larger(done, &self.worst)) {
                self.worst = done;
            }
        }
    }

    /// Time of the reversal, returned in the cycle in which the command has come back far enough to detect it.
    fn turned(&mut self, command: f64, time_s: f64) -> Option<f64> {
        let furthest = self.furthest.get_or_insert(Furthest { command, time_s, direction: 0.0 });
        let moved = command - furthest.command;
        if moved == 0.0 || moved.signum() == furthest.direction {
            (furthest.command, furthest.time_s) = (command, time_s);
            return None;
        }
        if moved.abs() <= TURNED {
            return None;
        }
        let before = std::mem::replace(furthest, Furthest { command, time_s, direction: moved.signum() });
        (before.direction != 0.0).then_some(before.time_s)
    }
}

fn report(axis: Axis, stretch: &Stretch) -> ReversalReport {
    let at = |value: &dyn Fn(&Instant) -> f32| -> Vec<[f64; 2]> {
        let points = stretch.instants.iter().map(|now| [1e3 * (now.time_s - stretch.turned_s), value(now).into()]);
        points.collect()
    };
    let i = axis.index();
    ReversalReport {
        axis: axis.letter().into(),
        rotary: axis.is_rotary(),
        line: stretch.line,
        time_s: stretch.turned_s,
        sent: at(&|now| now.dynamic.sent[i]),
        feed_forward: at(&|now| now.dynamic.feed_forward[i]),
        feedback: at(&|now| now.dynamic.feedback[i]),
        crosstalk: at(&|now| now.dynamic.crosstalk[i]),
        compensated_um: at(&|now| now.compensated_um),
        full_um: at(&|now| now.full_um),
    }
}
