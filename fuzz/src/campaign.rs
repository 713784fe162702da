//! The seeded loop: the same target, seed and corpus give the same inputs in the same order on every computer.

use crate::Target;
use crate::execution::execute;
use crate::finding::Finding;
use crate::mutate::{Mutator, dictionary};
use serde::Serialize;
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Most inputs kept in addition to seeds and corpus.
const MOST_KEPT: usize = 4096;

/// When to end a loop that has no finding.
#[derive(Clone, Copy, Debug)]
pub enum Until {
    /// After this many executions: repeats exactly.
    Executions(u64),
    /// After this much time.
    Elapsed(Duration),
}

/// Statistics of a loop.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Tally {
    /// Inputs run.
    pub executions: u64,
    /// Executions that accepted their input.
    pub accepted: u64,
    /// Different outcomes.
    pub outcomes: u64,
    /// Inputs to mutate: seeds, corpus, and those kept for a new outcome.
    pub inputs: u64,
    /// Time, s.
    pub seconds: f64,
}

impl Tally {
    /// Executions per second.
    pub fn rate(&self) -> f64 {
        if self.seconds > 0.0 { self.executions as f64 / self.seconds } else { 0.0 }
    }
}

/// A loop over one target.
pub struct Campaign<'t> {
    target: &'t Target,
    seed: u64,
    mutator: Mutator,
    inputs: Vec<Vec<u8>>,
    given: usize,
    outcomes: HashSet<u64>,
    tally: Tally,
    input: Vec<u8>,
}

impl<'t> Campaign<'t> {
    /// Creates a loop that begins with `inputs`: the target's seeds and corpus.
    pub fn new(target: &'t Target, seed: u64, mut inputs: Vec<Vec<u8>>) -> Campaign<'t> {
        let mutator = Mutator::new(seed, dictionary(target.dictionary), target.longest());
        if inputs.is_empty() {
            inputs.push(Vec::new());
        }
        let (given, outcomes, input) = (inputs.len(), HashSet::new(), Vec::new());
        Campaign { target, seed, mutator, inputs, given, outcomes, tally: Tally::default(), input }
    }

    /// Runs to the end or to the first finding. `before_each` runs before every execution and may stop the loop.
    ///
    /// # Errors
    /// The finding.
    pub fn run(
        &mut self,
        until: Until,
        before_each: &mut dyn FnMut(&Tally, &[u8]) -> ControlFlow<()>,
    ) -> Result<Tally, Box<Finding>> {
        let start = Instant::now();
        loop {
            let over = match until {
                Until::Executions(most) => self.tally.executions >= most,
                Until::Elapsed(most) => start.elapsed() >= most,
            };
            self.tally.seconds = start.elapsed().as_secs_f64();
            if over {
                return Ok(self.tally);
            }
            self.next_input();
            if before_each(&self.tally, &self.input).is_break() {
                return Ok(self.tally);
            }
            self.execute()?;
        }
    }

    /// Selects the next input: first the given ones, unchanged; then mutants, most of them repaired.
    fn next_input(&mut self) {
        let number = self.tally.executions as usize;
        if number < self.given {
            self.input.clone_from(&self.inputs[number]);
            return;
        }
        let count = self.inputs.len();
        let (one, other) = (self.mutator.below(count), self.mutator.below(count));
        self.input.clone_from(&self.inputs[one]);
        self.mutator.mutate(&mut self.input, &self.inputs[other]);
        if !self.mutator.once_in(8) {
            (self.target.repair)(&mut self.input);
        }
    }

    fn execute(&mut self) -> Result<(), Box<Finding>> {
        let ended = execute(self.target, &self.input);
        let outcome = ended.map_err(|what| {
            let (target, execution) = (self.target.name, self.tally.executions);
            Box::new(Finding { target, seed: self.seed, execution, what, input: self.input.clone() })
        })?;
        let number = self.tally.executions as usize;
        self.tally.executions += 1;
        self.tally.accepted += u64::from(outcome.accepted);
        let room = self.inputs.len() - self.given < MOST_KEPT;
        if room && self.outcomes.insert(outcome.class) && number >= self.given {
            self.inputs.push(self.input.clone());
        }
        self.tally.outcomes = self.outcomes.len() as u64;
        self.tally.inputs = self.inputs.len() as u64;
        Ok(())
    }
}
