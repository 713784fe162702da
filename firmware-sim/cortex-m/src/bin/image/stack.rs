//! Stack use of the servo interrupt: painted before every cycle, measured after it.

use core::arch::asm;

/// Number of words painted below the interrupt's own frame.
pub const PAINTED_WORDS: u32 = 1024;
const PAINT: u32 = 0xc0de_5afe;

/// Returns the stack pointer.
#[inline(always)]
pub fn pointer() -> u32 {
    let pointer;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags)) };
    pointer
}

/// Paints [`PAINTED_WORDS`] below the stack pointer.
#[inline(always)]
pub fn paint() {
    // SAFETY: nobody owns the memory below the stack pointer, and no interrupt has a higher priority.
    unsafe {
        asm!(
            "mov {place}, sp",
            "2:",
            "str {paint}, [{place}, #-4]!",
            "subs {count}, #1",
            "bne 2b",
            place = out(reg) _,
            count = inout(reg) PAINTED_WORDS => _,
            paint = in(reg) PAINT,
        );
    }
}

/// Bytes below the stack pointer that were used since [`paint`]; must be called from the same function.
#[inline(always)]
pub fn used() -> u32 {
    let used;
    // SAFETY: reads what `paint` wrote.
    unsafe {
        asm!(
            "sub {place}, sp, {bytes}",
            "2:",
            "cmp {place}, sp",
            "beq 3f",
            "ldr {word}, [{place}], #4",
            "cmp {word}, {paint}",
            "beq 2b",
            "sub {place}, #4",
            "3:",
            "sub {place}, sp, {place}",
            place = out(reg) used,
            word = out(reg) _,
            bytes = in(reg) PAINTED_WORDS * 4,
            paint = in(reg) PAINT,
            options(readonly),
        );
    }
    used
}
