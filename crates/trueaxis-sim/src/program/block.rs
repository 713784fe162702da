//! The words of one line: values sorted by letter, G and M words by modal group.

use super::error::{Refusal, THROUGH_LINUXCNC};
use super::expression::{Parameter, Values};
use super::modal::{self, G_WORDS, M_WORDS, g, m};
use super::words::{Item, Word, Words};

/// Letters of the axes, in the order used everywhere.
pub(super) const AXIS_LETTERS: [char; 6] = ['X', 'Y', 'Z', 'A', 'B', 'C'];

/// G80, in tenths.
pub(super) const CANCEL: u16 = 800;

/// The sorted words of one line. A value still unused at the end is an error.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub(super) line: u32,
    /// A to Z, then @ and ^.
    values: [Option<f64>; 28],
    /// G words in tenths, by group.
    pub(super) g: [Option<u16>; g::COUNT],
    pub(super) m: [Option<u16>; m::COUNT],
}

fn index(letter: char) -> usize {
    match letter {
        '@' => 26,
        '^' => 27,
        _ => (letter as usize).wrapping_sub('A' as usize).min(25),
    }
}

impl Block {
    /// Sorts a line cleaned by [`clean`](super::text::clean); its assignments go to `settings`, because they take effect after
    /// the whole line has been read.
    ///
    /// # Errors
    /// A letter or a modal group twice, an unsupported word, text that is not a word.
    pub(super) fn read<'t>(
        line: u32,
        text: &'t str,
        values: &impl Values,
        settings: &mut Vec<(Parameter<'t>, f64)>,
    ) -> Result<Block, Refusal> {
        let mut block = Block { line, ..Block::default() };
        for (position, item) in Words::new(line, text, values).enumerate() {
            let word = match item? {
                Item::Word(word) => word,
                Item::Set(parameter, value) => {
                    settings.push((parameter, value));
                    continue;
                }
            };
            match word.letter {
                'N' if position == 0 => {}
                'N' => {
                    return Err(Refusal::new(line, format!("`{}`", word.text), "N once, at the beginning of a line"));
                }
                'G' => block.add_g(&word)?,
                'M' => block.add_m(&word)?,
                'D' | 'O' | 'U' | 'V' | 'W' if block.g[g::SPINDLE] != Some(960) || word.letter != 'D' => {
                    let needed = "a word of the supported dialect (G M X Y Z A B C I J K R P Q L F H N S T E @ ^)";
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
                format!("{M_WORDS}; others {THROUGH_LINUXCNC}")
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

    /// Multiplies the value of a letter.
    pub(super) fn scale(&mut self, letter: char, by: f64) {
        if let Some(value) = &mut self.values[index(letter)] {
            *value *= by;
        }
    }

    /// Whether one of the letters has an unused value.
    pub(super) fn has(&self, letters: &str) -> bool {
        letters.chars().any(|letter| self.values[index(letter)].is_some())
    }

    /// Whether the line names a target.
    pub(super) fn has_axes(&self) -> bool {
        self.has("XYZABC@^")
    }

    /// Refuses the first value that nothing has used.
    pub(super) fn refuse_unused(&self) -> Result<(), Refusal> {
        for (letter, value) in ('A'..='Z').chain(['@', '^']).zip(self.values) {
            let Some(value) = value else { continue };
            let needed = match letter {
                'P' => "P only with G2, G3, G4, G5, G5.2, G10, G64, G82, G84, G86, G89 or M98",
                'I' | 'J' | 'K' => "I, J, K only with G2, G3, G5 or G5.1",
                'R' => "R only with G2, G3, G10 L2 or a canned cycle",
                'L' => "L only with G5.2, G10, M98 or a canned cycle",
                'Q' => "Q only with G5, G64, G73 or G83",
                'E' => "E only with M67 or M68",
                '@' | '^' => "G0, G1, G2 or G3 with @ and ^",
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
