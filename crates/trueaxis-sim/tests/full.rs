//! The full run: machines with dynamic parts have it, it is reproducible, and it is as accurate as documented.

use std::path::Path;
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Kind, Moment, Run, Sample, Tallies};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

const SHORT: &str = "G21 G90 F1500\nG1 X10\nG2 X10 Y-20 J-10\nG1 X0 Y0\nG0 Z5\n";
/// Two turns, R 50 mm at 1500 mm/min.
const CIRCLE: &str = "G21 G90 F1500\nG0 X50 Y-5\nG1 X50 Y0\nG3 X50 Y0 I-50 J0\nG3 X50 Y0 I-50 J0\n";

fn sample(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name)).unwrap()
}

/// The machine with geometric correction only.
fn geometry_alone(mut machine: Machine) -> Machine {
    for axis in &mut machine.settings.axes {
        (axis.servo.friction, axis.servo.dynamic) = (None, None);
    }
    machine.settings.contour.feedback = None;
    machine.settings.crosstalk.clear();
    machine
}

fn short(machine: Machine) -> Scenario {
    let program = Program::parse("short", SHORT, "short.ngc").unwrap();
    Scenario::new(machine, program, Settings { rate_hz: 2000.0, ..Settings::default() }).unwrap()
}

fn tallies(scenario: Scenario, kinds: &[Kind]) -> Vec<Tallies> {
    let mut run = Run::of(scenario, kinds).unwrap();
    while run.advance(u64::MAX, &mut ()) {}
    run.tallies()
}

#[test]
fn a_machine_gets_the_fourth_run_for_any_dynamic_part() {
    let plain = geometry_alone(sample("mill-3axis"));
    assert!(plain.settings.axes.iter().any(|axis| axis.servo.drive.is_some()), "figures of a drive alone do nothing");
    assert_eq!(Kind::of(&plain.settings), Kind::BASIC);
    let whole = sample("mill-3axis").settings;
    assert_eq!(Kind::of(&whole), Kind::ALL);
    let mut one = plain.clone();
    one.settings.contour.feedback = whole.contour.feedback;
    assert_eq!(Kind::of(&one.settings), Kind::ALL);
    for part in 0..2 {
        let mut one = plain.clone();
        let (to, from) = (&mut one.settings.axes[1].servo, whole.axes[1].servo);
        if part == 0 {
            to.friction = from.friction;
        } else {
            to.dynamic = from.dynamic;
        }
        assert_eq!(Kind::of(&one.settings), Kind::ALL, "{part}");
    }
    let count = |machine| {
        let mut run = Run::new(short(machine)).unwrap();
        while run.advance(u64::MAX, &mut ()) {}
        run.tallies().len()
    };
    assert_eq!([count(plain), count(sample("mill-3axis"))], [3, 4]);
}

/// The dynamic parts do not affect the three other runs.
#[test]
fn the_other_runs_stay_as_they_are() {
    let plain = tallies(short(geometry_alone(sample("mill-3axis"))), &Kind::BASIC);
    assert_eq!(tallies(short(sample("mill-3axis")), &Kind::ALL)[..3], plain);
}

#[test]
fn the_full_run_repeats_and_records_its_parts_separately() {
    let run = |stretch: u64| {
        let mut run = Run::of(short(sample("mill-3axis")), &Kind::ALL).unwrap();
        let mut largest = [[0.0_f32; 3]; 2];
        let mut sink = |_: &Moment, machines: &[Option<&Sample>]| {
            let [_, Some(compensated), _, Some(full)] = machines else { panic!("four machines") };
            let parts =
                |s: &Sample| [s.dynamic.sent, s.dynamic.feed_forward, s.dynamic.feedback].map(|part| part[0].abs());
            for (largest, sample) in largest.iter_mut().zip([compensated, full]) {
                let both = largest.iter_mut().zip(parts(sample));
                both.for_each(|(largest, part)| *largest = largest.max(part));
            }
        };
        while run.advance(stretch, &mut sink) {}
        (run.tallies(), largest)
    };
    let (whole, [compensated, full]) = run(u64::MAX);
    assert_eq!(compensated, [0.0; 3]);
    assert!(full.iter().all(|part| *part > 0.05), "{full:?}");
    assert_eq!(run(100), (whole, [compensated, full]));
}

fn full(machine: Machine, program: Program) -> (f64, f64) {
    let scenario = Scenario::new(machine, program, Settings::default()).unwrap();
    let found = tallies(scenario, &[Kind::Full]).remove(0);
    assert!(found.faults.is_empty() && !found.stopped, "{:?}", found.faults);
    (found.error.max_um, found.error.rms_um)
}

/// The sample's drives differ from its file: friction −10 %, gains +5 %, pre-sliding +20 %.
#[test]
fn servo_errors_fall_to_a_third_with_figures_that_are_off() {
    for (name, [most, rms]) in
        [("circle-diamond-square", [0.80, 0.08]), ("butterfly", [1.0, 0.12]), ("pocket-3d", [1.0, 0.16])]
    {
        let found = full(sample("mill-3axis"), Program::builtin(name).unwrap().unwrap());
        assert!(found.0 <= most && found.1 <= rms, "{name}: {found:?} µm");
    }
}

#[test]
fn a_circle_is_true_within_150_nm_where_the_figures_are_right() {
    let mut machine = sample("mill-3axis");
    let plant = Settings::default().plant(0.0).drives;
    for axis in &mut machine.settings.axes {
        let drive = plant[axis.axis.index()];
        if let (Some(figures), Some(friction)) = (&mut axis.servo.drive, &mut axis.servo.friction) {
            figures.position_gain_per_s = drive.position_gain_per_s;
            figures.velocity_gain_per_s = drive.velocity_gain_per_s;
            friction.coulomb_per_s = drive.coulomb_mm_per_s2 / drive.velocity_gain_per_s;
            friction.viscous = drive.viscous_per_s / drive.velocity_gain_per_s;
            friction.presliding = drive.presliding_mm;
        }
    }
    let found = full(machine, Program::parse("circle", CIRCLE, "circle.ngc").unwrap());
    assert!(found.0 <= 0.15, "{found:?} µm");
}

/// Includes rotary axes; the linear ones move the tip.
#[test]
fn a_cone_on_five_axes_is_left_below_half_of_what_the_servo_alone_leaves() {
    let program = Program::builtin("cone-5axis").unwrap().unwrap();
    let settings = Settings { rate_hz: 4000.0, ..Settings::default() };
    let scenario = Scenario::new(sample("mill-5axis"), program, settings).unwrap();
    let [servo, full] = &tallies(scenario, &[Kind::ServoOnly, Kind::Full])[..] else { panic!("two runs") };
    assert!(full.error.rms_um < 0.5 * servo.error.rms_um, "{full:?} against {servo:?}");
}
