//! The events of a cycle: how each begins, and how it acts while it lasts.

use super::combination::Measured;
use super::device::{Ground, Moment};
use super::event::Event;
use super::facts::Facts;
use super::host::Host;
use super::scalar::{Place, Scalar};
use trueaxis::compensation::ThermalLine;
use trueaxis::sample::Refusal;
use trueaxis::{Dynamics, Fault};

/// Faults of a stage before the step.
const REFUSALS: [Fault; 5] =
    [Fault::ToolUnreachable, Fault::SingularPose, Fault::BranchChange, Fault::CommandNotFinite, Fault::CommandJump];

impl<R: Scalar, P: Place, const N: usize> Host<R, P, N> {
    /// Begins an event; some end at once.
    pub(super) fn begin(
        &mut self,
        event: Event,
        ground: &Ground<'_, R, P, N>,
        facts: &Facts<P, N>,
        moment: &mut Moment<R, P, N>,
    ) {
        let dice = &mut self.dice;
        self.victims[event as usize] = dice.below(N) as u8;
        let cycles = match event {
            Event::WildCommand => 1 + dice.below(6),
            Event::Jump | Event::OutOfTravel | Event::Late | Event::Early | Event::Refusal => 1 + dice.below(2),
            Event::WildReading | Event::Alarm | Event::Probes => 1 + dice.below(60),
            Event::Everything => 1 + dice.below(5),
            Event::Stuck | Event::Disable | Event::Reference => 1 + dice.below(300),
            Event::Unhomed => 1 + dice.below(100),
            Event::Reset => 1 + dice.below(4),
            _ => 1,
        };
        self.timers[event as usize] = cycles as u16;
        match event {
            Event::Exchange => moment.exchange = Some(dice.below(ground.loops.len())),
            Event::Thermal => {
                let extreme = dice.one_in(8);
                let [offset, slope] = if extreme { [10.0, 1e-3] } else { [0.02, 2e-5] };
                let line = ThermalLine::new(offset * dice.signed(), slope * dice.signed());
                moment.thermal = Some((dice.below(N + 1), line.expect("within the limits")));
            }
            Event::Switches => {
                let bits = dice.bits() as u8;
                self.dynamics = if dice.one_in(2) { Dynamics::ALL } else { Dynamics(bits) };
            }
            Event::Learned => {
                for k in 0..3 {
                    let wild = dice.one_in(8);
                    self.learned[k] = if wild { P::wild(dice) } else { P::of(0.01 * dice.signed()) };
                }
                if dice.one_in(3) {
                    self.learned = [P::default(); 3];
                }
            }
            Event::Measure => {
                let kinds = [Measured::Nothing, Measured::Path, Measured::Window, Measured::ToolPath, self.base];
                self.measured = dice.one_of(&kinds);
                if self.measured == Measured::ToolPath && ground.kinematics.is_none() || dice.one_in(2) {
                    self.measured = self.base;
                }
                moment.restart = dice.one_in(2);
            }
            Event::Stuck => self.stood = self.reading[usize::from(self.victims[event as usize])],
            Event::Ends => self.at_an_end(facts),
            Event::Gauge => {
                let turning = dice.one_of(&[0, -60, -300, 40, 150, 400, 800, 1000, 3000]);
                self.spindle.turning = if dice.one_in(3) { self.spindle.turning } else { turning };
                moment.probes.new_part = dice.one_in(4);
            }
            Event::Unhomed => {
                for k in 0..N {
                    let [low, high] = facts.axes[k].travel.map(P::to_f64);
                    self.motion.at[k] = dice.range(low, high).clamp(-1e3, 1e3);
                }
            }
            _ => {}
        }
    }

    /// Sets the switched-off axes near an end of a travel.
    fn at_an_end(&mut self, facts: &Facts<P, N>) {
        self.timers[Event::Disable as usize] = 2;
        let k = self.dice.below(N);
        if !facts.axes[k].present {
            return;
        }
        let [low, high] = facts.axes[k].travel.map(P::to_f64);
        let off = 0.01 * self.dice.unit();
        self.motion.at[k] = if self.dice.one_in(2) { low + off } else { high - off };
    }

    /// Applies the current events to a cycle.
    pub(super) fn disturb(&mut self, ground: &Ground<'_, R, P, N>, facts: &Facts<P, N>, moment: &mut Moment<R, P, N>) {
        // The case of nearly every cycle.
        if self.timers.iter().all(|left| *left == 0) {
            return;
        }
        for event in Event::ALL {
            let left = &mut self.timers[*event as usize];
            if *left > 0 {
                *left -= 1;
                self.act(*event, ground, facts, moment);
            }
        }
    }

    fn act(&mut self, event: Event, ground: &Ground<'_, R, P, N>, facts: &Facts<P, N>, moment: &mut Moment<R, P, N>) {
        let k = usize::from(self.victims[event as usize]);
        let dice = &mut self.dice;
        let (input, axis) = (&mut moment.input, &facts.axes[k]);
        match event {
            Event::WildCommand => input.command[k] = P::wild(dice),
            Event::Jump => {
                let way = axis.command_jump.min(1e3) * dice.one_of(&[0.999, 1.01, 3.0, -1.01, -20.0]);
                input.command[k] = P::of(input.command[k].to_f64() + way);
            }
            Event::OutOfTravel => {
                let off = dice.factor(1e-6, 10.0);
                let [low, high] = axis.travel.map(P::to_f64);
                input.command[k] = P::of(if dice.one_in(2) { low - off } else { high + off });
            }
            Event::WildReading => input.feedback[k] = P::wild(dice),
            Event::ReadingJumps => {
                let way = axis.feedback_jump.min(1e3) * dice.one_of(&[0.99, 1.2, -2.0, 30.0]);
                input.feedback[k] = P::of(input.feedback[k].to_f64() + way);
            }
            Event::Alarm => input.encoder_alarm = (dice.bits() & dice.bits()) as u8 | 1 << k,
            Event::Stuck => input.feedback[k] = P::of(self.stood),
            Event::Late => {
                let periods = dice.factor(1.1, 40.0);
                let late = f64::from(facts.period_ns) * periods;
                input.elapsed_ns = if dice.one_in(8) { u32::MAX } else { late as u32 };
            }
            Event::Early => input.elapsed_ns = dice.below(facts.period_ns as usize) as u32,
            Event::Disable => input.enable = false,
            Event::Unhomed => input.homed = false,
            Event::Reset => input.reset = true,
            Event::Reference => {
                const WILD: [f64; 8] = [f64::NAN, f64::INFINITY, -1.0, 2.0, 1e300, -0.0, 0.5, f64::NEG_INFINITY];
                moment.reference.t = R::of(dice.one_of(&WILD));
                moment.reference.span = dice.below(ground.spans.len() + 2) as u32;
            }
            Event::Probes => {
                const WILD: [f64; 6] = [f64::NAN, f64::INFINITY, 1e30, -1001.0, 999.0, -0.0];
                moment.probes.readings[k % 3] = R::of(dice.one_of(&WILD));
            }
            Event::Gauge => {
                moment.probes.idle = dice.one_in(2);
                if dice.one_in(2) {
                    moment.probes.index = dice.one_in(2).then(|| dice.bits() as i32);
                }
            }
            Event::Refusal => match &mut moment.tool {
                Some(tool) => {
                    let mut spoilt = *tool;
                    self.spoil(&mut spoilt);
                    moment.tool = Some(spoilt);
                }
                None => input.refusal = Refusal { fault: dice.one_of(&REFUSALS), slot: k as u8 },
            },
            Event::Everything => self.everything(ground, moment),
            _ => {}
        }
    }

    fn everything(&mut self, ground: &Ground<'_, R, P, N>, moment: &mut Moment<R, P, N>) {
        let dice = &mut self.dice;
        let input = &mut moment.input;
        for k in 0..N {
            if dice.one_in(2) {
                input.command[k] = P::wild(dice);
            }
            if dice.one_in(2) {
                input.feedback[k] = P::wild(dice);
            }
        }
        let bits = dice.bits();
        input.encoder_alarm = (bits & bits >> 8) as u8;
        input.elapsed_ns = (bits >> 16) as u32;
        (input.homed, input.enable, input.reset) = (bits >> 48 & 3 != 0, bits >> 50 & 3 != 0, bits >> 52 & 1 == 0);
        input.dynamics = Dynamics((bits >> 56) as u8);
        input.learned = [(); 3].map(|()| P::wild(dice));
        moment.reference.t = R::of(f64::from_bits(dice.bits()));
        moment.reference.span = dice.below(2 * ground.spans.len() + 2) as u32;
        moment.probes.readings = [(); 3].map(|()| R::of(f64::from_bits(dice.bits())));
        (moment.probes.spindle, moment.probes.arm) = (dice.bits() as i32, dice.bits() as i32);
        moment.tool = None;
    }
}
