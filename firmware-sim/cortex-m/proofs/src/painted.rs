//! Stack depth of each function in a run: the stack below it is painted before every call and checked afterwards.

use crate::symbols::{
    P, POINTS, R, WINDOW, proved_bypass, proved_step, proved_step_following, proved_step_rtcp, proved_step_with_gauge,
    proved_step_with_tool, proved_take_into,
};
use core::hint::black_box;
use cortex_m::register::msp;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use trueaxis::contour::{CommandWindow, Method, Path, Reference, Segment, Span, ToolPath, Turn, convert};
use trueaxis::exchange::Exchange;
use trueaxis::glam::DVec3;
use trueaxis::kinematics::{BranchTracker, Kinematics};
use trueaxis::machine::{
    AxisSettings, CrosstalkSettings, DriveFigures, DynamicSettings, ErrorModel, FeedbackSettings, FrictionSettings,
    MachineSettings,
};
use trueaxis::roundness::{Gauge, GaugeSettings, GaugeState, ProbeAngles, Probes};
use trueaxis::{Axis, Bypass, Config, Dynamics, Fault, Input, Position, Real, Row, ServoLoop};

#[path = "../../src/settings.rs"]
mod shared;

const PERIOD_NS: u32 = 100_000;
const CYCLES: u32 = 3000;
/// Painted bytes: more than any function needs.
const PAINTED: usize = 16_384;
const PAINT: u32 = 0xdead_beef;

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    hprintln!("PANIC {}", info);
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

/// Calls the function, and records its largest stack depth below this frame.
#[inline(always)]
fn deepest(worst: &mut usize, call: impl FnOnce()) {
    let top = msp::read() as usize;
    let bottom = top - PAINTED;
    // SAFETY: the memory below the stack pointer is RAM that nothing uses; no interrupt is on.
    unsafe {
        for place in (bottom..top).step_by(4) {
            (place as *mut u32).write_volatile(PAINT);
        }
        call();
        let touched = (bottom..top).step_by(4).find(|place| (*place as *const u32).read_volatile() != PAINT);
        *worst = (*worst).max(top - touched.unwrap_or(top));
    }
}

fn scalar(x: f64) -> R {
    <R as Real>::of(x)
}

fn settings(axes: &[Axis], model: ErrorModel) -> MachineSettings {
    let axis = |axis: &Axis| AxisSettings {
        travel: [-1000.0, 1000.0],
        joint: [-1001.0, 1001.0],
        backlash: 0.002,
        hysteresis: 0.003,
        ..AxisSettings::with_defaults(*axis, axis.is_rotary())
    };
    let mut machine = shared::machine([0.0, 0.0, -150.0], model, axes.iter().map(axis));
    let servo = |axis: &mut AxisSettings| {
        let drive = DriveFigures {
            velocity_feed_forward: 0.9,
            lowest_resonance_hz: 5000.0,
            ..DriveFigures::with_defaults(110.0, 800.0, 0.006)
        };
        axis.servo.drive = Some(drive);
        axis.servo.friction = Some(FrictionSettings::with_defaults(0.5, 0.006));
        let dynamic = DynamicSettings::with_defaults(axis.axis);
        axis.servo.dynamic = Some(DynamicSettings { lag: true, acceleration: true, take_up: true, ..dynamic });
    };
    machine.axes.iter_mut().for_each(servo);
    machine.contour.feedback = Some(FeedbackSettings::default());
    let points = [[-300.0, 1e-6], [300.0, 2e-6]].into_iter().collect();
    let crosstalk = CrosstalkSettings { tip: Axis::X, from: Axis::Y, over: Axis::Z, points };
    machine.crosstalk.push(crosstalk).expect("room for it");
    machine.compensation.orientation = axes.len() == 5 && model == ErrorModel::Volumetric;
    machine
}

/// Tables with an uneven grid, so that its search runs too.
fn rows() -> [Row; 6] {
    [-1000.0, -400.0, -90.0, 10.0, 380.0, 1000.0].map(|position| {
        let e = 0.004 + 4e-6 * position;
        let forward = [e, -e, 0.5 * e, 0.01 * e, 0.02 * e, -0.01 * e];
        let [x, rest @ ..] = forward;
        let [y, z, a, b, c] = rest;
        Row { position, forward, reverse: [x + 0.001, y, z, a, b, c] }
    })
}

/// A corner between two lines and an arc: a closed path, followed endlessly.
fn pieces() -> heapless::Vec<Span<R, P>, 64> {
    let normal = [0.0, 0.0, 1.0];
    let segments = [
        Segment::Line { start: DVec3::new(0.0, 0.0, 0.0), end: DVec3::new(30.0, 0.0, 0.0) },
        Segment::Line { start: DVec3::new(30.0, 0.0, 0.0), end: DVec3::new(30.0, 10.0, 0.0) },
        Segment::Arc {
            start: DVec3::new(30.0, 10.0, 0.0),
            end: DVec3::new(0.0, 10.0, 0.0),
            center: DVec3::new(15.0, 10.0, 0.0),
            normal: normal.into(),
            turns: 0,
        },
        Segment::Line { start: DVec3::new(0.0, 10.0, 0.0), end: DVec3::new(0.0, 0.0, 0.0) },
    ];
    let mut all = heapless::Vec::new();
    for (number, segment) in segments.iter().enumerate() {
        convert(segment, number as u32, normal, |span| {
            all.push(span).ok().expect("enough room for the path");
            Ok(())
        })
        .expect("a path");
    }
    all
}

/// One cycle of a run: readings that stray, an alarm, a jump of the command and the reset that follows it.
fn input<const N: usize>(cycle: u32, command: [P; N]) -> Input<P, N> {
    let mut input = Input { command, feedback: command, homed: true, enable: true, ..Input::at_rest(PERIOD_NS) };
    for (k, feedback) in input.feedback.iter_mut().enumerate() {
        *feedback = feedback.plus(scalar(1e-3 * f64::from((cycle * 7 + k as u32 * 3) % 11)));
    }
    input.encoder_alarm = u8::from(cycle % 500 == 499);
    if cycle % 900 == 899 {
        input.command[0] = input.command[0].plus(scalar(500.0));
    }
    // The parts of the dynamic correction come and go.
    input.dynamics = Dynamics::ALL.without(Dynamics(if cycle % 200 < 50 { (cycle / 200) as u8 } else { 0 }));
    input.learned = [P::default().plus(scalar(1e-6 * f64::from(cycle % 100))); 3];
    input.reset = cycle % 900 > 10 && cycle % 900 < 100;
    input
}

/// Position of the interpolator, and its command.
fn place(spans: &[Span<R, P>], cycle: u32) -> (Reference<R>, [P; 3]) {
    let (piece, part) = ((cycle / 40) as usize % spans.len(), cycle % 40);
    let t = scalar(f64::from(part) / 40.0);
    (Reference { span: piece as u32, t }, spans[piece].position(t))
}

fn print(symbol: &str, bytes: usize) {
    hprintln!("{} {}", symbol, bytes);
}

fn three_axes(worst: &mut [usize; 5], model: ErrorModel) {
    let machine = settings(&[Axis::X, Axis::Y, Axis::Z], model);
    let config = Config {
        machine: &machine,
        grids: &[],
        machine_id: 1,
        tables_crc: 2,
        period_ns: PERIOD_NS,
        inverse_passes: 3,
        method: Method::Guarded,
    };
    let rows = rows();
    let mut memory = [<R as Real>::ZERO; 1024];
    let servo: ServoLoop<'_, R, P, 3> = config.build(|_| Some(&rows[..]), &mut memory).expect("a configuration");
    // SAFETY: a static lifetime for the exchange; nothing of it outlives this function.
    let servo: &'static ServoLoop<'static, R, P, 3> = unsafe { core::mem::transmute(&servo) };
    let spans = pieces();
    let path = Path::new(&spans, 0, true);

    let mut state = servo.start();
    for cycle in 0..CYCLES {
        let (reference, command) = place(&spans, cycle);
        let input = input(cycle, command);
        deepest(&mut worst[0], || {
            black_box(proved_step(servo, &mut state, &input, &path, reference));
        });
    }

    let mut gauge_settings =
        GaugeSettings::with_defaults(POINTS as u16, ProbeAngles::Slots { p: 188, q: 667 }, 1 << 16);
    gauge_settings.revolutions = 1;
    let gauge = Gauge::<R, POINTS>::build(&gauge_settings, PERIOD_NS).expect("a gauge");
    let mut gauge_state = GaugeState::new();
    let mut state = servo.start();
    for cycle in 0..10 * CYCLES {
        let (reference, command) = place(&spans, cycle);
        let input = input(cycle, command);
        let readings = [cycle % 13, cycle % 17, cycle % 19].map(|x| scalar(f64::from(x)));
        let index = (cycle % 8192 == 0).then_some((cycle * 8) as i32);
        let probes = Probes { readings, spindle: (cycle * 8) as i32, index, ..Probes::default() };
        deepest(&mut worst[1], || {
            let gauge = (&gauge, &mut gauge_state, &probes);
            black_box(proved_step_with_gauge(servo, &mut state, &input, &path, reference, gauge));
        });
    }

    let mut commanded = CommandWindow::<R, P, WINDOW>::new([0.0, 0.0, 1.0], 0.005).expect("a window");
    let mut state = servo.start();
    for cycle in 0..CYCLES {
        let (_, command) = place(&spans, cycle);
        let input = input(cycle, command);
        deepest(&mut worst[2], || {
            black_box(proved_step_following(servo, &mut state, &input, &mut commanded));
        });
    }

    let mut bypass = Bypass::<P, 3>::new(Fault::TablesRefused);
    for cycle in 0..10 {
        let input = input(cycle, [P::default(); 3]);
        deepest(&mut worst[3], || {
            black_box(proved_bypass(&mut bypass, &input));
        });
    }

    let exchange = Exchange::new();
    let mut active = servo;
    for cycle in 0..10 {
        if cycle % 2 == 0 {
            exchange.offer(servo).expect("the place is free");
        }
        deepest(&mut worst[4], || {
            black_box(proved_take_into(&exchange, &mut active));
        });
    }
}

fn five_axes(worst: &mut [usize; 2], model: ErrorModel) {
    let machine = settings(&[Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::C], model);
    let config = Config {
        machine: &machine,
        grids: &[],
        machine_id: 1,
        tables_crc: 2,
        period_ns: PERIOD_NS,
        inverse_passes: 3,
        method: Method::Guarded,
    };
    let rows = rows();
    let mut memory = [<R as Real>::ZERO; 2048];
    let servo: ServoLoop<'_, R, P, 5> = config.build(|_| Some(&rows[..]), &mut memory).expect("a configuration");
    // SAFETY: the table's functions need a static loop; nothing of it outlives this function.
    let servo: &'static ServoLoop<'static, R, P, 5> = unsafe { core::mem::transmute(&servo) };
    let kinematics = Kinematics::<R>::new(&machine).expect("a chain");
    let spans = pieces();
    let turns: heapless::Vec<Turn<R>, 64> =
        spans.iter().map(|span| Turn::axes(span, [0.0, 1.0], [10.0, 0.0, -20.0], [40.0, 0.0, 25.0])).collect();
    let path = ToolPath::new(Path::new(&spans, 0, true), &turns);
    // Axes in the order of the kinematics.
    let joints = |cycle: u32| {
        let along = f64::from(cycle) / f64::from(CYCLES);
        [10.0 * along, 5.0 * along, 150.0, 10.0 + 5.0 * along, 0.0, -20.0 + 9.0 * along].map(scalar)
    };

    let mut state = servo.start();
    for cycle in 0..CYCLES {
        let [x, y, z, a, _, c] = joints(cycle);
        let input = input(cycle, [x, y, z, a, c].map(|joint| P::default().plus(joint)));
        let (reference, _) = place(&spans, cycle);
        deepest(&mut worst[0], || {
            black_box(proved_step_with_tool(servo, &mut state, &input, &path, reference, &kinematics));
        });
    }

    let mut state = servo.start();
    let near = joints(0);
    let pose = kinematics.inverse(&kinematics.forward(&near), &near).expect("a pose");
    let mut follow = BranchTracker::new(&pose, scalar(0.1));
    for cycle in 0..CYCLES {
        let [x, y, z, a, b, c] = joints(cycle);
        let input = input(cycle, [x, y, z, a, c].map(|joint| P::default().plus(joint)));
        let (reference, _) = place(&spans, cycle);
        // Now and then a tip out of reach.
        let far = if cycle % 700 == 699 { scalar(5000.0) } else { x };
        let tool = kinematics.forward(&[far, y, z, a, b, c]);
        deepest(&mut worst[1], || {
            let commanded = (&tool, &mut follow);
            black_box(proved_step_rtcp(servo, &mut state, &input, commanded, &path, reference, &kinematics));
        });
    }
}

#[entry]
fn main() -> ! {
    // Prevents the compiler from specialising functions for these calls.
    crate::proved();
    let (mut three, mut five) = ([0; 5], [0; 2]);
    for model in [ErrorModel::Nine, ErrorModel::Volumetric] {
        three_axes(&mut three, model);
        five_axes(&mut five, model);
    }
    let [step, gauge, following, bypass, take_into] = three;
    print("proved_step", step);
    print("proved_step_with_gauge", gauge);
    print("proved_step_with_tool", five[0]);
    print("proved_step_rtcp", five[1]);
    print("proved_step_following", following);
    print("proved_bypass", bypass);
    print("proved_take_into", take_into);
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}
