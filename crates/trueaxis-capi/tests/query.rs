//! Errors, corrections and feet without a state.

use crate::machines::rust::*;
use crate::machines::*;
use std::ptr::{null, null_mut};
use trueaxis::Conditions;
use trueaxis::compensation::{Direction, ThermalLine};
use trueaxis::tcomp::Tcomp;
use trueaxis_capi::*;

type Query = unsafe extern "C" fn(*const Loop, *const Position, u8, *const f64, *mut Real) -> ResultCode;

fn asked(
    query: Query,
    servo: &Loop,
    at: &[f64],
    negative: u8,
    kelvin: Option<&[f64]>,
) -> Result<Vec<Real>, ResultCode> {
    let positions: Vec<Position> = at.iter().copied().map(position).collect();
    let mut found = vec![9.0; at.len()];
    let kelvin = kelvin.map_or(null(), <[f64]>::as_ptr);
    // SAFETY: all pointers and sizes match their types.
    match unsafe { query(servo, positions.as_ptr(), negative, kelvin, found.as_mut_ptr()) } {
        OK => Ok(found),
        refused => {
            assert!(found.iter().all(|x| *x == 9.0));
            Err(refused)
        }
    }
}

fn same_as_rust<const N: usize>(file: &[u8], points: &[[f64; N]]) {
    let (servo, rust) = (built(file), rust_loop::<N>(file));
    let settings = Tcomp::parse(file).unwrap().settings().clone();
    let mut largest: f64 = 0.0;
    for (i, at) in points.iter().enumerate() {
        let negative = (i * 11) as u8;
        let kelvin: Vec<f64> = (0..N).map(|slot| (slot + i % 3) as f64).collect();
        let mut conditions = Conditions::<R, N>::default();
        for slot in 0..N {
            conditions.directions[slot] =
                if negative >> slot & 1 == 1 { Direction::NEGATIVE } else { Direction::POSITIVE };
        }
        let core = at.map(core_position);
        for heated in [false, true] {
            if heated {
                for (slot, line) in conditions.thermal.iter_mut().enumerate().take(3) {
                    let growth = settings.axes.iter().find(|axis| axis.axis.index() == slot).map(|axis| axis.thermal);
                    *line = ThermalLine::for_axis(&growth.unwrap_or_default(), kelvin[slot]).unwrap();
                }
            }
            let warm: Vec<f64> = kelvin.iter().enumerate().map(|(slot, k)| if slot < 3 { *k } else { 0.0 }).collect();
            let given = heated.then_some(&warm[..]);
            let error = asked(trueaxis_error_at, &servo.servo, at, negative, given).unwrap();
            let correction = asked(trueaxis_correction_at, &servo.servo, at, negative, given).unwrap();
            assert_eq!(error, rust.error_at(&core, &conditions).unwrap(), "{at:?}");
            assert_eq!(correction, rust.correction_at(&core, &conditions).unwrap(), "{at:?}");
            largest = error.iter().fold(largest, |largest, e| largest.max(f64::from(e.abs() as f32)));
        }
    }
    assert!(largest > 1e-3, "{largest}");
}

#[test]
fn errors_and_corrections_are_those_of_rust() {
    let points: &[[f64; 3]] =
        &[[10.0, 20.0, -200.0], [-250.0, 33.3, -100.0], [299.0, -199.0, -1.0], [60.0, -40.0, -390.0]];
    same_as_rust(mill(), &points[..if cfg!(miri) { 1 } else { 3 }]);
}

#[test]
#[cfg_attr(miri, ignore)]
fn five_axes_too() {
    same_as_rust::<5>(&sample("mill-5axis"), &[[60.0, -40.0, 100.0, 10.0, -20.0], [10.0, 20.0, 50.0, -5.0, 200.0]]);
}

#[test]
fn questions_are_checked() {
    let servo = mill_loop();
    let mut bypass = zeroed::<Loop>();
    let size = size_of::<Loop>();
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_loop_bypass(&mut *bypass, size, 3, FAULT_TABLES_REFUSED, PERIOD_NS) }, OK);
    let good = [10.0, 20.0, -200.0];
    for query in [trueaxis_error_at as Query, trueaxis_correction_at] {
        assert_eq!(asked(query, &bypass, &good, 0, None), Err(ERROR_STATE));
        assert_eq!(asked(query, &zeroed::<Loop>(), &good, 0, None), Err(ERROR_UNBUILT));
        assert_eq!(asked(query, &servo.servo, &[10.0, f64::INFINITY, 0.0], 0, None), Err(ERROR_ARGUMENT));
        assert_eq!(asked(query, &servo.servo, &good, 0, Some(&[f64::NAN; 3])), Err(ERROR_ARGUMENT));
        let (at, mut to) = (good.map(position), [0.0; 3]);
        let odd = at.as_ptr().wrapping_byte_add(1);
        // SAFETY: invalid arguments are null or misaligned.
        unsafe {
            assert_eq!(query(null(), at.as_ptr(), 0, null(), to.as_mut_ptr()), ERROR_NULL);
            assert_eq!(query(&*servo.servo, null(), 0, null(), to.as_mut_ptr()), ERROR_NULL);
            assert_eq!(query(&*servo.servo, at.as_ptr(), 0, null(), null_mut()), ERROR_NULL);
            assert_eq!(query(&*servo.servo, odd, 0, null(), to.as_mut_ptr()), ERROR_ALIGNMENT);
            assert_eq!(query(&*servo.servo, at.as_ptr(), 0, odd.cast(), to.as_mut_ptr()), ERROR_ALIGNMENT);
        }
    }
    // Outside the travel an error is defined, but not a correction.
    let outside = [1000.0, 20.0, -200.0];
    assert!(asked(trueaxis_error_at, &servo.servo, &outside, 0, None).is_ok());
    assert_eq!(asked(trueaxis_correction_at, &servo.servo, &outside, 0, None), Err(ERROR_ARGUMENT));
}

#[test]
fn the_nearest_foot_of_a_path() {
    let mut path = Programmed::new(16, 5);
    let mut found = Contour { span: 77, ..output().record.tip };
    let point = [12.0, 3.0, 4.0].map(position);
    let foot = |path: &Path, point: &[Position; 3], found: &mut Contour| {
        // SAFETY: all pointers and sizes match their types.
        unsafe { trueaxis_nearest_foot(path, point.as_ptr(), found) }
    };
    assert_eq!((foot(&path.path, &point, &mut found), found.span), (ERROR_ARGUMENT, 77), "no segment yet");
    assert_eq!(path.line([0.0; 3], [40.0, 0.0, 0.0]), OK);
    assert_eq!(foot(&path.path, &point, &mut found), OK);
    let near = |a: Real, b: f64| (f64::from(a as f32) - b).abs() < 1e-5;
    assert!(near(found.error, 5.0) && near(found.normal, 3.0) && near(found.binormal, 4.0), "{found:?}");
    let spans = found.span;
    assert!((5..8).contains(&spans) && found.lag == 0.0, "{found:?}");
    // A point that is not finite and a path that was not started are refused.
    let unusable = [f64::INFINITY; 3].map(position);
    assert_eq!(foot(&path.path, &unusable, &mut found), ERROR_ARGUMENT);
    assert_eq!(foot(&zeroed::<Path>(), &point, &mut found), ERROR_UNBUILT);
    // SAFETY: invalid arguments are null.
    unsafe {
        assert_eq!(trueaxis_nearest_foot(null(), point.as_ptr(), &mut found), ERROR_NULL);
        assert_eq!(trueaxis_nearest_foot(&*path.path, null(), &mut found), ERROR_NULL);
        assert_eq!(trueaxis_nearest_foot(&*path.path, point.as_ptr(), null_mut()), ERROR_NULL);
    }
    assert_eq!(found.span, spans);
}
