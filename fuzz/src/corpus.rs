//! Inputs in files: the committed corpus, one archive per target, and folders with one file per input.

use crate::Target;
use crate::archive::{Inputs, pack, unpack};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The folder of this crate.
pub fn home() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The archive with a target's corpus.
pub fn archive(target: &Target) -> PathBuf {
    home().join("corpus").join(format!("{}.tar.gz", target.name))
}

/// Reads the inputs of an archive.
///
/// # Errors
/// A missing or damaged archive.
pub fn read(archive: &Path) -> Result<Inputs> {
    let shown = archive.display();
    let bytes = match fs::read(archive) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            bail!(
                "{shown}: found no archive, needed one, even an empty one: `trueaxis-fuzz pack` writes it from a folder"
            )
        }
        bytes => bytes.with_context(|| shown.to_string())?,
    };
    unpack(&bytes).map_err(|found| {
        anyhow::anyhow!("{shown}: found {found:#}, needed an archive of inputs as `trueaxis-fuzz pack` writes it")
    })
}

/// Writes an archive, unless it already has these inputs: another version of the compressor would write other bytes.
///
/// # Errors
/// A file that cannot be written.
pub fn write(archive: &Path, inputs: &Inputs) -> Result<()> {
    if read(archive).is_ok_and(|kept| kept == *inputs) {
        return Ok(());
    }
    let shown = || archive.display().to_string();
    fs::write(archive, pack(inputs).with_context(shown)?).with_context(shown)
}

/// Adds an input to an archive.
///
/// # Errors
/// Another input of this name in the archive, or an archive that cannot be read or written.
pub fn add(archive: &Path, name: &str, input: Vec<u8>) -> Result<()> {
    let mut inputs = read(archive)?;
    if let Some(kept) = inputs.insert(name.to_owned(), input) {
        ensure!(kept == inputs[name], "{}: found another input {name:?}, needed a new name", archive.display());
    }
    write(archive, &inputs)
}

/// Every file of a folder, ordered by name; empty if the folder does not exist.
///
/// # Errors
/// A file that cannot be read.
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

/// The files of a folder as inputs.
///
/// # Errors
/// A missing folder, or a file that cannot be read.
pub fn gather(folder: &Path) -> Result<Inputs> {
    let shown = folder.display();
    ensure!(folder.is_dir(), "{shown}: found no folder, needed a folder with one file per input");
    let named = |(path, input): (PathBuf, Vec<u8>)| {
        let name = path.file_name().and_then(|name| name.to_str());
        let name = name.with_context(|| format!("{}: needed a name that is UTF-8", path.display()))?;
        Ok((name.to_owned(), input))
    };
    files(folder).with_context(|| shown.to_string())?.into_iter().map(named).collect()
}

/// Writes every input into a file of a folder, which must be new or empty: any other file would be packed as well.
///
/// # Errors
/// A folder that is not empty or cannot be written.
pub fn spread(inputs: &Inputs, folder: &Path) -> Result<()> {
    let shown = || folder.display().to_string();
    fs::create_dir_all(folder).with_context(shown)?;
    let empty = fs::read_dir(folder).with_context(shown)?.next().is_none();
    ensure!(empty, "{}: found files, needed a new or empty folder", shown());
    inputs.iter().try_for_each(|(name, input)| fs::write(folder.join(name), input)).with_context(shown)
}

/// Seeds and corpus of a target.
///
/// # Errors
/// A corpus that cannot be read.
pub fn inputs(target: &Target) -> Result<Vec<Vec<u8>>> {
    Ok((target.seeds)().into_iter().chain(read(&archive(target))?.into_values()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(name: &str, input: &[u8]) -> Inputs {
        [(name.to_owned(), input.to_vec())].into()
    }

    #[test]
    fn inputs_go_from_folder_to_archive_and_back() {
        let folder = tempfile::tempdir().unwrap();
        let (archive, loose) = (folder.path().join("a.tar.gz"), folder.path().join("loose/a"));
        let mut inputs = one("finding-what", b"\0\xff");
        inputs.insert("1".to_owned(), Vec::new());
        write(&archive, &inputs).unwrap();
        spread(&read(&archive).unwrap(), &loose).unwrap();
        assert_eq!(gather(&loose).unwrap(), inputs);
        let refusal = spread(&inputs, &loose).unwrap_err().to_string();
        assert_eq!(refusal, format!("{}: found files, needed a new or empty folder", loose.display()));
    }

    #[test]
    fn an_archive_stays_as_it_is_while_its_inputs_do() {
        let folder = tempfile::tempdir().unwrap();
        let archive = folder.path().join("a.tar.gz");
        let inputs = one("1", b"input");
        let mut other_bytes = pack(&inputs).unwrap();
        // The operating system in gzip's header.
        other_bytes[9] ^= 1;
        fs::write(&archive, &other_bytes).unwrap();
        write(&archive, &inputs).unwrap();
        assert_eq!(fs::read(&archive).unwrap(), other_bytes);
        write(&archive, &one("2", b"input")).unwrap();
        assert_eq!(read(&archive).unwrap(), one("2", b"input"));
    }

    #[test]
    fn no_input_is_lost_where_one_is_added() {
        let folder = tempfile::tempdir().unwrap();
        let archive = folder.path().join("a.tar.gz");
        write(&archive, &one("1", b"input")).unwrap();
        add(&archive, "finding-what", b"2".to_vec()).unwrap();
        add(&archive, "1", b"input".to_vec()).unwrap();
        let refusal = add(&archive, "1", b"other".to_vec()).unwrap_err().to_string();
        assert_eq!(refusal, format!("{}: found another input \"1\", needed a new name", archive.display()));
        assert!(add(&archive, "../1", Vec::new()).is_err());
        let kept = read(&archive).unwrap();
        assert_eq!((kept.len(), &kept["1"][..], &kept["finding-what"][..]), (2, &b"input"[..], &b"2"[..]));
    }

    #[test]
    fn missing_and_damaged_archives_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let archive = folder.path().join("a.tar.gz");
        let shown = archive.display();
        let refusal = || read(&archive).unwrap_err().to_string();
        assert!(refusal().starts_with(&format!("{shown}: found no archive, needed one")), "{}", refusal());
        let packed = pack(&one("1", b"input")).unwrap();
        fs::write(&archive, &packed[..packed.len() - 1]).unwrap();
        assert!(refusal().starts_with(&format!("{shown}: found no sound gzip: ")), "{}", refusal());
        assert!(refusal().ends_with("needed an archive of inputs as `trueaxis-fuzz pack` writes it"), "{}", refusal());
        let loose = folder.path().join("loose");
        let refusal = gather(&loose).unwrap_err().to_string();
        assert_eq!(refusal, format!("{}: found no folder, needed a folder with one file per input", loose.display()));
    }
}
