//! The checks of command and readings: limits, state from cycle to cycle, quick and full check.

#![deny(clippy::indexing_slicing)]

use super::ratio::{Ratio, RatioState, Ratios};
use super::{Input, Refusal, Sample, Verdict};
use crate::error::Fault;
use crate::machine::{AxisOrder, FaultSettings, MachineSettings};
use crate::position::Position;
use crate::real::Real;

/// Limits of an axis; the changes are the largest ones in an on-time cycle.
#[derive(Clone, Copy, Debug)]
struct Plausible<R, P: Position> {
    travel: [P; 2],
    /// Readings within this range are trusted: the joint's range extended by [`READING_MARGIN`].
    readable: [P; 2],
    command_jump: P::Reach,
    feedback_jump: P::Reach,
    stuck: P::Reach,
    /// A reading that changes by no more counts as unchanged: [`STILL_STEPS`] of the encoder, 0 if its resolution is not
    /// stated.
    still: P::Reach,
    /// A command that changes by no more need not show in the reading.
    play: P::Reach,
    resume: P::Reach,
    /// The two jumps again, mm (deg), to be multiplied by the number of missing cycles.
    jumps: [R; 2],
}

impl<R: Real, P: Position> Plausible<R, P> {
    /// Largest change of a reading after `missing` cycles without one.
    #[inline(always)]
    fn feedback_jump_after(&self, missing: u16) -> P::Reach {
        let [_, jump] = self.jumps;
        if missing == 0 { self.feedback_jump } else { P::reach_of(jump * (R::ONE + R::of_i32(i32::from(missing)))) }
    }

    /// Whether the command has moved by more than `stuck` while the reading did not change. Idempotent within a cycle.
    #[inline(always)]
    fn is_stuck(&self, suspicion: &mut Suspicion<P>, reading: P, command: P) -> bool {
        if reading.apart(suspicion.reading) > self.still {
            *suspicion = Suspicion::from(reading, command);
            return false;
        }
        let way = command.apart(suspicion.command);
        if way > self.play {
            suspicion.command = command;
            suspicion.way = P::farther(suspicion.way, way);
        }
        suspicion.way > self.stuck
    }
}

/// Plausibility limits of every axis: immutable.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampler<R, P: Position, const N: usize> {
    axes: [Plausible<R, P>; N],
    earliest_ns: u32,
    /// Difference between the latest and the earliest.
    tolerance_ns: u32,
    latest_ns: u32,
    /// Time after which the corrections may move by one cycle's worth.
    pace_ns: u32,
    /// From this time on a cycle counts as [`LONGEST`] periods.
    longest_ns: u32,
    per_period: R,
    ratios: Ratios<R, N>,
}

/// Commanded distance since a reading last moved.
#[derive(Clone, Copy, Debug, Default)]
struct Suspicion<P: Position> {
    /// The reading since then.
    reading: P,
    /// The command up to which the distance is counted.
    command: P,
    way: P::Reach,
}

impl<P: Position> Suspicion<P> {
    /// Starts with no distance counted.
    #[inline(always)]
    fn from(reading: P, command: P) -> Self {
        Suspicion { reading, command, way: P::Reach::default() }
    }
}

/// State of the stage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleState<R, P: Position, const N: usize> {
    /// Whether the last cycle was active and passed every check: no stop, no reading missing, no reset held.
    calm: bool,
    started: bool,
    /// Time in which the corrections have not moved yet, below [`Sampler::pace_ns`].
    time_ns: u32,
    /// While the output holds before the first command: one bit for every axis whose position is known.
    known: u8,
    active: bool,
    reset: bool,
    latched: Fault,
    latched_axis: u8,
    command: [P; N],
    feedback: [P; N],
    /// Cycles since the last trusted reading.
    missing: [u16; N],
    suspicions: [Suspicion<P>; N],
    ratios: RatioState<R, P, N>,
    /// Whether this cycle, which passed the quick check, shows a wrong ratio.
    found: bool,
}

impl<R: Real, P: Position, const N: usize> SampleState<R, P, N> {
    pub(crate) fn new() -> Self {
        SampleState {
            calm: false,
            started: false,
            time_ns: 0,
            known: 0,
            active: false,
            reset: false,
            latched: Fault::None,
            latched_axis: 0,
            command: [P::default(); N],
            feedback: [P::default(); N],
            missing: [0; N],
            suspicions: [Suspicion::default(); N],
            ratios: RatioState::new(),
            found: false,
        }
    }

    /// The command of the last cycle; during a stop, the held one.
    pub(crate) fn commanded(&self) -> [P; N] {
        self.command
    }

    /// Begins at rest at the first command, as the readings are.
    #[cold]
    fn rest(&mut self, command: &[P; N]) {
        self.ratios.rest(command, &self.feedback);
    }

    /// Accepts this cycle's command: it goes to the drives.
    #[inline(always)]
    pub(crate) fn accept(&mut self, command: &[P; N]) {
        self.command = *command;
    }

    /// Whether the last cycle, or an earlier one, requested a stop that is still latched.
    pub(crate) fn is_latched(&self) -> bool {
        self.latched != Fault::None
    }

    pub(crate) fn latch(&mut self, fault: Fault, axis: u8) {
        (self.latched, self.latched_axis) = (fault, axis);
        self.calm = false;
        // The drives do not move: a rejected command required no motion.
        for (suspicion, held) in self.suspicions.iter_mut().zip(&self.command) {
            suspicion.command = *held;
        }
        self.ratios.axes().for_each(Ratio::interrupt);
    }
}

/// A cycle longer than this multiple of the configured period is late.
const LATE: f64 = 1.25;
/// A cycle shorter than this multiple is early.
const EARLY: f64 = 0.75;
/// Share of a period by which a host's clock may be fast: [`crate::ServoLoop::check_period`].
const FAST: u32 = 1000;
/// The farthest usable position of any type, mm (deg).
const FARTHEST: f64 = 1e9;
/// Readings are trusted up to this far beyond the range of the joint, mm (deg): an axis overshoots at the end of its
/// travel or coasts after a stop. A counter that wraps is farther away.
pub const READING_MARGIN: f64 = 1.0;
/// Encoder steps within which a reading counts as unchanged: one count to either side of where it died, and one more.
pub const STILL_STEPS: f64 = 3.0;
/// Largest share of `faults.stuck` within which a reading counts as unchanged; a coarser encoder must then show the same
/// count.
const STILL_SHARE: f64 = 0.25;
/// A late cycle excuses no larger change than this number of periods does.
const LONGEST: u32 = 16;

impl<R: Real, P: Position, const N: usize> Sampler<R, P, N> {
    pub(crate) fn new(order: &AxisOrder<N>, machine: &MachineSettings, period_ns: u32) -> Self {
        let period = f64::from(period_ns) * 1e-9;
        let any = P::reach(f64::MAX);
        let none = Plausible {
            travel: [-FARTHEST, FARTHEST].map(P::nearest),
            readable: [-FARTHEST, FARTHEST].map(P::nearest),
            command_jump: any,
            feedback_jump: any,
            stuck: any,
            still: P::Reach::default(),
            play: P::Reach::default(),
            resume: any,
            jumps: [R::MAX; 2],
        };
        let limits = order.slots(|axis| {
            let FaultSettings { resume, command_jump_factor, feedback_jump, stuck } = machine.faults;
            let pick = |[linear, rotary]: [f64; 2]| if axis.is_rotary() { rotary } else { linear };
            machine.axis(axis).map_or(none, |settings| {
                let jump = command_jump_factor * settings.max_feed_per_s * period;
                let jumps = [jump, jump + pick(feedback_jump)];
                let [command_jump, feedback_jump] = jumps.map(P::reach);
                let place = |x: f64| P::nearest(Real::limit(x, -FARTHEST, FARTHEST));
                let [low, high] = settings.joint;
                let [still, play] = settings.encoder_resolution.map_or([0.0; 2], |step| {
                    let still = (STILL_STEPS * step).min(STILL_SHARE * pick(stuck));
                    [still, still + settings.backlash.abs()]
                });
                Plausible {
                    travel: settings.travel.map(place),
                    readable: [low - READING_MARGIN, high + READING_MARGIN].map(place),
                    command_jump,
                    feedback_jump,
                    stuck: P::reach(pick(stuck)),
                    still: P::reach(still),
                    play: P::reach(play),
                    resume: P::reach(pick(resume)),
                    jumps: jumps.map(R::of),
                }
            })
        });
        let latest_ns = (LATE * f64::from(period_ns)) as u32;
        let earliest_ns = libm::ceil(EARLY * f64::from(period_ns)) as u32;
        Sampler {
            axes: limits,
            earliest_ns,
            tolerance_ns: latest_ns.saturating_sub(earliest_ns),
            latest_ns,
            pace_ns: period_ns - period_ns / FAST,
            longest_ns: period_ns.saturating_mul(LONGEST),
            per_period: R::of(1.0 / f64::from(period_ns)),
            ratios: Ratios::new(order, machine, period),
        }
    }

    /// Whether every position lies in the declared travel of its axis.
    pub(crate) fn within_travel(&self, positions: &[P; N]) -> bool {
        self.axes.iter().zip(positions).all(|(axis, position)| position.is_within(&axis.travel))
    }

    /// Quick check: whether this cycle, following one that passed every check, passes them too, apart from the ratio of the
    /// readings ([`Sampler::compare`]); its sample is then [`Sample::calm`]. `false`: the full check ([`Sampler::full_check`]) is
    /// needed; anything changed here it changes in the same way.
    #[inline(always)]
    pub(crate) fn quick_check(&self, state: &mut SampleState<R, P, N>, input: &Input<P, N>) -> bool {
        let Some(time_ns) = self.calm_time(state, input) else { return false };
        let positions = input.feedback.iter().zip(&input.command);
        for ((axis, suspicion), (reading, command)) in self.axes.iter().zip(&mut state.suspicions).zip(positions) {
            if axis.is_stuck(suspicion, *reading, *command) {
                return false;
            }
        }
        (state.feedback, state.time_ns) = (input.feedback, time_ns);
        true
    }

    /// Whether no ratio is compared in this cycle, which passed the quick check; otherwise [`Sampler::compare`] follows. Apart
    /// from the quick check, whose usual path would lose registers to a call.
    #[inline(always)]
    pub(crate) fn compares_nothing(&self, state: &mut SampleState<R, P, N>) -> bool {
        state.ratios.waits()
    }

    /// Whether a cycle that passed the quick check shows a reading of a wrong ratio, which the full check then reports. `sent`:
    /// the drive positions sent last.
    #[inline(always)]
    pub(crate) fn compare(&self, state: &mut SampleState<R, P, N>, input: &Input<P, N>, sent: &[P; N]) -> bool {
        state.found = self.ratios.find(&mut state.ratios, sent, &input.command, &input.feedback);
        state.found
    }

    /// The sample of a cycle that passed the quick check and shows a wrong ratio.
    fn wrong_ratio<'s>(&self, state: &mut SampleState<R, P, N>, input: &'s Input<P, N>) -> Sample<'s, P, N> {
        (state.found, state.calm) = (false, false);
        state.ratios.found(true);
        let axis = state.ratios.wrong().unwrap_or_default();
        Sample { verdict: Verdict::Freeze, fault: Fault::FeedbackRatio, axis, ..Sample::calm(input) }
    }

    /// The time left after a cycle in which [`Sampler::full_check`] would find no fault either, apart from a stuck reading.
    #[inline(always)]
    fn calm_time(&self, state: &SampleState<R, P, N>, input: &Input<P, N>) -> Option<u32> {
        let switched = input.homed && input.enable && !input.reset;
        let in_order = input.encoder_alarm == 0 && input.refusal.fault == Fault::None;
        let in_time = input.elapsed_ns.wrapping_sub(self.earliest_ns) <= self.tolerance_ns;
        if !(state.calm && switched && in_order && in_time) {
            return None;
        }
        let (time_ns, true) = self.passed(state.time_ns.wrapping_add(input.elapsed_ns)) else { return None };
        let before = state.command.iter().zip(&state.feedback);
        let now = input.command.iter().zip(&input.feedback);
        for ((axis, (command, reading)), (last, good)) in self.axes.iter().zip(now).zip(before) {
            if !(command.is_within(&axis.travel) && command.apart(*last) <= axis.command_jump) {
                return None;
            }
            // Every readable position is usable.
            if !(reading.is_within(&axis.readable) && reading.apart(*good) <= axis.feedback_jump) {
                return None;
            }
        }
        Some(time_ns)
    }

    /// Given the time accumulated with this cycle, the time left after it and whether the corrections may move in it.
    #[inline(always)]
    fn passed(&self, time_ns: u32) -> (u32, bool) {
        // However long the time was, the remainder is shorter than one movement takes.
        let most = self.pace_ns.wrapping_mul(2).wrapping_sub(1);
        let time = time_ns.min(most);
        match time.checked_sub(self.pace_ns) {
            Some(left) => (left, true),
            None => (time, false),
        }
    }

    /// Slot of the first axis whose reading moves by a wrong ratio: from the cycle that shows it, until the compensation is
    /// switched off or a reset arrives. `compares`: a cycle on time.
    // Only with full_check.
    #[inline(always)]
    fn ratio_fault(
        &self,
        state: &mut SampleState<R, P, N>,
        command: &[P; N],
        sent: &[P; N],
        (active, compares): (bool, bool),
    ) -> Option<u8> {
        if !active {
            state.ratios.release();
        }
        let compares = compares && !state.ratios.waits();
        if compares && self.ratios.find(&mut state.ratios, sent, command, &state.feedback) {
            state.ratios.found(active);
        }
        state.ratios.wrong()
    }

    /// The full check of a cycle. `trusted` receives the positions of command and feedback.
    #[inline(never)]
    pub(crate) fn full_check<'s>(
        &self,
        state: &mut SampleState<R, P, N>,
        input: &'s Input<P, N>,
        sent: &[P; N],
        trusted: &'s mut [[P; N]; 2],
    ) -> Sample<'s, P, N> {
        if state.found {
            return self.wrong_ratio(state, input);
        }
        state.calm = false;
        let first = !state.started;
        let active = input.homed && input.enable;
        let late = input.elapsed_ns > self.latest_ns;
        // The time before the first cycle is unknown.
        let due;
        (state.time_ns, due) =
            self.passed(if first { u32::MAX } else { state.time_ns.saturating_add(input.elapsed_ns) });
        let early = input.elapsed_ns < self.earliest_ns || !due;
        let (command_fault, command_axis) = match input.refusal.fault {
            Fault::None => self.command_fault(state, input, active, late),
            refused => (refused, input.refusal.slot),
        };
        let reset = input.reset && !state.reset && input.refusal == Refusal::NONE;
        state.reset = input.reset;

        if state.latched != Fault::None || command_fault != Fault::None {
            return self.stopped(state, input, reset, (command_fault, command_axis), (first, due), trusted);
        }
        let (feedback_fault, feedback_axis) = self.feedback_fault(state, input, &input.command, active && !first);
        if reset {
            state.ratios.axes().for_each(Ratio::forget);
        }
        if first {
            state.rest(&input.command);
        }
        let ratio = self.ratio_fault(state, &input.command, sent, (active, !(first || late || early)));
        let (fault, axis) = match (feedback_fault, ratio) {
            (Fault::None, None) if (late || early) && active && !first => (Fault::LateCycle, 0),
            (_, Some(slot)) if feedback_fault == Fault::None || slot < feedback_axis => (Fault::FeedbackRatio, slot),
            _ => (feedback_fault, feedback_axis),
        };
        state.started = true;
        state.active = active;
        let verdict = match (active, fault) {
            (false, _) => Verdict::Inactive,
            (true, Fault::None) => Verdict::Active,
            (true, _) => Verdict::Freeze,
        };
        state.calm = verdict == Verdict::Active && !input.reset;
        *trusted = [input.command, state.feedback];
        let [command, feedback] = trusted;
        Sample { command, feedback, verdict, fault, axis, due, first, homed: input.homed, input }
    }

    /// Number of periods that a cycle took, the bound on the motion in it: 1 if on time, at most 16.
    #[inline(always)]
    pub(crate) fn periods(&self, elapsed_ns: u32) -> R {
        if elapsed_ns <= self.latest_ns {
            return R::ONE;
        }
        if elapsed_ns >= self.longest_ns {
            return R::of_i32(LONGEST as i32);
        }
        // At most 16 periods of 0.1 s: fits.
        R::of_i32(elapsed_ns as i32) * self.per_period
    }

    /// The first fault of the command. Travel and jumps count only while the step is active: before homing, positions
    /// have no meaning.
    // Only with full_check.
    #[inline(always)]
    fn command_fault(
        &self,
        state: &SampleState<R, P, N>,
        input: &Input<P, N>,
        active: bool,
        late: bool,
    ) -> (Fault, u8) {
        let check_jump = state.started && state.active;
        let mut place = 0;
        for ((axis, command), last) in self.axes.iter().zip(&input.command).zip(&state.command) {
            if active {
                // Every position within the travel is usable.
                let [low, high] = axis.travel;
                if !(*command >= low && *command <= high) {
                    let fault = if command.is_usable() { Fault::CommandOutOfTravel } else { Fault::CommandNotFinite };
                    return (fault, place);
                }
                let [jump, _] = axis.jumps;
                let most = if late { P::reach_of(jump * self.periods(input.elapsed_ns)) } else { axis.command_jump };
                if check_jump && command.apart(*last) > most {
                    return (Fault::CommandJump, place);
                }
            } else if !command.is_usable() {
                return (Fault::CommandNotFinite, place);
            }
            place = place.wrapping_add(1);
        }
        (Fault::None, 0)
    }

    /// Accepts the plausible readings and keeps the last good ones of the others. The readings' range counts only while
    /// the step is active, like the travel of commands.
    // Only with full_check.
    #[inline(always)]
    fn feedback_fault(
        &self,
        state: &mut SampleState<R, P, N>,
        input: &Input<P, N>,
        command: &[P; N],
        watch: bool,
    ) -> (Fault, u8) {
        let mut worst = (Fault::None, 0);
        let mut place = 0u8;
        let active = input.homed && input.enable;
        let memory =
            state.feedback.iter_mut().zip(&mut state.missing).zip(&mut state.suspicions).zip(state.ratios.axes());
        // At most N rounds: an axis each.
        for (((axis, reading), command), (((good, missing), suspicion), ratio)) in
            self.axes.iter().zip(&input.feedback).zip(command).zip(memory)
        {
            // In the cycle of switching on, the host may have set a new command.
            if !state.active {
                suspicion.command = *command;
            }
            let fault = if !reading.is_usable() {
                Fault::FeedbackNotFinite
            } else if input.encoder_alarm & (1 << (place & 7)) != 0 {
                Fault::EncoderAlarm
            } else if active && !reading.is_within(&axis.readable) {
                Fault::FeedbackJump
            } else if !watch {
                Fault::None
            } else if reading.apart(*good) > axis.feedback_jump_after(*missing) {
                Fault::FeedbackJump
            } else if axis.is_stuck(suspicion, *reading, *command) {
                Fault::EncoderStuck
            } else {
                Fault::None
            };
            match fault {
                Fault::None => {
                    *good = *reading;
                    *missing = 0;
                }
                // Before the first good reading no earlier value can replace a missing one: the command does.
                _ if !state.started || active && !good.is_within(&axis.readable) => {
                    *good = *command;
                    suspicion.reading = *command;
                }
                _ => *missing = missing.saturating_add(1),
            }
            if !watch {
                *suspicion = Suspicion::from(*good, *command);
            }
            // The reading could not show this distance.
            if !matches!(fault, Fault::None | Fault::EncoderStuck) {
                suspicion.command = *command;
                ratio.interrupt();
            }
            if fault != Fault::None && worst.0 == Fault::None {
                worst = (fault, place);
            }
            place = place.wrapping_add(1);
        }
        worst
    }

    /// A bad command now or earlier: holds the output, unless this cycle brings the reset near the held position.
    // Only with full_check.
    #[inline(never)]
    fn stopped<'s>(
        &self,
        state: &mut SampleState<R, P, N>,
        input: &'s Input<P, N>,
        reset: bool,
        (fault, axis): (Fault, u8),
        (first, due): (bool, bool),
        trusted: &'s mut [[P; N]; 2],
    ) -> Sample<'s, P, N> {
        let was_latched = state.latched != Fault::None;
        if !was_latched {
            state.latch(fault, axis);
        }
        let placed = state.started || self.placed(state, input);
        let near = self
            .axes
            .iter()
            .zip(&input.command)
            .zip(&state.command)
            .all(|((axis, command), held)| command.is_usable() && command.apart(*held) <= axis.resume);
        // A jump is measured from the held command, so nearness excuses it. Out of travel remains a fault, also on an
        // axis after the one that jumps.
        let inactive = !(input.homed && input.enable);
        let within = inactive || self.within_travel(&input.command);
        let acceptable = matches!(fault, Fault::None | Fault::CommandJump) && within;
        // Readings are still checked, but only the stop is reported.
        if inactive {
            state.ratios.axes().for_each(Ratio::forget);
        }
        let held = state.command;
        let _ = self.feedback_fault(state, input, &held, state.active && !first);
        if was_latched && reset && placed && near && acceptable {
            state.latched = Fault::None;
            state.started = true;
            // The output held the drives, so commands during the stop say nothing about the readings.
            for ((suspicion, reading), command) in state.suspicions.iter_mut().zip(&state.feedback).zip(&input.command)
            {
                *suspicion = Suspicion::from(*reading, *command);
            }
            state.ratios.axes().for_each(Ratio::forget);
            state.active = input.homed && input.enable;
            let verdict = if state.active { Verdict::Active } else { Verdict::Inactive };
            *trusted = [input.command, state.feedback];
            let [command, feedback] = trusted;
            return Sample {
                command,
                feedback,
                verdict,
                fault: Fault::None,
                axis: 0,
                due,
                first,
                homed: input.homed,
                input,
            };
        }
        *trusted = [held, state.feedback];
        let [command, feedback] = trusted;
        Sample {
            command,
            feedback,
            verdict: if placed { Verdict::Hold } else { Verdict::NoOutput },
            fault: state.latched,
            axis: state.latched_axis,
            due,
            first,
            homed: input.homed,
            input,
        }
    }

    /// Before the first command, sets the held position to the latest readings until every axis has been read. Returns
    /// whether all axes are known.
    #[cold]
    fn placed(&self, state: &mut SampleState<R, P, N>, input: &Input<P, N>) -> bool {
        let known = |known: u8| known.count_ones() as usize == N;
        if known(state.known) {
            return true;
        }
        let active = input.homed && input.enable;
        let mut bit = 1u8;
        for ((axis, held), reading) in self.axes.iter().zip(&mut state.command).zip(&input.feedback) {
            let readable = reading.is_within(&axis.readable) || !active;
            if reading.is_usable() && readable && input.encoder_alarm & bit == 0 {
                *held = *reading;
                state.known |= bit;
            }
            bit = bit.wrapping_shl(1);
        }
        known(state.known)
    }
}
