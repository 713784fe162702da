//! The sample machines of `compensation-tables`, read from their compiled files.

use super::combination::Combination;
use super::dice::Dice;
use super::drawn::Drawn;
use std::path::Path;
use std::sync::LazyLock;
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::{Machine, compile};

const NAMES: [&str; 5] = ["mill-3axis", "grinder", "mill-5axis", "head-5axis", "mill-turn"];

/// The compiled files of the sample machines, in the order of the folder names here.
pub(super) static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables");
    NAMES.map(|name| compile(&Machine::read(&folder.join(name)).expect(name)).expect(name)).into()
});

static SAMPLES: LazyLock<Vec<Machine>> = LazyLock::new(|| {
    FILES.iter().map(|file| Machine::from_tcomp(&Tcomp::parse(file).expect("what was compiled"))).collect()
});

/// A sample with the given number of axes, if any, and with the requested model.
pub(super) fn with(dice: &mut Dice, of: &Combination) -> Option<Drawn> {
    let fitting: Vec<_> = SAMPLES.iter().filter(|machine| machine.settings.step_axes().count() == of.axes).collect();
    if fitting.is_empty() {
        return None;
    }
    let mut settings = dice.one_of(&fitting).settings.clone();
    let tables = fitting.iter().find(|machine| machine.settings == settings)?.tables.iter();
    let tables = tables.map(|table| table.as_ref().map(|table| table.rows.clone())).collect();
    settings.compensation.model = of.model;
    settings.compensation.orientation &= of.model == trueaxis::machine::ErrorModel::Volumetric;
    Some(Drawn { settings, tables, grids: Vec::new() })
}
