//! The servo cycle: configuration, state, and the pipeline of named stages.

#![deny(clippy::indexing_slicing)]

mod bypass;
mod following;
mod rtcp;
mod tool;

pub use bypass::Bypass;

use crate::compensation::{Compensation, Requirement, Reversal, Rows, Storage, ThermalLine, step_axes};
use crate::contour::{ContourError, ContourSearch, ContourState, Method, OrientationError, Path, Reference};
use crate::error::{ConfigError, Fault, Field};
use crate::machine::{AXES, Axis, MachineSettings};
use crate::output::{Release, ReleaseState, Released};
use crate::position::Position;
use crate::real::Real;
use crate::roundness::{Cycle, Followed, Probes, Roundness, RoundnessState};
use crate::sample::{Input, Sample, SampleState, Sampler, Verdict};
use crate::tcomp::Tcomp;
use crate::telemetry::{Record, Status};
use crate::vector::V3;

/// What a servo loop is built from.
#[derive(Clone, Copy, Debug)]
pub struct Config<'m> {
    /// The machine's settings.
    pub machine: &'m MachineSettings,
    /// Identity of the machine ([`crate::tcomp::Tcomp::machine_id`]); goes into every record.
    pub machine_id: u32,
    /// CRC-32 of the table file; goes into every record.
    pub tables_crc: u32,
    /// Servo period.
    pub period_ns: u32,
    /// Passes of the exact inverse, 1 to 8; [`crate::check::machine_passes`] tells how many a machine needs.
    pub inverse_passes: u8,
    /// How the foot point is found.
    pub method: Method,
}

impl<'m> Config<'m> {
    /// The configuration that a compiled table file describes, with guarded search and as many passes as it needs.
    pub fn of(file: &'m Tcomp<'_>, period_ns: u32) -> Self {
        Config {
            machine: file.settings(),
            machine_id: file.machine_id(),
            tables_crc: file.crc(),
            period_ns,
            inverse_passes: file.inverse_passes(),
            method: Method::Guarded,
        }
    }

    /// Checks everything once and precomputes what a cycle needs, in memory lent by the caller.
    ///
    /// # Errors
    /// What is wrong, with the figure found and what is needed.
    pub fn build<'a, 'r, R: Real, P: Position, const N: usize, T: Rows + ?Sized + 'r>(
        &self,
        rows: impl Fn(Axis) -> Option<&'r T>,
        storage: Storage<'a, R>,
    ) -> Result<ServoLoop<'a, R, P, N>, ConfigError> {
        if !(3..=AXES).contains(&N) {
            return Err(ConfigError::new(Field::Axes, N as f64, "3 to 6 axes"));
        }
        if !(1_000..=100_000_000).contains(&self.period_ns) {
            return Err(ConfigError::new(Field::Period, f64::from(self.period_ns) * 1e-9, "1e-6 s to 0.1 s"));
        }
        crate::check::settings(self.machine)?;
        let axes = step_axes::<N>(self.machine)?;
        let mut bands = [R::ZERO; N];
        for (band, axis) in bands.iter_mut().zip(axes) {
            let settings = self.machine.axes.iter().find(|a| a.axis == axis);
            *band = R::of(settings.map_or(0.0, |s| s.hysteresis));
        }
        let compensation = Compensation::build(self.machine, &rows, self.inverse_passes, storage)?;
        crate::check::reversal(self.machine, &rows)?;
        Ok(ServoLoop {
            axes,
            sampler: Sampler::new(self.machine, self.period_ns)?,
            compensation,
            bands,
            search: ContourSearch::new(self.machine.contour.max_lag_mm, self.method)?,
            release: Release::new(self.machine, f64::from(self.period_ns) * 1e-9)?,
            machine_id: self.machine_id,
            tables_crc: self.tables_crc,
            period_ns: self.period_ns,
        })
    }

    /// Memory that [`Config::build`] takes.
    pub fn requirement<'r, R: Real, P: Position, const N: usize, T: Rows + ?Sized + 'r>(
        &self,
        rows: impl Fn(Axis) -> Option<&'r T>,
    ) -> Requirement {
        Compensation::<R, P, N>::requirement(self.machine, rows)
    }
}

/// The immutable half: limits, tables, search settings. One in flash serves for ever, or is exchanged for another
/// between two cycles ([`crate::exchange::Exchange`]); the state goes on, and the limiter makes the change bumpless.
#[derive(Clone, Copy, Debug)]
pub struct ServoLoop<'a, R, P, const N: usize> {
    axes: [Axis; N],
    sampler: Sampler<R, P, N>,
    compensation: Compensation<'a, R, P, N>,
    bands: [R; N],
    search: ContourSearch<R>,
    release: Release<R, P, N>,
    machine_id: u32,
    tables_crc: u32,
    period_ns: u32,
}

/// The mutable half: what one cycle hands to the next.
#[derive(Clone, Copy, Debug)]
pub struct State<R, P, const N: usize> {
    sample: SampleState<R, P, N>,
    reversal: [Reversal<P>; N],
    /// The machine was homed in the last cycle.
    homed: bool,
    thermal: [ThermalLine<R>; N],
    tip: ContourState<R>,
    encoder: ContourState<R>,
    release: ReleaseState<R, P, N>,
    /// Axes whose correction was limited in the last cycle.
    limited: u8,
    sequence: u32,
}

impl<R: Real, P: Position, const N: usize> State<R, P, N> {
    /// Sets the thermal growth of the axis at a place (0 = X); takes effect in the next cycle, through the limiter.
    pub fn set_thermal(&mut self, place: usize, line: ThermalLine<R>) {
        if let Some(slot) = self.thermal.get_mut(place) {
            *slot = line;
        }
    }

    /// Before homing positions have no meaning, and homing moves none of the drives: they travel from here, forward.
    #[cold]
    fn begin_travel(&mut self, sample: &Sample<P, N>) {
        let held = sample.verdict == Verdict::Hold && !sample.first;
        let drive = if held { *self.release.drive() } else { self.release.drive_at(&sample.command) };
        self.reversal = drive.map(Reversal::at);
    }
}

/// A stage of the step, in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// Command and readings looked at ([`crate::sample`]).
    Sample,
    /// Errors looked up at command and feedback, inverse solved ([`crate::compensation`]).
    Compensation,
    /// Foot points of the estimated tip and of the plain encoder position ([`crate::contour`]).
    Contour,
    /// Correction limited and led in, or held ([`crate::limiter`]).
    Output,
    /// The record filled ([`crate::telemetry`]).
    Telemetry,
}

/// What a cycle gives back.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Output<R, P, const N: usize> {
    /// Corrected positions for the drives, mm (deg).
    pub drive: [P; N],
    /// Feedback for the host, without the correction: it sees no following error that is not there.
    pub feedback: [P; N],
    /// The cycle's telemetry: correction, contour error, flags, fault.
    pub record: Record<R, P, N>,
}

impl<R, P, const N: usize> Output<R, P, N> {
    /// The output is held and the host must stop the machine.
    pub fn stop_requested(&self) -> bool {
        self.record.status.has(Status::STOP_REQUEST)
    }
}

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// A fresh state, if the host runs at the configured period (within 0.1 %).
    ///
    /// # Errors
    /// [`Fault::PeriodMismatch`].
    pub fn start(&self, period_ns: u32) -> Result<State<R, P, N>, Fault> {
        if period_ns.abs_diff(self.period_ns) > self.period_ns / 1000 {
            return Err(Fault::PeriodMismatch);
        }
        Ok(State {
            sample: SampleState::new(),
            reversal: [Reversal::default(); N],
            homed: false,
            thermal: [ThermalLine::default(); N],
            tip: ContourState::default(),
            encoder: ContourState::default(),
            release: ReleaseState::new(),
            limited: 0,
            sequence: 0,
        })
    }

    /// The compensation in force, for looking errors up outside the step.
    pub fn compensation(&self) -> &Compensation<'_, R, P, N> {
        &self.compensation
    }

    /// One servo cycle: cannot fail, panic, allocate, block, or loop without a fixed bound.
    ///
    /// The first cycle returns the command; from then on `drive = command + c`, c the limited correction. `path` is
    /// what the interpolator follows and `reference` where on it the command of this cycle lies.
    #[inline]
    pub fn step(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
    ) -> Output<R, P, N> {
        self.step_watched(state, input, path, reference, |_| ())
    }

    /// The same, telling `watch` when a stage has ended: for counting or timing the stages on the target.
    ///
    /// The compiler may move work over the border of two stages; what all of them take together is exact.
    #[inline(always)]
    pub fn step_watched(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        mut watch: impl FnMut(Stage),
    ) -> Output<R, P, N> {
        let sample = self.sampler.read(&mut state.sample, input);
        watch(Stage::Sample);
        let modelled = self.model::<false>(state, &sample);
        watch(Stage::Compensation);
        self.finish(state, &sample, &modelled, path, reference, watch)
    }

    /// The same with a gauge of three probes riding along: some units of its work a cycle, and its infeed correction
    /// added to what the tables want of that axis, through the same limiter.
    ///
    /// While the step is not active the gauge measures on, but nothing is fed in. What the infeed moves on purpose is
    /// part of the contour error: the programmed path knows nothing of it.
    #[inline]
    pub fn step_with_gauge<const POINTS: usize>(
        &self,
        state: &mut State<R, P, N>,
        input: &Input<P, N>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        gauge: &Roundness<R, POINTS>,
        gauge_state: &mut RoundnessState<R, POINTS>,
        probes: &Probes<R>,
    ) -> (Output<R, P, N>, Cycle<R>) {
        let sample = self.sampler.read(&mut state.sample, input);
        let mut modelled = self.model::<false>(state, &sample);
        let place = gauge.infeed_place().unwrap_or(N);
        let followed = match sample.verdict {
            Verdict::Active if (state.limited >> (place & 7)) & 1 == 1 => Followed::Limited,
            Verdict::Active => Followed::Whole,
            _ => Followed::Not,
        };
        let cycle = gauge.update(gauge_state, probes, followed);
        if let (Verdict::Active, Some(wanted)) = (sample.verdict, modelled.wanted.get_mut(place)) {
            *wanted += cycle.infeed;
        }
        (self.finish(state, &sample, &modelled, path, reference, |_| ()), cycle)
    }

    /// The stages after the model.
    #[inline(always)]
    fn finish(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        mut watch: impl FnMut(Stage),
    ) -> Output<R, P, N> {
        let contour = self.contour(state, sample, modelled, path, reference);
        watch(Stage::Contour);
        self.finish_measured(state, sample, modelled, contour, watch)
    }

    /// The stages after the contour error.
    #[inline(always)]
    fn finish_measured(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        contour: [ContourError<R>; 2],
        mut watch: impl FnMut(Stage),
    ) -> Output<R, P, N> {
        let released = self.release.release(&mut state.release, &mut state.sample, sample, &modelled.wanted);
        state.limited = released.limited;
        watch(Stage::Output);
        let output = self.record(state, sample, modelled.at_edge, contour, &OrientationError::none(), released);
        watch(Stage::Telemetry);
        output
    }

    /// Wanted correction at the command, modelled error at the feedback; that of the direction only for a `TOOL`.
    #[inline(always)]
    fn model<const TOOL: bool>(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>) -> Modelled<R, N> {
        let reverse = self.travel(state, sample);
        // Switched off but homed, the tip is still estimated: that is how the errors look without correction.
        let believed = matches!(sample.verdict, Verdict::Active | Verdict::Inactive);
        if !(sample.homed && believed) {
            return Modelled { wanted: [R::ZERO; N], tip_error: [R::ZERO; N], tilt: V3::ZERO, at_edge: 0 };
        }
        let mut at_edge = 0;
        let command = self.compensation.coordinates(&sample.command);
        let feedback = self.compensation.coordinates(&sample.feedback);
        let wanted = self.compensation.correction(&command, &feedback, &reverse, &state.thermal, &mut at_edge);
        let (reverse, thermal) = (&reverse, &state.thermal);
        let (mut tip_error, mut tilt) = ([R::ZERO; N], V3::ZERO);
        match self.compensation.volumetric() {
            Some(volumetric) if TOOL => {
                let pose = volumetric.pose_error(&feedback, reverse, thermal, &mut 0);
                for (error, tip) in tip_error.iter_mut().zip(pose.tip) {
                    *error = tip;
                }
                tilt = pose.orientation.into();
            }
            _ => tip_error = self.compensation.errors(&feedback, reverse, thermal, &mut 0),
        }
        Modelled { wanted, tip_error, tilt, at_edge }
    }

    /// Direction of travel of every drive as it was sent last, command plus correction: while one axis alone is commanded,
    /// the corrections of the others take up lost motion that their commands know nothing of. A held drive stands.
    #[inline(always)]
    fn travel(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>) -> [usize; N] {
        let begins = sample.first || (sample.homed && !state.homed);
        state.homed = sample.homed;
        let mut reverse = [0; N];
        if begins {
            state.begin_travel(sample);
            return reverse;
        }
        let drives = state.release.drive().iter().zip(&self.bands);
        for ((reverse, reversal), (drive, band)) in reverse.iter_mut().zip(&mut state.reversal).zip(drives) {
            *reverse = reversal.update(*drive, *band);
        }
        reverse
    }

    /// Contour error of the estimated tip and of the plain encoder position; none while a reading is not believed.
    #[inline(always)]
    fn contour(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        modelled: &Modelled<R, N>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
    ) -> [ContourError<R>; 2] {
        let Some([tip, encoder]) = points(sample, modelled) else {
            // After a fault the last foot says nothing about the next one.
            (state.tip, state.encoder) = (ContourState::default(), ContourState::default());
            return [ContourError::none(); 2];
        };
        let at_tip = self.search.update(&mut state.tip, path, reference, tip);
        let at_encoder = self.search.update(&mut state.encoder, path, reference, encoder);
        [at_tip, at_encoder]
    }

    #[inline(always)]
    fn record(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        at_edge: u8,
        [tip, encoder]: [ContourError<R>; 2],
        orientation: &OrientationError<R>,
        released: Released<R, P, N>,
    ) -> Output<R, P, N> {
        let sequence = state.sequence;
        state.sequence = sequence.wrapping_add(1);
        let (fault, fault_axis) = match released.outside {
            Some(place) => (Fault::JointRange, place),
            None => (sample.fault, sample.axis),
        };
        let status = Status::default()
            .with(Status::ACTIVE, sample.verdict == Verdict::Active)
            .with(Status::FROZEN, sample.verdict == Verdict::Freeze)
            .with(Status::STOP_REQUEST, fault.stops())
            .with(Status::CONTOUR, tip.is_measured());
        let record = Record {
            sequence,
            machine_id: self.machine_id,
            tables_crc: self.tables_crc,
            fault,
            fault_axis,
            status,
            limited: released.limited,
            at_edge,
            command: sample.command,
            feedback: sample.feedback,
            correction: released.correction,
            tip,
            encoder,
            orientation: orientation.angle,
            orientation_flags: orientation.flags,
        };
        Output { drive: released.drive, feedback: released.feedback, record }
    }
}

/// The estimated tip and the plain encoder position; none while a reading is not believed.
#[inline(always)]
fn points<R: Real, P: Position, const N: usize>(
    sample: &Sample<P, N>,
    modelled: &Modelled<R, N>,
) -> Option<[[P; 3]; 2]> {
    let (true, [x, y, z, ..], [dx, dy, dz, ..]) =
        (matches!(sample.verdict, Verdict::Active | Verdict::Inactive), &sample.feedback[..], &modelled.tip_error[..])
    else {
        return None;
    };
    Some([[x.plus(*dx), y.plus(*dy), z.plus(*dz)], [*x, *y, *z]])
}

/// What the tables say in a cycle.
#[derive(Clone, Copy, Debug)]
struct Modelled<R, const N: usize> {
    wanted: [R; N],
    tip_error: [R; N],
    /// Small rotation of the tool in bed axes, rad, beside what the rotary axes' own entries in `tip_error` say.
    tilt: V3<R>,
    at_edge: u8,
}

#[cfg(test)]
mod tests;
