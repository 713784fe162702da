//! Runs the target named by the environment variable `TRUEAXIS_FUZZ` under libFuzzer: see `fuzz/run.sh`.

#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use std::sync::OnceLock;
use trueaxis_fuzz::targets::named;
use trueaxis_fuzz::{Target, outcome};

fn target() -> &'static Target {
    static TARGET: OnceLock<&Target> = OnceLock::new();
    TARGET.get_or_init(|| {
        let name = std::env::var("TRUEAXIS_FUZZ").unwrap_or_default();
        named(&name).unwrap_or_else(|| {
            eprintln!("TRUEAXIS_FUZZ: found {name:?}, needed the name of a target");
            std::process::exit(2)
        })
    })
}

fuzz_target!(|input: &[u8]| {
    outcome::begin(input);
    (target().run)(input);
});

// libFuzzer's mutations; most are followed by a repair of lengths and check sums.
fuzz_mutator!(|data: &mut [u8], size: usize, most: usize, seed: u32| {
    let size = fuzzer_mutate(data, size, most);
    if seed.is_multiple_of(8) {
        return size;
    }
    let mut input = data[..size].to_vec();
    (target().repair)(&mut input);
    let size = input.len().min(most);
    data[..size].copy_from_slice(&input[..size]);
    size
});
