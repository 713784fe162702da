//! A leg: draws machines, path and gauge, walks, and returns home.

use super::combination::{Combination, Measured, Numbers};
use super::course::Course;
use super::device::Ground;
use super::dice::Dice;
use super::drawn::Drawn;
use super::event::{Event, Events};
use super::facts::Facts;
use super::gauge::AnyGauge;
use super::host::Host;
use super::machines;
use super::planted::Planted;
use super::rule::{Broken, Rule, Tally};
use super::scalar::{Place, Scalar};
use super::walker::Walker;
use super::{home, without_cycles};
use std::fmt;
use trueaxis::contour::Method;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::{GridData, Limits, MachineSettings};
use trueaxis::{Config, ConfigError, Nanometres, ServoLoop, check};

/// A leg to be walked.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Seed of the whole walk.
    pub seed: u64,
    /// Number of the leg; with the seed it determines everything that is drawn.
    pub number: u64,
    /// Combination that it runs.
    pub combination: Combination,
    /// Cycles, excluding the way home.
    pub cycles: u64,
    /// Events that may occur.
    pub events: Events,
    /// A defect for the contract to find.
    pub planted: Planted,
}

/// Result of a leg.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Walked {
    /// Number of times each rule was checked.
    pub tally: Tally,
    /// Number of times each event began.
    pub events: [u64; Event::ALL.len()],
    /// Cycles, including the way home.
    pub cycles: u64,
    /// Digest of the drives of all cycles.
    pub digest: u64,
    /// Index of the combination among all.
    pub combination: usize,
}

/// A broken rule.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The leg, with the events needed to break the rule.
    pub leg: Leg,
    /// The cycle, including the way home.
    pub cycle: u64,
    /// The broken rule.
    pub broken: Broken,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Failure { leg, cycle, broken } = self;
        writeln!(f, "{}: {}", broken.rule.name(), broken.rule.text())?;
        writeln!(f, "  {}", broken.found)?;
        writeln!(f, "  seed {}, leg {}, cycle {cycle}: {}", leg.seed, leg.number, leg.combination)?;
        let needed = Event::ALL.iter().filter(|event| leg.events.has(**event));
        let needed: Vec<_> = needed.map(|event| event.text()).collect();
        writeln!(f, "  events that it takes: {}", if needed.is_empty() { "none".into() } else { needed.join("; ") })?;
        write!(
            f,
            "  cargo run --release -p trueaxis-tests --bin walk -- --seed {} --leg {} --leg-cycles {}",
            leg.seed, leg.number, leg.cycles
        )
    }
}

impl Leg {
    /// Leg `number` of a walk, which takes the combinations in turn.
    pub fn new(seed: u64, number: u64, cycles: u64) -> Leg {
        let all = Combination::all();
        let combination = all[(number % all.len() as u64) as usize];
        Leg { seed, number, combination, cycles, events: Events::ALL, planted: Planted::Nothing }
    }

    /// Walks the leg.
    ///
    /// # Errors
    /// The first broken rule.
    pub fn walk(&self) -> Result<Walked, Box<Failure>> {
        let walked = match self.combination.axes {
            3 => self.walk_axes::<3>(),
            4 => self.walk_axes::<4>(),
            5 => self.walk_axes::<5>(),
            _ => self.walk_axes::<6>(),
        };
        walked.map_err(|(cycle, broken)| Box::new(Failure { leg: *self, cycle, broken }))
    }

    /// Walks the leg, and some legs a second time: the same sequence must give the same bits.
    ///
    /// # Errors
    /// The first broken rule.
    pub fn walk_twice_now_and_then(&self) -> Result<Walked, Box<Failure>> {
        let mut walked = self.walk()?;
        if self.number % 47 == 5 {
            let again = self.walk()?;
            let found = || format!("{:x}, not {:x}", again.digest, walked.digest);
            let repeats = walked.tally.that(Rule::Repeats, again == walked, found);
            repeats.map_err(|broken| Box::new(Failure { leg: *self, cycle: walked.cycles, broken }))?;
        }
        Ok(walked)
    }

    /// Reduces a failure to the kinds of events that it needs.
    pub fn shrink(failure: &Failure) -> Failure {
        let mut least = failure.clone();
        for event in Event::ALL {
            let leg = Leg { events: least.leg.events.without(*event), ..least.leg };
            if let Err(found) = leg.walk()
                && found.broken.rule == failure.broken.rule
            {
                least = *found;
            }
        }
        least
    }

    fn walk_axes<const N: usize>(&self) -> Result<Walked, (u64, Broken)> {
        match self.combination.numbers {
            Numbers::Double => self.draw::<f64, f64, N>(),
            Numbers::Mixed => self.draw::<f32, f64, N>(),
            Numbers::DoubleOnIntegers => self.draw::<f64, Nanometres, N>(),
            Numbers::SingleOnIntegers => self.draw::<f32, Nanometres, N>(),
        }
    }

    fn draw<R: Scalar, P: Place, const N: usize>(&self) -> Result<Walked, (u64, Broken)> {
        let mut dice = Dice::new(self.seed, self.number);
        let period = machines::period(&mut dice);
        let [first, second, third] = self.machines::<R, P, N>(&mut dice, period);
        let plain = without_servo(&first);
        let drawn = [&first, &first, &second, &third, &plain];
        let mut memories = drawn.map(|drawn| vec![R::ZERO; requirement(drawn)]);
        let ids = [(7, 11), (7, 12), (7, 13), (7, 14), (7, 15)];
        let mut loops = Vec::new();
        let grids = drawn.map(Drawn::grids);
        for (((drawn, memory), grids), ids) in drawn.into_iter().zip(&mut memories).zip(&grids).zip(ids) {
            loops.push(build::<R, P, N>(drawn, grids, ids, period, memory).expect("built before"));
        }
        let facts: Vec<_> =
            drawn.into_iter().zip(ids).map(|(drawn, (id, crc))| Facts::of(drawn, id, crc, period)).collect();
        let turn = self.number / Combination::all().len() as u64;
        let (gauge, infeed_limit_um) = AnyGauge::draw(&mut dice, period, (self.number / 2 + turn) % 2 == 1);
        let gauge = Some(gauge).filter(|_| self.combination.gauge);
        let kinematics = Kinematics::new(&first.settings).ok();
        let mut ground = Ground {
            loops: &loops,
            facts: &facts,
            spans: &[],
            turns: &[],
            closed: false,
            kinematics,
            gauge,
            infeed_limit_um,
        };
        let by_tool = self.combination.measured == Measured::ToolPath;
        let home = home::place(&ground, by_tool);
        let mut center = [home[0], home[1], home[2]];
        if let Some(kinematics) = ground.kinematics.filter(|_| by_tool) {
            let joints = [home[0], home[1], home[2], 0.0, 0.0, 0.0].map(R::of);
            center = kinematics.forward(&joints).tip.into().map(R::to_f64);
        }
        let room = facts.iter().flat_map(|facts| &facts.axes[..3]).map(|axis| axis.travel.map(P::to_f64));
        let size = room.map(|[low, high]| 0.15 * (high - low)).fold(20.0, f64::min);
        let course = Course::draw(&mut dice, center, size, by_tool);
        (ground.spans, ground.turns, ground.closed) = (&course.spans, &course.turns, course.closed);
        let shift = [0, 1, 2].map(|k| home[k] - center[k]);
        let host = Host::new(dice, home, shift, self.combination.measured, self.events);
        self.run(&ground, host, home)
    }

    /// A machine and two that are exchanged for it.
    fn machines<R: Scalar, P: Place, const N: usize>(&self, dice: &mut Dice, period: u32) -> [Drawn; 3] {
        let mut draw = |like: Option<&MachineSettings>| {
            let mut refused = None;
            for plain in 0..200 {
                let drawn = machines::draw(dice, &self.combination, period, plain, like);
                let mut memory = vec![R::ZERO; requirement(&drawn)];
                let built = build::<R, P, N>(&drawn, &drawn.grids(), (0, 0), period, &mut memory).map(|_| ());
                match built {
                    Ok(()) => return drawn,
                    Err(error) => refused = Some(error),
                }
            }
            panic!("no machine that is not refused: {}, {:?}", self.combination, refused);
        };
        let first = draw(None);
        let second = draw(Some(&first.settings));
        let third = draw(Some(&first.settings));
        [first, second, third]
    }

    fn run<R: Scalar, P: Place, const N: usize>(
        &self,
        ground: &Ground<'_, R, P, N>,
        mut host: Host<R, P, N>,
        home: [f64; N],
    ) -> Result<Walked, (u64, Broken)> {
        let mut walker = Walker::new(ground, self.planted);
        let mut result = Ok(());
        let heap = allocation_counter::measure(|| {
            result = self.there_and_back(ground, &mut walker, &mut host, home);
        });
        let cycles = walker.cycles;
        let found = || format!("{} allocations, {} bytes", heap.count_total, heap.bytes_total);
        result
            .and_then(|()| walker.contract.tally.that(Rule::Allocation, heap.count_total == 0, found))
            .and_then(|()| without_cycles::check(self.number, ground, &mut walker.contract.tally))
            .map_err(|broken| (cycles, broken))?;
        let tally = walker.contract.tally;
        let combination = Combination::all().iter().position(|known| *known == self.combination).unwrap_or(0);
        Ok(Walked { tally, events: host.seen, cycles, digest: walker.digest.0, combination })
    }

    fn there_and_back<R: Scalar, P: Place, const N: usize>(
        &self,
        ground: &Ground<'_, R, P, N>,
        walker: &mut Walker<'_, '_, R, P, N>,
        host: &mut Host<R, P, N>,
        home: [f64; N],
    ) -> Result<(), Broken> {
        let measured = self.combination.measured;
        let start = walker.home(home, measured)?;
        for number in 0..self.cycles {
            if number % 4000 == 300 && !walker.has_shadow() {
                walker.cast((self.number + number / 4000) & 1 == 0);
            }
            let mut moment = host.next(ground, &ground.facts[walker.active], &walker.outcome);
            walker.cycle(&mut moment, Some(host))?;
        }
        let end = walker.home(home, measured)?;
        let found = || format!("{end:x}, not {start:x}");
        walker.contract.tally.that(Rule::Returns, start == end, found)
    }
}

/// The last configuration: the machine without dynamic correction and with wide limits, so that the way home is short.
fn without_servo(drawn: &Drawn) -> Drawn {
    let mut plain = drawn.clone();
    for axis in &mut plain.settings.axes {
        axis.servo = Default::default();
        axis.limits = Limits { slope_per_s: 200.0, acceleration_per_s2: 1e5, ..axis.limits };
    }
    plain.settings.contour.feedback = None;
    plain.settings.crosstalk.clear();
    plain
}

fn requirement(drawn: &Drawn) -> usize {
    trueaxis::compensation::requirement(&drawn.settings, |axis| drawn.rows(axis))
}

fn build<'a, R: Scalar, P: Place, const N: usize>(
    drawn: &Drawn,
    grids: &[GridData<'a>],
    (machine_id, tables_crc): (u32, u32),
    period_ns: u32,
    memory: &'a mut [R],
) -> Result<ServoLoop<'a, R, P, N>, ConfigError> {
    let machine = &drawn.settings;
    let inverse_passes = check::machine(machine, |axis| drawn.rows(axis), grids)?;
    let config = Config { machine, grids, machine_id, tables_crc, period_ns, inverse_passes, method: Method::Guarded };
    config.build(|axis| drawn.rows(axis), memory)
}
