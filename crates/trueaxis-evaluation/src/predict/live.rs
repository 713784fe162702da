//! A part that is moved about the machine, and warmed, at the pace of a slider.
//!
//! ```text
//! p(place)   = points of the features at the place, by exact transforms with the correction there
//! d_i        = p_i(home) − p(home): 200 drawn parts, cut once where the part was prepared
//! y(place)   = characteristics of the features fitted to p(place)
//! y_i(place) = the same of p(place) + d_i
//! ```
//!
//! Of a part of many features fewer draws are fitted again, as many as a slider has time for; what the others move by is then
//! that of one of these.
//!
//! The values are exact at every place. The scatter is exact at home, where it is that of [`predict`](super::predict()) with
//! 200 draws. At another place it is exact for quantities with the same effect everywhere (squareness, scale, repeatability
//! of an approach) as far as the datums follow the part, and approximate for points of tables, whose uncertainties may differ
//! along an axis, for angular errors, whose levers change with the place, and for what is not known of growth. The fits are
//! repeated for every draw, so that a zone that the new place widens is not counted twice.

use super::cut::State;
use super::document::Outcome;
use super::room::room;
use super::shape::drawn;
use super::{CHECKED, GrowthModel, Options, Part, PredictDocument, Prepared};
use anyhow::{Result, bail};
use glam::{DVec3, Vec3};
use trueaxis_metrology::cores::*;
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;

/// Fits that a move has time for, and fewest draws fitted again.
const FITS: usize = 800;
const FEWEST: usize = 16;

/// Deviations of a drawn part from the stated one by feature and point, mm.
type Scatter = Vec<Vec<Vec3>>;

/// A part prepared at one place, to be moved to others.
#[derive(Debug)]
pub struct Live {
    machine: Machine,
    stated: Uncertainties,
    program: Program,
    part: Part,
    /// How its machine grows; none if no growth is stated.
    growth: Option<GrowthModel>,
    seed: u64,
    /// Values of every drawn part at home; empty if the machine states no uncertainty.
    home: Vec<Vec<f64>>,
    /// Of the draws that are fitted again.
    scatter: Vec<Scatter>,
}

impl Live {
    /// Draws the scatter of a part at its place, and keeps it.
    ///
    /// # Errors
    /// As [`predict`](super::predict()).
    pub fn new(machine: &Machine, stated: &Uncertainties, program: &Program, part: &Part, seed: u64) -> Result<Live> {
        let prepared = Prepared::new(machine, stated, program, part)?;
        let model = prepared.model(machine, part);
        let home = model.points(&model.nothing(), State::Corrected)?;
        let apart = |number: u64| {
            let points = model.points(&model.draw(seed, number), State::Corrected)?;
            let of_feature = |(own, home): (&Vec<DVec3>, &Vec<DVec3>)| {
                own.iter().zip(home).map(|(own, home)| (*own - *home).as_vec3()).collect()
            };
            let scatter = points.iter().zip(&home).map(of_feature).collect();
            Ok((model.values(&points)?, scatter))
        };
        let draws = if model.terms.all.is_empty() { 0 } else { CHECKED };
        let drawn = (0..draws).into_par_iter().map(apart).collect::<Result<Vec<(Vec<f64>, Scatter)>>>()?;
        let (home, mut scatter): (Vec<Vec<f64>>, Vec<Scatter>) = drawn.into_iter().unzip();
        scatter.truncate((FITS / part.features.len().max(1)).max(FEWEST));
        let (machine, stated, program, part) = (machine.clone(), stated.clone(), program.clone(), part.clone());
        let growth = GrowthModel::of(&machine, None).ok();
        Ok(Live { machine, stated, program, part, growth, seed, home, scatter })
    }

    /// The part on a machine that grows by this model in place of its `[axis.X.thermal]`.
    pub fn growing_by(self, model: GrowthModel) -> Live {
        Live { growth: Some(model), ..self }
    }

    /// Lowest and highest place of the program's zero in the machine along X, Y and Z until the program leaves the travel, mm.
    /// With rotary axes, only near the first place: they carry X, Y and Z along.
    ///
    /// # Errors
    /// A machine without a kinematic chain.
    pub fn range_mm(&self) -> Result<[[f64; 2]; 3]> {
        let room = room(&self.machine, &self.program, &self.part)?;
        Ok(std::array::from_fn(|k| room[k].map(|way| self.part.at_mm[k] + way)))
    }

    /// Temperature of the machine at the first place, °C: the part's, or that of its tables; none if it states no growth, or
    /// follows a record.
    pub fn machine_c(&self) -> Option<f64> {
        let reference_c = self.machine.settings.reference_temperature_c;
        let is_recorded = self.part.growth.as_ref().is_some_and(|growth| growth.is_recorded());
        self.growth.as_ref().filter(|_| !is_recorded)?;
        Some(self.part.temperature.machine_c.unwrap_or(reference_c))
    }

    /// The part with its program's zero at `at_mm` of the machine, whose temperature is `machine_c` from now on, °C; further
    /// set-ups stay where they are. The budgets are empty.
    ///
    /// # Errors
    /// A place at which the program leaves the travel; a temperature of a machine without growth, or that no machine has.
    pub fn at(&self, at_mm: [f64; 3], machine_c: Option<f64>) -> Result<PredictDocument> {
        let Live { machine, stated, program, seed, .. } = self;
        let mut part = Part { at_mm, ..self.part.clone() };
        if let Some(celsius) = machine_c {
            let model = self.growth.clone().map_or_else(|| GrowthModel::of(machine, None), Ok)?;
            part = part.at_temperature(model, celsius)?;
        }
        let prepared = Prepared::new(machine, stated, program, &part)?;
        let model = prepared.model(machine, &part);
        let nothing = model.nothing();
        let uncorrected = model.points(&nothing, State::Uncorrected)?;
        let corrected = model.points(&nothing, State::Corrected)?;
        let counts = |points: &[Vec<DVec3>]| points.iter().map(Vec::len).collect::<Vec<_>>();
        if let Some(first) = self.scatter.first()
            && first.iter().map(Vec::len).ne(counts(&corrected))
        {
            bail!("found features with other points than at the first place, needed the same ones");
        }
        let values = [model.values(&uncorrected)?, model.values(&corrected)?];
        let moved = |scatter: &Scatter| {
            let of_feature = |(own, apart): (&Vec<DVec3>, &Vec<Vec3>)| {
                own.iter().zip(apart).map(|(own, apart)| *own + apart.as_dvec3()).collect()
            };
            model.values(&corrected.iter().zip(scatter).map(of_feature).collect::<Vec<Vec<DVec3>>>())
        };
        let draws = self.scatter.par_iter().map(moved).collect::<Result<Vec<_>>>()?;
        let value = |number: usize, index: usize| {
            let again = number % draws.len();
            self.home[number][index] + draws[again][index] - self.home[again][index]
        };
        let outcome = |index: usize| Outcome {
            values: (0..self.home.len()).map(|number| value(number, index)).collect(),
            cut: true,
            contributions: vec![0.0; model.terms.all.len()],
        };
        let outcomes = if draws.is_empty() { Vec::new() } else { (0..values[1].len()).map(outcome).collect() };
        let options = Options { trials: CHECKED, seed: *seed };
        let document =
            PredictDocument::new(&model, program, options, ([&values[0], &values[1], &values[1]], None), outcomes);
        let shapes = drawn(&model, [&uncorrected, &corrected, &corrected], &document);
        Ok(PredictDocument { shapes, ..document })
    }
}
