//! The features of a part on a machine, before anything is drawn.

use super::cut::{Cut, Point};
use super::fit::Nominal;
use super::fixture::{self, Moves};
use super::kinds::FeatureKind;
use super::part::{Characteristic, Feature, Part};
use super::servo::{self, ServoDocument};
use super::temperature::{self, TemperatureDocument, Warm};
use super::unknowns::Model;
use super::{characteristic, profile, run};
use crate::uncertainty::terms::Terms;
use anyhow::{Result, bail};
use std::cmp::Ordering;
use trueaxis_sim::program::{Program, ProgramError};
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;

/// Servo rate, Hz, and what is told about the progress of the runs.
pub(super) type Servo<'s> = (f64, &'s mut dyn FnMut(u64, u64));

/// The features of a part on a machine, and what is not known of it.
pub(super) struct Prepared {
    pub(super) cuts: Vec<Cut>,
    nominal: Vec<Nominal>,
    pub(super) terms: Terms,
    moves: Vec<Moves>,
    pub(super) temperature: Option<TemperatureDocument>,
}

impl Prepared {
    /// # Errors
    /// As [`predict`](super::predict()).
    pub(super) fn new(machine: &Machine, stated: &Uncertainties, program: &Program, part: &Part) -> Result<Prepared> {
        if part.tolerances.is_empty() {
            bail!("{}: key tolerance: found nothing, needed at least one section [[tolerance]]", part.file.display());
        }
        let growth = part.growth_on(machine)?;
        let warm = growth.as_deref().map(|growth| Warm::new(growth, (machine, part), program)).transpose()?;
        let (mut cuts, clipped) = run::features(machine, program, part, warm.as_ref())?;
        settle_profiles(program, part, &mut cuts)?;
        let nominal = nominal(program, part, &cuts)?;
        characteristic::check(part, &nominal)?;
        datums_first(part, &cuts)?;
        let mut terms = Terms::stated(machine, stated);
        terms.warnings.extend(clipped.notes(&machine.settings, "point"));
        let temperature = temperature_of(&mut terms, (machine, stated), (part, &cuts), warm.as_ref())?;
        let mut moves = Vec::new();
        // Set-ups and tools alone allow no verdict on a machine of which nothing is known.
        if !terms.all.is_empty() {
            let (held, of_part) = fixture::moves(&part.setups, &part.tools);
            moves = held;
            terms.all.extend(of_part);
        }
        terms.correlate(&stated.correlations);
        Ok(Prepared { cuts, nominal, terms, moves, temperature })
    }

    /// Runs the servo; its drives are not exactly known either, unless nothing of the machine is.
    ///
    /// # Errors
    /// As [`predict_with_servo`](super::predict_with_servo).
    pub(super) fn follow(
        &mut self,
        (machine, stated): (&Machine, &Uncertainties),
        program: &Program,
        part: &Part,
        seed: u64,
        (rate_hz, on_progress): Servo<'_>,
    ) -> Result<servo::Run> {
        let ran = servo::Ran { part, program, cuts: &self.cuts, rate_hz };
        let known = (!self.terms.all.is_empty()).then_some(stated);
        let (run, cuts) = servo::follow(machine, known, &ran, seed, on_progress)?;
        self.cuts = cuts;
        self.terms.not_stated.extend(run.not_stated.iter().cloned());
        self.know(&run.document.kept);
        Ok(run)
    }

    /// Adds what is not known of the drives.
    fn know(&mut self, kept: &servo::Kept) {
        self.terms.all.extend(kept.terms.iter().cloned());
        self.moves.extend(kept.moves());
    }

    /// The features where the drives brought them in runs of the servo.
    pub(super) fn with_servo(mut self, of: &ServoDocument) -> Prepared {
        self.cuts.clone_from(&of.kept.cuts);
        self.know(&of.kept);
        self
    }

    pub(super) fn model<'m>(&'m self, machine: &'m Machine, part: &'m Part) -> Model<'m> {
        Model { machine, part, cuts: &self.cuts, nominal: &self.nominal, terms: &self.terms, moves: &self.moves }
    }
}

/// Adds what is not known of the temperatures to the terms; the temperatures as a document.
fn temperature_of(
    terms: &mut Terms,
    known: (&Machine, &Uncertainties),
    (part, cuts): (&Part, &[Cut]),
    warm: Option<&Warm<'_>>,
) -> Result<Option<TemperatureDocument>> {
    let points = || cuts.iter().flat_map(|cut| cut.points.iter().map(|point| (cut.setup, point)));
    let place = |(setup, point): (Option<usize>, &Point)| (setup, point.place);
    let span = warm.map(|warm| warm.span(points().map(place))).transpose()?;
    let growth = warm.map(|warm| warm.growth).zip(span);
    temperature::add_terms(terms, known, growth, part.temperature.part.as_ref());
    let by_place = |one: &(Option<usize>, &Point), other: &(Option<usize>, &Point)| {
        place(*one).partial_cmp(&place(*other)).unwrap_or(Ordering::Equal)
    };
    let ends = [points().min_by(by_place), points().max_by(by_place)];
    let at = ends.map(|point| point.map_or_else(Default::default, |(_, point)| point.uncorrected.sent));
    if warm.is_none_or(|warm| !warm.is_timed()) {
        let stated = part.setups.iter().filter(|setup| setup.start.is_some());
        terms.warnings.extend(stated.map(|setup| {
            format!("the start of the set-up {} in a record counts only with a record of temperatures", setup.name)
        }));
    }
    Ok(temperature::document(warm.zip(span), part, at))
}

/// Points and normals of the profiles.
fn settle_profiles(program: &Program, part: &Part, cuts: &mut [Cut]) -> Result<()> {
    for (cut, feature) in cuts.iter_mut().zip(&part.features).filter(|(cut, _)| cut.kind == FeatureKind::Profile) {
        profile::settle(cut).map_err(|(found, needed)| {
            let program = part.program_of(feature.setup, program);
            let line = program.moves.get(cut.moves[0]).map_or(0, |step| step.line);
            ProgramError::new(&program.file, line, format!("{found}, in the lines of {}", feature.name), needed)
        })?;
    }
    Ok(())
}

fn nominal(program: &Program, part: &Part, cuts: &[Cut]) -> Result<Vec<Nominal>> {
    let of = |(cut, feature): (&Cut, &Feature)| {
        Nominal::of(cut).map_err(|needed| {
            let program = part.program_of(feature.setup, program);
            let line = program.moves.get(cut.moves[0]).map_or(0, |step| step.line);
            let what = match feature.kind {
                FeatureKind::Flank | FeatureKind::Circle => "the lines of",
                _ => "other lines among those of",
            };
            let found = format!("{what} {}", feature.name);
            ProgramError::new(&program.file, line, found, needed).into()
        })
    };
    cuts.iter().zip(&part.features).map(of).collect()
}

/// Where a feature is cut, for a reader.
fn place(part: &Part, of: &Feature) -> String {
    let lines = match of.lines {
        [first, last] if first == last => format!("line {first}"),
        [first, last] => format!("lines {first} to {last}"),
    };
    let setup = of.setup.and_then(|setup| part.setups.get(setup));
    let setup = setup.map_or("the first set-up", |setup| &setup.name);
    if part.setups.is_empty() { lines } else { format!("{lines} of {setup}") }
}

/// Refuses datums that are cut after a feature that refers to them.
fn datums_first(part: &Part, cuts: &[Cut]) -> Result<()> {
    for tolerance in part.tolerances.iter().filter(|one| one.characteristic != Characteristic::Distance) {
        for datum in &tolerance.datums {
            let (datum_cut, own_cut) = (&cuts[*datum], &cuts[tolerance.feature]);
            if (datum_cut.setup, datum_cut.moves[1]) >= (own_cut.setup, own_cut.moves[0]) {
                let [own, datum] = [tolerance.feature, *datum].map(|index| &part.features[index]);
                let found = format!("the datum {}, cut in {}", datum.name, place(part, datum));
                let needed = format!("a datum that is made before {}, {}", own.name, place(part, own));
                return Err(part.wrong(tolerance.line, found, needed).into());
            }
        }
    }
    Ok(())
}
