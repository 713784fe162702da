//! Modal state: executes line after line, in the order of RS274/NGC.

use super::ReadOptions;
use super::arc::Plane;
use super::block::Block;
use super::builder::{Builder, Pace};
use super::error::Refusal;
use super::frame::Frame;
use super::modal::{g, m};
use super::modes::{Feed, Saved, Spindle};
use super::nurbs_block::NurbsBlock;
use super::offsets::Offsets;
use super::parameters::Parameters;
use super::words::LARGEST;

pub(super) const MM_PER_INCH: f64 = 25.4;

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

/// Which line runs next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// The one that follows.
    Line,
    /// M98.
    Call { label: u32, times: u64 },
    /// M99.
    Return,
}

/// State between lines, and the moves so far.
pub(super) struct Interpreter<'o> {
    pub(super) options: &'o ReadOptions,
    pub(super) builder: Builder,
    pub(super) frame: Frame,
    /// Current offsets, those of G10 included.
    pub(super) offsets: Offsets,
    pub(super) plane: Plane,
    pub(super) inch: bool,
    /// G7: X is a diameter.
    pub(super) diameter: bool,
    pub(super) incremental: bool,
    pub(super) absolute_center: bool,
    /// Active motion word, in tenths.
    pub(super) motion: Option<u16>,
    pub(super) inverse_time: bool,
    /// In G94 per minute and modal; in G93 one over the minutes of the move, valid in this line only.
    pub(super) feed: Option<Feed>,
    /// G98: cycles retract to where they began; otherwise (G99) to R.
    pub(super) retract_to_start: bool,
    /// G61.1.
    pub(super) exact_stop: bool,
    pub(super) cycle: Option<CannedCycle>,
    /// Height at which the series of cycles began, in program coordinates: G98 retracts to it.
    pub(super) cycle_start: Option<f64>,
    pub(super) selected_tool: Option<u32>,
    pub(super) loaded_tool: u32,
    pub(super) nurbs: Option<NurbsBlock>,
    /// Direction in which the next G5 begins, mm.
    pub(super) spline_end: Option<[f64; 2]>,
    /// Last motion word other than a canned cycle, in tenths.
    pub(super) before_cycle: Option<u16>,
    /// Whether axis words after G80 move at rapid.
    pub(super) rapid_after_cancel: bool,
    pub(super) spindle: Spindle,
    pub(super) parameters: Parameters,
    /// Modes that the subprogram has saved.
    pub(super) saved: Saved,
    /// Value of the last subprogram.
    pub(super) returned: Option<f64>,
    /// Number of subprograms that have been called and not ended.
    pub(super) level: u32,
    pub(super) line: u32,
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
            diameter: false,
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
            spline_end: None,
            before_cycle: None,
            rapid_after_cancel: false,
            spindle: Spindle::default(),
            parameters: Parameters::default(),
            saved: Saved::default(),
            returned: None,
            level: 0,
            line: 1,
            began: false,
            ended: false,
        }
    }

    /// A line without `/`; `None` if it is left out.
    pub(super) fn undeleted<'t>(&self, text: &'t str) -> Option<&'t str> {
        match text.strip_prefix('/') {
            Some(_) if self.options.block_delete => None,
            // Fanuc's switches /1 to /9 are a single switch here.
            Some(rest) => Some(rest.trim_start_matches(|c: char| c.is_ascii_digit())),
            None => Some(text),
        }
    }

    /// Takes a line cleaned by [`clean`](super::text::clean); returns its words, if it has any.
    pub(super) fn begin<'t>(&mut self, line: u32, text: &'t str) -> Option<&'t str> {
        self.line = line;
        let Some(text) = self.undeleted(text) else {
            self.note(line, "/", "left out by --block-delete");
            return None;
        };
        if text == "%" {
            // The first % may begin the program; a second one ends it.
            self.ended = self.began;
            self.began = true;
            return None;
        }
        self.began |= !text.is_empty();
        Some(text).filter(|text| !text.is_empty())
    }

    /// Executes the words of a line.
    pub(super) fn execute(&mut self, line: u32, text: &str) -> Result<Next, Refusal> {
        let mut settings = Vec::new();
        let mut block = Block::read(line, text, &*self, &mut settings)?;
        for (parameter, value) in settings {
            self.assign(line, parameter, value)?;
        }
        if let Some(number) = block.m[m::CALL] {
            return self.next(&mut block, number);
        }
        if self.nurbs.is_some() {
            self.stay_in_nurbs(&block)?;
        }
        if let Some(number) = block.m[m::STATE] {
            self.save_or_restore(line, number)?;
        }
        self.set_feed(&mut block)?;
        self.spindle_and_tool(&mut block)?;
        self.set_modes(&mut block)?;
        self.once(&mut block)?;
        self.go(&mut block)?;
        block.refuse_unused()?;
        self.stop(&block)?;
        Ok(Next::Line)
    }

    /// M98 and M99.
    fn next(&mut self, block: &mut Block, number: u16) -> Result<Next, Refusal> {
        let line = block.line;
        if block.g.iter().any(Option::is_some) || block.m.iter().flatten().count() > 1 {
            return Err(Refusal::new(line, format!("M{number} beside another word"), "M98 or M99 on a separate line"));
        }
        let next = if number == 99 {
            Next::Return
        } else {
            let whole = |value: f64| value.fract() == 0.0 && value >= 0.0;
            let Some(label) = block.take('P').filter(|p| whole(*p)) else {
                return Err(Refusal::new(line, "M98 without a program", "P with its number"));
            };
            let times = block.take('L').unwrap_or(1.0);
            if !whole(times) {
                return Err(Refusal::new(line, format!("M98 L{times}"), "a whole number of repeats"));
            }
            Next::Call { label: label as u32, times: times as u64 }
        };
        block.refuse_unused()?;
        Ok(next)
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
        if number > LARGEST {
            self.note(block.line, "F above 1e6", "taken as the highest feed of the axes");
        }
        let number = number.min(LARGEST);
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
        if let Some(speed) = block.take('S') {
            self.spindle.speed = speed;
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
                3..=5 => self.spindle.word = number,
                7 => self.spindle.mist = true,
                8 => self.spindle.flood = true,
                9 => (self.spindle.mist, self.spindle.flood) = (false, false),
                67 | 68 if !(block.has("E") && block.has("Q")) => {
                    return Err(Refusal::new(
                        line,
                        format!("M{number} without E and Q"),
                        "E, the output, and Q, its value",
                    ));
                }
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
        if let Some(code) = block.g[g::LATHE] {
            self.diameter = code == 70;
        }
        if self.diameter {
            block.scale('X', 0.5);
        }
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
            let system = super::modal::system_number(code) - 1;
            // The one in force is not read again, as in LinuxCNC: its parameters may have been assigned.
            if system != self.offsets.active {
                self.choose_system(system);
            }
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
            self.spindle.surface_speed = code == 960;
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
