//! Data flashed apart from the image: tables, thermal growth and a recording, each in a region of its own (`memory.x`).

use core::ptr::addr_of;

unsafe extern "C" {
    static _tables_a: u8;
    static _tables_b: u8;
    static _warming: u8;
    static _recording: u8;
    static _regions_end: u8;
    static _request: [u32; 2];
}

/// A cycle that is to be run alone, with those before it that it needs.
#[derive(Clone, Copy, Debug)]
pub enum Request {
    /// Of the recording.
    Recorded(u32),
    /// Of the adversarial cycles.
    Adversarial(u32),
}

/// What was asked for at the very end of the recording's region: kind 1 or 2, and a number. Nothing where both are zero.
pub fn request() -> Option<Request> {
    // SAFETY: two words of the board's memory (memory.x), written by nobody while the image runs.
    let [kind, number] = unsafe { addr_of!(_request).read_volatile() };
    match kind {
        1 => Some(Request::Recorded(number)),
        2 => Some(Request::Adversarial(number)),
        _ => None,
    }
}

fn region(from: *const u8, to: *const u8) -> &'static [u8] {
    // SAFETY: both lie in the board's memory behind the code (memory.x), which nothing writes while the image runs.
    unsafe { core::slice::from_raw_parts(from, to as usize - from as usize) }
}

/// A table file by the length that its header gives: the whole region where that is no table file.
fn table_file(region: &'static [u8]) -> &'static [u8] {
    /// Magic, version, machine id; then the length of the payload, then the sum behind it.
    const LENGTH_AT: usize = 14;
    let length = region.get(LENGTH_AT..).and_then(|rest| rest.first_chunk()).map(|bytes| u32::from_le_bytes(*bytes));
    let whole = length.and_then(|length| (length as usize).checked_add(LENGTH_AT + 4 + 4));
    whole.and_then(|whole| region.get(..whole)).unwrap_or(region)
}

/// The tables in force from the start.
pub fn tables_a() -> &'static [u8] {
    table_file(region(addr_of!(_tables_a), addr_of!(_tables_b)))
}

/// The tables that are asked for in motion.
pub fn tables_b() -> &'static [u8] {
    table_file(region(addr_of!(_tables_b), addr_of!(_warming)))
}

/// Thermal growth with readings of sensors, and what lies behind them.
pub fn warming() -> &'static [u8] {
    region(addr_of!(_warming), addr_of!(_recording))
}

/// The recording, and what lies behind it.
pub fn recording() -> &'static [u8] {
    region(addr_of!(_recording), addr_of!(_regions_end))
}
