//! Runs a program in a temporary folder.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A temporary folder in which one program runs; removed when dropped.
#[derive(Debug)]
pub struct Folder {
    directory: TempDir,
    program: &'static str,
}

impl Folder {
    /// Creates an empty folder for a program, usually `env!("CARGO_BIN_EXE_…")`.
    pub fn new(program: &'static str) -> Self {
        Folder { directory: tempfile::tempdir().expect("a temporary folder"), program }
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        self.directory.path()
    }

    /// A path inside the folder.
    pub fn join(&self, name: impl AsRef<Path>) -> PathBuf {
        self.path().join(name)
    }

    /// Whether a file or folder with that name exists.
    pub fn has(&self, name: &str) -> bool {
        self.join(name).exists()
    }

    /// Writes a file and creates the folders above it.
    #[track_caller]
    pub fn write(&self, name: impl AsRef<Path>, content: impl AsRef<[u8]>) {
        let path = self.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    /// The text of a file.
    #[track_caller]
    pub fn read(&self, name: impl AsRef<Path>) -> String {
        let path = self.join(name);
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    /// Copies the files and folders of another folder into a folder `name` of this one.
    #[track_caller]
    pub fn copy(&self, from: &Path, name: impl AsRef<Path>) {
        for file in fs::read_dir(from).unwrap() {
            let file = file.unwrap();
            let (from, to) = (file.path(), name.as_ref().join(file.file_name()));
            if from.is_dir() {
                self.copy(&from, to);
            } else {
                self.write(to, fs::read(from).unwrap());
            }
        }
    }

    /// Every file with its bytes, and every folder without any.
    pub fn tree(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        tree(self.path())
    }

    /// The program with its arguments, not yet started.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.program);
        command.args(arguments).current_dir(self.path());
        command
    }

    /// Runs the program.
    #[track_caller]
    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs the program, which must succeed; returns standard output and standard error.
    #[track_caller]
    pub fn both(&self, arguments: &[&str]) -> [String; 2] {
        let output = self.run(arguments);
        let [out, error] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert!(output.status.success(), "{arguments:?}: {error}");
        [out, error]
    }

    /// Standard output of a run that must succeed.
    #[track_caller]
    pub fn good(&self, arguments: &[&str]) -> String {
        let [out, _] = self.both(arguments);
        out
    }

    /// Standard error of a run that must succeed.
    #[track_caller]
    pub fn reported(&self, arguments: &[&str]) -> String {
        let [_, error] = self.both(arguments);
        error
    }

    /// Standard output of a run that must succeed, as JSON.
    #[track_caller]
    pub fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.good(arguments)).unwrap()
    }

    /// Header and rows of the CSV printed by a run.
    #[track_caller]
    pub fn csv(&self, arguments: &[&str]) -> (String, Vec<Vec<f64>>) {
        csv(&self.good(arguments))
    }

    /// Runs the program, which must be refused: exit code 2, empty standard output, every part in the message, all files
    /// unchanged. Returns the message.
    #[track_caller]
    pub fn bad(&self, arguments: &[&str], parts: &[&str]) -> String {
        let before = self.tree();
        let output = self.run(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stdout));
        for part in parts {
            assert!(error.contains(part), "{arguments:?}: {error} without {part:?}");
        }
        assert_eq!(self.tree(), before, "{arguments:?}");
        error
    }
}

fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(tree(&path));
            found.insert(path, Vec::new());
        } else {
            let bytes = fs::read(&path).unwrap();
            found.insert(path, bytes);
        }
    }
    found
}

/// Header and rows of a CSV of numbers.
pub fn csv(text: &str) -> (String, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let header = lines.next().expect("a header").to_owned();
    (header, lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect())
}

/// The elements of a JSON array of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|number| number.as_f64().expect("a number")).collect()
}
