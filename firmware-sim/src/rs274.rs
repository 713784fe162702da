//! Runs a program through `rs274`, LinuxCNC's standalone interpreter.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use trueaxis_sim::program::canonical::Canonical;
use trueaxis_sim::program::{Program, ProgramError, ReadOptions, ToolTable, numbered};

/// Without an INI file `rs274` interprets tool table and parameters in inches.
const MM_PER_UNIT: f64 = 25.4;

/// Time limit: a program that loops forever is stopped.
const PATIENCE: Duration = Duration::from_secs(120);

/// Maximum length of an output line, bytes.
const LONGEST: u64 = 4096;

/// Reads a program through an installed `rs274`: with parameters, subprograms, cutter compensation; its output has four
/// decimals. `file` appears in errors only.
///
/// # Errors
/// `rs274` is missing, or refuses the program; the error gives the line.
pub fn read(name: &str, bytes: &[u8], file: &str, options: &ReadOptions) -> Result<Program, ProgramError> {
    let wrong = |line: u32, found: String, needed: &str| ProgramError::new(file, line, found, needed);
    let scratch = |e: std::io::Error| wrong(1, format!("no folder for temporary files ({e})"), "one");
    let folder = tempfile::tempdir().map_err(scratch)?;
    let path = |name: &str| folder.path().join(name);
    let program = numbered(bytes, file)?;
    std::fs::write(path("program.ngc"), &program).map_err(scratch)?;
    // A copy of the parameters, because rs274 rewrites them.
    let offsets = options.offsets.clone().unwrap_or_default();
    std::fs::write(path("offsets.var"), offsets.parameters(MM_PER_UNIT)).map_err(scratch)?;
    let tools = options.tools.clone().unwrap_or_else(|| ToolTable::without_lengths(&program));
    std::fs::write(path("tool.tbl"), tools.text(MM_PER_UNIT)).map_err(scratch)?;

    let mut command = Command::new("rs274");
    command.args(["-t", "tool.tbl", "-v", "offsets.var"]).args(options.block_delete.then_some("-b"));
    // rs274 keeps its tools in a file below HOME, which two instances would share.
    command.args(["-g", "program.ngc"]).current_dir(folder.path()).env("HOME", folder.path());
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(std::fs::File::create(path("errors")).map_err(scratch)?);
    let mut child = command.spawn().map_err(|e| {
        let needed = "LinuxCNC installed (Debian: linuxcnc-uspace), with rs274 on the search path";
        wrong(1, format!("no LinuxCNC interpreter ({e})"), needed)
    })?;
    let output = child.stdout.take();
    let child = Guarded::watch(child);
    let mut canonical = Canonical::new(file);
    if let Some(output) = output {
        let unread = |line, e| wrong(line, format!("no output of rs274 ({e})"), "its canonical output");
        take_all(BufReader::new(output), &mut canonical, unread)?;
    }
    let done = child.finish();
    if !done || !canonical.has_ended() {
        let errors = std::fs::read(path("errors")).unwrap_or_default();
        let (line, found) = refusal(&String::from_utf8_lossy(&errors), canonical.line(), done);
        return Err(wrong(line, found, "a program that its interpreter accepts"));
    }
    Ok(canonical.finish(name))
}

fn take_all(
    mut output: impl BufRead,
    canonical: &mut Canonical,
    unread: impl Fn(u32, std::io::Error) -> ProgramError,
) -> Result<(), ProgramError> {
    let mut text = Vec::new();
    loop {
        text.clear();
        let read = output.by_ref().take(LONGEST).read_until(b'\n', &mut text);
        if read.map_err(|e| unread(canonical.line(), e))? == 0 {
            return Ok(());
        }
        canonical.take(&String::from_utf8_lossy(&text))?;
    }
}

/// Line and reason of a refusal: `rs274` prints a message, then the line of the program.
fn refusal(errors: &str, last: u32, done: bool) -> (u32, String) {
    let mut said = errors.lines().map(str::trim).filter(|text| !text.is_empty() && *text != "executing");
    let message = said.next().unwrap_or(if done { "no end" } else { "no end in two minutes" });
    let line = said.find_map(|text| {
        let number = text.trim_start_matches('/').strip_prefix(['N', 'n'])?;
        number.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
    });
    (line.unwrap_or(last), format!("a program that LinuxCNC refuses: {message}"))
}

/// A child process that is killed when it exceeds the time limit or when dropped.
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

    /// Waits for the process to end; returns whether it ended within the time limit.
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
