//! A part that is moved about the machine.

use super::plant::{Errors, Known, V, cut, program, run, sub};
use super::{AT, COUNT, KNOWN, part, plate};
use std::path::Path;
use trueaxis_evaluation::predict::{Live, Options, Part, Predicted, predict};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

const ELSEWHERE: V = [25.0, 10.0, 60.0];
const OPTIONS: Options = Options { trials: 200, seed: 7 };

struct Plate {
    machine: Machine,
    stated: Uncertainties,
    program: Program,
    part: Part,
}

impl Plate {
    fn on(known: Option<&Known>) -> Plate {
        let (files, toml) = (Memory::new(Errors::stated().files(known)), Path::new("machine.toml"));
        let (steps, lines) = plate();
        Plate {
            machine: Machine::read_from(&files, toml, &mut |_| {}).unwrap(),
            stated: Uncertainties::read_from(&files, toml).unwrap(),
            program: Program::parse("plate", &program(&steps), "plate.ngc").unwrap(),
            part: Part::read(&part(&lines), Path::new("part.toml")).unwrap(),
        }
    }

    fn live(&self) -> Live {
        Live::new(&self.machine, &self.stated, &self.program, &self.part, OPTIONS.seed).unwrap()
    }

    fn predicted(&self, at_mm: V) -> Vec<Predicted> {
        let part = Part { at_mm, ..self.part.clone() };
        predict(&self.machine, &self.stated, &self.program, &part, OPTIONS).unwrap().features
    }
}

/// Ends of the intervals, those of `found` within `most` of the wanted expanded uncertainty.
fn same_intervals(found: &[Predicted], wanted: &[Predicted], most: impl Fn(&Predicted) -> f64) {
    for (found, wanted) in found.iter().zip(wanted) {
        let [is, was] = [found, wanted].map(|of| of.known.as_ref().unwrap());
        let apart =
            (is.interval_um.low - was.interval_um.low).abs().max((is.interval_um.high - was.interval_um.high).abs());
        let case = format!("{} {}: {:?} for {:?}", found.feature, found.kind, is.interval_um, was.interval_um);
        assert!(apart <= most(wanted) * was.expanded_um + 1e-3, "{case}");
        assert!(is.budget.is_empty() && is.parts_cut == Some(200), "{case}");
    }
}

#[test]
fn where_it_was_prepared_a_moved_part_is_the_predicted_one() {
    let plate = Plate::on(Some(&KNOWN));
    let found = plate.live().at(AT, None).unwrap();
    let wanted = plate.predicted(AT);
    // The same parts cut; derivatives differ from them by a twentieth of the scatter at most.
    let is_cut = |of: &Predicted| of.known.as_ref().unwrap().parts_cut.is_some();
    assert!(wanted.iter().any(is_cut));
    same_intervals(&found.features, &wanted, |of| if is_cut(of) { 1e-5 } else { 0.1 });
}

#[test]
fn elsewhere_values_are_exact_and_so_is_the_scatter_of_what_is_the_same_everywhere() {
    let uniform = Known { shift: 0.0, turn: 0.0, play: 0.0, ..KNOWN };
    let plate = Plate::on(Some(&uniform));
    let live = plate.live();
    let (found, wanted) = (live.at(ELSEWHERE, None).unwrap().features, plate.predicted(ELSEWHERE));
    for ((found, wanted), here) in found.iter().zip(&wanted).zip(plate.predicted(AT)) {
        let [is, was] = [found, wanted].map(|of| [of.uncorrected_um, of.corrected_um]);
        let case = format!("{} {}: {is:?} for {was:?}", found.feature, found.kind);
        assert!(is.iter().zip(was).all(|(is, was)| (is - was).abs() < 1e-6), "{case}");
        assert!((is[0] - here.uncorrected_um).abs() > 0.02, "{case}, as where it was prepared");
    }
    // A position without datums holds the scale of the whole way from the datum of the axis, which the place changes.
    let follows = |of: &Predicted| of.kind != "position" || !of.datums.is_empty();
    let keep = |all: Vec<Predicted>| all.into_iter().filter(follows).collect::<Vec<_>>();
    same_intervals(&keep(found), &keep(wanted), |_| 0.1);
}

#[test]
fn a_shape_deviates_as_another_plant_cuts_it() {
    let plate = Plate::on(None);
    let shapes = predict(&plate.machine, &plate.stated, &plate.program, &plate.part, OPTIONS).unwrap().shapes;
    let (steps, _) = super::plate();
    for is_corrected in [false, true] {
        let places = run(&steps, AT, &Errors::stated(), is_corrected);
        let truth = cut(&places, AT, &Errors::stated(), &[[0.0; 3]; COUNT]);
        for (shape, truth) in shapes.iter().zip(&truth) {
            let deviations = if is_corrected { &shape.corrected_um } else { &shape.uncorrected_um };
            for (at, um) in shape.points_mm.iter().zip(deviations) {
                let away = |point: &[V; 2]| sub(point[1], *at).iter().map(|q| q * q).sum::<f64>();
                let near = truth.iter().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
                let wanted = sub(near[0], near[1]).map(|mm| 1e3 * mm);
                let apart = sub(*um, wanted).iter().map(|q| q * q).sum::<f64>().sqrt();
                assert!(away(near) < 1.0 && apart < 0.2, "{} at {at:?}: {um:?} for {wanted:?}", shape.feature);
            }
        }
    }
    let [top, bore] = [&shapes[0], &shapes[3]];
    assert!(bore.closed && !top.closed && bore.kind == "circle" && top.points_mm.len() == 73);
    assert!(shapes.iter().all(|shape| shape.verdict.is_none() && shape.used.is_some_and(|used| used > 0.0)));
}

#[test]
fn verdict_and_share_of_a_shape_are_those_of_its_worst_characteristic() {
    let plate = Plate::on(Some(&Known { approach: 1.2e-3, ..KNOWN }));
    let found = plate.live().at(AT, None).unwrap();
    let bore = &found.shapes[3];
    let own: Vec<&Predicted> = found.features.iter().filter(|of| of.feature == "f3").collect();
    let verdicts: Vec<&str> = own.iter().map(|of| of.known.as_ref().unwrap().verdict).collect();
    assert!(verdicts.contains(&"undecided") && verdicts.contains(&"conforms"), "{verdicts:?}");
    assert_eq!(bore.verdict, Some("undecided"));
    let high = |of: &&Predicted| of.known.as_ref().unwrap().interval_um.high;
    let widest = own.iter().filter(|of| of.kind == "position").map(|of| high(of) / 6.0).fold(0.0, f64::max);
    assert!((bore.used.unwrap() - widest).abs() < 1e-12 && widest > 1.0, "{:?} for {widest}", bore.used);
}

#[test]
fn a_place_beyond_the_travel_is_refused() {
    let error = Plate::on(Some(&KNOWN)).live().at([150.0, 0.0, 0.0], None).unwrap_err().to_string();
    assert!(error.contains("axis X at") && error.contains("within its travel, -200 to 200 mm"), "{error}");
}
