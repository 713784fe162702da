//! Checks that need no cycle.

use super::device::Ground;
use super::rule::{Broken, Rule, Tally};
use super::sample;
use super::scalar::{Place, Scalar};
use trueaxis::Fault;
use trueaxis::tcomp::Tcomp;

/// Checks periods, and tables that are damaged or belong to other machines.
pub(super) fn check<R: Scalar, P: Place, const N: usize>(
    number: u64,
    ground: &Ground<'_, R, P, N>,
    tally: &mut Tally,
) -> Result<(), Broken> {
    let period = ground.facts[0].period_ns;
    for (measured, fits) in [(period, true), (period + period / 500, false), (period - period / 500, false)] {
        let answer = ground.loops[0].check_period(measured);
        let expected = if fits { Ok(()) } else { Err(Fault::PeriodMismatch) };
        tally.that(Rule::Period, answer == expected, || format!("{answer:?} for {measured} of {period} ns"))?;
    }
    if number.is_multiple_of(16) {
        let files = &sample::FILES;
        let file = &files[(number / 16) as usize % files.len()];
        let Ok(tables) = Tcomp::parse(file) else { return Ok(()) };
        let own = tables.machine_id();
        let holds = tables.expect_machine(own).is_ok() && tables.expect_machine(own ^ 1 << (number % 32)).is_err();
        tally.that(Rule::Foreign, holds, || format!("{own}"))?;
        let mut damaged = file.clone();
        let at = (number as usize).wrapping_mul(7919) % file.len();
        damaged[at] ^= 1 << (number / 16 % 8);
        tally.that(Rule::Foreign, Tcomp::parse(&damaged).is_err(), || format!("byte {at} damaged"))?;
    }
    Ok(())
}
