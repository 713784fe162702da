//! `[[uncertainty.correlation]]` of a `machine.toml` whose figures change.

use crate::error::FileError;
use crate::finding::{Decision, uncertainty_keys};
use crate::origin::Origin;
use crate::uncertainty::{Correlation, Uncertainties};
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, Value};
use trueaxis_metrology::uncertainty::{Correlations, Pair};

/// Smallest coefficient that is written beside found values, unless the others contradict each other without it.
const WRITTEN: f64 = 0.1;
/// Decimals of a coefficient.
const DECIMALS: f64 = 1e4;
/// Factor by which coefficients are reduced as long as rounding and figures that stay make them contradict each other.
const LESS: f64 = 0.98;

/// A figure that is written.
struct Written {
    key: String,
    /// Share of the stated value in its deviation, and of the found one, in units of the standard uncertainty written.
    parts: [f64; 2],
}

impl Written {
    /// `None`: the decision writes no standard uncertainty, or the figure is none that can be correlated.
    fn of(decision: &Decision) -> Option<Written> {
        let u = decision.written?.uncertainty?;
        let stated = decision.stated.and_then(|stated| stated.uncertainty).unwrap_or(0.0);
        let found = decision.found.uncertainty.unwrap_or(0.0);
        let parts = [(1.0 - decision.share) * stated, decision.share * found].map(|part| part / u);
        let [key, _] = uncertainty_keys(&decision.key);
        parts.iter().all(|part| part.is_finite()).then_some(Written { key, parts })
    }
}

/// Coefficients after these decisions; `found`: those of the found values, by the keys of the values.
///
/// ```text
/// x = (1 − w) stated + w found        r u_x u_y = (1 − w_x)(1 − w_y) cov(stated) + w_x w_y cov(found)
/// ```
///
/// A figure that is replaced (w = 1) loses its coefficients with those that stay (w = 0).
fn after(known: &Uncertainties, decisions: &[Decision], found: &[Correlation]) -> (Vec<Correlation>, Vec<Correlation>) {
    let written: Vec<Written> = decisions.iter().filter_map(Written::of).collect();
    let touched =
        |key: &String| decisions.iter().any(|own| own.written.is_some() && uncertainty_keys(&own.key)[0] == *key);
    let parts = |key: &String| {
        let own = written.iter().find(|own| own.key == *key).map(|own| own.parts);
        own.unwrap_or(if touched(key) { [0.0; 2] } else { [1.0, 0.0] })
    };
    let same = |a: &[String; 2], b: &[String; 2]| a == b || a[0] == b[1] && a[1] == b[0];
    let (changed, kept): (Vec<Correlation>, Vec<Correlation>) =
        known.correlations.iter().cloned().partition(|own| own.between.iter().any(touched));
    let mut new: Vec<Correlation> = Vec::new();
    let found = found.iter().map(|own| {
        let between = own.between.each_ref().map(|key| uncertainty_keys(key)[0].clone());
        (1, Correlation { between, ..*own })
    });
    for (which, own) in changed.into_iter().map(|own| (0, own)).chain(found) {
        let [a, b] = own.between.each_ref().map(|key| parts(key)[which]);
        let coefficient = own.coefficient * a * b;
        match new.iter_mut().find(|other| same(&other.between, &own.between)) {
            Some(other) => other.coefficient += coefficient,
            None => new.push(Correlation { coefficient, ..own }),
        }
    }
    (kept, new)
}

/// The new coefficients as they are written: the large ones, or all if the large ones contradict each other or those that stay.
fn settled(kept: &[Correlation], new: &[Correlation]) -> Vec<Correlation> {
    let rounded = |factor: f64, least: f64| -> Vec<Correlation> {
        let of = |own: &Correlation| {
            let coefficient = (factor * own.coefficient.clamp(-1.0, 1.0) * DECIMALS).round() / DECIMALS;
            Correlation { coefficient, ..own.clone() }
        };
        new.iter().map(of).filter(|own| own.coefficient != 0.0 && own.coefficient.abs() >= factor * least).collect()
    };
    let large = rounded(1.0, WRITTEN);
    if is_possible(kept, &large) {
        return large;
    }
    let mut factor = 1.0;
    loop {
        let all = rounded(factor, 0.0);
        if all.is_empty() || is_possible(kept, &all) {
            return all;
        }
        factor *= LESS;
    }
}

fn is_possible(kept: &[Correlation], new: &[Correlation]) -> bool {
    let all = || kept.iter().chain(new);
    let mut keys: Vec<&String> = all().flat_map(|own| &own.between).collect();
    keys.sort_unstable();
    keys.dedup();
    let place = |key: &String| keys.iter().position(|own| *own == key).unwrap_or(0);
    let pairs: Vec<Pair> = all().map(|own| (own.between.each_ref().map(place), own.coefficient)).collect();
    Correlations::new(&pairs, &vec![f64::INFINITY; keys.len()]).is_ok()
}

/// Writes the coefficients after these decisions.
pub(crate) fn write(
    known: &Uncertainties,
    decisions: &[Decision],
    found: &[Correlation],
    document: &mut DocumentMut,
    origin: &Origin,
) -> Result<(), FileError> {
    let figures = known.figures();
    let is_figure = |key: &String| figures.iter().any(|(own, _)| *own == uncertainty_keys(key)[0]);
    let found: Vec<Correlation> = found.iter().filter(|own| own.between.iter().all(is_figure)).cloned().collect();
    let (kept, new) = after(known, decisions, &found);
    let new = settled(&kept, &new);
    if new.is_empty() && kept.len() == known.correlations.len() {
        return Ok(());
    }
    let refused = || origin.whole("an uncertainty that is not a section", "a section [uncertainty]");
    let section = document.entry("uncertainty").or_insert_with(|| {
        let mut section = Table::new();
        section.set_implicit(true);
        Item::Table(section)
    });
    let section = section.as_table_like_mut().ok_or_else(refused)?;
    let list = section.entry("correlation").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    let refused = || origin.whole("correlation that is not a list of sections", "sections [[uncertainty.correlation]]");
    let list = list.as_array_of_tables_mut().ok_or_else(refused)?;
    list.retain(|own| kept.iter().any(|kept| is_between(own, &kept.between)));
    for own in new {
        let mut table = Table::new();
        table.insert("between", Item::Value(own.between.into_iter().collect::<Array>().into()));
        table.insert("coefficient", Item::Value(Value::from(own.coefficient)));
        list.push(table);
    }
    if list.is_empty() {
        section.remove("correlation");
    }
    Ok(())
}

/// Removes the coefficients of a standard uncertainty that is removed.
pub(crate) fn forget(document: &mut DocumentMut, key: &str) {
    let section = document.get_mut("uncertainty").and_then(Item::as_table_like_mut);
    let Some(section) = section else { return };
    let Some(list) = section.get_mut("correlation").and_then(Item::as_array_of_tables_mut) else { return };
    list.retain(|own| !between(own).contains(&key));
    if list.is_empty() {
        section.remove("correlation");
    }
}

/// The keys of an entry.
fn between(entry: &Table) -> Vec<&str> {
    let list = entry.get("between").and_then(Item::as_array);
    list.map(|list| list.iter().filter_map(Value::as_str).collect()).unwrap_or_default()
}

fn is_between(entry: &Table, [one, other]: &[String; 2]) -> bool {
    let own = between(entry);
    own == [one, other] || own == [other, one]
}
