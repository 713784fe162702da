//! The polynomials of a table compared with the table itself and its rows: cached values, and their valid extent.

use super::*;

const BOTH: [Direction; 2] = [Direction::POSITIVE, Direction::NEGATIVE];

/// A table and its inputs.
struct Case {
    grid: Vec<f64>,
    rows: Vec<Row>,
    table: AxisTable<'static, f64, f64>,
}

/// Equidistant and free grids, linear and cubic, with and without separate values for negative travel.
fn cases() -> Vec<Case> {
    let mut noise = Noise::new(41);
    let even: Vec<f64> = (0..9).map(|i| -20.0 + 2.5 * f64::from(i)).collect();
    let free: Vec<f64> = (0..9).map(|i| 3.0 + 2.0 * f64::from(i) + 0.7 * noise.signed()).collect();
    let mut cases = Vec::new();
    for grid in [even, free] {
        for interpolation in [Interpolation::Linear, Interpolation::Cubic] {
            for two_sided in [false, true] {
                let mut rows = rows(&grid);
                if two_sided {
                    rows.iter_mut().for_each(|row| row.reverse[1] += 0.01 * noise.signed());
                }
                let settings = AxisSettings { interpolation, ..AxisSettings::with_defaults(Axis::X, false) };
                let table = table(&settings, &rows);
                cases.push(Case { grid: grid.clone(), rows, table });
            }
        }
    }
    cases
}

impl Case {
    fn at(&self, coordinate: f64, direction: Direction) -> [f64; 4] {
        self.table.at(coordinate, direction).0
    }

    fn start(&self, index: usize) -> f64 {
        self.grid[index] - self.grid[0]
    }

    fn length(&self) -> f64 {
        self.start(self.grid.len() - 1)
    }

    /// Coefficients of an interval per mm, from its start, from four of its values (Newton's divided differences).
    fn polynomial(&self, index: usize, direction: Direction) -> [[f64; 4]; 4] {
        let (start, width) = (self.start(index), self.start(index + 1) - self.start(index));
        let u = [0.1, 0.35, 0.6, 0.9].map(|share| share * width);
        let mut d = u.map(|u| self.at(start + u, direction));
        for level in 1..4 {
            for i in (level..4).rev() {
                d[i] = core::array::from_fn(|k| (d[i][k] - d[i - 1][k]) / (u[i] - u[i - level]));
            }
        }
        // From Newton's form to powers.
        core::array::from_fn(|power| {
            core::array::from_fn(|k| {
                let [a, b, c, d] = [d[0][k], d[1][k], d[2][k], d[3][k]];
                match power {
                    0 => a - u[0] * b + u[0] * u[1] * c - u[0] * u[1] * u[2] * d,
                    1 => b - (u[0] + u[1]) * c + (u[0] * u[1] + u[0] * u[2] + u[1] * u[2]) * d,
                    2 => c - (u[0] + u[1] + u[2]) * d,
                    _ => d,
                }
            })
        })
    }
}

#[test]
fn a_piece_is_the_interval_about_the_place() {
    for case in cases() {
        let last = case.grid.len() - 2;
        for step in -40..=440 {
            let place = case.length() * f64::from(step) / 400.0;
            let inside = place.clamp(0.0, case.length());
            for direction in BOTH {
                let piece = case.table.piece(place, direction);
                let index = (0..=last).rev().find(|&i| case.start(i) <= inside).unwrap();
                let width = case.start(index + 1) - case.start(index);
                assert!((piece.length * piece.unit - width).abs() < 1e-12, "{place}");
                assert!((piece.t * piece.unit - (inside - case.start(index))).abs() < 1e-12, "{place}: {}", piece.t);
                assert!((piece.rate * piece.unit - 1.0).abs() < 1e-15);
                assert_eq!(piece.ends, [index == 0, index == last], "{place}");
                let truth = case.at(place, direction);
                for (value, truth) in piece.at(piece.t).iter().zip(truth) {
                    assert!((value - truth).abs() < 1e-15, "{place}: {value} {truth}");
                }
            }
        }
    }
    let none = AxisTable::<f64, f64>::zero().piece(3.0, Direction::POSITIVE);
    assert_eq!(none.at(0.5), [0.0; 3]);
}

#[test]
fn an_interval_says_how_far_it_goes_and_what_it_is_there() {
    for case in cases() {
        let last = case.grid.len() - 2;
        for step in 0..=400 {
            let place = case.length() * (f64::from(step) + 0.3) / 401.0;
            let index = (0..=last).rev().find(|&i| case.start(i) <= place).unwrap();
            let (below, above) = (place - case.start(index), case.start(index + 1) - place);
            for direction in BOTH {
                let found = case.table.interval(place, direction);
                assert!((found.below - below).abs() < 1e-12 && (found.above - above).abs() < 1e-12, "{place}");
                assert_eq!((found.inner, found.edge), ([index > 0, index < last], false), "{place}");
                let [low, high] = found.rooms(0.01);
                assert!((low - below - if index > 0 { 0.01 } else { 0.0 }).abs() < 1e-12);
                assert!((high - above - if index < last { 0.01 } else { 0.0 }).abs() < 1e-12);
                // The Taylor series around the place equals the table within the interval.
                let ([value, slope], rest) = found.powers(found.t);
                for share in [-0.99, -0.4, 0.3, 0.99] {
                    let h = share * if share < 0.0 { below } else { above };
                    for (k, truth) in case.at(place + h, direction).into_iter().enumerate() {
                        let bent = rest.map_or(0.0, |[second, third]| h * h * (second[k] + h * third[k]));
                        assert!((value[k] + h * slope[k] + bent - truth).abs() < 1e-14, "{place} {h}");
                    }
                }
            }
        }
    }
}

#[test]
fn beyond_a_table_its_edge_value_is_constant() {
    for case in cases() {
        for direction in BOTH {
            for (place, edge) in [(-3.0, 0.0), (case.length() + 2.0, case.length())] {
                let found = case.table.interval(place, direction);
                assert!(found.edge && found.inner == [false; 2]);
                let rooms = if place < 0.0 { (f64::MAX, 3.0) } else { (2.0, f64::MAX) };
                assert!((found.below - rooms.0).abs() <= 1e-12 && (found.above - rooms.1).abs() <= 1e-12, "{place}");
                let ([value, slope], rest) = found.powers(found.t);
                for (value, truth) in value.iter().zip(case.at(edge, direction)) {
                    assert!((value - truth).abs() < 1e-15);
                }
                assert_eq!(slope, [0.0; 4]);
                assert!(rest.is_none_or(|rest| rest == [[0.0; 4]; 2]));
            }
            // The last point itself: an interval of zero length, clamped only beyond it.
            let found = case.table.interval(case.length(), direction);
            assert!(!found.edge && found.above == 0.0 && found.inner == [false; 2]);
        }
    }
    let none = AxisTable::<f64, f64>::zero().interval(3.0, Direction::POSITIVE);
    assert_eq!((none.below, none.above, none.edge, none.per_mm), (f64::MAX, f64::MAX, false, 1.0));
    assert_eq!(none.powers(0.0), ([[0.0; 4]; 2], None));
}

/// Coefficients about the end of an interval.
fn at_the_end([_, c1, c2, c3]: [[f64; 4]; 4], w: f64) -> [[f64; 4]; 3] {
    [
        core::array::from_fn(|k| c1[k] + 2.0 * w * c2[k] + 3.0 * w * w * c3[k]),
        core::array::from_fn(|k| c2[k] + 3.0 * w * c3[k]),
        c3,
    ]
}

#[test]
fn an_overlap_is_as_long_as_its_tolerance_permits() {
    for case in cases() {
        for tolerance in [1e-9, 0.5e-6, 20e-6, 1e-2] {
            let overlap = case.table.overlap(tolerance);
            let (mut widest, mut strictest) = (0.02_f64, f64::MAX);
            for direction in BOTH {
                for index in 0..case.grid.len() - 1 {
                    let width = case.start(index + 1) - case.start(index);
                    widest = widest.min(0.5 * width);
                    if index == 0 {
                        continue;
                    }
                    let before =
                        at_the_end(case.polynomial(index - 1, direction), case.start(index) - case.start(index - 1));
                    let [_, c1, c2, c3] = case.polynomial(index, direction);
                    let length =
                        |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
                    let [d1, d2, d3] = [length(before[0], c1), length(before[1], c2), length(before[2], c3)];
                    let strays = |o: f64| d1 * o + d2 * o * o + d3 * o * o * o;
                    assert!(strays(overlap) <= tolerance * (1.0 + 1e-6) + 1e-15, "{overlap}");
                    strictest = strictest.min(
                        (1..=20_000).map(|i| 1e-6 * f64::from(i)).find(|&o| strays(o) > tolerance).unwrap_or(f64::MAX),
                    );
                }
            }
            assert!(
                overlap <= widest && overlap >= 0.89 * widest.min(strictest) - 1e-6,
                "{tolerance}: {overlap} {widest} {strictest}"
            );
        }
    }
    assert_eq!(AxisTable::<f64, f64>::zero().overlap(1e-9), 0.02);
}

#[test]
fn bends_and_kinks_are_those_of_the_polynomials() {
    for case in cases() {
        let (mut bends, mut kinks) = ([0.0_f64; 4], [0.0_f64; 4]);
        for direction in BOTH {
            for index in 0..case.grid.len() - 1 {
                let width = case.start(index + 1) - case.start(index);
                let [_, c1, c2, c3] = case.polynomial(index, direction);
                for k in 0..4 {
                    bends[k] = bends[k].max(2.0 * c2[k].abs() + 6.0 * width * c3[k].abs());
                    if index > 0 {
                        let before = case.polynomial(index - 1, direction)[1];
                        kinks[k] = kinks[k].max((c1[k] - before[k]).abs());
                    }
                }
            }
        }
        let straight = case.table.is_straight();
        let (found_bends, found_kinks) = (case.table.largest_bends(), case.table.largest_kinks());
        for k in 0..4 {
            let truth = if straight { (0.0, kinks[k]) } else { (bends[k], 0.0) };
            assert!((found_bends[k] - truth.0).abs() < 1e-11, "{} {}", found_bends[k], truth.0);
            assert!((found_kinks[k] - truth.1).abs() < 1e-12, "{} {}", found_kinks[k], truth.1);
        }
    }
}

#[test]
fn every_number_of_a_table_is_listed() {
    let numbers = |table: &AxisTable<'_, f64, f64>| {
        let mut numbers = Vec::new();
        table.numbers(&mut |number| numbers.push(number));
        numbers
    };
    for case in cases() {
        let own = numbers(&case.table);
        let (points, sides) = (case.rows.len(), if case.rows[0].forward == case.rows[0].reverse { 1 } else { 2 });
        let powers = if case.table.is_straight() { 2 } else { 4 };
        let knots = if case.table.is_even() || (own[4] * 2.5 - 1.0).abs() < 1e-12 { 0 } else { points };
        assert_eq!(own.len(), 6 + 4 * points * sides * powers + knots);
        assert!(own.contains(&case.grid[0]) && own.contains(&case.grid[points - 1]));
    }
}
