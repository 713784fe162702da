//! The tool through and around the singular pose; reference: the product of homogeneous transforms.

use super::*;
use trueaxis::kinematics::{Branch, BranchTracker, Choice, InverseError, Kinematics, Solution, Tool};
use trueaxis::machine::links;
use trueaxis::{Fault, Real};

/// Tables, heads, heads over tables, slides beyond rotary axes.
const CHAINS: [&str; 12] = [
    "w C' A' Y' b X Z t",
    "w C' A' b X Y Z t",
    "w C' B' X' b Y Z t",
    "w A' B' b X Y Z t",
    "w X' Y' b Z C A t",
    "w b X Y Z C B t",
    "w b X Y Z A B t",
    "w b C A X Y Z t",
    "w C' X' b Y Z A t",
    "w C' Y' b X Z B t",
    "w A' X' b Y Z B t",
    "w Z' C' Y' b X A t",
];
const CONE_DEG: f64 = 0.1;
/// Largest turn of the first axis per degree of tilt, degrees: 180 through the cone.
const FASTEST: f64 = 1.001 * 180.0 / CONE_DEG;

/// A machine with everything disturbed except its tool axis, which is along the first rotary axis of the code.
struct Bench {
    settings: MachineSettings,
    first: Axis,
    second: Axis,
}

fn along(axis: Axis) -> DVec3 {
    [DVec3::X, DVec3::Y, DVec3::Z][axis.index() % 3]
}

impl Bench {
    fn new(chain: &str, noise: &mut Noise) -> Bench {
        let mut settings = machine(chain);
        disturb(noise, &mut settings);
        let rotary: Vec<Axis> = links(chain).unwrap().iter().map(|link| link.axis).filter(|a| a.is_rotary()).collect();
        settings.kinematics.tool_axis = along(rotary[0]).to_array();
        Bench { settings, first: rotary[0], second: rotary[1] }
    }

    fn kinematics<R: Real>(&self) -> Kinematics<R> {
        Kinematics::<R>::new(&self.settings).unwrap()
    }

    /// Direction tilted from the first rotary axis by this angle, towards an azimuth; degrees.
    fn tilted(&self, tilt: f64, azimuth: f64) -> DVec3 {
        let n = along(self.first);
        let across = DVec3::new(n.y, n.z, n.x);
        let (s, c) = azimuth.to_radians().sin_cos();
        n * tilt.to_radians().cos() + (across * c + n.cross(across) * s) * tilt.to_radians().sin()
    }

    fn tool<R: Real>(&self, tip: DVec3, axis: DVec3) -> Tool<R> {
        let [tip, axis] = [tip, axis].map(|v| R::Vec3::from(v.to_array().map(R::of)));
        Tool { tip, axis }
    }

    /// Distance of the tip (mm) and angle of the direction (degrees) from the requested ones, by exact transforms.
    fn off<R: Real>(&self, found: &Solution<R>, tool: &Tool<R>) -> (f64, f64) {
        let [tip, axis] = [tool.tip, tool.axis].map(|v| DVec3::from_array(v.into().map(R::to_f64)));
        let (at, direction) = by_transforms(&self.settings, &found.axes.map(R::to_f64), self.settings.tool_mm);
        (apart(at, tip), axis.cross(direction).length().atan2(axis.dot(direction)).to_degrees())
    }

    /// Checks that the tip is exact, and the error of the direction as reported and at most `most`.
    fn check<R: Real>(&self, found: &Solution<R>, tool: &Tool<R>, most: f64) {
        let rounding = if R::EPSILON.to_f64() > 1e-10 { [2e-3, 1e-4] } else { [1e-9, 1e-11] };
        let (tip, direction) = self.off(found, tool);
        let reported = found.direction_error_deg.to_f64();
        assert!(tip < rounding[0], "{}: {tip:e} mm, {found:?}", self.settings.chain);
        assert!((direction - reported).abs() < rounding[1], "{}: {direction} {found:?}", self.settings.chain);
        assert!(reported <= most, "{}: {found:?}", self.settings.chain);
    }

    fn initial<R: Real>(&self, kinematics: &Kinematics<R>, tip: DVec3, axis: DVec3, turn: f64) -> Solution<R> {
        let mut near = [R::ZERO; AXES];
        near[self.first.index()] = R::of(turn);
        kinematics.inverse(&self.tool(tip, axis), &near).unwrap()
    }
}

const TIP: DVec3 = DVec3::new(120.0, -35.0, 60.0);

/// Vectors that equal the pole except for the sixth decimal: the axis next to the workpiece does not move at all.
fn noise_about_the_pole<R: Real>() {
    let mut noise = Noise::new(400);
    for chain in CHAINS {
        let bench = Bench::new(chain, &mut noise);
        let kinematics = bench.kinematics::<R>();
        let start = bench.initial(&kinematics, TIP, bench.tilted(0.0, 0.0), 33.0);
        let mut tracker = BranchTracker::new(&start, R::of(0.05));
        let mut near = start.axes;
        for _ in 0..300 {
            let axis = (bench.tilted(0.0, 0.0) + DVec3::from_array(noise.vector(1e-6))).normalize();
            let tool = bench.tool::<R>(TIP, axis);
            for found in [kinematics.inverse(&tool, &near).unwrap(), tracker.next(&kinematics, &tool).unwrap()] {
                assert_eq!(found.axes[bench.first.index()], R::of(33.0), "{chain}: {found:?}");
                bench.check(&found, &tool, 1e-4);
                near = found.axes;
            }
            for choice in [Choice::First, Choice::Second] {
                let found = kinematics.solutions(&tool, &near).unwrap().choose(choice).unwrap();
                assert_eq!(found.axes[bench.first.index()], R::of(33.0), "{chain}: {found:?}");
                bench.check(&found, &tool, 1e-4);
            }
        }
    }
}

#[test]
fn noise_about_the_pole_turns_nothing() {
    noise_about_the_pole::<f64>();
    noise_about_the_pole::<f32>();
}

/// From 2 degrees on one side to 2 on the other, past the pole at a distance, with noise in the sixth decimal of every
/// vector: the second axis passes through; the first one moves only as far as the distance and the noise require
/// outside the cone.
fn straight_through<R: Real>(cone_deg: f64) {
    let mut noise = Noise::new(401);
    for chain in CHAINS {
        for (lateral_deg, decimals) in [(0.0, 0.0), (0.0, 1e-6), (0.02, 1e-6), (0.045, 0.0), (-0.09, 0.0)] {
            if cone_deg == 0.0 && (lateral_deg != 0.0 || decimals != 0.0) {
                continue;
            }
            let bench = Bench::new(chain, &mut noise);
            let kinematics = bench.kinematics::<R>().with_singular_cone_deg(R::of(cone_deg));
            let azimuth = 180.0 * noise.signed();
            let mut tracker: Option<BranchTracker<R>> = None;
            let (mut last, mut walked, mut tilts) = (None::<[R; AXES]>, 0.0_f64, [0.0_f64; 2]);
            for i in -200..=200 {
                let tilt = 0.01 * f64::from(i);
                let across = bench.tilted(90.0, azimuth) * tilt.to_radians();
                let aside = bench.tilted(90.0, azimuth + 90.0) * f64::to_radians(lateral_deg);
                let by = DVec3::from_array(noise.vector(decimals));
                let axis = (bench.tilted(0.0, 0.0) + across + aside + by).normalize();
                let tool = bench.tool::<R>(TIP, axis);
                let found = match &mut tracker {
                    None => bench.initial(&kinematics, TIP, axis, 10.0),
                    Some(tracker) => {
                        tracker.next(&kinematics, &tool).unwrap_or_else(|error| panic!("{chain} {i}: {error}"))
                    }
                };
                let tracker = tracker.get_or_insert_with(|| BranchTracker::new(&found, R::of(40.0)));
                assert_eq!(tracker.direction_error_deg(), found.direction_error_deg);
                let outside = found.singularity_margin_deg >= R::of(cone_deg);
                bench.check(&found, &tool, if outside { 0.0 } else { 0.58 * cone_deg });
                let turn = found.axes[bench.first.index()];
                if let Some(last) = last {
                    walked += (turn - last[bench.first.index()]).to_f64().abs();
                }
                last = Some(found.axes);
                tilts[usize::from(i > -200)] = found.axes[bench.second.index()].to_f64();
            }
            // The azimuth of a line past the pole turns by 180 degrees; outside the cone the first axis follows it, and
            // turns back again if it stays through the middle.
            let off =
                if lateral_deg.abs() < 0.05 { 4.0 * (lateral_deg.abs() / 0.1).asin().to_degrees() } else { 180.0 };
            assert!(walked < off + 2.0 + 400.0 * decimals / 2e-5, "{chain} {lateral_deg} {decimals}: {walked}");
            if lateral_deg.abs() < 0.05 {
                let [before, after] = tilts.map(|tilt| tilt.rem_euclid(360.0));
                let step = (before - after + 180.0).rem_euclid(360.0) - 180.0;
                assert!((step.abs() - 4.0).abs() < 0.02, "{chain}: {before} {after}");
            }
        }
    }
}

#[test]
fn straight_through_the_pole_the_first_axis_stays() {
    straight_through::<f64>(CONE_DEG);
    straight_through::<f32>(CONE_DEG);
}

/// Without a cone the path passes the pole itself on the other branch; nothing deviates, and noise is followed as
/// commanded.
#[test]
fn without_a_cone_the_path_continues_through_the_pole() {
    straight_through::<f64>(0.0);
    let mut noise = Noise::new(402);
    for chain in CHAINS {
        let bench = Bench::new(chain, &mut noise);
        let kinematics = bench.kinematics::<f64>().with_singular_cone_deg(0.0);
        let start = bench.initial(&kinematics, TIP, bench.tilted(1e-4, 0.0), 0.0);
        let mut tracker = BranchTracker::new(&start, 1.0);
        let tool = bench.tool::<f64>(TIP, bench.tilted(1e-4, 70.0));
        let error = tracker.next(&kinematics, &tool).unwrap_err();
        assert!(
            matches!(error, InverseError::TooFast { axis, step_deg, .. }
            if axis == bench.first && (step_deg - 70.0).abs() < 1e-6),
            "{chain}: {error}"
        );
        // Far from the pole a change of branch is still refused, however large the permitted steps.
        let start = bench.initial(&kinematics, TIP, bench.tilted(30.0, 0.0), 0.0);
        let mut tracker = BranchTracker::new(&start, 100.0);
        let error = tracker.next(&kinematics, &bench.tool(TIP, bench.tilted(30.0, 120.0))).unwrap_err();
        assert!(matches!(error, InverseError::BranchChange { .. }), "{chain}: {error}");
    }
}

/// In at one azimuth, out at another: the first axis turns in proportion to the path, on every requested branch.
fn out_at_another_azimuth<R: Real>() {
    let mut noise = Noise::new(403);
    for chain in CHAINS {
        let bench = Bench::new(chain, &mut noise);
        let kinematics = bench.kinematics::<R>();
        for (deep, turn) in [(0.0, 90.0), (0.03, 150.0), (0.01, -60.0), (0.07, 120.0), (0.0, 180.0)] {
            for choice in [Choice::Nearest, Choice::First, Choice::Second] {
                let from = 360.0 * noise.unit();
                let first = bench.tool::<R>(TIP, bench.tilted(0.3, from));
                let mut last = kinematics.solutions(&first, &[R::ZERO; AXES]).unwrap().choose(choice).unwrap().axes;
                let mut before = [0.3, from];
                for i in 0..=2000 {
                    // In, around, out.
                    let s = 3.0 * f64::from(i) / 2000.0;
                    let tilt = deep + (0.3 - deep) * (1.0 - s).max(s - 2.0).max(0.0);
                    let azimuth = from + turn * (s - 1.0).clamp(0.0, 1.0);
                    let tool = bench.tool::<R>(TIP, bench.tilted(tilt, azimuth));
                    let found = match choice {
                        Choice::Nearest => kinematics.inverse(&tool, &last),
                        _ => kinematics.solutions(&tool, &last).and_then(|both| both.choose(choice)),
                    };
                    let found = found.unwrap_or_else(|error| panic!("{chain} {deep} {turn} {i}: {error}"));
                    let outside = found.singularity_margin_deg >= R::of(CONE_DEG);
                    let (most, times) = if choice == Choice::Nearest { (0.58, 1.0) } else { (1.0, 2.0) };
                    bench.check(&found, &tool, if outside { 0.0 } else { most * CONE_DEG });
                    let [first, second] = [bench.first, bench.second]
                        .map(|axis| (found.axes[axis.index()] - last[axis.index()]).to_f64().abs());
                    let moved = [(tilt - before[0]).abs(), (azimuth - before[1]).abs()];
                    let rounding = if R::EPSILON.to_f64() > 1e-10 { 0.05 } else { 1e-6 };
                    assert!(
                        first <= times * FASTEST * moved[0] + moved[1] + rounding && second < 0.01,
                        "{chain} {deep} {turn} {i}: {first} {second} {moved:?}"
                    );
                    (last, before) = (found.axes, [tilt, azimuth]);
                }
                // Outside the cone the pose is exact, on the requested branch.
                let axis = bench.tilted(0.3, from + turn);
                let (_, direction) = by_transforms(&bench.settings, &last.map(R::to_f64), bench.settings.tool_mm);
                assert!(apart(direction, axis) < 2e-6, "{chain} {deep} {turn}");
            }
        }
    }
}

#[test]
fn positions_go_with_the_path_through_the_cone() {
    out_at_another_azimuth::<f64>();
    out_at_another_azimuth::<f32>();
}

/// The first axis turns as fast as it may while the tool is within the cone of the commanded one; a path that needs
/// more is refused with the axis, and the pose stays.
fn as_fast_as_the_axis_may<R: Real>() {
    let mut noise = Noise::new(404);
    for chain in CHAINS {
        let bench = Bench::new(chain, &mut noise);
        let kinematics = bench.kinematics::<R>();
        // 90 degrees at 0.1 per call; the direction moves by `speed` per call.
        for (speed, passes) in [(1e-4, true), (1.9e-4, true), (4e-4, false), (1e-2, false)] {
            let start = bench.initial(&kinematics, TIP, bench.tilted(0.3, 0.0), 0.0);
            let mut tracker = BranchTracker::new(&start, R::of(0.1));
            let (mut s, mut refused, mut off, mut late) = (-0.3_f64, None, 0.0_f64, 0);
            while s < 0.6 && refused.is_none() {
                let tool = bench.tool::<R>(TIP, bench.tilted(s.abs(), if s < 0.0 { 0.0 } else { 90.0 }));
                let before = *tracker.axes();
                match tracker.next(&kinematics, &tool) {
                    Ok(found) => {
                        bench.check(&found, &tool, CONE_DEG);
                        assert!(found.step_deg <= R::of(0.1001), "{chain}: {found:?}");
                        assert_eq!(found.direction_error_deg, tracker.direction_error_deg());
                        off = off.max(found.direction_error_deg.to_f64());
                        let outside = found.singularity_margin_deg >= R::of(CONE_DEG);
                        late += i32::from(outside && found.direction_error_deg > R::ZERO);
                    }
                    Err(error) => {
                        assert!(matches!(error, InverseError::TooFast { axis, .. } if axis == bench.first), "{error}");
                        assert_eq!(*tracker.axes(), before);
                        refused = Some(error);
                    }
                }
                s += speed;
            }
            assert_eq!(refused.is_none(), passes, "{chain} {speed}: {refused:?}");
            if passes {
                assert_eq!(tracker.direction_error_deg(), R::ZERO);
                assert!(off > 0.5 * CONE_DEG && (speed < 1.5e-4 || late > 10), "{chain} {speed}: {off} {late}");
            }
        }
    }
}

#[test]
fn the_way_out_is_as_fast_as_the_axis_may_turn() {
    as_fast_as_the_axis_may::<f64>();
    as_fast_as_the_axis_may::<f32>();
}

/// Random directions in and around the cone: within 0.58 of it, exact outside; none refused.
#[test]
fn directions_at_random_are_within_what_is_reported() {
    let mut noise = Noise::new(405);
    for chain in CHAINS {
        let bench = Bench::new(chain, &mut noise);
        for cone in [1e-3, 0.1, 5.0, 45.0] {
            let kinematics = bench.kinematics::<f64>().with_singular_cone_deg(cone);
            let mut near = [0.0; AXES];
            for _ in 0..500 {
                // Also in the direction opposite to the axis.
                let tilt = 1.2 * cone * noise.unit();
                let tilt = if noise.below(4) == 0 { 180.0 - tilt } else { tilt };
                let tool = bench.tool::<f64>(TIP, bench.tilted(tilt, 360.0 * noise.unit()));
                let found = kinematics.inverse(&tool, &near).unwrap();
                let outside = found.singularity_margin_deg >= cone;
                bench.check(&found, &tool, if outside { 0.0 } else { 0.58 * cone });
                near = found.axes;
            }
        }
    }
}

/// A second axis whose travel ends at the pole: the first one must turn round, and does so in the outer half of the
/// cone.
#[test]
fn an_axis_that_ends_at_the_pole_lets_the_other_come_round() {
    let mut noise = Noise::new(406);
    for chain in CHAINS {
        let mut bench = Bench::new(chain, &mut noise);
        let second = bench.second;
        let sense = bench.kinematics::<f64>();
        let start = bench.initial(&sense, TIP, bench.tilted(1.0, 0.0), 0.0).axes[second.index()];
        of(&mut bench.settings, second).travel = if start > 0.0 { [0.0, 90.0] } else { [-90.0, 0.0] };
        let kinematics = bench.kinematics::<f64>();
        let mut near = bench.initial(&kinematics, TIP, bench.tilted(1.0, 0.0), 0.0).axes;
        let begin = near[bench.first.index()];
        let mut largest = 0.0_f64;
        for i in -20_000_i32..=20_000 {
            let tool = bench.tool::<f64>(TIP, bench.tilted(f64::from(i) * 1e-5, 180.0));
            let found = kinematics.inverse(&tool, &near).unwrap();
            bench.check(&found, &tool, 1.000_001 * CONE_DEG);
            let step = (found.axes[bench.first.index()] - near[bench.first.index()]).abs();
            largest = largest.max(step);
            assert!(i.abs() > 5000 || step == 0.0, "{chain} {i}: {step}");
            near = found.axes;
        }
        // 180 degrees on the way out over 0.05 degrees of tilt: 0.036 per point on average.
        assert!(((near[bench.first.index()] - begin).abs() - 180.0).abs() < 1e-6, "{chain}");
        assert!(largest < 0.2, "{chain}: {largest}");
    }
}

/// A travel that begins beyond the pole, within the cone: a pose that it keeps too far from the tool is refused.
#[test]
fn a_travel_that_keeps_the_tool_off_by_more_than_the_cone_is_refused() {
    let mut table = machine("w C' A' Y' b X Z t");
    of(&mut table, Axis::A).travel = [0.05, 90.0];
    let kinematics = Kinematics::<f64>::new(&table).unwrap();
    let near = [0.0, 0.0, 0.0, 0.06, 0.0, 0.0];
    let other = kinematics.forward(&[0.0, 0.0, 0.0, 0.06, 0.0, 180.0]);
    let tool = Tool { tip: TIP, axis: other.axis };
    let error = kinematics.inverse(&tool, &near).unwrap_err();
    let InverseError::SingularPose { margin_deg, cone_deg } = error else { panic!("{error}") };
    assert!((margin_deg - 0.06).abs() < 1e-9 && cone_deg == 0.1);
    assert!(error.to_string().contains("degrees from the singular pose"), "{error}");
    assert_eq!(Fault::SingularPose as u8, 21);
}

/// A tool axis with a component along the second axis stays off the first one: the path crosses and touches the border
/// of reach, also a little beyond it.
#[test]
fn the_border_of_reach_is_a_singular_pose_too() {
    let mut noise = Noise::new(407);
    for (chain, along_second) in [("w C' A' b X Y Z t", 1e-5), ("w b X Y Z C B t", -0.02), ("w C' X' b Y Z A t", 0.3)] {
        let mut bench = Bench::new(chain, &mut noise);
        let axis = (along(bench.first) + along(bench.second) * along_second).normalize();
        bench.settings.kinematics.tool_axis = axis.to_array();
        let kinematics = bench.kinematics::<f64>();
        let border = axis.dot(along(bench.second)).abs().asin().to_degrees();
        for _ in 0..40 {
            let (from, to) = (360.0 * noise.unit(), 4.0 * noise.signed());
            let mut last = bench.initial(&kinematics, TIP, bench.tilted(border + 0.4, from), 0.0);
            for i in 0..=2000 {
                let s = f64::from(i) / 1000.0 - 1.0;
                // Down to 0.04 degrees beyond reach, or to the pole if that is nearer, and out beside it.
                let tilt = (border - 0.04).max(0.0) + 0.44 * s.abs();
                let tool = bench.tool::<f64>(TIP, bench.tilted(tilt, from + to * (s + 1.0)));
                let found =
                    kinematics.inverse(&tool, &last.axes).unwrap_or_else(|error| panic!("{chain} {tilt}: {error}"));
                let outside = found.singularity_margin_deg >= CONE_DEG;
                bench.check(&found, &tool, if outside { 0.0 } else { 0.58 * CONE_DEG });
                let moved = (found.singularity_margin_deg - last.singularity_margin_deg).abs() + 0.44e-3;
                let step = (found.axes[bench.first.index()] - last.axes[bench.first.index()]).abs();
                assert!(step <= FASTEST * moved + 4.4e-3, "{chain} {tilt}: {step} {moved}");
                last = found;
            }
        }
    }
}

/// Out of the cone in one call: on the nearer branch, not on the one followed on the way in.
#[test]
fn out_of_the_cone_in_one_call_on_the_nearer_branch() {
    let bench = Bench::new("w X' Y' b Z C A t", &mut Noise::new(408));
    let kinematics = bench.kinematics::<f64>();
    for (azimuth, branch) in [(0.3, Branch::First), (179.7, Branch::Second)] {
        let solutions = kinematics.solutions(&bench.tool(TIP, bench.tilted(0.2, 0.0)), &[0.0; AXES]).unwrap();
        let start = solutions.choose(Choice::First).unwrap();
        let mut tracker = BranchTracker::new(&start, 1.0);
        tracker.next(&kinematics, &bench.tool(TIP, bench.tilted(0.04, 0.0))).unwrap();
        tracker.next(&kinematics, &bench.tool(TIP, bench.tilted(0.001, 60.0))).unwrap();
        assert!(tracker.direction_error_deg() > 1e-4);
        let tool = bench.tool(TIP, bench.tilted(0.2, azimuth));
        let found = tracker.next(&kinematics, &tool).unwrap();
        bench.check(&found, &tool, 0.0);
        assert_eq!((found.branch, tracker.branch()), (branch, branch));
        tracker.take_back();
        assert!(tracker.direction_error_deg() > 1e-4);
    }
}
