//! Lists of specifications, as written in a scenario file for faults and events.

use serde::{Deserialize, Serialize};
use std::fmt::Display;
use std::str::FromStr;

/// An ordered list of items, each written as one text: `["dropout:X@1.25s+3", …]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    try_from = "Vec<String>",
    into = "Vec<String>",
    bound(serialize = "T: Clone + Display", deserialize = "T: FromStr<Err: Display>")
)]
pub struct Script<T> {
    /// The items.
    pub items: Vec<T>,
}

impl<T> Default for Script<T> {
    /// An empty list.
    fn default() -> Script<T> {
        Script { items: Vec::new() }
    }
}

impl<T: FromStr> Script<T> {
    /// Reads one specification per item.
    ///
    /// # Errors
    /// The first invalid specification.
    pub fn parse<S: AsRef<str>>(specs: impl IntoIterator<Item = S>) -> Result<Script<T>, T::Err> {
        let items = specs.into_iter().map(|spec| spec.as_ref().parse()).collect::<Result<_, _>>()?;
        Ok(Script { items })
    }
}

impl<T: FromStr> TryFrom<Vec<String>> for Script<T> {
    type Error = T::Err;

    fn try_from(specs: Vec<String>) -> Result<Script<T>, T::Err> {
        Script::parse(specs)
    }
}

impl<T: Display> From<Script<T>> for Vec<String> {
    fn from(script: Script<T>) -> Vec<String> {
        script.items.iter().map(T::to_string).collect()
    }
}
