//! What is not known of the growth.

use super::model::{By, Lines};
use super::record::Reading;
use super::{Expansion, Growth};
use crate::uncertainty::terms::{Along, Counts, Effect, Terms};
use trueaxis::machine::Axis;
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;

/// Change of a sensor that gives the derivative of the growth with respect to it, K: plausible in any model.
const STEP_K: f64 = 0.1;

/// Length over which a slope counts beside an offset, mm.
const LEVER: f64 = 100.0;

/// Name of the term of the part's own temperature, which no axis shows: [`part_length`] has its effect.
const PART: &str = "part temperature";

/// Adds the uncertain quantities of the growth in the middle of the time in which a part is cut, and that of the part's own
/// temperature.
pub(in crate::predict) fn add_terms(
    terms: &mut Terms,
    (machine, stated): (&Machine, &Uncertainties),
    growth: Option<(&Growth, [f64; 2])>,
    part: Option<&Expansion>,
) {
    let growth_known = stated.instrument.sensor_k.is_some() || stated.axes.iter().any(|axis| axis.growth.is_some());
    let is_known = !terms.all.is_empty() || growth_known;
    if let Some((growth, [first, last])) = growth {
        growth.add_terms(terms, machine, stated, 0.5 * (first + last));
    }
    if let Some(part) = part {
        let key = "temperature.part_u_k of the part's file";
        terms.put(key.into(), PART.into(), part.u_k, f64::INFINITY, |_| Effect::Along(Vec::new()));
    }
    // A thermal.toml or a part's temperature alone allow no verdict on a machine of which nothing is known.
    if !is_known {
        terms.all.clear();
        terms.keys.clear();
    }
}

/// Lengths of a part when it is measured, as a share of those when it is cut; `values` of the terms in units of their standard
/// uncertainties.
pub(in crate::predict) fn part_length(part: Option<&Expansion>, terms: &Terms, values: &[Vec<f64>]) -> f64 {
    let Some(part) = part else { return 1.0 };
    let drawn = terms.all.iter().zip(values).find(|(term, _)| term.name == PART);
    let z = drawn.and_then(|(_, values)| values.first()).copied().unwrap_or(0.0);
    Expansion { celsius: part.celsius + z * part.u_k.unwrap_or(0.0), ..*part }.measured()
}

impl Growth {
    fn add_terms(&self, terms: &mut Terms, machine: &Machine, stated: &Uncertainties, middle_s: f64) {
        let instrument = &stated.instrument;
        let of = instrument.degrees_of_freedom.unwrap_or(f64::INFINITY);
        let names = match self.model.sensors() {
            [] => vec![String::from("temperature sensor")],
            sensors => sensors.iter().map(|name| format!("temperature sensor {name}")).collect(),
        };
        let sensor = instrument.sensor_k;
        if sensor.is_none() {
            terms.not_stated.push("uncertainty.sensor_k".into());
        }
        for (index, name) in names.into_iter().enumerate() {
            let along = self.per_kelvin(index, middle_s);
            if let Some(u) = sensor.filter(|_| !along.is_empty()) {
                let effect = |u: f64| Effect::Along(along.iter().map(|one| one.times(u)).collect());
                terms.put(String::new(), name, Some(u), of, effect);
            }
        }
        match &self.model.by {
            By::Temperature(per_kelvin) => {
                let middle = self.kelvin(middle_s);
                let linear = machine.settings.axes.iter().filter(|own| !own.axis.is_rotary());
                let expand: Vec<_> = linear.filter(|own| own.thermal.expansion_per_k != 0.0).collect();
                let (key, missing) = ("uncertainty.expansion_um_per_m_k", instrument.expansion_per_k.is_none());
                if missing && !expand.is_empty() && !terms.not_stated.iter().any(|own| own == key) {
                    terms.not_stated.push(key.into());
                }
                if let Some(u) = instrument.expansion_per_k.filter(|_| !expand.is_empty()) {
                    let scaled = |u: f64, axis: Axis, datum: f64| Along {
                        axis,
                        constant: 0.0,
                        per_length: u,
                        datum,
                        counts: Counts::Always,
                    };
                    terms.put(String::new(), "expansion while cutting".into(), Some(u * middle.abs()), of, |u| {
                        Effect::Along(expand.iter().map(|own| scaled(u, own.axis, own.thermal.datum)).collect())
                    });
                }
                for own in &machine.settings.axes {
                    let axis = stated.of(own.axis);
                    let found = axis.and_then(|axis| axis.growth);
                    let of = axis.and_then(|axis| axis.degrees_of("growth")).unwrap_or(f64::INFINITY);
                    if found.is_some() || per_kelvin[own.axis.index()][0] != 0.0 {
                        let unit = if own.axis.is_rotary() { "urad" } else { "um" };
                        let key = format!("axis.{}.uncertainty.growth_{unit}", own.axis.letter());
                        terms.put(key, name_of(own.axis), found, of, |u| shifted(own.axis, u));
                    }
                }
            }
            By::Sensors(own) => {
                for (axis, found) in &own.axes {
                    let unit = if axis.is_rotary() { "urad" } else { "um" };
                    let key = format!("axis.{}.uncertainty_{unit} of thermal.toml", axis.letter());
                    let found = found.map(|u| if axis.is_rotary() { u.to_radians() } else { u });
                    terms.put(key, name_of(*axis), found, f64::INFINITY, |u| shifted(*axis, u));
                }
            }
        }
        terms.warnings.extend(self.warnings());
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.is_beyond {
            warnings
                .push("a temperature is beyond the knots of thermal.toml: the growth at the last knot counts".into());
        }
        if let Some(unused) = self.record.as_ref().map(|record| &record.unused).filter(|unused| !unused.is_empty()) {
            warnings.push(format!("the model of the growth does not take {} of the record", unused.join(", ")));
        }
        warnings
    }

    /// Kelvin above the reference of the machine's one temperature.
    fn kelvin(&self, t_s: f64) -> f64 {
        self.temperatures(t_s).first().map_or(0.0, |celsius| celsius - self.model.reference_c)
    }

    /// What one kelvin at a sensor adds to the axes, upwards or downwards, whichever is more: beyond the ends of a curve the
    /// growth is held. Nothing where it has no effect.
    fn per_kelvin(&self, sensor: usize, t_s: f64) -> Vec<Along> {
        let ways = [STEP_K, -STEP_K].map(|step_k| self.over(step_k, sensor, t_s));
        let size = |of: &[Along]| of.iter().map(|one| one.constant.abs() + LEVER * one.per_length.abs()).sum::<f64>();
        let [up, down] = ways;
        if size(&up) >= size(&down) { up } else { down }
    }

    /// The same over one step; nothing if the readings then are not plausible.
    fn over(&self, step_k: f64, sensor: usize, t_s: f64) -> Vec<Along> {
        let warmer = |reading: &Reading| {
            let mut warmer = reading.clone();
            warmer.temperatures_c.iter_mut().skip(sensor).take(1).for_each(|celsius| *celsius += step_k);
            warmer
        };
        let readings: Vec<Reading> = self.readings.iter().map(warmer).collect();
        let Ok((lines, _)) = self.model.lines(&readings) else { return Vec::new() };
        let warmer: Lines = Growth { lines, ..self.clone() }.at(t_s);
        let pairs = Axis::ALL.into_iter().zip(warmer.into_iter().zip(self.at(t_s)));
        let along = pairs.map(|(axis, (warm, own))| {
            let [constant, per_length] = [warm.offset - own.offset, warm.slope - own.slope].map(|by| by / step_k);
            // Positions and growth of a rotary axis are in degrees, its errors in rad.
            let unit = if axis.is_rotary() { 1f64.to_radians() } else { 1.0 };
            let (constant, per_length) = (unit * constant, unit * per_length);
            Along { axis, constant, per_length, datum: own.datum, counts: Counts::Always }
        });
        along.filter(|one| one.constant != 0.0 || one.per_length != 0.0).collect()
    }
}

fn name_of(axis: Axis) -> String {
    format!("growth of {}", axis.letter())
}

/// A constant error along an axis, mm or rad.
fn shifted(axis: Axis, constant: f64) -> Effect {
    Effect::Along(vec![Along { axis, constant, per_length: 0.0, datum: 0.0, counts: Counts::Always }])
}
