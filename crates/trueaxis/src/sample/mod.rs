//! First stage: turns command and encoder readings into finite, plausible positions, or reports a fault.

#![deny(clippy::indexing_slicing)]

mod encoder;

pub use encoder::{EncoderScale, WrappingCounter};

use crate::dynamic::Dynamics;
use crate::error::Fault;
use crate::machine::{AxisOrder, FaultSettings, MachineSettings};
use crate::position::Position;
use crate::real::Real;
use crate::telemetry::Status;

/// Input of a servo cycle.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Input<P, const N: usize> {
    /// Commanded positions, uncorrected, mm (rotary: degrees).
    pub command: [P; N],
    /// Raw encoder positions, mm (degrees). A reading that is NaN, beyond 1e9 or, in integers, at an end of their range
    /// is a dropout.
    pub feedback: [P; N],
    /// One bit for every axis whose encoder interface reports an alarm.
    pub encoder_alarm: u8,
    /// Time since the last cycle in nanoseconds, as the host measured or knows it.
    ///
    /// [`Fault::LateCycle`], correction frozen, if it is more than a quarter off the period or if the corrections must
    /// pause. They pause if too little time has passed since they last moved; with e this time, T 0.999 of the period
    /// and t the accumulated time,
    ///
    /// ```text
    /// t <- min(t + e, 2 T − 1 ns)      t >= T: they move by a cycle's worth, t <- t − T;  else they do not move
    /// ```
    ///
    /// so that over any time they move by at most what their slope allows in it plus one cycle's worth. Afterwards they
    /// continue at the velocity they had. 0: no time has passed and nothing moves. The value in the first cycle is
    /// ignored.
    pub elapsed_ns: u32,
    /// Whether all axes are homed, so that positions are machine positions.
    pub homed: bool,
    /// Whether the host wants compensation.
    pub enable: bool,
    /// Releases a latched stop request (on its rising edge, near the held position).
    pub reset: bool,
    /// Why a stage before the step ([`crate::ServoLoop::rtcp`]) has no command for this cycle: the output then holds,
    /// whatever `command` contains. Otherwise [`Refusal::NONE`].
    pub refusal: Refusal,
    /// Parts of the dynamic correction that the host wants; parts that are not configured stay off.
    pub dynamics: Dynamics,
    /// Learned correction of X, Y and Z at this point of the program, mm, as a position counted from 0. An unusable
    /// position counts as zero.
    pub learned: [P; 3],
}

/// A command rejected before the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Refusal {
    /// The reason; [`Fault::None`] if the command was not rejected.
    pub fault: Fault,
    /// Slot of the axis at fault.
    pub slot: u8,
}

impl Refusal {
    /// No command was rejected.
    pub const NONE: Refusal = Refusal { fault: Fault::None, slot: 0 };
}

impl<P: Position, const N: usize> Input<P, N> {
    /// All axes at zero, neither homed nor enabled, the cycle on time: defaults for the other fields.
    pub fn at_rest(period_ns: u32) -> Self {
        Input {
            command: [P::default(); N],
            feedback: [P::default(); N],
            encoder_alarm: 0,
            elapsed_ns: period_ns,
            homed: false,
            enable: false,
            reset: false,
            refusal: Refusal::NONE,
            dynamics: Dynamics::ALL,
            learned: [P::default(); 3],
        }
    }
}

/// How the step treats a cycle, decided from its sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Verdict {
    /// Not homed or not enabled: the correction returns to zero.
    Inactive = 0,
    /// Homed, enabled, plausible.
    Active = Status::ACTIVE.0,
    /// The correction freezes; the command passes.
    Freeze = Status::FROZEN.0,
    /// The output holds.
    Hold = Status::STOP_REQUEST.0,
    /// The output would hold, but no command was ever usable and some axis has not been read yet: the step gives no
    /// output.
    NoOutput = Status::STOP_REQUEST.0 | Status::NO_OUTPUT.0,
}

impl Verdict {
    /// The corresponding bits of the status.
    #[inline(always)]
    pub(crate) fn status(self) -> Status {
        Status(self as u8)
    }

    /// Whether the drives receive nothing new.
    #[inline(always)]
    pub(crate) fn holds(self) -> bool {
        matches!(self, Verdict::Hold | Verdict::NoOutput)
    }
}

/// Positions that the rest of the step trusts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample<'s, P, const N: usize> {
    pub(crate) command: &'s [P; N],
    pub(crate) feedback: &'s [P; N],
    pub(crate) verdict: Verdict,
    pub(crate) fault: Fault,
    /// Slot of the axis at fault.
    pub(crate) axis: u8,
    /// Whether the corrections may move in this cycle: a period has passed since they last moved
    /// ([`Input::elapsed_ns`]).
    pub(crate) due: bool,
    /// Whether no earlier command was accepted.
    pub(crate) first: bool,
    /// Whether the positions are machine positions.
    pub(crate) homed: bool,
    /// The unmodified input, for fields that only one stage reads.
    pub(crate) input: &'s Input<P, N>,
}

impl<'s, P, const N: usize> Sample<'s, P, N> {
    /// The sample of a cycle that passed every check.
    #[inline(always)]
    pub(crate) fn calm(input: &'s Input<P, N>) -> Self {
        Sample {
            command: &input.command,
            feedback: &input.feedback,
            verdict: Verdict::Active,
            fault: Fault::None,
            axis: 0,
            due: true,
            first: false,
            homed: true,
            input,
        }
    }
}

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
pub(crate) struct SampleState<P: Position, const N: usize> {
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
}

impl<P: Position, const N: usize> SampleState<P, N> {
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
        }
    }

    /// The command of the last cycle; during a stop, the held one.
    pub(crate) fn commanded(&self) -> [P; N] {
        self.command
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
        }
    }

    /// Whether every position lies in the declared travel of its axis.
    pub(crate) fn within_travel(&self, positions: &[P; N]) -> bool {
        self.axes.iter().zip(positions).all(|(axis, position)| position.is_within(&axis.travel))
    }

    /// Quick check: whether this cycle, following one that passed every check, passes them too; its sample is then
    /// [`Sample::calm`]. `false`: the full check ([`Sampler::full_check`]) is needed; anything changed here it changes in the
    /// same way.
    #[inline(always)]
    pub(crate) fn quick_check(&self, state: &mut SampleState<P, N>, input: &Input<P, N>) -> bool {
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

    /// The time left after a cycle in which [`Sampler::full_check`] would find no fault either, apart from a stuck reading.
    #[inline(always)]
    fn calm_time(&self, state: &SampleState<P, N>, input: &Input<P, N>) -> Option<u32> {
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

    /// The full check of a cycle. `trusted` receives the positions of command and feedback.
    #[inline(never)]
    pub(crate) fn full_check<'s>(
        &self,
        state: &mut SampleState<P, N>,
        input: &'s Input<P, N>,
        trusted: &'s mut [[P; N]; 2],
    ) -> Sample<'s, P, N> {
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
        let (fault, axis) = match (feedback_fault, (late || early) && active && !first) {
            (Fault::None, true) => (Fault::LateCycle, 0),
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
    #[inline(always)]
    fn command_fault(&self, state: &SampleState<P, N>, input: &Input<P, N>, active: bool, late: bool) -> (Fault, u8) {
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
    #[inline(always)]
    fn feedback_fault(
        &self,
        state: &mut SampleState<P, N>,
        input: &Input<P, N>,
        command: &[P; N],
        watch: bool,
    ) -> (Fault, u8) {
        let mut worst = (Fault::None, 0);
        let mut place = 0u8;
        let active = input.homed && input.enable;
        let memory = state.feedback.iter_mut().zip(&mut state.missing).zip(&mut state.suspicions);
        for (((axis, reading), command), ((good, missing), suspicion)) in
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
            }
            if fault != Fault::None && worst.0 == Fault::None {
                worst = (fault, place);
            }
            place = place.wrapping_add(1);
        }
        worst
    }

    /// A bad command now or earlier: holds the output, unless this cycle brings the reset near the held position.
    #[inline(never)]
    fn stopped<'s>(
        &self,
        state: &mut SampleState<P, N>,
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
    fn placed(&self, state: &mut SampleState<P, N>, input: &Input<P, N>) -> bool {
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

#[cfg(test)]
mod tests;
