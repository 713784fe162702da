//! Replay of a recording in the bare-metal image, under QEMU.

use anyhow::{Context, Result, anyhow, bail};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use trueaxis_tables::output::Outputs;

/// Address and size of a region that is flashed separately from the image.
const TABLES_A: (u64, u64) = (0x0011_0000, 0x3_0000);
const TABLES_B: (u64, u64) = (0x0014_0000, 0x3_8000);
/// Address and size of the region for thermal growth and its readings, bytes.
pub(super) const WARMING: (u64, u64) = (0x0017_8000, 0x0_8000);
/// Address and size of the region for the recording, bytes.
pub const RECORDING: (u64, u64) = (0x0018_0000, 0x28_0000);

/// A core with the QEMU board that provides it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Core {
    /// Cortex-M4F, single precision.
    M4f,
    /// Cortex-M7, double precision.
    M7,
}

impl Core {
    /// Name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Core::M4f => "m4f",
            Core::M7 => "m7",
        }
    }

    /// Title in reports.
    pub fn title(self) -> &'static str {
        match self {
            Core::M4f => "Cortex-M4F, single precision",
            Core::M7 => "Cortex-M7, double precision",
        }
    }

    fn board(self) -> [&'static str; 4] {
        match self {
            Core::M4f => ["-M", "mps2-an386", "-cpu", "cortex-m4"],
            Core::M7 => ["-M", "mps2-an500", "-cpu", "cortex-m7"],
        }
    }
}

/// Files that are loaded into the image's flash.
#[derive(Clone, Debug)]
pub struct Flash {
    /// Compiled tables.
    pub tables: PathBuf,
    /// Tables that the recording requests in motion.
    pub second: Option<PathBuf>,
    /// Thermal growth with sensor readings.
    pub warming: Option<PathBuf>,
    /// The recording.
    pub recording: PathBuf,
}

/// Data sent by the image.
#[derive(Clone, Debug)]
pub struct Sent {
    /// Telemetry: COBS frames.
    pub frames: Vec<u8>,
    /// Outputs of the step, byte for byte.
    pub outputs: Vec<u8>,
    /// Wall time.
    pub took: Duration,
}

/// Output files of a run: telemetry, outputs, log.
pub(super) const FILES: [&str; 3] = ["frames.bin", "outputs.bin", "defmt.bin"];

/// Time limit of a run; a longer one counts as hung.
const PATIENCE: Duration = Duration::from_secs(300);

/// Runs an image to its end; afterwards `folder` holds its output: frames.bin, outputs.bin and its log, defmt.bin.
///
/// QEMU writes to a scratch folder, so the files in `folder` are complete even if the image failed.
///
/// # Errors
/// QEMU is missing or fails, a file does not fit into its region, or the image does not end with success.
pub fn run(core: Core, elf: &Path, flash: &Flash, folder: &Path) -> Result<Sent> {
    let scratch = tempfile::tempdir().context("no folder for temporary files")?;
    let exit = emulated(core, elf, flash, scratch.path());
    let mut outputs = Outputs::default();
    outputs.folder(folder)?;
    for name in FILES {
        if let Ok(bytes) = std::fs::read(scratch.path().join(name)) {
            outputs.put(&folder.join(name), &bytes)?;
        }
    }
    outputs.commit()?;
    let (exit, took) = exit?;
    let [frames, outputs, log] = FILES.map(|name| folder.join(name));
    if exit != Some(0) {
        let code = exit.map_or("none: ended by a signal".to_owned(), |code| code.to_string());
        bail!(
            "{}: found exit code {code}, needed 0; the image's log is {} (defmt-print -e ELF)",
            elf.display(),
            log.display()
        );
    }
    let read = |path: &Path| std::fs::read(path).with_context(|| format!("cannot read {}", path.display()));
    Ok(Sent { frames: read(&frames)?, outputs: read(&outputs)?, took })
}

/// Exit code and wall time of an image whose output QEMU writes to a folder.
fn emulated(core: Core, elf: &Path, flash: &Flash, scratch: &Path) -> Result<(Option<i32>, Duration)> {
    let [frames, outputs, log] = FILES.map(|name| scratch.join(name));
    let mut command = Command::new("qemu-system-arm");
    command.args(core.board()).args(["-nographic", "-monitor", "none"]);
    command.args(["-icount", "shift=7,align=off,sleep=off", "-semihosting-config", "enable=on,target=native"]);
    for file in [&frames, &outputs] {
        command.arg("-serial").arg(option("file:", file, "")?);
    }
    command.arg("-kernel").arg(elf);
    let regions = [
        (Some(&flash.tables), TABLES_A),
        (flash.second.as_ref(), TABLES_B),
        (flash.warming.as_ref(), WARMING),
        (Some(&flash.recording), RECORDING),
    ];
    for (file, (address, room)) in regions {
        let Some(file) = file else { continue };
        let length = std::fs::metadata(file).with_context(|| format!("cannot read {}", file.display()))?.len();
        if length > room {
            bail!(
                "{}: found {length} bytes, needed at most {room} (fewer cycles: --cycles, --rate-hz)",
                file.display()
            );
        }
        command.arg("-device").arg(option("loader,file=", file, &format!(",addr={address:#x},force-raw=on"))?);
    }
    let file = std::fs::File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
    command.stdin(Stdio::null()).stdout(file);
    let started = Instant::now();
    let mut child = command.spawn().map_err(|error| {
        anyhow!("qemu-system-arm: {error}; needed QEMU with the Arm boards (Debian: apt-get install qemu-system-arm)")
    })?;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok((status.code(), started.elapsed()));
        }
        if started.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            bail!("{}: found no end of the run after {} s", elf.display(), PATIENCE.as_secs());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// QEMU separates options by commas; a comma in a file name is doubled.
fn option(before: &str, path: &Path, behind: &str) -> Result<String> {
    let path = path.to_str().ok_or_else(|| anyhow!("{}: found a name that is not UTF-8", path.display()))?;
    Ok(format!("{before}{}{behind}", path.replace(',', ",,")))
}

/// Path of the image's package in this source tree.
pub fn package() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/cortex-m"))
}

/// Builds the image of a core into `target` with cargo; returns the path of the ELF file.
///
/// # Errors
/// cargo or the target thumbv7em-none-eabihf is missing, or the build fails.
pub fn build(core: Core, target: &Path) -> Result<PathBuf> {
    let mut command = Command::new("cargo");
    command.current_dir(package()).args(["build", "--release", "--quiet", "--bin", "image"]);
    command.arg("--target-dir").arg(target).env_remove("RUSTFLAGS").stdin(Stdio::null());
    if core == Core::M7 {
        command.args(["--features", "double"]);
        command.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS", "-Ctarget-cpu=cortex-m7");
    }
    let status = command.status().context("cargo cannot be run; give built images with --image-m4f and --image-m7")?;
    if !status.success() {
        bail!("the image for {} does not build (rustup target add thumbv7em-none-eabihf?)", core.title());
    }
    Ok(target.join("thumbv7em-none-eabihf/release/image"))
}
