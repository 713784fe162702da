//! The direction of travel is the drive's: command plus correction.

use proptest::prelude::*;
use trueaxis::contour::{Method, Path, Reference};
use trueaxis::machine::{Axis, AxisSettings, Interpolation, MachineSettings, Row};
use trueaxis::{Config, Input, Output, ServoLoop, State};
use trueaxis_testing::machine::{Machine, rows_both_ways};
use trueaxis_testing::share::share;

const PERIOD_NS: u32 = 100_000;

fn settings() -> MachineSettings {
    let machine = Machine::three_axis().travel([-500.0, 500.0], 1.0);
    machine.each(|axis| axis.interpolation = Interpolation::Cubic).settings()
}

/// A table over the travel, every 10 mm.
fn table(error: impl Fn(f64, bool) -> [f64; 3]) -> Vec<Row> {
    rows_both_ways((-50..=50).map(|i| 10.0 * f64::from(i)), |q, reverse| {
        let [x, y, z] = error(q, reverse);
        [x, y, z, 0.0, 0.0, 0.0]
    })
}

/// Builds a loop with leaked memory.
fn servo(
    machine: &MachineSettings,
    tables: &[Vec<Row>; 3],
) -> Result<ServoLoop<'static, f64, f64, 3>, trueaxis::ConfigError> {
    let config = Config {
        machine,
        grids: &[],
        machine_id: 0,
        tables_crc: 0,
        period_ns: PERIOD_NS,
        inverse_passes: 8,
        method: Method::Guarded,
    };
    let rows = |axis: Axis| Some(tables[axis.index()].as_slice()).filter(|rows| !rows.is_empty());
    let memory = vec![0.0; config.requirement(rows)].leak();
    config.build(rows, memory)
}

struct Run {
    servo: ServoLoop<'static, f64, f64, 3>,
    state: State<f64, f64, 3>,
}

impl Run {
    fn new(machine: &MachineSettings, tables: &[Vec<Row>; 3]) -> Self {
        let servo = servo(machine, tables).unwrap();
        Run { state: servo.start(), servo }
    }

    fn cycle(&mut self, input: &Input<f64, 3>) -> Output<f64, f64, 3> {
        self.servo.step(&mut self.state, input, Path::new(&[], 0, false).on(Reference { span: 0, t: 0.0 }), ())
    }

    fn at(&mut self, command: [f64; 3]) -> Output<f64, f64, 3> {
        self.cycle(&input(command))
    }

    fn settle(&mut self, command: [f64; 3]) -> Output<f64, f64, 3> {
        for _ in 0..2000 {
            self.at(command);
        }
        self.at(command)
    }
}

fn input(command: [f64; 3]) -> Input<f64, 3> {
    Input { command, feedback: command, homed: true, enable: true, ..Input::at_rest(PERIOD_NS) }
}

/// Play between a drive and its carriage: a fraction of its width, traversed as the drive moves.
struct Play {
    width: f64,
    reverse: f64,
    drive: f64,
}

impl Play {
    fn follow(&mut self, drive: f64) -> f64 {
        self.reverse = (self.reverse - (drive - self.drive) / self.width).clamp(0.0, 1.0);
        self.drive = drive;
        self.reverse * self.width
    }
}

/// Only X is commanded, over a wave of its straightness, 30 µm; Y has 2 µm of play and is never commanded. Y's
/// drive follows −EYX, so its direction is known in closed form: negative where EYX rises.
#[test]
fn a_straightness_correction_takes_up_the_play_of_the_axis_that_it_moves() {
    const WAVE_MM: f64 = 300.0;
    const HEIGHT_MM: f64 = 0.030;
    const PLAY_MM: f64 = 0.002;
    let straightness = |x: f64| HEIGHT_MM * (std::f64::consts::TAU * x / WAVE_MM).sin();
    let mut machine = settings();
    machine.axes[1].backlash = PLAY_MM;
    let none = table(|_, _| [0.0; 3]);
    let tables = [table(|x, _| [0.0, straightness(x), 0.0]), none.clone(), none];
    let mut run = Run::new(&machine, &tables);
    let begin = -450.0;
    run.settle([begin, 0.0, 0.0]);
    let mut play = Play { width: PLAY_MM, reverse: 0.0, drive: run.at([begin, 0.0, 0.0]).drive[1] };
    let (mut worst, mut settled, mut squares, mut cycles) = (0.0_f64, 0.0_f64, 0.0, 0);
    // 50 mm/s: 0.75 s in an eighth of a wave.
    for n in 0..=60_000 {
        let x = begin + 0.005 * f64::from(n);
        let out = run.at([x, 0.0, 0.0]);
        assert_eq!((out.drive[0], out.record.correction[2]), (x, 0.0));
        let error = out.drive[1] + straightness_of(&tables[0], x) + play.follow(out.drive[1]);
        let slope = (std::f64::consts::TAU * x / WAVE_MM).cos();
        worst = worst.max(error.abs());
        // A reversal at the crest of a wave takes some distance to cross the band.
        if slope.abs() > 0.25 {
            let reverse = slope > 0.0;
            let asked = -straightness_of(&tables[0], x) - if reverse { PLAY_MM } else { 0.0 };
            assert!((out.record.correction[1] - asked).abs() < 1e-6, "at {x} the play counts as {}", !reverse);
            settled = settled.max(error.abs());
        }
        squares += error * error;
        cycles += 1;
    }
    let rms = (squares / f64::from(cycles)).sqrt();
    assert!(settled < 1e-6 && worst <= PLAY_MM + 1e-6 && rms < 0.2e-3, "{settled} {worst} {rms}");
}

/// Straightness by the table's own interpolation, which is not under test: it deviates from the wave as a cubic does.
fn straightness_of(rows: &[Row], x: f64) -> f64 {
    let settings = AxisSettings { interpolation: Interpolation::Cubic, ..AxisSettings::with_defaults(Axis::X, false) };
    trueaxis::machine::Curve::new(&settings, rows, 1, false).at(x).unwrap()
}

const PLAY: f64 = 0.004;

/// X with 4 µm of play and nothing else.
fn with_play() -> Run {
    let mut machine = settings();
    machine.axes[0].backlash = PLAY;
    let none = table(|_, _| [0.0; 3]);
    Run::new(&machine, &[none.clone(), none.clone(), none])
}

/// Whether the correction has taken up the play (is −PLAY) after a time at rest.
fn taken(run: &mut Run, command: [f64; 3]) -> bool {
    let correction = run.settle(command).record.correction[0];
    assert!(correction == 0.0 || (correction + PLAY).abs() < 1e-12, "{correction}");
    correction != 0.0
}

#[test]
fn homing_is_no_travel() {
    for homed_at in [-300.0, 300.0] {
        let mut run = with_play();
        for n in 0..100 {
            run.cycle(&Input { homed: false, ..input([40.0 + 0.01 * f64::from(n), 0.0, 0.0]) });
        }
        assert!(!taken(&mut run, [homed_at, 0.0, 0.0]), "{homed_at}");
        // Homed again elsewhere, before the correction has ramped out.
        for n in 0..=100 {
            run.at([homed_at - 0.01 * f64::from(n), 0.0, 0.0]);
        }
        assert!(taken(&mut run, [homed_at - 1.0, 0.0, 0.0]));
        run.cycle(&Input { homed: false, ..input([17.0, 0.0, 0.0]) });
        assert!(!taken(&mut run, [17.0, 0.0, 0.0]));
    }
}

#[test]
fn switching_off_and_on_turns_only_the_drives_that_move() {
    let mut run = with_play();
    run.settle([10.0, 0.0, 0.0]);
    for n in 0..=100 {
        run.at([10.0 - 0.01 * f64::from(n), 0.0, 0.0]);
    }
    assert!(taken(&mut run, [9.0, 0.0, 0.0]));
    // Ramping out moves the drive back by its play: it has reversed, and ramping in does not reverse it again.
    for _ in 0..2000 {
        run.cycle(&Input { enable: false, ..input([9.0, 0.0, 0.0]) });
    }
    assert!(!taken(&mut run, [9.0, 0.0, 0.0]));
}

#[test]
fn a_reversal_while_readings_are_missing_counts() {
    for far in [8.0, 11.0] {
        let mut run = with_play();
        run.settle([10.0, 0.0, 0.0]);
        let steps = 300;
        // There and back to a position beyond the start: only the return shows the direction.
        for n in 0..=2 * steps {
            let part = f64::from(if n <= steps { n } else { 2 * steps - n }) / f64::from(steps);
            let x =
                10.0 + part * (far - 10.0) + if n > steps { 0.5 * (1.0 - part) * (far - 10.0).signum() } else { 0.0 };
            run.cycle(&Input { encoder_alarm: 1, ..input([x, 0.0, 0.0]) });
        }
        let end = 10.0 + 0.5 * (far - 10.0_f64).signum();
        assert_eq!(taken(&mut run, [end, 0.0, 0.0]), far > 10.0, "{far}");
    }
}

#[test]
fn a_held_drive_has_no_direction() {
    let mut run = with_play();
    let before = run.settle([10.0, 0.0, 0.0]);
    run.cycle(&Input { feedback: before.drive, ..input([f64::NAN, 0.0, 0.0]) });
    // Commands in the meantime move nothing.
    for n in 0..500 {
        let away = Input { feedback: before.drive, ..input([10.0 - 0.01 * f64::from(n), 0.0, 0.0]) };
        assert!(run.cycle(&away).stop_requested());
    }
    run.at([10.0, 0.0, 0.0]);
    assert!(!run.cycle(&Input { reset: true, ..input([10.0, 0.0, 0.0]) }).stop_requested());
    assert!(!taken(&mut run, [10.0, 0.0, 0.0]));
}

#[test]
fn a_correction_against_the_travel_needs_a_wider_band() {
    let mut machine = settings();
    machine.axes[0].backlash = -0.0005;
    let none = table(|_, _| [0.0; 3]);
    let tables = [none.clone(), none.clone(), none];
    let error = servo(&machine, &tables).unwrap_err();
    assert_eq!((error.field, error.axis, error.found), (trueaxis::error::Field::Hysteresis, Some(Axis::X), 0.0003));
    assert!(error.bound.is_some_and(|bound| (bound - 0.0005).abs() < 1e-9), "{error}");
    assert_eq!(
        error.to_string(),
        "axis.X.hysteresis_um: found 0.3, needed more than its correction steps against the travel at a reversal: 0.5"
    );
    machine.axes[0].hysteresis = 0.00051;
    assert!(servo(&machine, &tables).is_ok());
}

/// Random steps that the reversals of the axes cause in their own and each other's errors: µm that a table adds in
/// negative travel.
fn any_steps() -> impl Strategy<Value = [[f64; 3]; 3]> {
    let step = prop_oneof![2 => Just(0.0), 3 => -1.5..1.5f64, 1 => 0.0..8.0f64];
    prop::array::uniform3(prop::array::uniform3(step))
}

/// Y has only its play, X and Z have no errors: tables of zeros add nothing, and the step sends the same bits. The step
/// subtracts the play from the command once Y travels in the negative direction.
#[test]
fn play_is_corrected_without_a_table() {
    const PLAY_MM: f64 = 0.02;
    let mut machine = settings();
    machine.axes[1].backlash = PLAY_MM;
    let none = || Vec::new();
    let zeros = rows_both_ways([-500.0, 500.0], |_, _| [0.0; 6]);
    let mut with = Run::new(&machine, &[none(), zeros, none()]);
    let mut without = Run::new(&machine, &[none(), none(), none()]);
    let mut leg = |from: f64, to: f64| {
        let mut last = 0.0;
        for n in 0..=4000 {
            let y = from + (to - from) * f64::from(n.min(2000)) / 2000.0;
            let [a, b] = [&mut without, &mut with].map(|run| run.at([0.0, y, 0.0]));
            assert_eq!(a.drive.map(f64::to_bits), b.drive.map(f64::to_bits), "{y}");
            last = a.drive[1] - y;
        }
        last
    };
    assert_eq!(leg(0.0, 10.0), 0.0);
    assert!((leg(10.0, -5.0) + PLAY_MM).abs() < 1e-12);
    assert_eq!(leg(-5.0, 0.0), 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: share(600) as u32, ..ProptestConfig::default() })]

    /// Every accepted machine comes to rest: after any travel, a constant command gets a constant correction.
    #[test]
    fn no_reversal_takes_itself_back(
        steps in any_steps(),
        waves in prop::array::uniform3(-8.0..8.0f64),
        bands in prop::array::uniform3(0.05..2.0f64),
        targets in prop::collection::vec(prop::array::uniform3(-0.02..0.02f64), 1..6),
    ) {
        let mut machine = settings();
        for (axis, band) in machine.axes.iter_mut().zip(bands) {
            axis.hysteresis = band * 1e-3;
        }
        let of = |moving: usize| table(|q, reverse| std::array::from_fn(|k| {
            let step = if reverse { steps[moving][k] } else { 0.0 };
            1e-3 * (waves[k] * (q / 47.0 + k as f64).sin() + step)
        }));
        let tables = [of(0), of(1), of(2)];
        let Ok(servo) = servo(&machine, &tables) else { return Ok(()) };
        let mut run = Run { state: servo.start(), servo };
        let mut at = [1.0, 2.0, 3.0];
        for target in targets {
            for _ in 0..200 {
                for (at, by) in at.iter_mut().zip(target) {
                    *at += by;
                }
                run.at(at);
            }
            let rest = run.settle(at).record.correction;
            // Looked up at the last drive position, a correction may alternate between two neighbouring numbers for
            // ever.
            for _ in 0..300 {
                let now = run.at(at).record.correction;
                prop_assert!(now.iter().zip(rest).all(|(now, rest)| (now - rest).abs() < 1e-17), "{now:?}, not {rest:?}");
            }
        }
    }

    /// With only positive play, every machine is accepted, however narrow the band.
    #[test]
    fn positive_play_is_always_accepted(
        plays in prop::array::uniform3(0.0..0.05f64),
        bands in prop::array::uniform3(0.0..1e-3f64),
    ) {
        let mut machine = settings();
        for (axis, (play, band)) in machine.axes.iter_mut().zip(plays.into_iter().zip(bands)) {
            (axis.backlash, axis.hysteresis) = (play, band);
        }
        let tables = [0, 1, 2].map(|k| table(|q, _| [0.0, 1.0, 2.0].map(|c| 0.01 * (q / 90.0 + c + f64::from(k)).sin())));
        prop_assert!(servo(&machine, &tables).is_ok());
    }
}
