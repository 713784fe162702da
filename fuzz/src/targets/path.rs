//! Programmed paths in JSON, as `trueaxis contour` reads them.

use crate::execution::SLOWEST;
use crate::outcome::{accepted, refused, saw};
use crate::{Target, no_repair};
use std::path::Path;
use trueaxis::contour::{ContourSearch, Flags, Method};
use trueaxis_evaluation::path::{MOST_SPANS, PathFile, ProgrammedPath};
use trueaxis_tables::text::decode;

/// Reads a path, cuts it and searches for nearest points.
pub const TARGET: Target = Target {
    name: "path",
    about: "path JSON: read, cut into spans, searched",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/path.dict"),
    slowest: SLOWEST,
};

/// A path with more spans is read but rarely cut: that is slow and shows nothing new.
const MANY: u64 = 2000;

fn seeds() -> Vec<Vec<u8>> {
    let lines = "{\"segments\":[\n{\"type\":\"line\",\"start\":[0,0,0],\"end\":[10,0,0]},\n\
        {\"type\":\"arc\",\"start\":[10,0,0],\"end\":[20,10,1.5],\"center\":[10,10,0],\"normal\":[0,0,1],\"turns\":0}]}\n";
    let circle =
        "{\"segments\":[{\"type\":\"arc\",\"start\":[10,0,0],\"end\":[10,0,0],\"center\":[0,0,0],\"turns\":1}]}";
    let spline = "{\"segments\":[{\"type\":\"nurbs\",\"degree\":3,\"knots\":[0,0,0,0,0.5,1,1,1,1],\
        \"points\":[[0,0,0],[3,4,0],[6,-2,1],[9,5,0],[12,0,0]],\"weights\":[1,0.7,2,1,1]}]}";
    let straight = "{\"segments\":[{\"type\":\"nurbs\",\"degree\":1,\"knots\":[0,0,1,2,2],\"points\":[[0,0,0],[3,4,0],[6,-2,1]]}]}";
    [lines, circle, spline, straight].map(|text| text.as_bytes().to_vec()).to_vec()
}

fn run(input: &[u8]) {
    let file = Path::new("path.json");
    let text = match decode(input.to_vec(), file, &[]) {
        Ok(text) => text,
        Err(error) => return refused(error),
    };
    let path = match PathFile::read(&text, file) {
        Ok(path) => path,
        Err(error) => return refused(error),
    };
    assert!((1..=MOST_SPANS).contains(&path.span_count()));
    if path.span_count() > MANY && input.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) != 0 {
        return saw("many spans");
    }
    match path.cut(&mut |_| saw("gap")) {
        Err(error) => refused(error),
        Ok(cut) => {
            assert!(cut.spans().len() as u64 <= path.span_count(), "more spans than were counted");
            accepted();
            searched(&cut);
        }
    }
}

/// Checks that spans join, and that the search finds the nearest point for a place beside each of the first segments.
fn searched(path: &ProgrammedPath) {
    let search = ContourSearch::new(1.0, Method::Guarded).expect("a window of 1 mm");
    for segment in 0..path.segments().min(8) {
        let [low, high] = path.reference(segment, f64::NAN).expect_err("no range has NaN in it");
        assert!(low < high, "segment {segment} from {low} to {high}");
        let middle = path.reference(segment, low + 0.5 * (high - low)).expect("within its range");
        let on = path.spans()[middle.span as usize].position(middle.t);
        assert!(on.iter().all(|x| x.is_finite()), "{on:?}");
        let nearby = [on[0] + 0.01, on[1] - 0.02, on[2] + 0.005];
        let found = search.nearest(&path.view(), middle, nearby);
        let away = on.iter().zip(nearby).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let scale = on.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
        assert!(found.error.is_finite() && found.lag.is_finite());
        assert!(found.error <= away + 1e-9 * scale, "{} mm to the nearest point, {away} mm to another", found.error);
        saw((path.spans()[middle.span as usize].is_stationary(), found.flags.has(Flags::BRACKETED)));
    }
}
