//! The machines of a run side by side, for one number of axes.

use super::cell::{Cell, Shared};
use super::commanded::{Commanded, Commander};
use super::sample::{Sample, Sink};
use super::{Kind, Tallies};
use crate::error::Result;
use crate::motion::Motion;
use crate::scenario::Scenario;
use crate::servo::Owned;
use std::sync::Arc;

/// Cycles that are commanded at a time, and then simulated machine by machine: enough that one after the other has the
/// processor's caches for itself, little enough to stay in them.
const BLOCK: usize = 256;

/// A run whose number of axes is no longer part of its type.
pub(super) trait Advance {
    fn advance(&mut self, cycles: u64, sink: &mut dyn Sink) -> bool;
    fn cycle(&self) -> u64;
    fn cycles(&self) -> u64;
    fn tallies(&self) -> Vec<Tallies>;
}

/// Machines that get the same commands.
pub(super) struct Lanes<S, const N: usize> {
    scenario: Arc<Scenario>,
    servo: S,
    commander: Commander<N>,
    cells: Vec<Cell<N>>,
    settled: bool,
    block: Vec<Commanded<N>>,
    /// Samples of the block, a list for every machine.
    samples: Vec<Vec<Sample>>,
}

impl<S: Owned<N> + 'static, const N: usize> Lanes<S, N> {
    pub(super) fn boxed(scenario: Arc<Scenario>, motion: Motion, kinds: &[Kind]) -> Result<Box<dyn Advance + Send>> {
        let servo = S::build(&scenario.machine, scenario.period_ns())?;
        let cells = kinds.iter().map(|kind| Cell::new(&scenario, *kind, servo.servo())).collect::<Result<_>>()?;
        Ok(Box::new(Lanes {
            commander: Commander::new(&scenario, motion)?,
            servo,
            cells,
            settled: false,
            block: Vec::with_capacity(BLOCK),
            samples: kinds.iter().map(|_| Vec::with_capacity(BLOCK)).collect(),
            scenario,
        }))
    }

    /// Leads the correction in, as a machine is switched on before it cuts.
    fn settle(&mut self, sink: &mut dyn Sink) {
        self.settled = true;
        let Ok(Some(first)) = self.commander.first(&self.scenario) else { return };
        let shared = Shared { scenario: &self.scenario, servo: self.servo.servo(), path: &self.commander.path };
        for (number, cell) in self.cells.iter_mut().enumerate() {
            cell.settle(number, &first, &shared, sink);
        }
    }

    fn has_ended(&self) -> bool {
        self.commander.is_done() || self.cells.iter().all(Cell::has_ended)
    }

    /// The commands in the block, through one machine after the other, then to the sink.
    fn simulate_block(&mut self, sink: &mut dyn Sink) {
        let shared = Shared { scenario: &self.scenario, servo: self.servo.servo(), path: &self.commander.path };
        for (number, (cell, samples)) in self.cells.iter_mut().zip(&mut self.samples).enumerate() {
            samples.clear();
            for commanded in &self.block {
                if cell.has_ended() {
                    break;
                }
                samples.push(cell.cycle(number, commanded, &shared, sink));
            }
        }
        let mut machines = vec![None; self.cells.len()];
        for (i, commanded) in self.block.iter().enumerate() {
            for (machine, samples) in machines.iter_mut().zip(&self.samples) {
                *machine = samples.get(i);
            }
            if machines.iter().any(Option::is_some) {
                sink.cycle(&commanded.moment, &machines);
            }
        }
    }
}

impl<S: Owned<N> + 'static, const N: usize> Advance for Lanes<S, N> {
    fn advance(&mut self, cycles: u64, sink: &mut dyn Sink) -> bool {
        if !self.settled {
            self.settle(sink);
        }
        let mut left = cycles;
        while left > 0 && !self.has_ended() {
            let most = usize::try_from(left).unwrap_or(BLOCK).min(BLOCK);
            // Every move was converted once when the run was made, with the same result.
            if self.commander.next_block(&self.scenario, &mut self.block, most).is_err() {
                return false;
            }
            self.simulate_block(sink);
            left -= self.block.len() as u64;
        }
        !self.has_ended()
    }

    fn cycle(&self) -> u64 {
        self.commander.cycle
    }

    fn cycles(&self) -> u64 {
        self.commander.cycles()
    }

    fn tallies(&self) -> Vec<Tallies> {
        self.cells.iter().map(Cell::tallies).collect()
    }
}
