//! Words that set the origin of coordinates, and words that go to fixed positions: G10, G28, G30, G43, G49, G52, G54 to G59.3,
//! G92.

use super::block::{AXIS_LETTERS, Block};
use super::builder::Pace;
use super::error::{Refusal, THROUGH_LINUXCNC};
use super::interpreter::Interpreter;
use super::modal::g;
use super::offsets::System;

impl Interpreter<'_> {
    pub(super) fn tool_offset(&self, line: u32, tool: u32) -> Result<[f64; 6], Refusal> {
        match &self.options.tools {
            Some(tools) if tool > 0 => {
                tools.offset(tool).ok_or_else(|| Refusal::new(line, format!("tool {tool}"), "a tool of the tool table"))
            }
            _ => Ok([0.0; 6]),
        }
    }

    /// G43, G43.1, G43.2, G43.4 and G49.
    pub(super) fn set_tool_length(&mut self, block: &mut Block) -> Result<(), Refusal> {
        let (line, Some(code)) = (block.line, block.g[g::TOOL_LENGTH]) else { return Ok(()) };
        self.set_tool_center(line, code == 434)?;
        let number = match code {
            431 | 490 => None,
            _ => block.take('H'),
        };
        if let Some(number) = number.filter(|h| h.fract() != 0.0 || !(0.0..=99_999_999.0).contains(h)) {
            return Err(Refusal::new(line, format!("`H{number}`"), "a whole number of a tool"));
        }
        let tool = number.map_or(self.loaded_tool, |number| number as u32);
        match code {
            434 => {
                self.frame.tool = [0.0; 6];
                if number.is_some() {
                    self.note(line, "G43.4 H", "the tool's length is that of the machine file");
                }
            }
            430 | 432 if self.options.tools.is_none() => {
                self.note(line, "G43", "no length without --tool-table");
                if code == 430 {
                    self.frame.tool = [0.0; 6];
                }
            }
            430 => self.frame.tool = self.tool_offset(line, tool)?,
            432 => {
                let more = self.tool_offset(line, tool)?;
                self.frame.tool = std::array::from_fn(|k| self.frame.tool[k] + more[k]);
            }
            431 => {
                if !block.has_axes() {
                    return Err(Refusal::new(line, "G43.1 without axis words", "the tool's offset, as Z"));
                }
                for (axis, value) in self.axis_words(block) {
                    self.frame.tool[axis] = value;
                }
            }
            _ => self.frame.tool = [0.0; 6],
        }
        Ok(())
    }

    fn set_tool_center(&mut self, line: u32, on: bool) -> Result<(), Refusal> {
        if on == self.builder.tool_center {
            return Ok(());
        }
        // Only there do X, Y and Z mean the same position in both modes, on every machine.
        let axes = AXIS_LETTERS.iter().zip(self.builder.at).skip(3);
        if let Some((letter, angle)) = axes.clone().find(|(_, angle)| angle % 360.0 != 0.0) {
            let word = if on { "G43.4" } else { "G49" };
            let needed = "A, B and C at 0 (or whole turns) before G43.4 and before G49 after it";
            return Err(Refusal::new(line, format!("{word} at {letter}{angle}"), needed));
        }
        self.builder.tool_center = on;
        if on {
            self.builder.first.tool_center.get_or_insert(line);
        }
        Ok(())
    }

    pub(super) fn choose_system(&mut self, index: usize) {
        let system = self.offsets.systems[index];
        self.offsets.active = index;
        (self.frame.g5x, self.frame.rotation_deg) = (system.offset, system.rotation_deg);
    }

    /// Takes the axis words of the line: index of the axis, and the value in mm or degrees.
    fn axis_words(&self, block: &mut Block) -> Vec<(usize, f64)> {
        let words = AXIS_LETTERS.iter().enumerate();
        words.filter_map(|(k, l)| block.take(*l).map(|v| (k, if k < 3 { self.mm(v) } else { v }))).collect()
    }

    /// Words of the non-modal group, except G4 and G53.
    pub(super) fn once(&mut self, block: &mut Block) -> Result<(), Refusal> {
        let (line, Some(code)) = (block.line, block.g[g::ONCE]) else { return Ok(()) };
        if matches!(code, 40 | 530 | 921..=923) {
            if code >= 921 {
                self.frame.g92 = if code == 923 { self.offsets.g92 } else { [0.0; 6] };
                if code == 921 {
                    self.offsets.g92 = [0.0; 6];
                }
            }
            return Ok(());
        }
        // Posts write G0 beside G28, which moves at rapid.
        let harmless = |motion: u16| motion == super::block::CANCEL || motion == 0 && matches!(code, 280 | 300);
        if let Some(motion) = block.g[g::MOTION].filter(|motion| !harmless(*motion)) {
            let found = format!("G{} and G{}", f64::from(code) / 10.0, f64::from(motion) / 10.0);
            return Err(Refusal::new(line, found, "one word in a line that uses axis words"));
        }
        match code {
            100 => self.set_data(block),
            280 => self.go_home(block, 0),
            300 => self.go_home(block, 1),
            281 | 301 => {
                self.offsets.home[usize::from(code == 301)] = self.builder.at;
                Ok(())
            }
            _ => self.shift(block, code == 920),
        }
    }

    /// G52 sets the shift; G92 makes the words the coordinates of the current position.
    fn shift(&mut self, block: &mut Block, here: bool) -> Result<(), Refusal> {
        if !block.has_axes() {
            return Err(Refusal::new(block.line, if here { "G92 alone" } else { "G52 alone" }, "axis words"));
        }
        let now = self.frame.to_program(self.builder.at);
        for (axis, value) in self.axis_words(block) {
            let before = self.frame.g92[axis];
            self.frame.g92[axis] = if here { now[axis] + before - value } else { value };
        }
        self.offsets.g92 = self.frame.g92;
        Ok(())
    }

    /// G10 L2 and L20.
    fn set_data(&mut self, block: &mut Block) -> Result<(), Refusal> {
        let line = block.line;
        let (kind, number) = (block.take('L'), block.take('P'));
        let relative = match kind {
            Some(2.0) => false,
            Some(20.0) => true,
            _ => {
                let needed = format!("L2 or L20; the others {THROUGH_LINUXCNC}");
                return Err(Refusal::new(line, format!("G10 L{}", kind.unwrap_or(0.0)), needed));
            }
        };
        let index = match number {
            Some(0.0) => self.offsets.active,
            Some(p) if p.fract() == 0.0 && (1.0..=9.0).contains(&p) => p as usize - 1,
            other => {
                let found = other.map_or("G10 without P".to_owned(), |p| format!("G10 P{p}"));
                return Err(Refusal::new(line, found, "P0 to P9: the system in force, G54 to G59.3"));
            }
        };
        let System { mut offset, mut rotation_deg } = self.offsets.systems[index];
        if let Some(angle) = block.take('R') {
            if relative || angle.abs() > 360.0 {
                return Err(Refusal::new(line, format!("`R{angle}`"), "R with L2, within ±360°"));
            }
            rotation_deg = angle;
        }
        let words = self.axis_words(block);
        if relative {
            let mut frame = super::frame::Frame { g5x: offset, rotation_deg, ..self.frame.clone() };
            let mut wanted = frame.to_program(self.builder.at);
            for (axis, value) in words {
                wanted[axis] = value;
            }
            frame.g5x = [0.0; 6];
            let there = frame.to_machine(wanted);
            offset = std::array::from_fn(|k| self.builder.at[k] - there[k]);
        } else {
            for (axis, value) in words {
                offset[axis] = value;
            }
        }
        self.offsets.systems[index] = System { offset, rotation_deg };
        if index == self.offsets.active {
            self.choose_system(index);
        }
        Ok(())
    }

    /// G28 and G30: via the programmed position to the stored one, in the named axes, or in all if none is named.
    fn go_home(&mut self, block: &mut Block, which: usize) -> Result<(), Refusal> {
        let line = block.line;
        let name = ["G28", "G30"][which];
        self.refuse_tool_center(line, name)?;
        if self.options.offsets.is_none() {
            self.note(line, name, "goes to the machine's zero without --offsets");
        }
        let (between, given) = self.target(block);
        self.builder.line_to(line, Pace::Rapid, between, self.plane.normal())?;
        self.moved();
        let all = !given.contains(&true);
        let home = self.offsets.home[which];
        let end: [f64; 6] = std::array::from_fn(|k| if all || given[k] { home[k] } else { between[k] });
        for axis in 3..6 {
            if end[axis] != self.builder.at[axis] {
                self.builder.first.rotary[axis - 3].get_or_insert(line);
            }
        }
        self.builder.line_to(line, Pace::Rapid, end, self.plane.normal())?;
        self.moved();
        Ok(())
    }

    /// With the tool centre point on, axis positions cannot be determined from X Y Z alone.
    pub(super) fn refuse_tool_center(&self, line: u32, word: &str) -> Result<(), Refusal> {
        if self.builder.tool_center {
            return Err(Refusal::new(line, format!("{word} with G43.4"), "G49 before it"));
        }
        Ok(())
    }
}
