//! Runs whole steps one at a time for callgrind: each call of `counted` is a cycle.
//!
//! ```text
//! counted walk                       cycles one cycle in twenty all along the butterfly
//! counted walk-friction              the same with friction at reversals on three axes
//! counted walk-feedback              with contour feedback besides
//! counted walk-dynamic               with every part of the dynamic correction
//! counted walk-bilinear              with a grid over X and Y beside the tables
//! counted walk-trilinear             with a grid over X, Y and Z
//! counted adversarial CYCLE...       adversarial cycles by number
//! counted digest                     digests of all adversarial outputs, f32 and f64: what the bare-metal image prints
//! counted replay CYCLE               inputs and output of an adversarial cycle
//! ```
//!
//! With `--toggle-collect='counted::counted*' --dump-after='counted::counted*'` callgrind counts each cycle separately.

use std::hint::black_box;
use trueaxis::Output;
use trueaxis::machine::{GridData, MachineSettings};
use trueaxis_benches::adversarial::{self, Adversarial};
use trueaxis_benches::{step, tables};
use trueaxis_recording::adversary::{CYCLES, DYNAMIC_CYCLES, ServoParts};
use trueaxis_recording::outputs::Wire;

type Out = Output<f64, f64, 3>;

#[inline(never)]
fn counted_walk(cycle: &mut step::RunningLoop, output: &mut Out) {
    cycle.servo.step_into(&mut cycle.state, &cycle.input, cycle.path.on(cycle.reference), (), output);
    // Callgrind must see the end of this function, not that of a tail call.
    black_box(output);
}

#[inline(never)]
fn counted_adversarial(cycle: &mut adversarial::AdversarialCycle<'_, f64>, output: &mut Out) {
    cycle.run(output);
    black_box(output);
}

fn print_digests<R: Wire>(scalar: &str) {
    let all = Adversarial::<R>::default();
    let ([bare, gauged, volumetric], dynamic) = (all.digests(CYCLES), all.dynamic_digest(DYNAMIC_CYCLES));
    println!("{scalar} dynamic digest of {DYNAMIC_CYCLES} cycles: {dynamic:08x}");
    println!("{scalar} digests of {CYCLES} cycles: {bare:08x} {gauged:08x} {volumetric:08x}");
}

/// One cycle in this many is counted.
const SAMPLED: u32 = 20;

fn walk(parts: Option<ServoParts>) {
    let configure = |machine: &mut MachineSettings| {
        if let Some(parts) = parts {
            parts.configure(machine);
        }
    };
    walk_on(configure, &[]);
}

fn walk_on(configure: impl FnOnce(&mut MachineSettings), grids: &'static [GridData<'static>]) {
    step::walk_on(configure, grids, u32::MAX, |number, cycle, output| {
        if number >= step::AT_REST && number % SAMPLED == 0 {
            counted_walk(black_box(&mut { *cycle }), black_box(&mut { *output }));
        }
    });
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let numbers: Vec<u32> = arguments.iter().skip(1).filter_map(|a| a.parse().ok()).collect();
    match (arguments.first().map(String::as_str), &numbers[..]) {
        (Some("walk"), []) => walk(None),
        (Some("walk-friction"), []) => walk(Some(ServoParts::Friction)),
        (Some("walk-feedback"), []) => walk(Some(ServoParts::Feedback)),
        (Some("walk-dynamic"), []) => walk(Some(ServoParts::All)),
        (Some("walk-bilinear"), []) => walk_on(|_| (), tables::grid(false)),
        (Some("walk-trilinear"), []) => walk_on(|_| (), tables::grid(true)),
        (Some("adversarial"), numbers) => {
            let all = Adversarial::<f64>::default();
            for number in numbers {
                let mut cycle = all.cycle(*number);
                let mut output = Output::none();
                counted_adversarial(black_box(&mut cycle), black_box(&mut output));
            }
        }
        (Some("digest"), []) => {
            print_digests::<f32>("f32");
            print_digests::<f64>("f64");
        }
        (Some("replay"), &[number]) => {
            let all = Adversarial::<f64>::default();
            let mut cycle = all.cycle(number);
            println!("events: {}\n{:#?}", cycle.moment.events, cycle.moment);
            let mut output = Output::none();
            cycle.run(&mut output);
            println!("{:#?}", output.record);
        }
        _ => eprintln!(
            "usage: counted walk | walk-friction | walk-feedback | walk-dynamic | walk-bilinear | walk-trilinear | \
             adversarial CYCLE... | digest | replay CYCLE"
        ),
    }
}
