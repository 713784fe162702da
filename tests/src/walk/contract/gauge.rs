//! The gauge in the loop: its probes, the bound of its infeed, and which revolutions it must and must not learn from.

use super::{Contract, Seen, Verdict};
use crate::walk::gauge::MANY;
use crate::walk::rule::{Broken, Rule};
use crate::walk::scalar::{Place, Scalar};
use trueaxis::roundness::GaugeFlags;

/// Bound on the weights of the cubic through four points that interpolates the infeed between two of them.
const BETWEEN: f64 = 1.26;

/// State of the gauge after the previous cycle.
#[derive(Clone, Debug)]
pub(super) struct GaugeMemory<R: Scalar> {
    /// The infeed after the last revolution.
    correction: [R; MANY],
    sampled: u32,
    /// Cycles since then, and those in which the infeed was followed only in part, or not at all.
    cycles: u32,
    limited: u32,
    ineffective: u32,
    /// Whether the axis of the infeed was limited in the last cycle.
    was_limited: bool,
    /// Revolutions discarded because of a new part.
    lost: u32,
    clearing: bool,
    /// Whether the preceding state is unknown.
    unknown: bool,
}

impl<R: Scalar> Default for GaugeMemory<R> {
    fn default() -> Self {
        GaugeMemory {
            correction: [R::ZERO; MANY],
            sampled: 0,
            cycles: 0,
            limited: 0,
            ineffective: 0,
            was_limited: false,
            lost: 0,
            clearing: false,
            unknown: true,
        }
    }
}

impl<R: Scalar, P: Place, const N: usize> Contract<R, P, N> {
    /// Checks every cycle with a gauge.
    pub(super) fn gauged(&mut self, seen: &Seen<'_, '_, R, P, N>, verdict: Verdict) -> Result<(), Broken> {
        let Some(gauge) = &seen.ground.gauge else { return Ok(()) };
        let (output, state, probes) = (&seen.outcome.gauge_output, &seen.device.gauge, &seen.moment.probes);
        let good = probes.readings.iter().all(|reading| reading.to_f64().abs() <= 1000.0);
        let reported = output.flags.has(GaugeFlags::PROBE_RANGE);
        // Without an angle the probes are not evaluated.
        let holds = if good { !reported } else { output.flags.discards() };
        self.tally.that(Rule::Probes, holds, || format!("{:?} for {:?}", output.flags, probes.readings))?;
        let limit = seen.ground.infeed_limit_um * 1e-3;
        let infeed = output.infeed.to_f64();
        // False for NaN.
        let bounded = infeed.abs() <= BETWEEN * limit * (1.0 + 1e-5);
        self.tally.that(Rule::InfeedBound, bounded, || format!("{infeed} mm of {limit}"))?;

        let memory = &mut self.gauge;
        let counts = state.counts();
        memory.cycles += 1;
        let slot = gauge.infeed_slot().unwrap_or(N);
        if verdict != Verdict::Active && seen.outcome.output.record.fault != trueaxis::Fault::JointRange || probes.idle
        {
            memory.ineffective += 1;
        } else if memory.was_limited {
            memory.limited += 1;
        }
        memory.was_limited = seen.outcome.output.record.limited >> (slot & 7) & 1 == 1;
        if counts.sampled != memory.sampled && !memory.unknown {
            let few = memory.cycles / 64 + 3;
            let learns = gauge.infeed_slot().is_some();
            if learns && (memory.limited > few || memory.ineffective > few) {
                let frozen = output.flags.has(GaugeFlags::INFEED_FROZEN);
                let found = || format!("{memory:?}, {:?}", output.flags);
                self.tally.that(Rule::InfeedFrozen, frozen, found)?;
            }
            (memory.cycles, memory.limited, memory.ineffective) = (0, 0, 0);
        }
        if counts.sampled != memory.sampled || memory.unknown {
            (memory.cycles, memory.limited, memory.ineffective) = (0, 0, 0);
        }
        (memory.sampled, memory.unknown) = (counts.sampled, false);
        let loose = counts.sampled.wrapping_sub(counts.evaluated).wrapping_sub(counts.skipped);
        if probes.new_part {
            (memory.lost, memory.clearing) = (loose, true);
        }
        memory.clearing &= !state.is_settled();
        // Clearing the profile learned from the last part counts as work, but not as work on a revolution.
        let in_work = u32::from(!state.is_settled() && !memory.clearing);
        let done = loose.wrapping_sub(memory.lost);
        self.tally.that(Rule::GaugeCounts, done == in_work, || format!("{counts:?}, in work: {in_work}"))?;
        if output.finished {
            self.revolution(seen)?;
        }
        Ok(())
    }

    /// Checks a completed revolution.
    fn revolution(&mut self, seen: &Seen<'_, '_, R, P, N>) -> Result<(), Broken> {
        let state = &seen.device.gauge;
        let Some(latest) = state.latest() else { return Ok(()) };
        let correction = state.correction();
        let limit = seen.ground.infeed_limit_um;
        let bounded = correction.iter().all(|c| c.to_f64().abs() <= limit * (1.0 + 1e-5));
        self.tally.that(Rule::InfeedBound, bounded, || format!("{correction:?} µm of {limit}"))?;
        let motion = [latest.x, latest.y];
        let numbers = motion.iter().flat_map(|motion| {
            let [cosine, sine] = motion.once_per_revolution_um;
            [motion.synchronous_um, motion.asynchronous_um, motion.total_um, cosine, sine]
        });
        let finite = latest.peak_to_valley_um.is_finite() && numbers.into_iter().all(|x| x.is_finite());
        self.tally.that(Rule::Finite, finite, || format!("{latest:?}"))?;
        if latest.flags.has(GaugeFlags::INFEED_FROZEN) && !latest.flags.has(GaugeFlags::INFEED_REDUCED) {
            let before = &self.gauge.correction[..correction.len()];
            let same = correction == before || correction.iter().all(|c| *c == R::ZERO);
            let found = || format!("{:?}: {correction:?} after {before:?}", latest.flags);
            self.tally.that(Rule::InfeedFrozen, same, found)?;
        }
        self.gauge.correction[..correction.len()].copy_from_slice(correction);
        Ok(())
    }
}
