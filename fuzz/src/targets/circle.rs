//! Points of a nominally round section: `trueaxis circle` and the desk.

use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome, refusal};
use std::path::Path;
use trueaxis_evaluation::circle::{COLUMNS, CircleDocument, Evaluation};
use trueaxis_evaluation::rows::Rows;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "circle",
    about: "points of a circle (CSV), and the four reference circles about them",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/csv.dict"),
    slowest: SLOWEST,
};

/// With more points, the exact circles take too long here.
const MOST_POINTS: usize = 64;

const FILE: &str = "points.csv";

fn run(bytes: &[u8]) {
    if bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() > MOST_POINTS {
        return;
    }
    let evaluate = || Evaluation::read(&mut Rows::new(bytes, Path::new(FILE), &COLUMNS, |_| {})?);
    match evaluate() {
        Ok(found) => accepted(&found),
        Err(error) => refusal::of_file(&format!("{error:#}"), FILE, bytes),
    }
}

/// Checks that the circles are finite and bound the points as their names say, to rounding.
fn accepted(found: &Evaluation) {
    let points = &found.points;
    assert!(points.len() >= 3 && found.lines.len() == points.len());
    // A carriage return alone ends a row, but not a line.
    assert!(found.lines.windows(2).all(|pair| pair[0] <= pair[1]));
    let size = points.iter().flatten().fold(0.0_f64, |size, q| size.max(q.abs()));
    for circle in found.circles.iter().flatten() {
        let numbers = [circle.centre[0], circle.centre[1], circle.radius, circle.zone, circle.outer, circle.inner];
        assert!(numbers.iter().all(|number| number.is_finite()), "{circle:?}");
        assert!(circle.contacts.iter().all(|contact| *contact < points.len()), "{circle:?}");
        let size = size.max(circle.radius);
        assert!(circle.zone >= 0.0 && circle.inner >= 0.0 && circle.outer >= circle.inner, "{circle:?}");
        let distances = points.iter().map(|[x, y]| (x - circle.centre[0]).hypot(y - circle.centre[1]));
        for distance in distances {
            let rounding = rounding(size, distance);
            let within = circle.inner - rounding..=circle.outer + rounding;
            assert!(within.contains(&distance), "{distance} outside {circle:?} of {points:?}");
        }
    }
    narrowest(found, size);
    outcome::saw(found.circles.each_ref().map(Result::is_ok));
    let document: CircleDocument = found.document();
    let json = serde_json::to_string(&document).expect("a document");
    outcome::accepted();
    assert_eq!(document.refused.len(), found.circles.iter().filter(|circle| circle.is_err()).count(), "{json}");
    document.refused.values().for_each(outcome::refused);
}

/// No zone is narrower than the minimum zone.
fn narrowest(found: &Evaluation, size: f64) {
    let [lsc, mzc, mcc, mic] = &found.circles;
    let Ok(mzc) = mzc else { return };
    for other in [lsc, mcc, mic].into_iter().flatten() {
        let rounding = rounding(size.max(other.radius), other.inner.min(mzc.inner));
        assert!(mzc.zone <= other.zone + rounding, "{mzc:?} wider than {other:?} of {:?}", found.points);
    }
}

/// Rounding of a distance among points as far from the origin as `size`: squares of distances are compared, so points a
/// million radii away cost the near ones digits.
fn rounding(size: f64, distance: f64) -> f64 {
    let square = 16.0 * f64::EPSILON * size * size;
    1e-9 * size + square.sqrt().min(square / distance)
}

fn seeds() -> Vec<Vec<u8>> {
    [
        "x_mm,y_mm\n3,0\n0,3\n-3,0\n0,-3.002\n2,2\n",
        "y_mm;x_mm\n# comment\n0,5;1,5\n2,5;-1\n-0,25;-1,5\n\n0;0\n",
        "x_mm\ty_mm\r\n1e0\t0\r\n0\t1\r\n-1\t0.001\r\n0.1\t-1\r\n",
        "x_mm,z_mm\n3,0\n0,3\n-3,0\n0,-3.002\n",
        "x_mm,y_mm,z_mm\n3,0,1\n0,3,1\n-3,0,1.001\n0,-3.002,1\n",
        "\u{feff}\"x_mm\",\"y_mm\"\n\"1\",\"0\"\n\"0\",\"1\"\n\"-1\",\"0\"\n",
    ]
    .map(|text| text.as_bytes().to_vec())
    .into()
}
