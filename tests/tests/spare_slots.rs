//! A step with spare slots sends and records what a step with as many slots as the machine has axes does, to the bit.
//! (On three axes the volumetric model has forms of its own, which round otherwise.)

use std::path::Path as File;
use trueaxis::compensation::{Compensation, Direction, PoseError, Query, ThermalLine, requirement};
use trueaxis::contour::{CommandWindow, Path, Reference, Segment, ToolPath, Turn, convert};
use trueaxis::error::Field;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::{AXES, AxisOrder, ErrorModel};
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::{FRAME_BYTES, Frame};
use trueaxis::{Axis, Config, Dynamics, Input, Measure, OnToolPath, ServoLoop, State};
use trueaxis_tables::{Machine, compile};
use trueaxis_testing::noise::Noise;

const PERIOD_NS: u32 = 250_000;
const CYCLES: usize = 6_000;
/// Way of X along the path, mm.
const WAY_MM: f64 = 60.0;

/// One cycle of a host: mostly sound, now and then with a fault, a pause or a part switched off.
struct Cycle {
    input: Input<f64, AXES>,
    /// Share of the way.
    u: f64,
}

fn cycles(random: &mut Noise, axes: usize) -> Vec<Cycle> {
    let mut known = [0.0; AXES];
    (0..CYCLES)
        .map(|i| {
            let turn = std::f64::consts::TAU * i as f64 / 1500.0;
            // There and back, so that every axis reverses.
            let u = 0.5 - 0.5 * turn.cos();
            let mut input = Input::at_rest(PERIOD_NS);
            (input.homed, input.enable) = (true, !(2000..2100).contains(&i));
            for (slot, command) in input.command.iter_mut().enumerate().take(axes) {
                *command = match slot {
                    0 => WAY_MM * u,
                    1 | 2 => -50.0 + 2.0 * (turn * (slot as f64 + 0.5)).sin(),
                    _ => 2.0 * (turn * 0.7).sin(),
                };
            }
            input.feedback = known;
            known = input.command;
            known.iter_mut().take(axes).for_each(|reading| *reading += 2e-3 * random.signed());
            input.learned = random.vector(2e-3);
            match i % 977 {
                400 => input.feedback[random.below(axes)] = f64::NAN,
                500 => input.encoder_alarm = 1 << random.below(axes),
                600 => input.command[random.below(axes)] += 500.0,
                700 => input.elapsed_ns *= 3,
                800..900 => input.dynamics = Dynamics::ALL.without(Dynamics::LAG),
                900..950 => input.reset = i % 977 == 900,
                _ => {}
            }
            Cycle { input, u }
        })
        .collect()
}

fn first<const N: usize>(input: &Input<f64, AXES>) -> Input<f64, N> {
    let Input { encoder_alarm, elapsed_ns, homed, enable, reset, refusal, dynamics, learned, .. } = *input;
    let [command, feedback] = [input.command, input.feedback].map(|slots| std::array::from_fn(|k| slots[k]));
    Input { command, feedback, encoder_alarm, elapsed_ns, homed, enable, reset, refusal, dynamics, learned }
}

/// Positions sent and the frame of the record, each without its spare slots.
type Sent = (Vec<u64>, Vec<u8>);

fn step<const N: usize>(
    servo: &ServoLoop<'_, f64, f64, N>,
    state: &mut State<f64, f64, N>,
    input: &Input<f64, AXES>,
    axes: usize,
    measure: &mut dyn Measure<f64, f64, N>,
) -> Sent {
    let output = servo.step(state, &first(input), measure, ());
    assert!(output.drive[axes..].iter().all(|spare| *spare == 0.0) && output.record.limited >> axes == 0);
    let mut frame = Frame::of(&output.record);
    frame.axes.truncate(axes);
    let mut buffer = [0; FRAME_BYTES];
    let frame = frame.encode(&mut buffer).expect("a frame").to_vec();
    (output.drive[..axes].iter().map(|drive| drive.to_bits()).collect(), frame)
}

/// All cycles on a step with `N` slots: with a window of the commands, then with a tool path on a machine with rotary axes.
fn run<const N: usize>(machine: &Machine, cycles: &[Cycle]) -> Vec<Sent> {
    let bytes = compile(machine).expect("a sound machine");
    let file = Tcomp::parse(&bytes).expect("what was compiled");
    let mut memory = vec![0.0; file.requirement()];
    let config = Config::of(&file, PERIOD_NS);
    let axes = machine.settings.step_axes().count();
    assert_eq!(ServoLoop::<f64, f64, N>::load(&file, PERIOD_NS, &mut memory.clone()).is_ok(), axes == N);
    let servo: ServoLoop<'_, f64, f64, N> =
        config.build_with_spare_slots(file.rows(), &mut memory).expect("enough slots");
    let mut window = CommandWindow::<f64, f64, 32>::new([0.0, 0.0, 1.0], 0.02).expect("a spacing");
    let mut state = servo.start();
    let of_window = |cycle: &Cycle| step(&servo, &mut state, &cycle.input, axes, &mut &mut window);
    let mut sent: Vec<Sent> = cycles.iter().map(of_window).collect();
    if axes == 5 {
        let kinematics = Kinematics::new(&machine.settings).expect("five axes");
        let tip = |x: f64| kinematics.forward(&[x, -50.0, -50.0, 0.0, 0.0, 0.0]).tip;
        let (mut spans, mut turns) = (Vec::new(), Vec::new());
        convert(&Segment::Line { start: tip(0.0), end: tip(WAY_MM) }, 0, [0.0, 0.0, 1.0], |span| {
            turns.push(Turn::axes(&span, [0.0, 1.0], [0.0; 3], [1.0, 0.0, 1.0]));
            spans.push(span);
            Ok(())
        })
        .expect("a line");
        let path = ToolPath::new(Path::new(&spans, 0, false), &turns);
        let mut state = servo.start();
        sent.extend(cycles.iter().map(|cycle| {
            let place = cycle.u * spans.len() as f64;
            let span = (place as usize).min(spans.len() - 1);
            let mut on = OnToolPath::new(&path, Reference { span: span as u32, t: place - span as f64 }, &kinematics);
            step(&servo, &mut state, &cycle.input, axes, &mut &mut on)
        }));
    }
    sent
}

fn compare<const N: usize>(random: &mut Noise, machine: &Machine) {
    let name = &machine.settings.name;
    let cycles = cycles(random, N);
    let (own, wide) = (run::<N>(machine, &cycles), run::<AXES>(machine, &cycles));
    for (i, (own, wide)) in own.iter().zip(&wide).enumerate() {
        assert_eq!(own, wide, "{name}: cycle {i}");
    }
    let corrected = own.iter().zip(&cycles).filter(|(sent, cycle)| sent.0[0] != cycle.input.command[0].to_bits());
    assert!(corrected.count() > CYCLES / 2, "{name}: cycles with a correction");
}

/// Error and correction at random poses, on `N` slots of which the machine has `axes`.
fn looked_up<const N: usize>(machine: &Machine, seed: u64, axes: usize) -> Vec<[u64; 2 * AXES]> {
    let rows = |axis| machine.rows(axis);
    let mut memory = vec![0.0; requirement(&machine.settings, rows)];
    let compensation: Compensation<'_, f64, f64, N> =
        Compensation::build(&machine.settings, rows, &machine.grids(), 3, &mut memory).expect("sound tables");
    let mut random = Noise::new(seed);
    let of_pose = |_| {
        let (mut command, mut directions) = ([0.0; N], [Direction::POSITIVE; N]);
        for (command, direction) in command.iter_mut().zip(&mut directions).take(axes) {
            (*command, *direction) = (150.0 * random.signed(), Direction::of(random.unit() < 0.5));
        }
        let at = compensation.coordinates(&command);
        let thermal = [ThermalLine::default(); N];
        let query = Query::at(&at, &directions, &thermal);
        let PoseError { tip, orientation, .. } = compensation.pose_error(&query, &mut 0);
        let mut found = [0; 2 * AXES];
        let values = tip.to_array().into_iter().chain(orientation.to_array());
        let correction = compensation.correction(&query, &mut 0).into_iter().take(axes);
        found.iter_mut().zip(values.chain(correction)).for_each(|(found, value)| *found = value.to_bits());
        found
    };
    (0..500).map(of_pose).collect()
}

/// The five-axis sample without its A axis.
fn four_axes(model: ErrorModel) -> Machine {
    let mut machine = sample("mill-5axis", model);
    let place = machine.settings.axes.iter().position(|own| own.axis == Axis::A).expect("an A axis");
    machine.settings.axes.remove(place);
    machine.tables.remove(place);
    machine.settings.chain = machine.settings.chain.replace(" A'", "").as_str().try_into().expect("a shorter chain");
    machine
}

fn sample(name: &str, model: ErrorModel) -> Machine {
    let folder = File::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables").join(name);
    let mut machine = Machine::read(&folder).expect(name);
    machine.settings.compensation.model = model;
    // Angular errors of every slide, also where the sample has none.
    let Machine { settings, tables, .. } = &mut machine;
    let slides = settings.axes.iter().zip(tables).filter(|(own, _)| !own.axis.is_rotary());
    for (row, i) in slides.filter_map(|(_, table)| table.as_mut()).flat_map(|table| &mut table.rows).zip(0..) {
        row.forward[3..].iter_mut().zip(1..).for_each(|(error, k)| *error += 1e-6 * f64::from((i * k) % 7));
        row.reverse[3..].iter_mut().zip(1..).for_each(|(error, k)| *error += 1e-6 * f64::from((i * k) % 7));
    }
    machine
}

#[test]
fn spare_slots_follow_those_of_the_machine() {
    let machine = four_axes(ErrorModel::Nine);
    let order = AxisOrder::<AXES>::with_spare_slots(&machine.settings).expect("enough slots");
    assert_eq!(order.axes(), [Axis::X, Axis::Y, Axis::Z, Axis::C, Axis::A, Axis::B]);
    assert_eq!(AxisOrder::<4>::with_spare_slots(&machine.settings), AxisOrder::of(&machine.settings));
    let refused = AxisOrder::<3>::with_spare_slots(&machine.settings).expect_err("too few slots");
    assert_eq!((refused.field, refused.found), (Field::Axes, 3.0));
}

#[test]
fn the_look_up_is_the_same() {
    for model in [ErrorModel::Nine, ErrorModel::Volumetric] {
        let machine = four_axes(model);
        assert_eq!(looked_up::<4>(&machine, 1, 4), looked_up::<AXES>(&machine, 1, 4), "{model:?}");
        for name in ["mill-5axis", "head-5axis", "mill-turn"] {
            let machine = sample(name, model);
            assert_eq!(looked_up::<5>(&machine, 2, 5), looked_up::<AXES>(&machine, 2, 5), "{name} {model:?}");
        }
    }
}

#[test]
fn the_step_is_the_same() {
    let mut random = Noise::new(5);
    for model in [ErrorModel::Nine, ErrorModel::Volumetric] {
        for name in ["mill-5axis", "head-5axis", "mill-turn"] {
            compare::<5>(&mut random, &sample(name, model));
        }
        compare::<4>(&mut random, &four_axes(model));
    }
}
