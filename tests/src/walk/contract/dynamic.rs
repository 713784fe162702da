//! The dynamic correction: its limits, parts, switches and watch.

use super::moving::Moving;
use super::{Contract, Seen, Verdict};
use crate::walk::rule::{Broken, Rule};
use crate::walk::scalar::{Place, Scalar};
use trueaxis::telemetry::Status;
use trueaxis::{DynamicParts, Dynamics};

/// State of the dynamic correction after the previous cycle.
#[derive(Clone, Debug)]
pub(super) struct Parts<R: Scalar, const N: usize> {
    sent: [Moving; N],
    geometric: [Moving; N],
    /// Cycles since a limit last bound, by axis.
    free: [u32; N],
    /// The feedback's wanted correction during a refused reading, with the parts that were switched on.
    frozen: Option<([R; N], Dynamics)>,
    out: bool,
}

impl<R: Scalar, const N: usize> Default for Parts<R, N> {
    fn default() -> Self {
        let rest = [Moving::default(); N];
        Parts { sent: rest, geometric: rest, free: [0; N], frozen: None, out: false }
    }
}

impl<R: Scalar, P: Place, const N: usize> Contract<R, P, N> {
    /// Checks every cycle.
    pub(super) fn dynamic(
        &mut self,
        seen: &Seen<'_, '_, R, P, N>,
        verdict: Verdict,
        first: bool,
    ) -> Result<(), Broken> {
        let record = &seen.outcome.output.record;
        let agrees = record.dynamic.is_some() == seen.facts.dynamic;
        self.tally.that(Rule::NoDynamic, agrees, || format!("{:?}", record.dynamic))?;
        let Some(parts) = &record.dynamic else {
            let geometric = record.correction.map(|c| Moving::at(c.to_f64()));
            self.parts = Parts { geometric, ..Parts::default() };
            return Ok(());
        };
        self.own_limits(seen, parts, verdict, first)?;
        self.switches(seen, parts, verdict, first)
    }

    fn own_limits(
        &mut self,
        seen: &Seen<'_, '_, R, P, N>,
        parts: &DynamicParts<R, N>,
        verdict: Verdict,
        first: bool,
    ) -> Result<(), Broken> {
        let record = &seen.outcome.output.record;
        for (k, axis) in seen.facts.axes.iter().enumerate() {
            let (sent, geometric) = (parts.sent[k].to_f64(), record.correction[k].to_f64());
            if verdict.holds() || first {
                // Other rules check that nothing moves.
                (self.parts.sent[k].c, self.parts.geometric[k].c) = (sent, geometric);
                self.parts.sent[k].stop();
                self.parts.geometric[k].stop();
                if seen.exchanged {
                    self.parts.sent[k].lowered::<R>(&axis.dynamic);
                }
                self.parts.free[k] = 0;
                continue;
            }
            let free = record.limited >> k & 1 == 0 && !seen.exchanged && verdict == Verdict::Active;
            self.parts.free[k] = if free { self.parts.free[k].saturating_add(1) } else { 0 };
            let moving = &mut self.parts.sent[k];
            if seen.exchanged {
                moving.lowered::<R>(&axis.dynamic);
            }
            let before = *moving;
            if !self.senses.due {
                let unchanged = (sent - before.c).abs() <= 8.0 * R::EPSILON.to_f64() * (sent.abs() + geometric.abs());
                let found = || format!("axis {k}: {before:?} to {sent} in no time");
                self.tally.that(Rule::Pace, unchanged || seen.exchanged, found)?;
                continue;
            }
            let keeps = moving.keeps::<R>(sent, geometric, &axis.dynamic);
            for (rule, keeps) in
                [Rule::DynamicMagnitude, Rule::DynamicSlope, Rule::DynamicAcceleration].into_iter().zip(keeps)
            {
                let found = || format!("axis {k}: {before:?} to {moving:?} of {:?}", axis.dynamic);
                self.tally.that(rule, keeps, found)?;
            }
            let moving = &mut self.parts.geometric[k];
            let before = *moving;
            let keeps = moving.keeps::<R>(geometric, 2.0 * sent, &axis.sum);
            if self.parts.free[k] > 3 && axis.present {
                let found = || format!("axis {k}: {before:?} to {moving:?} of {:?}", axis.sum);
                self.tally.that(Rule::GeometricLimits, keeps == [true; 3], found)?;
            }
        }
        Ok(())
    }

    fn switches(
        &mut self,
        seen: &Seen<'_, '_, R, P, N>,
        parts: &DynamicParts<R, N>,
        verdict: Verdict,
        first: bool,
    ) -> Result<(), Broken> {
        let (facts, input) = (seen.facts, &seen.moment.input);
        let works = matches!(verdict, Verdict::Active | Verdict::Frozen) && !first;
        if verdict.holds() {
            return Ok(());
        }
        let on = if works { input.dynamics } else { Dynamics::NONE };
        let any = |of: Dynamics| on.0 & of.0 != 0;
        // From the cycle after its detection.
        let out = self.parts.out && seen.outcome.output.record.status.has(Status::FEEDBACK_OUT);
        for (k, axis) in facts.axes.iter().enumerate() {
            let linear = k < 3;
            let silent = [
                (parts.feed_forward[k], axis.fed_forward),
                (parts.feedback[k], any(Dynamics::FEEDBACK) && facts.feedback && linear && !out),
                (parts.crosstalk[k], any(Dynamics::CROSSTALK) && axis.crosstalked),
                (parts.learned[k], any(Dynamics::LEARNED) && linear),
            ];
            for (part, may) in silent {
                if !may {
                    let found = || format!("axis {k}, {on:?}, out: {out}, {verdict:?}: {parts:?}");
                    self.tally.that(Rule::PartsOff, part == R::ZERO, found)?;
                }
            }
            if linear && any(Dynamics::LEARNED) {
                let learned = input.learned[k];
                let wanted = if learned.is_usable() { learned.since_near(P::default()) } else { R::ZERO };
                let found = || format!("axis {k}: {:?}, not {wanted:?}", parts.learned[k]);
                self.tally.that(Rule::Learned, parts.learned[k] == wanted, found)?;
            }
        }
        Ok(())
    }

    /// Checks the watch in every cycle; `verdict` is the one before the output was examined.
    pub(super) fn watch(&mut self, seen: &Seen<'_, '_, R, P, N>, verdict: Verdict, first: bool) -> Result<(), Broken> {
        let (input, record) = (&seen.moment.input, &seen.outcome.output.record);
        let on = input.dynamics.has(Dynamics::FEEDBACK);
        let out = record.status.has(Status::FEEDBACK_OUT);
        let works = matches!(verdict, Verdict::Active | Verdict::Frozen) && !first;
        if self.parts.out && !seen.exchanged {
            let stays = verdict.holds() || works && on && !input.reset;
            let found = || format!("{:?}, {verdict:?}, on: {on}", record.status);
            self.tally.that(Rule::FeedbackOut, out == (stays && !first) || first, found)?;
        } else {
            let may = verdict == Verdict::Active && on && seen.facts.feedback;
            let found = || format!("{:?}, {verdict:?}, on: {on}", record.status);
            self.tally.that(Rule::FeedbackOut, !out || may || seen.exchanged, found)?;
        }
        self.parts.out = out;
        let feedback = record.dynamic.map(|parts| (parts.feedback, input.dynamics));
        let frozen = feedback.filter(|_| verdict == Verdict::Frozen && !first && !seen.exchanged && !input.reset);
        if let (Some((before, parts)), Some((now, on))) = (self.parts.frozen, frozen)
            && parts == on
        {
            let mut axes = now.iter().zip(&before);
            let same = axes.all(|(now, before)| now == before || *now == R::ZERO);
            self.tally.that(Rule::FeedbackStands, same, || format!("{now:?} after {before:?}"))?;
        }
        self.parts.frozen = frozen;
        Ok(())
    }
}
