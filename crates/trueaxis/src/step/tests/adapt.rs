//! Friction that adapts, on simulated axes whose friction changes: the plant is written here, from its differential equations.

use super::*;
use crate::error::Fault;
use crate::machine::{AxisServo, DriveFigures, DynamicSettings, FrictionSettings, Limits};
use core::f64::consts::TAU;

/// An axis with its drive and the friction that the plugin is told.
#[derive(Clone, Copy)]
struct Axis {
    drive: DriveFigures,
    friction: FrictionSettings,
    /// Whether the velocity loop of the plant has an integrator.
    integrates: bool,
    period_s: f64,
}

const MILL: Axis = Axis {
    drive: DriveFigures { velocity_feed_forward: 0.9, ..DriveFigures::with_defaults(100.0, 800.0, 0.006) },
    friction: FrictionSettings { stribeck_share: 0.3, viscous: 0.005, ..FrictionSettings::with_defaults(0.5, 0.006) },
    integrates: true,
    period_s: 1e-3,
};

/// The EMPS axis (A. Janot, M. Gautier, M. Brunot, Data set and reference models of EMPS, 2019): mass 95.1 kg, Coulomb
/// friction 20.39 N, viscous 203.5 N/(m/s), K_p 160.2/s, 35.15 N/V · 243.45 V/(m/s) of proportional velocity loop; 1 kHz. Of
/// pre-sliding it states nothing.
const EMPS: Axis = {
    let velocity_gain_per_s = 35.15 * 243.45 / 95.1;
    Axis {
        drive: DriveFigures::with_defaults(160.2, velocity_gain_per_s, 10.0),
        friction: FrictionSettings {
            viscous: 203.5 / 95.1 / velocity_gain_per_s,
            ..FrictionSettings::with_defaults(1e3 * 20.39 / 95.1 / velocity_gain_per_s, 0.005)
        },
        integrates: false,
        period_s: 1e-3,
    }
};

/// State of the plant: one mass, Coulomb and Stribeck friction with pre-sliding, velocity and position loop.
struct Plant {
    of: Axis,
    position: f64,
    velocity: f64,
    integral: f64,
    share: f64,
    force: f64,
    command: f64,
}

impl Plant {
    fn at(of: Axis, position: f64) -> Plant {
        Plant { of, position, velocity: 0.0, integral: 0.0, share: 1.0, force: 0.0, command: position }
    }

    /// A period, with `level` times the Coulomb friction and `wider` times the pre-sliding that the plugin is told.
    fn advance(&mut self, command: f64, level: f64, wider: f64) {
        let Axis { drive, friction, integrates, period_s } = self.of;
        let fed = drive.velocity_feed_forward * (command - self.command) / period_s;
        let wanted = drive.position_gain_per_s * (self.command - self.position) + fed;
        self.command = command;
        let steps = 20;
        let h = period_s / f64::from(steps);
        for _ in 0..steps {
            let error = wanted - self.velocity;
            if integrates {
                self.integral += error * h / drive.reset_time_s;
            }
            let asked = drive.velocity_gain_per_s * (error + self.integral);
            self.force += (1.0 - (-h / drive.current_loop_s).exp()) * (asked - self.force);
            let travel = self.velocity * h / (wider * friction.presliding);
            self.share = (self.share + travel) / (1.0 + travel.abs());
            let ratio = self.velocity / friction.stribeck_velocity_per_s;
            let sliding = level * friction.coulomb_per_s * (1.0 + friction.stribeck_share / (1.0 + ratio * ratio));
            let drag = drive.velocity_gain_per_s * (sliding * self.share + friction.viscous * self.velocity);
            self.velocity += (self.force - drag) * h;
            self.position += self.velocity * h;
        }
    }
}

/// A machine with two such axes, whose stated friction is multiplied by `level` and `wider`.
fn servo(of: Axis, adapt: f64, level: f64, wider: f64) -> &'static Loop {
    Box::leak(Box::new(built(of, adapt, level, wider)))
}

fn built(of: Axis, adapt: f64, level: f64, wider: f64) -> Loop {
    let mut machine = machine(|axis| {
        let friction = FrictionSettings {
            coulomb_per_s: level * of.friction.coulomb_per_s,
            presliding: wider * of.friction.presliding,
            adapt,
            ..of.friction
        };
        let limits = Limits { magnitude: 0.5, slope_per_s: 50.0, acceleration_per_s2: 1e5 };
        let dynamic = DynamicSettings { limits, ..DynamicSettings::with_defaults(axis.axis) };
        axis.limits = Limits { magnitude: 0.6, slope_per_s: 60.0, acceleration_per_s2: 1e5 };
        axis.joint = [-20.0, 120.0];
        axis.servo = AxisServo { drive: Some(of.drive), friction: Some(friction), dynamic: Some(dynamic) };
    });
    machine.faults.stuck = [5.0; 2];
    let config = Config {
        machine: &machine,
        grids: &[],
        machine_id: 0,
        tables_crc: 0,
        period_ns: (of.period_s * 1e9).round() as u32,
        inverse_passes: 1,
        method: Method::Guarded,
    };
    config.build(|_| None::<&[Row]>, Default::default()).unwrap()
}

/// Two axes on a circle about (50, 50).
struct Circle {
    plants: [Plant; 2],
    state: State<f64, f64, 3>,
    radius: f64,
    angle: f64,
    per_cycle: f64,
    noise: f64,
    seed: u64,
    last: Option<Out>,
}

impl Circle {
    fn new(of: Axis, servo: &Loop, radius: f64, speed: f64) -> Circle {
        let plants = [Plant::at(of, 50.0 + radius), Plant::at(of, 50.0)];
        let per_cycle = speed * of.period_s / radius;
        Circle { plants, state: servo.start(), radius, angle: 0.0, per_cycle, noise: 0.0, seed: 1, last: None }
    }

    /// Noise of a reading, uniform.
    fn noise(&mut self) -> f64 {
        self.seed = self.seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        self.noise * ((self.seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
    }

    /// A cycle; returns the error of the radius.
    fn cycle(&mut self, servo: &Loop, level: f64, wider: f64) -> f64 {
        self.angle = (self.angle + self.per_cycle) % TAU;
        let command = [50.0 + self.radius * self.angle.cos(), 50.0 + self.radius * self.angle.sin(), 0.0];
        let feedback = [self.plants[0].position + self.noise(), self.plants[1].position + self.noise(), 0.0];
        let given = Input { feedback, elapsed_ns: servo.period_ns(), ..input(command) };
        let out = servo.step(&mut self.state, &given, (), ());
        for (plant, drive) in self.plants.iter_mut().zip(out.drive) {
            plant.advance(drive, level, wider);
        }
        self.last = Some(out);
        (self.plants[0].position - 50.0).hypot(self.plants[1].position - 50.0) - self.radius
    }

    /// Turns; returns the errors of the last one, without their mean.
    fn turns(&mut self, servo: &Loop, turns: u32, level: f64, wider: f64) -> Left {
        let cycles = (TAU / self.per_cycle).round() as usize;
        let mut errors: Vec<f64> = (1..turns as usize * cycles).map(|_| self.cycle(servo, level, wider)).collect();
        errors.drain(..errors.len() + 1 - cycles);
        Left::of(&errors)
    }

    fn factors(&self, servo: &Loop) -> [[f64; 2]; 2] {
        [0, 1].map(|slot| servo.friction_factors(&self.state, slot).unwrap())
    }

    fn fault(&self) -> Fault {
        self.last.unwrap().record.fault
    }
}

/// Error of the radius about its mean.
#[derive(Debug)]
struct Left {
    rms: f64,
    largest: f64,
}

impl Left {
    fn of(errors: &[f64]) -> Left {
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let rms = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
        Left { rms, largest: errors.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max) }
    }
}

/// Follows a friction that swings by ±50 % over `turns` turns, beside a loop that is told the true figures of every turn. Returns
/// the errors of both, over all turns but the first tenth, and the largest error of a factor.
fn drift(of: Axis, speed: f64, turns: u32) -> ([Left; 2], f64) {
    let adapts = servo(of, 0.6, 1.0, 1.0);
    let told = built(of, 0.0, 1.0, 1.0);
    let mut circles = [Circle::new(of, adapts, 25.0, speed), Circle::new(of, &told, 25.0, speed)];
    let cycles = (TAU / circles[0].per_cycle).round() as usize;
    let (mut sums, mut largest, mut off) = ([0.0; 2], [0.0_f64; 2], 0.0_f64);
    for turn in 0..turns {
        let swing = (TAU * f64::from(turn) / f64::from(turns)).sin();
        let (level, wider) = (1.0 + 0.5 * swing, 1.0 - 0.3 * swing);
        let told = built(of, 0.0, level, wider);
        for (k, servo) in [adapts, &told].into_iter().enumerate() {
            let errors: Vec<f64> = (0..cycles).map(|_| circles[k].cycle(servo, level, wider)).collect();
            if turn >= turns / 10 {
                let left = Left::of(&errors);
                sums[k] += left.rms * left.rms;
                largest[k] = largest[k].max(left.largest);
            }
        }
        if turn >= turns / 10 {
            let factors = circles[0].factors(adapts);
            off = factors.iter().fold(off, |off, [now, _]| off.max((now / level - 1.0).abs()));
        }
        assert_eq!(circles[0].fault(), Fault::None, "turn {turn}");
    }
    let counted = f64::from(turns - turns / 10);
    ([0, 1].map(|k| Left { rms: (sums[k] / counted).sqrt(), largest: largest[k] }), off)
}

#[test]
fn a_friction_that_drifts_by_half_leaves_what_its_true_figures_leave() {
    for (name, of, speed) in [("mill", MILL, 80.0), ("EMPS", EMPS, 80.0)] {
        let ([left, told], _) = drift(of, speed, 100);
        assert!(left.rms < 1.1 * told.rms && left.largest < 1.1 * told.largest, "{name} {speed}: {left:?} {told:?}");
    }
}

/// 10^8 cycles, of the EMPS axis, half of them told the true figures: `.ci/campaign adapt`.
#[test]
#[ignore = "a campaign"]
fn the_emps_axis_drifts_over_a_hundred_million_cycles() {
    let cycles_a_turn = TAU * 25.0 / 80.0 / EMPS.period_s;
    let ([left, told], off) = drift(EMPS, 80.0, (1e8 / cycles_a_turn) as u32);
    std::println!("adapting {left:?}, told {told:?}, Coulomb friction off by up to {off}");
    assert!(left.rms < 1.1 * told.rms && left.largest < 1.1 * told.largest, "{left:?} {told:?}");
}

#[test]
fn noise_alone_moves_nothing() {
    let adapts = servo(MILL, 0.5, 1.0, 1.0);
    // Peak values; the spikes at these figures are below 1 µm.
    for noise in [1e-4, 1e-3, 1e-2] {
        let mut circle = Circle::new(MILL, adapts, 25.0, 80.0);
        circle.noise = noise;
        circle.turns(adapts, 60, 1.0, 1.0);
        let factors = circle.factors(adapts);
        for [level, presliding] in factors {
            assert!((level - 1.0).abs() < 0.05 && (presliding - 1.0).abs() < 0.1, "{noise}: {factors:?}");
        }
    }
}

#[test]
fn an_axis_that_does_not_adapt_has_no_factors_and_a_frozen_one_keeps_every_bit() {
    let (plain, adapts) = (servo(MILL, 0.0, 1.0, 1.0), servo(MILL, 0.5, 1.0, 1.0));
    let mut circles = [Circle::new(MILL, plain, 25.0, 80.0), Circle::new(MILL, adapts, 25.0, 80.0)];
    circles[1].state.freeze_friction(true);
    for k in 0..5000 {
        let [own, other] = [plain, adapts].map(|servo| servo.friction_factors(&circles[0].state, 0));
        assert_eq!((own, other), (None, Some([1.0; 2])));
        circles[0].cycle(plain, 0.5, 1.0);
        circles[1].cycle(adapts, 0.5, 1.0);
        let drives = [0, 1].map(|k| circles[k].last.unwrap().drive.map(f64::to_bits));
        assert_eq!(drives[0], drives[1], "cycle {k}");
    }
    circles[1].state.freeze_friction(false);
    circles[1].turns(adapts, 3, 0.5, 1.0);
    let factors = circles[1].factors(adapts);
    assert!(factors.iter().all(|[level, _]| *level < 0.9), "{factors:?}");
    circles[1].state.reset_friction();
    assert_eq!(circles[1].factors(adapts), [[1.0; 2]; 2]);
}

#[test]
fn a_narrower_interval_holds_from_the_cycle_in_which_it_is_exchanged() {
    let (wide, narrow) = (servo(MILL, 0.6, 1.0, 1.0), servo(MILL, 0.1, 1.0, 1.0));
    let mut circle = Circle::new(MILL, wide, 25.0, 80.0);
    circle.turns(wide, 10, 0.5, 1.0);
    assert!(circle.factors(wide)[0][0] < 0.55);
    assert!((circle.factors(narrow)[0][0] - 0.9).abs() < 1e-12);
    circle.turns(narrow, 2, 1.0, 1.0);
    assert!(circle.factors(narrow)[0][0] > 0.9);
}

/// A circle whose readings are made of its commands.
fn faked(servo: &Loop, state: &mut State<f64, f64, 3>, k: u32, speed: f64, reading: impl FnOnce(f64) -> f64) -> Fault {
    let angle = speed * MILL.period_s / 25.0 * f64::from(k);
    let command = [50.0 + 25.0 * angle.cos(), 50.0 + 25.0 * angle.sin(), 0.0];
    let feedback = [reading(command[0]), command[1], 0.0];
    let given = Input { feedback, elapsed_ns: servo.period_ns(), ..input(command) };
    servo.step(state, &given, (), ()).record.fault
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    /// Whatever the readings are, the figures stay in their interval.
    #[test]
    fn no_readings_move_the_figures_out_of_their_interval(
        share in 0.01..0.9,
        sizes in prop::collection::vec(-0.5..0.5, 50),
        wave in 1.0..500.0_f64,
    ) {
        let adapts = built(MILL, share, 1.0, 1.0);
        let mut state = adapts.start();
        for k in 0..12_000 {
            let size = sizes[k as usize / 240];
            faked(&adapts, &mut state, k, 80.0, |x: f64| x + size * (f64::from(k) * TAU / wave).sin());
            let [level, presliding] = adapts.friction_factors(&state, 0).unwrap();
            prop_assert!((level - 1.0).abs() <= share && (presliding - 1.0).abs() <= share);
        }
    }
}

#[test]
fn an_axis_that_sticks_and_slips_is_a_fault_until_a_reset() {
    let adapts = servo(MILL, 0.5, 1.0, 1.0);
    let (mut state, mut at, mut found) = (adapts.start(), 75.0, None);
    for k in 0..12_000 {
        // It stands still until it is 20 µm behind.
        let fault = faked(adapts, &mut state, k, 25.0, |x: f64| {
            if (x - at).abs() > 0.02 {
                at = x;
            }
            at
        });
        if fault != Fault::None {
            found = found.or(Some((k, fault)));
            assert_eq!((fault, adapts.friction_factors(&state, 0)), (Fault::StickSlip, Some([1.0; 2])));
        }
    }
    assert!(found.is_some());
    state.reset_friction();
    assert_eq!(faked(adapts, &mut state, 12_000, 25.0, |x| x), Fault::None);
}

#[test]
fn a_friction_with_the_wrong_sign_is_a_fault_and_no_adaptation() {
    let adapts = servo(MILL, 0.5, 1.0, 1.0);
    let mut circle = Circle::new(MILL, adapts, 25.0, 80.0);
    circle.turns(adapts, 6, -0.8, 1.0);
    assert_eq!((circle.fault(), circle.factors(adapts)), (Fault::FrictionReversed, [[1.0; 2]; 2]));
    // No friction at all is a change to follow, as far as the interval permits.
    let mut circle = Circle::new(MILL, adapts, 25.0, 80.0);
    circle.turns(adapts, 12, 0.0, 1.0);
    assert_eq!(circle.fault(), Fault::None);
    assert!((circle.factors(adapts)[0][0] - 0.5).abs() < 1e-12);
}
