//! Parameters that tell the interpreter's state, and assignments.

use super::arc::Plane;
use super::block::AXIS_LETTERS;
use super::error::Refusal;
use super::expression::{Parameter, Values};
use super::interpreter::{Interpreter, MM_PER_INCH};
use super::parameters::MOST_NAMES;

impl Interpreter<'_> {
    /// A place in the program's unit.
    fn in_units(&self, place: [f64; 6], axis: usize) -> f64 {
        let value = place.get(axis).copied().unwrap_or(0.0);
        if self.inch && axis < 3 { value / MM_PER_INCH } else { value }
    }

    fn here(&self, axis: usize) -> f64 {
        self.in_units(self.frame.to_program(self.builder.at), axis)
    }

    /// The value of a parameter that cannot be assigned; U, V, W are zero.
    fn state(&self, number: u32) -> Option<f64> {
        let axis = |first: u32| (number - first) as usize;
        Some(match number {
            5021..=5029 => self.in_units(self.builder.at, axis(5021)),
            5081..=5089 => self.in_units(self.frame.tool, axis(5081)),
            5400 => f64::from(self.loaded_tool),
            5401..=5409 => {
                let tools = self.options.tools.as_ref();
                self.in_units(tools.and_then(|t| t.offset(self.loaded_tool)).unwrap_or_default(), axis(5401))
            }
            5410..=5413 => 0.0,
            5420..=5428 => self.here(axis(5420)),
            _ => return None,
        })
    }

    /// The value of a predefined name; `None` if there is none of that name.
    fn predefined(&self, name: &str) -> Option<f64> {
        let name = name.strip_prefix('_')?;
        let letter = |name: &str| match name.as_bytes() {
            [letter @ (b'X'..=b'Z' | b'A'..=b'C' | b'U'..=b'W')] => {
                Some(AXIS_LETTERS.iter().position(|axis| *axis == char::from(*letter)).unwrap_or(6))
            }
            _ => None,
        };
        if let Some(axis) = letter(name) {
            return Some(self.here(axis));
        }
        if let Some(axis) = name.strip_prefix("ABS_").and_then(letter) {
            return Some(self.in_units(self.builder.at, axis));
        }
        let truth = |yes: bool| f64::from(u8::from(yes));
        Some(match name {
            "LINE" => f64::from(self.line),
            "MOTION_MODE" => f64::from(self.motion.unwrap_or(super::block::CANCEL)),
            "PLANE" => match self.plane {
                Plane::Xy => 170.0,
                Plane::Zx => 180.0,
                Plane::Yz => 190.0,
            },
            "CCOMP" => 400.0,
            "METRIC" => truth(!self.inch),
            "IMPERIAL" => truth(self.inch),
            "ABSOLUTE" => truth(!self.incremental),
            "INCREMENTAL" => truth(self.incremental),
            "INVERSE_TIME" => truth(self.inverse_time),
            "UNITS_PER_MINUTE" => truth(!self.inverse_time),
            "COORD_SYSTEM" => match self.offsets.active as u32 {
                system @ 0..=5 => f64::from(540 + 10 * system),
                system => f64::from(585 + system),
            },
            "TOOL_OFFSET" => truth(self.frame.tool != [0.0; 6]),
            "RETRACT_R_PLANE" => truth(!self.retract_to_start),
            "RETRACT_OLD_Z" => truth(self.retract_to_start),
            "SPINDLE_RPM_MODE" => truth(!self.spindle.surface_speed),
            "SPINDLE_CSS_MODE" => truth(self.spindle.surface_speed),
            "IJK_ABSOLUTE_MODE" => truth(self.absolute_center),
            "LATHE_DIAMETER_MODE" => truth(self.diameter),
            "LATHE_RADIUS_MODE" => truth(!self.diameter),
            "SPINDLE_ON" => truth(matches!(self.spindle.word, 3 | 4)),
            "SPINDLE_CW" => truth(self.spindle.word == 3),
            "MIST" => truth(self.spindle.mist),
            "FLOOD" => truth(self.spindle.flood),
            "SPEED_OVERRIDE" | "FEED_OVERRIDE" | "FEED_HOLD" => 1.0,
            "UNITS_PER_REV" | "ADAPTIVE_FEED" | "REMAP_LEVEL" | "TASK" => 0.0,
            "FEED" => self.feed.map_or(0.0, |feed| feed.number),
            "RPM" => self.spindle.speed.abs(),
            "CURRENT_TOOL" => f64::from(self.loaded_tool),
            "SELECTED_TOOL" => f64::from(self.selected_tool.unwrap_or(0)),
            "VALUE" => self.returned.unwrap_or(0.0),
            "VALUE_RETURNED" => truth(self.returned.is_some()),
            "CALL_LEVEL" => f64::from(self.level),
            "VMAJOR" => 2.9,
            "VMINOR" => 0.0,
            _ => return None,
        })
    }

    /// Where a probing move ended, #5061 to #5069, and whether the probe tripped, #5070.
    pub(super) fn probed(&mut self, tripped: bool) {
        for (axis, number) in (5061..=5069).enumerate() {
            let value = self.here(axis);
            self.parameters.set(Parameter::Number(number), value);
        }
        self.parameters.set(Parameter::Number(5070), f64::from(u8::from(tripped)));
    }

    /// Assigns a parameter. One of offsets takes effect where its coordinate system is chosen next, as in LinuxCNC.
    pub(super) fn assign(&mut self, line: u32, parameter: Parameter<'_>, value: f64) -> Result<(), Refusal> {
        let fixed =
            |name: String| Err(Refusal::new(line, format!("`{name}` assigned"), "a parameter that may be assigned"));
        match parameter {
            Parameter::Number(number) if self.state(number).is_some() => return fixed(format!("#{number}")),
            Parameter::Name(name) if self.predefined(name).is_some() => return fixed(format!("#<{name}>")),
            Parameter::Number(number) if self.offsets.parameter(number).is_some() => {
                return self.offsets.assign(line, number, value);
            }
            _ => {}
        }
        if self.parameters.set(parameter, value) {
            return Ok(());
        }
        Err(Refusal::new(line, "one more name of a parameter", format!("at most {MOST_NAMES}")))
    }
}

impl Values for Interpreter<'_> {
    fn numbered(&self, number: u32) -> Option<f64> {
        let state = self.state(number).or_else(|| self.offsets.parameter(number));
        state.or_else(|| Some(self.parameters.numbered(number)))
    }

    fn named(&self, name: &str) -> Option<f64> {
        self.predefined(name).or_else(|| self.parameters.named(name))
    }
}
