//! Blocks with parallel faces: gauge blocks, parallels, edges, 1-2-3 blocks.

use super::place::Place;
use super::ranges::number;
use trueaxis_tables::Section;
use trueaxis_tables::error::FileError;

/// A block with three pairs of parallel faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Distances between opposite faces, mm.
    pub size_mm: [f64; 3],
    /// Number of lengths that are measured, 1 (gauge block) or 3.
    pub measured: usize,
    /// Standard uncertainty of its right angles, rad; `None` if they are unknown.
    pub angles: Option<f64>,
    /// Index of the block whose lengths it has, and the standard uncertainty of the difference, mm.
    pub like: Option<(usize, f64)>,
}

/// Pairs of lengths whose faces are at right angles.
pub const ANGLES: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

impl Block {
    /// Reads a block; `before`: the names of the artefacts above it, with their blocks.
    pub(super) fn read(
        section: &Section<'_>,
        kind: &str,
        before: &[(&str, Option<&Block>)],
    ) -> Result<Block, FileError> {
        let fine = |sizes: &[f64]| sizes.iter().all(|mm| (0.5..=5000.0).contains(mm));
        let (size_mm, measured) = if kind == "block" {
            let sizes = section.numbers::<3>("size_mm")?;
            let sizes = sizes.ok_or_else(|| section.missing_here("size_mm", "its three lengths, mm"))?;
            if !fine(&sizes.value) {
                return Err(section.wrong(&sizes, "0.5 to 5000 mm each"));
            }
            (sizes.value, 3)
        } else {
            let length = number(section, "length_mm", [0.5, 5000.0], " mm")?;
            let length = length.ok_or_else(|| section.missing_here("length_mm", "the distance of its faces, mm"))?;
            let faces = section.numbers::<2>("section_mm")?;
            let faces = faces.ok_or_else(|| section.missing_here("section_mm", "the two sides of its faces, mm"))?;
            if !fine(&faces.value) {
                return Err(section.wrong(&faces, "0.5 to 5000 mm each"));
            }
            ([length, faces.value[0], faces.value[1]], 1)
        };
        let angles = match measured {
            3 => number(section, "uncertainty_urad", [0.001, 1e5], " urad")?.map(|urad| 1e-6 * urad),
            _ => None,
        };
        let mut block = Block { size_mm, measured, angles, like: None };
        if let Some(name) = section.string("same_as")? {
            let own = |(_, (of, block)): &(usize, &(&str, Option<&Block>))| {
                *of == name.value && block.is_some_and(|block| block.measured == measured && block.like.is_none())
            };
            let of = before.iter().enumerate().find(own).and_then(|(index, (_, block))| Some((index, (*block)?)));
            let (of, other) = of.ok_or_else(|| section.wrong(&name, "the name of a block of this kind above it"))?;
            if other.size_mm[..measured] != size_mm[..measured] {
                let [own, other] = [size_mm, other.size_mm].map(|sizes| format!("{:?} mm", &sizes[..measured]));
                return Err(section.at(name.line, "same_as", &own, format!("{other}, as {}", name.value)));
            }
            let um = number(section, "difference_um", [0.001, 1e4], " um")?;
            let needed = "the standard uncertainty of the difference, um";
            block.like = Some((of, 1e-3 * um.ok_or_else(|| section.missing_here("difference_um", needed))?));
        } else {
            match (section.boolean("unknown_length")?.unwrap_or(false), section.number("uncertainty_um")?) {
                (true, Some(um)) => return Err(section.wrong(&um, "either unknown_length or uncertainty_um")),
                (false, None) => {
                    let needed = "the standard uncertainty of its lengths, um, or unknown_length = true";
                    return Err(section.missing_here("uncertainty_um", needed));
                }
                _ => {}
            }
        }
        Ok(block)
    }

    /// Whether a pair of faces can be touched at a place.
    pub(super) fn touches_any(&self, place: &Place) -> bool {
        self.measured == 3 || place.along != place.normal || place.base
    }

    /// Name of a length.
    pub(super) fn length_name(&self, index: usize, name: &str) -> String {
        if self.measured == 1 { format!("length of {name}") } else { format!("length {} of {name}", index + 1) }
    }

    /// Whether both faces of a length are touched at a place.
    pub(super) fn measures(&self, place: &Place, index: usize) -> bool {
        let [axes, _] = directions(place);
        index < self.measured && (axes[index] != place.normal.index() as i8 || place.base)
    }
}

/// Axis of the machine along each length, 0 to 2, and the sense of the length on it: the lengths make a right-handed system.
pub fn directions(place: &Place) -> [[i8; 3]; 2] {
    let [first, second] = [place.along, place.across].map(|axis| (axis.index() % 3) as i8);
    let even = (second - first).rem_euclid(3) == 1;
    let over = if place.reversed { -1 } else { 1 };
    [[first, second, 3 - first - second], [over, 1, if even { over } else { -over }]]
}
