//! A command that is interrupted at any moment, or runs out of room, leaves the old file or the new one.
//!
//! These tests use the kernel's file system: signals kill processes at points in time and at every system call that touches a
//! file (strace), and processes meet limits, full disks and read-only disks.

mod calls;
mod killed;
mod room;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");
const UNFINISHED: &str = ".trueaxis-tmp";

/// Two machines with three tables each: every error of `other` is 2 µm larger than that of `m`, and it has no backlash.
fn machines() -> Folder {
    let folder = Folder::new(TRUEAXIS);
    for (name, more) in [("m", 0), ("other", 2)] {
        let mut toml = format!("name = \"m\"\nchain = \"w b X Y Z t\"\n# {name}\n");
        for axis in ["X", "Y", "Z"] {
            toml += &format!("[axis.{axis}]\ntable = \"{}.csv\"\n", axis.to_lowercase());
            let table = format!("{axis}_mm,E{axis}{axis}_um\n0,{}\n100,{}\n", 1 + more, 3 + more);
            folder.write(format!("{name}/{}.csv", axis.to_lowercase()), table);
        }
        if more == 0 {
            toml += "backlash_um = 2\n";
        }
        folder.write(format!("{name}/machine.toml"), toml);
    }
    folder
}

/// The files of a folder, with the unfinished ones listed separately.
fn files(folder: &Path) -> (BTreeMap<PathBuf, Vec<u8>>, Vec<PathBuf>) {
    let mut found = BTreeMap::new();
    let mut left = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.to_string_lossy().ends_with(UNFINISHED) {
            left.push(path);
        } else if path.is_file() {
            found.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    (found, left)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Whether a program is installed; prints a line if it is not.
fn has(program: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok_and(|done| done.status.success());
    if !there {
        eprintln!("not tested: found no {program}");
    }
    there
}

const COMPILE: [&str; 5] = ["tables", "compile", "m", "-o", "t.tcomp"];
