//! The words of one line: values sorted by letter, G and M words by modal group.

use super::error::{Refusal, THROUGH_LINUXCNC};
use super::modal::{self, G_WORDS, M_WORDS, g, m};
use super::words::{Word, Words};

/// Letters of the axes, in the order used everywhere.
pub(super) const AXIS_LETTERS: [char; 6] = ['X', 'Y', 'Z', 'A', 'B', 'C'];

/// G80, in tenths.
pub(super) const CANCEL: u16 = 800;

/// The sorted words of one line. A value still unused at the end is an error.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub(super) line: u32,
    values: [Option<f64>; 26],
    /// G words in tenths, by group.
    pub(super) g: [Option<u16>; g::COUNT],
    pub(super) m: [Option<u16>; m::COUNT],
    /// Whether the line is an O word with a number and nothing else.
    pub(super) program_number: bool,
}

fn index(letter: char) -> usize {
    (letter as usize).wrapping_sub('A' as usize).min(25)
}

impl Block {
    /// Sorts a line cleaned by [`clean`](super::text::clean).
    ///
    /// # Errors
    /// A letter or a modal group twice, an unsupported word, text that is not a word.
    pub(super) fn read(line: u32, text: &str) -> Result<Block, Refusal> {
        let mut block = Block { line, ..Block::default() };
        if is_o_word(text) {
            let number = text.trim_start_matches(|c: char| c == 'N' || c.is_ascii_digit()).get(1..).unwrap_or_default();
            if number.is_empty() || !number.bytes().all(|b| b.is_ascii_digit()) {
                let needed =
                    format!("a program number O1234 on a separate line; subprograms and loops {THROUGH_LINUXCNC}");
                return Err(Refusal::new(line, format!("`{text}`"), needed));
            }
            block.program_number = true;
            return Ok(block);
        }
        for (position, word) in Words::new(line, text).enumerate() {
            let word = word?;
            match word.letter {
                'N' if position == 0 => {}
                'N' => {
                    return Err(Refusal::new(line, format!("`{}`", word.text), "N once, at the beginning of a line"));
                }
                'G' => block.add_g(&word)?,
                'M' => block.add_m(&word)?,
                'D' | 'E' | 'O' | 'U' | 'V' | 'W' if block.g[g::SPINDLE] != Some(960) || word.letter != 'D' => {
                    let needed = "a word of the supported dialect (G M X Y Z A B C I J K R P Q L F H N S T)";
                    return Err(Refusal::new(line, format!("`{}`", word.text), needed));
                }
                letter => {
                    if block.values[index(letter)].replace(word.value).is_some() {
                        let found = format!("`{}`, {letter} for the second time", word.text);
                        return Err(Refusal::new(line, found, "each letter once in a line"));
                    }
                }
            }
        }
        Ok(block)
    }

    fn add_g(&mut self, word: &Word<'_>) -> Result<(), Refusal> {
        let tenths = word.tenths().unwrap_or(u16::MAX);
        let Some(group) = modal::g_group(tenths) else {
            let needed = if matches!(tenths, 410 | 411 | 420 | 421) {
                format!("G40; cutter compensation {THROUGH_LINUXCNC}")
            } else if modal::linuxcnc_has_g(tenths) {
                format!("{G_WORDS}; others {THROUGH_LINUXCNC}")
            } else {
                G_WORDS.to_owned()
            };
            return Err(Refusal::new(self.line, format!("`{}`", word.text), needed));
        };
        match self.g[group] {
            // LinuxCNC ignores G80 next to another motion word.
            Some(_) if group == g::MOTION && tenths == CANCEL => return Ok(()),
            Some(before) if group != g::MOTION || before != CANCEL => {
                return self.same_group(word, 'G', f64::from(before) / 10.0);
            }
            _ => self.g[group] = Some(tenths),
        }
        Ok(())
    }

    fn add_m(&mut self, word: &Word<'_>) -> Result<(), Refusal> {
        let number = word.tenths().filter(|tenths| tenths % 10 == 0).map_or(u16::MAX, |tenths| tenths / 10);
        let Some(group) = modal::m_group(number) else {
            let needed = if modal::linuxcnc_has_m(number) {
                format!("{M_WORDS}; subprograms and others {THROUGH_LINUXCNC}")
            } else {
                M_WORDS.to_owned()
            };
            return Err(Refusal::new(self.line, format!("`{}`", word.text), needed));
        };
        match self.m[group].replace(number) {
            // LinuxCNC refuses M7 beside M8; posts write both, and neither moves anything.
            Some(7 | 8) if matches!(number, 7 | 8) => Ok(()),
            Some(before) => self.same_group(word, 'M', f64::from(before)),
            None => Ok(()),
        }
    }

    fn same_group(&self, word: &Word<'_>, letter: char, before: f64) -> Result<(), Refusal> {
        let found = format!("`{}` and `{letter}{before}`", word.text);
        Err(Refusal::new(self.line, found, "one word of a modal group in a line"))
    }

    /// The value of a letter, which is then marked as used.
    pub(super) fn take(&mut self, letter: char) -> Option<f64> {
        self.values[index(letter)].take()
    }

    /// Whether one of the letters has an unused value.
    pub(super) fn has(&self, letters: &str) -> bool {
        letters.chars().any(|letter| self.values[index(letter)].is_some())
    }

    /// Whether the line names a target.
    pub(super) fn has_axes(&self) -> bool {
        self.has("XYZABC")
    }

    /// Refuses the first value that nothing has used.
    pub(super) fn refuse_unused(&self) -> Result<(), Refusal> {
        for (letter, value) in ('A'..='Z').zip(self.values) {
            let Some(value) = value else { continue };
            let needed = match letter {
                'P' => "P only with G2, G3, G4, G5.2, G10, G64, G82, G84, G86 or G89",
                'I' | 'J' | 'K' => "I, J, K only with G2 or G3",
                'R' => "R only with G2, G3, G10 L2 or a canned cycle",
                'L' => "L only with G5.2, G10 or a canned cycle",
                'Q' => "Q only with G64, G73 or G83",
                'X' | 'Y' | 'Z' => "a motion word (G0, G1, G2, G3, G5.2, G38.2, G73, G81 to G89) before axis words",
                'A' | 'B' | 'C' => "a motion word (G0, G1, G2, G3) before rotary words",
                'H' => "H only with G43, G43.2 or G43.4",
                _ => "a word that uses it",
            };
            return Err(Refusal::new(self.line, format!("`{letter}{value}`"), needed));
        }
        Ok(())
    }
}

/// Whether a line is O1234 or begins a control structure of LinuxCNC: an O word, preceded at most by N.
fn is_o_word(text: &str) -> bool {
    let rest = text.strip_prefix('N').map_or(text, |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    rest.starts_with('O')
}
