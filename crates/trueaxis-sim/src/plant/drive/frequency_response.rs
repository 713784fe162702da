//! The drive against its transfer function, which is computed here from the equations and shares no code with the simulation.

use super::*;
use std::ops::{Add, Div, Mul, Sub};
use trueaxis::machine::Axis;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    fn exp(self) -> Complex {
        let (sin, cos) = self.im.sin_cos();
        Complex { re: self.re.exp() * cos, im: self.re.exp() * sin }
    }

    fn abs(self) -> f64 {
        self.re.hypot(self.im)
    }
}

impl From<f64> for Complex {
    fn from(re: f64) -> Complex {
        Complex { re, im: 0.0 }
    }
}

impl Add for Complex {
    type Output = Complex;
    fn add(self, b: Complex) -> Complex {
        Complex { re: self.re + b.re, im: self.im + b.im }
    }
}

impl Sub for Complex {
    type Output = Complex;
    fn sub(self, b: Complex) -> Complex {
        Complex { re: self.re - b.re, im: self.im - b.im }
    }
}

impl Mul for Complex {
    type Output = Complex;
    fn mul(self, b: Complex) -> Complex {
        Complex { re: self.re * b.re - self.im * b.im, im: self.re * b.im + self.im * b.re }
    }
}

impl Div for Complex {
    type Output = Complex;
    fn div(self, b: Complex) -> Complex {
        let square = b.re * b.re + b.im * b.im;
        Complex { re: (self.re * b.re + self.im * b.im) / square, im: (self.im * b.re - self.re * b.im) / square }
    }
}

/// Closed loops of a drive with viscous friction alone at one frequency.
struct Response {
    /// Load over command.
    load: Complex,
    /// Scale over command.
    scale: Complex,
    /// Scale over a force on the motor.
    compliance: Complex,
}

/// ```text
/// (1 − σ) s² x_M = F + D − (k + c s)(x_M − x_L)        σ s² x_L = (k + c s)(x_M − x_L) − d s x_L
/// F = K_vp (1 + 1/(τ s)) / (1 + t_i s) · (H K_v (w − x_S) + k_ff (e^sT − 1)/T · H w − s x_M)
/// H = (1 − e^−sT)/(s T)                                sampled and held for T
/// ```
fn response(p: &DriveSettings, period_s: f64, hz: f64) -> Response {
    let real = Complex::from;
    let s = Complex { re: 0.0, im: TAU * hz };
    let sigma = p.load_share;
    let omega = TAU * p.resonance_hz;
    let (k, c) = (sigma * (1.0 - sigma) * omega * omega, 2.0 * p.resonance_damping * sigma * (1.0 - sigma) * omega);
    let (to_motor, to_load) = if p.resonance_hz == 0.0 {
        let rigid = real(1.0) / (s * s + real(p.viscous_per_s) * s);
        (rigid, rigid)
    } else {
        let coupling = real(k) + real(c) * s;
        let motor = real(1.0 - sigma) * s * s + coupling;
        let load = real(sigma) * s * s + real(p.viscous_per_s) * s + coupling;
        let both = motor * load - coupling * coupling;
        (load / both, coupling / both)
    };
    let to_scale = if p.scale_at == ScaleAt::Load { to_load } else { to_motor };
    let velocity_loop = real(p.velocity_gain_per_s) * (real(1.0) + real(1.0) / (real(p.reset_time_s) * s))
        / (real(1.0) + real(p.current_loop_s) * s);
    let held = (real(1.0) - (real(-period_s) * s).exp()) / (s * real(period_s));
    let ahead = ((real(period_s) * s).exp() - real(1.0)) / real(period_s);
    let reference = held * (real(p.position_gain_per_s) + real(p.velocity_feed_forward) * ahead);
    let back = s * to_motor + held * real(p.position_gain_per_s) * to_scale;
    let closed = real(1.0) + velocity_loop * back;
    let forward = velocity_loop * reference / closed;
    Response { load: forward * to_load, scale: forward * to_scale, compliance: to_scale / closed }
}

/// Amplitude and phase of a series at `hz`, over a whole number of periods.
fn correlated(series: &[f64], period_s: f64, hz: f64) -> Complex {
    let mut sum = Complex::from(0.0);
    for (k, value) in series.iter().enumerate() {
        let (sin, cos) = (TAU * hz * k as f64 * period_s).sin_cos();
        sum = sum + Complex { re: value * sin, im: value * cos };
    }
    sum * Complex::from(2.0 / series.len() as f64)
}

/// A drive without Coulomb friction.
fn linear(settings: DriveSettings) -> DriveSettings {
    DriveSettings { coulomb_mm_per_s2: 0.0, torque_ripple_mm_per_s2: 0.0, gear_play_mm: 0.0, ..settings }
}

/// Load and scale over command at a multiple of 2 Hz.
fn driven(settings: DriveSettings, period_s: f64, hz: f64) -> [Complex; 2] {
    let mut drive = Drive::new(settings, period_s);
    let window = (0.5 / period_s).round() as usize;
    let (mut load, mut scale) = (Vec::new(), Vec::new());
    for k in 1..=4 * window {
        let command = 1e-4 * (TAU * hz * k as f64 * period_s).sin();
        drive.cycle(command, drive.position(), 1.0);
        if k >= 3 * window && k < 4 * window {
            load.push(1e4 * drive.load_position());
            scale.push(1e4 * drive.position());
        }
    }
    [load, scale].map(|series| correlated(&series, period_s, hz))
}

#[test]
fn a_drive_with_two_masses_follows_a_sine_as_its_transfer_function() {
    for scale_at in [ScaleAt::Motor, ScaleAt::Load] {
        for (resonance_hz, load_share) in [(120.0, 0.4), (60.0, 0.7)] {
            let usual = linear(Variant::Usual.settings());
            let settings = DriveSettings { scale_at, resonance_hz, load_share, resonance_damping: 0.02, ..usual };
            let antiresonance = settings.antiresonance_hz();
            let middle = 0.5 * (antiresonance + resonance_hz);
            for wanted in [0.3 * antiresonance, antiresonance, middle, resonance_hz, 1.6 * resonance_hz] {
                let hz = 2.0 * (0.5 * wanted).round();
                let [load, scale] = driven(settings, 2e-5, hz);
                let expected = response(&settings, 2e-5, hz);
                for (what, found, needed) in [("load", load, expected.load), ("scale", scale, expected.scale)] {
                    let off = (found - needed).abs() / needed.abs();
                    println!("{scale_at:?} {resonance_hz} Hz, {what} at {hz} Hz: {found:?}, {needed:?}, off {off:.4}");
                    // Amplitude and phase (rad) within 2 %.
                    assert!(
                        off < 0.02,
                        "{scale_at:?} {resonance_hz} Hz, {what} at {hz} Hz: {found:?}, needed {needed:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_rigid_drive_follows_a_sine_as_its_transfer_function() {
    let settings = linear(DriveSettings::default());
    for hz in [4.0, 16.0, 60.0, 120.0, 250.0] {
        let [load, _] = driven(settings, 1e-5, hz);
        let needed = response(&settings, 1e-5, hz).load;
        assert!((load - needed).abs() < 0.02 * needed.abs(), "{hz} Hz: {load:?}, needed {needed:?}");
    }
}

#[test]
fn the_ripple_moves_the_motor_as_its_amplitude_and_period_say() {
    let period_s = 1e-4;
    let ripple = |settings| DriveSettings {
        torque_ripple_mm_per_s2: 80.0,
        ripple_period_mm: 2.0,
        velocity_feed_forward: 1.0,
        viscous_per_s: 0.0,
        ..linear(settings)
    };
    for settings in [DriveSettings::default(), Variant::Usual.settings(), Variant::Soft.settings()].map(ripple) {
        let mut drive = Drive::new(settings, period_s);
        // 20 mm/s: 10 Hz.
        let position = |k: usize| 20.0 * k as f64 * period_s;
        let mut errors = Vec::new();
        for k in 1..=40_000 {
            drive.cycle(position(k), drive.position(), 1.0);
            if k > 30_000 {
                errors.push(drive.position() - position(k));
            }
        }
        let found = correlated(&errors, period_s, 10.0).abs();
        let needed = 80.0 * response(&settings, period_s, 10.0).compliance.abs();
        assert!((found / needed - 1.0).abs() < 0.02, "{found} mm, needed {needed} mm");
    }
}

/// The friction acts on the load: it deflects the spring.
#[test]
fn steady_friction_deflects_the_spring_and_reverses_through_the_play() {
    let settings = DriveSettings {
        gear_play_mm: 0.008,
        torque_ripple_mm_per_s2: 0.0,
        stribeck_share: 0.0,
        viscous_per_s: 0.0,
        ..Variant::Worn.settings()
    };
    let mut drive = Drive::new(settings, 1e-4);
    let omega = TAU * settings.resonance_hz;
    let stiffness = settings.load_share * (1.0 - settings.load_share) * omega * omega;
    let deflection = settings.coulomb_mm_per_s2 / stiffness;
    let mut command = 0.0;
    for velocity in [5.0, -5.0, 5.0] {
        for _ in 0..10_000 {
            command += velocity * 1e-4;
            drive.cycle(command, drive.position(), 1.0);
        }
        // The encoder is on the motor: the load follows behind by its friction and in negative travel by the play.
        let behind = drive.load_position() - drive.position();
        let needed = if velocity > 0.0 { -deflection } else { 0.008 + deflection };
        assert!((behind - needed).abs() < 0.01 * needed.abs(), "{velocity}: {behind}, needed {needed}");
    }
}

/// In the play the load rests: the motor travels its width before the load follows.
#[test]
fn the_load_rests_while_the_motor_crosses_the_play() {
    // Stiff friction: the load hardly swings back.
    let settings = DriveSettings { gear_play_mm: 0.05, presliding_mm: 1e-4, ..Variant::Worn.settings() };
    let mut drive = Drive::new(settings, 1e-4);
    let (mut command, mut motor, mut load) = (0.0, f64::MIN, f64::MIN);
    let mut crossed = None;
    for k in 0..20_000 {
        command += if k < 10_000 { 1e-4 } else { -1e-4 };
        drive.cycle(command, drive.position(), 1.0);
        motor = motor.max(drive.motor_position());
        load = load.max(drive.load_position());
        if crossed.is_none() && drive.load_position() < load - 1e-3 {
            crossed = Some(motor - drive.motor_position());
        }
    }
    // The spring turns round within twice its deflection by the load's friction, 975 mm/s² or 16 µm at most.
    let crossed = crossed.unwrap();
    assert!((0.05..0.05 + 0.034).contains(&crossed), "{crossed}");
}

#[test]
fn every_variant_is_stable_and_damped_by_itself_on_every_axis() {
    for variant in Variant::ALL {
        for axis in Axis::ALL {
            for period_s in [1e-4, 1e-3] {
                let varied = variant.settings().varied(&super::super::variation::Variation::of(axis));
                // Without feed-forward of the velocity, which lifts every loop's response.
                let loops = DriveSettings { velocity_feed_forward: 0.0, ..linear(varied) };
                let peak =
                    (1..2000).map(|k| response(&loops, period_s, 0.25 * f64::from(k)).load.abs()).fold(0.0, f64::max);
                let [late, later] = after_a_step(varied, period_s);
                println!("{} {axis:?} {period_s}: peak {peak:.3}, left {late:.2e} {later:.2e} mm", variant.name());
                assert!(peak < 1.3, "{} {axis:?} {period_s}: peak {peak}", variant.name());
                assert!(late < 2e-3 && later < 2e-4, "{} {axis:?} {period_s}: {late} {later}", variant.name());
            }
        }
    }
}

/// Extent of the load's motion about half a second and two seconds after a step of 0.1 mm, mm.
fn after_a_step(settings: DriveSettings, period_s: f64) -> [f64; 2] {
    let mut drive = Drive::new(settings, period_s);
    let mut extent = |seconds: f64| {
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for _ in 0..(seconds / period_s) as usize {
            drive.cycle(0.1, drive.position(), 1.0);
            low = low.min(drive.load_position());
            high = high.max(drive.load_position());
        }
        high - low
    };
    extent(0.45);
    let late = extent(0.1);
    extent(1.4);
    [late, extent(0.1)]
}

#[test]
fn absurd_commands_leave_two_masses_finite() {
    for variant in Variant::ALL {
        let mut drive = Drive::new(variant.settings(), 1e-4);
        for bad in [f64::MAX, f64::NAN, f64::MIN, f64::MAX, f64::INFINITY, 1e200, 0.0] {
            drive.cycle(bad, drive.position(), 2.5);
            assert!(drive.position().is_finite() && drive.load_position().is_finite() && drive.velocity().is_finite());
        }
        for _ in 0..80_000 {
            drive.cycle(0.0, drive.position(), 1.0);
        }
        assert!(drive.position().abs() < 1e-3, "{}: {}", variant.name(), drive.position());
        for position in [1e300, -1e300] {
            drive.rest_at(position);
            drive.cycle(position, position, 1000.0);
            assert!(drive.position().is_finite() && drive.velocity().is_finite());
        }
    }
}

/// Without friction a force on the load deflects the spring while the motor stays where it is commanded.
#[test]
fn a_side_load_deflects_the_spring() {
    let settings = DriveSettings { resonance_hz: 60.0, viscous_per_s: 0.0, ..linear(Variant::Soft.settings()) };
    let mut drive = Drive::new(settings, 1e-3);
    let omega = TAU * settings.resonance_hz;
    let stiffness = settings.load_share * (1.0 - settings.load_share) * omega * omega;
    for side_load in [300.0, -150.0, 0.0] {
        drive.push(side_load);
        (0..4000).for_each(|_| drive.cycle(1.0, drive.position(), 1.0));
        let (motor, load) = (drive.position() - 1.0, drive.load_position() - 1.0);
        assert!(motor.abs() < 1e-9 && (load - side_load / stiffness).abs() < 1e-9, "{side_load}: {motor} {load}");
    }
}
