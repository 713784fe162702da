//! Refused tables: the bypass that replaces the step, on the same inputs.

use super::rule::{Broken, Rule, Tally};
use super::scalar::{Place, Scalar};
use trueaxis::telemetry::Status;
use trueaxis::{Bypass, Fault, Input, Output};

/// The bypass, and its expected results.
#[derive(Clone, Debug)]
pub(super) struct Through<P: Place, const N: usize> {
    bypass: Bypass<P, N>,
    reason: Fault,
    next: u32,
    held: [P; N],
    known: u32,
    commanded: bool,
    read: [P; N],
    has_read: [bool; N],
}

impl<P: Place, const N: usize> Through<P, N> {
    pub(super) fn new(reason: Fault) -> Self {
        let zero = [P::default(); N];
        Through {
            bypass: Bypass::new(reason),
            reason,
            next: 0,
            held: zero,
            known: 0,
            commanded: false,
            read: zero,
            has_read: [false; N],
        }
    }

    /// Runs and checks one cycle.
    pub(super) fn check<R: Scalar>(&mut self, tally: &mut Tally, input: &Input<P, N>) -> Result<(), Broken> {
        let output: Output<R, P, N> = self.bypass.step(input);
        let usable = input.command.iter().all(|command| command.is_usable());
        if usable {
            (self.held, self.commanded) = (input.command, true);
        }
        let all = (1 << N) - 1;
        for k in 0..N {
            let sound = input.feedback[k].is_usable();
            if !self.commanded && self.known != all && sound && input.encoder_alarm >> k & 1 == 0 {
                self.held[k] = input.feedback[k];
            }
        }
        if !self.commanded && self.known != all {
            for k in 0..N {
                let sound = input.feedback[k].is_usable() && input.encoder_alarm >> k & 1 == 0;
                self.known |= u32::from(sound) << k;
            }
        }
        for k in 0..N {
            if input.feedback[k].is_usable() {
                (self.read[k], self.has_read[k]) = (input.feedback[k], true);
            } else if !self.has_read[k] {
                self.read[k] = self.held[k];
            }
        }
        let record = &output.record;
        let same = |a: &[P; N], b: &[P; N]| a.iter().zip(b).all(|(a, b)| a.bits() == b.bits());
        let holds = (!output.has_drive() || same(&output.drive, &self.held))
            && same(&output.feedback, &self.read)
            && record.sequence == self.next
            && record.fault == self.reason
            && output.has_drive() == (self.commanded || self.known == all)
            && record.status.has(Status::STOP_REQUEST) != usable
            && record.correction.iter().all(|c| *c == R::ZERO);
        self.next = self.next.wrapping_add(1);
        tally.that(Rule::Bypass, holds, || format!("{output:?} for {input:?}"))
    }
}
