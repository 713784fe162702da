//! Friction that adapts, through the C interface, on an axis that is simulated here: followed, frozen, reset, reported.

// The conversions are useless only in double precision.
#![allow(clippy::useless_conversion)]

use crate::machines::rust::*;
use crate::machines::*;
use std::f64::consts::TAU;
use trueaxis::Position as _;
use trueaxis::machine::FrictionSettings;
use trueaxis_capi::*;

const PERIOD_S: f64 = 1e-9 * PERIOD_NS as f64;
const CENTER: [f64; 3] = [60.0, -40.0, -200.0];
const RADIUS: f64 = 25.0;
/// Cycles of a turn: 79 mm/s.
const AROUND: usize = 20_000;

fn friction() -> FrictionSettings {
    FrictionSettings { adapt: 0.5, ..FrictionSettings::with_defaults(0.5, 0.006) }
}

/// The mill with friction that adapts on X and Y, and one that does not on Z.
fn adapting_mill() -> Vec<u8> {
    let mut machine = read("mill-3axis");
    for (k, axis) in machine.settings.axes.iter_mut().enumerate() {
        axis.servo.drive = Some(drive());
        axis.servo.friction = Some(FrictionSettings { adapt: if k < 2 { 0.5 } else { 0.0 }, ..friction() });
        axis.servo.dynamic = None;
    }
    machine.settings.contour.feedback = None;
    machine.settings.crosstalk.clear();
    trueaxis_tables::compile(&machine).unwrap()
}

/// A mass with friction, and its position and velocity loop.
#[derive(Default)]
struct Slide {
    at: f64,
    velocity: f64,
    integral: f64,
    force: f64,
    share: f64,
    command: f64,
}

impl Slide {
    fn rest(at: f64) -> Slide {
        Slide { at, command: at, ..Slide::default() }
    }

    /// A period, with `level` times the stated Coulomb friction.
    fn advance(&mut self, command: f64, level: f64) {
        let (drive, friction, parts) = (drive(), friction(), 10);
        let fed = drive.velocity_feed_forward * (command - self.command) / PERIOD_S;
        let wanted = drive.position_gain_per_s * (self.command - self.at) + fed;
        self.command = command;
        let h = PERIOD_S / f64::from(parts);
        for _ in 0..parts {
            let error = wanted - self.velocity;
            self.integral += error * h / drive.reset_time_s;
            let asked = drive.velocity_gain_per_s * (error + self.integral);
            self.force += (asked - self.force) * h / drive.current_loop_s;
            let travel = self.velocity * h / friction.presliding;
            self.share = (self.share + travel) / (1.0 + travel.abs());
            let ratio = self.velocity / friction.stribeck_velocity_per_s;
            let sliding = level * friction.coulomb_per_s * (1.0 + friction.stribeck_share / (1.0 + ratio * ratio));
            self.velocity += (self.force - drive.velocity_gain_per_s * sliding * self.share) * h;
            self.at += self.velocity * h;
        }
    }
}

/// Two slides on a circle, through C and Rust; every output of C is the Rust one in every bit.
struct Circle {
    servo: BuiltLoop,
    state: Box<State>,
    core: trueaxis::ServoLoop<'static, R, P, 3>,
    core_state: trueaxis::State<R, P, 3>,
    slides: [Slide; 3],
    cycle: usize,
}

impl Circle {
    fn turns(&mut self, turns: usize, level: f64) {
        for _ in 0..turns * AROUND {
            let [sin, cos] = [f64::sin, f64::cos].map(|f| f(TAU * self.cycle as f64 / AROUND as f64));
            let command = [CENTER[0] + RADIUS * cos, CENTER[1] + RADIUS * sin, CENTER[2], 0.0, 0.0, 0.0];
            let [x, y, z] = self.slides.each_ref().map(|slide| slide.at);
            let (c, mut out) = (input(command, [x, y, z, 0.0, 0.0, 0.0]), output());
            assert_eq!(step(&self.servo.servo, &mut self.state, &c, &mut out), OK);
            same(&out, &self.core.step(&mut self.core_state, &core_input(&c), (), ()), self.cycle);
            assert_eq!(out.record.fault, FAULT_NONE, "cycle {}", self.cycle);
            self.slides
                .iter_mut()
                .zip(out.drive)
                .for_each(|(slide, drive)| slide.advance(from_c(drive).to_f64(), level));
            self.cycle += 1;
        }
    }

    /// Factors on Coulomb friction and pre-sliding of an axis, equal to those of the Rust interface.
    fn factors(&mut self, axis: u32) -> Result<[f64; 2], ResultCode> {
        let (mut coulomb, mut presliding) = (9.0, 9.0);
        let (servo, state) = (&*self.servo.servo, &mut *self.state);
        // SAFETY: all pointers match their types.
        let result = unsafe { trueaxis_friction_factors(servo, state, axis, &mut coulomb, &mut presliding) };
        let core = self.core.friction_factors(&self.core_state, axis as usize);
        assert_eq!((result == OK).then_some([coulomb, presliding]), core);
        core.map(|core| core.map(f64::from)).ok_or(result)
    }

    fn freeze(&mut self, frozen: bool) {
        // SAFETY: all pointers match their types.
        assert_eq!(unsafe { trueaxis_friction_freeze(&*self.servo.servo, &mut *self.state, frozen.into()) }, OK);
        self.core_state.freeze_friction(frozen);
    }
}

#[test]
#[cfg_attr(miri, ignore)]
fn friction_is_followed_frozen_and_reset_as_in_rust() {
    let file = adapting_mill();
    let (servo, core) = (built(&file), rust_loop::<3>(&file));
    let (state, core_state) = (started(&servo.servo), core.start());
    let slides = [CENTER[0] + RADIUS, CENTER[1], CENTER[2]].map(Slide::rest);
    let mut circle = Circle { servo, state, core, core_state, slides, cycle: 0 };
    let levels = |circle: &mut Circle| [0, 1].map(|axis| circle.factors(axis).unwrap()[0]);
    assert_eq!(levels(&mut circle), [1.0; 2]);
    // Neither an axis whose friction does not adapt, nor one that does not exist.
    assert_eq!([2, 3, u32::MAX].map(|axis| circle.factors(axis)), [Err(ERROR_ARGUMENT); 3]);
    circle.turns(4, 1.4);
    let followed = levels(&mut circle);
    assert!(followed.iter().all(|level| (1.2..=1.5).contains(level)), "{followed:?}");
    circle.freeze(true);
    circle.turns(2, 0.6);
    assert_eq!(levels(&mut circle), followed);
    circle.freeze(false);
    circle.turns(2, 0.6);
    assert!(levels(&mut circle).iter().zip(followed).all(|(level, before)| *level < before - 0.1));
    // SAFETY: all pointers match their types.
    assert_eq!(unsafe { trueaxis_friction_reset(&*circle.servo.servo, &mut *circle.state) }, OK);
    circle.core_state.reset_friction();
    assert_eq!(levels(&mut circle), [1.0; 2]);
    circle.turns(1, 0.6);
    assert!(levels(&mut circle).iter().all(|level| *level < 0.99));
}
