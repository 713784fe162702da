//! Characteristics to which a correction gives another verdict: with the same uncertainty about the value without it.

use super::prior::Prior;
use crate::predict::cut::{Cut, State};
use crate::predict::servo::{Alone, Ran, alone};
use crate::predict::unknowns::Model;
use crate::predict::verdict::verdict_of;
use crate::predict::{PredictDocument, ServoDocument};
use anyhow::Result;
use trueaxis_metrology::uncertainty::Interval;
use trueaxis_sim::program::Program;

/// What to say of them: of the correction of the geometry, and with the servo of everything else that is on.
pub(super) fn corrected(predicted: &PredictDocument, prior: &Prior<'_>, program: &Program) -> Result<Vec<String>> {
    let value = |index: usize| {
        let of = &predicted.features[index];
        of.everything_um.unwrap_or(of.corrected_um)
    };
    // Verdict where the value is this one, um.
    let verdict = |index: usize, um: f64| {
        let (own, by) = (&prior.features[index], 1e-3 * (um - value(index)));
        verdict_of(Interval { low: own.interval.low + by, high: own.interval.high + by }, own.limits)
    };
    let mut said = Vec::new();
    for (index, of) in predicted.features.iter().enumerate() {
        let [without, with] = [of.uncorrected_um, of.corrected_um].map(|um| verdict(index, um));
        if without != with {
            said.push(said_of(&of.title(), with, "with the correction on", "without it", without));
        }
    }
    let Some(servo) = &predicted.servo else { return Ok(said) };
    let changed: Vec<usize> = (0..predicted.features.len())
        .filter(|index| verdict(*index, value(*index)) != verdict(*index, predicted.features[*index].corrected_um))
        .collect();
    let parts = if changed.is_empty() { Vec::new() } else { parts(prior.model, program, servo)? };
    for index in changed {
        let of = &predicted.features[index];
        let [with, without] = [value(index), of.corrected_um].map(|um| verdict(index, um));
        let enough = parts.iter().filter(|(_, values)| verdict(index, 1e3 * values[index]) == with);
        let enough: Vec<&str> = enough.map(|(name, _)| *name).collect();
        let enough = match (parts.is_empty(), enough.is_empty()) {
            (true, _) => String::new(),
            (_, true) => "; no part of it does that by itself".into(),
            _ => format!("; by itself does that: {}", enough.join(", ")),
        };
        let alone = "with the correction of the geometry alone";
        said.push(said_of(&of.title(), with, "with everything on", alone, without) + &enough);
    }
    Ok(said)
}

/// Values with every part of what acts on the servo by itself, mm.
fn parts(model: &Model<'_>, program: &Program, servo: &ServoDocument) -> Result<Vec<(&'static str, Vec<f64>)>> {
    let ran = Ran { part: model.part, program, cuts: model.cuts, rate_hz: servo.rate_hz };
    let value = |Alone { name, errors }: Alone| {
        let mut cuts: Vec<Cut> = model.cuts.to_vec();
        for (point, error) in cuts.iter_mut().flat_map(|cut| &mut cut.points).zip(errors) {
            if let Some(error) = error {
                point.everything = point.after(error);
            }
        }
        Ok((name, Model { cuts: &cuts, ..*model }.cut(&model.nothing(), State::Everything)?))
    };
    alone(model.machine, &ran)?.into_iter().map(value).collect()
}

fn said_of(title: &str, verdict: &str, with: &str, without: &str, otherwise: &str) -> String {
    let of = |verdict: &str| if verdict == "undecided" { format!("is {verdict}") } else { verdict.to_owned() };
    // "bore, size": the subject of a sentence.
    let [subject, verdict, otherwise] = [title.replacen(", ", " ", 1), of(verdict), of(otherwise)];
    format!("{subject} {verdict} {with}; {without}, it {otherwise}")
}
