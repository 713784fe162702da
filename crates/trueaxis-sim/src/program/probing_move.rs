//! Probing moves: to the trip on the surface of the options, else to their ends.

use super::Surface;
use super::block::Block;
use super::error::Refusal;
use super::interpreter::Interpreter;
use super::way::Way;
use glam::DVec3;

/// G38.4 and G38.5 move away from contact.
const AWAY: u16 = 384;

impl Interpreter<'_> {
    /// G38.2 to G38.5. As in LinuxCNC, G38.2 and G38.4 are errors where they do not trip, or would have tripped before they
    /// began; G38.3 and G38.5 trip at once in the second case. The axes stop where the probe trips.
    pub(super) fn probe(&mut self, block: &mut Block, code: u16) -> Result<(), Refusal> {
        let line = block.line;
        let name = format!("G{}", f64::from(code) / 10.0);
        self.refuse_tool_center(line, &name)?;
        if self.inverse_time {
            return Err(Refusal::new(line, format!("{name} in G93"), "G94"));
        }
        let pace = self.feed(line)?;
        let start = self.builder.at;
        let (mut end, _) = self.target(block);
        let trip = match &self.options.surface {
            Some(surface) => self.trip(surface, end, line, code)?,
            None => None,
        };
        if let Some(share) = trip.filter(|share| *share < 1.0) {
            end = std::array::from_fn(|axis| start[axis] + share * (end[axis] - start[axis]));
        }
        let moved = self.builder.line_to(line, pace, end, self.plane.normal())?;
        if !moved && trip.is_none() {
            return Err(Refusal::new(line, "a probing move without length", "an end away from where it starts"));
        }
        if self.options.surface.is_none() {
            self.note(line, &name, "moves to its end: nothing to touch without --surface");
        }
        self.builder.stop();
        if moved && code < AWAY {
            self.builder.probe();
        }
        self.probed(trip.is_some());
        Ok(())
    }

    /// Share of the move at which the probe trips.
    fn trip(&self, surface: &Surface, end: [f64; 6], line: u32, code: u16) -> Result<Option<f64>, Refusal> {
        let linear = |[x, y, z, ..]: [f64; 6]| DVec3::new(x, y, z);
        let start = linear(self.builder.at);
        let way = Way { start: start - linear(self.frame.tool), change: linear(end) - start };
        let (away, is_error) = (code >= AWAY, code.is_multiple_of(2));
        let refuse =
            |found: &str, needed: &str| Err(Refusal::new(line, format!("G{} {found}", f64::from(code) / 10.0), needed));
        if surface.in_contact(way.start) != away {
            return match (is_error, away) {
                (false, _) => Ok(Some(0.0)),
                (true, true) => refuse("that begins out of contact", "a start in contact, or G38.5"),
                (true, false) => refuse("that begins in contact", "a start clear of every surface, or G38.3"),
            };
        }
        match if away { surface.free(&way) } else { surface.contact(&way) } {
            None if is_error && away => refuse("that stays in contact", "an end clear of every surface, or G38.5"),
            None if is_error => refuse("that touches nothing", "a surface on its way, or G38.3"),
            trip => Ok(trip),
        }
    }
}
