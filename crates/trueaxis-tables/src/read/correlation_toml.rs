//! `[[uncertainty.correlation]]` of `machine.toml`.

use super::section::{KeyValue, Section};
use crate::error::FileError;
use crate::text::one_of;
use crate::uncertainty::{Correlation, Uncertainties};
use trueaxis_metrology::uncertainty::{Correlations, Pair};

/// A section with the lines of its keys.
struct Entry<'a> {
    between: KeyValue<Vec<&'a str>>,
    coefficient: KeyValue<f64>,
    pair: Pair,
}

/// All sections, in the order of the file; `stated`: everything else that the file states.
pub(super) fn read(uncertainty: &Section<'_>, stated: &Uncertainties) -> Result<Vec<Correlation>, FileError> {
    let sections = uncertainty.sections("correlation")?;
    if sections.is_empty() {
        return Ok(Vec::new());
    }
    let figures = stated.figures();
    let mut entries: Vec<Entry<'_>> = Vec::new();
    for section in sections {
        let entry = read_one(section, uncertainty, &figures)?;
        let same = |own: &&Entry<'_>| own.pair.0 == entry.pair.0;
        if let Some(first) = entries.iter().find(same) {
            let needed = format!("each pair once, this one is in line {}", first.between.line);
            return Err(uncertainty.wrong(&entry.between, needed));
        }
        entries.push(entry);
    }
    let pairs: Vec<Pair> = entries.iter().map(|entry| entry.pair).collect();
    Correlations::new(&pairs, &vec![f64::INFINITY; figures.len()]).map_err(|impossible| {
        let at = &entries[impossible.pair].coefficient;
        let names: Vec<&str> = impossible.members.iter().map(|member| figures[*member].0.as_str()).collect();
        let all = names.join(", ");
        let lowest = impossible.lowest;
        let needed = format!(
            "coefficients that {all} can have together: their matrix has the eigenvalue {lowest:.3}, and none may be \
             below zero"
        );
        uncertainty.wrong(at, needed)
    })?;
    let correlation = |entry: Entry<'_>| {
        let [a, b] = entry.pair.0.map(|place| figures[place].0.clone());
        Correlation { between: [a, b], coefficient: entry.pair.1 }
    };
    Ok(entries.into_iter().map(correlation).collect())
}

fn read_one<'a>(
    section: Section<'a>,
    uncertainty: &Section<'_>,
    figures: &[(String, Option<f64>)],
) -> Result<Entry<'a>, FileError> {
    let needed = "the keys of two standard uncertainties, like [\"axis.X.uncertainty.scale_ppm\", \
                  \"uncertainty.location.C0Y_urad\"]";
    let between = section.strings("between")?.ok_or_else(|| section.missing_here("between", needed))?;
    let [one, other] = between.value[..] else { return Err(section.wrong(&between, needed)) };
    let place = |key: &str| match figures.iter().position(|(own, _)| own == key) {
        Some(place) if figures[place].1.is_some_and(|u| u > 0.0) => Ok(place),
        Some(_) => Err(section.wrong(&between, format!("{key} stated above zero"))),
        None => Err(section.wrong(&between, refused(key, figures))),
    };
    let mut places = [place(one)?, place(other)?];
    if places[0] == places[1] {
        return Err(section.wrong(&between, "two different keys: a figure has the coefficient 1 with itself"));
    }
    places.sort_unstable();
    let needed = "a coefficient of correlation, -1 to 1";
    let coefficient = section.number("coefficient")?.ok_or_else(|| section.missing_here("coefficient", needed))?;
    if coefficient.value.abs() > 1.0 {
        return Err(uncertainty.wrong(&coefficient, needed));
    }
    section.finish(None)?;
    let pair = (places, coefficient.value);
    Ok(Entry { between, coefficient, pair })
}

/// What is needed in place of a key that has no coefficients.
fn refused(key: &str, figures: &[(String, Option<f64>)]) -> String {
    let (section, last) = key.rsplit_once('.').unwrap_or(("", key));
    let of_axis = section.starts_with("axis.") && section.ends_with(".uncertainty");
    let why = match last {
        _ if of_axis && last.starts_with('E') => "every point of a table has its own value",
        _ if of_axis && last.starts_with("repeatability") => "every approach has its own value",
        "device_um" | "eve_um" => "every point of a table has its own value",
        "misalignment_mm" => "every axis has its own value",
        "sensor_k" => "every sensor has its own value",
        _ => "",
    };
    let all = one_of(key, figures.iter().map(|(own, _)| own.as_str()), ", ");
    if why.is_empty() { all } else { format!("a single number, in place of {key}, of which {why}: {all}") }
}
