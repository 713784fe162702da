//! One `.tar.gz` for all inputs of a target, so that a checkout is not slowed by thousands of small files.
//!
//! The archive has sorted names and neither times nor owners: equal inputs give equal bytes with the same version of
//! `flate2`.

use anyhow::{Context, Result, ensure};
use flate2::bufread::GzDecoder;
use flate2::{Compression, GzBuilder};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::{Read, Write};
use std::path::Path;

/// Inputs by name; they run in the order of their names.
pub type Inputs = BTreeMap<String, Vec<u8>>;

/// Packs the inputs into an archive.
///
/// # Errors
/// A name that is not a plain file name.
pub fn pack(inputs: &Inputs) -> Result<Vec<u8>> {
    let mut tar = tar::Builder::new(Vec::new());
    for (name, input) in inputs {
        check_name(name)?;
        let mut header = tar::Header::new_gnu();
        header.set_entry_type(tar::EntryType::Regular);
        header.set_mode(0o644);
        header.set_mtime(0);
        header.set_uid(0);
        header.set_gid(0);
        header.set_size(input.len() as u64);
        tar.append_data(&mut header, name, input.as_slice()).with_context(|| name.clone())?;
    }
    let mut gzip = GzBuilder::new().mtime(0).write(Vec::new(), Compression::best());
    gzip.write_all(&tar.into_inner()?)?;
    Ok(gzip.finish()?)
}

/// Unpacks an archive in memory.
///
/// # Errors
/// A damaged archive, or entries other than files without a folder.
pub fn unpack(archive: &[u8]) -> Result<Inputs> {
    // Read to the end first: the check sum of the whole archive comes last.
    let mut gzip = GzDecoder::new(archive);
    let mut bytes = Vec::new();
    gzip.read_to_end(&mut bytes).context("no sound gzip")?;
    ensure!(gzip.into_inner().is_empty(), "bytes after its end");
    let mut inputs = Inputs::new();
    for entry in tar::Archive::new(bytes.as_slice()).entries()? {
        let mut entry = entry?;
        let name = String::from_utf8(entry.path_bytes().into_owned()).context("a name that is not UTF-8")?;
        check_name(&name)?;
        ensure!(entry.header().entry_type().is_file(), "{name:?}, which is not a file");
        let mut input = Vec::new();
        entry.read_to_end(&mut input)?;
        ensure!(input.len() as u64 == entry.size(), "{} of {} bytes of {name:?}", input.len(), entry.size());
        ensure!(inputs.insert(name.clone(), input).is_none(), "{name:?} twice");
    }
    Ok(inputs)
}

/// Once unpacked into a folder, no input may land outside it or in a subfolder.
fn check_name(name: &str) -> Result<()> {
    ensure!(
        Path::new(name).file_name() == Some(OsStr::new(name)) && !name.contains(['\\', '\0']),
        "the name {name:?}, needed that of a file without a folder"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inputs() -> Inputs {
        let of = |(name, input): (&str, &[u8])| (name.to_owned(), input.to_vec());
        let long = "n".repeat(200);
        [("b", b"\0\xff".as_slice()), ("finding-what", b""), ("a", b"G1 X1\n"), (&long, &[7; 1500])].map(of).into()
    }

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut gzip = GzBuilder::new().write(Vec::new(), Compression::fast());
        gzip.write_all(bytes).unwrap();
        gzip.finish().unwrap()
    }

    /// An archive as another program might write it.
    fn foreign(entries: &[(&str, tar::EntryType, &[u8])]) -> Vec<u8> {
        let mut tar = tar::Builder::new(Vec::new());
        for (name, kind, input) in entries {
            let mut header = tar::Header::new_gnu();
            header.as_old_mut().name[..name.len()].copy_from_slice(name.as_bytes());
            header.set_entry_type(*kind);
            header.set_size(input.len() as u64);
            header.set_cksum();
            tar.append(&header, *input).unwrap();
        }
        tar.into_inner().unwrap()
    }

    #[test]
    fn packed_inputs_are_unpacked() {
        for inputs in [Inputs::new(), inputs()] {
            assert_eq!(unpack(&pack(&inputs).unwrap()).unwrap(), inputs);
        }
    }

    #[test]
    fn the_same_inputs_give_the_same_bytes_without_times_and_owners() {
        let packed = pack(&inputs()).unwrap();
        assert_eq!(pack(&unpack(&packed).unwrap()).unwrap(), packed);
        assert_eq!(pack(&inputs().into_iter().rev().collect()).unwrap(), packed);
        assert_eq!(packed[4..8], [0; 4], "gzip's time");
        let mut bytes = Vec::new();
        GzDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
        let mut names = Vec::new();
        for entry in tar::Archive::new(bytes.as_slice()).entries().unwrap() {
            let entry = entry.unwrap();
            let header = entry.header();
            let (mode, time) = (header.mode().unwrap(), header.mtime().unwrap());
            assert_eq!((mode, time, header.uid().unwrap(), header.gid().unwrap()), (0o644, 0, 0, 0));
            names.push(entry.path_bytes().into_owned());
        }
        assert!(names.len() == 4 && names.is_sorted());
    }

    #[test]
    fn a_damaged_archive_is_refused() {
        let packed = pack(&inputs()).unwrap();
        for length in 0..packed.len() {
            assert!(unpack(&packed[..length]).is_err(), "the first {length} bytes");
        }
        assert!(unpack(&[packed.as_slice(), b"\0"].concat()).is_err());
        for bit in 0..8 * packed.len() {
            let mut damaged = packed.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            // Some bits do not matter: gzip's time, or which of two equal runs a copy refers to.
            if let Ok(read) = unpack(&damaged) {
                assert_eq!(read, inputs(), "bit {bit}");
            }
        }
    }

    #[test]
    fn an_archive_of_other_things_than_files_is_refused() {
        use tar::EntryType::{Directory, Regular, Symlink};
        let refusal = |tar: &[u8]| unpack(&gzip(tar)).unwrap_err().to_string();
        assert_eq!(unpack(&gzip(&foreign(&[("a", Regular, b"1")]))).unwrap(), [("a".to_owned(), b"1".to_vec())].into());
        for name in ["../a", "/a", "a/b", "a/", ".", "..", "a\\b"] {
            assert!(refusal(&foreign(&[(name, Regular, b"1")])).contains("needed that of a file"), "{name}");
        }
        assert_eq!(refusal(&foreign(&[("a", Directory, b"")])), "\"a\", which is not a file");
        assert_eq!(refusal(&foreign(&[("a", Symlink, b"")])), "\"a\", which is not a file");
        assert_eq!(refusal(&foreign(&[("a", Regular, b"1"), ("a", Regular, b"2")])), "\"a\" twice");
        assert_eq!(refusal(&foreign(&[("a", Regular, &[1; 600])])[..700]), "188 of 600 bytes of \"a\"");
        assert!(pack(&[("a/b".to_owned(), Vec::new())].into()).is_err());
    }
}
