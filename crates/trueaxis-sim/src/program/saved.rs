//! M70 to M73: modes saved and restored.

use super::error::Refusal;
use super::interpreter::Interpreter;
use super::modes::{Modes, Saved};

impl Interpreter<'_> {
    fn modes(&self) -> Modes {
        Modes {
            plane: self.plane,
            inch: self.inch,
            incremental: self.incremental,
            absolute_center: self.absolute_center,
            inverse_time: self.inverse_time,
            diameter: self.diameter,
            feed: self.feed,
            retract_to_start: self.retract_to_start,
            exact_stop: self.exact_stop,
            system: self.offsets.active,
            tool: self.frame.tool != [0.0; 6],
        }
    }

    /// M70 to M73.
    pub(super) fn save_or_restore(&mut self, line: u32, number: u16) -> Result<(), Refusal> {
        match number {
            70 | 73 => self.saved = Saved { modes: Some(self.modes()), on_return: number == 73 },
            71 => self.saved = Saved::default(),
            _ => match self.saved.modes.clone() {
                Some(modes) => self.restore(line, modes)?,
                None => {
                    return Err(Refusal::new(line, "M72 without saved modes", "M70 before it, in the same subprogram"));
                }
            },
        }
        Ok(())
    }

    /// The end of a subprogram that began with M73.
    pub(super) fn restore_on_return(&mut self, line: u32) -> Result<(), Refusal> {
        match self.saved.modes.clone().filter(|_| self.saved.on_return) {
            Some(modes) => self.restore(line, modes),
            None => Ok(()),
        }
    }

    fn restore(&mut self, line: u32, modes: Modes) -> Result<(), Refusal> {
        self.plane = modes.plane;
        self.inch = modes.inch;
        self.incremental = modes.incremental;
        self.absolute_center = modes.absolute_center;
        self.inverse_time = modes.inverse_time;
        self.diameter = modes.diameter;
        self.feed = modes.feed;
        self.retract_to_start = modes.retract_to_start;
        self.exact_stop = modes.exact_stop;
        if modes.system != self.offsets.active {
            self.choose_system(modes.system);
        }
        // As in LinuxCNC, a length is restored as G43 of the loaded tool.
        if modes.tool != (self.frame.tool != [0.0; 6]) {
            self.frame.tool = if modes.tool { self.tool_offset(line, self.loaded_tool)? } else { [0.0; 6] };
        }
        Ok(())
    }
}
