//! The host of a leg: plausible motion, a plant that follows it, events, and recovery from a stop.

use super::combination::Measured;
use super::device::{Ground, Moment, Outcome};
use super::dice::Dice;
use super::event::{Event, Events};
use super::facts::Facts;
use super::motion::Motion;
use super::scalar::{Place, Scalar};
use super::spindle::Spindle;
use trueaxis::kinematics::{BranchTracker, Choice, Tool};
use trueaxis::{Dynamics, Input};

/// Draws the inputs of one cycle after the other.
#[derive(Clone, Debug)]
pub(super) struct Host<R: Scalar, P: Place, const N: usize> {
    pub(super) dice: Dice,
    allowed: Events,
    /// Number of times that each event began.
    pub seen: [u64; Event::ALL.len()],
    /// Remaining cycles of each event, and the axis that it affects.
    pub(super) timers: [u16; Event::ALL.len()],
    pub(super) victims: [u8; Event::ALL.len()],
    pub(super) motion: Motion<R, N>,
    /// Follows the tool while the tool is commanded.
    pub tracker: Option<BranchTracker<R>>,
    was_by_tool: bool,
    /// Encoders: position, share of the remaining travel per cycle, noise and resolution.
    pub(super) reading: [f64; N],
    follows: f64,
    noise: f64,
    step: f64,
    pub(super) spindle: Spindle<R>,
    pub(super) base: Measured,
    pub(super) measured: Measured,
    pub(super) dynamics: Dynamics,
    pub(super) learned: [P; 3],
    /// Value of a stuck reading.
    pub(super) stood: f64,
    stop: Stop,
}

/// Recovery from a stop.
#[derive(Clone, Copy, Debug, Default)]
struct Stop {
    cycles: u32,
    wait: u32,
    tries: u32,
}

impl<R: Scalar, P: Place, const N: usize> Host<R, P, N> {
    /// A host at home, with the events that are `allowed`.
    pub(super) fn new(mut dice: Dice, home: [f64; N], shift: [f64; 3], base: Measured, allowed: Events) -> Self {
        let follows = dice.one_of(&[1.0, 0.5, 0.3]);
        let noise = dice.one_of(&[0.0, 2e-4, 2e-3]);
        let step = dice.one_of(&[0.0, 1e-5, 1e-3]);
        Host {
            spindle: Spindle::draw(&mut dice),
            dice,
            allowed,
            seen: [0; Event::ALL.len()],
            timers: [0; Event::ALL.len()],
            victims: [0; Event::ALL.len()],
            motion: Motion::new(home, shift),
            tracker: None,
            was_by_tool: false,
            reading: home,
            follows,
            noise,
            step,
            base,
            measured: base,
            dynamics: Dynamics::ALL,
            learned: [P::default(); 3],
            stood: 0.0,
            stop: Stop::default(),
        }
    }

    /// The inputs of the next cycle, after the outcome of the last one.
    pub(super) fn next(
        &mut self,
        ground: &Ground<'_, R, P, N>,
        facts: &Facts<P, N>,
        last: &Outcome<R, P, N>,
    ) -> Moment<R, P, N> {
        self.plant(last);
        let mut reset = false;
        let mut switched = (true, true);
        if last.output.stop_requested() {
            (reset, switched) = self.recover(facts, last);
        } else {
            if self.stop.cycles > 0 || self.was_by_tool && !self.motion.by_tool {
                self.motion.stop_at(last.output.record.command.map(P::to_f64));
            }
            (self.stop, self.was_by_tool) = (Stop::default(), self.motion.by_tool);
            let follows = matches!(self.base, Measured::Path | Measured::ToolPath);
            let tool = ground.kinematics.is_some() && self.base == Measured::ToolPath;
            self.motion.advance(&mut self.dice, ground, facts, follows, tool);
        }
        let input = Input {
            command: self.motion.at.map(P::of),
            feedback: self.reading.map(P::of),
            homed: switched.0,
            enable: switched.1,
            reset,
            dynamics: self.dynamics,
            learned: self.learned,
            ..Input::at_rest(facts.period_ns)
        };
        let mut moment = Moment {
            input,
            measured: self.measured,
            reference: self.motion.reference,
            probes: self.spindle.turn(),
            tool: None,
            exchange: None,
            thermal: None,
            restart: false,
        };
        self.tool(ground, facts, &mut moment);
        if self.dice.one_in(70) {
            let event = self.dice.one_of(Event::ALL);
            if self.allowed.has(event) {
                self.seen[event as usize] += 1;
                self.begin(event, ground, facts, &mut moment);
            }
        }
        self.disturb(ground, facts, &mut moment);
        moment
    }

    /// The encoders follow the drives.
    fn plant(&mut self, last: &Outcome<R, P, N>) {
        if !last.output.has_drive() {
            return;
        }
        let mut bits = self.dice.bits();
        for (reading, drive) in self.reading.iter_mut().zip(&last.output.drive) {
            let drive = drive.to_f64();
            let way = drive - *reading;
            // After the axes were set to another position while switched off.
            *reading = if way.abs() > 20.0 { drive } else { *reading + self.follows * way };
            *reading += self.noise * (f64::from(bits as u8) / 128.0 - 1.0);
            bits >>= 8;
            if self.step > 0.0 && reading.abs() < 1e6 {
                *reading = (*reading / self.step).round() * self.step;
            }
        }
    }

    /// Returns near the held command, or not near enough; switches off if nothing else helps.
    fn recover(&mut self, facts: &Facts<P, N>, last: &Outcome<R, P, N>) -> (bool, (bool, bool)) {
        let stop = &mut self.stop;
        if stop.cycles == 0 {
            (stop.wait, stop.tries) = (2 + self.dice.below(40) as u32, 0);
        }
        stop.cycles += 1;
        let held = match last.output.has_drive() {
            true => last.output.record.command.map(P::to_f64),
            false => self.reading,
        };
        self.motion.stop_at(held);
        let tries = stop.tries;
        let switched = (tries <= 6, tries <= 3);
        if stop.cycles < stop.wait {
            return (false, switched);
        }
        (stop.wait, stop.tries) = (stop.cycles + 2 + self.dice.below(4) as u32, tries + 1);
        if tries > 8 {
            self.timers = [0; Event::ALL.len()];
            return (true, switched);
        }
        let far = self.dice.one_in(5).then(|| self.dice.below(N));
        for k in 0..N {
            let resume = facts.axes[k].resume.min(1.0);
            self.motion.at[k] += match far {
                Some(axis) if axis == k => resume * self.dice.range(1.2, 3.0),
                _ => 0.8 * resume * self.dice.signed() * self.dice.unit(),
            };
        }
        // Held down, it does not count as a reset.
        (true, switched)
    }

    /// Commands the tool in workpiece coordinates instead of the axes.
    fn tool(&mut self, ground: &Ground<'_, R, P, N>, facts: &Facts<P, N>, moment: &mut Moment<R, P, N>) {
        let Some(kinematics) = ground.kinematics.as_ref().filter(|_| self.motion.by_tool) else {
            self.tracker = None;
            return;
        };
        let mut joints = [R::ZERO; 6];
        for (axis, at) in facts.letters.iter().zip(self.motion.at) {
            joints[axis.index()] = R::of(at);
        }
        let tool = kinematics.forward(&joints);
        if self.tracker.is_none() {
            let fastest = facts.axes[3..].iter().fold(1e-3, |most, axis| axis.feed.max(most));
            let start = kinematics.solutions(&tool, &joints).and_then(|both| both.choose(Choice::Nearest));
            let start = start.ok().filter(|start| start.step_deg.to_f64() < fastest);
            self.tracker = start.map(|start| BranchTracker::new(&start, R::of(1.5 * fastest)));
            self.motion.by_tool = self.tracker.is_some();
        }
        moment.tool = self.tracker.is_some().then_some(tool);
    }

    /// Makes the tool's pose invalid or sets another direction.
    pub(super) fn spoil(&mut self, tool: &mut Tool<R>) {
        let [x, y, z]: [R; 3] = tool.axis.into();
        match self.dice.below(4) {
            0 => tool.axis = [R::of(f64::NAN), y, z].into(),
            1 => tool.axis = [R::ZERO; 3].into(),
            2 => tool.tip = [R::of(f64::INFINITY), R::ZERO, R::ZERO].into(),
            _ => tool.axis = [z, x, -y].into(),
        }
    }
}
