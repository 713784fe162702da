//! The machines of a run side by side, for one number of axes.

use super::cell::{Cell, Shared};
use super::commanded::{Commanded, Commander};
use super::kind::{Kind, Parts};
use super::sample::{Sample, Sink};
use super::tally::Tallies;
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

/// One servo loop for each set of parts that a machine is driven with.
struct Servos<S>(Vec<(Parts, S)>);

impl<S> Servos<S> {
    fn build<const N: usize>(scenario: &Scenario, kinds: &[Kind]) -> Result<Servos<S>>
    where
        S: Owned<N>,
    {
        let mut servos: Vec<(Parts, S)> = Vec::new();
        for parts in kinds.iter().map(|kind| kind.parts()) {
            if servos.iter().all(|(built, _)| *built != parts) {
                let machine = parts.of(&scenario.machine, scenario.period_s())?;
                servos.push((parts, S::build(&machine, scenario.period_ns())?));
            }
        }
        Ok(Servos(servos))
    }

    fn of(&self, kind: Kind) -> Option<&S> {
        self.0.iter().find(|(parts, _)| *parts == kind.parts()).map(|(_, servo)| servo)
    }
}

/// Machines that get the same commands.
pub(super) struct Lanes<S, const N: usize> {
    scenario: Arc<Scenario>,
    servos: Servos<S>,
    commander: Commander<N>,
    cells: Vec<Cell<N>>,
    settled: bool,
    block: Vec<Commanded<N>>,
    /// Samples of the block, a list for every machine.
    samples: Vec<Vec<Sample>>,
}

impl<S: Owned<N> + 'static, const N: usize> Lanes<S, N> {
    pub(super) fn boxed(scenario: Arc<Scenario>, motion: Motion, kinds: &[Kind]) -> Result<Box<dyn Advance + Send>> {
        let servos = Servos::<S>::build(&scenario, kinds)?;
        let with_servo = kinds.iter().filter_map(|kind| Some((kind, servos.of(*kind)?)));
        let cells =
            with_servo.map(|(kind, servo)| Cell::new(&scenario, *kind, servo.servo())).collect::<Result<_>>()?;
        Ok(Box::new(Lanes {
            commander: Commander::new(&scenario, motion)?,
            servos,
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
        for (number, cell) in self.cells.iter_mut().enumerate() {
            let Some(servo) = self.servos.of(cell.kind()) else { continue };
            let shared = Shared { scenario: &self.scenario, servo: servo.servo(), path: &self.commander.path };
            cell.settle(number, &first, &shared, sink);
        }
    }

    fn has_ended(&self) -> bool {
        self.commander.is_done() || self.cells.iter().all(Cell::has_ended)
    }

    /// The commands in the block, through one machine after the other, then to the sink.
    fn simulate_block(&mut self, sink: &mut dyn Sink) {
        for (number, (cell, samples)) in self.cells.iter_mut().zip(&mut self.samples).enumerate() {
            samples.clear();
            let Some(servo) = self.servos.of(cell.kind()) else { continue };
            let shared = Shared { scenario: &self.scenario, servo: servo.servo(), path: &self.commander.path };
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
