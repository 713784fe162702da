//! Lines of all keys and sections of a TOML file, for errors that only later checks find.

use crate::text::line_at;
use std::collections::BTreeMap;
use toml::de::DeTable;

/// A key or section as written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// Line, from 1.
    pub line: u32,
    /// The value; empty for a section.
    pub text: String,
}

/// The keys and sections of a file by their full names, like `axis.X.limits.magnitude_um`; sections of a list have their
/// number, from 0: `crosstalk[0].tip`.
#[derive(Clone, Debug)]
pub struct Keys(BTreeMap<String, Written>);

impl Keys {
    /// All keys and sections of the table, which was parsed from `text`.
    pub fn new(text: &str, table: &DeTable<'_>) -> Keys {
        let mut keys = Keys(BTreeMap::new());
        keys.add(text, "", table);
        keys
    }

    fn add(&mut self, text: &str, prefix: &str, table: &DeTable<'_>) {
        for (key, value) in table {
            let name = format!("{prefix}{}", key.get_ref());
            let section = value.get_ref().as_table();
            let (span, written) = match section {
                Some(_) => (key.span(), ""),
                None => (value.span(), text.get(value.span()).unwrap_or_default()),
            };
            if let Some(section) = section {
                self.add(text, &format!("{name}."), section);
            }
            let list = value.get_ref().as_array().into_iter().flat_map(|list| list.iter());
            for (index, section) in
                list.enumerate().filter_map(|(index, item)| Some((index, item.get_ref().as_table()?)))
            {
                self.add(text, &format!("{name}[{index}]."), section);
            }
            self.0.insert(name, Written { line: line_at(text, span.start), text: written.into() });
        }
    }

    /// The key or section with this name.
    pub fn get(&self, name: &str) -> Option<&Written> {
        self.0.get(name)
    }

    /// Line of the innermost section of a key, whether the key is present or not; `None` for the file.
    pub fn section(&self, name: &str) -> Option<u32> {
        let (section, _) = name.rsplit_once('.')?;
        self.get(section).map(|written| written.line).or_else(|| self.section(section))
    }
}
