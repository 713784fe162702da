//! Mutants known to survive, each with a reason, and mutants refused by the compiler, kept from run to run.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result};
use serde::Deserialize;

use crate::list::Mutant;
use crate::rewrite::RefusedMutants;

#[derive(Deserialize)]
struct File {
    #[serde(default)]
    mutant: Vec<Explained>,
}

/// Reason why a mutant survives.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Hash)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// No input distinguishes it from the code.
    #[default]
    Equivalent,
    /// Differs only where two numbers are equal, and either result meets the documented behaviour.
    Border,
    /// Its results equal the code's or are as good within the documented bounds, but the cost of a cycle differs.
    Cost,
    /// Not equivalent, but not detected: the reason names what would detect it.
    Open,
}

/// Mutants that survive for the same reason.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Explained {
    #[serde(default)]
    pub kind: Kind,
    /// Path below `crates/trueaxis/src`.
    pub file: String,
    /// Function; the whole file if omitted.
    pub function: Option<String>,
    /// Mutation as named by cargo-mutants, without the function: `replace < with <=`; all if omitted.
    pub mutation: Option<Words>,
    /// Part of the source line; every such mutant of the function if omitted.
    pub code: Option<Words>,
    /// Column given by cargo-mutants, to select one of several on the line.
    pub column: Option<usize>,
    /// Explanation for readers.
    pub reason: String,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum Words {
    One(String),
    Several(Vec<String>),
}

impl Words {
    fn any(&self, fits: impl Fn(&str) -> bool) -> bool {
        match self {
            Words::One(one) => fits(one),
            Words::Several(all) => all.iter().any(|one| fits(one)),
        }
    }
}

impl Explained {
    pub fn is(&self, mutant: &Mutant) -> bool {
        let changes = |one: &str| {
            mutant.change == one || mutant.change.strip_prefix(one).is_some_and(|rest| rest.starts_with(" in "))
        };
        mutant.file.strip_prefix(crate::list::SOURCE) == Some(self.file.as_str())
            && self.function.as_ref().is_none_or(|function| mutant.function == *function)
            && self.mutation.as_ref().is_none_or(|mutation| mutation.any(changes))
            && self.code.as_ref().is_none_or(|code| code.any(|one| mutant.code.contains(one)))
            && self.column.is_none_or(|column| mutant.column == column)
    }
}

/// The first reason on the list that applies to a mutant.
pub fn reason<'a>(list: &'a [Explained], mutant: &Mutant) -> Option<&'a Explained> {
    list.iter().find(|one| one.is(mutant))
}

/// Reads the list of reasons.
pub fn explained(path: &Path) -> Result<Vec<Explained>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    Ok(toml::from_str::<File>(&text).with_context(|| path.display().to_string())?.mutant)
}

/// Reads the mutants refused by earlier runs; numbers refer to the mutants of this run.
pub fn refused(path: &Path, mutants: &[Mutant]) -> RefusedMutants {
    let numbers: HashMap<String, usize> = mutants.iter().enumerate().map(|(n, m)| (m.key(), n)).collect();
    let mut refused = RefusedMutants::default();
    for line in std::fs::read_to_string(path).unwrap_or_default().lines() {
        let Some((kind, rest)) = line.split_once('\t') else { continue };
        let number = numbers.get(rest.split_once('\t').map_or(rest, |(key, _)| key)).copied();
        match (kind, number) {
            ("constant", _) => drop(refused.constant.insert(rest.to_string())),
            ("mutant", Some(number)) => drop(refused.mutants.insert(number)),
            ("place", Some(number)) => {
                let forms = rest.split_once('\t').and_then(|(_, forms)| forms.parse().ok()).unwrap_or(1);
                refused.places.insert(number, forms);
            }
            _ => {}
        }
    }
    refused
}

/// Writes the refused mutants.
pub fn keep(path: &Path, refused: &RefusedMutants, mutants: &[Mutant]) -> Result<()> {
    let mut lines: Vec<String> = refused.constant.iter().map(|name| format!("constant\t{name}")).collect();
    lines.extend(refused.mutants.iter().map(|&n| format!("mutant\t{}", mutants[n].key())));
    lines.extend(refused.places.iter().map(|(&n, forms)| format!("place\t{}\t{forms}", mutants[n].key())));
    lines.sort();
    std::fs::write(path, lines.join("\n") + "\n").with_context(|| path.display().to_string())
}
