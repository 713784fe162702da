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
//! Cost: some hundred simulations of the record, a few seconds for a minute at 10 kHz; of a record whose fits hardly settle,
//! some thousand.
//!
//! Source: P. R. Dahl, 10.2514/3.61511 (pre-sliding); B. Armstrong-Hélouvry, P. Dupont and C. Canudas de Wit,
//! 10.1016/0005-1098(94)90209-7 (Stribeck, identification).

mod circles;
mod drive;
mod glitch;
mod least_squares;
mod parameters;
mod record;
mod refused;
mod selection;
mod start;

pub use circles::{Circle, circles};
pub use glitch::{Deviation, Glitch, Size, Spike};
pub use record::{Record, Recorded};
pub use refused::Refused;

use least_squares::Fit;
use parameters::{
    COULOMB, FEED_FORWARD, POSITION_GAIN, PRESLIDING, Problem, READING_LAG, RESET_TIME, STRIBECK_SHARE,
    STRIBECK_VELOCITY, VELOCITY_GAIN, VISCOUS, Values,
};
use record::Reversal;
use selection::{judge, reduced};
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
/// Share of the spikes that the model has to explain.
const EXPLAINED: f64 = 0.5;

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
    values: Values,
}

impl Identified {
    /// Position offset u, mm, that feeds the friction found forward along `path` (mm, one value a period), as the servo step
    /// does it:
    ///
    /// ```text
    /// h <- (h + ΔF/K_vp) e^(−T/τ),   u <- u + T (h − K_v u)/k_ff        (k_ff = 0: u = h/K_v)
    /// ```
    pub fn feed_forward(&self, path: &[f64], period_s: f64) -> Vec<f64> {
        let axis = drive::Axis { drive: self.drive, friction: self.friction, feed_lag_s: 0.0, rest: 0.0 };
        drive::feed_forward(&axis, path, period_s)
    }

    /// Spikes of another record of this axis, `before` in the first place: how far its readings stand from where the drive found would be without
    /// friction, at its reversals. `index` is the axis' place in the record, whose commands are the path: without what a
    /// feed-forward adds to them.
    ///
    /// # Errors
    /// A record that [`identify`] would refuse before any fit.
    pub fn spikes(&self, record: &Record, index: usize) -> Result<Glitch, Refused> {
        let (problem, turns) = self.problem(record, index)?;
        Ok(glitch::glitch(&problem, &self.values, &turns))
    }

    /// How far this axis stands from where the drive found would be without friction, over a whole record: the one that was
    /// fitted, or another as in [`Identified::spikes`].
    ///
    /// # Errors
    /// A record that [`identify`] would refuse before any fit.
    ///
    /// Cost: three simulations of the record.
    pub fn deviation(&self, record: &Record, index: usize) -> Result<Deviation, Refused> {
        let (problem, _) = self.problem(record, index)?;
        Ok(glitch::deviation(&problem, &self.values))
    }

    fn problem(&self, record: &Record, index: usize) -> Result<(Problem, Vec<Reversal>), Refused> {
        let turns = record.reversals()?;
        let index = index.min(1);
        let mut drive = self.drive;
        if self.drive_errors.is_some() {
            // What was found of it is in the reading's lag already.
            drive.dead_time_s = start::DRIVE.dead_time_s;
        }
        Ok(problem(record, &record.axes[index], &turns[index], Some(drive), STEP_S))
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
    let [first, second] = record.reversals()?;
    Ok([
        identify_axis(record, &record.axes[0], &first, given[0], progress)?,
        identify_axis(record, &record.axes[1], &second, given[1], progress)?,
    ])
}

/// The fit's view of an axis in steps of about `step_s`, and its reversals.
fn problem(
    record: &Record,
    recorded: &Recorded,
    turns: &[Reversal],
    given: Option<DriveFigures>,
    step_s: f64,
) -> (Problem, Vec<Reversal>) {
    let figures = given.unwrap_or(start::DRIVE);
    let mut problem = Problem::new(&recorded.command, &recorded.reading, record.period_s, step_s, figures);
    let sample_s = problem.sample_s();
    if given.is_none() {
        problem.read_after_s = record.read_after_s;
    } else {
        // Starts and stops tell the drive. Where its figures are given, what these are wrong by would bend the friction.
        let even = record.even(turns);
        let coarse = (sample_s / record.period_s).round().max(1.0) as usize;
        problem.even = even.into_iter().step_by(coarse).collect();
    }
    problem.skip = if record.rests(recorded) { 0 } else { (UNKNOWN_S / sample_s) as usize };
    let scale = record.period_s / sample_s;
    let place = |turn: &Reversal| Reversal { index: (turn.index as f64 * scale).round() as usize, ..*turn };
    let turns: Vec<Reversal> = turns.iter().map(place).collect();
    problem.borders = turns.windows(2).map(|pair| (pair[0].index + pair[1].index) / 2).collect();
    (problem, turns)
}

fn identify_axis(
    record: &Record,
    recorded: &Recorded,
    turns: &[Reversal],
    given: Option<DriveFigures>,
    progress: &mut Progress<'_>,
) -> Result<Identified, Refused> {
    let axis = recorded.axis;
    let with_drive = given.is_none();
    let problem = |step_s: f64| problem(record, recorded, turns, given, step_s);
    let start = start::start(&problem(COARSE_S).0, given.as_ref());
    let mut steps = 0;
    let mut tell = || {
        steps += 1;
        progress(axis, steps);
    };
    let rough = problem(ROUGH_S).0;
    let (problem, turns) = problem(STEP_S);
    // Where starts do not count, neither does the state of friction before them.
    let rests = with_drive && record.rests(recorded);
    let (found, free) = reduced(axis, [&rough, &problem], start, (with_drive, rests), &mut tell)?;
    judge(axis, &found, &free, with_drive)?;
    let glitch = glitch::glitch(&problem, &found.values, &turns);
    if glitch.explained < EXPLAINED {
        return Err(Refused::NotExplained { axis, share: glitch.explained, needed: EXPLAINED });
    }
    Ok(identified(axis, &problem, &found, &free, turns.len(), glitch))
}

fn identified(
    axis: Axis,
    problem: &Problem,
    found: &Fit,
    free: &[usize],
    reversals: usize,
    glitch: Glitch,
) -> Identified {
    let figure = |parameter: usize| Figure {
        value: found.values.0[parameter],
        standard_error: free.contains(&parameter).then(|| found.uncertainties[parameter]),
    };
    let errors =
        [POSITION_GAIN, VELOCITY_GAIN, RESET_TIME, FEED_FORWARD].map(|parameter| found.uncertainties[parameter]);
    let mut drive = found.values.drive(&problem.given);
    let with_drive = free.contains(&POSITION_GAIN);
    if with_drive {
        drive.dead_time_s = if problem.read_after_s.is_some() { 0.0 } else { found.values.0[READING_LAG].max(0.0) };
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
        values: found.values,
    }
}
