//! Puts the memory layout where the linker looks for it.

use std::env;

fn main() {
    if env::var("CARGO_CFG_TARGET_ARCH").as_deref() == Ok("arm") {
        let out = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
        std::fs::copy("../memory.x", format!("{out}/memory.x")).expect("memory.x can be copied");
        println!("cargo:rustc-link-search={out}");
    } else {
        println!("cargo:rustc-link-arg=-lc");
    }
    println!("cargo:rerun-if-changed=../memory.x");
}
