//! The stage as documented, in whole nanometres and without shortcuts: both implementations decide random cycles.

use super::*;
use crate::machine::{AxisOrder, FaultSettings, MachineSettings};
use std::collections::BTreeMap;
use std::string::String;

/// 8 kHz; jumps of 0.1 mm (0.3°), readings 0.02 mm (0.05°) more.
const PERIOD_NS: u32 = 125_000;
const AXES: usize = 4;
/// X, Y, Z in nm, C in 1e-6 deg.
const TRAVEL: [i64; 2] = [-10_000_000, 90_000_000];
const JUMP: [i64; AXES] = [100_000, 100_000, 100_000, 300_000];
const READING_MORE: [i64; AXES] = [20_000, 20_000, 20_000, 50_000];
const STUCK: [i64; AXES] = [200_000, 200_000, 200_000, 700_000];
/// Readings in this range are trusted: the joint, which is the travel, extended by 1 mm (1°).
const READABLE: [i64; 2] = [TRAVEL[0] - 1_000_000, TRAVEL[1] + 1_000_000];
/// Resolution of the encoder, not stated on X; on Z three steps are more than a quarter of the stuck distance.
const ENCODER: [i64; AXES] = [0, 2_000, 20_000, 5_000];
const BACKLASH: i64 = 10_000;
/// A reading that changes by no more counts as unchanged.
const STILL: [i64; AXES] = [0, 6_000, 50_000, 15_000];
/// On C larger than a jump.
const RESUME: [i64; AXES] = [50_000, 50_000, 50_000, 400_000];

fn machine() -> MachineSettings {
    let mm = |[linear, rotary]: [i64; 2]| [linear as f64 * 1e-6, rotary as f64 * 1e-6];
    let machine = Machine::new("w C' b X Y Z t").each(|axis| {
        let place = if axis.axis.is_rotary() { 3 } else { 0 };
        axis.travel = TRAVEL.map(|x| x as f64 * 1e-6);
        axis.joint = axis.travel;
        let slot = if axis.axis.is_rotary() { 3 } else { axis.axis.index() };
        axis.encoder_resolution = (slot > 0).then_some(ENCODER[slot] as f64 * 1e-6);
        axis.backlash = BACKLASH as f64 * 1e-6;
        axis.max_feed_per_s = JUMP[place] as f64 * 1e-6 / 2.0 / (f64::from(PERIOD_NS) * 1e-9);
    });
    let faults = FaultSettings {
        resume: mm([RESUME[0], RESUME[3]]),
        command_jump_factor: 2.0,
        feedback_jump: mm([READING_MORE[0], READING_MORE[3]]),
        stuck: mm([STUCK[0], STUCK[3]]),
    };
    machine.with(|machine| machine.faults = faults).settings()
}

/// Result of a cycle.
#[derive(Clone, Debug, PartialEq)]
struct Decided {
    verdict: Verdict,
    fault: (Fault, u8),
    due: bool,
    first: bool,
    command: [Nanometres; AXES],
    feedback: [Nanometres; AXES],
}

#[derive(Default)]
struct Model {
    started: bool,
    active: bool,
    reset: bool,
    latched: Option<(Fault, u8)>,
    command: [i64; AXES],
    feedback: [i64; AXES],
    read: [bool; AXES],
    /// Time since corrections last moved, ns.
    time: u64,
    missing: [i64; AXES],
    /// The unchanged reading, the command up to which the distance is counted, and that distance.
    unchanged: [i64; AXES],
    counted: [i64; AXES],
    unmoved: [i64; AXES],
}

fn usable(x: i64) -> bool {
    x > i64::from(i32::MIN) && x < i64::from(i32::MAX)
}

impl Model {
    /// Periods that a cycle took: 1 up to a quarter late, then the actual number, at most 16.
    fn periods(elapsed_ns: u32) -> f64 {
        let periods = f64::from(elapsed_ns) / f64::from(PERIOD_NS);
        if periods <= 1.25 { 1.0 } else { periods.min(16.0) }
    }

    fn command_fault(&self, input: &Input<Nanometres, AXES>) -> Option<(Fault, u8)> {
        if input.refusal.fault != Fault::None {
            return Some((input.refusal.fault, input.refusal.slot));
        }
        let active = input.homed && input.enable;
        (0..AXES).find_map(|k| {
            let command = i64::from(input.command[k].0);
            let farthest = JUMP[k] as f64 * Model::periods(input.elapsed_ns);
            let fault = if !usable(command) {
                Fault::CommandNotFinite
            } else if active && !(TRAVEL[0]..=TRAVEL[1]).contains(&command) {
                Fault::CommandOutOfTravel
            } else if active && self.started && self.active && (command - self.command[k]).abs() as f64 > farthest {
                Fault::CommandJump
            } else {
                return None;
            };
            Some((fault, k as u8))
        })
    }

    /// `toward`: the commands with which readings are compared.
    fn readings(&mut self, input: &Input<Nanometres, AXES>, toward: [i64; AXES], watched: bool) -> Option<(Fault, u8)> {
        let mut worst = None;
        let readable = |x: i64| !(input.homed && input.enable) || (READABLE[0]..=READABLE[1]).contains(&x);
        for k in 0..AXES {
            let reading = i64::from(input.feedback[k].0);
            let farthest = JUMP[k] + READING_MORE[k];
            let fault = if !usable(reading) {
                Some(Fault::FeedbackNotFinite)
            } else if input.encoder_alarm >> k & 1 == 1 {
                Some(Fault::EncoderAlarm)
            } else if !readable(reading)
                || watched && (reading - self.feedback[k]).abs() > farthest * (1 + self.missing[k])
            {
                Some(Fault::FeedbackJump)
            } else if watched && self.is_stuck(k, reading, toward[k]) {
                Some(Fault::EncoderStuck)
            } else {
                None
            };
            match fault {
                None => (self.feedback[k], self.missing[k]) = (reading, 0),
                // No value to fall back on, or none that can be trusted.
                Some(_) if !self.started || !readable(self.feedback[k]) => {
                    (self.feedback[k], self.unchanged[k]) = (toward[k], toward[k]);
                }
                Some(_) => self.missing[k] += 1,
            }
            // A reading that is missing or not monitored cannot show motion.
            if !watched || !matches!(fault, None | Some(Fault::EncoderStuck)) {
                self.counted[k] = toward[k];
            }
            if !watched {
                (self.unchanged[k], self.unmoved[k]) = (self.feedback[k], 0);
            }
            worst = worst.or(fault.map(|fault| (fault, k as u8)));
        }
        worst
    }

    /// A plausible reading stays within three encoder steps while the command moves by more than these and the backlash.
    fn is_stuck(&mut self, k: usize, reading: i64, toward: i64) -> bool {
        if (reading - self.unchanged[k]).abs() > STILL[k] {
            (self.unchanged[k], self.counted[k], self.unmoved[k]) = (reading, toward, 0);
            return false;
        }
        let from = if self.active { self.counted[k] } else { toward };
        let play = if ENCODER[k] == 0 { 0 } else { STILL[k] + BACKLASH };
        self.counted[k] = from;
        if (toward - from).abs() > play {
            self.unmoved[k] += (toward - from).abs();
            self.counted[k] = toward;
        }
        self.unmoved[k] > STUCK[k]
    }

    fn cycle(&mut self, input: &Input<Nanometres, AXES>) -> Decided {
        let command = input.command.map(|p| i64::from(p.0));
        let (first, active) = (!self.started, input.homed && input.enable);
        let periods = f64::from(input.elapsed_ns) / f64::from(PERIOD_NS);
        // 0.999 of a period counts as one; a longer time leaves less than two.
        let pace = u64::from(PERIOD_NS) * 999 / 1000;
        let passed = if first { 2 * pace } else { self.time + u64::from(input.elapsed_ns) };
        self.time = passed.min(2 * pace - 1);
        let due = self.time >= pace;
        self.time -= if due { pace } else { 0 };
        let off = !(0.75..=1.25).contains(&periods) || !due;
        let bad = self.command_fault(input);
        let rising = input.reset && !self.reset && input.refusal.fault == Fault::None;
        self.reset = input.reset;
        let was_latched = self.latched.is_some();
        if !was_latched && bad.is_none() {
            let found = self.readings(input, command, active && !first);
            let fault = found.or((off && active && !first).then_some((Fault::LateCycle, 0)));
            (self.started, self.active, self.command) = (true, active, command);
            let verdict = match (active, fault) {
                (false, _) => Verdict::Inactive,
                (true, None) => Verdict::Active,
                (true, Some(_)) => Verdict::Freeze,
            };
            return self.decided(verdict, fault, (first, due));
        }
        if !was_latched {
            self.latch(bad);
        }
        // Before the first command the output holds the position that was read, once every axis has been read.
        if !self.started && !self.read.iter().all(|read| *read) {
            for k in 0..AXES {
                let reading = i64::from(input.feedback[k].0);
                let readable = !active || (READABLE[0]..=READABLE[1]).contains(&reading);
                if usable(reading) && readable && input.encoder_alarm >> k & 1 == 0 {
                    (self.command[k], self.read[k]) = (reading, true);
                }
            }
        }
        let placed = self.started || self.read.iter().all(|read| *read);
        let near = (0..AXES).all(|k| usable(command[k]) && (command[k] - self.command[k]).abs() <= RESUME[k]);
        let inside = !active || command.iter().all(|x| (TRAVEL[0]..=TRAVEL[1]).contains(x));
        let fits = bad.is_none_or(|(fault, _)| fault == Fault::CommandJump) && inside;
        self.readings(input, self.command, self.active && !first);
        if was_latched && rising && placed && near && fits {
            (self.latched, self.started, self.active, self.unmoved) = (None, true, active, [0; AXES]);
            (self.command, self.counted, self.unchanged) = (command, command, self.feedback);
            return self.decided(if active { Verdict::Active } else { Verdict::Inactive }, None, (first, due));
        }
        self.decided(if placed { Verdict::Hold } else { Verdict::NoOutput }, self.latched, (first, due))
    }

    /// Holds the current command from now on.
    fn latch(&mut self, fault: Option<(Fault, u8)>) {
        (self.latched, self.counted) = (fault, self.command);
    }

    fn decided(&self, verdict: Verdict, fault: Option<(Fault, u8)>, (first, due): (bool, bool)) -> Decided {
        let positions = |x: [i64; AXES]| x.map(|x| Nanometres(x as i32));
        Decided {
            verdict,
            fault: fault.unwrap_or((Fault::None, 0)),
            due,
            first,
            command: positions(self.command),
            feedback: positions(self.feedback),
        }
    }
}

/// Steps to, at and just beyond every limit; occasionally impossible values.
fn next(random: &mut Noise, from: i64, borders: &[i64], wild: f64) -> Nanometres {
    let border = borders[random.below(borders.len())] + [0, 1][random.below(2)];
    let sign = if random.below(2) == 0 { 1 } else { -1 };
    let x = match random.unit() {
        x if x < wild => [i64::from(i32::MIN), i64::from(i32::MAX), TRAVEL[0] - 1, TRAVEL[1] + 1][random.below(4)],
        x if x < 0.02 => from + sign * border,
        x if x < 0.03 => TRAVEL[random.below(2)],
        x if x < 0.3 => from,
        _ => from + sign * 40_000,
    };
    Nanometres(x.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
}

/// How a run of cycles behaves: `wild` is the share of impossible commands and readings, `rare` that of every other
/// unusual event, `stuck` an axis whose reading seldom changes.
struct Stretch {
    wild: f64,
    rare: f64,
    stuck: usize,
}

fn random_cycle(random: &mut Noise, model: &Model, stretch: &Stretch) -> Input<Nanometres, AXES> {
    let Stretch { wild, rare, stuck } = *stretch;
    let command = std::array::from_fn(|k| {
        // A multiple of the limit is rounded down, so its exact value is not tried.
        let [two, sixteen] = [2, 16].map(|periods| periods * JUMP[k]);
        let borders = [JUMP[k], two - 2, two + 1, sixteen - 2, sixteen + 1, RESUME[k]];
        if model.latched.is_some() && random.below(3) > 0 {
            return next(random, model.command[k], &[0, RESUME[k]], 0.0);
        }
        next(random, model.command[k], &borders, wild)
    });
    let feedback = std::array::from_fn(|k| {
        let jump = (JUMP[k] + READING_MORE[k]) * (1 + model.missing[k]);
        let still = STILL[k] as f64;
        if k == stuck && random.below(10) > 0 {
            // Back and forth by up to what counts as unchanged, and one nanometre more.
            let noise = [0.0, 0.0, still * random.signed(), still, -still, still + 1.0][random.below(6)];
            let from = if random.below(2) == 0 { model.unchanged[k] } else { model.feedback[k] };
            return Nanometres((from + noise as i64) as i32);
        }
        if random.unit() < wild {
            let ends = [READABLE[0], READABLE[0] - 1, READABLE[1], READABLE[1] + 1];
            return Nanometres(ends[random.below(4)] as i32);
        }
        let borders = if model.missing[k] == 0 { [jump; 2] } else { [jump - 2, jump + 1] };
        if random.below(2) == 0 { command[k] } else { next(random, model.feedback[k], &borders, wild) }
    });
    let mut rarely = |share: f64| random.unit() < share;
    let switched = [!rarely(rare), !rarely(rare)];
    let (alarm, refused, late) = (rarely(rare), rarely(rare), rarely(rare));
    Input {
        command,
        feedback,
        homed: switched[0],
        enable: switched[1],
        reset: rarely(0.3),
        encoder_alarm: if alarm { random.below(16) as u8 } else { 0 },
        refusal: if refused { Refusal { fault: Fault::ToolUnreachable, slot: 3 } } else { Refusal::NONE },
        ..Input::at_rest(match late {
            // Early and on time to the last nanosecond, just late, as late as counts, and later.
            true => {
                [[0, 93_749, 93_750, 112_000, 156_250], [156_251, 250_000, 16 * PERIOD_NS, 17 * PERIOD_NS, u32::MAX]]
                    [random.below(2)][random.below(5)]
            }
            false => PERIOD_NS,
        })
    }
}

#[test]
fn every_decision_is_the_models() {
    let machine = machine();
    let order = AxisOrder::<AXES>::of(&machine).unwrap();
    let sampler = Sampler::<f64, Nanometres, AXES>::new(&order, &machine, PERIOD_NS);
    let mut random = Noise::new(3);
    let mut seen = BTreeMap::<String, u32>::new();
    for round in 0..1500 {
        let mut model = Model::default();
        let mut state = SampleState::<f64, Nanometres, AXES>::new();
        for cycle in 0..100 {
            let stretch = match (round % 4, cycle) {
                (0, 0..4) => Stretch { wild: 0.3, rare: 0.1, stuck: AXES },
                (0, _) => Stretch { wild: 0.02, rare: 0.05, stuck: AXES },
                (1, _) => Stretch { wild: 0.0005, rare: 0.002, stuck: round / 4 % AXES },
                _ => Stretch { wild: 0.0005, rare: 0.002, stuck: AXES },
            };
            let input = random_cycle(&mut random, &model, &stretch);
            let expected = model.cycle(&input);
            let mut trusted = [[Nanometres(0); AXES]; 2];
            // The drives are sent the commands.
            let sent = state.commanded();
            let calm = sampler.quick_check(&mut state, &input)
                && (sampler.compares_nothing(&mut state) || !sampler.compare(&mut state, &input, &sent));
            let found = match calm {
                true => Sample::calm(&input),
                false => sampler.full_check(&mut state, &input, &sent, &mut trusted),
            };
            let decided = Decided {
                verdict: found.verdict,
                fault: (found.fault, found.axis),
                due: found.due,
                first: found.first,
                command: *found.command,
                feedback: *found.feedback,
            };
            assert_eq!(decided, expected, "round {round}, cycle {cycle}: {input:?}");
            assert_eq!((found.homed, state.is_latched()), (input.homed, model.latched.is_some()));
            *seen.entry(format!("{:?} {:?}", expected.verdict, expected.fault.0)).or_default() += 1;
            if !expected.verdict.holds() {
                state.accept(&expected.command);
                // Occasionally a later stage finds a fault: the command was not accepted.
                if random.below(500) == 0 {
                    state.latch(Fault::JointRange, 2);
                    model.latch(Some((Fault::JointRange, 2)));
                }
            }
            assert_eq!(state.commanded().map(|p| i64::from(p.0)), model.command);
        }
    }
    let faults = ["CommandNotFinite", "CommandOutOfTravel", "CommandJump", "ToolUnreachable", "JointRange"];
    let kinds = faults.iter().flat_map(|fault| [format!("Hold {fault}"), format!("NoOutput {fault}")]);
    let freezes = ["FeedbackNotFinite", "EncoderAlarm", "FeedbackJump", "EncoderStuck", "LateCycle"];
    let kinds = kinds.chain(freezes.map(|fault| format!("Freeze {fault}")));
    let kinds = kinds.filter(|kind| kind != "NoOutput JointRange" && kind != "NoOutput CommandJump");
    for kind in kinds.chain(["Active None", "Inactive None", "Inactive EncoderAlarm"].map(String::from)) {
        assert!(seen.get(&kind).is_some_and(|count| *count > 10), "{kind}: {seen:?}");
    }
}

#[test]
fn a_late_cycle_excuses_as_many_periods_as_it_took() {
    let machine = machine();
    let order = AxisOrder::<AXES>::of(&machine).unwrap();
    let sampler = Sampler::<f64, Nanometres, AXES>::new(&order, &machine, PERIOD_NS);
    let late = [(0, 1.0), (156_250, 1.0), (250_000, 2.0), (1_000_000, 8.0), (2_000_000, 16.0), (u32::MAX, 16.0)];
    for (elapsed_ns, periods) in late {
        assert!((sampler.periods(elapsed_ns) - periods).abs() < 1e-12, "{elapsed_ns}");
        assert!((Model::periods(elapsed_ns) - periods).abs() < 1e-12, "{elapsed_ns}");
    }
    // A quarter of a period late, and one nanosecond more.
    assert!((sampler.periods(156_251) - 1.250_008).abs() < 1e-12);
}

#[test]
fn travel_holds_to_its_ends_and_an_absent_axis_has_all_there_is() {
    let machine = machine();
    let order = AxisOrder::<AXES>::of(&machine).unwrap();
    let sampler = Sampler::<f64, Nanometres, AXES>::new(&order, &machine, PERIOD_NS);
    let [low, high] = TRAVEL.map(|x| x as i32);
    for (x, within) in [(low, true), (low - 1, false), (high, true), (high + 1, false)] {
        for k in 0..AXES {
            let mut positions = [Nanometres(0); AXES];
            positions[k] = Nanometres(x);
            assert_eq!(sampler.within_travel(&positions), within, "{k} {x}");
        }
    }
    // With X, Y and C only, the slot of Z is unused: it may take any value, change at any rate and stay unchanged for any
    // time.
    let two = Machine::new("w C' b X Y t").settings();
    let order = AxisOrder::<4>::of(&two).unwrap();
    let sampler = Sampler::<f64, f64, 4>::new(&order, &two, PERIOD_NS);
    for (far, within) in [(1e9, true), (-1e9, true), (1.000_001e9, false), (-1.000_001e9, false)] {
        assert_eq!(sampler.within_travel(&[0.0, 0.0, far, 0.0]), within, "{far}");
    }
    let mut state = SampleState::<f64, f64, 4>::new();
    for command in [0.0, 1e9, -1e9, 5.0] {
        let input = Input { homed: true, enable: true, ..Input::at_rest(PERIOD_NS) };
        let input = Input { command: [0.0, 0.0, command, 0.0], ..input };
        let mut trusted = [[0.0; 4]; 2];
        let sent = state.commanded();
        let found = sampler.full_check(&mut state, &input, &sent, &mut trusted);
        assert_eq!((found.verdict, found.fault), (Verdict::Active, Fault::None), "{command}");
        state.accept(&input.command);
    }
}

#[test]
fn a_resting_input_asks_for_nothing() {
    let input = Input::<f64, 3>::at_rest(7);
    assert_eq!((input.elapsed_ns, input.command, input.feedback, input.learned), (7, [0.0; 3], [0.0; 3], [0.0; 3]));
    assert!(!(input.homed || input.enable || input.reset) && input.encoder_alarm == 0);
    assert_eq!((input.refusal, input.dynamics), (Refusal::NONE, Dynamics::ALL));
}

#[test]
fn encoder_scales_have_borders() {
    for resolution in [1.0, -1.0, 1e-9] {
        assert!(EncoderScale::<f64>::new(0.0, resolution).is_ok());
    }
    assert!(EncoderScale::<f64>::new(0.0, 1.0 + f64::EPSILON).is_err());
    let error = EncoderScale::<f64>::new(2e9, 1.0).unwrap_err();
    assert_eq!((error.field, error.found), (Field::Encoder, 2e9));
    // Half a nanometre is always rounded upwards.
    let scale = EncoderScale::<Nanometres>::new(0.001, 0.5e-6).unwrap();
    assert_eq!([1, 3, -1, -3].map(|counts| scale.nanometres(counts).0), [1001, 1002, 1000, 999]);
}
