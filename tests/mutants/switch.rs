//! Selects the active mutant. The scratch copy of the core calls [`at`] at every place of a mutant.
//!
//! `MUTANT=site:variant` enables one; `MUTANT_COVER=file` writes the reached sites when the process ends.

use std::fs::OpenOptions;
use std::io::Write;
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};

const SITES: usize = 1 << 16;
const COVER: u8 = u8::MAX;

static STATE: [AtomicU8; SITES] = [const { AtomicU8::new(0) }; SITES];
static REACHED: [AtomicU8; SITES] = [const { AtomicU8::new(0) }; SITES];

/// The active variant at a site; 0 is the original code.
#[inline(always)]
pub fn at(site: usize) -> u8 {
    match STATE[site].load(Relaxed) {
        0 => 0,
        state => switched(site, state),
    }
}

#[cold]
#[inline(never)]
fn switched(site: usize, state: u8) -> u8 {
    if state != COVER {
        return state;
    }
    STATE[site].store(0, Relaxed);
    REACHED[site].store(1, Relaxed);
    0
}

unsafe extern "C" {
    fn atexit(call: extern "C" fn()) -> i32;
    fn setrlimit(resource: i32, limit: *const [u64; 2]) -> i32;
}

#[used]
#[unsafe(link_section = ".init_array")]
static START: extern "C" fn() = start;

/// A mutant that allocates without end is stopped before it fills the machine's memory.
const ADDRESS_SPACE: (i32, u64) = (9, 4 << 30);

extern "C" fn start() {
    if let Some((site, variant)) = std::env::var("MUTANT").ok().as_deref().and_then(|on| on.split_once(':')) {
        let site: usize = site.parse().expect("MUTANT: a number before the colon");
        STATE[site].store(variant.parse().expect("MUTANT: a number after the colon"), Relaxed);
        // SAFETY: the resource and the two numbers match the arguments of Linux's setrlimit.
        unsafe { setrlimit(ADDRESS_SPACE.0, &[ADDRESS_SPACE.1; 2]) };
    }
    if std::env::var_os("MUTANT_COVER").is_some() {
        STATE.iter().for_each(|state| state.store(COVER, Relaxed));
        // SAFETY: `report` takes no arguments and does not unwind.
        unsafe { atexit(report) };
    }
}

extern "C" fn report() {
    let sites = REACHED.iter().enumerate().filter(|(_, reached)| reached.load(Relaxed) != 0);
    let text: String = sites.map(|(site, _)| format!("{site}\n")).collect();
    let file =
        std::env::var_os("MUTANT_COVER").and_then(|path| OpenOptions::new().create(true).append(true).open(path).ok());
    if let Some(mut file) = file {
        let _ = file.write_all(text.as_bytes());
    }
}
