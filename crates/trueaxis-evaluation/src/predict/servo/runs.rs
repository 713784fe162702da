//! Runs of a part's programs on several machines at a time.

use super::super::cut::{Cut, Followed};
use super::super::part::Part;
use super::super::times::rapid_mm_per_min;
use super::caught::{Caught, Stopped};
use super::shortened::Shortened;
use anyhow::Result;
use std::sync::Arc;
use trueaxis::machine::AXES;
use trueaxis_metrology::cores::*;
use trueaxis_sim::plant::drive::DriveSettings;
use trueaxis_sim::plant::encoder::{EncoderSettings, Encoders};
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Kind, Moment, Run, Sample};
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;

/// Machines in one run: their commands are computed once; few enough to occupy every core.
const GROUP: usize = 4;
/// Cycles between two reports of the progress.
const BLOCK: u64 = 8192;
/// Travel per count of the encoders, mm.
const COUNT_MM: f64 = 1e-6;

/// Part and program whose features are run.
pub(in crate::predict) struct Ran<'p> {
    pub(in crate::predict) part: &'p Part,
    pub(in crate::predict) program: &'p Program,
    pub(in crate::predict) cuts: &'p [Cut],
    /// Servo rate.
    pub(in crate::predict) rate_hz: f64,
}

/// A controller and the drives that it meets, in the order of the axes.
pub(super) struct Driven<'m> {
    pub(super) machine: &'m Machine,
    pub(super) kind: Kind,
    pub(super) drives: Vec<[DriveSettings; AXES]>,
}

/// What the machines did.
pub(super) struct Outcome {
    /// By machine, in the order asked for, and point of the features; `None` for a point that no run passes.
    pub(super) errors: Vec<Vec<Option<Followed>>>,
    /// Program and where in it the step stopped a machine.
    pub(super) stopped: Vec<Option<(String, Stopped)>>,
    pub(super) simulated_s: f64,
    pub(super) moves: [usize; 2],
}

/// A run under way, of the machines from `first` on.
struct Lane {
    run: Run,
    setup: usize,
    first: usize,
    caught: Vec<Caught>,
    is_on: bool,
}

impl Lane {
    fn advance(&mut self) {
        let Lane { run, caught, is_on, .. } = self;
        *is_on = *is_on
            && run.advance(BLOCK, &mut |moment: &Moment, samples: &[Option<&Sample>]| {
                for (caught, sample) in caught.iter_mut().zip(samples) {
                    sample.iter().for_each(|sample| caught.cycle(moment, sample));
                }
            });
    }
}

/// A set-up's points in the order of its program.
struct OfSetup {
    setup: Option<usize>,
    index: Vec<Option<usize>>,
    places: Arc<[(usize, f64)]>,
}

impl Ran<'_> {
    /// Runs the features on all machines. `on_progress` gets the cycles done and all cycles.
    ///
    /// # Errors
    /// A machine or program that the simulator refuses.
    pub(super) fn run(&self, driven: &[Driven<'_>], on_progress: &mut dyn FnMut(u64, u64)) -> Result<Outcome> {
        let machines = driven.iter().map(|of| of.drives.len()).sum();
        let points = self.cuts.iter().map(|cut| cut.points.len()).sum();
        let mut outcome = Outcome {
            errors: vec![vec![None; points]; machines],
            stopped: vec![None; machines],
            simulated_s: 0.0,
            moves: [0; 2],
        };
        let (mut setups, mut lanes) = (Vec::new(), Vec::new());
        for setup in std::iter::once(None).chain((0..self.part.setups.len()).map(Some)) {
            let own = || self.cuts.iter().filter(|cut| cut.setup == setup);
            if own().next().is_none() {
                continue;
            }
            let whole = self.part.program_of(setup, self.program);
            let Shortened { program, index } = Shortened::of(whole, own().map(|cut| cut.moves));
            outcome.moves[0] += program.moves.len();
            outcome.moves[1] += whole.moves.len();
            let mut places: Vec<(usize, f64)> = own()
                .flat_map(|cut| &cut.points)
                .filter_map(|point| Some((index.get(point.place.0).copied()??, point.place.1)))
                .collect();
            places.sort_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
            places.dedup();
            let of = OfSetup { setup, index, places: places.into() };
            let held = setup.and_then(|setup| self.part.setups.get(setup));
            let at_mm = held.map_or(self.part.at_mm, |held| held.at_mm);
            let mut first = 0;
            for Driven { machine, kind, drives } in driven {
                let settings = settings(machine, self.rate_hz, at_mm);
                let scenario = Arc::new(Scenario::new((*machine).clone(), program.clone(), settings)?);
                for drives in drives.chunks(GROUP) {
                    let run = Run::with_drives(Arc::clone(&scenario), *kind, drives)?;
                    let caught = drives.iter().map(|_| Caught::new(&of.places)).collect();
                    lanes.push(Lane { run, setup: setups.len(), first, caught, is_on: true });
                    first += drives.len();
                }
            }
            let cycles = lanes.last().map_or(0, |lane: &Lane| lane.run.cycles());
            outcome.simulated_s += cycles as f64 / self.rate_hz;
            setups.push(of);
        }
        let sum = |lanes: &[Lane], of: fn(&Run) -> u64| -> u64 {
            lanes.iter().map(|lane| lane.caught.len() as u64 * of(&lane.run)).sum()
        };
        let all = sum(&lanes, Run::cycles);
        while lanes.iter().any(|lane| lane.is_on) {
            lanes.par_chunks_mut(1).for_each(|lane| lane.iter_mut().for_each(Lane::advance));
            on_progress(sum(&lanes, Run::cycle), all);
        }
        for Lane { setup, first, caught, .. } in lanes {
            let of = &setups[setup];
            for (machine, caught) in (first..).zip(caught) {
                let (errors, stopped) = caught.finish();
                self.place(of, &errors, &mut outcome.errors[machine]);
                let file = || self.part.program_of(of.setup, self.program).file.clone();
                let own = &mut outcome.stopped[machine];
                *own = own.take().or_else(|| Some((file(), stopped?)));
            }
        }
        Ok(outcome)
    }

    /// Assigns the errors at the places of a set-up to the points of its features.
    fn place(&self, of: &OfSetup, errors: &[Followed], to: &mut [Option<Followed>]) {
        let points = self.cuts.iter().flat_map(|cut| cut.points.iter().map(move |point| (cut.setup, point.place)));
        for ((setup, (step, u)), to) in points.zip(to) {
            let Some(Some(step)) = of.index.get(step).filter(|_| setup == of.setup) else { continue };
            let found = of.places.binary_search_by(|own| own.0.cmp(step).then(own.1.total_cmp(&u)));
            *to = found.ok().and_then(|found| errors.get(found)).copied();
        }
    }
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
