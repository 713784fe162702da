//! One cycle of a leg: the preceding changes, the step, the contract, and a shadow that must agree.

use super::contract::{Contract, Seen};
use super::device::{Device, Ground, Moment, Outcome};
use super::digest::Digest;
use super::host::Host;
use super::planted::Planted;
use super::rule::{Broken, Rule};
use super::scalar::{Place, Scalar};
use super::through::Through;
use trueaxis::exchange::Exchange;
use trueaxis::kinematics::{Kinematics, Tool};
use trueaxis::{Fault, Input, ServoLoop};

/// Cycles for which a shadow runs along.
const SHADOW: u32 = 200;

/// A leg in progress.
pub(super) struct Walker<'g, 'a, R: Scalar, P: Place, const N: usize> {
    pub(super) ground: &'g Ground<'a, R, P, N>,
    pub(super) servo: &'g ServoLoop<'a, R, P, N>,
    /// Number of the configuration in force.
    pub(super) active: usize,
    mailbox: Exchange<'g, ServoLoop<'a, R, P, N>>,
    pub(super) device: Device<R, P, N>,
    pub(super) outcome: Outcome<R, P, N>,
    pub(super) contract: Contract<R, P, N>,
    pub(super) digest: Digest,
    pub(super) cycles: u64,
    shadow: Option<Shadow<R, P, N>>,
    through: Through<P, N>,
    planted: Planted,
}

/// A copied state that runs in parallel: with the same configuration, or with its identical twin.
struct Shadow<R: Scalar, P: Place, const N: usize> {
    device: Device<R, P, N>,
    outcome: Outcome<R, P, N>,
    left: u32,
    twin: bool,
}

impl<'g, 'a, R: Scalar, P: Place, const N: usize> Walker<'g, 'a, R, P, N> {
    pub(super) fn new(ground: &'g Ground<'a, R, P, N>, planted: Planted) -> Self {
        Walker {
            ground,
            servo: &ground.loops[0],
            active: 0,
            mailbox: Exchange::new(),
            device: Device::new(ground),
            outcome: Outcome::none(),
            contract: Contract::default(),
            digest: Digest::EMPTY,
            cycles: 0,
            shadow: None,
            through: Through::new(Fault::TablesRefused),
            planted,
        }
    }

    /// Starts a shadow.
    pub(super) fn cast(&mut self, twin: bool) {
        let (device, outcome) = (self.device, self.outcome);
        self.shadow = Some(Shadow { device, outcome, left: SHADOW, twin });
    }

    /// Whether a shadow is running.
    pub(super) fn has_shadow(&self) -> bool {
        self.shadow.is_some()
    }

    /// Runs one cycle.
    pub(super) fn cycle(
        &mut self,
        moment: &mut Moment<R, P, N>,
        host: Option<&mut Host<R, P, N>>,
    ) -> Result<(), Broken> {
        let mut exchanged = false;
        if let Some(number) = moment.exchange {
            exchanged = number != self.active;
            // The mailbox is empty.
            let _ = self.mailbox.offer(&self.ground.loops[number]);
            self.mailbox.take_into(&mut self.servo);
            self.active = number;
        }
        if let Some(host) = host {
            self.find_axes(moment, host)?;
        }
        self.device.cycle::<true>(self.ground, self.servo, moment, &mut self.outcome);
        self.planted.spoil(&mut self.outcome.output, &moment.input, self.cycles);
        self.cycles += 1;
        let seen = Seen {
            ground: self.ground,
            facts: &self.ground.facts[self.active],
            exchanged,
            moment,
            outcome: &self.outcome,
            device: &self.device,
        };
        self.contract.check(&seen)?;
        self.digest.drives(&self.outcome);
        if self.shadow.is_some() {
            self.follow(moment)?;
        }
        if self.cycles & 3 == 0 {
            self.through.check::<R>(&mut self.contract.tally, &moment.input)?;
        }
        Ok(())
    }

    /// Computes the axis positions for a tool, and checks that they bring it there.
    fn find_axes(&mut self, moment: &mut Moment<R, P, N>, host: &mut Host<R, P, N>) -> Result<(), Broken> {
        let (Some(tool), Some(tracker), Some(kinematics)) =
            (moment.tool, host.tracker.as_mut(), self.ground.kinematics.as_ref())
        else {
            return Ok(());
        };
        moment.input = self.servo.rtcp(&self.device.state, &tool, tracker, kinematics, &moment.input);
        let numbers = [tool.tip.into(), tool.axis.into()];
        let finite = numbers.iter().flatten().all(|x| x.is_finite());
        let there = self.there(kinematics, &moment.input);
        let left = tracker.direction_error_deg();
        let in_cone = left <= R::of(self.ground.facts[0].cone_deg);
        let reached = in_cone && self.is_at(&there, numbers, self.beyond(&moment.input), left.to_f64());
        let refused = moment.input.refusal.fault;
        let holds = if refused == Fault::None { finite && reached } else { refused.stops() };
        let found = || format!("{tool:?}, not {there:?}: {refused:?}, {:?}", moment.input.command);
        self.contract.tally.that(Rule::Rtcp, holds, found)
    }

    /// The tool's pose at the positions of a cycle.
    fn there(&self, kinematics: &Kinematics<R>, input: &Input<P, N>) -> Tool<R> {
        let mut joints = [R::ZERO; 6];
        for (letter, command) in self.ground.facts[self.active].letters.iter().zip(&input.command) {
            joints[letter.index()] = R::of(command.to_f64());
        }
        kinematics.forward(&joints)
    }

    /// Bound on how far beyond its travel an axis may have been before it was clamped to the end, mm or degrees: `rtcp` allows
    /// 64 units in the last place for rounding. Zero if no axis is at an end.
    fn beyond(&self, input: &Input<P, N>) -> f64 {
        // The kinematics, and with them the travel, are those of the leg's first machine.
        let axes = self.ground.facts[0].axes.iter().zip(&input.command);
        let at_an_end = axes
            .flat_map(|(axis, command)| axis.travel.map(|end| end.to_f64() - command.to_f64()))
            .any(|off| off.abs() <= 2.0 * P::GRAIN + R::EPSILON.to_f64() * 1e3);
        if at_an_end { R::EPSILON.to_f64() * 64.0 * 2e3 } else { 0.0 }
    }

    /// Whether the tool is where it was commanded.
    fn is_at(&self, there: &Tool<R>, [tip, axis]: [[R; 3]; 2], beyond: f64, left_deg: f64) -> bool {
        let near =
            |a: [R; 3], b: [R; 3], most: f64| a.iter().zip(b).all(|(a, b)| (a.to_f64() - b.to_f64()).abs() <= most);
        // Whole micro-degrees on a lever of one metre, and the rounding of coordinates of that size.
        let rounding = 1e-9 + 40.0 * P::GRAIN + R::EPSILON.to_f64() * 2e4;
        let rounding = rounding + beyond;
        let turned = 1e-3 * rounding + 1e-7 + (beyond + left_deg).to_radians();
        near(there.tip.into(), tip, rounding) && near(there.axis.into(), axis, turned)
    }

    fn follow(&mut self, moment: &Moment<R, P, N>) -> Result<(), Broken> {
        let Some(shadow) = &mut self.shadow else { return Ok(()) };
        let number = if shadow.twin && self.active < 2 { 1 - self.active } else { self.active };
        let servo = &self.ground.loops[number];
        shadow.device.cycle::<false>(self.ground, servo, moment, &mut shadow.outcome);
        let mut digests = [Digest::EMPTY; 2];
        digests[0].add(&self.outcome, true);
        digests[1].add(&shadow.outcome, true);
        let rule = if shadow.twin { Rule::Twin } else { Rule::Copied };
        let found = || format!("{:?}\nnot\n{:?}", self.outcome, shadow.outcome);
        self.contract.tally.that(rule, digests[0] == digests[1], found)?;
        shadow.left -= 1;
        if shadow.left == 0 {
            self.shadow = None;
        }
        Ok(())
    }
}
