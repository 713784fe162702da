//! The commands of a program, cycle by cycle, with the stretch of the path that belongs to them.

use super::sample::Moment;
use crate::error::Result;
use crate::motion::{Motion, Setpoint, Walk};
use crate::path::SlidingPath;
use crate::scenario::Scenario;
use glam::DVec3;
use trueaxis::contour::Reference;
use trueaxis::machine::AXES;

/// Command of one cycle.
pub(super) struct Commanded {
    pub(super) moment: Moment,
    pub(super) setpoint: Setpoint,
    /// Indexed by [`Axis::index`](trueaxis::Axis::index), mm and degrees.
    pub(super) positions: [f64; AXES],
    pub(super) reference: Reference<f64>,
}

/// Generates the commands of a scenario, a block at a time.
pub(super) struct Commander {
    motion: Motion,
    walk: Walk,
    next: Option<Setpoint>,
    pub(super) path: SlidingPath,
    span: u32,
    /// Cycles commanded so far.
    pub(super) cycle: u64,
}

impl Commander {
    pub(super) fn new(scenario: &Scenario, motion: Motion) -> Self {
        let mut walk = Walk::new(&motion);
        let next = walk.next(&motion, &scenario.program);
        Commander { motion, walk, next, path: SlidingPath::new(scenario), span: 0, cycle: 0 }
    }

    /// Number of cycles of the whole program.
    pub(super) fn cycles(&self) -> u64 {
        self.motion.cycles()
    }

    /// Whether the last cycle has been commanded.
    pub(super) fn is_done(&self) -> bool {
        self.next.is_none()
    }

    /// Start of the program: the command of its first cycle, which is not consumed.
    pub(super) fn first(&mut self, scenario: &Scenario) -> Result<Option<Commanded>> {
        let Some(setpoint) = self.next else { return Ok(None) };
        self.path.cover(scenario, [setpoint.move_index; 2])?;
        Ok(Some(self.commanded(scenario, setpoint)))
    }

    /// Replaces the cycles in `block` by the next ones, at most `most`.
    pub(super) fn next_block(&mut self, scenario: &Scenario, block: &mut Vec<Commanded>, most: usize) -> Result<()> {
        block.clear();
        let first = self.next.map_or(0, |setpoint| setpoint.move_index);
        let mut last = first;
        while block.len() < most
            && let Some(setpoint) = self.next
        {
            self.next = self.walk.next(&self.motion, &scenario.program);
            last = last.max(setpoint.move_index);
            self.path.cover(scenario, [first, last])?;
            let commanded = self.commanded(scenario, setpoint);
            block.push(commanded);
            self.cycle += 1;
        }
        Ok(())
    }

    fn commanded(&mut self, scenario: &Scenario, setpoint: Setpoint) -> Commanded {
        let step = scenario.program.moves.get(setpoint.move_index);
        let nominal = match step {
            Some(step) if scenario.five_axis => scenario.placement.place(step, setpoint.u).tip,
            _ => DVec3::from(setpoint.position) + DVec3::from(scenario.origin_mm),
        };
        Commanded {
            moment: Moment {
                cycle: self.cycle,
                time_s: self.cycle as f64 * scenario.period_s(),
                line: step.map_or(0, |step| step.line),
                cutting: step.is_some_and(|step| !step.rapid),
                length_mm: setpoint.length,
                nominal_mm: nominal.to_array(),
                rotary_deg: setpoint.rotary,
                move_index: setpoint.move_index,
                u: setpoint.u,
            },
            positions: scenario.axis_positions(&setpoint),
            reference: self.path.reference(setpoint.move_index, setpoint.u, &mut self.span),
            setpoint,
        }
    }
}
