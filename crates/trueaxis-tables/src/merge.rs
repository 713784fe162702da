//! Sections of a servo's figures, as identifications write them, merged into a machine.

use crate::document::{as_before, set};
use crate::error::FileError;
use crate::origin::Origin;
use crate::read::text_is_sound;
use crate::text::line_at;
use std::path::Path;
use toml_edit::{DocumentMut, Item, Table, TableLike};

/// Sections of an axis that a fragment may have.
const OF_AXIS: [&str; 3] = ["drive", "friction", "dynamic"];
const NEEDED: &str = "sections [axis.X.drive], [axis.X.friction], [axis.X.dynamic] or [contour.feedback]";

/// The text of a `machine.toml` with the sections of a fragment in it: `[axis.*.drive]`, `[axis.*.friction]`,
/// `[axis.*.dynamic]`, `[contour.feedback]`.
///
/// A section that the machine has not got is added with its comments. In one that it has, the keys of the fragment are set;
/// its other keys, all other sections, their order and every comment stay. The result is checked as [`crate::Machine::read`]
/// does, but for the tables.
///
/// ```
/// let machine = "name = \"m\" # mine\nchain = \"w b X t\"\n\n[axis.X]\ntable = \"x.csv\"\n";
/// let drive = "[axis.X.drive]\nposition_gain_per_s = 100\nvelocity_gain_per_s = 700\nreset_time_s = 0.008\n";
/// let merged = trueaxis_tables::merge_sections(machine, drive)?;
/// assert_eq!(merged, format!("{machine}\n{drive}"));
/// # Ok::<(), trueaxis_tables::error::FileError>(())
/// ```
///
/// # Errors
/// Text that is no TOML, other sections in the fragment, an axis that the machine has not got, or a result that a
/// controller would refuse. The files are called `machine.toml` and `fragment.toml`: callers put in the names that they read.
pub fn merge_sections(machine_toml: &str, fragment: &str) -> Result<String, FileError> {
    let [machine, fragments] = ["machine.toml", "fragment.toml"].map(|name| Origin::new(Path::new(name)));
    let mut document = parsed(machine_toml.strip_prefix('\u{feff}').unwrap_or(machine_toml), &machine)?;
    let given = parsed(fragment, &fragments)?;
    let place = Place { origin: &fragments, text: fragment };
    for (key, item) in given.iter() {
        match (key, item.as_table_like()) {
            ("axis", Some(axes)) => merge_axes(axes, &mut document, &place)?,
            ("contour", Some(contour)) => {
                let to = section(document.as_table_mut(), "contour", &machine)?;
                merge_into(contour, to, "contour", &["feedback"], &place)?;
            }
            _ => return Err(place.refused(key, key)),
        }
    }
    let text = as_before(document.to_string(), machine_toml);
    text_is_sound(&text, &machine).map_err(|error| FileError {
        needed: format!("{} (in the machine with the sections merged; nothing is written)", error.needed),
        ..error
    })?;
    Ok(text)
}

fn parsed(text: &str, origin: &Origin) -> Result<DocumentMut, FileError> {
    text.parse::<DocumentMut>().map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(text, span.start));
        origin.at(line, "", error.message(), "a valid TOML file")
    })
}

/// The fragment, for errors in it.
struct Place<'t> {
    origin: &'t Origin,
    text: &'t str,
}

impl Place<'_> {
    /// A key that is none of those needed; at the first line that has its last name.
    fn refused(&self, full: &str, name: &str) -> FileError {
        let line = (1..)
            .zip(self.text.lines())
            .find(|(_, line)| line.split('#').next().is_some_and(|line| line.contains(name)));
        self.origin.at(line.map_or(0, |(line, _)| line), full, name, NEEDED)
    }
}

fn merge_axes(axes: &dyn TableLike, document: &mut DocumentMut, place: &Place<'_>) -> Result<(), FileError> {
    let machine = Origin::new(Path::new("machine.toml"));
    for (letter, item) in axes.iter() {
        let name = format!("axis.{letter}");
        let given = item.as_table_like().ok_or_else(|| place.refused(&name, letter))?;
        let to = section(document.as_table_mut(), "axis", &machine)?;
        let to = section(to, letter, &machine)?;
        merge_into(given, to, &name, &OF_AXIS, place)?;
    }
    Ok(())
}

/// A section of a table, made where there is none, without a header of its own.
fn section<'d>(table: &'d mut dyn TableLike, name: &str, origin: &Origin) -> Result<&'d mut dyn TableLike, FileError> {
    let new = || {
        let mut new = Table::new();
        new.set_implicit(true);
        Item::Table(new)
    };
    let refused = || origin.whole(format!("a {name} that is no section"), format!("a section [{name}]"));
    table.entry(name).or_insert_with(new).as_table_like_mut().ok_or_else(refused)
}

/// The sections of `given` that are in `names`, merged into those of `to`.
fn merge_into(
    given: &dyn TableLike,
    to: &mut dyn TableLike,
    prefix: &str,
    names: &[&str],
    place: &Place<'_>,
) -> Result<(), FileError> {
    for (name, item) in given.iter() {
        let full = format!("{prefix}.{name}");
        let known = names.contains(&name);
        let from = item.as_table_like().filter(|_| known).ok_or_else(|| place.refused(&full, name))?;
        match to.get_mut(name).and_then(Item::as_table_like_mut) {
            Some(section) => {
                for (key, value) in from.iter() {
                    let value = value.as_value().ok_or_else(|| place.refused(&format!("{full}.{key}"), key))?;
                    set(section, key, value.clone());
                }
            }
            None => {
                // Without the place that it had in the fragment: behind what is there.
                let mut section = Table::new();
                if let Some(table) = item.as_table() {
                    *section.decor_mut() = table.decor().clone();
                }
                if section.decor().prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default().is_empty() {
                    section.decor_mut().set_prefix("\n");
                }
                from.iter().for_each(|(key, value)| {
                    section.insert(key, value.clone());
                });
                to.insert(name, Item::Table(section));
            }
        }
    }
    Ok(())
}
