//! Runs the commands shown in the documentation and compares their output with the output shown.
//!
//! A block indented by four spaces begins with commands after `$`; the rest of it is the output of the last command, in which
//! a line `…` matches any lines. With the environment variable `UPDATE_DOCS` set, changed figures are written into the file;
//! any other change must be made by hand.

use std::ops::Range;
use std::path::Path;
use std::process::Command;

const INDENT: &str = "    ";
const ANY: &str = "…";

/// Runs the commands of one program shown in a file of the repository `root`. `program` is its path; `shown` selects its
/// commands.
///
/// # Panics
/// The printed output differs from the file.
pub(crate) fn check(root: &Path, file: &str, program: &Path, shown: impl Fn(&str) -> bool) {
    let path = root.join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(root.join("compensation-tables"), folder.path().join("compensation-tables")).unwrap();
    let name = program.file_name().unwrap().to_string_lossy();
    let (mut run, mut wrong) = (0, Vec::new());
    for block in blocks(&lines) {
        let (commands, output) = parts(&lines, block);
        let ours = |command: &String| command.starts_with(&format!("{name} ")) || command.starts_with("printf ");
        if !commands.iter().all(ours) || !commands.last().is_some_and(|last| shown(last)) || output.is_empty() {
            continue;
        }
        let mut last = Vec::new();
        for command in &commands {
            last = printed(command, program, folder.path());
        }
        run += 1;
        wrong.extend(compare(&mut lines, output, &last).into_iter().map(|line| format!("{file}:{line}")));
    }
    assert!(run > 0, "{file} shows nothing of {name}");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, lines.join("\n") + "\n").unwrap();
    } else {
        assert!(wrong.is_empty(), "not as printed (UPDATE_DOCS=1 rewrites the figures):\n{}", wrong.join("\n"));
    }
}

/// The blocks that begin with a command.
fn blocks(lines: &[String]) -> Vec<Range<usize>> {
    let mut blocks = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        if !lines[at].starts_with("    $ ") {
            at += 1;
            continue;
        }
        // Blank lines inside a block are not indented.
        let inside = |i: usize| {
            let next = lines[i..].iter().find(|line| !line.is_empty());
            next.is_some_and(|line| line.starts_with(INDENT))
        };
        let end = (at..lines.len()).find(|&i| !inside(i)).unwrap_or(lines.len());
        blocks.push(at..end);
        at = end;
    }
    blocks
}

/// The commands of a block, and the range of their output lines.
fn parts(lines: &[String], block: Range<usize>) -> (Vec<String>, Range<usize>) {
    let (mut commands, mut open) = (Vec::<String>::new(), false);
    let mut end = block.start;
    for line in &lines[block.clone()] {
        let text = line.strip_prefix(INDENT).unwrap_or_default();
        match text.strip_prefix("$ ") {
            Some(command) => commands.push(command.trim_end_matches('\\').to_owned()),
            None if open => commands.last_mut().unwrap().push_str(text.trim_end_matches('\\')),
            None => break,
        }
        open = text.ends_with('\\');
        end += 1;
    }
    (commands, end..block.end)
}

fn printed(command: &str, program: &Path, folder: &Path) -> Vec<String> {
    let path = format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap_or_default());
    let output = Command::new("sh").args(["-c", command]).current_dir(folder).env("PATH", path).output().unwrap();
    assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(|line| line.trim_end().to_owned()).collect()
}

/// A line without its figures.
fn frame(line: &str) -> String {
    let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '−' | '+');
    line.split(|c: char| digits(c) || c == ' ').filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Replaces the shown output by the printed output; returns the lines that differed.
fn compare(lines: &mut [String], output: Range<usize>, printed: &[String]) -> Vec<String> {
    let shown: Vec<String> =
        lines[output.clone()].iter().map(|line| line.strip_prefix(INDENT).unwrap_or_default().to_owned()).collect();
    let (mut wrong, mut at, mut first) = (Vec::new(), 0, 0);
    for piece in shown.split(|line| line == ANY) {
        let fits = |start: usize| {
            let there = printed.get(start..start + piece.len());
            there.is_some_and(|there| there.iter().zip(piece).all(|(a, b)| frame(a) == frame(b)))
        };
        let last = first + piece.len() == shown.len();
        let found = if first == 0 { fits(0).then_some(0) } else { (at..=printed.len()).find(|&start| fits(start)) };
        let Some(start) = found.filter(|start| !last || piece.is_empty() || start + piece.len() == printed.len())
        else {
            wrong.push(format!("{}: these lines are not printed:\n{}", output.start + first + 1, piece.join("\n")));
            return wrong;
        };
        for (i, now) in printed[start..start + piece.len()].iter().enumerate() {
            let number = output.start + first + i;
            if shown[first + i] != *now {
                wrong.push(format!("{}:\n  shown   {}\n  printed {now}", number + 1, shown[first + i]));
                lines[number] = if now.is_empty() { String::new() } else { format!("{INDENT}{now}") };
            }
        }
        at = start + piece.len();
        first += piece.len() + 1;
    }
    wrong
}
