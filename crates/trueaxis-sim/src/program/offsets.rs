//! Work offsets and home positions: LinuxCNC's parameter file, or TOML.

use serde::Deserialize;
use trueaxis_tables::text::line_at;

use super::ProgramError;
use super::error::Refusal;
use super::words::LARGEST;

/// Names of the nine systems, in the order of G10 L2 P1 to P9.
pub(super) const SYSTEMS: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/// Zero of a work coordinate system in machine coordinates, mm and degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct System {
    /// X Y Z A B C.
    pub offset: [f64; 6],
    /// Rotation of X and Y about Z, degrees.
    pub rotation_deg: f64,
}

/// Work offsets and stored positions that a controller keeps between programs, mm and degrees; all zero by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Offsets {
    /// G54 to G59.3.
    pub systems: [System; 9],
    /// Index of the system active at the beginning.
    pub active: usize,
    /// G92, X Y Z A B C.
    pub g92: [f64; 6],
    /// Whether G92 is active at the beginning.
    pub g92_active: bool,
    /// Positions of G28 and of G30 in machine coordinates, X Y Z A B C.
    pub home: [[f64; 6]; 2],
}

/// One table of the TOML form.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Table {
    x_mm: f64,
    y_mm: f64,
    z_mm: f64,
    a_deg: f64,
    b_deg: f64,
    c_deg: f64,
    rotation_deg: f64,
}

/// The TOML form. Each table is a separate field, so that an error is reported with its line.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct OffsetsFile {
    active: Option<String>,
    #[serde(rename = "G54")]
    g54: Option<Table>,
    #[serde(rename = "G55")]
    g55: Option<Table>,
    #[serde(rename = "G56")]
    g56: Option<Table>,
    #[serde(rename = "G57")]
    g57: Option<Table>,
    #[serde(rename = "G58")]
    g58: Option<Table>,
    #[serde(rename = "G59")]
    g59: Option<Table>,
    #[serde(rename = "G59.1")]
    g59_1: Option<Table>,
    #[serde(rename = "G59.2")]
    g59_2: Option<Table>,
    #[serde(rename = "G59.3")]
    g59_3: Option<Table>,
    #[serde(rename = "G92")]
    g92: Option<Table>,
    #[serde(rename = "G28")]
    g28: Option<Table>,
    #[serde(rename = "G30")]
    g30: Option<Table>,
}

impl Offsets {
    /// Reads LinuxCNC's parameter file (one number and value per line, in mm), or TOML if the name of `file` ends in .toml:
    /// tables G54 to "G59.3", G92, G28, G30 with x_mm, y_mm, z_mm, a_deg, b_deg, c_deg, rotation_deg, and `active = "G54"`.
    ///
    /// # Errors
    /// Text in neither format, and a value outside ±1e6; with its line.
    pub fn parse(text: &str, file: &str) -> Result<Offsets, ProgramError> {
        let toml = file.rsplit_once('.').is_some_and(|(_, extension)| extension.eq_ignore_ascii_case("toml"));
        let offsets = if toml { Offsets::from_toml(text) } else { Offsets::from_parameters(text) };
        offsets.map_err(|refusal| refusal.in_file(file))
    }

    fn from_parameters(text: &str) -> Result<Offsets, Refusal> {
        let mut offsets = Offsets::default();
        for (line, text) in (1_u32..).zip(text.lines()) {
            let text = text.split([';', '#', '(']).next().unwrap_or_default();
            let mut words = text.split_whitespace();
            let (number, value) = match (words.next(), words.next(), words.next()) {
                (None, ..) => continue,
                (Some(number), Some(value), None) => (number.parse::<u32>().ok(), value.parse::<f64>().ok()),
                _ => (None, None),
            };
            let (Some(number), Some(value)) = (number, value) else {
                return Err(Refusal::new(line, format!("`{}`", text.trim()), "a parameter's number and its value"));
            };
            in_range(line, value)?;
            offsets.set_parameter(line, number, value)?;
        }
        Ok(offsets)
    }

    /// Assigns a parameter of [`Offsets::parameter`].
    pub(super) fn assign(&mut self, line: u32, number: u32, value: f64) -> Result<(), Refusal> {
        if number == 5220 {
            return Err(Refusal::new(line, "`#5220` assigned", "G54 to G59.3"));
        }
        in_range(line, value)?;
        self.set_parameter(line, number, value)
    }

    /// A parameter that LinuxCNC reserves, mm and degrees; `None` for others.
    pub(super) fn parameter(&self, number: u32) -> Option<f64> {
        let axis = |first: u32| (number - first) as usize;
        match number {
            5161..=5166 => self.home[0].get(axis(5161)).copied(),
            5181..=5186 => self.home[1].get(axis(5181)).copied(),
            5210 => Some(f64::from(u8::from(self.g92_active))),
            5211..=5216 => self.g92.get(axis(5211)).copied(),
            5220 => Some(self.active as f64 + 1.0),
            5221..=5399 => {
                let system = self.systems.get(axis(5221) / 20)?;
                match axis(5221) % 20 {
                    9 => Some(system.rotation_deg),
                    place => system.offset.get(place).copied(),
                }
            }
            _ => None,
        }
    }

    /// Sets a parameter that LinuxCNC reserves; others have no meaning here.
    fn set_parameter(&mut self, line: u32, number: u32, value: f64) -> Result<(), Refusal> {
        let axis = |first: u32| (number - first) as usize;
        match number {
            5161..=5166 => self.home[0][axis(5161)] = value,
            5181..=5186 => self.home[1][axis(5181)] = value,
            5210 => self.g92_active = value != 0.0,
            5211..=5216 => self.g92[axis(5211)] = value,
            5220 if value.fract() == 0.0 && (1.0..=9.0).contains(&value) => self.active = value as usize - 1,
            5220 => return Err(Refusal::new(line, format!("5220 {value}"), "a coordinate system from 1 to 9")),
            5221..=5399 => {
                let (system, place) = ((number - 5221) / 20, (number - 5221) % 20);
                if let Some(system) = self.systems.get_mut(system as usize) {
                    match place {
                        0..=5 => system.offset[place as usize] = value,
                        9 => system.rotation_deg = value,
                        _ => {}
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn from_toml(text: &str) -> Result<Offsets, Refusal> {
        let document: OffsetsFile = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| line_at(text, span.start));
            Refusal::new(
                line,
                error.message(),
                "tables G54 to \"G59.3\", G92, G28, G30 with x_mm … c_deg, rotation_deg",
            )
        })?;
        let mut offsets = Offsets::default();
        let OffsetsFile { g54, g55, g56, g57, g58, g59, g59_1, g59_2, g59_3, g92, g28, g30, .. } = &document;
        let systems = [g54, g55, g56, g57, g58, g59, g59_1, g59_2, g59_3];
        let place = |name: &str, table: &Table| {
            let line = text.lines().position(|text| text.contains(name)).map_or(1, |line| line as u32 + 1);
            let place = [table.x_mm, table.y_mm, table.z_mm, table.a_deg, table.b_deg, table.c_deg];
            place.into_iter().chain([table.rotation_deg]).try_for_each(|value| in_range(line, value))?;
            Ok(place)
        };
        for ((system, name), table) in offsets.systems.iter_mut().zip(SYSTEMS).zip(systems) {
            if let Some(table) = table {
                *system = System { offset: place(name, table)?, rotation_deg: table.rotation_deg };
            }
        }
        if let Some(table) = g92 {
            (offsets.g92, offsets.g92_active) = (place("G92", table)?, true);
        }
        for (home, (name, table)) in offsets.home.iter_mut().zip([("G28", g28), ("G30", g30)]) {
            if let Some(table) = table {
                *home = place(name, table)?;
            }
        }
        if let Some(active) = document.active {
            let line = text.lines().position(|text| text.contains("active")).map_or(1, |line| line as u32 + 1);
            let found = SYSTEMS.iter().position(|system| *system == active);
            offsets.active =
                found.ok_or_else(|| Refusal::new(line, format!("active = \"{active}\""), "G54 to G59.3"))?;
        }
        Ok(offsets)
    }

    /// Writes LinuxCNC's parameter file, for a machine whose unit of length is `mm_per_unit` mm.
    pub fn parameters(&self, mm_per_unit: f64) -> String {
        use std::fmt::Write as _;
        let mut text = String::new();
        let mut set = |first: usize, place: &[f64; 6]| {
            for (axis, value) in place.iter().enumerate() {
                let value = if axis < 3 { value / mm_per_unit } else { *value };
                let _ = writeln!(text, "{}\t{value:.15}", first + axis);
            }
        };
        set(5161, &self.home[0]);
        set(5181, &self.home[1]);
        set(5211, &self.g92);
        for (number, system) in self.systems.iter().enumerate() {
            set(5221 + 20 * number, &system.offset);
        }
        for (number, system) in self.systems.iter().enumerate() {
            let _ = writeln!(text, "{}\t{:.15}", 5230 + 20 * number, system.rotation_deg);
        }
        let _ = writeln!(text, "5210\t{}\n5220\t{}", u8::from(self.g92_active), self.active + 1);
        // LinuxCNC requires ascending order.
        let mut lines: Vec<&str> = text.lines().collect();
        lines.sort_unstable();
        lines.join("\n") + "\n"
    }
}

fn in_range(line: u32, value: f64) -> Result<(), Refusal> {
    if value.abs() <= LARGEST {
        return Ok(());
    }
    Err(Refusal::new(line, format!("{value}"), format!("mm or degrees within ±{LARGEST}")))
}
