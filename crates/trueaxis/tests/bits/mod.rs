//! Results to the last bit, field by field as printed: equal inputs give equal outputs, on every host and from one
//! version to the next. Other tests check whether the values are right; an intended change of a number needs new sums
//! here.

mod chains;
mod gauges;
mod refusals;
mod tables;
mod turning;

use glam::DVec3;
use tables::{servo, tables};
use trueaxis::contour::{
    CommandWindow, ContourSearch, ContourState, Method, Path, Reference, Segment, Span, ToolPath, Turn, convert,
};
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::{AXES, ErrorModel, Interpolation};
use trueaxis::{Nanometres, OnToolPath, Position, Real};
use trueaxis_testing::machine::Machine;
use trueaxis_testing::noise::Noise;

/// FNV-1a hash of the printed results.
struct Sum(u64);

impl Sum {
    fn new() -> Self {
        Sum(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, result: &impl std::fmt::Debug) {
        for byte in format!("{result:?}").bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

fn vector(noise: &mut Noise, size: f64) -> DVec3 {
    DVec3::from_array(noise.vector(size))
}

/// A path without a gap: lines, arcs and helices about various axes, splines with and without weights.
fn spans<R: Real, P: Position>() -> Vec<Span<R, P>> {
    let mut noise = Noise::new(61);
    let (mut all, mut at) = (Vec::new(), DVec3::ZERO);
    for number in 0..28 {
        let made = all.len();
        let mut take = |segment: &Segment<'_>| {
            convert(segment, number, [0.1, 0.0, 1.0], |span| {
                all.push(span);
                Ok(())
            })
            .expect("a segment of a path");
        };
        match number % 4 {
            0 => {
                let end = at + vector(&mut noise, 12.0);
                take(&Segment::Line { start: at, end });
            }
            1 => {
                let normal = if number % 8 == 1 { DVec3::Z } else { vector(&mut noise, 1.0) };
                let across = normal.cross(vector(&mut noise, 1.0)).normalize() * noise.range(0.3, 9.0);
                let center = at + across;
                let n = normal.normalize();
                let (c, s) = [(0.0, 1.0), (-1.0, 0.0), (0.6, -0.8)][noise.below(3)];
                let end = center - across * c - n.cross(across) * s + n * noise.range(-2.0, 2.0);
                take(&Segment::Arc { start: at, end, center, normal, turns: noise.below(2) as u32 });
            }
            2 => {
                let points: Vec<DVec3> =
                    (0..6).map(|i| at + if i == 0 { DVec3::ZERO } else { vector(&mut noise, 9.0) }).collect();
                let knots = [0.0, 0.0, 0.0, 0.0, 0.3, 0.7, 1.0, 1.0, 1.0, 1.0];
                let weights: Vec<f64> = (0..6).map(|_| noise.range(0.5, 2.0)).collect();
                let weights = if number % 8 == 2 { &weights[..] } else { &[] };
                take(&Segment::Nurbs { degree: 3, knots: &knots, points: &points, weights });
            }
            _ => {
                let points: Vec<DVec3> =
                    (0..5).map(|i| at + if i == 0 { DVec3::ZERO } else { vector(&mut noise, 5.0) }).collect();
                let knots = [0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0];
                take(&Segment::Nurbs { degree: 2, knots: &knots, points: &points, weights: &[] });
            }
        }
        assert!(all.len() > made);
        at = DVec3::from_array(all[all.len() - 1].position(R::ONE).map(P::to_f64));
    }
    all
}

fn spans_sum<R: Real, P: Position>() -> u64 {
    let mut sum = Sum::new();
    for span in spans::<R, P>() {
        sum.add(&span);
        for i in 0..=4 {
            let t = R::of(0.25 * f64::from(i));
            let arc = span.arc_length(t);
            sum.add(&(span.position(t), arc, span.t_at(arc), span.u_of(t), span.t_of(span.u_of(t))));
        }
    }
    sum.0
}

fn feet_sum<R: Real, P: Position>() -> u64 {
    let all = spans::<R, P>();
    let mut sum = Sum::new();
    for method in [Method::Guarded, Method::Bisection] {
        let search = ContourSearch::<R>::new(2.0, method).expect("a window");
        for closed in [false, true] {
            let (path, mut noise) = (Path::new(&all, 0, closed), Noise::new(62));
            let mut state = ContourState::default();
            for i in 0..500 {
                let span = if i % 3 == 0 { noise.below(all.len()) } else { i * all.len() / 500 } as u32;
                let reference = Reference { span, t: R::of([noise.unit(), 0.0, 1.0][i % 5 % 3]) };
                let size = [0.0, 1e-4, 0.01, 0.3, 5.0][i % 5];
                let point = all[span as usize].position(reference.t).map(|p| p.plus(R::of(size * noise.signed())));
                sum.add(&search.update(&mut state, &path, reference, point));
                if i % 4 == 0 {
                    sum.add(&search.nearest(&path, reference, point));
                    sum.add(&search.foot_near(&path, reference, &point));
                }
                if i % 25 == 0 {
                    sum.add(&path.nearest(point));
                }
            }
        }
    }
    sum.0
}

fn window_sum<R: Real, P: Position>() -> u64 {
    let (mut sum, mut noise) = (Sum::new(), Noise::new(63));
    for spacing in [0.005, 0.05] {
        let mut window = CommandWindow::<R, P, 32>::new([0.0, 0.0, 1.0], spacing).expect("a window");
        let (mut at, mut way) = (DVec3::ZERO, DVec3::X);
        for i in 0..1500 {
            match i % 100 {
                0 => way = vector(&mut noise, 1.0) * [1e-4, 0.003, 0.02, 0.3][noise.below(4)],
                50 => way = -way,
                70..80 => {}
                _ => way += vector(&mut noise, 0.02) * way.length(),
            }
            if !(70..76).contains(&(i % 100)) {
                at += way;
            }
            if i % 700 == 699 {
                at += DVec3::splat(9.0);
            }
            window.append(at.to_array().map(P::of));
            let point = at - way * 3.0 + vector(&mut noise, 0.002);
            sum.add(&(window.contour_error(point.to_array().map(P::of)), window.reference()));
        }
    }
    sum.0
}

fn inverse_sum<R: Real>() -> u64 {
    let (mut sum, mut noise) = (Sum::new(), Noise::new(64));
    let kinds = [
        ("w X' Y' b Z C A t", [0.0, 0.0, 1.0]),
        ("w b X Y Z A B t", [0.0, 0.0, 1.0]),
        ("w Y' b X Z A C t", [0.0, 1.0, 0.0]),
        ("w C' X' b Y Z A t", [0.0, 1.0, 0.0]),
        ("w C' A' b X Y Z t", [0.0, 0.3, 1.0]),
        ("w B' A' X' b Y Z t", [0.2, -0.1, 1.0]),
        ("w b X C Y Z A t", [0.0, 0.0, 1.0]),
        ("w C' X' b Y Z t", [0.3, 0.0, 1.0]),
        ("w X' b Y Z t", [0.0, 0.0, 1.0]),
    ];
    for (chain, tool_axis) in kinds {
        let machine = Machine::new(chain).tool(noise.vector(100.0)).travel([-150.0, 130.0], 5.0);
        let machine = machine.each(|axis| axis.offset_mm = noise.vector(60.0));
        let machine = machine.with(|machine| machine.kinematics.tool_axis = tool_axis).settings();
        let kinematics = Kinematics::<R>::new(&machine).expect("a chain");
        for i in 0..120 {
            // Around the ends of the travels, near the singular pose, and several turns away.
            let size = [20.0, 140.0, 200.0, 0.3][i % 4];
            let pose: [R; AXES] = std::array::from_fn(|_| R::of(size * noise.signed()));
            let near: [R; AXES] = std::array::from_fn(|k| pose[k] + R::of([0.0, 1.0, 400.0][i % 3] * noise.signed()));
            let tool = kinematics.forward(&pose);
            sum.add(&(tool, kinematics.singularity_margin_deg(&pose), kinematics.direction(&near)));
            sum.add(&(kinematics.to_bed(&pose, tool.tip), kinematics.to_workpiece(&near, tool.tip)));
            sum.add(&(kinematics.inverse(&tool, &near), kinematics.solutions(&tool, &near)));
        }
    }
    sum.0
}

/// A tilting table with random errors, driven along a tool path.
fn five_axes_sum<R: Real, P: Position>(cubic: bool) -> u64 {
    let mut noise = Noise::new(65);
    let machine = Machine::five_axis().tool([2.0, -3.0, -140.0]).each(|axis| {
        axis.interpolation = if cubic { Interpolation::Cubic } else { Interpolation::Linear };
        axis.offset_mm = noise.vector(50.0);
        axis.backlash = 5e-4;
        axis.hysteresis = 0.02;
    });
    let mut machine = machine.settings();
    machine.compensation.model = ErrorModel::Volumetric;
    machine.compensation.orientation = true;
    (machine.location.c0y, machine.location.b0z, machine.location.a0z) = (1e-5, -2e-5, 1.5e-5);
    let rows = tables(&machine, &mut noise, |_| (0..19).map(|i| -180.0 + 20.0 * f64::from(i)).collect());
    let (servo, _) = servo::<R, P, 5>(&machine, &rows).expect("a valid configuration");
    let kinematics = Kinematics::<R>::new(&machine).expect("a chain");
    let all = spans::<R, P>();
    let turns: Vec<Turn<R>> =
        all.iter().map(|span| Turn::axes(span, [0.0, 1.0], [5.0, 0.0, 10.0], [25.0, 0.0, -30.0])).collect();
    let (path, mut state, mut sum) = (ToolPath::new(Path::new(&all, 0, false), &turns), servo.start(), Sum::new());
    let (mut at, mut way) = ([10.0, 20.0, -30.0, 8.0, 40.0], [0.0; 5]);
    for i in 0..1200 {
        if i % 40 == 0 {
            way = std::array::from_fn(|k| if k < 3 { 0.12 } else { 0.02 } * noise.signed());
        }
        at = std::array::from_fn(|k| at[k] + way[k]);
        let lag = noise.vector(1e-3);
        let command = at.map(P::of);
        let feedback = std::array::from_fn(|k| P::of(at[k] - way[k] + lag[k % 3]));
        let input = servo.input(command, feedback);
        let reference = Reference { span: (i as usize * all.len() / 1200) as u32, t: R::HALF };
        let mut measure = OnToolPath::new(&path, reference, &kinematics);
        sum.add(&servo.step(&mut state, &input, &mut measure, ()));
    }
    sum.0
}

#[track_caller]
fn check(found: &[u64], wanted: &[u64]) {
    assert!(found == wanted, "{found:#x?}");
}

#[test]
fn spans_of_segments() {
    check(&[spans_sum::<f64, f64>(), spans_sum::<f32, Nanometres>()], &[0xaa73_ab07_bb32_2650, 0xffe7_f91b_c2bd_cdda]);
}

#[test]
fn feet_of_points() {
    check(&[feet_sum::<f64, f64>(), feet_sum::<f32, Nanometres>()], &[0x358a_24b7_3284_2ff9, 0xb8a5_24ad_2e31_72c1]);
}

#[test]
fn last_commands_as_the_path() {
    check(
        &[window_sum::<f64, f64>(), window_sum::<f32, Nanometres>()],
        &[0xa99f_7ff3_ab2b_6338, 0x1346_2277_2af1_1c5c],
    );
}

#[test]
fn axes_of_a_tool() {
    check(&[inverse_sum::<f64>(), inverse_sum::<f32>()], &[0x71f9_d7c1_42b6_6e65, 0xebb4_a89a_c5d8_23b5]);
}

#[test]
fn five_axes_along_a_tool_path() {
    let doubles = [false, true].map(five_axes_sum::<f64, f64>);
    let singles = [false, true].map(five_axes_sum::<f32, Nanometres>);
    check(
        &[doubles[0], doubles[1], singles[0], singles[1]],
        &[0xb945_68ee_2cbe_9194, 0xd09b_2864_53ff_8196, 0xc35b_6f8f_2006_5164, 0x3ac7_a8fc_88f8_ae70],
    );
}
