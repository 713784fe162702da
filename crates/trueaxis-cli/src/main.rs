//! trueaxis on the bench.
fn main() {}
