//! The smallest firmware in Rust: what `examples/c/small.c` does, by `McuServo`. `size.py` links it.

#![no_std]

use core::panic::PanicInfo;
use trueaxis::contour::PathBuffer;
use trueaxis::telemetry::{FRAME_BYTES, Frame};
use trueaxis::{McuServo, Nanometres, Tcomp};

const PERIOD_NS: u32 = 100_000;
const SPANS: usize = 64;

unsafe extern "C" {
    static tables: [u8; 4096];
    fn read_machine(nanometres: *mut i32);
    fn write_drives(nanometres: *const i32);
    fn send(bytes: *const u8, count: u32);
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}

#[unsafe(no_mangle)]
extern "C" fn reset() -> ! {
    run();
    loop {}
}

fn run() -> Option<()> {
    // SAFETY: the board's constant.
    let file = Tcomp::parse(unsafe { &tables }).ok()?;
    let mut memory = [0.0; 2048];
    let servo = McuServo::<3>::load(&file, PERIOD_NS, &mut memory).ok()?;
    let mut state = servo.start();
    let mut path = PathBuffer::<f32, Nanometres, SPANS>::new();
    path.line([0.0; 3], [1.0, 0.0, 0.0]).ok()?;
    let mut frame = [0; FRAME_BYTES];
    loop {
        let mut readings = [[0; 3]; 2];
        // SAFETY: the board writes six numbers.
        unsafe { read_machine(readings.as_mut_ptr().cast()) };
        let [command, feedback] = readings.map(|positions| positions.map(Nanometres));
        let output = servo.step(&mut state, &servo.input(command, feedback), path.at(0, 0.5), ());
        if output.has_drive() {
            // SAFETY: the board reads three numbers.
            unsafe { write_drives(output.drive.map(|position| position.0).as_ptr()) };
        }
        if let Ok(bytes) = Frame::of(&output.record).encode(&mut frame) {
            // SAFETY: the board reads as many bytes.
            unsafe { send(bytes.as_ptr(), bytes.len() as u32) };
        }
    }
}
