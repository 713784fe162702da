//! The probing program in the dialect of its control.

use super::plan::{Plan, Step};
use super::sheet::sheet;
use super::task::{Dialect, Task};
use std::fmt::Write;
use trueaxis::machine::AXES;
use trueaxis_tables::Machine;
use trueaxis_tables::text::{counted, fixed};

const LETTERS: [char; AXES] = ['X', 'Y', 'Z', 'A', 'B', 'C'];

/// Replaces characters that not every control allows in a comment.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || " .,:+-_/=".contains(c) { c } else { '_' }).collect()
}

fn number(value: f64) -> String {
    let text = fixed(value, 4);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn words(values: impl IntoIterator<Item = (char, f64)>) -> String {
    values.into_iter().fold(String::new(), |mut text, (letter, value)| {
        let _ = write!(text, " {letter}{}", number(value));
        text
    })
}

/// Writes the program of a plan.
///
/// Positions are machine positions: LinuxCNC and grblHAL get a coordinate system with the machine's zero (G59.3) and no tool
/// length. Every probing move is one line, and the log states its number with its trip.
///
/// The program of a task with dials is the sheet for their readings.
pub fn program(task: &Task, machine: &Machine, plan: &Plan) -> String {
    if task.is_read() {
        return sheet(task, plan, None);
    }
    let mut text = String::new();
    let axes: Vec<usize> = machine.settings.axes.iter().map(|own| own.axis.index()).collect();
    let writer =
        Writer { dialect: task.dialect, feed: task.probe.feed_mm_per_min, probe: task.probe.probe_feed_mm_per_min };
    writer.head(&mut text, task, machine, plan, &axes);
    let mut at_rapid = false;
    for step in &plan.steps {
        match step {
            Step::Pause(what) => writer.pause(&mut text, what),
            Step::Remark(what) => writer.remark(&mut text, what),
            Step::Rapid(to) => {
                let given = to.iter().zip(LETTERS).filter_map(|(value, letter)| Some((letter, (*value)?)));
                let _ = writeln!(text, "G0{}", words(given));
                at_rapid = true;
            }
            Step::Feed([x, y, z]) => {
                let feed = if at_rapid { format!(" F{}", number(writer.feed)) } else { String::new() };
                let _ = writeln!(text, "G1{}{feed}", words([('X', *x), ('Y', *y), ('Z', *z)]));
                at_rapid = false;
            }
            Step::Probe(touch) => {
                let [x, y, z, ..] = plan.touches[*touch].end;
                writer.touch(&mut text, touch + 1, [x, y, z], &axes);
                // The next move must state its feed.
                at_rapid = true;
            }
        }
    }
    writer.tail(&mut text, plan);
    text
}

struct Writer {
    dialect: Dialect,
    feed: f64,
    probe: f64,
}

impl Writer {
    fn head(&self, text: &mut String, task: &Task, machine: &Machine, plan: &Plan, axes: &[usize]) {
        let (number, count) = (plan.number(), plan.touches.len());
        let minutes = counted(plan.minutes().ceil() as usize, "minute");
        let title = format!(
            "trueaxis probing program for {}, tip radius {} mm, {count} touches, about {minutes}",
            machine.settings.name, task.probe.tip_radius_mm
        );
        let started = format!("trueaxis calibrate {number} touches {count}");
        if self.dialect == Dialect::Klipper {
            let _ = writeln!(text, "; {}\n; needs [pause_resume] and [trueaxis_probe]", plain(&title));
            let _ = writeln!(text, "TRUEAXIS_NOTE MSG=\"{started}\"\nG21\nG90");
            return;
        }
        let zero = words(axes.iter().map(|axis| (LETTERS[*axis], 0.0)));
        let _ = writeln!(text, "({})", plain(&title));
        text.push_str("G17 G21 G40 G49 G80 G90 G94\n");
        let _ = writeln!(text, "G10 L2 P9{zero} R0 (G59.3: the machine's own zero)\nG59.3\nG92.2");
        match self.dialect {
            Dialect::LinuxCnc => {
                let _ = writeln!(text, "(LOGOPEN,trueaxis-{number}.log)\n(LOG,{started})");
            }
            _ => {
                let _ = writeln!(text, "(MSG,{started})");
            }
        }
    }

    fn pause(&self, text: &mut String, what: &str) {
        let what = plain(what);
        let _ = match self.dialect {
            Dialect::Klipper => writeln!(text, "TRUEAXIS_NOTE MSG=\"{what}, then RESUME\"\nPAUSE"),
            _ => writeln!(text, "(MSG,{what})\nM0"),
        };
    }

    fn remark(&self, text: &mut String, what: &str) {
        let what = plain(what);
        let _ = match self.dialect {
            Dialect::Klipper => writeln!(text, "; {what}"),
            _ => writeln!(text, "({what})"),
        };
    }

    fn touch(&self, text: &mut String, id: usize, [x, y, z]: [f64; 3], axes: &[usize]) {
        let to = words([('X', x), ('Y', y), ('Z', z)]);
        let feed = number(self.probe);
        let _ = match self.dialect {
            Dialect::LinuxCnc => {
                let position = (0..AXES).fold(String::new(), |all, axis| {
                    // Axes that the machine lacks are 0 in the log.
                    if axes.contains(&axis) { format!("{all} #{}", 5061 + axis) } else { format!("{all} 0") }
                });
                writeln!(text, "G38.2{to} F{feed}\n(LOG,touch {id}{position} #5070)")
            }
            Dialect::GrblHal => writeln!(text, "(MSG,touch {id})\nG38.2{to} F{feed}"),
            Dialect::Klipper => {
                let to = to.replace(" X", " X=").replace(" Y", " Y=").replace(" Z", " Z=");
                writeln!(text, "TRUEAXIS_PROBE ID={id}{to} F={feed}")
            }
        };
    }

    fn tail(&self, text: &mut String, plan: &Plan) {
        let ended = format!("trueaxis end {}", plan.number());
        let _ = match self.dialect {
            Dialect::LinuxCnc => writeln!(text, "(LOG,{ended})\n(LOGCLOSE)\nM2"),
            Dialect::GrblHal => writeln!(text, "(MSG,{ended})\nM2"),
            Dialect::Klipper => writeln!(text, "TRUEAXIS_NOTE MSG=\"{ended}\""),
        };
    }
}
