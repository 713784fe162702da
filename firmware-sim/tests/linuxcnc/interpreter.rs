//! Parameters, expressions, loops and subprograms against `rs274`: programs that use each construct, and random ones.

use super::{agree_within, installed, steps};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use trueaxis_sim::program::{Curve, Move, Program, ReadOptions};
use trueaxis_testing::noise::Noise;

const PROGRAMS: [&str; 8] = [
    "expressions.ngc",
    "parameters.ngc",
    "loops.ngc",
    "subprograms.ngc",
    "fanuc.ngc",
    "modes.ngc",
    "polar.ngc",
    "splines.ngc",
];

/// In mm `rs274` prints to half of this.
const TOLERANCE: f64 = 1.0e-4;

/// Shorter lines are not compared: their ends may be printed as one point, mm.
const SHORT: f64 = 5.0e-4;

const RANDOM: u64 = 300;

fn programs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs")
}

/// What `rs274` prints of a program in a folder.
fn printed(folder: &Path, name: &str) -> String {
    let home = tempfile::tempdir().unwrap();
    let mut command = Command::new("rs274");
    let output = command.current_dir(folder).env("HOME", home.path()).args(["-g", name]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("PROGRAM_END"), "{name}: {}\n{text}", String::from_utf8_lossy(&output.stderr));
    text
}

fn compare(folder: &Path, name: &str) -> usize {
    let path = folder.join(name);
    let bytes = std::fs::read(&path).unwrap();
    let program = Program::read(name, &bytes, name, &ReadOptions::default().beside(&path)).unwrap();
    let is_compared = |element: &Move| match &element.curve {
        Curve::Line { start, end } => {
            let far = |(a, b): (&f64, &f64)| (a - b).abs() > SHORT;
            start.iter().zip(end).any(far) || element.turn.change.iter().any(|by| by.abs() > SHORT)
        }
        curve => !matches!(curve, Curve::Nurbs { .. }),
    };
    let moves: Vec<_> = program.moves.into_iter().filter(is_compared).collect();
    let steps = steps(&printed(folder, name), SHORT);
    agree_within(name, &moves, &steps, TOLERANCE);
    moves.len()
}

#[test]
fn each_construct_goes_where_linuxcnc_goes() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(programs()).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
    }
    for name in PROGRAMS {
        assert!(compare(folder.path(), name) > 3, "{name}");
    }
}

#[test]
fn random_programs_go_where_linuxcnc_goes() {
    // Half a minute of the LinuxCNC suite.
    if std::env::var_os("TRUEAXIS_LINUXCNC").is_none() || !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (mut moves, mut compared, mut amplifying) = (0, 0, Vec::new());
    for seed in 0_u64.. {
        if compared == RANDOM {
            break;
        }
        let name = format!("random-{seed}.ngc");
        let text = Author::new(seed).program();
        if amplifies(&text) {
            amplifying.push(seed);
            continue;
        }
        std::fs::write(folder.path().join(&name), &text).unwrap();
        println!("{name}\n{text}");
        moves += compare(folder.path(), &name);
        compared += 1;
    }
    println!("{moves} moves of {compared} programs; {} amplify: {amplifying:?}", amplifying.len());
    assert!(moves > 10_000 && amplifying.len() < 60, "{moves} moves, {amplifying:?} amplify");
}

/// Whether a program makes a rounding larger than the tolerance, in its loops or by a value that is whole but for its last bits:
/// in such a program end points of `rs274` itself move by 1.6 µm where 1e-13 is added to a parameter. Every bounded value is
/// changed by some hundred times its last bit, up and down.
fn amplifies(text: &str) -> bool {
    let moves = |text: &str| Program::parse("random", text, "random.ngc").unwrap().moves;
    let plain = moves(text);
    let far = |(one, other): (&Move, &Move)| {
        let end = |element: &Move| element.curve.position(element.curve.domain().1);
        end(one).iter().zip(end(other)).any(|(one, other)| (one - other).abs() > 0.1 * TOLERANCE)
    };
    ["[0.0000000000002 + 20 * sin[", "[-0.0000000000002 + 20 * sin["].iter().any(|by| {
        let changed = moves(&text.replace("[20 * sin[", by));
        plain.len() != changed.len() || plain.iter().zip(&changed).any(far)
    })
}

/// Writes random programs that LinuxCNC accepts.
struct Author {
    noise: Noise,
    text: String,
    label: u32,
    /// After a break out of a while loop, LinuxCNC leaves the next do loop after its first turn, against its documentation: a
    /// program has the one or the other.
    breaks: bool,
    indent: usize,
}

impl Author {
    fn new(seed: u64) -> Author {
        let mut noise = Noise::new(seed);
        let breaks = noise.below(2) == 0;
        Author { noise, text: String::new(), label: 200, breaks, indent: 0 }
    }

    fn line(&mut self, text: &str) {
        let _ = writeln!(self.text, "{}{text}", "  ".repeat(self.indent));
    }

    fn pick<'a>(&mut self, from: &[&'a str]) -> &'a str {
        from[self.noise.below(from.len())]
    }

    fn number(&mut self) -> String {
        format!("{:.3}", self.noise.range(-9.0, 9.0))
    }

    fn label(&mut self) -> u32 {
        self.label += 1;
        self.label
    }

    fn value(&mut self, depth: u32) -> String {
        if depth == 0 || self.noise.below(4) == 0 {
            return match self.noise.below(3) {
                0 => self.number(),
                1 => format!("#{}", self.noise.range(1.0, 6.0) as u32),
                _ => self.pick(&["#<a>", "#<_g>", "#31", "#<b c>"]).to_owned(),
            };
        }
        let (one, other) = (self.value(depth - 1), self.value(depth - 1));
        match self.noise.below(14) {
            0..=3 => format!("[{one} {} {other}]", self.pick(&["+", "-", "*"])),
            4 => format!("[{one} / [abs[{other}]+1]]"),
            5 => format!("[{one} mod [abs[{other}]+2]]"),
            6 => format!("[[abs[{one}]+1] ** [{other} / [abs[{other}]+1]]]"),
            7 => format!("[{one} {} {other}]", self.pick(&["EQ", "NE", "GT", "GE", "LT", "LE", "AND", "OR", "XOR"])),
            8 => format!("atan[{one}]/[{other}]"),
            9 => format!("{}[{one}]", self.pick(&["sin", "cos", "fix", "fup", "round", "abs"])),
            10 => format!("{}[abs[{one}]+1]", self.pick(&["sqrt", "ln"])),
            11 => format!("{}[sin[{one}]]", self.pick(&["acos", "asin", "exp"])),
            12 => format!("-{one}"),
            _ => format!(
                "[{one} {} {other} {} {}]",
                self.pick(&["+", "-", "GT", "OR"]),
                self.pick(&["*", "-"]),
                self.number()
            ),
        }
    }

    /// A value that leaves room in LinuxCNC's lines of 255 bytes.
    fn short(&mut self, depth: u32) -> String {
        loop {
            let value = self.value(depth);
            if value.len() <= 90 {
                return value;
            }
        }
    }

    /// A value within ±20, continuous, so that a rounding does not change it by 40.
    fn bounded(&mut self) -> String {
        format!("[20 * sin[{}]]", self.short(2))
    }

    fn statement(&mut self, depth: u32, main: bool) {
        match self.noise.below(if depth > 0 { 15 } else { 9 }) {
            0 => {
                let place = self.pick(&["#1", "#2", "#3", "#4", "#5", "#31", "#<a>", "#<_g>", "#<b c>"]);
                let value = self.bounded();
                self.line(&format!("{place}={value}"));
            }
            1 | 2 => {
                let (word, x, y) = (self.pick(&["G0", "G1", "G1"]), self.bounded(), self.bounded());
                let z = if self.noise.below(3) == 0 { format!(" Z{}", self.number()) } else { String::new() };
                self.line(&format!("{word} X{x} Y{y}{z}"));
            }
            3 => {
                let (i, j, turns) = (self.noise.range(1.0, 5.0), self.bounded(), 1 + self.noise.below(3));
                let word = self.pick(&["G2", "G3"]);
                self.line(&format!("{word} I{i:.3} J{j} P{turns}"));
            }
            4 => {
                let (dx, dy, r) = (self.noise.range(1.0, 4.0), self.noise.range(-3.0, 3.0), self.noise.range(5.0, 9.0));
                let word = self.pick(&["G2", "G3"]);
                self.line(&format!("{word} X[#5420+{dx:.3}] Y[#<_y>+{dy:.3}] R{r:.3}"));
            }
            5 => {
                let (radius, angle) = (self.value(1), self.bounded());
                self.line(&format!("G1 @[abs[{radius}] mod 30 + 1]^{angle}"));
            }
            6 => {
                let x = self.bounded();
                self.line("M70");
                self.line(&format!("G91 G1 X{x} F[100+abs[#1]]"));
                self.line("M72");
            }
            7 => {
                let (x, y) = (self.number(), self.number());
                self.line(&format!("G53 G0 X{x} Y{y}"));
                self.line(&format!("G92 X{y}"));
                self.line("G1 X[#5420+1] Y[#5421]");
                self.line("G92.1");
            }
            8 if main => {
                let arguments: Vec<_> = (0..self.noise.below(4)).map(|_| self.bounded()).collect();
                // Two of the longest fit in a line.
                let arguments = &arguments[..arguments.len().min(if arguments.concat().len() > 200 { 2 } else { 3 })];
                let name = self.pick(&["o100", "o<one>", "o[99+1]"]);
                self.line(&format!("{name} call {}", arguments.join(" ")));
                self.line("G1 X[#<_value>] Y[#<_value_returned>]");
            }
            8 => self.line("G1 X[#1+1] Y#2"),
            kind => self.block(kind, depth - 1, main),
        }
    }

    fn body(&mut self, depth: u32, main: bool) {
        self.indent += 1;
        for _ in 0..=self.noise.below(3) {
            self.statement(depth, main);
        }
        self.indent -= 1;
    }

    fn block(&mut self, kind: usize, depth: u32, main: bool) {
        let (label, count) = (self.label(), 1 + self.noise.below(4));
        match kind {
            9 | 10 => {
                let value = self.short(2);
                self.line(&format!("o{label} if [{value} GT 0.5]"));
                self.body(depth, main);
                if self.noise.below(2) == 0 {
                    let value = self.value(1);
                    self.line(&format!("o{label} elseif [{value} LE 1.5]"));
                    self.body(depth, main);
                }
                if self.noise.below(2) == 0 {
                    self.line(&format!("o{label} else"));
                    self.body(depth, main);
                }
                self.line(&format!("o{label} endif"));
            }
            11 => {
                self.line(&format!("o{label} repeat [{count}.3]"));
                self.body(depth, main);
                self.line(&format!("o{label} endrepeat"));
            }
            12 if !self.breaks => {
                self.line(&format!("#{label}=0"));
                self.line(&format!("o{label} do"));
                self.body(depth, main);
                self.line(&format!("  #{label}=[#{label}+1]"));
                self.line(&format!("o{label} while [#{label} LT {count}]"));
            }
            _ => {
                self.line(&format!("#{label}=0"));
                self.line(&format!("o{label} while [#{label} LT {count}]"));
                self.line(&format!("  #{label}=[#{label}+1]"));
                self.body(depth, main);
                if self.breaks {
                    let (inner, word, value) = (self.label(), self.pick(&["break", "continue"]), self.value(1));
                    self.line(&format!("  o{inner} if [{value} GT 2.5]"));
                    self.line(&format!("    o{label} {word}"));
                    self.line(&format!("  o{inner} endif"));
                    self.body(depth, main);
                }
                self.line(&format!("o{label} endwhile"));
            }
        }
    }

    fn subprogram(&mut self, name: &str) {
        let (value, label) = (self.bounded(), self.label());
        self.line(&format!("{name} sub"));
        self.line("  #<a>=#1 #<b c>=[#2+1]");
        self.body(2, false);
        self.line(&format!("  o{label} if [#3 GT 1.5]"));
        self.line(&format!("    {name} return"));
        self.line(&format!("  o{label} endif"));
        self.body(1, false);
        self.line(&format!("{name} endsub {value}"));
    }

    fn program(mut self) -> String {
        self.line("G21 G90 G17 F500");
        self.subprogram("o100");
        self.subprogram("o<one>");
        for number in 1..6 {
            let value = self.number();
            self.line(&format!("#{number}={value}"));
        }
        self.line("#<a>=1.25 #<_g>=-3.5 #<b c>=7.75 #31=0.375");
        for _ in 0..12 {
            self.statement(3, true);
        }
        self.line("M2");
        self.text
    }
}
