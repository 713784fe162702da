//! Searches for the most expensive contour query.
//!
//! `worst SHAPE find COUNT KEEP` runs the queries 0 … COUNT − 1 and prints the KEEP queries with the most evaluations of the
//! path; `worst SHAPE count SEED...` calls `counted` once per seed, so that callgrind with `--dump-after='worst::counted*'
//! --toggle-collect='worst::counted*'` counts each one separately.

use std::hint::black_box;
use trueaxis::contour::ContourError;
use trueaxis_benches::contour::{Query, Shape, Track};

#[inline(never)]
fn counted(query: &mut Query) -> ContourError<f64> {
    query.run()
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let shape = match arguments.first().map(String::as_str) {
        Some("rational") => Shape::RationalCubic,
        Some("polynomial") => Shape::PolynomialCubic,
        _ => return eprintln!("usage: worst rational|polynomial find COUNT KEEP | count SEED..."),
    };
    let track = Track::new(shape);
    let numbers: Vec<u64> = arguments.iter().skip(2).filter_map(|a| a.parse().ok()).collect();
    if let (Some("find"), &[count, keep]) = (arguments.get(1).map(String::as_str), &numbers[..]) {
        let mut ranked: Vec<(u8, u64)> = (0..count).map(|seed| (track.query(seed).run().evaluations, seed)).collect();
        ranked.sort_by_key(|(evaluations, seed)| (u8::MAX - evaluations, *seed));
        for (evaluations, seed) in ranked.iter().take(keep as usize) {
            eprintln!("{evaluations} evaluations: query {seed}");
            println!("{seed}");
        }
        return;
    }
    for seed in numbers {
        black_box(counted(black_box(&mut track.query(seed))));
    }
}
