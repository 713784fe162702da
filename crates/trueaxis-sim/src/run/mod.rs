//! Runs of a part program: every servo cycle goes through the step against one or more simulated machines.

mod cell;
mod columns;
mod commanded;
mod document;
mod figures;
mod kind;
mod lanes;
mod limits;
mod plugin;
mod sample;
mod sampled;
mod tally;
mod withdrawn;

use crate::error::Result;
use crate::event::Act;
use crate::plant::drive::DriveSettings;
use crate::scenario::Scenario;
use crate::{path, servo};
use lanes::{Advance, Lanes};
use std::collections::BTreeMap;
use std::sync::Arc;
use trueaxis::machine::AXES;
use trueaxis_tables::Machine;

/// A machine of a run: how it is driven, and the drives in the order X Y Z A B C if they are not those of the settings.
type Driven = (Kind, Option<[DriveSettings; AXES]>);

pub use columns::{Column, columns};
pub use document::{RunDocument, notes};
pub use figures::{ByKind, Figures, FrictionFactors, ReportedFault, Size};
pub use kind::{Kind, feedback_refused};
pub use limits::CorrectionLimits;
pub use sample::{DynamicSample, Given, Moment, Sample, Sink};
pub use tally::{AngleSize, ErrorSize, FaultSpan, MOST_FAULT_SPANS, Tallies};
pub use withdrawn::Withdrawn;

/// A simulation in progress: program, motion, servo loop with its tables, plants and their state, owned together.
///
/// It can be paused between any two cycles, sent to another thread and resumed; the cycles do not depend on how they are
/// divided. Memory: a block of cycles and a stretch of the path, however long the program is.
pub struct Run(Box<dyn Advance + Send>);

impl Run {
    /// Sets up the scenario on the machines of [`Kind::of`], side by side.
    ///
    /// # Errors
    /// As [`Run::of`].
    pub fn new(scenario: impl Into<Arc<Scenario>>) -> Result<Run> {
        let scenario = scenario.into();
        let kinds = Kind::of(&scenario.machine.settings);
        Run::of(scenario, kinds)
    }

    /// Sets up the scenario on the requested machines, side by side.
    ///
    /// # Errors
    /// The motion cannot be planned, a move is not a valid path, the machine's tables do not build, a fault names an axis that
    /// the machine does not have, or an event names an unknown machine or the tables of another one.
    pub fn of(scenario: impl Into<Arc<Scenario>>, kinds: &[Kind]) -> Result<Run> {
        Run::driven(scenario.into(), &kinds.iter().map(|kind| (*kind, None)).collect::<Vec<_>>())
    }

    /// Sets up the scenario on machines of one kind that differ in their drives, side by side: each entry, in the order
    /// X Y Z A B C, replaces the drives of the settings on one machine.
    ///
    /// # Errors
    /// As [`Run::of`], and for drives whose figures do not agree with each other.
    pub fn with_drives(
        scenario: impl Into<Arc<Scenario>>,
        kind: Kind,
        drives: &[[DriveSettings; AXES]],
    ) -> Result<Run> {
        Run::driven(scenario.into(), &drives.iter().map(|drives| (kind, Some(*drives))).collect::<Vec<_>>())
    }

    fn driven(scenario: Arc<Scenario>, machines: &[Driven]) -> Result<Run> {
        let motion = scenario.motion()?;
        path::check(&scenario)?;
        Ok(Run(match scenario.machine.settings.step_axes().count() {
            3 => Lanes::<servo::three::Cell, 3>::boxed(scenario, motion, machines)?,
            _ => Lanes::<servo::six::Cell, 6>::boxed(scenario, motion, machines)?,
        }))
    }

    /// Simulates at most `cycles` further cycles and passes each to `sink`; returns `false` at the end of the program, or once
    /// every machine has stopped. Before the first cycle the machines settle at the first point.
    pub fn advance(&mut self, cycles: u64, sink: &mut dyn Sink) -> bool {
        self.0.advance(cycles, sink)
    }

    /// Adds a fault or an event at its time, from the next cycle on: the results are bit for bit those of a scenario that
    /// lists it last. `machines`: the machines whose tables an exchange may use, by the name in the event.
    ///
    /// The current time of the run is that of the next cycle, [`Scenario::time_s`].
    ///
    /// # Errors
    /// A time in the past, a run that has ended, an axis that the machine does not have, tables of another machine or tables
    /// that do not build. The run is then unchanged.
    pub fn act(&mut self, act: &Act, machines: &BTreeMap<String, Machine>) -> Result<()> {
        self.0.act(act, machines)
    }

    /// Cycles simulated so far.
    pub fn cycle(&self) -> u64 {
        self.0.cycle()
    }

    /// Cycles of the whole program.
    pub fn cycles(&self) -> u64 {
        self.0.cycles()
    }

    /// Figures of every machine so far, in the order requested.
    pub fn tallies(&self) -> Vec<Tallies> {
        self.0.tallies()
    }
}

impl std::fmt::Debug for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Run").field("cycle", &self.cycle()).field("cycles", &self.cycles()).finish_non_exhaustive()
    }
}
