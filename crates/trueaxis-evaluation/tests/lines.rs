//! Points on a line, in a plane that is tilted, and in one that is inclined to the axes.

use std::fmt::Write;
use std::path::Path;
use trueaxis::Axis;
use trueaxis::machine::Row;
use trueaxis_evaluation::points::{COLUMNS, Options, PlaneDocument, PlaneFit, Points, identify_plane};
use trueaxis_evaluation::rows::Rows;
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::machine::Machine as Settings;
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::normal;

/// Errors of the machine that the test makes up, in 1 and rad: dx = sX·x − C0Y·y + B0Z·z, dy = sY·y − A0Z·z, dz = sZ·z.
#[derive(Clone, Copy, Default)]
struct Truth {
    scale: [f64; 3],
    a0z: f64,
    b0z: f64,
    c0y: f64,
    /// Rotation of the instrument.
    turn: [f64; 3],
    /// Sag of Y along X, mm: zero at both ends of ±200 mm and at the middle −1 times this.
    sag_mm: f64,
    noise_mm: f64,
}

impl Truth {
    fn at(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let ([sx, sy, sz], [a, b, c]) = (self.scale, self.turn);
        let sag = self.sag_mm * ((x / 200.0).powi(2) - 1.0);
        [
            sx * x - self.c0y * y + self.b0z * z + b * z - c * y + 0.05,
            sy * y - self.a0z * z + c * x - a * z - 0.02 + sag,
            sz * z + a * y - b * x + 0.03,
        ]
    }

    fn record(&self, places: &[[f64; 3]]) -> String {
        let mut noise = Noise::new(5);
        let mut text = String::from("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm\n");
        for place in places {
            let off = self.at(*place).map(|mm| mm + self.noise_mm * normal(&mut noise));
            let [x, y, z] = *place;
            writeln!(text, "{x},{y},{z},{},{},{}", x + off[0], y + off[1], z + off[2]).unwrap();
        }
        text
    }
}

fn points(text: &str) -> Points {
    Points::read(&mut Rows::new(text.as_bytes(), Path::new("points.csv"), &COLUMNS, |_| {}).unwrap()).unwrap()
}

fn found(text: &str, machine: Option<&Machine>) -> PlaneFit {
    identify_plane(&points(text), machine, &Options::default(), None).unwrap()
}

fn refusal(text: &str) -> String {
    format!("{:#}", identify_plane(&points(text), None, &Options::default(), None).unwrap_err())
}

fn document(text: &str) -> PlaneDocument {
    PlaneDocument::new(&found(text, None), false)
}

#[track_caller]
fn assert_near(is: f64, needed: f64, most: f64) {
    assert!((is - needed).abs() <= most, "{is}, needed {needed} ± {most}");
}

/// A line along X, set at 5 mrad in XY, whose own positions across it follow that setting.
fn line() -> Vec<[f64; 3]> {
    (-20..=20).map(|k| [10.0 * f64::from(k), 40.0 + 0.05 * f64::from(k), -60.0]).collect()
}

#[test]
fn a_line_along_an_axis_gives_its_positioning_and_straightness() {
    let scaled = Truth { scale: [40e-6, 0.0, 0.0], turn: [0.0, 0.0, 3e-3], noise_mm: 1e-3, ..Truth::default() };
    let of = document(&scaled.record(&line()));
    assert_eq!((of.shape, of.plane, of.model.as_str()), ("line", ['X', 'Y'], "scale"), "{:?}", of.models);
    assert_eq!((of.unknowns, of.rank, of.degrees_of_freedom), (4, 4, 2 * 41 - 4));
    let [scale] = &of.terms[..] else { panic!("{:?}", of.terms) };
    // σ/√Σ(x − x̄)², of the textbook.
    let error = of.sigma_um / (100.0 * 2.0 * 2870.0_f64).sqrt() * 1e3;
    assert_eq!(scale.name, "scale X");
    assert_near(scale.of.standard_error, error, 1e-9 * error);
    assert_near(scale.of.value, 40.0, 4.0 * error);
    assert!(of.not_determined[0].starts_with("slope of EYX") && of.not_determined[1].starts_with("C0Y"), "{of:?}");
    assert_near(of.turn_urad, 3000.0, 4.0 * error);
    assert!(
        of.notes.iter().any(|note| note.starts_with("EZX: deviations along Z were measured too")),
        "{:?}",
        of.notes
    );
    // The rotation of the setting is seen across the line, and takes no part in the scale: that would be 15 ppm. C0Y does, by the
    // inclination of the line, which a note names.
    let exact = document(&Truth { noise_mm: 0.0, c0y: 100e-6, ..scaled }.record(&line()));
    assert_near(exact.terms[0].of.value, 39.5, 1e-6);
    assert!(exact.notes.iter().any(|note| note.contains("by 0.0050 of their length")), "{:?}", exact.notes);
}

/// The machine that a line is written into: its axis is corrected, the other axis and the squareness stay.
#[test]
fn a_line_leaves_the_rest_of_the_machine() {
    let row = |position: f64, twist: [f64; 6]| Row { position, forward: twist, reverse: twist };
    let mut machine = machine();
    machine.settings.location.c0y = 25e-6;
    for (slot, old) in
        [[0.01, 0.02, 0.003, 0.0, 0.0, 1e-5], [0.004, 0.005, 0.006, 0.0, 0.0, 0.0]].into_iter().enumerate()
    {
        let rows = vec![row(-300.0, old), row(300.0, old.map(|value| -value))];
        machine.tables[slot] = Some(Table { given: [true; 6], bidirectional: false, rows });
    }
    let truth = Truth { sag_mm: 0.02, noise_mm: 2e-4, c0y: 25e-6, ..Truth::default() };
    let flat: Vec<[f64; 3]> = line().into_iter().map(|[x, ..]| [x, 0.0, 0.0]).collect();
    let found = found(&truth.record(&flat), Some(&machine));
    let written = found.machine.as_ref().unwrap();
    assert!(found.model().starts_with("tables of"), "{}", found.model());
    assert_eq!(written.settings.location.c0y, 25e-6);
    assert_eq!(written.tables[1], machine.tables[1]);
    let rows = written.rows(Axis::X).unwrap();
    let at = |position: f64| rows.iter().find(|row| (row.position - position).abs() < 1e-6).unwrap().forward;
    // Straightness from its value at machine zero; the vertical straightness and the rotations as they were.
    let sag = at(200.0)[1] - at(0.0)[1];
    assert_near(sag, 0.02, 1e-3);
    assert_near(at(200.0)[1], at(-200.0)[1], 1e-3);
    assert_near(at(200.0)[0], 0.0, 1e-3);
    assert_near(at(200.0)[2], -0.002, 1e-12);
    assert_near(at(200.0)[5], -1e-5 / 1.5, 1e-12);
}

fn machine() -> Machine {
    let mut settings = Settings::new("w X' Y' b Z t").settings();
    settings.axes.iter_mut().for_each(|own| own.travel = [-320.0, 320.0]);
    Machine { tables: vec![None; settings.axes.len()], settings, grids: Vec::new() }
}

/// Points over two directions around a middle.
fn lattice(along: [f64; 3], over: [f64; 3]) -> Vec<[f64; 3]> {
    (0..63)
        .map(|k| {
            let (s, t) = (-150.0 + 50.0 * f64::from(k % 7), -160.0 + 40.0 * f64::from(k / 7));
            std::array::from_fn(|c| s * along[c] + t * over[c] + 10.0)
        })
        .collect()
}

/// A plate that its set-up tilts by 10 mrad, under an instrument turned by 3 mrad: both together are 30 ppm, which the deviations
/// across the plane take out. The squareness to Z enters with the tilt.
#[test]
fn a_tilted_plate() {
    let truth =
        Truth { scale: [40e-6, -25e-6, 70e-6], c0y: 30e-6, b0z: 50e-6, turn: [2e-3, 3e-3, 1e-3], ..Truth::default() };
    let of = document(&truth.record(&lattice([1.0, 0.0, 0.01], [0.0, 1.0, 0.004])));
    assert_eq!((of.shape, of.plane, of.model.as_str()), ("plane", ['X', 'Y'], "affine"), "{:?}", of.models);
    // Of the rotations about X and Y, the deviations across the plane also show sZ of the tilt: 0.7 and 0.28 µrad, times the tilt.
    for (term, needed) in of.terms.iter().zip([40.0 + 0.01 * 50.0, -25.0, 30.0 - 0.004 * 50.0]) {
        assert_near(term.of.value, needed, 0.011);
    }
    assert!(of.notes.iter().any(|note| note.contains("errors of the other axes")), "{:?}", of.notes);
}

/// The plane of X and Z, turned by 30° about Z: the scale of Z is seen alone, everything else in combinations.
#[test]
fn an_inclined_plane_gives_what_its_rank_allows() {
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let truth = Truth {
        scale: [40e-6, -25e-6, 70e-6],
        a0z: -15e-6,
        b0z: 50e-6,
        c0y: 30e-6,
        turn: [2e-3, 3e-3, 1e-3],
        ..Truth::default()
    };
    let plane = lattice([cos, sin, 0.0], [0.0, 0.0, 1.0]);
    let text = truth.record(&plane);
    let of = document(&text);
    assert_eq!((of.shape, of.plane, of.terms.len()), ("inclined plane", ['X', 'Z'], 1), "{of:?}");
    assert_eq!(of.terms[0].name, "scale Z");
    assert_near(of.terms[0].of.value, 70.0, 1e-6);
    let along = 0.75 * 40.0 - 0.25 * 25.0 - cos * sin * 30.0;
    let shear = cos * 50.0 + sin * 15.0;
    let needed =
        [format!("0.75·scale X + 0.25·scale Y − 0.43·C0Y = {along:.2}"), format!("−0.50·A0Z + 0.87·B0Z = {shear:.2}")];
    for (is, needed) in of.not_determined.iter().zip(needed) {
        assert!(is.starts_with(&needed[..needed.len() - 1]), "{is}, needed {needed}");
    }
    assert_eq!(of.not_determined.len(), 2);
    // With noise, the standard error of σ/√Σ(z − z̄)².
    let noisy = document(&Truth { noise_mm: 1e-3, ..truth }.record(&plane));
    let error = 1e3 * noisy.sigma_um / (7.0 * 1600.0 * 60.0_f64).sqrt();
    assert_near(noisy.terms[0].of.standard_error, error, 1e-6 * error);
    // Added to the machine: to its table of Z and nothing else.
    let mut machine = machine();
    machine.settings.location.c0y = 5e-6;
    let found = found(&text, Some(&machine));
    let written = found.machine.as_ref().unwrap();
    assert_eq!(written.settings.location, machine.settings.location);
    let rows = written.rows(Axis::Z).unwrap();
    assert_near((rows[1].forward[2] - rows[0].forward[2]) / (rows[1].position - rows[0].position), 70e-6, 1e-10);
    assert!(written.rows(Axis::X).is_none() && written.rows(Axis::Y).is_none());
    // No axis within the plane: nothing is determined.
    let third = 3.0_f64.sqrt().recip();
    let half = 0.5_f64.sqrt();
    let refused = refusal(&truth.record(&lattice([half, -half, 0.0], [third, third, -third])));
    assert!(refused.contains("no scale and no squareness alone but 0.83·scale X + 0.03·scale Y + 0.13·scale Z − 0.07·A0Z − 0.33·B0Z + 0.17·C0Y = 31.17"), "{refused}");
}

/// A line at an angle determines one sum of the terms, which the refusal states.
#[test]
fn an_oblique_line_is_refused_with_what_it_determines() {
    let truth = Truth { scale: [40e-6, -25e-6, 70e-6], c0y: 30e-6, ..Truth::default() };
    let oblique: Vec<[f64; 3]> = (0..30).map(|k| [8.0 * f64::from(k), 6.0 * f64::from(k), 5.0]).collect();
    let refused = refusal(&truth.record(&oblique));
    let value = 0.64 * 40.0 - 0.36 * 25.0 - 0.48 * 30.0;
    let needed = format!(
        "inclined by 36.87° to X, which determines nothing but 0.64·scale X + 0.36·scale Y − 0.48·C0Y = {value:.1}"
    );
    assert!(refused.contains(&needed) && refused.contains("needed a line along an axis"), "{refused}, needed {needed}");
    // Beyond the travel of ±320 mm.
    let far: Vec<[f64; 3]> = line().into_iter().map(|[x, y, z]| [2.0 * x, y, z]).collect();
    let own = points(&truth.record(&far));
    let error = identify_plane(&own, Some(&machine()), &Options::default(), None).unwrap_err().to_string();
    assert!(
        error.contains("line 2: column x_mm: found -400, beyond the travel") && error.ends_with("-320 to 320 mm"),
        "{error}"
    );
    // Positions alone.
    let text: String = (0..30).map(|k| format!("{k},0,0,{},0,0\n", 1.00001 * f64::from(k))).collect();
    let refused = refusal(&format!("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm\n{text}"));
    assert!(refused.contains("found deviations along X alone"), "{refused}");
}
