//! Corrections: the corrected pose by the same transforms.

use super::*;

/// Values of a step's array by axis; zero for absent ones.
fn by_axis<const N: usize>(order: &AxisOrder<N>, values: &[f64; N]) -> [f64; 6] {
    let mut all = [0.0; 6];
    order.axes().into_iter().zip(values).for_each(|(axis, value)| all[axis.index()] = *value);
    all
}

/// Errors left at `q + r`, tip and direction in the bed, with the directions of the present slides and the rotary axes
/// there.
fn left<const N: usize>(exact: &Exact, order: &AxisOrder<N>, q: &[f64; 6], r: &[f64; N]) -> (DVec3, DVec3, Pose) {
    let r = by_axis(order, r);
    let there: [f64; 6] = core::array::from_fn(|k| q[k] + r[k]);
    let (ideal, real, (d, w, _)) = (exact.pose(q), exact.pose(&there), exact.volumetric(&there));
    let back = ideal.workpiece.matrix3.transpose();
    let forth = real.workpiece.matrix3;
    let wanted = real.workpiece.transform_point3(ideal.workpiece.inverse().transform_point3(ideal.tip));
    (real.tip + d - wanted, real.tool + w.cross(real.tool) - forth * (back * ideal.tool), real)
}

fn corrections_of<const N: usize>(chain: &str, orientation: bool, seed: u64) {
    let mut random = Noise::new(seed);
    let mut exact = Exact::new(&mut random, chain);
    exact.machine.compensation.orientation = orientation;
    let present = |axis: &Axis| exact.machine.axis(*axis).is_some();
    exact.with::<N, _>(|model, order| {
        let thermal = exact.thermal(order);
        let mut regular = 0;
        for _ in 0..40 {
            let (all, at) = exact.place(&mut random, order, 0.7);
            let (coordinates, directions) = (model.coordinates(&at), [Direction::POSITIVE; N]);
            let r = model.correction(&Query::at(&coordinates, &directions, &thermal), 6, &mut 0);
            let (tip, tool, pose) = left(&exact, order, &all, &r);
            let of =
                |axis: Axis| pose.carriers.iter().find(|(of, ..)| *of == axis).map(|(_, _, m, _)| *m * along(axis));
            let slides: Vec<DVec3> = [Axis::X, Axis::Y, Axis::Z].into_iter().filter_map(of).collect();
            let rotary: Vec<DVec3> = [Axis::A, Axis::B, Axis::C].into_iter().filter(present).filter_map(of).collect();
            let spanned = match slides[..] {
                [x, y, z] => x.dot(y.cross(z)).abs() > 0.06,
                [x, y] => x.cross(y).length() > 0.06,
                _ => true,
            };
            let singular = rotary.len() == 2 && pose.tool.dot(rotary[0].cross(rotary[1])).abs() < 0.1;
            if !spanned || (orientation && singular) {
                continue;
            }
            regular += 1;
            // The remaining error of the tip is perpendicular to every slide.
            let tip = slides.iter().map(|slide| slide.dot(tip).abs()).fold(0.0, f64::max);
            assert!(tip < CLOSE, "{chain} {all:?}: {tip:e}");
            if orientation {
                let along = |axis: &DVec3| axis.cross(pose.tool).dot(tool).abs();
                let tool = rotary.iter().map(along).fold(0.0, f64::max);
                assert!(tool < 1e-13, "{chain} {all:?}: {tool:e}");
            } else {
                assert!(r[3..].iter().all(|r| *r == 0.0));
            }
        }
        assert!(regular > 15, "{chain}: {regular}");
    });
}

#[test]
fn the_corrected_tip_is_the_ideal_one_in_the_workpiece() {
    for (seed, chain) in FIVE.into_iter().enumerate() {
        for orientation in [false, true] {
            corrections_of::<5>(chain, orientation, 40 + seed as u64);
        }
    }
    corrections_of::<3>("w X' b Y Z t", false, 50);
    for (seed, chain) in
        ["w b X Y Z B t", "w A' X' b Y Z t", "w C' X' b Z t", "w b Y A Z t", "w B' X' Y' b t", "w C' X' b t"]
            .into_iter()
            .enumerate()
    {
        for orientation in [false, true] {
            corrections_of::<4>(chain, orientation, 60 + seed as u64);
        }
    }
    corrections_of::<6>("w A' b X Y Z C B t", false, 70);
}

/// Below a determinant of 0.05 the solution fades by the square of (determinant / 0.05).
#[test]
fn slides_that_hardly_span_space_are_asked_for_less() {
    let mut random = Noise::new(80);
    let exact = Exact::new(&mut random, "w b X Y B Z t");
    exact.with::<4, _>(|model, order| {
        let thermal = exact.thermal(order);
        for angle in [87.5, 89.0, -88.0, -91.5] {
            let all = [30.0, -40.0, 50.0, 0.0, angle, 0.0];
            let at = model.coordinates(&order.axes().map(|axis| all[axis.index()]));
            let query = Query::at(&at, &[Direction::POSITIVE; 4], &thermal);
            let r = model.correction(&query, 1, &mut 0);
            let (d, ..) = exact.volumetric(&all);
            let z = exact.pose(&all).carriers.iter().find(|(axis, ..)| *axis == Axis::Z).unwrap().2 * DVec3::Z;
            let slides = DMat3::from_cols(DVec3::X, DVec3::Y, z);
            let share = slides.determinant() / 0.05;
            assert!(share.abs() < 1.0);
            let wanted = slides.inverse() * -d * (share * share);
            assert!((DVec3::new(r[0], r[1], r[2]) - wanted).length() < 1e-9 * d.length(), "{angle}: {r:?} {wanted}");
        }
    });
}
