//! Runs a program through `rs274`, LinuxCNC's own interpreter.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::ReadOptions;
use super::builder::Builder;
use super::canonical::Canonical;
use super::error::Refusal;
use super::text;

/// Without an INI file `rs274` takes tool table and parameters for inches.
const MM_PER_UNIT: f64 = 25.4;

/// So long it may take: a program that loops for ever is ended.
const PATIENCE: Duration = Duration::from_secs(120);

/// Longest line of its output, bytes.
const LONGEST: u64 = 4096;

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Builder, Refusal> {
    let scratch = |e: std::io::Error| Refusal::new(1, format!("no place for scratch files ({e})"), "a folder for them");
    let folder = tempfile::tempdir().map_err(scratch)?;
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("program.ngc"), numbered(bytes)?).map_err(scratch)?;
    // A copy of the parameters: rs274 writes them anew.
    let offsets = options.offsets.clone().unwrap_or_default();
    std::fs::write(file("offsets.var"), offsets.parameters(MM_PER_UNIT)).map_err(scratch)?;
    let tools = options.tools.clone().unwrap_or_default();
    std::fs::write(file("tool.tbl"), tools.text(MM_PER_UNIT)).map_err(scratch)?;

    let mut command = Command::new("rs274");
    command.args(["-t", "tool.tbl", "-v", "offsets.var"]).args(options.block_delete.then_some("-b"));
    // It keeps its tools in a file below HOME, which two of it would share.
    command.args(["-g", "program.ngc"]).current_dir(folder.path()).env("HOME", folder.path());
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(std::fs::File::create(file("errors")).map_err(scratch)?);
    let mut child = command.spawn().map_err(|e| {
        let needed = "LinuxCNC installed (Debian: linuxcnc-uspace), with rs274 on the search path";
        Refusal::new(1, format!("no LinuxCNC interpreter ({e})"), needed)
    })?;
    let output = child.stdout.take();
    let child = Guarded::watch(child);
    let mut canonical = Canonical::new();
    let mut line = 1;
    if let Some(output) = output {
        take_all(BufReader::new(output), &mut canonical, &mut line)?;
    }
    let done = child.finish();
    if !done || !canonical.ended {
        let errors = std::fs::read(file("errors")).unwrap_or_default();
        return Err(refusal(&String::from_utf8_lossy(&errors), line, done));
    }
    canonical.builder.notes.add(1, "--interpreter rs274", "coordinates are rounded to four decimals");
    Ok(canonical.builder)
}

fn take_all(mut output: impl BufRead, canonical: &mut Canonical, line: &mut u32) -> Result<(), Refusal> {
    let mut text = Vec::new();
    loop {
        text.clear();
        let read = output.by_ref().take(LONGEST).read_until(b'\n', &mut text);
        if read.map_err(|e| Refusal::new(*line, format!("no output of rs274 ({e})"), "its canonical output"))? == 0 {
            return Ok(());
        }
        if !canonical.ended {
            canonical.take(&String::from_utf8_lossy(&text), line)?;
        }
    }
}

/// The program with every line numbered by N as in the file, so that errors find their line, and without comments: those of
/// LinuxCNC can write files.
fn numbered(bytes: &[u8]) -> Result<String, Refusal> {
    let mut program = String::new();
    let mut text = String::new();
    let mut ends = false;
    for (line, bytes) in text::lines(bytes) {
        match text::clean(line, bytes, &mut text) {
            Err(refusal) if !ends => return Err(refusal),
            // Behind the end anything may stand; subprograms too.
            Err(_) => text.clear(),
            Ok(()) => {}
        }
        let (slash, rest) = match text.strip_prefix('/') {
            Some(rest) => ("/", rest),
            None => ("", text.as_str()),
        };
        let own_number = rest.strip_prefix('N').map(|r| r.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.'));
        let words = own_number.unwrap_or(rest);
        ends |= words.split('M').skip(1).any(|word| {
            let number = word.trim_start_matches('0');
            let digits = number.find(|c: char| !c.is_ascii_digit()).unwrap_or(number.len());
            matches!(number.get(..digits), Some("2" | "30"))
        });
        if words.is_empty() || words.starts_with(['%', 'O']) {
            program += words;
        } else {
            program += &format!("{slash}N{line} {words}");
        }
        program.push('\n');
    }
    // Own programs may end without a word; rs274 wants one.
    if !ends && !program.trim_start().starts_with('%') {
        program += "M2\n";
    }
    Ok(program)
}

/// What `rs274` says: a line of text, then the line of the program.
fn refusal(errors: &str, last: u32, done: bool) -> Refusal {
    let mut said = errors.lines().map(str::trim).filter(|text| !text.is_empty() && *text != "executing");
    let message = said.next().unwrap_or(if done { "no end" } else { "no end in two minutes" });
    let line = said.find_map(|text| {
        let number = text.trim_start_matches('/').strip_prefix(['N', 'n'])?;
        number.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
    });
    Refusal::new(
        line.unwrap_or(last),
        format!("what LinuxCNC refuses: {message}"),
        "a program that its interpreter takes",
    )
}

/// A child that is ended when it takes too long, or when nobody waits for it any more.
struct Guarded {
    child: Arc<Mutex<Child>>,
    began: Instant,
}

impl Guarded {
    fn watch(child: Child) -> Guarded {
        let child = Arc::new(Mutex::new(child));
        let watched = Arc::downgrade(&child);
        let began = Instant::now();
        std::thread::spawn(move || {
            while began.elapsed() < PATIENCE {
                std::thread::sleep(Duration::from_millis(50));
                if watched.strong_count() == 0 {
                    return;
                }
            }
            if let Some(child) = watched.upgrade() {
                let _ = child.lock().unwrap_or_else(PoisonError::into_inner).kill();
            }
        });
        Guarded { child, began }
    }

    /// Waits for its end; whether it came by itself.
    fn finish(self) -> bool {
        let status = self.child.lock().unwrap_or_else(PoisonError::into_inner).wait();
        status.is_ok() && self.began.elapsed() < PATIENCE
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        let mut child = self.child.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = child.kill();
        let _ = child.wait();
    }
}
