//! Host simulator.
fn main() {}
