//! Roll, pitch and yaw of the linear axes from touches with two lengths of the stylus, on machines whose error curves the tests
//! write down themselves; the plant's touches are exact transforms.

use std::path::Path;
use trueaxis::machine::Row;
use trueaxis_evaluation::calibrate::{Calibration, Plan, Planning, Task, Term, foresee, perfect, solved};
use trueaxis_evaluation::simulated::rehearsal::{self, Conditions, Drift};
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_sim::calibration::{Class, random_machine};
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::share::share;

const HEAD: &str = "machine = \"mill\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 3.0\nrepeats = 1\n\
                    [solve]\nstraightness_degree = 3\npositioning_degree = 3\nangular_degree = 2\n\
                    [reference]\nartefact = \"ball\"\nevery = 100\n\
                    [[artefact]]\nname = \"ball\"\nkind = \"ball\"\ndiameter_mm = 25.0\nuncertainty_um = 0.3\n\
                    [[artefact.place]]\nat_mm = [40.0, 40.0, -275.0]\nstylus_mm = 100.0\n\
                    [[artefact]]\nname = \"plate\"\nkind = \"ball plate\"\ndiameter_mm = 20.0\nuncertainty_um = 0.3\n\
                    uncertainty_ppm = 1.0\nballs_mm = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [200.0, 0.0, 0.0], \
                    [0.0, 100.0, 0.0], [100.0, 100.0, 0.0], [200.0, 100.0, 0.0], [0.0, 200.0, 0.0], \
                    [100.0, 200.0, 0.0], [200.0, 200.0, 0.0]]\n";

/// Place of the plate, its normal, and the stylus.
type At = ([f64; 3], char, f64);

const PLACES: [At; 9] = [
    ([30.0, 170.0, -270.0], 'Z', 100.0),
    ([270.0, 30.0, -270.0], 'Z', 100.0),
    ([270.0, 170.0, -60.0], 'Z', 100.0),
    ([30.0, 120.0, -280.0], 'Y', 100.0),
    ([270.0, 340.0, -280.0], 'Y', 100.0),
    ([120.0, 30.0, -280.0], 'X', 100.0),
    ([440.0, 170.0, -280.0], 'X', 100.0),
    ([150.0, 150.0, -240.0], 'Y', 200.0),
    ([250.0, 150.0, -240.0], 'X', 200.0),
];

fn task(places: &[At], change: impl Fn(f64) -> f64) -> Task {
    let place = |(at, normal, stylus): &At| {
        let stylus = change(*stylus);
        format!("[[artefact.place]]\nat_mm = {at:?}\nnormal = \"{normal}\"\nstylus_mm = {stylus:?}\n")
    };
    let text = format!("{HEAD}{}", places.iter().map(place).collect::<String>());
    Task::read(&text, Path::new("task.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// Legendre polynomials of degree 1 to 3 between two positions, with their slope beyond these.
fn polynomial(degree: u8, [low, high]: [f64; 2], q: f64) -> f64 {
    let t = (2.0 * q - low - high) / (high - low);
    let inside = t.clamp(-1.0, 1.0);
    let [value, slope] = match degree {
        1 => [inside, 1.0],
        2 => [1.5 * inside * inside - 0.5, 3.0 * inside],
        3 => [2.5 * inside.powi(3) - 1.5 * inside, 7.5 * inside * inside - 1.5],
        _ => panic!("degree {degree}"),
    };
    value + slope * (t - inside)
}

/// Standard deviation of a term that is drawn, mm, rad or 1.
fn usual(term: Term) -> f64 {
    match term {
        Term::Squareness(_) | Term::Curve { degree: 1, component: 0..3, .. } => 40e-6,
        Term::Curve { component: 3.., .. } => 10e-6,
        Term::Backlash(_) => 0.004,
        _ => 0.002,
    }
}

/// A machine of these terms.
fn machine_of(nominal: &Machine, terms: &[Term], values: &[f64], reach: [[f64; 2]; 3]) -> Machine {
    let mut machine = nominal.clone();
    for (slot, own) in nominal.settings.axes.iter().enumerate() {
        let [low, high] = own.travel;
        let axis = own.axis;
        let errors = |q: f64| {
            let mut errors = [0.0; 6];
            for (term, value) in terms.iter().zip(values) {
                let Term::Curve { axis: of, component, degree } = *term else { continue };
                if of == axis && degree == 1 && component < 3 {
                    errors[usize::from(component)] += value * q;
                } else if of == axis {
                    // All errors are zero at the machine's zero.
                    let at = |q| polynomial(degree, reach[axis.index()], q);
                    errors[usize::from(component)] += value * (at(q) - at(0.0));
                }
            }
            errors
        };
        let rows = (0..=300).map(|i| {
            let position = low + (high - low) * f64::from(i) / 300.0;
            Row { position, forward: errors(position), reverse: errors(position) }
        });
        machine.tables[slot] = Some(Table { given: [true; 6], bidirectional: false, rows: rows.collect() });
    }
    for (term, value) in terms.iter().zip(values) {
        match *term {
            Term::Squareness(0) => machine.settings.location.c0y = *value,
            Term::Squareness(1) => machine.settings.location.b0z = *value,
            Term::Squareness(_) => machine.settings.location.a0z = *value,
            Term::Backlash(axis) => {
                machine.settings.axes.iter_mut().filter(|own| own.axis == axis).for_each(|own| own.backlash = *value);
            }
            _ => {}
        }
    }
    machine
}

/// A machine of terms that were drawn, and what was found of them.
pub(crate) struct Rehearsed {
    pub(crate) values: Vec<f64>,
    pub(crate) truth: Machine,
    pub(crate) found: Calibration,
}

impl Rehearsed {
    /// Names of the kinds of terms, and by how many standard errors each value is off.
    pub(crate) fn off(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        let solution = &self.found.solution;
        self.found.observed.terms.terms.iter().zip(&self.values).enumerate().map(|(k, (term, value))| {
            let kind = match term {
                Term::Squareness(_) => "squareness",
                Term::Backlash(_) => "lost motion",
                Term::Location(..) => "centre lines",
                Term::Curve { component: 3.., .. } => "angular",
                Term::Curve { axis, component, degree: 1 } if usize::from(*component) == axis.index() => "scale",
                Term::Curve { axis, component, .. } if usize::from(*component) == axis.index() => "positioning",
                Term::Curve { .. } => "straightness",
            };
            (kind, (solution.values[k] - value) / solution.standard_errors[k])
        })
    }
}

pub(crate) fn rehearsed(task: &Task, seed: u64) -> Rehearsed {
    let nominal = perfect(&random_machine(seed, &Class::MILL));
    let plan = Plan::new(task, &nominal).unwrap_or_else(|error| panic!("{error:#}"));
    let terms = foresee(task, &nominal, &plan).unwrap_or_else(|error| panic!("{error:#}")).observed.terms.terms;
    let mut draws = Draws::new(seed, 7);
    let draw = |term: &Term| {
        let value = usual(*term) * draws.normal();
        if let Term::Backlash(_) = term { value.abs() } else { value }
    };
    let values: Vec<f64> = terms.iter().map(draw).collect();
    let truth = machine_of(&nominal, &terms, &values, plan.reach_mm(task));
    let conditions = Conditions { noise_um: None, drift: Drift::Size(3.0), seed, set_up: seed };
    let log = rehearsal::calibrate(task, &nominal, &truth, &conditions).unwrap_or_else(|error| panic!("{error:#}"));
    let (_, found) = solved(task, &nominal, &log, Path::new("probe.log"), |_| {}).unwrap_or_else(|e| panic!("{e:#}"));
    Rehearsed { values, truth, found }
}

/// Two styli and a plate at several heights, flat and upright: every angular error that moves the tip is found within its band.
#[test]
fn angles_come_back() {
    let task = task(&PLACES, |stylus| stylus);
    let (mut within, mut all) = (0, 0);
    for seed in 1..=share(20) as u64 {
        let Rehearsed { values, found, .. } = rehearsed(&task, seed);
        let (terms, solution) = (&found.observed.terms.terms, &found.solution);
        for (index, (term, value)) in terms.iter().zip(&values).enumerate() {
            let (error, name) = (solution.standard_errors[index], term.name());
            let off = (solution.values[index] - value).abs() / error;
            assert!(off < 4.5, "machine {seed}: {name} {off:.1} standard errors off");
            all += 1;
            within += usize::from(off < 1.96);
            // No stylus along the spindle moves by its roll; that of X or Y depends on the chain.
            if term.is_angle() && !name.starts_with("ECZ") && !name.starts_with("ECX") && !name.starts_with("ECY") {
                assert!(error < 12e-6, "machine {seed}: {name} ± {:.1} µrad of 20", 1e6 * error);
            }
        }
        let notes = found.document(&task, &random_machine(seed, &Class::MILL)).warnings.concat();
        assert!(notes.contains("left at zero within the range assumed") && notes.contains("ECZ"), "{notes}");
        assert!(!notes.contains("EBZ") && !notes.contains("stylus_mm"), "{notes}");
    }
    println!("{within} of {all} terms within 1.96 standard errors");
    assert!(within as f64 > 0.9 * f64::from(all), "{within} of {all}");
}

/// Balls 20 µm off their certificate are off along the plate's own directions, flat and upright: what is left of the touches
/// is the probe's scatter of 1 µm.
#[test]
fn balls_are_off_along_the_directions_of_their_plate() {
    let text = HEAD.replace("uncertainty_um = 0.3\nuncertainty_ppm", "uncertainty_um = 20.0\nuncertainty_ppm");
    let place = |(at, normal, stylus): &At| {
        format!("[[artefact.place]]\nat_mm = {at:?}\nnormal = \"{normal}\"\nstylus_mm = {stylus:?}\n")
    };
    let text = text + &[0, 3, 5].map(|k| place(&PLACES[k])).concat();
    let task = Task::read(&text, Path::new("task.toml")).unwrap_or_else(|error| panic!("{error}"));
    let sigma_mm = rehearsed(&task, 1).found.solution.sigma_mm;
    assert!((0.8e-3..1.2e-3).contains(&sigma_mm), "{sigma_mm}");
}

/// The probe scatters along its travel, also where it touches a ball at an angle of 45°.
#[test]
fn oblique_touches_scatter_like_the_others() {
    const REPEATS: usize = 8;
    let quick = format!("probe_feed_mm_per_min = 300.0\nfeed_mm_per_min = 5000.0\nrepeats = {REPEATS}");
    let text = HEAD.replace("repeats = 1", &quick).replace("every = 100", "every = 20");
    let place = |(at, normal, stylus): &At| {
        format!("[[artefact.place]]\nat_mm = {at:?}\nnormal = \"{normal}\"\nstylus_mm = {stylus:?}\n")
    };
    let text = text.replace("angular_degree = 2", "").replace("_degree = 3", "_degree = 1") + &place(&PLACES[0]);
    let task = Task::read(&text, Path::new("task.toml")).unwrap_or_else(|error| panic!("{error}"));
    let plan = Plan::new(&task, &perfect(&random_machine(1, &Class::MILL))).unwrap();
    let residuals = rehearsed(&task, 1).found.solution.residuals_mm;
    let of_ball = plan.touches.iter().zip(residuals).filter(|(touch, _)| {
        let visit = &plan.visits[touch.visit];
        touch.artefact == 0 && !visit.reference
    });
    let of_ball: Vec<f64> = of_ball.map(|(_, residual)| 1e3 * residual).collect();
    // Thirteen points towards the middle of the ball, sixteen along one axis.
    assert_eq!(of_ball.len(), (13 + 16) * REPEATS);
    let (radial, oblique) = of_ball.split_at(13 * REPEATS);
    for touches in [radial, oblique] {
        let rms = (touches.iter().map(|um| um * um).sum::<f64>() / touches.len() as f64).sqrt();
        assert!((0.85..1.15).contains(&rms), "{rms} µm");
    }
}

/// With one length, a turn of Z about Y and a straightness of Z are one: the plan says so, and what would separate them.
#[test]
fn one_length_leaves_turns_of_z_unseen() {
    let task = task(&PLACES[..7], |_| 100.0);
    let nominal = perfect(&random_machine(1, &Class::MILL));
    let warnings =
        Planning::new(&task, &nominal).unwrap_or_else(|error| panic!("{error:#}")).foreseen.warnings.concat();
    assert!(warnings.contains("EAZ, EBZ, ECZ; a second length of the stylus (stylus_mm)"), "{warnings}");
}

/// What makes no sense is refused with its line.
#[test]
fn angles_of_dials_and_corrected_machines_are_refused() {
    let refused = |text: &str| Task::read(text, Path::new("task.toml")).unwrap_err().to_string();
    let place = "[[artefact.place]]\nat_mm = [30.0, 170.0, -270.0]\n";
    let corrected = format!("compensated = true\n{HEAD}{place}");
    let found = refused(&corrected);
    assert!(
        found.starts_with("task.toml:20: key artefact.place.stylus_mm") && found.contains("compensated = false"),
        "{found}"
    );
    let dial = "machine = \"mill\"\n[indicator]\nrepeatability_um = 1.0\n[[dial]]\nname = \"bar\"\nkind = \"tram\"\n\
                at_mm = [150.0, 200.0, -280.0]\nradius_mm = 100.0\nsweep_mm = [200.0, 200.0]\n[solve]\nangular_degree = 1\n";
    let found = refused(dial);
    assert!(found.contains("angular_degree") && found.contains("certified artefacts"), "{found}");
}
