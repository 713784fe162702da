//! Runs the lines of a program in their order: loops, conditions, subprograms in the program and in files of its folder.
//!
//! Bounded: [`DEEPEST`] subprograms within one another, lines run by loops and calls, and the pieces of path of the
//! [`builder`](super::builder).

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::builder::Builder;
use super::error::Refusal;
use super::interpreter::{Interpreter, Next};
use super::limits::MOST_BYTES;
use super::modes::Saved;
use super::o_word::{Kind, OWord};
use super::parameters::ARGUMENTS;
use super::{ProgramError, ReadOptions, files, language, text};

/// Most subprograms within one another, as in LinuxCNC.
const DEEPEST: usize = 9;

/// Most ifs and loops within one another, and most subprograms.
const MOST_OPEN: usize = 200;
const MOST_KNOWN: usize = 10_000;

/// Lines that loops and calls may run for every piece of path that the program may have.
const LINES_PER_PIECE: u64 = 5;

/// A longer line counts as several.
const BYTES_PER_LINE: usize = 256;

struct File<'o> {
    name: String,
    bytes: Cow<'o, [u8]>,
}

/// The beginning of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Place {
    file: usize,
    offset: usize,
    line: u32,
}

/// An if or a loop that has begun and not ended.
struct Open {
    word: OWord,
    /// Its line.
    at: Place,
    /// The line after it.
    after: Place,
    /// Repetitions of repeat that remain.
    remain: u64,
    /// How often it has turned back.
    turns: u64,
}

/// The program, or a subprogram that runs.
struct Level {
    open: Vec<Open>,
    /// Where it was called.
    called: Place,
    /// The line after the call.
    back: Place,
    /// First line of the subprogram.
    start: Place,
    /// The caller's #1 to #30; `None` if they are shared (M98).
    arguments: Option<[f64; ARGUMENTS]>,
    /// The caller's names and saved modes.
    local: BTreeMap<String, f64>,
    saved: Saved,
    /// Repetitions that remain, of M98 L.
    remain: u64,
    turns: u64,
}

/// A program that runs.
pub(super) struct Flow<'o> {
    interpreter: Interpreter<'o>,
    files: Vec<File<'o>>,
    /// Next line.
    at: Place,
    /// Line that is being executed.
    here: Place,
    /// Last line of the program itself: the moves of a subprogram in a file have that of its call.
    own_line: u32,
    /// First lines of subprograms by label, those of O words and of M98 apart.
    known: BTreeMap<(bool, String), Place>,
    levels: Vec<Level>,
    /// Lines run since the first loop or call.
    lines: u64,
    most_lines: u64,
    turned: bool,
}

/// Reads a program.
pub(super) fn read(bytes: &[u8], file: &str, options: &ReadOptions, most_pieces: u64) -> Result<Builder, ProgramError> {
    let mut flow = Flow {
        interpreter: Interpreter::new(options, most_pieces),
        files: vec![File { name: file.to_owned(), bytes: Cow::Borrowed(bytes) }],
        at: Place { file: 0, offset: text::beginning(bytes), line: 1 },
        here: Place { file: 0, offset: 0, line: 1 },
        own_line: 1,
        known: BTreeMap::new(),
        levels: vec![Level::new(Place::default(), Place::default(), 1)],
        lines: 0,
        most_lines: most_pieces.saturating_mul(LINES_PER_PIECE),
        turned: false,
    };
    let last = match text::refuse_utf16(bytes).and_then(|()| flow.run()) {
        Ok(()) => flow.own_line,
        Err(refusal) => {
            let name = &flow.files[flow.here.file].name;
            return Err(language::named(bytes, name, refusal).in_file(name));
        }
    };
    flow.interpreter.finish(last).map_err(|refusal| refusal.in_file(file))
}

impl Level {
    fn new(called: Place, back: Place, times: u64) -> Level {
        Level {
            open: Vec::new(),
            called,
            back,
            start: back,
            arguments: None,
            local: BTreeMap::new(),
            saved: Saved::default(),
            remain: times.saturating_sub(1),
            turns: 0,
        }
    }
}

impl<'o> Flow<'o> {
    fn run(&mut self) -> Result<(), Refusal> {
        let mut line = String::new();
        while !self.interpreter.ended {
            if !self.next(&mut line, true)? {
                return self.end_of_file();
            }
            self.execute(&line)?;
        }
        Ok(())
    }

    fn level(&mut self) -> &mut Level {
        // The program's own level is never removed.
        let last = self.levels.len() - 1;
        &mut self.levels[last]
    }

    /// Goes to the next line of the file; returns whether there is one. A line that is skipped may have any text.
    fn next(&mut self, line: &mut String, executed: bool) -> Result<bool, Refusal> {
        let bytes = &self.files[self.at.file].bytes;
        let Some(rest) = bytes.get(self.at.offset..) else { return Ok(false) };
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.here = self.at;
        self.at = Place { offset: self.at.offset + length + 1, line: self.at.line.saturating_add(1), ..self.at };
        if let Err(refusal) = text::clean(self.here.line, &rest[..length], line) {
            line.clear();
            if executed {
                return Err(refusal);
            }
        }
        if self.turned {
            self.lines += 1 + (length / BYTES_PER_LINE) as u64;
            if self.lines > self.most_lines {
                return Err(self.endless(format!("{} lines", self.lines)));
            }
        }
        Ok(true)
    }

    /// The refusal of a loop that takes too long: of the one that has turned most.
    fn endless(&mut self, after: String) -> Refusal {
        let loops = self.levels.iter().flat_map(|level| {
            let open = level.open.iter().map(|open| (open.turns, open.at));
            open.chain([(level.turns, level.called)])
        });
        if let Some((_, at)) = loops.filter(|(turns, _)| *turns > 0).max_by_key(|(turns, _)| *turns) {
            self.here = at;
        }
        let needed =
            format!("a loop that ends before {} lines or the pieces of path that a program may have", self.most_lines);
        Refusal::new(self.here.line, format!("a loop without an end after {after}"), needed)
    }

    fn end_of_file(&mut self) -> Result<(), Refusal> {
        let levels = self.levels.len();
        let (open, called) = (self.level().open.last().map(|open| open.at.line), self.level().called.line);
        let refuse = |line, found: &str, needed: &str| Err(Refusal::new(line, found, needed));
        match open {
            Some(line) => {
                refuse(line, "an O word without its end", "endif, endwhile, while or endrepeat of the same label")
            }
            None if levels > 1 => {
                let found = format!("the end of the file in the subprogram called in line {called}");
                refuse(self.here.line, &found, "endsub, or M99 after M98")
            }
            None => Ok(()),
        }
    }

    fn execute(&mut self, line: &str) -> Result<(), Refusal> {
        if self.here.file == 0 {
            self.own_line = self.here.line;
        }
        let (here, shown) = (self.here.line, self.own_line);
        // A file of a subprogram may stand between %.
        if self.here.file != 0 && line == "%" {
            return Ok(());
        }
        let Some(text) = self.interpreter.begin(shown, line) else { return Ok(()) };
        if let Some(word) = OWord::read(here, text, &self.interpreter)? {
            return self.o_word(word);
        }
        let next = match self.interpreter.execute(shown, text) {
            Ok(next) => next,
            Err(refusal) if self.turned && self.interpreter.builder.full => {
                return Err(self.endless(refusal.found));
            }
            Err(refusal) => {
                let line = if refusal.line == shown { here } else { refusal.line };
                return Err(Refusal { line, ..refusal });
            }
        };
        match next {
            Next::Line => Ok(()),
            Next::Call { label, times } => self.call_program(label, times),
            Next::Return => self.return_program(),
        }
    }

    fn o_word(&mut self, word: OWord) -> Result<(), Refusal> {
        let line = self.here.line;
        match word.kind {
            Kind::Program => {
                self.interpreter.note(self.own_line, "O", "program number");
                return Ok(());
            }
            Kind::Sub => return self.define(&word),
            Kind::Call => return self.call(&word),
            Kind::EndSub | Kind::Return => return self.return_value(&word),
            Kind::If => {
                if word.condition(line, &self.interpreter)? == 0.0 {
                    return self.branch(word);
                }
                self.open(word, 0)?;
            }
            Kind::ElseIf | Kind::Else | Kind::EndIf => {
                let open = self.opened(&word, &[Kind::If])?;
                if word.kind != Kind::EndIf {
                    self.skip(&open, &[Kind::EndIf])?;
                }
            }
            Kind::Do => {
                word.alone(line)?;
                self.open(word, 0)?;
            }
            Kind::While => self.r#while(word)?,
            Kind::Repeat => {
                let times = word.condition(line, &self.interpreter)?.round_ties_even();
                if times < 1.0 {
                    self.skip(&Open::new(word, self.here, self.at, 0), &[Kind::EndRepeat])?;
                } else {
                    self.open(word, times as u64 - 1)?;
                }
            }
            Kind::EndWhile | Kind::EndRepeat => {
                word.alone(line)?;
                let kind = if word.kind == Kind::EndWhile { Kind::While } else { Kind::Repeat };
                let open = self.opened(&word, &[kind])?;
                self.turn(open, true)?;
            }
            Kind::Break | Kind::Continue => {
                word.alone(line)?;
                let open = self.opened(&word, &[Kind::While, Kind::Do, Kind::Repeat])?;
                if word.kind == Kind::Break {
                    let end = open.end();
                    self.skip(&open, &[end])?;
                } else if open.word.kind == Kind::Do {
                    let end = self.skip(&open, &[Kind::While])?;
                    self.again(open, &end)?;
                } else {
                    self.turn(open, false)?;
                }
            }
        }
        Ok(())
    }

    /// Remembers an if or a loop that begins in this line.
    fn open(&mut self, word: OWord, remain: u64) -> Result<(), Refusal> {
        let open = Open::new(word, self.here, self.at, remain);
        self.push(open)
    }

    fn push(&mut self, open: Open) -> Result<(), Refusal> {
        if self.level().open.len() >= MOST_OPEN {
            let found = format!("{} within {MOST_OPEN} others", open.word.text(open.word.kind));
            return Err(Refusal::new(open.at.line, found, "ends of ifs and loops before it"));
        }
        self.level().open.push(open);
        Ok(())
    }

    /// Takes the innermost open word of that label, and ends those within it.
    fn opened(&mut self, word: &OWord, kinds: &[Kind]) -> Result<Open, Refusal> {
        let line = self.here.line;
        let open = &mut self.level().open;
        let found = open.iter().rposition(|open| open.word.label == word.label);
        if let Some(at) = found.filter(|at| kinds.contains(&open[*at].word.kind)) {
            open.truncate(at + 1);
            if let Some(open) = open.pop() {
                return Ok(open);
            }
        }
        let needed: Vec<_> = kinds.iter().map(|kind| word.text(*kind)).collect();
        Err(Refusal::new(line, format!("`{}`", word.text(word.kind)), format!("{} before it", needed.join(" or "))))
    }

    /// Skips to the next O word of the same label and one of the kinds, and past it.
    fn skip(&mut self, open: &Open, kinds: &[Kind]) -> Result<OWord, Refusal> {
        let (label, begun) = (&open.word.label, open.at);
        let mut line = String::new();
        while self.next(&mut line, false)? {
            if let Some(word) = self.skipped(&line).filter(|word| word.label == *label && kinds.contains(&word.kind)) {
                return Ok(word);
            }
        }
        self.here = begun;
        let found = format!("`{}` without its end", open.word.text(open.word.kind));
        Err(Refusal::new(begun.line, found, format!("`{}` after it", open.word.text(open.end()))))
    }

    /// The O word of a line that is not executed.
    fn skipped(&self, line: &str) -> Option<OWord> {
        let text = self.interpreter.undeleted(line)?;
        OWord::read(self.here.line, text, &self.interpreter).ok().flatten()
    }

    /// Goes to the branch of an if whose condition holds, or past it.
    fn branch(&mut self, word: OWord) -> Result<(), Refusal> {
        let open = Open::new(word, self.here, self.at, 0);
        loop {
            let found = self.skip(&open, &[Kind::ElseIf, Kind::Else, Kind::EndIf])?;
            let taken = match found.kind {
                Kind::ElseIf => found.condition(self.here.line, &self.interpreter)? != 0.0,
                Kind::Else => true,
                _ => return Ok(()),
            };
            if taken {
                return self.push(open);
            }
        }
    }

    /// The beginning of a while loop, or the end of a do loop of that label.
    fn r#while(&mut self, word: OWord) -> Result<(), Refusal> {
        let open = &self.level().open;
        if open.iter().rev().find(|open| open.word.label == word.label).is_some_and(|open| open.word.kind == Kind::Do) {
            let open = self.opened(&word, &[Kind::Do])?;
            return self.again(open, &word);
        }
        if word.condition(self.here.line, &self.interpreter)? == 0.0 {
            self.skip(&Open::new(word, self.here, self.at, 0), &[Kind::EndWhile])?;
        } else {
            self.open(word, 0)?;
        }
        Ok(())
    }

    /// The end of a do loop.
    fn again(&mut self, open: Open, end: &OWord) -> Result<(), Refusal> {
        if end.condition(self.here.line, &self.interpreter)? != 0.0 {
            self.turn(open, true)?;
        }
        Ok(())
    }

    /// Begins the next turn of a loop that goes on, from its end or from within.
    fn turn(&mut self, mut open: Open, at_end: bool) -> Result<(), Refusal> {
        let goes_on = match open.word.kind {
            Kind::Repeat => open.remain > 0,
            Kind::While => open.word.condition(open.at.line, &self.interpreter)? != 0.0,
            _ => true,
        };
        if !goes_on {
            return if at_end { Ok(()) } else { self.skip(&open, &[open.end()]).map(|_| ()) };
        }
        self.turned = true;
        open.remain = open.remain.saturating_sub(1);
        open.turns += 1;
        self.at = open.after;
        self.level().open.push(open);
        Ok(())
    }

    fn define(&mut self, word: &OWord) -> Result<(), Refusal> {
        word.alone(self.here.line)?;
        if self.levels.len() > 1 {
            let found = format!("`{}` in another subprogram", word.text(Kind::Sub));
            return Err(Refusal::new(self.here.line, found, "endsub before it"));
        }
        self.know((false, word.label.clone()), self.at)?;
        let open = Open::new(word.clone(), self.here, self.at, 0);
        self.skip(&open, &[Kind::EndSub]).map(|_| ())
    }

    fn call(&mut self, word: &OWord) -> Result<(), Refusal> {
        let arguments = word.arguments(self.here.line, &self.interpreter)?;
        let start = self.find(false, &word.label, &word.text(Kind::Call), &word.text(Kind::Sub))?;
        self.enter(start, 1)?;
        let before = std::mem::replace(&mut self.interpreter.parameters.arguments, arguments);
        self.level().arguments = Some(before);
        Ok(())
    }

    /// M98.
    fn call_program(&mut self, label: u32, times: u64) -> Result<(), Refusal> {
        if times == 0 {
            return Ok(());
        }
        let start = self.find(true, &label.to_string(), &format!("M98 P{label}"), &format!("O{label}"))?;
        self.enter(start, times)
    }

    fn enter(&mut self, start: Place, times: u64) -> Result<(), Refusal> {
        if self.levels.len() > DEEPEST {
            let found = format!("{} subprograms within one another", self.levels.len());
            return Err(Refusal::new(self.here.line, found, format!("at most {DEEPEST}")));
        }
        self.turned = true;
        let mut level = Level { start, ..Level::new(self.here, self.at, times) };
        level.local = std::mem::take(&mut self.interpreter.parameters.local);
        level.saved = std::mem::take(&mut self.interpreter.saved);
        self.levels.push(level);
        self.interpreter.level += 1;
        self.at = start;
        Ok(())
    }

    fn return_value(&mut self, word: &OWord) -> Result<(), Refusal> {
        let line = self.here.line;
        let value = word.result(line, &self.interpreter)?;
        if self.levels.len() == 1 || self.level().arguments.is_none() {
            let found = format!("`{}` outside a subprogram that is called", word.text(word.kind));
            return Err(Refusal::new(line, found, format!("`{}` and its call; M99 after M98", word.text(Kind::Sub))));
        }
        self.interpreter.returned = value;
        self.leave()
    }

    /// M99.
    fn return_program(&mut self) -> Result<(), Refusal> {
        if self.levels.len() == 1 {
            self.interpreter.note(self.own_line, "M99", "ends the program, which a control would begin again");
            self.interpreter.ended = true;
            return Ok(());
        }
        if self.level().arguments.is_some() {
            return Err(Refusal::new(self.here.line, "M99 in a subprogram of an O word", "endsub"));
        }
        self.interpreter.returned = None;
        self.leave()
    }

    fn leave(&mut self) -> Result<(), Refusal> {
        self.interpreter.restore_on_return(self.own_line)?;
        let Some(mut level) = self.levels.pop() else { return Ok(()) };
        if level.remain > 0 {
            (level.remain, level.turns) = (level.remain - 1, level.turns + 1);
            level.open.clear();
            self.interpreter.parameters.local.clear();
            self.interpreter.saved = Saved::default();
            self.at = level.start;
            self.levels.push(level);
            return Ok(());
        }
        if let Some(arguments) = level.arguments {
            self.interpreter.parameters.arguments = arguments;
        }
        self.interpreter.parameters.local = level.local;
        self.interpreter.saved = level.saved;
        self.interpreter.level -= 1;
        self.at = level.back;
        Ok(())
    }

    /// First line of a subprogram: one that has been passed, a file in the program's folder, or one further on in this file.
    fn find(&mut self, program: bool, label: &str, call: &str, head: &str) -> Result<Place, Refusal> {
        let key = (program, label.to_owned());
        if let Some(place) = self.known.get(&key) {
            return Ok(*place);
        }
        let (here, next) = (self.here, self.at);
        let found = match self.load(label)? {
            Some(file) => self.scan(Place { file, line: 1, offset: text::beginning(&self.files[file].bytes) }, &key)?,
            None => {
                let first = Place { file: here.file, line: 1, offset: text::beginning(&self.files[here.file].bytes) };
                match self.scan(next, &key)? {
                    Some(place) => Some(place),
                    None => self.scan(first, &key)?,
                }
            }
        };
        (self.here, self.at) = (here, next);
        let Some(place) = found else {
            let options = &self.interpreter.options;
            let place = match (&options.folder, &options.texts) {
                (Some(_), _) => "in its folder",
                (None, Some(_)) => "beside the program",
                (None, None) => "",
            };
            let mut needed = format!("`{head}` in the program");
            if !place.is_empty() {
                needed += &format!(", or a file {}.ngc with it {place}", label.to_ascii_lowercase());
            }
            return Err(Refusal::new(here.line, format!("`{call}` without its subprogram"), needed));
        };
        self.know(key, place)?;
        Ok(place)
    }

    fn know(&mut self, key: (bool, String), place: Place) -> Result<(), Refusal> {
        if self.known.len() >= MOST_KNOWN {
            return Err(Refusal::new(self.here.line, "one more subprogram", format!("at most {MOST_KNOWN}")));
        }
        self.known.insert(key, place);
        Ok(())
    }

    /// The line after the head of a subprogram, from a place to the end of its file.
    fn scan(&mut self, from: Place, (program, label): &(bool, String)) -> Result<Option<Place>, Refusal> {
        let kind = if *program { Kind::Program } else { Kind::Sub };
        self.at = from;
        let mut line = String::new();
        while self.next(&mut line, false)? {
            if self.skipped(&line).is_some_and(|word| word.kind == kind && word.label == *label) {
                return Ok(Some(self.at));
            }
        }
        Ok(None)
    }

    /// Index of the file of a subprogram, if there is one.
    fn load(&mut self, label: &str) -> Result<Option<usize>, Refusal> {
        let own = files::subprogram(self.interpreter.options, &label.to_ascii_lowercase());
        let Some((name, bytes)) = own else { return Ok(None) };
        let all = self.files.iter().map(|file| file.bytes.len() as u64).sum::<u64>();
        if all + bytes.len() as u64 > MOST_BYTES {
            let found = format!("a program and its files of more than {MOST_BYTES} bytes, with {name}");
            return Err(Refusal::new(self.here.line, found, "shorter files"));
        }
        self.files.push(File { name, bytes: Cow::Owned(bytes) });
        Ok(Some(self.files.len() - 1))
    }
}

impl Open {
    fn new(word: OWord, at: Place, after: Place, remain: u64) -> Open {
        Open { word, at, after, remain, turns: 0 }
    }

    fn end(&self) -> Kind {
        match self.word.kind {
            Kind::If => Kind::EndIf,
            Kind::Do => Kind::While,
            Kind::Repeat => Kind::EndRepeat,
            Kind::Sub => Kind::EndSub,
            _ => Kind::EndWhile,
        }
    }
}
