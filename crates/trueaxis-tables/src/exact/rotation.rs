//! Rotation vectors and matrices.

use glam::{DMat3, DVec3};

/// Rotation matrix of a rotation vector (Rodrigues).
///
/// Below 0.01 rad sin θ/θ and (1 − cos θ)/θ² are the first three terms of their series, exact to the last bit.
pub(super) fn rotation(w: DVec3) -> DMat3 {
    let square = w.length_squared();
    let (a, b) = if square < 1e-4 {
        (1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0))
    } else {
        let angle = square.sqrt();
        (libm::sin(angle) / angle, (1.0 - libm::cos(angle)) / square)
    };
    let cross = DMat3::from_cols(DVec3::new(0.0, w.z, -w.y), DVec3::new(-w.z, 0.0, w.x), DVec3::new(w.y, -w.x, 0.0));
    let outer = DMat3::from_cols(w * w.x, w * w.y, w * w.z);
    DMat3::from_diagonal(DVec3::splat(1.0 - b * square)) + cross * a + outer * b
}

/// Rotation about a unit vector by an angle, rad, with the same sine and cosine on every host.
pub(super) fn about(axis: DVec3, angle: f64) -> DMat3 {
    let (sine, cosine) = libm::sincos(angle);
    let (DVec3 { x, y, z }, rest) = (axis, 1.0 - cosine);
    let (xy, xz, yz) = (x * y * rest, x * z * rest, y * z * rest);
    DMat3::from_cols(
        DVec3::new(x * x * rest + cosine, xy + z * sine, xz - y * sine),
        DVec3::new(xy - z * sine, y * y * rest + cosine, yz + x * sine),
        DVec3::new(xz + y * sine, yz - x * sine, z * z * rest + cosine),
    )
}

/// Rotation vector of a rotation matrix that turns by less than half a revolution; the inverse of [`rotation`].
pub(super) fn rotation_vector(turn: DMat3) -> DVec3 {
    let sine =
        DVec3::new(turn.y_axis.z - turn.z_axis.y, turn.z_axis.x - turn.x_axis.z, turn.x_axis.y - turn.y_axis.x) * 0.5;
    let size = sine.length();
    // For a small angle the sine equals the angle to rounding; this also avoids 0/0.
    if size < 1e-9 {
        return sine;
    }
    let cosine = 0.5 * (turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0);
    sine * (libm::atan2(size, cosine) / size)
}
