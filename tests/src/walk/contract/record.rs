//! Checks the record: counts, ids, finite numbers, state, commands and readings in force, ends of tables.

use super::{Contract, Seen, Verdict};
use crate::walk::rule::{Broken, Rule};
use crate::walk::scalar::{Place, Scalar};
use trueaxis::contour::ContourError;
use trueaxis::telemetry::Status;
use trueaxis::{Fault, Output};

/// Whether every number of an output is finite.
fn is_finite<R: Scalar, P: Place, const N: usize>(output: &Output<R, P, N>) -> bool {
    let record = &output.record;
    let mut finite = true;
    for positions in [&output.drive, &output.feedback, &record.command, &record.feedback] {
        finite &= positions.iter().all(|position| position.to_f64().is_finite());
    }
    finite &= record.correction.iter().all(|x| x.is_finite());
    if let Some(parts) = &record.dynamic {
        for part in [&parts.sent, &parts.feed_forward, &parts.feedback, &parts.crosstalk, &parts.learned] {
            finite &= part.iter().all(|x| x.is_finite());
        }
    }
    finite & contour_is_finite(&record.tip) & contour_is_finite(&record.encoder) & record.orientation.is_finite()
}

fn contour_is_finite<R: Scalar>(error: &ContourError<R>) -> bool {
    let vector: [R; 3] = error.vector.into();
    let others = [error.t, error.error, error.normal, error.binormal, error.tangential, error.lag, error.width];
    vector.iter().chain(&others).all(|x| x.is_finite())
}

impl<R: Scalar, P: Place, const N: usize> Contract<R, P, N> {
    /// Rules for any single record.
    pub(super) fn record(&mut self, seen: &Seen<'_, '_, R, P, N>) -> Result<(), Broken> {
        let (tally, output) = (&mut self.tally, &seen.outcome.output);
        let record = &output.record;
        let next = self.next.unwrap_or(0);
        tally.that(Rule::Sequence, record.sequence == next, || format!("{} after {next} − 1", record.sequence))?;
        self.next = Some(next.wrapping_add(1));
        let ids = (record.machine_id, record.tables_crc);
        let own = (seen.facts.machine_id, seen.facts.tables_crc);
        tally.that(Rule::Identity, ids == own, || format!("{ids:?} for {own:?}"))?;
        tally.that(Rule::Finite, is_finite(output), || format!("{output:?}"))
    }

    /// Rules that depend on the verdict.
    pub(super) fn by_verdict(&mut self, seen: &Seen<'_, '_, R, P, N>, verdict: Verdict) -> Result<(), Broken> {
        let (tally, input, output) = (&mut self.tally, &seen.moment.input, &seen.outcome.output);
        let record = &output.record;
        let state = match verdict {
            Verdict::Inactive => 0,
            Verdict::Active => Status::ACTIVE.0,
            Verdict::Frozen => Status::FROZEN.0,
            Verdict::Held => Status::STOP_REQUEST.0,
            Verdict::NoOutput => Status::STOP_REQUEST.0 | Status::NO_OUTPUT.0,
        };
        let mask = Status::ACTIVE.0 | Status::FROZEN.0 | Status::STOP_REQUEST.0;
        let found = || format!("{:?}, {verdict:?}", record.status);
        tally.that(Rule::State, record.status.0 & mask == state & mask, found)?;
        tally.that(Rule::NoOutput, output.has_drive() == (verdict != Verdict::NoOutput), found)?;
        let accepted = self.senses.accepted();
        let same = record.feedback.iter().zip(accepted).all(|(a, b)| a.bits() == b.bits());
        tally.that(Rule::ReadingInForce, same, || format!("{:?}, not {accepted:?}", record.feedback))?;
        let command = if verdict.holds() { &self.senses.held } else { &input.command };
        let same = record.command.iter().zip(command).all(|(a, b)| a.bits() == b.bits());
        tally.that(Rule::CommandInForce, same, || format!("{:?}, not {command:?}", record.command))?;
        if verdict.holds() {
            tally.that(Rule::LimitedReported, record.limited == 0, || format!("{:b} while held", record.limited))?;
        }
        if let Some((slot, line)) = seen.moment.thermal
            && let Some(reach) = self.grown.get_mut(slot)
        {
            let from_datum = [-3000.0, 3000.0].map(|way| line.at(R::of(way)).to_f64().abs());
            // A rotary axis moves points far from it.
            let lever = if slot > 2 { 40.0 } else { 1.0 };
            *reach = lever * from_datum.into_iter().fold(0.0, f64::max);
        }
        // The command of an axis that the machine does not have may be anything, a long lever for every angle.
        let farthest = input.command.iter().map(|command| command.to_f64().abs()).fold(0.0, f64::max);
        let far = farthest > 1e5;
        let leaning = 1.5 * seen.facts.lean * farthest;
        if verdict != Verdict::Active || record.fault != Fault::None || far {
            return Ok(());
        }
        for (k, axis) in seen.facts.axes.iter().enumerate() {
            let Some([low, high]) = axis.table else { continue };
            // Lookups are as far from the command as the correction may be.
            let margin = 2.0 * axis.sum.c + 0.1 + leaning + 1.5 * self.grown.iter().sum::<f64>();
            let at = [input.command[k], record.feedback[k]].map(P::to_f64);
            let reported = record.at_edge >> k & 1 == 1;
            if at.iter().all(|at| *at > low + margin && *at < high - margin) {
                tally.that(Rule::AtEdge, !reported, || format!("axis {k} at {at:?} within {low} to {high}"))?;
            } else if at.iter().all(|at| *at > high + margin) || at.iter().all(|at| *at < low - margin) {
                tally.that(Rule::AtEdge, reported, || format!("axis {k} at {at:?} beyond {low} to {high}"))?;
            }
        }
        Ok(())
    }
}
