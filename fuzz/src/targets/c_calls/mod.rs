//! The C interface as sequences of calls: every byte of the input is an opcode or an argument.
//!
//! Objects are built, used, copied, exchanged and queried in any order. Some arguments are null, misaligned or of a wrong
//! size, as far as the header permits; every other pointer points to what its type says.
#![allow(unsafe_code)]

mod draw;
mod gauges;
mod machines;
mod paths;
mod poses;
mod servo;
mod step;
mod world;

use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome};
use draw::Draw;
use std::cell::RefCell;
use world::World;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "c_calls",
    about: "the C interface as sequences of calls",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../../dictionaries/c_calls.dict"),
    slowest: SLOWEST,
};

/// Most calls, or groups of cycles, in one input.
const MOST: usize = 40;

/// Inputs whose first byte is below this begin with nothing built.
const FROM_NOTHING: u8 = 64;
/// Number of sound files to begin with.
const FILES: u8 = 6;

type Call = fn(&mut World, &mut Draw<'_>);

/// Calls by opcode; the step has several, because everything else serves it.
const CALLS: [Call; 24] = [
    servo::build,
    servo::bypass,
    servo::start,
    step::run,
    paths::start,
    paths::segment,
    paths::window,
    poses::build,
    poses::forward,
    gauges::build,
    gauges::restart,
    poses::learned,
    step::run,
    servo::thermal,
    servo::copy_loop,
    servo::keep_state,
    paths::shape,
    paths::reference,
    paths::foot,
    poses::rtcp,
    gauges::results,
    servo::query,
    servo::frame,
    other,
];

/// The less frequent calls.
fn other(world: &mut World, draw: &mut Draw<'_>) {
    match draw.below(4) {
        0 => poses::program(world, draw),
        1 => poses::other_kinds(world, draw),
        2 => gauges::wheel(world, draw),
        _ => poses::version(draw),
    }
}

thread_local! {
    static WORLD: RefCell<World> = RefCell::new(World::new());
}

fn run(bytes: &[u8]) {
    WORLD.with_borrow_mut(|world| {
        world.reset();
        let mut draw = Draw::new(bytes);
        // Usually begin with a loop and a state: one wrong byte in their construction would make everything else unreachable.
        if let Some(file) = draw.byte().checked_sub(FROM_NOTHING) {
            servo::build(world, &mut Draw::new(&seed::build(file % FILES, 0)[1..]));
            servo::start(world, &mut Draw::new(&seed::start(0, 0)[1..]));
        }
        for _ in 0..MOST {
            if draw.is_over() {
                break;
            }
            let call = draw.below(CALLS.len());
            CALLS[call](world, &mut draw);
        }
        if world.states.running.iter().flatten().any(|running| running.cycles > 0) {
            outcome::accepted();
        }
    });
}

/// Bytes of a call, as read by [`CALLS`].
mod seed {
    /// Builds a loop from a file.
    pub(super) fn build(file: u8, slot: u8) -> Vec<u8> {
        vec![0, 0, file, 0, slot, 0, 5, 1]
    }

    pub(super) fn start(servo: u8, state: u8) -> Vec<u8> {
        vec![2, 0, servo, state, 1]
    }

    /// Plain motion along the axes, against a measure, with or without a gauge.
    pub(super) fn step(servo: u8, state: u8, delta: u8, against: u8, gauge: bool) -> Vec<u8> {
        vec![3, servo, state, 11, 1, delta, 0, delta, 0, 0, 0, against, u8::from(!gauge), 0, 0, 1, 0]
    }

    /// A wild cycle, followed by plain ones.
    pub(super) fn wild(what: u8, argument: &[u8]) -> Vec<u8> {
        [&[3, 0, 0, 3, what, 1, 1, 1, 0, 0, 0][..], argument, &[0, 1, 0, 0, 0, 0]].concat()
    }
}

/// Plain motion; an exchange; paths; the tool; the gauge; faults and resets; a bypass; one state of two loops.
fn seeds() -> Vec<Vec<u8>> {
    use seed::{build, start, step, wild};
    let set = |file| [build(file, 0), start(0, 0)].concat();
    let path = |of_tool| {
        [vec![4, 0, 0, of_tool, 0, 0, 0, 0, 0, 1], vec![5, 0, 0, 0, 1, 1, 0, 1], vec![5, 0, 0, 0, 1, 1, 0, 1]].concat()
    };
    let tool = [vec![7, 0, 1, 0], vec![8, 0, 2, 0, 1, 0, 1, 0, 1, 0, 10, 0, 1, 0, 0, 0, 5]].concat();
    let gauge = [vec![9, 0, 1, 0, 1], vec![10, 0, 0]].concat();
    let bypass = vec![1, 0, 1, 3, 0, 0, 1];
    let seeds = vec![
        [set(0), step(0, 0, 9, 0, false), step(0, 0, 200, 0, false), vec![22, 0, 1, 1]].concat(),
        [set(0), build(4, 1), step(0, 0, 60, 0, false), step(1, 0, 60, 0, false), step(0, 0, 9, 0, false)].concat(),
        [set(0), path(0), step(0, 0, 80, 129, false), vec![17, 0, 0, 1, 1, 0, 0], vec![18, 0, 0, 0, 1, 0, 1, 0, 0]]
            .concat(),
        [set(0), vec![6, 0, 0, 0, 1], step(0, 0, 80, 130, false), step(0, 0, 80, 130, false)].concat(),
        [set(1), path(1), tool, step(0, 0, 80, 131, false), vec![19, 0, 0, 0, 1, 0, 1, 0, 1, 0, 1]].concat(),
        [set(5), gauge, step(0, 0, 1, 0, true), step(0, 0, 1, 0, true), vec![20, 0, 0]].concat(),
        [set(4), wild(129, &[0, 208, 0]), wild(4, &[0]), wild(4, &[7]), step(0, 0, 20, 0, false)].concat(),
        [bypass, start(1, 1), step(1, 1, 50, 0, false), set(2), step(0, 0, 50, 0, false), vec![21, 0, 0, 1]].concat(),
        [
            set(3),
            vec![13, 0, 0, 0, 0, 0, 10],
            step(0, 0, 50, 0, false),
            vec![11, 0, 0, 0, 0, 0, 1],
            vec![11, 0, 1, 0, 5],
        ]
        .concat(),
        [set(0), vec![15, 0, 0], step(0, 0, 50, 0, false), vec![15, 0, 1], step(0, 0, 50, 0, false), vec![14, 0, 2]]
            .concat(),
    ];
    let ready = (0..FILES).map(|file| [vec![FROM_NOTHING + file], step(0, 0, 9, 0, false)].concat());
    seeds.into_iter().map(|calls| [vec![0], calls].concat()).chain(ready).collect()
}
