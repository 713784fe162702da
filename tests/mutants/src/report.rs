//! Survivors by file, and the table by room.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;

use crate::known::{self, Explained, Kind};
use crate::list::{Mutant, ROOMS};
use crate::results::{Results, Verdict};

/// Result for one mutant.
#[derive(Clone, Copy, PartialEq)]
pub enum Fate {
    Unviable,
    Killed,
    TimedOut,
    Survived,
    Unreached,
    /// Survived, for a reason on the list.
    Known(Kind),
    NotRun,
}

/// The fate of every mutant.
pub fn fates(mutants: &[Mutant], unviable: &HashSet<usize>, results: &Results, list: &[Explained]) -> Vec<Fate> {
    let fate = |(number, mutant): (usize, &Mutant)| {
        if unviable.contains(&number) {
            return Fate::Unviable;
        }
        let kind = known::reason(list, mutant).map(|one| one.kind);
        match results.get(mutant) {
            Some(Verdict::Killed(by)) => {
                if kind == Some(Kind::Equivalent) {
                    eprintln!("listed as equivalent, but killed by {by}: {}", mutant.name);
                }
                Fate::Killed
            }
            Some(Verdict::TimedOut(_)) => Fate::TimedOut,
            Some(Verdict::Survived) => kind.map_or(Fate::Survived, Fate::Known),
            Some(Verdict::Unreached) => kind.map_or(Fate::Unreached, Fate::Known),
            None => Fate::NotRun,
        }
    };
    mutants.iter().enumerate().map(fate).collect()
}

/// Entries of the list that match no survivor.
pub fn idle<'a>(mutants: &[Mutant], fates: &[Fate], list: &'a [Explained]) -> Vec<&'a Explained> {
    let survives = |one: &Explained| {
        mutants.iter().zip(fates).any(|(m, fate)| matches!(fate, Fate::Known(_) | Fate::NotRun) && one.is(m))
    };
    let here = |one: &Explained| mutants.iter().any(|m| m.file.ends_with(&one.file));
    list.iter().filter(|one| here(one) && !survives(one)).collect()
}

/// Share of killed mutants among those tried and not equivalent, per cent; 100 if none was tried. Any other reason counts as
/// survived.
pub fn score(fates: &[Fate]) -> f64 {
    let known = |fate: &Fate| matches!(fate, Fate::Known(kind) if *kind != Kind::Equivalent);
    share(fates, is_killed, |fate| known(fate) || is_open(fate))
}

/// Share of mutants that were killed or have any reason, among those tried, per cent.
pub fn explained(fates: &[Fate]) -> f64 {
    share(fates, |fate| is_killed(fate) || matches!(fate, Fate::Known(_)), is_open)
}

fn is_killed(fate: &Fate) -> bool {
    matches!(fate, Fate::Killed | Fate::TimedOut)
}

fn is_open(fate: &Fate) -> bool {
    matches!(fate, Fate::Survived | Fate::Unreached)
}

fn share(fates: &[Fate], good: impl Fn(&Fate) -> bool, bad: impl Fn(&Fate) -> bool) -> f64 {
    let [good, bad] = [fates.iter().filter(|f| good(f)).count(), fates.iter().filter(|f| bad(f)).count()];
    if bad == 0 { 100.0 } else { 100.0 * good as f64 / (good + bad) as f64 }
}

/// One line per room, and one for all rooms, in Markdown.
pub fn table(mutants: &[Mutant], fates: &[Fate]) -> String {
    let mut text = String::from(
        "| room | mutants | viable | killed | timeout | equivalent | border | cost | open | no reason | not run | score |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for room in ROOMS.iter().map(|room| Some(*room)).chain([None]) {
        let of: Vec<Fate> = mutants
            .iter()
            .zip(fates)
            .filter(|(m, _)| room.is_none_or(|room| m.room() == room))
            .map(|(_, f)| *f)
            .collect();
        let count = |fate: Fate| of.iter().filter(|&&f| f == fate).count();
        if of.is_empty() {
            continue;
        }
        let survived = count(Fate::Survived) + count(Fate::Unreached);
        let (killed, timeout) = (count(Fate::Killed), count(Fate::TimedOut));
        let viable = of.len() - count(Fate::Unviable);
        let score = score(&of);
        let _ = writeln!(
            text,
            "| {} | {} | {viable} | {killed} | {timeout} | {} | {} | {} | {} | {survived} | {} | {score:.1} % |",
            room.unwrap_or("all"),
            of.len(),
            count(Fate::Known(Kind::Equivalent)),
            count(Fate::Known(Kind::Border)),
            count(Fate::Known(Kind::Cost)),
            count(Fate::Known(Kind::Open)),
            count(Fate::NotRun)
        );
    }
    text
}

/// Survivors by file, each with its source line and reason.
pub fn survivors(mutants: &[Mutant], fates: &[Fate], reasons: &[Explained]) -> String {
    let mut files: BTreeMap<&str, Vec<(&Mutant, Fate)>> = BTreeMap::new();
    for (mutant, &fate) in mutants.iter().zip(fates) {
        if matches!(fate, Fate::Survived | Fate::Unreached | Fate::Known(_) | Fate::NotRun) {
            files.entry(&mutant.file).or_default().push((mutant, fate));
        }
    }
    let mut text = String::new();
    for (file, list) in files {
        let _ = writeln!(text, "\n# {file}: {}", list.len());
        let mut line = 0;
        for (mutant, fate) in list {
            if line != mutant.line {
                line = mutant.line;
                let _ = writeln!(text, "{line}: {}", mutant.code);
            }
            let reason = known::reason(reasons, mutant).map_or("", |one| one.reason.as_str());
            let word = match fate {
                Fate::Unreached => " [no test comes here]".to_string(),
                Fate::NotRun => " [not run]".to_string(),
                Fate::Known(kind) => format!(" [{kind:?}] {reason}"),
                _ => String::new(),
            };
            let _ = writeln!(text, "    {}: {}{word}", mutant.column, mutant.change);
        }
    }
    text
}
