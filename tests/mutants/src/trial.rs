//! Runs test programs as processes: records which code they reach, and whether they detect a mutant.

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result};

use crate::compile::Program;
use crate::process::{self, End};

/// One test of a program, and the sites that it reaches without any mutant.
#[derive(Clone, Debug)]
pub struct Test {
    pub program: usize,
    pub name: String,
    pub took: Duration,
    pub reaches: BTreeSet<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    Passed,
    Failed(String),
    TimedOut(String),
}

/// Options of a run.
#[derive(Clone, Copy)]
pub enum On<'a> {
    Mutant(usize, u8),
    /// No mutant; the reached sites are written to a file.
    Cover(&'a Path),
}

/// Runs the named tests of a program in one process, one after the other; also returns the processor time used.
pub fn run(program: &Program, tests: &[&str], on: On<'_>, out: &Path, seconds: u64) -> Result<(Outcome, Duration)> {
    let mut command = Command::new(&program.path);
    command.current_dir(&program.folder).args(["--exact", "--test-threads=1"]).args(tests);
    match on {
        On::Mutant(site, variant) => command.env("MUTANT", format!("{site}:{variant}")),
        On::Cover(path) => command.env("MUTANT_COVER", path),
    };
    command
        .env("CARGO_MANIFEST_DIR", &program.folder)
        .env("RUST_BACKTRACE", "0")
        .env("PROPTEST_FAILURE_PERSISTENCE", "off")
        .stdin(Stdio::null())
        .stdout(File::create(out)?)
        .stderr(Stdio::null());
    let (end, took) = process::run(&mut command, seconds).with_context(|| program.path.display().to_string())?;
    let outcome = match end {
        End::Passed => Outcome::Passed,
        End::Failed => Outcome::Failed(failed(out).unwrap_or_else(|| tests.join(" "))),
        End::TimedOut => Outcome::TimedOut(tests.join(" ")),
    };
    Ok((outcome, took))
}

/// The first failed test in the program's output.
fn failed(out: &Path) -> Option<String> {
    let text = std::fs::read_to_string(out).ok()?;
    let line = text.lines().find(|line| line.starts_with("test ") && line.ends_with("FAILED"))?;
    Some(line.split(' ').nth(1)?.to_string())
}

/// The names of a program's tests.
fn names(program: &Program) -> Result<Vec<String>> {
    let output =
        Command::new(&program.path).current_dir(&program.folder).args(["--list", "--format", "terse"]).output()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    Ok(text.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_string).collect())
}

/// Runs every test separately and records which code it reaches and how long it takes; returns fast tests first. Stops
/// tests longer than `longest` and leaves them out.
pub fn survey(programs: &[Program], folder: &Path, longest: Duration) -> Result<Vec<Test>> {
    std::fs::create_dir_all(folder)?;
    let seconds = longest.as_secs_f64().ceil() as u64;
    let mut wanted = Vec::new();
    for (number, program) in programs.iter().enumerate() {
        wanted.extend(names(program)?.into_iter().map(|name| (number, name)));
    }
    let found = crate::campaign::parallel(&wanted, |worker, (number, name)| {
        let reached: PathBuf = folder.join(format!("reached-{worker}"));
        let _ = std::fs::remove_file(&reached);
        let out = folder.join(format!("survey-{worker}"));
        let (outcome, took) = run(&programs[*number], &[name.as_str()], On::Cover(&reached), &out, seconds)?;
        let outcome = if took > longest { Outcome::TimedOut(name.clone()) } else { outcome };
        let text = std::fs::read_to_string(&reached).unwrap_or_default();
        let reaches = text.lines().filter_map(|line| line.parse().ok()).collect();
        Ok((outcome, Test { program: *number, name: name.clone(), took, reaches }))
    })?;
    let mut tests = Vec::new();
    let mut seen: HashMap<String, ()> = HashMap::new();
    for (outcome, test) in found {
        // A test that fails without a mutant cannot detect one.
        if let Outcome::Failed(_) = outcome {
            eprintln!("fails without a mutant, left out: {} of {}", test.name, programs[test.program].name);
        } else if let Outcome::TimedOut(_) = outcome {
            eprintln!("too long, left out: {} of {}", test.name, programs[test.program].name);
        } else if seen.insert(format!("{} {}", test.program, test.name), ()).is_none() {
            tests.push(test);
        }
    }
    // Tests of the whole step from outside precede the slower unit tests, because they detect the most mutants.
    let outside = |test: &Test| programs[test.program].name != "trueaxis";
    tests.sort_by_key(|test| if outside(test) { test.took.min(Duration::from_millis(25)) } else { test.took });
    Ok(tests)
}
