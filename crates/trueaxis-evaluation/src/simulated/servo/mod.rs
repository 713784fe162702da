//! Bound of the contour error along a program, over a family of plants: what the servo may do where its figures are not known
//! exactly.
//!
//! The plants are simulated, with the plugin as the machine's settings say. First the figures as stated, and each figure by
//! itself at either end. At every moment their effects on the contour error add up by assumption: that foresees the errors of
//! 4,000 plants drawn from the family without simulating them. The worst of each line are then simulated, and the errors of
//! the sums on these correct their forecast of the others. The bound is 1.15 times the worst error on the line.

mod bound;
mod document;
mod family;
mod feeds;
mod shown;
mod side_by_side;
mod superposed;

use bound::Plants;
use std::collections::BTreeMap;
use std::sync::Arc;
use trueaxis_sim::error::Result;
use trueaxis_sim::{Scenario, SimError};

pub use document::{Drawn, FeedFor, LineBound, ServoBound};
pub use family::Family;

/// Options of a prediction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// The family.
    pub family: Family,
    /// Plants drawn from the family and simulated beside the bound; 0: none.
    pub plants: usize,
    /// Seed of the plants drawn.
    pub seed: u64,
    /// Bound that the feed of every line is to keep, µm.
    pub feed_for_um: Option<f64>,
}

/// Computes the bound.
///
/// # Errors
/// A family out of range; a machine whose settings do not build at the scenario's rate; drives whose figures do not agree.
pub fn predict(scenario: Scenario, options: &Options) -> Result<ServoBound> {
    options.family.check()?;
    if let Some(wanted) = options.feed_for_um.filter(|wanted| !(*wanted > 0.0 && wanted.is_finite())) {
        let (what, found) = ("--feed-for".into(), format!("{wanted} µm"));
        return Err(SimError::Unsuited { what, found, needed: "a bound above 0 µm".into() });
    }
    let scenario = Arc::new(scenario);
    let plants = Plants::new(Arc::clone(&scenario), &options.family);
    let (bounds, simulated) = plants.bounds()?;
    let drawn = match options.plants {
        0 => None,
        count => Some(plants.worst(&Family::draw(options.seed, count))?),
    };
    let feeds = match options.feed_for_um {
        Some(wanted) => feeds::feeds(&scenario, &options.family, wanted, &bounds)?,
        None => BTreeMap::new(),
    };
    Ok(ServoBound::new(&scenario, options, &bounds, simulated, drawn.as_ref(), &feeds))
}
