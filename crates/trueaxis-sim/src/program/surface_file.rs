//! The file of a surface: TOML, and a height map of RepRapFirmware that it names.

use super::ProgramError;
use super::error::Refusal;
use super::height_map::HeightMap;
use super::surface::{Solid, Surface};
use super::words::LARGEST;
use crate::calibration::artefact::Artefact;
use glam::{DMat3, DVec3};
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;
use trueaxis_tables::formats::{Format, import};
use trueaxis_tables::text::line_at;

/// Needed instead of a file without any.
const NEEDED: &str = "tip_diameter_mm, plane_z_mm, [height_map], [[box]], [[ball]]";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceFile {
    tip_diameter_mm: Option<Spanned<f64>>,
    plane_z_mm: Option<Spanned<f64>>,
    height_map: Option<MapTable>,
    #[serde(default, rename = "box")]
    boxes: Vec<BoxTable>,
    #[serde(default, rename = "ball")]
    balls: Vec<BallTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MapTable {
    file: Spanned<String>,
    z_mm: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxTable {
    from_mm: Spanned<[f64; 3]>,
    to_mm: Spanned<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BallTable {
    centre_mm: Spanned<[f64; 3]>,
    diameter_mm: Spanned<f64>,
}

impl Surface {
    /// Reads what a probing move touches, in machine coordinates: `tip_diameter_mm` of the probe's ball (0 if absent),
    /// `plane_z_mm`, `[height_map]` (`file`, `z_mm` of its zero), `[[box]]` (`from_mm`, `to_mm`), `[[ball]]` (`centre_mm`,
    /// `diameter_mm`). `read` returns the text of a height map; `file` appears in errors only.
    ///
    /// # Errors
    /// Text in another format, a file without a surface, a box without inside, a height map that cannot be read; with its line.
    pub fn parse(
        text: &str,
        file: &str,
        read: impl Fn(&str) -> std::io::Result<String>,
    ) -> Result<Surface, ProgramError> {
        let at = |offset: usize| line_at(text, offset);
        let document: SurfaceFile = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| at(span.start));
            Refusal::new(line, error.message(), NEEDED).in_file(file)
        })?;
        let refuse = |line: u32, found: String, needed: &str| Refusal::new(line, found, needed).in_file(file);
        let number = |value: &Spanned<f64>, least: f64| match *value.get_ref() {
            number if (least..=LARGEST).contains(&number) => Ok(number),
            number => {
                Err(refuse(at(value.span().start), format!("{number}"), &format!("mm from {least} to {LARGEST}")))
            }
        };
        let point = |value: &Spanned<[f64; 3]>| match *value.get_ref() {
            point if point.iter().all(|one| one.abs() <= LARGEST) => Ok(DVec3::from(point)),
            point => Err(refuse(at(value.span().start), format!("{point:?}"), &format!("mm within ±{LARGEST}"))),
        };
        let tip = document.tip_diameter_mm.as_ref().map_or(Ok(0.0), |value| number(value, 0.0))?;
        let mut solids = Vec::new();
        if let Some(height) = &document.plane_z_mm {
            solids.push(Solid::Plane(number(height, -LARGEST)?));
        }
        if let Some(map) = &document.height_map {
            let zero = map.z_mm.as_ref().map_or(Ok(0.0), |value| number(value, -LARGEST))?;
            let line = at(map.file.span().start);
            let name = map.file.get_ref();
            let text = read(name)
                .map_err(|error| refuse(line, format!("{name}, which cannot be read ({error})"), "a height map"))?;
            solids.push(Solid::Map(HeightMap::parse(&text, name, zero)?));
        }
        for table in &document.boxes {
            let (from, to) = (point(&table.from_mm)?, point(&table.to_mm)?);
            if !from.cmplt(to).all() {
                let found = format!("a box from {from} to {to}");
                return Err(refuse(at(table.to_mm.span().start), found, "to_mm above from_mm along X, Y and Z"));
            }
            let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
            solids.push(Solid::Artefact(Artefact::Block { centre, directions: DMat3::IDENTITY, half }));
        }
        for table in &document.balls {
            let (centre, diameter) = (point(&table.centre_mm)?, number(&table.diameter_mm, 0.0)?);
            solids.push(Solid::Artefact(Artefact::Ball { centre, diameter }));
        }
        if solids.is_empty() {
            return Err(refuse(1, "nothing to touch".into(), NEEDED));
        }
        Ok(Surface { tip_radius_mm: 0.5 * tip, solids })
    }
}

impl HeightMap {
    /// Reads `heightmap.csv` of RepRapFirmware, with its zero at Z `zero` of the machine.
    fn parse(text: &str, file: &str, zero: f64) -> Result<HeightMap, ProgramError> {
        let imported = import(Format::HeightMap, text, Path::new(file), None).map_err(|error| {
            let column = error.column.map_or(String::new(), |column| format!("column {column}: "));
            ProgramError::new(file, error.line.unwrap_or(1), format!("{column}{}", error.found), error.needed)
        })?;
        let Some(source) = imported.grids.first().map(trueaxis_tables::Grid::source) else {
            return Err(ProgramError::new(file, 1, "no heights", "a height map"));
        };
        let [x, y, _] = source.nodes.clone();
        // A height is an error of Z with the other sign.
        let heights = source.values.iter().map(|value| zero - value[2]).collect();
        Ok(HeightMap { nodes: [x, y], heights })
    }
}
