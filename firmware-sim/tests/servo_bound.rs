//! The bound of `trueaxis predict-servo` against plants drawn from its family.

use std::path::Path;
use trueaxis_evaluation::simulated::servo::{Family, Options, ServoBound, predict};
use trueaxis_sim::program::Program;
use trueaxis_sim::{Scenario, Settings};
use trueaxis_testing::share::share;

/// A circle, an oblique line, a sharp corner at twice the feed, a half circle and a line into the depth.
const TOUR: &str = "G21 G90 G17\nF3000\nG0 X20 Y0\nG3 X20 Y0 I-20 J0\nG1 X40 Y15\nG1 X30 Y-10 F6000\nG2 X50 Y-10 I10 J0\n\
                    G1 X0 Y0 Z-5\nM2\n";
/// A shallow arc at a low feed, on which only Y reverses.
const ARC: &str = "G21 G90 G17\nF800\nG0 X-10 Y0\nG2 X10 Y0 I10 J-30\nM2\n";

fn bound(program: &str, options: Options) -> ServoBound {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../compensation-tables/mill-3axis");
    let machine = trueaxis_evaluation::model::source(&folder, &mut |_| {}).unwrap();
    let program = Program::parse("tour", program, "tour.ngc").unwrap();
    let settings = Settings { rate_hz: 1000.0, ..Settings::default() };
    predict(Scenario::new(machine, program, settings).unwrap(), &options).unwrap()
}

/// 1,000 plants with `TRUEAXIS_TEST_SHARE=1`, otherwise 100, whose worst is up to a third below that of 1,000.
#[test]
fn no_drawn_plant_exceeds_the_bound_of_a_line_and_none_is_far_below() {
    let plants = share(1000);
    let most = if plants >= 1000 { 1.5 } else { 2.0 };
    let resonant = Family { resonance_hz: 90.0, ..Family::default() };
    for (program, family) in [(TOUR, Family::default()), (ARC, Family::default()), (ARC, resonant)] {
        let found = bound(program, Options { family, plants, seed: 1, feed_for_um: None });
        for line in &found.lines {
            let ratio = line.bound_um / line.drawn_um.unwrap();
            println!("line {}: bound {:.3}, ratio {ratio:.3}", line.line, line.bound_um);
            assert!((1.0..most).contains(&ratio), "{family}, line {}: {ratio}", line.line);
            assert!(line.stated_um < line.bound_um);
        }
        let drawn = found.drawn.unwrap();
        assert!(drawn.worst_um <= found.bound_um && found.bound_um < 1.5 * drawn.worst_um, "{drawn:?}");
    }
}

#[test]
fn a_narrower_family_has_a_smaller_bound() {
    let of = |friction| bound(ARC, Options { family: Family { friction, ..Family::default() }, ..Options::default() });
    let [narrow, wide] = [0.1, 0.5].map(of);
    assert!(narrow.bound_um < 0.7 * wide.bound_um, "{} {}", narrow.bound_um, wide.bound_um);
    assert_eq!(narrow.stated_um, wide.stated_um);
}

#[test]
fn the_feeds_found_keep_the_wanted_bound() {
    let found = bound(TOUR, Options { feed_for_um: Some(2.6), ..Options::default() });
    let mut program: Vec<String> = TOUR.lines().map(str::to_owned).collect();
    let mut slowed = 0;
    for line in &found.lines {
        let feed = line.feed_for.unwrap().feed_per_min.expect("a feed for every line");
        slowed += usize::from(feed < line.feed_per_min);
        let text = &mut program[line.line as usize - 1];
        *text = format!("{} F{feed}", text.split(" F").next().unwrap());
    }
    assert!(slowed > 0 && slowed < found.lines.len(), "{slowed} lines");
    let again = bound(&program.join("\n"), Options::default());
    assert!(again.bound_um <= 2.6, "{}", again.bound_um);
}
