//! The gauge: building, restarting, reading results.

use super::draw::Draw;
use super::machines::PERIOD_NS;
use super::world::{World, answered, bytes_of, explained};
use trueaxis_capi::*;

/// Builds the gauge of a file, usually of the last, which has one.
pub(super) fn build(world: &mut World, draw: &mut Draw<'_>) {
    let mut wrong = draw.wrong();
    let mut file =
        world.files[if draw.below(4) == 0 { draw.below(world.files.len()) } else { world.files.len() - 1 }].clone();
    super::world::damage(&mut file, draw);
    let period_ns = if draw.below(16) == 0 { draw.word() } else { PERIOD_NS };
    let gauges = &mut world.gauges;
    let before = bytes_of(&*gauges.gauge).to_vec();
    // SAFETY: a wrong argument is null, misaligned or has another stated size.
    let result = unsafe {
        trueaxis_gauge_build(
            wrong.at(0, &raw mut *gauges.gauge),
            wrong.size(0, size_of::<Gauge>()),
            wrong.at(1, file.as_mut_ptr()),
            file.len(),
            period_ns,
            &raw mut *world.error,
        )
    };
    answered("gauge_build", result, &wrong, &[ERROR_TABLES, ERROR_CONFIG, ERROR_GAUGE]);
    if result != OK {
        explained(&world.error, result);
        assert!(before == bytes_of(&*world.gauges.gauge), "a refused gauge was written");
    }
}

/// Starts a new state of the gauge.
pub(super) fn restart(world: &mut World, draw: &mut Draw<'_>) {
    let mut wrong = draw.wrong();
    let sizes = [size_of::<GaugeState512>(), size_of::<GaugeState512>(), size_of::<GaugeState>(), 64];
    let gauges = &mut world.gauges;
    let size = sizes[draw.below(4)];
    // SAFETY: as above; the storage has the size of the larger state.
    let result = unsafe {
        let gauge = wrong.at(0, (&raw const *gauges.gauge).cast_mut());
        trueaxis_gauge_restart(gauge, wrong.at(1, &raw mut *gauges.state), wrong.size(1, size))
    };
    wrong.met |= result == ERROR_SIZE && size != sizes[0];
    answered("gauge_restart", result, &wrong, &[ERROR_GAUGE]);
}

/// Sets the radius of the wheel.
pub(super) fn wheel(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, wheel_mm) = (draw.wrong(), draw.number());
    // SAFETY: as above.
    let result = unsafe {
        let gauge = wrong.at(0, (&raw const *world.gauges.gauge).cast_mut());
        let state = wrong.at(1, &raw mut *world.gauges.state);
        trueaxis_gauge_set_wheel(gauge, state, wheel_mm, &raw mut *world.error)
    };
    answered("gauge_set_wheel", result, &wrong, &[ERROR_CONFIG, ERROR_GAUGE]);
    if result != OK {
        explained(&world.error, result);
    }
}

/// Reads the gauge's results.
pub(super) fn results(world: &mut World, draw: &mut Draw<'_>) {
    let (mut wrong, kind) = (draw.wrong(), draw.below(3));
    let gauge = wrong.at(0, (&raw const *world.gauges.gauge).cast_mut()).cast_const();
    let state = wrong.at(1, &raw mut *world.gauges.state);
    match kind {
        0 => {
            // SAFETY: numbers only.
            let mut found: Evaluation = unsafe { std::mem::zeroed() };
            found.size = wrong.size(2, size_of::<Evaluation>()) as u32;
            // SAFETY: as above.
            let result = unsafe { trueaxis_gauge_latest(gauge, state, wrong.at(2, &raw mut found)) };
            answered("gauge_latest", result, &wrong, &[ERROR_NOT_YET, ERROR_GAUGE]);
            let numbers = [found.peak_to_valley_um, found.x.total_um, found.y.total_um, found.x.synchronous_um];
            assert!(numbers.iter().all(|value| value.is_finite() && *value >= 0.0), "{found:?}");
            assert!(result == OK || (found.revolution, found.sampled) == (0, 0), "a refused evaluation was written");
        }
        1 => {
            let (harmonic, mut found) = (u32::from(draw.byte()), [f64::NAN; 2]);
            // SAFETY: as above.
            let result = unsafe { trueaxis_gauge_harmonic(gauge, state, harmonic, wrong.at(2, found.as_mut_ptr())) };
            answered("gauge_harmonic", result, &wrong, &[ERROR_NOT_YET, ERROR_ARGUMENT, ERROR_GAUGE]);
            assert!(found.iter().all(|value| value.is_finite() == (result == OK)), "{found:?}");
            assert!(result != OK || harmonic <= 127);
        }
        _ => {
            let size = if draw.flag() { GAUGE_FRAME_BYTES } else { draw.below(256) };
            let (mut buffer, mut written) = ([0xa5_u8; GAUGE_FRAME_BYTES], usize::MAX);
            // SAFETY: as above; the buffer is at least as large as stated.
            let result = unsafe {
                let bytes = wrong.at(2, buffer.as_mut_ptr());
                trueaxis_gauge_frame_encode(gauge, state, 7, bytes, size, wrong.at(3, &raw mut written))
            };
            answered("gauge_frame_encode", result, &wrong, &[ERROR_NOT_YET, ERROR_BUFFER, ERROR_GAUGE]);
            if result != OK {
                return assert!(written == usize::MAX && buffer == [0xa5; GAUGE_FRAME_BYTES]);
            }
            assert!(written <= size && buffer[written..].iter().all(|byte| *byte == 0xa5));
            trueaxis::telemetry::RoundnessFrame::decode(&mut buffer[..written]).expect("a frame");
        }
    }
}
