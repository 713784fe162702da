//! Contour feedback on drives with a resonance that its margins do not contain: the watch on harm keeps the contour error
//! near that without feedback.

use super::*;
use crate::contour::{Segment, Span, convert};
use crate::machine::{AxisServo, DriveFigures, FeedbackSettings};
use crate::telemetry::Status;
use core::f64::consts::TAU;
use std::format;
use std::string::String;

const DRIVE: DriveFigures = DriveFigures {
    velocity_feed_forward: 0.93,
    lowest_resonance_hz: 5000.0,
    ..DriveFigures::with_defaults(110.0, 800.0, 0.006)
};
const RADIUS_MM: f64 = 25.0;
const FEED_MM_PER_S: f64 = 25.0;
/// Longest step of the mechanics, s.
const STEP_S: f64 = 2e-5;

/// Mechanics of both axes: frequency and damping of the load against the motor, its share of the mass.
#[derive(Clone, Copy, Debug)]
struct Mechanics {
    hz: f64,
    damping: f64,
    share: f64,
    period_s: f64,
}

/// Motor and load with a spring between them; velocity loop on the motor, friction and the scale on the load. A command
/// arrives one period late.
struct Axis {
    of: Mechanics,
    gain_per_s: f64,
    commands: [f64; 3],
    motor: [f64; 2],
    load: [f64; 2],
    integral: f64,
    force: f64,
    friction: f64,
}

impl Axis {
    fn at(position: f64, gain_per_s: f64, of: Mechanics) -> Axis {
        let rest = [position, 0.0];
        let commands = [position; 3];
        Axis { of, gain_per_s, commands, motor: rest, load: rest, integral: 0.0, force: 0.0, friction: 0.0 }
    }

    /// Position in steps of 50 nm.
    fn reading(&self) -> f64 {
        (self.load[0] / 5e-5).round() * 5e-5
    }

    fn advance(&mut self, command: f64) {
        let Mechanics { hz, damping, share, period_s } = self.of;
        self.commands = [command, self.commands[0], self.commands[1]];
        let [_, arrived, before] = self.commands;
        let fed = DRIVE.velocity_feed_forward * (arrived - before) / period_s;
        let wanted = self.gain_per_s * (before - self.reading()) + fed;
        let h = STEP_S;
        for _ in 0..(period_s / h).round() as u32 {
            let error = wanted - self.motor[1];
            self.integral += error * h / DRIVE.reset_time_s;
            let asked = DRIVE.velocity_gain_per_s * (error + self.integral);
            self.force += (1.0 - (-h / DRIVE.current_loop_s).exp()) * (asked - self.force);
            let omega = TAU * hz;
            let [stretch, rate] = [0, 1].map(|k| self.motor[k] - self.load[k]);
            let spring = share * (omega * omega * stretch + 2.0 * damping * omega * rate);
            let velocity = self.load[1];
            let travel = velocity * h / 0.006;
            self.friction = (self.friction + travel) / (1.0 + travel.abs());
            let sliding = 420.0 * (1.0 + 0.3 / (1.0 + (velocity / 2.0).powi(2)));
            let drag = sliding * self.friction + 4.0 * velocity;
            self.motor[1] += (self.force - spring) / (1.0 - share) * h;
            self.load[1] += (spring - drag) / share * h;
            self.motor[0] += self.motor[1] * h;
            self.load[0] += self.load[1] * h;
        }
    }
}

/// Configuration with a level of the watches, mm; `None`: without feedback.
fn servo_of(watch_mm: Option<f64>, period_s: f64) -> &'static Loop {
    let mut machine = machine(|axis| axis.servo = AxisServo { drive: Some(DRIVE), ..AxisServo::default() });
    machine.contour.feedback = watch_mm.map(|watch_mm| FeedbackSettings { watch_mm, ..FeedbackSettings::default() });
    let config = Config {
        machine: Box::leak(Box::new(machine)),
        grids: &[],
        machine_id: 0,
        tables_crc: 0,
        period_ns: (period_s * 1e9).round() as u32,
        inverse_passes: 1,
        method: Method::Guarded,
    };
    Box::leak(Box::new(config.build(|_| None::<&[Row]>, Default::default()).unwrap()))
}

/// Runs a circle about (50, 50) for 2 s, past a reversal. Returns the contour error of every cycle, µm, and when the feedback was out, s.
fn circle(of: Mechanics, watch_mm: Option<f64>) -> (Vec<f64>, Option<f64>) {
    let servo = servo_of(watch_mm, of.period_s);
    let start = [50.0 + RADIUS_MM, 50.0, 0.0].into();
    let mut spans: Vec<Span<f64, f64>> = Vec::new();
    let arc =
        Segment::Arc { start, end: start, center: [50.0, 50.0, 0.0].into(), normal: [0.0, 0.0, 1.0].into(), turns: 0 };
    convert(&arc, 0, [0.0, 0.0, 1.0], |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
    let path = Path::new(&spans, 0, false);
    let mut axes = [Axis::at(50.0 + RADIUS_MM, 110.0, of), Axis::at(50.0, 106.7, of)];
    let (mut state, mut velocity, mut angle) = (servo.start(), 0.0_f64, 0.0_f64);
    let (mut errors, mut out) = (Vec::new(), None);
    for cycle in 0..(2.0 / of.period_s) as u32 {
        velocity = (velocity + 1000.0 * of.period_s).min(FEED_MM_PER_S);
        angle += velocity * of.period_s / RADIUS_MM;
        let command = [50.0 + RADIUS_MM * angle.cos(), 50.0 + RADIUS_MM * angle.sin(), 0.0];
        let feedback = [axes[0].reading(), axes[1].reading(), 0.0];
        errors.push(1e3 * ((axes[0].load[0] - 50.0).hypot(axes[1].load[0] - 50.0) - RADIUS_MM).abs());
        let given = Input { feedback, elapsed_ns: servo.period_ns(), ..input(command) };
        let output = servo.step(&mut state, &given, path.at(0, angle / TAU), ());
        if output.record.status.has(Status::FEEDBACK_OUT) {
            out.get_or_insert(f64::from(cycle) * of.period_s);
        }
        axes.iter_mut().zip(output.drive).for_each(|(axis, drive)| axis.advance(drive));
    }
    (errors, out)
}

/// Largest error from 0.1 s on.
fn largest(errors: &[f64]) -> f64 {
    errors[errors.len() / 20..].iter().copied().fold(0.0, f64::max)
}

/// Drives that are sound alone, whose resonance the feedback excites.
const EXCITED: [Mechanics; 2] = [
    Mechanics { hz: 120.0, damping: 0.02, share: 0.2, period_s: 1e-4 },
    Mechanics { hz: 103.0, damping: 0.036, share: 0.3, period_s: 1e-3 },
];

#[test]
fn a_resonance_that_the_feedback_excites_stays_within_the_error_without_feedback() {
    for (k, of) in EXCITED.into_iter().enumerate() {
        let (without, _) = circle(of, None);
        let (unwatched, _) = circle(of, Some(1.0));
        let (watched, out) = circle(of, Some(0.01));
        if k == 0 && std::env::var_os("UPDATE_DOCS").is_some() {
            let traces =
                [("without feedback", &without), ("feedback unwatched", &unwatched), ("with the watch", &watched)];
            let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/watch.svg");
            std::fs::write(file, picture(&traces, of.period_s)).unwrap();
        }
        let from = without.len() / 20;
        let harm = 1.25 * largest(&without);
        let begins = from + unwatched[from..].iter().position(|e| *e > harm).unwrap();
        // The watch changes no bit before it takes K_p out.
        let acts = watched.iter().zip(&unwatched).position(|(own, other)| own != other).unwrap();
        let [begins, acts] = [begins, acts].map(|cycle| cycle as f64 * of.period_s);
        let [without, unwatched, watched] = [without, unwatched, watched].map(|errors| largest(&errors));
        let case = format!("{of:?}: {without}, {unwatched}, {watched} µm; harm {begins} s, K_p {acts} s, out {out:?}");
        std::println!("{case}");
        assert!(unwatched > 8.0 * without, "{case}");
        assert!(watched < 1.25 * without, "{case}");
        assert!(acts < begins + 0.05, "{case}");
        assert!(out.is_some(), "{case}");
    }
}

/// Contour errors over time, µm: of every 5 ms the largest.
fn picture(traces: &[(&str, &Vec<f64>)], period_s: f64) -> String {
    const COLOURS: [&str; 3] = ["#1b7837", "#b2182b", "#2166ac"];
    let (x, y) = (|t: f64| 60.0 + 420.0 * t, |um: f64| 170.0 - 80.0 * um.max(0.1).log10());
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 920 290\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"920\" height=\"290\" fill=\"#fff\"/>\n",
    );
    for um in [0.1, 1.0, 10.0, 100.0] {
        let at = y(um);
        svg += &format!("<path d=\"M60 {at}H900\" stroke=\"#ccc\"/><text x=\"8\" y=\"{}\">{um} µm</text>\n", at + 4.0);
    }
    for quarter in 0..=8 {
        let t = 0.25 * f64::from(quarter);
        svg += &format!("<text x=\"{}\" y=\"275\" text-anchor=\"middle\">{t} s</text>\n", x(t));
    }
    for (k, ((name, errors), colour)) in traces.iter().zip(COLOURS).enumerate() {
        let points = errors.chunks((5e-3 / period_s).round() as usize).enumerate().map(|(bin, errors)| {
            let largest = errors.iter().copied().fold(0.0, f64::max);
            format!("{:.1},{:.1}", x(5e-3 * bin as f64), y(largest))
        });
        let points = points.collect::<Vec<_>>().join(" ");
        svg += &format!("<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>\n");
        svg += &format!("<text x=\"{}\" y=\"24\" fill=\"{colour}\">{name}</text>\n", 70 + 160 * k);
    }
    svg + "</svg>\n"
}

#[test]
fn without_harm_the_watch_changes_no_bit() {
    for period_s in [1e-4, 1e-3] {
        let stiff = Mechanics { hz: 300.0, damping: 0.1, share: 0.5, period_s };
        let [watched, unwatched] = [0.01, 1.0].map(|watch_mm| circle(stiff, Some(watch_mm)));
        assert_eq!(watched, unwatched);
    }
}
