//! Friction of an axis, and the figures of its drive, from recorded circles.
//!
//! Where an axis turns, its friction changes sign, and the axis stands off its path until the velocity loop's integrator
//! has supplied the other force: a spike in the following error at every quadrant. The model of the drive
//!
//! ```text
//! r  = K_v (c − x) + k_ff c'                        position loop with velocity feed-forward
//! v' = K_vp (r − v + 1/τ ∫(r − v) dt) − F − d v     velocity loop behind the current loop, mass, friction
//! F  = F_c (1 + s/(1 + (v/v_s)²)) f                 Coulomb friction, Stribeck share
//! f' = (v − |v| f)/z                                pre-sliding (Dahl): friction reverses by 63 % over the travel z
//! ```
//!
//! is followed along the recorded commands c, and its following error c − x fitted to the recorded one by least squares:
//! F_c/K_vp (mm/s), s, v_s (mm/s), z (mm), d/K_vp, how late the reading is, and, where the drive's figures are not known,
//! K_v, K_vp, τ and k_ff. The simulation is the record's own input put through the model, so that the fit needs no record
//! with a learned correction in between: its result is the waveform that repeated learning would converge to.
//!
//! **What tells what.** Spikes alone give F_c, s, v_s and z at the drive's figures, but not the drive: a force reaches the
//! position through s/((s + K_v)(s + 1/τ)), in which K_v and 1/τ may change places. Starts and stops of the commanded
//! motion part them. d and k_ff act alike on circles; starts and stops part these too, less well. The fit holds the
//! Stribeck share, v_s or the viscous friction at 0, 2 mm/s and 0 where they are less than three standard errors from 0,
//! and refuses what would leave a needed figure open.
//!
//! **Standard errors** count one reversal, not one sample, as an observation. They do not contain errors that all
//! reversals share: a wrong figure of a given drive, an encoder whose subdivisional error repeats at every reversal
//! (radii that are no multiple of the signal period avoid it).
//!
//! Units: mm and s. F_c/K_vp is the friction as the velocity by which the velocity loop has to be off to supply it.
//! Cost: some hundred simulations of the record, a few seconds for a minute at 10 kHz.
//!
//! Source: P. R. Dahl, 10.2514/3.61511 (pre-sliding); B. Armstrong-Hélouvry, P. Dupont and C. Canudas de Wit,
//! 10.1016/0005-1098(94)90209-7 (Stribeck, identification).

mod drive;
mod glitch;
mod least_squares;
mod parameters;
mod record;
mod refused;
mod start;

pub use glitch::{Glitch, Size, Spike};
pub use record::{Record, Recorded};
pub use refused::Refused;

use least_squares::{Fit, fit};
use parameters::{
    COULOMB, FEED_FORWARD, OFFSET, POSITION_GAIN, PRESLIDING, Problem, READING_LAG, RESET_TIME, REST, STRIBECK_SHARE,
    STRIBECK_VELOCITY, VELOCITY_GAIN, VISCOUS, Values,
};
use record::Reversal;
use std::vec::Vec;
use trueaxis::Axis;
use trueaxis::machine::{DriveFigures, FrictionSettings};

/// Model step, s.
const STEP_S: f64 = 2e-4;
/// Step of the search for starting values, s.
const COARSE_S: f64 = 1e-3;
/// Step of the fits before the last, s.
const ROUGH_S: f64 = 5e-4;
/// Samples before this time do not count unless the axis stands: the state before them is not known, s.
const UNKNOWN_S: f64 = 0.15;
/// A parameter is told by the record if it is this many standard errors from 0.
const TOLD: f64 = 3.0;
/// Largest standard error of a figure of the drive, as a share of it.
const LOOSE: f64 = 0.2;
/// Share of the spikes that the model has to explain.
const EXPLAINED: f64 = 0.5;
/// What a drive that is found has to have been told.
const DRIVE_FIGURES: [usize; 3] = [POSITION_GAIN, RESET_TIME, VELOCITY_GAIN];
/// Residual with position gain and reset time exchanged over that of the fit, at least.
const EXCHANGED: f64 = 1.02;

/// A figure with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// The figure.
    pub value: f64,
    /// Its standard error; none where it was not fitted but held.
    pub standard_error: Option<f64>,
}

/// Friction and drive of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// Which axis.
    pub axis: Axis,
    /// Friction, as settings.
    pub friction: FrictionSettings,
    /// F_c/K_vp, mm/s.
    pub coulomb_per_s: Figure,
    /// s.
    pub stribeck_share: Figure,
    /// v_s, mm/s.
    pub stribeck_velocity_per_s: Figure,
    /// z, mm.
    pub presliding: Figure,
    /// d/K_vp, mm/s per mm/s.
    pub viscous: Figure,
    /// The drive: as given, or as found.
    pub drive: DriveFigures,
    /// Standard errors of K_v, K_vp, τ and k_ff; none where the drive was given.
    pub drive_errors: Option<[f64; 4]>,
    /// By how much the reading is later than the drive's own lag, s.
    pub reading_lag_s: Figure,
    /// Root mean square of what the fit leaves, mm.
    pub residual_rms: f64,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Parameters fitted.
    pub fitted: usize,
    /// Reversals in motion.
    pub reversals: usize,
    /// Spikes at the reversals.
    pub glitch: Glitch,
}

impl Identified {
    /// Position offset u, mm, that feeds the friction found forward along `path` (mm, one value a period), as the servo step
    /// does it:
    ///
    /// ```text
    /// h <- (h + ΔF/K_vp) e^(−T/τ),   u <- u + T (h − K_v u)/k_ff        (k_ff = 0: u = h/K_v)
    /// ```
    pub fn feed_forward(&self, path: &[f64], period_s: f64) -> Vec<f64> {
        let axis = drive::Axis { drive: self.drive, friction: self.friction, rest: 0.0 };
        drive::feed_forward(&axis, path, period_s)
    }
}

/// Called with the axis and the number of steps of its fits so far.
pub type Progress<'p> = dyn FnMut(Axis, usize) + 'p;

/// Friction of both axes; `given` are the drives' figures where they are known.
///
/// # Errors
/// See [`Refused`].
pub fn identify(
    record: &Record,
    given: [Option<DriveFigures>; 2],
    progress: &mut Progress<'_>,
) -> Result<[Identified; 2], Refused> {
    let turns = record.reversals()?;
    let [first, second] = &record.axes;
    Ok([
        identify_axis(first, record.period_s, &turns[0], given[0], progress)?,
        identify_axis(second, record.period_s, &turns[1], given[1], progress)?,
    ])
}

fn identify_axis(
    recorded: &Recorded,
    period_s: f64,
    turns: &[Reversal],
    given: Option<DriveFigures>,
    progress: &mut Progress<'_>,
) -> Result<Identified, Refused> {
    let axis = recorded.axis;
    let rests = recorded.command.windows(2).take(3).all(|pair| pair[0] == pair[1]);
    let problem = |step_s: f64| {
        let mut problem =
            Problem::new(&recorded.command, &recorded.reading, period_s, step_s, given.unwrap_or(start::DRIVE));
        let sample_s = problem.sample_s();
        problem.skip = if rests { 0 } else { (UNKNOWN_S / sample_s) as usize };
        let own: Vec<Reversal> = turns
            .iter()
            .map(|turn| Reversal { index: (turn.index as f64 * period_s / sample_s).round() as usize, ..*turn })
            .collect();
        problem.borders = own.windows(2).map(|pair| (pair[0].index + pair[1].index) / 2).collect();
        (problem, own)
    };
    let start = start::start(&problem(COARSE_S).0, given.as_ref());
    let mut steps = 0;
    let mut tell = || {
        steps += 1;
        progress(axis, steps);
    };
    let rough = problem(ROUGH_S).0;
    let (problem, turns) = problem(STEP_S);
    let (found, free) = reduced(axis, [&rough, &problem], start, (given.is_none(), rests), &mut tell)?;
    judge(axis, &found, &free, given.is_none())?;
    let glitch = glitch::glitch(&problem, &found.values, &turns);
    if glitch.explained < EXPLAINED {
        return Err(Refused::NotExplained { axis, share: glitch.explained, needed: EXPLAINED });
    }
    Ok(identified(axis, &problem, &found, &free, given.is_none(), turns.len(), glitch))
}

/// The fit with the parameters that the record tells; the others hold values that do no harm.
fn reduced(
    axis: Axis,
    [coarse, problem]: [&Problem; 2],
    start: Values,
    (with_drive, rests): (bool, bool),
    tell: &mut dyn FnMut(),
) -> Result<(Fit, Vec<usize>), Refused> {
    let unsettled = || Refused::NoConvergence { axis, steps: least_squares::STEPS };
    let mut free = Vec::from([COULOMB, PRESLIDING, OFFSET]);
    if with_drive {
        free.extend([POSITION_GAIN, RESET_TIME, FEED_FORWARD, VELOCITY_GAIN]);
    } else {
        free.push(READING_LAG);
    }
    let rough = fit(coarse, start, &free, tell).ok_or_else(unsettled)?;
    let mut values = rough.values;
    if with_drive {
        values = the_better_order(axis, coarse, &rough, &free, tell)?;
        free.push(READING_LAG);
    }
    if rests {
        free.push(REST);
    }
    free.extend([VISCOUS, STRIBECK_SHARE, STRIBECK_VELOCITY]);
    loop {
        let found = fit(problem, values, &free, tell).ok_or_else(unsettled)?;
        let Some(held) = untold(&found, &free, with_drive) else { return Ok((found, free)) };
        values = found.values;
        for parameter in held {
            free.retain(|p| p != parameter);
            values.0[*parameter] = if *parameter == STRIBECK_VELOCITY { 2.0 } else { 0.0 };
        }
    }
}

/// Parameters that can be left out and that the fit does not tell: the least told first.
///
/// Viscous friction and velocity feed-forward act alike on a circle. Beside a drive that is fitted, viscous friction
/// therefore stays free, however little it is told (held at 0 it would bend K_v), unless the drive is not told with it.
fn untold(found: &Fit, free: &[usize], with_drive: bool) -> Option<&'static [usize]> {
    let value = |parameter: usize| found.values.0[parameter];
    let told = |parameter: usize| value(parameter).abs() / found.errors[parameter];
    let loose = !with_drive || DRIVE_FIGURES.iter().any(|&p| !(found.errors[p] <= LOOSE * value(p)));
    let is_told = |parameter: usize| match parameter {
        READING_LAG => told(parameter) >= TOLD,
        VISCOUS => value(parameter) > 0.0 && (told(parameter) >= TOLD || !loose),
        _ => value(parameter) > 0.0 && told(parameter) >= TOLD,
    };
    let candidates: [(usize, &'static [usize]); 4] = [
        (READING_LAG, &[READING_LAG]),
        (STRIBECK_SHARE, &[STRIBECK_SHARE, STRIBECK_VELOCITY]),
        (STRIBECK_VELOCITY, &[STRIBECK_VELOCITY]),
        (VISCOUS, &[VISCOUS]),
    ];
    let untold = candidates.into_iter().find(|(parameter, _)| free.contains(parameter) && !is_told(*parameter));
    untold.map(|(_, held)| held)
}

/// Of a fit and the one from position gain and 1/reset time exchanged, the better.
fn the_better_order(
    axis: Axis,
    problem: &Problem,
    found: &Fit,
    free: &[usize],
    tell: &mut dyn FnMut(),
) -> Result<Values, Refused> {
    let mut start = found.values;
    let [gain, reset] = [start.0[POSITION_GAIN], start.0[RESET_TIME]];
    start.0[POSITION_GAIN] = 1.0 / reset;
    start.0[RESET_TIME] = 1.0 / gain;
    start.0[FEED_FORWARD] = (1.0 - (1.0 - start.0[FEED_FORWARD]) / (gain * reset)).max(0.0);
    let Some(other) = fit(problem, start, free, tell) else { return Ok(found.values) };
    let [best, worse] = if found.rms <= other.rms { [found, &other] } else { [&other, found] };
    let apart = |parameter: usize| (best.values.0[parameter] / worse.values.0[parameter]).ln().abs();
    if apart(POSITION_GAIN).max(apart(RESET_TIME)) > 0.02 && worse.rms < EXCHANGED * best.rms {
        return Err(Refused::GainOrResetTime {
            axis,
            position_gain_per_s: best.values.0[POSITION_GAIN],
            reset_time_s: best.values.0[RESET_TIME],
            residual_um: 1e3 * best.rms,
            exchanged_um: 1e3 * worse.rms,
        });
    }
    Ok(best.values)
}

fn judge(axis: Axis, found: &Fit, free: &[usize], with_drive: bool) -> Result<(), Refused> {
    if found.rank < free.len() {
        return Err(Refused::RankShort { axis, rank: found.rank, of: free.len(), condition: found.condition });
    }
    let [value, error] = [found.values.0[COULOMB], found.errors[COULOMB]];
    if !(value > TOLD * error) {
        return Err(Refused::NoFriction { axis, found_mm_per_s: value, standard_error_mm_per_s: error });
    }
    let circles = "circles of another radius or at another feed";
    let drive = "a record that starts and stops, or the drive's figures (--machine)";
    let mut needed = Vec::from([(PRESLIDING, "pre-sliding", circles)]);
    if with_drive {
        needed.extend([
            (POSITION_GAIN, "position gain", drive),
            (RESET_TIME, "reset time", drive),
            (VELOCITY_GAIN, "velocity gain", drive),
        ]);
    }
    for (parameter, figure, needed) in needed {
        let relative_error = found.errors[parameter] / found.values.0[parameter];
        if !(relative_error <= LOOSE) {
            return Err(Refused::NotExcited { axis, figure, relative_error, needed });
        }
    }
    Ok(())
}

fn identified(
    axis: Axis,
    problem: &Problem,
    found: &Fit,
    free: &[usize],
    with_drive: bool,
    reversals: usize,
    glitch: Glitch,
) -> Identified {
    let figure = |parameter: usize| Figure {
        value: found.values.0[parameter],
        standard_error: free.contains(&parameter).then(|| found.errors[parameter]),
    };
    let errors = [POSITION_GAIN, VELOCITY_GAIN, RESET_TIME, FEED_FORWARD].map(|parameter| found.errors[parameter]);
    let mut drive = found.values.drive(&problem.given);
    if with_drive {
        drive.dead_time_s = found.values.0[READING_LAG].max(0.0);
        drive.velocity_feed_forward = drive.velocity_feed_forward.min(1.0);
    }
    Identified {
        axis,
        friction: found.values.friction(),
        coulomb_per_s: figure(COULOMB),
        stribeck_share: figure(STRIBECK_SHARE),
        stribeck_velocity_per_s: figure(STRIBECK_VELOCITY),
        presliding: figure(PRESLIDING),
        viscous: figure(VISCOUS),
        drive,
        drive_errors: with_drive.then_some(errors),
        reading_lag_s: figure(READING_LAG),
        residual_rms: found.rms,
        condition: found.condition,
        fitted: free.len(),
        reversals,
        glitch,
    }
}
