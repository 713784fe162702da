//! Memory behind the code that is written apart from it (see `memory.x`).

unsafe extern "C" {
    static _tables_a: u8;
    static _tables_b: u8;
    static _recording: u8;
    static _regions_end: u8;
}

fn between(start: *const u8, end: *const u8) -> &'static [u8] {
    // SAFETY: the linker script puts the borders in this order, into memory that exists and that nothing writes while
    // the image runs.
    unsafe { core::slice::from_raw_parts(start, end.offset_from_unsigned(start)) }
}

/// Tables that are in force from the start.
pub fn tables_a() -> &'static [u8] {
    between(&raw const _tables_a, &raw const _tables_b)
}

/// Tables to be exchanged for.
pub fn tables_b() -> &'static [u8] {
    between(&raw const _tables_b, &raw const _recording)
}

/// Inputs of the step.
pub fn recording() -> &'static [u8] {
    between(&raw const _recording, &raw const _regions_end)
}
