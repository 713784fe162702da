//! Registers of the board: the servo timer and two serial ports.

/// Ticks of the board's 25 MHz clock in a servo cycle: 84,000 instructions, of which QEMU executes one in 128 ns.
///
/// A 168 MHz core executes as many in 1 ms at two clocks each. Step and telemetry keep up at a quarter of it, in software
/// doubles and byte by byte through two ports; the remaining time determines how soon other tables are in force, whose check
/// takes some 35 million instructions of such doubles.
pub const TICKS: u32 = if cfg!(feature = "hurried") { 16_000 } else { 268_800 };

/// Instructions that QEMU executes in that many ticks.
pub fn instructions(ticks: u32) -> u32 {
    ticks / 16 * 5 + ticks % 16 * 5 / 16
}

const TIMER: *mut u32 = 0x4000_0000 as *mut u32;
const VALUE: usize = 1;
const RELOAD: usize = 2;
const PENDING: usize = 3;

/// The servo timer (CMSDK timer 0): counts down and raises its interrupt every [`TICKS`].
pub struct ServoTimer(());

impl ServoTimer {
    /// Starts the timer.
    ///
    /// # Safety
    /// The caller must be the only owner.
    pub unsafe fn start() -> Self {
        // SAFETY: registers of the board's timer 0: value, reload; control: run, interrupt.
        unsafe {
            TIMER.add(VALUE).write_volatile(TICKS - 1);
            TIMER.add(RELOAD).write_volatile(TICKS - 1);
            TIMER.write_volatile(1 | 1 << 3);
        }
        ServoTimer(())
    }

    /// Acknowledges the interrupt; returns the number of ticks since it was raised.
    pub fn acknowledge(&mut self) -> u32 {
        // SAFETY: the timer's value, and its pending interrupt, which writing 1 clears.
        unsafe {
            TIMER.add(PENDING).write_volatile(1);
            (TICKS - 1).saturating_sub(TIMER.add(VALUE).read_volatile())
        }
    }

    /// Whether the next cycle is already due.
    pub fn is_due(&self) -> bool {
        // SAFETY: the timer's pending interrupt.
        unsafe { TIMER.add(PENDING).read_volatile() & 1 == 1 }
    }
}

/// A serial port (CMSDK UART), transmitting only.
pub struct Uart(*mut u32);

// SAFETY: the registers belong to whoever owns the value.
unsafe impl Send for Uart {}

const STATE: usize = 1;
const CONTROL: usize = 2;
const BAUD: usize = 4;
const FULL: u32 = 1;

impl Uart {
    /// UART 0.
    ///
    /// # Safety
    /// The caller must be the only owner.
    pub unsafe fn zero() -> Self {
        Self::enabled(0x4000_4000 as *mut u32)
    }

    /// UART 1.
    ///
    /// # Safety
    /// The caller must be the only owner.
    pub unsafe fn one() -> Self {
        Self::enabled(0x4000_5000 as *mut u32)
    }

    fn enabled(registers: *mut u32) -> Self {
        // SAFETY: registers of a UART: clocks per bit (at least 16), transmitter on.
        unsafe {
            registers.add(BAUD).write_volatile(16);
            registers.add(CONTROL).write_volatile(1);
        }
        Uart(registers)
    }

    /// Sends bytes, waiting while the port is busy.
    pub fn send(&mut self, bytes: &[u8]) {
        for byte in bytes {
            // SAFETY: registers of this UART: state, data.
            unsafe {
                while self.0.add(STATE).read_volatile() & FULL != 0 {}
                self.0.write_volatile(u32::from(*byte));
            }
        }
    }
}
