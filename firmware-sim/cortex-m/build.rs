//! Puts the memory layout and the names of the interrupts where the linker looks for them.

fn main() {
    let out = std::env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    for script in ["memory.x", "device.x"] {
        std::fs::copy(script, format!("{out}/{script}")).expect("linker scripts can be copied");
        println!("cargo:rerun-if-changed={script}");
    }
    println!("cargo:rustc-link-search={out}");
    // The log's format strings stay in the ELF file.
    println!("cargo:rustc-link-arg-bin=image=-Tdefmt.x");
}
