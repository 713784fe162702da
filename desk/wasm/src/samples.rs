//! The sample machines of `compensation-tables`.

use crate::files::{DESCRIPTION, Texts};
use anyhow::{Context, Result};
use serde::Serialize;

macro_rules! sample {
    ($folder:literal: $($file:literal)*) => {
        ($folder, &[$(($file, include_str!(concat!("../../../compensation-tables/", $folder, "/", $file)))),*])
    };
}

/// A machine's name and files.
type Sample = (&'static str, &'static [(&'static str, &'static str)]);

const SAMPLES: [Sample; 6] = [
    sample!("mill-3axis": "machine.toml" "x.csv" "y.csv" "z.csv" "x-iso230-2.csv"),
    sample!("mill-5axis": "machine.toml" "x.csv" "y.csv" "z.csv" "a.csv" "c.csv"),
    sample!("head-5axis": "machine.toml" "x.csv" "y.csv" "z.csv" "a.csv" "c.csv"),
    sample!("mill-turn": "machine.toml" "x.csv" "y.csv" "z.csv" "a.csv" "c.csv"),
    sample!("grinder": "machine.toml" "x.csv"),
    sample!("router": "machine.toml" "x.csv" "y.csv" "rail.csv" "surface.csv"),
];

/// A sample machine described in one sentence.
#[derive(Debug, Serialize)]
pub(crate) struct Described {
    name: &'static str,
    description: String,
}

/// All sample machines.
pub(crate) fn samples() -> Vec<Described> {
    SAMPLES.iter().map(|(name, files)| Described { name, description: description(files) }).collect()
}

/// The first sentence of the opening comment in `machine.toml`.
fn description(files: &[(&str, &str)]) -> String {
    let text = files.iter().find(|(name, _)| *name == DESCRIPTION).map_or("", |(_, text)| text);
    let comment: Vec<&str> = text.lines().map_while(|line| line.strip_prefix("# ")).collect();
    let comment = comment.join(" ");
    comment.split_once(". ").map_or(comment.as_str(), |(first, _)| first).trim_end_matches('.').to_owned()
}

/// The files of one sample.
pub(crate) fn sample(name: &str) -> Result<Texts> {
    let known = || SAMPLES.map(|(name, _)| name).join(" ");
    let (_, files) = SAMPLES
        .iter()
        .find(|(known, _)| *known == name)
        .with_context(|| format!("found the sample {name:?}, needed one of {}", known()))?;
    Ok(files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_samples_are_the_folders_with_all_of_their_files() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables");
        let mut count = 0;
        for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap).filter(|entry| entry.path().is_dir()) {
            let files = sample(&entry.file_name().to_string_lossy()).unwrap();
            let names: Vec<_> = std::fs::read_dir(entry.path()).unwrap().map(|file| file.unwrap()).collect();
            assert_eq!(names.len(), files.len(), "{:?}", entry.path());
            for file in names {
                let text = std::fs::read_to_string(file.path()).unwrap();
                assert_eq!(files[&*file.file_name().to_string_lossy()], text, "{:?}", file.path());
            }
            count += 1;
        }
        assert_eq!(count, SAMPLES.len());
        assert_eq!(samples()[1].name, "mill-5axis");
        let trunnion = "Five-axis machining centre: trunnion A on the slide Y, rotary table C in the trunnion; the spindle on Z on X";
        assert_eq!(samples()[1].description, trunnion);
    }
}
