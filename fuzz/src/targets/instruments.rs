//! Records of tests with instruments: `trueaxis evaluate`. The first byte selects the test.

use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome, refusal};
use std::path::Path;
use trueaxis_evaluation::rows::{Column, Rows};
use trueaxis_evaluation::{diagonal, points, probing, r_test, thermal_test};
use trueaxis_tables::Machine;
use trueaxis_testing::machine::Machine as Settings;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "instruments",
    about: "records of instruments (CSV): diagonals, R-test, points, thermal and probing tests, and their documents",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/csv.dict"),
    slowest: SLOWEST,
};

const FILE: &str = "record.csv";
/// Longer inputs reach nothing new.
const MOST_ROWS: usize = 64;

fn run(bytes: &[u8]) {
    let Some((kind, text)) = bytes.split_first() else { return };
    if text.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() > MOST_ROWS {
        return;
    }
    let result = match kind {
        b'0' => step_diagonal(text),
        b'1' => rotary(text),
        b'2' => volume(text),
        b'3' => drift(text),
        _ => probe(text, *kind),
    };
    if let Err(error) = result {
        refusal::of_file(&format!("{error:#}"), FILE, text);
    }
}

fn rows<'t, const C: usize>(text: &'t [u8], columns: &[Column; C]) -> anyhow::Result<Rows<'t, C>> {
    Rows::new(text, Path::new(FILE), columns, outcome::refused)
}

/// A document of finite numbers: JSON writes others as null, so there must be as many nulls as empty optional fields.
fn finite(values: impl IntoIterator<Item = f64>) {
    values.into_iter().for_each(|value| assert!(value.is_finite(), "{value}"));
}

fn step_diagonal(text: &[u8]) -> anyhow::Result<()> {
    let test = diagonal::read(&mut rows(text, &diagonal::COLUMNS)?)?;
    outcome::accepted();
    let found = diagonal::DiagonalDocument::new(&test, Some(20.0));
    finite([found.e_d_um, found.m_d_um, found.a0z.value, found.b0z.value, found.c0y.value, found.scale.value]);
    assert!(found.diagonals.len() == 4 && found.rank <= 4);
    outcome::saw((found.steps.is_some(), found.r_d_um.is_some(), found.b_d_um.is_some()));
    Ok(())
}

fn rotary(text: &[u8]) -> anyhow::Result<()> {
    let record = r_test::Record::read(&mut rows(text, &r_test::COLUMNS)?)?;
    outcome::accepted();
    let settings = Settings::new("w C' A' Y' b X Z t").settings();
    let machine = Machine { tables: settings.axes.iter().map(|_| None).collect(), grids: Vec::new(), settings };
    let found = r_test::identify(&record, FILE, &machine, &r_test::Options::default())?;
    let document = r_test::RTestDocument::new(&record, &found, &machine);
    finite(document.terms.iter().flat_map(|term| [term.value, term.standard_error]));
    outcome::saw((document.terms.len(), document.balls));
    Ok(())
}

fn volume(text: &[u8]) -> anyhow::Result<()> {
    let points = points::Points::read(&mut rows(text, &points::COLUMNS)?)?;
    outcome::accepted();
    let settings = Settings::new("w X' b Y Z t").settings();
    let machine = Machine { tables: settings.axes.iter().map(|_| None).collect(), grids: Vec::new(), settings };
    let options = points::Options { nodes: Some([2; 3]), ..points::Options::default() };
    match points::identify(&points, &machine, &options) {
        Ok(found) => {
            let document = points::PointsDocument::new(&points, &found);
            finite([document.left.rms_um, document.sigma_um, document.condition]);
            outcome::saw((document.unseen.len(), document.unknowns));
        }
        Err(error) => refusal::in_words(&format!("{error:#}")),
    }
    Ok(())
}

fn drift(text: &[u8]) -> anyhow::Result<()> {
    let test = thermal_test::read(&mut rows(text, &thermal_test::COLUMNS)?)?;
    outcome::accepted();
    let document = thermal_test::ThermalTestDocument::new(&test, "spindle", 1.0, Some(100.0));
    for channel in document.positions.iter().flat_map(|place| &place.channels) {
        finite([channel.range, channel.first_period, channel.worst_period, channel.end]);
        assert!(channel.first_period <= channel.range && channel.worst_period <= channel.range, "{channel:?}");
        assert!(channel.end.abs() <= channel.range, "{channel:?}");
    }
    outcome::saw((document.positions.len(), document.temperatures.len(), document.notes.len()));
    Ok(())
}

fn probe(text: &[u8], kind: u8) -> anyhow::Result<()> {
    let feature = match kind % 3 {
        0 => probing::Feature::Ring,
        1 => probing::Feature::Sphere,
        _ => probing::Feature::Point,
    };
    let record = probing::Record::read(&mut rows(text, &probing::COLUMNS)?, feature, None)?;
    outcome::accepted();
    let document = probing::ProbingDocument::new(&record);
    finite(document.runs.iter().flat_map(|run| run.centre_mm));
    finite(document.p_ftu_um);
    outcome::saw((document.feature, document.runs.len(), document.tip_offset.is_some()));
    Ok(())
}

fn seeds() -> Vec<Vec<u8>> {
    let mut diagonals = String::from("0diagonal,run,direction,x_mm,y_mm,z_mm,deviation_um\n");
    for (k, [sx, sy, sz]) in [[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]].into_iter().enumerate() {
        for direction in [1, -1] {
            for t in 0..4 {
                let at = [sx, sy, sz].map(|sign| 100 * sign * t);
                diagonals += &format!("{},1,{direction},{},{},{},{}.5\n", k + 1, at[0], at[1], at[2], t * t + sx * t);
            }
        }
    }
    let mut rotary = String::from("1a_deg,c_deg,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n");
    for a in [-60, 0, 20] {
        for c in [0, 90, 180, 270] {
            rotary += &format!("{a},{c},{},{},30,{},2.5,{}\n", 50 - c / 4, a, c % 7, a % 5);
        }
    }
    let mut volume = String::from("2x_mm;y_mm;z_mm;actual_x_mm;actual_y_mm;actual_z_mm\n");
    for corner in 0..27 {
        let [x, y, z] = [corner % 3, corner / 3 % 3, corner / 9].map(|k: i32| 100 * k);
        volume += &format!("{x};{y};{z};{x},00{};{y},01;{z}\n", (x * y / 1000) % 7);
    }
    let mut drift = String::from("3t_s,position,x1_um,z_um,x2_um,ambient_c\n");
    for t in 0..30 {
        drift += &format!("{},{},{}.5,{},{t},20.{t}\n", 10 * t, t % 2, t * t % 13, t);
    }
    let mut ring = String::from("6x_mm,y_mm,run,spindle_deg\n");
    for (k, [x, y]) in [[10, 0], [0, 10], [-10, 0], [0, -10], [6, 8]].into_iter().enumerate() {
        ring += &format!("{x},{y}.00{k},1,0\n{y}.00{k},{x},2,180\n");
    }
    let sphere = "7x_mm,y_mm,z_mm\n10,0,0\n-10,0,0\n0,10,0\n0,-10.002,0\n0,0,10.001\n6,8,0\n";
    let point = "8x_mm,y_mm,z_mm\n1,1,1\n1,1,1.001\n1,1,0.999\n";
    [&diagonals[..], &rotary, &volume, &drift, &ring, sphere, point].map(|text| text.as_bytes().to_vec()).into()
}
