//! Canned cycles, as LinuxCNC expands them: G73, G81 to G86, G89.

use super::block::Block;
use super::builder::Pace;
use super::error::Refusal;
use super::interpreter::{CannedCycle, Interpreter};
use super::limits::MOST_PIECES;

/// Distance at which G83, when it returns, stops before the depth reached, and by which G73 retracts, mm.
const CLEARANCE: f64 = 0.254;

/// Heights of one hole along the normal of the plane, program coordinates, mm.
struct Hole {
    r: f64,
    bottom: f64,
    /// Height at which the cycle ends.
    clear: f64,
}

impl Interpreter<'_> {
    pub(super) fn drill(&mut self, block: &mut Block, code: u16) -> Result<(), Refusal> {
        let line = block.line;
        let refuse = |found: String, needed: &str| Err(Refusal::new(line, found, needed));
        let feed = self.feed(line)?;
        if self.inverse_time {
            return refuse(format!("G{} in G93", code / 10), "G94");
        }
        if block.has("ABC") {
            return refuse(format!("a rotary word with G{}", code / 10), "rotary axes at rest in a canned cycle");
        }
        let [first, second, normal] = self.plane.axes();
        let letters = ['X', 'Y', 'Z'];
        let sticky = self.cycle.filter(|cycle| cycle.code == code);
        let Some(bottom) = block.take(letters[normal]).or(sticky.map(|cycle| cycle.bottom)) else {
            return refuse(format!("G{} without {}", code / 10, letters[normal]), "the depth in its first line");
        };
        let Some(r) = block.take('R').or(sticky.map(|cycle| cycle.r)) else {
            return refuse(format!("G{} without R", code / 10), "the height R in its first line");
        };
        let dwell = block.take('P').or(sticky.and_then(|cycle| cycle.dwell));
        if matches!(code, 820 | 860 | 890) && dwell.is_none() {
            return refuse(format!("G{} without P", code / 10), "the dwell P in its first line");
        }
        let pecks = matches!(code, 730 | 830);
        let peck = if pecks { block.take('Q').or(sticky.and_then(|cycle| cycle.peck)) } else { None };
        if pecks && peck.is_none_or(|q| q <= 0.0) {
            return refuse(format!("G{} with Q{}", code / 10, peck.unwrap_or(0.0)), "a positive depth Q of a peck");
        }
        let times = match block.take('L') {
            None => 1,
            Some(l) if l.fract() == 0.0 && (1.0..=MOST_PIECES as f64).contains(&l) => l as u64,
            Some(l) => return refuse(format!("`L{l}`"), "a whole number of repeats, at least 1"),
        };
        self.cycle = Some(CannedCycle { code, bottom, r, dwell, peck });

        let [x, y, z, ..] = self.frame.to_program(self.builder.at);
        let mut at = [x, y, z];
        let mut step = [0.0; 3];
        for axis in [first, second] {
            if let Some(value) = block.take(letters[axis]) {
                let value = self.mm(value);
                if self.incremental { step[axis] = value } else { at[axis] = value }
            }
        }
        let mut height = [x, y, z][normal];
        let mut began = *self.cycle_start.get_or_insert(height);
        let (r, bottom) = if self.incremental {
            (began + self.mm(r), began + self.mm(r) + self.mm(bottom))
        } else {
            (self.mm(r), self.mm(bottom))
        };
        if r < bottom {
            return refuse(format!("R {r} below the depth {bottom}"), "R above it");
        }
        let peck = self.mm(peck.unwrap_or(0.0));
        let strokes = (if pecks { ((r - bottom) / peck).max(1.0) } else { 1.0 }) * times as f64;
        let moves = 3.0 * strokes;
        if moves > MOST_PIECES as f64 {
            return refuse(format!("a line of {moves:.0} moves"), &format!("at most {MOST_PIECES} pieces of path"));
        }
        self.builder.count_strokes(line, strokes)?;
        if began < r {
            let mut up = [x, y, z];
            up[normal] = r;
            self.rapid(line, up)?;
            (began, height) = (r, r);
        }
        let clear = if self.retract_to_start { began } else { r };
        for number in 0..times {
            at = std::array::from_fn(|k| at[k] + step[k]);
            at[normal] = if number == 0 && height > r { height } else { clear };
            self.rapid(line, at)?;
            self.hole(line, code, at, &Hole { r, bottom, clear }, peck, feed)?;
        }
        if dwell.is_some() && matches!(code, 820 | 840 | 860 | 890) {
            self.note(line, "P with a cycle", "the axes stop; the time is not simulated");
        }
        Ok(())
    }

    fn rapid(&mut self, line: u32, at: [f64; 3]) -> Result<(), Refusal> {
        self.straight_in_cycle(line, Pace::Rapid, at)
    }

    fn straight_in_cycle(&mut self, line: u32, pace: Pace, [x, y, z]: [f64; 3]) -> Result<(), Refusal> {
        let [.., a, b, c] = self.frame.to_program(self.builder.at);
        let mut end = self.frame.to_machine([x, y, z, a, b, c]);
        // Rounding from adding and subtracting offsets must move nothing.
        for (end, at) in end.iter_mut().zip(self.builder.at) {
            if (*end - at).abs() < 1.0e-9 {
                *end = at;
            }
        }
        self.builder.line_to(line, pace, end, self.plane.normal())?;
        self.moved();
        Ok(())
    }

    /// Drills from the height of `at` and retracts to the end height.
    fn hole(&mut self, line: u32, code: u16, at: [f64; 3], hole: &Hole, peck: f64, feed: Pace) -> Result<(), Refusal> {
        let [.., normal] = self.plane.axes();
        let height = |height: f64| {
            let mut at = at;
            at[normal] = height;
            at
        };
        self.rapid(line, height(hole.r))?;
        if peck > 0.0 {
            for number in 1..((hole.r - hole.bottom) / peck).ceil() as u32 {
                let depth = hole.r - f64::from(number) * peck;
                self.straight_in_cycle(line, feed, height(depth))?;
                if code == 830 {
                    self.rapid(line, height(hole.r))?;
                }
                self.rapid(line, height(depth + CLEARANCE))?;
            }
        }
        self.straight_in_cycle(line, feed, height(hole.bottom))?;
        match code {
            820 | 860 => self.builder.stop(),
            // G89 bores out at the feed; G84 taps out likewise.
            840 | 890 => {
                self.builder.stop();
                self.straight_in_cycle(line, feed, height(hole.clear))?;
            }
            850 => self.straight_in_cycle(line, feed, height(hole.r))?,
            _ => {}
        }
        self.rapid(line, height(hole.clear))
    }
}
