//! Text in buffers of the caller: UTF-8, cut off between two characters, terminated by a zero byte.

use core::ffi::c_char;
use core::fmt::{self, Display, Write};

/// Whether the build includes the text of refusals.
pub(crate) const TEXT: bool = cfg!(feature = "text");

/// A fixed-size text under construction; characters that do not fit are dropped.
pub(crate) struct Text<const N: usize> {
    characters: [c_char; N],
    length: usize,
    full: bool,
}

impl<const N: usize> Text<N> {
    /// The text of a printable value; empty in a build without texts.
    #[inline]
    pub(crate) fn of(what: &dyn Display) -> [c_char; N] {
        if TEXT { Self::written(what) } else { [0; N] }
    }

    /// A text of the machine's own, in any build.
    pub(crate) fn copied(text: &str) -> [c_char; N] {
        let mut copy = Text { characters: [0; N], length: 0, full: false };
        // Writing never fails here; characters that do not fit are dropped.
        let _ = copy.write_str(text);
        copy.characters
    }

    /// `#` and a number, in any build.
    pub(crate) fn numbered(number: u8) -> [c_char; N] {
        let digits = [number / 100, number / 10 % 10, number % 10];
        let mut text = [0; N];
        let shown = digits.iter().skip(if number < 10 { 2 } else { usize::from(number < 100) });
        for (place, character) in text.iter_mut().zip([b'#'].into_iter().chain(shown.map(|digit| b'0' + digit))) {
            *place = character as c_char;
        }
        text
    }

    fn written(what: &dyn Display) -> [c_char; N] {
        let mut text = Text { characters: [0; N], length: 0, full: false };
        // Writing never fails here; characters that do not fit are dropped.
        let _ = write!(text, "{what}");
        text.characters
    }
}

impl<const N: usize> Write for Text<N> {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        let mut encoded = [0; 4];
        for character in part.chars() {
            let bytes = character.encode_utf8(&mut encoded).as_bytes();
            // One byte is reserved for the zero byte.
            let room = self.characters.get_mut(self.length..N.saturating_sub(1));
            match room.and_then(|room| room.get_mut(..bytes.len())) {
                Some(places) if !self.full => {
                    for (place, byte) in places.iter_mut().zip(bytes) {
                        *place = *byte as c_char;
                    }
                    self.length += bytes.len();
                }
                _ => self.full = true,
            }
        }
        Ok(())
    }
}
