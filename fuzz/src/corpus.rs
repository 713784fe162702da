//! Inputs kept in files: the committed corpus, and findings.

use crate::Target;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The folder of this crate.
pub fn home() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folder with the corpus of a target; may be missing.
pub fn folder(target: &Target) -> PathBuf {
    home().join("corpus").join(target.name)
}

/// Every file of a folder, in the order of their names; none where there is no folder.
///
/// # Errors
/// Something cannot be read.
pub fn files(folder: &Path) -> io::Result<Vec<(PathBuf, Vec<u8>)>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let mut paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<Vec<_>>>()?;
    paths.retain(|path| path.is_file());
    paths.sort();
    paths.into_iter().map(|path| fs::read(&path).map(|bytes| (path, bytes))).collect()
}

/// Seeds and corpus of a target.
///
/// # Errors
/// A file cannot be read.
pub fn inputs(target: &Target) -> io::Result<Vec<Vec<u8>>> {
    let kept = files(&folder(target))?;
    Ok((target.seeds)().into_iter().chain(kept.into_iter().map(|(_, bytes)| bytes)).collect())
}
