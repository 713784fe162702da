//! The output to the drives: sum, limits across every transition, hold, freeze, ramping out.

use super::moving::{Moving, SHARE};
use super::{Contract, Seen, Verdict};
use crate::walk::facts::{AxisFacts, Bounds};
use crate::walk::rule::{Broken, Rule};
use crate::walk::scalar::{Place, Scalar};
use trueaxis::Output;

/// The last output.
#[derive(Clone, Debug)]
pub(super) struct Motion<R: Scalar, P: Place, const N: usize> {
    sum: [Moving; N],
    drive: [P; N],
    /// Total correction of the command, and its geometric part as reported.
    total: [R; N],
    correction: [R; N],
    /// Whether the correction had two parts.
    parted: bool,
    /// Cycles since the step was switched off, and the number that ramping out may take.
    dark: f64,
    may: f64,
}

impl<R: Scalar, P: Place, const N: usize> Default for Motion<R, P, N> {
    fn default() -> Self {
        let zero = [R::ZERO; N];
        Motion {
            sum: [Moving::default(); N],
            drive: [P::default(); N],
            total: zero,
            correction: zero,
            parted: false,
            dark: 0.0,
            may: 0.0,
        }
    }
}

impl<R: Scalar, P: Place, const N: usize> Motion<R, P, N> {
    pub(super) fn is_at_zero(&self) -> bool {
        self.total.iter().all(|c| *c == R::ZERO)
    }

    /// Maximum movement of the drive in one cycle, in either direction.
    fn reach(&self, k: usize, axis: &AxisFacts<P>) -> f64 {
        axis.sum.v.max(self.sum[k].v.abs()) * (1.0 + SHARE) + 4.0 * P::GRAIN + 1e-7
    }
}

fn rule_of(broken: [bool; 3]) -> Rule {
    match broken {
        [false, ..] => Rule::Magnitude,
        [_, false, _] => Rule::Slope,
        _ => Rule::Acceleration,
    }
}

impl<R: Scalar, P: Place, const N: usize> Contract<R, P, N> {
    /// The output would leave the range of a joint and must hold; checks that this was possible.
    pub(super) fn joint_range(
        &mut self,
        seen: &Seen<'_, '_, R, P, N>,
        verdict: Verdict,
        first: bool,
    ) -> Result<(), Broken> {
        let record = &seen.outcome.output.record;
        let k = usize::from(record.fault_axis);
        let possible = match seen.facts.axes.get(k) {
            Some(axis) if verdict != Verdict::Inactive && !first => {
                let at = seen.moment.input.command[k].to_f64() + self.motion.sum[k].c;
                let reach = self.motion.reach(k, axis);
                at + reach > axis.joint[1].to_f64() || at - reach < axis.joint[0].to_f64()
            }
            _ => false,
        };
        let found = || format!("axis {k} at {:?}, {verdict:?}, first: {first}", seen.moment.input.command);
        self.tally.that(Rule::JointRangeOnlyWhenDue, possible, found)
    }

    /// Checks drives, corrections and the host's feedback.
    pub(super) fn follow(&mut self, seen: &Seen<'_, '_, R, P, N>, verdict: Verdict, first: bool) -> Result<(), Broken> {
        let output = &seen.outcome.output;
        let total = totals(output);
        self.feedback_is_measured(seen)?;
        if verdict.holds() {
            self.output_holds(seen, &total, first)?;
        } else {
            self.output_follows(seen, &total, verdict, first)?;
        }
        let motion = &mut self.motion;
        (motion.drive, motion.total, motion.correction) = (output.drive, total, output.record.correction);
        motion.parted = output.record.dynamic.is_some();
        Ok(())
    }

    fn feedback_is_measured(&mut self, seen: &Seen<'_, '_, R, P, N>) -> Result<(), Broken> {
        let output = &seen.outcome.output;
        for k in 0..N {
            let reading = output.record.feedback[k];
            let expected = reading.moved_back(P::offset(self.motion.total[k]));
            let same = match self.motion.parted {
                false => output.feedback[k].bits() == expected.bits(),
                true => is_near::<R, P>(output.feedback[k], expected, reading, self.motion.correction[k]),
            };
            let found = || format!("axis {k}: {:?}, not {expected:?}", output.feedback[k]);
            self.tally.that(Rule::FeedbackIsMeasured, same, found)?;
        }
        Ok(())
    }

    /// Checks a held output.
    fn output_holds(&mut self, seen: &Seen<'_, '_, R, P, N>, total: &[R; N], first: bool) -> Result<(), Broken> {
        let (motion, output) = (&mut self.motion, &seen.outcome.output);
        // A configuration without dynamic correction reports the whole correction as geometric.
        let renamed = seen.exchanged && motion.parted != output.record.dynamic.is_some();
        for k in 0..N {
            let place = if first { self.senses.held[k] } else { motion.drive[k] };
            let drive = output.drive[k].bits() == place.bits() || !output.has_drive();
            let correction = output.record.correction[k].bits() == motion.correction[k].bits();
            let sum = total[k].bits() == motion.total[k].bits();
            let off = (total[k].to_f64() - motion.total[k].to_f64()).abs();
            let parts = output.record.correction[k].to_f64().abs() + motion.correction[k].to_f64().abs();
            let near = off <= 4.0 * R::EPSILON.to_f64() * (total[k].to_f64().abs() + parts);
            let holds = drive && if renamed { near } else { correction && sum };
            let found = || {
                let (was, is) = (motion.correction[k], output.record.correction[k]);
                format!("axis {k}: drive {:?} after {place:?}, correction {is:?} after {was:?}", output.drive[k])
            };
            self.tally.that(Rule::Hold, holds, found)?;
            motion.sum[k].stop();
            if seen.exchanged {
                motion.sum[k].lowered::<R>(&seen.facts.axes[k].sum);
            }
        }
        motion.dark = 0.0;
        Ok(())
    }

    /// The output follows the command.
    fn output_follows(
        &mut self,
        seen: &Seen<'_, '_, R, P, N>,
        total: &[R; N],
        verdict: Verdict,
        first: bool,
    ) -> Result<(), Broken> {
        let (output, input) = (&seen.outcome.output, &seen.moment.input);
        let within = !first && verdict != Verdict::Inactive;
        let dynamic = output.record.dynamic.is_some();
        for (k, axis) in seen.facts.axes.iter().enumerate() {
            let (command, drive, c) = (input.command[k], output.drive[k], total[k]);
            let expected = command.moved(P::offset(c));
            let same = match dynamic {
                false => drive.bits() == expected.bits(),
                true => is_near::<R, P>(drive, expected, command, output.record.correction[k]),
            };
            self.tally.that(Rule::DriveIsSum, same, || format!("axis {k}: {drive:?}, not {expected:?}"))?;
            if within && axis.present {
                let inside = drive.is_within(&axis.joint);
                self.tally.that(Rule::JointRange, inside, || format!("axis {k} at {drive:?} of {:?}", axis.joint))?;
            }
            if first {
                let passes = c == R::ZERO && drive.bits() == command.bits();
                self.tally.that(Rule::First, passes, || format!("axis {k}: {drive:?} for {command:?}"))?;
                continue;
            }
            self.limited(seen, k, c, verdict)?;
        }
        if verdict == Verdict::Inactive && !first {
            return self.passes(seen, total);
        }
        self.motion.dark = 0.0;
        Ok(())
    }

    /// Checks magnitude, slope and acceleration of one axis, and the freeze.
    #[inline(always)]
    fn limited(&mut self, seen: &Seen<'_, '_, R, P, N>, k: usize, c: R, verdict: Verdict) -> Result<(), Broken> {
        let (axis, moving) = (&seen.facts.axes[k], &mut self.motion.sum[k]);
        let other = seen.outcome.output.record.dynamic.map_or(0.0, |parts| parts.sent[k].to_f64());
        if seen.exchanged {
            moving.lowered::<R>(&axis.sum);
        }
        let before = *moving;
        if !self.senses.due {
            // A constant sum may be rounded differently after being split into other parts and summed.
            let rounding = 8.0 * R::EPSILON.to_f64() * (before.c.abs() + before.other().max(other.abs()));
            let dynamic = seen.exchanged || seen.facts.dynamic || before.other() > 0.0;
            let unchanged = (c.to_f64() - before.c).abs() <= if dynamic { rounding } else { 0.0 };
            let found = || format!("axis {k}: {before:?} to {c:?} in no time, {verdict:?}");
            return self.tally.that(Rule::Pace, unchanged, found);
        }
        let keeps = moving.keeps::<R>(c.to_f64(), other, &axis.sum);
        let holds = keeps == [true; 3];
        let found = || format!("axis {k}: {before:?} to {moving:?} of {:?}, {verdict:?}", axis.sum);
        let rule = if seen.exchanged { Rule::ExchangeSmooth } else { rule_of(keeps) };
        self.tally.that(rule, holds, found)?;
        if !seen.exchanged {
            self.tally.0[Rule::Magnitude as usize] += 1;
            self.tally.0[Rule::Slope as usize] += 1;
        }
        if verdict == Verdict::Frozen && !seen.facts.dynamic && !seen.exchanged {
            let most = (before.v.abs() - axis.sum.a).max(0.0);
            let size = before.c.abs().max(moving.c.abs()).max(before.other()) + before.v.abs();
            let still = moving.v.abs() <= most + 1e-6 * axis.sum.a + 4.0 * R::EPSILON.to_f64() * size;
            let settled = before.v.abs() > axis.sum.a || moving.c == before.c || still && before.v != 0.0;
            self.tally.that(Rule::Freeze, still && settled, || {
                format!("axis {k}: {before:?} to {moving:?} of {:?}", axis.sum)
            })?;
        }
        Ok(())
    }

    /// Switched off: the correction must reach zero within the time that the limits take; then commands pass bit for bit.
    fn passes(&mut self, seen: &Seen<'_, '_, R, P, N>, total: &[R; N]) -> Result<(), Broken> {
        let (output, motion) = (&seen.outcome.output, &mut self.motion);
        let record = &output.record;
        if record.dynamic.is_none() {
            let expected = (0..N).fold(0, |bits, k| bits | u8::from(total[k] != R::ZERO) << k);
            let found = || format!("{:b}, not {expected:b}, for {total:?}", record.limited);
            self.tally.that(Rule::LimitedReported, record.limited == expected, found)?;
        }
        if motion.dark == 0.0 || seen.exchanged {
            motion.may = motion.dark;
            for (moving, axis) in motion.sum.iter().zip(&seen.facts.axes) {
                motion.may = motion.may.max(motion.dark + way_out(moving, axis, seen.facts.dynamic));
            }
        }
        motion.dark += f64::from(u8::from(self.senses.due));
        // The feed-forward of a drive decays like the error that it compensates.
        let negligible = if seen.facts.dynamic { 1e-9 } else { 0.0 };
        if total.iter().any(|c| c.to_f64().abs() > negligible) {
            let found = || format!("{total:?} after {} cycles, {} at most", motion.dark, motion.may);
            return self.tally.that(Rule::RampedOut, motion.dark <= motion.may, found);
        }
        if total.iter().all(|c| *c == R::ZERO) {
            let commands = output.drive.iter().zip(&seen.moment.input.command).zip(&record.correction);
            let same = commands.clone().all(|((drive, command), part)| match drive.bits() == command.bits() {
                // Two parts that cancel each other: the output is rounded once, the reported parts separately.
                false => *part != R::ZERO && is_near::<R, P>(*drive, *command, *command, *part),
                true => true,
            });
            let found = || format!("{:?} for {:?}, {:?}", output.drive, seen.moment.input.command, record.correction);
            self.tally.that(Rule::Disabled, same, found)?;
        }
        Ok(())
    }
}

/// Cycles until a correction is zero, with margin: twice the time for its size at the slope, and for the acceleration.
fn way_out<P>(moving: &Moving, axis: &AxisFacts<P>, dynamic: bool) -> f64 {
    let time = |c: f64, bounds: &Bounds, a: f64| {
        let v = moving.v.abs().max(bounds.v.min((2.0 * a * c).sqrt()));
        10.0 + 2.0 * (c / bounds.v + 3.0 * v / a + v * v / (a * bounds.v) + moving.v.abs() / a)
    };
    let geometric = time(moving.c.abs(), &axis.sum, axis.sum.a);
    if !dynamic {
        return geometric;
    }
    // Both parts, each through its own limiter, then through that of the sum.
    let c = axis.sum.c + axis.dynamic.c;
    axis.dies_away
        + 2.0 * (geometric + time(c, &axis.sum, axis.ramp_a) + time(axis.dynamic.c, &axis.dynamic, axis.dynamic.a))
}

/// Total correction of the command.
fn totals<R: Scalar, P: Place, const N: usize>(output: &Output<R, P, N>) -> [R; N] {
    let record = &output.record;
    match &record.dynamic {
        None => record.correction,
        Some(parts) => std::array::from_fn(|k| record.correction[k] + parts.sent[k]),
    }
}

/// Whether two positions are equal except for the rounding of a sum of two parts.
fn is_near<R: Scalar, P: Place>(a: P, b: P, place: P, part: R) -> bool {
    let part = part.to_f64().abs() + 0.2;
    let rounding = 2.0 * P::GRAIN + 4.0 * R::EPSILON.to_f64() * part + 1e-15 * place.to_f64().abs();
    (a.to_f64() - b.to_f64()).abs() <= rounding + 1e-15
}
