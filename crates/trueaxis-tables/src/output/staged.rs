//! A file that is staged before it takes its place.

use super::left;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file that replaces its target only when complete; dropped before [`Staged::commit`], it leaves nothing behind.
///
/// Until then it is beside its target as `NAME.XXXXXX.trueaxis-tmp`. A killed process leaves it there, and the next one that
/// writes the same target removes it.
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

/// Number of attempts to create a file: another command may remove a new file as a leftover before it is locked.
const TRIES: usize = 8;

impl Staged {
    /// Begins the file that will replace `path`. If `path` is a link, the file replaces the link's target, which need not
    /// exist yet, so that the link stays.
    ///
    /// # Errors
    /// Errors of the file system; the target is a folder; links that lead nowhere.
    pub fn create(path: &Path) -> io::Result<Staged> {
        let target = super::resolved(path);
        if super::is_dangling_link(&target) {
            return Err(io::Error::other("it is a link that leads nowhere"));
        }
        let old = fs::metadata(&target).ok();
        if old.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
        }
        if old.as_ref().is_some_and(|old| !old.is_file()) {
            let device = OpenOptions::new().write(true).open(&target)?;
            return Ok(Staged { target, to: To::Device(device) });
        }
        left::sweep(&target);
        let file = temporary_file(&target)?;
        if let Some(old) = old {
            file.as_file().set_permissions(old.permissions())?;
        }
        Ok(Staged { target, to: To::File(file) })
    }

    /// Moves the file to its target, which keeps its old content until then. After the return the new content survives a power
    /// failure.
    ///
    /// # Errors
    /// Errors of the file system; the old content is still there, unless only the flush of the folder failed.
    pub fn commit(mut self) -> io::Result<()> {
        self.complete()?;
        match self.place()? {
            Some(folder) => flush_folder(&folder),
            None => Ok(()),
        }
    }

    /// Flushes everything to the disk, still under the temporary name.
    pub(super) fn complete(&mut self) -> io::Result<()> {
        match &mut self.to {
            To::File(file) => file.as_file().sync_all(),
            To::Device(device) => device.flush(),
        }
    }

    /// Replaces the target; returns the folder whose entry has changed.
    pub(super) fn place(self) -> io::Result<Option<PathBuf>> {
        let To::File(file) = self.to else { return Ok(None) };
        file.persist(&self.target).map_err(|error| error.error)?;
        Ok(Some(folder_of(&self.target).to_path_buf()))
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

/// Writes a file so that its old content stays until the new one is complete: a temporary file beside it, renamed.
///
/// # Errors
/// Errors of the file system; no temporary file remains.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = Staged::create(path)?;
    file.write_all(bytes)?;
    file.commit()
}

/// The folder that contains a file.
pub(super) fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Makes the entries of a folder survive a power failure. Where a folder cannot be opened or flushed (other systems, no
/// permission to read), this relies on the file system.
pub(super) fn flush_folder(folder: &Path) -> io::Result<()> {
    if !cfg!(unix) {
        return Ok(());
    }
    let Ok(open) = File::open(folder) else { return Ok(()) };
    open.sync_all().or_else(|error| match error.kind() {
        io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported => Ok(()),
        _ => Err(error),
    })
}

/// A new temporary file beside its target, locked.
fn temporary_file(target: &Path) -> io::Result<NamedTempFile> {
    let mut prefix = target.file_name().ok_or(io::ErrorKind::InvalidInput)?.to_os_string();
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).rand_bytes(left::LETTERS).suffix(left::UNFINISHED);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file, less the mask; tempfile's default is private.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    for _ in 0..TRIES {
        let file = builder.tempfile_in(folder_of(target))?;
        if left::hold(file.as_file(), file.path()) {
            return Ok(file);
        }
    }
    Err(io::Error::new(io::ErrorKind::ResourceBusy, "other commands write the same file"))
}
