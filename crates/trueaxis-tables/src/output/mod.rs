//! Outputs of a command: written whole or not at all, and never over an input.
//!
//! Each file is written beside its place, flushed to the disk and renamed, and its folder is flushed: a crash or a power
//! failure at any moment leaves the old file or the new one, never a part. A file not yet renamed by then remains as
//! `NAME.XXXXXX.trueaxis-tmp` ([`UNFINISHED`]); [`leftovers`] finds it, and the next command that writes NAME removes it.
//!
//! All files of one command are on the disk before the first is renamed, and they are renamed in the order in which they were
//! put. A crash between two renames leaves the first ones new and the rest old, each with its unfinished file beside it: if
//! files belong together, put the one that names the others last.
//!
//! ```
//! use trueaxis_tables::output::Outputs;
//! let folder = tempfile::tempdir()?;
//! let [input, output] = ["in.csv", "out.csv"].map(|name| folder.path().join(name));
//! std::fs::write(&input, "1,2")?;
//!
//! let mut outputs = Outputs::of([&input]);
//! outputs.put(&output, b"3,4")?;
//! assert!(!output.exists(), "nothing is in its place before everything is written");
//! outputs.commit()?;
//! assert_eq!(std::fs::read(&output)?, b"3,4");
//!
//! assert!(Outputs::of([&input]).put(&folder.path().join("./in.csv"), b"3,4").is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod alone;
mod left;
mod staged;

pub use alone::Alone;
pub use left::{UNFINISHED, left_notes, leftovers};
pub use staged::{Staged, write_atomically};

use staged::{flush_folder, folder_of};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why an output is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The output is a file that the command reads, under whatever name.
    #[error("{}: found the input {}, needed another file: an input is never written", .output.display(), .input.display())]
    Input {
        /// The output as given.
        output: PathBuf,
        /// The input as given.
        input: PathBuf,
    },
    /// Two outputs are the same file.
    #[error("{}: found two outputs for this file, needed a file for each", .0.display())]
    Twice(PathBuf),
    /// Another command has locked the machine's folder, [`Alone`].
    #[error("{}: found another command that is changing this machine, needed it to end: try again", .0.display())]
    Busy(PathBuf),
    /// The file system failed.
    #[error("cannot write {}", .output.display())]
    Io {
        /// The output as given.
        output: PathBuf,
        /// Error of the file system.
        #[source]
        error: io::Error,
    },
    /// The file system failed after some of the files were in place.
    #[error("cannot write {}; already written: {}", .output.display(), list(.written))]
    Between {
        /// The first output that is unchanged.
        output: PathBuf,
        /// The outputs before it, which are written.
        written: Vec<PathBuf>,
        /// Error of the file system.
        #[source]
        error: io::Error,
    },
}

/// Folders created for outputs, outermost first; dropping this removes those that are still empty.
#[derive(Debug, Default)]
struct Folders(Vec<PathBuf>);

impl Folders {
    fn create(&mut self, folder: &Path) -> io::Result<()> {
        let mut missing: Vec<&Path> =
            folder.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists()).collect();
        missing.reverse();
        self.0.extend(missing.into_iter().map(Path::to_path_buf));
        fs::create_dir_all(folder)
    }
}

impl Drop for Folders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            // Fails for a folder that contains a file, which is then kept.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// All outputs of a command, held back until every one is complete. Dropped before [`Outputs::commit`], it leaves nothing
/// behind.
#[derive(Debug, Default)]
pub struct Outputs {
    inputs: Vec<PathBuf>,
    /// Paths already reserved.
    places: Vec<PathBuf>,
    // Before `folders`, so that it is dropped first.
    ready: Vec<(PathBuf, Ready)>,
    folders: Folders,
}

#[derive(Debug)]
enum Ready {
    Staged(Staged),
    /// Written at the end, since it cannot be undone.
    Device(Vec<u8>),
}

impl Outputs {
    /// An empty set of outputs for a command that reads these files.
    pub fn of<P: AsRef<Path>>(inputs: impl IntoIterator<Item = P>) -> Outputs {
        Outputs { inputs: inputs.into_iter().map(|input| input.as_ref().to_path_buf()).collect(), ..Outputs::default() }
    }

    /// Refuses an output that is a file the command reads: the same file on the disk under any name (`./x.csv`, a link, a hard
    /// link). Devices and pipes may be both.
    ///
    /// # Errors
    /// [`OutputError::Input`].
    pub fn refuse_input(&self, output: &Path) -> Result<(), OutputError> {
        let same = |input: &&PathBuf| input.is_file() && same_file::is_same_file(input, output).unwrap_or(false);
        match self.inputs.iter().find(same) {
            Some(input) => Err(OutputError::Input { output: output.into(), input: input.clone() }),
            None => Ok(()),
        }
    }

    /// Creates a folder for outputs, and its missing parents.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn folder(&mut self, folder: &Path) -> Result<(), OutputError> {
        self.folders.create(folder).map_err(|error| OutputError::Io { output: folder.into(), error })
    }

    /// Adds one file with its content, staged beside its target.
    ///
    /// # Errors
    /// An output that is an input or was already put, or an error of the file system.
    pub fn put(&mut self, output: &Path, bytes: &[u8]) -> Result<(), OutputError> {
        let path = self.reserve(output)?;
        let ready = if is_device(&path) {
            Ready::Device(bytes.to_vec())
        } else {
            let written = Staged::create(output).and_then(|mut file| file.write_all(bytes).map(|()| file));
            Ready::Staged(written.map_err(|error| OutputError::Io { output: output.into(), error })?)
        };
        self.ready.push((path, ready));
        Ok(())
    }

    /// Begins one file that is written piecewise, beside its target until [`Outputs::add`] and the commit; a device or a pipe
    /// receives the data at once.
    ///
    /// # Errors
    /// As [`Outputs::put`].
    pub fn begin(&mut self, output: &Path) -> Result<Staged, OutputError> {
        self.reserve(output)?;
        Staged::create(output).map_err(|error| OutputError::Io { output: output.into(), error })
    }

    /// Returns a completed file from [`Outputs::begin`].
    pub fn add(&mut self, output: &Path, file: Staged) {
        self.ready.push((resolved(output), Ready::Staged(file)));
    }

    /// Reserves a path that is neither an input nor another output.
    fn reserve(&mut self, output: &Path) -> Result<PathBuf, OutputError> {
        self.refuse_input(output)?;
        let path = resolved(output);
        if !is_device(&path) && self.places.contains(&path) {
            return Err(OutputError::Twice(output.into()));
        }
        self.places.push(path.clone());
        Ok(path)
    }

    /// Moves every file to its target, in the order in which they were put, once all of them are on the disk.
    ///
    /// # Errors
    /// Errors of the file system. [`Outputs::put`] has already refused whatever can be refused, so an error here means a
    /// failing disk. It names the files that are already new, if any.
    pub fn commit(self) -> Result<(), OutputError> {
        let Outputs { mut ready, folders, .. } = self;
        for (output, ready) in &mut ready {
            if let Ready::Staged(file) = ready {
                file.complete().map_err(|error| OutputError::Io { output: output.clone(), error })?;
            }
        }
        let mut changed: Vec<PathBuf> = folders.0.iter().map(|made| folder_of(made).to_path_buf()).collect();
        let mut written = Vec::new();
        for (output, ready) in ready {
            let done = match ready {
                Ready::Staged(file) => file.place(),
                Ready::Device(bytes) => Staged::create(&output).and_then(|mut to| to.write_all(&bytes)).map(|()| None),
            };
            match done {
                Ok(folder) => changed.extend(folder),
                Err(error) if written.is_empty() => return Err(OutputError::Io { output, error }),
                Err(error) => return Err(OutputError::Between { output, written, error }),
            }
            written.push(output);
        }
        changed.sort();
        changed.dedup();
        changed.iter().try_for_each(|folder| {
            flush_folder(folder).map_err(|error| OutputError::Io { output: folder.clone(), error })
        })
    }
}

fn list(files: &[PathBuf]) -> String {
    files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Neither a file nor a folder: it is written to rather than replaced.
fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|old| !old.is_file() && !old.is_dir())
}

/// Most links followed to a file that does not exist yet; the Linux kernel has the same limit.
const LINKS: usize = 40;

/// Whether a path is a link whose target does not exist. The target of a link to a pipe (`/dev/stdout`) exists, though without
/// a name.
fn is_dangling_link(path: &Path) -> bool {
    path.is_symlink() && !path.exists()
}

/// The path of a file with all links resolved, so that two names of one file give the same path. The file need not exist, but
/// its folder must. If the links lead nowhere, the result is itself a link.
fn resolved(output: &Path) -> PathBuf {
    if let Ok(path) = fs::canonicalize(output) {
        return path;
    }
    let mut output = output.to_path_buf();
    for _ in 0..LINKS {
        match fs::read_link(&output) {
            Ok(to) if is_dangling_link(&output) => output = folder_of(&output).join(to),
            _ => break,
        }
    }
    match (fs::canonicalize(folder_of(&output)), output.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => output,
    }
}
