//! Modal state: executes line after line, in the order of RS274/NGC.

use super::ReadOptions;
use super::arc::Plane;
use super::block::Block;
use super::builder::{Builder, Pace};
use super::error::Refusal;
use super::frame::Frame;
use super::modal::{g, m};
use super::nurbs_block::NurbsBlock;
use super::offsets::Offsets;

const MM_PER_INCH: f64 = 25.4;

/// A feed as programmed.
#[derive(Clone, Copy, Debug)]
struct Feed {
    /// The F word.
    number: f64,
    /// The number in mm, if it counts lengths.
    mm: f64,
}

/// Programmed values of a canned cycle, which the next line inherits.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CannedCycle {
    /// G word of the cycle, in tenths.
    pub(super) code: u16,
    pub(super) bottom: f64,
    pub(super) r: f64,
    /// P.
    pub(super) dwell: Option<f64>,
    /// Q.
    pub(super) peck: Option<f64>,
}

/// State between lines, and the moves so far.
pub(super) struct Interpreter<'o> {
    pub(super) options: &'o ReadOptions,
    pub(super) builder: Builder,
    pub(super) frame: Frame,
    /// Current offsets, those of G10 included.
    pub(super) offsets: Offsets,
    pub(super) plane: Plane,
    inch: bool,
    pub(super) incremental: bool,
    pub(super) absolute_center: bool,
    /// Active motion word, in tenths.
    pub(super) motion: Option<u16>,
    pub(super) inverse_time: bool,
    /// In G94 per minute and modal; in G93 one over the minutes of the move, valid in this line only.
    feed: Option<Feed>,
    /// G98: cycles retract to where they began; otherwise (G99) to R.
    pub(super) retract_to_start: bool,
    /// G61.1.
    exact_stop: bool,
    pub(super) cycle: Option<CannedCycle>,
    /// Height at which the series of cycles began, in program coordinates: G98 retracts to it.
    pub(super) cycle_start: Option<f64>,
    selected_tool: Option<u32>,
    pub(super) loaded_tool: u32,
    pub(super) nurbs: Option<NurbsBlock>,
    began: bool,
    pub(super) ended: bool,
}

impl<'o> Interpreter<'o> {
    pub(super) fn new(options: &'o ReadOptions, most_pieces: u64) -> Self {
        let offsets = options.offsets.clone().unwrap_or_default();
        let system = offsets.systems[offsets.active];
        let frame = Frame {
            g5x: system.offset,
            rotation_deg: system.rotation_deg,
            g92: if offsets.g92_active { offsets.g92 } else { [0.0; 6] },
            tool: [0.0; 6],
        };
        Interpreter {
            options,
            builder: Builder::new(most_pieces),
            frame,
            offsets,
            plane: Plane::default(),
            inch: false,
            incremental: false,
            absolute_center: false,
            motion: None,
            inverse_time: false,
            feed: None,
            retract_to_start: false,
            exact_stop: false,
            cycle: None,
            cycle_start: None,
            selected_tool: None,
            loaded_tool: 0,
            nurbs: None,
            began: false,
            ended: false,
        }
    }

    /// Executes a line cleaned by [`clean`](super::text::clean).
    pub(super) fn run(&mut self, line: u32, text: &str) -> Result<(), Refusal> {
        if self.ended {
            return Ok(());
        }
        let text = match text.strip_prefix('/') {
            Some(_) if self.options.block_delete => {
                self.note(line, "/", "left out by --block-delete");
                return Ok(());
            }
            // Fanuc's switches /1 to /9 are a single switch here.
            Some(rest) => rest.trim_start_matches(|c: char| c.is_ascii_digit()),
            None => text,
        };
        if text == "%" {
            // The first % may begin the program; a second one ends it.
            self.ended = self.began;
            self.began = true;
            return Ok(());
        }
        if text.is_empty() {
            return Ok(());
        }
        self.began = true;
        let mut block = Block::read(line, text)?;
        if block.program_number {
            self.note(line, "O", "program number");
            return Ok(());
        }
        if self.nurbs.is_some() {
            self.stay_in_nurbs(&block)?;
        }
        self.set_feed(&mut block)?;
        self.spindle_and_tool(&mut block)?;
        self.set_modes(&mut block)?;
        self.once(&mut block)?;
        self.go(&mut block)?;
        block.refuse_unused()?;
        self.stop(&block)
    }

    /// Refuses a program that ends within a NURBS; `last` is its last line.
    pub(super) fn finish(self, last: u32) -> Result<Builder, Refusal> {
        match self.nurbs {
            Some(nurbs) => Err(Refusal::new(last, format!("the end in the NURBS of line {}", nurbs.line), "G5.3")),
            None => Ok(self.builder),
        }
    }

    pub(super) fn note(&mut self, line: u32, word: &str, why: &'static str) {
        self.builder.notes.add(line, word, why);
    }

    pub(super) fn mm(&self, value: f64) -> f64 {
        if self.inch { value * MM_PER_INCH } else { value }
    }

    /// G93, G94 and F. As in LinuxCNC, F is in the unit that was active before the line.
    fn set_feed(&mut self, block: &mut Block) -> Result<(), Refusal> {
        if let Some(code) = block.g[g::FEED] {
            // A number from the other mode would be a wrong feed: a new F is required.
            if self.inverse_time != (code == 930) {
                self.feed = None;
            }
            self.inverse_time = code == 930;
        }
        let Some(number) = block.take('F') else {
            if self.inverse_time {
                self.feed = None;
            }
            return Ok(());
        };
        if number < 0.0 {
            return Err(Refusal::new(block.line, format!("`F{number}`"), "a positive feed"));
        }
        self.feed = (number > 0.0).then(|| Feed { number, mm: self.mm(number) });
        Ok(())
    }

    /// Pace of a feed motion.
    pub(super) fn feed(&self, line: u32) -> Result<Pace, Refusal> {
        let needed = if self.inverse_time { "F in every line of a feed motion in G93" } else { "F before it" };
        let feed = self.feed.ok_or_else(|| Refusal::new(line, "a feed motion without feed", needed))?;
        Ok(if self.inverse_time {
            Pace::InverseTime(feed.number)
        } else {
            Pace::PerMinute { mm: feed.mm, degrees: feed.number }
        })
    }

    /// S, T, M3 to M9, M19, M48 to M53, M6, M61 and M62 to M68.
    fn spindle_and_tool(&mut self, block: &mut Block) -> Result<(), Refusal> {
        let line = block.line;
        if block.take('S').is_some() {
            self.note(line, "S", "");
        }
        if let Some(number) = block.take('T') {
            if number.fract() != 0.0 || !(0.0..=99_999_999.0).contains(&number) {
                return Err(Refusal::new(line, format!("`T{number}`"), "a whole number of a tool"));
            }
            self.selected_tool = Some(number as u32);
            if self.options.tools.is_some() && number > 0.0 {
                self.tool_offset(line, number as u32)?;
            }
            self.note(line, "T", "");
        }
        for (group, letters) in
            [(m::IO, "PQE"), (m::TOOL, "Q"), (m::SPINDLE, "PQR"), (m::COOLANT, ""), (m::OVERRIDE, "P")]
        {
            let Some(number) = block.m[group] else { continue };
            self.note(line, &format!("M{number}"), "");
            match number {
                6 => self.loaded_tool = self.selected_tool.unwrap_or(self.loaded_tool),
                61 => self.loaded_tool = block.take('Q').unwrap_or(0.0).clamp(0.0, 99_999_999.0) as u32,
                19 | 48..=53 | 62.. => letters.chars().for_each(|letter| {
                    block.take(letter);
                }),
                _ => {}
            }
            if number == 6 {
                self.builder.stop();
            }
        }
        Ok(())
    }

    /// Modal G words, except motion.
    fn set_modes(&mut self, block: &mut Block) -> Result<(), Refusal> {
        let line = block.line;
        if block.g[g::ONCE] == Some(40) {
            if block.take('P').is_none_or(|seconds| seconds < 0.0) {
                return Err(Refusal::new(line, "G4 without its time", "P with seconds"));
            }
            self.builder.stop();
            self.note(line, "G4", "the axes stop; the time is not simulated");
        }
        match block.g[g::PLANE] {
            Some(170) => self.plane = Plane::Xy,
            Some(180) => self.plane = Plane::Zx,
            Some(_) => self.plane = Plane::Yz,
            None => {}
        }
        if let Some(code) = block.g[g::UNIT] {
            self.inch = code == 200;
        }
        self.set_tool_length(block)?;
        if let Some(code) = block.g[g::SYSTEM] {
            self.choose_system(super::modal::system_number(code) - 1);
        }
        match block.g[g::PATH] {
            Some(640) => {
                block.take('Q');
                match block.take('P') {
                    Some(_) => {
                        self.note(line, "G64 P", "corners are not rounded, the programmed path is followed exactly")
                    }
                    None => self.note(line, "G64", "the programmed path is followed exactly"),
                }
                self.exact_stop = false;
            }
            Some(code) => self.exact_stop = code == 611,
            None => {}
        }
        if let Some(code) = block.g[g::DISTANCE] {
            self.incremental = code == 910;
        }
        if let Some(code) = block.g[g::CENTER] {
            self.absolute_center = code == 901;
        }
        if let Some(code) = block.g[g::RETRACT] {
            self.retract_to_start = code == 980;
        }
        if let Some(code) = block.g[g::SPINDLE] {
            block.take('D');
            self.note(line, if code == 960 { "G96" } else { "G97" }, "");
        }
        Ok(())
    }

    /// M0, M1, M60 and the program's end.
    fn stop(&mut self, block: &Block) -> Result<(), Refusal> {
        match block.m[m::STOP] {
            Some(2 | 30) if self.nurbs.is_some() => {
                return Err(Refusal::new(block.line, "the program's end within a NURBS", "G5.3"));
            }
            Some(2 | 30) => self.ended = true,
            Some(number) => {
                self.builder.stop();
                self.note(block.line, &format!("M{number}"), "the axes stop and continue at once");
            }
            None => {}
        }
        Ok(())
    }

    /// Stops after a move if G61.1 is active.
    pub(super) fn moved(&mut self) {
        if self.exact_stop {
            self.builder.stop();
        }
    }
}
