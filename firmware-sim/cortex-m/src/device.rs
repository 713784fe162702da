//! The board's interrupts, in the form that RTIC and cortex-m-rt expect; no vendor's crate describes the MPS2 images AN386 and
//! AN500.

use cortex_m::interrupt::InterruptNumber;

/// Implemented priority bits of the processor: the three highest of a byte.
pub const NVIC_PRIO_BITS: u8 = 3;

/// The interrupts in use. Hardware never raises those of the UARTs here: they dispatch tasks.
#[derive(Clone, Copy, Debug)]
#[repr(u16)]
pub enum Interrupt {
    /// Receiver of UART 1.
    Uart1Rx = 2,
    /// Receiver of UART 2.
    Uart2Rx = 4,
    /// Transmitter of UART 2.
    Uart2Tx = 5,
    /// Timer 0.
    Timer0 = 8,
}

/// The name used by vendors' crates.
pub use Interrupt as interrupt;

// SAFETY: the discriminants are the numbers of the interrupts.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// An entry of the vector table.
#[repr(C)]
pub union Vector {
    handler: unsafe extern "C" fn(),
    reserved: usize,
}

// Defaults are in `device.x`.
#[allow(non_snake_case)]
unsafe extern "C" {
    fn Uart1Rx();
    fn Uart2Rx();
    fn Uart2Tx();
    fn Timer0();
}

const LAST: usize = Interrupt::Timer0 as usize;

/// Vectors of the interrupts, after those of the exceptions.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [Vector; LAST + 1] = {
    let mut vectors = [const { Vector { reserved: 0 } }; LAST + 1];
    vectors[Interrupt::Uart1Rx as usize].handler = Uart1Rx;
    vectors[Interrupt::Uart2Rx as usize].handler = Uart2Rx;
    vectors[Interrupt::Uart2Tx as usize].handler = Uart2Tx;
    vectors[Interrupt::Timer0 as usize].handler = Timer0;
    vectors
};
