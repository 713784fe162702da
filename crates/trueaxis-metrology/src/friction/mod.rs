//! Identification of an axis' friction and drive figures from recorded circles.
//!
//! At a reversal the friction changes sign, and the axis deviates from its path until the velocity loop's integrator has
//! supplied the opposite force: a spike in the following error at every quadrant. The model of the drive
//!
//! ```text
//! r  = K_v (c − x) + k_ff c'                        position loop with velocity feed-forward
//! v' = K_vp (r − v + 1/τ ∫(r − v) dt) − F − d v     velocity loop behind the current loop, mass, friction
//! F  = F_c (1 + s/(1 + (v/v_s)²)) f                 Coulomb friction, Stribeck share
//! f' = (v − |v| f)/z                                pre-sliding (Dahl): friction reverses by 63 % over the travel z
//! ```
//!
//! is simulated along the recorded commands c, and its following error c − x is fitted to the recorded one by least squares.
//! The parameters are F_c/K_vp (mm/s), s, v_s (mm/s), z (mm), d/K_vp, the lag of the reading and, if the drive's figures are
//! unknown, K_v, K_vp, τ and k_ff. Because the recorded commands drive the model, the fit needs no further record with a
//! learned correction: its result is the waveform to which repeated learning would converge.
//!
//! **Observability.** Spikes alone determine F_c, s, v_s and z for given drive figures, but not the drive: a force reaches the
//! position through s/((s + K_v)(s + 1/τ)), in which K_v and 1/τ are interchangeable. Starts and stops of the commanded motion
//! separate them. d and k_ff have the same effect on circles; starts and stops separate these too, less well. The fit fixes
//! the Stribeck share, v_s or the viscous friction at 0, 2 mm/s and 0 if they are less than three standard errors from 0, and
//! refuses a record that leaves a needed figure undetermined.
//!
//! **Standard errors** count one reversal, not one sample, as an observation. They exclude errors common to all reversals: a
//! wrong figure of a given drive, or an encoder whose subdivisional error repeats at every reversal (radii that are not a
//! multiple of the signal period avoid it).
//!
//! Units: mm and s. F_c/K_vp expresses friction as the velocity error at which the velocity loop supplies it. Cost: some
//! hundred simulations of the record, a few seconds for a minute at 10 kHz; some thousand if the fits barely converge.
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
mod resonance;
mod selection;
mod start;

pub use circles::{Circle, circles};
pub use glitch::{Deviation, Glitch, Size, Spike};
pub use record::{Record, Recorded};
pub use refused::FrictionRefusal;
pub use resonance::{Mechanics, NoResonance, Resonance};

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
/// Samples before this time, s, are ignored unless the axis is at rest: the state before them is unknown.
const UNKNOWN_S: f64 = 0.15;
/// Least share of the spikes that the model has to explain.
const EXPLAINED: f64 = 0.5;

/// A figure with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Value of the figure.
    pub value: f64,
    /// Standard error; `None` if the figure was fixed, not fitted.
    pub standard_error: Option<f64>,
}

/// Names of the figures in [`Identified::covariance`]: fields of [`FrictionSettings`], then of [`DriveFigures`]; the dead time is
/// that of [`Identified::reading_lag_s`]. Units mm and s.
pub const FIGURES: [&str; 10] = [
    "coulomb_per_s",
    "stribeck_share",
    "stribeck_velocity_per_s",
    "presliding",
    "viscous",
    "position_gain_per_s",
    "velocity_gain_per_s",
    "reset_time_s",
    "velocity_feed_forward",
    "dead_time_s",
];
/// Parameters of the fit in the order of [`FIGURES`].
const PARAMETERS: [usize; FIGURES.len()] = [
    COULOMB,
    STRIBECK_SHARE,
    STRIBECK_VELOCITY,
    PRESLIDING,
    VISCOUS,
    POSITION_GAIN,
    VELOCITY_GAIN,
    RESET_TIME,
    FEED_FORWARD,
    READING_LAG,
];

/// Friction and drive of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// The axis.
    pub axis: Axis,
    /// Friction, as settings.
    pub friction: FrictionSettings,
    /// F_c/K_vp, mm/s.
    pub coulomb_per_s: Figure,
    /// Stribeck share s.
    pub stribeck_share: Figure,
    /// Stribeck velocity v_s, mm/s.
    pub stribeck_velocity_per_s: Figure,
    /// Pre-sliding travel z, mm.
    pub presliding: Figure,
    /// d/K_vp, mm/s per mm/s.
    pub viscous: Figure,
    /// The drive, as stated by the caller or as identified.
    pub drive: DriveFigures,
    /// Standard errors of K_v, K_vp, τ and k_ff; `None` for a drive that the caller stated.
    pub drive_errors: Option<[f64; 4]>,
    /// Lag of the reading in addition to the drive's lag, s.
    pub reading_lag_s: Figure,
    /// Covariance of the figures, in the order of [`FIGURES`] and in their units; 0 for a figure that was fixed.
    ///
    /// It is conditional on the figures that the fit fixed, at 0, at 2 mm/s or as the caller stated them, and on the linearised
    /// model at the values found. The axes of a record are fitted separately.
    pub covariance: [[f64; FIGURES.len()]; FIGURES.len()],
    /// Root mean square residual of the fit, mm.
    pub residual_rms: f64,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Number of fitted parameters.
    pub fitted: usize,
    /// Number of reversals in motion.
    pub reversals: usize,
    /// Spikes at the reversals.
    pub glitch: Glitch,
    /// Resonance of the axis; `None` until [`Identified::find_resonance`] has searched for it.
    pub mechanics: Option<Mechanics>,
    values: Values,
}

impl Identified {
    /// Returns the position offset u, mm, that feeds the identified friction forward along `path` (mm, one value per period),
    /// with the law of the servo step:
    ///
    /// ```text
    /// h <- (h + ΔF/K_vp) e^(−T/τ),   u <- u + T (h − K_v u)/k_ff        (k_ff = 0: u = h/K_v)
    /// ```
    pub fn feed_forward(&self, path: &[f64], period_s: f64) -> Vec<f64> {
        let axis = drive::Axis { drive: self.drive, friction: self.friction, feed_lag_s: 0.0, rest: 0.0 };
        drive::feed_forward(&axis, path, period_s)
    }

    /// Evaluates another record of this axis, returned as `before`: the deviation of its readings at the reversals from the
    /// identified drive without friction. `index` is the axis' index in the record; its commands must be the path, without the
    /// offsets that a feed-forward adds.
    ///
    /// # Errors
    /// A record that [`identify`] would refuse before fitting.
    pub fn spikes(&self, record: &Record, index: usize) -> Result<Glitch, FrictionRefusal> {
        let (problem, turns) = self.problem(record, index)?;
        Ok(glitch::glitch(&problem, &self.values, &turns))
    }

    /// Deviation of this axis from the identified drive without friction, over a whole record: the fitted one, or another as
    /// in [`Identified::spikes`].
    ///
    /// # Errors
    /// A record that [`identify`] would refuse before fitting.
    ///
    /// Cost: three simulations of the record.
    pub fn deviation(&self, record: &Record, index: usize) -> Result<Deviation, FrictionRefusal> {
        let (problem, _) = self.problem(record, index)?;
        Ok(glitch::deviation(&problem, &self.values))
    }

    /// Searches the record for the resonance of this axis, which is number `index` in it; `on_step` is called before every
    /// step of a fit.
    ///
    /// # Errors
    /// A record that [`identify`] would refuse before fitting.
    ///
    /// Cost: several times that of [`identify`].
    pub fn find_resonance(
        &mut self,
        record: &Record,
        index: usize,
        on_step: &mut dyn FnMut(),
    ) -> Result<(), FrictionRefusal> {
        self.mechanics = Some(resonance::mechanics(record, self, index, on_step)?);
        Ok(())
    }

    fn problem(&self, record: &Record, index: usize) -> Result<(Problem, Vec<Reversal>), FrictionRefusal> {
        let turns = record.reversals()?;
        let index = index.min(1);
        let mut drive = self.drive;
        if self.drive_errors.is_some() {
            // The reading's lag already contains the identified dead time.
            drive.dead_time_s = start::DRIVE.dead_time_s;
        }
        Ok(problem(record, &record.axes[index], &turns[index], Some(drive), STEP_S))
    }
}

/// Callback with the axis and the number of fit steps so far.
pub type Progress<'p> = dyn FnMut(Axis, usize) + 'p;

/// Identifies the friction of both axes; `given` are the drives' figures if known.
///
/// # Errors
/// See [`FrictionRefusal`].
pub fn identify(
    record: &Record,
    given: [Option<DriveFigures>; 2],
    progress: &mut Progress<'_>,
) -> Result<[Identified; 2], FrictionRefusal> {
    let [first, second] = record.reversals()?;
    Ok([
        identify_axis(record, &record.axes[0], &first, given[0], progress)?,
        identify_axis(record, &record.axes[1], &second, given[1], progress)?,
    ])
}

/// An axis as the fit uses it, in steps of about `step_s`, and its reversals.
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
        // Only a fit of the drive needs starts and stops. With stated figures they are ignored: errors in the figures would
        // appear there as friction.
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
) -> Result<Identified, FrictionRefusal> {
    let axis = recorded.axis;
    let with_drive = given.is_none();
    let problem = |step_s: f64| problem(record, recorded, turns, given, step_s);
    let start = start::start(&problem(COARSE_S).0, given.as_ref());
    let mut steps = 0;
    let mut on_step = || {
        steps += 1;
        progress(axis, steps);
    };
    let rough = problem(ROUGH_S).0;
    let (problem, turns) = problem(STEP_S);
    // If starts are ignored, the state of friction before them is unobservable.
    let rests = with_drive && record.rests(recorded);
    let (found, free) = reduced(axis, [&rough, &problem], start, (with_drive, rests), &mut on_step)?;
    judge(axis, &found, &free, with_drive)?;
    let glitch = glitch::glitch(&problem, &found.values, &turns);
    if glitch.explained < EXPLAINED {
        return Err(FrictionRefusal::NotExplained { axis, share: glitch.explained, needed: EXPLAINED });
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
        covariance: PARAMETERS.map(|one| PARAMETERS.map(|other| found.covariance[one][other])),
        residual_rms: found.rms,
        condition: found.condition,
        fitted: free.len(),
        reversals,
        glitch,
        mechanics: None,
        values: found.values,
    }
}
