//! Samples of the motion at the servo period.

use super::Motion;
use super::arc_length::ArcLength;
use super::profile::{Phase, Planner};
use crate::program::{Polar, Program};

/// Command of one servo cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint {
    /// C(u) of the move, mm.
    pub position: [f64; 3],
    /// A, B, C, degrees.
    pub rotary: [f64; 3],
    /// `feed` times the unit tangent, mm/s; zero in moves measured in degrees.
    pub velocity: [f64; 3],
    /// Index into [`Program::moves`](crate::program::Program).
    pub move_index: usize,
    /// Parameter on the curve of that move.
    pub u: f64,
    /// Arc length from the beginning of the program, mm (degrees in moves measured in degrees).
    pub length: f64,
    /// Speed along the path, mm/s (deg/s).
    pub feed: f64,
}

/// Progress along a motion. Borrows neither motion nor program, so that one owner can move all three.
#[derive(Debug)]
pub struct Walk {
    cycle: u64,
    planner: Planner,
    /// Number of sections planned so far, the phases of the last one, and the index of the current phase.
    section: usize,
    phases: Vec<Phase>,
    phase: usize,
    element: usize,
    /// Tables of the current move.
    table: Option<(ArcLength, Option<Polar>)>,
    node: usize,
}

impl Walk {
    /// State before the first setpoint of a motion.
    pub fn new(motion: &Motion) -> Walk {
        Walk {
            cycle: 0,
            planner: Planner::new(&motion.settings),
            section: 0,
            phases: Vec::new(),
            phase: 0,
            element: 0,
            table: None,
            node: 0,
        }
    }

    /// The next setpoint; `None` at the end. Motion and program must be those of the previous calls.
    pub fn next(&mut self, motion: &Motion, program: &Program) -> Option<Setpoint> {
        if self.cycle >= motion.cycles {
            return None;
        }
        // Computed from the cycle number, not by adding periods: no drift, and equal in every run.
        let time = (self.cycle as f64 - super::DWELL_CYCLES as f64) * motion.settings.period_s;
        self.cycle += 1;
        let (length, feed) = self.progress(motion, time);
        while self.element + 1 < motion.starts.len() && motion.starts[self.element + 1] <= length {
            self.element += 1;
            self.node = 0;
            self.table = None;
        }
        let element = program.moves.get(self.element)?;
        let curve = &element.curve;
        let along = (length - motion.starts[self.element]).max(0.0);
        let (table, polar) = self.table.get_or_insert_with(|| (ArcLength::of(element), curve.polar()));
        let u = table.parameter(along, &mut self.node);
        let (position, first, _) = curve.vectors_by(polar.as_ref(), u);
        let along = if element.in_degrees() { 0.0 } else { feed };
        let velocity = along * first.try_normalize().unwrap_or_default();
        Some(Setpoint {
            position: position.into(),
            rotary: element.rotary(u),
            velocity: velocity.into(),
            move_index: self.element,
            u,
            length,
            feed,
        })
    }

    /// The phase at a time from the beginning of the motion, s; `None` at its end.
    fn phase_at(&mut self, motion: &Motion, time: f64) -> Option<Phase> {
        loop {
            while let Some(phase) = self.phases.get(self.phase) {
                if phase.end > time {
                    return Some(*phase);
                }
                self.phase += 1;
            }
            let section = motion.sections.get(self.section)?;
            let ends = [*motion.speeds.get(self.section)?, *motion.speeds.get(self.section + 1)?];
            // Cannot fail: the section was already planned with the motion, with the same result.
            self.planner.section(section, ends, &mut self.phases).ok()?;
            self.section += 1;
            self.phase = 0;
        }
    }

    /// Arc length and speed at a time from the beginning of the motion, s.
    fn progress(&mut self, motion: &Motion, time: f64) -> (f64, f64) {
        if time <= 0.0 {
            return (0.0, 0.0);
        }
        // Rounding of the planner may leave a speed of −1e-9 at a stop.
        self.phase_at(motion, time).map_or((motion.length, 0.0), |phase| {
            let (length, speed) = phase.at(time);
            (length, speed.max(0.0))
        })
    }
}

/// The setpoints of a motion in order, one per cycle.
#[derive(Debug)]
pub struct Setpoints<'m> {
    motion: &'m Motion,
    program: &'m Program,
    walk: Walk,
}

impl<'m> Setpoints<'m> {
    pub(super) fn new(motion: &'m Motion, program: &'m Program) -> Self {
        Setpoints { motion, program, walk: Walk::new(motion) }
    }
}

impl Iterator for Setpoints<'_> {
    type Item = Setpoint;

    fn next(&mut self) -> Option<Setpoint> {
        self.walk.next(self.motion, self.program)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = usize::try_from(self.motion.cycles - self.walk.cycle).unwrap_or(usize::MAX);
        (left, Some(left))
    }
}

impl ExactSizeIterator for Setpoints<'_> {}
