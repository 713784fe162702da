//! The canonical output of LinuxCNC's interpreter, as `rs274 -g` prints it: one call per line.
//!
//! ```text
//!    12 N7     STRAIGHT_FEED(2.1235, 3.0000, 0.0000, 0.0000, 0.0000, 0.0000)
//! ```
//!
//! Positions are program coordinates in the active unit; offsets come as separate calls.

use super::arc::Plane;
use super::block::AXIS_LETTERS;
use super::builder::{Builder, Pace};
use super::curve::Curve;
use super::error::Refusal;
use super::frame::Frame;
use super::limits::{MOST_PIECES, MOST_TURNS};
use super::{Program, ProgramError};

const MM_PER_INCH: f64 = 25.4;

/// Reads that output line by line; the program's own lines were numbered by [`numbered`](super::numbered).
#[derive(Debug)]
pub struct Canonical {
    /// File name for errors.
    file: String,
    /// Line of the program: the last N word.
    line: u32,
    builder: Builder,
    frame: Frame,
    mm_per_unit: f64,
    plane: Plane,
    /// Units or degrees per minute.
    feed: f64,
    exact_stop: bool,
    ended: bool,
}

impl Canonical {
    /// Starts before the first line of output; `file` appears in errors only.
    pub fn new(file: &str) -> Self {
        Canonical {
            file: file.to_owned(),
            line: 1,
            builder: Builder::new(MOST_PIECES),
            frame: Frame::default(),
            mm_per_unit: 1.0,
            plane: Plane::default(),
            feed: 0.0,
            exact_stop: false,
            ended: false,
        }
    }

    /// Line of the program that produced the last output.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// Whether the program has ended; later output is ignored.
    pub fn has_ended(&self) -> bool {
        self.ended
    }

    /// Reads a line of output.
    ///
    /// # Errors
    /// A call that is not a line or arc of X to C; with the program's line.
    pub fn take(&mut self, output: &str) -> Result<(), ProgramError> {
        if self.ended {
            return Ok(());
        }
        self.read(output).map_err(|refusal| refusal.in_file(&self.file))
    }

    /// The program, under that name.
    pub fn finish(mut self, name: &str) -> Program {
        self.builder.notes.add(1, "--interpreter rs274", "coordinates are rounded to four decimals");
        Program::of(name, &self.file, self.builder)
    }

    fn read(&mut self, output: &str) -> Result<(), Refusal> {
        let Some((head, arguments)) = output.split_once('(') else { return Ok(()) };
        // The number may run into the name: N123456STRAIGHT_FEED.
        let name = head.trim_start_matches(|c: char| c.is_ascii_digit() || c.is_whitespace());
        let (number, name) = match name.strip_prefix('N') {
            Some(rest) if rest.starts_with(['.', '0', '1', '2', '3', '4', '5', '6', '7', '8', '9']) => {
                let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
                rest.split_at(end)
            }
            _ => ("", name),
        };
        if let Ok(number) = number.parse() {
            self.line = number;
        }
        let arguments = arguments.trim_end().trim_end_matches(')');
        self.call(self.line, name.trim(), arguments)
    }

    fn call(&mut self, line: u32, name: &str, arguments: &str) -> Result<(), Refusal> {
        match name {
            "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" => {
                let end = self.frame.to_machine(self.place(numbers(line, name, arguments)?));
                let pace = if name == "STRAIGHT_FEED" { self.pace() } else { Pace::Rapid };
                for axis in 3..6 {
                    if end[axis] != self.builder.at[axis] {
                        self.builder.first.rotary[axis - 3].get_or_insert(line);
                    }
                }
                self.builder.line_to(line, pace, self.keep_still(end), self.plane.normal())?;
                self.moved();
            }
            "STRAIGHT_PROBE" => {
                let end = self.frame.to_machine(self.place(numbers(line, name, arguments)?));
                let pace = self.pace();
                if self.builder.line_to(line, pace, self.keep_still(end), self.plane.normal())? {
                    self.builder.probe();
                }
                self.builder.notes.add(line, "G38", "moves to its end: --surface is for the built-in interpreter");
            }
            "ARC_FEED" => self.arc(line, numbers(line, name, arguments)?)?,
            "USE_LENGTH_UNITS" => {
                let unit = if arguments.contains("INCHES") { MM_PER_INCH } else { 1.0 };
                // The feed stays the same speed.
                self.feed *= self.mm_per_unit / unit;
                self.mm_per_unit = unit;
            }
            "SELECT_PLANE" => {
                self.plane = match arguments {
                    "CANON_PLANE_XY" => Plane::Xy,
                    "CANON_PLANE_XZ" => Plane::Zx,
                    "CANON_PLANE_YZ" => Plane::Yz,
                    _ => return Err(Refusal::new(line, format!("{name}({arguments})"), "a plane of X, Y and Z")),
                }
            }
            "SET_G5X_OFFSET" => {
                let [_, place @ ..] = numbers::<7>(line, name, arguments)?;
                self.frame.g5x = self.place(place);
            }
            "SET_G92_OFFSET" => self.frame.g92 = self.place(numbers(line, name, arguments)?),
            "SET_XY_ROTATION" => [self.frame.rotation_deg] = numbers(line, name, arguments)?,
            "USE_TOOL_LENGTH_OFFSET" => {
                let [x, y, z, a, b, c, ..] = numbers::<9>(line, name, arguments)?;
                self.frame.tool = self.place([x, y, z, a, b, c]);
            }
            "SET_FEED_RATE" => [self.feed] = numbers(line, name, arguments)?,
            "SET_FEED_MODE" => {
                let [_, mode] = numbers::<2>(line, name, arguments)?;
                if mode != 0.0 {
                    return Err(Refusal::new(line, "a feed per revolution (G95)", "G93 or G94"));
                }
            }
            "SET_MOTION_CONTROL_MODE" => self.exact_stop = arguments.contains("EXACT_STOP"),
            "PROGRAM_END" | "FINISH" => self.ended = true,
            "DWELL" | "PROGRAM_STOP" | "OPTIONAL_PROGRAM_STOP" | "CHANGE_TOOL" => {
                self.builder.stop();
                self.builder.notes.add(line, word(name), "the axes stop and continue at once");
            }
            "SET_NAIVECAM_TOLERANCE"
            | "SET_FEED_REFERENCE"
            | "ON_RESET"
            | "COMMENT"
            | "MESSAGE"
            | "LOG"
            | "PALLET_SHUTTLE"
            | "START_CHANGE"
            | "TURN_PROBE_ON"
            | "TURN_PROBE_OFF" => {}
            "NURBS_FEED" => {
                let needed = "a program without G5, G5.1 and G5.2: rs274 does not print their points (they run without \
                              --interpreter rs274)";
                return Err(Refusal::new(line, format!("{name}({arguments})"), needed));
            }
            "STOP_SPINDLE_TURNING" | "SET_SPINDLE_MODE" => {}
            _ if has_no_effect(name) => self.builder.notes.add(line, word(name), ""),
            _ => {
                return Err(Refusal::new(
                    line,
                    format!("{name}({arguments})"),
                    "lines and arcs of LinuxCNC's interpreter",
                ));
            }
        }
        Ok(())
    }

    /// Converts the lengths to mm.
    fn place(&self, place: [f64; 6]) -> [f64; 6] {
        std::array::from_fn(|k| if k < 3 { place[k] * self.mm_per_unit } else { place[k] })
    }

    fn pace(&self) -> Pace {
        Pace::PerMinute { mm: self.feed * self.mm_per_unit, degrees: self.feed }
    }

    fn keep_still(&self, end: [f64; 6]) -> [f64; 6] {
        std::array::from_fn(|k| {
            let at = self.builder.at[k];
            if (end[k] - at).abs() < 1.0e-9 { at } else { end[k] }
        })
    }

    fn moved(&mut self) {
        if self.exact_stop {
            self.builder.stop();
        }
    }

    /// First and second end, first and second axis of the centre, turns (the sign gives the sense), height, A, B, C.
    fn arc(&mut self, line: u32, [e1, e2, c1, c2, turns, height, a, b, c]: [f64; 9]) -> Result<(), Refusal> {
        if turns == 0.0 || turns.abs() > f64::from(MOST_TURNS) {
            return Err(Refusal::new(line, format!("an arc of {turns} turns"), format!("1 to {MOST_TURNS}")));
        }
        let [first, second, normal] = self.plane.axes();
        let mut end = [0.0, 0.0, 0.0, a, b, c];
        (end[first], end[second], end[normal]) = (e1, e2, height);
        let end = self.keep_still(self.frame.to_machine(self.place(end)));
        let mut center = [0.0; 6];
        (center[first], center[second], center[normal]) = (c1, c2, height);
        let [x, y, z, ..] = self.place(center);
        let turn = self.builder.turn_to([end[3], end[4], end[5]]);
        for axis in 0..3 {
            if turn.change[axis] != 0.0 {
                self.builder.first.rotary[axis].get_or_insert(line);
            }
        }
        let plane_normal = self.frame.direction(self.plane.normal());
        let curve = Curve::Arc {
            start: self.builder.point(),
            end: [end[0], end[1], end[2]],
            center: self.frame.point([x, y, z]),
            normal: plane_normal.map(|n| if turns < 0.0 { -n } else { n }),
            turns: turns.abs() as u32 - 1,
        };
        let pace = self.pace();
        self.builder.push(line, pace, curve, turn, plane_normal)?;
        self.moved();
        Ok(())
    }
}

/// The program's word for a call, where there is one.
fn word(call: &str) -> &str {
    match call {
        "SELECT_TOOL" => "T",
        "CHANGE_TOOL" => "M6",
        "DWELL" => "G4",
        "PROGRAM_STOP" => "M0",
        "OPTIONAL_PROGRAM_STOP" => "M1",
        "SET_SPINDLE_SPEED" => "S",
        "START_SPINDLE_CLOCKWISE" => "M3",
        "START_SPINDLE_COUNTERCLOCKWISE" => "M4",
        "MIST_ON" => "M7",
        "FLOOD_ON" => "M8",
        "MIST_OFF" | "FLOOD_OFF" => "M9",
        call => call,
    }
}

/// Calls that move no axis.
fn has_no_effect(name: &str) -> bool {
    [
        "SPINDLE",
        "COOLANT",
        "FLOOD",
        "MIST",
        "OVERRIDE",
        "SELECT_TOOL",
        "AUX_",
        "MOTION_OUTPUT",
        "TOOL_TABLE",
        "TOOL_NUMBER",
    ]
    .iter()
    .any(|part| name.contains(part))
}

/// Exactly `N` numbers, separated by commas and blanks.
fn numbers<const N: usize>(line: u32, name: &str, arguments: &str) -> Result<[f64; N], Refusal> {
    let mut numbers = [0.0; N];
    let mut words = arguments.split([',', ' ']).filter(|word| !word.is_empty());
    let complete = numbers.iter_mut().all(|number| {
        words.next().and_then(|word| word.parse::<f64>().ok()).filter(|value| value.is_finite()).is_some_and(|value| {
            *number = value;
            true
        })
    });
    if complete && words.next().is_none() {
        return Ok(numbers);
    }
    let letters: String = AXIS_LETTERS.iter().collect();
    Err(Refusal::new(line, format!("{name}({arguments})"), format!("{N} numbers (axes {letters})")))
}
