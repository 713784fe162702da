//! Instructions of the step and its parts on a Cortex-M, counted in QEMU (see `count.sh`).
//!
//! QEMU counts instructions, not cycles: with `-icount shift=7` one instruction takes 128 ns of virtual time, in which
//! the board's 25 MHz timer ticks 3.2 times. The call of an empty function is subtracted.
//!
//! Tables and a recording are where the image has them ([`trueaxis_cortex_m::regions`]).

#![no_std]
#![no_main]

mod arena;
mod gauge;
mod recorded;
mod things;

use arena::Arena;
use cortex_m as _;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use trueaxis_cortex_m::timer;

/// Ends QEMU.
fn leave(code: debug::ExitStatus) -> ! {
    debug::exit(code);
    loop {
        cortex_m::asm::bkpt();
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    hprintln!("PANIC {}", info);
    leave(debug::EXIT_FAILURE)
}

#[entry]
fn main() -> ! {
    timer::start();
    let mut arena = Arena::take();
    gauge::all::<f32>("f32", &mut arena);
    things::all::<f32, trueaxis::Nanometres>("f32", &mut arena);
    recorded::all::<f32, trueaxis::Nanometres>("f32", &mut arena);
    if cfg!(feature = "double") {
        let mut arena = Arena::take();
        gauge::all::<f64>("f64", &mut arena);
        things::all::<f64, f64>("f64", &mut arena);
        recorded::all::<f64, f64>("f64", &mut arena);
    }
    leave(debug::EXIT_SUCCESS)
}
