//! The machines of a run side by side, for one number of slots of the step.

use super::Driven;
use super::cell::{Cell, Shared};
use super::commanded::{Commanded, Commander};
use super::kind::Kind;
use super::plugin::Plugin;
use super::sample::{Sample, Sink};
use super::tally::Tallies;
use crate::error::{Result, SimError};
use crate::event::{Act, Event, EventKind, Switch};
use crate::motion::Motion;
use crate::plant::PlantError;
use crate::plant::fault::first_cycle;
use crate::scenario::Scenario;
use crate::servo::{Axes, Compiled, Owned};
use std::collections::BTreeMap;
use std::sync::Arc;
use trueaxis_tables::Machine;

/// Cycles that are commanded at a time and then simulated machine by machine: enough that each machine has the processor's
/// caches to itself for a while, few enough to fit in them.
const BLOCK: usize = 256;

/// A run whose number of slots is not part of its type.
pub(super) trait Advance {
    fn advance(&mut self, cycles: u64, sink: &mut dyn Sink) -> bool;
    fn cycle(&self) -> u64;
    fn cycles(&self) -> u64;
    fn tallies(&self) -> Vec<Tallies>;
    fn act(&mut self, act: &Act, machines: &BTreeMap<String, Machine>) -> Result<()>;
}

/// Effect of an event, ready to be applied.
enum EventEffect<S, const N: usize> {
    Switch(Switch, bool),
    ResetAdaptation,
    Exchange(Box<Plugin<S, N>>),
}

/// Machines that get the same commands.
pub(super) struct Lanes<S, const N: usize> {
    scenario: Arc<Scenario>,
    /// Plugin with the scenario's tables, and with the tables last exchanged: the latter drives the machines whose plugin is
    /// enabled.
    plugin: Plugin<S, N>,
    exchanged: Option<Plugin<S, N>>,
    /// Pending events in order, each with the cycle before which it acts.
    effects: Vec<(u64, EventEffect<S, N>)>,
    commander: Commander,
    cells: Vec<Cell<N>>,
    settled: bool,
    block: Vec<Commanded>,
    /// Samples of the block, one list per machine.
    samples: Vec<Vec<Sample>>,
}

impl<S: Owned<N> + 'static, const N: usize> Lanes<S, N>
where
    Axes: Compiled<N>,
{
    pub(super) fn boxed(
        scenario: Arc<Scenario>,
        motion: Motion,
        machines: &[Driven],
    ) -> Result<Box<dyn Advance + Send>> {
        let kinds: Vec<Kind> = machines.iter().map(|(kind, _)| *kind).collect();
        let plugin = Plugin::<S, N>::of(&scenario, &kinds)?;
        let with_servo = machines.iter().filter_map(|machine| Some((machine, plugin.servo(machine.0)?)));
        let cells = with_servo
            .map(|(machine, servo)| Cell::new(&scenario, *machine, servo.servo(), plugin.about()))
            .collect::<Result<_>>()?;
        let mut lanes = Lanes {
            commander: Commander::new(&scenario, motion),
            plugin,
            exchanged: None,
            effects: Vec::new(),
            cells,
            settled: false,
            block: Vec::with_capacity(BLOCK),
            samples: machines.iter().map(|_| Vec::with_capacity(BLOCK)).collect(),
            scenario: Arc::clone(&scenario),
        };
        for event in &scenario.settings.events.items {
            lanes.plan(event, &scenario.exchanges)?;
        }
        Ok(Box::new(lanes))
    }

    /// Inserts an event into the pending ones, after those of the same cycle.
    fn plan(&mut self, event: &Event, machines: &BTreeMap<String, Machine>) -> Result<()> {
        let effect = match &event.kind {
            EventKind::On(switch) => EventEffect::Switch(*switch, true),
            EventKind::Off(switch) => EventEffect::Switch(*switch, false),
            EventKind::ResetAdaptation => EventEffect::ResetAdaptation,
            EventKind::Exchange(name) => {
                let machine = named(machines, name)?;
                let kinds: Vec<Kind> = self.cells.iter().map(Cell::kind).collect();
                EventEffect::Exchange(Box::new(Plugin::exchanged(&self.scenario, name, machine, &kinds)?))
            }
        };
        let cycle = first_cycle(event.at_s, self.scenario.period_s());
        let place = self.effects.partition_point(|(before, _)| *before <= cycle);
        self.effects.insert(place, (cycle, effect));
        Ok(())
    }

    /// Applies the events that are due before the next cycle.
    fn do_what_is_due(&mut self) {
        let due = self.effects.partition_point(|(cycle, _)| *cycle <= self.commander.cycle);
        for (_, effect) in self.effects.drain(..due) {
            match effect {
                EventEffect::Switch(what, on) => self.cells.iter_mut().for_each(|cell| cell.switch(what, on)),
                EventEffect::ResetAdaptation => self.cells.iter_mut().for_each(Cell::reset_adaptation),
                EventEffect::Exchange(plugin) => {
                    let driven = self.cells.iter_mut().filter(|cell| plugin.servo(cell.kind()).is_some());
                    driven
                        .filter(|cell| cell.kind().enables_the_plugin())
                        .for_each(|cell| cell.take_over(plugin.about()));
                    self.exchanged = Some(*plugin);
                }
            }
        }
    }

    /// Cycles until the next event, at most `most`.
    fn undisturbed(&self, most: u64) -> u64 {
        self.effects.first().map_or(most, |(cycle, _)| most.min(cycle - self.commander.cycle))
    }

    /// Lets the correction ramp in, as on a machine that is switched on before it cuts.
    fn settle(&mut self, sink: &mut dyn Sink) {
        self.settled = true;
        let Ok(Some(first)) = self.commander.first(&self.scenario) else { return };
        for (number, cell) in self.cells.iter_mut().enumerate() {
            let Some(servo) = self.plugin.servo(cell.kind()) else { continue };
            let shared = Shared { scenario: &self.scenario, servo: servo.servo(), path: &self.commander.path };
            cell.settle(number, &first, &shared, sink);
        }
    }

    fn has_ended(&self) -> bool {
        self.commander.is_done() || self.cells.iter().all(Cell::has_ended)
    }

    /// Runs the commands of the block through one machine after the other, then passes the samples to the sink.
    fn simulate_block(&mut self, sink: &mut dyn Sink) {
        for (number, (cell, samples)) in self.cells.iter_mut().zip(&mut self.samples).enumerate() {
            samples.clear();
            let exchanged = self.exchanged.as_ref().filter(|_| cell.kind().enables_the_plugin());
            let Some(servo) = exchanged.unwrap_or(&self.plugin).servo(cell.kind()) else { continue };
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

impl<S: Owned<N> + 'static, const N: usize> Advance for Lanes<S, N>
where
    Axes: Compiled<N>,
{
    fn advance(&mut self, cycles: u64, sink: &mut dyn Sink) -> bool {
        if !self.settled {
            self.settle(sink);
        }
        let mut left = cycles;
        while left > 0 && !self.has_ended() {
            self.do_what_is_due();
            let most = self.undisturbed(left.min(BLOCK as u64)) as usize;
            // Cannot fail: the run's constructor has already converted every move.
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

    fn act(&mut self, act: &Act, machines: &BTreeMap<String, Machine>) -> Result<()> {
        check(act, &self.scenario, (!self.has_ended()).then_some(self.commander.cycle))?;
        match act {
            Act::Event(event) => self.plan(event, machines),
            Act::Fault(fault) => self.cells.iter_mut().try_for_each(|cell| cell.inject(*fault)),
        }
    }
}

// The functions below do not depend on the number of slots, so they are compiled once.

/// The machine of that name among those that provide tables for an exchange.
fn named<'m>(machines: &'m BTreeMap<String, Machine>, name: &str) -> Result<&'m Machine> {
    machines.get(name).ok_or_else(|| {
        SimError::unsuited(format!("exchange:{name}"), "no machine of that name", "one given with the scenario")
    })
}

/// Checks whether an act is possible in a run whose next cycle is `now`; `None`: the run has ended.
fn check(act: &Act, scenario: &Scenario, now: Option<u64>) -> Result<()> {
    let at_s = match act {
        Act::Fault(fault) => fault.at_s,
        Act::Event(event) => event.at_s,
    };
    let refused = |found: String, needed: String| Err(SimError::unsuited(act.to_string(), found, needed));
    match now {
        None => return refused("a run that has ended".to_owned(), "one under way".to_owned()),
        Some(now) if first_cycle(at_s, scenario.period_s()) < now => {
            return refused(format!("{at_s} s"), format!("a time from {} s on", scenario.time_s(now)));
        }
        Some(_) => {}
    }
    let has = |axis| scenario.machine.settings.axis(axis).is_some();
    match act {
        Act::Fault(fault) => match fault.kind.axis().filter(|axis| !has(*axis)) {
            Some(axis) => Err(PlantError::FaultAxis { axis: axis.letter() }.into()),
            None => Ok(()),
        },
        Act::Event(_) => Ok(()),
    }
}
