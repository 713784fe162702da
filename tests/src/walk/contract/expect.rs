//! Required result of the first stage for an input: which commands and readings are accepted, what stops, what freezes.

use super::{Seen, Verdict, apart};
use crate::walk::rule::{Broken, Rule, Tally};
use crate::walk::scalar::{Place, Scalar};
use trueaxis::Fault;
use trueaxis::sample::Refusal;
use trueaxis::telemetry::Status;

/// Maximum number of periods that a late cycle excuses.
const LONGEST: f64 = 16.0;

/// State of commands and readings after the previous cycle.
#[derive(Clone, Debug)]
pub(super) struct Senses<P, const N: usize> {
    /// Whether a command was accepted.
    pub(super) started: bool,
    active: bool,
    reset: bool,
    /// Time for which corrections have not moved yet, ns, and whether they may move in this cycle.
    time: f64,
    pub(super) due: bool,
    pub(super) latched: Option<(Fault, u8)>,
    known: u8,
    /// The command in force.
    pub(super) held: [P; N],
    good: [P; N],
    missing: [u16; N],
    /// Position at which a reading is constant, command up to which the commanded travel has been counted, and that travel.
    steady: [P; N],
    counted: [P; N],
    unmoved: [f64; N],
    /// Axes whose readings were found to move by a wrong ratio, and the range of reading minus command.
    ratio: [bool; N],
    apart: [[f64; 2]; N],
}

/// A reading that has never deviated by more than this moves by no wrong ratio, mm (deg): the least motion against the
/// command, of which half may come from a correction that is not in the reading.
const RIGHT: f64 = 0.075;

impl<P: Place, const N: usize> Default for Senses<P, N> {
    fn default() -> Self {
        let zero = [P::default(); N];
        Senses {
            started: false,
            active: false,
            reset: false,
            time: 0.0,
            due: true,
            latched: None,
            known: 0,
            held: zero,
            good: zero,
            missing: [0; N],
            steady: zero,
            counted: zero,
            unmoved: [0.0; N],
            ratio: [false; N],
            apart: [[f64::INFINITY, f64::NEG_INFINITY]; N],
        }
    }
}

/// A quantity compared with its limit; `Either` if so close that rounding decides.
#[derive(Clone, Copy, PartialEq)]
enum Size {
    Within,
    Either,
    Beyond,
}

fn size<P: Place>(value: f64, limit: f64) -> Size {
    let grain = 2.0 * P::GRAIN + 1e-9 + 1e-6 * limit.min(1e3);
    match value {
        // The first case covers an infinite limit.
        _ if limit == f64::INFINITY => Size::Within,
        value if value <= limit - grain => Size::Within,
        value if value <= limit + grain => Size::Either,
        _ => Size::Beyond,
    }
}

/// A limit as positions compare it, half a step above the last position within it.
fn steps<P: Place>(limit: f64) -> f64 {
    if P::GRAIN == 0.0 { limit } else { ((limit / P::GRAIN).round_ties_even() + 0.5) * P::GRAIN }
}

impl<P: Place, const N: usize> Senses<P, N> {
    /// Takes an input; returns the required verdict. Where rounding decides, follows the output.
    pub(super) fn expect<R: Scalar>(
        &mut self,
        tally: &mut Tally,
        seen: &Seen<'_, '_, R, P, N>,
    ) -> Result<Verdict, Broken> {
        let (facts, input) = (seen.facts, &seen.moment.input);
        let record = &seen.outcome.output.record;
        let stops = record.status.has(Status::STOP_REQUEST);
        let active = input.homed && input.enable;
        let late = f64::from(input.elapsed_ns) > 1.25 * f64::from(facts.period_ns);
        let off = self.off(facts.period_ns, input.elapsed_ns);
        let reported = (record.fault, record.fault_axis);
        let due = self.command_faults(seen, active, late);
        let any = due.iter().any(|fault| *fault != Fault::None) || input.refusal.fault != Fault::None;
        let is_due = |(fault, axis): (Fault, u8)| match input.refusal {
            Refusal::NONE => due.get(usize::from(axis)) == Some(&fault) && fault != Fault::None,
            Refusal { fault: refused, slot } => (fault, axis) == (refused, slot),
        };
        let rising = input.reset && !self.reset && input.refusal == Refusal::NONE;
        self.reset = input.reset;
        let first = !self.started;
        if self.latched.is_none() && !any {
            if rising {
                self.ratio = [false; N];
            }
            let readings = self.readings(seen, &input.command, active && !first);
            let joint = stops && reported.0 == Fault::JointRange;
            tally.that(Rule::StopsOnlyWhenDue, !stops || joint, || format!("{reported:?} for {input:?}"))?;
            (self.started, self.active) = (true, active);
            let frozen = active && !first && off || readings.iter().any(|fault| *fault != Fault::None);
            if !joint {
                let fits = |(fault, axis): (Fault, u8)| {
                    let late = fault == Fault::LateCycle && off && active && !first;
                    late || fault != Fault::None && readings.get(usize::from(axis)) == Some(&fault)
                };
                if frozen {
                    tally.that(Rule::Reading, fits(reported), || {
                        format!("{reported:?}, due {readings:?}, off: {off}")
                    })?;
                } else {
                    tally.that(Rule::ReadingOnlyWhenDue, reported.0 == Fault::None, || {
                        format!("{reported:?} for {input:?}")
                    })?;
                }
            }
            return Ok(match (active, frozen) {
                (false, _) => Verdict::Inactive,
                (true, false) => Verdict::Active,
                (true, true) => Verdict::Frozen,
            });
        }
        let was_latched = self.latched;
        if was_latched.is_none() {
            tally.that(Rule::Stops, stops && is_due(reported), || format!("{reported:?}, due {due:?}, {input:?}"))?;
            self.latch(reported);
        }
        let placed = self.started || self.placed(seen);
        let near = self.near(seen);
        let acceptable =
            input.refusal == Refusal::NONE && due.iter().all(|fault| matches!(fault, Fault::None | Fault::CommandJump));
        let held = self.held;
        self.readings(seen, &held, self.active && !first);
        let Some(latched) = was_latched else {
            return Ok(if placed { Verdict::Held } else { Verdict::NoOutput });
        };
        let may = rising && placed && acceptable;
        // After a release, the output may leave the range of a joint at once and stop again.
        let continues = !stops || reported.0 == Fault::JointRange;
        let released = match near {
            Size::Within if may => {
                tally.that(Rule::ResetReleases, continues, || format!("{reported:?}, {input:?}, held {held:?}"))?;
                true
            }
            Size::Either if may => continues,
            _ => {
                let rule = if rising { Rule::ResetOnlyNear } else { Rule::Latches };
                let found = || format!("{reported:?} after {latched:?}, held {held:?}, due {due:?}, {input:?}");
                tally.that(rule, stops && reported == latched, found)?;
                false
            }
        };
        if released {
            let quiet = stops || reported.0 == Fault::None;
            tally.that(Rule::ResetReleases, quiet, || format!("released with {reported:?}"))?;
            self.latched = None;
            self.started = true;
            (self.steady, self.counted, self.unmoved) = (self.good, input.command, [0.0; N]);
            self.ratio = [false; N];
            self.active = active;
            return Ok(if active { Verdict::Active } else { Verdict::Inactive });
        }
        Ok(if placed { Verdict::Held } else { Verdict::NoOutput })
    }

    /// Holds the command in force from now on.
    pub(super) fn latch(&mut self, fault: (Fault, u8)) {
        (self.latched, self.counted) = (Some(fault), self.held);
    }

    /// Whether a cycle is off its time, by more than a quarter of the period or so much that corrections must not move: each
    /// movement takes 0.999 of a period, and less than that remains of any time.
    fn off(&mut self, period_ns: u32, elapsed_ns: u32) -> bool {
        let pace = f64::from(period_ns - period_ns / 1000);
        let passed = if self.started { self.time + f64::from(elapsed_ns) } else { f64::INFINITY };
        self.time = passed.min(2.0 * pace - 1.0);
        self.due = self.time >= pace;
        self.time -= if self.due { pace } else { 0.0 };
        !self.due || !(0.75..=1.25).contains(&(f64::from(elapsed_ns) / f64::from(period_ns)))
    }

    /// The fault of each axis' command.
    fn command_faults<R: Scalar>(&self, seen: &Seen<'_, '_, R, P, N>, active: bool, late: bool) -> [Fault; N] {
        let (facts, input) = (seen.facts, &seen.moment.input);
        let mut due = [Fault::None; N];
        let periods = f64::from(input.elapsed_ns) / f64::from(facts.period_ns);
        let periods = if late { periods.min(LONGEST) } else { 1.0 };
        let record = &seen.outcome.output.record;
        for k in 0..N {
            let (axis, command) = (&facts.axes[k], input.command[k]);
            if !command.is_usable() {
                due[k] = Fault::CommandNotFinite;
            } else if active && !command.is_within(&axis.travel) {
                due[k] = Fault::CommandOutOfTravel;
            } else if active && self.started && self.active {
                due[k] = match size::<P>(apart(command, self.held[k]), axis.command_jump * periods) {
                    Size::Beyond => Fault::CommandJump,
                    Size::Either if (record.fault, usize::from(record.fault_axis)) == (Fault::CommandJump, k) => {
                        Fault::CommandJump
                    }
                    _ => Fault::None,
                };
            }
        }
        due
    }

    /// Accepts the plausible readings; returns the fault of each reading.
    fn readings<R: Scalar>(&mut self, seen: &Seen<'_, '_, R, P, N>, command: &[P; N], watch: bool) -> [Fault; N] {
        let input = &seen.moment.input;
        let recorded = &seen.outcome.output.record.feedback;
        let mut faults = [Fault::None; N];
        let active = input.homed && input.enable;
        for k in 0..N {
            let (axis, reading) = (&seen.facts.axes[k], input.feedback[k]);
            let readable = |position: P| !active || position.is_within(&axis.readable);
            let fault = if !reading.is_usable() {
                Fault::FeedbackNotFinite
            } else if input.encoder_alarm >> (k & 7) & 1 == 1 {
                Fault::EncoderAlarm
            } else if !readable(reading) {
                Fault::FeedbackJump
            } else if !watch {
                Fault::None
            } else {
                // The limit grows with the number of missing readings.
                let limit = axis.feedback_jump * (1.0 + f64::from(self.missing[k]));
                let jumps = size::<P>(apart(reading, self.good[k]), limit);
                if jumps == Size::Beyond || jumps == Size::Either && recorded[k] != reading {
                    Fault::FeedbackJump
                } else if apart(reading, self.steady[k]) > steps::<P>(axis.still) {
                    (self.steady[k], self.counted[k], self.unmoved[k]) = (reading, command[k], 0.0);
                    Fault::None
                } else {
                    let way = if self.active { apart(command[k], self.counted[k]) } else { 0.0 };
                    if way > steps::<P>(axis.play) {
                        self.unmoved[k] += way;
                    }
                    if way > steps::<P>(axis.play) || !self.active {
                        self.counted[k] = command[k];
                    }
                    // Exact to the position step, because no output shows which of several axes was stuck.
                    if self.unmoved[k] > steps::<P>(axis.stuck) { Fault::EncoderStuck } else { Fault::None }
                }
            };
            match fault {
                Fault::None => (self.good[k], self.missing[k]) = (reading, 0),
                // Before the first command only the command can replace a reading; likewise if the last good reading is out of
                // range.
                _ if !self.started || !readable(self.good[k]) => {
                    (self.good[k], self.steady[k]) = (command[k], command[k]);
                }
                _ => self.missing[k] = self.missing[k].saturating_add(1),
            }
            if !matches!(fault, Fault::None | Fault::EncoderStuck) {
                self.counted[k] = command[k];
            }
            if !watch {
                (self.steady[k], self.counted[k], self.unmoved[k]) = (self.good[k], command[k], 0.0);
            }
            faults[k] = fault;
            let apart = self.good[k].to_f64() - command[k].to_f64();
            self.apart[k] = [self.apart[k][0].min(apart), self.apart[k][1].max(apart)];
        }
        self.ratios(seen, active, &mut faults);
        faults
    }

    /// Readings of a wrong ratio: follows the record where a reading has deviated enough; the axes' own tests know when it must.
    fn ratios<R: Scalar>(&mut self, seen: &Seen<'_, '_, R, P, N>, active: bool, faults: &mut [Fault; N]) {
        if !active {
            self.ratio = [false; N];
        }
        let record = &seen.outcome.output.record;
        let reported = (active && record.fault == Fault::FeedbackRatio).then_some(usize::from(record.fault_axis));
        for (k, fault) in faults.iter_mut().enumerate() {
            let [least, most] = self.apart[k];
            self.ratio[k] |= reported == Some(k) && most - least > RIGHT;
            if self.ratio[k] && *fault == Fault::None {
                *fault = Fault::FeedbackRatio;
            }
        }
    }

    /// A stop before the first command: the machine is where every axis was last read. Returns whether that is known.
    fn placed<R: Scalar>(&mut self, seen: &Seen<'_, '_, R, P, N>) -> bool {
        let all = ((1_u32 << N) - 1) as u8;
        if self.known == all {
            return true;
        }
        let input = &seen.moment.input;
        let active = input.homed && input.enable;
        for k in 0..N {
            let readable = !active || input.feedback[k].is_within(&seen.facts.axes[k].readable);
            if input.feedback[k].is_usable() && readable && input.encoder_alarm >> k & 1 == 0 {
                self.held[k] = input.feedback[k];
                self.known |= 1 << k;
            }
        }
        self.known == all
    }

    /// Compares the command with the held one on every axis.
    fn near<R: Scalar>(&self, seen: &Seen<'_, '_, R, P, N>) -> Size {
        let mut near = Size::Within;
        for k in 0..N {
            let command = seen.moment.input.command[k];
            let here = match command.is_usable() {
                true => size::<P>(apart(command, self.held[k]), seen.facts.axes[k].resume),
                false => Size::Beyond,
            };
            match (here, near) {
                (Size::Beyond, _) => near = Size::Beyond,
                (Size::Either, Size::Within) => near = Size::Either,
                _ => {}
            }
        }
        near
    }

    /// The reading that the record must show.
    pub(super) fn accepted(&self) -> &[P; N] {
        &self.good
    }
}
