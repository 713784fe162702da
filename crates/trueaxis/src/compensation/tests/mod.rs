use super::*;
use crate::compensation::Query;
use crate::machine::{AxisSettings, Interpolation, LocationErrors, Lookup, Row};
use crate::position::Nanometres;
use crate::testing::machine::{self, Machine};
use crate::testing::noise::Noise;
use crate::testing::share::share;
use std::{vec, vec::Vec};

mod pieces;
mod stated;

/// Memory that a test leaks, so that it needs no owner.
fn lent<R: Real>(scalars: usize) -> &'static mut [R] {
    vec![R::ZERO; scalars].leak()
}

fn table<R: Real, P: Position>(settings: &AxisSettings, rows: &[Row]) -> AxisTable<'static, R, P> {
    let mut memory = lent(AxisTable::<R, P>::requirement(settings, rows));
    AxisTable::build(settings, rows, 1.0, &mut memory).unwrap()
}

fn rows(positions: &[f64]) -> Vec<Row> {
    let mut noise = Noise::new(1);
    machine::rows(positions.iter().copied(), |_| {
        let ([x, y, z], [a, _, c]) = (noise.vector(0.025), noise.vector(25e-6));
        [x, y, z, a, 0.0, c]
    })
}

/// Textbook linear interpolation by linear search.
fn plain_linear(rows: &[Row], q: f64) -> [f64; 3] {
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let q = q.max(first.position).min(last.position);
    let i = rows.windows(2).position(|w| q <= w[1].position).unwrap();
    let t = (q - rows[i].position) / (rows[i + 1].position - rows[i].position);
    core::array::from_fn(|k| rows[i].forward[k] + t * (rows[i + 1].forward[k] - rows[i].forward[k]))
}

#[test]
fn linear_tables_agree_with_the_textbook_on_any_grid() {
    let equidistant: Vec<f64> = (0..128).map(|i| -300.0 + 5.0 * f64::from(i)).collect();
    let mut noise = Noise::new(2);
    let mut free: Vec<f64> = (0..97).map(|i| -200.0 + 4.0 * f64::from(i) + 0.5 * noise.signed()).collect();
    // As uneven as a grid can be: a nanometre next to a hundred millimetres, all in one bucket.
    let wild = vec![0.0, 1e-6, 2e-6, 1e-3, 0.5, 0.500001, 100.0, 100.000001, 700.0, 700.1];
    free.push(500.0);
    for grid in [equidistant, free, wild] {
        let rows = rows(&grid);
        let table = table::<f64, f64>(&AxisSettings::with_defaults(Axis::X, false), &rows);
        let (low, high) = (grid[0] - 20.0, grid[grid.len() - 1] + 20.0);
        let places = (0..20_000).map(|i| low + (high - low) * f64::from(i) / 20_000.0).chain(grid.iter().copied());
        for q in places {
            let (value, held) = table.at(table.coordinate(q), Direction::POSITIVE);
            let truth = plain_linear(&rows, q);
            // The steepest cell rises 50 µm per nanometre: there a position in f64 is itself uncertain.
            let tolerance = if grid.len() == 10 { 1e-8 } else { 1e-13 };
            for k in 0..3 {
                assert!((value[k] - truth[k]).abs() < tolerance, "{q}: {} {}", value[k], truth[k]);
            }
            assert_eq!(held, q < grid[0] || q > grid[grid.len() - 1], "{q}");
            assert_eq!(table.at_linear(table.coordinate(q), Direction::POSITIVE), (value, held));
            if table.is_plain() {
                assert_eq!(table.at_plain(table.coordinate(q), Direction::POSITIVE), (value, held));
            }
        }
    }
}

#[test]
fn single_precision_keeps_a_thousandth_of_a_micrometre() {
    let grid: Vec<f64> = (0..128).map(|i| -300.0 + 5.0 * f64::from(i)).collect();
    let rows = rows(&grid);
    let table = table::<f32, Nanometres>(&AxisSettings::with_defaults(Axis::X, false), &rows);
    for i in 0..20_000 {
        let q = -310.0 + 655.0 * f64::from(i) / 20_000.0;
        let (value, _) = table.at(table.coordinate(Nanometres::of(q)), Direction::POSITIVE);
        for (value, truth) in value.iter().zip(plain_linear(&rows, q)) {
            assert!((f64::from(*value) - truth).abs() < 1e-6, "{q}: {value} {truth}");
        }
    }
}

#[test]
fn cubic_tables_pass_their_points_and_never_leave_a_cell() {
    let settings = AxisSettings { interpolation: Interpolation::Cubic, ..AxisSettings::with_defaults(Axis::Y, false) };
    for grid in [(0..33).map(|i| 10.0 * f64::from(i)).collect::<Vec<_>>(), (0..40).map(|i| f64::from(i * i)).collect()]
    {
        let rows = rows(&grid);
        let table = table::<f64, f64>(&settings, &rows);
        let mut last = None::<[f64; 4]>;
        for i in 0..=40_000 {
            let q = grid[grid.len() - 1] * f64::from(i) / 40_000.0;
            let (value, _) = table.at(table.coordinate(q), Direction::POSITIVE);
            let cell = rows.windows(2).position(|w| q <= w[1].position).unwrap();
            for k in 0..3 {
                let (a, b) = (rows[cell].forward[k], rows[cell + 1].forward[k]);
                assert!(value[k] >= a.min(b) - 1e-12 && value[k] <= a.max(b) + 1e-12, "{q} leaves its cell");
                if let Some(last) = last {
                    assert!((value[k] - last[k]).abs() < 6e-3, "jump at {q}");
                }
            }
            last = Some(value);
        }
        for row in &rows {
            let (value, _) = table.at(table.coordinate(row.position), Direction::POSITIVE);
            assert!((value[0] - row.forward[0]).abs() < 1e-14);
        }
    }
}

/// Values of SciPy's PchipInterpolator, written by tests/reference/pchip.py.
#[test]
fn cubic_tables_agree_with_scipy() {
    let text = include_str!("../../../../../tests/reference/pchip.csv");
    let lines: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let settings = AxisSettings { interpolation: Interpolation::Cubic, ..AxisSettings::with_defaults(Axis::Y, false) };
    let mut compared = 0;
    for grid in ["equidistant", "free", "two"] {
        let of = |kind: &'static str| lines.iter().filter(move |line| line[0] == grid && line[1] == kind);
        let number = |text: &str| text.parse::<f64>().unwrap();
        let rows: Vec<Row> = of("knot")
            .map(|line| {
                let error = [number(line[3]), -number(line[3]), 0.0, 0.0, 0.0, 0.0];
                Row { position: number(line[2]), forward: error, reverse: error }
            })
            .collect();
        let table = table::<f64, f64>(&settings, &rows);
        let curve = crate::machine::Curve::new(&settings, &rows[..], 0, false);
        let mut steepest = 0.0_f64;
        for line in of("at") {
            let (q, truth) = (number(line[2]), number(line[3]));
            let (value, held) = table.at(table.coordinate(q), Direction::POSITIVE);
            assert!(
                (value[0] - truth).abs() < 1e-15 && value[1] == -value[0] && !held,
                "{grid} {q}: {value:?} {truth}"
            );
            assert!((curve.at(q).unwrap() - truth).abs() < 1e-15, "{grid} {q}");
            steepest = steepest.max(number(line[4]).abs());
            compared += 1;
        }
        assert!(curve.steepest().0 >= steepest * (1.0 - 1e-12), "{grid}: {} {steepest}", curve.steepest().0);
    }
    assert_eq!(compared, 3 * 61);
}

#[test]
fn a_rotary_table_wraps_and_a_million_degrees_is_the_angle_itself() {
    let mut rows = rows(&(0..=36).map(|i| -180.0 + 10.0 * f64::from(i)).collect::<Vec<_>>());
    let first = rows[0].forward;
    rows[36].forward = first;
    rows[36].reverse = first;
    for interpolation in [Interpolation::Linear, Interpolation::Cubic] {
        let settings = AxisSettings { interpolation, ..AxisSettings::with_defaults(Axis::C, true) };
        let table = table::<f64, f64>(&settings, &rows);
        let at = |q: f64| table.at(table.coordinate(q), Direction::POSITIVE);
        // 1e6 = 2777 · 360 + 280
        assert_eq!(at(1e6), at(280.0));
        assert_eq!(at(1e6), at(-80.0));
        assert_eq!(at(-1e6), at(80.0));
        assert_eq!(at(180.0), at(-180.0));
        let (before, after) = (at(180.0 - 1e-9).0, at(180.0 + 1e-9).0);
        assert!((before[0] - after[0]).abs() < 1e-10 && !at(1234.5).1);
        // A rotary axis' positioning error, here ECC, is in degrees.
        let (own, _) = at(20.0);
        assert!((own[3] - rows[20].forward[5].to_degrees()).abs() < 1e-15);
        if interpolation == Interpolation::Cubic {
            let slope = |q: f64, h: f64| (at(q + h).0[1] - at(q).0[1]) / h;
            assert!((slope(180.0, 1e-5) - slope(180.0, -1e-5)).abs() < 1e-7, "a kink at the seam");
        }
    }
}

#[test]
fn backlash_and_reverse_columns_act_in_negative_travel_only() {
    let mut rows = rows(&[0.0, 10.0, 20.0]);
    for row in &mut rows {
        row.reverse[0] += 0.004;
    }
    let settings = AxisSettings { backlash: 0.01, ..AxisSettings::with_defaults(Axis::X, false) };
    let table = table::<f64, f64>(&settings, &rows);
    let (forward, reverse) = (table.at(13.0, Direction::POSITIVE).0, table.at(13.0, Direction::NEGATIVE).0);
    assert!((reverse[0] - forward[0] - 0.014).abs() < 1e-15);
    assert_eq!(reverse[1], forward[1]);
}

#[test]
fn dither_within_the_band_does_not_toggle_the_direction() {
    let mut reversal = Reversal::at(10.0_f64);
    assert_eq!(reversal.update(12.0, 1e-3), Direction::POSITIVE);
    let mut noise = Noise::new(3);
    for _ in 0..1000 {
        assert_eq!(reversal.update(12.0 + 0.45e-3 * noise.signed(), 1e-3), Direction::POSITIVE);
    }
    assert_eq!(reversal.update(11.99, 1e-3), Direction::NEGATIVE);
    assert_eq!(reversal.update(11.9905, 1e-3), Direction::NEGATIVE);
    assert_eq!(reversal.update(11.9, 1e-3), Direction::NEGATIVE);
    assert_eq!(reversal.update(11.902, 1e-3), Direction::POSITIVE);
}

/// A drive that wanders around its turning point in steps of about the band's width, with and without the quick check.
fn verdicts_agree<R: Real, P: Position>(seed: u64) {
    let mut noise = Noise::new(seed);
    for band in [0.0, 0.3e-3, 3e-3] {
        let within = P::reach(band * (1.0 - 1e-6));
        let (mut q, mut turns) = (10.0, 0);
        let (mut long, mut short) = (Reversal::at(P::of(q)), Reversal::at(P::of(q)));
        for _ in 0..share(100_000) {
            // Whole and half bands, to hit their ends.
            let step = [0.0, band, 0.5 * band, 1e-3 * noise.signed(), 1e-6][noise.below(5)];
            q += if noise.unit() < 0.5 { step } else { -step };
            let (drive, before) = (P::of(q), long.direction());
            let direction = long.update(drive, R::of(band));
            if !short.continues(drive, within) {
                short.update(drive, R::of(band));
            }
            assert_eq!((short, short.direction()), (long, direction), "{band} {q}");
            turns += u32::from(direction != before);
        }
        assert!(turns > 100, "{turns}");
    }
}

#[test]
fn a_drive_that_goes_on_needs_no_second_look() {
    verdicts_agree::<f64, f64>(21);
    verdicts_agree::<f32, Nanometres>(22);
}

fn compensation<const N: usize>(
    machine: &MachineSettings,
    tables: &[(Axis, Vec<Row>)],
    passes: u8,
) -> Compensation<'static, f64, f64, N> {
    let find = |axis| tables.iter().find(|(a, _)| *a == axis).map(|(_, rows)| &rows[..]);
    let memory = lent(requirement(machine, find));
    Compensation::build(machine, find, &[], passes, memory).unwrap()
}

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

#[test]
fn nine_terms_add_up_and_squareness_tilts_the_travel() {
    let axes = LINEAR.map(|axis| AxisSettings::with_defaults(axis, false));
    let mut machine = Machine::three_axis().axes(&axes).settings();
    machine.location = LocationErrors { a0z: 30e-6, b0z: -20e-6, c0y: 50e-6, ..Default::default() };
    let grid: Vec<f64> = (0..9).map(|i| 50.0 * f64::from(i)).collect();
    let tables: Vec<_> = LINEAR.iter().map(|axis| (*axis, rows(&grid))).collect();
    let compensation = compensation::<3>(&machine, &tables, 1);
    let (x, y, z) = (120.0, 310.0, 75.0);
    let mut held = 0;
    let at = compensation.coordinates(&[x, y, z]);
    let error =
        compensation.errors(&Query::at(&at, &[Direction::POSITIVE; 3], &[ThermalLine::default(); 3]), &mut held);
    let sum: [f64; 3] = core::array::from_fn(|k| [x, y, z].iter().map(|q| plain_linear(&rows(&grid), *q)[k]).sum());
    let truth = [sum[0] - 50e-6 * y - 20e-6 * z, sum[1] - 30e-6 * z, sum[2]];
    for k in 0..3 {
        assert!((error[k] - truth[k]).abs() < 1e-15, "{k}");
    }
    // Beyond the table its value is clamped; the squareness continues.
    let at = compensation.coordinates(&[x, 500.0, z]);
    let beyond =
        compensation.errors(&Query::at(&at, &[Direction::POSITIVE; 3], &[ThermalLine::default(); 3]), &mut held);
    let edge = plain_linear(&rows(&grid), 500.0)[0] - plain_linear(&rows(&grid), y)[0];
    assert_eq!(held, 0b010);
    assert!((beyond[0] - error[0] - edge + 50e-6 * 190.0).abs() < 1e-15);
}

#[test]
fn the_exact_inverse_lands_on_the_command() {
    let axes = LINEAR
        .map(|axis| AxisSettings { interpolation: Interpolation::Cubic, ..AxisSettings::with_defaults(axis, false) });
    let machine = Machine::three_axis().axes(&axes).settings();
    // Steep: 25 µm per 1 mm.
    let grid: Vec<f64> = (0..64).map(f64::from).collect();
    let tables: Vec<_> = LINEAR.iter().map(|axis| (*axis, rows(&grid))).collect();
    let compensation = compensation::<3>(&machine, &tables, 8);
    let thermal = [ThermalLine::new(0.01, 1e-4).unwrap(); 3];
    let mut noise = Noise::new(4);
    for _ in 0..5000 {
        let q = noise.vector(30.0).map(|q| 31.5 + q);
        let at = compensation.coordinates(&q);
        let r = compensation.correction(&Query::at(&at, &[Direction::POSITIVE; 3], &thermal), &mut 0);
        let there = compensation.coordinates(&[q[0] + r[0], q[1] + r[1], q[2] + r[2]]);
        let error = compensation.errors(&Query::at(&there, &[Direction::POSITIVE; 3], &thermal), &mut 0);
        for k in 0..3 {
            assert!((r[k] + error[k]).abs() < 1e-6, "lands {} mm beside", r[k] + error[k]);
        }
    }
}

#[test]
fn own_and_cross_terms_follow_their_lookup_settings() {
    let mut axes = LINEAR.map(|axis| AxisSettings::with_defaults(axis, false));
    axes[0].lookup = Lookup::Feedback;
    axes[1].cross_lookup = Lookup::Feedback;
    let machine = Machine::three_axis().axes(&axes).settings();
    let grid: Vec<f64> = (0..9).map(|i| 50.0 * f64::from(i)).collect();
    let tables: Vec<_> = LINEAR.iter().map(|axis| (*axis, rows(&grid))).collect();
    let compensation = compensation::<3>(&machine, &tables, 1);
    let (command, feedback) = ([100.0, 110.0, 120.0], [130.0, 145.0, 160.0]);
    let r = compensation.correction(
        &Query {
            command: &command,
            feedback: &feedback,
            directions: &[Direction::POSITIVE; 3],
            thermal: &[ThermalLine::default(); 3],
        },
        &mut 0,
    );
    let e = |q: f64| plain_linear(&rows(&grid), q);
    let truth = [
        e(130.0)[0] + e(145.0)[0] + e(120.0)[0],
        e(100.0)[1] + e(110.0)[1] + e(120.0)[1],
        e(100.0)[2] + e(145.0)[2] + e(120.0)[2],
    ];
    for k in 0..3 {
        assert!((r[k] + truth[k]).abs() < 1e-15, "{k}: {} {}", r[k], truth[k]);
    }
}

#[test]
fn a_rotary_carrier_turns_the_translations_it_carries() {
    // A carries C, and the bed carries A: at A = 90° (workpiece side, turns by −q) C's frame is turned by −90° about X.
    let machine = Machine::five_axis().settings();
    let flat = |error: [f64; 6]| [0.0, 360.0].map(|position| Row { position, forward: error, reverse: error }).to_vec();
    let tables = vec![(Axis::C, flat([0.001, 0.002, 0.003, 0.0, 0.0, 1e-5]))];
    let compensation = compensation::<5>(&machine, &tables, 1);
    let at = compensation.coordinates(&[0.0, 0.0, 0.0, 90.0, 77.0]);
    let e = compensation.errors(&Query::at(&at, &[Direction::POSITIVE; 5], &[ThermalLine::default(); 5]), &mut 0);
    for (k, truth) in [0.001, 0.003, -0.002, 0.0, 1e-5_f64.to_degrees()].into_iter().enumerate() {
        assert!((e[k] - truth).abs() < 1e-16, "{k}: {} {truth}", e[k]);
    }
}

#[test]
fn bad_tables_and_small_memory_are_refused() {
    let settings = AxisSettings::with_defaults(Axis::X, false);
    let build = |rows: &[Row]| {
        let mut memory = lent::<f64>(384);
        AxisTable::<f64, f64>::build(&settings, rows, 1.0, &mut memory).err()
    };
    let good = rows(&[0.0, 1.0, 2.0]);
    assert!(build(&good).is_none());
    assert!(build(&[]).is_some() && build(&good[..1]).is_some());
    assert!(build(&rows(&[0.0, 2.0, 1.0])).is_some() && build(&rows(&[0.0, 1.0, 1.0])).is_some());
    let mut bad = good.clone();
    bad[1].forward[2] = f64::NAN;
    assert!(build(&bad).is_some());
    let mut little = lent::<f64>(20);
    let error = AxisTable::<f64, f64>::build(&settings, &good[..], 1.0, &mut little).err().unwrap();
    assert_eq!((error.field, error.found, error.bound), (Field::Memory, 20.0, Some(24.0)));
}
