//! The scratch copy of the workspace, with the core rewritten.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::list::Mutant;
use crate::rewrite::{RefusedMutants, Rewritten, rewrite};

/// The switch crate: which mutant is on.
const SWITCH: &str = include_str!("../switch.rs");
/// Its manifest, with a separate workspace beside the copy.
const SWITCH_MANIFEST: &str = "\
[package]
name = \"mutant-switch\"
version = \"0.1.0\"
edition = \"2024\"

[lib]
path = \"lib.rs\"

[workspace]
";

/// Folders of the campaign.
pub struct Scratch {
    pub root: PathBuf,
    pub workspace: PathBuf,
    pub target: PathBuf,
    /// Folder of the switch crate that the copy depends on. Each copy has one: cargo distinguishes packages by their path in
    /// the workspace, and would use the build of one copy for the other.
    switch: &'static str,
}

/// File → its rewritten form.
pub type Files = BTreeMap<String, Rewritten>;

impl Scratch {
    /// The copy with all mutants, or a separate one with only those on changed lines.
    pub fn new(root: &Path, changed: bool) -> Self {
        let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
        Scratch {
            root: root.to_path_buf(),
            workspace: target.join(if changed { "mutants/changed" } else { "mutants/workspace" }),
            target,
            switch: if changed { "switch-changed" } else { "switch" },
        }
    }

    /// Path of a campaign file beside the workspace.
    pub fn file(&self, name: &str) -> PathBuf {
        self.target.join("mutants").join(name)
    }

    /// Copies tracked and new files of the git tree; unchanged files are not rewritten.
    pub fn copy(&self, rewritten: &Files) -> Result<()> {
        let list = Command::new("git")
            .current_dir(&self.root)
            .args(["ls-files", "--cached", "--others", "--exclude-standard", "-z"])
            .output()?;
        if !list.status.success() {
            bail!("git ls-files: {}", String::from_utf8_lossy(&list.stderr));
        }
        let list = String::from_utf8(list.stdout)?;
        let names: HashSet<&str> = list.split('\0').filter(|name| !name.is_empty()).collect();
        self.sweep(&self.workspace, &names)?;
        for &name in &names {
            if rewritten.contains_key(name) || name.starts_with("tests/mutants/") {
                continue;
            }
            let Ok(content) = std::fs::read(self.root.join(name)) else { continue };
            write(&self.workspace.join(name), &adapted(name, content, self.switch))?;
        }
        write(&self.file(self.switch).join("Cargo.toml"), SWITCH_MANIFEST.as_bytes())?;
        write(&self.file(self.switch).join("lib.rs"), SWITCH.as_bytes())?;
        self.write(rewritten)
    }

    /// Removes files that no longer exist: a moved test would otherwise be built twice.
    fn sweep(&self, folder: &Path, names: &HashSet<&str>) -> Result<()> {
        let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
        for entry in entries {
            let path = entry?.path();
            if path.is_dir() {
                self.sweep(&path, names)?;
                continue;
            }
            let name = path.strip_prefix(&self.workspace)?.to_string_lossy().into_owned();
            if !names.contains(name.as_str()) || !self.root.join(&name).exists() {
                std::fs::remove_file(&path)?;
            }
        }
        Ok(())
    }

    /// Whether the copy contains exactly these files.
    pub fn has(&self, rewritten: &Files) -> bool {
        rewritten.iter().all(|(name, file)| {
            std::fs::read(self.workspace.join(name)).is_ok_and(|there| there == file.text.as_bytes())
        })
    }

    /// Writes the rewritten files.
    pub fn write(&self, rewritten: &Files) -> Result<()> {
        rewritten.iter().try_for_each(|(name, file)| write(&self.workspace.join(name), file.text.as_bytes()))
    }

    /// Rewrites every file that has a mutant.
    pub fn rewrite(&self, mutants: &[Mutant], refused: &RefusedMutants) -> Result<Files> {
        let mut by_file: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (number, mutant) in mutants.iter().enumerate() {
            by_file.entry(&mutant.file).or_default().push(number);
        }
        let mut site = 0;
        let mut files = Files::new();
        for (name, here) in by_file {
            let text = std::fs::read_to_string(self.root.join(name))?;
            let file = rewrite(&text, mutants, &here, refused, site).with_context(|| name.to_string())?;
            site += file.sites;
            files.insert(name.to_string(), file);
        }
        Ok(files)
    }
}

/// Makes the core depend on the switch, and silences warnings about the generated choices.
fn adapted(name: &str, content: Vec<u8>, switch: &str) -> Vec<u8> {
    let replace = |what: &str, with: &str| String::from_utf8_lossy(&content).replacen(what, with, 1).into_bytes();
    match name {
        "crates/trueaxis/Cargo.toml" => {
            let dependency = format!("\n[dependencies]\nmutant-switch = {{ path = \"../../../{switch}\" }}\n");
            replace("\n[dependencies]\n", &dependency)
        }
        "crates/trueaxis/src/lib.rs" => replace("#![no_std]\n", "#![no_std]\n#![allow(warnings)]\n"),
        _ => content,
    }
}

fn write(path: &Path, content: &[u8]) -> Result<()> {
    if std::fs::read(path).is_ok_and(|there| there == content) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, content).with_context(|| path.display().to_string())
}
