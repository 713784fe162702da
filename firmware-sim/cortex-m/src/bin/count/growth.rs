//! Thermal growth: the task's update, and its handling in the servo interrupt.

use crate::arena::Arena;
use crate::forms::{AXES, Machine};
use core::cell::{Cell, RefCell};
use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use heapless::Vec;
use heapless::spsc::Queue;
use trueaxis::compensation::ThermalLine;
use trueaxis::tcomp::checksum;
use trueaxis::temperature::{KNOTS, MAGIC, SENSORS, VERSION};
use trueaxis::{Real, State};
use trueaxis_cortex_m::growth::{Growths, InForce, WAITING};
use trueaxis_cortex_m::timer::{Tally, timed};
use trueaxis_recording::Integer;
use trueaxis_recording::warming::{self, Task, Warming};

const ROWS: u32 = 40;
/// Cycles between two rows.
const INTERVAL: u32 = 1000;
const PERIOD_NS: u32 = 1_000_000;

/// Room for the largest growth with its readings.
type Bytes = Vec<u8, 12_288>;

fn put(bytes: &mut Bytes, more: &[u8]) {
    assert!(bytes.extend_from_slice(more).is_ok(), "room for the largest growth");
}

fn seal(bytes: &mut Bytes) {
    let sum = checksum(bytes);
    put(bytes, &sum.to_le_bytes());
}

/// The largest possible growth: all sensors, knots, speeds and axes.
fn file() -> Bytes {
    let mut bytes = Bytes::new();
    let to = &mut bytes;
    put(to, &MAGIC);
    put(to, &VERSION.to_le_bytes());
    put(to, &1_u32.to_le_bytes());
    put(to, &[SENSORS as u8, 6, KNOTS as u8, 0]);
    put(to, &900_000_u32.to_le_bytes());
    (0..KNOTS as u32).for_each(|knot| put(to, &(2000 * knot).to_le_bytes()));
    for sensor in 0..SENSORS as i32 {
        for number in [600_000 + sensor, -20_000, 90_000, 2_000, 1_000, 3_600_000, 3_000] {
            put(to, &number.to_le_bytes());
        }
        put(to, &[KNOTS as u8]);
        (0..KNOTS as i32).for_each(|knot| put(to, &(10_000 + 4_000 * knot).to_le_bytes()));
    }
    for axis in 0..6 {
        put(to, &[axis]);
        put(to, &0_i64.to_le_bytes());
        for number in 0..(KNOTS * SENSORS) as i32 {
            put(to, &(100 * (number % 11)).to_le_bytes());
            put(to, &(300_000 * (number % 13)).to_le_bytes());
        }
        for knot in 0..KNOTS as i32 {
            put(to, &(900 * knot).to_le_bytes());
            put(to, &(5_000 * knot).to_le_bytes());
        }
    }
    seal(to);
    bytes
}

/// The growth with readings that rise by 0.1 K from row to row.
fn flashed(arena: &mut Arena) -> Warming<'static> {
    let growth = file();
    let mut bytes = Bytes::new();
    let to = &mut bytes;
    put(to, &warming::MAGIC);
    put(to, &warming::VERSION.to_le_bytes());
    put(to, &INTERVAL.to_le_bytes());
    put(to, &(growth.len() as u32).to_le_bytes());
    put(to, &growth);
    put(to, &[SENSORS as u8]);
    put(to, &ROWS.to_le_bytes());
    for row in 0..ROWS as i32 {
        (0..SENSORS as i32).for_each(|sensor| put(to, &(18_000 + 100 * row + 700 * sensor).to_le_bytes()));
        put(to, &5_300_i32.to_le_bytes());
    }
    seal(to);
    match Warming::parse(arena.collect(bytes.into_iter()), 1) {
        Ok(warming) => warming,
        Err(error) => panic!("{}", error),
    }
}

struct Updating(Warming<'static>, RefCell<Task>, Cell<u32>);

#[inline(never)]
fn no_update(of: &Updating) -> u32 {
    black_box(&mut *of.1.borrow_mut());
    black_box(of.2.get())
}

#[inline(never)]
fn update(of: &Updating) -> u32 {
    let growth = of.0.update(&mut of.1.borrow_mut(), of.2.get(), PERIOD_NS);
    black_box(growth).map_or(0, |growth| u32::from(growth.is_good()))
}

fn task(scalar: &str, warming: Warming<'static>) {
    let updating = Updating(warming, RefCell::default(), Cell::new(0));
    let frame = timed(no_update, &updating).0;
    let mut updates = Tally::default();
    for row in 0..ROWS {
        updating.2.set(row);
        let (taken, good) = timed(update, &updating);
        assert!(good == 1, "a sensor is not good");
        updates.add(taken - frame);
    }
    hprintln!("{} thermal_update {}", scalar, updates);
}

/// The interrupt's end of the queue, and the step's state in a cycle.
struct Taking<R: Real, P: Integer>(Warming<'static>, RefCell<(Growths<R, AXES>, State<R, P, AXES>)>, Cell<u32>);

#[inline(never)]
fn no_take<R: Real, P: Integer>(of: &Taking<R, P>) -> u32 {
    black_box(&mut *of.1.borrow_mut());
    black_box(of.2.get())
}

#[inline(never)]
fn take<R: Real, P: Integer>(of: &Taking<R, P>) -> u32 {
    let (growths, state) = &mut *of.1.borrow_mut();
    let cycle = of.2.get();
    growths.take_into(black_box(state), cycle);
    of.0.read_in(cycle).unwrap_or(cycle)
}

fn interrupt<R: Real, P: Integer>(scalar: &str, warming: Warming<'static>, machine: &Machine<R, P>, arena: &mut Arena) {
    let (mut offered, waiting) = arena.keep(Queue::<InForce<R, AXES>, WAITING>::new()).split();
    let taking = Taking(warming, RefCell::new((Growths::new(waiting), machine.start())), Cell::new(100));
    let frame = timed(no_take, &taking).0;
    let count = |name, cycle| {
        taking.2.set(cycle);
        hprintln!("{} growth_{} worst {}", scalar, name, timed(take, &taking).0 - frame);
    };
    count("none", 100);
    count("read", INTERVAL);
    assert!(offered.enqueue(InForce { from: 200, lines: [ThermalLine::new(0.02, 1e-5); AXES] }).is_ok(), "room");
    count("waiting", 199);
    count("taken", 201);
    let (growths, _) = &*taking.1.borrow();
    assert!((growths.taken, growths.late) == (1, 1), "one growth taken, late");
}

/// Counts the task and the interrupt.
pub fn all<R: Real, P: Integer>(scalar: &str, machine: &Machine<R, P>, arena: &mut Arena) {
    let warming = flashed(arena);
    task(scalar, warming);
    interrupt(scalar, warming, machine, arena);
}
