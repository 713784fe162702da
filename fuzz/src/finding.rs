//! A broken promise, recorded so that it can be reproduced.

use crate::Target;
use crate::corpus;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io;
use std::path::{Path, PathBuf};

/// An input that breaks a promise.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Name of the target.
    pub target: &'static str,
    /// Seed of the loop.
    pub seed: u64,
    /// Number of the execution, from 0.
    pub execution: u64,
    /// What happened.
    pub what: String,
    /// The input.
    pub input: Vec<u8>,
}

/// The folder for a target's findings.
pub fn folder(target: &Target) -> PathBuf {
    corpus::home().join("findings").join(target.name)
}

impl Finding {
    /// Writes the input to `folder`, and beside it a `.txt` file with what happened and the commands that reproduce it.
    /// Returns the input's file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> io::Result<PathBuf> {
        fs::create_dir_all(folder)?;
        let mut hasher = DefaultHasher::new();
        self.input.hash(&mut hasher);
        let file = folder.join(format!("{:016x}.bin", hasher.finish()));
        fs::write(&file, &self.input)?;
        fs::write(file.with_extension("txt"), self.report(&file))?;
        Ok(file)
    }

    /// What happened, and the commands that reproduce it.
    pub fn report(&self, file: &Path) -> String {
        let Finding { target, seed, execution, what, input } = self;
        let run = "cargo run -p trueaxis-fuzz --profile fuzz --";
        format!(
            "target {target}, seed {seed}, execution {execution}, {} bytes\n{what}\n\nthe input:   {run} run {target} {}\n\
             the search:  {run} {target} --seed {seed} --executions {}\n",
            input.len(),
            file.display(),
            execution + 1
        )
    }
}

/// The findings in a folder: inputs without the reports beside them.
///
/// # Errors
/// A file that cannot be read.
pub fn inputs(folder: &Path) -> io::Result<Vec<(PathBuf, Vec<u8>)>> {
    let mut files = corpus::files(folder)?;
    files.retain(|(path, _)| path.extension().is_none_or(|extension| extension != "txt"));
    Ok(files)
}
