//! What is not known of the machine: one number of unit variance for every quantity, and the part that a set of them cuts.

use super::characteristic::value;
use super::cut::{Cut, Point, State};
use super::fit::{Fitted, Nominal};
use super::fixture::{Moved, Moves};
use super::part::{Part, Tolerance};
use super::temperature::part_length;
use crate::uncertainty::monte_carlo::{machine_of, values};
use crate::uncertainty::terms::{Along, Counts, Effect, Term, Terms};
use anyhow::{Result, anyhow};
use glam::DVec3;
use trueaxis::machine::wraps;
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// Points of a table beyond those around the part that an interpolation depends on.
const BEYOND: usize = 2;

/// A machine, a part on it, and what is not known of the machine.
pub(super) struct Model<'m> {
    pub(super) machine: &'m Machine,
    pub(super) part: &'m Part,
    pub(super) cuts: &'m [Cut],
    pub(super) nominal: &'m [Nominal],
    pub(super) terms: &'m Terms,
    /// What the terms of set-ups, tools and drives move, in their order.
    pub(super) moves: &'m [Moves],
}

/// Where an unknown is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unknown {
    /// Index of its term.
    pub(super) term: usize,
    /// Index of its value within the term, or of the feature that an approach cuts.
    pub(super) index: usize,
    /// Whether its effect goes with its square: a cosine error.
    pub(super) squared: bool,
}

/// Values of the unknowns in units of their standard uncertainties.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// By term; what differs from approach to approach is 0 here.
    values: Vec<Vec<f64>>,
    /// By term and feature; empty for terms that do not differ.
    approaches: Vec<Vec<f64>>,
}

impl Drawn {
    /// The value of an unknown, squared where its effect is.
    pub(super) fn of(&self, unknown: &Unknown) -> f64 {
        let z = self.plain(unknown);
        if unknown.squared { z * z } else { z }
    }

    /// The value of an unknown.
    pub(super) fn plain(&self, unknown: &Unknown) -> f64 {
        let approaches = &self.approaches[unknown.term];
        let all = if approaches.is_empty() { &self.values[unknown.term] } else { approaches };
        all.get(unknown.index).copied().unwrap_or(0.0)
    }

    /// Changes the value of an unknown.
    pub(super) fn set(&mut self, unknown: &Unknown, z: f64) {
        let approaches = &mut self.approaches[unknown.term];
        let all = if approaches.is_empty() { &mut self.values[unknown.term] } else { approaches };
        if let Some(value) = all.get_mut(unknown.index) {
            *value = z;
        }
    }

    /// The values that do not differ from approach to approach, by term.
    pub(super) fn common(&self) -> &[Vec<f64>] {
        &self.values
    }
}

impl Model<'_> {
    /// Whether a term differs from approach to approach.
    pub(super) fn is_approach(&self, term: usize) -> bool {
        let along = |one: &Along| one.counts == Counts::Approach;
        matches!(&self.terms.all[term].effect, Effect::Along(axes) if axes.iter().any(along))
    }

    /// Draws all unknowns. A feature is one approach.
    pub(super) fn draw(&self, seed: u64, number: u64) -> Drawn {
        let mut draws = Draws::new(seed, number);
        let mut drawn =
            Drawn { values: values(self.terms, &mut draws), approaches: vec![Vec::new(); self.terms.all.len()] };
        for term in (0..self.terms.all.len()).filter(|term| self.is_approach(*term)) {
            drawn.values[term] = vec![0.0];
            let spread = draws.spread(self.terms.all[term].degrees_of_freedom);
            drawn.approaches[term] = self.cuts.iter().map(|_| spread * draws.normal()).collect();
        }
        drawn
    }

    /// All unknowns zero.
    pub(super) fn nothing(&self) -> Drawn {
        let count = |effect: &Effect| if let Effect::Points { of, .. } = effect { of.len() } else { 1 };
        let approaches = |term| if self.is_approach(term) { vec![0.0; self.cuts.len()] } else { Vec::new() };
        Drawn {
            values: self.terms.all.iter().map(|term| vec![0.0; count(&term.effect)]).collect(),
            approaches: (0..self.terms.all.len()).map(approaches).collect(),
        }
    }

    /// One unknown alone.
    pub(super) fn alone(&self, unknown: &Unknown, z: f64) -> Drawn {
        let mut drawn = self.nothing();
        drawn.set(unknown, z);
        drawn
    }

    /// The unknowns that can have an effect on the part.
    pub(super) fn unknowns(&self) -> Vec<Unknown> {
        self.unknowns_at(|axis, of| self.near(axis, of))
    }

    /// The unknowns of the whole machine.
    pub(super) fn all_unknowns(&self) -> Vec<Unknown> {
        self.unknowns_at(|_, of| (0..of.len()).filter(|row| of[*row] > 0.0).collect())
    }

    /// The unknowns, of tables those at these points.
    fn unknowns_at(&self, points: impl Fn(usize, &[f64]) -> Vec<usize>) -> Vec<Unknown> {
        let mut unknowns = Vec::new();
        for (term, of) in self.terms.all.iter().enumerate() {
            let indices: Vec<usize> = match &of.effect {
                Effect::Points { axis, of, .. } => points(axis.index(), of),
                Effect::Along(_) if self.is_approach(term) => (0..self.cuts.len()).collect(),
                _ => vec![0],
            };
            let squared = matches!(of.effect, Effect::Cosine(..));
            unknowns.extend(indices.into_iter().map(|index| Unknown { term, index, squared }));
        }
        unknowns
    }

    /// Points of an axis' table that the interpolation around the part depends on, without those known exactly.
    fn near(&self, axis: usize, of: &[f64]) -> Vec<usize> {
        let mut own = self.machine.axes().filter(|(own, _)| own.axis.index() == axis);
        let Some((own, Some(table))) = own.next() else { return Vec::new() };
        let sent = |cut: &Cut| -> Vec<f64> {
            cut.points.iter().flat_map(|point| [point.uncorrected.sent[axis], point.corrected.sent[axis]]).collect()
        };
        let sent: Vec<f64> = self.cuts.iter().flat_map(sent).collect();
        let low = sent.iter().copied().fold(f64::MAX, f64::min);
        let high = sent.iter().copied().fold(f64::MIN, f64::max);
        let (mut from, mut to) = (0, of.len());
        if !wraps(own.axis, table.rows.as_slice()) {
            from = table.rows.partition_point(|row| row.position <= low).saturating_sub(1 + BEYOND);
            to = (table.rows.partition_point(|row| row.position < high) + 1 + BEYOND).min(of.len());
        }
        (from..to).filter(|row| of[*row] > 0.0).collect()
    }

    /// Values of all tolerances of the part that this machine cuts, mm: exact transforms and fits.
    pub(super) fn cut(&self, drawn: &Drawn, state: State) -> Result<Vec<f64>> {
        self.values(&self.points(drawn, state)?)
    }

    /// The points of every feature that this machine cuts, mm, in coordinates of the program.
    pub(super) fn points(&self, drawn: &Drawn, state: State) -> Result<Vec<Vec<DVec3>>> {
        let (machine, along) = machine_of(self.machine, self.terms, &drawn.values);
        let geometry = Geometry::new(&machine, 0.0).map_err(|error| anyhow!("{error}"))?;
        let measured = part_length(self.part.temperature.part.as_ref(), self.terms, &drawn.values);
        let held: Vec<f64> = self.held(drawn);
        let of_drives = self.moves.iter().zip(&held).filter(|(of, _)| matches!(of, Moves::Drive));
        let drives: Vec<f64> = of_drives.map(|(_, z)| *z).collect();
        let of_feature = |(feature, (cut, nominal)): (usize, (&Cut, &Nominal))| {
            let scattered = self.approach(drawn, feature);
            let along = || along.iter().chain(&scattered);
            let moved = Moved::of(self.moves, &held, &self.part.setups, cut);
            let at = |point: &Point| {
                let error = cut.to_part * point.error(self.machine, &geometry, state, along(), &drives);
                measured * (point.nominal + error + moved.of_point(point, cut, nominal))
            };
            cut.points.iter().map(at).collect()
        };
        Ok(self.cuts.iter().zip(self.nominal).enumerate().map(of_feature).collect())
    }

    /// Values of all tolerances of the part with these points, mm.
    pub(super) fn values(&self, points: &[Vec<DVec3>]) -> Result<Vec<f64>> {
        if points.iter().flatten().any(|point| !point.is_finite()) {
            return Err(anyhow!(
                "{}: found a point that is not finite, needed finite errors",
                self.machine.settings.name
            ));
        }
        let at = |line: u32, error: anyhow::Error| anyhow!("{}:{line}: {error}", self.part.file.display());
        let fits = self.nominal.iter().zip(points).zip(&self.part.features);
        let fits =
            fits.map(|((nominal, points), feature)| nominal.fit(points).map_err(|error| at(feature.line, error)));
        let fitted = fits.collect::<Result<Vec<Fitted>>>()?;
        let of = |tolerance: &Tolerance| {
            value(tolerance, self.nominal, &fitted, points).map_err(|error| at(tolerance.line, error))
        };
        self.part.tolerances.iter().map(of).collect()
    }

    /// Indices of the terms of set-ups, tools and drives.
    pub(super) fn part_terms(&self) -> impl Iterator<Item = usize> + '_ {
        let is_part = |(index, term): (usize, &Term)| matches!(term.effect, Effect::Part).then_some(index);
        self.terms.all.iter().enumerate().filter_map(is_part)
    }

    /// Values of the quantities of set-ups, tools and drives.
    fn held(&self, drawn: &Drawn) -> Vec<f64> {
        self.part_terms().map(|term| drawn.values[term].first().copied().unwrap_or(0.0)).collect()
    }

    /// Errors of the axes along themselves in the approach of a feature.
    fn approach(&self, drawn: &Drawn, feature: usize) -> Vec<Along> {
        let mut found = Vec::new();
        for (term, approaches) in self.terms.all.iter().zip(&drawn.approaches) {
            if let (Effect::Along(axes), Some(z)) = (&term.effect, approaches.get(feature)) {
                found.extend(axes.iter().map(|one| one.times(*z)));
            }
        }
        found
    }
}
