//! Counts the instructions of the step and its parts on a Cortex-M, in QEMU (see `count.sh`).
//!
//! QEMU counts instructions, not cycles: with `-icount shift=7` one instruction takes 128 ns of virtual time, in which the
//! board's 25 MHz timer ticks 3.2 times. The cost of calling an empty function is subtracted.
//!
//! Tables and recording are at the same addresses as in the image ([`trueaxis_cortex_m::regions`]).

#![no_std]
#![no_main]

mod adversarial;
mod arena;
mod climb;
mod dynamic;
mod forms;
mod gauge;
mod growth;
mod middle;
mod recorded;
mod things;

use arena::Arena;
use cortex_m as _;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use forms::Machine;
use trueaxis::Nanometres;
use trueaxis_cortex_m::regions::{self, Request};
use trueaxis_cortex_m::timer;
use trueaxis_recording::Integer;
use trueaxis_recording::outputs::Wire;

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

/// Counts everything in one scalar.
fn count<R: Wire<Place = P>, P: Integer>(scalar: &str, adversarial: bool) {
    let mut arena = Arena::take();
    gauge::all::<R>(scalar, &mut arena);
    things::all::<R, P>(scalar, &mut arena);
    let machine = Machine::flashed(recorded::recording().header().period_ns, &mut arena);
    growth::all::<R, P>(scalar, machine, &mut arena);
    recorded::all::<R, P>(scalar, machine, &mut arena);
    dynamic::recorded::<R, P>(scalar, &mut arena);
    if adversarial {
        dynamic::adversarial::<R, P>(scalar, &mut arena);
        adversarial::all::<R, P>(scalar, machine, &mut arena);
    }
    // Everything before is done with its memory.
    dynamic::periodic::<R, P>(scalar, &mut Arena::take());
}

/// Runs the request.
fn replay<R: Wire<Place = P>, P: Integer>(scalar: &str, request: Request) {
    let mut arena = Arena::take();
    let machine = Machine::flashed(recorded::recording().header().period_ns, &mut arena);
    match request {
        Request::Recorded(number) => recorded::replay::<R, P>(scalar, machine, number, &mut arena),
        Request::Adversarial(number) => adversarial::replay::<R, P>(scalar, machine, number, &mut arena),
        Request::Climbs(number) => climb::all::<R, P>(scalar, machine, number, &mut arena),
    }
}

#[entry]
fn main() -> ! {
    timer::start();
    let double = cfg!(feature = "double");
    match regions::request() {
        Some(request) if double => replay::<f64, f64>("f64", request),
        Some(request) => replay::<f32, Nanometres>("f32", request),
        None => {
            count::<f32, Nanometres>("f32", !double);
            if double {
                count::<f64, f64>("f64", true);
            }
        }
    }
    leave(debug::EXIT_SUCCESS)
}
