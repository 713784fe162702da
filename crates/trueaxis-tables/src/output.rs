//! Outputs of a command: written whole or not at all, and never over an input.
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

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Why an output is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The output is a file that the command reads, by whatever name.
    #[error("{}: found the input {}, needed another file: an input is never written", .output.display(), .input.display())]
    Input {
        /// The output as it was given.
        output: PathBuf,
        /// The input as it was given.
        input: PathBuf,
    },
    /// Two outputs in one file.
    #[error("{}: found two outputs for this file, needed a file for each", .0.display())]
    Twice(PathBuf),
    /// The file system refused.
    #[error("cannot write {}", .output.display())]
    Io {
        /// The output as it was given.
        output: PathBuf,
        /// Its answer.
        #[source]
        error: io::Error,
    },
}

/// A file that replaces its target only when complete; dropped before [`Staged::commit`], it leaves nothing behind.
#[derive(Debug)]
pub struct Staged {
    target: PathBuf,
    to: To,
}

#[derive(Debug)]
enum To {
    /// Beside its target; renamed to it at the end.
    File(NamedTempFile),
    /// A device or a pipe takes the bytes directly: it must not be replaced by a file.
    Device(File),
}

impl Staged {
    /// Begins a file that will stand at `path`; behind a link, so that the link stays.
    ///
    /// # Errors
    /// Those of the file system; the target is a folder.
    pub fn create(path: &Path) -> io::Result<Staged> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let old = fs::metadata(&target).ok();
        if old.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
        }
        if old.as_ref().is_some_and(|old| !old.is_file()) {
            let device = OpenOptions::new().write(true).open(&target)?;
            return Ok(Staged { target, to: To::Device(device) });
        }
        let name = target.file_name().ok_or(io::ErrorKind::InvalidInput)?;
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(name).suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As any new file, less the mask; tempfile's own default is private.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder)?;
        if let Some(old) = old {
            file.as_file().set_permissions(old.permissions())?;
        }
        Ok(Staged { target, to: To::File(file) })
    }

    /// Moves the file to its target, which keeps its old content until then.
    ///
    /// # Errors
    /// Those of the file system; the old content still stands.
    pub fn commit(self) -> io::Result<()> {
        match self.to {
            To::File(file) => {
                file.as_file().sync_all()?;
                file.persist(&self.target).map_err(|error| error.error)?;
                Ok(())
            }
            To::Device(mut device) => device.flush(),
        }
    }
}

impl Write for Staged {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.to {
            To::File(file) => file.write(bytes),
            To::Device(device) => device.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.to {
            To::File(file) => file.flush(),
            To::Device(device) => device.flush(),
        }
    }
}

/// Writes a file so that its old content stands until the new one is complete: a temporary file beside it, renamed.
///
/// # Errors
/// Those of the file system; nothing is left behind.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = Staged::create(path)?;
    file.write_all(bytes)?;
    file.commit()
}

/// Folders made for outputs, the outermost first; those still empty are removed with it.
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
            // One with a file in it is refused, and stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// All that a command writes, held back until everything is there. Dropped before [`Outputs::commit`], nothing is left.
#[derive(Debug, Default)]
pub struct Outputs {
    inputs: Vec<PathBuf>,
    // Before the folders: dropped in this order.
    ready: Vec<(PathBuf, Ready)>,
    folders: Folders,
}

#[derive(Debug)]
enum Ready {
    Staged(Staged),
    /// Written at the end, since it cannot be taken back.
    Device(Vec<u8>),
}

impl Outputs {
    /// None yet, of a command that reads these files.
    pub fn of<P: AsRef<Path>>(inputs: impl IntoIterator<Item = P>) -> Outputs {
        Outputs { inputs: inputs.into_iter().map(|input| input.as_ref().to_path_buf()).collect(), ..Outputs::default() }
    }

    /// Refuses a file that the command reads: the same file on the disk, whatever it is called (`./x.csv`, a link, a hard
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

    /// Makes a folder for outputs, and those above it.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn folder(&mut self, folder: &Path) -> Result<(), OutputError> {
        self.folders.create(folder).map_err(|error| OutputError::Io { output: folder.into(), error })
    }

    /// One file with its content, staged beside its target.
    ///
    /// # Errors
    /// An input, a second output of that name, or a refusal of the file system.
    pub fn put(&mut self, output: &Path, bytes: &[u8]) -> Result<(), OutputError> {
        self.refuse_input(output)?;
        let path = resolved(output);
        let device = fs::metadata(&path).is_ok_and(|old| !old.is_file() && !old.is_dir());
        if !device && self.ready.iter().any(|(other, _)| *other == path) {
            return Err(OutputError::Twice(output.into()));
        }
        let ready = if device {
            Ready::Device(bytes.to_vec())
        } else {
            let written = Staged::create(output).and_then(|mut file| file.write_all(bytes).map(|()| file));
            Ready::Staged(written.map_err(|error| OutputError::Io { output: output.into(), error })?)
        };
        self.ready.push((path, ready));
        Ok(())
    }

    /// One file that is written bit by bit, beside its target until the commit; a device or a pipe takes it at once.
    ///
    /// # Errors
    /// As [`Outputs::put`].
    pub fn stream(&mut self, output: &Path) -> Result<&mut Staged, OutputError> {
        self.refuse_input(output)?;
        let path = resolved(output);
        if self.ready.iter().any(|(other, _)| *other == path) {
            return Err(OutputError::Twice(output.into()));
        }
        let staged = Staged::create(output).map_err(|error| OutputError::Io { output: output.into(), error })?;
        self.ready.push((path, Ready::Staged(staged)));
        match self.ready.last_mut() {
            Some((_, Ready::Staged(staged))) => Ok(staged),
            _ => Err(OutputError::Twice(output.into())),
        }
    }

    /// Moves every file to its target, in the order of arrival.
    ///
    /// # Errors
    /// Those of the file system: what could be refused was when it was put, so that one here is a disk that fails.
    pub fn commit(self) -> Result<(), OutputError> {
        let Outputs { ready, .. } = self;
        for (output, ready) in ready {
            let done = match ready {
                Ready::Staged(file) => file.commit(),
                Ready::Device(bytes) => Staged::create(&output).and_then(|mut device| device.write_all(&bytes)),
            };
            done.map_err(|error| OutputError::Io { output, error })?;
        }
        Ok(())
    }
}

/// A name that is the same for the same file, whether it exists or its folder alone.
fn resolved(output: &Path) -> PathBuf {
    if let Ok(path) = fs::canonicalize(output) {
        return path;
    }
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (fs::canonicalize(folder), output.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => output.to_path_buf(),
    }
}
