//! Both runs side by side: figures, JSON, summary.

use super::simulate::{self, Run};
use super::spindle::sum;
use super::{Grinding, Linkage};
use anyhow::Result;
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt;
use std::time::Instant;
use trueaxis::roundness::{ErrorMotion, GaugeFlags};

/// What grinding without and with correction gave.
#[derive(Debug)]
pub struct Outcome {
    /// Correction off, the gauge measuring.
    pub uncorrected: Run,
    /// Correction on.
    pub corrected: Run,
    /// Error motion of the corrected pin's centre as it is, X and Y: that of the spindle, and the eccentricity with which
    /// the pin has been ground.
    pub motion: [ErrorMotion<f64>; 2],
    /// Motion of that centre over θ in a mean revolution, [R_X, R_Y], µm.
    pub orbit: Vec<[f64; 2]>,
    wall_s: f64,
}

/// Grinds twice with the same seed. `progress` gets the fraction done, 0 to 1.
///
/// # Errors
/// As [`simulate::run`].
pub fn simulate(grinding: &Grinding, progress: &mut dyn FnMut(f64)) -> Result<Outcome> {
    let started = Instant::now();
    let turns = f64::from(grinding.revolutions.max(1));
    let mut cycles = 0u32;
    let mut one = |corrected: bool| {
        simulate::run(grinding, corrected, &mut |moment| {
            cycles = cycles.wrapping_add(1);
            if cycles.is_multiple_of(4096) {
                progress(0.5 * ((moment.turns / turns).clamp(0.0, 1.0) + if corrected { 1.0 } else { 0.0 }));
            }
        })
    };
    let (uncorrected, corrected) = (one(false)?, one(true)?);
    Ok(Outcome {
        motion: true_motion(grinding, &corrected)?,
        orbit: true_orbit(grinding, &corrected)?,
        uncorrected,
        corrected,
        wall_s: started.elapsed().as_secs_f64(),
    })
}

/// Spindle angle at an angle of the surface, by fixed-point iteration of θ = α + β(α).
fn alpha_at(linkage: &Linkage, theta: f64) -> f64 {
    (0..60).fold(theta, |alpha, _| theta - linkage.beta(alpha))
}

/// Points over θ at which the true motion is evaluated.
const MOTION_POINTS: usize = 1024;

/// Motion of the pin's centre over θ in a mean revolution, [R_X, R_Y], µm.
///
/// The first harmonic a cos s + b sin s of the pin's surface is a displacement of its centre, which turns with it:
/// R_Y += a cos α + b sin α, R_X += b cos α − a sin α.
fn true_orbit(grinding: &Grinding, run: &Run) -> Result<Vec<[f64; 2]>> {
    let linkage = Linkage::of(grinding.gauge()?);
    let motion = &grinding.process.motion;
    let [a, b] = run.average.get(1).copied().unwrap_or_default();
    let at = |n: usize| {
        let alpha = alpha_at(&linkage, TAU * n as f64 / MOTION_POINTS as f64);
        let (sin, cos) = alpha.sin_cos();
        let ground = [b * cos - a * sin, a * cos + b * sin];
        std::array::from_fn(|i| {
            ground[i] + sum(&motion.eccentricity[i..=i], alpha) + sum(&motion.synchronous[i], alpha)
        })
    };
    Ok((0..MOTION_POINTS).map(at).collect())
}

/// Figures of the true motion over the window of the gauge, by their definitions; white noise left out.
fn true_motion(grinding: &Grinding, run: &Run) -> Result<[ErrorMotion<f64>; 2]> {
    let gauge = grinding.gauge()?;
    let linkage = Linkage::of(gauge);
    let window = u32::from(gauge.revolutions).min(grinding.revolutions);
    let orbit = true_orbit(grinding, run)?;
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let of = |i: usize| {
        let n = MOTION_POINTS as f64;
        let (mut mean, mut a, mut b) = (0.0, 0.0, 0.0);
        for (k, point) in orbit.iter().enumerate() {
            let (sin, cos) = (TAU * k as f64 / n).sin_cos();
            mean += point[i] / n;
            a += 2.0 * point[i] * cos / n;
            b += 2.0 * point[i] * sin / n;
        }
        let (mut left, mut widest, mut total) = (Vec::new(), 0.0_f64, [f64::INFINITY, f64::NEG_INFINITY]);
        for (k, point) in orbit.iter().enumerate() {
            let theta = TAU * k as f64 / n;
            let (sin, cos) = theta.sin_cos();
            let rest = point[i] - mean - a * cos - b * sin;
            left.push(rest);
            let alpha = alpha_at(&linkage, theta);
            let turn = |m: u32| alpha + TAU * f64::from(grinding.revolutions - window + m);
            let [low, high] = range(&mut (0..window).map(|m| sum(&grinding.process.motion.asynchronous[i], turn(m))));
            widest = widest.max(high - low);
            total = [total[0].min(rest + low), total[1].max(rest + high)];
        }
        let [low, high] = range(&mut left.iter().copied());
        ErrorMotion {
            synchronous_um: high - low,
            asynchronous_um: widest,
            once_per_revolution_um: [a, b],
            total_um: total[1] - total[0],
        }
    };
    Ok([of(0), of(1)])
}

#[derive(Serialize)]
struct RevolutionJson {
    imprint_um: f64,
    roundness_um: f64,
    gauge_imprint_um: Option<f64>,
    gauge_roundness_um: Option<f64>,
}

#[derive(Serialize)]
struct RunJson {
    imprint_um: f64,
    roundness_um: f64,
    evaluated: u32,
    skipped: u32,
    discarded: u32,
    limited_cycles: u64,
    per_revolution: Vec<RevolutionJson>,
}

#[derive(Serialize)]
struct MotionJson {
    x: ErrorMotion<f64>,
    y: ErrorMotion<f64>,
}

#[derive(Serialize)]
struct SpindleJson {
    #[serde(rename = "true")]
    truth: MotionJson,
    gauge: Option<MotionJson>,
}

/// What `--json` prints.
#[derive(Serialize)]
pub struct Json {
    machine: String,
    revolutions: u32,
    points: u16,
    harmonics: [u16; 2],
    servo_rate_hz: f64,
    speed_rpm: f64,
    gain: f64,
    cycles: u64,
    cycles_of_work: usize,
    averaged_revolutions: usize,
    uncorrected: RunJson,
    corrected: RunJson,
    imprint_ratio: f64,
    spindle: SpindleJson,
    limits_exceeded: u64,
    wall_s: f64,
}

fn of_run(run: &Run) -> RunJson {
    let per_revolution = run.revolutions.iter().map(|r| RevolutionJson {
        imprint_um: r.imprint_um,
        roundness_um: r.roundness_um,
        gauge_imprint_um: r.gauge_imprint_um,
        gauge_roundness_um: r.gauge_roundness_um,
    });
    RunJson {
        imprint_um: run.imprint_um,
        roundness_um: run.roundness_um,
        evaluated: run.counts.evaluated,
        skipped: run.counts.skipped,
        discarded: run.counts.discarded,
        limited_cycles: run.limited_cycles,
        per_revolution: per_revolution.collect(),
    }
}

impl Outcome {
    /// Synchronous imprint with correction over that without.
    pub fn imprint_ratio(&self) -> f64 {
        self.corrected.imprint_um / self.uncorrected.imprint_um
    }

    /// Cycles of both runs in which a correction passed a limit.
    pub fn limits_exceeded(&self) -> u64 {
        self.uncorrected.limits_exceeded + self.corrected.limits_exceeded
    }

    /// The outcome as one JSON document.
    ///
    /// # Errors
    /// The machine has no gauge.
    pub fn json(&self, grinding: &Grinding) -> Result<Json> {
        let gauge = grinding.gauge()?;
        let infeed = gauge.infeed.as_ref();
        let [x, y] = self.motion;
        let measured = self.corrected.evaluation.filter(|e| e.revolutions > 0);
        Ok(Json {
            machine: grinding.machine.settings.name.as_str().into(),
            revolutions: grinding.revolutions,
            points: gauge.points,
            harmonics: infeed.map_or([0; 2], |infeed| [infeed.band.first, infeed.band.last]),
            servo_rate_hz: grinding.rate_hz,
            speed_rpm: grinding.speed_rpm,
            gain: infeed.map_or(0.0, |infeed| infeed.gain),
            cycles: self.corrected.cycles,
            cycles_of_work: self.corrected.cycles_of_work,
            averaged_revolutions: self.corrected.averaged,
            uncorrected: of_run(&self.uncorrected),
            corrected: of_run(&self.corrected),
            imprint_ratio: self.imprint_ratio(),
            spindle: SpindleJson { truth: MotionJson { x, y }, gauge: measured.map(|e| MotionJson { x: e.x, y: e.y }) },
            limits_exceeded: self.limits_exceeded(),
            wall_s: self.wall_s,
        })
    }

    /// The summary for the console.
    pub fn summary<'o>(&'o self, grinding: &'o Grinding) -> Summary<'o> {
        Summary { outcome: self, grinding }
    }
}

/// Prints the outcome in plain words.
pub struct Summary<'o> {
    outcome: &'o Outcome,
    grinding: &'o Grinding,
}

impl fmt::Display for Summary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (g, o) = (self.grinding, self.outcome);
        let Outcome { uncorrected: before, corrected: after, .. } = o;
        let settings = &g.machine.settings;
        let Some((gauge, infeed)) = settings.roundness.as_ref().and_then(|r| Some((r, r.infeed.as_ref()?))) else {
            return Ok(());
        };
        writeln!(f, "machine  {} ({})", settings.name, settings.chain)?;
        writeln!(
            f,
            "grinding {} revolutions at {:.4} rpm, {} Hz: {} servo cycles",
            g.revolutions, g.speed_rpm, g.rate_hz, after.cycles
        )?;
        writeln!(
            f,
            "gauge    {} points, harmonics {} to {} corrected, gain {}; {} cycles of work on a revolution of {:.0}",
            gauge.points,
            infeed.band.first,
            infeed.band.last,
            infeed.gain,
            after.cycles_of_work,
            60.0 * g.rate_hz / g.speed_rpm
        )?;
        writeln!(f)?;
        writeln!(f, "true surface, last {} revolutions     synchronous imprint    out of roundness", after.averaged)?;
        for (name, run) in [("without correction", before), ("with correction", after)] {
            writeln!(f, "  {name:<36} {:>9.4} µm rms {:>13.3} µm", run.imprint_um, run.roundness_um)?;
        }
        writeln!(f, "  {:<36} {:>9.1} %", "what is left", 100.0 * o.imprint_ratio())?;
        writeln!(f)?;
        writeln!(f, "error motion of the pin's centre        synchronous  asynchronous  once per revolution")?;
        let mut row = |name: &str, motion: &ErrorMotion<f64>| {
            let [a, b] = motion.once_per_revolution_um;
            let (synchronous, asynchronous) = (motion.synchronous_um, motion.asynchronous_um);
            writeln!(f, "  {name:<36} {synchronous:>8.3} µm   {asynchronous:>8.3} µm  {:>16.3} µm", a.hypot(b))
        };
        let [x, y] = &o.motion;
        row("X, across probe 1, true", x)?;
        if let Some(measured) = after.evaluation.filter(|e| e.revolutions > 0) {
            row("X, as the gauge sees it", &measured.x)?;
            row("Y, along probe 1, true", y)?;
            row("Y, as the gauge sees it", &measured.y)?;
        } else {
            row("Y, along probe 1, true", y)?;
        }
        writeln!(f)?;
        writeln!(
            f,
            "revolutions evaluated {}, skipped {}, discarded {}; cycles beyond the correction's limits {}",
            after.counts.evaluated,
            after.counts.skipped,
            after.counts.discarded,
            o.limits_exceeded()
        )?;
        if after.flags.has(GaugeFlags::INFEED_FROZEN) {
            writeln!(f, "note     the infeed correction was frozen at least once: it was limited, or near its bound")?;
        }
        writeln!(f, "two runs in {:.1} s", o.wall_s)
    }
}
