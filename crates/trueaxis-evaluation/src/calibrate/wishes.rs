//! `[plan]` of a task: what `calibrate plan --minutes` may choose from, and what the machine's errors may be.

use super::ranges::number;
use trueaxis::machine::Axis;
use trueaxis_tables::Section;
use trueaxis_tables::error::FileError;

/// What a planner may choose from.
#[derive(Clone, Debug, PartialEq)]
pub struct Wishes {
    /// Lengths of the styli that there are, shortest first, mm; empty: the machine's tool only.
    pub styli_mm: Vec<f64>,
    /// Lowest and highest position of X, Y, Z that the tip of the shortest stylus may have at an artefact, mm; `None`: the
    /// travels.
    pub free_mm: Option<[[f64; 2]; 3]>,
    /// Directions that rings, plates and squares may face.
    pub normals: Vec<Axis>,
    /// Time to set an artefact up, minutes.
    pub set_up_minutes: f64,
    /// Lengths of the tools with which the machine works, mm; empty: the machine's tool.
    pub tools_mm: Vec<f64>,
    /// Standard deviations before anything is measured: squareness, rad; scale, 1; straightness and positioning, mm; lost
    /// motion, mm.
    pub ranges: [f64; 4],
    /// Lowest and highest angle of A and B at which a ball on the table may be touched, degrees.
    pub tilts_deg: [f64; 2],
    /// Line in the task file.
    pub line: u32,
}

impl Default for Wishes {
    fn default() -> Wishes {
        Wishes {
            styli_mm: Vec::new(),
            free_mm: None,
            normals: vec![Axis::Z, Axis::Y, Axis::X],
            set_up_minutes: 3.0,
            tools_mm: Vec::new(),
            ranges: [50e-6, 50e-6, 3e-3, 5e-3],
            tilts_deg: [-30.0, 30.0],
            line: 0,
        }
    }
}

/// Reads `[plan]`.
pub(super) fn read_wishes(section: Section<'_>) -> Result<Wishes, FileError> {
    let mut wishes = Wishes { line: section.first_line(), ..Wishes::default() };
    if let Some(found) = section.list("styli_mm")? {
        let mut lengths = found.value.clone();
        lengths.sort_by(f64::total_cmp);
        if !(1..=4).contains(&lengths.len()) || lengths.iter().any(|mm| !(1.0..=2000.0).contains(mm)) {
            return Err(section.wrong(&found, "1 to 4 lengths of 1 to 2000 mm"));
        }
        if let Some(twice) = lengths.windows(2).find(|pair| pair[1] - pair[0] < 1.0) {
            let needed = format!(
                "lengths that differ: with two of {} mm, a turn of Z about X or Y and its straightness are one",
                twice[0]
            );
            return Err(section.wrong(&found, needed));
        }
        wishes.styli_mm = lengths;
    }
    if let Some(found) = section.lists::<2>("free_mm")? {
        let rises = found.value.iter().all(|[low, high]| low <= high);
        match <[[f64; 2]; 3]>::try_from(found.value.clone()) {
            Ok(free) if rises => wishes.free_mm = Some(free),
            _ => return Err(section.wrong(&found, "lowest and highest position of X, of Y and of Z")),
        }
    }
    if let Some(found) = section.strings("normals")? {
        let axis = |name: &&str| {
            let axis = Axis::ALL.into_iter().find(|axis| axis.letter().to_string() == **name);
            axis.filter(|axis| !axis.is_rotary())
        };
        let all: Option<Vec<Axis>> = found.value.iter().map(axis).collect();
        match all.filter(|all| !all.is_empty()) {
            Some(all) => wishes.normals = all,
            None => return Err(section.wrong(&found, "a list of \"X\", \"Y\", \"Z\"")),
        }
    }
    if let Some(minutes) = number(&section, "set_up_minutes", [0.0, 600.0], " minutes")? {
        wishes.set_up_minutes = minutes;
    }
    if let Some(found) = section.list("tools_mm")? {
        if !(1..=4).contains(&found.value.len()) || found.value.iter().any(|mm| !(0.0..=2000.0).contains(mm)) {
            return Err(section.wrong(&found, "1 to 4 lengths of 0 to 2000 mm"));
        }
        wishes.tools_mm = found.value;
    }
    if let Some(found) = section.numbers::<2>("tilts_deg")? {
        let [low, high] = found.value;
        if !(-180.0..=0.0).contains(&low) || !(0.0..=180.0).contains(&high) {
            return Err(section.wrong(&found, "lowest and highest angle of A and B, -180 to 0 and 0 to 180 degrees"));
        }
        wishes.tilts_deg = found.value;
    }
    let keys = [
        ("squareness_range_urad", 1e-6),
        ("scale_range_ppm", 1e-6),
        ("straightness_range_um", 1e-3),
        ("backlash_range_um", 1e-3),
    ];
    for ((key, factor), to) in keys.into_iter().zip(&mut wishes.ranges) {
        if let Some(range) = number(&section, key, [0.01, 1e5], "")? {
            *to = factor * range;
        }
    }
    section.finish(None)?;
    Ok(wishes)
}
