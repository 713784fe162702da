//! Errors in cells compared with the tables themselves, looked up directly in doubles.

#![allow(clippy::indexing_slicing)]

use super::PERIOD_NS;
use crate::compensation::{Direction, Query, ThermalLine};
use crate::contour::Method;
use crate::machine::{Axis, GridAxis, GridData, GridHeader, Interpolation, LocationErrors, MachineSettings, Row};
use crate::position::{Nanometres, Position};
use crate::real::Real;
use crate::sample::{Input, Verdict};
use crate::step::{Config, ServoLoop, State};
use crate::testing::machine::{Machine, rows_both_ways};
use crate::testing::noise::Noise;
use crate::testing::share::share;
use std::{boxed::Box, vec, vec::Vec};

const T: f64 = 1e-4;
/// Share of the inverse's tolerance for a cell that extends beyond its ends, mm.
const OVERLAP: f64 = 0.5e-6;
const ENDS: [f64; 2] = [-20.0, 120.0];

/// A machine whose tables end within its travel, and its tables; one axis has no table. Grids, if any, end there too.
#[derive(Clone)]
struct Tables {
    machine: MachineSettings,
    rows: [Vec<Row>; 3],
    grids: &'static [GridData<'static>],
}

impl Tables {
    /// `steep`: change of an error from one point to the next, 10 mm further, mm.
    fn new(seed: u64, free: bool, interpolation: Interpolation, steep: f64, table_of_y: bool) -> Self {
        let mut noise = Noise::new(seed);
        let machine = Machine::three_axis().travel([-40.0, 140.0], 0.2);
        let mut machine = machine.each(|axis| axis.interpolation = interpolation).settings();
        machine.axes[0].backlash = 2e-3;
        machine.location = LocationErrors { a0z: 30e-6, b0z: -20e-6, c0y: 50e-6, ..Default::default() };
        let rows = [0, 1, 2].map(|slot| {
            if slot == 1 && !table_of_y {
                return Vec::new();
            }
            let mut error = [0.0; 6];
            let points = (0..15).map(|i| {
                let stray = if free && i > 0 && i < 14 { 3.0 * noise.signed() } else { 0.0 };
                ENDS[0] + 10.0 * f64::from(i) + stray
            });
            let points: Vec<f64> = points.collect();
            rows_both_ways(points, |_, reverse| {
                if !reverse {
                    error[..3].iter_mut().for_each(|e| *e += steep * noise.signed());
                }
                error.map(|e| if reverse { e + 0.3e-3 } else { e })
            })
        });
        Tables { machine, rows, grids: &[] }
    }

    /// Adds a grid over some of the axes, one over X and Y that fades, or both.
    fn with_grid(self, seed: u64, over: Option<[bool; 3]>, fade: bool) -> Self {
        let mut noise = Noise::new(seed);
        let mut grid = |over: [bool; 3], fade| {
            let mut header = GridHeader { given: 0b111, scales: [1e-7; 6], fade, ..GridHeader::default() };
            header.scales[3..].fill(0.0);
            for (along, _) in header.axes.iter_mut().zip(over).filter(|(_, there)| *there) {
                let first = noise.range(-30.0, 0.0);
                *along = GridAxis { nodes: 7, ends: [first, first + noise.range(60.0, 160.0)], free: false };
            }
            let count = 3 * over.map(|there| if there { 7 } else { 1 }).into_iter().product::<usize>();
            let bytes: Vec<u8> = (0..count).flat_map(|_| ((1e4 * noise.signed()) as i16).to_le_bytes()).collect();
            GridData::new(header, bytes.leak()).expect("enough bytes").0
        };
        let mut grids: Vec<_> = over.map(|over| grid(over, None)).into_iter().collect();
        grids.extend(fade.then(|| grid([true, true, false], Some([20.0, 90.0]))));
        Tables { grids: grids.leak(), ..self }
    }

    /// Nodes of the grids along an axis, and the heights between which the grids fade.
    fn nodes(&self, slot: usize) -> impl Iterator<Item = f64> {
        let fades = self.grids.iter().filter(move |_| slot == 2).filter_map(|grid| grid.header().fade).flatten();
        let along = move |grid: &GridData<'_>| {
            let GridAxis { nodes, ends: [first, last], .. } = grid.header().axes[slot];
            (0..nodes).map(move |i| first + (last - first) * f64::from(i) / f64::from(nodes.max(2) - 1))
        };
        self.grids.iter().flat_map(along).chain(fades)
    }

    /// Whether a position is beyond the table or a grid along an axis.
    fn is_beyond(&self, slot: usize, place: f64) -> bool {
        let outside = |[first, last]: [f64; 2]| !(first..=last).contains(&place);
        let grids = self.grids.iter().map(|grid| grid.header().axes[slot]);
        let beyond_grids = grids.filter(GridAxis::is_there).any(|along| outside(along.ends));
        beyond_grids || (!self.rows[slot].is_empty() && outside(ENDS))
    }

    fn servo<R: Real, P: Position>(&self, period_ns: u32) -> &'static ServoLoop<'static, R, P, 3> {
        let config = Config {
            machine: &self.machine,
            grids: self.grids,
            machine_id: 0,
            tables_crc: 0,
            period_ns,
            inverse_passes: 8,
            method: Method::Guarded,
        };
        let rows = |axis: Axis| Some(&self.rows[axis.index()][..]).filter(|rows| !rows.is_empty());
        let memory = vec![R::ZERO; config.requirement(rows)].leak();
        Box::leak(Box::new(config.build(rows, memory).unwrap()))
    }
}

/// Reference: the tables in doubles, looked up directly.
#[derive(Clone, Copy)]
struct Truth {
    servo: &'static ServoLoop<'static, f64, f64, 3>,
    directions: [Direction; 3],
    thermal: [ThermalLine<f64>; 3],
}

impl Truth {
    fn error(&self, at: [f64; 3]) -> [f64; 3] {
        let compensation = &self.servo.compensation;
        let at = compensation.coordinates(&at);
        compensation.errors(&Query::at(&at, &self.directions, &self.thermal), &mut 0)
    }

    /// The correction to which the inverse converges.
    fn correction(&self, command: [f64; 3]) -> [f64; 3] {
        (0..60).fold([0.0; 3], |r, _| {
            let error = self.error([0, 1, 2].map(|k| command[k] + r[k]));
            error.map(|e| -e)
        })
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
}

/// Commands that move, rest, dither around points and ends of the tables, and reverse.
struct Walk {
    noise: Noise,
    place: [f64; 3],
    target: [f64; 3],
    speed: f64,
    dither: f64,
    points: Vec<f64>,
}

impl Walk {
    fn new(seed: u64, tables: &Tables) -> Self {
        let points = tables.rows.iter().flatten().map(|row| row.position);
        let points = points.chain((0..3).flat_map(|slot| tables.nodes(slot))).collect();
        let place = [-20.1, 119.9, 50.0];
        Walk { noise: Noise::new(seed), place, target: place, speed: 0.0, dither: 0.0, points }
    }

    fn next(&mut self) -> [f64; 3] {
        if self.noise.unit() < 0.003 {
            for target in &mut self.target {
                let nearest = |places: &[f64]| {
                    let apart = |q: &f64| (q - *target).abs();
                    *places.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap()
                };
                *target = match self.noise.below(6) {
                    0 => *target,
                    1 => self.noise.range(-39.0, 139.0),
                    2 => nearest(&ENDS),
                    3 => nearest(&ENDS) + self.noise.signed(),
                    4 => nearest(&self.points),
                    _ => nearest(&self.points) + 3.0 * self.noise.signed(),
                };
            }
            self.speed = [0.05, 0.02, 0.002][self.noise.below(3)];
            self.dither = [0.0, 0.0, 1e-3, 1e-2][self.noise.below(4)];
        }
        for (place, target) in self.place.iter_mut().zip(self.target) {
            *place += (target - *place).clamp(-self.speed, self.speed);
        }
        let (dither, noise) = (self.dither, &mut self.noise);
        self.place.map(|place| place + dither * noise.signed())
    }
}

/// Largest deviations in a run, mm.
#[derive(Debug, Default)]
struct Worst {
    feedback: f64,
    inside: f64,
    locked: f64,
    filled: usize,
    edges: usize,
    kept: usize,
}

/// Runs the tables one after the other, exchanged in motion, with thermal growth, faults and pauses.
fn run<R: Real, P: Position>(all: &[Tables], seed: u64, cycles: usize, rounding: f64) -> Worst {
    let servos: Vec<_> = all.iter().map(|tables| (tables.servo::<R, P>(PERIOD_NS), tables.servo(PERIOD_NS))).collect();
    let mut walk = Walk::new(seed, &all[0]);
    let mut noise = Noise::new(seed + 1);
    let mut state = servos[0].0.start();
    let mut thermal = [ThermalLine::default(); 3];
    let (mut worst, mut which) = (Worst::default(), 0);
    let mut enable = true;
    for cycle in 0..cycles {
        if noise.unit() < 0.002 {
            which = noise.below(servos.len());
        }
        if noise.unit() < 0.002 {
            let (slot, offset, slope) = (noise.below(3), 2e-3 * noise.signed(), 5e-5 * noise.signed());
            thermal[slot] = ThermalLine::new(offset, slope).unwrap();
            state.set_thermal(slot, ThermalLine::new(offset, slope).unwrap()).unwrap();
        }
        enable = noise.unit() > 0.001 && (enable || noise.unit() < 0.1);
        let homed = noise.unit() > 0.0005;
        let command = walk.next();
        let (servo, truth) = servos[which];
        let mut feedback = command.map(|q| q + 5e-3 * noise.signed());
        if noise.unit() < 0.001 {
            feedback[1] = f64::NAN;
        }
        let input = Input { homed, enable, ..servo.input(command.map(P::of), feedback.map(P::of)) };
        compare(&mut state, servo, truth, &input, thermal, &all[which], rounding, &mut worst, cycle);
        servo.step(&mut state, &input, (), ());
    }
    worst
}

#[allow(clippy::too_many_arguments)]
fn compare<R: Real, P: Position>(
    state: &mut State<R, P, 3>,
    servo: &'static ServoLoop<'static, R, P, 3>,
    truth: &'static ServoLoop<'static, f64, f64, 3>,
    input: &Input<P, 3>,
    thermal: [ThermalLine<f64>; 3],
    tables: &Tables,
    rounding: f64,
    worst: &mut Worst,
    cycle: usize,
) {
    let mut probe = *state;
    let sent = *state.output.offsets();
    let mut trusted = [[P::default(); 3]; 2];
    let sample = servo.sampler.full_check(&mut probe.sample, input, state.output.drive(), &mut trusted);
    let before = probe.cells.windows();
    let kept = probe.cells.are_direct(&servo.tables);
    let modelled = servo.model(&mut probe, &sample, false);
    let only_moved = kept && state.reversal.map(|r| r.direction()) == probe.reversal.map(|r| r.direction());
    let filled = before.iter().zip(probe.cells.windows()).filter(|(a, b)| *a != b && b.is_some()).count();
    worst.filled = worst.filled.max(filled);
    if !matches!(sample.verdict, Verdict::Active | Verdict::Inactive) || !sample.homed {
        assert_eq!(modelled.wanted.map(Real::to_f64), [0.0; 3]);
        return;
    }
    worst.kept += usize::from(kept);
    let truth = Truth { servo: truth, directions: probe.reversal.map(|r| r.direction()), thermal };
    let feedback = sample.feedback.map(P::to_f64);
    let off = distance(modelled.tip_error.map(Real::to_f64), truth.error(feedback));
    assert!(off <= OVERLAP + rounding, "{cycle}: {off:e} mm off at the feedback {feedback:?}");
    worst.feedback = worst.feedback.max(off);
    let points = |slot: usize| tables.rows[slot].iter().map(|row| row.position).chain(tables.nodes(slot));
    let clear_of_nodes = |q: f64, slot: usize| points(slot).all(|point| (q - point).abs() > 0.021);
    if (0..3).all(|slot| clear_of_nodes(feedback[slot], slot)) {
        assert!(off <= rounding, "{cycle}: {off:e} mm off within a cell at the feedback {feedback:?}");
        worst.inside = worst.inside.max(off);
    }

    let place: [f64; 3] = core::array::from_fn(|k| sample.command[k].moved(sent[k]).to_f64());
    let command = sample.command.map(P::to_f64);
    let (wanted, converged) = (modelled.wanted.map(Real::to_f64), truth.correction(command));
    let left = distance(core::array::from_fn(|k| place[k] - command[k]), converged);
    let off = distance(wanted, converged);
    let norm = 2e-3;
    assert!(off <= OVERLAP + rounding + norm * left, "{cycle}: {off:e} mm off at the command");
    if left <= 5.0 * T {
        assert!(off <= 2.0 * OVERLAP + rounding, "{cycle}: {off:e} mm off at the command while locked");
        worst.locked = worst.locked.max(off);
    }
    for (slot, place) in place.into_iter().enumerate() {
        let near_end = ENDS.iter().any(|end| (place - end).abs() < 2e-6)
            || tables.nodes(slot).any(|node| (place - node).abs() < 0.021);
        // If more than the position has changed, the inverse starts at the command, and either value is correct.
        if only_moved && !near_end {
            let beyond = tables.is_beyond(slot, place);
            assert_eq!(modelled.at_edge >> slot & 1 == 1, beyond, "{cycle}: axis {slot} at {place}");
            worst.edges += usize::from(beyond);
        }
    }
}

fn kinds() -> Vec<Vec<Tables>> {
    let of = |seed, free, interpolation, y| Tables::new(seed, free, interpolation, 2e-3, y);
    vec![
        vec![of(1, false, Interpolation::Linear, true), of(2, false, Interpolation::Linear, true)],
        vec![of(3, true, Interpolation::Linear, true), of(4, false, Interpolation::Linear, false)],
        vec![of(5, false, Interpolation::Cubic, true), of(6, true, Interpolation::Cubic, true)],
        vec![of(7, true, Interpolation::Cubic, false), of(8, true, Interpolation::Linear, true)],
    ]
}

#[test]
fn kept_cells_say_what_the_tables_say() {
    let (mut edges, mut kept) = (0, 0);
    for (seed, tables) in kinds().into_iter().enumerate() {
        let doubles = run::<f64, f64>(&tables, seed as u64, share(60_000), 1e-13);
        let singles = run::<f32, Nanometres>(&tables, seed as u64, share(60_000), 0.1e-6);
        for worst in [doubles, singles] {
            // A cell at the command, and its copy at the feedback.
            assert!(worst.filled <= 2, "{worst:?}");
            edges += worst.edges;
            kept += worst.kept;
        }
    }
    assert!(edges > share(2000) && kept > share(400_000), "{edges} {kept}");
}

/// A position never leaves a box of the grids without leaving a cell, whatever is exchanged.
#[test]
fn kept_cells_with_grids_say_what_both_say() {
    let of = |seed, interpolation| Tables::new(seed, seed % 3 == 0, interpolation, 2e-3, seed % 2 == 0);
    let (linear, cubic) = (Interpolation::Linear, Interpolation::Cubic);
    let kinds = [
        vec![
            of(21, linear).with_grid(1, Some([true, true, false]), false),
            of(22, cubic).with_grid(2, Some([true; 3]), true),
        ],
        vec![
            of(23, linear).with_grid(3, Some([true, false, true]), true),
            of(24, linear),
            of(23, linear).with_grid(4, None, true),
        ],
        vec![
            of(25, cubic).with_grid(5, Some([false, true, true]), false),
            of(26, linear).with_grid(5, Some([false, true, true]), false),
        ],
    ];
    let (mut edges, mut kept) = (0, 0);
    for (seed, tables) in kinds.into_iter().enumerate() {
        // Twice the permitted deviation of a box beyond a node.
        let doubles = run::<f64, f64>(&tables, 40 + seed as u64, share(60_000), 0.2e-6);
        let singles = run::<f32, Nanometres>(&tables, 40 + seed as u64, share(60_000), 0.4e-6);
        for worst in [doubles, singles] {
            // Two cells at the command, and their copies at the feedback.
            assert!(worst.filled <= 4, "{worst:?}");
            edges += worst.edges;
            kept += worst.kept;
        }
    }
    assert!(edges > share(2000) && kept > share(300_000), "{edges} {kept}");
}

/// Tables so steep that one lookup is not enough: whatever the correction does, the inverse keeps its stated accuracy.
#[test]
fn the_inverse_from_the_last_correction_keeps_its_bound() {
    let (mut locked, mut limited) = (0, 0);
    for (seed, steep) in [(11, 0.02), (12, 0.1), (13, 0.5), (14, 1.0)] {
        for interpolation in [Interpolation::Linear, Interpolation::Cubic] {
            let tables = Tables::new(seed, false, interpolation, steep, true);
            for period_ns in [100_000, 1_000_000] {
                let found = at_the_velocity_limit(&tables, period_ns);
                assert!(found.locked <= 2.0 * OVERLAP + 1e-12, "{steep} {period_ns}: {found:?}");
                locked += found.cycles_locked;
                limited += found.cycles_limited;
            }
        }
    }
    assert!(locked > share(50_000) && limited > share(20_000), "{locked} {limited}");
}

/// Deviations of the inverse from the converged one during a motion, mm.
#[derive(Debug, Default)]
struct Inverse {
    locked: f64,
    cycles_locked: usize,
    cycles_limited: usize,
}

/// Moves as fast as the correction can just follow, and faster, with occasional reversals.
fn at_the_velocity_limit(tables: &Tables, period_ns: u32) -> Inverse {
    let mut tables = tables.clone();
    for axis in &mut tables.machine.axes {
        axis.limits.magnitude = 8.0;
        axis.joint = [-60.0, 160.0];
        axis.hysteresis = 0.1;
    }
    let rows = |axis: Axis| Some(&tables.rows[axis.index()][..]);
    let norm = crate::check::jacobian_norm(&tables.machine, rows, &crate::check::GridBounds::NONE);
    let servo = tables.servo::<f64, f64>(period_ns);
    let truth = Truth { servo, directions: [Direction::default(); 3], thermal: Default::default() };
    let mut state = servo.start();
    let mut noise = Noise::new(u64::from(period_ns));
    let mut found = Inverse::default();
    let limit = 5.0 * f64::from(period_ns) * 1e-9;
    let fastest = 500.0 * f64::from(period_ns) * 1e-9;
    let (mut place, mut speed) = ([50.0; 3], [0.0; 3]);
    for _ in 0..share(20_000) {
        if noise.unit() < 0.005 {
            let share = [0.3, 0.5, 1.0, 3.0][noise.below(4)];
            speed = noise.vector((share * limit / norm).min(fastest));
        }
        for (place, speed) in place.iter_mut().zip(&mut speed) {
            if (*place < -35.0 && *speed < 0.0) || (*place > 135.0 && *speed > 0.0) {
                *speed = -*speed;
            }
            *place += *speed;
        }
        let input = servo.input(place, place);
        let sent = *state.output.offsets();
        let mut probe = state;
        let mut trusted = [[0.0; 3]; 2];
        let sample = servo.sampler.full_check(&mut probe.sample, &input, state.output.drive(), &mut trusted);
        let wanted = servo.model(&mut probe, &sample, false).wanted;
        let truth = Truth { directions: probe.reversal.map(|r| r.direction()), ..truth };
        let off = distance(wanted, truth.correction(place));
        let changed = distance(sent, wanted);
        assert!(
            off <= norm / (1.0 - norm) * changed + 2.0 * OVERLAP,
            "{off:e} of a change by {changed:e}, norm {norm}"
        );
        let out = servo.step(&mut state, &input, (), ());
        assert_eq!(out.record.fault, crate::error::Fault::None);
        if out.record.limited == 0 && out.record.sequence > 0 {
            found.locked = found.locked.max(off);
            found.cycles_locked += 1;
        } else {
            found.cycles_limited += 1;
        }
    }
    found
}
