//! One rigid mass.

use super::*;
use trueaxis::machine::Axis;

#[test]
fn lags_by_the_velocity_that_is_not_fed_forward() {
    for period in [1e-4, 2.5e-4, 1e-3] {
        let settings = DriveSettings::of(Axis::X);
        let mut drive = Drive::new(settings, period);
        let velocity = 25.0;
        let mut command = 0.0;
        for k in 1..=(1.0 / period) as u32 {
            command = velocity * f64::from(k) * period;
            drive.cycle(command, drive.position(), 1.0);
        }
        let designed = velocity * (1.0 - settings.velocity_feed_forward) / settings.position_gain_per_s;
        let lag = command - drive.position();
        assert!((lag / designed - 1.0).abs() < 1e-3, "period {period}: lag {lag}, designed {designed}");
    }
}

#[test]
fn a_step_settles_without_much_overshoot_and_within_the_force_limit() {
    let settings = DriveSettings::of(Axis::Y);
    let mut drive = Drive::new(settings, 1e-4);
    let (mut top, mut before): (f64, f64) = (0.0, 0.0);
    for _ in 0..20_000 {
        drive.cycle(1.0, drive.position(), 1.0);
        top = top.max(drive.position());
        let acceleration = (drive.velocity() - before) / 1e-4;
        // Friction can add to the motor's braking.
        let friction = 1.3 * settings.coulomb_mm_per_s2 + settings.viscous_per_s * before.abs();
        assert!(acceleration.abs() <= settings.force_limit_mm_per_s2 + friction + 1.0);
        before = drive.velocity();
    }
    assert!((drive.position() - 1.0).abs() < 5e-4, "{}", drive.position());
    assert!(top < 1.35, "{top}");
}

#[test]
fn a_command_that_is_not_finite_is_ignored() {
    let mut drive = Drive::new(DriveSettings::of(Axis::X), 1e-4);
    drive.rest_at(3.0);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        drive.cycle(bad, 3.0, 1.0);
    }
    assert_eq!(drive.position(), 3.0);
}

#[test]
fn absurd_commands_leave_the_state_finite() {
    let mut drive = Drive::new(DriveSettings::of(Axis::X), 1e-4);
    for bad in [f64::MAX, f64::MIN, f64::MAX, 1e200, 0.0] {
        drive.cycle(bad, drive.position(), 2.5);
    }
    for _ in 0..50_000 {
        drive.cycle(0.0, drive.position(), 1.0);
    }
    assert!(drive.position().abs() < 1e-3, "{}", drive.position());
}

#[test]
fn dead_time_adds_to_the_lag() {
    let velocity = 25.0;
    let lag = |dead_time_s: f64| {
        let mut drive = Drive::new(DriveSettings { dead_time_s, ..DriveSettings::of(Axis::X) }, 1e-4);
        for k in 1..=10_000 {
            drive.cycle(velocity * f64::from(k) * 1e-4, drive.position(), 1.0);
        }
        velocity - drive.position()
    };
    let more = lag(0.00125) - lag(0.0);
    assert!((more / (velocity * 0.00125) - 1.0).abs() < 1e-3, "{more}");
}
