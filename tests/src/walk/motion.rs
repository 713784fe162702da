//! Plausible motion of the commands: standing, moving, dithering, waves, along the path, by the tool.

use super::device::Ground;
use super::dice::Dice;
use super::facts::Facts;
use super::scalar::{Place, Scalar};
use trueaxis::contour::Reference;

/// Motion of the axes for some cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Rest,
    Go,
    Dither,
    Wave,
    /// Moves to the start of the reference, then along the path.
    Reach,
    Follow,
}

/// The commands in the absence of events.
#[derive(Clone, Debug)]
pub(super) struct Motion<R, const N: usize> {
    /// Commanded positions, mm (deg).
    pub(super) at: [f64; N],
    /// Whether the tool is commanded in this phase.
    pub(super) by_tool: bool,
    pub(super) reference: Reference<R>,
    phase: Phase,
    left: u32,
    speed: [f64; N],
    goal: [f64; N],
    turn: [f64; 2],
    wave: [f64; 2],
    arc: f64,
    /// Offset from the path to the axes.
    shift: [f64; 3],
    home: [f64; N],
}

impl<R: Scalar, const N: usize> Motion<R, N> {
    pub(super) fn new(home: [f64; N], shift: [f64; 3]) -> Self {
        Motion {
            at: home,
            by_tool: false,
            reference: Reference { span: 0, t: R::ZERO },
            phase: Phase::Rest,
            left: 0,
            speed: [0.0; N],
            goal: home,
            turn: [1.0, 0.0],
            wave: [1.0, 0.0],
            arc: 0.0,
            shift,
            home,
        }
    }

    /// Stops at this position, until another phase begins.
    pub(super) fn stop_at(&mut self, at: [f64; N]) {
        (self.at, self.phase, self.left, self.by_tool) = (at, Phase::Rest, 3, false);
    }

    /// The next command, within the travel and the highest feed of every axis.
    pub(super) fn advance<P: Place>(
        &mut self,
        dice: &mut Dice,
        ground: &Ground<'_, R, P, N>,
        facts: &Facts<P, N>,
        follows: bool,
        tool: bool,
    ) {
        if self.left == 0 {
            self.begin(dice, ground, facts, follows, tool);
        }
        self.left -= 1;
        match self.phase {
            Phase::Rest => {}
            Phase::Go => {
                for k in 0..N {
                    self.at[k] += self.speed[k];
                }
            }
            Phase::Dither => {
                let back = if self.left & 1 == 0 { 1.0 } else { -1.0 };
                for k in 0..N {
                    self.at[k] += back * self.speed[k];
                }
            }
            Phase::Wave => self.follow_wave(),
            Phase::Reach => {
                let mut there = true;
                for k in 0..N {
                    let most = 0.8 * facts.axes[k].feed;
                    let way = self.goal[k] - self.at[k];
                    there &= way.abs() <= most;
                    self.at[k] += way.clamp(-most, most);
                }
                if there {
                    (self.phase, self.left) = (Phase::Follow, 200 + dice.below(2000) as u32);
                    self.speed[0] = dice.factor(0.01, 0.9) * facts.axes[..3].iter().fold(1.0, |a, b| b.feed.min(a));
                }
            }
            Phase::Follow => self.follow(ground),
        }
        for k in 0..N {
            let [low, high] = facts.axes[k].travel.map(P::to_f64);
            if self.at[k] <= low || self.at[k] >= high {
                self.at[k] = self.at[k].clamp(low, high);
                self.speed[k] = -self.speed[k];
            }
        }
    }

    /// A wave about the axes' last position: the increments of a rotating pointer.
    fn follow_wave(&mut self) {
        let [c, s] = self.turn;
        let [x, y] = self.wave;
        let next = [c * x - s * y, s * x + c * y];
        for k in 0..N {
            self.at[k] += self.speed[k] * (next[k & 1] - self.wave[k & 1]);
        }
        self.wave = next;
    }

    fn follow<P: Place>(&mut self, ground: &Ground<'_, R, P, N>) {
        let path = ground.path();
        let Some(span) = path.span(self.reference.span) else {
            self.left = 0;
            return;
        };
        self.arc += self.speed[0];
        let length = span.length().to_f64();
        if self.arc >= length || span.is_stationary() {
            let next = self.reference.span + 1;
            self.arc = (self.arc - length).max(0.0);
            if next as usize >= ground.spans.len() {
                if !ground.closed {
                    self.left = 0;
                    self.reference.t = R::ONE;
                    return;
                }
                self.reference.span = 0;
            } else {
                self.reference.span = next;
            }
        }
        let Some(span) = path.span(self.reference.span) else { return };
        self.arc = self.arc.min(span.length().to_f64());
        self.reference.t = span.t_at(R::of(self.arc)).max(R::ZERO).min(R::ONE);
        let place = span.position(self.reference.t);
        for k in 0..3 {
            self.at[k] = place[k].to_f64() + self.shift[k];
        }
    }

    fn begin<P: Place>(
        &mut self,
        dice: &mut Dice,
        ground: &Ground<'_, R, P, N>,
        facts: &Facts<P, N>,
        follows: bool,
        tool: bool,
    ) {
        self.by_tool = tool && dice.one_in(3);
        let most = if dice.one_in(3) { 40 } else { 800 };
        self.left = 1 + dice.below(most) as u32;
        let share = if self.by_tool { dice.factor(1e-4, 0.2) } else { dice.factor(1e-3, 0.95) };
        for k in 0..N {
            let idle = dice.one_in(3);
            self.speed[k] = if idle { 0.0 } else { share * facts.axes[k].feed * dice.signed() };
        }
        self.phase = match dice.below(10) {
            0 | 1 => Phase::Rest,
            2..=4 => Phase::Go,
            5 => {
                for k in 0..N {
                    let band = facts.axes[k].hysteresis;
                    self.speed[k] = (band * dice.factor(0.05, 20.0)).min(0.9 * facts.axes[k].feed);
                }
                Phase::Dither
            }
            6 => {
                let angle = dice.factor(2e-3, 0.5);
                self.turn = [angle.cos(), angle.sin()];
                self.wave = [1.0, 0.0];
                for k in 0..N {
                    self.speed[k] *= 1.0 / angle;
                }
                Phase::Wave
            }
            _ if follows && !ground.spans.is_empty() => self.set_out(dice, ground),
            _ => Phase::Go,
        };
    }

    /// Heads for any point of the path.
    fn set_out<P: Place>(&mut self, dice: &mut Dice, ground: &Ground<'_, R, P, N>) -> Phase {
        let number = dice.below(ground.spans.len());
        self.reference = Reference { span: number as u32, t: R::ZERO };
        (self.arc, self.by_tool, self.left) = (0.0, false, 3000);
        self.goal = self.home;
        for (k, place) in ground.spans[number].position(R::ZERO).into_iter().enumerate() {
            self.goal[k] = place.to_f64() + self.shift[k];
        }
        Phase::Reach
    }
}
