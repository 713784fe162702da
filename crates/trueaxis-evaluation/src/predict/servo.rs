//! Where the drives bring the axes at the points of a part's features: the simulator's step and plant run the program.
//!
//! ```text
//! q(t) = q_c(t) + e(t)        e: reading − command of a run, in which the correction and the error of the servo are
//! ```
//!
//! The drives are exactly those of the machine.toml, rigid, with encoders that are free of errors; friction that is not stated
//! is zero. A point gets the positions of the moment at which it is commanded: the lag along the path moves it along the
//! feature, and what is left across the path is in the feature.
//!
//! Of a program of X, Y and Z alone only the features run, each with some moves before and after it, and rapids between them.

use super::cut::{Cut, Followed};
use super::part::Part;
use super::times::rapid_mm_per_min;
use anyhow::{Result, bail};
use glam::DVec3;
use serde::Serialize;
use std::sync::Arc;
use trueaxis::machine::{AXES, Axis, MachineSettings};
use trueaxis_sim::plant::drive::DriveSettings;
use trueaxis_sim::plant::encoder::{EncoderSettings, Encoders};
use trueaxis_sim::plant::stated;
use trueaxis_sim::program::{Curve, Move, Program, Turn};
use trueaxis_sim::run::{Kind, Moment, Run, Sample, Sink};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

/// Moves before and after a feature that are simulated with it, at least so many and so long, mm: friction and lost motion then
/// have their side, and the drives follow at the programmed feed.
const BESIDE: usize = 3;
const BESIDE_MM: f64 = 30.0;
/// Shortest way between two features, mm: the simulator takes no line of length zero.
const SHORTEST_MM: f64 = 1e-6;
/// Cycles between two reports of the progress.
const BLOCK: u64 = 8192;
/// Travel per count of the encoders, mm.
const COUNT_MM: f64 = 1e-6;

/// How the servo was simulated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ServoDocument {
    /// Servo rate.
    pub rate_hz: f64,
    /// Simulated machines, by how they are driven.
    pub machines: Vec<&'static str>,
    /// Simulated time of each machine.
    pub simulated_s: f64,
    /// Moves simulated, and moves of the programs.
    pub moves: [usize; 2],
}

impl ServoDocument {
    /// What a reader has to know of the runs.
    pub(super) fn summary(&self) -> String {
        let [simulated, all] = self.moves;
        format!(
            "with the servo: {simulated} of {all} moves, {:.1} s at {} Hz, {}",
            self.simulated_s,
            self.rate_hz,
            self.machines.join(", ")
        )
    }
}

/// Runs the program on the machine and moves the points of the features to where the drives bring them: uncorrected, with the
/// geometric correction, and with everything that the machine configures. `on_progress` gets the cycles done and all cycles.
///
/// # Errors
/// A moving axis without figures of its drive; a machine or program that the simulator refuses; a run that the step stops.
pub(super) fn follow(
    (machine, program, part): (&Machine, &Program, &Part),
    cuts: &mut [Cut],
    rate_hz: f64,
    on_progress: &mut dyn FnMut(u64, u64),
) -> Result<ServoDocument> {
    let has_dynamics = Kind::of(&machine.settings).len() > Kind::BASIC.len();
    let mut kinds = vec![Kind::Uncompensated, Kind::Compensated];
    kinds.extend(has_dynamics.then_some(Kind::Configured));
    let mut document = ServoDocument {
        rate_hz,
        machines: kinds.iter().map(|kind| kind.words()).collect(),
        simulated_s: 0.0,
        moves: [0; 2],
    };
    let mut runs = Vec::new();
    for setup in std::iter::once(None).chain((0..part.setups.len()).map(Some)) {
        let own = || cuts.iter().filter(|cut| cut.setup == setup);
        if own().next().is_none() {
            continue;
        }
        let program = part.program_of(setup, program);
        let shortened = Shortened::of(program, own().map(|cut| cut.moves));
        document.moves[0] += shortened.program.moves.len();
        document.moves[1] += program.moves.len();
        let mut places: Vec<(usize, f64)> = own()
            .flat_map(|cut| &cut.points)
            .filter_map(|point| Some((shortened.index.get(point.place.0).copied()??, point.place.1)))
            .collect();
        places.sort_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
        places.dedup();
        let drives = drives(&machine.settings, program.is_five_axis())?;
        let at_mm = setup.and_then(|setup| part.setups.get(setup)).map_or(part.at_mm, |held| held.at_mm);
        let Shortened { program, index } = shortened;
        let scenario = Arc::new(Scenario::new(machine.clone(), program, settings(machine, rate_hz, at_mm))?);
        let start = |kind: &Kind| Ok(Run::with_drives(Arc::clone(&scenario), *kind, &[drives])?);
        let started = kinds.iter().map(start).collect::<Result<Vec<Run>>>()?;
        document.simulated_s += started[0].cycles() as f64 / rate_hz;
        runs.push((setup, index, places, started));
    }
    let all: u64 = runs.iter().flat_map(|(.., runs)| runs).map(Run::cycles).sum();
    let mut done = 0;
    for (setup, index, places, started) in runs {
        let program = part.program_of(setup, program);
        let mut errors = Vec::new();
        for mut run in started {
            let mut caught = Caught { places: &places, errors: Vec::new(), before: None, stopped: None };
            loop {
                let before = run.cycle();
                let is_on = run.advance(BLOCK, &mut caught);
                done += run.cycle() - before;
                on_progress(done, all);
                if !is_on {
                    break;
                }
            }
            if let Some((line, fault)) = caught.stopped {
                bail!(
                    "{}:{line}: found fault {fault}, at which the simulated controller stops; needed a program that it cuts: \
                     trueaxis explain fault {fault}",
                    program.file
                );
            }
            errors.push(caught.finish());
        }
        for point in cuts.iter_mut().filter(|cut| cut.setup == setup).flat_map(|cut| &mut cut.points) {
            let Some(Some(step)) = index.get(point.place.0) else { continue };
            let place = (*step, point.place.1);
            let found = places.binary_search_by(|own| own.0.cmp(&place.0).then(own.1.total_cmp(&place.1)));
            let Ok(found) = found else { continue };
            let last = errors.len() - 1;
            point.follow([&errors[0], &errors[1], &errors[last]].map(|errors| errors[found]));
        }
    }
    Ok(document)
}

/// Drives as the machine states them.
///
/// # Errors
/// A moving axis without figures of its drive.
fn drives(machine: &MachineSettings, is_five_axis: bool) -> Result<[DriveSettings; AXES]> {
    for own in machine.axes.iter().filter(|own| is_five_axis || !own.axis.is_rotary()) {
        if own.servo.drive.is_none() {
            let letter = own.axis.letter();
            bail!(
                "{}: key axis.{letter}.drive: found nothing, needed position_gain_per_s, velocity_gain_per_s and \
                 reset_time_s of the drive, which --servo simulates",
                machine.name
            );
        }
    }
    Ok(Axis::ALL.map(|axis| {
        let own = stated(machine, axis);
        let has_friction = machine.axis(axis).is_some_and(|own| own.servo.friction.is_some());
        if has_friction {
            return own;
        }
        DriveSettings { coulomb_mm_per_s2: 0.0, stribeck_share: 0.0, viscous_per_s: 0.0, ..own }
    }))
}

fn settings(machine: &Machine, rate_hz: f64, origin_mm: [f64; 3]) -> Settings {
    let exact = |of: EncoderSettings| EncoderSettings {
        resolution_mm: COUNT_MM,
        sde_first_mm: 0.0,
        sde_second_mm: 0.0,
        noise_rms_mm: 0.0,
        ..of
    };
    let mut settings = Settings { rate_hz, origin_mm: Some(origin_mm), ..Settings::default() };
    settings.encoder = Encoders { linear: exact(EncoderSettings::LINEAR), rotary: exact(EncoderSettings::ROTARY) };
    settings.motion.rapid_mm_per_min = rapid_mm_per_min(machine);
    settings
}

/// A program of the features alone.
struct Shortened {
    program: Program,
    /// Where the moves of the whole program are in this one.
    index: Vec<Option<usize>>,
}

impl Shortened {
    /// `features`: first and last move of each.
    fn of(program: &Program, features: impl Iterator<Item = [usize; 2]>) -> Shortened {
        let mut index = vec![None; program.moves.len()];
        if program.is_five_axis() {
            (0..program.moves.len()).for_each(|step| index[step] = Some(step));
            return Shortened { program: program.clone(), index };
        }
        let mut stretches: Vec<[usize; 2]> = features.map(|feature| widened(program, feature)).collect();
        stretches.sort_unstable();
        let mut moves: Vec<Move> = Vec::new();
        for [first, last] in stretches {
            for (step, own) in program.moves.iter().enumerate().take(last + 1).skip(first) {
                if index[step].is_some() {
                    continue;
                }
                let start = own.curve.position(own.curve.domain().0);
                let follows = step > 0 && index[step - 1].is_some();
                let last = moves.last().filter(|_| !follows);
                if let Some(end) = last.map(|before| before.curve.position(before.curve.domain().1))
                    && (DVec3::from(end) - DVec3::from(start)).length() > SHORTEST_MM
                {
                    let curve = Curve::Line { start: end, end: start };
                    moves.push(Move { rapid: true, feed_per_min: 0.0, curve, turn: Turn::default(), ..own.clone() });
                }
                index[step] = Some(moves.len());
                moves.push(own.clone());
            }
        }
        Shortened { program: Program { moves, ..program.clone() }, index }
    }
}

/// A feature with the moves beside it.
fn widened(program: &Program, [mut first, mut last]: [usize; 2]) -> [usize; 2] {
    let length = |step: usize| program.moves[step].curve.length();
    let (mut count, mut mm) = (0, 0.0);
    while first > 0 && (count < BESIDE || mm < BESIDE_MM) {
        first -= 1;
        (count, mm) = (count + 1, mm + length(first));
    }
    (count, mm) = (0, 0.0);
    while last + 1 < program.moves.len() && (count < BESIDE || mm < BESIDE_MM) {
        last += 1;
        (count, mm) = (count + 1, mm + length(last));
    }
    [first, last]
}

/// Reading minus command at places of the program, and the share of the lost motion that is taken up in negative travel.
struct Caught<'p> {
    /// In the order of the program.
    places: &'p [(usize, f64)],
    errors: Vec<Followed>,
    /// Place and error of the last cycle.
    before: Option<((usize, f64), Followed)>,
    /// Line and code of the fault at which the step stopped.
    stopped: Option<(u32, u8)>,
}

impl Caught<'_> {
    fn finish(mut self) -> Vec<Followed> {
        // The last place may be beyond the last setpoint by a rounding.
        let last = self.before.map_or([[0.0; AXES]; 2], |(_, error)| error);
        self.errors.resize(self.places.len(), last);
        self.errors
    }
}

impl Sink for Caught<'_> {
    fn cycle(&mut self, moment: &Moment, machines: &[Option<&Sample>]) {
        let Some(Some(sample)) = machines.first() else { return };
        if sample.fault != 0 && self.stopped.is_none() {
            self.stopped = Some((moment.line, sample.fault));
        }
        let at = (moment.move_index, moment.u);
        let off = std::array::from_fn(|axis| sample.feedback[axis] - sample.command[axis]);
        let error = [off, sample.reverse];
        while let Some(place) = self.places.get(self.errors.len()).filter(|place| **place <= at) {
            let share = |(step, u): (usize, f64)| (step == at.0 && at.1 > u).then(|| (place.1 - u) / (at.1 - u));
            let mixed = self.before.and_then(|(before, own)| Some((share(before)?, own)));
            self.errors.push(match mixed {
                Some((share, own)) => [0, 1].map(|of| {
                    let [own, error]: [[f64; AXES]; 2] = [own[of], error[of]];
                    std::array::from_fn(|axis| own[axis] + share * (error[axis] - own[axis]))
                }),
                None => error,
            });
        }
        self.before = Some((at, error));
    }
}
