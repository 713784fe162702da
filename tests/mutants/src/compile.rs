//! Builds the scratch copy; removes the mutants that the compiler refuses, error by error, until it compiles.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Result, bail};
use serde::Deserialize;

use crate::list::Mutant;
use crate::rewrite::RefusedMutants;
use crate::scratch::{Files, Scratch};

#[derive(Deserialize)]
struct Line {
    reason: String,
    message: Option<Message>,
    executable: Option<PathBuf>,
    manifest_path: Option<PathBuf>,
    target: Option<Target>,
}

#[derive(Deserialize)]
struct Target {
    name: String,
}

#[derive(Deserialize)]
struct Code {
    code: String,
}

#[derive(Deserialize)]
struct Message {
    level: String,
    message: String,
    rendered: Option<String>,
    code: Option<Code>,
    spans: Vec<Place>,
}

#[derive(Deserialize)]
struct Place {
    file_name: String,
    byte_start: usize,
    byte_end: usize,
    is_primary: bool,
}

/// A built test program.
#[derive(Clone, Debug)]
pub struct Program {
    pub name: String,
    pub path: PathBuf,
    pub folder: PathBuf,
}

/// Removes the mutants that do not compile; `refused` collects the refusals from run to run.
pub fn settle(scratch: &Scratch, mutants: &[Mutant], refused: &mut RefusedMutants) -> Result<Files> {
    loop {
        let files = scratch.rewrite(mutants, refused)?;
        // A copy that has compiled once need not be checked again.
        let settled = scratch.workspace.with_extension("settled");
        if settled.exists() && scratch.has(&files) {
            scratch.copy(&files)?;
            return Ok(files);
        }
        let _ = std::fs::remove_file(&settled);
        scratch.copy(&files)?;
        let lines = cargo(scratch, &["check", "-p", "trueaxis", "--tests", "--keep-going"])?;
        let errors: Vec<&Message> =
            lines.iter().filter_map(|line| line.message.as_ref()).filter(|m| m.level == "error").collect();
        if errors.is_empty() {
            std::fs::write(&settled, "")?;
            return Ok(files);
        }
        let before = refused.count();
        errors.iter().for_each(|error| refuse(error, &files, refused));
        eprintln!("{} errors, {} more refused", errors.len(), refused.count() - before);
        if refused.count() == before {
            let texts: Vec<&str> = errors.iter().filter_map(|e| e.rendered.as_deref()).take(5).collect();
            bail!("errors that belong to no mutant:\n{}", texts.join("\n"));
        }
    }
}

/// Builds the tests of some packages, with arguments as for `cargo test`.
pub fn programs(scratch: &Scratch, packages: &[String], only: &[String]) -> Result<Vec<Program>> {
    let mut arguments = vec!["test", "--no-run"];
    packages.iter().for_each(|package| arguments.extend(["-p", package]));
    arguments.extend(only.iter().map(String::as_str));
    let lines = cargo(scratch, &arguments)?;
    if let Some(error) = lines.iter().filter_map(|l| l.message.as_ref()).find(|m| m.level == "error") {
        bail!("{}", error.rendered.as_deref().unwrap_or(&error.message));
    }
    // Copies, because a later build must not change a running campaign.
    let copies = scratch.file(&format!("programs-{}", std::process::id()));
    std::fs::create_dir_all(&copies)?;
    let mut programs = Vec::new();
    for line in lines {
        let (Some(built), Some(manifest), Some(target)) = (line.executable, line.manifest_path, line.target) else {
            continue;
        };
        let path = copies.join(built.file_name().unwrap_or_default());
        std::fs::copy(&built, &path)?;
        let folder = manifest.parent().map(PathBuf::from).unwrap_or_default();
        programs.push(Program { name: target.name, path, folder });
    }
    Ok(programs)
}

fn cargo(scratch: &Scratch, arguments: &[&str]) -> Result<Vec<Line>> {
    let output = Command::new("cargo")
        .current_dir(&scratch.workspace)
        .args(arguments)
        .arg("--message-format=json")
        // The core is optimised, unlike in a developer's build, because it is built once and run for every mutant.
        .args(["--config", "profile.dev.package.trueaxis.opt-level=1"])
        .env("CARGO_TARGET_DIR", &scratch.target)
        .stderr(Stdio::inherit())
        .output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let lines: Vec<Line> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let said =
        lines.iter().any(|l| l.reason == "compiler-message" && l.message.as_ref().is_some_and(|m| m.level == "error"));
    if !output.status.success() && !said {
        bail!("cargo {} failed", arguments.join(" "));
    }
    Ok(lines)
}

fn overlaps(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start < b.end && b.start < a.end
}

/// Refuses the mutant, the place or the constant function that an error refers to.
fn refuse(error: &Message, files: &Files, refused: &mut RefusedMutants) {
    if error.code.as_ref().is_some_and(|code| code.code == "E0015") && !error.message.contains("mutant_switch") {
        let name = error.message.split('`').nth(1).unwrap_or_default();
        let name = if name.ends_with('>') { name.rsplit_once("::<").map_or(name, |(name, _)| name) } else { name };
        let name = name.rsplit("::").next().unwrap_or(name).trim_start_matches("__");
        refused.constant.insert(name.to_string());
        return;
    }
    if error.code.as_ref().is_some_and(|code| code.code == "E0004") {
        error.spans.iter().filter(|span| span.is_primary).for_each(|span| refuse_arms(span, files, refused));
        return;
    }
    let spans: BTreeSet<(bool, &str, usize, usize)> =
        error.spans.iter().map(|s| (!s.is_primary, s.file_name.as_str(), s.byte_start, s.byte_end)).collect();
    for (_, name, start, end) in &spans {
        let Some(file) = files.get(*name) else { continue };
        let mut hit = false;
        for (own, mutant) in &file.own {
            if overlaps(own, &(*start..*end)) && own.len() >= end - start {
                refused.mutants.insert(*mutant);
                hit = true;
            }
        }
        if hit {
            return;
        }
    }
    for (_, name, start, end) in &spans {
        let Some(file) = files.get(*name) else { continue };
        let around = file.places.iter().filter(|(place, _)| place.start <= *start && *end <= place.end);
        if let Some((_, first)) = around.min_by_key(|(place, _)| place.len()) {
            *refused.places.entry(*first).or_default() += 1;
            return;
        }
    }
}

/// Refuses the arms of a match that is not exhaustive once they have guards, because such arms cannot be removed.
fn refuse_arms(matched: &Place, files: &Files, refused: &mut RefusedMutants) {
    let Some(file) = files.get(&matched.file_name) else { return };
    let mut depth = 0;
    for (at, byte) in file.text.bytes().enumerate().skip(matched.byte_end) {
        match byte {
            b'{' => depth += 1,
            b'}' if depth == 1 => return,
            b'}' => depth -= 1,
            _ if depth == 1 => {
                let arms = file.own.iter().filter(|(own, _)| own.start == at && own.len() == 1);
                refused.mutants.extend(arms.map(|(_, mutant)| *mutant));
            }
            _ => {}
        }
    }
}
