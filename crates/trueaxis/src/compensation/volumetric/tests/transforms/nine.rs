//! The nine terms by the same transforms.

use super::*;
use crate::compensation::nine::NineTerms;

/// The nine terms: translations only, turned with their carrier; each rotary axis' own error in its own position.
#[test]
fn nine_terms_of_rotary_machines_are_turned_with_their_carriers() {
    for (seed, chain) in FIVE.into_iter().enumerate() {
        let mut random = Noise::new(90 + seed as u64);
        let exact = Exact::new(&mut random, chain);
        let order = AxisOrder::<5>::of(&exact.machine).unwrap();
        let scalars = NineTerms::<f64, f64, 5>::requirement(&exact.machine, |axis| exact.rows(axis));
        let mut memory = vec![0.0; scalars];
        let model = NineTerms::build(&order, &exact.machine, |axis| exact.rows(axis), &mut memory).unwrap();
        let thermal = exact.thermal(&order);
        for _ in 0..40 {
            let (all, at) = exact.place(&mut random, &order, 1.0);
            let (mut clamped, mut expected, mut held) = (0, [0.0; 5], Vec::new());
            let errors =
                model.errors(&Query::at(&model.coordinates(&at), &[Direction::POSITIVE; 5], &thermal), &mut clamped);
            let mut tip = DVec3::ZERO;
            for (axis, on_workpiece, carrier, _) in exact.pose(&all).carriers {
                let q = all[axis.index()];
                let ([x, y, z, ..], beyond) = exact.twist(axis, q);
                held.extend(beyond.then_some(axis));
                tip += carrier * DVec3::new(x, y, z);
                let slot = order.slot(axis).unwrap();
                expected[slot] += exact.growth(axis, q);
                if axis.is_rotary() {
                    let located = exact.machine.location.of(axis).unwrap()[axis.index()];
                    let own = exact.twist(axis, q).0[axis.index()] - located;
                    let sense = f64::from(exact.machine.axis(axis).unwrap().direction);
                    expected[slot] += own.to_degrees() * if on_workpiece { -sense } else { sense };
                }
            }
            let location = &exact.machine.location;
            tip.x += location.b0z * all[2] - location.c0y * all[1];
            tip.y -= location.a0z * all[2];
            let expected: [f64; 5] =
                core::array::from_fn(|k| expected[k] + if k < 3 { tip.to_array()[k] } else { 0.0 });
            for (error, expected) in errors.into_iter().zip(expected) {
                assert!((error - expected).abs() < 1e-15, "{chain} {all:?}: {errors:?} {expected:?}");
            }
            assert_eq!(clamped, bits(&order, &held), "{chain} {all:?}");
        }
    }
}

/// Three slides with tables of different kinds: each uses its own.
#[test]
fn nine_terms_of_mixed_tables_are_those_of_each() {
    let mut random = Noise::new(95);
    let mut exact = Exact::new(&mut random, "w b X Y Z t");
    let order = AxisOrder::<3>::of(&exact.machine).unwrap();
    let none = [ThermalLine::new(0.0, 0.0).unwrap(); 3];
    (exact.machine.location.c0y, exact.machine.location.b0z, exact.machine.location.a0z) = (0.0, 0.0, 0.0);
    let cubic = crate::machine::Interpolation::Cubic;
    let errors = |exact: &Exact, which: &[usize], at: &[f64; 3]| {
        let rows = |axis: Axis| which.contains(&axis.index()).then(|| exact.rows(axis)).flatten();
        let mut memory = vec![0.0; NineTerms::<f64, f64, 3>::requirement(&exact.machine, rows)];
        let model = NineTerms::build(&order, &exact.machine, rows, &mut memory).unwrap();
        model.errors(&Query::at(&model.coordinates(at), &[Direction::POSITIVE; 3], &none), &mut 0)
    };
    for (kinds, feedback) in [([true, false, false], 9), ([true, true, false], 9), ([true, true, true], 1)] {
        for (slot, is_cubic) in kinds.into_iter().enumerate() {
            let axis = &mut exact.machine.axes[slot];
            axis.interpolation = if is_cubic { cubic } else { crate::machine::Interpolation::Linear };
            axis.lookup = if slot == feedback { Lookup::Feedback } else { Lookup::Command };
        }
        for _ in 0..50 {
            let (_, at) = exact.place(&mut random, &order, 0.9);
            let all = errors(&exact, &[0, 1, 2], &at);
            let each = [0, 1, 2].map(|slot| errors(&exact, &[slot], &at));
            for k in 0..3 {
                let sum: f64 = each.iter().map(|each| each[k]).sum();
                assert!((all[k] - sum).abs() < 1e-18 && sum != 0.0, "{kinds:?} {at:?}: {all:?} {each:?}");
            }
        }
    }
}
