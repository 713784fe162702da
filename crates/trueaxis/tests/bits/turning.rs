//! Tools that turn along spans and on the spot.

use super::{Sum, check, spans};
use trueaxis::contour::{ContourSearch, ContourState, Method, Path, Reference, Segment, Span, ToolPath, Turn, convert};
use trueaxis::kinematics::{BranchTracker, Kinematics};
use trueaxis::machine::AXES;
use trueaxis::{Nanometres, Position, Real};
use trueaxis_testing::machine::Machine;
use trueaxis_testing::noise::Noise;

fn turning_sum<R: Real, P: Position>() -> u64 {
    let mut noise = Noise::new(71);
    let machine = Machine::five_axis().tool([2.0, -3.0, -140.0]).settings();
    let kinematics = Kinematics::<R>::new(&machine).expect("a chain");
    let of_axes = |[a, b, c]: [R; 3]| kinematics.direction(&[R::ZERO, R::ZERO, R::ZERO, a, b, c]);
    let mut all: Vec<Span<R, P>> = Vec::new();
    for (number, span) in spans::<R, P>().into_iter().enumerate() {
        all.push(span);
        if number % 9 == 4 {
            let point = glam::DVec3::from_array(span.position(R::ONE).map(P::to_f64));
            convert(&Segment::Turning { point }, 100 + number as u32, [0.0, 0.0, 1.0], |span| {
                all.push(span);
                Ok(())
            })
            .expect("a turn");
        }
    }
    let (mut angles, mut turns) = ([20.0, 0.0, 30.0], Vec::new());
    for (number, span) in all.iter().enumerate() {
        let end = [20.0 + 15.0 * noise.signed(), 0.0, angles[2] + 25.0 * noise.signed()];
        let heads = [angles, end].map(|[a, b, c]| [a, b, c].map(R::of));
        let around = heads.map(|at| of_axes(at).into()).map(|at: [R; 3]| at.map(|x| x.to_f64()));
        let turn = match number % 3 {
            0 => Turn::directions(span, [0.0, 1.0], around[0], around[1]).expect("less than half a turn"),
            1 => Turn::axes(span, span.u_range(), angles, end),
            _ => Turn::axes(span, [0.0, 1.0], angles, end),
        };
        turns.push(turn);
        angles = end;
    }
    let path = ToolPath::new(Path::new(&all, 0, false), &turns);
    let search = ContourSearch::<R>::new(2.0, Method::Guarded).expect("a window");
    let (mut state, mut sum) = (ContourState::default(), Sum::new());
    for i in 0..900 {
        let span = (i * all.len() / 900) as u32;
        let reference = Reference { span, t: R::of((i * all.len() % 900) as f64 / 900.0) };
        let point = all[span as usize].position(reference.t).map(|p| p.plus(R::of(3e-3 * noise.signed())));
        let tip = search.update(&mut state, path.path(), reference, point);
        let heading = turns[span as usize].direction(reference.t, of_axes);
        let stray = R::Vec3::from([R::of(1e-3 * noise.signed()), R::of(1e-3 * noise.signed()), R::of(1e-3)]);
        let around: [R; 3] = heading.into();
        let stray: [R; 3] = stray.into();
        let actual = R::Vec3::from(std::array::from_fn(|k| around[k] + stray[k]));
        sum.add(&(tip, heading, path.orientation(reference, &tip, actual, of_axes)));
    }
    sum.0
}

fn tracker_sum<R: Real>() -> u64 {
    let (mut noise, mut sum) = (Noise::new(72), Sum::new());
    let machine = Machine::new("w b X Y Z C A t").tool([0.0, 0.0, -140.0]).settings();
    let kinematics = Kinematics::<R>::new(&machine).expect("a chain");
    let mut pose: [R; AXES] = [1.0, 2.0, 3.0, 30.0, 0.0, 10.0].map(R::of);
    let first = kinematics.inverse(&kinematics.forward(&pose), &pose).expect("a pose");
    let mut tracker = BranchTracker::new(&first, R::of(2.0));
    for i in 0..400 {
        let step = if i % 40 == 39 { 30.0 } else { 1.9 };
        let before = pose;
        for (k, at) in pose.iter_mut().enumerate().filter(|(k, _)| *k != 4) {
            *at += R::of(if k < 3 { 1.0 } else { step } * noise.signed());
        }
        let found = tracker.next_after(&kinematics, &kinematics.forward(&pose), R::of(1.0 + f64::from(i % 3)));
        if found.is_err() {
            pose = before;
        }
        if i % 17 == 0 {
            tracker.take_back();
        }
        sum.add(&(found, tracker.axes(), tracker.branch()));
    }
    sum.0
}

#[test]
fn tools_that_turn() {
    check(
        &[turning_sum::<f64, f64>(), turning_sum::<f32, Nanometres>()],
        &[0xf5ae_cb7f_7ee7_521c, 0xb2ad_4498_b956_f356],
    );
}

#[test]
fn a_branch_that_is_followed() {
    check(&[tracker_sum::<f64>(), tracker_sum::<f32>()], &[0xf41f_7f1b_7087_2197, 0xd271_2199_6a61_fd6b]);
}
