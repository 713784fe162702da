//! LinuxCNC's tool table: offsets added by G43.

use std::collections::BTreeMap;

use super::ProgramError;
use super::block::AXIS_LETTERS;
use super::error::Refusal;
use super::words::LARGEST;

/// Most tools of LinuxCNC's table.
const MOST_TOOLS: usize = 1000;

/// Offsets of tools, mm and degrees, by number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolTable {
    offsets: BTreeMap<u32, [f64; 6]>,
}

impl ToolTable {
    /// Reads a table in LinuxCNC's format: `T1 P1 X0 Y0 Z50.5 D6 ;comment`, one tool per line, in mm. D, I, J, Q, U, V, W have
    /// no effect here. `file` appears in errors only.
    ///
    /// # Errors
    /// An invalid word, a line without T, a duplicate tool, a value outside ±1e6; with its line.
    pub fn parse(text: &str, file: &str) -> Result<ToolTable, ProgramError> {
        ToolTable::read(text).map_err(|refusal| refusal.in_file(file))
    }

    /// A table of tools without length: of all that a program names by T or H, up to as many as LinuxCNC takes.
    pub fn without_lengths(program: &str) -> ToolTable {
        let mut table = ToolTable::default();
        for word in program.lines().flat_map(|line| line.split(['T', 'H']).skip(1)) {
            let digits = word.bytes().take_while(u8::is_ascii_digit).count();
            let number = word.get(..digits).and_then(|number| number.parse::<u32>().ok());
            if let Some(number) = number.filter(|number| *number > 0)
                && table.offsets.len() < MOST_TOOLS
            {
                table.offsets.insert(number, [0.0; 6]);
            }
        }
        table
    }

    fn read(text: &str) -> Result<ToolTable, Refusal> {
        let mut table = ToolTable::default();
        for (line, text) in (1_u32..).zip(text.lines()) {
            let text = text.split(';').next().unwrap_or_default();
            let mut number = None;
            let mut offset = [0.0; 6];
            let mut any = false;
            for word in text.split_whitespace() {
                any = true;
                let letter = word.chars().next().unwrap_or(' ').to_ascii_uppercase();
                let value = word.get(letter.len_utf8()..).and_then(|number| number.parse::<f64>().ok());
                let refuse = |needed: &str| Err(Refusal::new(line, format!("`{word}`"), needed));
                let Some(value) = value.filter(|value| value.abs() <= LARGEST || letter == 'T') else {
                    return refuse("T, P, X to C, D, I, J or Q with a number within ±1e6; comments after ;");
                };
                match letter {
                    'T' if value.fract() == 0.0 && (0.0..=99_999_999.0).contains(&value) => number = Some(value as u32),
                    'T' => return refuse("a whole number of a tool"),
                    'P' | 'D' | 'I' | 'J' | 'Q' | 'U' | 'V' | 'W' => {}
                    _ => match AXIS_LETTERS.iter().position(|axis| *axis == letter) {
                        Some(axis) => offset[axis] = value,
                        None => return refuse("T, P, X to C, D, I, J or Q with a number; comments after ;"),
                    },
                }
            }
            let Some(number) = number else {
                if any {
                    return Err(Refusal::new(line, format!("`{}`", text.trim()), "the tool's number, T"));
                }
                continue;
            };
            if table.offsets.insert(number, offset).is_some() {
                return Err(Refusal::new(line, format!("T{number} for the second time"), "each tool once"));
            }
        }
        Ok(table)
    }

    /// Offset of a tool, X Y Z A B C.
    pub fn offset(&self, tool: u32) -> Option<[f64; 6]> {
        self.offsets.get(&tool).copied()
    }

    /// Writes LinuxCNC's table, for a machine whose unit of length is `mm_per_unit` mm.
    pub fn text(&self, mm_per_unit: f64) -> String {
        let mut text = String::new();
        for (pocket, (tool, offset)) in (1..).zip(&self.offsets) {
            let words = AXIS_LETTERS.iter().zip(offset).enumerate().map(|(axis, (letter, value))| {
                format!(" {letter}{:+.15}", if axis < 3 { value / mm_per_unit } else { *value })
            });
            text += &format!("T{tool} P{pocket}{} D1\n", words.collect::<String>());
        }
        text
    }
}
