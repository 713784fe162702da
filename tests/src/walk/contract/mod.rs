//! The contract of the step, as an external oracle: given the configuration, the previous cycle, this input and this output,
//! what must and may follow. Written from the documentation; it knows the ends of the tables, but not their values.

mod dynamic;
mod expect;
mod gauge;
mod limits;
mod measured;
mod moving;
mod record;

use super::device::{Device, Ground, Moment, Outcome};
use super::facts::Facts;
use super::rule::{Broken, Tally};
use super::scalar::{Place, Scalar};
use dynamic::Parts;
use expect::Senses;
use gauge::GaugeMemory;
use limits::Motion;
use measured::WindowMemory;
use trueaxis::{Fault, Position};

/// Required treatment of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Not homed or not enabled.
    Inactive,
    /// Corrected.
    Active,
    /// A reading is refused; corrections are frozen.
    Frozen,
    /// The output holds.
    Held,
    /// The output should hold, but none exists.
    NoOutput,
}

impl Verdict {
    /// Whether the drives get nothing new.
    pub(super) fn holds(self) -> bool {
        matches!(self, Verdict::Held | Verdict::NoOutput)
    }
}

/// A cycle and its results.
#[derive(Debug)]
pub(super) struct Seen<'c, 'a, R: Scalar, P: Place, const N: usize> {
    /// Constants of the leg.
    pub ground: &'c Ground<'a, R, P, N>,
    /// The configuration in force.
    pub facts: &'c Facts<P, N>,
    /// Whether it was exchanged in this cycle.
    pub exchanged: bool,
    /// Inputs of the cycle.
    pub moment: &'c Moment<R, P, N>,
    /// Outputs of the cycle.
    pub outcome: &'c Outcome<R, P, N>,
    /// State after the cycle.
    pub device: &'c Device<R, P, N>,
}

/// State of the contract between cycles.
#[derive(Clone, Debug)]
pub(super) struct Contract<R: Scalar, P: Place, const N: usize> {
    /// Number of times each rule was checked.
    pub tally: Tally,
    senses: Senses<P, N>,
    motion: Motion<R, P, N>,
    parts: Parts<R, N>,
    window: WindowMemory,
    gauge: GaugeMemory<R>,
    next: Option<u32>,
    /// Bound on the thermal growth of a lookup, mm (deg), by slot.
    grown: [f64; N],
}

impl<R: Scalar, P: Place, const N: usize> Default for Contract<R, P, N> {
    fn default() -> Self {
        Contract {
            tally: Tally::default(),
            senses: Senses::default(),
            motion: Motion::default(),
            parts: Parts::default(),
            window: WindowMemory::default(),
            gauge: GaugeMemory::default(),
            next: None,
            grown: [0.0; N],
        }
    }
}

impl<R: Scalar, P: Place, const N: usize> Contract<R, P, N> {
    /// Checks a cycle, given all earlier ones.
    ///
    /// # Errors
    /// The first broken rule.
    pub(super) fn check(&mut self, seen: &Seen<'_, '_, R, P, N>) -> Result<Verdict, Broken> {
        self.record(seen)?;
        let first = !self.senses.started;
        let mut verdict = self.senses.expect(&mut self.tally, seen)?;
        let decided = verdict;
        let record = &seen.outcome.output.record;
        if record.fault == Fault::JointRange && !verdict.holds() {
            self.joint_range(seen, verdict, first)?;
            self.senses.latch((Fault::JointRange, record.fault_axis));
            verdict = Verdict::Held;
        }
        self.by_verdict(seen, verdict)?;
        self.follow(seen, verdict, first)?;
        self.dynamic(seen, verdict, first)?;
        // The feedback acts before the output stage detects that a joint would leave its range.
        self.watch(seen, decided, first)?;
        self.measured(seen, verdict, first)?;
        self.gauged(seen, verdict)?;
        if !verdict.holds() {
            self.senses.held = seen.moment.input.command;
        }
        Ok(verdict)
    }

    /// Resets the memory of the gauge.
    pub(super) fn restart_gauge(&mut self) {
        self.gauge = GaugeMemory::default();
    }

    /// Whether all corrections have reached zero.
    pub(super) fn is_at_zero(&self) -> bool {
        self.motion.is_at_zero()
    }

    /// Whether a stop is requested, and the held command.
    pub(super) fn held(&self) -> (bool, [P; N]) {
        (self.senses.latched.is_some(), self.senses.held)
    }
}

/// Distance of two positions, mm (deg).
#[inline(always)]
fn apart<P: Position>(a: P, b: P) -> f64 {
    (a.to_f64() - b.to_f64()).abs()
}
