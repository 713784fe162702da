//! Data flashed separately from the image: tables, thermal growth and a recording, each in its region (`memory.x`).

use core::ptr::addr_of;

unsafe extern "C" {
    static _tables_a: u8;
    static _tables_b: u8;
    static _warming: u8;
    static _recording: u8;
    static _regions_end: u8;
    static _request: [u32; 2];
}

/// A single cycle to be run, after the preceding cycles that it depends on.
#[derive(Clone, Copy, Debug)]
pub enum Request {
    /// A cycle of the recording.
    Recorded(u32),
    /// One of the adversarial cycles.
    Adversarial(u32),
    /// Number of climbs to a dearer cycle.
    Climbs(u32),
}

/// The request at the very end of the recording's region: kind 1 to 3, and a number; `None` if both are zero.
pub fn request() -> Option<Request> {
    // SAFETY: two words of the board's memory (memory.x), which nothing writes while the image runs.
    let [kind, number] = unsafe { addr_of!(_request).read_volatile() };
    match kind {
        1 => Some(Request::Recorded(number)),
        2 => Some(Request::Adversarial(number)),
        3 => Some(Request::Climbs(number)),
        _ => None,
    }
}

fn region(from: *const u8, to: *const u8) -> &'static [u8] {
    // SAFETY: both are in the board's memory behind the code (memory.x), which nothing writes while the image runs.
    unsafe { core::slice::from_raw_parts(from, to as usize - from as usize) }
}

/// A table file, cut to the length in its header; the whole region if that is not a table file.
fn table_file(region: &'static [u8]) -> &'static [u8] {
    /// Offset of the payload's length, after magic, version and machine id; the CRC follows the payload.
    const LENGTH_AT: usize = 14;
    let length = region.get(LENGTH_AT..).and_then(|rest| rest.first_chunk()).map(|bytes| u32::from_le_bytes(*bytes));
    let whole = length.and_then(|length| (length as usize).checked_add(LENGTH_AT + 4 + 4));
    whole.and_then(|whole| region.get(..whole)).unwrap_or(region)
}

/// The tables in force from the start.
pub fn tables_a() -> &'static [u8] {
    table_file(region(addr_of!(_tables_a), addr_of!(_tables_b)))
}

/// The tables that the recording requests in motion.
pub fn tables_b() -> &'static [u8] {
    table_file(region(addr_of!(_tables_b), addr_of!(_warming)))
}

/// Thermal growth with sensor readings, and everything after them in the region.
pub fn warming() -> &'static [u8] {
    region(addr_of!(_warming), addr_of!(_recording))
}

/// The recording, and everything after it in the region.
pub fn recording() -> &'static [u8] {
    region(addr_of!(_recording), addr_of!(_regions_end))
}
