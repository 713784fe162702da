//! The resonance of motor and load in a record of circles.
//!
//! Friction that reverses, starts and stops make the load swing on its spring. The velocity loop damps that swing and shifts
//! its frequency: a resonance of 120 Hz with 3 % damping rings on the `usual` drive of the simulator with 15 %. A decaying
//! sinusoid fitted to the ringing would therefore state the drive, not the mechanics, and two periods of it are too few. The
//! model of the drive instead gets a second mass, and its resonance ω_r (both masses free), damping ζ and share σ of the
//! load are fitted to the readings, together with all figures of drive and friction.
//!
//! 1. One mass is fitted: its residual is what a second mass must explain. If it is as small as the noise, there is nothing left.
//! 2. Plants of a grid of resonances, with a scale on the load and with an encoder on the motor, are compared with the record
//!    after one step of all figures.
//! 3. The best ones are fitted, first on every few samples. The better of scale and encoder counts; if both explain the
//!    record alike, the uncertainty includes their difference.
//!
//! **What the record does not determine** (share of the load, current loop, times within a cycle, Stribeck and viscous
//! friction) enters as prior knowledge, so that its uncertainty is part of that of the resonance.
//!
//! **Nothing is invented**: a resonance counts as found only if it explains more than the noise could, in both halves of the
//! record, and with standard uncertainties of at most a tenth of its frequency and a tenth of critical damping. That a record shows none does
//! not exclude one.
//!
//! Cost: some hundred to some thousand simulations of the parts of the record around reversals, starts and stops.

mod fit;
mod plant;

use super::parameters::{Problem, READING_LAG};
use super::record::Reversal;
use super::{Figure, FrictionRefusal, Identified, ROUGH_S, Record, STEP_S, UNKNOWN_S, problem};
use fit::{ALL, DAMPING, Data, Fit, LOWEST_HZ, Point, RESONANCE, SHARE, known};
use std::f64::consts::TAU;
use std::vec::Vec;

/// Highest resonance that is sought, Hz.
const HIGHEST_HZ: f64 = 400.0;
/// Samples of the record per period of the highest one.
const SAMPLES: f64 = 4.0;
/// From this share of the highest frequency on, a resonance found may stand in for one beyond the search.
const NEAR_END: f64 = 0.8;
/// Time before and after a reversal that counts, s.
const BEFORE_S: f64 = 0.02;
const AFTER_S: f64 = 0.25;
/// Time simulated before a stretch that counts, in 1/K_v.
const RUN_IN: f64 = 6.0;
/// Half of the time over which a motion in progress is averaged, s.
const MEAN_S: f64 = 0.01;
/// Quotient of two resonances of the grid, damping of its plants, and their shares of the load.
const NEXT: f64 = 1.2;
const TYPICAL_DAMPING: f64 = 0.05;
/// Number of plants of the grid that fits start from, for each place of the encoder, and the logarithm of the least quotient
/// of their resonances.
const STARTS: usize = 3;
const APART: f64 = 0.3;
/// Least noise that is assumed, mm.
const LEAST_NOISE_MM: f64 = 3e-7;
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];
/// Standard uncertainty of a reading's lag, dead time included, if the friction fit could not do without one, s.
const UNKNOWN_LAG_S: f64 = 2e-3;
/// Steps of the fits that decide where to search on.
const FEW: usize = 5;
/// A first fit whose squares are this many times those of the best one is not continued.
const HOPELESS: f64 = 4.0;
/// Variances by which the squares must fall for a resonance to be found.
const FOUND: f64 = 40.0;
/// Largest excess of neighbouring residuals over independent ones; an encoder's subdivisional error causes a few times.
const COLOURED: f64 = 12.0;
/// Share of that fall that each half of the record must contain.
const EACH_HALF: f64 = 0.1;
/// Standard uncertainties from what the model leaves out, such as commands that are held for a cycle: every start repeats such
/// errors, so that the residuals do not show how much they shift the frequency (relative) and the damping.
const MODEL_FREQUENCY: f64 = 0.02;
const MODEL_DAMPING: f64 = 0.02;
/// Largest relative standard uncertainty of a resonance.
const LOOSE: f64 = 0.1;
/// Largest standard uncertainty of its damping: axes have up to some 10 %, and a fit that leaves more open does not see the
/// ringing that would fix the frequency.
const BLURRED: f64 = 0.1;
/// A resonance with its figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// Frequency of motor and load against each other, both free, Hz.
    pub frequency_hz: Figure,
    /// Damping, share of critical.
    pub damping: Figure,
    /// Mass of the load over that of motor and load.
    pub load_share: Figure,
    /// Degrees of freedom of the standard errors.
    pub degrees_of_freedom: f64,
    /// Whether the readings are those of a scale on the load; `None`: an encoder on the motor explains them as well.
    pub on_load: Option<bool>,
}

impl Resonance {
    /// Whether the record determines the damping: it differs from 0 by more than two standard errors.
    pub fn is_damping_known(&self) -> bool {
        self.damping.standard_error.is_some_and(|error| self.damping.value > 2.0 * error)
    }
}

/// Why a record shows no resonance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoResonance {
    /// A second mass explains the readings no better than noise.
    NotSeen {
        /// Gain over the variance of a reading.
        gain: f64,
        /// Gain needed.
        needed: f64,
    },
    /// The best resonance is uncertain.
    Uncertain {
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Standard error, Hz.
        standard_error_hz: f64,
    },
    /// The damping of the best resonance is uncertain.
    Blurred {
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Standard error of the damping, share of critical.
        damping_error: f64,
    },
    /// The best resonance is near the end of what the record can show.
    OutOfRange {
        /// The end, Hz.
        limit_hz: f64,
    },
    /// The best resonance explains one part of the record only.
    OnePartOnly {
        /// Frequency, Hz.
        frequency_hz: f64,
    },
    /// Two masses leave errors that noise cannot explain.
    Misfit {
        /// Frequency of the best resonance, Hz.
        frequency_hz: f64,
        /// Root mean square of the residuals, mm.
        residual_rms: f64,
    },
    /// The fit does not settle.
    NoConvergence,
}

/// The mechanics of an axis as far as a record shows them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mechanics {
    /// The resonance, or why there is none.
    pub resonance: Result<Resonance, NoResonance>,
}

/// Finds the resonance of an axis whose friction is identified; `index` is the axis' index in the record.
///
/// # Errors
/// A record that [`super::identify`] would refuse before fitting.
pub(super) fn mechanics(
    record: &Record,
    found: &Identified,
    index: usize,
    on_step: &mut dyn FnMut(),
) -> Result<Mechanics, FrictionRefusal> {
    let turns = record.reversals()?;
    let index = index.min(1);
    let mut drive = found.drive;
    if found.drive_errors.is_some() {
        drive.dead_time_s = super::start::DRIVE.dead_time_s;
    }
    let more = [drive.current_loop_s, 0.5 * record.period_s, 0.0, TYPICAL_DAMPING, SHARES[0]];
    let mut start = Point { values: found.values, more, scale: None };
    let rests = record.rests(&record.axes[index]);
    let lag_s = match found.reading_lag_s.standard_error {
        Some(_) => UNKNOWN_LAG_S,
        None => record.period_s / 12_f64.sqrt(),
    };
    let read_after_s = record.read_after_s.filter(|_| found.drive_errors.is_some());
    // A lag that one mass needs would hide the second one; a stated time of reading stays.
    if read_after_s.is_none() {
        start.values.0[READING_LAG] = 0.0;
    }
    let run_in_s = (RUN_IN / drive.position_gain_per_s).clamp(0.3, 0.8);
    let data = |step_s: f64| {
        let (mut problem, _) = problem(record, &record.axes[index], &turns[index], Some(drive), step_s);
        problem.read_after_s = read_after_s;
        let stretches = stretches(record, &turns[index], &problem, rests, run_in_s);
        let begins = stretches.iter().map(|[begin, ..]| (*begin > 0 || !rests).then(|| motion(&problem, *begin)));
        let begins = begins.collect();
        let before = known(&start, record.period_s, lag_s);
        let highest_hz = HIGHEST_HZ.min(1.0 / (SAMPLES * record.period_s));
        Data { problem, stretches, begins, before, highest_hz, rests }
    };
    Ok(search([&data(ROUGH_S), &data(STEP_S)], start, on_step))
}

/// Stretches of the record around reversals, starts, stops and changes of speed.
fn stretches(record: &Record, turns: &[Reversal], problem: &Problem, rests: bool, run_in_s: f64) -> Vec<[usize; 3]> {
    let even = record.even(turns);
    let every = (problem.sample_s() / record.period_s).round().max(1.0) as usize;
    let samples = |seconds: f64| (seconds / problem.sample_s()).round() as usize;
    let count = problem.error.len();
    let mut counts: Vec<bool> = (0..count).map(|k| !even.get(k * every).copied().unwrap_or(true)).collect();
    for turn in turns {
        let at = turn.index / every;
        let [from, to] = [at.saturating_sub(samples(BEFORE_S)), (at + samples(AFTER_S)).min(count)];
        counts[from.min(to)..to].iter_mut().for_each(|counts| *counts = true);
    }
    let first = if rests { 0 } else { samples(UNKNOWN_S) };
    let mut stretches: Vec<[usize; 3]> = Vec::new();
    for k in (first..count).filter(|&k| counts[k]) {
        match stretches.last_mut() {
            Some([_, _, end]) if *end == k => *end = k + 1,
            _ => stretches.push([k.saturating_sub(samples(run_in_s)), k, k + 1]),
        }
    }
    stretches
}

/// Position and velocity read at a sample.
fn motion(problem: &Problem, at: usize) -> [f64; 2] {
    let reach = ((MEAN_S / problem.sample_s()) as usize).max(1);
    let reading = |k: usize| problem.command[k * problem.fine] - problem.error[k];
    let reach = reach.min(problem.error.len() - 1 - at);
    let mean = |from: usize, to: usize| (from..=to).map(reading).sum::<f64>() / (to - from + 1) as f64;
    if at < reach || reach == 0 {
        // At the start of the record there is only what follows.
        let [near, far] = [mean(at, at + reach), mean(at + reach, (at + 2 * reach).min(problem.error.len() - 1))];
        let velocity = (far - near) / (reach.max(1) as f64 * problem.sample_s());
        return [near - 0.5 * reach as f64 * problem.sample_s() * velocity, velocity];
    }
    let velocity = (mean(at, at + reach) - mean(at - reach, at)) / (reach as f64 * problem.sample_s());
    [mean(at - reach, at + reach), velocity]
}

/// Resonances of the grid, Hz.
fn grid(highest_hz: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(1.2 * LOWEST_HZ), |hz| Some(NEXT * hz)).take_while(move |hz| *hz <= highest_hz)
}

/// Variance of the white part of the readings, mm²: from their third differences, which smooth motion does not reach.
fn noise(problem: &Problem) -> f64 {
    let third = |e: &[f64]| (e[3] - 3.0 * e[2] + 3.0 * e[1] - e[0]).powi(2);
    let mut squares: Vec<f64> = problem.error.windows(4).map(third).collect();
    let middle = squares.len() / 2;
    // The median of squares of normal deviates is 0.455 of their mean; the coefficients' squares add up to 20.
    (*squares.select_nth_unstable_by(middle, f64::total_cmp).1 / (0.455 * 20.0)).max(LEAST_NOISE_MM * LEAST_NOISE_MM)
}

fn search([rough, fine]: [&Data; 2], start: Point, on_step: &mut dyn FnMut()) -> Mechanics {
    let none = |why| Mechanics { resonance: Err(why) };
    let residuals = rough.residuals(&start);
    let crude = residuals.iter().map(|r| r * r).sum::<f64>();
    if residuals.len() < 2 * ALL || crude <= 0.0 || !crude.is_finite() {
        return none(NoResonance::NoConvergence);
    }
    let variance = noise(&rough.problem);
    let free = rough.free(None);
    let rigid = fit::fit(rough, start, &free, variance, 2 * FEW, on_step);
    // A second mass cannot explain more than what exceeds the noise.
    let [own, inflation] = rigid.variance(rough);
    let largest = rigid.residuals.len() as f64 * (own - variance) / (variance * inflation);
    if largest < FOUND {
        let why = NoResonance::NotSeen { gain: largest.max(0.0), needed: FOUND };
        return Mechanics { resonance: Err(why) };
    }
    let mut fits: Vec<Fit> = Vec::new();
    for scale in [false, true] {
        let plants = grid(rough.highest_hz).flat_map(|hz| SHARES.map(|share| (hz, share)));
        let mut tried: Vec<(f64, Point)> =
            plants.map(|(hz, share)| left(rough, &rigid, hz, (TYPICAL_DAMPING, share, scale))).collect();
        tried.retain(|(left, _)| left.is_finite());
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut begun: Vec<Fit> = Vec::new();
        let mut starts: Vec<f64> = Vec::new();
        for (_, at) in tried {
            let omega = at.get(RESONANCE);
            if starts.len() == STARTS || starts.iter().any(|other| (other / omega).ln().abs() < APART) {
                continue;
            }
            starts.push(omega);
            // From the figures of the friction fit, not from those that one mass needed in place of the second.
            let at = Point {
                values: start.values,
                more: [start.more[0], start.more[1], omega, at.more[3], at.more[4]],
                ..at
            };
            begun.push(fit::fit(rough, at, &rough.free(Some(scale)), variance, FEW, on_step));
        }
        begun.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let go_on = begun
            .into_iter()
            .take(2)
            .map(|begun| fit::fit(rough, begun.at, &rough.free(Some(scale)), variance, 3 * FEW, on_step));
        fits.extend(go_on.min_by(|a, b| a.cost.total_cmp(&b.cost)));
    }
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let Some(limit) = fits.first().map(|first| HOPELESS * first.cost) else { return none(NoResonance::NoConvergence) };
    fits.retain(|fit| fit.cost <= limit);
    let mut last: Vec<Fit> = Vec::new();
    for begun in &fits {
        last.push(fit::fit(fine, begun.at, &fine.free(begun.at.scale), variance, usize::MAX, on_step));
    }
    last.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let one = fit::fit(fine, rigid.at, &free, variance, FEW, on_step);
    let Some(first) = last.first() else { return none(NoResonance::NoConvergence) };
    Mechanics { resonance: judged(fine, &one, first, last.get(1)) }
}

/// What is left of the squares of a plant with a second mass after one step of the figures of a rigid fit, and that plant.
fn left(data: &Data, rigid: &Fit, hz: f64, (damping, share, scale): (f64, f64, bool)) -> (f64, Point) {
    let [current, age, ..] = rigid.at.more;
    let at = Point { more: [current, age, TAU * hz, damping, share], scale: Some(scale), ..rigid.at };
    (rigid.linear.left(&data.residuals(&at)), at)
}

/// The resonance of the best fit, if it counts as found; `other` has its encoder on the other side.
fn judged(data: &Data, rigid: &Fit, best: &Fit, other: Option<&Fit>) -> Result<Resonance, NoResonance> {
    let [variance, inflation] = best.variance(data);
    let halves = [rigid.halves(data), best.halves(data)];
    let gains: [f64; 2] = std::array::from_fn(|i| halves[0][i] - halves[1][i]);
    let gain = (gains[0] + gains[1]) / (variance * inflation);
    if gain.is_nan() || gain < FOUND {
        return Err(NoResonance::NotSeen { gain: gain.max(0.0), needed: FOUND });
    }
    let omega = best.at.get(RESONANCE);
    let frequency_hz = omega / TAU;
    if frequency_hz >= NEAR_END * data.highest_hz {
        return Err(NoResonance::OutOfRange { limit_hz: NEAR_END * data.highest_hz });
    }
    if frequency_hz <= 1.02 * LOWEST_HZ {
        return Err(NoResonance::OutOfRange { limit_hz: LOWEST_HZ });
    }
    if gains[0].min(gains[1]) < EACH_HALF * (gains[0] + gains[1]) {
        return Err(NoResonance::OnePartOnly { frequency_hz });
    }
    if !best.settled {
        return Err(NoResonance::NoConvergence);
    }
    if inflation > COLOURED {
        return Err(NoResonance::Misfit { frequency_hz, residual_rms: variance.sqrt() });
    }
    // Weight of the other side of the encoder.
    let weight = other.map_or(0.0, |other| {
        let worse = (other.cost - best.cost) / (variance * inflation);
        1.0 / (1.0 + (0.5 * worse).exp())
    });
    let errors = best.errors(data);
    let others = other.map(|other| other.errors(data));
    let figure = |parameter: usize, scale: f64, of_model: f64| {
        let (own, own_error) = (best.at.get(parameter), errors[parameter]);
        let (value, error) = match (other, &others) {
            (Some(fit), Some(errors)) if weight > 1e-3 => {
                let (there, error) = (fit.at.get(parameter), errors[parameter]);
                let apart = weight * (1.0 - weight) * (there - own).powi(2);
                let squares = (1.0 - weight) * own_error.powi(2) + weight * error.powi(2) + apart;
                ((1.0 - weight) * own + weight * there, squares.sqrt())
            }
            _ => (own, own_error),
        };
        Figure { value: scale * value, standard_error: Some((scale * error).hypot(of_model)) }
    };
    let frequency = figure(RESONANCE, 1.0 / TAU, MODEL_FREQUENCY * frequency_hz);
    let standard_error_hz = frequency.standard_error.unwrap_or(f64::INFINITY);
    if standard_error_hz.is_nan() || standard_error_hz > LOOSE * frequency.value {
        return Err(NoResonance::Uncertain { frequency_hz: frequency.value, standard_error_hz });
    }
    let damping = figure(DAMPING, 1.0, MODEL_DAMPING);
    let damping_error = damping.standard_error.unwrap_or(f64::INFINITY);
    if damping_error.is_nan() || damping_error > BLURRED {
        return Err(NoResonance::Blurred { frequency_hz: frequency.value, damping_error });
    }
    Ok(Resonance {
        frequency_hz: frequency,
        damping,
        load_share: figure(SHARE, 1.0, 0.0),
        degrees_of_freedom: best.degrees_of_freedom(data),
        on_load: best.at.scale.filter(|_| weight < 0.05),
    })
}
