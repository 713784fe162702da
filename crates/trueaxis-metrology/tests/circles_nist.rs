//! Reference circles of the NIST two-dimensional reference pairs and of real indicator records, if available.
//!
//! The data are not part of this repository: the tests read them from the folder that `TRUEAXIS_REFERENCE_DATA` names, and
//! report if it is not set.

use serde_json::Value;
use std::fs;
use std::path::Path;
use trueaxis_metrology::circles::limacon;
use trueaxis_metrology::circles::{
    NoCircle, ReferenceCircle, least_squares, maximum_inscribed, minimum_circumscribed, minimum_zone,
};

fn data(name: &str) -> Option<String> {
    let Some(folder) = std::env::var_os("TRUEAXIS_REFERENCE_DATA") else {
        println!("skipped: TRUEAXIS_REFERENCE_DATA names no folder with {name}");
        return None;
    };
    let file = Path::new(&folder).join(name);
    Some(fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display())))
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_str().and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{name}: {value}"))
}

/// Largest error of a centre, mm, and largest relative error of a zone.
#[derive(Default)]
struct Worst {
    centre: f64,
    zone: f64,
}

#[test]
fn nist_reference_pairs() {
    let Some(text) = data("nist_circle2d.json") else { return };
    let cases: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(cases.len(), 30);
    let mut worst = [Worst::default(), Worst::default(), Worst::default(), Worst::default()];
    for case in &cases {
        let name = case["name"].as_str().unwrap();
        let points: Vec<[f64; 2]> = case["points"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| [0, 1].map(|k| p[k].as_str().unwrap().parse().unwrap()))
            .collect();
        let largest = points.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
        let fit = least_squares(&points).unwrap();
        let nist = &case["nist_fit"];
        let off = [
            fit.centre[0] - number(nist, "cx"),
            fit.centre[1] - number(nist, "cy"),
            2.0 * fit.radius - number(nist, "diameter"),
        ];
        for value in off {
            assert!(value.abs() < 1e-9, "{name}: {off:?}");
            worst[0].centre = worst[0].centre.max(value.abs());
        }
        let mut check = |k: usize, key: &str, circle: &ReferenceCircle| {
            let truth = number(&case[key], "zone");
            let error = (circle.zone - truth).abs();
            // Reading a coordinate as f64 moves a point by up to half a unit in its last place.
            assert!(
                error < 1e-9 * truth + 2.0 * f64::EPSILON * largest,
                "{name} {key}: {} for {truth}: {:e}",
                circle.zone,
                error / truth
            );
            // Three points are on their circle; their zone is only rounding.
            if points.len() > 3 {
                worst[k].zone = worst[k].zone.max(error / truth);
            }
            let off = (circle.centre[0] - number(&case[key], "cx")).hypot(circle.centre[1] - number(&case[key], "cy"));
            worst[k].centre = worst[k].centre.max(off);
        };
        check(0, "lsc", &fit);
        check(1, "mcc", &minimum_circumscribed(&points).unwrap());
        if case["mzc"].is_object() {
            check(2, "mzc", &minimum_zone(&points).unwrap());
            check(3, "mic", &maximum_inscribed(&points).unwrap());
        } else {
            assert_eq!(maximum_inscribed(&points), Err(NoCircle::PartArc), "{name}");
            let zone = minimum_zone(&points).unwrap();
            assert!(zone.zone <= fit.zone, "{name}");
        }
    }
    for (k, name) in ["least squares", "circumscribed", "minimum zone", "inscribed"].iter().enumerate() {
        println!("{name}: centre within {:.1e} mm, zone within {:.1e}", worst[k].centre, worst[k].zone);
    }
}

/// Zones of three records, least squares and minimum, in their units; published with the records to six decimals.
#[test]
fn indicator_records() {
    for (name, lsc, mzc) in
        [("balyrond", 7.579967, 6.907403), ("epsilon", 101.440890, 94.776244), ("tri_lobe", 24.000198, 23.921453)]
    {
        let Some(text) = data(&format!("{name}_sample_data.csv")) else { return };
        let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let place = |column: &str| header.iter().position(|name| *name == column).unwrap();
        let (angle, distance) = (place("angle"), place("distance"));
        let (theta, r): (Vec<f64>, Vec<f64>) = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>())
            .map(|row| (row[angle].to_radians(), row[distance]))
            .unzip();
        let plane: Vec<[f64; 2]> = theta.iter().zip(&r).map(|(t, r)| [r * t.cos(), r * t.sin()]).collect();
        let a =
            [limacon::least_squares_at(&theta, &r).unwrap().zone, limacon::minimum_zone_at(&theta, &r).unwrap().zone];
        let b = [least_squares(&plane).unwrap().zone, minimum_zone(&plane).unwrap().zone];
        println!("{name}: limaçon {a:?}, plane {b:?}");
        // The files contain readings without a known radius: the published figures are those of the limaçon.
        assert!((a[0] - lsc).abs() < 1e-6 && (a[1] - mzc).abs() < 1e-6, "{name}: {a:?}");
    }
}
