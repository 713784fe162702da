//! Paths, their segments, windows of commands, foot points.

use super::draw::{Draw, Wrong};
use super::world::{World, answered, bytes_of, explained};
use std::ptr::{null, null_mut};
use trueaxis_capi::*;

/// Starts a path, with or without a tool.
pub(super) fn start(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, slot, of_tool) = (draw.wrong(), draw.below(2), draw.flag());
    let first = [0, 1, draw.word(), u32::MAX, u32::MAX - 3][draw.below(5)];
    let paths = &mut world.paths;
    let bytes = if draw.below(8) == 0 { draw.below(256) * 8 } else { 8 * paths.memory[slot].len() };
    let before = bytes_of(&*paths.objects[slot]).to_vec();
    let function = if of_tool { trueaxis_path_start_tool } else { trueaxis_path_start };
    // SAFETY: a wrong argument is null, misaligned or has another stated size; the memory belongs to this path alone.
    let result = unsafe {
        let path = wrong.at(0, &raw mut *paths.objects[slot]);
        let size = wrong.size(0, size_of::<Path>());
        function(path, size, wrong.memory(1, &mut paths.memory[slot]), bytes.min(8 * paths.memory[slot].len()), first)
    };
    answered("path_start", result, &wrong, &[ERROR_ARGUMENT]);
    if result != OK {
        return assert!(before == bytes_of(&*paths.objects[slot]), "a refused path was written");
    }
    paths.started[slot] = Some((first, of_tool));
    assert_eq!(count(world, slot), (0, 0));
}

fn count(world: &World, slot: usize) -> (u32, u32) {
    let (mut segments, mut spans) = (u32::MAX, u32::MAX);
    // SAFETY: every argument matches its type.
    let result = unsafe { trueaxis_path_count(&*world.paths.objects[slot], &mut segments, &mut spans) };
    assert_eq!(result, OK);
    (segments, spans)
}

/// Appends a segment: a line, an arc, a spline or a turn, usually where the last one ended.
pub(super) fn segment(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, slot, kind) = (draw.wrong(), draw.below(2), draw.below(4));
    let before = world.paths.started[slot].map(|_| count(world, slot));
    let object = bytes_of(&*world.paths.objects[slot]).to_vec();
    let error = if draw.below(4) == 0 { null_mut() } else { &raw mut *world.error };
    let path = wrong.at(0, &raw mut *world.paths.objects[slot]);
    let result = match kind {
        0 => {
            let (start, end) = ends(draw, before);
            // SAFETY: as above.
            unsafe { trueaxis_path_line(path, wrong.at(1, start.as_ptr().cast_mut()), end.as_ptr(), error) }
        }
        1 => arc(path, &mut wrong, draw, before, error),
        2 => nurbs(path, &mut wrong, draw, error),
        _ => {
            let (point, _) = ends(draw, before);
            // SAFETY: as above.
            unsafe { trueaxis_path_turning(path, wrong.at(1, point.as_ptr().cast_mut()), error) }
        }
    };
    answered("path segment", result, &wrong, &[ERROR_MEMORY, ERROR_PATH, ERROR_ARGUMENT]);
    let Some((segments, spans)) = before else {
        return assert_ne!(result, OK, "a segment of a path that was never started");
    };
    if result != OK {
        if !error.is_null() {
            explained(&world.error, result);
        }
        assert!(object == bytes_of(&*world.paths.objects[slot]), "a refused segment changed the path");
        return;
    }
    let after = count(world, slot);
    assert!(after.0 == segments + 1 && after.1 > spans, "{after:?} after {segments} {spans}");
}

/// Start and end on a small grid, so that segments meet; sometimes any numbers.
fn ends(draw: &mut Draw<'_>, before: Option<(u32, u32)>) -> ([f64; 3], [f64; 3]) {
    if draw.below(16) == 0 {
        return (draw.numbers(), draw.numbers());
    }
    let at = before.map_or(0.0, |(segments, _)| f64::from(segments));
    let step = 0.25 * f64::from(draw.byte() as i8);
    ([at, 0.0, 0.0], [at + 1.0, if draw.below(8) == 0 { step } else { 0.0 }, 0.0])
}

fn arc(path: *mut Path, wrong: &mut Wrong, draw: &mut Draw<'_>, before: Option<(u32, u32)>, error: *mut Error) -> i32 {
    let (start, end) = ends(draw, before);
    let middle = std::array::from_fn(|i| 0.5 * (start[i] + end[i]));
    let centre: [f64; 3] = if draw.below(4) == 0 { draw.numbers() } else { middle };
    let normal = if draw.below(4) == 0 { draw.numbers() } else { [0.0, 0.0, 1.0] };
    let turns = if draw.below(4) == 0 { draw.word() } else { draw.below(2) as u32 };
    // SAFETY: as above.
    unsafe {
        let (start, end) = (wrong.at(1, start.as_ptr().cast_mut()), wrong.at(2, end.as_ptr().cast_mut()));
        let normal = wrong.at(3, normal.as_ptr().cast_mut());
        trueaxis_path_arc(path, start, end, centre.as_ptr(), normal, turns, error)
    }
}

fn nurbs(path: *mut Path, wrong: &mut Wrong, draw: &mut Draw<'_>, error: *mut Error) -> i32 {
    let (degree, points) = (draw.below(8), draw.below(8));
    let clamped = |k: usize| k.clamp(degree, points.max(degree)) as f64 - degree as f64;
    let mut knots: [f64; 17] = std::array::from_fn(clamped);
    let mut places: [f64; 24] = std::array::from_fn(|k| if k % 3 == 0 { k as f64 / 3.0 } else { 0.1 * (k % 5) as f64 });
    let mut weights = [1.0; 8];
    for _ in 0..draw.below(4) {
        match draw.below(3) {
            0 => knots[draw.below(17)] = draw.number(),
            1 => places[draw.below(24)] = draw.number(),
            _ => weights[draw.below(8)] = draw.number(),
        }
    }
    let weights = if draw.flag() { weights.as_ptr() } else { null() };
    // SAFETY: seven points of degree seven have fifteen knots.
    unsafe {
        let knots = wrong.at(1, knots.as_ptr().cast_mut());
        let places = wrong.at(2, places.as_ptr().cast_mut());
        trueaxis_path_nurbs(path, degree as u32, knots, places, weights, points, error)
    }
}

/// Sets the plane, the axes or the directions of a path, or closes or clears it.
pub(super) fn shape(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, slot, kind) = (draw.wrong(), draw.below(2), draw.below(5));
    let (one, other) = (draw.numbers::<3>(), draw.numbers::<3>());
    let before = bytes_of(&*world.paths.objects[slot]).to_vec();
    let path = wrong.at(0, &raw mut *world.paths.objects[slot]);
    // SAFETY: as above.
    let (result, allowed) = unsafe {
        let mut one = || wrong.at(1, one.as_ptr().cast_mut()).cast_const();
        match kind {
            0 => (trueaxis_path_plane(path, one()), ERROR_ARGUMENT),
            1 => (trueaxis_path_axes(path, one(), other.as_ptr()), ERROR_ARGUMENT),
            2 => (trueaxis_path_directions(path, one(), other.as_ptr()), ERROR_ARGUMENT),
            3 => (trueaxis_path_close(path), ERROR_PATH),
            _ => (trueaxis_path_clear(path), OK),
        }
    };
    answered("path shape", result, &wrong, &[allowed]);
    if result != OK {
        return assert!(before == bytes_of(&*world.paths.objects[slot]), "a refused change of a path");
    }
    assert!(world.paths.started[slot].is_some());
    if kind == 4 {
        assert_eq!(count(world, slot), (0, 0));
    }
}

/// Looks up a point of a path.
pub(super) fn reference(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, slot) = (draw.wrong(), draw.below(2));
    let (segment, u) = (if draw.below(8) == 0 { draw.word() } else { draw.below(8) as u32 }, draw.number());
    let mut found = Reference { span: 99, t: f64::NAN };
    // SAFETY: as above.
    let result = unsafe {
        let path = wrong.at(0, (&raw const *world.paths.objects[slot]).cast_mut());
        trueaxis_path_reference(path, segment, u, wrong.at(1, &raw mut found))
    };
    answered("path_reference", result, &wrong, &[ERROR_ARGUMENT]);
    if result != OK {
        return assert!(found.span == 99 && found.t.is_nan(), "a refused reference was written");
    }
    let (first, _) = world.paths.started[slot].expect("a reference on a path that was never started");
    let (segments, spans) = count(world, slot);
    assert!(segment < segments && u.is_finite() && (0.0..=1.0).contains(&found.t), "{found:?}");
    assert!(found.span.wrapping_sub(first) < spans, "{found:?} of {spans} spans from {first}");
}

/// Searches for the foot point nearest to a point.
pub(super) fn foot(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, slot, point) = (draw.wrong(), draw.below(2), draw.numbers::<3>());
    // SAFETY: numbers only.
    let mut contour: Contour = unsafe { std::mem::zeroed() };
    contour.error = f64::NAN;
    // SAFETY: as above.
    let result = unsafe {
        let path = wrong.at(0, (&raw const *world.paths.objects[slot]).cast_mut());
        trueaxis_nearest_foot(path, wrong.at(1, point.as_ptr().cast_mut()), wrong.at(2, &raw mut contour))
    };
    answered("nearest_foot", result, &wrong, &[ERROR_ARGUMENT]);
    if result != OK {
        return assert!(contour.error.is_nan() && contour.flags == 0, "a refused foot was written");
    }
    assert!(point.iter().all(|q| q.is_finite()) && count(world, slot).0 > 0);
    let numbers = [contour.t, contour.error, contour.normal, contour.binormal, contour.tangential, contour.width];
    assert!(numbers.iter().chain(&contour.vector).all(|value| value.is_finite()), "{contour:?} of {point:?}");
    assert!(contour.error >= 0.0 && contour.lag == 0.0 && (0.0..=1.0).contains(&contour.t), "{contour:?}");
}

/// Starts or restarts the window of the last commands.
pub(super) fn window(world: &mut World, draw: &mut Draw<'_>) {
    let mut wrong = draw.wrong();
    let window = wrong.at(0, &raw mut *world.paths.window);
    if draw.flag() {
        // SAFETY: as above.
        let result = unsafe { trueaxis_command_window_restart(window) };
        return answered("command_window_restart", result, &wrong, &[]);
    }
    let plane = draw.flag().then(|| draw.numbers::<3>());
    let spacing = if draw.flag() { 0.005 } else { draw.number() };
    // SAFETY: as above.
    let result = unsafe {
        let plane = plane.as_ref().map_or(null(), |plane| plane.as_ptr());
        trueaxis_command_window_start(window, wrong.size(0, size_of::<CommandWindow>()), plane, spacing)
    };
    answered("command_window_start", result, &wrong, &[ERROR_ARGUMENT]);
    assert!(result != OK || (0.001..=1.0).contains(&spacing));
}
