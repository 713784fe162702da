//! Readings of a ball for identifying the errors of a rotary axis: `trueaxis identify`.

use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome, refusal};
use std::path::Path;
use trueaxis::Axis;
use trueaxis_evaluation::identify::{COLUMNS, Readings, table};
use trueaxis_evaluation::rows::Rows;
use trueaxis_metrology::identification::{Offsets, identify};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "identify",
    about: "readings of a ball (CSV), the errors found from them, and the table of these",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/csv.dict"),
    slowest: SLOWEST,
};

const FILE: &str = "measured.csv";
/// Longer inputs reach nothing new.
const MOST_ROWS: usize = 64;

fn run(bytes: &[u8]) {
    if bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() > MOST_ROWS {
        return;
    }
    let read = || Readings::read(&mut Rows::new(bytes, Path::new(FILE), &COLUMNS, outcome::refused)?);
    match read() {
        Ok(readings) => taken(&readings),
        Err(error) => refusal::of_file(&format!("{error:#}"), FILE, bytes),
    }
}

/// Checks that every set-up has every angle, and the result.
fn taken(readings: &Readings) {
    let angles = &readings.angles_deg;
    assert!(readings.balls.len() >= 3 && readings.deviations_mm.len() == angles.len());
    assert!(readings.deviations_mm.iter().all(|own| own.len() == readings.balls.len()));
    assert!(angles.windows(2).all(|pair| pair[0] < pair[1]) && angles[angles.len() - 1] - angles[0] < 360.1);
    outcome::accepted();
    for (axis, direction, offsets) in
        [(Axis::C, 1.0, Offsets::Known), (Axis::A, -1.0, Offsets::Free), (Axis::B, 1.0, Offsets::Known)]
    {
        let found = match identify(&readings.test(axis, direction), offsets) {
            Ok(found) => found,
            Err(refused) => {
                outcome::refused(refused);
                continue;
            }
        };
        assert_eq!(found.angles.len(), angles.len());
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        for angle in &found.angles {
            assert!(finite(&angle.errors) && finite(&angle.standard_errors) && angle.condition >= 1.0, "{angle:?}");
            assert!(angle.residual_mm >= 0.0 && angle.residual_mm.is_finite() && angle.rank <= 6, "{angle:?}");
        }
        assert!(found.sigma_mm >= 0.0 && found.sigma_mm.is_finite());
        outcome::saw((axis.letter(), found.null_space));
        match table(angles, &found) {
            Ok((table, _)) => {
                assert!(table.rows.windows(2).all(|pair| pair[0].position < pair[1].position), "{:?}", table.rows);
                let travel = table.rows[table.rows.len() - 1].position - table.rows[0].position;
                assert!(travel <= 360.0 + 1e-6, "a table over {travel} degrees");
            }
            Err(error) => outcome::refused(error),
        }
    }
}

fn seeds() -> Vec<Vec<u8>> {
    let mut good = String::from("angle_deg,l_mm,h_mm,dx_um,dy_um,dz_um\n");
    let mut semicolons = String::from("# a ball\nl_mm;h_mm;angle_deg;dz_um;dy_um;dx_um\n");
    for (l, h) in [(100, 50), (200, 50), (100, 150)] {
        for angle in [0, 120, 240] {
            good += &format!("{angle},{l},{h},{}.5,1,-2\n", angle % 7);
        }
        for angle in [0, 180, 360] {
            semicolons += &format!("{l};{h};{angle};0,5;{};1\n", angle % 11);
        }
    }
    let one = "angle_deg\tl_mm\th_mm\tdx_um\tdy_um\tdz_um\n0\t1\t0\t1\t1\t1\n0\t0\t1\t1\t1\t1\n0\t9\t9\t1\t1\t1\n";
    [good.as_bytes(), semicolons.as_bytes(), one.as_bytes()].map(<[u8]>::to_vec).into()
}
