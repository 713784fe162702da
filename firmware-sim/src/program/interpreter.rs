//! Modal state: executes the words of one line after the other, in the order of RS274/NGC.

use super::arc::{ArcWords, Plane};
use super::curve::Curve;
use super::error::Refusal;
use super::nurbs_block::NurbsBlock;
use super::words::{Block, Word};
use super::{FirstWords, Move, Note, ROTARY_LETTERS, Turn};

const MM_PER_INCH: f64 = 25.4;

/// Motion mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Rapid,
    Feed,
    Arc { clockwise: bool },
    Nurbs,
    NurbsEnd,
    Cancel,
}

/// One block sorted: letters with values, and what its G and M words ask for.
#[derive(Default)]
struct Sorted {
    line: u32,
    /// By letter, A first.
    values: [Option<f64>; 26],
    /// Taken by a G or M word or a note.
    used: [bool; 26],
    motion: Option<Motion>,
    /// G43.4 (true) or G49 (false).
    tool_center: Option<bool>,
    ends: bool,
}

impl Sorted {
    fn index(letter: char) -> usize {
        (letter as usize).wrapping_sub('A' as usize).min(25)
    }

    fn take(&mut self, letter: char) -> Option<f64> {
        let i = Sorted::index(letter);
        self.used[i] = true;
        self.values[i]
    }

    fn has(&self, letters: &str) -> bool {
        letters.chars().any(|letter| self.values[Sorted::index(letter)].is_some())
    }

    /// Whether it names a place to go to.
    fn moves(&self) -> bool {
        self.has("XYZABC")
    }
}

/// A feed as it was programmed.
#[derive(Clone, Copy)]
struct Feed {
    /// The F word.
    number: f64,
    /// The same in mm, where it counts lengths.
    mm: f64,
}

/// State between lines. The default is that of the beginning of a program.
#[derive(Default)]
pub(super) struct Interpreter {
    position: [f64; 3],
    /// A, B, C, degrees.
    rotary: [f64; 3],
    tool_center: bool,
    plane: Plane,
    inch: bool,
    incremental: bool,
    absolute_center: bool,
    motion: Option<Motion>,
    inverse_time: bool,
    /// Per minute in G94 and modal; in G93 one over the minutes of the move, and of this line only.
    feed: Option<Feed>,
    nurbs: Option<NurbsBlock>,
    ended: bool,
    moves: Vec<Move>,
    notes: Vec<Note>,
    first: FirstWords,
}

impl Interpreter {
    /// Executes one line.
    pub(super) fn run(&mut self, block: &Block) -> Result<(), Refusal> {
        if block.percent || block.words.is_empty() {
            return Ok(());
        }
        if self.ended {
            let found = block.words.first().map_or("", |word| word.text.as_str());
            return Err(Refusal::new(block.line, format!("`{found}` after the program's end"), "nothing but %"));
        }
        let mut sorted = self.sort(block)?;
        self.set_feed(&mut sorted)?;
        self.set_tool_center(&mut sorted)?;
        self.execute(&mut sorted)?;
        for (letter, (value, used)) in ('A'..='Z').zip(sorted.values.iter().zip(sorted.used)) {
            if let (Some(value), false) = (value, used) {
                let needed = match letter {
                    'P' => "P only with G2, G3, G5.2 or G64",
                    'I' | 'J' | 'K' | 'R' => "I, J, K, R only with G2 or G3",
                    'L' => "L only with G5.2",
                    'X' | 'Y' | 'Z' => "a motion word (G0, G1, G2, G3, G5.2) before axis words",
                    'A' | 'B' | 'C' => "a motion word (G0, G1, G2, G3) before rotary words",
                    'H' => "H only with G43.4",
                    _ => "a word of the supported dialect (G M X Y Z A B C I J K R P L F H N S T)",
                };
                return Err(Refusal::new(block.line, format!("`{letter}{value}`"), needed));
            }
        }
        self.ended = sorted.ends;
        Ok(())
    }

    /// The moves and notes of a program whose last line was `last`, and where it first needs more than X, Y and Z.
    pub(super) fn finish(self, last: u32) -> Result<(Vec<Move>, Vec<Note>, FirstWords), Refusal> {
        match self.nurbs {
            Some(nurbs) => Err(Refusal::new(last, format!("the end in the NURBS of line {}", nurbs.line), "G5.3")),
            None => Ok((self.moves, self.notes, self.first)),
        }
    }

    fn note(&mut self, line: u32, text: impl Into<String>) {
        self.notes.push(Note { line, text: text.into() });
    }

    /// Sorts the words and applies the modes they set; refuses a letter or a modal group twice.
    fn sort(&mut self, block: &Block) -> Result<Sorted, Refusal> {
        let mut sorted = Sorted { line: block.line, ..Sorted::default() };
        let mut groups: Vec<(u32, &str)> = Vec::new();
        let inch_before = self.inch;
        for word in &block.words {
            let group = match word.letter {
                'G' => self.set_mode(word, &mut sorted)?,
                'M' => self.auxiliary(word, &mut sorted)?,
                letter => {
                    let i = Sorted::index(letter);
                    if sorted.values[i].replace(word.value).is_some() {
                        let found = format!("`{}`, {letter} for the second time", word.text);
                        return Err(Refusal::new(block.line, found, "each letter once in a line"));
                    }
                    continue;
                }
            };
            if let Some((_, other)) = groups.iter().find(|(other, _)| *other == group) {
                let found = format!("`{}` and `{other}`", word.text);
                return Err(Refusal::new(block.line, found, "one word of a modal group in a line"));
            }
            groups.push((group, &word.text));
        }
        if self.inch != inch_before && sorted.has("F") {
            return Err(Refusal::new(block.line, "F in the line that changes the unit", "F in a line of its own"));
        }
        for (letter, why) in [('S', "spindle speed"), ('T', "tool number")] {
            if let Some(value) = sorted.take(letter) {
                self.note(block.line, format!("{letter}{value}: {why}, no effect on the path"));
            }
        }
        sorted.take('N');
        Ok(sorted)
    }

    /// Applies a G word; returns its modal group.
    fn set_mode(&mut self, word: &Word, sorted: &mut Sorted) -> Result<u32, Refusal> {
        let refuse = |needed: &str| Err(Refusal::new(sorted.line, format!("`{}`", word.text), needed));
        let Some(code) = word.tenths() else { return refuse("a supported G word") };
        let motion = match code {
            0 => Some(Motion::Rapid),
            10 => Some(Motion::Feed),
            20 => Some(Motion::Arc { clockwise: true }),
            30 => Some(Motion::Arc { clockwise: false }),
            52 => Some(Motion::Nurbs),
            53 => Some(Motion::NurbsEnd),
            800 => Some(Motion::Cancel),
            _ => None,
        };
        if motion.is_some() {
            sorted.motion = motion;
            return Ok(1);
        }
        let group = match code {
            170 | 180 | 190 => 2,
            900 | 910 => 3,
            901 | 911 => 4,
            930 | 940 => 5,
            200 | 210 => 6,
            400 => 7,
            434 | 490 => 8,
            540 => 12,
            610 | 611 | 640 => 13,
            _ => {
                return refuse(
                    "G0 G1 G2 G3 G5.2 G5.3 G17 G18 G19 G20 G21 G40 G43.4 G49 G54 G61 G61.1 G64 G80 G90 G90.1 G91 G91.1 G93 \
                     G94",
                );
            }
        };
        if self.nurbs.is_some() {
            return refuse("control points or G5.3 within a NURBS");
        }
        match code {
            170 => self.plane = Plane::Xy,
            180 => self.plane = Plane::Zx,
            190 => self.plane = Plane::Yz,
            200 => self.inch = true,
            210 => self.inch = false,
            900 => self.incremental = false,
            910 => self.incremental = true,
            901 => self.absolute_center = true,
            911 => self.absolute_center = false,
            930 | 940 => {
                // A number of the other kind would be a wrong feed: F has to follow.
                if self.inverse_time != (code == 930) {
                    self.feed = None;
                }
                self.inverse_time = code == 930;
            }
            434 => sorted.tool_center = Some(true),
            490 if self.tool_center => sorted.tool_center = Some(false),
            640 => {
                let tolerance = sorted.take('P').map_or_else(String::new, |p| format!(" P{p}"));
                self.note(sorted.line, format!("G64{tolerance}: the programmed path is followed exactly"));
            }
            _ => self.note(sorted.line, format!("{}: no effect on the path", word.text)),
        }
        Ok(group)
    }

    /// Accepts an M word; returns its modal group, counted from 100.
    fn auxiliary(&mut self, word: &Word, sorted: &mut Sorted) -> Result<u32, Refusal> {
        let group = match word.tenths() {
            Some(20 | 300) => {
                sorted.ends = true;
                return Ok(104);
            }
            Some(30 | 40 | 50) => 107,
            Some(60) => 106,
            Some(70) => 108,
            Some(80) => 109,
            Some(90) => 110,
            _ => {
                let needed = "M2 M3 M4 M5 M6 M7 M8 M9 M30";
                return Err(Refusal::new(sorted.line, format!("`{}`", word.text), needed));
            }
        };
        self.note(sorted.line, format!("{}: no effect on the path", word.text));
        Ok(group)
    }

    fn mm(&self, value: f64) -> f64 {
        if self.inch { value * MM_PER_INCH } else { value }
    }

    fn set_feed(&mut self, sorted: &mut Sorted) -> Result<(), Refusal> {
        let Some(number) = sorted.take('F') else {
            if self.inverse_time {
                self.feed = None;
            }
            return Ok(());
        };
        if number <= 0.0 {
            return Err(Refusal::new(sorted.line, format!("`F{number}`"), "a positive feed"));
        }
        self.feed = Some(Feed { number, mm: self.mm(number) });
        Ok(())
    }

    fn required_feed(&self, line: u32) -> Result<Feed, Refusal> {
        let needed = if self.inverse_time { "F in every line of a feed motion in G93" } else { "F before it" };
        self.feed.ok_or_else(|| Refusal::new(line, "a feed motion without feed", needed))
    }

    /// G43.4 and G49, before the motion of the line.
    fn set_tool_center(&mut self, sorted: &mut Sorted) -> Result<(), Refusal> {
        let Some(on) = sorted.tool_center else { return Ok(()) };
        // Only there do X, Y and Z mean the same place before and after, on every machine.
        if let Some((letter, angle)) = ROTARY_LETTERS.iter().zip(self.rotary).find(|(_, angle)| angle % 360.0 != 0.0) {
            let word = if on { "G43.4" } else { "G49" };
            let needed = "A, B and C at 0 (or whole turns) before G43.4 and before G49 after it";
            return Err(Refusal::new(sorted.line, format!("{word} at {letter}{angle}"), needed));
        }
        self.tool_center = on;
        if on {
            self.first.tool_center.get_or_insert(sorted.line);
            if let Some(number) = sorted.take('H') {
                self.note(sorted.line, format!("H{number}: the tool's length is that of the machine file"));
            }
        }
        Ok(())
    }

    /// The programmed value of an axis, mm and absolute.
    fn target(&self, axis: usize, value: f64) -> f64 {
        let value = self.mm(value);
        if self.incremental { self.position[axis] + value } else { value }
    }

    fn execute(&mut self, sorted: &mut Sorted) -> Result<(), Refusal> {
        let line = sorted.line;
        if let Some(motion) = sorted.motion {
            if self.nurbs.is_some() && !matches!(motion, Motion::Nurbs | Motion::NurbsEnd) {
                return Err(Refusal::new(line, "another motion word within a NURBS", "control points or G5.3"));
            }
            self.motion = Some(motion);
        }
        let moving = sorted.moves();
        match self.motion {
            Some(Motion::Rapid) if moving => {
                let curve = self.line(sorted);
                let turn = self.turn(sorted);
                self.push(line, None, curve, turn);
            }
            Some(Motion::Feed) if moving => {
                let feed = self.required_feed(line)?;
                let curve = self.line(sorted);
                let turn = self.turn(sorted);
                self.push(line, Some(feed), curve, turn);
            }
            Some(Motion::Arc { clockwise }) if moving || sorted.has("IJKR") || sorted.motion.is_some() => {
                let feed = self.required_feed(line)?;
                let curve = self.arc(sorted, clockwise)?;
                let turn = self.turn(sorted);
                self.push(line, Some(feed), curve, turn);
            }
            Some(Motion::Nurbs) if moving || sorted.has("PL") || sorted.motion.is_some() => {
                if self.inverse_time {
                    return Err(Refusal::new(line, "a NURBS in G93", "G94"));
                }
                self.required_feed(line)?;
                self.control_point(sorted)?;
            }
            Some(Motion::NurbsEnd) => self.close_nurbs(sorted)?,
            _ => {}
        }
        if self.nurbs.is_some() && sorted.ends {
            return Err(Refusal::new(line, "the program's end within a NURBS", "G5.3"));
        }
        Ok(())
    }

    fn end_point(&self, sorted: &mut Sorted) -> [f64; 3] {
        let mut end = self.position;
        for (axis, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if let Some(value) = sorted.take(letter) {
                end[axis] = self.target(axis, value);
            }
        }
        end
    }

    fn line(&self, sorted: &mut Sorted) -> Curve {
        Curve::Line { start: self.position, end: self.end_point(sorted) }
    }

    /// The rotary axes' way to the programmed angles.
    fn turn(&mut self, sorted: &mut Sorted) -> Turn {
        let mut turn = Turn { start: self.rotary, change: [0.0; 3] };
        for (axis, letter) in ROTARY_LETTERS.into_iter().enumerate() {
            if let Some(value) = sorted.take(letter) {
                self.first.rotary[axis].get_or_insert(sorted.line);
                turn.change[axis] = if self.incremental { value } else { value - self.rotary[axis] };
            }
        }
        turn
    }

    fn arc(&self, sorted: &mut Sorted, clockwise: bool) -> Result<Curve, Refusal> {
        ArcWords {
            line: sorted.line,
            clockwise,
            plane: self.plane,
            start: self.position,
            end: self.end_point(sorted),
            center: ['I', 'J', 'K'].map(|letter| sorted.take(letter).map(|value| self.mm(value))),
            absolute_center: self.absolute_center,
            radius: sorted.take('R').map(|value| self.mm(value)),
            turns: sorted.take('P'),
        }
        .curve()
    }

    fn control_point(&mut self, sorted: &mut Sorted) -> Result<(), Refusal> {
        let line = sorted.line;
        if self.plane != Plane::Xy {
            return Err(Refusal::new(line, format!("G5.2 in {}", self.plane.code()), "G17"));
        }
        if sorted.has("Z") {
            return Err(Refusal::new(line, "Z within a NURBS", "X and Y only"));
        }
        if sorted.has("ABC") {
            return Err(Refusal::new(line, "a rotary word within a NURBS", "X and Y only"));
        }
        // In G91 control points count from the start of the curve: the current point stays there until G5.3.
        let point =
            [sorted.take('X').map(|value| self.target(0, value)), sorted.take('Y').map(|value| self.target(1, value))];
        let (weight, order) = (sorted.take('P'), sorted.take('L'));
        let start = self.position;
        self.nurbs.get_or_insert_with(|| NurbsBlock::new(line, start)).add(line, point, weight, order)
    }

    fn close_nurbs(&mut self, sorted: &Sorted) -> Result<(), Refusal> {
        let line = sorted.line;
        if sorted.motion.is_none() {
            return Ok(());
        }
        self.motion = None;
        let Some(nurbs) = self.nurbs.take() else {
            return Err(Refusal::new(line, "G5.3 without G5.2", "G5.2 and control points before it"));
        };
        let feed = self.required_feed(line)?;
        let curve = nurbs.curve(line)?;
        self.push(line, Some(feed), curve, Turn { start: self.rotary, change: [0.0; 3] });
        Ok(())
    }

    /// Appends a move and goes to its end; one without length leaves a note instead. Without `feed` it is a rapid.
    fn push(&mut self, line: u32, feed: Option<Feed>, curve: Curve, turn: Turn) {
        let (end, length) = match &curve {
            Curve::Line { end, .. } | Curve::Arc { end, .. } => (*end, curve.length()),
            Curve::Nurbs { points, .. } => (points.last().copied().unwrap_or_default(), curve.length()),
        };
        self.position = end;
        self.rotary = turn.end();
        let angle = turn.angle();
        if length <= 0.0 && angle <= 0.0 {
            self.note(line, "a move without length");
            return;
        }
        let feed_per_min = feed.map_or(0.0, |feed| match (self.inverse_time, length > 0.0) {
            (true, along) => feed.number * if along { length } else { angle },
            (false, true) => feed.mm,
            (false, false) => feed.number,
        });
        self.moves.push(Move {
            line,
            rapid: feed.is_none(),
            feed_per_min,
            plane_normal: self.plane.normal(),
            curve,
            turn,
            tool_center: self.tool_center,
        });
    }
}
