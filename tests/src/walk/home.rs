//! The return to a fixed position: the same bits as at the start, and agreement with the stateless functions.

use super::combination::Measured;
use super::device::{Ground, Moment};
use super::digest::Digest;
use super::rule::{Broken, Rule};
use super::scalar::{Place, Scalar};
use super::walker::Walker;
use trueaxis::compensation::{Direction, ThermalLine};
use trueaxis::contour::Reference;
use trueaxis::roundness::Probes;
use trueaxis::{Conditions, Input};

/// Number of compared cycles after switching on.
const COMPARED: u32 = 150;
/// Cycles after which the walk no longer waits for a correction that is still limited.
const PATIENCE: u32 = 500;

impl<R: Scalar, P: Place, const N: usize> Walker<'_, '_, R, P, N> {
    /// Goes home switched off, using the configuration without dynamic correction, holds once, is switched on from rest;
    /// returns a digest of the following bits. Leaves the first configuration in force, no thermal growth, a fresh gauge and
    /// an empty window.
    pub(super) fn home(&mut self, home: [f64; N], measured: Measured) -> Result<u64, Broken> {
        let at = home.map(P::of);
        let period = self.ground.facts[0].period_ns;
        let rest = Input { command: at, feedback: at, ..Input::at_rest(period) };
        let mut moment = Moment {
            input: rest,
            measured,
            reference: Reference { span: 0, t: R::ZERO },
            probes: Probes::default(),
            tool: None,
            exchange: Some(self.ground.loops.len() - 1),
            thermal: None,
            restart: true,
        };
        if let Some(gauge) = &self.ground.gauge {
            self.device.gauge = gauge.start();
            self.contract.restart_gauge();
        }
        // Reset at the held position, switched off.
        for number in 0..6 {
            let (stopped, held) = self.contract.held();
            if !stopped && number > 0 {
                break;
            }
            let command = if stopped { held } else { at };
            moment.input = Input { command, reset: stopped && number & 1 == 1, ..rest };
            self.cycle(&mut moment, None)?;
            (moment.exchange, moment.restart) = (None, false);
        }
        moment.input = rest;
        for slot in 0..N {
            moment.thermal = Some((slot, ThermalLine::default()));
            self.cycle(&mut moment, None)?;
        }
        moment.thermal = None;
        // The contract bounds the time.
        while !self.contract.is_at_zero() {
            self.cycle(&mut moment, None)?;
        }
        moment.exchange = Some(0);
        for _ in 0..2 {
            moment.input = Input { command: [P::of(f64::NAN); N], ..rest };
            self.cycle(&mut moment, None)?;
            moment.exchange = None;
        }
        moment.restart = true;
        moment.input = Input { homed: true, enable: true, reset: true, ..rest };
        let mut digest = Digest::EMPTY;
        for _ in 0..COMPARED {
            self.cycle(&mut moment, None)?;
            digest.add(&self.outcome, false);
            (moment.input.reset, moment.restart) = (false, false);
        }
        self.settle(&mut moment)?;
        Ok(digest.0)
    }

    /// Rests until no limit binds: the correction must agree with the stateless functions.
    fn settle(&mut self, moment: &mut Moment<R, P, N>) -> Result<(), Broken> {
        let facts = &self.ground.facts[self.active];
        if facts.dynamic || facts.at_feedback {
            return Ok(());
        }
        let mut calm = 0;
        for _ in 0..PATIENCE {
            self.cycle(moment, None)?;
            calm = if self.outcome.output.record.limited == 0 { calm + 1 } else { 0 };
            if calm > 10 {
                return self.compare(moment.input.command);
            }
        }
        Ok(())
    }

    fn compare(&mut self, command: [P; N]) -> Result<(), Broken> {
        let (record, servo) = (&self.outcome.output.record, self.servo);
        let sent = record.correction.map(R::to_f64);
        let rounding = if R::EPSILON.to_f64() > 1e-10 { 5e-5 } else { 2e-6 } + P::GRAIN;
        let near = |a: f64, b: f64| (a - b).abs() <= rounding;
        // Only the step knows each axis' direction of travel.
        let ways = (0..1_u32 << N).map(|bits| Conditions {
            directions: std::array::from_fn(|k| Direction::of(bits >> k & 1 == 1)),
            ..Conditions::default()
        });
        let mut found = None;
        for way in ways {
            let Ok(correction) = servo.correction_at(&command, &way) else { continue };
            if correction.iter().zip(sent).all(|(a, b)| near(a.to_f64(), b)) {
                found = Some(way);
                break;
            }
        }
        let tally = &mut self.contract.tally;
        let forward = servo.correction_at(&command, &Conditions::default());
        tally.that(Rule::Settles, found.is_some(), || format!("{sent:?}, not {forward:?}"))?;
        let way = found.unwrap_or_default();
        let Ok(errors) = servo.error_at(&self.outcome.output.drive, &way) else { return Ok(()) };
        // The volumetric form also corrects directions; these errors do not include the effect of its rotary axes on the tip.
        let turned = servo.compensation().volumetric().is_some() && sent[3..].iter().any(|c| *c != 0.0);
        if !turned {
            let cancels = errors.iter().zip(sent).all(|(error, c)| near(-error.to_f64(), c));
            tally.that(Rule::Cancels, cancels, || format!("{errors:?} against {sent:?}"))?;
        }
        Ok(())
    }
}

/// The middle of the travel common to all configurations; rotary axes at zero if a tool is to follow a path.
pub(super) fn place<R: Scalar, P: Place, const N: usize>(ground: &Ground<'_, R, P, N>, at_zero: bool) -> [f64; N] {
    std::array::from_fn(|k| {
        let travels = || ground.facts.iter().map(|facts| facts.axes[k].travel.map(P::to_f64));
        let low = travels().map(|[low, _]| low).fold(-1e4, f64::max);
        let high = travels().map(|[_, high]| high).fold(1e4, f64::min);
        if at_zero && k > 2 { 0.0 } else { 0.45 * low + 0.55 * high }
    })
}
