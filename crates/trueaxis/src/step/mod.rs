//! The servo cycle: the pipeline of named stages, and the only module that knows their order.

#![deny(clippy::indexing_slicing)]

mod bypass;
mod config;
mod dynamic;
mod gauge;
mod measure;
mod model;
mod rtcp;
mod state;
mod stateless;
mod tables;

pub use bypass::Bypass;
pub use config::Config;
pub use gauge::{GaugeRide, Ride};
pub use measure::{Measure, OnToolPath};
pub use state::{Output, Stage, State};
pub use stateless::Conditions;

use crate::compensation::volumetric::TangentCache;
use crate::compensation::{Cells, Compensation, NearGrids, Reversal, Tables, ThermalLine};
use crate::contour::{ContourSearch, PairState};
use crate::dynamic::{DynamicStage, DynamicState};
use crate::error::Fault;
use crate::machine::AxisOrder;
use crate::output::{Applied, Outlets, OutputStage, OutputState};
use crate::part;
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Input, Sample, SampleState, Sampler, Verdict};
use crate::telemetry::{Record, Status};

/// Immutable half of the servo loop: limits, tables, search settings.
///
/// A host may use one loop for ever, or exchange it for another between two cycles ([`crate::exchange::Exchange`]); the
/// state continues, and the limiter makes the change bumpless. `R` is the scalar of the step, `P` that of positions,
/// `N` the number of axes: [`crate::HostServo`] and [`crate::McuServo`] name the usual ones.
#[derive(Clone, Copy, Debug)]
pub struct ServoLoop<'a, R, P: Position, const N: usize> {
    order: AxisOrder<N>,
    sampler: Sampler<R, P, N>,
    compensation: Compensation<'a, R, P, N>,
    tables: Tables<R, P>,
    bands: [R; N],
    /// `bands` in position steps, rounded down.
    within: [P::Reach; N],
    search: ContourSearch<R>,
    output: OutputStage<R, P, N>,
    /// `None` if no part is configured.
    dynamic: Option<DynamicStage<R, P, N>>,
    machine_id: u32,
    tables_crc: u32,
    period_ns: u32,
}

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// Creates the state before the first cycle.
    pub fn start(&self) -> State<R, P, N> {
        State {
            sample: SampleState::new(),
            reversal: [Reversal::default(); N],
            homed: false,
            thermal: [ThermalLine::default(); N],
            cells: Cells::empty(),
            poses: TangentCache::empty(),
            grids: NearGrids::empty(),
            feet: PairState::default(),
            output: OutputState::new(),
            dynamic: DynamicState::new(),
            limited: 0,
            sequence: 0,
        }
    }

    /// The configured servo period.
    pub fn period_ns(&self) -> u32 {
        self.period_ns
    }

    /// Checks that the host's period, measured or nominal, equals the configured one within 0.1 %.
    ///
    /// # Errors
    /// [`Fault::PeriodMismatch`]: run [`Bypass`] with it.
    pub fn check_period(&self, period_ns: u32) -> Result<(), Fault> {
        if period_ns.abs_diff(self.period_ns) > self.period_ns / 1000 {
            return Err(Fault::PeriodMismatch);
        }
        Ok(())
    }

    /// Creates the input of an on-time cycle, with all axes homed and compensation enabled; positions in mm (degrees).
    ///
    /// A host that measures its period sets `elapsed_ns`, one that homes sets `homed`.
    #[inline(always)]
    pub fn input(&self, command: [P; N], feedback: [P; N]) -> Input<P, N> {
        Input { command, feedback, homed: true, enable: true, ..Input::at_rest(self.period_ns) }
    }

    /// The compensation in force, for error lookups outside the step.
    #[doc(hidden)]
    pub fn compensation(&self) -> &Compensation<'_, R, P, N> {
        &self.compensation
    }

    /// Runs one servo cycle: cannot fail, panic, allocate, block, or loop without a fixed bound.
    ///
    /// The first cycle returns the command; from then on `drive = command + c`, c the limited correction. While the
    /// output holds, drive and c do not change by a bit; afterwards c continues from rest.
    ///
    /// `measure` selects the reference of the contour error:
    ///
    /// | | |
    /// |---|---|
    /// | `()` | nothing |
    /// | [`Path::at`](crate::contour::Path::at) | the programmed path |
    /// | `&mut` [`CommandWindow`](crate::contour::CommandWindow) | the last commands, for a host that knows no path |
    /// | `&mut` [`OnToolPath`] | tip and direction of the tool, in workpiece coordinates |
    ///
    /// `gauge`: `()`, or `&mut` [`GaugeRide`] with three probes. Every combination works; an absent part costs nothing.
    /// A program that uses several combinations can pass `&mut dyn` of [`Measure`] and [`Ride`] instead: one copy of
    /// the step then serves all of them, and an absent part costs a call.
    ///
    /// The output is built and copied in every cycle: [`ServoLoop::step_into`] avoids that.
    #[inline]
    pub fn step(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        measure: impl Measure<R, P, N>,
        gauge: impl Ride<R>,
    ) -> Output<R, P, N> {
        let mut output = Output::none();
        self.step_into(state, input, measure, gauge, &mut output);
        output
    }

    /// Runs [`ServoLoop::step`] into an existing output, all of which it overwrites.
    #[inline]
    pub fn step_into(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        measure: impl Measure<R, P, N>,
        gauge: impl Ride<R>,
        output: &mut Output<R, P, N>,
    ) {
        self.step_watched(state, input, measure, gauge, output, |_| ());
    }

    /// Runs [`ServoLoop::step_into`] and calls `watch` at the end of each stage: for counting or timing the stages on
    /// the target.
    ///
    /// The compiler may move work across the border of two stages; their sum is exact.
    #[inline(always)]
    #[doc(hidden)]
    pub fn step_watched(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        mut measure: impl Measure<R, P, N>,
        mut gauge: impl Ride<R>,
        output: &mut Output<R, P, N>,
        mut watch: impl FnMut(Stage),
    ) {
        if !part::FAST {
            self.any_cycle(state, input, &mut measure, &mut gauge, output, &mut watch);
        } else if !self.sampler.quick_check(&mut state.sample, input) {
            self.slow_cycle(state, input, &mut measure, &mut gauge, output, &mut watch);
        } else if self.sampler.compares_nothing(&mut state.sample) {
            self.calm_cycle(state, input, &mut measure, &mut gauge, output, &mut watch);
        } else {
            self.comparing_cycle(state, input, &mut measure, &mut gauge, output, &mut watch);
        }
    }

    /// Runs a cycle that passed every check. A separate function, so that the compiler allocates registers for it
    /// alone.
    #[inline(never)]
    fn calm_cycle(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        measure: &mut impl Measure<R, P, N>,
        gauge: &mut impl Ride<R>,
        output: &mut Output<R, P, N>,
        watch: &mut impl FnMut(Stage),
    ) {
        self.cycle(state, &Sample::calm(input), measure, gauge, output, watch);
    }

    /// Runs a cycle that passed the quick check and in which the ratio of a reading is compared.
    // Only with comparison. Never both comparison and full_check in one step: after a ratio that was found wrong, the full
    // check returns at once.
    #[inline(never)]
    fn comparing_cycle(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        measure: &mut impl Measure<R, P, N>,
        gauge: &mut impl Ride<R>,
        output: &mut Output<R, P, N>,
        watch: &mut impl FnMut(Stage),
    ) {
        if self.sampler.compare(&mut state.sample, input, state.output.drive()) {
            self.slow_cycle(state, input, measure, gauge, output, watch);
        } else {
            self.calm_cycle(state, input, measure, gauge, output, watch);
        }
    }

    /// Runs a cycle that needs the full check. Separate from the calm cycles, so that those repeat no check.
    #[inline(never)]
    fn slow_cycle(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        measure: &mut impl Measure<R, P, N>,
        gauge: &mut impl Ride<R>,
        output: &mut Output<R, P, N>,
        watch: &mut impl FnMut(Stage),
    ) {
        let mut trusted = [[P::default(); N]; 2];
        let sample = self.sampler.full_check(&mut state.sample, input, state.output.drive(), &mut trusted);
        self.cycle(state, &sample, measure, gauge, output, watch);
    }

    /// Runs any cycle, with one copy of the stages.
    #[inline(never)]
    fn any_cycle(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        measure: &mut impl Measure<R, P, N>,
        gauge: &mut impl Ride<R>,
        output: &mut Output<R, P, N>,
        watch: &mut impl FnMut(Stage),
    ) {
        let mut trusted = [[P::default(); N]; 2];
        let is_calm = self.sampler.quick_check(&mut state.sample, input)
            && (self.sampler.compares_nothing(&mut state.sample)
                || !self.sampler.compare(&mut state.sample, input, state.output.drive()));
        let sample = if is_calm {
            Sample::calm(input)
        } else {
            self.sampler.full_check(&mut state.sample, input, state.output.drive(), &mut trusted)
        };
        self.cycle(state, &sample, measure, gauge, output, watch);
    }

    /// Runs the stages after the sample.
    #[inline(always)]
    fn cycle(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        measure: &mut impl Measure<R, P, N>,
        gauge: &mut impl Ride<R>,
        output: &mut Output<R, P, N>,
        watch: &mut impl FnMut(Stage),
    ) {
        watch(Stage::Sample);
        let mut modelled = self.model(state, sample, measure.needs_tilt());
        gauge::run(gauge, sample, state.limited, &mut modelled.wanted);
        watch(Stage::Compensation);
        measure.measure(self, state, sample, &modelled, &mut output.record);
        watch(Stage::Contour);
        let Output { drive, feedback, record } = output;
        let applied = match self.dynamic() {
            None => {
                record.dynamic = None;
                let outlets = Outlets { drive, feedback, correction: &mut record.correction };
                self.output.apply(&mut state.output, sample, &modelled.wanted, true, outlets)
            }
            Some(stage) => {
                let error = measure.in_machine(self, sample, record.tip.vector);
                self.apply_dynamic(stage, state, sample, &modelled.wanted, error, (drive, feedback), record)
            }
        };
        self.settle(state, sample, applied, measure);
        watch(Stage::Output);
        self.record(state, sample, modelled.at_edge, applied, record);
        watch(Stage::Telemetry);
    }

    /// Keeps the output stage's decision for the next cycles: it accepted the command, or a joint's range holds the
    /// output.
    #[inline(always)]
    fn settle(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        applied: Applied,
        measure: &mut impl Measure<R, P, N>,
    ) {
        state.limited = applied.limited;
        match applied.outside {
            None => state.sample.accept(sample.command),
            Some(slot) => {
                state.sample.latch(Fault::JointRange, slot);
                measure.take_back();
            }
        }
    }

    /// Completes the record: contour and output stage have written their parts.
    #[inline(always)]
    fn record(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        at_edge: u8,
        applied: Applied,
        record: &mut Record<R, P, N>,
    ) {
        record.sequence = state.sequence;
        state.sequence = state.sequence.wrapping_add(1);
        (record.machine_id, record.tables_crc) = (self.machine_id, self.tables_crc);
        let status;
        (record.fault, record.fault_axis, status) = match applied.outside {
            Some(slot) => (Fault::JointRange, slot, Verdict::Hold.status()),
            None => (sample.fault, sample.axis, sample.verdict.status()),
        };
        if let (Fault::None, Some((fault, slot))) = (record.fault, self.friction_fault(state)) {
            (record.fault, record.fault_axis) = (fault, slot);
        }
        let status = Status(status.0 | applied.status.0);
        record.status = status.with(Status::CONTOUR, record.tip.is_measured());
        (record.limited, record.at_edge) = (applied.limited, at_edge);
        record.command = state.sample.commanded();
        record.feedback = *sample.feedback;
    }
}

#[cfg(test)]
mod tests;
