//! The uncertain quantities and their effects.

use crate::contributions::Source;
use crate::model::range;
use anyhow::{Result, bail};
use trueaxis::machine::{Axis, AxisSettings};
use trueaxis_metrology::uncertainty::{Correlations, Pair};
use trueaxis_tables::uncertainty::{AxisUncertainty, Instrument, Uncertainties};
use trueaxis_tables::{Machine, Table};

/// Standard uncertainty of ε in a cosine error, ε = m²/(2L²), m normal about zero: the root mean square of m² is √3 u².
const SQUARED_NORMAL: f64 = 1.732_050_807_568_877_2;

/// Travel in which an error of an axis along itself counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Counts {
    Always,
    /// In negative travel.
    Reverse,
    /// Always, with another value for every approach.
    Approach,
}

/// Error of an axis along itself: constant + per_length (q − datum), of unit variance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Along {
    pub(crate) axis: Axis,
    /// Constant error, mm or rad.
    pub(crate) constant: f64,
    /// Error by length, mm per mm.
    pub(crate) per_length: f64,
    pub(crate) datum: f64,
    pub(crate) counts: Counts,
}

/// Effect of a quantity.
#[derive(Clone, Debug)]
pub(crate) enum Effect {
    /// Error along one axis, or along several with one sign and size for all.
    Along(Vec<Along>),
    /// Misalignment m over a length L: always reads short, by m²/(2L²); `per_length` is its root mean square, the second
    /// number u(m)/L.
    Cosine(Along, f64),
    /// Points of a column, independent of each other: standard uncertainty of each, mm or rad.
    Points { axis: Axis, component: usize, of: Vec<f64> },
    /// A location error: standard uncertainty, mm or rad.
    Location(Source, f64),
    /// Of a part's set-up or tool, or of a drive, whose effect the points of the part have.
    #[cfg_attr(not(feature = "simulation"), expect(dead_code, reason = "predicted parts alone have it"))]
    Part,
}

/// A quantity with its name and the degrees of freedom of its standard uncertainty.
#[derive(Clone, Debug)]
pub(crate) struct Term {
    pub(crate) name: String,
    pub(crate) effect: Effect,
    pub(crate) degrees_of_freedom: f64,
}

/// The correlated terms.
#[derive(Default)]
pub(crate) struct Correlated {
    pub(super) pairs: Vec<Pair>,
    /// Of the terms in their order.
    pub(crate) terms: Correlations,
}

/// All uncertain quantities of a machine.
pub(crate) struct Terms {
    pub(crate) all: Vec<Term>,
    /// Full keys of terms with their indices.
    pub(crate) keys: Vec<(String, usize)>,
    pub(crate) correlated: Correlated,
    /// Keys without a value, which count as zero.
    pub(crate) not_stated: Vec<String>,
    pub(crate) warnings: Vec<String>,
}

/// Standard uncertainty of an instrument per length along an axis, mm per mm: calibration, temperature, expansion.
///
/// `expansion_per_k` is the machine's; misalignment also needs the length `travel_mm`.
pub fn per_length(instrument: &Instrument, expansion_per_k: f64, travel_mm: f64) -> f64 {
    let misalignment = instrument.misalignment.map_or(0.0, |m| SQUARED_NORMAL * 0.5 * (m / travel_mm).powi(2));
    let parts = [
        instrument.device_per_length.unwrap_or(0.0),
        expansion_per_k * instrument.temperature_k.unwrap_or(0.0),
        instrument.temperature_difference_k.unwrap_or(0.0) * instrument.expansion_per_k.unwrap_or(0.0),
        misalignment,
    ];
    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// Standard uncertainty of a single reading, mm: resolution and environmental variation.
pub fn reading(instrument: &Instrument) -> f64 {
    instrument.device.unwrap_or(0.0).hypot(instrument.eve.unwrap_or(0.0))
}

impl Terms {
    /// # Errors
    /// No uncertainty above zero.
    pub(crate) fn new(machine: &Machine, stated: &Uncertainties) -> Result<Terms> {
        let mut terms = Terms::stated(machine, stated);
        terms.correlate(&stated.correlations);
        if terms.all.is_empty() {
            bail!(
                "{}: found no standard uncertainty above zero, needed [uncertainty], [uncertainty.location] or \
                 [axis.X.uncertainty] in machine.toml",
                machine.settings.name
            );
        }
        Ok(terms)
    }

    /// The quantities, none if nothing above zero is stated; not yet [correlated](Terms::correlate).
    pub(crate) fn stated(machine: &Machine, stated: &Uncertainties) -> Terms {
        let mut terms = Terms {
            all: Vec::new(),
            keys: Vec::new(),
            correlated: Correlated::default(),
            not_stated: Vec::new(),
            warnings: Vec::new(),
        };
        terms.instrument(machine, &stated.instrument);
        let unstated: Vec<AxisUncertainty> =
            machine.settings.axes.iter().map(|own| AxisUncertainty::unstated(own.axis)).collect();
        for ((own, table), none) in machine.axes().zip(&unstated) {
            terms.axis(own, table, stated.of(own.axis).unwrap_or(none));
        }
        for source in Source::locations(machine) {
            let value = match source {
                Source::Squareness(which) => stated.location.squareness.get(which).copied().flatten(),
                Source::Location(axis, component) => {
                    let rotary = axis.index().checked_sub(Axis::A.index());
                    let errors = rotary.and_then(|rotary| stated.location.rotary.get(rotary));
                    errors.and_then(|errors| errors.get(component)).copied().flatten()
                }
                _ => None,
            };
            let key = format!("uncertainty.location.{}", source.name());
            let of = stated.location.degrees_of(&source.name()).unwrap_or(f64::INFINITY);
            terms.put(key, source.name(), value, of, |u| Effect::Location(source, u));
        }
        terms
    }

    /// Adds a quantity if it is stated, otherwise its key to those not stated. Zero counts as stated but has no effect.
    pub(crate) fn put(
        &mut self,
        key: String,
        name: String,
        value: Option<f64>,
        of: f64,
        effect: impl FnOnce(f64) -> Effect,
    ) {
        match value {
            None => self.not_stated.push(key),
            Some(0.0) => {}
            Some(value) => {
                self.keys.push((key, self.all.len()));
                self.all.push(Term { name, effect: effect(value), degrees_of_freedom: of });
            }
        }
    }

    fn instrument(&mut self, machine: &Machine, stated: &Instrument) {
        let of = stated.degrees_of_freedom.unwrap_or(f64::INFINITY);
        let linear: Vec<_> = machine.axes().filter(|(own, _)| !own.axis.is_rotary()).collect();
        let by_length = |per_length: &dyn Fn(&AxisSettings) -> f64| {
            let along = |(own, _): &(&AxisSettings, Option<&Table>)| scaled(own, per_length(own));
            Effect::Along(linear.iter().map(along).collect())
        };
        let key = |key: &str| format!("uncertainty.{key}");
        let name = |name: &str| name.to_owned();
        self.put(key("device_um_per_m"), name("device, by length"), stated.device_per_length, of, |u| {
            by_length(&|_| u)
        });
        self.put(key("temperature_k"), name("machine temperature"), stated.temperature_k, of, |u| {
            by_length(&|own| own.thermal.expansion_per_k * u)
        });
        let without: Vec<String> = linear
            .iter()
            .filter(|(own, _)| own.thermal.expansion_per_k == 0.0)
            .map(|(own, _)| own.axis.letter().to_string())
            .collect();
        if stated.temperature_k.is_some_and(|u| u > 0.0) && !without.is_empty() {
            self.warnings.push(format!(
                "no thermal.expansion_um_per_m_k of {}: the temperature counts as zero there",
                without.join(", ")
            ));
        }
        let difference = stated.temperature_difference_k;
        let expansion = stated.expansion_per_k.zip(difference).map(|(u, difference)| u * difference.abs());
        let missing =
            if stated.expansion_per_k.is_some() { "temperature_difference_k" } else { "expansion_um_per_m_k" };
        self.put(key(missing), name("coefficient of expansion"), expansion, of, |u| by_length(&|_| u));
        for (own, table) in &linear {
            let letter = own.axis.letter();
            let [low, high] = range(own, *table);
            let inclined = stated.misalignment.map(|m| m / (high - low).max(f64::MIN_POSITIVE));
            let key = format!("uncertainty.misalignment_mm ({letter})");
            self.put(key, format!("misalignment {letter}"), inclined, of, |inclined| {
                Effect::Cosine(scaled(own, SQUARED_NORMAL * 0.5 * inclined * inclined), inclined)
            });
            let Some(table) = table.filter(|table| table.given.get(own.axis.index()) == Some(&true)) else { continue };
            for (key, name, u) in [("device_um", "device", stated.device), ("eve_um", "environment", stated.eve)] {
                self.put(format!("uncertainty.{key} ({letter})"), format!("{name} {letter}"), u, of, |u| {
                    Effect::Points { axis: own.axis, component: own.axis.index(), of: vec![u; table.rows.len()] }
                });
            }
        }
    }

    fn axis(&mut self, own: &AxisSettings, table: Option<&Table>, stated: &AxisUncertainty) {
        let (axis, letter) = (own.axis, own.axis.letter());
        let of = |name: &str| stated.degrees_of(name).unwrap_or(f64::INFINITY);
        let key = |key: &str| format!("axis.{letter}.uncertainty.{key}");
        if !axis.is_rotary() {
            self.put(key("scale_ppm"), format!("scale {letter}"), stated.scale, of("scale"), |u| {
                Effect::Along(vec![scaled(own, u)])
            });
        }
        let constant = |constant: f64, counts: Counts| {
            Effect::Along(vec![Along { axis, constant, per_length: 0.0, datum: 0.0, counts }])
        };
        self.put(key("backlash"), format!("backlash {letter}"), stated.backlash, of("backlash"), |u| {
            constant(u, Counts::Reverse)
        });
        self.put(
            key("repeatability"),
            format!("repeatability {letter}"),
            stated.repeatability,
            of("repeatability"),
            |u| constant(u, Counts::Approach),
        );
        for (component, along) in Axis::ALL.into_iter().enumerate() {
            let name = format!("E{}{letter}", along.letter());
            let given = table.is_some_and(|table| table.given.get(component) == Some(&true));
            let rows = table.map_or(0, |table| table.rows.len());
            let points: Option<Vec<f64>> = (0..rows).map(|row| stated.of_point(component, row)).collect();
            let said = stated.columns.get(component).is_some_and(Option::is_some);
            match points.filter(|_| rows > 0) {
                Some(of_points) if of_points.iter().any(|u| *u > 0.0) => {
                    let effect = Effect::Points { axis, component, of: of_points };
                    let degrees_of_freedom = of(&name);
                    self.all.push(Term { name: format!("points {name}"), effect, degrees_of_freedom });
                }
                Some(_) => {}
                None if said => {
                    self.warnings.push(format!("axis {letter} has no table: the uncertainty of {name} counts as zero"));
                }
                None if given => self.not_stated.push(key(&name)),
                None => self.not_stated.push(format!("{} (not in the table either)", key(&name))),
            }
        }
    }
}

fn scaled(own: &AxisSettings, per_length: f64) -> Along {
    Along { axis: own.axis, constant: 0.0, per_length, datum: own.thermal.datum, counts: Counts::Always }
}

impl Along {
    /// The error times a factor.
    pub(crate) fn times(self, factor: f64) -> Along {
        Along { constant: factor * self.constant, per_length: factor * self.per_length, ..self }
    }

    /// What the error adds to the axis' position, mm or degrees; `reverse`: 1 in negative travel, 0 in positive.
    pub(crate) fn moves(&self, position: f64, reverse: f64) -> f64 {
        let share = if self.counts == Counts::Reverse { reverse } else { 1.0 };
        let moved = share * self.at(position);
        if self.axis.is_rotary() { moved.to_degrees() } else { moved }
    }

    /// Error of unit variance at a position, mm or rad.
    pub(crate) fn at(&self, position: f64) -> f64 {
        self.constant + self.per_length * (position - self.datum)
    }
}
