//! Adversarial cycles: inputs as hard for the step as a program, a host and encoders can make them.
//!
//! A hundred thousand cycles in scenes that begin cold, drawn from seeds by plain IEEE operations: a host and a bare-metal
//! image of the same scalar compute identical bits, and running a scene up to any of its cycles replays that cycle.

mod course;
mod digest;
mod random;
mod servo;
#[cfg(test)]
mod tests;

pub use course::{COURSES, Course};
pub use digest::Digest;
pub use servo::{ServoParts, vary};

use core::fmt;
use random::Random;
use trueaxis::compensation::ThermalLine;
use trueaxis::contour::Reference;
use trueaxis::roundness::Probes;
use trueaxis::{Input, Position, Real};

/// Number of axes.
pub const AXES: usize = 3;
/// Total number of cycles.
pub const CYCLES: u32 = 100_000;
/// Number of cycles per scene; the first starts from a fresh state.
pub const SCENE: u32 = 250;
/// Number of these cycles that also run with dynamic correction, [`vary`]ing.
pub const DYNAMIC_CYCLES: u32 = 10_000;
/// Largest motion of a command in a cycle, mm: plausible at 200 mm/s and 1 ms.
const FARTHEST: f64 = 0.3;
/// Maximum number of spans passed in a cycle.
const HOPS: u32 = 64;

/// Events of a cycle besides its motion; several may coincide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events(u16);

impl Events {
    const NAMES: [&str; 16] = [
        "cold start",
        "readings missing",
        "encoder alarm",
        "late cycle",
        "reading jumps",
        "reference leaps over spans",
        "not homed",
        "not enabled",
        "another program",
        "tables exchanged",
        "reversal",
        "bad command",
        "reset",
        "reference elsewhere on the path",
        "thermal growth set",
        "readings far along the path",
    ];
    const COLD: u32 = 0;
    const MISSING: u32 = 1;
    const ALARM: u32 = 2;
    const LATE: u32 = 3;
    const GLITCH: u32 = 4;
    const LEAP: u32 = 5;
    const NOT_HOMED: u32 = 6;
    const DISABLED: u32 = 7;
    const PROGRAM: u32 = 8;
    const EXCHANGE: u32 = 9;
    const REVERSAL: u32 = 10;
    const BAD_COMMAND: u32 = 11;
    const RESET: u32 = 12;
    const ELSEWHERE: u32 = 13;
    const THERMAL: u32 = 14;
    const FAR: u32 = 15;

    fn set(&mut self, event: u32) {
        self.0 |= 1 << event;
    }

    fn has(self, event: u32) -> bool {
        self.0 & (1 << event) != 0
    }
}

impl fmt::Display for Events {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut before = "";
        for (_, name) in (0..).zip(Self::NAMES).filter(|(event, _)| self.has(*event)) {
            write!(f, "{before}{name}")?;
            before = ", ";
        }
        if self.0 == 0 { f.write_str("motion alone") } else { Ok(()) }
    }
}

/// Inputs of one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Moment<R, P> {
    /// Input of the step.
    pub input: Input<P, AXES>,
    /// Position on the course.
    pub reference: Reference<R>,
    /// Index of the course.
    pub course: usize,
    /// Whether the second tables are in force.
    pub exchanged: bool,
    /// Input of the gauge.
    pub probes: Probes<R>,
    /// Whether the cycle begins with a fresh state.
    pub cold: bool,
    /// Thermal growth of an axis from this cycle on: slot and line.
    pub thermal: Option<(usize, ThermalLine<R>)>,
    /// Events of the cycle.
    pub events: Events,
}

/// Draws the cycles one after the other.
#[derive(Clone, Debug)]
pub struct Adversary<'a, R, P> {
    courses: &'a [Course<R, P>],
    period_ns: u32,
    random: Random,
    course: usize,
    /// Number of the span, and arc length on it.
    span: u32,
    arc: R,
    command: [P; AXES],
    /// Motion of a stretch of cycles: speed along the path per cycle and distances of the readings, mm.
    speed: R,
    jitter: R,
    behind: [R; AXES],
    stretch: u32,
    /// Distance along the path in this cycle instead of the speed.
    leap: Option<R>,
    /// Cycles until a latched stop is released; the program does not advance until then.
    stopped: u32,
    off: u32,
    homing: bool,
    exchanged: bool,
    spindle: i32,
    turning: i32,
}

impl<'a, R: Real, P: Position> Adversary<'a, R, P> {
    /// An adversary on the courses 0 to [`COURSES`] − 1.
    pub fn new(courses: &'a [Course<R, P>], period_ns: u32) -> Self {
        Adversary {
            courses,
            period_ns,
            random: Random::new(0),
            course: 0,
            span: 0,
            arc: R::ZERO,
            command: [P::default(); AXES],
            speed: R::ZERO,
            jitter: R::ZERO,
            behind: [R::ZERO; AXES],
            stretch: 0,
            leap: None,
            stopped: 0,
            off: 0,
            homing: false,
            exchanged: false,
            spindle: 0,
            turning: 0,
        }
    }

    /// Draws cycle `number` of [`CYCLES`]. Cycles of a scene are drawn in order, starting from its first, a multiple of
    /// [`SCENE`].
    pub fn cycle(&mut self, number: u32) -> Moment<R, P> {
        let mut events = Events::default();
        if number.is_multiple_of(SCENE) {
            *self = Adversary { random: Random::new(number / SCENE), ..Self::new(self.courses, self.period_ns) };
            events.set(Events::COLD);
            self.program();
        }
        if self.stretch == 0 {
            self.stretch();
        }
        self.stretch -= 1;
        self.spindle = self.spindle.wrapping_add(self.turning);
        // Calm stretches between the events let limiters settle and cells fill.
        let eventful = self.random.below(8) == 0;
        if eventful {
            for _ in 0..1 + self.random.below(3) {
                self.happen(&mut events);
            }
        }
        let mut reference = self.advance();
        let mut moment = self.moment(reference);
        if eventful {
            self.disturb(&mut events, &mut moment);
        }
        if events.has(Events::ELSEWHERE) {
            reference.span = self.random.below(self.spans().max(1));
            reference.t = self.random.unit();
            moment.reference = reference;
        }
        self.switches(&mut events, &mut moment);
        moment.cold = events.has(Events::COLD);
        moment.events = events;
        moment
    }

    /// Continues with other random numbers.
    pub fn divert(&mut self, seed: u32) {
        self.random = Random::new(seed);
    }

    fn spans(&self) -> u32 {
        self.courses.get(self.course).map_or(0, Course::len)
    }

    /// Jumps to a random position on a random course.
    fn program(&mut self) {
        self.course = self.random.below(self.courses.len() as u32) as usize;
        self.span = self.random.below(self.spans().max(1));
        self.arc = R::ZERO;
    }

    /// Draws a new motion for some cycles.
    fn stretch(&mut self) {
        self.stretch = 8 + self.random.below(56);
        let fastest = self.random.one_of(&[0.0, 0.001, 0.01, 0.05, 0.1, 0.2]);
        let sense = if self.random.below(4) == 0 { -R::ONE } else { R::ONE };
        self.speed = R::of(fastest) * sense;
        self.jitter = R::of(self.random.one_of(&[0.0, 1e-4, 0.001, 0.005, 0.02]));
        let lag = R::of(self.random.one_of(&[0.0, 0.001, 0.01, 0.1, 0.5]));
        self.behind = [(); AXES].map(|()| lag * self.random.signed());
        self.turning = self.random.one_of(&[0, 431, 3600, 36_000, -3600, 400_000]);
    }

    /// Draws events of the motion; [`Adversary::disturb`] draws those of the readings.
    fn happen(&mut self, events: &mut Events) {
        let event = 1 + self.random.below(15);
        events.set(event);
        match event {
            Events::LEAP => self.leap = Some(R::of(FARTHEST) * self.random.signed()),
            Events::NOT_HOMED | Events::DISABLED => {
                (self.off, self.homing) = (1 + self.random.below(3), event == Events::NOT_HOMED);
            }
            // A new program comes with a pause, and perhaps with new tables and the other direction: all state kept between
            // cycles becomes useless at once.
            Events::PROGRAM if self.stopped == 0 => {
                self.program();
                (self.off, self.homing) = (1, self.random.below(2) == 0);
                self.exchanged ^= self.random.below(2) == 0;
            }
            Events::EXCHANGE => self.exchanged = !self.exchanged,
            Events::REVERSAL => self.speed = -self.speed,
            Events::BAD_COMMAND => self.stopped = self.stopped.max(2 + self.random.below(5)),
            _ => {}
        }
    }

    /// Moves along the path, reversing at the ends of an open one.
    fn advance(&mut self) -> Reference<R> {
        let way = self.leap.take().unwrap_or(self.speed);
        if self.stopped == 0 {
            self.arc += way;
        }
        let Some(course) = self.courses.get(self.course) else { return Reference { span: 0, t: R::ZERO } };
        let (path, last) = (course.path(), course.len().saturating_sub(1));
        for _ in 0..HOPS {
            let Some(span) = path.span(self.span) else { break };
            if self.arc > span.length() {
                let wraps = self.span == last;
                if wraps && !course.is_closed() {
                    (self.arc, self.speed) = (span.length(), -self.speed);
                    break;
                }
                self.arc -= span.length();
                self.span = if wraps { 0 } else { self.span + 1 };
            } else if self.arc < R::ZERO {
                let wraps = self.span == 0;
                if wraps && !course.is_closed() {
                    (self.arc, self.speed) = (R::ZERO, -self.speed);
                    break;
                }
                self.span = if wraps { last } else { self.span - 1 };
                self.arc += path.span(self.span).map_or(R::ZERO, |span| span.length());
            } else {
                break;
            }
        }
        let t = path.span(self.span).map_or(R::ZERO, |span| span.t_at(self.arc));
        Reference { span: self.span, t }
    }

    /// The undisturbed cycle at a reference.
    fn moment(&mut self, reference: Reference<R>) -> Moment<R, P> {
        let place = self.courses.get(self.course).and_then(|course| course.path().on(reference).position());
        self.command = place.unwrap_or(self.command);
        let mut input = Input { command: self.command, homed: true, enable: true, ..Input::at_rest(self.period_ns) };
        for ((reading, command), behind) in input.feedback.iter_mut().zip(&self.command).zip(self.behind) {
            *reading = command.plus(behind + self.jitter * self.random.signed());
        }
        let readings = [(); 3].map(|()| R::of(5.0) * self.random.signed());
        let turned = self.random.below(16) == 0;
        let index = turned.then_some(self.spindle & !0xfff);
        let probes = Probes { readings, spindle: self.spindle, index, ..Probes::default() };
        let (course, exchanged) = (self.course, self.exchanged);
        Moment { input, reference, course, exchanged, probes, cold: false, thermal: None, events: Events::default() }
    }

    /// Applies the events of readings and commands.
    fn disturb(&mut self, events: &mut Events, moment: &mut Moment<R, P>) {
        let random = &mut self.random;
        let slot = random.below(AXES as u32) as usize;
        let input = &mut moment.input;
        if let Some(reading) = input.feedback.get_mut(slot) {
            if events.has(Events::MISSING) {
                *reading = P::of(f64::NAN);
            }
            if events.has(Events::GLITCH) {
                *reading = reading.plus(R::of(5.0) * random.signed());
            }
        }
        if events.has(Events::FAR) {
            let far = R::of(0.25) * random.signed();
            self.behind = self.behind.map(|behind| behind + far);
        }
        if events.has(Events::ALARM) {
            input.encoder_alarm = random.below(8) as u8;
        }
        if events.has(Events::LATE) {
            input.elapsed_ns = self.period_ns + self.period_ns / 4 * random.below(80);
        }
        if events.has(Events::BAD_COMMAND)
            && let Some(command) = input.command.get_mut(slot)
        {
            *command = match random.below(3) {
                0 => P::of(f64::NAN),
                1 => P::of(900.0),
                _ => command.plus(R::of(20.0)),
            };
        }
        if events.has(Events::THERMAL) {
            let kelvin = 10.0 * random.signed::<f64>();
            moment.thermal = ThermalLine::new(2e-3 * kelvin, 11.5e-6 * kelvin).map(|line| (slot, line));
        }
    }

    /// Sets homing, enabling and the release of a stop.
    fn switches(&mut self, events: &mut Events, moment: &mut Moment<R, P>) {
        if self.off > 0 {
            self.off -= 1;
            moment.input.homed = !self.homing;
            moment.input.enable = self.homing;
            events.set(if self.homing { Events::NOT_HOMED } else { Events::DISABLED });
        }
        if self.stopped > 0 {
            self.stopped -= 1;
            if self.stopped == 0 {
                events.set(Events::RESET);
            }
        }
        moment.input.reset = events.has(Events::RESET);
    }
}
