//! Sources of the files that a machine is read from: a folder, or texts in memory.

use crate::error::FileError;
use crate::origin::Origin;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Kind of a name in a [`Source`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// Nothing has this name.
    Absent,
    /// A file.
    File,
    /// A link to a file.
    Link,
    /// A folder, a device, or a link to one or to nothing.
    Other,
}

impl Entry {
    /// Whether it can be read as a file.
    pub fn is_file(self) -> bool {
        matches!(self, Entry::File | Entry::Link)
    }
}

/// Named files from which a machine is read. Names are paths relative to the folder of `machine.toml`.
pub trait Source {
    /// Bytes of a file.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] if the file does not exist, or any other error that prevents reading it.
    fn read(&self, name: &Path) -> io::Result<Vec<u8>>;

    /// Kind of a name.
    fn entry(&self, name: &Path) -> Entry;

    /// Path of the file for errors.
    fn path(&self, name: &Path) -> PathBuf {
        name.to_path_buf()
    }

    /// Whether two names denote the same file.
    fn same(&self, one: &Path, other: &Path) -> bool {
        one == other
    }
}

/// Bytes of a required file.
pub(crate) fn bytes(files: &dyn Source, name: &Path) -> Result<Vec<u8>, FileError> {
    files.read(name).map_err(|error| Origin::new(&files.path(name)).unreadable(&error))
}

/// A folder of the file system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folder(PathBuf);

impl Folder {
    /// The folder with this path.
    pub fn new(folder: impl Into<PathBuf>) -> Folder {
        Folder(folder.into())
    }

    /// The folder of a machine and the name of its description in it. `path` is the description or the folder; in a folder the
    /// description is `machine.toml`.
    pub fn of_machine(path: &Path) -> (Folder, PathBuf) {
        match (path.is_dir(), path.parent(), path.file_name()) {
            (false, Some(folder), Some(name)) => (Folder::new(folder), name.into()),
            _ => (Folder::new(path), "machine.toml".into()),
        }
    }
}

impl Source for Folder {
    fn read(&self, name: &Path) -> io::Result<Vec<u8>> {
        fs::read(self.0.join(name))
    }

    fn entry(&self, name: &Path) -> Entry {
        let path = self.0.join(name);
        match path.symlink_metadata() {
            Err(_) => Entry::Absent,
            Ok(found) if found.is_file() => Entry::File,
            Ok(found) if found.is_symlink() && path.is_file() => Entry::Link,
            Ok(_) => Entry::Other,
        }
    }

    fn path(&self, name: &Path) -> PathBuf {
        self.0.join(name)
    }

    fn same(&self, one: &Path, other: &Path) -> bool {
        one == other || same_file::is_same_file(self.0.join(one), self.0.join(other)).unwrap_or(false)
    }
}

/// Files in memory, by name, for example those opened in a browser, or a machine after an import.
///
/// ```
/// use std::path::Path;
/// use trueaxis_tables::{Machine, files::Memory};
///
/// let files = Memory::new([
///     ("machine.toml", "name = \"m\"\nchain = \"w X' b t\"\n[axis.X]\ntable = \"x.csv\"\n"),
///     ("x.csv", "X_mm,EXX_um\n0,1\n10,two\n"),
/// ]);
/// let error = Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap_err();
/// assert_eq!(error.to_string(), "x.csv:3: column EXX_um: found \"two\", needed a number");
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Memory(BTreeMap<PathBuf, Vec<u8>>);

impl Memory {
    /// Files with their bytes or text; if two have the same name, the last one is used.
    pub fn new(files: impl IntoIterator<Item = (impl AsRef<Path>, impl Into<Vec<u8>>)>) -> Memory {
        Memory(files.into_iter().map(|(name, bytes)| (plain(name.as_ref()), bytes.into())).collect())
    }
}

/// Normalises a path: `./a/../x.csv` becomes `x.csv`.
fn plain(name: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in name.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

impl Source for Memory {
    fn read(&self, name: &Path) -> io::Result<Vec<u8>> {
        self.0.get(&plain(name)).cloned().ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn entry(&self, name: &Path) -> Entry {
        if self.0.contains_key(&plain(name)) { Entry::File } else { Entry::Absent }
    }

    fn same(&self, one: &Path, other: &Path) -> bool {
        plain(one) == plain(other)
    }
}

/// Changed files in memory on top of an underlying source: a machine as an edit would leave it.
pub(crate) struct Edit<'a> {
    pub(crate) changed: Memory,
    pub(crate) beneath: &'a dyn Source,
}

impl Source for Edit<'_> {
    fn read(&self, name: &Path) -> io::Result<Vec<u8>> {
        self.changed.read(name).or_else(|_| self.beneath.read(name))
    }

    fn entry(&self, name: &Path) -> Entry {
        if self.changed.entry(name).is_file() { Entry::File } else { self.beneath.entry(name) }
    }

    fn path(&self, name: &Path) -> PathBuf {
        self.beneath.path(name)
    }

    fn same(&self, one: &Path, other: &Path) -> bool {
        self.beneath.same(one, other)
    }
}
