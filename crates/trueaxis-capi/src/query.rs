//! Errors, corrections and feet without a state: for planners, displays and tests, outside the servo cycle.

use crate::axes::AXES_MAX;
use crate::built::{AnyServo, Built, Loop};
use crate::contour::Contour;
use crate::cycle::first;
use crate::opaque;
use crate::path::Path;
use crate::plugin::{CorePosition, Servo, to_core};
use crate::pointer::{check, slice};
use crate::result::{self, ERROR_ARGUMENT, ERROR_STATE, ResultCode};
use crate::{Position, Real};
use trueaxis::compensation::Direction;
use trueaxis::{Conditions, Fault};

/// Computes the modelled error at a position, actual − ideal: first X, Y, Z of the tip in machine axes (mm), then the
/// errors of the rotary axes themselves (degrees; 0 in a volumetric model).
///
/// `position`, `error`: as many numbers as the loop has axes. `negative`: bit 0 = X, …: the axis travels in its
/// negative direction. `kelvin`: temperatures of the axes above the file's reference, or `NULL`. Outside a table the
/// value at its edge applies. Bounded time. Errors: `_STATE` (a bypass), `_ARGUMENT` (not finite; growth as for
/// `trueaxis_set_thermal`).
///
/// # Safety
/// Pointers are null or point to objects of their types, lists to as many numbers as the loop has axes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_error_at(
    r#loop: *const Loop,
    position: *const Position,
    negative: u8,
    kelvin: *const f64,
    error: *mut Real,
) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { at(r#loop, position, (negative, kelvin), error, Wanted::Error) })
}

/// Computes the correction of a command, mm (degrees): the value to which the step settles at standstill if no limit
/// acts. The inverse is exact; the result is not limited.
///
/// Arguments as for `trueaxis_error_at`. Errors: `_STATE`, `_ARGUMENT` (as for `trueaxis_error_at`; also: outside the
/// travel).
///
/// # Safety
/// As for `trueaxis_error_at`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_correction_at(
    r#loop: *const Loop,
    command: *const Position,
    negative: u8,
    kelvin: *const f64,
    correction: *mut Real,
) -> ResultCode {
    // SAFETY: the caller's promise.
    result::of(unsafe { at(r#loop, command, (negative, kelvin), correction, Wanted::Correction) })
}

/// Finds the foot nearest to a point (three numbers) on the whole path. `lag` is 0. Not real-time: the time grows with
/// the path. Errors: `_ARGUMENT` (not finite, or no segment).
///
/// # Safety
/// Pointers are null or point to objects of their types, `point` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueaxis_nearest_foot(
    path: *const Path,
    point: *const Position,
    contour: *mut Contour,
) -> ResultCode {
    let work = || {
        check(contour)?;
        // SAFETY: the caller's promise.
        let (spans, point) = unsafe { (opaque::content(path)?, slice(point, 3)?) };
        let [x, y, z] = *point else { return Err(ERROR_ARGUMENT) };
        let found = spans.path().nearest([to_core(x), to_core(y), to_core(z)]);
        if !found.is_measured() {
            return Err(ERROR_ARGUMENT);
        }
        // SAFETY: checked; writable by the caller's promise.
        unsafe { contour.write(Contour::of(&found)) };
        Ok(())
    };
    result::of(work())
}

#[derive(Clone, Copy)]
enum Wanted {
    Error,
    Correction,
}

/// # Safety
/// As for the functions above; `conditions`: their `negative` and `kelvin`.
unsafe fn at(
    r#loop: *const Loop,
    position: *const Position,
    (negative, kelvin): (u8, *const f64),
    to: *mut Real,
    wanted: Wanted,
) -> Result<(), ResultCode> {
    check(to)?;
    // SAFETY: the caller's promise.
    let built = unsafe { opaque::content(r#loop) }?;
    let axes = built.servo.axes();
    // SAFETY: the caller's promise.
    let position = unsafe { slice(position, axes) }?;
    // SAFETY: the caller's promise.
    let kelvin = if kelvin.is_null() { &[][..] } else { unsafe { slice(kelvin, axes) }? };
    let found = match &built.servo {
        AnyServo::Three(servo) => asked(built, servo, position, negative, kelvin, wanted),
        #[cfg(all(feature = "rotary", not(feature = "three")))]
        AnyServo::Four(servo) => asked(built, servo, position, negative, kelvin, wanted),
        #[cfg(all(feature = "rotary", not(feature = "three")))]
        AnyServo::Five(servo) => asked(built, servo, position, negative, kelvin, wanted),
        #[cfg(all(feature = "rotary", not(feature = "three")))]
        AnyServo::Six(servo) => asked(built, servo, position, negative, kelvin, wanted),
        AnyServo::Bypass { .. } => Err(ERROR_STATE),
    }?;
    // SAFETY: checked; as many writable numbers by the caller's promise, and not those of a local array.
    unsafe { to.copy_from_nonoverlapping(found.as_ptr(), axes) };
    Ok(())
}

fn asked<const N: usize>(
    built: &Built,
    servo: &Servo<N>,
    position: &[Position],
    negative: u8,
    kelvin: &[f64],
    wanted: Wanted,
) -> Result<[Real; AXES_MAX], ResultCode> {
    let mut conditions = Conditions::<Real, N>::default();
    for (slot, direction) in conditions.directions.iter_mut().enumerate() {
        *direction = Direction::of(negative >> slot & 1 == 1);
    }
    for (slot, (line, kelvin)) in conditions.thermal.iter_mut().zip(kelvin).enumerate() {
        *line = built.growth(slot, *kelvin).ok_or(ERROR_ARGUMENT)?;
    }
    let position: [CorePosition; N] = first(position);
    let found: Result<[Real; N], Fault> = match wanted {
        Wanted::Error => servo.error_at(&position, &conditions),
        Wanted::Correction => servo.correction_at(&position, &conditions),
    };
    let mut all = [0.0; AXES_MAX];
    for (to, from) in all.iter_mut().zip(found.map_err(|_| ERROR_ARGUMENT)?) {
        *to = from;
    }
    Ok(all)
}
