//! The part's uncertainty before and after measurements.

use super::design::Readings;
use crate::predict::cut::State;
use crate::predict::unknowns::{Model, Unknown};
use anyhow::{Result, anyhow};
use trueaxis_metrology::cores::*;
use trueaxis_metrology::uncertainty::{Correlations, Draws, Interval, Update, Verdict, quantile, verdict_within};

/// Draws cut by exact transforms for a characteristic that does not follow its derivatives.
const CUT: u64 = 1000;
/// Streams of the readings' noise are apart from those of the machines.
const NOISE: u64 = 0x5eed;
/// Ends of the interval.
const ENDS: [f64; 2] = [0.025, 0.975];

/// A characteristic as predicted, mm.
#[derive(Clone, Debug)]
pub(super) struct Feature {
    pub(super) value: f64,
    pub(super) interval: Interval,
    pub(super) limits: [f64; 2],
    /// Whether parts cut by exact transforms gave the interval.
    pub(super) is_cut: bool,
    pub(super) derivatives: Vec<f64>,
    /// Effect of one standard uncertainty of each unknown, also where both directions widen a zone.
    pub(super) effects: Vec<f64>,
}

/// The part and all unknowns of its machine.
pub(super) struct Prior<'m> {
    pub(super) model: &'m Model<'m>,
    pub(super) unknowns: Vec<Unknown>,
    /// Of the unknowns.
    pub(super) correlations: Correlations,
    pub(super) features: Vec<Feature>,
    pub(super) trials: u64,
    pub(super) seed: u64,
}

/// Whether a verdict is possible.
pub(super) fn is_decided(interval: Interval, limits: [f64; 2]) -> bool {
    verdict_within(interval, limits) != Verdict::Undecided
}

impl Prior<'_> {
    /// What readings of unit variance leave.
    pub(super) fn update(&self, readings: &Readings) -> Option<Update> {
        let unit = |k: usize| (0..readings.len()).map(|j| f64::from(u8::from(j == k))).collect();
        Update::new(readings, &(0..readings.len()).map(unit).collect::<Vec<_>>(), &self.correlations)
    }

    /// The interval that a feature is expected to have: its parts scale with what is left of the uncertainty.
    pub(super) fn expected(&self, update: Option<&Update>, variances: &[f64], of: &Feature) -> Interval {
        let Some(update) = update else { return of.interval };
        let squares = |parts: &[f64]| parts.iter().map(|part| part * part).sum::<f64>();
        // Of a zone only the effect of each unknown by itself is at hand, not how the points move: what the readings leave of
        // each variance counts, not what they leave of the covariances. With the movement A of the points by the unknowns it
        // would be tr(A P Aᵀ) / tr(A Aᵀ). This ranks the sets only: the chosen one is drawn and cut.
        let share = if of.is_cut {
            let left: f64 = of.effects.iter().zip(variances).map(|(part, left)| part * part * left).sum();
            left / squares(&of.effects).max(f64::MIN_POSITIVE)
        } else {
            update.variance(&of.derivatives) / update.before(&of.derivatives).max(f64::MIN_POSITIVE)
        };
        let end = |end: f64| of.value + share.min(1.0).sqrt() * (end - of.value);
        Interval { low: end(of.interval.low), high: end(of.interval.high) }
    }

    /// The intervals after these readings, from draws: z − ẑ in place of z.
    pub(super) fn after(&self, readings: &Readings) -> Result<Vec<Interval>> {
        let Some(update) = self.update(readings) else {
            return Ok(self.features.iter().map(|of| of.interval).collect());
        };
        let weights: Vec<Vec<f64>> = self.features.iter().map(|of| update.weights(&of.derivatives)).collect();
        let draw = |number: u64| self.draw(&update, &weights, number);
        let drawn: Vec<Vec<Option<f64>>> = (0..self.trials).into_par_iter().map(draw).collect::<Result<_>>()?;
        let interval = |index: usize| {
            let mut values: Vec<f64> = drawn.iter().filter_map(|values| values[index]).collect();
            values.sort_unstable_by(f64::total_cmp);
            let [low, high] = ENDS.map(|p| quantile(&values, p));
            Interval { low, high }
        };
        Ok((0..self.features.len()).map(interval).collect())
    }

    /// The values of a drawn machine that is measured.
    fn draw(&self, update: &Update, weights: &[Vec<f64>], number: u64) -> Result<Vec<Option<f64>>> {
        let drawn = self.model.draw(self.seed, number);
        let z: Vec<f64> = self.unknowns.iter().map(|unknown| drawn.plain(unknown)).collect();
        let mut noise = Draws::new(self.seed ^ NOISE, number);
        let normal: Vec<f64> = (0..update.readings()).map(|_| noise.normal()).collect();
        let read = update.read(&z, &normal);
        let mut cut = None;
        if number < CUT && self.features.iter().any(|of| of.is_cut) {
            let mut left = drawn.clone();
            for (unknown, (z, known)) in self.unknowns.iter().zip(z.iter().zip(update.estimate(&read))) {
                left.set(unknown, z - known);
            }
            cut = Some(self.model.cut(&left, State::Everything)?);
        }
        let value = |(index, of): (usize, &Feature)| {
            if of.is_cut {
                return cut.as_ref().map(|cut| cut[index]);
            }
            let parts = self.unknowns.iter().zip(&of.derivatives).map(|(unknown, d)| d * drawn.of(unknown));
            let known: f64 = weights[index].iter().zip(&read).map(|(weight, read)| weight * read).sum();
            Some(of.value + parts.sum::<f64>() - known)
        };
        Ok(self.features.iter().enumerate().map(value).collect())
    }

    /// The terms that keep a feature's uncertainty after readings, largest share first: name, share without what they have in
    /// common, and whether a reading depends on it or on one that it is correlated with.
    pub(super) fn left(&self, readings: &Readings, of: &Feature) -> Vec<(String, f64, bool)> {
        let update = self.update(readings);
        let variances = update.as_ref().map(|update| update.variances());
        let mut terms = vec![(0.0, false); self.model.terms.all.len()];
        for (k, (unknown, effect)) in self.unknowns.iter().zip(&of.effects).enumerate() {
            let left = variances.as_ref().map_or(1.0, |all| all[k]);
            terms[unknown.term].0 += effect * effect * left;
            terms[unknown.term].1 |= update.as_ref().is_some_and(|update| update.sees(k));
        }
        let whole: f64 = terms.iter().map(|(left, _)| left).sum();
        let named = self.model.terms.all.iter().zip(terms).filter(|(_, (left, _))| *left > 0.0);
        let mut named: Vec<(String, f64, bool)> =
            named.map(|(term, (left, seen))| (term.name.clone(), left / whole, seen)).collect();
        trueaxis_metrology::order::sort_by_number(&mut named, |one| -one.1);
        named
    }
}

/// The characteristics of a document with their derivatives.
pub(super) fn features(
    predicted: &[crate::predict::Predicted],
    limits: &[[f64; 2]],
    derivatives: impl Fn(usize) -> [Vec<f64>; 2],
) -> Result<Vec<Feature>> {
    let of = |(index, of): (usize, &crate::predict::Predicted)| {
        let known = of.known.as_ref().ok_or_else(|| anyhow!("found a part without uncertainties"))?;
        let [derivatives, effects] = derivatives(index);
        let Interval { low, high } = known.interval_um;
        Ok(Feature {
            value: 1e-3 * of.everything_um.unwrap_or(of.corrected_um),
            interval: Interval { low: 1e-3 * low, high: 1e-3 * high },
            limits: limits[index],
            is_cut: known.parts_cut.is_some(),
            derivatives,
            effects,
        })
    };
    predicted.iter().enumerate().map(of).collect()
}
