//! Stored verdicts: one line each, appended at once, so that a run can be resumed.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};

use crate::list::Mutant;

#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    Killed(String),
    TimedOut(String),
    Survived,
    /// Survived; no test reaches it.
    Unreached,
}

impl Verdict {
    fn is_noticed(&self) -> bool {
        matches!(self, Verdict::Killed(_) | Verdict::TimedOut(_))
    }
}

/// The verdict on every mutant, by its key.
pub struct Results {
    verdicts: HashMap<String, Verdict>,
    file: File,
}

impl Results {
    pub fn open(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let mut verdicts = HashMap::new();
        for (key, verdict) in text.lines().filter_map(read) {
            // A mutant detected by one set of tests stays detected even if another set misses it.
            if !verdicts.get(&key).is_some_and(Verdict::is_noticed) {
                verdicts.insert(key, verdict);
            }
        }
        let file =
            OpenOptions::new().create(true).append(true).open(path).with_context(|| path.display().to_string())?;
        Ok(Results { verdicts, file })
    }

    pub fn get(&self, mutant: &Mutant) -> Option<&Verdict> {
        self.verdicts.get(&mutant.key())
    }

    pub fn set(&mut self, mutant: &Mutant, verdict: Verdict) -> Result<()> {
        let (word, by) = match &verdict {
            Verdict::Killed(by) => ("killed", by.as_str()),
            Verdict::TimedOut(by) => ("timeout", by.as_str()),
            Verdict::Survived => ("survived", ""),
            Verdict::Unreached => ("unreached", ""),
        };
        writeln!(self.file, "{word}\t{by}\t{}", mutant.key())?;
        self.verdicts.insert(mutant.key(), verdict);
        Ok(())
    }
}

fn read(line: &str) -> Option<(String, Verdict)> {
    let (word, rest) = line.split_once('\t')?;
    let (by, key) = rest.split_once('\t')?;
    let verdict = match word {
        "killed" => Verdict::Killed(by.to_string()),
        "timeout" => Verdict::TimedOut(by.to_string()),
        "survived" => Verdict::Survived,
        "unreached" => Verdict::Unreached,
        _ => return None,
    };
    Some((key.to_string(), verdict))
}
